"""The top of a logarithm of a probability, and its width: Newton's method that climbs and never falls. Internal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats

# Differences are taken over this share of a standard deviation along each principal axis: neither rounding nor the next peak.
_SHARE = 0.3
# A top is found where the next move would be shorter than this, in standard deviations.
_CLOSE = 0.05
_TURNS = 40
# Curvature, in units of the steps, below which an axis is taken as flat.
_FLAT = 1e-4
# Axes grow and shrink by no more than this from turn to turn.
_GROWTH = 5.0
# Shares of a move that are tried.
_TRIED = (1.0, 0.4, 0.15, 0.05, 0.015)


@dataclass(frozen=True)
class Summit:
    """Where a function is greatest, and how wide it is there."""

    x: Floats
    covariance: Floats
    is_settled: bool
    """Whether the function falls to all sides, and no move is left."""


def summit(
    logs: Callable[[Floats], Floats],
    refix: Callable[[Floats], None],
    start: Floats,
    step: Floats,
    longest: Floats,
    bounds: tuple[Floats, Floats],
) -> Summit:
    """The top of ``logs`` near a start.

    Differences are taken along the principal axes, as they were at the turn before: thickness and index lie on a ridge, n h, a
    hundred times as long as wide, and a step along either of them alone leads off it, where the function bends the other way.

    logs      of points (m, axes), (m,)
    refix     told of the present place now and then
    step      first steps along the axes
    longest   moves are no longer
    """
    low, high = bounds
    x, axes = np.clip(start, low, high), np.diag(step)
    refix(x)
    covariance, is_settled, stuck = axes @ axes.T, False, 0
    for turn in range(_TURNS):
        gradient, hessian = _curvature(logs, x, axes, bounds)
        bend, turned = np.linalg.eigh(-hessian)
        along = turned.T @ gradient
        falls = bend > _FLAT
        # Where it does not fall to both sides: uphill, ten steps far.
        newton = np.where(falls, along / np.where(falls, bend, 1.0), 10.0 * np.sign(along))
        move = axes @ (turned @ newton)
        move = move / max(1.0, float(np.abs(move / longest).max()))
        tried = np.clip(x + np.multiply.outer((0.0, *_TRIED), move), low, high)
        seen = logs(tried)
        best = int(np.argmax(seen))
        went = np.linalg.solve(axes @ turned, tried[best] - x)
        x = tried[best]
        sd = 1.0 / np.sqrt(np.where(falls, bend, _FLAT))
        covariance = axes @ (turned * sd**2) @ turned.T @ axes.T
        uphill = np.asarray(np.linalg.solve(axes.T, gradient), dtype=np.float64)
        barred = ((x <= low) & (uphill < 0.0)) | ((x >= high) & (uphill > 0.0))
        stuck = stuck + 1 if barred.any() else 0
        if stuck > 1:
            return _at_bound(logs, refix, x, (barred, uphill), step, longest, bounds)
        is_short = bool((np.abs(newton) < _CLOSE * sd).all())
        # The steps have found their size, and what is left of the way is short.
        at_size = bool((np.abs(_SHARE * sd - 1.0) < 0.5).all())
        if falls.all() and at_size and (is_short or (best > 0 and bool((np.abs(went) < _CLOSE * sd).all()))):
            is_settled = True
            break
        grown = np.clip(_SHARE * sd, 1.0 / _GROWTH, _GROWTH)
        if best == 0 and not is_short:
            # No share of the move goes up: the curvature is that of too far around. Where it falls, but too little to be seen,
            # the steps are too short instead: at a top that was met by chance nothing goes up, however short.
            grown = np.where((bend > 0.0) & ~falls, grown, np.minimum(grown, 0.4))
        axes = axes @ (turned * grown)
        axes = axes / np.maximum(1.0, np.abs(axes / longest[:, None]).max(axis=0))
        if turn % 3 == 2:
            refix(x)
    refix(x)
    return Summit(x, covariance, is_settled)


def _at_bound(
    logs: Callable[[Floats], Floats],
    refix: Callable[[Floats], None],
    x: Floats,
    at: tuple[npt.NDArray[np.bool_], Floats],
    step: Floats,
    longest: Floats,
    bounds: tuple[Floats, Floats],
) -> Summit:
    """The top along a bound, beyond which the function still rises: within, it falls as an exponential does."""
    barred, uphill = at
    free = ~barred

    def whole(points: Floats) -> Floats:
        out = np.tile(x, (*points.shape[:-1], 1))
        out[..., free] = points
        return out

    is_settled, covariance = True, np.zeros((x.size, x.size))
    if free.any():
        found = summit(
            lambda points: logs(whole(points)),
            lambda point: refix(whole(point)),
            x[free],
            step[free],
            longest[free],
            (bounds[0][free], bounds[1][free]),
        )
        x, is_settled = whole(found.x), found.is_settled
        covariance[np.ix_(free, free)] = found.covariance
    # How steeply it falls from there, over a tenth of what the slope was before.
    for axis in np.flatnonzero(barred):
        by = 0.1 / uphill[axis]
        inside = x.copy()
        inside[axis] -= by
        top, below = logs(np.stack([x, inside]))
        covariance[axis, axis] = (by / max(float(top - below), 1e-3)) ** 2
    return Summit(x, covariance, is_settled)


def _curvature(
    logs: Callable[[Floats], Floats], x: Floats, axes: Floats, bounds: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Gradient at a place and second derivatives, in units of the axes (columns)."""
    low, high = bounds
    count = x.size
    # Inside the bounds, so that both sides can be asked.
    reach = np.abs(axes).sum(axis=1)
    middle = np.clip(x, low + reach, np.maximum(high - reach, low + reach))
    columns = axes.T
    pairs = [(i, j) for i in range(count) for j in range(i)]
    points = [middle, *(middle + one for one in columns), *(middle - one for one in columns)]
    points += [middle + columns[i] + columns[j] for i, j in pairs] + [
        middle - columns[i] - columns[j] for i, j in pairs
    ]
    seen = logs(np.array(points))
    at, up, down = seen[0], seen[1 : count + 1], seen[count + 1 : 2 * count + 1]
    hessian = np.diag(up - 2.0 * at + down)
    for number, (i, j) in enumerate(pairs):
        both, neither = seen[2 * count + 1 + number], seen[2 * count + 1 + len(pairs) + number]
        hessian[i, j] = hessian[j, i] = 0.5 * (both + neither - up[i] - up[j] - down[i] - down[j] + 2.0 * at)
    gradient = 0.5 * (up - down) + hessian @ np.linalg.solve(axes, x - middle)
    return gradient, hessian
