"""Least squares for a thickness: gain and baseline by projection, the rest by Levenberg and Marquardt. Internal."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.inverse.model import Model

_ITERATIONS = 60
# A step that lowers the misfit by less than this share of it ends a search: of a thousand points 1e-4 of a variance. Exact data
# lower theirs by orders of size until they are met.
_SETTLED = 1e-7


@dataclass(frozen=True)
class Data:
    """A cleaned spectrum: ascending wavelengths, values, weights (1/sd up to a factor), and what is linear in its model."""

    wavelength_nm: Floats
    measured: Floats
    weight: Floats
    gain: float | None
    """Fixed gain; None where it is free."""
    bend: int
    """Degree of the free gain in wavelength: 0 even, 1 changing in proportion, 2 bent."""
    baseline: int
    """Number of baseline terms: 0 none, 1 a constant, 2 a straight line in wavelength, 3 a parabola."""

    @property
    def x(self) -> Floats:
        """The wavelengths scaled to -1..1."""
        low, high = self.wavelength_nm[0], self.wavelength_nm[-1]
        return np.asarray((2.0 * self.wavelength_nm - low - high) / (high - low))

    @property
    def terms(self) -> Floats:
        """The baseline's terms, (wavelengths, terms)."""
        x = self.x
        return (
            np.stack([x**power for power in range(self.baseline)], axis=1) if self.baseline else np.empty((x.size, 0))
        )

    @property
    def linear_count(self) -> int:
        """Number of linear parameters."""
        return self.baseline + (1 + self.bend if self.gain is None else 0)

    def thinned(self, step: int) -> Data:
        """Every so manieth point."""
        part = slice(None, None, step)
        return replace(
            self, wavelength_nm=self.wavelength_nm[part], measured=self.measured[part], weight=self.weight[part]
        )


@dataclass(frozen=True)
class Fitted:
    """A point of the parameter space with its best gain and baseline."""

    parameters: Floats
    gain: Floats
    """Polynomial in x: the gain in the middle of the spectrum first."""
    baseline: Floats
    curve: Floats
    misfit: float
    """Weighted sum of squares."""


