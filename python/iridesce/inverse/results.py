"""Answers of a fit: solutions, each with its probability, and a verdict over all of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.inverse.measurement import Measurement

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Solution:
    """One plausible thickness, or set of thicknesses.

    thickness_nm     float, or a tuple where several are unknown (in the order of the layers)
    interval_nm      (low, high) that holds the thickness with the asked probability if this is the right order: noise, response,
                     and the tolerances of index and wavelengths that were stated; a tuple of such pairs for several
    sd_nm            standard deviation of all that, of a straight-line estimate
    accuracy_interval_nm, accuracy_nm    the same with what is usual where nothing was stated: 1 % of the film's index, 0.3 nm of
                     the wavelengths
    precision_interval_nm, precision_nm  the same of noise and response alone, index and wavelengths taken as exact: by this
                     films of one material on one instrument can be told apart
    misfit           root mean square of measured - fitted, in the unit of the measurement
    chi2             misfit over the noise, squared, a degree of freedom: 1 where the model explains the data; without a
                     noise given, over the scatter of neighbours in what is left
    weight           its probability: the weights, ``no_film`` and ``other`` of the result add to 1
    gain, gain_slope, gain_bend, baseline  measured = (gain + gain_slope x + gain_bend x^2) * model + sum baseline_i x^i, x
                     running from -1 to 1 over the wavelengths; of a response that bends otherwise, the parabolas nearest to it
    resolution_nm    full width at half maximum of the instrument's line (fitted, or as given)
    kappa            by how much the noise had to be larger than stated for the best explanation: 1, 3 or 10
    lit              share of the channels in which the response is above a tenth of its largest: less than half of them is a film
                     that is seen in a corner of the spectrum
    nm_per_percent_of_index  how far the thickness moves, nm, where the film's index is 1 % off: fringes show their product, so no
                     misfit tells it, and the interval holds it by ``index_tolerance`` alone. None where several are unknown
    angle_offset_deg  of joint fits with ``angle_tolerance_deg``: by how much the angles were found to be larger
    index            for each fitted index, by layer number: {"n": ...} or Cauchy's {"A": ..., "B_um2": ...}, with "sd" each
    wavelength_nm, fitted  the fitted curve in the unit of the measurement

    >>> import numpy as np
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
    kappa: float = 1.0
    angle_offset_deg: float = 0.0
    lit: float = 1.0
    nm_per_percent_of_index: float | None = None
    precision_nm: Any = math.nan
    precision_interval_nm: Any = (math.nan, math.nan)
    accuracy_nm: Any = math.nan
    accuracy_interval_nm: Any = (math.nan, math.nan)

    def to_dict(self) -> dict[str, Any]:
        """All but the curve, as plain values.

        Returns    dict

        >>> import numpy as np
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
    verdict          "clear": one order holds more than 0.95 of all probability; "ambiguous": several explanations share it;
                     "doubtful": nothing fits well, or the answer is an end of what was searched; "none": no film is the likeliest
    measurements     of a joint fit; wavelengths, measured and fitted values are then those of all, one after the other
    points           of a joint fit: how many of each measurement were used
    no_film, other   probability that no film is seen, and that it is something else than this stack

    >>> import numpy as np
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
    verdict: str = "clear"
    no_film: float = 0.0
    other: float = 0.0
    measurements: tuple[Measurement, ...] = ()
    points: tuple[int, ...] = ()

    @property
    def best(self) -> Any:
        """The likeliest solution; None where there is none (verdict "none"). Look at the others, too."""
        return self.solutions[0] if self.solutions else None

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

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(str(self))}</pre>"

    def plot(self, ax: Axes | None = None, *, title: str | None = None, theme: str | None = None) -> Axes:
        """The measurement and the curves of all solutions.

        ax, title, theme  as in `iridesce.plot`
        Returns    the Axes
        Raises     ValueError as there

        >>> import numpy as np
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

        >>> import numpy as np
        >>> import iridesce as ir
        >>> nm = np.arange(420.0, 760.0, 2.0)
        >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=500.0), "air"])
        >>> sorted(ir.fit_thickness(nm, film.reflectance(nm), film).to_dict())
        ['no_film', 'noise', 'notes', 'other', 'points', 'probability', 'solutions', 'stack', 'verdict']
        """
        return {
            "stack": self.stack,
            "points": int(self.wavelength_nm.size),
            "noise": self.noise,
            "probability": self.probability,
            "notes": list(self.notes),
            "verdict": self.verdict,
            "no_film": self.no_film,
            "other": self.other,
            "solutions": [solution.to_dict() for solution in self.solutions],
        }


def _table(result: FitResult) -> list[str]:
    """The answer for people."""
    percent = f"{100.0 * result.probability:g} %"
    count = len(result)
    lines = [
        f"{result.stack}: {result.verdict}, {count} plausible solution{'' if count == 1 else 's'}, "
        f"{result.wavelength_nm.size} points"
    ]
    for solution in result:
        several = not isinstance(solution.thickness_nm, float)
        values = solution.thickness_nm if several else (solution.thickness_nm,)
        intervals = solution.interval_nm if several else (solution.interval_nm,)
        accuracies = solution.accuracy_nm if several else (solution.accuracy_nm,)
        words = [
            f"{value:.2f} nm ({percent}: {low:.2f} to {high:.2f}; accuracy {accuracy:.2g})"
            for value, (low, high), accuracy in zip(values, intervals, accuracies, strict=True)
        ]
        for place, entry in solution.index.items():
            words.append(f"layer {place} " + ", ".join(f"{name} {value:.4g}" for name, value in entry.items()))
        lines.append(
            f"  {' + '.join(words)}   weight {solution.weight:.3g}, chi2 {solution.chi2:.3g}, misfit {solution.misfit:.3g}, "
            f"gain {solution.gain:.4g}, line {solution.resolution_nm:.2g} nm"
        )
    if result.no_film > 1e-3 or result.other > 1e-3:
        lines.append(f"  no film {result.no_film:.3g}, something else {result.other:.3g}")
    return [*lines, *(f"  note: {note}" for note in result.notes)]


def scaled(result: FitResult, scale: float) -> FitResult:
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


def order_share(solutions: Sequence[Solution], quarter_nm: float) -> float:
    """Probability of all within a quarter of a wave of the best solution."""
    best = solutions[0].thickness_nm
    # Below a quarter wave films differ in kind, not in order: a tenth of them is as near as "near" gets.
    near = min(quarter_nm, 0.25 * best + 3.0)
    return sum(one.weight for one in solutions if abs(one.thickness_nm - best) <= near)


# A thickness is known where noise and response leave it this good, relative or nm, with a probability of 95 %.
_KNOWN, _KNOWN_NM = 0.04, 3.0


def is_known(thickness_nm: Any, precision_nm: Any) -> Any:
    """Whether a thickness is known, and not its order alone: thin films are all of one order."""
    return 1.96 * precision_nm <= _KNOWN * thickness_nm + _KNOWN_NM


def apart(solved: list[tuple[Solution, float, bool]]) -> list[tuple[Solution, float, bool]]:
    """Peaks that lie within the precision of a likelier one are that one, reached from another side.

    What all channels share moves every peak alike: of a thick film 1 % of index is an order and more.
    """
    kept: list[tuple[Solution, float, bool]] = []
    for one in solved:
        if not any(_within(one[0], better[0]) for better in kept):
            kept.append(one)
    return kept


def _within(one: Solution, other: Solution) -> bool:
    if isinstance(other.thickness_nm, float):
        near = other.precision_interval_nm[0] <= one.thickness_nm <= other.precision_interval_nm[1]
    else:
        inside = zip(one.thickness_nm, other.precision_interval_nm, strict=True)
        near = all(low <= value <= high for value, (low, high) in inside)
    by = np.abs(np.subtract(one.thickness_nm, other.thickness_nm)).max()
    return bool(near or by < 3.0 * np.max(other.precision_nm))
