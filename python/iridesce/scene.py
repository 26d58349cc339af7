"""Scenes: what to render, read from a file, a dict or the built-in set."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from iridesce import _core
from iridesce.errors import SceneError


class Scene:
    """A validated scene: every default filled in, every medium, illuminant and map resolved.

    Make one with :meth:`load`; it never changes (:meth:`with_value` gives a new one).

    >>> scene = Scene.load("soap-bubble")
    >>> scene.to_dict()["camera"]["fov_deg"]
    35.0
    """

    __slots__ = ("_core",)

    def __init__(self, core: _core.Scene):
        if not isinstance(core, _core.Scene):
            raise TypeError(f"use ir.Scene.load(...) to make a scene, got {type(core).__name__}")
        self._core = core

    @classmethod
    def load(cls, source: str | os.PathLike[str] | Mapping[str, Any] | Scene, allow_outside: bool = False) -> Scene:
        """Read and validate a scene.

        source         the name of a built-in scene, a path to a TOML or JSON file, or a dict of the same shape
        allow_outside  let paths inside the scene leave its folder (of a dict: the current folder)
        Returns        the scene
        Raises         SceneError with ``.file``, ``.line``, ``.key``; ResourceError for a picture that cannot fit

        A name without a path separator and without an ending is a built-in scene unless a file of that name exists.

        >>> Scene.load("soap-bubble")
        <iridesce.Scene 512 x 512, object bubble, 1 light>
        """
        if isinstance(source, Scene):
            return source
        if isinstance(source, Mapping):
            return cls(_core.Scene.from_dict(dict(source), None, allow_outside))
        if not isinstance(source, (str, os.PathLike)):
            raise SceneError(
                f"a scene is a built-in name, a path, a dict or an ir.Scene, got {type(source).__name__}",
                None,
                None,
                None,
            )
        path = Path(source)
        is_name = isinstance(source, str) and not path.suffix and len(path.parts) <= 1
        if is_name and not path.is_file():
            return cls(_core.Scene.builtin(str(source)))
        return cls(_core.Scene.load(path, allow_outside))

    def to_dict(self) -> dict[str, Any]:
        """The scene as a dict with every default filled in.

        Returns  a new dict; ``Scene.load(scene.to_dict())`` is the same scene (from the same current folder)

        >>> Scene.load("soap-bubble").to_dict()["version"]
        1
        """
        result: dict[str, Any] = self._core.to_dict()
        return result

    def to_json(self) -> str:
        """The same tree as JSON text.

        Returns  one line of JSON

        >>> Scene.load("soap-bubble").to_json()[:12]
        '{"version":1'
        """
        return self._core.to_json()

    def with_value(self, path: str, value: Any) -> Scene:
        """The scene with one value replaced, validated anew.

        path     dotted; objects by name or number, lights by number: ``object.bubble.surface.film.thickness_nm``,
                 ``light.0.environment.radiance``, ``camera.fov_deg``
        value    a number, text, list or dict, or a thickness model
        Returns  a new scene; where a table takes one of several keys, the one set replaces the others
        Raises   SceneError for a path that leads nowhere or a value that is not allowed there

        >>> scene = Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", 400.0)
        >>> scene.to_dict()["object"][0]["surface"]["film"]["thickness_nm"]
        400.0
        """
        if not isinstance(path, str):
            raise SceneError(
                f'path must be a text such as "camera.fov_deg", got {type(path).__name__}', None, None, None
            )
        return Scene(self._core.with_value(path, value))

    def __repr__(self) -> str:
        tree = self.to_dict()
        width, height = tree["camera"]["resolution"]
        names = [item["name"] for item in tree["object"]]
        objects = f"object {names[0]}" if len(names) == 1 else f"{len(names)} objects"
        lights = len(tree["light"])
        return f"<iridesce.Scene {width} x {height}, {objects}, {lights} light{'s' if lights != 1 else ''}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.to_dict() == other.to_dict()

    def __hash__(self) -> int:
        return hash(self.to_json())

    def __reduce__(self) -> tuple[Any, ...]:
        return (_from_json, (self.to_json(),))


def _from_json(text: str) -> Scene:
    return Scene.load(json.loads(text))


def scene_names() -> list[str]:
    """Names of the built-in scenes.

    Returns  a list of texts, each good for ``Scene.load``

    >>> "soap-bubble" in scene_names()
    True
    """
    return _core.scene_names()


def scene_text(name: str) -> str:
    """The TOML text of a built-in scene, to start one's own from.

    name     one of :func:`scene_names`
    Returns  the text
    Raises   ValueError for an unknown name, with the nearest known one

    >>> scene_text("soap-bubble").splitlines()[1]
    'version = 1'
    """
    return _core.scene_text(name)