class Solver:
    """A model against data."""

    def __init__(self, model: Model, data: Data, low: Floats, high: Floats) -> None:
        self.model, self.data = model, data
        self.low, self.high = low, high
        self.x = data.x
        self.terms = data.terms * data.weight[:, None]
        self.target = data.measured * data.weight

    def linear(self, spectrum: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Best gain and baseline of a spectrum; the basis they span, and the weighted residual."""
        weighted = spectrum * self.data.weight
        gain = np.zeros(3)
        if self.data.gain is None:
            for degree in range(self.data.bend, -1, -1):
                gains = [weighted * self.x**power for power in range(degree + 1)]
                basis = np.column_stack([*gains, self.terms])
                found = np.linalg.lstsq(basis, self.target, rcond=None)[0]
                gain[: degree + 1] = found[: degree + 1]
                if self._positive(gain):
                    baseline = np.asarray(found[degree + 1 :])
                    return gain, baseline, basis, np.asarray(self.target - basis @ found)
                # Fringes upside down are no solution, not even at one end: a simpler gain is left, or the baseline alone.
                gain = np.zeros(3)
        else:
            gain[0] = self.data.gain
        rest = self.target - gain[0] * weighted
        if not self.data.baseline:
            return gain, np.empty(0), self.terms, rest
        found = np.linalg.lstsq(self.terms, rest, rcond=None)[0]
        return gain, np.asarray(found), self.terms, np.asarray(rest - self.terms @ found)

    def _gain(self, gain: Floats) -> Floats:
        """The gain at every wavelength."""
        return np.asarray(gain[0] + gain[1] * self.x + gain[2] * self.x**2)

    def _positive(self, gain: Floats) -> bool:
        """Whether a gain is above a tenth of its middle everywhere: lamps change by less."""
        if gain[2] == 0.0:
            return bool(gain[0] > abs(gain[1]))
        return bool(gain[0] > 0.0 and self._gain(gain).min() > 0.1 * gain[0])

    def at(self, parameters: Floats) -> Fitted:
        """The best gain and baseline at fixed parameters."""
        spectrum = self.model.value(parameters)
        gain, baseline, _, residual = self.linear(spectrum)
        return self._fitted(parameters, spectrum, gain, baseline, residual)

    def _fitted(self, parameters: Floats, spectrum: Floats, gain: Floats, baseline: Floats, residual: Floats) -> Fitted:
        curve = self._gain(gain) * spectrum + self.data.terms @ baseline
        return Fitted(parameters.copy(), gain, baseline, curve, float(residual @ residual))

    def solve(self, start: Floats, free: list[int], iterations: int = _ITERATIONS) -> Fitted:
        """The least misfit near a start; only the parameters in ``free`` move, within their bounds.

        The derivative of the residual is projected on what gain and baseline cannot make up for (L. Kaufman, BIT 15, 49
        (1975)).
        """
        parameters = np.clip(np.asarray(start, dtype=float), self.low, self.high)
        sharp = len(parameters) - 1 not in free
        spectrum, slopes = self.model.both(parameters, sharp)
        gain, baseline, basis, residual = self.linear(spectrum)
        misfit = float(residual @ residual)
        damping = 1e-3
        for _ in range(iterations):
            columns = slopes[:, free] * (self._gain(gain) * self.data.weight)[:, None]
            columns = columns - _onto(basis, columns)
            normal, gradient = columns.T @ columns, columns.T @ residual
            scale = np.diag(normal).copy()
            if not np.any(scale > 0.0):
                break
            scale[scale <= 0.0] = 1.0
            improved = False
            for _ in range(12):
                step = np.linalg.lstsq(normal + damping * np.diag(scale), gradient, rcond=None)[0]
                trial = parameters.copy()
                trial[free] += step
                trial = np.clip(trial, self.low, self.high)
                moved = self.model.both(trial, sharp)
                linear = self.linear(moved[0])
                size = float(linear[3] @ linear[3])
                if size < misfit:
                    improved = True
                    break
                damping *= 4.0
                if np.abs(trial - parameters).max() < 1e-10:
                    break
            if not improved:
                break
            gone = (misfit - size) / max(misfit, 1e-300)
            moved_by = np.abs(trial - parameters)[free].max()
            parameters, (spectrum, slopes), misfit = trial, moved, size
            gain, baseline, basis, residual = linear
            damping = max(damping * 0.2, 1e-12)
            if gone < _SETTLED or moved_by < 1e-8:
                break
        return self._fitted(parameters, spectrum, gain, baseline, residual)

    def covariance(self, fitted: Fitted, free: list[int]) -> Floats:
        """Of the free parameters, for residuals of variance 1, gain and baseline being free as well."""
        spectrum, slopes = self.model.both(fitted.parameters, len(fitted.parameters) - 1 not in free)
        _, _, basis, _ = self.linear(spectrum)
        columns = slopes[:, free] * (self._gain(fitted.gain) * self.data.weight)[:, None]
        columns = columns - _onto(basis, columns)
        return np.asarray(np.linalg.pinv(columns.T @ columns, hermitian=True))

    def moved(self, fitted: Fitted, free: list[int], change: Floats) -> Floats:
        """How far the free parameters move where the spectrum is another by ``change``, gain and baseline moving too."""
        spectrum, slopes = self.model.both(fitted.parameters, len(fitted.parameters) - 1 not in free)
        _, _, basis, _ = self.linear(spectrum)
        gain = self._gain(fitted.gain) * self.data.weight
        columns = np.column_stack([slopes[:, free], change]) * gain[:, None]
        columns = columns - _onto(basis, columns)
        return np.asarray(-np.linalg.lstsq(columns[:, :-1], columns[:, -1], rcond=None)[0])

    def interval(self, fitted: Fitted, free: list[int], which: int, sd: float, rise: float) -> tuple[float, float]:
        """Where the misfit, all else fitted again, has risen by ``rise``: as far as the bounds on each side."""
        others = [place for place in free if place != which]

        def profile(value: float) -> float:
            start = fitted.parameters.copy()
            start[which] = value
            found = self.solve(start, others) if others else self.at(start)
            return found.misfit - fitted.misfit

        middle = float(fitted.parameters[which])
        ends = [_crossing(profile, middle, side * sd, rise, self.low[which], self.high[which]) for side in (-1.0, 1.0)]
        return min(ends), max(ends)


def _onto(basis: Floats, columns: Floats) -> Floats:
    if basis.shape[1] == 0:
        return np.zeros_like(columns)
    q, _ = np.linalg.qr(basis)
    return np.asarray(q @ (q.T @ columns))


def _crossing(
    profile: Callable[[float], float], middle: float, step: float, rise: float, low: float, high: float
) -> float:
    """How far from the middle, on the side of ``step`` (a first guess), the profile reaches ``rise``."""
    if not (math.isfinite(step) and step != 0.0):
        step = math.copysign(0.01 * (high - low), step)
    end = low if step < 0.0 else high
    reach = abs(end - middle)
    inside, outside = 0.0, None
    x = min(abs(step), reach)
    for _ in range(40):
        risen = profile(middle + math.copysign(x, step))
        # Close to a parabola the first guess is right: no need to look further.
        if abs(risen / rise - 1.0) < 0.02:
            return middle + math.copysign(x, step)
        if risen < rise:
            inside = x
            if x >= reach:
                return end
            guess = x * math.sqrt(rise / risen) if risen > 0.04 * rise else 4.0 * x
            guess = max(1.05 * x, min(guess, 4.0 * x))
            x = min(guess, reach) if outside is None else 0.5 * (inside + outside)
        else:
            outside = x
            guess = x * math.sqrt(rise / risen)
            x = guess if guess > inside else 0.5 * (inside + outside)
        if outside is not None and outside - inside < 1e-3 * outside:
            break
    return middle + math.copysign(x, step)


def student(probability: float, freedom: float) -> float:
    """Two-sided quantile of Student's t (Abramowitz & Stegun 26.7.5, after the normal quantile by Newton's method)."""
    z = 2.0
    for _ in range(60):
        error = math.erf(z / math.sqrt(2.0)) - probability
        z -= error / (math.sqrt(2.0 / math.pi) * math.exp(-0.5 * z * z))
    g1 = (z**3 + z) / 4.0
    g2 = (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    g3 = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
    g4 = (79.0 * z**9 + 776.0 * z**7 + 1482.0 * z**5 - 1920.0 * z**3 - 945.0 * z) / 92160.0
    v = max(freedom, 3.0)
    return z + g1 / v + g2 / v**2 + g3 / v**3 + g4 / v**4
