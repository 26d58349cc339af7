"""Tristimulus sums, colour spaces, differences, gamuts."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import _core
from iridesce.arguments.operands import Floats, Operand, broadcast_shape, place, reals, scalar
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import optional_text, text
from iridesce.color.light import Illuminant, as_illuminant

SPACES = (
    *("xyz", "xyy", "lab", "lch", "oklab", "srgb", "display-p3", "rec2020"),
    *("linear-srgb", "acescg", "ntsc1953"),
)

# Chromaticities by which colour-space standards define these whites; the tables of the illuminants round differently.
_WHITES = {
    "D65": (0.3127, 0.3290),
    "C": (0.31006, 0.31616),
    "D50": (0.34567, 0.35850),
    "ACES": (0.32168, 0.33767),
}


def spectrum_to_xyz(
    wavelength_nm: ArrayLike,
    values: ArrayLike,
    illuminant: str | os.PathLike[str] | Illuminant = "D65",
    observer: str = "cie1931",
) -> Floats:
    """Tristimulus values of reflectances (or other power ratios) under a light.

    XYZ = k (sum step S value cmf + sum over lines P value cmf), with k such that value = 1 gives Y = 1: a plain sum
    over the wavelengths given, tables interpolated linearly there. At lines the value is interpolated linearly.

    wavelength_nm   a uniform ascending grid of vacuum wavelengths, > 0           (n,), n >= 2
    values          the spectrum on that grid                                     (..., n)
    illuminant      name, path or Illuminant
    observer        "cie1931" | "cie1964"
    Returns         float64                                                       (..., 3)
    Raises          ValueError: grid not uniform or not ascending, shapes, a line outside the grid, no light on the grid
    Source          CIE 15:2004

    >>> import numpy as np
    >>> import iridesce as ir
    >>> nm = np.arange(360.0, 831.0)
    >>> ir.color.spectrum_to_xyz(nm, np.full(471, 0.5), "E").round(4).tolist()
    [0.5, 0.5, 0.5002]
    """
    nm = reals("wavelength_nm", wavelength_nm)
    if nm.ndim != 1:
        raise refusal("wavelength_nm", "one axis", Words(f"shape {nm.shape}"), must="have")
    spectra = reals("values", values)
    if spectra.ndim < 1 or spectra.shape[-1] != nm.size:
        raise complaint(
            f"the last axis of values must match wavelength_nm: shapes {spectra.shape} and {nm.shape}",
            "values",
            f"values with {nm.size} entries along the last axis",
            Words(f"shape {spectra.shape}"),
        )
    light = as_illuminant(illuminant)
    flat = np.ascontiguousarray(spectra.reshape(-1, nm.size))
    rows = _core.spectrum_to_xyz(np.ascontiguousarray(nm), flat, light._core, text("observer", observer))
    return np.asarray(rows).reshape(*spectra.shape[:-1], 3)


def convert(
    values: ArrayLike,
    from_space: str,
    to_space: str,
    white: str | ArrayLike | Illuminant = "D65",
    adaptation: str | None = None,
) -> Floats:
    """Colours of one space in another.

    XYZ, xyY, Lab and LCh are under the light ``white``; Lab and LCh are relative to it. RGB spaces and Oklab have
    whites of their own: without adaptation XYZ passes as it is; with ``"bradford"`` the one white becomes the other.
    Encoded spaces extend oddly: a negative value takes the curve of its absolute value. xyY of black has the
    chromaticity of ``white``.

    values       colours, finite                                             (..., 3)
    from_space   xyz xyy lab lch oklab srgb display-p3 rec2020 linear-srgb acescg ntsc1953
    to_space     the same
    white        "D65" "C" "D50" "ACES": the chromaticities of the standards; any other name of
                 :func:`illuminant`, or an Illuminant: its own white (CIE 1931, 1 nm); an array: (x, y) or (X, Y, Z)
    adaptation   None | "bradford" (linear Bradford)
    Returns      float64                                                     (..., 3)
    Raises       ValueError: unknown space, not finite, or a colour that has no XYZ (xyY with y = 0)
    Source       IEC 61966-2-1, SMPTE EG 432-1, ITU-R BT.2020, S-2014-004 (AP1), FCC 1953; CIE 15:2004 (Lab);
                 B. Ottosson, "A perceptual color space for image processing", 2020 (Oklab)

    >>> import iridesce as ir
    >>> ir.color.convert([0.5, 0.5, 0.5], "srgb", "lab").round(3).tolist()
    [53.389, 0.0, 0.0]
    """
    colors = _colors("values", values)
    rows = _core.convert_color(
        _rows(colors),
        text("from_space", from_space),
        text("to_space", to_space),
        _white(white),
        optional_text("adaptation", adaptation),
    )
    return _checked(np.asarray(rows).reshape(colors.shape), colors, f"has no finite colour in {to_space!r}")


def rgb_matrix(space: str) -> Floats:
    """The matrix from XYZ to the linear RGB of a space, derived from its primaries and white.

    space      srgb display-p3 rec2020 linear-srgb acescg ntsc1953
    Returns    float64 (3, 3)
    Raises     ValueError for a space without primaries

    >>> import iridesce as ir
    >>> ir.color.rgb_matrix("linear-srgb")[0].round(6).tolist()
    [3.24097, -1.537383, -0.498611]
    """
    matrix = _core.rgb_matrix(text("space", space))
    if matrix is None:
        raise complaint(
            f"space {space!r} has no primaries; RGB spaces: {' '.join(SPACES[5:])}",
            "space",
            f"one of {' '.join(SPACES[5:])}",
            space,
        )
    return np.array(matrix)


def delta_e(lab_a: ArrayLike, lab_b: ArrayLike) -> Any:
    """Colour difference CIEDE2000 of CIELAB colours, with k_L = k_C = k_H = 1.

    lab_a, lab_b   L*, a*, b*, finite           (..., 3), broadcast
    Returns        float64                      broadcast shape without the last axis; a float for two colours
    Raises         ValueError
    Source         CIE 142-2001; Sharma, Wu & Dalal, Color Research & Application 30, 21 (2005)

    >>> import iridesce as ir
    >>> round(ir.color.delta_e([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485]), 4)
    2.0425
    """
    a, b = _colors("lab_a", lab_a), _colors("lab_b", lab_b)
    shape = broadcast_shape([Operand("lab_a", a, a.shape), Operand("lab_b", b, b.shape)])
    a, b = np.broadcast_to(a, shape), np.broadcast_to(b, shape)
    difference = np.asarray(_core.delta_e(_rows(a), _rows(b))).reshape(a.shape[:-1])
    return scalar(_checked(difference, a, "of lab_a has no finite difference from that of lab_b"))


def map_gamut(values: ArrayLike, space: str = "srgb", gamut: str = "hue") -> tuple[Floats, float]:
    """Colours of an RGB space brought into [0, 1], and the share that was outside.

    ``"hue"`` keeps lightness and hue of Oklab and takes away just enough chroma; what is brighter than white becomes
    white. ``"clip"`` clips each linear channel. Colours inside stay as they are, bit for bit. A colour counts as
    outside when a linear channel is below -1e-6 or above 1.0005 (an eighth of an 8-bit step); smaller excursions are
    clipped.

    values     colours of ``space``, encoded where it is, finite        (..., 3)
    space      srgb display-p3 rec2020 linear-srgb acescg ntsc1953
    gamut      "hue" | "clip"
    Returns    (float64 (..., 3), share of the colours outside in [0, 1])
    Raises     ValueError

    >>> import iridesce as ir
    >>> mapped, share = ir.color.map_gamut([[0.2, 0.5, 0.3], [-0.1, 0.6, 0.2]], "linear-srgb")
    >>> mapped.round(4).tolist(), share
    ([[0.2, 0.5, 0.3], [0.0, 0.5543, 0.2374]], 0.5)
    """
    colors = _colors("values", values)
    rows, outside = _core.map_gamut(_rows(colors), text("space", space), text("gamut", gamut))
    return np.asarray(rows).reshape(colors.shape), 3 * outside / colors.size


def _colors(argument: str, values: ArrayLike) -> Floats:
    array = reals(argument, values)
    if array.ndim < 1 or array.shape[-1] != 3:
        raise refusal(argument, "a last axis of 3", Words(f"shape {array.shape}"), must="have")
    return array


def _rows(colors: Floats) -> Floats:
    return np.ascontiguousarray(colors.reshape(-1, 3))


def _checked(result: Floats, given: Floats, problem: str) -> Floats:
    """``result``, or an error that names the first of the ``given`` colours that did not give a finite one."""
    bad = np.argwhere(~np.isfinite(result))
    if bad.size:
        row = tuple(bad[0][: given.ndim - 1])
        colour = given[row].tolist()
        words = f"the colour {colour}{place(row)} {problem}"
        raise complaint(words, "values", "colours with a finite answer", colour, place(row))
    return result


def _white(white: str | ArrayLike | Illuminant) -> list[float]:
    """XYZ with Y = 1."""
    if isinstance(white, str) and white.strip().upper() in _WHITES:
        x, y = _WHITES[white.strip().upper()]
        return [x / y, 1.0, (1.0 - x - y) / y]
    if isinstance(white, (str, os.PathLike, Illuminant)):
        return [float(v) for v in as_illuminant(white).white()]
    array = reals("white", white)
    if array.shape == (2,) and array.min() > 0.0 and array.sum() < 1.0:
        x, y = (float(v) for v in array)
        return [x / y, 1.0, (1.0 - x - y) / y]
    if array.shape == (3,) and array.min() > 0.0:
        return [float(v / array[1]) for v in array]
    raise refusal("white", "a name, an Illuminant, (x, y) or (X, Y, Z), all > 0", white)
