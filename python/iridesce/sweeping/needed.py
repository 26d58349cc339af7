"""The files that a scene needs: which, by what content, and how they are laid out elsewhere."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from iridesce.files.whole import read_whole

# The largest environment that a scene reads has a little less.
_MOST_BYTES = 16 << 30


def needed_files(trees: Iterable[Any], folder: Path) -> dict[str, Path]:
    """Every text of some trees that names an ordinary file, from ``folder``; with the buffers of a glTF file."""
    found: dict[str, Path] = {}
    for text in _texts(list(trees)):
        # A name without an ending is that of an object or a medium, whatever lies in the folder.
        if text in found or len(text) > 4096 or "\0" in text or not Path(text).suffix:
            continue
        path = folder / text
        try:
            is_file = path.is_file()
        except OSError:
            is_file = False
        if is_file:
            found[text] = path
            found.update(_buffers(text, path))
    return found


def _texts(tree: Any) -> Iterator[str]:
    if isinstance(tree, str):
        yield tree
    elif isinstance(tree, Mapping):
        for value in tree.values():
            yield from _texts(value)
    elif isinstance(tree, list | tuple):
        for value in tree:
            yield from _texts(value)


def _buffers(name: str, path: Path) -> dict[str, Path]:
    """Files that a glTF file refers to."""
    if path.suffix.lower() != ".gltf":
        return {}
    try:
        tree = json.loads(path.read_bytes())
        parts = [part.get("uri") for kind in ("buffers", "images") for part in tree.get(kind, [])]
    except (ValueError, AttributeError, OSError):
        return {}  # the reader of meshes says what is wrong with it
    beside = {uri: path.parent / uri for uri in parts if isinstance(uri, str) and not uri.startswith("data:")}
    return {os.fspath(Path(name).parent / uri): file for uri, file in beside.items() if file.is_file()}


def digests(files: Mapping[str, Path]) -> dict[str, str]:
    """SHA-256 of each file, by its name in the scene."""
    found = {}
    for name, path in sorted(files.items()):
        with path.open("rb") as file:
            found[name] = hashlib.file_digest(file, "sha256").hexdigest()
    return found


def content(path: Path) -> bytes:
    """All of a file."""
    return read_whole(str(path), _MOST_BYTES)


def lay_out(root: Path, files: Mapping[str, bytes]) -> Path:
    """Write files under ``root`` so that a scene in the folder that is returned finds them by the names it has for them.

    ``ValueError`` for a name that begins at the root of a file system: it means the same nowhere else.
    """
    above = max((_steps_up(name) for name in files), default=0)
    folder = root.joinpath(*(f"level_{number}" for number in range(above)))
    folder.mkdir(parents=True, exist_ok=True)
    for name, inside in files.items():
        path = Path(os.path.normpath(folder / name))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(inside)
    return folder


def check_names(files: Iterable[str]) -> None:
    """Before the first point: a name that no other machine can follow is refused."""
    for name in files:
        if Path(name).is_absolute():
            raise ValueError(
                f"{name}: name the file relative to its scene; workers lay it out in a folder of their own"
            )


def _steps_up(name: str) -> int:
    """How far a name leads above the folder it starts from."""
    depth = lowest = 0
    for part in Path(name).parts:
        depth += -1 if part == ".." else 1
        lowest = min(lowest, depth)
    return -lowest
