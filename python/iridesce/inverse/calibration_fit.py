"""The response that a picture of a known film wants: smooth, not negative unless channels were mixed. Internal."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint
from iridesce.inverse.model import Problem
from iridesce.inverse.pictures import Picture

# Wavelengths of the response, nm: hats as wide as rings of a few um can tell apart.
KNOTS = np.arange(390.0, 771.0, 10.0)
# Thicknesses over which pixels are averaged.
_BINS = 700
_LEAST_BIN = 4
# A film must show so much of its colours: from its thinnest to its thickest, nm of optical path.
_LEAST_SPAN_NM = 250.0
# Weights of the roughness that are tried, of the normal matrix.
_ROUGH = np.geomspace(1e-7, 1e1, 17)
# Contact gaps that are tried where the thickness is a model, nm, and with which roughness.
_GAPS_NM = np.arange(-60.0, 61.0, 15.0)
_GAP_ROUGH = 1e-4
# Where weights >= 0 leave so many times what signed ones leave (or the noise), channels are mixed.
_MIXED = 1.5
# Normal matrix and right side to a solution.
Solved = Callable[[Floats, Floats], Floats]


@dataclass(frozen=True)
class ResponseFit:
    response: Floats
    haze: Floats
    misfit: float
    is_signed: bool


def contact_gap(
    problem: Problem, picture: Picture, known: Floats, usable: npt.NDArray[np.bool_], solved: Solved
) -> float:
    """What is to be added to a model's thickness: the least of the misfit, by a parabola."""

    def left(gap: float) -> float:
        thickness, means, _ = _profile(known + gap, picture, usable)
        columns = np.column_stack([_design(problem, thickness), np.ones(thickness.size)])
        size = float(np.trace(columns[:, :-1].T @ columns[:, :-1])) / KNOTS.size
        normal = columns.T @ columns + _GAP_ROUGH * size * _roughness()
        rest = [mean - columns @ solved(normal, columns.T @ mean) for mean in means]
        return float(sum(np.sum(one**2) / np.var(mean) for one, mean in zip(rest, means, strict=True)))

    lowest = float(known[usable].min())
    gaps = _GAPS_NM[_GAPS_NM + lowest >= 0.0]
    for step in (15.0, 4.0):
        sizes = np.array([left(float(gap)) for gap in gaps])
        best = int(sizes.argmin())
        middle = float(gaps[best])
        if step == 15.0:
            gaps = middle + step * np.array([-0.6, -0.3, 0.0, 0.3, 0.6])
            gaps = gaps[gaps + lowest >= 0.0]
        elif 0 < best < gaps.size - 1:
            low, mid, high = sizes[best - 1 : best + 2]
            middle += 0.5 * (low - high) / (low - 2.0 * mid + high) * float(gaps[1] - gaps[0])
    return middle


def _roughness() -> Floats:
    """Sum of squares of second differences of a spectrum; the constant has none."""
    bend = np.diff(np.eye(KNOTS.size), n=2, axis=0)
    rough = np.zeros((KNOTS.size + 1, KNOTS.size + 1))
    rough[:-1, :-1] = bend.T @ bend
    return rough


def _profile(
    known: Floats, picture: Picture, usable: npt.NDArray[np.bool_]
) -> tuple[Floats, list[Floats], list[float]]:
    """Mean light of each channel over all pixels of about one thickness, and its standard deviation."""
    nm, light = known[usable], picture.pixels[usable].astype(np.float64)
    low, high = float(nm.min()), float(nm.max())
    if high - low < _LEAST_SPAN_NM:
        raise complaint(
            f"thickness_nm spans {high - low:.0f} nm; a response can be learnt from {_LEAST_SPAN_NM:.0f} nm on, better from 2000",
            "thickness_nm",
            f"{_LEAST_SPAN_NM:.0f} nm wide or more",
            Words(f"{high - low:.0f} nm"),
        )
    bins = np.minimum(((nm - low) / (high - low) * _BINS).astype(int), _BINS - 1)
    count = np.bincount(bins, minlength=_BINS).astype(np.float64)
    full = count >= _LEAST_BIN
    if full.sum() < 60:
        raise complaint(
            f"only {int(full.sum())} thicknesses have {_LEAST_BIN} pixels or more; at least 60 are needed",
            "thickness_nm",
            f"60 thicknesses with {_LEAST_BIN} pixels each, or more",
            Words(int(full.sum())),
        )
    means, sds = [], []
    for c in range(3):
        mean = np.bincount(bins, light[:, c], minlength=_BINS)[full] / count[full]
        # What second differences leave: the film's own course is smooth over so narrow bins.
        noise = np.median(np.abs(mean[2:] - 2.0 * mean[1:-1] + mean[:-2])) / 0.6745 / math.sqrt(6.0)
        means.append(mean)
        sds.append(max(float(noise), 1e-4 * float(np.ptp(mean))))
    return np.bincount(bins, nm, minlength=_BINS)[full] / count[full], means, sds


