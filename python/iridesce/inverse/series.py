"""One film in time: many spectra that share lamp, spectrometer and neighbours.

>>> import numpy as np
>>> import iridesce as ir
>>> nm = np.arange(450.0, 800.0, 2.0)
>>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(1400.0, 900.0, 40)[:, None]), "air"])
>>> lamp = 2e4 * np.exp(-(((nm - 640.0) / 150.0) ** 2)) * (1.0 + 0.3 * np.exp(-(((nm - 560.0) / 30.0) ** 2)))
>>> counts = lamp * film.reflectance(nm) + 20.0 * np.random.default_rng(1).standard_normal((40, nm.size))
>>> series = ir.fit_series(nm, counts, "air / soap ? / air")
>>> bool(np.abs(series.thickness_nm - np.linspace(1400.0, 900.0, 40)).max() < 5.0), set(series.verdict.tolist())
(True, {'clear'})
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint
from iridesce.arguments.scalars import number, one_of
from iridesce.inverse.course import _CLEAR, Course
from iridesce.inverse.data import check_reference, local_noise
from iridesce.inverse.fit import fit_thickness
from iridesce.inverse.full import full_in_some
from iridesce.inverse.model import describe, quarter_wave_nm, read_problem
from iridesce.inverse.results import FitResult, is_known, order_share
from iridesce.inverse.series_data import bounds_of, by_reference, put_right, read, times_of, usable
from iridesce.inverse.series_result import SeriesResult, no_film
from iridesce.inverse.solve import student
from iridesce.inverse.spectrum_light import Found, Light
from iridesce.inverse.tolerances import Tolerances, read_tolerances
from iridesce.optics.averages import FWHM

__all__ = ["SeriesResult", "fit_series"]

# No noise is below this share of the largest value: a lamp of curves, a grid of films and tables of indices are not better.
_FINEST = 3e-4
# The lamp is learnt from at most so many spectra, evenly spaced in time; then all are asked.
_LEARNERS = 240
# A series that teaches no lamp is so many fits of single spectra, where there are so few.
_SINGLE = 64
# Where no lamp comes of the series at once, so many spectra are fitted alone, and so many of these have to be clear.
_ALONE, _LEAST_ALONE = 6, 3
_WORST_KAPPA = 10.0
_EXACT = Tolerances(0.0, 0.0, True, True)


def fit_series(
    wavelength_nm: npt.ArrayLike | None,
    spectra: Any,
    stack: Any,
    time_s: npt.ArrayLike | None = None,
    *,
    dark: npt.ArrayLike | None = None,
    reference: npt.ArrayLike | None = None,
    reference_stack: Any = None,
    layer: Any = None,
    quantity: str = "reflectance",
    angle_deg: float = 0.0,
    polarization: str = "unpolarized",
    thickness_range_nm: Any = None,
    gain: float | None = None,
    baseline: str = "auto",
    resolution_nm: float = 0.0,
    noise: float | None = None,
    probability: float = 0.95,
    index_tolerance: float | None = None,
    wavelength_tolerance_nm: float | None = None,
    progress: Callable[..., object] | None = None,
) -> SeriesResult:
    """The thickness of one film in time, from many spectra that share lamp and spectrometer.

    Each spectrum is compared with all films under a lamp of any smooth course; those that are sure, and have fringes
    enough that no lamp could have made them, teach the lamp's course; with it all spectra are asked again, twice. Time is
    a chain: a film drifts (its rate is found from the series), or jumps, or is gone; forward-backward sums over all
    paths. A learnt lamp makes thin films measurable that no spectrum alone could tell.

    wavelength_nm  vacuum wavelengths; None where ``spectra`` are files                             (wavelengths,)
    spectra        reflectances or counts, a row a spectrum; or paths of files, read by `ir.fit.read_spectrum`
                                                                                                    (n, wavelengths)
    stack          with one unknown thickness, as for `ir.fit_thickness`; its indices are known
    time_s         ascending; None: 0, 1, 2, ...                                                      (n,)
    dark, reference, reference_stack  as for `ir.fit_thickness`, the same for all spectra             (wavelengths,)
    layer, quantity, angle_deg, polarization, probability, index_tolerance, wavelength_tolerance_nm  as there; the last two are
                   errors that all spectra share: what is said of them is in ``interval_nm``, and not in ``precision_nm``;
                   ``accuracy_nm`` holds 0.01 and 0.3 nm where nothing is said
    thickness_range_nm  (low, high); None: 1 to 10 000 nm
    gain           None: unknown; 1.0 for calibrated reflectances
    baseline       "auto": stray light with the lamp's course; "none"
    resolution_nm  full width at half maximum of the instrument's line
    noise          standard deviation of the measurement; None: estimated
    progress       called with (done, total)
    Returns        `SeriesResult`
    Raises         ValueError naming the argument, or the file, that is wrong
    Source         L. R. Rabiner, Proc. IEEE 77, 257 (1989) (forward-backward)

    >>> import iridesce as ir
    >>> nm = np.arange(450.0, 800.0, 2.0)
    >>> path = np.r_[np.linspace(900.0, 870.0, 6), np.linspace(1250.0, 1200.0, 6)]          # a patch passes the spot
    >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=path[:, None]), "air"])
    >>> found = ir.fit_series(nm, film.reflectance(nm), "air / soap ? / air", gain=1.0)
    >>> bool(np.abs(found.thickness_nm - path).max() < 1.0)
    True
    """
    quantity = one_of("quantity", quantity, ("reflectance", "transmittance"))
    polarization = one_of("polarization", polarization, ("s", "p", "unpolarized"))
    baseline = one_of("baseline", baseline, ("auto", "none"))
    angle = number("angle_deg", angle_deg, low=0.0, high=90.0)
    line = number("resolution_nm", resolution_nm, low=0.0, high=100.0) / FWHM
    share = number("probability", probability, low=0.0, high=1.0, includes_low=False)
    tolerances = read_tolerances(index_tolerance, wavelength_tolerance_nm)
    if gain is not None:
        gain = number("gain", gain, low=0.0, high=math.inf, includes_low=False)
    size = None if noise is None else number("noise", noise, low=0.0, high=math.inf, includes_low=False)
    problem = read_problem(stack, layer, None, quantity, angle, polarization)
    if len(problem.unknown) != 1:
        raise complaint(
            f"a series has one unknown thickness, the stack has {len(problem.unknown)}",
            "stack",
            "one with one unknown thickness",
            Words(len(problem.unknown)),
        )
    notes: list[str] = []
    nm, values = read(wavelength_nm, spectra)
    filled = nm[full_in_some(values, notes)]
    sd: Floats | None = None
    times = times_of(time_s, len(values))
    check_reference(dark, reference, reference_stack)
    if reference is not None:
        nm, values, sd = by_reference(problem, nm, values, dark, reference, reference_stack, notes)
        gain = 1.0 if gain is None else gain
    nm, values, sd = usable(problem, nm, values, sd, filled, notes)
    problem.with_thickness([100.0]).reflectance(nm[[0, -1]], angle)
    values, whole = put_right(values, notes)
    if not whole.any():
        notes.append("no spectrum is whole: no film is seen")
        return no_film(times, nm, describe(problem), share, notes)
    if sd is None:
        sd = local_noise(values[whole]) if size is None else np.full(nm.size, size)
    floor = _FINEST * float(np.abs(values[whole]).max(initial=0.0))
    empty = ~whole | (np.ptp(values, axis=1) <= 1e-12 * np.abs(values).max(axis=1))
    bounds = bounds_of(thickness_range_nm, problem, nm, notes)
    if empty.all():
        notes.append("no spectrum varies with wavelength: no film is seen")
        return no_film(times, nm, describe(problem), share, notes)
    known_lamp = np.ones_like(nm) if gain is not None else None
    light = Light(known_lamp, gain, baseline != "none")
    used = np.flatnonzero(~empty)
    # By a power of two: squares of sizes far from 1 would run over.
    scale = 2.0 ** math.floor(math.log2(max(float(np.abs(values[used]).max()), 1e-300))) if gain is None else 1.0
    sd = np.maximum(sd, max(floor, 1e-300)) / scale
    course = Course(problem, nm, values[used] / scale, sd, light, bounds, line)
    course.least_sd = max(floor, 1e-300) / scale
    belief, none, found = _asked(course, times[used], size is None, progress)
    rows = None
    if not course.learnt and gain is None:
        notes.append("the lamp could not be learnt: too few spectra with sure films of more than 2.5 fringes")
        if used.size <= _SINGLE:
            rows = _by_themselves(course, [_single(course, row, size, share, tolerances) for row in values[used]])
    if rows is None:
        rows = _by_the_series(course, belief, none, found, share, tolerances)
    return _answer(course, rows, times, used, share, tolerances, describe(problem), notes)


def _asked(
    course: Course, times: Floats, free_noise: bool, progress: Callable[..., object] | None
) -> tuple[Floats, Floats, Found]:
    """Learn from some, then ask all."""
    every = course.y
    few = np.unique(np.linspace(0, len(every) - 1, min(len(every), _LEARNERS)).astype(int))

    def ask() -> tuple[Floats, Floats, Found]:
        at = times[few] if len(course.y) == few.size else times
        steps = np.diff(at)
        found = course.candidates()
        belief = none = np.empty(0)
        for _ in range(3):
            belief, none = course.chain(found, steps)
            best, _ = _best(course, belief, found)
            by = np.abs(np.diff(best)) / steps
            sure = (belief.max(axis=1) > _CLEAR)[1:] & (belief.max(axis=1) > _CLEAR)[:-1]
            if sure.sum() > 3:
                # Laplace's scale is the mean; jumps are left out by the median's.
                course.rate_of_change = float(max(np.median(by[sure]) / math.log(2.0), 1e-3 / float(np.median(steps))))
        return belief, none, found

    total = 4
    course.y = every[few]
    course.rate_of_change = 20.0 / float(np.median(np.diff(times))) if times.size > 1 else 20.0
    for turn in range(2):
        belief, none, found = ask()
        if progress is not None:
            progress(turn + 1, total)
        best, mass = _best(course, belief, found)
        sure = mass > 0.99
        if not course.learn(best, sure):
            best, sure = _alone(course)
            if turn > 0 or not course.learn(best, sure, _LEAST_ALONE):
                break
        if free_noise:
            course.sd = np.maximum(local_noise(course.left(best, sure)), course.least_sd)
    course.y = every
    belief, none, found = ask()
    if progress is not None:
        progress(total, total)
    return belief, none, found


def _alone(course: Course) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Some spectra by themselves, where the series is too short, or too still, to begin with: `fit_thickness` takes a lamp in."""
    best, sure = np.full(len(course.y), np.nan), np.zeros(len(course.y), dtype=bool)
    if course.light.lamp is not None:
        return best, sure
    for place in np.unique(np.linspace(0, len(course.y) - 1, min(len(course.y), _ALONE)).astype(int)):
        found = _single(course, course.y[place])
        if found.verdict == "clear":
            best[place], sure[place] = found.best.thickness_nm, True
    return best, sure


