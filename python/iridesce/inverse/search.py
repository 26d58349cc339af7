"""Where to start a fit: every thickness that could be, found globally. Internal.

Three steps. A Fourier transform over the round trip's own phase, which is dispersion and angle corrected, tells which thick
films show periodic fringes at all. At these, and at every thin film, the whole model is compared with the data, gain and
baseline being fitted at each trial. The local minima of that misfit are the starts.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint
from iridesce.inverse.model import HarmonicModel, Problem, phase_rate
from iridesce.inverse.solve import Data

# Phase between two trials, radians at the wavelength where it grows fastest: a fit converges from well beyond half of it.
_STEP = 0.7
# Films of less than so many fringes over the spectrum are tried in finer steps: a free gain and baseline make up for so much of
# a thin film that its minima are narrow and lie close together.
_THIN_FRINGES = 1.5
_FINER = 8
# Up to so many fringes over the spectrum every thickness is tried; beyond, those that the Fourier transform shows.
_FEW_FRINGES = 3.0
# Thicknesses are tried where the periodic part of the data is this share of the largest.
_GATE = 0.25
_MOST_TRIALS = 60_000
_PASS = 1 << 21


Start = tuple[Floats, float]
"""Thicknesses, and the sd of the instrument's line (nm) with which they came out best."""


def starts(problem: Problem, model: object, data: Data, bounds: Floats, lines: list[float], count: int) -> list[Start]:
    """Where to start, best first. ``lines``: sd of the instrument's line to try, nm."""
    if len(problem.unknown) == 1:
        return _one(problem, model, data, bounds[0], lines, count)
    return [(thickness, lines[0]) for thickness in _several(problem, data, bounds, count)]


def _one(problem: Problem, model: object, data: Data, bounds: Floats, lines: list[float], count: int) -> list[Start]:
    low, high = bounds
    rate = round_trip_rate(problem, data.wavelength_nm, 0)
    step = _STEP / rate.max()
    trials = np.arange(low, high + step, step)
    trials[-1] = min(trials[-1], high)
    fringes = trials * np.ptp(rate) / (2.0 * np.pi)
    few = fringes <= _FEW_FRINGES
    chosen = few
    if not few.all():
        periodic = _periodic(data, rate, trials)
        chosen = few | (periodic >= _GATE * periodic[~few].max())
    thin = np.flatnonzero(fringes <= _THIN_FRINGES)
    if thin.size:
        end = trials[thin[-1]]
        fine = np.linspace(low, end, _FINER * (thin.size - 1) + 1)
        trials = np.r_[fine, trials[thin[-1] + 1 :]]
        chosen = np.r_[np.ones(fine.size, dtype=bool), chosen[thin[-1] + 1 :]]
    where = np.flatnonzero(chosen)
    misfit = np.full(trials.size, np.inf)
    if not isinstance(model, HarmonicModel):
        lines = lines[:1]  # the plain spectra below know no line
    by_line = np.stack([_misfits(problem, model, data, trials[where], sd) for sd in lines])
    misfit[where] = by_line.min(axis=0)
    line = np.zeros(trials.size)
    line[where] = np.array(lines)[by_line.argmin(axis=0)]
    # Local minima among neighbours that were tried.
    before, after = np.r_[np.inf, misfit[:-1]], np.r_[misfit[1:], np.inf]
    # A plateau is what the baseline alone leaves, the gain being 0.
    lowest = (misfit <= before) & (misfit <= after) & ((misfit < before) | (misfit < after))
    minima = np.flatnonzero(np.isfinite(misfit) & lowest)
    if minima.size == 0:
        minima = where
    best = minima[np.argsort(misfit[minima], kind="stable")[:count]]
    return [(np.array([trials[place]]), float(line[place])) for place in best]


def round_trip_rate(problem: Problem, wavelength_nm: Floats, which: int) -> Floats:
    """Radians a nm of the round trip; for an absorbing layer by the real part of its wavenumber."""
    rate = phase_rate(problem, wavelength_nm, which)
    if rate is not None:
        return rate
    medium = problem.stack.layers[problem.unknown[which]].medium
    index = np.broadcast_to(np.asarray(medium.index(wavelength_nm, extrapolate="hold")), wavelength_nm.shape)
    first = np.asarray(problem.stack.first.index(wavelength_nm, extrapolate="hold")).real
    kz = np.sqrt(index**2 - (first * np.sin(np.radians(problem.angle_deg))) ** 2 + 0j)
    # Where it decays rather than turns, the decay sets the scale.
    return np.asarray(4.0 * np.pi * np.maximum(np.abs(kz.real), np.abs(kz.imag)) / wavelength_nm)


