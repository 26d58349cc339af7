"""A folder that holds a sweep: what was asked, one file a point, and an index that only grows and is checked.

    sweep.json         what was asked: base, grid, quantity, digests of files, version and SIMD level
    points/000012.npy  the value of a point: .exr for pictures, .npy for numbers, .json for a point that failed
    index/0001.json    what one run has finished: length and SHA-256 of each file, each line chained to the one before

Nothing in it is a pickle. Shards write into the same folder, each into an index of its own. What the index does not vouch for
is made again, so a kill at any moment, a full disk or a spoiled file costs those points and nothing else.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import io
import json
import os
import tempfile
import threading
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from iridesce.files.arrays import array_of
from iridesce.files.trees import NotATree, from_json
from iridesce.files.whole import check_place, read_whole, write_whole
from iridesce.image import Image
from iridesce.sweeping.grid import Point, described_point

_FORMAT = 1
_MOST_BYTES = 16 << 30
_HEADER = "sweep.json"
# Letters of the chained digest of an index line.
_CHAIN = 16


class Entry(NamedTuple):
    """A finished point: the name of its file, how long that is and its digest; what failed has a message there."""

    file: str
    size: int
    sha256: str

    @property
    def has_failed(self) -> bool:
        return self.file.endswith(".json")


class Store:
    """An open store; `done` holds the points that its index vouches for, each looked at."""

    def __init__(self, folder: Path, header: Mapping[str, Any]) -> None:
        self.folder = folder
        self._lock = threading.Lock()
        self._index: _Index | None = None
        text = json.dumps({"format": _FORMAT, **header}, indent=1, ensure_ascii=False) + "\n"
        path = folder / _HEADER
        if not path.exists():
            if folder.exists() and any(folder.iterdir()):
                raise ValueError(f"{folder} is not empty and holds no sweep; name a new folder")
            # (A shard that begins at the same moment writes the same bytes, or finds the difference below.)
            (folder / "points").mkdir(parents=True, exist_ok=True)
            (folder / "index").mkdir(exist_ok=True)
            write_whole(path, text.encode())
        self._refuse_another(path, json.loads(text))
        self.id = hashlib.sha256(path.read_bytes()).hexdigest()
        (folder / "points").mkdir(exist_ok=True)
        (folder / "index").mkdir(exist_ok=True)
        check_place(folder / "points" / "0.npy")
        self.done = self._read_index()

    def put(self, number: int, value: Any) -> Entry:
        """Write a point's value and vouch for it."""
        entry = write_value(self.folder, number, value)
        self.record(number, entry)
        return entry

    def put_content(self, number: int, ending: str, content: bytes) -> Entry:
        """Write a point's file that came from elsewhere, and vouch for it."""
        entry = write_content(self.folder, number, ending, content)
        self.record(number, entry)
        return entry

    def put_failure(self, number: int, point: Point, message: str) -> Entry:
        """Keep why a point failed, and vouch for that."""
        entry = write_content(self.folder, number, ".json", failure_bytes(point, message))
        self.record(number, entry)
        return entry

    def record(self, number: int, entry: Entry) -> None:
        """Vouch for a point whose file is in place."""
        with self._lock:
            if self._index is None:
                self._index = _Index.begun(self.folder / "index", self.id)
            self._index.append({"point": number, **entry._asdict()})
            self.done[number] = entry
        if not entry.has_failed:
            # It may have failed in a run before.
            with contextlib.suppress(OSError):
                (self.folder / "points" / f"{number:06d}.json").unlink(missing_ok=True)

    def is_there(self, entry: Entry) -> bool:
        """Whether a file is what its entry says, to the last byte."""
        path = self.folder / "points" / entry.file
        try:
            if path.stat().st_size != entry.size:
                return False
            with path.open("rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest() == entry.sha256
        except OSError:
            return False

    def value(self, number: int) -> Any:
        """The value of a finished point."""
        path = self.folder / "points" / self.done[number].file
        return Image.load(path) if path.suffix == ".exr" else np.load(path, allow_pickle=False)

    def message(self, number: int) -> str:
        """Why a point failed."""
        path = self.folder / "points" / self.done[number].file
        return str(from_json(read_whole(str(path), _MOST_BYTES), str(path))["error"])

    def tidy(self) -> None:
        """Take away what killed runs left half written of points that are finished now."""
        for part in (self.folder / "points").glob(".*.part-*"):
            number = part.name[1:].split(".")[0]
            if number.isdigit() and int(number) in self.done:
                with contextlib.suppress(OSError):
                    part.unlink(missing_ok=True)

    def _refuse_another(self, path: Path, wanted: dict[str, Any]) -> None:
        try:
            found = from_json(read_whole(str(path), _MOST_BYTES), str(path))
            if not isinstance(found, dict) or not isinstance(found.get("format"), int):
                raise NotATree
        except NotATree:
            raise ValueError(f"{path} is not the description of a sweep") from None
        if found["format"] > _FORMAT:
            raise ValueError(f"{path} is of a later version of iridesce (format {found['format']}, known: {_FORMAT})")
        difference = first_difference(found, wanted)
        if difference is not None:
            place, was, now = difference
            raise ValueError(f"{self.folder} holds another sweep: its {place} is {was}, not {now}")

    def _read_index(self) -> dict[int, Entry]:
        found: dict[int, Entry] = {}
        for path in sorted((self.folder / "index").glob("*.json")):
            for number, entry in _Index.read(path, self.id):
                # What a later run made of a point that failed counts, whichever index says so.
                if number not in found or found[number].has_failed:
                    found[number] = entry
        spoiled = [number for number, entry in found.items() if not self.is_there(entry)]
        for number in spoiled:
            del found[number]
        if spoiled:
            some = ", ".join(map(str, spoiled[:5])) + (", ..." if len(spoiled) > 5 else "")
            warnings.warn(
                f"{self.folder}: {len(spoiled)} files are not what the index says (points {some}); made again",
                stacklevel=4,
            )
        return found


class _Index:
    """A list of JSON that grows: the closing bracket moves on with every line, and each line is chained to the one before."""

    def __init__(self, path: Path, chain: str) -> None:
        self._path = path
        self._chain = chain

    @classmethod
    def begun(cls, folder: Path, sweep: str) -> _Index:
        """A new file, whatever other runs begin at the same moment."""
        number = len(list(folder.glob("*.json"))) + 1
        while True:
            path = folder / f"{number:04d}.json"
            first, chain = _line({"sweep": sweep}, "")
            try:
                with path.open("xb") as file:
                    file.write(f"[\n{first}\n]\n".encode())
                return cls(path, chain)
            except FileExistsError:
                number += 1

    def append(self, record: dict[str, Any]) -> None:
        line, self._chain = _line(record, self._chain)
        with self._path.open("r+b") as file:
            file.seek(-2, os.SEEK_END)
            file.write(f",{line}\n]\n".encode())

    @staticmethod
    def read(path: Path, sweep: str) -> Iterator[tuple[int, Entry]]:
        """Lines up to the first that is not whole or not chained to the one before: a kill or a full disk tears the last."""
        try:
            lines = read_whole(str(path), _MOST_BYTES).decode("utf-8", "replace").split("\n")
        except ValueError:
            return
        chain, is_first = "", True
        for number, text in enumerate(lines[1:], start=2):
            if text in ("]", "") or not text.endswith("}"):
                return
            try:
                record = json.loads(text.removeprefix(","))
                _, next_chain = _line({k: v for k, v in record.items() if k != "check"}, chain)
                if record.get("check") != next_chain or (is_first and record.get("sweep") != sweep):
                    raise ValueError
                if not is_first:
                    yield int(record["point"]), Entry(record["file"], int(record["size"]), record["sha256"])
            except (ValueError, KeyError, TypeError, AttributeError):
                warnings.warn(f"{path}: line {number} is damaged; points from there on are made again", stacklevel=5)
                return
            chain, is_first = next_chain, False


def _line(record: dict[str, Any], chain: str) -> tuple[str, str]:
    text = json.dumps(record)
    check = hashlib.sha256((chain + text).encode()).hexdigest()[:_CHAIN]
    return json.dumps({**record, "check": check}), check


def write_value(folder: Path, number: int, value: Any) -> Entry:
    """Write a point's value under its name: whole or not at all."""
    if isinstance(value, Image):
        return _placed(folder, number, ".exr", value.save)
    return write_content(folder, number, ".npy", npy_bytes(value))


def write_content(folder: Path, number: int, ending: str, content: bytes) -> Entry:
    """Write a point's file: whole or not at all. It need not have reached the disk, as the index holds its digest."""
    return _placed(folder, number, ending, lambda path: _write(path, content))


def _placed(folder: Path, number: int, ending: str, write: Any) -> Entry:
    path = folder / "points" / f"{number:06d}{ending}"
    part = path.with_name(f".{number:06d}.part-{os.getpid()}-{threading.get_ident()}{ending}")
    try:
        write(part)
        with part.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        entry = Entry(path.name, part.stat().st_size, digest)
        part.replace(path)
    except OSError as error:
        # Told of the point's own name, not of that beside it.
        raise OSError(error.errno or errno.EIO, error.strerror or str(error), str(path)) from None
    finally:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
    return entry


def _write(path: Path, content: bytes) -> None:
    with path.open("wb") as file:
        file.write(content)


def npy_bytes(value: Any) -> bytes:
    """An array as the content of an NPY file."""
    buffer = io.BytesIO()
    np.save(buffer, np.asarray(value), allow_pickle=False)
    return buffer.getvalue()


def failure_bytes(point: Point, message: str) -> bytes:
    """A failed point as the content of a JSON file."""
    return (json.dumps({"point": described_point(point), "error": message}, indent=1) + "\n").encode()


def read_value(ending: str, content: bytes) -> Any:
    """The value that the content of a point's file holds: a picture with every plane and its facts, or an array."""
    if ending == ".npy":
        return array_of(content)
    with tempfile.TemporaryDirectory(prefix="iridesce-") as folder:
        path = Path(folder) / "point.exr"
        path.write_bytes(content)
        return Image.load(path)


def first_difference(was: Any, now: Any, place: str = "") -> tuple[str, str, str] | None:
    """Where two trees differ first, in words; None where they do not."""
    if isinstance(was, dict) and isinstance(now, dict):
        for key in [*now, *(key for key in was if key not in now)]:
            inside = first_difference(
                was.get(key, _NOTHING), now.get(key, _NOTHING), f"{place}.{key}" if place else key
            )
            if inside is not None:
                return inside
        return None
    if isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        for number, pair in enumerate(zip(was, now, strict=True)):
            inside = first_difference(*pair, f"{place}.{number}")
            if inside is not None:
                return inside
        return None
    if was == now and (type(was) is type(now) or not (isinstance(was, bool) or isinstance(now, bool))):
        return None  # 300 and 300.0 are one thickness
    return place, _shown(was), _shown(now)


_NOTHING = object()


def _shown(value: Any) -> str:
    if value is _NOTHING:
        return "not given"
    text = json.dumps(value, ensure_ascii=False, default=repr)
    if isinstance(value, list) and len(text) > 60:
        return f"a list of {len(value)} from {text[1:25]}..."
    return text if len(text) <= 80 else f"{text[:77]}..."
