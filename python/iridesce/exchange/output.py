"""A folder of files that appear whole, all or none. Internal."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from pathlib import Path

from iridesce.arguments.refusals import refusal
from iridesce.files.whole import check_place, write_whole


def checked_folder(path: object) -> Path:
    """The folder to write into, as a path; `ValueError` for what is no path, `OSError` for what cannot be a folder."""
    if not isinstance(path, str | os.PathLike):
        raise refusal("path", "a folder", path)
    name = os.fspath(path)
    if not isinstance(name, str) or not name or "\0" in name:
        raise refusal("path", "a folder", name)
    folder = Path(name)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(20, "is a file, not a folder", str(folder))
    if not folder.exists() and not folder.parent.is_dir():
        raise FileNotFoundError(2, "no such folder", str(folder.parent))
    return folder


def write_folder(folder: Path, files: Mapping[str, bytes]) -> tuple[Path, ...]:
    """Write all files into a folder, which is made where it is missing; where one fails, the new ones go again."""
    made = not folder.exists()
    folder.mkdir(exist_ok=True)
    fresh: list[Path] = []
    paths = [folder / name for name in files]
    try:
        for path in paths:
            path.parent.mkdir(exist_ok=True)
            check_place(path)
        for path, content in zip(paths, files.values(), strict=True):
            was_there = path.exists()
            write_whole(path, content)
            if not was_there:
                fresh.append(path)
    except BaseException:
        for path in fresh:
            with contextlib.suppress(OSError):
                path.unlink()
        if made:
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise
    return tuple(paths)