def _single(
    course: Course,
    spectrum: Floats,
    noise: float | None = None,
    probability: float = 0.95,
    tolerances: Tolerances = _EXACT,
) -> FitResult:
    """A spectrum of the series by itself."""
    problem = course.problem
    return fit_thickness(
        course.nm,
        spectrum,
        problem.stack,
        layer=problem.unknown[0] + 1,
        quantity=problem.quantity,
        angle_deg=problem.angle_deg,
        polarization=problem.polarization,
        thickness_range_nm=course.bounds,
        baseline="auto" if course.light.stray else "none",
        resolution_nm=course.line * FWHM,
        noise=noise,
        probability=probability,
        index_tolerance=tolerances.index if tolerances.stated else None,
        wavelength_tolerance_nm=tolerances.wavelength_nm if tolerances.stated_nm else None,
    )


def _best(course: Course, belief: Floats, found: Found) -> tuple[Floats, Floats]:
    """The thickness of the likeliest order, and the probability of that order."""
    place = belief.argmax(axis=1)
    rows_ = np.arange(len(belief))
    best = found.thickness_nm[rows_, place]
    near = np.abs(found.thickness_nm - best[:, None]) <= course.near_nm(np.nan_to_num(best))[:, None]
    return best, np.where(near, belief, 0.0).sum(axis=1)


