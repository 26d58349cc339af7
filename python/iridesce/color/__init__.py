"""From spectra to colour: illuminants, observers, tristimulus sums, colour spaces, differences, gamuts (``ir.color``).

Tristimulus values are relative: the perfect white reflector has Y = 1. Wavelengths are vacuum wavelengths in nm. A
colour is three values on the last axis; everything before it broadcasts. Results are float64.

Spaces: ``xyz xyy lab lch oklab``; ``srgb display-p3 rec2020`` (encoded); ``linear-srgb acescg ntsc1953`` (linear). RGB
matrices are derived from primaries and whites: D65 (0.3127, 0.3290), C (0.31006, 0.31616), ACES (0.32168, 0.33767).
Values out of range are kept, negative ones on the curve of their absolute value, until a gamut mapping is asked for.
"""

from __future__ import annotations

from iridesce.color.camera_tables import Camera, camera, cameras
from iridesce.color.films import dias1991, purity_eps, stack_color
from iridesce.color.light import Illuminant, color_matching, illuminant, illuminants
from iridesce.color.spaces import convert, delta_e, map_gamut, rgb_matrix, spectrum_to_xyz

__all__ = [
    "Camera",
    "Illuminant",
    "camera",
    "cameras",
    "color_matching",
    "convert",
    "delta_e",
    "dias1991",
    "illuminant",
    "illuminants",
    "map_gamut",
    "purity_eps",
    "rgb_matrix",
    "spectrum_to_xyz",
    "stack_color",
]


def __dir__() -> list[str]:
    return __all__
