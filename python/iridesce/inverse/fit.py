"""Film thickness from a measured spectrum: every plausible answer with its probability, its interval and a verdict.

>>> import numpy as np
>>> import iridesce as ir
>>> wavelength_nm = np.arange(420.0, 760.0, 1.0)
>>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=812.0), "air"])
>>> noise = 1e-4 * np.random.default_rng(1).standard_normal(wavelength_nm.size)
>>> counts = 52_000.0 * (film.reflectance(wavelength_nm) + noise) + 300.0        # gain and offset unknown
>>> result = ir.fit_thickness(wavelength_nm, counts, "air / soap ? / air")
>>> result.verdict, len(result), round(result[0].thickness_nm)
('clear', 1, 812)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import number, one_of
from iridesce.files.spectra import Spectrum, read_spectrum
from iridesce.inverse.data import (
    check_reference,
    cleaned,
    heteroscedastic_weights,
    inside_media,
    referenced,
    unit,
    within_light,
    without_spikes,
)
from iridesce.inverse.doubt import Looks, looked_at
from iridesce.inverse.full import parted
from iridesce.inverse.joint import joint
from iridesce.inverse.measurement import Measurement
from iridesce.inverse.members import members
from iridesce.inverse.model import Problem, describe, read_problem
from iridesce.inverse.posterior import (
    Light,
)
from iridesce.inverse.results import FitResult, Solution, scaled
from iridesce.inverse.solve import Data
from iridesce.inverse.tolerances import Tolerances, read_tolerances
from iridesce.optics.averages import FWHM

__all__ = ["FitResult", "Measurement", "Solution", "Spectrum", "fit_thickness", "read_spectrum"]


def __dir__() -> list[str]:
    return __all__


BASELINES = ("none", "constant", "linear", "quadratic")
GAINS = ("linear", "quadratic")
_THINNEST_NM, _THICKEST_NM = 1.0, 50_000.0
_THICKEST_OF_SEVERAL_NM = 1_500.0
_FEWEST_POINTS = 12


def fit_thickness(
    wavelength_nm: npt.ArrayLike | None = None,
    measured: npt.ArrayLike | None = None,
    stack: Any = None,
    *,
    measurements: Sequence[Measurement] | None = None,
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
    dark: npt.ArrayLike | None = None,
    reference: npt.ArrayLike | None = None,
    reference_stack: Any = None,
    index_tolerance: float | None = None,
    wavelength_tolerance_nm: float | None = None,
    angle_tolerance_deg: float = 0.0,
) -> FitResult:
    """Unknown film thicknesses from a reflectance or transmittance spectrum: every plausible solution and its probability.

    measured = response * (spectrum of the stack through a Gaussian line of the instrument) + stray light. The search is
    global: a Fourier transform over the phase of the round trip shows which thick films have fringes at all; at these and at
    every thin one the whole model is compared with the data and the minima refined by least squares. What each is worth is
    its posterior: gain, the course of the lamp and stray light are integrated out as smooth curves, how far they bend and how
    understated the noise is are summed over, residuals that hang together count once, and "no film" and "something else"
    stand beside all films. ``verdict`` says in one word what that comes to.

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
    baseline       stray light: "none", "constant", "linear" or "quadratic"; "auto": a constant
                   where that will do, else smooth curves, told in ``notes``
    resolution_nm  full width at half maximum of the instrument's line; None: unknown, found where the data show it
    index          None: known; "constant": one unknown n; "cauchy": n = A + B/lambda^2 with A, B unknown; or a dict of
                   these by layer. k stays that of the medium. Thickness and n are told apart by contrast and dispersion only:
                   give the gain if you know it
    noise          standard deviation of the measurement, in its unit; None: estimated                () or (n,)
    probability    of the intervals
    dark, reference  counts of the same instrument without light, and with `reference_stack` in place of the film: measured is
                   then (measured - dark) / (reference - dark) times its reflectance or transmittance, the gain 1 within a few
                   per cent unless ``gain`` says otherwise, and channels without light are dropped             (n,)
    reference_stack  a `Stack` or text, "air / Si"; None: a perfect mirror (a free path, for transmittance)
    index_tolerance  standard deviation of the film's index, relative: intervals hold what the film moves with it, which no
                   misfit shows. None: nothing is known of it; intervals take it as exact, ``accuracy_interval_nm`` holds 0.01,
                   and a note says so. Of an index that is fitted it is not used
    wavelength_tolerance_nm  standard deviation of the spectrometer's wavelengths, all off alike: intervals hold it. None: they
                   take them as exact, and ``accuracy_interval_nm`` holds 0.3
    measurements   several `Measurement` of one film instead of wavelength_nm and measured: they share thicknesses, index
                   ("constant" at most) and an error of the angle; gain, baseline, noise, angle and reference are those of each.
                   Instruments' lines are taken as points, thicknesses looked for up to 10 000 nm (several unknowns: 1 000)
    angle_tolerance_deg  standard deviation of the angle of incidence, one error for all measurements; it is summed over
    Returns        `FitResult`, a sequence of `Solution`, best first
    Raises         ValueError: too few points, nothing that varies, all wavelengths outside the data of a medium, a layer
                   without fringes, and what else cannot be fitted
    Source         K. Levenberg, Quart. Appl. Math. 2, 164 (1944); D. W. Marquardt, J. SIAM 11, 431 (1963); variable
                   projection by L. Kaufman, BIT 15, 49 (1975); evidence: docs/guide/fit.md

    >>> import iridesce as ir
    >>> nm = np.linspace(450.0, 950.0, 600)
    >>> oxide = ir.Stack(["air", ir.Layer("SiO2", thickness_nm=1234.5), "Si"])
    >>> seen = oxide.reflectance_averaged(nm, resolution_nm=3.0).value
    >>> found = ir.fit_thickness(nm, seen, "air / SiO2 ? / Si", gain=1.0)
    >>> len(found), round(found[0].thickness_nm, 1), round(found[0].resolution_nm, 1)
    (1, 1234.5, 3.0)
    """
    tolerances = read_tolerances(index_tolerance, wavelength_tolerance_nm)
    angle_tolerance = number("angle_tolerance_deg", angle_tolerance_deg, low=0.0, high=20.0)
    probability = number("probability", probability, low=0.0, high=1.0, includes_low=False)
    if stack is None:
        raise complaint(
            "stack must say what the film is: text like 'air / soap ? / air', a Stack, or a list",
            "stack",
            "text, a Stack, or a list",
            None,
        )
    if measurements is not None:
        _check_alone(wavelength_nm=wavelength_nm, measured=measured, dark=dark, reference=reference, noise=noise)
        return _together(
            measurements, stack, layer, index, thickness_range_nm, tolerances, angle_tolerance, probability
        )
    if wavelength_nm is None or measured is None:
        raise complaint(
            "wavelength_nm and measured must be given, or measurements=",
            "wavelength_nm" if wavelength_nm is None else "measured",
            "given, or measurements=",
            None,
        )
    quantity = one_of("quantity", quantity, ("reflectance", "transmittance"))
    polarization = one_of("polarization", polarization, ("s", "p", "unpolarized"))
    baseline = one_of("baseline", baseline, ("auto", *BASELINES))
    angle = number("angle_deg", angle_deg, low=0.0, high=90.0)
    fixed_gain, bend = _gain(gain)
    line = None if resolution_nm is None else number("resolution_nm", resolution_nm, low=0.0) / FWHM
    problem = read_problem(stack, layer, index, quantity, angle, polarization)
    notes: list[str] = []
    light = Light(fixed_gain, True, bend > 0, baseline != "none")
    counted: Floats | None = None
    check_reference(dark, reference, reference_stack)
    filled: Floats | None = None
    lit: tuple[Floats, Floats] | None = None
    if reference is not None:
        wavelength_nm, measured, counted, filled, lit = referenced(
            problem, wavelength_nm, measured, dark, reference, reference_stack, noise, notes
        )
        if gain is None:
            fixed_gain, light = 1.0, Light(1.0, False, False, baseline != "none")
    nm, values, sd = cleaned(wavelength_nm, measured, noise if counted is None else counted, notes)
    known = inside_media(problem, nm, notes)
    nm, values, sd = nm[known], values[known], None if sd is None else sd[known]
    part = parted(nm, values, sd, filled, notes)
    nm, values, sd, held = part.wavelength_nm, part.values, part.sd, part.full
    terms = 1 if baseline == "auto" else BASELINES.index(baseline)
    linear = terms + (fixed_gain is None) * (1 + bend)
    parameters = len(problem.unknown) + problem.index_count + linear + (line is None)
    _check_enough(nm.size, parameters, notes)
    # The stack's own complaint about wavelengths outside its media, before anything else.
    problem.with_thickness([100.0] * len(problem.unknown)).reflectance(nm[[0, -1]], angle)
    scale = _scale(values)
    values, sd = values / scale, None if sd is None else sd / scale
    held = None if held is None else (held[0], held[1] / scale)
    if scale != 1.0 and fixed_gain is not None:
        fixed_gain /= scale
        light = replace(light, gain=fixed_gain)
    weight = np.ones_like(nm) if sd is None else unit(1.0 / sd)
    if np.ptp(values) <= 1e-12 * np.abs(values).max(initial=0.0) and sd is None:
        notes.append("measured does not vary with wavelength: no film is seen in it")
        return FitResult((), nm, values * scale, weight, 0.0, probability, describe(problem), tuple(notes), "none", 1.0)
    if noise is None:
        nm, values, sd, weight = _despiked(nm, values, sd, notes)
    bounds = _bounds(thickness_range_nm, problem, nm, notes)
    pliable = baseline == "auto" and nm.size >= 4 * (parameters + 4)
    seen_by = None if lit is None else np.interp(nm, *lit)
    looks = Looks(problem, Data(nm, values, weight, fixed_gain, bend, terms), sd, light, line, bounds, held, seen_by)
    return scaled(looked_at(looks, notes, pliable, probability, tolerances), scale)


def _check_alone(**given: object) -> None:
    """Beside measurements= nothing is given that each measurement has of its own."""
    twice = [name for name, value in given.items() if value is not None]
    if twice:
        raise complaint(
            f"{twice[0]} goes without measurements=, each of which has its own",
            twice[0],
            "left out beside measurements=",
            Words("both"),
        )


def _gain(given: float | str | None) -> tuple[float | None, int]:
    """The gain where it is known, and the degree of its course along the wavelengths where it is not."""
    if given is None:
        return None, 0
    if isinstance(given, str):
        return None, GAINS.index(one_of("gain", given, GAINS)) + 1
    if not (math.isfinite(fixed := number("gain", given)) and fixed > 0.0):
        raise refusal("gain", 'None, "linear", "quadratic" or a number > 0', Words(f"{fixed:g}"))
    return fixed, 0


def _check_enough(count: int, parameters: int, notes: list[str]) -> None:
    least = max(_FEWEST_POINTS, 2 * parameters)
    if count < least:
        words = f"{count} usable points are too few for {parameters} unknowns; at least {least}"
        raise complaint("; ".join([words, *notes]), "measured", f"{least} usable points or more", Words(count))


def _scale(values: Floats) -> float:
    """Squares of sizes far from 1 would run over or under; by a power of two nothing is rounded."""
    size = float(np.abs(values).max(initial=0.0))
    return 1.0 if 1e-60 < size < 1e60 or size == 0.0 else 2.0 ** math.floor(math.log2(size))


def _despiked(
    nm: Floats, values: Floats, sd: Floats | None, notes: list[str]
) -> tuple[Floats, Floats, Floats | None, Floats]:
    """Without spikes and where there is light, and what each point weighs: where the noise is not given."""
    if sd is None:
        within = within_light(values, notes)
        nm, values = nm[within], values[within]
    steady = without_spikes(values, notes)
    nm, values, sd = nm[steady], values[steady], None if sd is None else sd[steady]
    return nm, values, sd, heteroscedastic_weights(values, notes) if sd is None else unit(1.0 / sd)


_THICKEST_TOGETHER_NM, _THICKEST_OF_SEVERAL_TOGETHER_NM = 10_000.0, 1_000.0


def _together(
    measurements: Any,
    stack: Any,
    layer: Any,
    index: Any,
    thickness_range_nm: Any,
    tolerances: Tolerances,
    angle_tolerance_deg: float,
    probability: float,
) -> FitResult:
    """A joint fit of what was given."""
    listed = [measurements] if isinstance(measurements, Measurement) else list(measurements)
    if not listed or not all(isinstance(one, Measurement) for one in listed):
        raise refusal("measurements", "a list of ir.Measurement", measurements)
    problem = read_problem(stack, layer, index, "reflectance", max(one.angle_deg for one in listed), "unpolarized")
    if "cauchy" in problem.index:
        raise refusal("index", 'None or "constant" with measurements=', Words('"cauchy"'))
    if any(not one.coherent for one in problem.stack.layers) and any(one.of_polarization for one in listed):
        raise complaint(
            "psi and delta need a stack without incoherent layers",
            "stack",
            "one without incoherent layers for psi and delta",
            problem.stack,
        )
    notes: list[str] = []
    parts = members(listed, notes)
    nm = np.unique(np.concatenate([one.every_nm for one in parts]))
    # The media's own complaint about wavelengths, before anything else.
    problem.with_thickness([100.0] * len(problem.unknown)).reflectance(nm[[0, -1]], problem.angle_deg)
    high = _THICKEST_TOGETHER_NM if len(problem.unknown) == 1 else _THICKEST_OF_SEVERAL_TOGETHER_NM
    given = (_THINNEST_NM, high) if thickness_range_nm is None else thickness_range_nm
    if thickness_range_nm is None:
        notes.append(f"thicknesses were looked for from {_THINNEST_NM:g} to {high:g} nm; thickness_range_nm= says else")
    longest = max((one.wavelength_nm for one in parts), key=lambda one: one.size / np.ptp(one))
    bounds = _bounds(given, problem, longest, notes)
    return joint(problem, parts, bounds, tolerances, angle_tolerance_deg, probability, notes)


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
        pairs = plain_reals("thickness_range_nm", given, "(low, high) in nm")
        if pairs.shape == (2,):
            pairs = np.broadcast_to(pairs, (count, 2)).copy()
        if pairs.shape != (count, 2):
            raise refusal("thickness_range_nm", f"(low, high), or one pair for each of {count} unknowns", given)
    if not (np.isfinite(pairs).all() and (pairs[:, 0] >= 0.0).all() and (pairs[:, 1] > pairs[:, 0]).all()):
        raise refusal("thickness_range_nm", "0 <= low < high", Words(pairs.tolist()))
    if (pairs[:, 1] > 1e6).any():
        raise refusal("thickness_range_nm", "at 1e6 nm at most", Words(pairs.tolist()), must="end")
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
