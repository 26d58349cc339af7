"""Spheres, rectangles and disks among the meshes of others. Internal."""

from __future__ import annotations

from typing import Any

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.exchange.geometry import Surface

# Of its size, by which u and v of a mesh may be off those of the shape that it is: a map is laid over 256 rows.
_NEAR = 2e-3


def shape_of(points: Floats) -> dict[str, Any] | None:
    """The sphere, rectangle or disk that points lie on; ``None`` for anything else."""
    if len(points) < 4 or not np.isfinite(points).all():
        return None
    size = float(np.ptp(points, axis=0).max())
    if size <= 0.0:
        return None
    middle = points.mean(axis=0)
    _, spread, axes = np.linalg.svd(points - middle, full_matrices=False)
    if spread[2] < 1e-5 * spread[0]:
        return _flat(points, middle, axes, size)
    # The sphere of least squares: |p|^2 = 2 c.p + (r^2 - |c|^2).
    design = np.concatenate([2.0 * (points - middle), np.ones((len(points), 1))], axis=1)
    solution = np.linalg.lstsq(design, ((points - middle) ** 2).sum(axis=1), rcond=None)[0]
    center = solution[:3]
    radius = float(np.sqrt(max(solution[3] + center @ center, 0.0)))
    away = np.abs(np.linalg.norm(points - middle - center, axis=1) - radius)
    reaches = all(np.ptp(points[:, axis]) > 1.9 * radius for axis in range(3))
    if away.max() > 1e-3 * radius or not reaches:
        return None
    return {"sphere": {"center": (middle + center).tolist(), "radius": radius}}


def _flat(points: Floats, middle: Floats, axes: Floats, size: float) -> dict[str, Any] | None:
    across = points - middle
    if len(points) == 4:
        # A parallelogram: the corner opposite the first is the sum of its neighbours.
        for far in (1, 2, 3):
            near = [i for i in (1, 2, 3) if i != far]
            u, v = (points[i] - points[0] for i in near)
            if np.linalg.norm(points[0] + u + v - points[far]) < 1e-6 * size:
                center = points[0] + 0.5 * (u + v)
                return {"rectangle": {"center": center.tolist(), "u": (0.5 * u).tolist(), "v": (0.5 * v).tolist()}}
        return None
    radius = float(np.linalg.norm(across, axis=1).max())
    rim = np.linalg.norm(across, axis=1) > 0.999 * radius
    if rim.sum() >= len(points) - 1 >= 8:
        normal = axes[2]
        return {"disk": {"center": middle.tolist(), "normal": normal.tolist(), "radius": radius}}
    return None


def on_chart(shape: dict[str, Any], points: Floats, uv: Floats) -> dict[str, Any] | None:
    """The same shape with u and v, upwards, as the mesh has them; ``None`` where they lie otherwise."""
    ((kind, keys),) = shape.items()
    size = float(np.ptp(points, axis=0).max())
    if kind == "rectangle":
        design = np.stack([np.ones(len(uv)), 2.0 * uv[:, 0] - 1.0, 2.0 * uv[:, 1] - 1.0], axis=1)
        found, _, rank, _ = np.linalg.lstsq(design, points, rcond=None)
        if rank < 3 or np.abs(design @ found - points).max() > _NEAR * size:
            return None
        center, u, v = found.tolist()
        return {"rectangle": {"center": center, "u": u, "v": v}}
    turned = [keys] if kind == "sphere" else [keys, {**keys, "normal": [-x for x in keys["normal"]]}]
    for own in turned:
        if np.abs(Surface(kind, own).points(uv[:, 0], uv[:, 1]) - points).max() <= _NEAR * size:
            return {kind: own}
    return None
