"""What films look like to cameras under lamps: the tables in which a photograph is looked up. Internal."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.color import Camera, camera, cameras, convert, illuminant
from iridesce.color.camera_tables import typical_cameras
from iridesce.color.light import Illuminant, color_matching
from iridesce.errors import ArgumentError
from iridesce.inverse.model import Problem
from iridesce.optics.wavelengths import SPECTRUM_NM, in_steps

# The order of a film is told at this wavelength, nm.
ORDER_NM = 550.0
# Lamps that are tried where none is named.
LAMPS = ("D65", "D50", "A", "FL2", "FL11", "LED-B1", "LED-B3")
_LOW_NM, _HIGH_NM = SPECTRUM_NM
# Samples a fringe of the thickest film at the shortest wavelength.
_SAMPLES = 6.0
# Channels whose balance differs by less are balanced.
_BALANCED = 0.03
# Bins of sin(angle)**2 in a picture with an angle for each pixel, and their least width.
_MOST_ANGLES = 120
_ANGLE_STEP = 0.004


@dataclass(frozen=True)
class View:
    """A camera under a lamp: channels of every film at every angle."""

    camera: str
    illuminant: str
    balance: str
    """"white": each channel over that of a white surface; "none": as the camera sees it."""
    channels: npt.NDArray[np.float32]
    """(angles, 3, thicknesses)"""


@dataclass(frozen=True)
class Angles:
    """Angles of the tables, which of them each pixel takes, and by what its thickness is then to be multiplied."""

    angle_deg: Floats
    table_of: npt.NDArray[np.uint8] | None
    factor: npt.NDArray[np.float32] | None


def read_angles(given: Any, shape: tuple[int, int], index: float) -> Angles:
    """Even steps of sin**2, in which a film's path is nearly even; within a step the path sets the thickness."""
    # Before they are numbers of 64 bits: an array of another picture may be large.
    if np.shape(given) not in ((), shape):
        raise refusal("angle_deg", f"one number or one a pixel {shape}", Words(f"shape {np.shape(given)}"))
    angle = plain_reals("angle_deg", given, "one number or one a pixel")
    finite = np.isfinite(angle)
    if not finite.any() or (angle[finite] < 0.0).any() or (angle[finite] >= 90.0).any():
        worst = angle[finite & ((angle < 0.0) | (angle >= 90.0))]
        raise refusal("angle_deg", ">= 0 and < 90", Words(f"{(float(worst[0]) if worst.size else float('nan')):g}"))
    if angle.shape == ():
        return Angles(angle.reshape(1), None, None)
    square = np.sin(np.radians(np.where(finite, angle, 0.0))) ** 2
    low, high = float(square[finite].min()), float(square[finite].max())
    bins = int(np.clip(np.ceil((high - low) / _ANGLE_STEP), 1, _MOST_ANGLES))
    edges = np.linspace(low, high + 1e-12, bins + 1)
    middles = 0.5 * (edges[1:] + edges[:-1])
    place = np.clip(np.searchsorted(edges, square, side="right") - 1, 0, bins - 1)
    factor = np.sqrt((index**2 - middles[place]) / (index**2 - square))
    return Angles(
        np.degrees(np.arcsin(np.sqrt(middles))),
        np.ascontiguousarray(place.reshape(-1), dtype=np.uint8),
        np.where(finite, factor, np.nan).astype(np.float32).reshape(-1),
    )


def film_index(problem: Problem) -> float:
    """Real index of the unknown layer at 550 nm."""
    medium = problem.stack.layers[problem.unknown[0]].medium
    return max(float(np.real(medium.index(ORDER_NM, extrapolate="hold"))), 1.0)


def wavelengths(thickest_nm: float, index: float) -> Floats:
    """5 nm apart, or as fine as the fringes of the thickest film ask for."""
    finest = _LOW_NM**2 / (2.0 * index * thickest_nm) / _SAMPLES
    step = next((step for step in (5.0, 2.5, 2.0, 1.0) if step <= finest), 0.5)
    return in_steps(SPECTRUM_NM, step)


