"""One word over all explanations of a spectrum. Internal; the words are defined in docs/guide/fit.md."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.inverse.model import Problem, quarter_wave_nm
from iridesce.inverse.posterior import Light
from iridesce.inverse.results import Solution, is_known, order_share
from iridesce.inverse.search import round_trip_rate

# One order holds the answer where it has this share of all probability.
_CLEAR = 0.95
# As many fringes a lamp of unknown course may imitate: no answer below them is clear unless its response is even or known.
FRINGES_OF_A_LAMP = 1.5
_WORST_KAPPA = 10.0
# A lamp shows a film in this share of its channels, at least: where its response is above this share of its largest.
LEAST_LIT, _DIM = 0.5, 0.1


def lit_share(response: Floats) -> float:
    """Share of the channels in which a film is seen; 0 where the response is below nought, of fringes upside down."""
    return float(np.mean(response > _DIM * response.max()))


@dataclass(frozen=True)
class Asked:
    """What was asked of a spectrum."""

    problem: Problem
    wavelength_nm: Floats
    light: Light
    single: bool
    """One thickness is all that is unknown."""


def verdict_of(asked: Asked, solutions: tuple[Solution, ...], without: tuple[float, float], at_end: bool) -> str:
    """The word.

    without    probability of no film, and of something else
    at_end     whether the best answer is an end of what was searched
    """
    none, other = without
    if none > 0.5 or not solutions:
        return "none"
    best = solutions[0]
    # A film that is seen in a corner of the spectrum alone is a line of the lamp, or noise that is larger there.
    if other > 0.5 or best.kappa >= _WORST_KAPPA or at_end or best.lit < LEAST_LIT:
        return "doubtful"
    # A lamp that bends, or a baseline that drifts, can make one fringe out of nothing: below, and just above, the response
    # has to be known.
    bends = max(abs(best.gain_slope), abs(best.gain_bend)) > 0.0 or len(best.baseline) > 1
    thin = _fringes(asked, best) < FRINGES_OF_A_LAMP
    if asked.light.gain is None and bends and thin:
        return "ambiguous"
    if asked.single and thin and not is_known(best.thickness_nm, best.precision_nm):
        return "ambiguous"
    quarter_nm = quarter_wave_nm(asked.problem, asked.wavelength_nm)
    share = order_share(solutions, quarter_nm) if asked.single else best.weight
    return "clear" if share > _CLEAR else "ambiguous"


def _fringes(asked: Asked, one: Solution) -> float:
    """How many fringes a solution has over the spectrum, of all unknown layers together."""
    thickness = np.atleast_1d(np.asarray(one.thickness_nm, dtype=float))
    turns = [np.ptp(round_trip_rate(asked.problem, asked.wavelength_nm, i)) for i in range(thickness.size)]
    return float(thickness @ np.array(turns) / (2.0 * np.pi))
