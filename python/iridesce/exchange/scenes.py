"""What of a scene other programs can hold: its films, each with its stack and the map of its thickness. Internal."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from iridesce import color, thickness
from iridesce.arguments.operands import Floats
from iridesce.exchange.appearance import roughness_of
from iridesce.exchange.films import Film
from iridesce.exchange.geometry import Surface, globe, surface_of
from iridesce.scene import Scene
from iridesce.stack import Layer, Stack
from iridesce.thickness import ThicknessMap

GRID = (512, 256)
"""Columns and rows of a map of thickness laid over an object."""

MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
"""Millimetres in a scene's unit."""

THICKEST_NM = 2e4
"""Fringes of thicker films have faded for every eye and every lamp of a broad spectrum; a map holds them at this."""

_OPEN_PLANE = 4.0


def films_of(scene: Scene, light: color.Illuminant) -> list[Film]:
    """The films and bare optical surfaces of a scene, named after their objects."""
    tree = scene.to_dict()
    folder = folder_of(scene)
    films = [film for item in tree["object"] if (film := film_of_object(item, tree["unit"], folder, light)) is not None]
    if not films:
        raise ValueError("the scene has no surface that interferes: no film, coating, dielectric or metal")
    return films


def folder_of(scene: Scene) -> Path:
    """Where a scene's files lie."""
    return Path(scene._core.folder) if scene._core.folder is not None else Path.cwd()


def film_of_object(item: Mapping[str, Any], unit: str, folder: Path, light: color.Illuminant) -> Film | None:
    """The film of one object; ``None`` for matt surfaces and lamps."""
    ((kind, keys),) = item["surface"].items()
    name = plain_name(item["name"])
    notes: list[str] = []
    which: int | None
    if kind == "film":
        outside = medium_of(keys["outside"])
        items, which, recipe = [outside, _layer(keys), outside], 0, keys["thickness_nm"]
    elif kind == "coating":
        layers = keys["layers"]
        varying = [number for number, layer in enumerate(layers) if isinstance(layer["thickness_nm"], Mapping)]
        if len(varying) > 1:
            notes.append(
                f"{name}: several of its layers vary; all but {layers[varying[0]]['medium']} are held at their mean"
            )
        which = varying[0] if varying else (0 if layers else None)
        recipe = layers[which]["thickness_nm"] if which is not None else 0.0
        items = ["air", *[_held(layer, item, unit, folder) for layer in layers], medium_of(keys["substrate"])]
    elif kind in ("dielectric", "metal"):
        items, which, recipe = ["air", medium_of(keys["medium"])], None, 0.0
    else:
        return None
    rough = roughness_of(keys, folder, name, notes)
    if rough is not None:
        notes.append(f"{name}: errors are told for the smooth surface")
    stack = Stack(items)
    if isinstance(recipe, Mapping) and which is not None:
        grid = thickness_grid(item, recipe, unit, folder)
        if grid.max() > THICKEST_NM:
            notes.append(
                f"{name}: thicker than {THICKEST_NM:g} nm, up to {grid.max():.6g}, is held at {THICKEST_NM:g} nm"
            )
            grid = np.minimum(grid, THICKEST_NM)
        extent = (float(grid.min()), float(grid.max()))
        if extent[0] == extent[1]:
            return Film(stack, which, extent, light, name, None, kind == "film", notes, rough)
        return Film(stack, which, extent, light, name, grid, kind == "film", notes, rough)
    if isinstance(recipe, str):
        notes.append(f"{name}: thickness {recipe!r} of the mesh's own points is not laid out; 0 nm is written")
        recipe = 0.0
    return Film(stack, which, (float(recipe), float(recipe)), light, name, None, kind == "film", notes, rough)


