"""How the planes of a picture are called and stored in OpenEXR files. Internal.

Spectra follow A. Fichet, R. Pacanowski, A. Wilkie, "An OpenEXR Layout for Spectral Images", JCGT 10(3), 2021: a layer for each
Stokes component, a channel for each wavelength with a comma for the decimal point, `S0.550,00nm`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[Any]
# Names of channels, numbers, and whether floats become halves.
FilePlane = tuple[list[str], _Array, bool]


@dataclass(frozen=True)
class _Stored:
    """A plane's channels in files; `may_be_half`: three digits are enough for it."""

    channels: tuple[str, ...]
    type: type
    may_be_half: bool = False


# Every plane of `Image.channels`. (OpenEXR has no signed whole numbers: -1, no object, needs a float.)
PLANES: dict[str, _Stored] = {
    "depth": _Stored(("depth.Z",), np.float32),
    "thickness_nm": _Stored(("thickness_nm",), np.float32),
    "normal": _Stored(("normal.X", "normal.Y", "normal.Z"), np.float32, True),
    "path_difference_nm": _Stored(("path_difference_nm",), np.float32),
    "object": _Stored(("object",), np.int32),
    "variance": _Stored(("variance",), np.float32),
    "samples": _Stored(("samples",), np.int32),
    "alpha": _Stored(("A",), np.float32, True),
}
_STOKES = tuple(f"stokes.{axis}.{component}" for axis in "XYZ" for component in range(4))
_SPECTRAL = re.compile(r"S([0-3])\.(\d+(?:,\d*)?)nm")
# Facts of ours that come back as metadata.
_METADATA = ("backend", "simd", "samples", "seed", "scene", "crop", "shard", "merged")
LAYOUT_FACTS = {
    "spectralLayoutVersion": "1.0",
    "emissiveUnits": "relative spectral radiance: 1 is that of D65 of Y = 1 at 560 nm",
}
# S3 > 0 turns clockwise as seen by whom the light meets (docs/reference/theory.md, section 5).
HANDEDNESS_FACTS = {"polarisationHandedness": "right"}


def wavelength_text(nm: float) -> str:
    """``550,00``: two decimals, more where they are needed."""
    text = f"{nm:.2f}"
    if float(text) != nm:
        text = np.format_float_positional(nm, trim="-")
    return text.replace(".", ",")


def file_planes(planes: Mapping[str, _Array], spectral: Mapping[str, _Array], half: bool) -> list[FilePlane]:
    """All planes as the core writes them."""
    written: list[FilePlane] = []
    for name, values in planes.items():
        stored = PLANES[name]
        if name == "samples":
            values = values.astype(np.uint32)
        elif values.dtype != np.float32:
            values = values.astype(np.float32)
        written.append((list(stored.channels), np.ascontiguousarray(values), half and stored.may_be_half))
    if "stokes" in spectral:
        written.append((list(_STOKES), np.ascontiguousarray(spectral["stokes"]), half))
    if "spectral_stokes" in spectral:
        names = [f"S{j}.{wavelength_text(nm)}nm" for nm in spectral["spectral_nm"] for j in range(4)]
        written.append((names, np.ascontiguousarray(spectral["spectral_stokes"]), half))
    elif "spectra" in spectral:
        names = [f"S0.{wavelength_text(nm)}nm" for nm in spectral["spectral_nm"]]
        written.append((names, np.ascontiguousarray(spectral["spectra"]), half))
    return written


