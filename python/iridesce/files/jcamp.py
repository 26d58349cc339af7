"""Spectra in JCAMP-DX, the text format of infrared spectrometers, its plain-number forms. Internal.

R. S. McDonald, P. A. Wilks, Applied Spectroscopy 42, 151 (1988): labels "##NAME= value", then XYPOINTS or PEAK TABLE as pairs, or
XYDATA=(X++(Y..Y)) as lines of one x and many y of even steps. Compressed forms (letters in place of digits) are refused.
"""

from __future__ import annotations

import re

import numpy as np

from iridesce.arguments.operands import Floats

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
# One pseudo-digit of the compressed forms: squeezed, difference and duplicate digits.
_PACKED = re.compile(r"[@A-DF-Za-df-z%]")


def is_jcamp(text: str) -> bool:
    """Whether the file says it is one."""
    return bool(re.match(r"\s*##(TITLE|JCAMP-?DX)\s*=", text, flags=re.IGNORECASE))


def read_jcamp(label: str, text: str) -> tuple[Floats, Floats, str, str]:
    """(x, y, unit of x, unit of y) of the first table of a file."""
    facts: dict[str, str] = {}
    form, rows = "", []
    for line in text.splitlines():
        line = line.split("$$")[0].strip()
        match = re.match(r"##\s*([^=]*?)\s*=\s*(.*)", line)
        if match:
            if form:
                break
            name = re.sub(r"[\s\-/_]", "", match[1]).upper()
            if name in ("XYDATA", "XYPOINTS", "PEAKTABLE"):
                form = re.sub(r"\s", "", match[2]).upper()
            else:
                facts.setdefault(name, match[2].strip())
        elif form and line:
            rows.append(line)
    if not rows:
        raise ValueError(f"{label}: this JCAMP-DX file holds no XYDATA or XYPOINTS")
    if any(_PACKED.search(row) for row in rows):
        raise ValueError(
            f"{label}: the numbers of this JCAMP-DX file are compressed; export it as plain numbers or CSV"
        )
    numbers = [[float(word) for word in _NUMBER.findall(row)] for row in rows]
    # Without the label the factors are 1.
    x_factor, y_factor = (_fact(label, facts, name, 1.0) for name in ("XFACTOR", "YFACTOR"))
    if "X++" in form:
        y = np.array([value for row in numbers for value in row[1:]]) * y_factor
        # The x of the first line alone is exact, the others are rounded: even steps from FIRSTX to LASTX.
        first = _fact(label, facts, "FIRSTX", numbers[0][0] * x_factor if numbers[0] else 0.0)
        step = _fact(label, facts, "DELTAX", float("nan"))
        last = _fact(label, facts, "LASTX", first + step * (y.size - 1))
        if _fact(label, facts, "NPOINTS", float(y.size)) != y.size or not np.isfinite(last - first):
            raise ValueError(
                f"{label}: this JCAMP-DX file holds {y.size} points, and NPOINTS, FIRSTX, LASTX say otherwise"
            )
        x = np.linspace(first, last, y.size)
    else:
        flat = [value for row in numbers for value in row]
        if len(flat) % 2:
            raise ValueError(f"{label}: the pairs of this JCAMP-DX file are not complete")
        pairs = np.array(flat).reshape(-1, 2)
        x, y = pairs[:, 0] * x_factor, pairs[:, 1] * y_factor
    if x.size < 2:
        raise ValueError(f"{label}: this JCAMP-DX file holds {x.size} points")
    return x, y, facts.get("XUNITS", ""), facts.get("YUNITS", "")


def _fact(label: str, facts: dict[str, str], name: str, default: float) -> float:
    if name not in facts:
        return default
    try:
        return float(facts[name])
    except ValueError:
        raise ValueError(f"{label}: {name} of this JCAMP-DX file must be a number, got {facts[name]!r}") from None
