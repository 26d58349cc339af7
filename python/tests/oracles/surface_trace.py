"""Rays through lenses, plates and coated bodies, one wavelength at a time, every branch followed.

Nothing is shared with the renderer but the laws: each face is told what lies before and behind it (no nesting of media
is kept), a stack of layers is summed by Airy's recursion from below (no characteristic matrices), and polarisation is
carried by 3 x 3 field matrices (Yun, Crabtree & Chipman, Appl. Opt. 50, 2855 (2011); no Stokes vectors).

Light is the radiance over n^2, which refraction leaves as it is: that is what the scene's numbers state.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .camera import camera_rays, pixel_places, unit

Vector = NDArray[np.float64]
Index = complex | Callable[[float], complex]
NEAR = 1e-9  # a hit closer than this is the one just left, scene units


def at(index: Index, nm: float) -> complex:
    """The index at a wavelength, of a number or a function of it."""
    return complex(index(nm)) if callable(index) else complex(index)


# ---- faces ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Round:
    """A sphere, or the part of it for which (place - vertex) . axis >= -depth (a cap)."""

    center: tuple[float, float, float]
    radius: float
    axis: tuple[float, float, float] | None = None
    rim: float = 0.0  # least height over the centre along the axis

    def hits(self, origin: Vector, direction: Vector) -> list[float]:
        relative = origin - np.asarray(self.center)
        along = float(relative @ direction)
        miss = relative - along * direction
        reach = self.radius**2 - float(miss @ miss)
        if reach <= 0.0:
            return []
        half = float(np.sqrt(reach))
        both = [-along - half, -along + half]
        if self.axis is None:
            return both
        return [d for d in both if float((relative + d * direction) @ np.asarray(self.axis)) >= self.rim]

    def normal(self, place: Vector) -> Vector:
        return unit(place - np.asarray(self.center))


@dataclass(frozen=True)
class Flat:
    """A plane through ``point``, within ``radius`` of it or within the box ``half`` (world x, y, z)."""

    point: tuple[float, float, float]
    facing: tuple[float, float, float]
    radius: float = np.inf
    half: tuple[float, float, float] | None = None

    def hits(self, origin: Vector, direction: Vector) -> list[float]:
        across = float(direction @ np.asarray(self.facing))
        if across == 0.0:
            return []
        distance = float((np.asarray(self.point) - origin) @ np.asarray(self.facing)) / across
        off = origin + distance * direction - np.asarray(self.point)
        if float(off @ off) > self.radius**2:
            return []
        if self.half is not None and bool(np.any(np.abs(off) > np.asarray(self.half) + 1e-9)):
            return []
        return [distance]

    def normal(self, place: Vector) -> Vector:
        return unit(np.asarray(self.facing, dtype=float))


@dataclass(frozen=True)
class Face:
    """A surface: ``front`` is the medium on the side of the normal, ``back`` the other; layers stand from the front.

    ``emits`` is a radiance, by wavelength or one number: such a face ends a path. ``opaque``: what passes is absorbed.
    """

    shape: Round | Flat
    front: Index = 1.0
    back: Index = 1.0
    layers: tuple[tuple[Index, float], ...] = ()
    emits: float | Callable[[float], float] | None = None
    opaque: bool = False


# ---- amplitudes -------------------------------------------------------------------------------------------------------


def stack_amplitudes(indices: Sequence[complex], thickness_nm: Sequence[float], cosine: float, nm: float) -> Any:
    """(r_s, r_p, t_s, t_p) of electric fields through layers; t is scaled so that |t|^2 is the transmitted power.

    From the last face up: r = (f + g e) / (1 + f g e), t = (1 + f) t' sqrt(e) / (1 + f g e) with the face's own f, what
    lies below g, and e = exp(4 pi i n d cos / lambda).
    """
    n = [complex(v) for v in indices]
    sine = n[0] * np.sqrt(1.0 - cosine**2 + 0j)
    q = [np.sqrt(v * v - sine * sine + 0j) for v in n]  # n cos; principal root: Im >= 0 for n + ik
    q[0] = n[0] * cosine
    out = []
    for p_light in (False, True):

        def face(i: int, p_light: bool = p_light) -> tuple[complex, complex]:
            if not p_light:
                below = q[i] + q[i + 1]
                return (q[i] - q[i + 1]) / below, 2.0 * q[i] / below
            a, b = n[i + 1] ** 2 * q[i], n[i] ** 2 * q[i + 1]
            return (a - b) / (a + b), 2.0 * n[i] * n[i + 1] * q[i] / (a + b)

        r, t = face(len(n) - 2)
        for i in range(len(n) - 3, -1, -1):
            f, through = face(i)
            half = np.exp(2j * np.pi * q[i + 1] * thickness_nm[i] / nm)
            r, t = (f + r * half * half) / (1.0 + f * r * half * half), through * t * half / (1.0 + f * r * half * half)
        last, first = q[-1], q[0]
        # power along the normal: Re(n cos) for s, Re(conj(n) cos) for p
        power = (np.conj(n[-1]) * last / n[-1]).real if p_light else last.real
        out.append((r, t * np.sqrt(max(power, 0.0) / first.real)))
    (r_s, t_s), (r_p, t_p) = out
    return r_s, r_p, t_s, t_p


# ---- the walk ---------------------------------------------------------------------------------------------------------


@dataclass
class SurfaceTracer:
    """Radiance along rays; ``environment`` is a number or a function of direction. ``left_out`` bounds what is dropped."""

    faces: Sequence[Face]
    environment: float | Callable[[Vector], float] = 1.0
    depth: int = 12
    threshold: float = 1e-5
    polarised: bool = True
    nm_per_unit: float = 1e7  # scenes in cm
    left_out: float = field(default=0.0, init=False)

    def nearest(self, origin: Vector, direction: Vector) -> tuple[float, Face] | None:
        best: tuple[float, Face] | None = None
        for face in self.faces:
            for distance in face.shape.hits(origin, direction):
                if distance > NEAR and (best is None or distance < best[0]):
                    best = (distance, face)
        return best

    def radiance(self, origin: Vector, direction: Vector, nm: float) -> float:
        """Light of one wavelength that arrives along a ray, unpolarised light all around being given."""
        total, dropped = 0.0, 0.0
        start: Any = np.eye(3, dtype=complex) if self.polarised else 1.0
        stack = [(np.asarray(origin, dtype=float), unit(direction), start, 0)]
        while stack:
            place, ray, chain, hits = stack.pop()
            share = _unpolarised(chain, ray) if self.polarised else chain
            if hits > self.depth or share < self.threshold:
                dropped += share
                continue
            found = self.nearest(place, ray)
            if found is None:
                total += share * (self.environment(ray) if callable(self.environment) else self.environment)
                continue
            distance, face = found
            place = place + distance * ray
            outward = face.shape.normal(place)
            from_front = float(ray @ outward) < 0.0
            facing = outward if from_front else -outward
            before, beyond = (face.front, face.back) if from_front else (face.back, face.front)
            n0, n1 = at(before, nm), at(beyond, nm)
            passed = np.exp(-4.0 * np.pi * n0.imag * distance / nm * self.nm_per_unit)
            chain, share = chain * (np.sqrt(passed) if self.polarised else passed), share * passed
            if face.emits is not None:
                total += share * (face.emits(nm) if callable(face.emits) else face.emits)
                continue
            layers = face.layers if from_front else face.layers[::-1]
            cosine = -float(ray @ facing)
            mirrored = ray + 2.0 * cosine * facing
            bend = n0.real / n1.real
            cosine2 = 1.0 - bend**2 * (1.0 - cosine**2)
            indices = [n0.real, *(at(index, nm) for index, _ in layers), n1 if face.opaque else n1.real]
            r_s, r_p, t_s, t_p = stack_amplitudes(indices, [d for _, d in layers], min(cosine, 1.0), nm)
            branches = [(mirrored, r_s, r_p)]
            if cosine2 > 0.0 and not face.opaque:
                bent = unit(bend * ray + (bend * cosine - np.sqrt(cosine2)) * facing)
                branches.append((bent, t_s, t_p))
            across = np.cross(ray, facing)
            s = unit(across) if np.linalg.norm(across) > 1e-12 else unit(np.cross(ray, [0.3, -0.5, 0.8]))
            for onward, a_s, a_p in branches:
                if self.polarised:
                    # light comes along -onward and leaves along -ray, towards the camera
                    p_in, p_out = np.cross(-onward, s), np.cross(-ray, s)
                    step: Any = chain @ (a_s * np.outer(s, s) + a_p * np.outer(p_out, p_in))
                else:
                    step = chain * 0.5 * (abs(a_s) ** 2 + abs(a_p) ** 2)
                stack.append((place, onward, step, hits + 1))
        self.left_out = max(self.left_out, dropped)
        return total

    def picture(self, camera: dict[str, Any], wavelengths_nm: Sequence[float], points: int = 2) -> NDArray[np.float64]:
        """(height, width, wavelengths) of radiance, each pixel averaged over ``points`` x ``points`` places."""
        width, height = camera["resolution"]
        out = np.zeros((height, width, len(wavelengths_nm)))
        for row in range(height):
            for column in range(width):
                for dx, dy, weight in zip(*pixel_places(points), strict=True):
                    origin, direction = camera_rays(camera, column + dx, row + dy)
                    for i, nm in enumerate(wavelengths_nm):
                        out[row, column, i] += weight * self.radiance(origin, direction, nm)
        return out


def _unpolarised(chain: NDArray[Any], ray: Vector) -> float:
    """Share of the power of unpolarised light that arrives against ``ray``'s own start, whatever its fields are."""
    # chain maps fields of light coming along -ray (far end) to the camera; rows of a dead field give nothing
    first = unit(np.cross(ray, [1.0, 0.0, 0.0] if abs(ray[0]) < 0.7 else [0.0, 1.0, 0.0]))
    fields = np.stack([first, np.cross(ray, first)], axis=-1)
    return float(0.5 * np.sum(np.abs(chain @ fields) ** 2))
