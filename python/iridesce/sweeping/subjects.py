"""What is swept: a scene or a stack, at a point of the grid, and what is kept of it. Subjects can be pickled."""

from __future__ import annotations

import hashlib
import inspect
import json
import os
import re
import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from iridesce.arguments.refusals import complaint, refusal, within
from iridesce.image import Image
from iridesce.optics.layer import Layer
from iridesce.optics.medium import as_medium
from iridesce.optics.wavelengths import SPECTRUM_NM, in_steps
from iridesce.rendering import render
from iridesce.scene import Scene
from iridesce.stack import Stack
from iridesce.sweeping.grid import Point, describe_medium
from iridesce.sweeping.needed import needed_files

# What is kept of a stack, and the arguments that a point may give it.
_LIGHT = ("wavelength_nm", "angle_deg", "polarization")
QUANTITIES: dict[str, tuple[str, ...]] = {
    "color": (
        *("angle_deg", "polarization", "illuminant", "observer", "space", "quantity", "model", "wavelength_nm"),
        *("adaptation", "gamut"),
    ),
    "reflectance": _LIGHT,
    "transmittance": _LIGHT,
    "absorptance": _LIGHT,
    "layer_absorptance": _LIGHT,
    "psi": _LIGHT[:2],
    "delta": _LIGHT[:2],
}
# Wavelengths of a spectrum whose points name none: those of `iridesce spectrum`.
UNNAMED_NM = in_steps(SPECTRUM_NM, 1.0)
_LAYER_KEYS = ("thickness_nm", "medium", "coherent")

# A picture of up to so many camera rays is drawn beside others on one thread, a larger one by all threads.
_SMALL_RAYS = 1 << 23

Function = Callable[[Any], Any]


class Axis(NamedTuple):
    """A last axis of a value: its name and, where it has them, coordinates."""

    name: str
    coordinates: Any = None


class SceneSubject:
    """A scene with some of its values changed; pictures of it, or what a function makes of it."""

    kind = "scene"

    def __init__(self, scene: Scene, quantity: str | Function) -> None:
        self._scene: Scene | None = scene
        self._text = scene.to_json()
        self.folder = Path(os.fspath(scene._core.folder)) if scene._core.folder is not None else Path.cwd()
        self._file = scene._core.file
        self._allow_outside = scene._core.allow_outside
        self.quantity = quantity
        self._lock = threading.Lock()

    @property
    def scene(self) -> Scene:
        """The scene itself, made anew where this subject has been sent to: maps are read once for all points."""
        with self._lock:
            if self._scene is None:
                from iridesce import _core

                tree = json.loads(self._text)
                self._scene = Scene(_core.Scene.from_dict(tree, self.folder, self._file, self._allow_outside))
            return self._scene

    def at(self, point: Point) -> Scene:
        """The scene of a point."""
        scene = self.scene
        for key, value in point.items():
            scene = scene.with_value(key, value)
        return scene

    def check(self, point: Point) -> None:
        """Raise what is wrong with a point; nothing is drawn."""
        self.at(point)

    def value(self, point: Point, threads: int | None, progress: Any = None) -> Any:
        """What is kept of a point."""
        scene = self.at(point)
        if callable(self.quantity):
            return self.quantity(scene)
        return render(scene, threads=threads, progress=progress)

    def is_small(self, points: Iterable[Point]) -> bool:
        """Whether points are so small that they are best done side by side."""
        if callable(self.quantity):
            return False
        tree = self.scene.to_dict()
        width, height = tree["camera"]["resolution"]
        rays = width * height * tree["render"]["samples"]
        varied = {key for point in points for key in point}
        return rays <= _SMALL_RAYS and not varied & {"camera.resolution", "render.samples", "camera", "render"}

    def files(self, points: Iterable[Point]) -> dict[str, Path]:
        """Files that the scene or its points name: the name as it is written, and where it is."""
        return needed_files([json.loads(self._text), *(list(point.values()) for point in points)], self.folder)

    def described(self) -> dict[str, Any]:
        """For a store."""
        return {"scene": json.loads(self._text)}

    def last_axes(self, shape: tuple[int, ...], constant: Mapping[str, Any]) -> list[Axis]:
        """Names of a value's axes."""
        if self.quantity == "image" and len(shape) == 3:
            return [Axis("y"), Axis("x"), Axis("channel", ["X", "Y", "Z"])]
        return [Axis(f"axis_{number}") for number in range(len(shape))]

    def moved(self, folder: Path) -> SceneSubject:
        """The same, its files in another folder."""
        other = SceneSubject.__new__(SceneSubject)
        other.__setstate__({**self.__getstate__(), "folder": folder})
        return other

    def __getstate__(self) -> dict[str, Any]:
        names = ("_text", "folder", "_file", "_allow_outside", "quantity")
        return {name: getattr(self, name) for name in names}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._scene = None
        self._lock = threading.Lock()


