"""Files that are written whole or not at all. Internal."""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from pathlib import Path


def read_whole(label: str, limit: int, why: str) -> bytes:
    """All bytes of a file that a user named, at most ``limit``; every way in which it cannot be read is a `ValueError`
    naming it, with ``why`` after a length that is too much.
    """
    try:
        with Path(label).open("rb") as file:
            content = file.read(limit + 1)
    except FileNotFoundError:
        raise ValueError(f"{label}: no such file") from None
    except IsADirectoryError:
        raise ValueError(f"{label}: is a folder, not a file") from None
    except OSError as error:
        raise ValueError(f"{label}: cannot be read: {error.strerror}") from error
    except ValueError as error:  # a zero byte in the name
        raise ValueError(f"path {label!r}: {error}") from None
    if len(content) > limit:
        raise ValueError(f"{label}: longer than {limit >> 20} MiB, which {why}")
    return content


def write_whole(path: Path, content: bytes) -> None:
    """Write beside the name and rename when whole: what was at ``path`` stays until then.

    ``OSError`` naming ``path`` where it cannot be written.
    """
    check_place(path)
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        Path(temporary).chmod(0o666 & ~_umask())  # mkstemp makes files that only their owner reads
        Path(temporary).replace(path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            Path(temporary).unlink()
        if isinstance(error, OSError):
            raise type(error)(error.errno, error.strerror, str(path)) from None
        raise


def check_place(path: Path) -> None:
    """Find out before the work that a file has nowhere to go: ``OSError`` naming it."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a folder", str(path))
    if not path.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "no such folder", str(path.parent))


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
