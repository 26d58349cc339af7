"""Film thickness from a measured spectrum: every plausible answer, with its interval and its misfit.

>>> import numpy as np
>>> import iridesce as ir
>>> wavelength_nm = np.arange(420.0, 760.0, 1.0)
>>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=812.0), "air"])
>>> noise = 1e-4 * np.random.default_rng(1).standard_normal(wavelength_nm.size)
>>> counts = 52_000.0 * (film.reflectance(wavelength_nm) + noise) + 300.0        # gain and offset unknown
>>> result = ir.fit_thickness(wavelength_nm, counts, "air / soap ? / air")
>>> len(result), round(result[0].thickness_nm)
(1, 812)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats
from iridesce.arguments.scalars import number, one_of
from iridesce.files.spectra import Spectrum, read_spectrum
from iridesce.inverse.data import (
    calm,
    cleaned,
    correlation,
    even_weight,
    inside_media,
    scatter,
    too_much,
    unit,
    weights_of,
    without_lamp,
)
from iridesce.inverse.model import GeneralModel, HarmonicModel, Problem, describe, harmonics, read_problem
from iridesce.inverse.search import Start, round_trip_rate, starts
from iridesce.inverse.solve import Data, Fitted, Solver, student
from iridesce.optics.averages import FWHM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["FitResult", "Solution", "Spectrum", "fit_thickness", "read_spectrum"]


def __dir__() -> list[str]:
    return __all__


_BASELINES = ("none", "constant", "linear", "quadratic")
_GAINS = ("linear", "quadratic")
_THINNEST_NM, _THICKEST_NM = 1.0, 50_000.0
_THICKEST_OF_SEVERAL_NM = 1_500.0
_FEWEST_POINTS = 12
_STARTS = 24
_FIRST_STEPS = 8
_SOME_LINE_NM = 0.5  # sd of the line with which its search starts
# A solution whose likelihood is below this share of the best one's is not plausible.
_LEAST_LIKELY = 1e-4
# Free blur is taken in where it lowers the misfit by this many variances: by chance, one time in seventy.
_WORTH_BLUR = 6.0
_WIDEST_LINE_NM = 25.0
# Residuals above this many times the noise, squared, say that something smooth is left.
_SMOOTH_LEFT = 1.5
# A more pliable gain and baseline are believed where they lower what is left to this share ...
_WORTH_BENDING = 0.75
# ... and where fringes that they cannot imitate are left: so many over the spectrum, by the degree of the gain.
_FRINGES_FOR = (0.0, 1.0, 2.0)
# The course of a lamp has seven degrees of freedom more.
_FRINGES_UNDER_A_LAMP = 5.0
_LEAST_GAIN = 0.2
# Residuals thirty times the noise: the best film is none.
_HOPELESS = 1e3
# Among ten thousand trials of two degrees of freedom each, chance lowers the misfit by 2 log(1e4) = 18 variances, seldom by 40.
_LAMP_CHANCE = 60.0


@dataclass(frozen=True)
class Solution:
    """One plausible thickness, or set of thicknesses.

    thickness_nm     float, or a tuple where several are unknown (in the order of the layers)
    interval_nm      (low, high) that holds the thickness with the asked probability if this is the right order; a tuple
                     of such pairs for several
    sd_nm            standard deviation, of a straight-line estimate
    misfit           root mean square of measured - fitted, in the unit of the measurement
    chi2             misfit over the noise, squared, a degree of freedom: 1 where the model explains the data; without a
                     noise given, over the scatter of neighbours in what is left
    weight           likelihood among the solutions; they add to 1
    gain, gain_slope, gain_bend, baseline  measured = (gain + gain_slope x + gain_bend x^2) * model + sum baseline_i x^i, x
                     running from -1 to 1 over the wavelengths
    resolution_nm    full width at half maximum of the instrument's line (fitted, or as given)
    index            for each fitted index, by layer number: {"n": ...} or Cauchy's {"A": ..., "B_um2": ...}, with "sd" each
    wavelength_nm, fitted  the fitted curve in the unit of the measurement

    >>> import iridesce as ir
    >>> nm = np.arange(420.0, 760.0, 2.0)
    >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=500.0), "air"])
    >>> solution = ir.fit_thickness(nm, film.reflectance(nm), film).best
    >>> round(solution.thickness_nm, 4), round(solution.gain, 4)
    (500.0, 1.0)
    """

    thickness_nm: Any
    interval_nm: Any
    sd_nm: Any
    misfit: float
    chi2: float
    weight: float
    gain: float
    gain_slope: float
    gain_bend: float
    baseline: tuple[float, ...]
    resolution_nm: float
    index: dict[int, dict[str, float]]
    wavelength_nm: Floats = field(repr=False)
    fitted: Floats = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """All but the curve, as plain values.

        Returns    dict

        >>> import iridesce as ir
        >>> nm = np.arange(420.0, 760.0, 2.0)
        >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=500.0), "air"])
        >>> ir.fit_thickness(nm, film.reflectance(nm), film)[0].to_dict()["resolution_nm"]
        0.0
        """
        return {name: value for name, value in self.__dict__.items() if name not in ("wavelength_nm", "fitted")}


@dataclass(frozen=True)
class FitResult(Sequence[Solution]):
    """All plausible solutions, best first; a sequence of `Solution`.

    solutions        the solutions
    wavelength_nm, measured  the data as used: ascending, without what was dropped
    weight           relative weight of each point, 1 where the noise is even
    noise            standard deviation of the measurement's noise, given or estimated
    probability      of the intervals
    stack            the stack as text, ? for what was unknown
    notes            what a user should know: points dropped, limits, doubts

    >>> import iridesce as ir
    >>> nm = np.arange(420.0, 760.0, 2.0)
    >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=500.0), "air"])
    >>> for solution in ir.fit_thickness(nm, film.reflectance(nm), film):
    ...     print(round(solution.thickness_nm, 4))
    500.0
    """

    solutions: tuple[Solution, ...]
    wavelength_nm: Floats = field(repr=False)
    measured: Floats = field(repr=False)
    weight: Floats = field(repr=False)
    noise: float
    probability: float
    stack: str
    notes: tuple[str, ...]

    @property
    def best(self) -> Solution:
        """The solution of least misfit. Look at the others, too."""
        return self.solutions[0]

    def __len__(self) -> int:
        return len(self.solutions)

    @overload
    def __getitem__(self, index: int) -> Solution: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Solution, ...]: ...
    def __getitem__(self, index: int | slice) -> Solution | tuple[Solution, ...]:
        return self.solutions[index]

    def __str__(self) -> str:
        return "\n".join(_table(self))

    def plot(self, ax: Axes | None = None, *, title: str | None = None, theme: str | None = None) -> Axes:
        """The measurement and the curves of all solutions.

        ax, title, theme  as in `iridesce.plot`
        Returns    the Axes
        Raises     ValueError as there

        >>> import iridesce as ir
        >>> nm = np.arange(420.0, 760.0, 2.0)
        >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=500.0), "air"])
        >>> ax = ir.fit_thickness(nm, film.reflectance(nm), film).plot()
        >>> ax.get_lines()[1].get_label()
        '500.00 nm'
        """
        from iridesce.plot import _fit

        return _fit.plot(self, ax, title, theme)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the curves, as plain values.

        Returns    dict

        >>> import iridesce as ir
        >>> nm = np.arange(420.0, 760.0, 2.0)
        >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=500.0), "air"])
        >>> sorted(ir.fit_thickness(nm, film.reflectance(nm), film).to_dict())
        ['noise', 'notes', 'points', 'probability', 'solutions', 'stack']
        """
        return {
            "stack": self.stack,
            "points": int(self.wavelength_nm.size),
            "noise": self.noise,
            "probability": self.probability,
            "notes": list(self.notes),
            "solutions": [solution.to_dict() for solution in self.solutions],
        }


