"""What the film models of glTF and MaterialX share: three Gaussian lobes for the observer's eye, in closed form.

Source: L. Belcour and P. Barla, "A practical extension to microfacet theory for the modeling of varying iridescence",
ACM Trans. Graph. 36(4), 2017, doi 10.1145/3072959.3073620; KHR_materials_iridescence.
"""

from __future__ import annotations

import numpy as np

from iridesce.arguments.operands import Floats

# Height, place (1/m) and width (1/m^2) of the lobes of X, Y, Z, and of the second lobe of X.
_HEIGHT = np.array([5.4856e-13, 4.4201e-13, 5.2481e-13])
_PLACE = np.array([1.6810e6, 1.7953e6, 2.2084e6])
_WIDTH = np.array([4.3278e9, 9.3046e9, 6.6121e9])
_SECOND = (9.7470e-14, 2.2399e6, 4.5282e9)
_NORM = 1.0685e-7


def sensitivity(path_nm: Floats, shift: Floats) -> Floats:
    """XYZ of cos(2 pi path / lambda + shift) under equal energy; ``path_nm`` (...,), ``shift`` (..., 3)."""
    q = 2.0 * np.pi * 1e-9 * np.asarray(path_nm)[..., None]
    xyz = _HEIGHT * np.sqrt(2.0 * np.pi * _WIDTH) * np.cos(_PLACE * q + shift) * np.exp(-_WIDTH * q**2)
    height, place, width = _SECOND
    lobe = (
        height
        * np.sqrt(2.0 * np.pi * width)
        * np.cos(place * q[..., 0] + shift[..., 0])
        * np.exp(-width * q[..., 0] ** 2)
    )
    xyz[..., 0] += lobe
    return np.asarray(xyz / _NORM)


def smoothstep(low: float, high: float, x: Floats) -> Floats:
    """0 below, 1 above, 3 s^2 - 2 s^3 between."""
    s = np.clip((np.asarray(x) - low) / (high - low), 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s))
