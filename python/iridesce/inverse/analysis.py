"""One spectrum, from the minima of its misfit to the posterior and the verdict. Internal."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.inverse.candidates import Search, model_of, paled
from iridesce.inverse.data import explained, scatter, too_much, weights_of, without_lamp
from iridesce.inverse.full import Full
from iridesce.inverse.model import HarmonicModel, Model, Problem, describe, harmonics
from iridesce.inverse.peak import climb, together
from iridesce.inverse.posterior import (
    PRIOR_FILM,
    PRIOR_NONE,
    PRIOR_OTHER,
    Engine,
    Light,
    Measured,
    Nuisance,
    log_sum,
    prior_density,
    temper,
)
from iridesce.inverse.remarks import Known, remarks
from iridesce.inverse.results import FitResult, Solution, apart
from iridesce.inverse.search import round_trip_rate, starts
from iridesce.inverse.solve import Data, Fitted, student
from iridesce.inverse.tolerances import Tolerances, by_index_off, widened, with_index_off
from iridesce.inverse.verdict import FRINGES_OF_A_LAMP, Asked, lit_share, verdict_of
from iridesce.optics.averages import FWHM

# Explanations whose probability is below this share of the best one's are not listed.
_LEAST_LIKELY = 1e-4
# The noise is at least this share of the largest value: below, it is the rounding of the models.
_ROUNDING = 2e-6
# Minima that are this much less likely, in units of the logarithm, are not looked at closely.
_LOOK = 16.0
_MOST_PEAKS = 12
# The scan under a lamp: up to so many fringes, in steps of so much phase (radians), peaks within so much of the best.
_SCANNED_FRINGES = 12.0
_SCAN_STEP = 0.25
_FAR = 60.0
_STARTS = 10
# An unknown line of the instrument, or a film that is uneven by as much, has this mean (sd, nm): spectrometers have 0.2 to 4 nm.
# Without it thick films whose fringes are all but gone pass for anything smooth.
_MEAN_LINE_NM = 1.5
# Lines of the instrument (sd, nm) that are tried where it is unknown; uneven films look like wider ones.
_LINES_NM = (0.0, 0.8, 2.0)


@dataclass(frozen=True)
class _Found:
    """A minimum and the search that found it."""

    fitted: Fitted
    search: Search
    log_evidence: float

    @property
    def spectrum(self) -> Floats:
        """By the model that the search had."""
        return self.search.model.value(self.fitted.parameters)


class Analysis:
    """One spectrum, from its minima to its posterior."""

    def __init__(
        self,
        problem: Problem,
        data: Data,
        sd: Floats | None,
        light: Light,
        line: float | None,
        bounds: Floats,
        notes: list[str],
        full: tuple[Floats, Floats] | None = None,
        reference: Floats | None = None,
    ) -> None:
        self.problem, self.data, self.sd, self.light = problem, data, sd, light
        self.line, self.bounds, self.notes = line, bounds, notes
        self.model: Model = model_of(problem, data.wavelength_nm)
        self.reference = reference
        # Channels that are full, and what they hold at least.
        self.full = None if full is None else Full(*full)
        self.full_model = None if full is None else model_of(problem, full[0])
        # Size of noise that neighbours share, and how many channels share it, where the data show such.
        self.shared: tuple[float, float] | None = None
        self.unknown = len(problem.unknown)
        # Only where one thickness is all that is unknown does its posterior have one axis.
        self.single = self.unknown == 1 and problem.index_count == 0

    def result(
        self,
        pliable: bool,
        probability: float,
        tolerances: Tolerances,
        more: Sequence[tuple[Fitted, Search]] = (),
    ) -> FitResult:
        """The answer. ``more``: films to look at beside those that are found."""
        self.met = found = [*self._minima(pliable), *more]
        self.engine = engine = Engine(self._measured(found), self.light)
        if self.shared is not None:
            engine.tempered = self.shared[1]
        rated = self._rated(engine, found)
        if rated:
            # Twice: the first temper is that of an answer chosen without one.
            for _ in range(2):
                best = rated[0].spectrum
                response, stray = engine.explain(best, self._best_row(engine, best))
                left = (engine.of.measured - response * best - stray) / engine.of.sd
                before, engine.tempered = engine.tempered, temper(left)
                if engine.tempered == before:
                    break
                # Tempered, none of the others comes nearer than by this.
                near = [one for one in rated if one.log_evidence > rated[0].log_evidence - _LOOK * engine.tempered]
                rated = self._rated(engine, [(one.fitted, one.search) for one in near])
        if engine.tempered > 1.5:
            self.notes.append("what is left hangs together along the spectrum; the intervals are widened for it")
        self.rated = rated
        top = rated[0].log_evidence if rated else 0.0
        near = [one for one in rated[:_MOST_PEAKS] if one.log_evidence > top - _LOOK]
        solved = [self._solution(engine, one, probability, tolerances) for one in near]
        return self._answer(engine, solved, probability, tolerances)

    # --- minima

    def _minima(self, pliable: bool) -> list[tuple[Fitted, Search]]:
        search = Search(self.problem, self.model, self.data, self.line, self.bounds)
        found = [(one, search) for one in search.candidates()]
        if found and self.sd is None:
            weight = weights_of(found[0][0].curve, self.data, self.notes)
            if weight is not None:
                self.data = replace(self.data, weight=weight)
                search = Search(self.problem, self.model, self.data, self.line, self.bounds)
                solver = search.solver()
                found = [
                    (one, search) for one in search.unique([search.refined(solver, one.parameters) for one, _ in found])
                ]
        if self.single and self.light.gain is not None and not self.light.exact:
            # A reference is good to a few per cent: the thin films that this hides are no minima under an even gain.
            if pliable and not (found and self._explains(found[0][0])):
                found = found + self._drifting()
            lines = [self.line] if self.line is not None else [0.0]
            solver = search.solver()
            thin = [solver.at(np.array([h, line * line])) for h, line in self._scanned(found, lines)]
            return found + [(one, search) for one in thin]
        if found and self._explains(found[0][0]):
            limit = found[0][0].misfit / max(self.data.wavelength_nm.size, 1) * 60.0
            return [(one, search) for one, search in found if one.misfit < found[0][0].misfit + 4.0 * limit]
        if not pliable:
            return found
        if self.light.gain is not None:
            return found + self._drifting()
        bent = Search(self.problem, self.model, replace(self.data, bend=2, baseline=3), self.line, self.bounds)
        if not self.single:
            return found + [(one, bent) for one in bent.candidates()[:8]]
        # Under a lamp of any course: every thin film by its evidence, thick ones by their period.
        solver = bent.solver()
        lines = [self.line] if self.line is not None else list(_LINES_NM)
        far = []
        for thickness, line in [*self._scanned(found, lines), *self._under_a_lamp(lines)]:
            if self.bounds[0, 0] <= thickness <= self.bounds[0, 1]:
                far.append((solver.at(np.array([thickness, line * line])), bent))
        return found + far

    def _drifting(self) -> list[tuple[Fitted, Search]]:
        """Minima under a baseline that is slanted and bowed, where the gain is known."""
        search = Search(self.problem, self.model, replace(self.data, baseline=3), self.line, self.bounds)
        return [(one, search) for one in search.candidates()[:8]]

    def _explains(self, best: Fitted) -> bool:
        """Whether nothing smooth is left."""
        residual = (self.data.measured - best.curve) * self.data.weight
        is_explained, shared = explained(residual, self.data.wavelength_nm)
        self.shared = shared if self.sd is None else None
        return is_explained

    def _under_a_lamp(self, lines: list[float]) -> list[tuple[float, float]]:
        """Minima of the spectrum over its own smooth course, for counts that were never divided by the lamp."""
        of = harmonics(self.problem, self.data.wavelength_nm)
        mean = np.ones_like(self.data.wavelength_nm) if of is None else np.maximum(of.base, 1e-6)
        divided = without_lamp(self.data.wavelength_nm, self.data.measured, mean)
        if divided is None:
            return []
        nm, values, weight = divided
        data = Data(nm, values, weight, None, 0, 1)
        other = Search(self.problem, model_of(self.problem, nm), data, self.line, self.bounds)
        found = starts(self.problem, other.model, data, self.bounds, lines, _STARTS)
        solver = other.solver()
        quick = [solver.solve(np.array([thickness[0], line * line]), [0], 8) for thickness, line in found]
        quick = [one for one in quick if one.gain[0] > 0.0]
        quick.sort(key=lambda one: one.misfit)
        return [(float(one.parameters[0]), math.sqrt(one.parameters[1])) for one in quick[:_STARTS]]

    def _scanned(self, found: list[tuple[Fitted, Search]], lines: list[float]) -> list[tuple[float, float]]:
        """Peaks of the evidence on a grid: what explains the data under a lamp that may bend as it likes."""
        rate = round_trip_rate(self.problem, self.data.wavelength_nm, 0)
        low = float(self.bounds[0, 0])
        high = min(float(self.bounds[0, 1]), 2.0 * math.pi * _SCANNED_FRINGES / float(np.ptp(rate)))
        if high <= low:
            return []
        grid = np.arange(low, high, _SCAN_STEP / float(rate.max()))
        of = self._measured(found)
        finest = float(self.data.wavelength_nm[0]) ** 2 / (3.0 * high)
        step = max(
            1, min(of.wavelength_nm.size // 150, int(finest / 6.0 / float(np.median(np.diff(of.wavelength_nm)))))
        )
        engine = Engine(of.averaged(step), self.light)
        model = model_of(self.problem, nm := engine.of.wavelength_nm)
        if isinstance(model, HarmonicModel):
            spectra = model.many(grid, lines[0] ** 2)
        else:
            stack = self.problem.with_thickness([grid[:, None]])
            spectra = np.asarray(
                getattr(stack, self.problem.quantity)(nm, self.problem.angle_deg, self.problem.polarization)
            )
        logs = np.array([log_sum(line) for line in engine.log_evidences(spectra, engine.scan())])
        logs = logs + np.log(prior_density(grid, low, high))
        before, after = np.r_[-np.inf, logs[:-1]], np.r_[logs[1:], -np.inf]
        tops = np.flatnonzero((logs >= before) & (logs > after) & (logs > logs.max() - _FAR))
        best = tops[np.argsort(-logs[tops], kind="stable")[:_STARTS]]
        return [(float(grid[place]), line) for place in best for line in lines]

    def _measured(self, found: list[tuple[Fitted, Search]]) -> Measured:
        """The data with the standard deviation of each point."""
        data = self.data
        if self.sd is not None:
            sd = self.sd
        else:
            curves = [one.curve for one, _ in found] or [np.zeros_like(data.measured)]
            size = min(scatter((data.measured - curve) * data.weight) for curve in curves)
            # Noise that neighbours share is larger than what parts them.
            size = size if self.shared is None else self.shared[0]
            sd = size / data.weight
        floor = _ROUNDING * float(np.abs(data.measured).max())
        trials = np.exp(np.linspace(np.log(self.bounds[:, 0] + 50.0), np.log(self.bounds[:, 1] + 50.0), 24)) - 50.0
        stack = self.problem.with_thickness([trials[:, place, None] for place in range(self.unknown)])
        spectra = getattr(stack, self.problem.quantity)(
            data.wavelength_nm[None, :: max(1, data.wavelength_nm.size // 24)],
            self.problem.angle_deg,
            self.problem.polarization,
        )
        return Measured(
            data.wavelength_nm, data.measured, np.maximum(sd, floor), float(np.mean(spectra)), self.reference
        )

    # --- posterior

    def _rated(self, engine: Engine, found: list[tuple[Fitted, Search]]) -> list[_Found]:
        rated = []
        for one, search in found:
            spectrum = search.model.value(one.parameters)
            films = engine.quick(spectrum)
            logs = engine.log_evidences(spectrum, films)[0]
            log_evidence = log_sum(logs) + self._log_prior_of_line(one.parameters)
            log_evidence += self._log_full(engine, one.parameters, films.rows[int(logs.argmax())])
            rated.append(_Found(one, search, log_evidence))
        return sorted(rated, key=lambda one: -one.log_evidence)

    def _log_prior_of_line(self, parameters: Floats) -> float:
        """Exponential; that of no line at all counts as 1."""
        return 0.0 if self.line is not None else -math.sqrt(max(float(parameters[-1]), 0.0)) / _MEAN_LINE_NM

    def _log_full(self, engine: Engine, parameters: Floats, row: Floats) -> float:
        """What full channels say of a film."""
        if self.full is None or self.full_model is None:
            return 0.0
        return self.full.log_probability(engine, self.model.value(parameters), self.full_model.value(parameters), row)

    def _best_row(self, engine: Engine, spectrum: Floats) -> Floats:
        films = engine.quick(spectrum)
        return np.asarray(films.rows[int(engine.log_evidences(spectrum, films)[0].argmax())])

    def _solution(
        self, engine: Engine, one: _Found, probability: float, tolerances: Tolerances
    ) -> tuple[Solution, float, bool]:
        """A solution, the logarithm of its mass, and whether it is an end of what was searched."""
        if not self.single:
            return self._laplace(engine, one, probability, tolerances)
        start = one.fitted.parameters
        rate = float(round_trip_rate(self.problem, self.data.wavelength_nm, 0).max())
        bounds = (float(self.bounds[0, 0]), float(self.bounds[0, 1]))
        models = [(one.search.model, start), *paled(one.search, self.model, start)]
        rows = [lambda h, model=model, rest=at[1:]: model.value(np.array([h, *rest])) for model, at in models]
        peaks = [
            climb(engine, row, float(at[0]), 0.02 / rate, bounds) for row, (_, at) in zip(rows, models, strict=True)
        ]
        # Either is as likely beforehand.
        kinds = len(models) if one.search.model is self.model else 2
        log_priors = [self._log_prior_of_line(at) - math.log(kinds) for _, at in models]
        peak = together(peaks, log_priors)
        model, start = models[int(np.argmax([p.log_mass + prior for p, prior in zip(peaks, log_priors, strict=True)]))]
        low, high = (side - peak.thickness_nm for side in peak.quantiles(probability))

        off = with_index_off(self.problem, self.data.wavelength_nm, model, start)
        thickness = peak.thickness_nm
        turns = float(np.ptp(round_trip_rate(self.problem, self.data.wavelength_nm, 0))) / (2.0 * math.pi)
        thin = thickness * turns < FRINGES_OF_A_LAMP
        moved, per_percent = by_index_off(engine, off, peak, tolerances.index, bounds if thin else None, 0.02 / rate)
        by_nm = thickness * tolerances.of_wavelengths(self.problem, self.data.wavelength_nm, 0)
        said = math.hypot(moved if tolerances.stated else 0.0, by_nm if tolerances.stated_nm else 0.0)
        reach, usual = student(probability, 1e6), math.hypot(moved, by_nm)
        interval, accurate = (widened(thickness, low, high, reach * sd) for sd in (said, usual))
        parameters = np.array([thickness, *start[1:]])
        told = self._told(engine, model, parameters, peak.best, thickness, interval, math.hypot(peak.sd_nm, said), {})
        return (
            replace(
                told,
                nm_per_percent_of_index=per_percent,
                precision_nm=peak.sd_nm,
                precision_interval_nm=(max(thickness + low, 0.0), thickness + high),
                accuracy_nm=math.hypot(peak.sd_nm, usual),
                accuracy_interval_nm=accurate,
            ),
            peak.log_mass + self._log_full(engine, parameters, peak.best),
            peak.at_end,
        )

    def _laplace(
        self, engine: Engine, one: _Found, probability: float, tolerances: Tolerances
    ) -> tuple[Solution, float, bool]:
        """Several unknowns: the mass of a normal peak, intervals from profiles of the misfit."""
        fitted, search = one.fitted, one.search
        solver, free = search.solver(), search.free(fitted)
        freedom = max(self.data.wavelength_nm.size - len(free) - search.data.linear_count, 1)
        variance = fitted.misfit / freedom
        if self.sd is not None:
            stated = 1.0 / float(np.mean(1.0 / self.sd**2))
            excess = max(variance / stated, 1.0)
            variance = stated * (1.0 if excess <= too_much(freedom) else excess)
        unit_variance = max(
            variance * engine.tempered, 1e-30 * float(np.mean((self.data.measured * self.data.weight) ** 2))
        )
        covariance = solver.covariance(fitted, free) * unit_variance
        axes = len([place for place in free if place < len(fitted.parameters) - 1])
        sign, volume = np.linalg.slogdet(2.0 * math.pi * covariance[:axes, :axes] + 1e-300 * np.eye(axes))
        spectrum = self.model.value(fitted.parameters)
        films = engine.films(spectrum)
        logs = engine.log_evidences(spectrum, films)[0]
        mass = log_sum(logs) + 0.5 * (float(volume) if sign > 0 else 0.0)
        thickness = [float(value) for value in fitted.parameters[: self.unknown]]
        for value, (low, high) in zip(thickness, self.bounds, strict=True):
            mass += math.log(float(prior_density(value, low, high)))
        mass += self._log_prior_of_line(fitted.parameters)
        # An unknown index is anywhere within 0.5.
        mass += math.log(2.0) * (axes - self.unknown)
        deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        reach = student(probability, freedom)
        precise = [
            solver.interval(fitted, free, place, float(reach * deviation[place]), reach**2 * unit_variance)
            for place in range(self.unknown)
        ]
        precisions = tuple(float(one) for one in deviation[: self.unknown])
        (intervals, deviations), (accurate, accuracies) = (
            (
                [
                    widened(h, low - h, high - h, reach * sd)
                    for h, (low, high), sd in zip(thickness, precise, off, strict=True)
                ],
                tuple(math.hypot(one, sd) for one, sd in zip(precisions, off, strict=True)),
            )
            for off in (
                one.of_layers(self.problem, self.data.wavelength_nm, (solver, fitted, free))
                for one in (tolerances.said(), tolerances)
            )
        )
        index: dict[int, dict[str, float]] = {}
        at = self.unknown
        for place, model in zip(self.problem.unknown, self.problem.index, strict=True):
            if model is None:
                continue
            entry: dict[str, float] = {}
            for name in ["n"] if model == "constant" else ["A", "B_um2"]:
                entry[name], entry[f"{name}_sd"] = float(fitted.parameters[at]), float(deviation[at])
                at += 1
            index[place + 1] = entry
        at_end = any(
            value <= low * (1.0 + 1e-9) or value >= high * (1.0 - 1e-9)
            for value, (low, high) in zip(thickness, self.bounds, strict=True)
        )
        best = films.rows[int(logs.argmax())]
        mass += self._log_full(engine, fitted.parameters, best)
        several: Callable[[Any], Any] = (lambda values: values[0]) if self.unknown == 1 else tuple
        shown = several(thickness), several(intervals), several(deviations)
        told = replace(
            self._told(engine, self.model, fitted.parameters, best, *shown, index),
            precision_nm=several(precisions),
            precision_interval_nm=several(precise),
            accuracy_nm=several(accuracies),
            accuracy_interval_nm=several(accurate),
        )
        return told, mass, at_end

    def _told(
        self,
        engine: Engine,
        model: Model,
        parameters: Floats,
        row: Floats,
        thickness: Any,
        interval: Any,
        sd: Any,
        index: Any,
    ) -> Solution:
        spectrum = model.value(parameters)
        response, stray = engine.explain(spectrum, row)
        fitted = response * spectrum + stray
        residual = self.data.measured - fitted
        x = self.data.x
        of = Nuisance(*row)
        # Over the light that stray light of counts is divided by, it is a curve, too.
        bent, drifts = of.bend > 0.0, of.drift > 0.0 or of.counted > 0.0
        gains = np.polynomial.polynomial.polyfit(x, response, 2) if bent else [float(response[0]), 0.0, 0.0]
        baseline = () if of.stray == 0.0 else np.polynomial.polynomial.polyfit(x, stray, 2 if drifts else 0)
        freedom = max(self.data.wavelength_nm.size - 1 - self.data.linear_count, 1)
        left = residual * self.data.weight
        gain, gain_slope, gain_bend = (float(value) for value in gains)
        return Solution(
            thickness,
            interval,
            sd,
            float(np.sqrt(np.mean(residual**2))),
            float(left @ left / freedom / scatter(left) ** 2),
            1.0,
            gain,
            gain_slope,
            gain_bend,
            tuple(float(value) for value in baseline),
            float(np.sqrt(parameters[-1]) * FWHM),
            index,
            self.data.wavelength_nm,
            fitted,
            float(of.kappa),
            lit=lit_share(response),
        )

    # --- answer

    def _answer(
        self,
        engine: Engine,
        solved: list[tuple[Solution, float, bool]],
        probability: float,
        tolerances: Tolerances,
    ) -> FitResult:
        bare = []
        if self.unknown == 1:
            zero = self.problem.with_thickness([0.0])
            seen = getattr(zero, self.problem.quantity)
            bare.append(np.asarray(seen(self.data.wavelength_nm, self.problem.angle_deg, self.problem.polarization)))
        if isinstance(self.model, HarmonicModel):
            # A film that is too thick or too uneven to show its fringes is none that could be told: with a baseline that drifts
            # nearly all such thicknesses suit a spectrum without fringes.
            bare.append(self.model.of.base)
        none, other = engine.without_film(*bare)
        solved = apart(sorted(solved, key=lambda one: -one[1]))
        logs = np.array(
            [
                math.log(PRIOR_NONE) + none,
                math.log(PRIOR_OTHER) + other,
                *(math.log(PRIOR_FILM) + one[1] for one in solved),
            ]
        )
        shares = np.exp(logs - log_sum(logs))
        best = max((one for one in shares[2:]), default=0.0)
        solutions = tuple(
            replace(one[0], weight=float(share))
            for one, share in zip(solved, shares[2:], strict=True)
            if share >= _LEAST_LIKELY * best
        )
        rest = float(shares[2:].sum()) - sum(one.weight for one in solutions)
        asked = Asked(self.problem, self.data.wavelength_nm, self.light, self.single)
        verdict = verdict_of(asked, solutions, (float(shares[0]), float(shares[1])), bool(solved) and solved[0][2])
        known = Known(self.light, self.bounds, self.line, [place + 1 for place in self.problem.unknown], self.single)
        self.notes.extend(remarks(known, self.data.measured, solutions, verdict, tolerances))
        noise = float(1.0 / np.sqrt(np.mean(1.0 / engine.of.sd**2)))
        return FitResult(
            solutions,
            self.data.wavelength_nm,
            self.data.measured,
            self.data.weight,
            noise,
            probability,
            describe(self.problem),
            tuple(self.notes),
            verdict,
            float(shares[0]),
            float(shares[1]) + rest,
        )
