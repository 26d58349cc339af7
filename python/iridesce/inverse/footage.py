"""Thickness of a film in every frame of a video: each frame is a prior of the next."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from iridesce._progress import Told, check_progress, watched
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import number
from iridesce.inverse.photograph import solve
from iridesce.inverse.shots import read_setup, take

if TYPE_CHECKING:
    from iridesce.color import Camera
    from iridesce.inverse.calibration import CameraCalibration
    from iridesce.inverse.exposures import Exposed
    from iridesce.inverse.maps import ThicknessResult

__all__ = ["map_thickness_video"]

_ENDINGS = (".exr", ".npy", ".tif", ".tiff", ".png", ".jpg", ".jpeg")
# Mean step from frame to frame, of half an order, before any was seen; and what it may come to.
_FIRST_STEP = 0.25
_STEPS = (0.02, 0.5)


def map_thickness_video(
    frames: Any,
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
    max_rate_nm_per_s: float | None = None,
    fps: float | None = None,
) -> Iterator[ThicknessResult]:
    """The thickness of a film in every frame: `map_thickness`, the last frame widened as the prior of the next.

    A pixel changes by a Laplace distributed step from frame to frame, of mean max_rate_nm_per_s / fps where both are given, else
    measured from frame to frame; now and then by anything, as films burst. Camera and lamp are those of the first frame.

    frames     images as for `map_thickness`, one after the other: any iterable, an array (n, h, w, 3), or a folder of pictures in
               the order of their names. All of one size
    tie_points  of the first frame
    max_rate_nm_per_s, fps  how fast thickness changes, and frames a second, > 0; both or neither
    progress   called for each frame anew
    others     as for `map_thickness`
    Returns    an iterator of `ThicknessResult`; a frame is read when its result is asked for
    Raises     ValueError as `map_thickness`; frames of different sizes; no frames

    >>> import numpy as np
    >>> import iridesce as ir
    >>> nm = np.linspace(150.0, 500.0, 64) + np.zeros((48, 1))
    >>> film = [ir.Stack(["air", ir.Layer("soap", nm - 5.0 * t), "air"]).color(space="linear-srgb") for t in range(3)]
    >>> maps = ir.map_thickness_video(film, "air / soap ? / air", camera="srgb", illuminant="D65")
    >>> [round(float(np.nanmean(one.thickness_nm - nm))) for one in maps]
    [0, -5, -10]
    """
    check_progress(progress)
    if (max_rate_nm_per_s is None) != (fps is None):
        raise complaint(
            "max_rate_nm_per_s and fps belong together: give both or neither",
            "max_rate_nm_per_s" if fps is None else "fps",
            "given with the other, or neither",
            Words("one of the two"),
        )
    step: float | None = None
    if max_rate_nm_per_s is not None:
        rate = number("max_rate_nm_per_s", max_rate_nm_per_s, low=0.0, high=1e9, includes_low=False)
        step = rate / number("fps", fps, low=0.0, high=1e9, includes_low=False)
    setup = read_setup(
        stack, calibration, camera, illuminant, thickness_range_nm, index_tolerance, angle_tolerance_deg, threads
    )
    every = _frames(frames)

    def answers() -> Iterator[ThicknessResult]:
        tables = None
        before: tuple[Exposed, ThicknessResult] | None = None
        mean = _FIRST_STEP * setup.quarter_nm if step is None else step
        for count, image in enumerate(every):
            ties = tie_points if count == 0 else None
            shot = take(setup, image, angle_deg, noise, mask, flat, dark, ties, clip)
            if before is not None and before[1].thickness_nm.shape != shot.picture.shape:
                first = before[1].thickness_nm.shape
                raise complaint(
                    f"frame {count} has {shot.picture.shape} pixels, those before {first}",
                    "frames",
                    f"of one size, {first}",
                    Words(shot.picture.shape),
                    f"in frame {count}",
                )
            with watched(progress, "mapping") as tell:
                tables = setup.views(shot.angles.angle_deg) if tables is None else tables
                prior = None if before is None else (*before, mean)
                result, exposed = solve(setup, shot, tables, tell, prior)
            if before is not None and step is None:
                sure = (result.confidence > 0.95) & (before[1].confidence > 0.95)
                moved = np.abs(result.thickness_nm - before[1].thickness_nm)[sure]
                if moved.size > 100:
                    low, high = (share * setup.quarter_nm for share in _STEPS)
                    mean = float(np.clip(np.mean(moved[moved < setup.quarter_nm]), low, high))
            if np.isfinite(result.thickness_nm).any():
                before = (exposed, result)
            yield result

    return answers()


def _frames(given: Any) -> Iterable[Any]:
    if isinstance(given, str | os.PathLike):
        folder = Path(os.fsdecode(os.fspath(given)))
        if not folder.is_dir():
            raise complaint(
                f"frames must be images, or a folder of pictures, got {str(folder)!r:.200}; "
                "take a video apart first (ffmpeg -i film.mp4 frames/%05d.png)",
                "frames",
                "images, or a folder of pictures",
                str(folder),
            )
        files = sorted(path for path in folder.iterdir() if path.suffix.lower() in _ENDINGS)
        if not files:
            raise complaint(
                f"{folder}: no picture in it ({', '.join(_ENDINGS)})",
                "frames",
                f"a folder with pictures ({', '.join(_ENDINGS)})",
                str(folder),
            )
        return files
    if getattr(given, "xyz", None) is not None or getattr(given, "ndim", 4) == 3:
        raise complaint(
            "frames must be several images, one after the other; of one picture: map_thickness",
            "frames",
            "several images, one after the other",
            Words("one picture"),
        )
    try:
        return list(given) if isinstance(given, list | tuple) else iter(given)
    except TypeError:
        raise refusal("frames", "images, one after the other", given) from None
