"""Bubbles that share walls, as triangles: spheres and caps cut where another bubble has the better claim. Internal.

Bubble i claims a point by f_i = (|p - c_i|^2 - r_i^2) / r_i, the least rules, as `docs/reference/scenes.md` says. Where two
claims are equal lies their wall, part of a sphere or a plane.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from iridesce.arguments.operands import Floats
from iridesce.exchange.geometry import Mesh, Surface, globe, joined

_ROUND = (96, 48)
_RINGS = (96, 24)
# Steps that put a cut edge onto both surfaces: from the middle of an edge of 1/96 of a turn, to 1e-9 of the radius.
_STEPS = 20

Claim = Callable[[Floats], Floats]


def walls(spheres: Sequence[Mapping[str, Any]]) -> tuple[Mesh, Mesh | None]:
    """The outsides, and the walls between (fronts towards the larger bubble) where there are any; u and v by longitude and
    latitude around the mean of the centres."""
    centers = np.array([ball["center"] for ball in spheres], dtype=np.float64)
    radii = np.array([ball["radius"] for ball in spheres], dtype=np.float64)
    middle = centers.mean(axis=0)
    away = np.linalg.norm(centers[:, None] - centers[None], axis=-1)
    overlap = (away < radii[:, None] + radii) & (away > np.abs(radii[:, None] - radii))
    claims = [_claim(center, radius) for center, radius in zip(centers, radii, strict=True)]
    outer, inner = [], []
    for i in range(len(radii)):
        ball = Surface("sphere", {"center": centers[i], "radius": radii[i]})
        mesh = ball._grid(*_ROUND)
        for k in np.flatnonzero(overlap[i]):
            mesh = cut(mesh, claims[k], ball)
        if len(mesh.triangles):
            outer.append(mesh)
        for j in range(i + 1, len(radii)):
            if overlap[i, j]:
                crowd = [claims[k] for k in np.flatnonzero(overlap[i] & overlap[j])]
                wall = _wall((centers[i], radii[i]), (centers[j], radii[j]), claims[i], crowd)
                if wall is not None and len(wall.triangles):
                    inner.append(wall)
    return _mapped(joined(outer), middle), _mapped(joined(inner), middle) if inner else None


def _claim(center: Floats, radius: float) -> Claim:
    return lambda p: (((p - center) ** 2).sum(axis=-1) - radius**2) / radius


def _wall(one: tuple[Floats, float], other: tuple[Floats, float], own: Claim, crowd: list[Claim]) -> Mesh | None:
    (c_small, small), (c_large, large) = (one, other) if one[1] <= other[1] else (other, one)
    way = c_large - c_small
    distance = float(np.linalg.norm(way))
    axis = way / distance
    along = 0.5 * (distance + (small - large) * (small + large) / distance)
    circle2 = (small - along) * (small + along)
    if circle2 <= 0.0:
        return None
    ring, circle = c_small + axis * along, float(np.sqrt(circle2))
    difference = large - small
    if difference <= 1e-12 * large:
        surface = Surface("disk", {"center": ring, "normal": axis, "radius": circle})
        mesh = _fan(surface, ring, axis, circle, 0.0)
    else:
        radius = float(min(small * large / difference, 1e9 * large))
        if crowd:
            # Where the two claims are equal: 1/r1 - 1/r2 of curvature.
            center = (c_small / small - c_large / large) / (1.0 / small - 1.0 / large)
            power = ((c_small @ c_small - small**2) / small - (c_large @ c_large - large**2) / large) / (
                1.0 / small - 1.0 / large
            )
            radius = max(float(center @ center - power), 0.0) ** 0.5
        else:
            center = ring - axis * max(radius**2 - float(circle2), 0.0) ** 0.5
        surface = Surface("sphere", {"center": center, "radius": radius})
        mesh = _fan(surface, ring, axis, min(circle, radius), radius)
    for claim in crowd:
        mesh = cut(mesh, lambda p, claim=claim: claim(p) - own(p), surface)  # type: ignore[misc]
    return mesh


def _across(axis: Floats) -> Floats:
    other = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    return np.asarray(other / np.linalg.norm(other))


def _fan(surface: Surface, ring: Floats, axis: Floats, circle: float, radius: float) -> Mesh:
    """Rings of the cap (or the disk, radius 0) over a circle; fronts along the axis."""
    around, rings = _RINGS
    right = _across(axis)
    up = np.cross(axis, right)
    angle = 2.0 * np.pi * np.arange(around) / around
    share = np.arange(1, rings + 1) / rings
    rho = circle * share if radius == 0.0 else radius * np.sin(share * np.arcsin(min(circle / radius, 1.0)))
    sag = np.zeros(rings) if radius == 0.0 else np.sqrt(radius**2 - rho**2) - np.sqrt(radius**2 - circle**2)
    top = 0.0 if radius == 0.0 else radius - np.sqrt(radius**2 - circle**2)
    out = np.cos(angle)[:, None] * right + np.sin(angle)[:, None] * up
    points = ring + rho[:, None, None] * out + sag[:, None, None] * axis
    points = np.concatenate([(ring + top * axis)[None], points.reshape(-1, 3)])
    here = np.arange(around)
    after = (here + 1) % around
    parts = [np.stack([np.zeros_like(here), 1 + here, 1 + after], axis=1)]
    for number in range(1, rings):
        inside, outside = 1 + (number - 1) * around, 1 + number * around
        parts.append(np.stack([inside + here, outside + here, outside + after], axis=1))
        parts.append(np.stack([inside + here, outside + after, inside + after], axis=1))
    normals = np.broadcast_to(axis, points.shape) if radius == 0.0 else surface.normals(points)
    return Mesh(points, np.asarray(normals), None, np.concatenate(parts))


def cut(mesh: Mesh, claim: Claim, surface: Surface) -> Mesh:
    """What of a mesh on a surface lies where a claim is at least zero; new corners lie on both surfaces."""
    kept = claim(mesh.positions) >= 0.0
    inside = kept[mesh.triangles]
    count = inside.sum(axis=1)
    # Turned so that the corner that is alone comes first.
    one, two = (mesh.triangles[count == number] for number in (1, 2))
    one = _turned(one, np.argmax(kept[one], axis=1))
    two = _turned(two, np.argmin(kept[two], axis=1))
    edges = np.concatenate([one[:, [0, 1]], one[:, [0, 2]], two[:, [1, 0]], two[:, [2, 0]]])
    edges, which = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    fresh = len(mesh.positions) + which.reshape(-1)
    first, second, third, fourth = np.split(fresh, np.cumsum([len(one), len(one), len(two)]))
    whole = [
        mesh.triangles[count == 3],
        np.stack([one[:, 0], first, second], axis=1),
        np.stack([two[:, 1], two[:, 2], fourth], axis=1),
        np.stack([two[:, 1], fourth, third], axis=1),
    ]
    extra = _between(mesh.positions[edges[:, 0]], mesh.positions[edges[:, 1]], claim, surface)
    points = np.concatenate([mesh.positions, extra])
    triangles = np.concatenate(whole)
    corners = points[triangles]
    size = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    triangles = triangles[size > 1e-12 * max(float(size.max(initial=0.0)), 1e-300)]
    used, triangles = np.unique(triangles, return_inverse=True)
    points = points[used]
    return Mesh(points, surface.normals(points), None, triangles.reshape(-1, 3))


def _turned(triangles: NDArray[np.int64], first: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.asarray(np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1))


def _between(a: Floats, b: Floats, claim: Claim, surface: Surface) -> Floats:
    """Where the claim is zero between points of a surface, by bisection."""
    below = (claim(a) < 0.0)[:, None]
    a, b = np.where(below, b, a), np.where(below, a, b)
    for _ in range(_STEPS):
        middle = _onto(0.5 * (a + b), surface)
        above = (claim(middle) >= 0.0)[:, None]
        a, b = np.where(above, middle, a), np.where(above, b, middle)
    return _onto(0.5 * (a + b), surface)


def _onto(points: Floats, surface: Surface) -> Floats:
    if surface.kind != "sphere":
        return points
    center, radius = np.asarray(surface.keys["center"]), float(surface.keys["radius"])
    way = points - center
    return np.asarray(center + way * (radius / np.linalg.norm(way, axis=-1, keepdims=True)))


def _mapped(mesh: Mesh, middle: Floats) -> Mesh:
    """Longitude and latitude; triangles across the seam get corners of their own, beyond u = 1."""
    u, v = globe(mesh.positions, middle)
    across = np.ptp(u[mesh.triangles], axis=1) > 0.5
    left = across[:, None] & (u[mesh.triangles] < 0.5)
    again = np.unique(mesh.triangles[left])
    place = np.full(len(u), -1)
    place[again] = len(u) + np.arange(len(again))
    triangles = np.where(left, place[mesh.triangles], mesh.triangles)
    uv = np.stack([np.concatenate([u, u[again] + 1.0]), np.concatenate([v, v[again]])], axis=1)
    positions = np.concatenate([mesh.positions, mesh.positions[again]])
    normals = None if mesh.normals is None else np.concatenate([mesh.normals, mesh.normals[again]])
    return Mesh(positions, normals, uv, triangles)
