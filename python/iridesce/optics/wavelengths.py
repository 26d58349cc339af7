"""The ranges of wavelengths that the package itself takes, and even steps over them. Internal."""

from __future__ import annotations

import numpy as np

from iridesce import _core
from iridesce.arguments.operands import Floats

VISIBLE_NM: tuple[float, float] = _core.VISIBLE_NM
"""What colour sums and renders run over: where the CIE tabulates its observers (ISO/CIE 11664-1), vacuum nm."""

SPECTRUM_NM = (380.0, 780.0)
"""A spectrum where nobody names a range, nm: beyond, the eye sees less than 1e-4 of its best (CIE 1931)."""


def in_steps(range_nm: tuple[float, float], step_nm: float) -> Floats:
    """Wavelengths from the first of a range to its last, both of them where the step divides it."""
    first, last = range_nm
    return np.arange(first, last + 0.5 * step_nm, step_nm)