def fit_thickness(
    wavelength_nm: npt.ArrayLike,
    measured: npt.ArrayLike,
    stack: Any,
    *,
    layer: Any = None,
    quantity: str = "reflectance",
    angle_deg: float = 0.0,
    polarization: str = "unpolarized",
    thickness_range_nm: Any = None,
    gain: float | str | None = None,
    baseline: str = "auto",
    resolution_nm: float | None = None,
    index: Any = None,
    noise: npt.ArrayLike | None = None,
    probability: float = 0.95,
) -> FitResult:
    """Unknown film thicknesses from a reflectance or transmittance spectrum: every plausible solution.

    measured = gain * (spectrum of the stack through a Gaussian line of the instrument) + baseline. The search is global:
    a Fourier transform over the phase of the round trip, 4 pi n cos(theta)/lambda with the film's own dispersion, shows
    which thick films have fringes at all; at these and at every thin one the whole model is compared with the data, gain and
    baseline fitted at each; the minima are refined by least squares with analytic derivatives. All whose likelihood is
    within 1e-4 of the best are answered. Noise is estimated from what is left unless it is given, uneven noise
    (the edges of a spectrometer) is weighed, and residuals that hang together widen the intervals.

    wavelength_nm  vacuum wavelengths, in any order                                               (n,)
    measured       reflectance, transmittance, or counts proportional to it; rows that are not finite, spikes, and wavelengths
                   that a medium has no data for are dropped, repeated wavelengths averaged, all told in ``notes``   (n,)
    stack          text with ? for what is unknown, "air / soap ? / air"; a `Stack`; or a list whose unknown layers are bare
                   media, ["air", "soap", "air"]
    layer          which thickness of a `Stack` is unknown: number (1 is the first) or name of its medium, or several of
                   them; None: the ? of the text, or the only coherent layer
    quantity       "reflectance" or "transmittance"
    angle_deg, polarization  of the light, as for `Stack.reflectance`
    thickness_range_nm  (low, high) or one pair for each unknown; None: 1 to 50 000 nm (several unknowns: 1 500)
    gain           None: unknown, > 0; "linear", "quadratic": unknown, and changing along the wavelengths, as a lamp drifts; a
                   number where it is known: 1.0 for a calibrated reflectance, 100.0 for percent
    baseline       stray light: "none", "constant", "linear" or "quadratic"; "auto": constant, and where an unknown gain
                   leaves something smooth that a changing gain and baseline take away, these, told in ``notes``
    resolution_nm  full width at half maximum of the instrument's line; None: unknown, found where the data show it
    index          None: known; "constant": one unknown n; "cauchy": n = A + B/lambda^2 with A, B unknown; or a dict of
                   these by layer. k stays that of the medium. Thickness and n are told apart by contrast and dispersion only:
                   give the gain if you know it
    noise          standard deviation of the measurement, in its unit; None: estimated                () or (n,)
    probability    of the intervals
    Returns        `FitResult`, a sequence of `Solution`, best first
    Raises         ValueError: too few points, nothing that varies, all wavelengths outside the data of a medium, a layer
                   without fringes, and what else cannot be fitted
    Source         K. Levenberg, Quart. Appl. Math. 2, 164 (1944); D. W. Marquardt, J. SIAM 11, 431 (1963); variable
                   projection by L. Kaufman, BIT 15, 49 (1975)

    >>> import iridesce as ir
    >>> nm = np.linspace(450.0, 950.0, 600)
    >>> oxide = ir.Stack(["air", ir.Layer("SiO2", thickness_nm=1234.5), "Si"])
    >>> seen = oxide.reflectance_averaged(nm, resolution_nm=3.0).value
    >>> found = ir.fit_thickness(nm, seen, "air / SiO2 ? / Si", gain=1.0)
    >>> len(found), round(found[0].thickness_nm, 1), round(found[0].resolution_nm, 1)
    (1, 1234.5, 3.0)
    """
    quantity = one_of("quantity", quantity, ("reflectance", "transmittance"))
    polarization = one_of("polarization", polarization, ("s", "p", "unpolarized"))
    baseline = one_of("baseline", baseline, ("auto", *_BASELINES))
    angle = number("angle_deg", angle_deg, low=0.0, high=90.0)
    bend = 0 if gain is None else _GAINS.index(one_of("gain", gain, _GAINS)) + 1 if isinstance(gain, str) else 0
    fixed_gain = None if gain is None or isinstance(gain, str) else number("gain", gain, low=0.0)
    if fixed_gain == 0.0:
        raise ValueError('gain must be None, "linear", "quadratic" or a number > 0, got 0')
    line = None if resolution_nm is None else number("resolution_nm", resolution_nm, low=0.0) / FWHM
    if not 0.0 < number("probability", probability, low=0.0, high=1.0) < 1.0:
        raise ValueError(f"probability must be > 0 and < 1, got {probability!r}")
    problem = read_problem(stack, layer, index, quantity, angle, polarization)
    notes: list[str] = []
    nm, values, sd = cleaned(wavelength_nm, measured, noise, notes)
    known = inside_media(problem, nm, notes)
    nm, values, sd = nm[known], values[known], None if sd is None else sd[known]
    terms = 1 if baseline == "auto" else _BASELINES.index(baseline)
    linear = terms + (fixed_gain is None) * (1 + bend)
    parameters = len(problem.unknown) + problem.index_count + linear + (line is None)
    if nm.size < max(_FEWEST_POINTS, 2 * parameters):
        raise ValueError(
            f"{nm.size} usable points are too few for {parameters} unknowns; at least {max(_FEWEST_POINTS, 2 * parameters)}"
            + "".join(f"; {note}" for note in notes)
        )
    # The stack's own complaint about wavelengths outside its media, before anything else.
    problem.with_thickness([100.0] * len(problem.unknown)).reflectance(nm[[0, -1]], angle)
    # Squares of sizes far from 1 would run over or under; by a power of two nothing is rounded.
    size = float(np.abs(values).max(initial=0.0))
    scale = 1.0 if 1e-60 < size < 1e60 or size == 0.0 else 2.0 ** math.floor(math.log2(size))
    values, sd = values / scale, None if sd is None else sd / scale
    fixed_gain = None if fixed_gain is None else fixed_gain / scale
    weight = np.ones_like(nm) if sd is None else unit(1.0 / sd)
    if np.ptp(values) <= 1e-12 * np.abs(values).max(initial=0.0):
        raise ValueError("measured does not vary with wavelength: there is nothing to fit")
    if sd is None:
        steady = calm(values, notes)
        nm, values = nm[steady], values[steady]
        weight = even_weight(values, notes)
    bounds = _bounds(thickness_range_nm, problem, nm, notes)
    # From the stiffest gain and baseline to the most pliable.
    plans = [(bend, terms)]
    if baseline == "auto" and fixed_gain is None and nm.size >= 4 * (parameters + 4):
        plans += [plan for plan in ((1, 2), (2, 3)) if plan[0] >= bend]

    def run(plan: tuple[int, int]) -> FitResult:
        fit = _Fit(problem, Data(nm, values, weight, fixed_gain, *plan), line, sd is not None, probability, list(notes))
        fit.bounds = bounds
        return fit.result(None if sd is None else float(1.0 / np.sqrt(np.mean(1.0 / sd**2))))

    result: FitResult | None = None
    refusal: _NoFringesError | None = None
    try:
        result = _first_that_fits(plans, run, problem)
    except _NoFringesError as error:
        refusal = error
    if len(plans) > 1 and sd is None and (result is None or result.best.chi2 > _HOPELESS):
        # Counts that were never divided by the lamp: its course hides the fringes.
        divided = without_lamp(nm, values, _mean_spectrum(problem, nm))
        if divided is not None:
            nm, values, weight = divided
            result = _under_a_lamp(plans[-1], run, problem) or result
    if result is None:
        raise refusal or ValueError("the fit found no solution")
    return _scaled(result, scale)


