"""Twin of the film of Cycles (Blender 5.0): Principled BSDF and Metallic BSDF with its physical conductor.

Exact Fresnel for s and p, orders up to three, the observer's functions as Fourier tables, equal energy scaled to the
working white; a conductor has one n and k for each of R, G, B. Checked against Blender 5.0.1, November 2026.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.exchange.twins.fresnel import amplitudes
from iridesce.exchange.twins.sensitivity import smoothstep
from iridesce.optics.wavelengths import SPECTRUM_NM, in_steps

VERSION = "Cycles of Blender 5.0.1, November 2026"

ORDERS = 3
TABLE_END_NM = 60000.0 / (2.0 * np.pi)
"""The path at which its table of sensitivities ends, nm."""


def rgb(thickness_nm: ArrayLike, cos_theta: ArrayLike, film_ior: float, base_ior: ArrayLike) -> Floats:
    """Reflectance in linear Rec.709 that the target shows: thicknesses and cosines broadcast, + an axis of 3.

    base_ior   real: a dielectric; complex (a number or three, for R, G, B): a conductor
    """
    t, cos1 = (np.asarray(x, dtype=np.float64) for x in np.broadcast_arrays(thickness_nm, cos_theta))
    film = (1.0 + (film_ior - 1.0) * smoothstep(0.0, 1.0, t))[..., None]
    base = np.broadcast_to(np.asarray(base_ior, dtype=np.complex128), (3,))
    cosine = cos1[..., None]
    squared = 1.0 - (1.0 - cosine**2) / film**2
    cos2 = np.sqrt(np.maximum(squared, 0.0))
    total_reflection = squared < 0.0
    path = 2.0 * film * t[..., None] * cos2
    result = np.zeros((*t.shape, 3))
    for first, second in zip(amplitudes(1.0, film, cosine), amplitudes(film, base, cos2), strict=True):
        r12, r23 = np.abs(first) ** 2, np.abs(second) ** 2
        if np.isrealobj(base_ior) or not np.any(base.imag):
            total_reflection = total_reflection | (r23 > 1.0 - 1e-6)
        # The inner face sees the upper one from below: a change of sign.
        phase = np.exp(1j * (np.angle(second) + np.angle(-first)))
        product = np.minimum(r12 * r23, 1.0 - 1e-9)
        inner = (1.0 - r12) ** 2 * r23 / (1.0 - product)
        part = r12 + inner
        weight = inner - (1.0 - r12)
        for order in range(1, ORDERS + 1):
            weight = weight * np.sqrt(product)
            wave = _sensitivity(order * path[..., 0])
            part = part + weight * 2.0 * (phase**order * wave).real
        result = result + 0.5 * part
    return np.where(total_reflection, 1.0, np.clip(result, 0.0, 1.0))


def _sensitivity(path_nm: Floats) -> Floats:
    """sum of w(lambda) exp(2 pi i path / lambda) for the w of R, G, B, each of sum 1."""
    wavelength, weights = _weights()
    flat = np.minimum(np.asarray(path_nm).reshape(-1), TABLE_END_NM)
    waves = np.exp(2j * np.pi * flat[:, None] / wavelength)
    return np.asarray(waves @ weights).reshape(*np.shape(path_nm), 3)


@cache
def _weights() -> tuple[Floats, Floats]:
    wavelength = in_steps(SPECTRUM_NM, 1.0)
    response = color.color_matching(wavelength) @ color.rgb_matrix("linear-srgb").T
    return wavelength, response / response.sum(axis=0)
