"""Shapes of scenes as points over u and v, and as triangles. Internal.

u and v run as `docs/reference/conventions.md` says: what is laid over a shape by them lies there in every program.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from iridesce.arguments.operands import Floats

# Sine of the angle to +y below which a normal counts as vertical: as the scene's own rule.
_VERTICAL = 1e-6
_SPHERE = (96, 48)
_DISK = (96, 16)
_TUBE = 96


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles, counter-clockwise seen from the front; v upwards."""

    positions: Floats
    normals: Floats | None
    """``None``: every face is flat."""
    uv: Floats | None
    triangles: NDArray[np.int64]

    def with_uv(self, uv: Floats) -> Mesh:
        """The same triangles under another map."""
        return Mesh(self.positions, self.normals, uv, self.triangles)

    def split(self) -> Mesh:
        """Faces that share no vertices, with normals of their own: flat in programs that would smooth them."""
        if self.normals is not None:
            return self
        corners = self.positions[self.triangles]
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
        uv = None if self.uv is None else self.uv[self.triangles].reshape(-1, 2)
        count = 3 * len(self.triangles)
        return Mesh(corners.reshape(-1, 3), np.repeat(flat, 3, axis=0), uv, np.arange(count).reshape(-1, 3))

    def mirrored(self) -> Mesh:
        """Its mirror image in x, whose front is still the front."""
        flip = np.array([-1.0, 1.0, 1.0])
        normals = None if self.normals is None else self.normals * flip
        return Mesh(self.positions * flip, normals, self.uv, self.triangles[:, ::-1])

    def scaled(self, factor: float) -> Mesh:
        """The same in another unit."""
        return Mesh(self.positions * factor, self.normals, self.uv, self.triangles)


