"""One film, several measurements: reflectance, transmittance, psi and delta at several angles, fitted together. Internal.

The measurements share the thicknesses, the index and an error of the angle; each has its own gain, lamp, stray light and
noise, which are integrated out of each by itself. Their evidences multiply.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint
from iridesce.inverse.blocks import AngleBlock, Block, PowerBlock
from iridesce.inverse.members import Member
from iridesce.inverse.model import Problem, describe
from iridesce.inverse.posterior import PRIOR_FILM, PRIOR_NONE, PRIOR_OTHER, log_sum, prior_density
from iridesce.inverse.results import FitResult, Solution
from iridesce.inverse.search import round_trip_rate
from iridesce.inverse.solve import student
from iridesce.inverse.summit import summit
from iridesce.inverse.tolerances import Tolerances
from iridesce.inverse.verdict import LEAST_LIT, lit_share
from iridesce.optics.medium import Medium
from iridesce.stack import Layer, Stack

# Steps of the search, radians of the round trip's phase; peaks so far below the best (log) are not climbed.
_STEP = 0.3
_FAR = 80.0
_MOST_TRIALS = 200_000
_MOST_PEAKS = 8
_PASS = 512
# An index to be fitted is anywhere within this, sd.
_FREE_INDEX = 0.3
_LEAST_LIKELY = 1e-4
# Films less likely than this are taken to move with their index as fringes do.
_LOOKED_AT = 0.01
_CLEAR = 0.95
_FRINGES_OF_A_LAMP = 1.5


@dataclass(frozen=True)
class _Axes:
    """What is unknown: thicknesses, then a shift of each index that is not known exactly, then that of the angle."""

    index: tuple[int, ...]
    """Which unknown layers have an index that may shift."""
    index_sd: tuple[float, ...]
    angle_sd: float

    def sds(self) -> list[float]:
        return [*self.index_sd, *([self.angle_sd] if self.angle_sd > 0.0 else [])]


@dataclass(frozen=True)
class _Peak:
    x: Floats
    covariance: Floats
    log_mass: float
    at_end: bool
    is_settled: bool


class Joint:
    """Several measurements against one film."""

    def __init__(
        self,
        problem: Problem,
        members: Sequence[Member],
        bounds: Floats,
        tolerances: Tolerances,
        angle_tolerance_deg: float,
        notes: list[str],
    ) -> None:
        self.problem, self.members, self.bounds, self.notes = problem, members, bounds, notes
        self.unknown = len(problem.unknown)
        self.tolerances = tolerances
        places, sds = [], []
        for which, model in enumerate(problem.index):
            if model is not None or (tolerances.stated and tolerances.index > 0.0):
                places.append(which)
                sds.append(_FREE_INDEX if model is not None else tolerances.index * self._n(which))
        self.axes = _Axes(tuple(places), tuple(sds), angle_tolerance_deg)
        self.grid_nm = np.unique(np.concatenate([one.every_nm for one in members]))
        self.indices = [
            np.broadcast_to(
                np.asarray(problem.stack.layers[place].medium.index(self.grid_nm), complex), self.grid_nm.shape
            )
            for place in problem.unknown
        ]
        trials = np.exp(np.linspace(np.log(bounds[:, 0] + 50.0), np.log(bounds[:, 1] + 50.0), 24)) - 50.0
        trials = np.maximum(trials, 0.0)  # where a range begins at 0, rounding goes below it
        self.blocks: list[Block] = []
        for one in members:
            if one.of.of_polarization:
                self.blocks.append(AngleBlock(one))
            else:
                nm, of = one.wavelength_nm, one.of
                stack = problem.with_thickness([trials[:, place, None] for place in range(self.unknown)])
                few = getattr(stack, of.quantity)(nm[:: max(1, nm.size // 24)], of.angle_deg, of.polarization)
                self.blocks.append(PowerBlock(one, float(np.mean(few))))

    def _n(self, which: int) -> float:
        medium = self.problem.stack.layers[self.problem.unknown[which]].medium
        return max(float(np.real(medium.index(float(self._middle()), extrapolate="hold"))), 1e-3)

    def _middle(self) -> float:
        return float(np.median(np.concatenate([one.wavelength_nm for one in self.members])))

    def _stack(self, thickness: Sequence[Any], shifts: Floats) -> Stack:
        layers = list(self.problem.stack.layers)
        for which, (place, value) in enumerate(zip(self.problem.unknown, thickness, strict=True)):
            medium = layers[place].medium
            if which in self.axes.index and shifts[self.axes.index.index(which)] != 0.0:
                medium = self._medium(medium.name, self.indices[which] + shifts[self.axes.index.index(which)])
            layers[place] = Layer(medium, value, layers[place].coherent)
        return Stack([self.problem.stack.first, *layers, self.problem.stack.last])

    def _spectra(self, points: Floats) -> list[Floats]:
        """What each measurement shows at points (m, axes): (m, channels) each."""
        out = [np.empty((len(points), block.channels)) for block in self.blocks]
        shifts = points[:, self.unknown :]
        kinds, place = np.unique(shifts, axis=0, return_inverse=True)
        for number, shift in enumerate(kinds):
            where = np.flatnonzero(place.reshape(-1) == number)
            stack = self._stack([points[where, one, None] for one in range(self.unknown)], shift)
            angle = float(shift[-1]) if self.axes.angle_sd > 0.0 else 0.0
            for block, rows in zip(self.blocks, out, strict=True):
                rows[where] = block.spectra(stack, angle)
        return out

    def _prior(self, points: Floats) -> Floats:
        total = np.zeros(len(points))
        for place, (low, high) in enumerate(self.bounds):
            total += np.log(prior_density(points[:, place], low, high))
        for place, sd in enumerate(self.axes.sds()):
            z = points[:, self.unknown + place] / sd
            total -= 0.5 * z * z + math.log(sd * math.sqrt(2.0 * math.pi))
        return total

    def _logs(self, points: Floats) -> Floats:
        spectra = self._spectra(points)
        total = self._prior(points)
        for block, rows in zip(self.blocks, spectra, strict=True):
            total = total + block.logs(rows)
        return np.asarray(total)

    def _fix(self, x: Floats) -> None:
        for block, rows in zip(self.blocks, self._spectra(x[None, :]), strict=True):
            block.fix(rows[0])

    # --- search

    def _starts(self) -> list[Floats]:
        shifts = len(self.axes.sds())
        free = [place for place, which in enumerate(self.axes.index) if self.problem.index[which] is not None]
        steps = [np.array([0.0, -0.12, 0.12]) if place in free else np.zeros(1) for place in range(shifts)]
        axes = []
        for (low, high), fastest in zip(self.bounds, self._fastest(), strict=True):
            axes.append(np.linspace(low, high, max(3, math.ceil((high - low) * fastest / _STEP) + 1)))
        total = math.prod(axis.size for axis in axes)
        if total > _MOST_TRIALS:
            raise complaint(
                f"the thicknesses asked for make {total} trials, at most {_MOST_TRIALS} are made: give a "
                "narrower thickness_range_nm",
                "thickness_range_nm",
                f"narrow enough for {_MOST_TRIALS} trials",
                Words(total),
            )
        thickness = np.stack([one.reshape(-1) for one in np.meshgrid(*axes, indexing="ij")], axis=1)
        found: list[tuple[float, Floats]] = []
        for shift in product(*steps):
            points = np.column_stack([thickness, np.tile(np.array(shift), (total, 1)).reshape(total, shifts)])
            logs = np.empty(total)
            for start in range(0, total, _PASS):
                part = points[start : start + _PASS]
                logs[start : start + _PASS] = self._prior(part) + sum(
                    block.scan(rows) for block, rows in zip(self.blocks, self._spectra(part), strict=True)
                )
            cube = logs.reshape([axis.size for axis in axes])
            padded = np.pad(cube, 1, constant_values=-np.inf)
            top = np.ones(cube.shape, dtype=bool)
            for move in product((0, 1, 2), repeat=cube.ndim):
                if move != (1,) * cube.ndim:
                    other = padded[tuple(slice(m, m + n) for m, n in zip(move, cube.shape, strict=True))]
                    top &= cube >= other
            found += [(float(logs[place]), points[place]) for place in np.flatnonzero(top.reshape(-1))]
        found.sort(key=lambda one: -one[0])
        return [x for log, x in found if log > found[0][0] - _FAR][: 3 * _MOST_PEAKS]

    def _climb(self, start: Floats) -> _Peak:
        """The top of the posterior near a start; its width follows its own curvature."""
        low, high = np.full(start.size, -np.inf), np.full(start.size, np.inf)
        low[: self.unknown], high[: self.unknown] = self.bounds[:, 0], self.bounds[:, 1]
        fastest = self._fastest()
        step = np.array([*(0.05 / fastest), *(0.02 * sd for sd in self.axes.sds())])
        longest = np.array([*(0.5 / fastest), *(1.5 * sd for sd in self.axes.sds())])
        top = summit(self._logs, self._fix, start, step, longest, (low, high))
        value = float(self._logs(top.x[None, :])[0])
        # As in fits of one spectrum: of the top, not of the way to it.
        spectra = self._spectra(top.x[None, :])
        value += sum(block.log_full(rows[0]) for block, rows in zip(self.blocks, spectra, strict=True))
        volume = float(np.linalg.slogdet(2.0 * math.pi * top.covariance)[1])
        at_end = bool((top.x <= low + 1e-9).any() or (top.x >= high - 1e-9).any())
        return _Peak(top.x, top.covariance, value + 0.5 * volume, at_end, top.is_settled)

    def _fastest(self) -> Floats:
        """Radians of the round trip a nm, of each unknown layer."""
        return np.array(
            [
                max(float(round_trip_rate(self.problem, block.nm, which).max()) for block in self.blocks)
                for which in range(self.unknown)
            ]
        )

    def _nearer(self, start: Floats) -> tuple[Floats, float]:
        """Towards the top by ever smaller steps of each thickness: far from it the curvature may point anywhere."""
        x, log, reach = start, -math.inf, 2.0 / self._fastest()
        for turn in range(7):
            for axis in range(self.unknown):
                points = np.tile(x, (7, 1))
                points[:, axis] += reach[axis] * 0.5**turn * np.linspace(-0.5, 0.5, 7)
                points[:, axis] = np.clip(points[:, axis], *self.bounds[axis])
                spectra = self._spectra(points)
                logs = self._prior(points) + sum(
                    block.scan(rows) for block, rows in zip(self.blocks, spectra, strict=True)
                )
                best = int(np.argmax(logs))
                x, log = points[best], float(logs[best])
        return x, log

    # --- answer

    def result(self, probability: float) -> FitResult:
        starts = self._starts()
        peaks = self._peaks(starts[:3])
        # Noise and correlation are those of what the best film leaves; then all are asked again.
        for turn in range(2):
            for block, rows in zip(self.blocks, self._spectra(peaks[0].x[None, :]), strict=True):
                block.learn(rows[0])
            peaks = self._peaks([*(peak.x for peak in peaks), *(starts if turn == 0 else [])])
        bare = self._spectra(np.zeros((1, self.unknown + len(self.axes.sds()))))
        without = [block.without_film(rows[0]) for block, rows in zip(self.blocks, bare, strict=True)]
        logs = np.array(
            [
                math.log(PRIOR_NONE) + sum(one for one, _ in without),
                math.log(PRIOR_OTHER) + sum(one for _, one in without),
                *(math.log(PRIOR_FILM) + peak.log_mass for peak in peaks),
            ]
        )
        shares = np.exp(logs - log_sum(logs))
        order = [place for place in np.argsort(-shares[2:]) if shares[2 + place] >= _LEAST_LIKELY * shares[2:].max()]
        solutions = tuple(self._told(peaks[place], float(shares[2 + place]), probability) for place in order)
        rest = float(shares[2:].sum()) - sum(one.weight for one in solutions)
        verdict = self._verdict(solutions, [peaks[place] for place in order], float(shares[0]), float(shares[1]))
        self._remarks(solutions, verdict)
        if solutions and not peaks[order[0]].is_settled:
            self.notes.append(
                "the search did not come to rest on a top: the thickness and its interval are those of where it stopped"
            )
        sds = np.concatenate([np.full(block.nm.size, 1.0) for block in self.blocks])
        return FitResult(
            solutions,
            np.concatenate([block.nm for block in self.blocks]),
            np.concatenate([block.values for block in self.blocks]),
            sds,
            0.0,
            probability,
            describe(self.problem),
            tuple(self.notes),
            verdict,
            float(shares[0]),
            float(shares[1]) + rest,
            tuple(one.of for one in self.members),
            tuple(block.nm.size for block in self.blocks),
        )

    def _peaks(self, starts: Sequence[Floats]) -> list[_Peak]:
        near = [self._nearer(start) for start in starts]
        near = [one for one in near if one[1] > max(log for _, log in near) - 0.5 * _FAR]
        kept: list[_Peak] = []
        climbed = (self._climb(start) for start in self._unlike([x for x, _ in sorted(near, key=lambda one: -one[1])]))
        for peak in sorted(climbed, key=lambda one: -one.log_mass):
            beside = [
                bool((np.abs(peak.x - other.x) <= 3.0 * np.sqrt(np.diag(other.covariance)) + 1e-6).all())
                for other in kept
            ]
            if not any(beside):
                kept.append(peak)
        return kept

    def _unlike(self, starts: Sequence[Floats]) -> list[Floats]:
        kept: list[Floats] = []
        for one in starts:
            if not any((np.abs(one - other) < 2e-3 * (1.0 + np.abs(other))).all() for other in kept):
                kept.append(one)
        return kept[:_MOST_PEAKS]

    def _told(self, peak: _Peak, weight: float, probability: float) -> Solution:
        self._fix(peak.x)
        told = [block.told(rows[0]) for block, rows in zip(self.blocks, self._spectra(peak.x[None, :]), strict=True)]
        fitted = np.concatenate([one[0] for one in told])
        measured = np.concatenate([block.values for block in self.blocks])
        sd = np.sqrt(np.diag(peak.covariance))
        reach = student(probability, 1e6)
        thickness = [float(one) for one in peak.x[: self.unknown]]
        moved = self._moved_by_index(peak, weight)
        by_nm = [self.tolerances.of_wavelengths(self.problem, self.grid_nm, which) for which in range(self.unknown)]
        by_nm = np.multiply(thickness, by_nm).tolist()
        accuracy = [math.hypot(*three) for three in zip(sd.tolist(), moved, by_nm, strict=False)]
        said = by_nm if self.tolerances.stated_nm else [0.0] * self.unknown
        whole = [math.hypot(*two) for two in zip(sd.tolist(), said, strict=False)]
        precision = self._precision(peak)
        intervals, precise, accurate = (
            [(max(h - reach * s, 0.0), h + reach * s) for h, s in zip(thickness, sds, strict=True)]
            for sds in (whole, precision, accuracy)
        )
        index = {}
        for place, which in enumerate(self.axes.index):
            shift, shift_sd = float(peak.x[self.unknown + place]), float(sd[self.unknown + place])
            index[self.problem.unknown[which] + 1] = {"n": self._n(which) + shift, "n_sd": shift_sd}
        lone = self.unknown == 1
        first = next((one for one, block in zip(told, self.blocks, strict=True) if not block.of.of_polarization), None)
        gain = 1.0 if first is None else float(np.mean(first[1]))
        stray = () if first is None or not np.any(first[2]) else (float(np.mean(first[2])),)
        left = [
            (block.values - one[0]) if block.of.quantity != "delta" else (block.values - one[0] + 180.0) % 360.0 - 180.0
            for one, block in zip(told, self.blocks, strict=True)
        ]
        lit = [lit_share(one[1]) for one in told]
        chi2 = [float(np.mean((part / _sd(block)) ** 2)) for part, block in zip(left, self.blocks, strict=True)]
        return Solution(
            thickness[0] if lone else tuple(thickness),
            intervals[0] if lone else tuple(intervals),
            whole[0] if lone else tuple(whole),
            float(np.sqrt(np.mean(np.concatenate(left) ** 2))),
            float(np.mean(chi2)),
            weight,
            gain,
            0.0,
            0.0,
            stray,
            0.0,
            index,
            np.concatenate([block.nm for block in self.blocks]),
            measured - np.concatenate(left) if measured.size == fitted.size else fitted,
            max(block.kappa for block in self.blocks),
            float(peak.x[-1]) if self.axes.angle_sd > 0.0 else 0.0,
            lit=min(lit),
            precision_nm=precision[0] if lone else tuple(precision),
            precision_interval_nm=precise[0] if lone else tuple(precise),
            accuracy_nm=accuracy[0] if lone else tuple(accuracy),
            accuracy_interval_nm=accurate[0] if lone else tuple(accurate),
        )

    def _moved_by_index(self, peak: _Peak, weight: float) -> list[float]:
        """Standard deviation of each thickness by indices of which nothing was said: what the films move where one is off."""
        squares = np.zeros(self.unknown)
        by, problem = self.tolerances.index, self.problem
        if self.tolerances.stated:
            return [0.0] * self.unknown
        for which, place in enumerate(problem.unknown):
            if problem.index[which] is not None:
                continue
            if weight < _LOOKED_AT:
                squares[which] += (by * peak.x[which]) ** 2
                continue
            layers = list(problem.stack.layers)
            medium = self._medium(layers[place].medium.name, self.indices[which] * (1.0 + by))
            layers[place] = Layer(medium, layers[place].thickness_nm, layers[place].coherent)
            self.problem = replace(problem, stack=Stack([problem.stack.first, *layers, problem.stack.last]))
            # Many of its own widths away: along the ridge of n h first.
            start = peak.x.copy()
            start[which] /= 1.0 + by
            squares += (self._climb(self._nearer(start)[0]).x - peak.x)[: self.unknown] ** 2
            self.problem = problem
        self._fix(peak.x)
        return [float(one) for one in np.sqrt(squares)]

    def _medium(self, name: str, index: Any) -> Medium:
        rows = zip(self.grid_nm, index.real, index.imag, strict=True)
        lines = "\n".join(f"{nm:.17g},{n:.17g},{k:.17g}" for nm, n, k in rows)
        return Medium._from_text(f"nm,n,k\n{lines}\n", name)

    def _precision(self, peak: _Peak) -> list[float]:
        """Standard deviations of the thicknesses where all that has a tolerance is as found: films measured alike share it."""
        fitted = [
            self.unknown + place for place, which in enumerate(self.axes.index) if self.problem.index[which] is not None
        ]
        free = [*range(self.unknown), *fitted]
        held = np.linalg.pinv(np.linalg.pinv(peak.covariance, hermitian=True)[np.ix_(free, free)], hermitian=True)
        return [float(one) for one in np.sqrt(np.maximum(np.diag(held)[: self.unknown], 0.0))]

    def _verdict(self, solutions: tuple[Solution, ...], peaks: list[_Peak], none: float, other: float) -> str:
        if none > 0.5 or not solutions:
            return "none"
        best = solutions[0]
        if other > 0.5 or best.kappa >= 10.0 or best.lit < LEAST_LIT or peaks[0].at_end or not peaks[0].is_settled:
            return "doubtful"
        known = any(block.of.of_polarization or block.of.gain is not None for block in self.blocks)
        if not known and self._fringes(peaks[0].x) < _FRINGES_OF_A_LAMP:
            return "ambiguous"
        return "clear" if self._share(solutions, peaks) > _CLEAR else "ambiguous"

    def _fringes(self, x: Floats) -> float:
        turns = [
            max(float(np.ptp(round_trip_rate(self.problem, block.nm, which))) for block in self.blocks)
            for which in range(self.unknown)
        ]
        return float(x[: self.unknown] @ np.array(turns) / (2.0 * math.pi))

    def _share(self, solutions: tuple[Solution, ...], peaks: list[_Peak]) -> float:
        """Probability of all films within a quarter of a wave of the best."""
        quarter = np.array([self._middle() / (4.0 * max(self._n(which), 1.0)) for which in range(self.unknown)])
        best = peaks[0].x[: self.unknown]
        near = np.minimum(quarter, 0.25 * best + 3.0)
        return sum(
            one.weight
            for one, peak in zip(solutions, peaks, strict=True)
            if (np.abs(peak.x[: self.unknown] - best) <= near).all()
        )

    def _remarks(self, solutions: tuple[Solution, ...], verdict: str) -> None:
        if verdict == "none":
            self.notes.append("no film is the likeliest explanation of these measurements together")
        if not solutions:
            return
        if solutions[0].lit < LEAST_LIT:
            self.notes.append(
                f"of one measurement the fringes of this film are seen in {solutions[0].lit:.0%} of the channels alone"
            )
        if solutions[0].kappa > 1.0:
            self.notes.append(
                f"the best film misses a measurement by about {solutions[0].kappa:g} times the noise: the index, an angle, "
                "its calibration, or another stack"
            )


def _sd(block: Block) -> Floats:
    sd = block.engine.of.sd if isinstance(block, PowerBlock) else block.sd if isinstance(block, AngleBlock) else None
    assert sd is not None
    return sd


def joint(
    problem: Problem,
    members: Sequence[Member],
    bounds: Floats,
    tolerances: Tolerances,
    angle_tolerance_deg: float,
    probability: float,
    notes: list[str],
) -> FitResult:
    """The answer of all measurements together."""
    found = Joint(problem, members, bounds, tolerances, angle_tolerance_deg, notes).result(probability)
    return replace(found, notes=tuple(dict.fromkeys(found.notes)))
