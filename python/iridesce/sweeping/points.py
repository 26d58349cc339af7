"""Making points on this machine: one after another with all threads, or small ones side by side."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from iridesce import _core
from iridesce.sweeping.grid import Point
from iridesce.sweeping.store import Store
from iridesce.sweeping.subjects import Subject, checked_value

# How often the calling thread looks at the keyboard while others work.
_PATIENCE_S = 0.05


class Task(NamedTuple):
    """A point that is to be made, and its place in the grid."""

    number: int
    point: Point


class Made(NamedTuple):
    """A point that has been made: its value, which a store keeps instead, or why it failed."""

    number: int
    value: Any
    message: str | None


class Stopped(Exception):
    """Told to a render whose sweep has ended."""


def message_of(error: BaseException) -> str:
    """Why a point failed: the words of an error that is ours, with its kind where it is a function's own."""
    words = str(error)
    if isinstance(error, ValueError) and words:
        return words
    return f"{type(error).__name__}: {words}" if words else type(error).__name__


def value_of(subject: Subject, point: Point, threads: int | None, progress: Any = None) -> tuple[Any, str | None]:
    """The value of a point, or what it failed with. Of what is no point's own fault, Ctrl-C is passed on."""
    try:
        return checked_value(subject.value(point, threads, progress)), None
    except (KeyboardInterrupt, SystemExit, GeneratorExit, Stopped):
        raise
    except BaseException as error:
        # (A panic of the core is a BaseException, and a point's own.)
        return None, message_of(error)


def make_here(subject: Subject, tasks: Sequence[Task], store: Store | None, threads: int | None) -> Iterator[Made]:
    """Make points by threads of this process, in the order in which they are ready."""
    width = _core.threads() if threads is None else threads
    if width > 1 and len(tasks) > 1 and subject.is_small(task.point for task in tasks):
        yield from _side_by_side(subject, tasks, store, min(width, len(tasks)))
        return
    for task in tasks:
        yield _kept(task, *value_of(subject, task.point, threads), store)


def _kept(task: Task, value: Any, message: str | None, store: Store | None) -> Made:
    if store is not None:
        if message is None:
            store.put(task.number, value)
            value = None
        else:
            store.put_failure(task.number, task.point, message)
    return Made(task.number, value, message)


def _side_by_side(subject: Subject, tasks: Sequence[Task], store: Store | None, width: int) -> Iterator[Made]:
    """Each point on one thread of its own. The core computes without the interpreter's lock, so threads are enough."""
    waiting = iter(tasks)
    lock = threading.Lock()
    ready: queue.SimpleQueue[Made | BaseException] = queue.SimpleQueue()
    stop = threading.Event()

    def hear(*_: object) -> None:
        if stop.is_set():
            raise Stopped

    def work() -> None:
        while not stop.is_set():
            with lock:
                task = next(waiting, None)
            if task is None:
                return
            try:
                ready.put(_kept(task, *value_of(subject, task.point, 1, hear), store))
            except BaseException as error:  # the calling thread raises it: a full disk, an end
                ready.put(error)
                return

    # Daemons, or a program that is told to end would wait for them.
    workers = [threading.Thread(target=work, name=f"iridesce-sweep-{n}", daemon=True) for n in range(width)]
    for worker in workers:
        worker.start()
    try:
        for _ in tasks:
            while True:
                try:
                    made = ready.get(timeout=_PATIENCE_S)
                    break
                except queue.Empty:
                    continue
            if isinstance(made, BaseException):
                raise made
            yield made
    finally:
        stop.set()
        for worker in workers:
            worker.join(timeout=5.0)
