"""Polarised light through many film spheres with 3 x 3 field matrices, every branch followed.

Every film hit maps the electric field of a plane wave in world coordinates (Yun, Crabtree & Chipman, Appl. Opt. 50,
2855 (2011), "Three-dimensional polarization ray-tracing calculus I"):

    reflection     M = r_s s s^T + r_p p_out p_in^T          s = unit(k_in x n), p = k x s
    transmission   M = t_s s s^T + t_p p p^T

No Stokes vector and no frame to turn appears anywhere. Paths are found from the camera backwards; along each the
matrices are multiplied in the order in which light meets them, camera side leftmost. Unpolarised light is two
orthogonal fields of half the power each. Different paths add their powers.

``polarised=False`` takes the mean of s and p at every hit: what a renderer without polarisation finds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import spectra
from .camera import camera_rays, pixel_places, unit
from .film import Amplitudes, film_amplitudes
from .film_sphere import FilmSphere

Environment = Callable[[NDArray[np.float64]], NDArray[np.float64]]
Vector = NDArray[np.float64]
NEAR = 1e-9  # a hit closer than this is the one just left, scene units


def cross(a: Vector, b: Vector) -> Vector:
    """The cross product of two vectors. (`numpy.cross` spends most of its time on shapes.)"""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def times(chain: NDArray[Any], columns: Vector) -> NDArray[Any]:
    """Matrices (471, 3, n) times one matrix (n, m): one product of a tall matrix, where ``@`` would take 471 small ones."""
    return (chain.reshape(-1, len(columns)) @ columns).reshape(len(chain), -1, columns.shape[1])


@dataclass(frozen=True)
class Meeting:
    """What a film does to the fields of one direction: a_s s s^T + a_p p_out p_in^T."""

    a_s: NDArray[Any]
    a_p: NDArray[Any]
    s: Vector
    p_in: Vector
    p_out: Vector

    def matrix(self) -> NDArray[Any]:
        """(471, 3, 3)."""
        across, along = np.outer(self.s, self.s), np.outer(self.p_out, self.p_in)
        return self.a_s[:, None, None] * across + self.a_p[:, None, None] * along

    def before(self, chain: NDArray[Any]) -> NDArray[Any]:
        """``chain @ matrix()``, by the two directions that the matrix is made of."""
        parts = times(chain, np.stack([self.s, self.p_out], axis=-1))
        parts *= np.stack([self.a_s, self.a_p], axis=-1)[:, None, :]
        return times(parts, np.stack([self.s, self.p_in]))


def film_meetings(amplitudes: Amplitudes, k_in: Vector, normal: Vector) -> tuple[Meeting, Meeting, Vector]:
    """Reflection and transmission of light along ``k_in``; the mirrored direction."""
    cosine = float(k_in @ normal)
    mirrored = k_in - 2.0 * cosine * normal
    across = cross(k_in, normal)
    # at normal incidence any s will do: r_p = -r_s and p_out = -p_in make the result the same for all
    s = unit(across) if np.linalg.norm(across) > 1e-12 else unit(cross(k_in, [0.3, -0.5, 0.8]))
    p_in, p_out = cross(k_in, s), cross(mirrored, s)
    reflection = Meeting(amplitudes.r_s, amplitudes.r_p, s, p_in, p_out)
    return reflection, Meeting(amplitudes.t_s, amplitudes.t_p, s, p_in, p_in), mirrored


def film_matrices(amplitudes: Amplitudes, k_in: Vector, normal: Vector) -> tuple[NDArray[Any], NDArray[Any], Vector]:
    """Field matrices (471, 3, 3) of reflection and transmission of light along ``k_in``; the mirrored direction."""
    reflection, transmission, mirrored = film_meetings(amplitudes, k_in, normal)
    return reflection.matrix(), transmission.matrix(), mirrored


def power_of_unpolarised(chain: NDArray[Any], k: Vector) -> NDArray[np.float64]:
    """Share of the power of unpolarised light along ``k`` that gets through ``chain`` (471, 3, 3)."""
    first = unit(cross(k, [1.0, 0.0, 0.0] if abs(k[0]) < 0.7 else [0.0, 1.0, 0.0]))
    fields = times(chain, np.stack([first, cross(k, first)], axis=-1))
    return 0.5 * np.sum(fields.real**2 + fields.imag**2, axis=(-2, -1))


def stokes_of_unpolarised(chain: NDArray[Any], k: Vector, leaving: Vector, upright: Vector) -> NDArray[np.float64]:
    """Stokes vector (471, 4) of what unpolarised light along ``k`` becomes in ``chain``, where it comes along ``leaving``.

    With s the camera's upright and p = leaving x s: S1 = |E_s|^2 - |E_p|^2, S3 = 2 Im(E_s conj(E_p)), and since p points to
    the left of the picture S2 = -2 Re(E_s conj(E_p)) is positive at 45 degrees clockwise.
    """
    first = unit(cross(k, [1.0, 0.0, 0.0] if abs(k[0]) < 0.7 else [0.0, 1.0, 0.0]))
    fields = times(chain, np.stack([first, cross(k, first)], axis=-1))
    s = unit(np.asarray(upright) - leaving * float(leaving @ upright))
    e_s, e_p = np.einsum("i,wij->wj", s, fields), np.einsum("i,wij->wj", cross(leaving, s), fields)
    mixed = e_s * np.conj(e_p)
    parts = (
        np.abs(e_s) ** 2 + np.abs(e_p) ** 2,
        np.abs(e_s) ** 2 - np.abs(e_p) ** 2,
        -2.0 * mixed.real,
        2.0 * mixed.imag,
    )
    return 0.5 * np.stack([part.sum(axis=-1) for part in parts], axis=-1)


@dataclass
class Tracer:
    """Traces camera rays to ``depth`` hits; ``left_out`` is the largest share of light not followed."""

    spheres: Sequence[FilmSphere]
    environment: Environment
    depth: int = 8
    polarised: bool = True
    threshold: float = 1e-6
    left_out: float = 0.0

    def nearest(self, origin: Vector, direction: Vector) -> tuple[float, FilmSphere] | None:
        """The closest hit ahead."""
        best: tuple[float, FilmSphere] | None = None
        for sphere in self.spheres:
            relative = origin - sphere.center
            along = float(relative @ direction)
            miss = relative - along * direction
            reach = sphere.radius**2 - float(miss @ miss)
            if reach <= 0.0:
                continue
            for distance in (-along - math.sqrt(reach), -along + math.sqrt(reach)):
                if distance > NEAR and (best is None or distance < best[0]):
                    best = (float(distance), sphere)
        return best

    def xyz(self, origin: Vector, direction: Vector) -> NDArray[np.float64]:
        """XYZ (3,) of one camera ray."""
        return self.spectrum(origin, direction)[:, 0] @ spectra.xyz_weights()

    def spectrum(self, origin: Vector, direction: Vector, upright: Vector | None = None) -> NDArray[np.float64]:
        """Share of the environment's light by wavelength, (471, 1); with the camera's upright its Stokes vector, (471, 4)."""
        count = len(spectra.WAVELENGTH_NM)
        start = np.broadcast_to(np.eye(3, dtype=complex), (count, 3, 3)) if self.polarised else np.ones(count)
        spectrum = np.zeros((count, 1 if upright is None else 4))
        dropped = 0.0
        stack = [(np.asarray(origin, dtype=float), unit(direction), start, 0)]
        while stack:
            place, ray, chain, hits = stack.pop()
            if upright is not None:
                share = stokes_of_unpolarised(chain, -ray, -unit(direction), upright)
            else:
                share = (power_of_unpolarised(chain, -ray) if self.polarised else chain)[:, None]
            found = self.nearest(place, ray)
            if found is None:
                spectrum += share * float(self.environment(ray))
                continue
            if hits == self.depth or share[:, 0].max() < self.threshold:
                dropped += float(share[:, 0].max())
                continue
            distance, sphere = found
            place = place + distance * ray
            normal = unit(place - np.asarray(sphere.center))
            cosine = abs(float(ray @ normal))
            thickness_nm = sphere.thickness_nm(place[1:2])
            film = film_amplitudes(sphere.index_at(spectra.WAVELENGTH_NM), thickness_nm, cosine, spectra.WAVELENGTH_NM)
            mirrored = ray - 2.0 * float(ray @ normal) * normal
            if self.polarised:
                # light comes along -mirrored (or -ray) and leaves along -ray, towards the camera
                reflection, _, leaving = film_meetings(film, -mirrored, normal)
                assert np.abs(leaving + ray).max() < 1e-8
                transmission = film_meetings(film, -ray, normal)[1]
                stack.append((place, mirrored, reflection.before(chain), hits + 1))
                stack.append((place, ray, transmission.before(chain), hits + 1))
            else:
                reflectance = (np.abs(film.r_s) ** 2 + np.abs(film.r_p) ** 2) / 2.0
                transmittance = (np.abs(film.t_s) ** 2 + np.abs(film.t_p) ** 2) / 2.0
                stack.append((place, mirrored, chain * reflectance, hits + 1))
                stack.append((place, ray, chain * transmittance, hits + 1))
        self.left_out = max(self.left_out, dropped)
        return spectrum

    def picture(self, camera: dict[str, Any], points: int = 2) -> NDArray[np.float64]:
        """(height, width, 3) XYZ, each pixel averaged over ``points`` x ``points`` Gauss-Legendre places."""
        width, height = camera["resolution"]
        xyz = np.zeros((height, width, 3))
        for row in range(height):
            for column in range(width):
                for dx, dy, weight in zip(*pixel_places(points), strict=True):
                    origin, direction = camera_rays(camera, column + dx, row + dy)
                    xyz[row, column] += weight * self.xyz(origin, direction)
        return xyz


@dataclass(frozen=True)
class Bounce:
    """One reflection of a chain: a film, its angle, and how far its plane is turned from the one before."""

    index: Any
    thickness_nm: float
    angle_deg: float
    turn_deg: float
    radius: float = 1.0


def chain_of_spheres(bounces: Sequence[Bounce], gap: float = 3.0) -> tuple[list[FilmSphere], dict[str, Any], Vector]:
    """Spheres placed so that a ray from (0, 0, 8) along -z is mirrored by each in turn.

    Returns the spheres, a camera (without resolution and field of view) that looks along that ray, and the direction in
    which the ray leaves the last sphere. ``turn_deg`` of the first bounce turns its plane from the y axis.
    """
    place, ray = np.array([0.0, 0.0, 8.0]), np.array([0.0, 0.0, -1.0])
    sideways = np.array([0.0, 1.0, 0.0])  # in the plane of incidence, across the ray
    spheres = []
    camera = {"position": place.tolist(), "target": [0.0, 0.0, 0.0], "up": [0.0, 1.0, 0.0]}
    distance = 8.0 - 1.0
    for bounce in bounces:
        turn, theta = np.radians(bounce.turn_deg), np.radians(bounce.angle_deg)
        sideways = np.cos(turn) * sideways + np.sin(turn) * np.cross(ray, sideways)
        place = place + distance * ray
        normal = -np.cos(theta) * ray + np.sin(theta) * sideways
        center = place - bounce.radius * normal
        spheres.append(
            FilmSphere(
                bounce.index,
                bounce.thickness_nm,
                bounce.thickness_nm,
                center=tuple(center.tolist()),
                radius=bounce.radius,
            )
        )
        mirrored = unit(ray - 2.0 * (ray @ normal) * normal)
        # the new in-plane direction across the ray, on the same side of the plane of incidence
        sideways = unit(np.cross(np.cross(ray, sideways), mirrored))
        ray, distance = mirrored, gap
    return spheres, camera, ray
