"""What runs on a worker: it is sent a subject once, files once, and then points; it answers file names or small contents."""

from __future__ import annotations

import atexit
import hashlib
import os
import pickle
import shutil
import tempfile
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from iridesce import _core
from iridesce.sweeping.grid import Point
from iridesce.sweeping.needed import lay_out
from iridesce.sweeping.points import Stopped, value_of
from iridesce.sweeping.store import npy_bytes, write_value
from iridesce.sweeping.subjects import Subject

# Subjects that a worker keeps ready, with the maps and films that their scenes have read.
_MOST_SUBJECTS = 2

# What runs on any worker, one without this package too: it is sent as it stands, by value.
PROBE = """
def probe():
    try:
        from iridesce import _core
    except ImportError as error:
        return {"missing": str(error)}
    return {"version": _core.__version__, "simd": _core.SIMD_LEVEL}
"""


class WrongWorker(Exception):
    """A worker that cannot take part: of another version or SIMD level."""


class CannotLoad(Exception):
    """What was sent cannot be made use of on a worker."""


class CannotWrite(Exception):
    """A worker could not write into the store: errno, words, file."""


def carry(value: Any) -> Any:
    """What is sent once: workers hand it on to each other, and it is made again from the scheduler's copy if all are lost."""
    return value


def make_point(
    blob: bytes,
    number: int,
    point: Point,
    files: Mapping[str, bytes],
    names: Mapping[str, str],
    store: tuple[str, str] | None,
    threads: int | None,
    wanted: tuple[str, str],
) -> tuple[Any, ...]:
    """Make one point.

    blob     the subject, pickled
    files    the files of its scene, by the names that the scene has for them; ``names`` their digests
    store    folder and digest of its description: if this worker sees that very folder, it writes there
    wanted   version and SIMD level of the sweep
    Returns  ("there", file, size, sha256), ("sent", ending, content) or ("failed", message)
    """
    check_worker(wanted)
    subject = subject_at_home(landed(blob, files, names))
    value, message = value_of(subject, point, threads or 1, _stopper())
    if message is not None:
        return "failed", message
    if store is not None and _sees(*store):
        try:
            return ("there", *write_value(Path(store[0]), number, value))
        except OSError as error:
            raise CannotWrite(error.errno, error.strerror or str(error), str(error.filename)) from None
    return ("sent", *encoded(value))


def check_worker(wanted: tuple[str, str]) -> None:
    """`WrongWorker` where this process is of another version or SIMD level."""
    own = (_core.__version__, _core.SIMD_LEVEL)
    if own != wanted:
        raise WrongWorker(
            f"a worker on {os.uname().nodename if hasattr(os, 'uname') else 'another machine'} has iridesce "
            f"{own[0]} ({own[1]}), the sweep {wanted[0]} ({wanted[1]})"
        )


def encoded(value: Any) -> tuple[str, bytes]:
    """A value as the ending and the content of its file."""
    if not hasattr(value, "xyz"):
        return ".npy", npy_bytes(value)
    with tempfile.TemporaryDirectory(prefix="iridesce-") as folder:
        path = Path(folder) / "point.exr"
        value.save(path)
        return ".exr", path.read_bytes()


class Sent(NamedTuple):
    """What was sent for many calls: the thing itself and a folder where its files lie; one object for all calls of a worker."""

    name: str
    thing: Any
    folder: Path | None


def call(
    function: Callable[..., Any],
    wanted: tuple[str, str],
    blob: bytes,
    files: Mapping[str, bytes],
    names: Mapping[str, str],
    item: tuple[Any, ...],
) -> tuple[Any, Exception | None]:
    """Call a function of this package with what was sent once and what is this call's own: (answer, None) or (None, error)."""
    check_worker(wanted)
    sent = landed(blob, files, names)
    try:
        return function(sent, *item), None
    except Exception as error:
        return None, error


_lock = threading.Lock()
_landed: dict[str, Sent] = {}
_subjects: dict[str, Subject] = {}
_seen: dict[tuple[str, str], bool] = {}


def landed(blob: bytes, files: Mapping[str, bytes], names: Mapping[str, str]) -> Sent:
    """What was sent, unpacked once, with its files in a folder of this worker's."""
    name = hashlib.sha256(blob + repr(sorted(names.items())).encode()).hexdigest()
    with _lock:
        if name not in _landed:
            try:
                thing = pickle.loads(blob)
            except Exception as error:
                raise CannotLoad(f"{type(error).__name__}: {error}") from None
            folder = None
            if files:
                root = Path(tempfile.mkdtemp(prefix="iridesce-sweep-"))
                atexit.register(shutil.rmtree, root, ignore_errors=True)
                folder = lay_out(root, files)
            while len(_landed) >= _MOST_SUBJECTS:
                oldest = next(iter(_landed))
                _subjects.pop(oldest, None)
                del _landed[oldest]
            _landed[name] = Sent(name, thing, folder)
        return _landed[name]


def subject_at_home(sent: Sent) -> Subject:
    """A subject that was sent, at home with its files: one object, which keeps what its scene has read."""
    with _lock:
        if sent.name not in _subjects:
            _subjects[sent.name] = sent.thing if sent.folder is None else sent.thing.moved(sent.folder)
        return _subjects[sent.name]


def _sees(folder: str, digest: str) -> bool:
    """Whether this worker sees the store, and not a folder that only has its name."""
    if (folder, digest) not in _seen:
        try:
            content = (Path(folder) / "sweep.json").read_bytes()
        except OSError:
            return False
        _seen[folder, digest] = hashlib.sha256(content).hexdigest() == digest
    return _seen[folder, digest]


def _stopper() -> Callable[..., None]:
    """What a render asks while it works: whether its task has been called off."""
    try:
        from distributed import get_worker

        worker = get_worker()
        key = worker.get_current_task()
    except (ImportError, ValueError, AttributeError):
        return lambda *_: None

    def hear(*_: object) -> None:
        task = worker.state.tasks.get(key)
        if task is None or task.state == "cancelled":
            raise Stopped

    return hear
