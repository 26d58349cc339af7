"""Thickness of every pixel of a photograph of a film: the likeliest one, how sure its order is, what else it could be."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce._progress import Tell, Told, check_progress, watched
from iridesce.inverse.exposures import Exposed, agreed, doubts, exposures
from iridesce.inverse.maps import ANCHORS, ThicknessResult
from iridesce.inverse.pictures import Mask, strips
from iridesce.inverse.shots import Setup, Shot, read_setup, take
from iridesce.inverse.views import View

if TYPE_CHECKING:
    from iridesce.color import Camera
    from iridesce.inverse.calibration import CameraCalibration

__all__ = ["map_thickness"]

# Relative sd of the scale: camera and lamp named; one of them tried; both.
_SCALE = (0.006, 0.02, 0.03)
_DOUBT = 0.9
_SCALE_IN_DOUBT = 0.02
# Stripes of so many pixels may be an edge whose sides are mixed: colour at half the resolution mixes two.
_NARROW = 2
# A picture whose mean light is below this many sd of its noise is dark; one that varies less than this many is of one colour.
_DIM, _VARIED = 4.0, 5.0
# Pixels by which a picture's range is told.
_RANGED = 1 << 16


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
    kappa = min(best.kappa, 5.0)
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
    confidence = np.where(known, confidence * agreed(setup, shot, rivals, nm, temper, notes), np.nan).astype(np.float32)
    confidence[_narrow(nm.reshape(height, width), setup.quarter_nm).reshape(-1)] *= np.float32(_DOUBT)
    if shot.ties:
        tied = anchors == ANCHORS.index("tie point")
        confidence[tied] = np.maximum(confidence[tied], 0.98)
    scale = _scale(setup, shot)
    doubted = doubts(shot, best, grows)
    if doubted:
        notes += doubted
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
            "misfit": best.misfit if math.isfinite(best.misfit) else None,
            "bias": best.bias,
        },
    )
    return result, best


def _narrow(nm: npt.NDArray[np.float32], quarter_nm: float) -> Mask:
    """Pixels in stripes of at most `_NARROW` that are another order than both their sides.

    At an edge a pixel has the colours of both sides mixed (lenses, demosaicing, JPEG with colour at half the resolution), which
    may be that of a third film; all along the edge alike, so that neighbours make each other sure of it.
    """
    found = np.zeros(nm.shape, dtype=bool)
    for axis in (0, 1):
        lines, mixed = (nm, found) if axis == 1 else (nm.T, found.T)
        edge = np.abs(np.diff(lines, axis=1)) > quarter_nm
        for wide in range(1, _NARROW + 1):
            # An edge, none within, an edge.
            count = edge.shape[1] - wide
            if count < 1:
                continue
            stripe = edge[:, :count] & edge[:, wide:]
            for inner in range(1, wide):
                stripe &= ~edge[:, inner : inner + count]
            for place in range(1, wide + 1):
                mixed[:, place : place + count] |= stripe
    return found


def _prior(before: ThicknessResult, reach_nm: float) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], float]:
    """Thickness and confidence of the frame before, none where there was no answer."""
    known = np.isfinite(before.thickness_nm)
    nm = np.where(known, before.thickness_nm, 0.0).astype(np.float32).reshape(-1)
    return nm, np.where(known, before.confidence, 0.0).astype(np.float32).reshape(-1), max(reach_nm, 1.0)


def _nothing(setup: Setup, shot: Shot) -> ThicknessResult | None:
    """The answer to a picture that says nothing: dark, full, or of one colour throughout."""
    usable = shot.usable
    pixels = shot.picture.pixels[usable] if not usable.all() else shot.picture.pixels.reshape(-1, 3)
    # Channel by channel: sums over an axis of three are many times slower.
    full, numbers = np.ones(len(pixels), dtype=bool), np.ones(len(pixels), dtype=bool)
    for channel, top in zip(pixels.T, shot.levels, strict=True):
        full &= channel >= top
        numbers &= np.isfinite(channel)
    why = ""
    numbers &= ~full
    seen = pixels if numbers.all() else pixels[numbers]
    # So many pixels, from all over the picture, show its range.
    some = seen[:: max(len(seen) // _RANGED, 1)]
    sums = [seen[part].sum(axis=0, dtype=np.float64) for part in strips(seen)] if seen.size else [np.zeros(3)]
    mean = np.sum(sums, axis=0) / max(len(seen), 1)
    level = np.maximum(mean, 0.0)
    sd = np.sqrt(shot.noise[:, 0] + shot.noise[:, 1] * level)
    if full.mean() > 0.98 or not seen.size:
        why = "all pixels are full: nothing can be told"
    elif not (np.abs(mean) > _DIM * sd / math.sqrt(min(seen.shape[0], 100))).any() or not seen.any():
        why = "the picture is dark: its numbers are noise, nothing can be told"
    elif (np.subtract(*np.percentile(some, [97.5, 2.5], axis=0)) < _VARIED * np.hypot(sd, 0.003 * mean)).all():
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