@dataclass(frozen=True, eq=False)
class Surface:
    """A shape of a scene: where a point of u, v lies."""

    kind: str
    keys: Mapping[str, Any]

    @property
    def repeats(self) -> bool:
        """Whether a map goes on beyond 0..1: a plane has no end."""
        return self.kind == "plane"

    def points(self, u: ArrayLike, v: ArrayLike) -> Floats:
        """World points; outside a disk's circle those of its plane."""
        u, v = (np.asarray(x, dtype=np.float64) for x in np.broadcast_arrays(u, v))
        if self.kind == "sphere":
            return _vector(self.keys["center"]) + float(self.keys["radius"]) * _direction(u, v)
        if self.kind == "rectangle":
            across, up = _vector(self.keys["u"]), _vector(self.keys["v"])
            return _vector(self.keys["center"]) + _out(2 * u - 1, across) + _out(2 * v - 1, up)
        if self.kind == "cylinder":
            side, axis, front = self.frame()
            turn = 2.0 * np.pi * (u - 0.5)
            radius, height = float(self.keys["radius"]), float(self.keys["height"])
            around = _out(radius * np.sin(turn), side) + _out(radius * np.cos(turn), front)
            return np.asarray(_vector(self.keys["center"]) + around + _out((v - 0.5) * height, axis))
        right, up, normal = self.frame()
        if self.kind == "plane":
            return _vector(self.keys["point"]) + _out(u - 0.5, right) + _out(v - 0.5, up)
        radius = float(self.keys["radius" if self.kind == "disk" else "aperture_radius"])
        x, y = radius * (2 * u - 1), radius * (2 * v - 1)
        points = _vector(self.keys["center"]) + _out(x, right) + _out(y, up)
        if self.kind == "cap":
            curvature = float(self.keys["radius_of_curvature"])
            square = np.minimum(x * x + y * y, curvature * curvature)
            sag = square / (abs(curvature) + np.sqrt(np.maximum(curvature * curvature - square, 0.0)))
            points = points - _out(np.sign(curvature) * sag, normal)
        return np.asarray(points)

    def frame(self) -> tuple[Floats, Floats, Floats]:
        """To the right and up, as who looks at the front sees them, and the normal; of a cylinder at u = 1/2."""
        if self.kind == "cylinder":
            axis = _unit(_vector(self.keys["axis"]))
            wanted = np.array([0.0, 1.0, 0.0] if np.hypot(axis[0], axis[1]) < _VERTICAL else [0.0, 0.0, 1.0])
            front = _unit(wanted - wanted @ axis * axis)
            return np.cross(axis, front), axis, front
        named = {"disk": "normal", "plane": "normal", "cap": "axis"}
        if self.kind == "rectangle":
            across, up = _vector(self.keys["u"]), _vector(self.keys["v"])
            normal = np.cross(across, up)
            return _unit(across), _unit(up), _unit(normal)
        normal = _unit(_vector(self.keys[named[self.kind]]))
        wanted = np.array([0.0, 0.0, -1.0] if np.hypot(normal[0], normal[2]) < _VERTICAL else [0.0, 1.0, 0.0])
        up = _unit(wanted - wanted @ normal * normal)
        return np.cross(up, normal), up, normal

    def normals(self, points: Floats) -> Floats:
        """Unit normals of the front at points of the shape."""
        if self.kind == "sphere":
            return (points - _vector(self.keys["center"])) / float(self.keys["radius"])
        if self.kind == "cylinder":
            axis, way = self.frame()[1], points - _vector(self.keys["center"])
            return np.asarray((way - _out(way @ axis, axis)) / float(self.keys["radius"]))
        normal = self.frame()[2]
        if self.kind == "cap":
            curvature = float(self.keys["radius_of_curvature"])
            return (points - self.middle_of_sphere()) / curvature
        return np.broadcast_to(normal, points.shape).copy()

    def middle_of_sphere(self) -> Floats:
        """The centre of the sphere that a cap or a sphere is part of."""
        center = _vector(self.keys["center"])
        if self.kind == "sphere":
            return center
        return np.asarray(center - float(self.keys["radius_of_curvature"]) * self.frame()[2])

    def span(self, along: Floats) -> tuple[float, float]:
        """The least and the greatest of ``along . p`` over its points."""
        if self.kind == "cap":
            far = self.mesh(fine=True).positions @ along
            return float(far.min()), float(far.max())
        size = float(np.linalg.norm(along))
        if self.kind == "sphere":
            half = size * float(self.keys["radius"])
        elif self.kind == "rectangle":
            half = abs(float(along @ _vector(self.keys["u"]))) + abs(float(along @ _vector(self.keys["v"])))
        else:
            axis = _unit(_vector(self.keys["axis" if self.kind == "cylinder" else "normal"]))
            across = np.sqrt(max(size**2 - float(along @ axis) ** 2, 0.0))
            half = float(self.keys["radius"]) * across
            if self.kind == "cylinder":
                half += 0.5 * float(self.keys["height"]) * abs(float(along @ axis))
        middle = float(along @ _vector(self.keys["center"]))
        return middle - half, middle + half

    def mesh(self, extent: float = 1.0, fine: bool = False) -> Mesh:
        """Triangles; ``extent``: half the side at which a plane, which has no end, is cut."""
        if self.kind == "sphere":
            return self._grid(*(4 * np.array(_SPHERE) if fine else _SPHERE))
        if self.kind == "rectangle":
            return self._grid(1, 1)
        if self.kind == "cylinder":
            return self._tube(4 * _TUBE if fine else _TUBE)
        if self.kind == "plane":
            sides = np.array([[0.5 - extent, 0.5 - extent], [0.5 + extent, 0.5 - extent], [0.5 + extent, 0.5 + extent]])
            uv = np.array([*sides, [0.5 - extent, 0.5 + extent]])
            points = self.points(uv[:, 0], uv[:, 1])
            return Mesh(points, self.normals(points), uv, np.array([[0, 1, 2], [0, 2, 3]]))
        return self._rings(*(4 * np.array(_DISK) if fine else _DISK))

    def _grid(self, columns: int, rows: int) -> Mesh:
        u, v = np.meshgrid(np.linspace(0.0, 1.0, columns + 1), np.linspace(0.0, 1.0, rows + 1))
        uv = np.stack([u.reshape(-1), v.reshape(-1)], axis=1)
        points = self.points(uv[:, 0], uv[:, 1])
        if self.kind in ("sphere", "cylinder"):  # a seam and poles that readers can weld: equal to the last bit
            grid = points.reshape(rows + 1, columns + 1, 3)
            grid[:, -1] = grid[:, 0]
            if self.kind == "sphere":
                grid[0], grid[-1] = grid[0, 0], grid[-1, 0]
        corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1)
        right, above = corner + 1, corner + columns + 1
        triangles = np.concatenate([np.stack([corner, right, above + 1], 1), np.stack([corner, above + 1, above], 1)])
        if self.kind == "sphere":  # triangles that shrink to a pole have no area and no normal
            flat = points[triangles]
            area = np.linalg.norm(np.cross(flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]), axis=1)
            triangles = triangles[area > 1e-9 * area.max()]
        return Mesh(points, self.normals(points), uv, triangles)

    def _tube(self, around: int) -> Mesh:
        side = self._grid(around, 1)
        if self.keys.get("open", True):
            return side
        assert side.uv is not None and side.normals is not None
        parts, axis = [side], self.frame()[1]
        center, height = _vector(self.keys["center"]), float(self.keys["height"])
        for v, sign in ((1.0, 1.0), (0.0, -1.0)):
            # A fan whose middle is there once for each triangle: u has no value on the axis.
            u = np.arange(around + 1) / around
            rim = side.positions[-(around + 1) :] if v else side.positions[: around + 1]
            middle = np.broadcast_to(center + sign * 0.5 * height * axis, (around, 3))
            uv = np.concatenate(
                [np.stack([u, np.full_like(u, v)], 1), np.stack([u[:-1] + 0.5 / around, np.full(around, v)], 1)]
            )
            here = np.arange(around)
            fan = np.stack([around + 1 + here, here, here + 1], axis=1)
            points = np.concatenate([rim, middle])
            normals = np.broadcast_to(sign * axis, points.shape)
            parts.append(Mesh(points, normals, uv, fan if sign > 0.0 else fan[:, ::-1]))
        return joined(parts)

    def _rings(self, around: int, rings: int) -> Mesh:
        angle = 2.0 * np.pi * np.arange(around) / around
        # Rings of a steep cap lie closer towards its rim.
        share = np.sin(0.5 * np.pi * np.arange(1, rings + 1) / rings) if self.kind == "cap" else np.array([1.0])
        x, y = share[:, None] * np.cos(angle), share[:, None] * np.sin(angle)
        uv = np.concatenate([[[0.5, 0.5]], np.stack([0.5 + x.reshape(-1) / 2, 0.5 + y.reshape(-1) / 2], axis=1)])
        points = self.points(uv[:, 0], uv[:, 1])
        here = np.arange(around)
        after = (here + 1) % around
        parts = [np.stack([np.zeros_like(here), 1 + here, 1 + after], axis=1)]
        for ring in range(1, len(share)):
            inner, outer = 1 + (ring - 1) * around, 1 + ring * around
            parts.append(np.stack([inner + here, outer + here, outer + after], axis=1))
            parts.append(np.stack([inner + here, outer + after, inner + after], axis=1))
        return Mesh(points, self.normals(points), uv, np.concatenate(parts))


