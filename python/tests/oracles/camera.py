"""Camera rays: world right-handed, y up unless told, row 0 on top, ``fov_deg`` the full vertical angle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def unit(vector: ArrayLike) -> NDArray[np.float64]:
    """Vectors of length 1 along the last axis."""
    v = np.asarray(vector, dtype=float)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def camera_rays(
    camera: Mapping[str, Any], column: ArrayLike, row: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Origins and directions, each (..., 3), through places of the picture; pixel i spans ``column`` i to i + 1.

    ``camera`` is a scene's camera table: position, target, up, fov_deg or orthographic_height, resolution.
    """
    width, height = camera["resolution"]
    position = np.asarray(camera["position"], dtype=float)
    ahead = unit(np.asarray(camera["target"], dtype=float) - position)
    right = unit(np.cross(ahead, np.asarray(camera.get("up", (0.0, 1.0, 0.0)), dtype=float)))
    up = np.cross(right, ahead)
    # -1..1 over the height; square pixels, so the width reaches further by the aspect ratio
    across = ((2.0 * np.asarray(column, dtype=float) - width) / height)[..., None]
    along = ((height - 2.0 * np.asarray(row, dtype=float)) / height)[..., None]
    if "orthographic_height" in camera:
        half = camera["orthographic_height"] / 2.0
        origin = position + half * (across * right + along * up)
        return origin, np.broadcast_to(ahead, origin.shape)
    half = np.tan(np.radians(camera["fov_deg"]) / 2.0)
    direction = unit(ahead + half * (across * right + along * up))
    return np.broadcast_to(position, direction.shape), direction


def pixel_places(points: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Column and row offsets in 0..1 and weights, each (points^2,): Gauss-Legendre over one pixel's square."""
    node, weight = np.polynomial.legendre.leggauss(points)
    node, weight = (node + 1.0) / 2.0, weight / 2.0
    column, row = np.meshgrid(node, node)
    return column.ravel(), row.ravel(), np.outer(weight, weight).ravel()
