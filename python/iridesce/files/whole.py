"""Files that are read and written whole or not at all: the core's one reader and one writer. Internal."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from iridesce.arguments.refusals import complaint


def read_whole(label: str, limit: int, why: str = "") -> bytes:
    """All bytes of an ordinary file that a user named, at most ``limit``; every way in which it cannot be read is a
    `ValueError` naming it, with ``why`` after a length that is too much. Pipes and devices are refused unopened.
    """
    from iridesce import _core

    if "\0" in label:
        raise complaint(f"path {label!r}: embedded null byte", "path", "a file name without a zero byte", label)
    try:
        return _core.read_file(label, limit)
    except ValueError as error:
        words = str(error)
        if words == "there is no such file":
            words = "no such file"
        elif words == "it is a folder":
            words = "is a folder, not a file"
        elif words.startswith("it is "):
            words = words.removeprefix("it ")
            words = f"{words.removeprefix('is ')}, which {why}" if why and "longer than" in words else words
        else:
            words = f"cannot be read: {words}"
        raise ValueError(f"{label}: {words}") from None


def write_whole(path: Path, content: bytes) -> None:
    """Write beside the name and rename when whole: what was at ``path`` stays until then. Links and rights are kept, and the
    bytes have reached the disk before the name is theirs.

    ``OSError`` naming ``path`` where it cannot be written.
    """
    from iridesce import _core

    _core.write_file(path, content)


def append(path: Path, content: bytes) -> None:
    """Lines at the end of a file that `write_whole` began: for tables that grow, whose reader leaves out a torn last line.

    ``OSError`` naming ``path`` where it cannot be written.
    """
    with path.open("ab", buffering=0) as file:
        written = file.write(content)
        if written != len(content):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))


def check_place(path: Path) -> None:
    """Find out before the work that a file has nowhere to go: ``OSError`` naming it."""
    from iridesce import _core

    _core.check_output(path)