class StackSubject:
    """A stack with some of its values changed and the light that falls on it; numbers of it, or what a function makes of it."""

    kind = "stack"

    def __init__(self, stack: Stack, quantity: str | Function, folder: Path = Path()) -> None:
        self.stack = stack
        self.quantity = quantity
        self.folder = folder

    def at(self, point: Point) -> Stack:
        """The stack of a point."""
        media = [self.stack.first, self.stack.last]
        layers = [[layer.thickness_nm, layer.medium, layer.coherent] for layer in self.stack.layers]
        for key, value in point.items():
            match = re.fullmatch(r"layers\.(\d{1,6})\.(\w+)", key)
            if key in ("first", "last"):
                media[key == "last"] = as_medium(_medium(value))
            elif match is not None and match[2] in _LAYER_KEYS:
                number = int(match[1])
                if number >= len(layers):
                    has = f"has layers 0 to {len(layers) - 1}" if layers else "has no layers"
                    raise complaint(f'vary: no "{key}"; the stack {has}', "vary", f"keys of a stack that {has}", key)
                kind = _LAYER_KEYS.index(match[2])
                layers[number][kind] = _medium(value) if match[2] == "medium" else value
            elif callable(self.quantity) or key not in QUANTITIES[self.quantity]:
                raise complaint(self._unknown(key), "vary", "keys of the stack and its quantity", key)
        return Stack([media[0], *(_layer(number, *layer) for number, layer in enumerate(layers)), media[1]])

    def check(self, point: Point) -> None:
        """Raise what is wrong with a point: with its stack, or with the light, of which a single film is asked instead."""
        self.at(point)
        if not callable(self.quantity):
            self._ask(Stack(["air", Layer(1.33, 100.0), 1.5]), point, 1)

    def value(self, point: Point, threads: int | None, progress: Any = None) -> Any:
        """What is kept of a point."""
        stack = self.at(point)
        return self.quantity(stack) if callable(self.quantity) else self._ask(stack, point, threads)

    def _ask(self, stack: Stack, point: Point, threads: int | None) -> Any:
        assert isinstance(self.quantity, str)
        light = {key: value for key, value in point.items() if key in QUANTITIES[self.quantity]}
        lamp = light.get("illuminant")
        if isinstance(lamp, str) and lamp in needed_files([lamp], self.folder):
            light["illuminant"] = self.folder / lamp
        if self.quantity == "color":
            return stack.color(**light)
        light.setdefault("wavelength_nm", UNNAMED_NM)
        if self.quantity in ("psi", "delta"):
            angles = stack.ellipsometry(light["wavelength_nm"], light.get("angle_deg", 0.0), threads=threads)
            return angles[self.quantity == "delta"]
        return getattr(stack, self.quantity)(**light, threads=threads)

    def _unknown(self, key: str) -> str:
        own = ["layers.N.thickness_nm", "layers.N.medium", "layers.N.coherent", "first", "last"]
        if callable(self.quantity):
            return f'vary: unknown "{key}"; a function receives the stack, of which vary: {", ".join(own)}'
        known = ", ".join([*own, *QUANTITIES[self.quantity]])
        return f'vary: unknown "{key}" of a stack\'s {self.quantity}; known: {known}'

    def is_small(self, points: Iterable[Point]) -> bool:
        """Whether points are best done side by side: those of a stack take less than handing them out."""
        return False

    def files(self, points: Iterable[Point]) -> dict[str, Path]:
        """Files that points name: a lamp's table."""
        return needed_files([list(point.values()) for point in points], self.folder)

    def described(self) -> dict[str, Any]:
        """For a store."""
        stack = self.stack
        layers = [
            {
                "medium": describe_medium(layer.medium),
                "thickness_nm": np.asarray(layer.thickness_nm).tolist(),
                "coherent": layer.coherent,
            }
            for layer in stack.layers
        ]
        return {"stack": {"first": describe_medium(stack.first), "layers": layers, "last": describe_medium(stack.last)}}

    def last_axes(self, shape: tuple[int, ...], constant: Mapping[str, Any]) -> list[Axis]:
        """Names of a value's axes; ``constant`` holds what is the same at all points."""
        plain = [Axis(f"axis_{number}") for number in range(len(shape))]
        if callable(self.quantity):
            return plain
        if self.quantity == "color" and shape == (3,) and constant.get("space", "xyz") is not None:
            names = {"xyz": "XYZ", "xyy": "xyY", "lab": "Lab", "lch": "LCh", "oklab": "Lab"}
            return [Axis("channel", list(names.get(constant.get("space", "xyz"), "RGB")))]
        if "wavelength_nm" not in constant and len(shape) >= 1 and shape[0] == len(UNNAMED_NM):
            return [Axis("wavelength_nm", UNNAMED_NM), *plain[1:]]
        return plain

    def moved(self, folder: Path) -> StackSubject:
        """The same, its files in another folder; media have their tables with them."""
        return StackSubject(self.stack, self.quantity, folder)


