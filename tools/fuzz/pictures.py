"""Scenes with some values, keys, surfaces or shapes changed that are still trees of the right form, drawn in a few pixels.

Mutated bytes are nearly always refused by the reader; these get as far as the renderer.
"""

from __future__ import annotations

import copy
import json
import random
from pathlib import Path
from typing import Any

NUMBERS = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    1e-30,
    1e-12,
    1e-6,
    1e-3,
    0.999999,
    1.000001,
    10.0,
    90.0,
    1e3,
    1e6,
    1e9,
    1e30,
    1e300,
    -1e6,
)
SHAPES: tuple[dict[str, Any], ...] = (
    {"sphere": {"center": [0.0, 0.0, 0.0], "radius": 1.0}},
    {"rectangle": {"center": [0.0, 0.0, 0.0], "u": [1.0, 0.0, 0.0], "v": [0.0, 1.0, 0.0]}},
    {"disk": {"center": [0.0, 0.0, 0.0], "normal": [0.0, 0.3, 1.0], "radius": 1.0}},
    {"plane": {"point": [0.0, -1.0, 0.0], "normal": [0.0, 1.0, 0.0]}},
    {"cap": {"center": [0.0, 0.0, 0.0], "axis": [0.0, 1.0, 0.0], "radius_of_curvature": 2.0, "aperture_radius": 1.0}},
    {"cylinder": {"center": [0.0, 0.0, 0.0], "axis": [0.0, 1.0, 0.0], "radius": 0.5, "height": 1.0}},
    {"bubbles": {"spheres": [{"center": [-0.5, 0.0, 0.0], "radius": 0.8}, {"center": [0.5, 0.0, 0.0], "radius": 0.8}]}},
    {"mesh": {"file": "thing.ply"}},
)
THICKNESSES: tuple[Any, ...] = (
    0.0,
    300.0,
    2e4,
    {"gradient": {"top": 0.0, "bottom": 800.0, "exponent": 1.0}},
    {"wedge": {"from": [-1.0, 0.0, 0.0], "to": [1.0, 0.0, 0.0], "start_nm": 0.0, "end_nm": 900.0}},
    {"lens_gap": {"radius_mm": 100.0, "contact_gap_nm": 0.0}},
)
SURFACES: tuple[dict[str, Any], ...] = (
    {"film": {"medium": "soap", "thickness_nm": 300.0, "roughness": 0.0}},
    {"film": {"medium": 1.33, "thickness_nm": 300.0, "roughness": 0.3}},
    {"coating": {"layers": [{"medium": 1.47, "thickness_nm": 400.0}], "substrate": "water", "roughness": 0.2}},
    {"coating": {"layers": [{"medium": "TiO2", "thickness_nm": 60.0}], "substrate": "Ti", "roughness": [0.1, 0.4]}},
    {"dielectric": {"medium": "N-BK7", "roughness": 0.0}},
    {"dielectric": {"medium": 1.5, "roughness": 0.5}},
    {"metal": {"medium": [0.5, 3.0], "roughness": 0.1}},
    {"diffuse": {"reflectance": [0.5, 0.4, 0.3]}},
    {"emitter": {"illuminant": "D65", "radiance": 2.0}},
)
LIGHTS: tuple[dict[str, Any], ...] = (
    {"environment": {"illuminant": "D65", "radiance": 1.0}},
    {"environment": {"builtin": "studio", "radiance": 1.0, "rotation_deg": 10.0}},
    {"sun": {"direction": [0.3, 1.0, 0.2], "angular_diameter_deg": 0.53, "irradiance": 1.0}},
    {"directional": {"direction": [0.3, 1.0, 0.2], "irradiance": 1.0}},
    {"point": {"position": [1.0, 2.0, 2.0], "intensity": 3.0}},
    {"spot": {"position": [1.0, 2.0, 2.0], "target": [0.0, 0.0, 0.0], "cone_deg": 40.0, "intensity": 3.0}},
)
TRANSFORM: dict[str, Any] = {"scale": [1.0, 1.0, 1.0], "rotate_deg": [0.0, 20.0, 0.0], "translate": [0.0, 0.0, 0.0]}


def tree_of(content: bytes) -> dict[str, Any]:
    """The scene that some bytes tell: the same for the same bytes."""
    dice = random.Random(content)
    tree: dict[str, Any] = {
        "version": 1,
        "camera": {"position": [0.0, 0.5, 6.0], "target": [0.0, 0.0, 0.0], "fov_deg": 30.0, "resolution": [4, 4]},
        "render": {"max_depth": dice.choice((1, 2, 16)), "samples": 1, "seed": 1},
        "object": [],
        "light": [copy.deepcopy(dice.choice(LIGHTS)) for _ in range(dice.choice((1, 1, 2)))],
    }
    if dice.random() < 0.2:
        tree["camera"] |= {"aperture_radius": 0.1, "focus_distance": 6.0}
    for number in range(dice.choice((1, 1, 2, 3, 4))):
        item = {"name": f"o{number}", "shape": copy.deepcopy(dice.choice(SHAPES))}
        item["surface"] = copy.deepcopy(dice.choice(SURFACES))
        ((kind, keys),) = item["surface"].items()
        if kind == "film":
            keys["thickness_nm"] = copy.deepcopy(dice.choice(THICKNESSES))
        if dice.random() < 0.3:
            item["transform"] = copy.deepcopy(TRANSFORM)
        if dice.random() < 0.1:
            item["instances"] = [copy.deepcopy(TRANSFORM), {"translate": [0.3, 0.0, 0.0]}]
        if dice.random() < 0.1:
            item["priority"] = number
        tree["object"].append(item)
    for _ in range(dice.choice((0, 1, 1, 2, 3))):
        _change(tree, dice)
    return tree


def _change(tree: dict[str, Any], dice: random.Random) -> None:
    """Another number somewhere; seldom a key less."""
    places: list[tuple[Any, Any]] = []

    def walk(node: Any) -> None:
        for key, value in list(node.items() if isinstance(node, dict) else enumerate(node)):
            if isinstance(value, dict | list):
                walk(value)
            elif isinstance(value, int | float):
                places.append((node, key))

    walk({key: tree[key] for key in ("camera", "render", "object", "light")})
    node, key = dice.choice(places)
    if dice.random() < 0.05 and isinstance(node, dict):
        del node[key]
    elif isinstance(node[key], int) and not isinstance(node[key], bool):
        node[key] = dice.choice((0, 1, 2, 5, 100))
    else:
        node[key] = dice.choice((dice.choice(NUMBERS), node[key] * dice.choice((0.5, -1.0, 2.0, 10.0, 1e3, 1e-3))))


def draw(content: bytes, folder: Path) -> Any:
    """A scene of bytes, drawn."""
    return picture(tree_of(content), folder)


def draw_mesh(name: str, content: bytes, folder: Path) -> Any:
    """A mesh of these bytes with some surface, drawn."""
    dice = random.Random(content)
    (folder / name).write_bytes(content)
    tree = tree_of(b"plain")
    tree["object"] = [{"name": "thing", "shape": {"mesh": {"file": name}}, "surface": dice.choice(SURFACES)}]
    tree["light"] = [dice.choice(LIGHTS)]
    return picture(tree, folder)


def picture(tree: dict[str, Any], folder: Path) -> Any:
    import numpy as np

    import iridesce as ir

    path = folder / "picture.json"
    path.write_text(json.dumps(tree))
    image = ir.render(path, size=(4, 4), samples=1, threads=1, progress=False)
    if not np.isfinite(image.xyz).all():
        raise AssertionError("a picture with values that are no numbers")
    return image
