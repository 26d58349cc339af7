"""What is dear to make and can be made again: kept in the user's cache folder, within a limit. Internal.

A file has the digest of its contents in front: one that is torn, or of another program, counts as missing. It is written
beside its name and renamed, so that two processes that make the same file at once leave one whole file; whoever reads it
meanwhile keeps what was open. Where nothing can be written, nothing is kept, and all goes on.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
from pathlib import Path

VARIABLE = "IRIDESCE_CACHE"
LIMIT_BYTES = 512 << 20
_MARK = b"iridesce cache 1\n"
_DIGEST = 32
_ENDING = ".cache"
# What another process has been writing for longer than this is left over of one that was killed.
_STALE_S = 3600.0


def folder() -> Path:
    """Where it is: the variable IRIDESCE_CACHE, else the place that the system has for it (XDG base directories on Linux)."""
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given)
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "iridesce"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "iridesce" / "Cache"
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path.home() / ".cache") / "iridesce"


def name_of(*parts: bytes) -> str:
    """A name for what follows from these bytes alone."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(len(part).to_bytes(8, "little"))
        digest.update(part)
    return digest.hexdigest()


def load(name: str) -> bytes | None:
    """What was kept under a name, or None; what is used stays longest."""
    try:
        path = folder() / f"{name}{_ENDING}"
        content = path.read_bytes()
    except (OSError, RuntimeError, ValueError):  # (RuntimeError: a user without a home)
        return None
    head = len(_MARK) + _DIGEST
    body = content[head:]
    if not content.startswith(_MARK) or hashlib.sha256(body).digest() != content[len(_MARK) : head]:
        return None
    with contextlib.suppress(OSError):
        os.utime(path)
    return body


def keep(name: str, body: bytes) -> bool:
    """Keep bytes under a name, if there is room and a place; the longest unused goes first. Whether they are kept."""
    content = _MARK + hashlib.sha256(body).digest() + body
    if len(content) > LIMIT_BYTES:
        return False
    written = None
    try:
        place = folder()
        place.mkdir(parents=True, exist_ok=True)
        _make_room(place, len(content))
        handle, written = tempfile.mkstemp(".part", f"{name[:16]}-", place)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        Path(written).replace(place / f"{name}{_ENDING}")
    except (OSError, RuntimeError, ValueError):
        if written is not None:
            with contextlib.suppress(OSError):
                Path(written).unlink()
        return False
    return True


def _make_room(place: Path, wanted: int) -> None:
    import time

    files = []
    with os.scandir(place) as entries:
        for entry in entries:
            with contextlib.suppress(OSError):
                told = entry.stat()
                if entry.name.endswith(_ENDING):
                    files.append((told.st_mtime, told.st_size, entry.path))
                elif entry.name.endswith(".part") and time.time() - told.st_mtime > _STALE_S:
                    Path(entry.path).unlink()
    total = sum(size for _, size, _ in files) + wanted
    for _, size, path in sorted(files):
        if total <= LIMIT_BYTES:
            break
        # (Another process may have taken it away already.)
        with contextlib.suppress(OSError):
            Path(path).unlink()
        total -= size


def used_bytes() -> int:
    """How much is kept now."""
    total = 0
    with contextlib.suppress(OSError, RuntimeError), os.scandir(folder()) as entries:
        for entry in entries:
            with contextlib.suppress(OSError):
                total += entry.stat().st_size if entry.name.endswith(_ENDING) else 0
    return total
