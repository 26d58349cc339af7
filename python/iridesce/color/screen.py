"""Colours of films as a screen shows them. Internal."""

from __future__ import annotations

import math

import numpy as np

from iridesce import _core
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import refusal
from iridesce.arguments.scalars import MOST_STOPS

# XYZ of the white of sRGB; only Lab and LCh would ask for it.
_D65 = [0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290]


def gains(xyz: Floats, exposure: float | str) -> Floats:
    """By how much to multiply the XYZ of each row: (rows, n, 3) gives (rows, 1, 1).

    ``"auto"`` brings the largest linear sRGB component of each row to 1, ``"common"`` that of them all.
    """
    shape = (xyz.shape[0], 1, 1)
    if isinstance(exposure, str) and exposure in ("auto", "common"):
        brightest = _convert(xyz, "xyz", "linear-srgb").max(axis=(1, 2) if exposure == "auto" else None)
        return np.broadcast_to(
            np.where(brightest > 0.0, 1.0 / np.where(brightest > 0.0, brightest, 1.0), 1.0).reshape(-1, 1, 1), shape
        )
    try:
        stops = math.nan if isinstance(exposure, str | bool | np.bool_) else float(exposure)
    except (TypeError, ValueError, OverflowError):
        stops = math.nan
    if not -MOST_STOPS <= stops <= MOST_STOPS:
        allowed = f'"auto", "common" or stops from {-MOST_STOPS:g} to {MOST_STOPS:g}'
        raise refusal("exposure", f"{allowed}", exposure)
    return np.full(shape, 2.0**stops)


def gains_in_words(factors: Floats, each: str) -> str:
    """What stands under a title: how much brighter than life the colours are shown."""
    if np.ptp(factors) > 0.0:
        return f"{each} brought to full brightness"
    factor = float(factors.flat[0])
    return "" if abs(factor - 1.0) < 0.005 else f"shown {factor:.2g} times as bright"


def screen(xyz: Floats, factor: Floats | float) -> Floats:
    """Encoded sRGB in [0, 1] of colours made brighter by ``factor``, hue kept where sRGB cannot hold them."""
    encoded = _convert(factor * xyz, "xyz", "srgb")
    return np.clip(_in_gamut(encoded), 0.0, 1.0)


def chromatic(xyz: Floats) -> Floats:
    """Each colour as bright as sRGB shows it, black left black: what a chromaticity looks like."""
    linear = _convert(xyz, "xyz", "linear-srgb")
    peak = linear.max(axis=-1, keepdims=True)
    return screen(xyz / np.where(peak > 0.0, peak, 1.0), 1.0)


def monochromatic(wavelength_nm: Floats) -> Floats:
    """Encoded sRGB that stands for pure wavelengths, for bands under spectra; no screen can show the colours themselves.

    What sRGB lacks is cut off softly (cut off sharply, the corners of the gamut would show as stripes), the rest is made
    bright, and fades to black where the eye fails.
    """
    xyz = np.asarray(_core.color_matching(np.ascontiguousarray(wavelength_nm.reshape(-1)), "cie1931"))
    xyz = xyz.reshape(*wavelength_nm.shape, 3)
    linear = _convert(xyz, "xyz", "linear-srgb")
    linear /= np.maximum(linear.max(axis=-1, keepdims=True), 1e-9)
    linear = 0.5 * (linear + np.sqrt(linear**2 + 0.03)) / (0.5 * (1.0 + np.sqrt(1.03)))
    linear *= np.minimum(xyz.sum(axis=-1, keepdims=True) / 0.3, 1.0) ** 0.8
    return np.clip(_convert(linear, "linear-srgb", "srgb"), 0.0, 1.0)


def readable_on(rgb: Floats) -> str:
    """Black or white, whichever is read more easily on an encoded sRGB colour."""
    linear = _convert(rgb, "srgb", "linear-srgb")
    return "#000000" if float(linear @ _core.REC709_LUMINANCE) > 0.18 else "#ffffff"


def _convert(colors: Floats, from_space: str, to_space: str) -> Floats:
    rows = np.ascontiguousarray(np.asarray(colors, dtype=np.float64).reshape(-1, 3))
    return np.asarray(_core.convert_color(rows, from_space, to_space, _D65, None)).reshape(np.shape(colors))


def _in_gamut(encoded: Floats) -> Floats:
    rows, _ = _core.map_gamut(np.ascontiguousarray(encoded.reshape(-1, 3)), "srgb", "hue")
    return np.asarray(rows).reshape(encoded.shape)
