"""Scenes: what to render, read from a file, a dict or the built-in set."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from iridesce import _core
from iridesce._notebook import facts_html
from iridesce._progress import Told, check_progress, watched
from iridesce.errors import SceneError
from iridesce.files.toml import dumps

__all__ = ["Scene", "scene_names", "scene_text"]


class Scene:
    """A validated scene, a recipe: every default filled in, every medium and illuminant found, every file named.

    Make one with `Scene.load`; it never changes (`with_value` gives a new one). Its maps are read and its films flow when it
    is first rendered, or with `resolve`; what was read and has flowed is shared by all scenes that come from one another
    through `with_value`. Equal scenes compare equal and hash
    alike, and they can be pickled.

    >>> scene = Scene.load("soap-bubble")
    >>> scene.to_dict()["camera"]["fov_deg"]
    35.0
    """

    __slots__ = ("_core",)

    def __init__(self, core: _core.Scene) -> None:
        if not isinstance(core, _core.Scene):
            raise TypeError(f"use ir.Scene.load(...) to make a scene, got {type(core).__name__}")
        self._core = core

    @classmethod
    def load(
        cls,
        source: str | os.PathLike[str] | Mapping[str, Any] | Scene,
        allow_outside: bool = False,
        progress: Told = None,
    ) -> Scene:
        """Read and validate a scene, in milliseconds: no map is read and no film flows.

        source         the name of a built-in scene, a path to a TOML or JSON file (JSON by its ending), or a dict of
                       the same shape; values may be numpy numbers and arrays, paths, `ir.thickness` models
        allow_outside  let files that the scene names lie outside its folder (of a dict: the current folder)
        progress       with it, or True for a bar, the scene is resolved too: see `resolve`
        Returns        Scene; a Scene is given back as it is
        Raises         SceneError with ``.file``, ``.line``, ``.key`` of the first thing that is wrong and ``.errors``, all
                       of them: a file that is missing, too long or no text,
                       unknown keys (the nearest known one is suggested), values that are not allowed, files outside
                       the folder; ResourceError: a picture that no machine can hold

        A text without a folder and an ending is the name of a built-in scene, or else of a file; write ``./soap-bubble``
        for a file that is called like a built-in scene.

        >>> Scene.load("soap-bubble")
        <iridesce.Scene 512 x 512, object bubble, 1 light>
        >>> Scene.load({"version": 1, "camera": {"fov": 30.0}})
        Traceback (most recent call last):
        iridesce.errors.SceneError: the scene needs the key "object"
        the scene needs the key "light"
        unknown key "fov" in camera; did you mean "fov_deg"?
        """
        check_progress(progress)
        scene = cls._loaded(source, allow_outside)
        return scene if progress is None or progress is False else scene.resolve(progress)

    @classmethod
    def _loaded(cls, source: str | os.PathLike[str] | Mapping[str, Any] | Scene, allow_outside: bool) -> Scene:
        if isinstance(source, Scene):
            return source
        if isinstance(source, Mapping):
            return cls(_core.Scene.from_dict(source, Path.cwd(), None, bool(allow_outside)))
        if not isinstance(source, (str, os.PathLike)):
            raise SceneError(
                f"a scene is a built-in name, a path, a dict or an ir.Scene, got {_type(source)} {source!r:.60}"
            )
        if isinstance(source, str) and _is_name(source):
            return cls(_core.Scene.builtin(source))
        path = os.fspath(source)
        if not isinstance(path, str):
            raise SceneError(f"the path of a scene must be a text, got {path!r:.60}")
        return cls(_core.Scene.load(path, bool(allow_outside)))

    def resolve(self, progress: Told = None) -> Scene:
        """Read its maps and let its films flow now, rather than with the first render.

        progress  called as ``progress(done, total)`` in steps of all films together; a function that takes ``stage`` also
                  hears of the maps, as ``progress(done, total, stage="reading")``; an exception from it stops the work.
                  True draws a bar on stderr
        Returns   the scene itself; renders of it, and of scenes made from it by `with_value`, begin at once
        Raises    SceneError for a map that cannot be used or a film that does not flow; KeyboardInterrupt on Ctrl-C

        >>> Scene.load("soap-bubble").resolve()
        <iridesce.Scene 512 x 512, object bubble, 1 light>
        """
        with watched(progress, "flowing", "the film flows") as tell:
            self._core.resolve(tell)
        return self

    def to_dict(self) -> dict[str, Any]:
        """The scene as a dict with every default filled in.

        Returns  a new dict of plain values; ``Scene.load(scene.to_dict())`` is the same scene, from the folder that
                 the paths in it are relative to
        Raises   nothing

        >>> Scene.load("soap-bubble").to_dict()["version"]
        1
        """
        result: dict[str, Any] = self._core.to_dict()
        return result

    def to_json(self) -> str:
        """The same tree as JSON text.

        Returns  one line of JSON
        Raises   nothing

        >>> Scene.load("soap-bubble").to_json()[:12]
        '{"version":1'
        """
        return self._core.to_json()

    def check(self) -> str:
        """The scene as a TOML file with every default filled in, as ``iridesce check`` prints it.

        Returns  the text; reading it gives the same scene
        Raises   nothing

        >>> print(Scene.load("soap-bubble").check()[:26])
        version = 1
        unit = "cm"
        <BLANKLINE>
        [
        """
        return dumps(self.to_dict())

    def with_value(self, path: str, value: Any) -> Scene:
        """The scene with one value replaced, validated anew; no map is read, and no film flows.

        path     dotted; objects by name or number, lights by number: ``object.bubble.surface.film.thickness_nm``,
                 ``light.0.environment.radiance``, ``camera.fov_deg``
        value    a number, text, list or dict, or an `ir.thickness` model
        Returns  a new Scene; where a table takes one of several keys, the one set replaces the others
        Raises   SceneError for a path that leads nowhere or a value that is not allowed there, with the key;
                 ResourceError for a picture that no machine can hold

        >>> scene = Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", 400.0)
        >>> scene.to_dict()["object"][0]["surface"]["film"]["thickness_nm"]
        400.0
        """
        if not isinstance(path, str):
            raise SceneError(f'path must be a text such as "camera.fov_deg", got {_type(path)} {path!r:.60}')
        return Scene(self._core.with_value(path, value))

    def __repr__(self) -> str:
        tree = self.to_dict()
        width, height = tree["camera"]["resolution"]
        names = [item["name"] for item in tree["object"]]
        objects = f"object {names[0]}" if len(names) == 1 else f"{len(names)} objects"
        lights = len(tree["light"])
        return f"<iridesce.Scene {width} x {height}, {objects}, {lights} light{'s' if lights != 1 else ''}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: the picture's size, each object and each light."""
        tree = self.to_dict()
        width, height = tree["camera"]["resolution"]
        facts = [("picture", f"{width} x {height}, {tree['render']['samples']} samples")]
        facts += [
            (f"object {one['name']}", f"{_kind(one['shape'])}, {_kind(one['surface'])}") for one in tree["object"]
        ]
        facts += [("light", _light(one)) for one in tree["light"]]
        return facts_html("iridesce.Scene", facts)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self._identity() == other._identity()

    def __hash__(self) -> int:
        return hash(self._identity())

    def __reduce__(self) -> tuple[Any, ...]:
        core = self._core
        return (_restore, (self.to_json(), core.folder, core.file, core.allow_outside))

    def _identity(self) -> tuple[Any, ...]:
        """What makes two scenes equal: the same tree, and the same folder where a file is named in it."""
        lights = [light["environment"] for light in self.to_dict()["light"]]
        names_files = any(
            not light.get("map", "builtin:").startswith("builtin:")
            or light.get("illuminant", "").lower().endswith(".csv")
            for light in lights
        )
        return self.to_json(), self._core.folder if names_files else None


def _kind(table: Any) -> str:
    """``film of soap``, ``sphere``: the one key of a table, and its medium."""
    if not isinstance(table, dict) or len(table) != 1:
        return str(table)
    ((kind, inside),) = table.items()
    medium = inside.get("medium", inside.get("substrate")) if isinstance(inside, dict) else None
    return str(kind) if medium is None else f"{kind} of {medium}"


def _light(table: dict[str, Any]) -> str:
    """``environment, builtin studio``: the one key of a light, and its texts."""
    ((kind, inside),) = table.items()
    return ", ".join([kind, *(f"{key} {value}" for key, value in inside.items() if isinstance(value, str))])


def _restore(text: str, folder: Path | None, file: Path | None, allow_outside: bool) -> Scene:
    return Scene(_core.Scene.from_dict(json.loads(text), folder or Path.cwd(), file, allow_outside))


def _is_name(source: str) -> bool:
    """Whether a text names a built-in scene rather than a file; an unknown plain word that is no file does, too."""
    if source in _core.scene_names():
        return True
    plain = not Path(source).suffix and not any(mark and mark in source for mark in (os.sep, os.altsep, "\0"))
    return plain and not Path(source).exists()


def _type(value: object) -> str:
    return type(value).__name__


def scene_names() -> list[str]:
    """Names of the built-in scenes.

    Returns  a list of texts, each good for `Scene.load`
    Raises   nothing

    >>> "soap-bubble" in scene_names()
    True
    """
    return _core.scene_names()


def scene_text(name: str) -> str:
    """The TOML text of a built-in scene, to start one's own from.

    name     one of `scene_names`
    Returns  the text
    Raises   SceneError for an unknown name, with the nearest known one

    >>> scene_text("soap-bubble").splitlines()[1]
    'version = 1'
    """
    if not isinstance(name, str):
        raise SceneError(f"name must be a text, got {_type(name)}")
    return _core.scene_text(name)
