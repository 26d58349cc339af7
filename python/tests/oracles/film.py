"""Complex field amplitudes of one free film in a medium of index 1, the textbook way (sum of all inner passes)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Amplitudes(NamedTuple):
    """Electric-field ratios; r_p = -r_s at normal incidence, time factor exp(-i omega t)."""

    r_s: NDArray[np.complex128]
    r_p: NDArray[np.complex128]
    t_s: NDArray[np.complex128]
    t_p: NDArray[np.complex128]


def film_amplitudes(
    index: ArrayLike, thickness_nm: ArrayLike, cos_theta: ArrayLike, wavelength_nm: ArrayLike
) -> Amplitudes:
    """r and t of a film of complex ``index`` between two half spaces of index 1; all arguments broadcast.

    r = r12 (1 - e) / (1 - r12^2 e)
    t = (1 - r12^2) sqrt(e) / (1 - r12^2 e)
    e = exp(4 pi i n d cos(theta_film) / lambda)
    """
    n = np.asarray(index, dtype=complex)
    outer = np.asarray(cos_theta, dtype=float)
    inner = np.sqrt(1.0 - (1.0 - outer**2) / n**2)  # real part > 0 for n + ik, k >= 0, and index 1 outside
    half_turn = np.exp(
        2j * np.pi * n * np.asarray(thickness_nm, dtype=float) * inner / np.asarray(wavelength_nm, dtype=float)
    )
    round_trip = half_turn**2

    def film(face: NDArray[np.complex128]) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        below = 1.0 - face**2 * round_trip
        return face * (1.0 - round_trip) / below, (1.0 - face**2) * half_turn / below

    r_s, t_s = film((outer - n * inner) / (outer + n * inner))
    r_p, t_p = film((n * outer - inner) / (n * outer + inner))
    return Amplitudes(r_s, r_p, t_s, t_p)


def film_powers(
    index: NDArray[np.float64], thickness_nm: ArrayLike, cos_theta: ArrayLike, wavelength_nm: ArrayLike
) -> NDArray[np.float64]:
    """(2, ...) reflectance of s and p for a real ``index``; the transmittance is one minus it.

    R = F sin^2(d / 2) / (1 + F sin^2(d / 2)), F = 4 r12^2 / (1 - r12^2)^2: the same film without complex numbers.
    """
    outer = np.asarray(cos_theta, dtype=float)
    inner = np.sqrt(1.0 - (1.0 - outer**2) / index**2)
    wave = np.sin(2.0 * np.pi * index * thickness_nm * inner / wavelength_nm) ** 2
    r_s = (outer - index * inner) / (outer + index * inner)
    r_p = (index * outer - inner) / (index * outer + inner)
    finesse = np.stack(np.broadcast_arrays(*(4.0 * r**2 / (1.0 - r**2) ** 2 for r in (r_s, r_p))))
    return finesse * wave / (1.0 + finesse * wave)
