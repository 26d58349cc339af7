"""Journals of renders: which render one is of, said so that two can be compared key by key. Internal."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from iridesce import _core
from iridesce.files.trees import NotATree, from_json
from iridesce.scene import Scene

# Keys of a scene whose values name files.
_NAMES_FILE = ("map", "file", "spectrum", "illuminant")
_PIECE = 1 << 20


@dataclass
class Keep:
    """A journal: its file, seconds before it begins, and whether what it holds already is taken over."""

    path: Path
    after_s: float
    resume: bool
    head: bytes = b""  # which render it is of, once that is known

    def is_ours(self) -> bool:
        """Whether the file is the journal of this very render."""
        try:
            return _core.journal_head(self.path) == self.head
        except ValueError:
            return False


def head_of(scene: Scene, tree: dict[str, Any], asked: dict[str, Any]) -> bytes:
    """Which render it is: all that its bytes depend on. `tree` is the scene with the size, samples and seed of the render."""
    head = {
        **{key: asked[key] for key in ("seed", "size", "samples", "crop", "planes")},
        "version": _core.__version__,
        "simd": _core.SIMD_LEVEL,
        "scene": {key: value for key, value in tree.items() if key != "render"}
        | {"render": {key: value for key, value in tree["render"].items() if key not in ("samples", "seed")}},
        "files": {name: _digest(path) for name, path in sorted(_files(scene, tree))},
    }
    head["scene"]["camera"] = {key: value for key, value in tree["camera"].items() if key != "resolution"}
    return json.dumps(head, allow_nan=False, default=_plain, sort_keys=True).encode()


def check_same(path: Path, head: bytes) -> None:
    """Refuse a journal of another render, saying how it differs."""
    there = _core.journal_head(path)
    if there is None or there == head:
        return
    try:
        before = from_json(there, str(path))
        now = from_json(head, str(path))
    except NotATree:
        raise ValueError(f"{path} is the journal of another kind of work") from None
    differing = list(_differences(before, now, ""))
    key, was, is_now = differing[0] if differing else ("its description", "?", "?")
    word = {"simd": "SIMD level"}.get(key, key)
    raise ValueError(
        f"{path} is the journal of another render: {word} was {_shown(was)}, now it is {_shown(is_now)}; "
        "go on with the same, or remove the journal to start afresh"
    )


def _differences(before: Any, now: Any, place: str) -> Iterator[tuple[str, Any, Any]]:
    if isinstance(before, dict) and isinstance(now, dict):
        for key in [*before, *(key for key in now if key not in before)]:
            yield from _differences(before.get(key), now.get(key), f"{place}.{key}" if place else key)
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now) and place.startswith("scene."):
        for number, (was, is_now) in enumerate(zip(before, now, strict=True)):
            yield from _differences(was, is_now, f"{place}.{number}")
    elif before != now or type(before) is not type(now):
        yield place, before, now


def _shown(value: Any) -> str:
    return f"{json.dumps(value):.80}"


def _files(scene: Scene, tree: Any) -> Iterator[tuple[str, Path]]:
    """Every file that a scene names."""
    folder = Path(scene._core.folder or ".")
    stack = [tree]
    while stack:
        node = stack.pop()
        if isinstance(node, dict):
            for key, value in node.items():
                if key in _NAMES_FILE and isinstance(value, str) and (folder / value).is_file():
                    yield value, folder / value
                stack.append(value)
        elif isinstance(node, list):
            stack.extend(node)


def _digest(path: Path) -> str:
    digest = hashlib.blake2b(digest_size=16)
    try:
        with path.open("rb") as file:
            while piece := file.read(_PIECE):
                digest.update(piece)
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror or error}") from None
    return digest.hexdigest()


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)
