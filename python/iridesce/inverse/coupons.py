"""Volts of anodising from a user's own samples: nm a volt, and how far samples scatter about it. Internal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import number
from iridesce.color.film_tables import Conditions
from iridesce.color.spaces import delta_e
from iridesce.optics.medium import Medium

# Oxides grow by 0.3 to 6 nm a volt, on what stands there already (up to 40 nm, less a rounding of the line through it).
_NM_PER_VOLT = np.geomspace(0.3, 6.0, 241)
_OFFSETS_NM = np.arange(-10.0, 41.0, 2.0)
# A colour this far from all colours of the film (CIEDE2000) says no more than one farther away.
_FAR = 20.0
_NEAR_NM = 20.0


@dataclass(frozen=True)
class Growth:
    """thickness = nm_per_volt * volts + offset, with the scatter of the coupons about it."""

    nm_per_volt: float
    nm_per_volt_sd: float
    offset_nm: float
    scatter_nm: float
    volts: Floats
    thickness_nm: Floats

    def volts_for(self, thickness_nm: float) -> tuple[float, float]:
        """Volts, and the standard deviation of the next sample: scatter and line together, in volts."""
        volts = (thickness_nm - self.offset_nm) / self.nm_per_volt
        count = self.volts.size
        if count > 2:
            away = self.volts - self.volts.mean()
            share = 1.0 + 1.0 / count + (volts - float(self.volts.mean())) ** 2 / float(away @ away)
        else:
            share = 1.0 + volts**2 / float(self.volts @ self.volts)
        return volts, self.scatter_nm * math.sqrt(share) / self.nm_per_volt


def growth(coupons: Any, media: Sequence[Medium], conditions: Conditions) -> Growth:
    """A straight line through coupons of (volt, nm) or (volt, Lab); through zero where there are two only."""
    volts, thickness, labs = _read(coupons)
    if labs is not None:
        if len(media) != 1:
            raise complaint(
                f"coupons by colour need one medium, the oxide; media has {len(media)}",
                "media",
                "one medium, the oxide, beside coupons by colour",
                Words(len(media)),
            )
        thickness = _by_color(volts, labs, media[0], conditions)
    line = volts.size > 2
    columns = np.column_stack([volts, np.ones_like(volts)]) if line else volts[:, None]
    found = np.linalg.lstsq(columns, thickness, rcond=None)[0]
    left = thickness - columns @ found
    variance = float(left @ left) / (volts.size - columns.shape[1])
    covariance = variance * np.linalg.inv(columns.T @ columns)
    slope = float(found[0])
    away = volts - volts.mean()
    if min(slope, float(away @ thickness)) <= 0.0:
        raise complaint(
            f"coupons must grow thicker with the voltage; a line through them has "
            f"{float(away @ thickness) / float(away @ away):.3g} nm a volt",
            "coupons",
            "ones that grow thicker with the voltage",
            Words(f"{float(away @ thickness) / float(away @ away):.3g} nm a volt"),
        )
    offset = float(found[1]) if line else 0.0
    return Growth(slope, math.sqrt(max(float(covariance[0, 0]), 0.0)), offset, math.sqrt(variance), volts, thickness)


def _read(coupons: Any) -> tuple[Floats, Floats, Floats | None]:
    wanted = "a list of (volt, nm) or of (volt, (L, a, b)), all of one kind"
    try:
        pairs = [(number("volt", volt), plain_reals("coupons", value, wanted)) for volt, value in coupons]
    except (TypeError, ValueError):
        raise refusal("coupons", wanted, coupons) from None
    shapes = {value.shape for _, value in pairs}
    if shapes not in ({()}, {(3,)}):
        raise refusal("coupons", wanted, coupons)
    volts, values = np.array([volt for volt, _ in pairs]), np.array([value for _, value in pairs])
    if not (np.isfinite(volts).all() and np.isfinite(values).all() and (volts > 0.0).all()):
        raise refusal("coupons", "finite, their volts > 0", coupons)
    if np.unique(volts).size < 2:
        raise complaint(
            f"coupons of two voltages at least are needed, got {np.unique(volts).tolist()} V",
            "coupons",
            "of two voltages at least",
            Words(f"{np.unique(volts).tolist()} V"),
        )
    if shapes == {()}:
        if not (values >= 0.0).all():
            raise refusal("coupons", "thicknesses >= 0 nm", Words(values.tolist()), must="have")
        return volts, values, None
    return volts, np.zeros_like(volts), values


def _by_color(volts: Floats, labs: Floats, medium: Medium, conditions: Conditions) -> Floats:
    """The thickness of each coupon: of all that its colour allows, that which lies on one line with the others'."""
    axis = np.arange(0.0, max(1.5 * conditions.range_nm[1], 600.0), 0.5)
    colors = conditions.color([medium], [axis], "lab", coarse=True)
    cost = np.minimum(np.array([delta_e(colors, lab) for lab in labs]), _FAR) ** 2
    best, line = math.inf, (0.0, 0.0)
    for offset in _OFFSETS_NM:
        places = np.multiply.outer(_NM_PER_VOLT, volts) + offset
        total = np.zeros(_NM_PER_VOLT.size)
        for one, row in enumerate(cost):
            total += np.interp(places[:, one], axis, row, left=_FAR**2, right=_FAR**2)
        at = int(total.argmin())
        if total[at] < best:
            best, line = float(total[at]), (float(_NM_PER_VOLT[at]), float(offset))
    if best > 0.5 * _FAR**2 * volts.size:
        raise complaint(
            f"the colours of the coupons are not those of {medium.name} of 0.3 to 6 nm a volt: the nearest line misses them by "
            f"{math.sqrt(best / volts.size):.3g} (CIEDE2000)",
            "coupons",
            f"of colours that {medium.name} of 0.3 to 6 nm a volt has",
            Words(f"ones {math.sqrt(best / volts.size):.3g} (CIEDE2000) off"),
        )
    found = []
    for volt, row in zip(volts, cost, strict=True):
        near = np.flatnonzero(np.abs(axis - (line[0] * volt + line[1])) <= _NEAR_NM)
        place = int(near[row[near].argmin()])
        found.append(_vertex(axis, row, place))
    return np.array(found)


def _vertex(axis: Floats, row: Floats, place: int) -> float:
    """Of a parabola through the lowest point and its neighbours."""
    if not 0 < place < axis.size - 1:
        return float(axis[place])
    before, at, after = row[place - 1 : place + 2]
    bend = before - 2.0 * at + after
    return float(axis[place] + (0.5 * (before - after) / bend if bend > 0.0 else 0.0) * (axis[1] - axis[0]))