def surface_of(shape: Mapping[str, Any]) -> Surface | None:
    """The shape of an object; ``None`` for one that this module cannot lay out."""
    ((kind, keys),) = shape.items()
    return Surface(kind, keys) if kind in ("sphere", "rectangle", "disk", "plane", "cap", "cylinder") else None


def joined(parts: list[Mesh]) -> Mesh:
    """One mesh of several; normals and u, v where all have them."""
    starts = np.cumsum([0, *(len(part.positions) for part in parts)])
    triangles = np.concatenate([part.triangles + start for part, start in zip(parts, starts[:-1], strict=True)])
    normals = [part.normals for part in parts if part.normals is not None]
    uv = [part.uv for part in parts if part.uv is not None]
    return Mesh(
        np.concatenate([part.positions for part in parts]),
        np.concatenate(normals) if len(normals) == len(parts) else None,
        np.concatenate(uv) if len(uv) == len(parts) else None,
        triangles,
    )


def globe(points: Floats, center: Floats) -> tuple[Floats, Floats]:
    """Longitude and latitude of points around a centre, as u and v."""
    x, y, z = np.moveaxis(points - center, -1, 0)
    return 0.5 + np.arctan2(x, z) / (2.0 * np.pi), 0.5 + np.arctan2(y, np.hypot(x, z)) / np.pi


def _direction(u: Floats, v: Floats) -> Floats:
    longitude, latitude = 2.0 * np.pi * (u - 0.5), np.pi * (v - 0.5)
    flat = np.cos(latitude)
    return np.stack([flat * np.sin(longitude), np.sin(latitude), flat * np.cos(longitude)], axis=-1)


def _vector(value: Any) -> Floats:
    return np.asarray(value, dtype=np.float64)


def _unit(value: Floats) -> Floats:
    return np.asarray(value / np.linalg.norm(value))


def _out(factor: ArrayLike, vector: Floats) -> Floats:
    return np.asarray(np.asarray(factor)[..., None] * vector)
