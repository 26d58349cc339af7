"""Layers whose index changes with depth, and rough faces, as slices. Internal; `Layer.graded` and `Layer.rough` call it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import real_operand
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.optics.medium import Medium, as_medium


def slices(
    thickness_nm: npt.ArrayLike,
    medium_at: Callable[[float], Any],
    wavelength_nm: npt.ArrayLike,
    tolerance: float,
) -> list[tuple[Medium, Any]]:
    """Equal slices as (medium, nm), each of the index in its middle; ``medium_at`` takes the depth as a share.

    How many is `optics::stack::graded` of the core.
    """
    nm = real_operand("wavelength_nm", wavelength_nm, low=0.0, includes_low=False).full().reshape(-1)
    thickness = real_operand("thickness_nm", thickness_nm, low=0.0)
    limit = real_operand("tolerance", tolerance, low=0.0, includes_low=False)
    if limit.shape != ():
        raise refusal("tolerance", "one number", Words(f"shape {limit.shape}"))
    thickest = float(thickness.values.max(initial=0.0))

    def index_at(depth: float) -> npt.NDArray[np.complex128]:
        return np.ascontiguousarray(as_medium(medium_at(depth)).index(nm), dtype=np.complex128).reshape(-1)

    count = _core.graded_slices(index_at, np.ascontiguousarray(nm), thickest, float(limit.values))
    each = np.asarray(thickness_nm, dtype=float) / count
    return [(as_medium(medium_at((place + 0.5) / count)), each) for place in range(count)]


def between(first: Any, second: Any, profile: Any, rule: str) -> Callable[[float], Any]:
    """The medium at a depth: a mixture of two whose share of the second follows the profile."""
    ends = Medium(first), Medium(second)
    if profile is not None and not callable(profile):
        raise refusal("profile", "None or a function of the depth (0 to 1)", profile)

    def at(depth: float) -> Any:
        share = depth if profile is None else float(profile(depth))
        if not 0.0 <= share <= 1.0:
            raise complaint(
                f"profile must give shares from 0 to 1, got {share!r} at depth {depth:g}",
                "profile",
                "a function that gives shares from 0 to 1",
                share,
                f"at depth {depth:g}",
            )
        return Medium.mixture(ends[0], ends[1], share, rule)

    return at


def of_index(n: Callable[[float], Any], thickness_nm: npt.ArrayLike) -> Callable[[float], Any]:
    """The index at a depth from a function of nm."""
    thickest = float(np.max(np.asarray(thickness_nm, dtype=float)))

    def at(depth: float) -> Any:
        return Medium(complex(n(depth * thickest)))

    return at
