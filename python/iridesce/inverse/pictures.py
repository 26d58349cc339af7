"""Pictures as three linear channels: what files and arrays say of the light that fell on each pixel. Internal."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, check_room, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.errors import ResourceError
from iridesce.files.arrays import array_of, head_of
from iridesce.files.report import of_core
from iridesce.files.whole import read_whole

Pixels = npt.NDArray[np.float32]
Mask = npt.NDArray[np.bool_]

MOST_PIXELS = 1 << 26
# What a pixel takes while it is mapped, beside the array that was given: 160 to 163 bytes measured on 4 to 9 Mpixel, with
# camera and lamp named or tried, with flat and dark, from a file; and a tenth to be on the safe side.
_BYTES_A_PIXEL = 180
_MOST_BYTES = 4 << 30
# Numbers that a step of numpy takes at a time: some 10 ms.
_STRIP = 1 << 22
# Below this there is no neighbourhood to learn from.
_LEAST_SIDE = 8
# Files whose names tell what their first bytes do not.
_RAW = {".cr2", ".cr3", ".nef", ".arw", ".dng", ".raf", ".orf", ".rw2", ".raw", ".pef", ".srw"}
# Variance of a step of 1/255 of the sRGB curve, seen through the curve: a + b value (its slope goes with value**0.58).
_STEP_8_BIT = (7.7e-9, 6.6e-6)


@dataclass(frozen=True)
class Picture:
    """Linear channels, and how they were cut when they were stored."""

    pixels: Pixels
    """(height, width, 3), NaN where there is no number."""
    full: Floats | None
    """(3,): value from which on a channel is full, infinite where none is; None: to be seen from the numbers."""
    cut_at_zero: bool
    step: tuple[float, float]
    """Variance that storing in steps added: a + b value."""
    notes: tuple[str, ...]

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.pixels.shape[0], self.pixels.shape[1]


def read_picture(image: Any, name: str = "image") -> Picture:
    """A picture from an array, an `Image` or a file."""
    if isinstance(image, Picture):
        return image
    if isinstance(image, str | os.PathLike):
        return _from_file(os.fsdecode(os.fspath(image)))
    xyz = getattr(image, "xyz", None)
    if xyz is not None:
        from iridesce.color import convert

        return _of_array(convert(np.asarray(xyz, dtype=np.float64), "xyz", "linear-srgb"), name)
    return _of_array(image, name)


def _of_array(image: Any, name: str) -> Picture:
    pixels = _checked(image, name)
    # Cut at zero: nothing below, and many exactly there.
    known = np.isfinite(pixels)
    cut = bool(np.min(pixels, where=known, initial=np.inf) >= 0.0 and np.mean(pixels == 0.0) > 1e-4)
    return Picture(pixels, None, cut, (0.0, 0.0), ())


def _checked(values: Any, name: str) -> Pixels:
    try:
        # What is masked is not known: NaN, and left out.
        is_masked = isinstance(values, np.ma.MaskedArray) and values.dtype.kind in "fiu"
        array = np.asarray(np.ma.filled(values.astype(np.float32), np.nan) if is_masked else values)
    except (TypeError, ValueError):
        raise refusal(name, "an array (height, width, 3)", values) from None
    if array.dtype.kind not in "fiu" or array.ndim != 3 or array.shape[2] != 3 or 0 in array.shape:
        raise refusal(
            name,
            "linear numbers of the shape (height, width, 3), a picture's file or an Image",
            Words(f"{type(values).__name__} of shape {array.shape} and type {array.dtype}"),
        )
    _check_size(array.shape[1], array.shape[0], name)
    if min(array.shape[:2]) < _LEAST_SIDE:
        raise refusal(
            name,
            f"at least {_LEAST_SIDE} x {_LEAST_SIDE} pixels",
            Words(f"{array.shape[1]} x {array.shape[0]}"),
            must="have",
        )
    out = np.empty(array.shape, dtype=np.float32)
    is_number = False
    for part in strips(out):
        with np.errstate(over="ignore"):
            out[part] = array[part]
        finite = np.isfinite(out[part])
        if not finite.all():
            out[part][~finite] = np.nan
        is_number = is_number or bool(finite.any())
    if not is_number:
        raise complaint(
            f"{name} holds no number at all that is finite and below 3.4e38",
            name,
            "a picture with numbers in it",
            Words("none"),
        )
    return out


def strips(pixels: Pixels) -> Iterator[slice]:
    """Rows of a picture, so many at a time that no step over them is long: between two of them Ctrl-C is heard."""
    height = max(_STRIP // max(pixels[0].size, 1), 1)
    return (slice(start, start + height) for start in range(0, len(pixels), height))


def lacks_numbers(pixels: Pixels) -> Mask:
    """Which pixels have no number in some channel."""
    out = np.empty(pixels.shape[:2], dtype=bool)
    for part in strips(pixels):
        # Channel by channel: sums over an axis of three are many times slower.
        red, green, blue = (np.isnan(pixels[part][..., channel]) for channel in range(3))
        out[part] = red | green | blue
    return out


def _check_size(width: int, height: int, name: str) -> None:
    if width * height > MOST_PIXELS:
        raise ResourceError(
            f"{name} has {width} x {height} pixels, at most {MOST_PIXELS} are mapped at once: crop it or scale it down"
        )
    needed = width * height * _BYTES_A_PIXEL
    check_room(f"mapping {name} of {width} x {height} pixels", needed, "crop it or scale it down")


def _npy_size(label: str) -> tuple[int, int] | None:
    """Columns and rows that the header of an array declares; None where it is no picture."""
    if not Path(label).is_file():
        return None
    try:
        with Path(label).open("rb") as file:
            shape, _ = head_of(file)
    except (ValueError, OSError):
        return None
    return (shape[1], shape[0]) if len(shape) == 3 else None


def _piled_up(pixels: Pixels, usable: Mask, notes: list[str]) -> Floats:
    """Levels at which many pixels of a channel that varies stand, half of them and more too: where it was cut."""
    full = np.full(3, np.inf)
    for c in range(3):
        values = pixels[..., c][usable]
        top = float(values.max(initial=0.0))
        count = int((values >= top).sum())
        share = count / max(values.size, 1)
        if share > 2e-3 and count > 20 and top > 0.0 and np.unique(values[:: max(1, values.size // 50_000)]).size > 100:
            full[c] = top
            notes.append(
                f"channel {'RGB'[c]} is full at {top:.4g} on {100.0 * share:.1f} % of the pixels: taken as at least that"
            )
    return full


def _from_file(label: str) -> Picture:
    ending = Path(label).suffix.lower()
    if ending in _RAW:
        raise ValueError(
            f"{label}: it is a camera's RAW file; convert it to a linear 16-bit TIFF (dcraw -4 -T, or a raw developer)"
        )
    if ending in (".heic", ".heif", ".avif"):
        raise ValueError(f"{label}: it is HEIC or AVIF; convert it to a linear 16-bit TIFF, or to PNG")
    # From its head: a picture that is too large would take seconds and gibibytes until it is known.
    size = _npy_size(label) if ending == ".npy" else _core.photograph_size(Path(label))
    if size is not None:
        _check_size(*size, label)
    if ending == ".npy":
        content = read_whole(label, _MOST_BYTES, "no picture is")
        try:
            array = array_of(content)
        except ValueError as error:
            raise ValueError(f"{label}: is not an array that can be read: {error}") from None
        return _of_array(array, label)
    rgb, clipped, plain = _core.read_photograph(Path(label), None, None)
    report = of_core(plain)
    pixels = _checked(rgb, label)
    notes = [f"{label}: {note}" for note in report.notes]
    if report.format.startswith(("TIFF", "PNG", "JPEG")):
        # The channel that was full is the greatest of its pixel.
        top = float(pixels.max(axis=2)[clipped].min()) if clipped.any() else np.inf
        is_coarse = report.format in ("JPEG", "PNG of 8 bits")
        return Picture(pixels, np.full(3, top), True, _STEP_8_BIT if is_coarse else (0.0, 0.0), tuple(notes))
    made = _of_array(pixels, label)
    return replace(made, notes=(*notes, *made.notes))


def corrected(picture: Picture, flat: Any, dark: Any) -> Picture:
    """(image - dark) / (flat - dark); what was full stays full wherever the flat puts it."""
    if flat is None and dark is None:
        return picture
    below = np.float32(0.0) if dark is None else read_picture(dark, "dark").pixels
    above = np.float32(1.0) if flat is None else read_picture(flat, "flat").pixels
    for name, one in (("dark", below), ("flat", above)):
        if np.ndim(one) and np.shape(one) != picture.pixels.shape:
            raise refusal(name, f"the size of the picture {picture.shape}", Words(np.shape(one)[:2]), must="have")
    # Without a white surface nothing is known of the light's course, and a dark may be of any unit.
    light = np.float32(1.0) if flat is None else above - below
    if flat is not None and not (light > 0.0).any():
        raise complaint(
            "flat must be brighter than dark: " + ("it is 0 or less everywhere" if dark is None else "it is nowhere"),
            "flat",
            "brighter than dark at some pixel",
            Words("nowhere"),
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        out = np.where(light > 0.0, (picture.pixels - below) / light, np.nan).astype(np.float32)
    notes: list[str] = []
    if flat is not None and (unlit := int(np.any(~(light > 0.0), axis=2).sum())):
        notes.append(f"flat is not brighter than dark at {unlit} pixels: they are left out")
    full = picture.full
    if full is None:
        full = _piled_up(picture.pixels, ~lacks_numbers(picture.pixels), notes)
    if np.isfinite(full).any():
        out[picture.pixels >= full] = np.inf
        full = np.where(np.isfinite(full), np.float64(np.finfo(np.float32).max), np.inf)
    return replace(
        picture,
        pixels=np.ascontiguousarray(out),
        full=full,
        cut_at_zero=picture.cut_at_zero and dark is None,
        notes=(*picture.notes, *notes),
    )


def clip_levels(picture: Picture, usable: Mask, given: Any, notes: list[str]) -> Floats:
    """The level from which on each channel is full."""
    if given is None:
        return _piled_up(picture.pixels, usable, notes) if picture.full is None else picture.full
    try:
        levels = np.broadcast_to(plain_reals("clip", given, "one level or three, > 0"), (3,)).copy()
    except ValueError:
        raise refusal("clip", "one level or three, > 0", given) from None
    if not (levels > 0.0).all():
        raise refusal("clip", "one level or three, > 0", given)
    return levels


def read_mask(given: Any, shape: tuple[int, int]) -> Mask:
    """True: left out."""
    if given is None:
        return np.zeros(shape, dtype=bool)
    mask = np.asarray(given)
    if mask.shape != shape or mask.dtype.kind not in "bui":
        raise refusal(
            "mask",
            f"true or false for each pixel {shape}",
            Words(f"shape {mask.shape} of type {mask.dtype}"),
            must="hold",
        )
    return mask.astype(bool)