def planes_of_file(
    channels: Sequence[tuple[str, _Array, bool]], size: tuple[int, int]
) -> tuple[dict[str, _Array], dict[str, _Array]]:
    """The planes, and what belongs to spectra and polarisation, of the channels of a file."""
    found = {name: values for name, values, _ in channels}
    planes: dict[str, _Array] = {}
    for name, stored in PLANES.items():
        if all(channel in found for channel in stored.channels):
            parts = [found[channel] for channel in stored.channels]
            joined = parts[0] if len(parts) == 1 else np.stack(parts, axis=-1)
            planes[name] = np.ascontiguousarray(joined).astype(stored.type)
    spectral: dict[str, _Array] = {}
    if all(name in found for name in _STOKES):
        spectral["stokes"] = np.stack([found[name] for name in _STOKES], axis=-1).reshape(*size, 3, 4)
    by_component: dict[int, dict[float, _Array]] = {}
    for name, values in found.items():
        match = _SPECTRAL.fullmatch(name)
        if match:
            by_component.setdefault(int(match[1]), {})[float(match[2].replace(",", "."))] = values
    if 0 in by_component:
        wavelengths = sorted(by_component[0])
        spectral["spectral_nm"] = np.array(wavelengths)
        spectral["spectra"] = np.stack([by_component[0][nm] for nm in wavelengths], axis=-1)
        if all(sorted(by_component.get(j, {})) == wavelengths for j in range(4)):
            by_wavelength = [np.stack([by_component[j][nm] for j in range(4)], axis=-1) for nm in wavelengths]
            spectral["spectral_stokes"] = np.stack(by_wavelength, axis=-2)
    return planes, spectral


def seen_spectra(spectral_stokes: _Array, scene: object) -> _Array:
    """Spectra as the camera of a scene sees them, through its polariser or none, of the light's Stokes vectors before it."""
    camera = scene.get("camera") if isinstance(scene, Mapping) else None
    degrees = camera.get("polarizer_deg") if isinstance(camera, Mapping) else None
    natural = spectral_stokes[..., 0]
    if not isinstance(degrees, (int, float)):
        return np.ascontiguousarray(natural)
    twice = np.radians(2.0 * degrees)
    along = np.cos(twice) * spectral_stokes[..., 1] + np.sin(twice) * spectral_stokes[..., 2]
    return np.ascontiguousarray(0.5 * (natural + along)).astype(np.float32)


def xyz_of_file(
    channels: Sequence[tuple[str, _Array, bool]], corners: Sequence[float] | None, name: str
) -> npt.NDArray[np.float32]:
    """XYZ of a file: as computed where it is ours, else from linear R, G, B (or Y alone) by the primaries it states."""
    found = {channel: values for channel, values, _ in channels}
    if all(f"XYZ.{axis}" in found for axis in "XYZ"):
        return np.ascontiguousarray(np.stack([found[f"XYZ.{axis}"] for axis in "XYZ"], axis=-1))
    red, green, blue, white = np.array(corners or _REC709).reshape(4, 2).astype(np.float64)
    columns = [
        np.array([x / y, 1.0, (1.0 - x - y) / y]) if y else np.array([1.0, 0.0, 0.0]) for x, y in (red, green, blue)
    ]
    d65 = np.array([white[0] / white[1], 1.0, (1.0 - white[0] - white[1]) / white[1]])
    matrix = np.stack(columns, axis=-1)
    matrix = matrix * np.linalg.solve(matrix, d65)
    if all(channel in found for channel in "RGB"):
        rgb = np.stack([found[channel] for channel in "RGB"], axis=-1).astype(np.float64)
        return np.ascontiguousarray((rgb @ matrix.T).astype(np.float32))
    if "Y" in found:
        return np.ascontiguousarray((found["Y"][..., None] * d65).astype(np.float32))
    names = ", ".join(list(found)[:20])
    raise ValueError(f"{name}: a picture needs the channels R, G, B or XYZ.X, XYZ.Y, XYZ.Z; it has {names}")


# ITU-R BT.709-6, table 1.
_REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


def metadata_of_file(said: Mapping[str, Any], name: str) -> dict[str, Any]:
    """What our own facts say, as `Image.metadata` has it."""
    metadata = {key: said[key] for key in _METADATA if key in said}
    try:
        if "seed" in metadata:
            metadata["seed"] = int(metadata["seed"])
        for key in ("scene", "merged"):
            if key in metadata:
                metadata[key] = json.loads(metadata[key])
        if "crop" in metadata:
            metadata["crop"] = tuple(int(word) for word in metadata["crop"].split())
    except (TypeError, ValueError, AttributeError, RecursionError):
        raise ValueError(f"{name}: its attributes seed, scene, crop or merged are damaged") from None
    software = said.get("Software")
    if isinstance(software, str) and software.startswith("iridesce "):
        metadata["version"] = software.removeprefix("iridesce ")
    return metadata
