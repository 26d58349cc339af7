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
from .film import film_powers
from .spectra import Light

# The radiance of unit directions, or one for all of them.
Environment = Callable[[NDArray[np.float64]], NDArray[np.float64]] | float
CHUNK = 1024  # rays worked on at a time: 1024 rays x 471 wavelengths x 2 polarisations stay near the cache
EXACT = 1e-12  # what is still under way below this share of the light is left out
PICTURE = 1e-3  # the same for a picture; a lossless remainder is then given the light of where it is going


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


def radiance_of(environment: Environment, direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """The light of directions (..., 3)."""
    return environment(direction) if callable(environment) else np.full(direction.shape[:-1], float(environment))


def _trace(
    sphere: FilmSphere,
    rays: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    environment: Environment,
    inside: bool,
    light: Light,
    step: float,
) -> NDArray[np.float64]:
    """XYZ (rays, 3) of rays (origin, direction, distance to the first hit) that hit, all from one side."""
    origin, direction, distance = rays
    center = np.asarray(sphere.center)
    place = origin + distance[:, None] * direction
    outward = unit(place - center)
    cosine = np.clip(np.abs(np.sum(direction * outward, axis=-1)), 0.0, 1.0)
    index = sphere.index_at(light.wavelength_nm)
    film = film_powers(index, cosine, light.wavelength_nm)
    total = np.zeros((len(place), len(light.wavelength_nm)))
    under_way = np.full((2, *total.shape), 0.5)  # the unpolarised half and half, times what has happened so far
    if inside:
        hit, going = outward, direction
    else:
        reflectance, transmittance = film.at(sphere.thickness_nm(place[:, 1]))
        mirrored = direction + 2.0 * cosine[:, None] * outward
        total += np.sum(under_way * reflectance, axis=0) * radiance_of(environment, mirrored)[:, None]
        under_way *= transmittance
        hit, going = outward + 2.0 * cosine[:, None] * direction, direction
    active = np.arange(len(place))
    even = sphere.top_nm == sphere.bottom_nm  # the same film at the same angle: nothing changes from hit to hit
    reflectance, transmittance = film.at(sphere.thickness_nm(center[1] + sphere.radius * hit[:, 1]))
    if even and not callable(environment):
        # The same share of the same light at every hit: a geometric series.
        total += environment * np.sum(under_way * transmittance / (1.0 - reflectance), axis=0)
        return total @ light.weights
    while len(active):
        if not even:
            reflectance, transmittance = film.at(sphere.thickness_nm(center[1] + sphere.radius * hit[:, 1]))
        total[active] += np.sum(under_way * transmittance, axis=0) * radiance_of(environment, going)[:, None]
        under_way *= reflectance
        keep = under_way.max(axis=(0, 2)) > step
        # mirror the direction at the inside of the sphere, then cross the next chord (unit radius)
        turned = unit(going - 2.0 * np.sum(going * hit, axis=-1)[:, None] * hit)
        hit = unit(hit + 2.0 * cosine[active][:, None] * turned)
        going = turned
        if keep.all():
            continue
        if not np.iscomplexobj(index):
            total[active[~keep]] += under_way[:, ~keep].sum(axis=0) * radiance_of(environment, turned[~keep])[:, None]
        active, under_way, hit, going = active[keep], under_way[:, keep], hit[keep], turned[keep]
        film, reflectance, transmittance = film.of(keep), reflectance[:, keep], transmittance[:, keep]
    return total @ light.weights


def radiance_xyz(
    sphere: FilmSphere,
    origin: NDArray[np.float64],
    direction: NDArray[np.float64],
    environment: Environment,
    light: Light | None = None,
    step: float = EXACT,
) -> NDArray[np.float64]:
    """XYZ (rays, 3) along rays (rays, 3); ``environment``: the light around, ``light``: its spectrum."""
    light = light or spectra.lamp()
    hits, distance, inside = sphere.first_hit(origin, direction)
    xyz = radiance_of(environment, direction)[:, None] * light.weights.sum(axis=0)
    chosen = np.flatnonzero(hits)
    for start in range(0, len(chosen), CHUNK):
        part = chosen[start : start + CHUNK]
        xyz[part] = _trace(sphere, (origin[part], direction[part], distance[part]), environment, inside, light, step)
    return xyz


def picture(
    sphere: FilmSphere, camera: dict[str, Any], environment: Environment, light: Light | None = None, points: int = 2
) -> NDArray[np.float64]:
    """(height, width, 3) XYZ, each pixel averaged over its square.

    ``points`` x ``points`` Gauss-Legendre places away from the limb, 4 x 4 within two pixels of it.
    A pixel that the limb crosses is cut along it: radiance there goes with the square root of the distance to it.
    """
    width, height = camera["resolution"]
    row, column = (a.ravel() for a in np.mgrid[0:height, 0:width])
    # The short cut is for many wavelengths of a film that loses nothing: light still caught by an absorbing one is not
    # on its way anywhere, and of a few lines none averages out the guess about another.
    lossless = not np.iscomplexobj(sphere.index_at((light or spectra.lamp()).wavelength_nm))
    step = PICTURE if lossless and len((light or spectra.lamp()).wavelength_nm) > 100 else 1e-7

    def radiance(chosen: NDArray[np.bool_], dx: Any, dy: Any) -> NDArray[np.float64]:
        """XYZ (places, pixels, 3) for offsets (places, 1) or (places, pixels)."""
        places = np.broadcast_arrays(column[chosen] + dx, row[chosen] + dy)
        origin, direction = camera_rays(camera, *(p.ravel() for p in places))
        xyz = radiance_xyz(sphere, origin, direction, environment, light, step)
        return xyz.reshape(*places[0].shape, 3)

    def hits(chosen: NDArray[np.bool_], dx: Any, dy: Any) -> NDArray[np.bool_]:
        return sphere.first_hit(*camera_rays(camera, column[chosen] + dx, row[chosen] + dy))[0]

    everywhere = np.ones(len(row), dtype=bool)
    near = [hits(everywhere, dx, dy) for dx in (-2, 0, 1, 3) for dy in (-2, 0, 1, 3)]
    crossed = np.zeros(len(row), dtype=bool)
    corners = [near[i] for i in (5, 6, 9, 10)]
    crossed = np.any(corners, axis=0) & ~np.all(corners, axis=0)
    close = np.any(near, axis=0) & ~np.all(near, axis=0) & ~crossed

    xyz = np.zeros((height * width, 3))
    for chosen, side in ((~crossed & ~close, points), (close, 4)):
        dx, dy, weight = pixel_places(side)
        xyz[chosen] = np.tensordot(weight, radiance(chosen, dx[:, None], dy[:, None]), 1)
    # Lines run along the picture axis that meets the limb more squarely.
    slope = [
        sum(c * sign for c, sign in zip(corners, signs, strict=True)) for signs in ((-1, -1, 1, 1), (-1, 1, -1, 1))
    ]
    along_columns = crossed & (np.abs(slope[0]) >= np.abs(slope[1]))
    for chosen, swap in ((along_columns, False), (crossed & ~along_columns, True)):
        if chosen.any():
            xyz[chosen] = _cut_pixels(chosen, swap, radiance, hits)
    return xyz.reshape(height, width, 3)


def _cut_pixels(chosen: NDArray[np.bool_], swap: bool, radiance: Any, hits: Any, lines: int = 4) -> NDArray[np.float64]:
    """Mean over pixels that the limb crosses: along each line the two sides of the limb are taken apart."""
    count = int(chosen.sum())
    node, weight = np.polynomial.legendre.leggauss(lines)
    node, weight = (node + 1.0) / 2.0, weight / 2.0
    across = np.repeat(node[:, None], count, axis=1)  # (lines, pixels)

    def hit(along: Any) -> NDArray[np.bool_]:
        places = (across, along) if swap else (along, across)
        return np.stack([hits(chosen, *pair) for pair in zip(*np.broadcast_arrays(*places), strict=True)])

    begins, ends = hit(0.0), hit(1.0)
    low, high = np.zeros_like(across), np.ones_like(across)
    for _ in range(40):  # where hitting changes along the line
        middle = (low + high) / 2.0
        same = hit(middle) == begins
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    limb = np.where(begins == ends, np.where(begins, 0.0, 1.0), high)
    far = np.where(ends | (begins & ends), 1.0, 0.0)  # the sphere lies between the limb and this end of the line
    total = np.zeros((count, 3))
    for start, end, power in ((limb, far, 2), (limb, 1.0 - far, 1)):
        # u^2 on the sphere's side: equal steps of u are equal steps of the cosine there
        along = start + (end - start) * node[:, None, None] ** power
        share = weight[:, None, None] * power * node[:, None, None] ** (power - 1) * np.abs(end - start)
        places = np.broadcast_arrays(across, along)
        dx, dy = (p.reshape(-1, count) for p in (places if swap else places[::-1]))
        total += np.sum(((share * weight[:, None]).reshape(-1, count))[..., None] * radiance(chosen, dx, dy), axis=0)
    return total
