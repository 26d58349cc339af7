"""What a scene says of a surface beside its film: how rough it is, what it reflects; in the terms of other programs. Internal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.exchange.drawn import drawn_shares, is_builtin
from iridesce.files.spectra import read_spectrum
from iridesce.optics.wavelengths import VISIBLE_NM, in_steps
from iridesce.thickness import ThicknessMap

_FINE_NM = in_steps(VISIBLE_NM, 1.0)
UNKNOWN = 0.5
"""What stands for a reflectance that a target cannot read."""


@dataclass(frozen=True, eq=False)
class Roughness:
    """Facets of GGX, alpha = roughness^2, as glTF, OpenPBR, Blender and a scene count."""

    along_u: float
    along_v: float
    grey: Floats | None = None
    """A map over u and v, row 0 on top; the two numbers are then its mean."""

    @property
    def alpha(self) -> tuple[float, float]:
        """Along u and along v."""
        return self.along_u**2, self.along_v**2

    @property
    def is_brushed(self) -> bool:
        """Whether it differs along u and v."""
        return self.along_u != self.along_v

    @property
    def mean(self) -> float:
        """One number for programs that hold one."""
        return float(np.sqrt(self.along_u * self.along_v)) if self.is_brushed else self.along_u

    def openpbr(self) -> tuple[float, float]:
        """specular_roughness and specular_roughness_anisotropy: alpha_t = r^2 sqrt(2 / (1 + (1 - a)^2)), alpha_b = (1 - a)
        alpha_t (OpenPBR 1.1, Microfacet model), the greater along the tangent."""
        most, least = max(self.alpha), min(self.alpha)
        share = least / most if most > 0.0 else 1.0
        return float(np.sqrt(most / np.sqrt(2.0 / (1.0 + share**2)))), 1.0 - share

    def gltf(self) -> tuple[float, float, float]:
        """roughnessFactor, and anisotropyStrength and Rotation of KHR_materials_anisotropy: alpha_t = mix(alpha, 1,
        strength^2), alpha_b = alpha, the tangent along u turned anticlockwise."""
        most, least = max(self.alpha), min(self.alpha)
        strength = float(np.sqrt((most - least) / (1.0 - least))) if most > least else 0.0
        return float(np.sqrt(least)), strength, 0.0 if self.along_u >= self.along_v else 0.5 * np.pi


@dataclass(frozen=True, eq=False)
class Reflectance:
    """Of a matt surface: its colour, and where there is one its spectrum or its picture."""

    rgb: list[float]
    """Linear Rec.709; of a spectrum under D65."""
    spectrum: tuple[Floats, Floats] | None = None
    """Wavelengths in nm, reflectances."""
    picture: Path | None = None


def roughness_of(keys: Mapping[str, Any], folder: Path, name: str, notes: list[str]) -> Roughness | None:
    """What a surface's ``roughness`` says; ``None`` for a mirror."""
    value = keys.get("roughness")
    if not value:
        return None
    if isinstance(value, int | float):
        return Roughness(float(value), float(value))
    if not isinstance(value, Mapping):
        along_u, along_v = (float(x) for x in value)
        return Roughness(along_u, along_v) if along_u or along_v else None
    low, high = float(value.get("min", 0.0)), float(value.get("max", 1.0))
    part = {key: value[key] for key in ("channel", "page") if key in value}
    path = folder / value["map"]
    try:
        if is_builtin(value["map"]):
            grey = drawn_shares(value["map"])
            return _mapped(low + (high - low) * grey)
        try:
            grey = ThicknessMap.load(path, min_nm=0.0, max_nm=1.0, **part).thickness_nm
        except ValueError:
            grey = ThicknessMap.load(path, **part).thickness_nm
    except ValueError as error:
        notes.append(f"{name}: the map of its roughness ({error}); the middle of its range stands for it")
        return Roughness(0.5 * (low + high), 0.5 * (low + high))
    return _mapped(low + (high - low) * np.asarray(grey))


def _mapped(values: Floats) -> Roughness:
    grey = np.clip(values, 0.0, 1.0)
    return Roughness(float(grey.mean()), float(grey.mean()), grey)


def reflectance_of(value: Any, folder: Path) -> Reflectance:
    """What ``diffuse.reflectance`` says."""
    if isinstance(value, int | float):
        return Reflectance([float(value)] * 3)
    if not isinstance(value, Mapping):
        return Reflectance([float(x) for x in value])
    if "map" in value:
        return Reflectance([UNKNOWN] * 3, picture=folder / value["map"])
    spectrum = read_spectrum(folder / value["spectrum"])
    nm, ratio = np.asarray(spectrum.wavelength_nm), np.asarray(spectrum.measured)
    xyz = color.spectrum_to_xyz(_FINE_NM, np.interp(_FINE_NM, nm, ratio))
    rgb = np.clip(color.rgb_matrix("linear-srgb") @ xyz, 0.0, 1.0)
    return Reflectance([float(x) for x in rgb], spectrum=(nm, ratio))


def lamp_rgb(illuminant: Any) -> Floats:
    """The colour of a lamp of Y = 1, linear Rec.709, cut at 0."""
    return np.maximum(color.rgb_matrix("linear-srgb") @ color.illuminant(illuminant).white(), 0.0)