def fit(problem: Problem, picture: Picture, known: Floats, usable: npt.NDArray[np.bool_]) -> ResponseFit:
    """Smooth spectra from the means of all pixels of about one thickness; not negative where such ones do."""
    thickness, means, sds = _profile(known, picture, usable)
    design = _design(problem, thickness)
    found, signed = (
        [_smooth(design, mean, sd, solved) for mean, sd in zip(means, sds, strict=True)]
        for solved in (not_negative, of_any_sign)
    )
    is_signed = any(
        np.std(one[2]) > _MIXED * max(float(np.std(other[2])), 1.05 * sd)
        for one, other, sd in zip(found, signed, sds, strict=True)
    )
    if is_signed:
        found = signed
    misfits = [
        float(np.sqrt(np.mean(left**2)) / max(float(np.std(mean)), 1e-30))
        for (_, _, left), mean in zip(found, means, strict=True)
    ]
    return ResponseFit(
        np.stack([q for q, _, _ in found], axis=1),
        np.array([o for _, o, _ in found]),
        float(np.mean(misfits)),
        is_signed,
    )


def _design(problem: Problem, thickness: Floats) -> Floats:
    """(thicknesses, knots): the film's light in each hat."""
    fine = np.arange(KNOTS[0] - 10.0, KNOTS[-1] + 10.5, 1.0)
    spectra = np.asarray(problem.with_thickness([thickness[:, None]]).reflectance(fine))
    hats = np.maximum(1.0 - np.abs(fine[:, None] - KNOTS) / (KNOTS[1] - KNOTS[0]), 0.0)
    return np.asarray(spectra @ (hats / hats.sum(axis=0)))


def _smooth(design: Floats, mean: Floats, sd: float, solved: Solved) -> tuple[Floats, float, Floats]:
    """The smoothest spectrum, and constant, that leave no more than the noise."""
    columns = np.column_stack([design, np.ones(mean.size)])
    normal, right = columns.T @ columns, columns.T @ mean
    size = float(np.trace(design.T @ design)) / KNOTS.size
    rough = _roughness()
    best: tuple[Floats, Floats] | None = None
    floor = None
    for weight in _ROUGH:
        q = solved(normal + weight * size * rough, right)
        left = mean - columns @ q
        size_left = float(np.sqrt(np.mean(left**2)))
        floor = size_left if floor is None else floor
        if best is None or size_left <= max(1.05 * sd, 1.03 * floor):
            best = (q, left)
        else:
            break
    assert best is not None
    return best[0][:-1], float(best[0][-1]), best[1]


def of_any_sign(normal: Floats, right: Floats) -> Floats:
    """Least squares."""
    ridge = 1e-12 * float(np.trace(normal)) / right.size
    return np.asarray(np.linalg.solve(normal + ridge * np.eye(right.size), right))


def not_negative(normal: Floats, right: Floats) -> Floats:
    """Least squares with every unknown >= 0 (Lawson and Hanson's active set, started from all free)."""
    free = np.ones(right.size, dtype=bool)
    ridge = 1e-12 * float(np.trace(normal)) / right.size
    for _ in range(4 * right.size):
        q = np.zeros(right.size)
        part = normal[np.ix_(free, free)] + ridge * np.eye(int(free.sum()))
        q[free] = np.linalg.solve(part, right[free])
        if (q[free] < 0.0).any():
            free &= q > 0.0
            continue
        pull = right - normal @ q
        pull[free] = 0.0
        if pull.max() <= 1e-9 * float(np.abs(right).max()):
            return q
        free[int(pull.argmax())] = True
        # A step back and forth ends where the pull is within rounding of nothing.
        trial = np.linalg.solve(normal[np.ix_(free, free)] + ridge * np.eye(int(free.sum())), right[free])
        if trial[np.flatnonzero(free) == int(pull.argmax())][0] <= 0.0:
            return q
    return np.maximum(q, 0.0)
