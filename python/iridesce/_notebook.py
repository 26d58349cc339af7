"""What notebooks show, from plain values: tables of facts, rows and colours. Internal.

Tables inherit the notebook's own colours. Nothing here raises: what cannot be shown is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
import numpy.typing as npt

_CELL = "text-align:left;padding:1px 12px 1px 0"
_SWATCH = (
    "display:inline-block;width:{width}px;height:22px;border-radius:4px;border:1px solid #8886;vertical-align:middle"
)


def facts_html(title: str, facts: Sequence[tuple[str, str]]) -> str:
    """A title over a table of label and value; facts without a value are left out."""
    body = "".join(
        f'<tr><th style="{_CELL}">{escape(label)}</th><td style="{_CELL}">{escape(value)}</td></tr>'
        for label, value in facts
        if value
    )
    return f"<strong>{escape(title)}</strong><table><tbody>{body}</tbody></table>"


def rows_html(head: Sequence[str], rows: Sequence[Sequence[str]], most: int) -> str:
    """A table; of more rows than ``most`` those before the last are left out, and counted."""
    lines = ["<tr>" + "".join(f'<td style="{_CELL}">{escape(cell)}</td>' for cell in row) + "</tr>" for row in rows]
    if len(lines) > most:
        left_out = len(lines) - most
        lines[most - 1 : -1] = [f'<tr><td></td><td style="{_CELL}">\u2026 {left_out} more</td></tr>']
    titles = "".join(f'<th style="{_CELL}">{title}</th>' for title in head)
    return f"<table><thead><tr>{titles}</tr></thead><tbody>{''.join(lines)}</tbody></table>"


def swatch(rgb: npt.NDArray[np.float64]) -> str:
    """Encoded sRGB colours side by side: one, two that meet at an edge, or a ramp."""
    colors = ["#" + "".join(f"{round(255.0 * value):02x}" for value in one) for one in np.atleast_2d(rgb)]
    ground = colors[0] if len(colors) == 1 else f"linear-gradient(to right,{','.join(colors)})"
    if len(colors) == 2:  # two colours to compare meet at an edge
        ground = f"linear-gradient(to right,{colors[0]} 50%,{colors[1]} 50%)"
    style = _SWATCH.format(width=44 if len(colors) == 1 else 88 if len(colors) == 2 else 220)
    return f'<span style="{style};background:{ground}"></span>'
