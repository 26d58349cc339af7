"""Blocks of a joint fit: how likely each measurement is for given spectra. Internal."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.inverse.data import scatter
from iridesce.inverse.full import Full
from iridesce.inverse.measurement import Measurement
from iridesce.inverse.members import Member
from iridesce.inverse.posterior import KAPPAS, Engine, Explanations, Measured, Nuisance, log_sum, temper
from iridesce.stack import Stack

# Psi and delta of instruments, degrees: below this it is rounding.
_FINEST_DEG = 1e-3
# The noise is at least this share of the largest value: below, it is the rounding of the models.
_ROUNDING = 2e-6


class Block(Protocol):
    """One measurement against spectra of films."""

    of: Measurement
    nm: Floats
    values: Floats
    kappa: float
    channels: int
    """Of a spectrum: those that were measured, then those that are full."""

    def spectra(self, stack: Stack, angle_offset_deg: float) -> Floats:
        """What the stack shows, (thicknesses, channels); its thicknesses have a last axis of 1."""

    def scan(self, spectra: Floats) -> Floats:
        """Tempered log evidence of many films, roughly."""

    def fix(self, spectrum: Floats) -> None:
        """Choose the explanations that `logs` sums over by those that matter for this film."""

    def logs(self, spectra: Floats) -> Floats:
        """Tempered log evidence of films near the one that was fixed."""

    def log_full(self, spectrum: Floats) -> float:
        """Tempered logarithm of the probability that the film that was fixed fills the channels that are full."""

    def learn(self, spectrum: Floats) -> None:
        """Noise and correlation of what this film leaves."""

    def without_film(self, bare: Floats) -> tuple[float, float]:
        """Tempered log evidence of no film, and of something else."""

    def told(self, spectrum: Floats) -> tuple[Floats, Floats, Floats]:
        """Fitted values, gain and stray light."""


def _spread(block: Block, residual: Floats) -> float:
    return scatter(residual) if residual.size > 6 else float(np.std(residual))


class PowerBlock:
    """A reflectance or a transmittance, with gain, lamp and stray light of its own."""

    def __init__(self, member: Member, mean: float) -> None:
        self.of, self.light, self.reference = member.of, member.light, member.reference
        self.nm, self.values, self.sd = member.wavelength_nm, member.values, member.sd
        self.full = None if member.full is None else Full(*member.full)
        self.seen_nm = member.every_nm
        self.channels = self.seen_nm.size
        self.mean, self.kappa = max(mean, 1e-6), 1.0
        self.stated = self.sd is not None
        self._make(self.sd if self.sd is not None else np.full(self.nm.size, _spread(self, self.values)), 1.0)

    def _make(self, sd: Floats, tempered: float) -> None:
        floor = _ROUNDING * float(np.abs(self.values).max(initial=1e-300))
        sd = np.maximum(sd, max(floor, 1e-300))
        self.engine = Engine(Measured(self.nm, self.values, sd, self.mean, self.reference), self.light)
        self.engine.tempered = tempered
        self.used: Explanations | None = None

    def spectra(self, stack: Stack, angle_offset_deg: float) -> Floats:
        angle = min(abs(self.of.angle_deg + angle_offset_deg), 89.9)
        found = getattr(stack, self.of.quantity)(self.seen_nm, angle, self.of.polarization)
        return np.ascontiguousarray(np.atleast_2d(found))

    def _measured(self, spectra: Floats) -> Floats:
        """At the channels that were measured."""
        return np.ascontiguousarray(spectra[..., : self.nm.size])

    def scan(self, spectra: Floats) -> Floats:
        return np.array(
            [log_sum(row) for row in self.engine.log_evidences(self._measured(spectra), self.engine.scan())]
        )

    def fix(self, spectrum: Floats) -> None:
        spectrum = self._measured(spectrum)
        explanations = self.engine.films(spectrum)
        logs = self.engine.log_evidences(spectrum, explanations)[0]
        self.used = explanations.only(np.flatnonzero(logs > logs.max() - 14.0))
        self.row = explanations.rows[int(logs.argmax())]
        self.kappa = float(Nuisance(*self.row).kappa)

    def logs(self, spectra: Floats) -> Floats:
        assert self.used is not None
        return np.array([log_sum(row) for row in self.engine.log_evidences(self._measured(spectra), self.used)])

    def log_full(self, spectrum: Floats) -> float:
        if self.full is None:
            return 0.0
        return self.full.log_probability(self.engine, self._measured(spectrum), spectrum[self.nm.size :], self.row)

    def learn(self, spectrum: Floats) -> None:
        self.fix(spectrum)
        left = self.values - self.told(spectrum)[0]
        sd = self.engine.of.sd if self.stated else np.full(self.nm.size, _spread(self, left))
        self._make(sd, temper(left / sd))
        self.fix(spectrum)

    def without_film(self, bare: Floats) -> tuple[float, float]:
        return self.engine.without_film(self._measured(bare))

    def told(self, spectrum: Floats) -> tuple[Floats, Floats, Floats]:
        spectrum = self._measured(spectrum)
        response, stray = self.engine.explain(spectrum, self.row)
        return response * spectrum + stray, response, stray


class AngleBlock:
    """Psi or delta: nothing linear, a difference of angles taken as the chord, so that 359 and 1 degrees are near."""

    def __init__(self, member: Member) -> None:
        self.of = member.of
        self.nm, self.values, self.sd = member.wavelength_nm, member.values, member.sd
        self.channels = self.nm.size
        self.stated, self.tempered, self.kappa = self.sd is not None, 1.0, 1.0
        if self.sd is None:
            unwrapped = np.degrees(np.unwrap(np.radians(self.values)))
            self.sd = np.full(self.nm.size, max(_spread(self, unwrapped), _FINEST_DEG))

    def spectra(self, stack: Stack, angle_offset_deg: float) -> Floats:
        angle = min(max(self.of.angle_deg + angle_offset_deg, 1e-3), 89.9)
        return np.atleast_2d(stack.ellipsometry(self.nm, angle)[0 if self.of.quantity == "psi" else 1])

    def _left(self, spectra: Floats) -> Floats:
        return np.asarray(np.degrees(2.0 * np.sin(0.5 * np.radians(self.values - spectra))))

    def scan(self, spectra: Floats) -> Floats:
        return self.logs(spectra)

    def fix(self, spectrum: Floats) -> None:
        by_kappa = self._by_kappa(np.atleast_2d(spectrum))[0]
        self.kappa = KAPPAS[int(by_kappa.argmax())]

    def _by_kappa(self, spectra: Floats) -> Floats:
        assert self.sd is not None
        square = ((self._left(spectra) / self.sd) ** 2).sum(axis=1)
        log_sd = float(np.log(self.sd).sum()) + 0.5 * self.nm.size * math.log(2.0 * math.pi)
        kappas = np.array(KAPPAS)
        logs = -0.5 * square[:, None] / kappas**2 - self.nm.size * np.log(kappas) - log_sd
        return np.asarray(logs / self.tempered - math.log(len(KAPPAS)))

    def logs(self, spectra: Floats) -> Floats:
        return np.array([log_sum(row) for row in self._by_kappa(spectra)])

    def log_full(self, spectrum: Floats) -> float:
        # Of angles there are none (`members`).
        return 0.0

    def learn(self, spectrum: Floats) -> None:
        left = self._left(spectrum)
        if not self.stated:
            self.sd = np.full(self.nm.size, max(_spread(self, left), _FINEST_DEG))
        assert self.sd is not None
        self.tempered = temper(left / self.sd)
        self.fix(spectrum)

    def without_film(self, bare: Floats) -> tuple[float, float]:
        # Something else: any angle.
        anything = -self.nm.size * math.log(90.0 if self.of.quantity == "psi" else 360.0)
        return float(self.logs(bare[None, :])[0]), anything / self.tempered

    def told(self, spectrum: Floats) -> tuple[Floats, Floats, Floats]:
        return spectrum, np.ones_like(spectrum), np.zeros_like(spectrum)