class _NoFringesError(ValueError):
    """Nothing above the noise."""


def _under_a_lamp(
    plan: tuple[int, int], run: Callable[[tuple[int, int]], FitResult], problem: Problem
) -> FitResult | None:
    """The fit of a spectrum that was divided by its own course, where its fringes can be believed."""
    try:
        result = _first_that_fits([plan], run, problem)
    except _NoFringesError:
        return None
    few = _fringes(problem, result) < _FRINGES_UNDER_A_LAMP
    # Divided so, the gain of a film is 1 less its stray light; what the lamp's course leaves over is far paler.
    if few or result.best.gain < _LEAST_GAIN or not _beats_its_mean(problem, result):
        return None
    note = "the spectrum was divided by its own smooth course (counts not divided by the lamp?): only its fringes count"
    return replace(result, notes=(*result.notes, note))


def _first_that_fits(
    plans: list[tuple[int, int]], run: Callable[[tuple[int, int]], FitResult], problem: Problem
) -> FitResult:
    """The stiffest plan that leaves nothing smooth, or the last that was worth it."""
    result: FitResult | None = None
    refusal: _NoFringesError | None = None
    for plan in plans:
        try:
            found = run(plan)
        except _NoFringesError as error:
            refusal = refusal or error
            continue
        if plan != plans[0]:
            fringes = _fringes(problem, found)
            worth = result is None or found.best.misfit < _WORTH_BENDING * result.best.misfit
            if fringes < _FRINGES_FOR[plan[0]] or not worth:
                continue
            words = ("", "changing along the spectrum", "bent along the spectrum")[plan[0]]
            shape = ("none", "constant", "a line", "a parabola")[plan[1]]
            note = f"an even gain does not fit; it was taken as {words}, the baseline as {shape} (a drifting lamp, stray light)"
            found = replace(found, notes=(*found.notes, note))
        result = found
        if result.best.chi2 <= _SMOOTH_LEFT:
            break
    if result is None:
        raise refusal or ValueError("the fit found no solution")
    return result


