"""What is looked at again where a first look ends in doubt: an uneven film, a spectrum that steps. Internal.

Two detectors that do not meet, or the second order of a grating that sets in at twice the shortest wavelength, leave a step at
one wavelength: beyond it counts are (1 + gain) times what they were, and more by an offset. No lamp is so steep, and no film.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.inverse.analysis import Analysis
from iridesce.inverse.candidates import Search
from iridesce.inverse.model import HarmonicModel, Problem, uneven
from iridesce.inverse.posterior import PRIOR_FILM, PRIOR_NONE, Engine, Light, Measured, log_sum
from iridesce.inverse.results import FitResult
from iridesce.inverse.solve import Data, Fitted
from iridesce.inverse.tolerances import Tolerances

# Standard deviations of a step: of what the gain does there, and of the offset, in units of the mean measurement.
_STEP_SD = 0.15
# So probable is a step at all.
_PRIOR_STEP = 0.05
# Channels on either side of it, at least.
_FEWEST_BEYOND = 12
# Channels on either side of an edge that straight lines are laid through.
_NEAR = 12
# Standard deviations of an uneven thickness, relative, that are tried, and how many of the films found so are looked at.
_UNEVEN = (0.004, 0.008, 0.013)
_MOST_UNEVEN = 10
# Films that may stand before a step, best first.
_FILMS = 24


@dataclass(frozen=True)
class Step:
    """A step at one wavelength."""

    channel: int
    """The first one beyond."""
    wavelength_nm: float
    gain: float
    """What the gain does there, relative."""
    offset: float
    """In the unit of the data."""
    log_share: float
    """Logarithm of its share of what was possible: prior times volume."""

    @property
    def words(self) -> str:
        return (
            f"the measurement steps at {self.wavelength_nm:.1f} nm, by {100.0 * self.gain:+.2g} % and an offset "
            f"of {self.offset:+.2g}: it was taken out (two detectors that do not meet, a second order that begins there)"
        )


@dataclass(frozen=True)
class Looks:
    """A spectrum, and what a fit of it is told."""

    problem: Problem
    data: Data
    sd: Floats | None
    light: Light
    line: float | None
    bounds: Floats
    full: tuple[Floats, Floats] | None
    reference: Floats | None

    def analysis(self, notes: list[str]) -> Analysis:
        """One look."""
        return Analysis(
            self.problem,
            self.data,
            self.sd,
            self.light,
            self.line,
            self.bounds,
            list(notes),
            self.full,
            self.reference,
        )

    def without(self, step: Step) -> Looks:
        """The spectrum as it is without a step."""
        measured, sd = self.data.measured.copy(), None if self.sd is None else self.sd.copy()
        weight = self.data.weight.copy()
        beyond = slice(step.channel, None)
        measured[beyond] = (measured[beyond] - step.offset) / (1.0 + step.gain)
        weight[beyond] *= 1.0 + step.gain
        if sd is not None:
            sd[beyond] /= 1.0 + step.gain
        return replace(self, data=replace(self.data, measured=measured, weight=weight), sd=sd)


def looked_at(looks: Looks, notes: list[str], pliable: bool, probability: float, tolerances: Tolerances) -> FitResult:
    """The answer of one look, or of a second one where the first is `doubtful`."""
    first = looks.analysis(notes)
    answer = first.result(pliable, probability, tolerances)
    if answer.verdict != "doubtful" or not pliable or not first.single or looks.full is not None:
        return answer
    if paler := _uneven(first):
        paled = looks.analysis(notes).result(pliable, probability, tolerances, paler)
        if paled.verdict != "doubtful":
            return paled
    for start in (best_step(looks.data, list(_spectra(first))), sharpest_step(looks.data)):
        if start is not None and (found := _stepping(looks, notes, first, start, pliable, probability, tolerances)):
            return found
    return answer


def _uneven(first: Analysis) -> list[tuple[Fitted, Search]]:
    """Minima of films so uneven that their fringes are seen at the long end alone: no line of an instrument pales so.

    None where they come no nearer to the data than what was met.
    """
    if first.line is not None or not isinstance(first.model, HarmonicModel):
        return []
    nm = first.data.wavelength_nm
    lines = tuple(share * float(np.mean(nm)) for share in _UNEVEN)
    search = Search(first.problem, HarmonicModel(uneven(first.model.of, nm)), first.data, None, first.bounds, lines)
    least = min((one.misfit for one, _ in first.met), default=math.inf)
    return [(one, search) for one in search.candidates()[:_MOST_UNEVEN] if one.misfit < least]


def _stepping(
    looks: Looks,
    notes: list[str],
    first: Analysis,
    start: Step,
    pliable: bool,
    probability: float,
    tolerances: Tolerances,
) -> FitResult | None:
    """The answer without a step, where it is one and likelier than that of the first look."""
    step: Step | None = start
    for turn in range(2):
        if step is None:
            return None
        other = looks.without(step).analysis([*notes, step.words])
        found = other.result(pliable, probability, tolerances)
        if not found or (turn == 1 and found.verdict == "doubtful"):
            return None
        before, step = step, best_step(looks.data, [other.rated[0].spectrum])
    return found if _likelier(first, other, before) else None


def _spectra(first: Analysis) -> Iterator[Floats]:
    """Of the films that a first look met."""
    for fitted, search in sorted(first.met, key=lambda one: one[0].misfit)[:_FILMS]:
        yield search.model.value(fitted.parameters)


def best_step(data: Data, spectra: list[Floats]) -> Step | None:
    """The step that leaves least, whichever of these films is there."""
    best: tuple[float, Step] | None = None
    for spectrum in spectra:
        found = _step(data, spectrum)
        if found is not None and (best is None or found[0] < best[0]):
            best = found
    return None if best is None else best[1]


def _step(data: Data, spectrum: Floats) -> tuple[float, Step] | None:
    """Misfit and step of one film, by least squares at each channel with the step's own prior."""
    count = spectrum.size
    if count < 4 * _FEWEST_BEYOND:
        return None
    weight = data.weight
    columns = [spectrum * weight] + ([weight] if data.baseline else [])
    target = data.measured * weight
    if data.gain is not None:
        target = target - data.gain * columns.pop(0)
    size = float(np.mean(np.abs(data.measured)))
    # Of two sides: (1 + gain) times what is before, and the offset. With the light as it is, a multiple of the data themselves
    # would carry their noise: the film and a constant stand for both.
    mean = float(np.mean(np.abs(spectrum))) or 1.0
    jumps = [spectrum / mean * size * weight, size * weight]
    whole = np.column_stack([*columns, *jumps])
    own, every = len(columns), len(columns) + 2
    product = whole[:, :, None] * whole[:, None, :]
    beyond = np.cumsum(product[::-1], axis=0)[::-1]
    right = np.cumsum((whole * target[:, None])[::-1], axis=0)[::-1]
    places = np.arange(_FEWEST_BEYOND, count - _FEWEST_BEYOND)
    normal = beyond[places].copy()
    normal[:, :own, :own] = beyond[0, :own, :own]
    sides = right[places].copy()
    sides[:, :own] = right[0, :own]
    # The noise, for the prior's weight: what neighbours differ by.
    noise = float(np.median(np.abs(np.diff(target, 2)))) / 0.6745 / math.sqrt(6.0)
    ridge = np.zeros(every)
    ridge[own:] = (noise / _STEP_SD) ** 2
    normal = normal + np.diag(ridge) + 1e-14 * np.trace(beyond[0]) * np.eye(every)
    found = np.linalg.solve(normal, sides[..., None])[..., 0]
    misfit = float(target @ target) - (found * sides).sum(axis=1)
    top = int(np.argmin(misfit))
    spread = np.linalg.inv(normal[top])[own:, own:] * noise**2
    jump, offset = (float(one) for one in found[top, own:])
    level = data.gain if data.gain is not None else float(found[top, 0])
    if level <= 0.0:
        return None
    gain = jump * size / mean / level
    stray = float(found[top, own - 1]) if data.baseline else 0.0
    # What comes before is gain R + stray; beyond, (1 + gain)(level R + stray) + rest.
    rest = offset * size - gain * stray
    if not -0.5 < gain < 1.0:
        return None
    volume = 0.5 * float(np.linalg.slogdet(spread / _STEP_SD**2)[1]) - 0.5 * (jump**2 + offset**2) / _STEP_SD**2
    share = math.log(_PRIOR_STEP) - math.log(places.size) + volume
    channel = int(places[top])
    where = 0.5 * float(data.wavelength_nm[channel - 1] + data.wavelength_nm[channel])
    return float(misfit[top]), Step(channel, where, gain, rest, share)


