"""Twin of glTF's KHR_materials_iridescence as the Khronos sample viewer and Babylon.js 9 ship it (November 2026).

three.js 0.187 has the same formula with another fifth power, exp2((-5.55473 x - 6.98316) x) of the cosine x for
(1 - x)^5 (Lagarde 2012, "Spherical Gaussian approximation for Blinn-Phong, Phong and Fresnel"): `fifth_power_of_three`.

Schlick at both faces, phases 0 or pi, two orders, no polarisation, no k. Source: KHR_materials_iridescence, and
Belcour & Barla 2017 (see `sensitivity`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.exchange.twins.sensitivity import sensitivity, smoothstep

FifthPower = Callable[[Floats], Floats]

VERSION = "KHR_materials_iridescence, the sample viewer and Babylon.js 9.35, November 2026"

# Below this the film fades out, nm.
_FADE_NM = 0.03


def rgb(
    thickness_nm: ArrayLike,
    cos_theta: ArrayLike,
    film_ior: float,
    f0: ArrayLike,
    outside_ior: float = 1.0,
    fifth: FifthPower | None = None,
) -> Floats:
    """Reflectance in linear Rec.709 that the target shows: thicknesses and cosines broadcast, + an axis of 3.

    film_ior   iridescenceIor
    f0         reflectance of the base at normal incidence, linear Rec.709 (a number, or three)
    fifth      what stands for (1 - cos)^5 in Schlick's formula; ``None``: itself
    """
    t, cos1 = (np.asarray(x, dtype=np.float64) for x in np.broadcast_arrays(thickness_nm, cos_theta))
    film = outside_ior + (film_ior - outside_ior) * smoothstep(0.0, _FADE_NM, t)
    squared = 1.0 - (outside_ior / film) ** 2 * (1.0 - cos1**2)
    cos2 = np.sqrt(np.maximum(squared, 0.0))
    first = schlick(normal_reflectance(film, outside_ior), cos1, fifth)
    passed = 1.0 - first
    phase_first = np.where(film < outside_ior, 0.0, np.pi)
    # F0 of 1 has no index; its square root is what the shader clamps.
    root = np.sqrt(np.clip(np.broadcast_to(np.asarray(f0, dtype=np.float64), (3,)), 0.0, 0.9999))
    base = (1.0 + root) / (1.0 - root)
    second = schlick(normal_reflectance(base, film[..., None]), cos2[..., None], fifth)
    phase = phase_first[..., None] + np.where(base < film[..., None], np.pi, 0.0)
    path = 2.0 * film * t * cos2
    both = np.clip(first[..., None] * second, 1e-5, 0.9999)
    amplitude = np.sqrt(both)
    inner = passed[..., None] ** 2 * second / (1.0 - both)
    total = first[..., None] + inner
    weight = inner - passed[..., None]
    to_rgb = color.rgb_matrix("linear-srgb")
    for order in (1, 2):
        weight = weight * amplitude
        total = total + weight * 2.0 * (sensitivity(order * path, order * phase) @ to_rgb.T)
    return np.where(squared[..., None] < 0.0, 1.0, np.maximum(total, 0.0))


def schlick(f0: Floats, cosine: Floats, fifth: FifthPower | None = None) -> Floats:
    """Schlick's reflectance (Computer Graphics Forum 13(3), 1994)."""
    rise = (1.0 - cosine) ** 5 if fifth is None else fifth(cosine)
    return np.asarray(f0 + (1.0 - f0) * rise)


def fifth_power_of_three(cosine: Floats) -> Floats:
    """What three.js takes for (1 - cos)^5."""
    return np.exp2((-5.55473 * cosine - 6.98316) * cosine)


def normal_reflectance(a: ArrayLike, b: ArrayLike) -> Floats:
    """((a - b)/(a + b))^2."""
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    return np.asarray(((a - b) / (a + b)) ** 2)
