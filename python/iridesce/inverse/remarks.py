"""What an answer is told with: the notes of a fit, from its solutions and its verdict. Internal."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.inverse.candidates import WIDEST_LINE_NM
from iridesce.inverse.posterior import Light
from iridesce.inverse.results import Solution
from iridesce.inverse.tolerances import Tolerances
from iridesce.inverse.verdict import LEAST_LIT

# Stray light that changes by more than this, of what the measurement varies by, is told.
_DRIFT = 0.1


@dataclass(frozen=True)
class Known:
    """What the fit was told."""

    light: Light
    bounds: Floats
    """(unknown, 2), nm"""
    line: float | None
    layers: list[int]
    """Numbers of the unknown layers, from 1."""
    single: bool
    """One thickness is all that is unknown."""


def remarks(
    known: Known, measured: Floats, solutions: tuple[Solution, ...], verdict: str, tolerances: Tolerances
) -> Iterator[str]:
    """Each doubt, in words."""
    if verdict == "none":
        yield (
            "no film is the likeliest explanation: there are no fringes that a lamp or the bare base could not make"
            + ("" if known.light.gain is not None else "; thin films need a known gain (gain=1.0), or a reference")
        )
    if not solutions:
        return
    best = solutions[0]
    yield from _ends(known, best)
    if known.line is None and best.resolution_nm >= 0.999 * WIDEST_LINE_NM:
        yield (
            f"the fringes are paler than even a line of {WIDEST_LINE_NM:g} nm makes them: uneven film, or another stack"
        )
    bend = max(abs(best.gain_slope), abs(best.gain_bend))
    if known.light.gain is None and not known.light.bent and bend > 0.02 * best.gain:
        yield (
            "an even gain does not fit; it was taken as a smooth curve, and stray light too (a drifting lamp, counts that "
            "were not divided by it)"
        )
    if best.lit < LEAST_LIT:
        yield (
            f"the fringes of this film are seen in {best.lit:.0%} of the channels alone: a line of the lamp, or noise, may "
            "be all that it explains"
        )
    drift = max((abs(one) for one in best.baseline[1:]), default=0.0)
    if (known.light.gain is not None or bend == 0.0) and drift > _DRIFT * float(np.std(measured)):
        yield "stray light changes along the spectrum; it was taken as a smooth curve"
    if best.kappa > 1.0:
        yield (
            f"the best curve misses the data by about {best.kappa:g} times the noise: the index, the wavelengths or "
            "another stack"
        )
    if float(np.std(measured - best.fitted)) > 0.7 * float(np.std(measured)):
        yield "the model explains less than half of what varies: doubt the stack or the data"
    if not tolerances.stated and known.single and verdict != "none" and best.nm_per_percent_of_index is not None:
        # Index and thickness cannot be told apart: what is taken of the index is said, with what it makes.
        yield (
            "nothing was said of the film's index: the interval takes it as exact, and the accuracy as good to "
            f"{100.0 * tolerances.index:g} % (standard deviation), of which the thickness moves by "
            f"{100.0 * tolerances.index * best.nm_per_percent_of_index:.2g} nm, and no misfit shows it; index_tolerance= says it"
        )


def _ends(known: Known, best: Solution) -> Iterator[str]:
    """Layers whose interval reaches an end of what was searched."""
    for place, (low, high) in enumerate(known.bounds):
        interval = best.precision_interval_nm if len(known.bounds) == 1 else best.precision_interval_nm[place]
        if interval[0] <= low or interval[1] >= high:
            yield (
                f"the interval of layer {known.layers[place]} reaches an end of thickness_range_nm "
                f"({low:g} to {high:g} nm)" + ("" if known.light.gain else "; a known gain tells thin films apart")
            )
