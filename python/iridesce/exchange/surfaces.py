"""What targets share in writing surfaces and cameras, and in telling what of them is lost. Internal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from iridesce.exchange import png
from iridesce.exchange.appearance import UNKNOWN, Reflectance, Roughness
from iridesce.exchange.package import Package
from iridesce.files.whole import read_whole

_MOST_BYTES = 2**28


def picture_file(name: str, found: Reflectance, package: Package, endings: tuple[str, ...], target: str) -> str | None:
    """The picture of a reflectance beside what is written, where the target reads such files; else it is told."""
    assert found.picture is not None
    ending = found.picture.suffix.lower()
    if ending not in endings:
        package.drop(
            f"{name}: the map of its reflectance: {target} reads {', '.join(endings)}, not {ending}; {UNKNOWN:g} is written"
        )
        return None
    file = f"{name}_reflectance{ending}"
    package.files[file] = read_whole(str(found.picture), _MOST_BYTES, "no map has")
    if ending in (".png", ".jpg", ".jpeg"):
        package.note(f"{file} is read as sRGB; a colour profile in it, which a scene obeys, is left to the target")
    return file


def told_spectrum(name: str, package: Package) -> None:
    """Targets of three numbers hold the colour of a spectrum."""
    package.drop(f"{name}: the spectrum of its reflectance; its colour under D65 is written")


def roughness_png(name: str, rough: Roughness, package: Package) -> str:
    """A 16-bit PNG, G the roughness, R and B full: what glTF and MaterialX read."""
    assert rough.grey is not None
    steps = np.rint(rough.grey * 65535.0).astype(np.uint16)
    full = np.full_like(steps, 65535)
    file = f"{name}_roughness.png"
    package.files[file] = png.png_bytes(np.stack([full, steps, full], axis=2), {})
    return file


def told_camera(camera: Mapping[str, Any], package: Package, lens: bool) -> None:
    """What of a camera is not written; ``lens``: whether the target's has an aperture."""
    if camera.get("aperture_radius") and not lens:
        package.drop(f"camera: its lens of radius {camera['aperture_radius']:g}; the target's is a pinhole")
    if camera.get("numerical_aperture"):
        package.drop(f"camera: its numerical aperture {camera['numerical_aperture']:g}; rays are parallel")
    if camera.get("polarizer_deg") is not None:
        package.drop("camera: its polariser")


def told_item(item: Mapping[str, Any], package: Package) -> None:
    """Keys of an object that no target holds yet."""
    for key in ("transform", "instances", "bump", "priority", "uv"):
        if item.get(key) not in (None, 0, {}, []):
            package.drop(f"{item['name']}: {key} is not written")
    ((_, keys),) = item["surface"].items()
    if keys.get("polarized_deg") is not None:
        package.drop(f"{item['name']}: its polarisation")
