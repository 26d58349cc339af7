"""Twin of MaterialX 1.39.5's film (`mx_fresnel_airy` of its GLSL), which OpenPBR and Standard Surface use there.

Exact Fresnel for s and p at the upper face; below it exact Fresnel (dielectric, conductor) or Schlick of F0; three orders;
three Gaussian lobes; a matrix that leads to CIE RGB, read as Rec.709. Checked against 1.39.5, November 2026.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from iridesce.arguments.operands import Floats
from iridesce.exchange.twins.fresnel import Complexes, amplitudes
from iridesce.exchange.twins.sensitivity import sensitivity

VERSION = "MaterialX 1.39.5, November 2026"

# XYZ to CIE 1931 RGB of white E; read as Rec.709 by what follows.
_TO_RGB = np.array(
    [[2.3706743, -0.9000405, -0.4706338], [-0.5138850, 1.4253036, 0.0885814], [0.0052982, -0.0146949, 1.0093968]]
)
_LEAST_F0, _MOST_F0 = 0.01, 0.99


def rgb(
    thickness_nm: ArrayLike,
    cos_theta: ArrayLike,
    film_ior: float,
    base_ior: ArrayLike | None = None,
    f0: ArrayLike | None = None,
) -> Floats:
    """Reflectance in linear Rec.709 that the target shows: thicknesses and cosines broadcast, + an axis of 3.

    base_ior   of a dielectric (a number) or a conductor (complex n + ik, a number or three)
    f0         instead: reflectance of a Schlick base, linear Rec.709
    """
    t, cos1 = (np.asarray(x, dtype=np.float64) for x in np.broadcast_arrays(thickness_nm, cos_theta))
    film = max(float(film_ior), 1.0)
    cos2 = np.sqrt(np.maximum(1.0 - (1.0 - cos1**2) / film**2, 0.0))
    upper = [np.abs(r) ** 2 for r in amplitudes(1.0, film, cos1)]
    cos_brewster = np.cos(np.arctan(film))
    phases_upper = (np.full_like(cos1, np.pi), np.where(cos1 < cos_brewster, 0.0, np.pi))
    if f0 is not None:
        reflectance = np.broadcast_to(np.asarray(f0, dtype=np.float64), (3,))
        root = np.sqrt(np.clip(reflectance, _LEAST_F0, _MOST_F0))
        # Half for each polarisation, as it stands there.
        half = 0.5 * (reflectance + (1.0 - reflectance) * (1.0 - cos2[..., None]) ** 5)
        phase = np.where((1.0 + root) / (1.0 - root) < film, np.pi, 0.0)
        lower, phases_lower = (half, half), (phase, phase)
    else:
        base = np.broadcast_to(np.asarray(base_ior, dtype=np.complex128), (3,))
        r_s, r_p = amplitudes(film, base, cos2[..., None])
        lower = (np.abs(r_s) ** 2, np.abs(r_p) ** 2)
        # Phases counted from a reflection without a change of sign at a lossless denser base.
        phases_lower = _conductor_phase(film, base, cos2)
    total = np.zeros((*t.shape, 3))
    path = 2.0 * film * cos2 * t
    for r12, phi21, r23, phi23 in zip(upper, phases_upper, lower, phases_lower, strict=True):
        passed = (1.0 - r12)[..., None]
        product = r12[..., None] * r23
        inner = passed**2 * r23 / (1.0 - product)
        part = r12[..., None] + inner
        weight = inner - passed
        for order in (1, 2):
            weight = weight * np.sqrt(product)
            part = part + weight * 2.0 * sensitivity(order * path, order * (phi23 + phi21[..., None]))
        total = total + 0.5 * part
    return np.asarray(np.clip(total @ _TO_RGB.T, 0.0, 1.0))


def _conductor_phase(film: float, base: Complexes, cos2: Floats) -> tuple[Floats, Floats]:
    """(s, p) phases on reflection at the lower face; Gulbrandsen's form as the target writes it."""
    n, k = base.real, base.imag / base.real
    cosine = cos2[..., None]
    a = n**2 * (1.0 - k**2) - film**2 * (1.0 - cosine**2)
    b = np.sqrt(a**2 + (2.0 * n**2 * k) ** 2)
    u, v = np.sqrt((a + b) / 2.0), np.sqrt(np.maximum((b - a) / 2.0, 0.0))
    s = np.arctan2(2.0 * film * v * cosine, u**2 + v**2 - (film * cosine) ** 2)
    p = np.arctan2(
        2.0 * film * n**2 * cosine * (2.0 * k * u - (1.0 - k**2) * v) + 0.0,
        (n**2 * (1.0 + k**2) * cosine) ** 2 - film**2 * (u**2 + v**2),
    )
    return s, p
