"""What targets share in writing surfaces and cameras, and in telling what of them is lost. Internal."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.exchange import png
from iridesce.exchange.appearance import UNKNOWN, Reflectance, Roughness
from iridesce.exchange.drawn import drawn_shares, is_builtin
from iridesce.exchange.package import Package
from iridesce.exchange.pieces import Piece
from iridesce.files.whole import read_whole
from iridesce.thickness import ThicknessMap

_MOST_BYTES = 2**28


def picture_file(name: str, found: Reflectance, package: Package, endings: tuple[str, ...], target: str) -> str | None:
    """The picture of a reflectance beside what is written, where the target reads such files; else it is told."""
    assert found.picture is not None
    if is_builtin(found.picture.name):
        package.drop(f"{name}: the picture {found.picture.name}, which comes with iridesce; {UNKNOWN:g} is written")
        return None
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


def environment_file(name: str, number: int, folder: Path, package: Package) -> str | None:
    """The map of an environment beside what is written; ``None`` for one that comes with the program, told."""
    if is_builtin(name):
        package.drop(f"light {number}: the map {name}, which comes with iridesce; an even light is written")
        return None
    path = Path(name)
    file = f"light_{number}{path.suffix.lower()}"
    package.files[file] = read_whole(str(path if path.is_absolute() else folder / path), _MOST_BYTES, "no map has")
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
    """Keys of an object that no target holds."""
    if item.get("priority"):
        package.drop(f"{item['name']}: its priority: where bodies overlap the target draws the surfaces of both")
    ((_, keys),) = item["surface"].items()
    if keys.get("polarized_deg") is not None:
        package.drop(f"{item['name']}: its polarisation")


def told_piece(piece: Piece, package: Package) -> None:
    """Maps that a piece cannot bear, and what of its object no target holds."""
    told_item(piece.item, package)
    for what in piece.lost_maps:
        package.drop(f"{piece.name}: the map of its {what}: u and v count its thickness")


def heights_of(piece: Piece, folder: Path) -> tuple[Floats, float] | None:
    """The heights of a bump as shares of 1 (row 0 on top), and what 1 is in scene units."""
    bump = piece.item.get("bump")
    if not bump or "bump" in piece.lost_maps:
        return None
    if is_builtin(bump["map"]):
        return drawn_shares(bump["map"]), float(bump["height"])
    path = Path(bump["map"])
    path = path if path.is_absolute() else folder / path
    try:
        shares = ThicknessMap.load(path, min_nm=0.0, max_nm=1.0).thickness_nm
    except ValueError:
        shares = ThicknessMap.load(path).thickness_nm
    return np.asarray(shares), float(bump["height"])


def normal_png(piece: Piece, folder: Path, package: Package, extent: float) -> str | None:
    """A bump as the map of normals that glTF and MaterialX read: R along u, G along v upwards, B outwards."""
    found = heights_of(piece, folder)
    if found is None:
        return None
    shares, height = found
    along_u, along_v = _lengths(piece, extent, len(shares))
    rows, columns = shares.shape
    wraps = piece.repeats
    slopes = []
    for axis, per_unit, repeats, length in ((1, columns, wraps[0], along_u), (0, -rows, wraps[1], along_v)):
        pad = [(1, 1) if number == axis else (0, 0) for number in range(2)]
        wide = np.pad(shares, pad, mode="wrap" if repeats else "edge")
        ahead = np.take(wide, np.arange(2, wide.shape[axis]), axis=axis)
        behind = np.take(wide, np.arange(wide.shape[axis] - 2), axis=axis)
        slopes.append(0.5 * height * per_unit * (ahead - behind) / np.maximum(length, 1e-300))
    normal = np.stack([-slopes[0], -slopes[1], np.ones_like(shares)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    file = f"{piece.name}_normal.png"
    package.files[file] = png.png_bytes(np.rint((0.5 + 0.5 * normal) * 65535.0).astype(np.uint16), {})
    package.note(f"{piece.name}: its bump as a map of normals, as steep as it is on the first of its instances")
    return file


def _lengths(piece: Piece, extent: float, rows: int) -> tuple[Floats, Floats]:
    """How far a point of the surface moves in the world for one whole map along u, and along v; by row or one number."""
    linear = piece.placements[0][:, :3]
    scale_u, scale_v = piece.uv_scale
    if piece.surface is not None:
        v = 1.0 - (np.arange(rows) + 0.5)[:, None] / rows
        at, step = np.full_like(v, 0.5), 1e-4
        ways = (
            piece.surface.points(at + step, v) - piece.surface.points(at - step, v),
            piece.surface.points(at, v + step) - piece.surface.points(at, v - step),
        )
        lengths = [np.linalg.norm(way @ linear.T, axis=-1) / (2.0 * step) for way in ways]
        if (scale_u, scale_v) == (1.0, 1.0):
            return lengths[0], lengths[1]
        return np.asarray(lengths[0].mean() / abs(scale_u)), np.asarray(lengths[1].mean() / abs(scale_v))
    mesh = piece.mesh(extent)
    assert mesh.uv is not None
    corners, uv = mesh.positions[mesh.triangles] @ linear.T, mesh.uv[mesh.triangles]
    q, r = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    dq, dr = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = dq[:, 0] * dr[:, 1] - dq[:, 1] * dr[:, 0]
    kept = area != 0.0
    weight = np.linalg.norm(np.cross(q, r), axis=1)[kept]
    along_u = (q * dr[:, 1:] - r * dq[:, 1:])[kept] / area[kept, None]
    along_v = (r * dq[:, :1] - q * dr[:, :1])[kept] / area[kept, None]
    total = max(float(weight.sum()), 1e-300)
    return tuple(np.asarray((np.linalg.norm(way, axis=1) * weight).sum() / total) for way in (along_u, along_v))  # type: ignore[return-value]
