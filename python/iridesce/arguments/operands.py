"""Arguments that broadcast: checked, named in errors, and passed to the core without being blown up to full size."""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce.arguments.refusals import Words, complaint, refusal, short
from iridesce.arguments.scalars import allowed_range
from iridesce.errors import ResourceError

Floats = npt.NDArray[np.float64]

_MOST_AXES = 32  # of the 64 that numpy has: results add some of their own
_ALWAYS_FITS = 2**26  # bytes; below this it is not worth asking the system


@dataclass(frozen=True, eq=False)
class Operand:
    """One argument: its name for errors, its values with every broadcast axis cut to length 1, its full shape."""

    name: str
    values: Floats
    shape: tuple[int, ...]

    def full(self) -> Floats:
        """The values in their full shape, as a read-only view."""
        return np.broadcast_to(self.values, self.shape)

    def strides(self, shape: tuple[int, ...]) -> list[int]:
        """How far to step in the flat values along each axis of the result's ``shape``."""
        steps = [0] * len(shape)
        step = 1
        for axis in range(1, self.values.ndim + 1):
            length = self.values.shape[-axis]
            steps[-axis] = step if length > 1 else 0
            step *= length
        return steps


def place(index: Sequence[Any]) -> str:
    """`` at index (3, 7)``; nothing for a scalar."""
    return f" at index {tuple(int(i) for i in index)}" if len(index) else ""


def real_operand(
    name: str, value: object, *, low: float = -math.inf, high: float = math.inf, includes_low: bool = True
) -> Operand:
    """A real, finite argument within [low, high) (or (low, high)), copied; ``ValueError`` tells what is wrong where."""
    refuse_masks(name, value)
    try:
        array = np.asarray(value)
    except (ValueError, TypeError, OverflowError):
        raise refusal(name, "a number or an array of numbers", value) from None
    if array.dtype.kind not in "iuf":
        raise refusal(name, "real numbers", Words(f"{short(value)} of type {array.dtype}"))
    if array.size == 0:
        raise complaint(
            f"{name} must not be empty, got shape {array.shape}", name, "not empty", Words(f"shape {array.shape}")
        )
    if array.ndim > _MOST_AXES:
        raise refusal(name, f"an array of at most {_MOST_AXES} axes", Words(f"{array.ndim} axes"))
    shape = array.shape
    # A broadcast view (stride 0) repeats itself: one entry of it is enough, and its full size may fit nowhere.
    cut = tuple(slice(0, 1) if step == 0 else slice(None) for step in array.strides)
    with np.errstate(over="ignore"):
        values = np.array(array[cut], dtype=np.float64, order="C", ndmin=array.ndim, copy=True)
    good = np.isfinite(values) & (values >= low if includes_low else values > low) & (values < high)
    if not good.all():
        wrong = np.unravel_index(int(np.argmin(good)), values.shape)
        raise refusal(name, allowed_range(low, high, includes_low), array[wrong].item(), place(wrong))
    values.flags.writeable = False
    return Operand(name, values, shape)


def reals(name: str, value: object) -> Floats:
    """A real, finite argument in its full shape."""
    return real_operand(name, value).full()


def refuse_masks(name: str, value: object) -> None:
    """``ValueError`` for a masked array: what is below the mask would count."""
    if isinstance(value, np.ma.MaskedArray):
        raise complaint(
            f"{name} must not be a masked array: fill or drop the masked entries",
            name,
            "an array without a mask",
            Words("a masked array"),
        )


def plain_reals(name: str, value: object, allowed: str) -> Floats:
    """Real numbers in their own shape, NaN and infinities too, for the caller to judge: masked ones are NaN.

    What numpy would make numbers of with a loss is refused: complex numbers, texts, times, truth values.
    """
    try:
        array = np.ma.asanyarray(value) if isinstance(value, np.ma.MaskedArray) else np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError
        found = array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise refusal(name, allowed, value) from None
    return found.filled(np.nan) if isinstance(found, np.ma.MaskedArray) else found


def scalar(array: Any) -> Any:
    """A float for an array of no axes; other arrays as they are."""
    return float(array) if array.ndim == 0 else array


def broadcast_shape(operands: Sequence[Operand]) -> tuple[int, ...]:
    """The common shape, or a ``ValueError`` that names the arguments and their shapes."""
    try:
        return np.broadcast_shapes(*(operand.shape for operand in operands))
    except ValueError:
        arrays = [operand for operand in operands if operand.shape]
        names = _listed([operand.name for operand in arrays])
        shapes = _listed([str(operand.shape) for operand in arrays])
        raise complaint(
            f"{names} must broadcast: shapes {shapes}", names, "of shapes that broadcast", Words(shapes)
        ) from None


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def new_array(what: str, shape: tuple[int, ...], dtype: npt.DTypeLike = np.float64) -> npt.NDArray[Any]:
    """An empty array, or `ResourceError` where it cannot fit (asking for it could otherwise end the process)."""
    needed = math.prod(shape) * np.dtype(dtype).itemsize
    check_room(f"{what} of shape {shape}", needed, "work in parts")
    try:
        return np.empty(shape, dtype)
    except (MemoryError, ValueError) as error:
        raise ResourceError(f"{what} of shape {shape} needs {_gib(needed)}: {error}") from None


def check_room(what: str, needed: float, way_out: str) -> None:
    """`ResourceError` where so many bytes cannot be had, before any of them is asked for."""
    free = available_bytes() if needed > _ALWAYS_FITS else math.inf
    if needed > free:
        raise ResourceError(f"{what} needs {_gib(needed)}, and {_gib(free)} of memory is free; {way_out}")


def _gib(count: float) -> str:
    return f"{count / 2**30:.3g} GiB"


def available_bytes() -> float:
    """Memory that can still be used: what the system has, and what a container's limit leaves, whichever is less."""
    free = math.inf
    with contextlib.suppress(AttributeError, OSError, ValueError):
        free = float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    with contextlib.suppress(OSError, StopIteration, ValueError):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        free = next(1024.0 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    group = Path("/sys/fs/cgroup")
    with contextlib.suppress(OSError, ValueError):  # ValueError: the limit reads "max", there is none
        most = int((group / "memory.max").read_text(encoding="ascii"))
        free = min(free, float(most - int((group / "memory.current").read_text(encoding="ascii"))))
    return free


def checked_out(out: object, shape: tuple[int, ...]) -> Floats:
    """``out`` as the core can write it: a writable float64 array in C order, of the result's shape."""
    if not isinstance(out, np.ndarray):
        raise refusal("out", "a numpy array", Words(type(out).__name__))
    if out.dtype != np.float64 or not out.dtype.isnative:
        raise refusal("out", "of type float64", Words(f"{out.dtype}"))
    if out.shape != shape:
        raise complaint(
            f"out must have the shape of the result, {shape}, got {out.shape}",
            "out",
            f"of the shape of the result, {shape}",
            Words(f"{out.shape}"),
        )
    if not out.flags.c_contiguous or not out.flags.aligned:
        raise complaint(
            "out must be in C order (contiguous, last axis fastest)", "out", "in C order", Words("another order")
        )
    if not out.flags.writeable:
        raise complaint("out must be writable", "out", "writable", Words("a read-only array"))
    return out