Subject = SceneSubject | StackSubject


def subject_of(base: Any, quantity: Any) -> Subject:
    """The subject that a caller means; ``ValueError`` for what is none and for quantities that it does not have."""
    if isinstance(base, str) and re.search(r"(?<!\S)/(?!\S)", base):
        base = Stack.parse(base)
    if isinstance(base, Stack):
        return StackSubject(base, _checked(quantity, "color", tuple(QUANTITIES), "a stack"))
    return SceneSubject(Scene.load(base), _checked(quantity, "image", ("image",), "a scene"))


def describe_quantity(quantity: str | Function) -> Any:
    """For a store: a word, or a function by its name and its source, so that another one is told from it."""
    if isinstance(quantity, str):
        return quantity
    inner = getattr(quantity, "func", quantity)  # of a functools.partial
    name = getattr(inner, "__qualname__", type(inner).__qualname__)
    try:
        source = inspect.getsource(inner if hasattr(inner, "__qualname__") else type(inner))
    except (OSError, TypeError):
        # Typed at a prompt or built in: what Python made of it.
        code = getattr(inner, "__code__", None)
        source = repr((code.co_code, code.co_consts, code.co_names)) if code is not None else name
        source = re.sub(r" at 0x[0-9a-f]+", "", source)
    given = [repr(getattr(quantity, part)) for part in ("args", "keywords") if inner is not quantity]
    digest = hashlib.sha256("\n".join([source, *given]).encode()).hexdigest()
    return {"function": name, "source_sha256": digest}


def _checked(quantity: Any, default: str, known: tuple[str, ...], of: str) -> str | Function:
    if quantity is None:
        return default
    if callable(quantity):
        function: Function = quantity
        return function
    if not isinstance(quantity, str) or quantity not in known:
        words = ", ".join(f'"{word}"' for word in known)
        raise refusal(f"quantity of {of}", f"{words} or a function", quantity)
    return quantity


def _layer(number: int, thickness_nm: Any, medium: Any, coherent: Any) -> Layer:
    try:
        return Layer(medium, thickness_nm, coherent)
    except ValueError as error:
        raise within(f"vary: layers.{number}", error) from None


def _medium(value: Any) -> Any:
    """``[n, k]`` as in scenes, beside what a `Stack` takes."""
    if isinstance(value, list) and len(value) == 2 and all(isinstance(one, int | float) for one in value):
        return complex(value[0], value[1])
    return value


def checked_value(value: Any) -> Any:
    """What a store can hold: an `Image`, or an array of numbers; ``TypeError`` for anything else."""
    if isinstance(value, Image):
        return value
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.asarray(None)
    if array.dtype.kind not in "biufc":
        raise TypeError(f"the function must answer numbers, an array of numbers or an Image, got {value!r:.80}")
    return array
