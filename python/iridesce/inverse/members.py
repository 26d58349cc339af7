"""A measurement of a joint fit, ready to be asked: in order, counts divided by their reference, full channels apart. Internal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint
from iridesce.inverse.data import cleaned, referenced
from iridesce.inverse.full import parted
from iridesce.inverse.measurement import FEWEST, Measurement
from iridesce.inverse.posterior import Light

# Squares of numbers beyond run over, or under.
_LEAST_SIZE = 1e-60


@dataclass(frozen=True)
class Member:
    """One measurement as it is used."""

    of: Measurement
    wavelength_nm: Floats
    values: Floats
    sd: Floats | None
    light: Light
    """What is known of gain, lamp and stray light; of psi and delta without a meaning."""
    full: tuple[Floats, Floats] | None = None
    """Wavelengths of the channels that are full, and what they hold at least."""
    reference: Floats | None = None
    """Light of the reference, at each channel."""

    @property
    def every_nm(self) -> Floats:
        """Wavelengths of the channels that were measured, then of those that are full."""
        return self.wavelength_nm if self.full is None else np.concatenate([self.wavelength_nm, self.full[0]])


def members(measurements: Sequence[Measurement], notes: list[str]) -> list[Member]:
    """All of them; what was dropped of which is told in the notes."""
    found = []
    for one in measurements:
        own: list[str] = []
        found.append(_angle(one) if one.of_polarization else _power(one, own))
        notes.extend(f"{one.label}: {note}" for note in own)
    return found


def _angle(one: Measurement) -> Member:
    """Psi or delta, which no channel can be full of.

    They are ratios of intensities at several settings of the polarizers: a detector that is full makes them wrong, by an amount
    that goes along the spectrum as the ratio does, and never equal to a largest number. That they have one (psi 90 degrees;
    delta 360, the same as 0) is the geometry of the angle, and a value there is as good as any other.
    """
    nm, values, sd = one.cleaned()
    return Member(one, nm, values, sd, Light(None, True, False, False))


def _power(one: Measurement, notes: list[str]) -> Member:
    """A reflectance or a transmittance, from its counts where a reference is given."""
    gain = None if one.gain is None or isinstance(one.gain, str) else float(one.gain)
    light = Light(gain, True, isinstance(one.gain, str), one.baseline != "none")
    nm, values, noise, filled, lit = one.wavelength_nm, one.values, one.noise, None, None
    if one.reference is not None:
        nm, values, noise, filled, lit = referenced(
            one, nm, values, one.dark, one.reference, one.reference_stack, noise, notes
        )
        if one.gain is None:
            light = Light(1.0, False, False, light.stray)
    part = parted(*cleaned(nm, values, noise, notes), filled, notes)
    size = float(np.abs(part.values).max(initial=0.0))
    if not (_LEAST_SIZE < size < 1.0 / _LEAST_SIZE or size == 0.0):
        raise complaint(
            f"values of {one.label} reach {size:.3g}, whose squares no number holds; give them in another unit",
            "values",
            f"of a size of {_LEAST_SIZE:g} to {1.0 / _LEAST_SIZE:g}",
            Words(f"{size:.3g}"),
            f"of {one.label}",
        )
    if np.ptp(part.values) <= 1e-12 * size:
        notes.append("it does not vary with wavelength: it shows no film")
    if part.values.size < FEWEST:
        raise complaint(
            "; ".join([f"{one.label} has {part.values.size} usable points, at least {FEWEST} are needed", *notes]),
            "values",
            f"{FEWEST} usable points or more",
            Words(part.values.size),
            f"of {one.label}",
        )
    reference = None if lit is None else np.interp(part.wavelength_nm, *lit)
    return Member(one, part.wavelength_nm, part.values, part.sd, light, part.full, reference)
