"""Fresnel's reflectances and phases as the film models of other programs take them. Angles inside the first medium."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Complexes = NDArray[np.complex128]


def amplitudes(n1: ArrayLike, n2: ArrayLike, cos1: ArrayLike) -> tuple[Complexes, Complexes]:
    """(r_s, r_p) from index n1 to n2 (complex), with r_p = r_s at normal incidence (magnetic field), broadcast."""
    n1, n2 = np.asarray(n1, dtype=np.complex128), np.asarray(n2, dtype=np.complex128)
    cos1 = np.asarray(cos1, dtype=np.complex128)
    cos2 = np.sqrt(1.0 - (n1 / n2) ** 2 * (1.0 - cos1**2))
    cos2 = np.where(cos2.imag * n2.real + cos2.real * n2.imag < 0.0, -cos2, cos2)
    r_s = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2)
    r_p = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2)
    return r_s, -r_p
