"""What real spectra have and models have not is put right by `ir.fit_thickness`, or doubted. Scores: bench/fit_trials.py."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fit_spectra import EXACT, NM, clean, noisy

import iridesce as ir
from iridesce.inverse.data import explained, within_light
from iridesce.inverse.full import full, stuck
from iridesce.inverse.model import read_problem
from iridesce.inverse.posterior import Light
from iridesce.inverse.verdict import Asked, verdict_of


def test_spikes_gaps_and_disorder_are_put_right_and_told() -> None:
    text = "air / SiO2 ? / Si"
    values = noisy(clean(text, 900.0))
    nm, values = NM.copy(), values.copy()
    values[[30, 170]] += 5.0
    values[200:204] = np.nan
    shuffled = np.random.default_rng(1).permutation(nm.size)
    nm, values = np.r_[nm[shuffled], nm[10]], np.r_[values[shuffled], values[10]]
    before = nm.copy(), values.copy()
    result = ir.fit_thickness(nm, values, text)
    assert result.best.thickness_nm == pytest.approx(900.0, abs=0.5)
    words = " ".join(result.notes)
    assert "4 of 341 points dropped" in words and "spikes" in words and "sorted" in words and "repeated" in words
    np.testing.assert_array_equal(nm, before[0])
    np.testing.assert_array_equal(values, before[1])


def test_noisy_ends_count_less() -> None:
    random = np.random.default_rng(5)
    values = clean("air / SiO2 ? / Si", 700.0)
    sd = np.std(values) * 0.01 * (1.0 + 60.0 * np.abs(np.linspace(-1.0, 1.0, NM.size)) ** 8)
    result = ir.fit_thickness(NM, values + sd * random.standard_normal(NM.size), "air / SiO2 ? / Si")
    assert result.best.thickness_nm == pytest.approx(700.0, abs=0.5)
    assert result.weight[[0, -1]].max() < 0.2 * result.weight.max()
    assert any("uneven" in note for note in result.notes)


@pytest.mark.parametrize("count", [2, 8, 25, 60])
@pytest.mark.parametrize("size", [0.2, 1.0, 30.0])
@pytest.mark.parametrize("where", ["start", "end", "both"])
def test_ends_without_light_hide_no_film(where: str, size: float, count: int) -> None:
    # A lamp that is dark there: ratios of noise to noise, up to thirty times the film's own range.
    random = np.random.default_rng(count)
    values = noisy(clean("air / soap ? / air", 1287.0))
    dark = np.zeros(NM.size, dtype=bool)
    dark[:count] = where in ("start", "both")
    dark[NM.size - count :] = where in ("end", "both")
    values = values + dark * size * np.ptp(values) * random.standard_normal(NM.size)
    found = ir.fit_thickness(NM, values, stack="air / soap ? / air")
    assert found.best.thickness_nm == pytest.approx(1287.0, rel=3e-3)
    assert found.verdict == "clear"


@pytest.mark.parametrize("text", ["air / soap ? / air", "air / SiO2 ? / Si"])
@pytest.mark.parametrize("where", [slice(40), slice(-40, None), slice(150, 175)])
@pytest.mark.parametrize("filled", ["zero", "the value before"])
def test_rows_of_one_number_are_no_measurement(text: str, where: slice, filled: str) -> None:
    # What instruments and scripts write where they have no data.
    values = noisy(clean(text, 612.0))
    values[where] = 0.0 if filled == "zero" else values[where][0]
    found = ir.fit_thickness(NM, values, stack=text)
    assert (found.verdict, found.best.thickness_nm) == ("clear", pytest.approx(612.0, rel=2e-3))
    assert any("one number in a long row" in note for note in found.notes)


def test_rounded_values_are_rows_of_no_filling() -> None:
    # Per cent without decimals, 0 to 17, and so coarse that three levels are left: what rounding makes is no reason to drop.
    rounded = np.round(100.0 * noisy(clean("air / soap ? / air", 612.0)))
    for values in (rounded, np.round(rounded / 6.0)):
        assert not stuck(values).any() and not full(values).any()
    found = ir.fit_thickness(NM, rounded, stack="air / soap ? / air")
    assert found.best.thickness_nm == pytest.approx(612.0, rel=5e-3)


def test_sharp_lines_are_no_ends_without_light() -> None:
    # A cavity between silver mirrors: its lines are wild all along, and all of them are kept.
    cavity = np.asarray(
        ir.Stack.parse("air / Ag 40 / SiO2 9000 / Ag 40 / N-BK7").transmittance(np.arange(420.0, 760.0, 2.0))
    )
    assert within_light(cavity, []).all()
    spiked = noisy(clean("air / soap ? / air", 612.0))
    spiked[4] += 1.0
    assert within_light(spiked, []).all()


def test_wavelengths_that_a_medium_does_not_know_are_dropped_and_told() -> None:
    nm = np.arange(380.0, 1100.0, 1.0)
    known = (nm >= 436.8) & (nm <= 1052.0)
    values = np.full(nm.size, 0.2)
    values[known] = noisy(clean("air / PMMA ? / Si", 1500.0, nm=nm[known]))
    result = ir.fit_thickness(nm, values, "air / PMMA ? / Si")
    assert result.best.thickness_nm == pytest.approx(1500.0, abs=0.5)
    assert any('"PMMA" has no data there' in note for note in result.notes)
    with pytest.raises(ValueError, match=r'"PMMA" has data for 436\.8-1052 nm'):
        ir.fit_thickness(nm + 2000.0, values, "air / PMMA ? / air")


def test_another_stack_is_doubted() -> None:
    """Fringes of a film on silicon cannot be those of a soap film with a known gain."""
    result = ir.fit_thickness(NM, clean("air / SiO2 ? / Si", 900.0), "air / soap ? / air", gain=1.0, baseline="none")
    assert result.best.chi2 > 10.0
    assert any("doubt the stack" in note or "another stack" in note for note in result.notes)


@pytest.mark.parametrize("slope", [0.0, 1e-4])
def test_no_fringes_are_no_film(slope: float) -> None:
    flat = 0.04 + slope * (NM - 400.0) + 1e-4 * np.random.default_rng(2).standard_normal(NM.size)
    result = ir.fit_thickness(NM, flat, "air / soap ? / air")
    assert result.verdict == "none" and result.no_film > 0.5
    assert sum(one.weight for one in result) < 0.5
    assert any("gain=1.0" in note for note in result.notes)


def test_what_does_not_vary_is_no_film() -> None:
    result = ir.fit_thickness(NM, np.full(NM.size, 0.3), "air / soap ? / air")
    assert (result.verdict, result.best, len(result), result.no_film) == ("none", None, 0, 1.0)
    assert "none" in str(result) and result.to_dict()["solutions"] == []


@pytest.mark.parametrize(
    ("text", "thickness_nm", "seed"), [("air / soap ? / air", 457.8, 1), ("air / SiO2 ? / Si", 507.6, 3)]
)
def test_noise_that_an_instrument_has_smoothed(text: str, thickness_nm: float, seed: int) -> None:
    """A boxcar of nine pixels: neighbours differ by a quarter of the noise, and films ten times as thick went with the rest."""
    nm = np.arange(420.0, 780.0, 0.7)
    values = noisy(np.pad(clean(text, thickness_nm, nm=nm), 4, mode="edge"), 26.0, seed)
    values = np.convolve(values, np.full(9, 1.0 / 9.0), mode="valid")
    result = ir.fit_thickness(nm, values, text, **EXACT)
    best = result.best
    assert best.thickness_nm == pytest.approx(thickness_nm, rel=0.004) and best.kappa == 1.0
    assert abs(best.thickness_nm - thickness_nm) < 3.0 * best.sd_nm
    assert result.noise == pytest.approx(0.05 / 3.0 * np.std(clean(text, thickness_nm, nm=nm)), rel=0.35)


def test_what_is_left_is_short_or_smooth() -> None:
    nm = np.arange(420.0, 780.0, 0.7)
    noise = np.random.default_rng(1).standard_normal(nm.size + 8)
    smoothed = np.convolve(noise, np.full(9, 1.0 / 3.0), mode="valid")
    assert explained(noise[4:-4], nm) == (True, None)
    found, shared = explained(smoothed, nm)
    assert found and shared is not None and 0.8 < shared[0] < 1.2 and 4.0 < shared[1] < 14.0
    for left in (2.0 * np.sin(nm / 30.0), 3.0 * np.sin(nm / 6.0), 3.0 * np.exp(-(((nm - 600.0) / 25.0) ** 2))):
        assert explained(0.3 * noise[4:-4] + left, nm) == (False, None)


def test_a_film_in_a_corner_of_the_spectrum_is_doubted() -> None:
    nm = np.arange(400.0, 700.0, 1.0)
    values = clean("air / SiO2 ? / Si", 900.0, nm=nm)
    result = ir.fit_thickness(nm, noisy(values), "air / SiO2 ? / Si", **EXACT)
    assert result.verdict == "clear" and result.best.lit == 1.0
    corner = replace(result.best, lit=0.3)
    problem = read_problem("air / SiO2 ? / Si", None, None, "reflectance", 0.0, "unpolarized")
    asked = Asked(problem, nm, Light(None, True, False, True), True)
    assert verdict_of(asked, (result.best,), (0.0, 0.0), False) == "clear"
    assert verdict_of(asked, (corner,), (0.0, 0.0), False) == "doubtful"


def test_a_spectrum_of_noise_alone_is_never_clear() -> None:
    """Percent of the dark end of a spectrometer: nothing but noise, of hundreds of per cent."""
    random = np.random.default_rng(3)
    nm = NM[::2]
    for scale in (1.0, 9.3):
        result = ir.fit_thickness(nm, scale * random.standard_normal(nm.size), "air / SiO2 ? / Si")
        assert result.verdict != "clear"