def _mean_spectrum(problem: Problem, nm: Floats) -> Floats:
    """R or T without fringes, where that has a closed form; else 1."""
    of = harmonics(problem, nm)
    return np.ones_like(nm) if of is None else np.maximum(of.base, 1e-6)


def _beats_its_mean(problem: Problem, result: FitResult) -> bool:
    """Whether the fringes explain more than the same stack without fringes, bent as the fit may bend it, beyond chance."""
    nm, weight = result.wavelength_nm, result.weight
    x = (2.0 * nm - nm[0] - nm[-1]) / (nm[-1] - nm[0])
    powers = np.stack([x**power for power in range(3)], axis=1)
    basis = np.column_stack([powers, powers * _mean_spectrum(problem, nm)[:, None]]) * weight[:, None]
    target = result.measured * weight
    without = target - basis @ np.linalg.lstsq(basis, target, rcond=None)[0]
    left = (result.measured - result.best.fitted) * weight
    variance = float(left @ left) / max(nm.size - 8, 1)
    return float(without @ without) - float(left @ left) > _LAMP_CHANCE * variance


def _scaled(result: FitResult, scale: float) -> FitResult:
    """The result in the measurement's own unit."""
    if scale == 1.0:
        return result
    solutions = tuple(
        replace(
            one,
            misfit=one.misfit * scale,
            gain=one.gain * scale,
            gain_slope=one.gain_slope * scale,
            gain_bend=one.gain_bend * scale,
            baseline=tuple(value * scale for value in one.baseline),
            fitted=one.fitted * scale,
        )
        for one in result
    )
    return replace(result, solutions=solutions, measured=result.measured * scale, noise=result.noise * scale)


