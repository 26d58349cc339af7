"""What a notebook shows for a stack: its layers in a table, and its colour. Internal."""

from __future__ import annotations

import warnings

import numpy as np

from iridesce._notebook import rows_html, swatch
from iridesce.color.films import stack_color
from iridesce.color.screen import chromatic, screen
from iridesce.optics.layer import Layer
from iridesce.optics.medium import Medium, index_in_words
from iridesce.optics.multilayer import Multilayer

_MOST_ROWS = 60
_MOST_COLORS = 64
_SHOWN_NM = 550.0


def stack_html(stack: Multilayer) -> str:
    """The layers in the order light meets them, and the colour in daylight at normal incidence."""
    rows = [_row("first", stack.first, "")]
    for number, layer in enumerate(stack.layers, start=1):
        values = np.asarray(layer.thickness_nm)
        nm = f"{values.min():g} to {values.max():g}, {values.shape}" if values.size > 1 else f"{values.item():g}"
        rows.append(_row(str(number), layer.medium, nm if layer.coherent else f"{nm}, incoherent"))
    rows.append(_row("last", stack.last, ""))
    return rows_html(("", "medium", "nm", f"n at {_SHOWN_NM:g} nm"), rows, _MOST_ROWS) + _swatches(stack)


def _row(number: str, medium: Medium, thickness: str) -> tuple[str, str, str, str]:
    return number, medium.name, thickness, index_in_words(medium, _SHOWN_NM)


def _swatches(stack: Multilayer) -> str:
    """The colour as it is and as bright as the screen can; along an array of thicknesses, a ramp."""
    thicknesses = [np.asarray(layer.thickness_nm) for layer in stack.layers]
    many = [values.size for values in thicknesses if values.size > 1]
    if len(many) > 1:  # a grid of stacks has no order in which to show it
        return ""
    picked = [
        values.reshape(-1)[np.linspace(0, values.size - 1, min(values.size, _MOST_COLORS)).astype(int)]
        for values in thicknesses
    ]
    layers = [Layer(old.medium, nm, old.coherent) for old, nm in zip(stack.layers, picked, strict=True)]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            xyz = np.atleast_2d(stack_color(Multilayer([stack.first, *layers, stack.last])))
    except ValueError:  # no data in the visible: no colour to show
        return ""
    return f"{swatch(screen(xyz, 1.0))} {swatch(chromatic(xyz))} D65, 0\u00b0: as it is, brightened"
