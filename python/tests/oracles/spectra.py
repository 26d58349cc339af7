"""Observer, light and indices on the grid of every oracle: 360..830 nm in 1 nm steps."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

WAVELENGTH_NM = np.arange(360.0, 831.0)  # (471,)

# Daimon & Masumura, Appl. Opt. 46, 3811 (2007), water at 20 C: n^2 - 1 = sum B L^2 / (L^2 - C), L in micrometres.
WATER_B = (0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688)
WATER_C = (0.005101829712, 0.01821153936, 0.02620722293, 10.69792721)

# Rec.709 primaries and white D65 (ITU-R BT.709).
REC709_PRIMARIES = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
REC709_WHITE = (0.3127, 0.3290)


def water_index(wavelength_nm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Real index of water at 20 C."""
    square = (np.asarray(wavelength_nm, dtype=float) * 1e-3) ** 2
    return np.sqrt(1.0 + sum(b * square / (square - c) for b, c in zip(WATER_B, WATER_C, strict=True)))


class Light(NamedTuple):
    """A lamp and the observer: ``values @ weights`` is the XYZ of the lamp's light times ``values`` (..., n)."""

    wavelength_nm: NDArray[np.float64]  # (n,)
    weights: NDArray[np.float64]  # (n, 3); the middle column sums to 1


@cache
def _observer() -> NDArray[np.float64]:
    """(471, 3) CIE 1931 2 degree observer."""
    import colour

    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    assert np.array_equal(observer.wavelengths, WAVELENGTH_NM)
    return np.asarray(observer.values, dtype=float)


@cache
def lamp(name: str = "D65") -> Light:
    """A CIE illuminant on the 1 nm grid: its 5 nm table, linear between.

    The tables of `colour-science` end at 780 nm; the last value is held, which moves Y by less than 2e-6.
    """
    import colour

    table = colour.SDS_ILLUMINANTS[name]
    weights = _observer() * np.interp(WAVELENGTH_NM, table.wavelengths, table.values)[:, None]
    return Light(WAVELENGTH_NM, weights / weights[:, 1].sum())


def line_lamp(*lines: tuple[float, float]) -> Light:
    """Lines of no width: (vacuum wavelength in nm, relative power) each."""
    nm, power = np.array(lines, dtype=float).T
    weights = np.stack([np.interp(nm, WAVELENGTH_NM, column) for column in _observer().T], axis=-1) * power[:, None]
    return Light(nm, weights / weights[:, 1].sum())


def xyz_weights() -> NDArray[np.float64]:
    """(471, 3) of D65."""
    return lamp("D65").weights


@cache
def xyz_from_rec709() -> NDArray[np.float64]:
    """3 x 3: linear Rec.709 to XYZ, from the primaries and the white, Y = 1 for (1, 1, 1)."""

    def xyz(xy: tuple[float, float]) -> NDArray[np.float64]:
        return np.array([xy[0] / xy[1], 1.0, (1.0 - xy[0] - xy[1]) / xy[1]])

    primaries = np.stack([xyz(xy) for xy in REC709_PRIMARIES], axis=1)
    return primaries * np.linalg.solve(primaries, xyz(REC709_WHITE))
