"""The closed form of a lone film sphere.

A ray that meets the sphere at the angle theta meets it again and again at that same angle and in one plane, for outside
and inside are the same medium and a film does not bend what passes it. So s and p never mix, every inner hit turns
place and direction by pi - 2 theta, and the radiance towards the camera is

    L = R_0 L_env(mirrored) + T_0 sum_j [prod_{0 < i < j} R_i] T_j L_env(d_j),    averaged over s and p,

where R_i, T_i take the thickness at hit i's own height. From a camera inside, T_0 = 1 and the mirrored part is missing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import spectra
from .camera import camera_rays, pixel_places, unit
from .film import film_amplitudes, film_powers
from .spectra import Light

Environment = Callable[[NDArray[np.float64]], NDArray[np.float64]]
CHUNK = 1024  # rays worked on at a time: 1024 rays x 471 wavelengths x 2 polarisations stay near the cache
STEP = 1e-12  # what is still under way below this share of the light is left out


@dataclass(frozen=True)
class FilmSphere:
    """A sphere with a film; ``index`` is a number, complex if it absorbs, or a function of the wavelength in nm."""

    index: complex | Callable[[NDArray[np.float64]], NDArray[np.float64]]
    top_nm: float
    bottom_nm: float
    exponent: float = 1.0
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radius: float = 1.0

    def thickness_nm(self, y: NDArray[np.float64]) -> NDArray[np.float64]:
        """bottom + (top - bottom) s^exponent, s the relative height."""
        share = np.clip((y - self.center[1] + self.radius) / (2.0 * self.radius), 0.0, 1.0)
        return self.bottom_nm + (self.top_nm - self.bottom_nm) * share**self.exponent

    def index_at(self, wavelength_nm: NDArray[np.float64]) -> Any:
        """The index at each wavelength, or the one number for all."""
        return self.index(wavelength_nm) if callable(self.index) else self.index

    def powers(
        self, y: NDArray[np.float64], cosine: NDArray[np.float64], wavelength_nm: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """R and T, each (2, rays, n), for hits at heights ``y`` (rays,) and ``wavelength_nm`` (n,)."""
        arguments = (self.thickness_nm(y)[:, None], cosine[:, None], wavelength_nm)
        index = self.index_at(wavelength_nm)
        if np.iscomplexobj(index):
            a = film_amplitudes(index, *arguments)
            return np.abs(np.stack([a.r_s, a.r_p])) ** 2, np.abs(np.stack([a.t_s, a.t_p])) ** 2
        reflectance = film_powers(np.asarray(index, dtype=float), *arguments)
        return reflectance, 1.0 - reflectance

    def first_hit(
        self, origin: NDArray[np.float64], direction: NDArray[np.float64]
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64], bool]:
        """Which rays hit, at what distance, and whether the camera stands inside (all rays or none)."""
        relative = origin - np.asarray(self.center)
        along = np.sum(relative * direction, axis=-1)
        # |relative - along direction|^2 from the vector itself: b^2 - c would lose digits far away
        miss = np.sum((relative - along[:, None] * direction) ** 2, axis=-1)
        reach = self.radius**2 - miss
        inside = bool(np.all(np.sum(relative**2, axis=-1) < self.radius**2))
        half = np.sqrt(np.maximum(reach, 0.0))
        distance = -along + half if inside else -along - half
        return (reach > 0.0) & (distance > 0.0), distance, inside


def _trace(
    sphere: FilmSphere,
    rays: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    environment: Environment,
    inside: bool,
    light: Light,
) -> NDArray[np.float64]:
    """XYZ (rays, 3) of rays (origin, direction, distance to the first hit) that hit, all from one side."""
    origin, direction, distance = rays
    center = np.asarray(sphere.center)
    place = origin + distance[:, None] * direction
    outward = unit(place - center)
    cosine = np.clip(np.abs(np.sum(direction * outward, axis=-1)), 0.0, 1.0)
    total = np.zeros((len(place), len(light.wavelength_nm)))
    under_way = np.full((2, *total.shape), 0.5)  # the unpolarised half and half, times what has happened so far
    if inside:
        hit, going = outward, direction
    else:
        reflectance, transmittance = sphere.powers(place[:, 1], cosine, light.wavelength_nm)
        mirrored = direction + 2.0 * cosine[:, None] * outward
        total += np.sum(under_way * reflectance, axis=0) * environment(mirrored)[:, None]
        under_way *= transmittance
        hit, going = outward + 2.0 * cosine[:, None] * direction, direction
    active = np.arange(len(place))
    while len(active):
        height = center[1] + sphere.radius * hit[:, 1]
        reflectance, transmittance = sphere.powers(height, cosine[active], light.wavelength_nm)
        total[active] += np.sum(under_way * transmittance, axis=0) * environment(going)[:, None]
        under_way = under_way * reflectance
        keep = under_way.max(axis=(0, 2)) > STEP
        # mirror the direction at the inside of the sphere, then cross the next chord (unit radius)
        turned = unit(going - 2.0 * np.sum(going * hit, axis=-1)[:, None] * hit)
        hit = unit(hit + 2.0 * cosine[active][:, None] * turned)
        active, under_way, hit, going = active[keep], under_way[:, keep], hit[keep], turned[keep]
    return total @ light.weights


def radiance_xyz(
    sphere: FilmSphere,
    origin: NDArray[np.float64],
    direction: NDArray[np.float64],
    environment: Environment,
    light: Light | None = None,
) -> NDArray[np.float64]:
    """XYZ (rays, 3) along rays (rays, 3); ``environment``: radiance of unit directions, ``light``: its spectrum."""
    light = light or spectra.lamp()
    hits, distance, inside = sphere.first_hit(origin, direction)
    xyz = environment(direction)[:, None] * light.weights.sum(axis=0)
    chosen = np.flatnonzero(hits)
    for start in range(0, len(chosen), CHUNK):
        part = chosen[start : start + CHUNK]
        xyz[part] = _trace(sphere, (origin[part], direction[part], distance[part]), environment, inside, light)
    return xyz


def picture(
    sphere: FilmSphere,
    camera: dict[str, Any],
    environment: Environment,
    light: Light | None = None,
    points: int = 3,
    limb_points: int = 10,
) -> NDArray[np.float64]:
    """(height, width, 3) XYZ, each pixel averaged over its square by Gauss-Legendre sub-points.

    Pixels that the limb crosses take ``limb_points`` a side, the others ``points``.
    """
    width, height = camera["resolution"]
    row, column = (a.ravel() for a in np.mgrid[0:height, 0:width])
    corner_row, corner_column = (a.ravel() for a in np.mgrid[0 : height + 1, 0 : width + 1])
    corner_hits = sphere.first_hit(*camera_rays(camera, corner_column, corner_row))[0].reshape(height + 1, width + 1)
    count = corner_hits[:-1, :-1] * 1 + corner_hits[1:, :-1] + corner_hits[:-1, 1:] + corner_hits[1:, 1:]
    crossed = ((count > 0) & (count < 4)).ravel()
    xyz = np.zeros((height * width, 3))
    for chosen, side in ((~crossed, points), (crossed, limb_points)):
        for dx, dy, weight in zip(*pixel_places(side), strict=True):
            origin, direction = camera_rays(camera, column[chosen] + dx, row[chosen] + dy)
            xyz[chosen] += weight * radiance_xyz(sphere, origin, direction, environment, light)
    return xyz.reshape(height, width, 3)