def _periodic(data: Data, rate: Floats, trials: Floats) -> Floats:
    """A Fourier transform over the round trip's phase: the share of the data, smooth part aside, that goes as its cos and sin."""
    x = np.linspace(-1.0, 1.0, data.wavelength_nm.size)
    weight = data.weight
    smooth, _ = np.linalg.qr(np.stack([x**power for power in range(5)], axis=1) * weight[:, None])
    target = data.measured * weight
    target = target - smooth @ (smooth.T @ target)
    shares = np.empty(trials.size)
    size = target @ target
    for start in range(0, trials.size, 256):
        part = slice(start, start + 256)
        # exp(i phase) of evenly spaced thicknesses, each from the one before by a product.
        turn = np.empty((trials[part].size, rate.size), dtype=np.complex128)
        turn[0] = np.exp(1j * rate * trials[start])
        turn[1:] = np.exp(1j * rate * (trials[1] - trials[0]))
        np.cumprod(turn, axis=0, out=turn)
        cosine, sine = turn.real * weight, turn.imag * weight
        # Least squares with cos and sin, the smooth part aside: two by two normal equations.
        c0, s0 = cosine @ smooth, sine @ smooth
        cc = (cosine * cosine).sum(axis=1) - (c0 * c0).sum(axis=1)
        ss = (sine * sine).sum(axis=1) - (s0 * s0).sum(axis=1)
        cs = (cosine * sine).sum(axis=1) - (c0 * s0).sum(axis=1)
        c, s = cosine @ target, sine @ target
        determinant = cc * ss - cs * cs
        good = determinant > 1e-9 * (cc * ss)
        solved = (ss * c * c - 2.0 * cs * c * s + cc * s * s) / np.where(good, determinant, 1.0)
        shares[part] = np.where(good, solved, 0.0)
    return shares / max(float(size), 1e-300)


def _misfits(problem: Problem, model: object, data: Data, trials: Floats, sd: float) -> Floats:
    """The misfit of every trial, gain and baseline fitted."""
    if not isinstance(model, HarmonicModel):
        # Films whose fringes are wide need fewer points: half of both, while neighbours stay within half a radian.
        steps = float(np.median(np.diff(data.wavelength_nm)))
        turn = float(round_trip_rate(problem, data.wavelength_nm, 0)[0] * trials.max() / data.wavelength_nm[0] * steps)
        if turn < 0.5 and data.wavelength_nm.size >= 240:
            return 2.0 * _misfits(problem, model, data.thinned(2), trials, sd)
        if trials.size > 64 and data.wavelength_nm.size >= 240:
            half = trials.size // 2
            return np.concatenate(
                [_misfits(problem, model, data, trials[:half], sd), _misfits(problem, model, data, trials[half:], sd)]
            )
    misfit = np.empty(trials.size)
    step = max(1, _PASS // data.wavelength_nm.size)
    for start in range(0, trials.size, step):
        part = trials[start : start + step]
        if isinstance(model, HarmonicModel):
            spectra = model.many(part, sd * sd)
        else:
            stack = problem.with_thickness([part[:, None]])
            spectra = np.asarray(
                getattr(stack, problem.quantity)(data.wavelength_nm, problem.angle_deg, problem.polarization)
            )
        misfit[start : start + step] = linear_misfits(spectra, data)
    return misfit


def linear_misfits(spectra: Floats, data: Data) -> Floats:
    """Weighted sums of squares of many spectra against the data, each with its best gain > 0 and baseline."""
    target = data.measured * data.weight
    weighted = spectra * data.weight
    if data.baseline:
        smooth, _ = np.linalg.qr(data.terms * data.weight[:, None])
        target = target - smooth @ (smooth.T @ target)
        weighted = weighted - (weighted @ smooth) @ smooth.T
    if data.gain is not None:
        return np.asarray(((target - data.gain * weighted) ** 2).sum(axis=1))
    size = (weighted**2).sum(axis=1)
    overlap = weighted @ target
    return np.asarray(target @ target - np.where(overlap > 0.0, overlap, 0.0) ** 2 / np.maximum(size, 1e-300))


def _several(problem: Problem, data: Data, bounds: Floats, count: int) -> list[Floats]:
    """A grid over all unknown thicknesses, then its lowest points that have no lower neighbour."""
    thinned = data.thinned(max(1, data.wavelength_nm.size // 160))
    axes = []
    for which, (low, high) in enumerate(bounds):
        step = 1.2 * _STEP / round_trip_rate(problem, thinned.wavelength_nm, which).max()
        axes.append(np.linspace(low, high, max(2, int(np.ceil((high - low) / step)) + 1)))
    shape = tuple(axis.size for axis in axes)
    total = int(np.prod(shape, dtype=np.int64))
    if total > _MOST_TRIALS:
        raise complaint(
            f"{len(axes)} unknown thicknesses within {[(float(a), float(b)) for a, b in bounds]} nm make {total} trials, "
            f"at most {_MOST_TRIALS} are made: give narrower thickness_range_nm, one (low, high) for each",
            "thickness_range_nm",
            f"narrow enough for {_MOST_TRIALS} trials",
            Words(total),
        )
    grid = np.stack([mesh.reshape(-1) for mesh in np.meshgrid(*axes, indexing="ij")])
    misfit = np.empty(total)
    step = max(1, _PASS // thinned.wavelength_nm.size)
    for start in range(0, total, step):
        stack = problem.with_thickness([row[start : start + step, None] for row in grid])
        spectra = getattr(stack, problem.quantity)(thinned.wavelength_nm, problem.angle_deg, problem.polarization)
        misfit[start : start + step] = linear_misfits(np.asarray(spectra), thinned)
    cube = misfit.reshape(shape)
    padded = np.pad(cube, 1, constant_values=np.inf)
    lowest = np.ones(shape, dtype=bool)
    for shift in product((0, 1, 2), repeat=len(shape)):
        if shift != (1,) * len(shape):
            neighbour = padded[tuple(slice(s, s + n) for s, n in zip(shift, shape, strict=True))]
            lowest &= cube <= neighbour
    minima = np.flatnonzero(lowest.reshape(-1))
    best = minima[np.argsort(misfit[minima], kind="stable")[: 2 * count]]
    return [grid[:, place] for place in best]
