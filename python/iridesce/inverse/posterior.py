"""How likely each explanation of a spectrum is: films, no film, something else. Internal.

Whatever enters linearly (gain, the course of the lamp, stray light) is integrated out by the core
(`crates/inverse/src/evidence.rs`); how strongly these may bend, how large the gain and how understated the noise are is summed
over, each with its prior, never chosen. What neighbouring channels share counts once (`temper`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats

# How far along the wavelengths a lamp, a mirror or a detector keeps its size (nm), and by how much it changes.
LENGTHS_NM = (20.0, 32.0, 50.0, 120.0, 120.0)
BENDS = (0.05, 0.3)
# A lamp is a wide bell with narrower bumps on it: (length, share of the variance) of what is finer on each of these curves. With
# one length alone the wide ones won, bumps were left to the film, and errors were twice what the intervals said.
_FINE = (20.0, 0.04)
# A bell without any bumps is a lamp, too: the last of the lengths.
_BARE = len(LENGTHS_NM) - 1
# A baseline that drifts under an even or a known response: slowly, and by as much of the stray light. So probable where the
# response is even and there is stray light.
_DRIFT_NM, _DRIFT, _DRIFTS = 200.0, 0.5, 0.3
# What is neither film nor lamp: curves finer than any lamp.
_OTHER_LENGTHS_NM = (5.0, 10.0)
_OTHER_BENDS = (0.1, 0.4)
KAPPAS = (1.0, 3.0, 10.0)
# Stray light, of the mean reflectance or transmittance of the stack over all its thicknesses.
_STRAYS = (0.05, 0.5)
_FREE_LEVEL = 0.3
# An unknown gain is known to a factor of 3 from the size of the data: sd of its logarithm.
_GAIN_SD = 0.5 * math.log(10.0)
_GAIN_STEP = 10.0**0.25
# A reference is as good as this: sd of its level, and of its course along the wavelengths, which is never quite even: taken
# for even where that could not be excluded, intervals of thin films were too narrow by a half.
_REFERENCED = 0.03
# A gain that the user states as a number holds at every wavelength, with this probability; else it bends like a reference.
_STATED = 0.95
PRIOR_FILM, PRIOR_NONE, PRIOR_OTHER = 0.9, 0.0999, 0.0001
# Films of 50 nm and of 100 nm are as probable as such of 1000 and of 2050: prior density 1 / (h + 50 nm).
_PRIOR_NM = 50.0


@dataclass(frozen=True)
class Light:
    """What is known of gain, lamp and stray light."""

    gain: float | None
    """Known gain, or None."""
    exact: bool
    """A known gain holds at every wavelength (but for a tolerance that costs evidence); else it bends like a reference."""
    bent: bool
    """The user says that the gain changes along the wavelengths."""
    stray: bool
    """Whether there can be stray light."""


@dataclass(frozen=True)
class Measured:
    """What was measured, in the order of the wavelengths."""

    wavelength_nm: Floats
    measured: Floats
    sd: Floats
    mean: float
    """Mean reflectance or transmittance of the stack over thickness and wavelength: what gains are measured by."""
    light: Floats | None = None
    """Of the reference, at each channel, in any unit: what counts were divided by."""

    def averaged(self, step: int) -> Measured:
        """Means of so many neighbouring points."""
        size = self.wavelength_nm.size // step * step
        nm, values, sd = (
            one[:size].reshape(-1, step).mean(axis=1)
            for one in (self.wavelength_nm, self.measured, self.sd / math.sqrt(step))
        )
        light = None if self.light is None else self.light[:size].reshape(-1, step).mean(axis=1)
        return Measured(nm, values, sd, self.mean, light)


class Nuisance(NamedTuple):
    """One row of `Explanations`: a number for each of these names, as the core has them (crates/inverse/src/evidence.rs)."""

    curves: float
    gain: float
    level: float
    bend: float
    stray: float
    kappa: float
    drift: float = 0.0
    counted: float = 0.0
    """1 where stray light is one of counts, 0 where it came through the lamp. The core is told by what it is given."""


@dataclass(frozen=True)
class Explanations:
    """Nuisances, one a row, and the logarithm of the prior of each."""

    rows: Floats
    """(explanations, numbers of a `Nuisance`)"""
    log_prior: Floats

    def of(self, name: str) -> Floats:
        """One number of a `Nuisance`, of all of them."""
        return np.asarray(self.rows[:, Nuisance._fields.index(name)])

    def only(self, places: npt.NDArray[np.intp]) -> Explanations:
        return Explanations(self.rows[places], self.log_prior[places])


def temper(residual: Floats) -> float:
    """By how much the independent channels are fewer, for residuals in units of the noise.

    1 + 2 sum (1 - k/N) rho_k, pairs of lags summed while positive: sums of two neighbouring lags are positive, so the first
    that is not ends it (C. J. Geyer, Statist. Sci. 7, 473 (1992)).
    """
    left = residual - residual.mean()
    size = float(left @ left)
    count = left.size
    if size <= 0.0 or count < 8:
        return 1.0
    total = 0.0
    for lag in range(1, count // 3, 2):
        pair = float(left[lag:] @ left[:-lag] + left[lag + 1 :] @ left[: -lag - 1]) / size
        # By chance a sum of two correlations reaches 2 sqrt(2 / N).
        if pair <= 2.0 * math.sqrt(2.0 / count):
            break
        total += pair
    # What hangs together far below the noise is rounding, and no noise.
    return float(max(1.0, (1.0 + 2.0 * total) * min(size / count, 1.0)))


def log_sum(values: Floats) -> float:
    """log sum exp."""
    top = float(np.max(values, initial=-np.inf))
    return -math.inf if not math.isfinite(top) else top + math.log(float(np.exp(values - top).sum()))


def log_twice_normal(z: float) -> float:
    """Logarithm of twice the normal distribution function, for z <= 0: 0 where nothing is missing."""
    if z > -8.0:
        return math.log(math.erfc(-z / math.sqrt(2.0)))
    # Asymptotically (Abramowitz & Stegun 26.2.12).
    return -0.5 * z * z - math.log(-z) - 0.5 * math.log(0.5 * math.pi)


class Engine:
    """Evidence of one measured spectrum."""

    def __init__(self, measured: Measured, light: Light) -> None:
        self.of, self.light = measured, light
        self.tempered = 1.0
        # A reference has taken the lamp's bumps out: what is left of them is smooth.
        smooth = light.gain is not None
        self.lamps = range(_BARE if smooth else len(LENGTHS_NM))
        shares = [0.0 if smooth or place == _BARE else _FINE[1] for place in range(len(LENGTHS_NM))]
        self.curves = [(length, _FINE[0], share) for length, share in zip(LENGTHS_NM, shares, strict=True)]
        self.curves += [(length, length, 0.0) for length in (*_OTHER_LENGTHS_NM, _DRIFT_NM)]
        nm = measured.wavelength_nm
        # A baseline of counts (a dark that drifts) is, divided by the reference, largest where the lamp is dimmest: evidence
        # of the counts themselves.
        self.per_light = None if measured.light is None else measured.light / float(measured.light.mean())
        # Curves whose length is below two channels are noise.
        self.fine = [length for length in _OTHER_LENGTHS_NM if length > 2.0 * float(np.median(np.diff(nm)))]

    def log_evidences(self, spectra: Floats, explanations: Explanations) -> Floats:
        """Tempered log of evidence times prior, (spectra, explanations)."""
        of, rows = self.of, explanations.rows
        spectra = np.atleast_2d(spectra)
        out = np.empty((len(spectra), len(rows)))
        counted = explanations.of("counted") > 0.0
        for kind in np.unique(counted):
            chosen = counted == kind
            curves, needed = self._needed(rows[chosen])
            scale = self.per_light if kind and self.per_light is not None else np.ones_like(of.sd)
            found = _core.inverse_evidence(
                of.wavelength_nm,
                of.measured * scale,
                of.sd * scale,
                np.ascontiguousarray(spectra * scale),
                curves,
                needed,
            )
            # Densities of what was measured, not of counts.
            out[:, chosen] = found + float(np.log(scale).sum())
        return np.asarray(out / self.tempered + explanations.log_prior)

    def explain(self, spectrum: Floats, row: Floats) -> tuple[Floats, Floats]:
        """Response and stray light under one nuisance."""
        of = self.of
        rows = np.atleast_2d(row)
        curves, needed = self._needed(rows)
        counted = Nuisance(*row).counted > 0.0
        scale = self.per_light if counted and self.per_light is not None else np.ones_like(of.sd)
        response, stray = _core.inverse_explain(
            of.wavelength_nm,
            of.measured * scale,
            of.sd * scale,
            np.ascontiguousarray(spectrum * scale),
            curves,
            needed,
        )
        return response, stray / scale

    def _needed(self, rows: Floats) -> tuple[list[tuple[float, float, float]], Floats]:
        """The curves that these nuisances use, and the nuisances counting among them: curves cost time to make."""
        of = Nuisance(*rows.T)
        used, place = np.unique(np.asarray(of.curves).astype(int), return_inverse=True)
        told = np.column_stack([place.reshape(-1), of.gain, of.level, of.bend, of.stray, of.kappa, of.drift])
        return [self.curves[one] for one in used], np.ascontiguousarray(told)

    def films(self, spectrum: Floats) -> Explanations:
        """What may lie between a film of this spectrum and the data."""
        gains = self._gains(spectrum)
        known = self.light.gain is not None
        even = 0.0 if self.light.bent or (known and not self.light.exact) else _STATED if known else 0.5
        # Curves, how far the response bends with them, and how far the stray light, each with its probability.
        drifting = len(self.curves) - 1
        bends: list[tuple[int, float, float, float]] = []
        drifts = _DRIFTS if self.light.stray else 0.0
        if even > 0.0:
            bends.append((0, 0.0, 0.0, even * (1.0 - drifts)))
            bends += [(drifting, 0.0, _DRIFT, even * drifts)] if drifts else []
        shapes = [(place, bend, bend) for place in self.lamps for bend in self._bends()]
        if known and drifts:
            shapes.append((self.lamps[-1], self._bends()[-1], _DRIFT))
        bends += [(place, bend, drift, (1.0 - even) / len(shapes)) for place, bend, drift in shapes]
        rows, priors = [], []
        for gain, gain_prior in gains:
            for place, bend, drift, bend_prior in bends:
                exact = self.light.gain is not None and self.light.exact and bend == 0.0
                level = 0.0 if exact else _FREE_LEVEL if self.light.gain is None else _REFERENCED
                strays = [size * self.of.mean for size in _STRAYS] if self.light.stray else [0.0]
                # Of light through the same lamp, or of counts.
                kinds = (0.0, 1.0) if self.per_light is not None and self.light.stray else (0.0,)
                for stray, kappa, kind in product(strays, KAPPAS, kinds):
                    rows.append(Nuisance(place, gain, level, bend, stray, kappa, drift, kind))
                    priors.append(gain_prior + math.log(bend_prior / len(strays) / len(KAPPAS) / len(kinds)))
        return Explanations(np.array(rows), np.array(priors))

    def quick(self, spectrum: Floats) -> Explanations:
        """Few of `films`, enough to tell which are worth a closer look."""
        every = self.films(spectrum)
        curves, bend, stray = every.of("curves"), every.of("bend"), every.of("stray")
        flat = (bend == 0.0) | (self.light.gain is not None)
        few = flat | ((bend == bend.max()) & (curves < 3) & (stray == stray.max()))
        return every.only(np.flatnonzero(few))

    def scan(self) -> Explanations:
        """Few kinds of lamp, with gains that are usual: for a look at very many films."""
        typical = self._typical()
        gains = (
            [self.light.gain] if self.light.gain is not None else [typical * _GAIN_STEP**step for step in range(-2, 3)]
        )
        level = _FREE_LEVEL if self.light.gain is None else _REFERENCED
        stray = _STRAYS[-1] * self.of.mean if self.light.stray else 0.0
        bend = self._bends()[-1]
        rows = [Nuisance(0, gain, level, bend, stray, 3.0, bend) for gain in gains]
        if self.light.gain is None and not self.light.bent:
            # Under a lamp that bends as it likes thin films are much alike; one that bends little tells them apart.
            rows += [Nuisance(0, gain, level, BENDS[0], stray, 3.0, BENDS[0]) for gain in gains]
            rows += [Nuisance(len(self.curves) - 1, gain, level, 0.0, stray, 3.0, _DRIFT) for gain in gains]
        if self.light.gain is not None and self.light.stray:
            rows.append(Nuisance(self.lamps[-1], self.light.gain, level, bend, stray, 3.0, _DRIFT))
        if self.per_light is not None and self.light.stray:
            return _even([row._replace(counted=kind) for row in rows for kind in (0.0, 1.0)])
        return _even(rows)

    def _typical(self) -> float:
        """The gain that data of this size have on a film of mean reflectance."""
        weight = 1.0 / self.of.sd**2
        return max(float(weight @ np.abs(self.of.measured) / weight.sum()) / max(self.of.mean, 1e-12), 1e-300)

    def _bends(self) -> tuple[float, ...]:
        return BENDS if self.light.gain is None else (_REFERENCED,)

    def _gains(self, spectrum: Floats) -> list[tuple[float, float]]:
        """Gains worth a look, with the logarithm of their prior: steps of 10^(1/4) near what the data want of this film."""
        if self.light.gain is not None:
            return [(self.light.gain, 0.0)]
        of = self.of
        weight = 1.0 / of.sd**2
        typical = self._typical()
        r = spectrum - weight @ spectrum / weight.sum()
        y = of.measured - weight @ of.measured / weight.sum()
        spread = float((weight * r) @ r)
        level = float(weight @ of.measured) / max(float(weight @ spectrum), 1e-300)
        wanted = [level] + ([float((weight * r) @ y) / spread] if spread > 0.0 else [])
        places = set()
        for gain in wanted:
            if gain > 0.0 and math.isfinite(gain):
                step = round(math.log(gain / typical) / math.log(_GAIN_STEP))
                places |= {step - 1, step, step + 1}
        places = {place for place in places if abs(place) <= 16} or {0}
        total = _GAIN_SD * math.sqrt(2.0 * math.pi) / math.log(_GAIN_STEP)
        return [
            (typical * _GAIN_STEP**place, -0.5 * (place * math.log(_GAIN_STEP) / _GAIN_SD) ** 2 - math.log(total))
            for place in sorted(places)
        ]

    def without_film(self, *bare: Floats) -> tuple[float, float]:
        """Tempered log evidence of no film and of something else, priors of all three apart.

        No film: a lamp, or one of the spectra ``bare``: of the base, of a film whose fringes are all washed out.
        """
        of = self.of
        ones = np.ones_like(of.measured)
        level = abs(float(of.measured.mean())) or 1e-300
        sizes = [level * _GAIN_STEP**step for step in (-2, -1, 0, 1, 2)]
        none: list[Nuisance] = []
        log_prior: list[float] = []
        # As responses of films: half of them even, some of these with a baseline that drifts; the others of any lamp's course.
        drifts = _DRIFTS if self.light.stray else 0.0
        kinds = [(0, 0.0, 0.5 * (1.0 - drifts))]
        kinds += [(len(self.curves) - 1, _DRIFT, 0.5 * drifts)] if drifts else []
        shapes = [(place, bend) for place in self.lamps for bend in self._bends()]
        kinds += [(place, bend, 0.5 / len(shapes)) for place, bend in shapes]
        for place, bend, share in kinds:
            for size in sizes:
                none += [Nuisance(place, size, _FREE_LEVEL, bend, 0.0, kappa) for kappa in KAPPAS]
                log_prior += [math.log(share / len(sizes) / len(KAPPAS))] * len(KAPPAS)
        lamp = self.log_evidences(ones, Explanations(np.array(none), np.array(log_prior)))
        found = [log_sum(lamp[0])]
        for one in bare:
            if float(np.max(one)) > 1e-6:
                found.append(log_sum(self.log_evidences(one, self.films(one))[0]))
        other = []
        for size in (level / _GAIN_STEP, level, level * _GAIN_STEP):
            for length in self.fine:
                place = len(LENGTHS_NM) + _OTHER_LENGTHS_NM.index(length)
                other += [
                    Nuisance(place, size, _FREE_LEVEL, bend, 0.0, kappa)
                    for bend in _OTHER_BENDS
                    for kappa in (1.0, 3.0)
                ]
        rest = log_sum(self.log_evidences(ones, _even(other))[0]) if other else -math.inf
        return log_sum(np.array(found)) - math.log(len(found)), rest


def only(row: Floats) -> Explanations:
    """One explanation alone."""
    return _even([Nuisance(*row)])


def _even(rows: Sequence[Nuisance]) -> Explanations:
    return Explanations(np.array(rows), np.full(len(rows), -math.log(len(rows))))


def prior_density(thickness_nm: Floats | float, low: float, high: float) -> Floats:
    """Prior probability a nm: flat in log(h + 50 nm)."""
    span = math.log((high + _PRIOR_NM) / (low + _PRIOR_NM))
    return np.asarray(1.0 / ((np.asarray(thickness_nm) + _PRIOR_NM) * span))
