"""Channels that are full: limits in a fit of one spectrum, and which they are."""

from __future__ import annotations

import numpy as np
import pytest
from fit_spectra import NM, Floats, bumps, clean, noisy

import iridesce as ir
from iridesce.inverse.full import Full, full
from iridesce.inverse.posterior import Engine, Light, Measured, Nuisance


@pytest.mark.parametrize("count", [4, 40])
def test_a_plateau_that_nothing_leads_up_to_is_no_full_channel(count: int) -> None:
    # What software writes where it divides by nothing.
    values = noisy(clean("air / soap ? / air", 612.0))
    values[-count:] = 9.3
    found = ir.fit_thickness(NM, values, stack="air / soap ? / air")
    assert (found.verdict, found.best.thickness_nm) == ("clear", pytest.approx(612.0, rel=2e-3))
    assert any(f"{count} of {NM.size} points dropped: at the largest value" in note for note in found.notes)


@pytest.mark.parametrize(
    ("text", "thickness_nm", "share"),
    [("air / soap ? / air", 750.0, 0.9), ("air / SiO2 ? / Si", 919.4, 0.9), ("air / SiO2 ? / Si", 270.0, 0.7)],
)
def test_full_channels_are_limits_and_no_values(text: str, thickness_nm: float, share: float) -> None:
    """Taken for values they are a lamp that bends, and films of other orders went with it, sure of themselves."""
    values = noisy(clean(text, thickness_nm), 35.0)
    values = np.minimum(values, values.min() + share * np.ptp(values))
    result = ir.fit_thickness(NM, 900.0 * values, text)
    assert result.verdict == "clear" and result.best.gain_slope == 0.0
    assert result.best.thickness_nm == pytest.approx(thickness_nm, rel=0.004)
    assert any("channels are full" in note for note in result.notes)
    assert result.measured.size < NM.size


def test_full_counts_beside_a_reference() -> None:
    """Full counts of the film are limits; of a full reference nothing is known."""
    random = np.random.default_rng(2)
    light = 4e4 * bumps(4)
    base = np.asarray(ir.Stack(["air", "Si"]).reflectance(NM))
    seen, mirror = (
        light * one + 300.0 + 20.0 * random.standard_normal(NM.size)
        for one in (clean("air / SiO2 ? / Si", 640.0), base)
    )
    for of, words in (((seen, 0.8), "channels are full"), ((mirror, 0.8), "the reference is full")):
        limit = of[1] * of[0].max()
        result = ir.fit_thickness(
            NM,
            np.minimum(seen, limit) if of[0] is seen else seen,
            "air / SiO2 ? / Si",
            dark=300.0 + 0.0 * NM,
            reference=np.minimum(mirror, limit) if of[0] is mirror else mirror,
            reference_stack="air / Si",
        )
        assert result.verdict == "clear" and result.best.thickness_nm == pytest.approx(640.0, rel=0.004)
        assert any(words in note for note in result.notes), result.notes


def test_plateaus_of_rounding_are_not_full_channels() -> None:
    values = clean("air / soap ? / air", 800.0)
    assert not full(values).any() and not full(np.round(values, 2)).any() and not full(np.ones(50)).any()
    clipped = np.minimum(values, 0.9 * values.max())
    assert np.array_equal(full(clipped), clipped == clipped.max())
    assert np.array_equal(full(0.3 * clipped), full(clipped))
    # Rounded to a hundredth of the range and cut well below its top: longer there than any other run.
    coarse = np.round(np.minimum(values, 0.5 * values.max()), 3)
    assert np.array_equal(full(coarse), coarse == coarse.max())


def test_a_film_must_fill_the_channels_that_are_full() -> None:
    values = noisy(clean("air / soap ? / air", 750.0), 40.0)
    over = values > 0.8 * values.max()
    engine = Engine(
        Measured(NM[~over], values[~over], np.full((~over).sum(), 3e-4), 0.05), Light(None, True, False, False)
    )
    held = Full(NM[over], np.full(int(over.sum()), 0.8 * values.max()))
    even = np.array(Nuisance(curves=0, gain=1.0, level=0.3, bend=0.0, stray=0.0, kappa=1.0))

    def filled(thickness_nm: float, row: Floats) -> float:
        spectrum = clean("air / soap ? / air", thickness_nm)
        return held.log_probability(engine, spectrum[~over], spectrum[over], row)

    assert filled(750.0, even) > -1.0 and filled(640.0, even) < -100.0
    # A lamp that may bend makes up for what an even one does not.
    bent = np.array(Nuisance(*even)._replace(bend=0.3))
    assert filled(640.0, bent) > -20.0
