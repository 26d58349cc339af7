"""Latitude-longitude light: looked up here in float64, written as a plain EXR for the renderer."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Directions = NDArray[np.float64]


def texel_directions(height: int, width: int) -> Directions:
    """(height, width, 3) directions of texel centres: first row +y, middle column -z, columns grow towards +x."""
    polar = np.pi * (np.arange(height) + 0.5)[:, None] / height
    azimuth = 2.0 * np.pi * ((np.arange(width) + 0.5)[None, :] / width - 0.5)
    x = np.sin(polar) * np.sin(azimuth)
    z = -np.sin(polar) * np.cos(azimuth)
    return np.stack([x, np.broadcast_to(np.cos(polar), x.shape), z], axis=-1)


def bake(radiance: Callable[[Directions], NDArray[np.float64]], height: int = 256) -> NDArray[np.float32]:
    """(height, 2 height) or (height, 2 height, 3) map of a function of direction, rounded to float32."""
    return np.asarray(radiance(texel_directions(height, 2 * height)), dtype=np.float32)


def lookup(image: NDArray[np.float32], direction: Directions, rotation_deg: float = 0.0) -> NDArray[np.float64]:
    """Radiance of a map (height, width[, 3]) in unit directions (..., 3): bilinear, wrapped in u, clamped in v.

    ``rotation_deg`` > 0 turns the map from +z towards +x about +y.
    """
    height, width = image.shape[:2]
    turn = np.radians(rotation_deg)
    # undo the turn of the map: what lies at +z of the map is seen towards (sin turn, 0, cos turn)
    x = direction[..., 0] * np.cos(turn) - direction[..., 2] * np.sin(turn)
    z = direction[..., 0] * np.sin(turn) + direction[..., 2] * np.cos(turn)
    u = (0.5 + np.arctan2(x, -z) / (2.0 * np.pi)) * width - 0.5
    v = np.arctan2(np.hypot(x, z), direction[..., 1]) / np.pi * height - 0.5
    column, row = np.floor(u).astype(int), np.floor(v).astype(int)
    fu, fv = u - column, v - row
    left, right = column % width, (column + 1) % width
    above, below = np.clip(row, 0, height - 1), np.clip(row + 1, 0, height - 1)
    if image.ndim == 3:
        fu, fv = fu[..., None], fv[..., None]

    def texels(row: NDArray[np.int_], column: NDArray[np.int_]) -> NDArray[np.float64]:
        return image[row, column].astype(np.float64)

    upper = texels(above, left) * (1.0 - fu) + texels(above, right) * fu
    lower = texels(below, left) * (1.0 - fu) + texels(below, right) * fu
    return upper * (1.0 - fv) + lower * fv


def smooth_grey(direction: Directions) -> NDArray[np.float64]:
    """A smooth grey sky, 0.4..2.4: no symmetry, so a mirrored or turned map cannot go unseen."""
    x, y, z = np.moveaxis(direction, -1, 0)
    return 1.2 + 0.5 * x + 0.3 * y - 0.25 * z + 0.2 * x * y - 0.15 * y * z + 0.1 * (x * x - z * z)


def lobe(
    axis: NDArray[np.float64], sharpness: float, peak: float, ambient: float
) -> Callable[[Directions], NDArray[np.float64]]:
    """A soft grey lamp around ``axis`` on a dim sky: ambient + peak exp(sharpness (cos(angle) - 1))."""

    def radiance(direction: Directions) -> NDArray[np.float64]:
        return ambient + peak * np.exp(sharpness * (direction @ axis - 1.0))

    return radiance


def write_exr(path: Path, image: NDArray[np.float32]) -> None:
    """Write (height, width) grey or (height, width, 3) linear Rec.709 as an uncompressed float32 scan-line EXR.

    Written out by hand from the file layout (openexr.com, "OpenEXR File Layout"), so that a reader is not tested with
    the library it was made from. Grey is written as R = G = B.
    """
    rgb = np.repeat(image[..., None], 3, axis=-1) if image.ndim == 2 else image
    height, width = rgb.shape[:2]

    def attribute(name: str, kind: str, value: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    channels = b"".join(c + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"  # 2: float
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<II", 20000630, 2) + b"".join(
        [
            attribute("channels", "chlist", channels),
            attribute("compression", "compression", b"\0"),
            attribute("dataWindow", "box2i", window),
            attribute("displayWindow", "box2i", window),
            attribute("lineOrder", "lineOrder", b"\0"),
            attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
            attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
            attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)),
            b"\0",
        ]
    )
    line_bytes = 3 * 4 * width
    first = len(header) + 8 * height
    offsets = b"".join(struct.pack("<Q", first + row * (line_bytes + 8)) for row in range(height))
    lines = b"".join(
        struct.pack("<ii", row, line_bytes) + np.ascontiguousarray(rgb[row, :, ::-1].T, dtype="<f4").tobytes()
        for row in range(height)
    )
    path.write_bytes(header + offsets + lines)
