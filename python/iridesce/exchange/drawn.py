"""Maps that only the renderer can read or make: what it says of a square that bears them. Internal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.scene import Scene

_BUILTIN = "builtin:"


def is_builtin(name: object) -> bool:
    """Whether a scene means a file that comes with the program."""
    return isinstance(name, str) and name.startswith(_BUILTIN)


def drawn_shares(name: str) -> Floats:
    """A grey map that comes with the program, 0 to 1, row 0 on top."""
    return by_render({"map": name, "min_nm": 0.0, "max_nm": 1e4}) / 1e4


def by_render(recipe: Mapping[str, Any]) -> Floats:
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