@dataclass
class _Rows:
    """What was found of the spectra that were asked, a row each."""

    thickness_nm: Floats
    interval_nm: Floats
    order_probability: Floats
    no_film: Floats
    verdict: npt.NDArray[np.str_]
    kappa: Floats
    precision_nm: Floats
    accuracy_nm: Floats


def _by_the_series(
    course: Course, belief: Floats, none: Floats, found: Found, probability: float, tolerances: Tolerances
) -> _Rows:
    best, mass = _best(course, belief, found)
    place = belief.argmax(axis=1)
    by_lamp, by_index = course.errors_of_all(best)
    sd = np.hypot(found.sd_nm[np.arange(len(best)), place], by_lamp)
    said, usual = (
        np.hypot(one.index * by_index, one.of_wavelengths(course.problem, course.nm, 0) * best)
        for one in (tolerances.said(), tolerances)
    )
    half, off = student(probability, 1e6) * np.hypot(sd, said), np.hypot(sd, usual)
    at_end = (best <= course.bounds[0] + 1e-6) | (best >= course.bounds[1] - 1e-6)
    words = np.where(mass > _CLEAR, "clear", "ambiguous").astype("<U9")
    if course.light.gain is None:
        # The size of the light varies: thin films, all of one order, are told from one another by little else.
        words[~is_known(best, sd)] = "ambiguous"
    if not course.learnt and course.light.lamp is None:
        # The lamp's first guess is the mean of the spectra, which holds the fringes of films that hardly change.
        words[words == "clear"] = "ambiguous"
    words[at_end | (found.kappa >= _WORST_KAPPA)] = "doubtful"
    words[(none > 0.5) | ~np.isfinite(best)] = "none"
    interval = np.stack([np.maximum(best - half, 0.0), best + half], axis=1)
    return _Rows(best, interval, mass, none, words, found.kappa, sd, off)


