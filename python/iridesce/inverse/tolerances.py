"""What a fit takes for granted, and how well it may: the film's index and the scale of the wavelengths. Internal.

Fringes show n h / lambda. A film's index and the calibration of a spectrometer are errors that every channel, and every spectrum
of one instrument, shares: no misfit shows them and no average takes them out (type B of the Guide to the Expression of
Uncertainty in Measurement, JCGM 100:2008). What was said of them stands in the interval; what is usual, where nothing was said,
in the accuracy that is told beside it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.arguments.scalars import number
from iridesce.inverse.model import Model, Problem, by_index, relative_slopes
from iridesce.inverse.peak import Peak, climb
from iridesce.inverse.posterior import Engine, only
from iridesce.inverse.search import round_trip_rate
from iridesce.inverse.solve import Fitted, Solver

# Where nothing is said of the index: a standard deviation of it, relative. Evaporated, sputtered and thermally grown films differ
# from the tables by 0.3 to 2 %.
INDEX = 0.01
# Where nothing is said of the wavelengths, nm: compact spectrometers are calibrated to 0.1 to 0.5 nm.
WAVELENGTH_NM = 0.3


@dataclass(frozen=True)
class Tolerances:
    """Standard deviations of what all channels share."""

    index: float
    """Of the film's index, relative."""
    wavelength_nm: float
    """Of all wavelengths together."""
    stated: bool
    """Whether the user said how well the index is known."""
    stated_nm: bool
    """Whether the user said how well the wavelengths are known."""

    def said(self) -> Tolerances:
        """What was said alone: the rest taken as exact."""
        return replace(
            self,
            index=self.index if self.stated else 0.0,
            wavelength_nm=self.wavelength_nm if self.stated_nm else 0.0,
        )

    def of_wavelengths(self, problem: Problem, wavelength_nm: Floats, which: int) -> float:
        """Standard deviation of a thickness, of itself: fringes stay where thickness and wavelengths grow alike."""
        rate = round_trip_rate(problem, wavelength_nm, which)
        nm = wavelength_nm
        return self.wavelength_nm * abs(float(np.log(rate[-1] / rate[0]))) / float(nm[-1] - nm[0])

    def of_layers(self, problem: Problem, wavelength_nm: Floats, at: tuple[Solver, Fitted, list[int]]) -> list[float]:
        """Standard deviation of each unknown thickness: by the wavelengths, and by each index that is not fitted.

        An index that is off moves its own layer, n times h held, and the others by what that leaves.

        at      a fit, and which of its parameters are free
        """
        solver, fitted, free = at
        count = len(problem.unknown)
        thickness = [float(value) for value in fitted.parameters[:count]]
        squares = np.array(
            [(h * self.of_wavelengths(problem, wavelength_nm, one)) ** 2 for one, h in enumerate(thickness)]
        )
        for which, model in enumerate(problem.index):
            if model is None and self.index > 0.0:
                slope, _ = relative_slopes(problem, wavelength_nm, thickness, which)
                moved = self.index * solver.moved(fitted, free, slope)[:count]
                moved[which] = max(abs(moved[which]), self.index * thickness[which])
                squares += moved**2
        return [float(one) for one in np.sqrt(squares)]


def read_tolerances(index_tolerance: float | None, wavelength_tolerance_nm: float | None) -> Tolerances:
    """The tolerances that were given, or those that hold where none was."""
    index = INDEX if index_tolerance is None else number("index_tolerance", index_tolerance, low=0.0, high=1.0)
    nm = (
        WAVELENGTH_NM
        if wavelength_tolerance_nm is None
        else number("wavelength_tolerance_nm", wavelength_tolerance_nm, low=0.0, high=100.0)
    )
    return Tolerances(index, nm, index_tolerance is not None, wavelength_tolerance_nm is not None)


def widened(thickness_nm: float, low: float, high: float, by_nm: float) -> tuple[float, float]:
    """The interval from `low` to `high` about a thickness, nm, with an error besides that reaches as far as `by_nm`."""
    return max(thickness_nm - math.hypot(low, by_nm), 0.0), thickness_nm + math.hypot(high, by_nm)


# No film moves by more than this many times the share that its index is off by: 20 nm of soap by 5.
_STEEPEST = 10.0


def by_index_off(
    engine: Engine,
    off: Callable[[float, float], Floats],
    peak: Peak,
    tolerance: float,
    bounds: tuple[float, float] | None,
    step_nm: float,
) -> tuple[float, float]:
    """How far the thickness moves with one standard deviation of the index, and with 1 % of it, nm.

    bounds    given for a thin film, which shows how large n is, under one explanation by more and under another by less: all
              are asked
    step_nm   about the width of the peak
    """
    if bounds is not None and tolerance > 0.0:
        moved = moved_by_index(engine, off, peak, tolerance, bounds)
        return moved, 0.01 * moved / tolerance
    per_percent = near_index(engine, off, peak, 0.01, step_nm)
    return 100.0 * tolerance * per_percent, per_percent


def moved_by_index(
    engine: Engine,
    off: Callable[[float, float], Floats],
    peak: Peak,
    tolerance: float,
    bounds: tuple[float, float],
) -> float:
    """How far the thickness moves with the index, from peaks at minus and plus one standard deviation of it, nm.

    Fringes show n h, and a thin film shows how large n is besides: 1 % of the index of soap is 5 % of a film of 20 nm. What the
    contrast of the fringes says of the index is not used: stray light and the lamp change it, too.

    off       the spectrum of a thickness whose index is off by a share
    """
    step = max(peak.sd_nm, 1e-6)

    def top(by: float) -> Peak:
        return climb(engine, lambda h: off(h, by), peak.thickness_nm / (1.0 + by), step, bounds)

    below, above = top(-tolerance), top(tolerance)
    least = tolerance * peak.thickness_nm
    return min(max(0.5 * abs(above.thickness_nm - below.thickness_nm), least), _STEEPEST * least)


def near_index(
    engine: Engine, off: Callable[[float, float], Floats], peak: Peak, share: float, step_nm: float
) -> float:
    """`moved_by_index` for an index that is off by a share, under the likeliest explanation alone: to say it in words."""
    best = only(peak.best)
    tops = []
    for by in (-share, share):
        h, step = peak.thickness_nm / (1.0 + by), max(peak.sd_nm, step_nm)
        for _ in range(8):
            step = min(step, 0.5 * h)
            places = np.array([h - step, h, h + step])
            below, at, above = engine.log_evidences(np.array([off(float(one), by) for one in places]), best)[:, 0]
            bend = 2.0 * at - below - above
            if bend > 0.0:
                move = min(max(0.5 * step * (above - below) / bend, -3.0 * step), 3.0 * step)
            else:
                move = math.copysign(3.0 * step, above - below)
            h = max(h + move, 1e-3 * peak.thickness_nm)
            if abs(move) < 0.3 * step:
                break
        tops.append(h)
    least = share * peak.thickness_nm
    return min(max(0.5 * abs(tops[1] - tops[0]), least), _STEEPEST * least)


def with_index_off(
    problem: Problem, wavelength_nm: Floats, model: Model, parameters: Floats
) -> Callable[[float, float], Floats]:
    """The spectrum of a thickness whose index is off by a share, all else as in `parameters`."""

    def off(thickness_nm: float, by: float) -> Floats:
        same = thickness_nm * (1.0 + by)
        spectrum = model.value(np.array([same, *parameters[1:]]))
        # Fringes that are paled say nothing of the contrast.
        return spectrum if parameters[-1] > 0.0 else spectrum + by * by_index(problem, wavelength_nm, same)

    return off
