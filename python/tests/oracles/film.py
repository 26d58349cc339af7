"""Complex field amplitudes of one free film in a medium of index 1, the textbook way (sum of all inner passes)."""

from __future__ import annotations

from typing import Any, NamedTuple

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


class Powers(NamedTuple):
    """Reflectance and transmittance, each (2, rays, n), of s and p for films of which only the thickness is open.

    What hangs on index, angle and wavelength alone is kept, since light that goes round in a sphere asks again and again.
    """

    face: NDArray[Any]  # (2, rays, n): the outer face's r for complex films, 4 r^2 / (1 - r^2)^2 for real ones
    turn: NDArray[Any]  # (rays, n): the phase of one crossing per nm of thickness

    def of(self, rays: NDArray[Any]) -> Powers:
        """The same for some of the rays."""
        return Powers(self.face[:, rays], self.turn[rays])

    def at(self, thickness_nm: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """R and T of films so thick, (rays,)."""
        if not np.iscomplexobj(self.face):
            wave = self.face * np.sin(self.turn * thickness_nm[:, None]) ** 2
            reflectance = wave / (1.0 + wave)
            return reflectance, 1.0 - reflectance
        round_trip = np.exp(2j * self.turn * thickness_nm[:, None])
        square = self.face**2
        below = _power(1.0 - square * round_trip)
        reflectance = _power(self.face) * _power(1.0 - round_trip) / below
        return reflectance, _power(1.0 - square) * np.abs(round_trip) / below  # |e^(2i x)| = |e^(i x)|^2


def _power(amplitude: NDArray[np.complex128]) -> NDArray[np.float64]:
    return amplitude.real**2 + amplitude.imag**2


def film_powers(index: ArrayLike, cos_theta: NDArray[np.float64], wavelength_nm: NDArray[np.float64]) -> Powers:
    """R and T of films by their thickness, for cosines (rays,) and wavelengths (n,); a complex ``index`` absorbs.

    Of a real one without complex numbers: R = F sin^2(d / 2) / (1 + F sin^2(d / 2)), F = 4 r12^2 / (1 - r12^2)^2.
    """
    n, outer = np.asarray(index), cos_theta[:, None]
    inner = np.sqrt(1.0 - (1.0 - outer**2) / n**2)
    faces = (outer - n * inner) / (outer + n * inner), (n * outer - inner) / (n * outer + inner)
    face = np.stack(np.broadcast_arrays(*faces))
    turn = 2.0 * np.pi * n * inner / wavelength_nm
    return Powers(face if np.iscomplexobj(n) else 4.0 * face**2 / (1.0 - face**2) ** 2, turn)
