"""Channels of a spectrum that are full: what they hold is a limit, not a value. Internal.

A detector or a converter that is full writes its largest number, whatever more light there is. Taken for values such a plateau is
a lamp that bends just so, and a film is found that goes with it. What it does say is that there is at least so much light
(J. Tobin, Econometrica 26, 24 (1958)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats
from iridesce.inverse.posterior import Engine, Measured, Nuisance, log_twice_normal

Mask = npt.NDArray[np.bool_]

# So many neighbours of the very same largest value are no chance.
_FEWEST_ALIKE = 3
# Fewer different values than this are of a rounding so coarse that runs of them say nothing.
_FEWEST_LEVELS = 12
# Values are the same within this share of the largest: rows that were scaled or interpolated.
_SAME = 1e-9
# Full channels stand among the others with this many times the range of all: they say nothing by themselves.
_MUTE = 1e3


def full(values: Floats) -> Mask:
    """Which channels are full: at the largest value, in runs that chance and rounding do not make.

    Rounded numbers (percent without decimals) have runs of equal values at every height; full ones have longer runs at the
    largest value than anywhere else in the upper half.
    """
    none = np.zeros(values.size, dtype=bool)
    if values.size == 0 or not np.isfinite(values).all() or np.unique(values).size < _FEWEST_LEVELS:
        return none
    low, high = float(values.min()), float(values.max())
    top = values >= high - _SAME * abs(high)
    if top.all():
        return none
    starts = np.flatnonzero(np.r_[True, np.abs(np.diff(values)) > _SAME * abs(high)])
    lengths, heights = np.diff(np.r_[starts, values.size]), values[starts]
    at_top = top[starts]
    longest = int(lengths[at_top].max(initial=0))
    elsewhere = int(lengths[~at_top & (heights > 0.5 * (low + high))].max(initial=1))
    return top if longest >= max(_FEWEST_ALIKE, 2 * elsewhere + 1) else none


# A series goes without the channels that are full in some spectrum while it keeps this share of its channels.
_ENOUGH = 0.4


def full_in_some(spectra: Floats, notes: list[str]) -> Mask:
    """Which channels of a series are full in one of its spectra or more, where enough others are left to go without them."""
    found = np.array([full(row) for row in spectra])
    over = np.zeros(spectra.shape[1], dtype=bool)
    if not found.any():
        return over
    # The detector is one: where another spectrum holds one or two channels of that value they are full, too.
    level = float(spectra[found].max()) * (1.0 - _SAME)
    over |= found.any(axis=0) | (spectra >= level).any(axis=0)
    if over.mean() > 1.0 - _ENOUGH:
        notes.append(
            f"{int(over.sum())} of {over.size} channels are full, at the largest value, in some spectrum, too many to go "
            "without: what is found there is doubtful; expose less"
        )
        return np.zeros(over.size, dtype=bool)
    notes.append(f"{int(over.sum())} of {over.size} channels dropped: full, at the largest value, in some spectrum")
    return over


# So many equal values in a row, and so many times as many as rounding makes elsewhere, were not measured.
_FEWEST_STUCK, _LONGER = 5, 3
# Runs that may be longer than those of rounding: ends and gaps that were filled.
_FILLED_RUNS = 4


def stuck(values: Floats) -> Mask:
    """Which values were not measured: long runs of one number below the largest, as zeros where an instrument has no data."""
    if values.size == 0 or np.unique(values).size < _FEWEST_LEVELS:
        return np.zeros(values.size, dtype=bool)
    starts = np.flatnonzero(np.r_[True, values[1:] != values[:-1]])
    lengths = np.diff(np.r_[starts, values.size])
    rounding = int(np.sort(lengths)[::-1][_FILLED_RUNS]) if lengths.size > _FILLED_RUNS else values.size
    of_run = (lengths >= max(_FEWEST_STUCK, _LONGER * rounding + 1)) & (values[starts] < values.max())
    return np.repeat(of_run, lengths)


# A run of full channels whose neighbours lie below it by more than this many times the middle half of the others stands alone.
_CLIFF = 1.5


def alone(values: Floats, over: Mask) -> Mask:
    """Which of the full channels are no light: runs that no neighbour leads up to, as software writes that divides by nothing."""
    out = np.zeros(values.size, dtype=bool)
    cliff = _CLIFF * float(np.subtract(*np.percentile(values[~over], [75.0, 25.0])))
    if not cliff > 0.0:
        return out
    places = np.flatnonzero(over)
    for run in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1):
        beside = [at for at in (run[0] - 1, run[-1] + 1) if 0 <= at < values.size]
        out[run] = all(values[run[0]] - values[at] > cliff for at in beside)
    return out


@dataclass(frozen=True)
class Parted:
    """A spectrum without the channels that hold no value."""

    wavelength_nm: Floats
    values: Floats
    sd: Floats | None
    full: tuple[Floats, Floats] | None
    """Wavelengths of the channels that are full, and what they hold at least."""


def parted(nm: Floats, values: Floats, sd: Floats | None, filled: Floats | None, notes: list[str]) -> Parted:
    """Channels that were measured and channels that are full; what stands still or alone at the top is dropped, and told.

    filled     wavelengths of full channels where they are known from the counts; None: looked for in the values
    """
    if filled is None and (still := stuck(values)).any():
        notes.append(f"{int(still.sum())} of {nm.size} points dropped: one number in a long row is no measurement")
        nm, values, sd = nm[~still], values[~still], None if sd is None else sd[~still]
    over = full(values) if filled is None else np.isin(nm, filled)
    if filled is None and over.any() and not over.all() and (single := alone(values, over)).any():
        notes.append(
            f"{int(single.sum())} of {nm.size} points dropped: at the largest value, and nothing leads up to it"
        )
        nm, values, over, sd = nm[~single], values[~single], over[~single], None if sd is None else sd[~single]
    if not over.any() or over.all():
        return Parted(nm, values, sd, None)
    notes.append(
        f"{int(over.sum())} of {nm.size} channels are full, at the largest value: they are taken to hold at least that"
    )
    return Parted(nm[~over], values[~over], None if sd is None else sd[~over], (nm[over], values[over]))


@dataclass(frozen=True)
class Full:
    """Full channels beside those that were measured."""

    wavelength_nm: Floats
    level: Floats
    """What they hold at least."""

    def log_probability(self, engine: Engine, spectrum: Floats, beyond: Floats, row: Floats) -> float:
        """Logarithm of the probability that a film and one explanation fill these channels, tempered as the evidence is.

        spectrum   of the film, at the channels that were measured
        beyond     of the film, at the full ones
        """
        of, of_row = engine.of, Nuisance(*row)
        nm = np.concatenate([of.wavelength_nm, self.wavelength_nm])
        order = np.argsort(nm, kind="stable")
        own = order >= of.wavelength_nm.size
        film = np.concatenate([spectrum, beyond])[order]
        values = np.concatenate([of.measured, self.level])[order]
        mute = _MUTE * max(float(np.ptp(values)), float(of.sd.max()))
        sd = np.concatenate([of.sd, np.full(self.level.size, mute)])[order]
        # The response of the channels that were measured, carried on to the others.
        light = None if of.light is None else np.interp(nm[order], of.wavelength_nm, of.light)
        wide = Engine(Measured(nm[order], values, sd, of.mean, light), engine.light)
        response, stray = wide.explain(film, row)
        lack = np.maximum(values - response * film - stray, 0.0)
        noise = float(of_row.kappa) * float(np.median(of.sd))
        total = 0.0
        for run in np.split(np.flatnonzero(own), np.flatnonzero(np.diff(np.flatnonzero(own)) > 1) + 1):
            # A response that bends is known there as well as it bends; along a run that error is one.
            unknown = float(of_row.bend) * float(np.abs(response[run] * film[run]).mean())
            total += log_twice_normal(-float(lack[run].mean()) / math.hypot(noise / math.sqrt(run.size), unknown))
        return total / engine.tempered