def reflectances(problem: Problem, grid: Floats, angles: Floats, nm: Floats) -> Floats:
    """(angles, thicknesses, wavelengths)"""
    stack = problem.with_thickness([grid[:, None]])
    return np.stack([np.asarray(stack.reflectance(nm, float(angle))) for angle in angles])


def views(
    problem: Problem, cameras_: Sequence[tuple[str, Camera | str]], lamps: Sequence[Any], grid: Floats, angles: Floats
) -> list[View]:
    """Every camera under every lamp, balanced and not."""
    nm = wavelengths(float(grid[-1]), film_index(problem))
    lights = [illuminant(lamp) for lamp in lamps]
    lines = np.unique([line for light in lights for line, _ in light.lines if _LOW_NM <= line <= _HIGH_NM])
    every = np.concatenate([nm, lines])
    spectra = reflectances(problem, grid, angles, every).astype(np.float32)
    found = []
    for light in lights:
        power = _power(light, nm, lines)
        if not power.max(initial=0.0) > 0.0:
            raise complaint(
                f"illuminant {light.name!r} has no light from {_LOW_NM:g} to {_HIGH_NM:g} nm",
                "illuminant",
                f"a lamp with light from {_LOW_NM:g} to {_HIGH_NM:g} nm",
                light.name,
            )
        for name, one in cameras_:
            response = sensitivity(one, every) * power[:, None]
            found += of_response(name, light.name, response, spectra)
    return found


def of_response(name: str, lamp: str, response: Floats, spectra: npt.NDArray[np.float32]) -> list[View]:
    """Views of a response (wavelengths, 3): each channel over its white, and as it is."""
    white = response.sum(axis=0)
    if not (white > 0.0).all():
        return []  # a channel without light
    channels = np.einsum("ahl,lc->ach", spectra, (response / white).astype(np.float32))
    found = [View(name, lamp, "white", np.ascontiguousarray(channels))]
    balance = white / white.mean()
    if np.abs(balance - 1.0).max() > _BALANCED:
        raw = channels * balance.astype(np.float32)[:, None]
        found.append(View(name, lamp, "none", np.ascontiguousarray(raw)))
    return found


def _power(light: Illuminant, nm: Floats, lines: Floats) -> Floats:
    """Weights of the wavelengths and lines: power per nm times the step, power of a line."""
    of_line = dict(light.lines)
    step = float(nm[1] - nm[0])
    power = np.asarray(light.power(nm), dtype=np.float64) * step
    return np.concatenate([power, [of_line.get(float(line), 0.0) for line in lines]])


def sensitivity(one: Camera | str, nm: Floats) -> Floats:
    """(wavelengths, 3)"""
    if isinstance(one, Camera):
        return np.asarray(one.at(nm))
    xyz = np.asarray(color_matching(nm, "cie1931"), dtype=np.float64)
    return xyz if one == "xyz" else np.asarray(convert(xyz, "xyz", "linear-srgb"))


def read_cameras(given: Any) -> list[tuple[str, Camera | str]]:
    """What a user names, or all that are tried."""
    if given is None:
        known: list[tuple[str, Camera | str]] = [(name, camera(name)) for name in cameras()]
        return [*known, ("srgb", "srgb"), *((one.name, one) for one in typical_cameras())]
    if isinstance(given, str) and given.lower() in ("srgb", "xyz"):
        return [(given.lower(), given.lower())]
    try:
        one = camera(given)
    except ArgumentError as error:
        allowed = error.allowed.replace("one of ", 'None, "srgb", "xyz", one of ')
        raise complaint(str(error).replace(error.allowed, allowed), "camera", allowed, given) from None
    return [(one.name if isinstance(given, str | os.PathLike | Camera) else str(given), one)]