def sharpest_step(data: Data) -> Step | None:
    """Where straight lines through the channels on either side differ most, in their noise, and by which factor."""
    count = data.measured.size
    if count < 4 * _FEWEST_BEYOND:
        return None
    x = np.arange(_NEAR) + 0.5
    basis = np.stack([np.ones(_NEAR), x], axis=1)
    # Values of the lines at the edge between two channels.
    at_edge = np.linalg.pinv(basis)[0]
    before = np.convolve(data.measured, at_edge, mode="valid")
    beyond = np.convolve(data.measured, at_edge[::-1], mode="valid")
    before, beyond = before[:-_NEAR], beyond[_NEAR:]
    top = int(np.argmax(np.abs(beyond - before) * data.weight[_NEAR : count - _NEAR + 1]))
    if not (before[top] > 0.0 and 0.5 < beyond[top] / before[top] < 2.0):
        return None
    channel = top + _NEAR
    where = 0.5 * float(data.wavelength_nm[channel - 1] + data.wavelength_nm[channel])
    return Step(channel, where, float(beyond[top] / before[top]) - 1.0, 0.0, 0.0)


def _likelier(first: Analysis, other: Analysis, step: Step) -> bool:
    """Whether a step and what is left are likelier than the best without one, by the same noise."""
    of = other.engine.of
    scale = np.ones_like(of.sd)
    scale[step.channel :] = 1.0 + step.gain
    whole = Engine(Measured(of.wavelength_nm, first.data.measured, of.sd * scale, of.mean, of.light), first.light)
    engine = Engine(of, other.light)
    with_step = _log_evidence(engine, other) + step.log_share - float(np.log(scale).sum())
    return with_step > _log_evidence(whole, first)


def _log_evidence(engine: Engine, of: Analysis) -> float:
    """Of the best film of an analysis, and of none, not tempered."""
    bare = [of.model.of.base] if isinstance(of.model, HarmonicModel) else []
    none, other = engine.without_film(*bare)
    logs = [math.log(PRIOR_NONE) + none, other]
    for one in of.rated[:3]:
        logs.append(math.log(PRIOR_FILM) + log_sum(engine.log_evidences(one.spectrum, engine.films(one.spectrum))[0]))
    return log_sum(np.array(logs))
