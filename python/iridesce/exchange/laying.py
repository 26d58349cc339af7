"""What of a scene other programs can hold: the film of an object as a stack, and which of its thicknesses varies. Internal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from iridesce import color
from iridesce.exchange.appearance import roughness_of
from iridesce.exchange.films import Film
from iridesce.scene import Scene
from iridesce.stack import Layer, Stack

GRID = (512, 256)
"""Columns and rows of a map of thickness laid over an object."""

RAMP = (2, 256)
"""Columns and rows of the map that stands for a range of thickness without a map of its own."""

MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
"""Millimetres in a scene's unit."""

THICKEST_NM = 2e4
"""Fringes of thicker films have faded for every eye and every lamp of a broad spectrum; a map holds them at this."""


def folder_of(scene: Scene) -> Path:
    """Where a scene's files lie."""
    return Path(scene._core.folder) if scene._core.folder is not None else Path.cwd()


@dataclass(eq=False)
class Base:
    """The film of an object before its thickness is laid out."""

    film: Film | None
    """``None`` for matt surfaces and lamps."""
    recipe: Any = None
    """How its thickness varies; ``None`` where it does not."""
    others: dict[int, Any] = field(default_factory=dict)
    """Further layers that vary, which a target cannot hold."""

    def hold(self, layer: int, nm: float) -> None:
        """Holds a layer at one thickness."""
        assert self.film is not None
        stack = self.film.stack
        layers = list(stack.layers)
        layers[layer] = Layer(layers[layer].medium, nm, layers[layer].coherent)
        self.film = replace(self.film, stack=Stack([stack.first, *layers, stack.last]))


def film_base(item: Mapping[str, Any], recipe: Any, light: color.Illuminant, name: str, folder: Path) -> Base:
    """The film of one object, or of one of its parts, whose thickness the recipe is."""
    ((kind, keys),) = item["surface"].items()
    notes: list[str] = []
    which: int | None
    others: dict[int, Any] = {}
    if kind == "film":
        outside = medium_of(keys["outside"])
        items = [outside, _layer(keys["medium"], recipe), outside]
        which = 0
    elif kind == "coating":
        layers = keys["layers"]
        varying = [number for number, layer in enumerate(layers) if _varies(layer["thickness_nm"])]
        if len(varying) > 1:
            notes.append(
                f"{name}: several of its layers vary; all but {layers[varying[0]]['medium']} are held at their mean"
            )
        which = varying[0] if varying else (0 if layers else None)
        others = {number: layers[number]["thickness_nm"] for number in varying[1:]}
        recipe = layers[which]["thickness_nm"] if which is not None else 0.0
        items = [
            "air",
            *[_layer(layer["medium"], layer["thickness_nm"]) for layer in layers],
            medium_of(keys["substrate"]),
        ]
    elif kind in ("dielectric", "metal"):
        items, which, recipe = ["air", medium_of(keys["medium"])], None, 0.0
    else:
        return Base(None)
    rough = roughness_of(keys, folder, name, notes)
    if rough is not None:
        notes.append(f"{name}: errors are told for the smooth surface")
    varies = _varies(recipe) and which is not None
    nm = 0.0 if varies else float(recipe)
    film = Film(Stack(items), which, (nm, nm), light, name, None, kind == "film", notes, rough)
    return Base(film, recipe if varies else None, others)


def medium_of(value: Any) -> Any:
    """A medium as a scene writes it, as a stack takes it."""
    if isinstance(value, list | tuple):
        return complex(*value) if value[1] else float(value[0])
    return value


def plain_name(name: str) -> str:
    """An object's name as a file, a glTF and a USD prim can bear it."""
    kept = "".join(letter if letter.isascii() and (letter.isalnum() or letter in "-_") else "_" for letter in name)
    return kept if kept and not kept[0].isdigit() and kept[0] != "-" else f"film_{kept}"


def _varies(recipe: Any) -> bool:
    return isinstance(recipe, Mapping | str)


def _layer(medium: Any, recipe: Any) -> Layer:
    return Layer(medium_of(medium), 0.0 if _varies(recipe) else float(recipe))