def thickness_grid(item: Mapping[str, Any], recipe: Mapping[str, Any], unit: str, folder: Path) -> Floats:
    """The thickness over u and v at the middles of the cells, row 0 on top (v = 1)."""
    columns, rows = GRID
    surface = surface_of(item["shape"])
    u = (np.arange(columns) + 0.5)[None, :] / columns
    v = 1.0 - (np.arange(rows) + 0.5)[:, None] / rows
    if str(recipe.get("map", "")).startswith("builtin:"):
        return _by_render(recipe)
    if "map" in recipe:
        path = Path(recipe["map"])
        ends = {key: recipe.get(key) for key in ("min_nm", "max_nm")}
        return np.asarray(ThicknessMap.load(path if path.is_absolute() else folder / path, **ends).thickness_nm)
    if "flow" in recipe:
        grid = thickness.flow(**recipe["flow"]).map(columns, rows)
        if surface is not None and surface.kind == "cap":
            across, up = globe(surface.points(u, v), surface.middle_of_sphere())
            return np.asarray(grid.sample(across, up))
        return np.asarray(grid.thickness_nm)
    if "swirls" in recipe:
        return _by_render(recipe)
    if surface is None:
        raise ValueError(
            f"{item['name']}: a {next(iter(recipe))} on the shape {next(iter(item['shape']))} cannot be laid out"
        )
    points = surface.points(u, v)
    if surface.kind == "plane":  # the patch that the map of a plane covers
        points = surface.points(0.5 + _OPEN_PLANE * (u - 0.5), 0.5 + _OPEN_PLANE * (v - 0.5))
    if surface.kind in ("disk", "cap"):  # the corners of the square lie beyond the rim: they go on as the rim is
        beyond = np.maximum(np.hypot(2 * u - 1, 2 * v - 1), 1.0)
        points = surface.points(0.5 + (u - 0.5) / beyond, 0.5 + (v - 0.5) / beyond)
    return _at_points(recipe, surface, points, unit)


def _at_points(recipe: Mapping[str, Any], surface: Surface, points: Floats, unit: str) -> Floats:
    ((kind, keys),) = recipe.items()
    if kind == "gradient":
        low, high = surface.heights()
        height = np.clip((points[..., 1] - low) / (high - low), 0.0, 1.0)
        return np.asarray(thickness.gradient(**keys).at_height(height), dtype=np.float64)
    if kind == "wedge":
        named = {f"{key}_point" if key in ("from", "to") else key: value for key, value in keys.items()}
        return np.asarray(np.maximum(thickness.wedge(**named).at_point(points), 0.0), dtype=np.float64)
    center = np.asarray(surface.keys.get("center", surface.keys.get("point")), dtype=np.float64)
    way = points - center
    if surface.kind == "cap":
        axis = surface.frame()[2]
        way = way - (way @ axis)[..., None] * axis
    radius_mm = np.linalg.norm(way, axis=-1) * MM[unit]
    return np.asarray(thickness.lens_gap(**keys).at_radius(np.minimum(radius_mm, 0.999 * float(keys["radius_mm"]))))


def _by_render(recipe: Mapping[str, Any]) -> Floats:
    """A model that only the renderer knows: what it says of a square that faces a parallel view."""
    from iridesce.rendering import render

    tree = {
        "version": 1,
        "camera": {"position": [0, 0, 4], "orthographic_height": 2.0, "resolution": [512, 512]},
        "object": [
            {
                "name": "square",
                "shape": {"rectangle": {"center": [0, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0]}},
                "surface": {"film": {"medium": 1.5, "thickness_nm": dict(recipe)}},
            }
        ],
        "light": [{"environment": {"illuminant": "E"}}],
    }
    image = render(Scene.load(tree), samples=1, seed=1)
    return np.asarray(image.channels["thickness_nm"], dtype=np.float64)


def medium_of(value: Any) -> Any:
    """A medium as a scene writes it, as a stack takes it."""
    if isinstance(value, list | tuple):
        return complex(*value) if value[1] else float(value[0])
    return value


def plain_name(name: str) -> str:
    """An object's name as a file, a glTF and a USD prim can bear it."""
    kept = "".join(letter if letter.isascii() and (letter.isalnum() or letter in "-_") else "_" for letter in name)
    return kept if kept and not kept[0].isdigit() and kept[0] != "-" else f"film_{kept}"


def _layer(keys: Mapping[str, Any]) -> Layer:
    recipe = keys["thickness_nm"]
    return Layer(medium_of(keys["medium"]), 0.0 if isinstance(recipe, Mapping | str) else float(recipe))


def _held(keys: Mapping[str, Any], item: Mapping[str, Any], unit: str, folder: Path) -> Layer:
    recipe = keys["thickness_nm"]
    if isinstance(recipe, Mapping):
        return Layer(medium_of(keys["medium"]), float(thickness_grid(item, recipe, unit, folder).mean()))
    return _layer(keys)
