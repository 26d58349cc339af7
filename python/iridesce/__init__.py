"""iridesce: interference colour, from film to spectrum, colour and picture (``import iridesce as ir``)."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from iridesce._interrupts import keep_in_submodules, kept_interrupts
from iridesce._moved import keep_old_names

if TYPE_CHECKING:  # for editors and type checkers, which do not run the lines below
    from iridesce import color as color
    from iridesce import exchange as exchange
    from iridesce import plot as plot
    from iridesce import thickness as thickness
    from iridesce._core import __version__ as __version__
    from iridesce.color.color_table import ColorTable as ColorTable
    from iridesce.errors import ArgumentError as ArgumentError
    from iridesce.errors import ResourceError as ResourceError
    from iridesce.errors import SceneError as SceneError
    from iridesce.exchange import export as export
    from iridesce.exchange import import_scene as import_scene
    from iridesce.exchange import validate as validate
    from iridesce.files.report import ReadReport as ReadReport
    from iridesce.image import Image as Image
    from iridesce.inverse import fit as fit
    from iridesce.inverse.calibration import CameraCalibration as CameraCalibration
    from iridesce.inverse.fit import fit_thickness as fit_thickness
    from iridesce.inverse.footage import map_thickness_video as map_thickness_video
    from iridesce.inverse.measurement import Measurement as Measurement
    from iridesce.inverse.photograph import map_thickness as map_thickness
    from iridesce.inverse.recipe_search import recipes as recipes
    from iridesce.inverse.series import fit_series as fit_series
    from iridesce.notebooks import widget as widget
    from iridesce.optics.medium import Medium as Medium
    from iridesce.optics.medium import media as media
    from iridesce.rendering import merge as merge
    from iridesce.rendering import render as render
    from iridesce.scene import Scene as Scene
    from iridesce.stack import Layer as Layer
    from iridesce.stack import Stack as Stack
    from iridesce.sweeping import SweepResult as SweepResult
    from iridesce.sweeping import sweep as sweep

keep_in_submodules("iridesce")
keep_old_names()

# Names are imported on first use (PEP 562), so that `iridesce --help` and small scripts start at once.
_HOME = {
    "Medium": "optics.medium",
    "media": "optics.medium",
    "Layer": "stack",
    "Stack": "stack",
    "Scene": "scene",
    "ArgumentError": "errors",
    "SceneError": "errors",
    "ResourceError": "errors",
    "fit_thickness": "inverse.fit",
    "Measurement": "inverse.measurement",
    "fit_series": "inverse.series",
    "recipes": "inverse.recipe_search",
    "map_thickness": "inverse.photograph",
    "map_thickness_video": "inverse.footage",
    "CameraCalibration": "inverse.calibration",
    "ColorTable": "color.color_table",
    "Image": "image",
    "ReadReport": "files.report",
    "merge": "rendering",
    "render": "rendering",
    "export": "exchange",
    "validate": "exchange",
    "import_scene": "exchange",
    "widget": "notebooks",
    "sweep": "sweeping",
    "SweepResult": "sweeping",
}
_MODULES = {"color", "exchange", "fit", "plot", "thickness"}

__all__ = sorted([*_HOME, *_MODULES])


def __getattr__(name: str) -> Any:
    if name not in _HOME and name not in _MODULES and name != "__version__":
        raise AttributeError(f"module 'iridesce' has no attribute {name!r}")
    with kept_interrupts():
        if name in _HOME:
            value = getattr(importlib.import_module(f"iridesce.{_HOME[name]}"), name)
        elif name in _MODULES:
            value = importlib.import_module(f"iridesce.{name}")
        else:
            value = importlib.import_module("iridesce._core").__version__
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__"})