def _by_themselves(course: Course, alone: list[FitResult]) -> _Rows:
    """Each spectrum by itself, where the series tells no more."""
    quarter = quarter_wave_nm(course.problem, course.nm)
    unknown = (np.nan, np.nan)
    errors = [(one.best.precision_nm, one.best.accuracy_nm) if one.best else unknown for one in alone]
    precision, accuracy = np.array(errors).T
    return _Rows(
        np.array([one.best.thickness_nm if one.best else np.nan for one in alone]),
        np.array([one.best.interval_nm if one.best else unknown for one in alone]),
        np.array([order_share(one.solutions, quarter) if one.best else 0.0 for one in alone]),
        np.array([one.no_film for one in alone]),
        np.array([one.verdict for one in alone]),
        np.array([one.best.kappa if one.best else 1.0 for one in alone]),
        precision,
        accuracy,
    )


def _answer(
    course: Course,
    rows: _Rows,
    times: Floats,
    used: npt.NDArray[np.intp],
    probability: float,
    tolerances: Tolerances,
    stack: str,
    notes: list[str],
) -> SeriesResult:
    """The answer, a row a spectrum: nothing is known of those that were not asked."""

    def all_times(values: npt.NDArray[Any], otherwise: Any) -> npt.NDArray[Any]:
        out = np.full((times.size, *values.shape[1:]), otherwise, dtype=values.dtype)
        out[used] = values
        return out

    thickness = all_times(np.where(rows.verdict == "none", np.nan, rows.thickness_nm), np.nan)
    if (rows.kappa > 1.5).mean() > 0.5:
        notes.append(
            f"the noise is taken {float(np.median(rows.kappa)):.2g} times larger than estimated: the index, the line, or "
            "another stack"
        )
    if not tolerances.stated and np.isfinite(thickness).any():
        notes.append(
            "nothing was said of the film's index: intervals take it as exact, and accuracy_nm as good to "
            f"{100.0 * tolerances.index:g} % (standard deviation), in which all spectra are off alike; index_tolerance= says it"
        )
    return SeriesResult(
        times,
        thickness,
        all_times(rows.interval_nm, np.nan),
        all_times(rows.order_probability, 0.0),
        all_times(rows.no_film, 1.0),
        all_times(rows.verdict.astype("<U9"), "none"),
        all_times(rows.kappa, 1.0),
        course.nm,
        course.lamp / float(course.lamp.mean()),
        course.learnt,
        stack,
        probability,
        tuple(notes),
        all_times(rows.precision_nm, np.nan),
        all_times(rows.accuracy_nm, np.nan),
    )
