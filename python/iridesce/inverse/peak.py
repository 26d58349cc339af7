"""One thickness, or order, and what a spectrum says of it: from a start to the top, and the mass there. Internal."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.inverse.posterior import Engine, Explanations, log_sum, prior_density


@dataclass(frozen=True)
class Peak:
    """One thickness (or order) and what the data say of it."""

    thickness_nm: float
    log_mass: float
    """Logarithm of evidence times prior, summed over the peak and all nuisances; the prior of a film at all is apart."""
    grid_nm: Floats
    density: Floats
    """Probability density on the grid, of integral 1."""
    best: Floats
    """The nuisance that explains it best."""
    at_end: bool

    @property
    def sd_nm(self) -> float:
        """Standard deviation."""
        mean = float(np.trapezoid(self.grid_nm * self.density, self.grid_nm))
        return math.sqrt(max(float(np.trapezoid((self.grid_nm - mean) ** 2 * self.density, self.grid_nm)), 0.0))

    def quantiles(self, probability: float) -> tuple[float, float]:
        """The interval that leaves as much out on either side."""
        steps = np.diff(self.grid_nm)
        rising = np.r_[0.0, np.cumsum(0.5 * steps * (self.density[1:] + self.density[:-1]))]
        rising /= rising[-1]
        out = 0.5 * (1.0 - probability)
        low, high = np.interp([out, 1.0 - out], rising, self.grid_nm)
        return float(low), float(high)


_NODES = np.linspace(-4.5, 4.5, 13)
# Explanations that are so much less likely than the best are left out of the sums: a thousandth of a thousandth.
_NEGLIGIBLE = 14.0
# And so much less likely than the best are a few that have little to say: a twentieth.
_LIKELY = 3.0
# The top of a parabola over points 1.5 standard deviations apart lies so much above them, at most.
_BETWEEN = 0.3


def together(peaks: Sequence[Peak], log_priors: Sequence[float]) -> Peak:
    """One peak that was reached under several models of what pales its fringes, each with its mass."""
    masses = np.array([one.log_mass + prior for one, prior in zip(peaks, log_priors, strict=True)])
    shares = np.exp(masses - log_sum(masses))
    best = peaks[int(masses.argmax())]
    used = [(one, share) for one, share in zip(peaks, shares, strict=True) if share > 1e-6]
    low, high = min(one.grid_nm[0] for one, _ in used), max(one.grid_nm[-1] for one, _ in used)
    grid = np.unique(np.concatenate([np.linspace(low, high, 257), *(one.grid_nm for one, _ in used)]))
    density = np.zeros(grid.size)
    for one, share in used:
        density += share * np.interp(grid, one.grid_nm, one.density, left=0.0, right=0.0)
    return replace(best, log_mass=log_sum(masses), grid_nm=grid, density=density / float(np.trapezoid(density, grid)))


def climb(
    engine: Engine, row: Callable[[float], Floats], start_nm: float, step_nm: float, bounds: tuple[float, float]
) -> Peak:
    """From a thickness to the top of its peak, and its mass there.

    row       the spectrum of a thickness
    step_nm   about the width of the peak
    """
    low, high = bounds
    h = min(max(start_nm, low), high)
    explanations = engine.films(row(h))
    first = engine.log_evidences(row(h), explanations)[0]
    best = explanations.only(np.array([int(first.argmax())]))
    step = step_nm
    top, top_at, half = -math.inf, h, step
    for _ in range(12):
        step = min(max(step, 1e-9 * max(h, 1.0)), 0.25 * (high - low))
        left, right = max(h - step, low), min(h + step, high)
        middle = 0.5 * (left + right)
        before, half = half, 0.5 * (right - left)
        below, at, above = engine.log_evidences(np.array([row(left), row(middle), row(right)]), best)[:, 0]
        if at < top - _NEGLIGIBLE:
            # The parabola was wider than the peak (exact data have peaks of 1e-5 nm) and the move went past it.
            h, step = top_at, min(step, 0.5 * before)
            continue
        top, top_at = at, middle
        bend = 2.0 * at - below - above
        if bend > 1e-12:
            move = min(max(half * (above - below) / (2.0 * bend), -3.0 * half), 3.0 * half)
            width = half / math.sqrt(bend)
        else:
            move, width = (2.0 * half if above > below else -2.0 * half), 2.0 * half
        moved = min(max(middle + move, low), high)
        done = abs(moved - h) < 0.1 * width and 0.2 < width / max(half, 1e-300) < 5.0
        h, step = moved, width
        if done:
            break
    explanations = engine.films(row(h))
    logs = engine.log_evidences(row(h), explanations)[0]
    used = explanations.only(np.flatnonzero(logs > logs.max() - _NEGLIGIBLE))
    # How wide a peak is, those tell that have most of its mass; of noise none is excluded, and no peak ends.
    few = explanations.only(np.flatnonzero(logs > logs.max() - _LIKELY))
    width = step
    for turn in range(6):
        grid = np.clip(h + width * _NODES, low, high)
        grid = np.unique(grid)
        if grid.size < 3:
            grid = np.linspace(low, high, 13)
        spectra = np.array([row(float(one)) for one in grid])
        by = used if turn == 0 else few
        table = engine.log_evidences(spectra, by)
        total = np.array([log_sum(line) for line in table]) + np.log(prior_density(grid, low, high))
        top = int(total.argmax())
        ends = max(total[0] if grid[0] > low else -np.inf, total[-1] if grid[-1] < high else -np.inf)
        if ends < total.max() - 6.0:
            break
        width *= 2.5 if 0 < top < grid.size - 1 else 1.5
        if not 0 < top < grid.size - 1:
            h = float(grid[top])
    if by is not used:
        table = engine.log_evidences(spectra, used)
        total = np.array([log_sum(line) for line in table]) + np.log(prior_density(grid, low, high))
    return _peak(grid, total, table, used, low, high)


def _peak(grid: Floats, total: Floats, table: Floats, used: Explanations, low: float, high: float) -> Peak:
    fine = np.linspace(grid[0], grid[-1], 257)
    # Between points that are as far apart as a peak needs there is no more than this; where they lie over half the range, of a
    # film whose fringes cannot be seen, the cubic made up peaks of their own, of e^13 times the evidence.
    logs = np.minimum(_cubic(grid, total, fine), total.max() + _BETWEEN)
    density = np.exp(logs - logs.max())
    area = float(np.trapezoid(density, fine))
    place = int(density.argmax())
    at = int(total.argmax())
    return Peak(
        float(fine[place]),
        float(logs.max()) + math.log(max(area, 1e-300)),
        fine,
        density / max(area, 1e-300),
        used.rows[int(table[at].argmax())],
        bool(place in (0, fine.size - 1) and (fine[place] <= low or fine[place] >= high)),
    )


def _cubic(x: Floats, y: Floats, at: Floats) -> Floats:
    """Cubic interpolation with slopes of parabolas through three points (Hermite)."""
    slope = np.gradient(y, x)
    place = np.clip(np.searchsorted(x, at) - 1, 0, x.size - 2)
    width = x[place + 1] - x[place]
    t = (at - x[place]) / width
    a, b = y[place], y[place + 1]
    c, d = slope[place] * width, slope[place + 1] * width
    return np.asarray(
        a * (1 + 2 * t) * (1 - t) ** 2 + c * t * (1 - t) ** 2 + b * t * t * (3 - 2 * t) + d * t * t * (t - 1)
    )
