"""Layers whose index changes with depth, and rough faces, as slices. Internal; `Layer.graded` and `Layer.rough` call it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats, real_operand
from iridesce.optics.evaluation import check_ends, evaluate
from iridesce.optics.medium import Medium, as_medium

_MOST_SLICES = 1024
# Surroundings in which the error is measured besides the layer's own ends: air above, and the index of silicon below.
_AROUND = (1.0, 4.0)


def slices(
    thickness_nm: npt.ArrayLike,
    medium_at: Callable[[float], Any],
    wavelength_nm: npt.ArrayLike,
    tolerance: float,
) -> list[tuple[Medium, Any]]:
    """Equal slices as (medium, nm), each of the index in its middle; ``medium_at`` takes the depth as a share.

    They err as their number to the power -2, so that one doubling changes R by three times what is left.
    """
    nm = real_operand("wavelength_nm", wavelength_nm, low=0.0, includes_low=False).full().reshape(-1)
    thickness = real_operand("thickness_nm", thickness_nm, low=0.0)
    limit = real_operand("tolerance", tolerance, low=0.0, includes_low=False)
    if limit.shape != ():
        raise ValueError(f"tolerance must be one number, got shape {limit.shape}")
    thickest = float(thickness.values.max(initial=0.0))
    ends = [medium_at(0.0), medium_at(1.0)]

    def middles(count: int) -> list[Medium]:
        return [as_medium(medium_at((place + 0.5) / count)) for place in range(count)]

    def seen(count: int) -> Floats:
        media = middles(count)
        # A first medium absorbs nothing and a last one has no gain: those ends are looked at from air.
        around = [_AROUND]
        if all(np.all(np.imag(Medium(end).index(nm)) == 0.0) for end in ends):
            around.append((ends[0], ends[1]))
        return np.concatenate(
            [
                _power(quantity, as_medium(first), media, thickest / count, as_medium(last), nm, angle)
                for first, last in around
                for quantity in ("reflectance", "transmittance")
                for angle in (0.0, 60.0)
            ]
        )

    count = 2
    before = seen(count)
    while True:
        after = seen(2 * count)
        if np.abs(after - before).max() <= 3.0 * float(limit.values):
            # Errors fall to a quarter, so the finer one is off by a third of the change.
            each = np.asarray(thickness_nm, dtype=float) / (2 * count)
            return [(medium, each) for medium in middles(2 * count)]
        count, before = 2 * count, after
        if count >= _MOST_SLICES:
            raise ValueError(
                f"tolerance {float(limit.values):g} is not reached with {_MOST_SLICES} slices of {thickest:g} nm in all: "
                "give a larger tolerance, or the layer in parts"
            )


def _power(
    quantity: str, first: Medium, media: list[Medium], each_nm: float, last: Medium, nm: Floats, angle_deg: float
) -> Floats:
    """R or T of equal slices between two media, unpolarised."""
    check_ends(first, last)
    arguments = [
        real_operand("wavelength_nm", nm),
        real_operand("angle_deg", angle_deg),
        *([real_operand("thickness_nm", each_nm)] * len(media)),
    ]
    out = np.empty(nm.shape)
    evaluate(quantity, "unpolarized", [first, *media, last], [True] * len(media), nm.shape, arguments, out)
    return out


def between(first: Any, second: Any, profile: Any, rule: str) -> Callable[[float], Any]:
    """The medium at a depth: a mixture of two whose share of the second follows the profile."""
    ends = Medium(first), Medium(second)
    if profile is not None and not callable(profile):
        raise ValueError(f"profile must be None or a function of the depth (0 to 1), got {profile!r:.60}")

    def at(depth: float) -> Any:
        share = depth if profile is None else float(profile(depth))
        if not 0.0 <= share <= 1.0:
            raise ValueError(f"profile must give shares from 0 to 1, got {share!r} at depth {depth:g}")
        return Medium.mixture(ends[0], ends[1], share, rule)

    return at


def of_index(n: Callable[[float], Any], thickness_nm: npt.ArrayLike) -> Callable[[float], Any]:
    """The index at a depth from a function of nm."""
    thickest = float(np.max(np.asarray(thickness_nm, dtype=float)))

    def at(depth: float) -> Any:
        return Medium(complex(n(depth * thickest)))

    return at