def _fringes(problem: Problem, result: FitResult) -> float:
    """How many fringes the best solution has over the spectrum, of all unknown layers together."""
    thickness = np.atleast_1d(np.asarray(result.best.thickness_nm, dtype=float))
    turns = [np.ptp(round_trip_rate(problem, result.wavelength_nm, which)) for which in range(thickness.size)]
    return float(thickness @ np.array(turns) / (2.0 * np.pi))


class _Fit:
    """One run of the fit."""

    bounds: Floats

    def __init__(
        self, problem: Problem, data: Data, line: float | None, noise_known: bool, probability: float, notes: list[str]
    ) -> None:
        self.problem, self.data, self.line = problem, data, line
        self.noise_known, self.probability, self.notes = noise_known, probability, notes
        of = harmonics(problem, data.wavelength_nm)
        self.model = HarmonicModel(of) if of is not None else GeneralModel(problem, data.wavelength_nm)
        self.unknown = len(problem.unknown)

    def result(self, noise: float | None) -> FitResult:
        candidates = self._candidates()
        solver = self._solver()
        best = candidates[0]
        if not self.noise_known:
            weight = weights_of(best.curve, self.data, self.notes)
            if weight is not None:
                self.data = replace(self.data, weight=weight)
                solver = self._solver()
                candidates = self._unique([self._refined(solver, one.parameters) for one in candidates])
                best = candidates[0]
        free = self._free(best)
        freedom = max(self.data.wavelength_nm.size - len(free) - self.data.linear_count, 1)
        variance = best.misfit / freedom
        residual = (self.data.measured - best.curve) * self.data.weight
        together = correlation(residual)
        if noise is not None:
            # Weights were 1/sd over their mean square: one unit of misfit is the mean noise.
            excess = max(variance / noise**2, 1.0)
            believed = excess <= too_much(freedom)
            # What hangs together far below the noise is rounding, and no noise.
            together = max(1.0, together * min(variance / noise**2, 1.0))
            variance_a_point = noise**2 * (1.0 if believed else excess)
            if not believed:
                self.notes.append(f"the best curve misses the data by {math.sqrt(excess):.2g} times the noise given")
        else:
            variance_a_point = variance
        smallest = 1e-30 * float(np.mean((self.data.measured * self.data.weight) ** 2))
        variance_a_point = max(variance_a_point * together, smallest)
        if together > 1.5:
            self.notes.append("what is left hangs together along the spectrum; the intervals are widened for it")
        self._must_show_fringes(solver, best, variance_a_point)
        limit = -2.0 * math.log(_LEAST_LIKELY)
        kept = [one for one in candidates if (one.misfit - best.misfit) / variance_a_point <= limit]
        likely = np.exp([-0.5 * (one.misfit - best.misfit) / variance_a_point for one in kept])
        solutions = self._without_overlap(
            [self._solution(solver, one, variance_a_point, freedom, noise or scatter(residual)) for one in kept], likely
        )
        self._remarks(solutions, best)
        return FitResult(
            solutions,
            self.data.wavelength_nm,
            self.data.measured,
            self.data.weight,
            noise if noise is not None else math.sqrt(variance),
            self.probability,
            describe(self.problem),
            tuple(self.notes),
        )

    def _must_show_fringes(self, solver: Solver, best: Fitted, unit: float) -> None:
        """Among so many trials chance alone lowers the misfit of a free gain; nothing less can be believed."""
        if self.data.gain is not None:
            return
        terms, target = solver.terms, solver.target
        left = target - terms @ np.linalg.lstsq(terms, target, rcond=None)[0] if terms.shape[1] else target
        trials = max(float(np.ptp(self.bounds, axis=1).max()) / 10.0, 10.0) ** self.unknown
        if (float(left @ left) - best.misfit) / unit < 12.0 + 2.0 * math.log(trials) + 4.0 * self.data.bend:
            raise _NoFringesError(
                "the spectrum shows no fringes above its noise: no thickness can be told from it"
                " (thin films need a known gain: gain=1.0 for a calibrated reflectance)"
            )

    # --- candidates

    def _limits(self) -> tuple[Floats, Floats]:
        low, high = list(self.bounds[:, 0]), list(self.bounds[:, 1])
        for model in self.problem.index:
            low += [] if model is None else [1.0]
            high += [] if model is None else [6.0]
            low += [-0.05] if model == "cauchy" else []
            high += [0.3] if model == "cauchy" else []
        widest = max(_WIDEST_LINE_NM / FWHM, self.line or 0.0)
        return np.array([*low, 0.0]), np.array([*high, widest**2])

    def _solver(self) -> Solver:
        return Solver(self.model, self.data, *self._limits())

    def _lines(self) -> list[float]:
        """Widths of the line (sd) worth trying in the search."""
        if self.line is not None:
            return [self.line]
        thickest = float(self.bounds[:, 1].max())
        nm = self.data.wavelength_nm
        # The width at which the finest fringe is all but gone.
        gone = 2.5 * nm[0] ** 2 / (4.0 * np.pi * 1.4 * thickest)
        return [0.0] + [sd for sd in (0.6, 1.7) if sd > 0.2 * gone]

    def _candidates(self) -> list[Fitted]:
        found = starts(self.problem, self.model, self.data, self.bounds, self._lines(), _STARTS)
        solver = self._solver()
        index = self.model.start_index() if isinstance(self.model, GeneralModel) else np.empty(0)
        tried = []
        for thickness, line in found:
            for moved in self._index_starts(index):
                scale = 1.0 if not moved.size else index[0] / moved[0]
                tried.append(solver.at(np.array([*(thickness * scale), *moved, line**2])))
        # A few steps each tell which can win; these are refined to the end.
        tried.sort(key=lambda one: one.misfit)
        sharp = list(range(len(tried[0].parameters) - 1))
        quick = self._quick_solver(solver, found)
        rough = self._unique([quick.solve(one.parameters, sharp, _FIRST_STEPS) for one in tried[:_STARTS]])
        if not rough:
            raise ValueError(
                "no thickness explains the data better than its baseline alone; check stack, quantity and wavelengths"
            )
        refined = [self._refined(solver, one.parameters) for one in rough[:2]]
        least = min(one.misfit for one in refined)
        refined += [self._refined(solver, one.parameters) for one in rough[2:] if one.misfit < 3.0 * least]
        refined = self._unique(refined)
        if not refined:
            raise ValueError("the fit found no solution within thickness_range_nm")
        return refined

    def _quick_solver(self, solver: Solver, found: list[Start]) -> Solver:
        """For first steps with a costly model: fewer points, as long as they show the fringes."""
        nm = self.data.wavelength_nm
        if isinstance(self.model, HarmonicModel) or nm.size < 300:
            return solver
        thickest = max(float(thickness.sum()) for thickness, _ in found)
        finest = nm[0] ** 2 / (8.0 * max(thickest, 1.0)) / float(np.median(np.diff(nm)))
        step = int(min(nm.size // 150, max(1.0, finest / 4.0)))
        data = self.data.thinned(step)
        return Solver(GeneralModel(self.problem, data.wavelength_nm), data, *self._limits())

    def _index_starts(self, index: Floats) -> list[Floats]:
        if not index.size:
            return [index]
        shifts = []
        for step in (0.0, -0.12, 0.12):
            moved = index.copy()
            at = 0
            for model in self.problem.index:
                if model is not None:
                    moved[at] += step
                    at += 1 if model == "constant" else 2
            shifts.append(moved)
        return shifts

    def _refined(self, solver: Solver, start: Floats) -> Fitted:
        """All parameters but the blur, then the blur too where the data ask for it."""
        last = len(start) - 1
        sharp = list(range(last))
        if self.line is not None:
            return solver.solve(start, sharp)
        best = solver.solve(np.array([*start[:-1], max(start[-1], _SOME_LINE_NM**2)]), [*sharp, last])
        freedom = max(self.data.wavelength_nm.size - len(start) - self.data.linear_count, 1)
        worth = _WORTH_BLUR * best.misfit / freedom
        zero = solver.solve(np.array([*best.parameters[:-1], 0.0]), sharp)
        return best if zero.misfit - best.misfit > worth else zero

    def _unique(self, found: list[Fitted]) -> list[Fitted]:
        """One of each minimum, best first."""
        kept: list[Fitted] = []
        for one in sorted(found, key=lambda one: one.misfit):
            if not np.isfinite(one.misfit) or one.gain[0] <= 0.0:
                continue
            thickness = one.parameters[: self.unknown]
            if all(np.abs(thickness - other.parameters[: self.unknown]).max() > 0.5 for other in kept):
                kept.append(one)
        return kept

    # --- answers

    def _free(self, fitted: Fitted) -> list[int]:
        last = len(fitted.parameters) - 1
        low, high = self._limits()
        blurred = self.line is None and low[-1] < fitted.parameters[-1] < high[-1]
        return [*range(last), *([last] if blurred else [])]

    def _solution(self, solver: Solver, one: Fitted, unit: float, freedom: int, noise: float) -> Solution:
        free = self._free(one)
        deviation = np.sqrt(np.maximum(np.diag(solver.covariance(one, free)), 0.0) * unit)
        reach = student(self.probability, freedom)
        intervals = [
            solver.interval(one, free, place, float(reach * deviation[place]), reach**2 * unit)
            for place in range(self.unknown)
        ]
        thickness = [float(value) for value in one.parameters[: self.unknown]]
        deviations = [float(value) for value in deviation[: self.unknown]]
        single = self.unknown == 1
        residual = self.data.measured - one.curve
        index: dict[int, dict[str, float]] = {}
        at = self.unknown
        for place, model in zip(self.problem.unknown, self.problem.index, strict=True):
            if model is None:
                continue
            names = ["n"] if model == "constant" else ["A", "B_um2"]
            entry: dict[str, float] = {}
            for name in names:
                entry[name], entry[f"{name}_sd"] = float(one.parameters[at]), float(deviation[at])
                at += 1
            index[place + 1] = entry
        return Solution(
            thickness[0] if single else tuple(thickness),
            intervals[0] if single else tuple(intervals),
            deviations[0] if single else tuple(deviations),
            float(np.sqrt(np.mean(residual**2))),
            float(one.misfit / freedom / noise**2),
            1.0,
            float(one.gain[0]),
            float(one.gain[1]),
            float(one.gain[2]),
            tuple(float(value) for value in one.baseline),
            float(np.sqrt(one.parameters[-1]) * FWHM),
            index,
            self.data.wavelength_nm,
            one.curve,
        )

    def _without_overlap(self, solutions: list[Solution], likely: Floats) -> tuple[Solution, ...]:
        """Minima that lie within the interval of a better one belong to it."""
        kept: list[tuple[Solution, float]] = []
        for one, share in zip(solutions, likely, strict=True):
            if not any(_within(one, better) for better, _ in kept):
                kept.append((one, float(share)))
        total = sum(share for _, share in kept)
        return tuple(
            Solution(**{**one.__dict__, "weight": share / total})  # a frozen copy
            for one, share in kept
        )

    def _remarks(self, solutions: tuple[Solution, ...], best: Fitted) -> None:
        for place, (low, high) in enumerate(self.bounds):
            interval = solutions[0].interval_nm if self.unknown == 1 else solutions[0].interval_nm[place]
            if interval[0] <= low or interval[1] >= high:
                self.notes.append(
                    f"the interval of layer {self.problem.unknown[place] + 1} reaches an end of thickness_range_nm "
                    f"({low:g} to {high:g} nm)" + ("" if self.data.gain else "; a known gain tells thin films apart")
                )
        _, high = self._limits()
        if self.line is None and best.parameters[-1] >= 0.999 * high[-1]:
            self.notes.append(
                f"the fringes are paler than even a line of {_WIDEST_LINE_NM:g} nm makes them: uneven film, or another stack"
            )
        if solutions[0].chi2 > _SMOOTH_LEFT and not self.noise_known:
            self.notes.append(
                f"something smooth is left, {math.sqrt(solutions[0].chi2):.2g} times the noise: the index, a drifting lamp "
                '(gain="linear", baseline="linear") or another stack; the interval does not know of it'
            )
        if self.data.gain is None and solutions[0].chi2 > _SMOOTH_LEFT and self._smooth_is_better(best):
            self.notes.append(
                "a parabola describes the spectrum better than any film does: there may be no fringes in it at all; "
                "a known gain (gain=1.0 for a calibrated reflectance) would tell"
            )
        spread = float(np.std(self.data.measured))
        left = float(np.std(self.data.measured - best.curve))
        if left > 0.7 * spread:
            self.notes.append("the model explains less than half of what varies: doubt the stack or the data")

    def _smooth_is_better(self, best: Fitted) -> bool:
        basis = np.stack([self.data.x**power for power in range(3)], axis=1) * self.data.weight[:, None]
        target = self.data.measured * self.data.weight
        left = target - basis @ np.linalg.lstsq(basis, target, rcond=None)[0]
        return float(left @ left) < best.misfit


def _within(one: Solution, other: Solution) -> bool:
    if isinstance(other.thickness_nm, float):
        return bool(other.interval_nm[0] <= one.thickness_nm <= other.interval_nm[1])
    return all(low <= value <= high for value, (low, high) in zip(one.thickness_nm, other.interval_nm, strict=True))


def _bounds(given: Any, problem: Problem, nm: Floats, notes: list[str]) -> Floats:
    """(unknown, 2): the thicknesses to look among, cut where the sampling shows no fringes any more."""
    count = len(problem.unknown)
    if given is None:
        high = _THICKEST_NM if count == 1 else _THICKEST_OF_SEVERAL_NM
        pairs = np.array([[_THINNEST_NM, high]] * count)
        if count > 1:
            notes.append(
                f"thicknesses were looked for from {_THINNEST_NM:g} to {high:g} nm; thickness_range_nm= says else"
            )
    else:
        try:
            pairs = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError):
            raise ValueError(f"thickness_range_nm must be (low, high) in nm, got {given!r}") from None
        if pairs.shape == (2,):
            pairs = np.broadcast_to(pairs, (count, 2)).copy()
        if pairs.shape != (count, 2):
            raise ValueError(
                f"thickness_range_nm must be (low, high), or one pair for each of {count} unknowns, got {given!r}"
            )
    if not (np.isfinite(pairs).all() and (pairs[:, 0] >= 0.0).all() and (pairs[:, 1] > pairs[:, 0]).all()):
        raise ValueError(f"thickness_range_nm must be 0 <= low < high, got {pairs.tolist()}")
    if (pairs[:, 1] > 1e6).any():
        raise ValueError(f"thickness_range_nm must end at 1e6 nm at most, got {pairs.tolist()}")
    # Two points a fringe at the longest wavelength: lambda^2/(2 n d) >= 2 steps.
    step = float(np.median(np.diff(nm)))
    for place, which in enumerate(problem.unknown):
        n = float(np.real(problem.stack.layers[which].medium.index(nm[-1], extrapolate="hold")))
        limit = nm[-1] ** 2 / (4.0 * max(n, 1.0) * step)
        if pairs[place, 1] > limit > 2.0 * pairs[place, 0]:
            pairs[place, 1] = limit
            if given is not None or count > 1:
                notes.append(f"films above {limit:.4g} nm have fringes finer than these wavelengths show")
    return pairs


# --- words


def _table(result: FitResult) -> list[str]:
    """The answer for people."""
    percent = f"{100.0 * result.probability:g} %"
    count = len(result)
    lines = [
        f"{result.stack}: {count} plausible solution{'s' if count > 1 else ''}, {result.wavelength_nm.size} points"
    ]
    for solution in result:
        several = not isinstance(solution.thickness_nm, float)
        values = solution.thickness_nm if several else (solution.thickness_nm,)
        intervals = solution.interval_nm if several else (solution.interval_nm,)
        words = [
            f"{value:.2f} nm ({percent}: {low:.2f} to {high:.2f})"
            for value, (low, high) in zip(values, intervals, strict=True)
        ]
        for place, entry in solution.index.items():
            words.append(f"layer {place} " + ", ".join(f"{name} {value:.4g}" for name, value in entry.items()))
        lines.append(
            f"  {' + '.join(words)}   weight {solution.weight:.3g}, chi2 {solution.chi2:.3g}, misfit {solution.misfit:.3g}, "
            f"gain {solution.gain:.4g}, line {solution.resolution_nm:.2g} nm"
        )
    return [*lines, *(f"  note: {note}" for note in result.notes)]
