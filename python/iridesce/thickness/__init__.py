"""Thickness models: how thick a film is, where. Each goes into a scene as ``thickness_nm`` and gives a map.

>>> import iridesce as ir
>>> drained = ir.thickness.gradient(top=20.0, bottom=900.0, exponent=0.8)
>>> scene = ir.Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", drained)
>>> ir.Stack(["air", ir.Layer("soap", thickness_nm=drained.map(2, 3)), "air"]).color().shape
(3, 2, 3)
"""

from __future__ import annotations

from iridesce.thickness.models import (
    ThicknessModel,
    flow,
    gradient,
    lens_gap,
    map,
    uniform,
    wedge,
)
from iridesce.thickness.simulation import (
    Frame,
    Simulation,
    presets,
    simulate,
)
from iridesce.thickness.thickness_map import (
    ThicknessMap,
)

__all__ = [
    "Frame",
    "Simulation",
    "ThicknessMap",
    "ThicknessModel",
    "flow",
    "gradient",
    "lens_gap",
    "map",
    "presets",
    "simulate",
    "uniform",
    "wedge",
]


def __dir__() -> list[str]:
    return __all__
