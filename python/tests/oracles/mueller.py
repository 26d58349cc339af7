"""Mueller matrices of film plates with every frame written out: the second, quite different road to polarised results.

Stokes vectors (I, Q, U, V) are taken in the frame (s, p) of a plane of incidence, Q = |E_s|^2 - |E_p|^2,
U = 2 Re(E_s conj(E_p)), V = 2 Im(E_s conj(E_p)); turning the frame by phi about the ray turns (Q, U) by 2 phi.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def diattenuating_retarder(a_s: NDArray[Any], a_p: NDArray[Any]) -> NDArray[np.float64]:
    """(471, 4, 4) Mueller matrix of amplitudes a_s, a_p in the frame of their own plane of incidence."""
    sum_, difference = (np.abs(a_s) ** 2 + np.abs(a_p) ** 2) / 2.0, (np.abs(a_s) ** 2 - np.abs(a_p) ** 2) / 2.0
    cross = a_s * np.conj(a_p)
    m = np.zeros((len(a_s), 4, 4))
    m[:, 0, 0] = m[:, 1, 1] = sum_
    m[:, 0, 1] = m[:, 1, 0] = difference
    m[:, 2, 2] = m[:, 3, 3] = cross.real
    m[:, 2, 3] = -cross.imag
    m[:, 3, 2] = cross.imag
    return m


def frame_turn(angle: float) -> NDArray[np.float64]:
    """4 x 4: Stokes vector of the same light in axes turned by ``angle`` radians."""
    c, s = np.cos(2.0 * angle), np.sin(2.0 * angle)
    return np.array([[1, 0, 0, 0], [0, c, s, 0], [0, -s, c, 0], [0, 0, 0, 1.0]])
