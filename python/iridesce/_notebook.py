"""What notebooks show for stacks, media, lights and thickness maps. Internal.

Tables inherit the notebook's own colours. Nothing here raises: what cannot be shown is left out.
"""

from __future__ import annotations

import warnings
from html import escape
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from iridesce.arguments.operands import Floats
    from iridesce.color import Illuminant
    from iridesce.optics.medium import Medium
    from iridesce.stack import Stack

_MOST_ROWS = 60
_MOST_COLORS = 64
_SHOWN_NM = 550.0
_CELL = "text-align:left;padding:1px 12px 1px 0"
_SWATCH = (
    "display:inline-block;width:{width}px;height:22px;border-radius:4px;border:1px solid #8886;vertical-align:middle"
)


def stack_html(stack: Stack) -> str:
    """The layers in the order light meets them, and the colour in daylight at normal incidence."""
    rows = [_row("first", stack.first, "")]
    for number, layer in enumerate(stack.layers, start=1):
        values = np.asarray(layer.thickness_nm)
        nm = f"{values.min():g} to {values.max():g}, {values.shape}" if values.size > 1 else f"{values.item():g}"
        rows.append(_row(str(number), layer.medium, nm if layer.coherent else f"{nm}, incoherent"))
    rows.append(_row("last", stack.last, ""))
    if len(rows) > _MOST_ROWS:
        left_out = len(rows) - _MOST_ROWS
        rows[_MOST_ROWS - 1 : -1] = [f'<tr><td></td><td style="{_CELL}">\u2026 {left_out} more</td></tr>']
    head = "".join(f'<th style="{_CELL}">{title}</th>' for title in ("", "medium", "nm", f"n at {_SHOWN_NM:g} nm"))
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>{_stack_swatches(stack)}"


def medium_html(medium: Medium) -> str:
    """Name, source, range, and the index at three wavelengths."""
    span = medium.range_nm
    facts = [
        ("data", "any wavelength" if span is None else f"{span[0]:g} to {span[1]:g} nm"),
        ("source", medium.source),
        ("extended", medium.extension or ""),
        ("note", medium.note),
    ]
    facts += [(f"n at {nm:g} nm", _index(medium, nm)) for nm in (450.0, 550.0, 650.0)]
    body = "".join(
        f'<tr><th style="{_CELL}">{escape(label)}</th><td style="{_CELL}">{escape(value)}</td></tr>'
        for label, value in facts
        if value
    )
    return f"<strong>{escape(medium.name)}</strong><table><tbody>{body}</tbody></table>"


def illuminant_html(light: Illuminant) -> str:
    """The light's colour beside that of D65, its name and chromaticity."""
    from iridesce import color
    from iridesce.plot._colors import chromatic

    x, y = light.xy
    both = chromatic(np.stack([light.white(), color.illuminant("D65").white()]))
    return f"{_swatch(both)} <strong>{escape(light.name)}</strong> x = {x:.4f}, y = {y:.4f} (right: D65)"


def map_png(thickness_nm: Floats) -> bytes:
    """A map in false colours from its least value (dark) to its greatest, small ones enlarged."""
    import matplotlib

    from iridesce import _core

    step = max(1, -(-max(thickness_nm.shape) // 1024))
    values = thickness_nm[::step, ::step]
    low, high = float(values.min()), float(values.max())
    share = (values - low) / (high - low) if high > low else np.zeros_like(values)
    rgb = matplotlib.colormaps["viridis"](share)[..., :3].astype(np.float32)
    times = max(1, 192 // max(values.shape))
    return bytes(_core.png_bytes(np.ascontiguousarray(rgb.repeat(times, axis=0).repeat(times, axis=1)), "srgb"))


def _row(number: str, medium: Medium, thickness: str) -> str:
    cells = (number, medium.name, thickness, _index(medium, _SHOWN_NM))
    return "<tr>" + "".join(f'<td style="{_CELL}">{escape(cell)}</td>' for cell in cells) + "</tr>"


def _index(medium: Medium, wavelength_nm: float) -> str:
    try:
        index = complex(medium.index(wavelength_nm))
    except ValueError:  # no data there
        return ""
    return f"{index.real:.4g}" if index.imag == 0.0 else f"{index.real:.4g} {index.imag:+.3g}i"


def _stack_swatches(stack: Stack) -> str:
    """The colour as it is and as bright as the screen can; along an array of thicknesses, a ramp."""
    from iridesce.plot._colors import chromatic, screen
    from iridesce.stack import Layer, Stack

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
            xyz = np.atleast_2d(Stack([stack.first, *layers, stack.last]).color())
    except ValueError:  # no data in the visible: no colour to show
        return ""
    return f"{_swatch(screen(xyz, 1.0))} {_swatch(chromatic(xyz))} D65, 0\u00b0: as it is, brightened"


def _swatch(rgb: Floats) -> str:
    colors = ["#" + "".join(f"{round(255.0 * value):02x}" for value in one) for one in np.atleast_2d(rgb)]
    ground = colors[0] if len(colors) == 1 else f"linear-gradient(to right,{','.join(colors)})"
    if len(colors) == 2:  # two colours to compare meet at an edge
        ground = f"linear-gradient(to right,{colors[0]} 50%,{colors[1]} 50%)"
    style = _SWATCH.format(width=44 if len(colors) == 1 else 88 if len(colors) == 2 else 220)
    return f'<span style="{style};background:{ground}"></span>'
