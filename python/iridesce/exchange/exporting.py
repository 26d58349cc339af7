"""``ir.export``: the look of a film, or a whole scene, for another program."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.exchange import charts
from iridesce.exchange.films import film_of, read_stack
from iridesce.exchange.output import checked_folder, write_folder
from iridesce.exchange.package import Package, Request
from iridesce.exchange.report import ExportReport
from iridesce.scene import Scene
from iridesce.stack import Stack
from iridesce.thickness import ThicknessMap

_TARGETS = {
    "lut": ("tables", "export_lut"),
    "cube": ("tables", "export_cube"),
    "gltf": ("gltf", "export_gltf"),
    "openpbr": ("openpbr", "export_openpbr"),
    "usd": ("usd", "export_usd"),
    "cycles": ("cycles", "export_cycles"),
    "mitsuba": ("mitsuba", "export_mitsuba"),
    "shader": ("shaders", "export_shader"),
    "osl": ("shaders", "export_osl"),
}
TARGETS = tuple(_TARGETS)

_FLAT = ("lut", "cube", "shader", "osl")


def export(
    stack_or_scene: Stack | Scene | str | os.PathLike[str] | Mapping[str, Any],
    to: str,
    path: str | os.PathLike[str],
    *,
    vary: ArrayLike | None = None,
    thickness: str | os.PathLike[str] | ThicknessMap | ArrayLike | None = None,
    illuminant: str | os.PathLike[str] | color.Illuminant = "D65",
    fit: bool = False,
) -> ExportReport:
    """Write a film, or a scene, for another program, and tell how far that program's colours are from the truth.

    stack_or_scene  a `Stack` or its text ("air / soap ? / air"), a `Scene`, or what `Scene.load` takes
    to              "lut" (EXR tables of exact colours), "cube", "shader" (GLSL, WGSL, HLSL, OSL), "osl", "mitsuba" (a
                    plugin with spectra), "cycles" (a script), "gltf", "openpbr" (MaterialX) or "usd"
    path            a folder; it is made where it is missing
    vary            (A, B) nm: the range over which the film's thickness goes; of several layers that one varies whose
                    thickness is an array, or ``?`` in text. Without it the extent of the map or array
    thickness       where the film is how thick: a file, a `ThicknessMap` or an array (rows from the top), nm
    illuminant      the lamp of tables and of the truth that errors are told against
    fit             fit the target's own knobs to the truth; the report says what it won
    Returns         ExportReport: files, delta_e, dropped, notes
    Raises          ValueError naming the argument, the value and what is allowed, SceneError for a scene; OSError where
                    the folder cannot be written. Nothing is left half written

    The truth is `Stack.color` in XYZ; the error that of the target's own film model, CIEDE2000.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     report = export("air / soap ? / air", "lut", folder, vary=(0.0, 1200.0))
    >>> [path.name for path in report.files]
    ['film_reflectance.exr', 'film_transmittance.exr']
    >>> report.delta_e["mean"] < 0.05
    True
    """
    if not isinstance(to, str) or to not in _TARGETS:
        raise refusal("to", f"one of {', '.join(TARGETS)}", to)
    if not isinstance(fit, bool | np.bool_):
        raise refusal("fit", "True or False", fit)
    folder = checked_folder(path)
    request = _request(stack_or_scene, vary, thickness, color.illuminant(illuminant), bool(fit))
    module, function = _TARGETS[to]
    work: Callable[[Request], Package] = getattr(
        importlib.import_module(f"iridesce.exchange.targets.{module}"), function
    )
    package = work(request)
    for film in request.films:
        for sentence in film.notes:
            package.note(sentence)
        if film.roughness is not None and to in _FLAT:
            package.drop(
                f"{film.name}: its roughness: {to} holds the colours of facets, the renderer has to spread them"
            )
    files = write_folder(folder, package.files)
    parts = {name: charts.summary(values, package.claims_deg) for name, values in package.differences.items()}
    # Every film counts by its chart, one of a single thickness by its seven entries.
    whole = charts.summary(np.concatenate(list(package.differences.values()), axis=1), package.claims_deg)
    return ExportReport(to, files, whole, tuple(package.dropped), tuple(package.notes), parts)


def _request(source: Any, vary: Any, thickness: Any, light: color.Illuminant, fit: bool) -> Request:
    layer = None
    if isinstance(source, str) and " / " in source:
        source, layer = read_stack(source)
    grid = None if thickness is None else _grid(thickness)
    if isinstance(source, Stack):
        return Request([film_of(source, layer, vary, grid, light)], light, None, fit)
    if vary is not None or thickness is not None:
        raise complaint(
            "vary and thickness go with a stack; the films of a scene have their own thicknesses",
            "vary" if vary is not None else "thickness",
            "left out for a scene",
            vary if vary is not None else Words(type(thickness).__name__),
        )
    from iridesce.exchange.laying import folder_of
    from iridesce.exchange.pieces import pieces_of

    scene = Scene.load(source)
    pieces = pieces_of(scene, light, folder_of(scene))
    return Request([piece.film for piece in pieces if piece.film is not None], light, scene, fit, pieces)


def _grid(thickness: Any) -> Floats:
    """The map of thicknesses, nm, rows from the top."""
    if isinstance(thickness, ThicknessMap):
        return thickness.thickness_nm
    if isinstance(thickness, str | os.PathLike):
        return ThicknessMap.load(Path(thickness)).thickness_nm
    return ThicknessMap(thickness).thickness_nm
