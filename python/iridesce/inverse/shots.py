"""What is asked of pictures of one film, and one picture ready to be asked. Internal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import checked_threads, number
from iridesce.inverse.model import Problem, read_problem
from iridesce.inverse.pictures import (
    Mask,
    Picture,
    clip_levels,
    corrected,
    lacks_numbers,
    read_mask,
    read_picture,
    strips,
)
from iridesce.inverse.views import LAMPS, ORDER_NM, Angles, View, film_index, read_angles, read_cameras, views

if TYPE_CHECKING:
    from iridesce.inverse.calibration import CameraCalibration

# Steps of the table, nm: no coarser, so that a parabola finds what lies between, and no finer than is of use.
_COARSEST_NM, _FINEST_NM = 4.0, 1.0
_MOST_THICKNESSES = 3000
_THICKEST_NM = 12_000.0
# Of a pixel's value, what the model does not know: indices, the cone of the lens, the curve of the camera. With a calibration
# of the same rig less.
_UNKNOWN, _UNKNOWN_CALIBRATED = 0.01, 0.005
_SHADING = 0.03
# And of the mean light, where a channel is dark: tables, stray light, and no camera is better than this.
_FLOOR = 2e-3
_OUTLIER = 1e-3


@dataclass(frozen=True)
class Setup:
    """What is asked of pictures of one film."""

    problem: Problem
    stack: Any
    calibration: CameraCalibration | None
    camera: Any
    illuminant: Any
    grid: Floats
    index_tolerance: float
    angle_tolerance_deg: float
    threads: int | None

    @property
    def index(self) -> float:
        """Of the film at 550 nm."""
        return film_index(self.problem)

    @property
    def quarter_nm(self) -> float:
        """Half an order."""
        return ORDER_NM / (4.0 * self.index)

    @property
    def steps(self) -> tuple[float, float]:
        """First thickness and step."""
        return float(self.grid[0]), float(self.grid[1] - self.grid[0])

    def views(self, angles: Floats) -> list[View]:
        """All that is tried."""
        if self.calibration is not None:
            return self.calibration._views(self.problem, self.grid, angles)
        lamps = list(LAMPS) if self.illuminant is None else [self.illuminant]
        return views(self.problem, read_cameras(self.camera), lamps, self.grid, angles)


@dataclass(frozen=True)
class Shot:
    """One picture, ready to be mapped."""

    picture: Picture
    usable: Mask
    levels: Floats
    noise: Floats
    """(3, 2): variance a + b value"""
    angles: Angles
    ties: list[tuple[int, float]]
    unknown: float

    @property
    def flat(self) -> npt.NDArray[np.float32]:
        """Pixels in a row."""
        return self.picture.pixels.reshape(-1, 3)

    def row(self, gain: float, haze: Sequence[float], kappa: float = 1.0, temper: float = 1.0) -> list[float]:
        """An exposure, as the core takes it."""
        largest = float(np.finfo(np.float32).max)
        clip = [float(value) if math.isfinite(value) else largest for value in self.levels]
        noise = [float(value) for value in (self.noise * kappa**2).reshape(-1)]
        cut = float(self.picture.cut_at_zero)
        return [gain, *haze, *noise, self.unknown * kappa, _SHADING, *clip, cut, temper, _OUTLIER]

    def sample(self, most: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float32], npt.NDArray[np.uint8] | None]:
        """Places, pixels and tables of pixels spread evenly (steps of the golden ratio)."""
        places = np.flatnonzero(self.usable.reshape(-1))
        count = min(most, places.size)
        golden = (np.arange(count) * 0.6180339887498949) % 1.0 if count < places.size else np.arange(count) / count
        places = places[np.unique((golden * places.size).astype(np.int64))]
        tables = None if self.angles.table_of is None else np.ascontiguousarray(self.angles.table_of[places])
        return places, np.ascontiguousarray(self.flat[places]), tables


def read_setup(
    stack: Any,
    calibration: Any,
    camera: Any,
    illuminant: Any,
    thickness_range_nm: Any,
    index_tolerance: Any,
    angle_tolerance_deg: Any,
    threads: Any,
) -> Setup:
    """Checks what is common to all pictures of one film."""
    problem = read_problem(stack, None, None, "reflectance", 0.0, "unpolarized")
    if len(problem.unknown) != 1:
        raise refusal(
            "stack",
            "one unknown thickness for a photograph (three numbers a pixel)",
            Words(len(problem.unknown)),
            must="have",
        )
    if calibration is not None:
        from iridesce.inverse.calibration import CameraCalibration

        if not isinstance(calibration, CameraCalibration):
            calibration = CameraCalibration.load(calibration)
        if camera is not None or illuminant is not None:
            raise complaint(
                "calibration stands for camera and illuminant: give it or them",
                "camera" if camera is not None else "illuminant",
                "left out beside a calibration",
                Words("both"),
            )
    return Setup(
        problem,
        stack,
        calibration,
        camera,
        illuminant,
        _grid(thickness_range_nm),
        number("index_tolerance", index_tolerance, low=0.0, high=1.0),
        number("angle_tolerance_deg", angle_tolerance_deg, low=0.0, high=90.0),
        checked_threads(threads),
    )


def _grid(given: Any) -> Floats:
    try:
        low, high = plain_reals("thickness_range_nm", given, "(low, high) in nm").tolist()
    except (TypeError, ValueError):
        raise refusal("thickness_range_nm", "(low, high) in nm", given) from None
    if not 0.0 <= low < high <= _THICKEST_NM:
        raise refusal("thickness_range_nm", f"0 <= low < high <= {_THICKEST_NM:g}", Words(f"({low:g}, {high:g})"))
    span = high - low
    count = int(np.clip(500, math.ceil(span / _COARSEST_NM) + 1, max(math.ceil(span / _FINEST_NM), 16) + 1))
    return np.linspace(low, high, min(count, _MOST_THICKNESSES))


def take(
    setup: Setup,
    image: Any,
    angle_deg: Any,
    noise: Any,
    mask: Any,
    flat: Any,
    dark: Any,
    tie_points: Any,
    clip: Any,
) -> Shot:
    """Checks what belongs to one picture, and measures its noise."""
    picture = corrected(read_picture(image), flat, dark)
    angles = read_angles(angle_deg, picture.shape, setup.index)
    usable = ~lacks_numbers(picture.pixels) & ~read_mask(mask, picture.shape)
    if angles.factor is not None:
        usable &= np.isfinite(angles.factor).reshape(picture.shape)
    if not usable.any():
        raise complaint(
            "mask (or NaN) leaves no pixel of the picture",
            "mask",
            "one that leaves pixels of the picture",
            Words("all masked"),
        )
    found: list[str] = []
    levels = clip_levels(picture, usable, clip, found)
    picture = replace(picture, notes=(*picture.notes, *found))
    unknown = _UNKNOWN if setup.calibration is None else _UNKNOWN_CALIBRATED
    ties = _ties(tie_points, picture.shape)
    return Shot(picture, usable, levels, _noise(picture, usable, noise), angles, ties, unknown)


def _noise(picture: Picture, usable: Mask, given: Any) -> Floats:
    if given is not None:
        sd = plain_reals("noise", given, "one number or three, finite and > 0")
        if sd.shape not in ((), (3,)) or not (np.isfinite(sd).all() and (sd > 0.0).all()):
            raise refusal("noise", "one number or three, finite and > 0", given)
        return np.stack([np.broadcast_to(sd, (3,)) ** 2, np.zeros(3)], axis=1)
    skipped = np.ascontiguousarray(~usable.reshape(-1))
    found = np.asarray(_core.picture_noise(picture.pixels.reshape(-1, 3), picture.shape[1], skipped))
    total = 0.0
    for part in strips(picture.pixels):
        light = np.abs(picture.pixels[part])
        total += float(np.sum(light, where=np.isfinite(light) & usable[part][..., None], dtype=np.float64))
    size = total / picture.pixels.size
    # Steps may hide all other noise.
    found = np.maximum(found, np.asarray(picture.step))
    found[:, 0] = np.maximum(found[:, 0], max((_FLOOR * size) ** 2, 1e-18))
    return np.asarray(found)


def _ties(points: Any, shape: tuple[int, int]) -> list[tuple[int, float]]:
    found = []
    for point in () if points is None else points:
        try:
            x, y, nm = plain_reals("tie_points", point, "a list of (x, y, nm)").tolist()
        except (TypeError, ValueError):
            raise refusal("tie_points", "a list of (x, y, nm)", point) from None
        if not (0.0 <= x <= shape[1] - 1 and 0.0 <= y <= shape[0] - 1 and math.isfinite(nm) and nm >= 0.0):
            raise complaint(
                f"a tie point must lie in the picture of {shape[1]} x {shape[0]} pixels, with nm >= 0, got {point!r:.60}",
                "tie_points",
                f"in the picture of {shape[1]} x {shape[0]} pixels, with nm >= 0",
                point,
            )
        found.append((round(y) * shape[1] + round(x), nm))
    return found
