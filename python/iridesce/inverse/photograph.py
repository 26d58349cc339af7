"""Thickness of every pixel of a photograph of a film: the likeliest one, how sure its order is, what else it could be."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce._progress import Tell, Told, check_progress, watched
from iridesce.arguments.operands import Floats
from iridesce.arguments.scalars import checked_threads, number
from iridesce.inverse.maps import ANCHORS, ThicknessResult
from iridesce.inverse.model import Problem, read_problem
from iridesce.inverse.pictures import Mask, Picture, clip_levels, corrected, read_mask, read_picture
from iridesce.inverse.views import LAMPS, ORDER_NM, Angles, View, film_index, read_angles, read_cameras, views

if TYPE_CHECKING:
    from iridesce.color import Camera
    from iridesce.inverse.calibration import CameraCalibration

__all__ = ["map_thickness"]

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
# Pixels by which the exposure is found, where all cameras and lamps are tried and where one is left.
_COARSE, _SAMPLED = 512, 2048
# Relative sd of the scale: camera and lamp named; one of them tried; both.
_SCALE = (0.006, 0.02, 0.03)
# Doubt: misfit (residuals over what they should be) and bias (what residuals of one thickness have in common, over their noise).
_MISFIT, _BIAS = 3.0, 0.5
_DOUBT = 0.9
_SCALE_IN_DOUBT = 0.02
# A picture whose mean light is below this many sd of its noise is dark; one that varies less than this many is of one colour.
_DIM, _VARIED = 4.0, 5.0
# A tie point is worth so many pixels where exposures are compared.
_TIED = 30.0
# Other exposures, cameras and lamps that are held against the best one.
_RIVALS = 8


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
class Exposed:
    """A view with the gain and haze that suit a picture."""

    view: View
    gain: float
    haze: tuple[float, float, float]
    cost: float
    misfit: float
    bias: float


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


def map_thickness(
    image: Any,
    stack: Any,
    *,
    calibration: CameraCalibration | str | os.PathLike[str] | None = None,
    camera: str | os.PathLike[str] | Camera | None = None,
    illuminant: Any = None,
    angle_deg: npt.ArrayLike = 0.0,
    thickness_range_nm: Sequence[float] = (0.0, 2000.0),
    noise: npt.ArrayLike | None = None,
    mask: npt.ArrayLike | None = None,
    flat: Any = None,
    dark: Any = None,
    tie_points: Sequence[tuple[float, float, float]] | None = None,
    index_tolerance: float = 0.0,
    angle_tolerance_deg: float = 0.0,
    clip: float | Sequence[float] | None = None,
    threads: int | None = None,
    progress: Told = None,
) -> ThicknessResult:
    """The thickness of a film at every pixel of a photograph.

    picture = gain * channels of the film + haze + noise. The gain, common to all channels, and the haze of each are fitted to
    the picture, the shading of each pixel (3 %) is integrated out. Every thickness that a pixel could have is kept, and what
    neighbours along rows and columns say of each is summed by forward and backward passes; errors that neighbours share are
    measured and count once. Channels that are full, or cut at 0, say only on which side they are.

    image          linear channels (h, w, 3), an `Image`, or a file: OpenEXR, NPY, TIFF (16 bit: linear), PNG and JPEG (by their
                   profile, else sRGB)
    stack          with one unknown layer, as for `fit_thickness`: "air / soap ? / air"
    calibration    `CameraCalibration` of the same rig, or its file; camera and illuminant are then not needed
    camera         a name of `iridesce.color.cameras`, "srgb" (a camera balanced for the lamp), "xyz", a file of sensitivities, a
                   `Camera`, or None: all of these names, and what cameras are like, are tried
    illuminant     as for `iridesce.color.illuminant`; None: daylight, tungsten, fluorescent and LED lamps are tried
    angle_deg      angle of incidence in the first medium, one number or one a pixel, >= 0 and < 90    () or (h, w)
    thickness_range_nm  (low, high), up to 12 000
    noise          standard deviation of the picture's numbers, one or one a channel; None: measured
    mask           True: left out, NaN in the answer                                                   (h, w)
    flat, dark     pictures of a white surface and without light: (image - dark) / (flat - dark)
    tie_points     (x, y, nm): pixels whose thickness is known; the order of all that hangs together with them follows
    index_tolerance, angle_tolerance_deg  standard deviations (the first relative): they widen scale and intervals
    clip           level, one or three, from which on a channel counts as full; None: found
    threads        worker threads, 1 to 1024; None: all cores. The answer does not depend on it
    progress       called as ``progress(done, total)``, or ``progress(done, total, stage=...)``; True: a bar
    Returns        `ThicknessResult`
    Raises         ValueError: no picture, no film with one unknown, an unknown camera or lamp, a wrong shape; ResourceError:
                   too many pixels
    Source         docs/guide/photographs.md

    >>> import iridesce as ir
    >>> found = ir.map_thickness(np.zeros((16, 16, 3)), "air / soap ? / air", camera="srgb", illuminant="D65")
    >>> found.sure, found.notes[0]
    (0.0, 'the picture is dark: its numbers are noise, nothing can be told')
    """
    check_progress(progress)
    setup = read_setup(
        stack,
        calibration,
        camera,
        illuminant,
        thickness_range_nm,
        index_tolerance,
        angle_tolerance_deg,
        threads,
    )
    shot = take(setup, image, angle_deg, noise, mask, flat, dark, tie_points, clip)
    with watched(progress, "mapping") as tell:
        tables = setup.views(shot.angles.angle_deg)
        return solve(setup, shot, tables, tell)[0]


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
        raise ValueError(
            f"stack must have one unknown thickness for a photograph (three numbers a pixel), got {len(problem.unknown)}"
        )
    if calibration is not None:
        from iridesce.inverse.calibration import CameraCalibration

        if not isinstance(calibration, CameraCalibration):
            calibration = CameraCalibration.load(calibration)
        if camera is not None or illuminant is not None:
            raise ValueError("calibration stands for camera and illuminant: give it or them")
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
        low, high = (float(value) for value in given)
    except (TypeError, ValueError):
        raise ValueError(f"thickness_range_nm must be (low, high) in nm, got {given!r:.60}") from None
    if not 0.0 <= low < high <= _THICKEST_NM:
        raise ValueError(f"thickness_range_nm must be 0 <= low < high <= {_THICKEST_NM:g}, got ({low:g}, {high:g})")
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
    usable = ~np.isnan(picture.pixels).any(axis=2) & ~read_mask(mask, picture.shape)
    if angles.factor is not None:
        usable &= np.isfinite(angles.factor).reshape(picture.shape)
    if not usable.any():
        raise ValueError("mask (or NaN) leaves no pixel of the picture")
    found: list[str] = []
    levels = clip_levels(picture, usable, clip, found)
    picture = replace(picture, notes=(*picture.notes, *found))
    unknown = _UNKNOWN if setup.calibration is None else _UNKNOWN_CALIBRATED
    ties = _ties(tie_points, picture.shape)
    return Shot(picture, usable, levels, _noise(picture, usable, noise), angles, ties, unknown)


def _noise(picture: Picture, usable: Mask, given: Any) -> Floats:
    if given is not None:
        try:
            sd = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError):
            sd = np.zeros(0)
        if sd.shape not in ((), (3,)) or not (np.isfinite(sd).all() and (sd > 0.0).all()):
            raise ValueError(f"noise must be one number or three, finite and > 0, got {given!r:.60}")
        return np.stack([np.broadcast_to(sd, (3,)) ** 2, np.zeros(3)], axis=1)
    skipped = np.ascontiguousarray(~usable.reshape(-1))
    found = np.asarray(_core.picture_noise(picture.pixels.reshape(-1, 3), picture.shape[1], skipped))
    known = np.where(np.isfinite(picture.pixels) & usable[..., None], picture.pixels, 0.0)
    size = float(np.abs(known).mean())
    # Steps may hide all other noise.
    found = np.maximum(found, np.asarray(picture.step))
    found[:, 0] = np.maximum(found[:, 0], max((_FLOOR * size) ** 2, 1e-18))
    return np.asarray(found)


def _ties(points: Any, shape: tuple[int, int]) -> list[tuple[int, float]]:
    found = []
    for point in () if points is None else points:
        try:
            x, y, nm = (float(value) for value in point)
        except (TypeError, ValueError):
            raise ValueError(f"tie_points must be a list of (x, y, nm), got {point!r:.60}") from None
        if not (0.0 <= x <= shape[1] - 1 and 0.0 <= y <= shape[0] - 1 and math.isfinite(nm) and nm >= 0.0):
            raise ValueError(
                f"a tie point must lie in the picture of {shape[1]} x {shape[0]} pixels, with nm >= 0, got {point!r:.60}"
            )
        found.append((round(y) * shape[1] + round(x), nm))
    return found


def solve(
    setup: Setup,
    shot: Shot,
    tables: list[View],
    tell: Tell | None,
    before: tuple[Exposed, ThicknessResult, float] | None = None,
) -> tuple[ThicknessResult, Exposed]:
    """Exposure, neighbours, map, doubt. ``before``: exposure and answer of the frame before, and its mean step, nm."""
    verdict = _nothing(setup, shot)
    if verdict is not None:
        return verdict, before[0] if before is not None else Exposed(tables[0], 1.0, (0.0, 0.0, 0.0), 0.0, 1.0, 0.0)
    rivals = exposures(setup, shot, tables if before is None else [before[0].view], tell)
    best = rivals[0]
    kappa = float(np.clip(best.misfit, 1.0, 5.0))
    height, width = shot.picture.shape
    skipped = np.ascontiguousarray(~shot.usable.reshape(-1))
    first, step = setup.steps
    common = (shot.flat, width, shot.angles.table_of, skipped, best.view.channels, first, step)
    row = shot.row(best.gain, best.haze, kappa)
    temper, across, down, grows = _core.picture_neighbourhood(*common, row, setup.quarter_nm, setup.threads)
    row = shot.row(best.gain, best.haze, kappa, temper)
    prior = None if before is None else _prior(before[1], before[2])
    nm, sd, confidence, candidates, weights, anchors, taken = _core.picture_thickness(
        *common, row, (temper, across, down), setup.quarter_nm, shot.ties, prior, setup.threads, tell
    )
    notes = [*shot.picture.notes]
    notes += [
        f"no film of {tie[1]:g} nm suits the pixel of its tie point"
        for tie, ok in zip(shot.ties, taken, strict=True)
        if not ok
    ]
    known = np.isfinite(nm)
    confidence = np.where(known, confidence * _agreed(setup, shot, rivals, nm, temper, notes), np.nan).astype(
        np.float32
    )
    if shot.ties:
        tied = anchors == ANCHORS.index("tie point")
        confidence[tied] = np.maximum(confidence[tied], 0.98)
    scale = _scale(setup, shot)
    doubts = _doubts(best, grows)
    if doubts:
        notes += doubts
        confidence = np.minimum(confidence, np.float32(_DOUBT))
        scale = math.hypot(scale, _SCALE_IN_DOUBT)
    if shot.angles.factor is not None:
        nm, sd = nm * shot.angles.factor, sd * shot.angles.factor
        candidates = candidates * shot.angles.factor[:, None]
    reach = np.float32(1.96) * np.hypot(sd, np.float32(scale) * nm)
    shape = (height, width)
    counts = np.bincount(anchors[known], minlength=len(ANCHORS)) if known.any() else np.array([1, 0, 0, 0])
    weights[~np.isfinite(candidates)] = np.nan
    result = ThicknessResult(
        nm.reshape(shape),
        confidence.reshape(shape),
        np.maximum(nm - reach, 0.0).reshape(shape),
        (nm + reach).reshape(shape),
        candidates.reshape(*shape, -1),
        weights.reshape(*shape, -1),
        (1.0 - 1.96 * scale, 1.0 + 1.96 * scale),
        ANCHORS[int(counts.argmax())],
        anchors.reshape(shape),
        tuple(notes),
        {
            "camera": best.view.camera,
            "illuminant": best.view.illuminant,
            "balance": best.view.balance,
            "gain": best.gain,
            "haze": list(best.haze),
            "noise": [float(v) for v in np.sqrt(shot.noise[:, 0])],
            "clip": [float(v) if math.isfinite(v) else None for v in shot.levels],
            "temper": float(temper),
            "slope_nm": [float(across), float(down)],
            "misfit": best.misfit,
            "bias": best.bias,
        },
    )
    return result, best


def _prior(before: ThicknessResult, reach_nm: float) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], float]:
    """Thickness and confidence of the frame before, none where there was no answer."""
    known = np.isfinite(before.thickness_nm)
    nm = np.where(known, before.thickness_nm, 0.0).astype(np.float32).reshape(-1)
    return nm, np.where(known, before.confidence, 0.0).astype(np.float32).reshape(-1), max(reach_nm, 1.0)


def _nothing(setup: Setup, shot: Shot) -> ThicknessResult | None:
    """The answer to a picture that says nothing: dark, full, or of one colour throughout."""
    pixels = shot.picture.pixels[shot.usable]
    full = (pixels >= shot.levels).all(axis=1)
    why = ""
    seen = pixels[~full & np.isfinite(pixels).all(axis=1)]
    level = np.maximum(seen.mean(axis=0), 0.0) if seen.size else np.zeros(3)
    sd = np.sqrt(shot.noise[:, 0] + shot.noise[:, 1] * level)
    if full.mean() > 0.98 or not seen.size:
        why = "all pixels are full: nothing can be told"
    elif not (np.abs(seen.mean(axis=0)) > _DIM * sd / math.sqrt(min(seen.shape[0], 100))).any() or not seen.any():
        why = "the picture is dark: its numbers are noise, nothing can be told"
    elif (
        np.percentile(seen, 97.5, axis=0) - np.percentile(seen, 2.5, axis=0)
        < _VARIED * np.hypot(sd, 0.003 * seen.mean(axis=0))
    ).all():
        why = "all pixels have one colour: gain and haze cannot be told from the film, nothing can be told"
    if not why:
        return None
    shape = shot.picture.shape
    none = np.full(shape, np.nan, dtype=np.float32)
    several = np.full((*shape, 4), np.nan, dtype=np.float32)
    scale = _scale(setup, shot)
    confidence = np.where(shot.usable, np.float32(0.0), none)
    return ThicknessResult(
        none,
        confidence,
        none,
        none,
        several,
        several,
        (1.0 - 1.96 * scale, 1.0 + 1.96 * scale),
        "none",
        np.zeros(shape, dtype=np.uint8),
        (why, *shot.picture.notes),
        {"camera": None, "illuminant": None, "noise": [float(v) for v in sd]},
    )


def exposures(setup: Setup, shot: Shot, tables: list[View], tell: Tell | None) -> list[Exposed]:
    """The exposures that suit the picture, best first: of all views by few pixels, of those that are left by more."""
    left = list(tables)
    if len(left) > 4:
        order = np.argsort([one[0].cost for one in _expose(setup, shot, left, _COARSE, tell)], kind="stable")
        left = [left[i] for i in order[:4]]
    found = [one for starts in _expose(setup, shot, left, _SAMPLED, None) for one in starts]
    if shot.ties:
        # An exposure in which a pixel cannot be what it is known to be is none.
        found = [replace(one, cost=one.cost + _untied(setup, shot, one)) for one in found]
    return sorted(found, key=lambda one: one.cost)


def _untied(setup: Setup, shot: Shot, one: Exposed) -> float:
    """What it costs that the pixels of tie points are of other orders."""
    places = np.array([place for place, _ in shot.ties])
    nm = np.array([nm for _, nm in shot.ties], dtype=np.float32)
    of = None if shot.angles.table_of is None else np.ascontiguousarray(shot.angles.table_of[places])
    first, step = setup.steps
    row = shot.row(one.gain, one.haze, max(one.misfit, 1.0))
    pixels = np.ascontiguousarray(shot.flat[places])
    mass = _core.picture_agreement(pixels, of, one.view.channels, first, step, row, nm, setup.quarter_nm)
    return float(-_TIED * np.log(np.maximum(np.nan_to_num(mass), 1e-6)).sum())


def _expose(setup: Setup, shot: Shot, tables: list[View], most: int, tell: Tell | None) -> list[list[Exposed]]:
    _, pixels, of = shot.sample(most)
    channels = np.stack([view.channels for view in tables])
    first, step = setup.steps
    base = shot.row(1.0, (0.0, 0.0, 0.0))
    rows = _core.picture_exposures(pixels, of, channels, first, step, base, setup.threads, tell)
    return [
        [Exposed(view, g, (r, gr, b), cost, misfit, bias) for g, r, gr, b, cost, misfit, bias in starts.tolist()]
        for view, starts in zip(tables, rows, strict=True)
    ]


def _agreed(
    setup: Setup, shot: Shot, rivals: list[Exposed], nm: npt.NDArray[np.float32], temper: float, notes: list[str]
) -> Any:
    """By thickness, with which probability other exposures, cameras and lamps that suit the picture give the same order."""
    best = rivals[0]
    # Costs count in units of the misfit that even the best one leaves.
    weight = [math.exp(-(one.cost - best.cost) / max(best.misfit, 1.0) ** 2) for one in rivals]
    chosen: list[tuple[Exposed, float]] = []
    for one, share in zip(rivals, weight, strict=True):
        close = any(
            one.view is other.view
            and abs(one.gain / other.gain - 1.0) < 0.02
            and max(abs(a - b) for a, b in zip(one.haze, other.haze, strict=True))
            < 0.02 * max(other.haze[0], other.gain * 0.05)
            for other, _ in chosen
        )
        if share > 1e-3 and not close and len(chosen) < _RIVALS:
            chosen.append((one, share))
    if len(chosen) == 1:
        return np.float32(1.0)
    places, pixels, of = shot.sample(_SAMPLED)
    first, step = setup.steps
    near = np.nan_to_num(nm[places], nan=first).astype(np.float32)
    masses = []
    for one, _ in chosen:
        row = shot.row(one.gain, one.haze, max(best.misfit, 1.0), temper)
        masses.append(_core.picture_agreement(pixels, of, one.view.channels, first, step, row, near, setup.quarter_nm))
    shares = np.array([share for _, share in chosen])
    shares /= shares.sum()
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.minimum(np.stack(masses) / np.maximum(masses[0], 1e-6), 1.0)
    agreed = np.tensordot(shares, np.nan_to_num(ratio, nan=0.0), axes=1)
    bins = np.clip(((near - first) / setup.quarter_nm).astype(int), 0, 200)
    count = np.bincount(bins, minlength=201)
    mean = np.bincount(bins, agreed, minlength=201) / np.maximum(count, 1)
    mean[count == 0] = float(agreed.mean())
    others = {f"{one.view.camera} under {one.view.illuminant}" for one, _ in chosen[1:]} - {
        f"{best.view.camera} under {best.view.illuminant}"
    }
    if others:
        notes.append("not excluded: " + ", ".join(sorted(others)))
    if mean.min() < 0.9:
        notes.append("other exposures suit the picture as well, and give other orders in part of it")
    of_pixel = np.clip(((np.nan_to_num(nm, nan=first) - first) / setup.quarter_nm).astype(int), 0, 200)
    return mean.astype(np.float32)[of_pixel]


def _doubts(best: Exposed, grows: bool) -> list[str]:
    """Why no order of the picture is sure."""
    found = []
    if best.misfit > _MISFIT:
        found.append(f"the best camera and lamp leave {best.misfit:.2g} times the noise")
    if best.bias > _BIAS:
        found.append(f"pixels of one thickness miss the model by {best.bias:.2g} of their noise, all alike")
    if grows:
        found.append("errors of neighbours hang together over the whole picture")
    words = "; ".join(found)
    return (
        [f"{words}: another lamp, camera or stack, a tone curve or local tone mapping; no order is sure"]
        if found
        else []
    )


def _scale(setup: Setup, shot: Shot) -> float:
    """Relative standard deviation of what is common to all thicknesses."""
    if setup.calibration is not None:
        own = setup.calibration.scale_sd
    else:
        own = _SCALE[(setup.camera is None) + (setup.illuminant is None)]
    angle = np.radians(float(np.mean(shot.angles.angle_deg)))
    inside = math.asin(min(math.sin(angle) / setup.index, 1.0))
    # d theta_2 = d theta cos theta / (n cos theta_2), and at right angles the second order alone.
    turned = math.radians(setup.angle_tolerance_deg)
    tilt = math.tan(inside) * turned * math.cos(angle) / (setup.index * math.cos(inside))
    tilt = math.hypot(tilt, 0.5 * (turned / setup.index) ** 2)
    return math.sqrt(own**2 + setup.index_tolerance**2 + tilt**2)
