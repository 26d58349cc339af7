"""`ir.fit_thickness` on spectra whose thickness is known. Scores over thousands: bench/fit_scores.py, bench/fit_trials.py."""

from __future__ import annotations

import importlib.util
import json
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import iridesce as ir
from conftest import ROOT
from iridesce.inverse import model as fit_model
from iridesce.inverse.candidates import model_of
from iridesce.inverse.data import explained, within_light
from iridesce.inverse.full import Full, full, stuck
from iridesce.inverse.model import read_problem
from iridesce.inverse.posterior import Engine, Light, Measured, climb
from iridesce.inverse.results import apart
from iridesce.inverse.solve import student
from iridesce.inverse.verdict import Asked, verdict_of
from iridesce.optics.averages import FWHM

Floats = npt.NDArray[np.float64]

NM = np.arange(420.0, 760.0, 1.0)
# Films of the very index and spectrometers of the very wavelengths that were said.
EXACT: dict[str, Any] = {"index_tolerance": 0.0, "wavelength_tolerance_nm": 0.0}


def clean(text: str, *thickness_nm: float, nm: Floats = NM, quantity: str = "reflectance", **how: Any) -> Floats:
    for value in thickness_nm:
        text = text.replace("?", repr(value), 1)
    return np.asarray(getattr(ir.Stack.parse(text), quantity)(nm, **how))


def noisy(values: Floats, db: float = 40.0, seed: int = 1) -> Floats:
    random = np.random.default_rng(seed)
    return np.asarray(values + np.std(values) * 10.0 ** (-db / 20.0) * random.standard_normal(values.size))


@pytest.mark.parametrize(
    ("text", "thickness_nm"),
    [
        ("air / soap ? / air", 320.0),
        ("air / soap ? / air", 4871.0),
        ("air / SiO2 ? / Si", 50.0),
        ("air / SiO2 ? / Si", 60.0),
        ("air / SiO2 ? / Si", 1234.5),
        ("air / Si3N4 ? / Si", 77.0),
        ("air / TiO2 ? / Ti", 45.0),
        ("air / TiO2 ? / Ti", 180.0),
        ("air / SiO2 100 / TiO2 ? / N-BK7", 333.0),
        ("air / water ? / MgF2 500 / N-SF11", 2000.0),
    ],
)
def test_counts_with_unknown_gain_and_offset(text: str, thickness_nm: float) -> None:
    counts = 31_000.0 * noisy(clean(text, thickness_nm)) + 900.0
    result = ir.fit_thickness(NM, counts, text)
    assert abs(result.best.thickness_nm - thickness_nm) < 1.0
    low, high = result.best.precision_interval_nm
    # Eight times the half-width of 95 %: an error of sixteen standard deviations is no chance.
    assert abs(result.best.thickness_nm - thickness_nm) < 8.0 * 0.5 * (high - low)
    assert result.best.gain == pytest.approx(31_000.0, rel=0.05)
    assert sum(one.weight for one in result) + result.no_film + result.other == pytest.approx(1.0, abs=1e-12)
    assert result.verdict == "clear"


@pytest.mark.parametrize("thickness_nm", [9_000.0, 23_456.7, 49_000.0])
def test_thick_films_through_a_line(thickness_nm: float) -> None:
    nm = np.arange(780.0, 900.0, 0.1)
    stack = ir.Stack.parse(f"air / PMMA {thickness_nm} / Si")
    measured = noisy(np.asarray(stack.reflectance_averaged(nm, resolution_nm=0.5, tolerance=1e-6).value), 30.0)
    result = ir.fit_thickness(nm, measured, "air / PMMA ? / Si")
    assert abs(result.best.thickness_nm - thickness_nm) < 1e-4 * thickness_nm
    if thickness_nm > 20_000.0:  # thinner films have fringes too wide for this line to matter
        assert result.best.resolution_nm == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("thickness_nm", [5.0, 7.0, 12.0, 30.0])
def test_thin_films_of_a_calibrated_reflectance(thickness_nm: float) -> None:
    text = "air / SiO2 ? / Si"
    result = ir.fit_thickness(NM, noisy(clean(text, thickness_nm), 40.0), text, gain=1.0, baseline="none")
    low, high = result.best.precision_interval_nm
    assert low - (high - low) < thickness_nm < high + (high - low)
    assert 0.0 < high - low < 1.0


@pytest.mark.parametrize("text", ["air / soap ? / air", "air / SiO2 ? / Si", "air / TiO2 ? / 1.5"])
def test_exact_data_are_clear(text: str) -> None:
    """Peaks of 1e-5 nm, which the way to their top steps over: a bent lamp with a wider one won under 1.5 fringes."""
    for thickness_nm in (60.0, 190.0, 431.0):
        found = ir.fit_thickness(NM[::2], clean(text, thickness_nm, nm=NM[::2]), text)
        assert found.verdict == "clear" and abs(found.best.thickness_nm - thickness_nm) < 0.1


def test_intervals_hold_what_they_claim() -> None:
    """Of 120 intervals of 68 %, the share that holds the truth is within four standard deviations (0.17) of 68 %."""
    text, held, widths = "air / SiO2 ? / Si", 0, []
    nm = NM[::3]
    for seed in range(120):
        thickness_nm = 400.0 + 3.7 * seed
        result = ir.fit_thickness(
            nm,
            noisy(clean(text, thickness_nm, nm=nm), 35.0, seed),
            text,
            probability=0.68,
            resolution_nm=0.0,
            thickness_range_nm=(300.0, 1000.0),
            **EXACT,
        )
        low, high = result.best.interval_nm
        held += low <= thickness_nm <= high
        widths.append(high - low)
    assert 0.51 < held / 120.0 < 0.85
    assert max(widths) < 1.0


def test_noise_that_is_known_sets_the_interval() -> None:
    """Ten times the noise, ten times the interval; Student's factor grows with the probability."""
    text = "air / soap ? / air"
    values = clean(text, 640.0)
    widths = []
    for size in (1e-5, 1e-4):
        result = ir.fit_thickness(NM, values, text, noise=size, gain=1.0, baseline="none", resolution_nm=0.0, **EXACT)
        widths.append(np.ptp(result.best.interval_nm))
        assert result.noise == pytest.approx(size, rel=1e-12)
    assert widths[1] == pytest.approx(10.0 * widths[0], rel=0.05)
    slopes = ir.Stack.parse("air / soap 640 / air").derivatives("reflectance", NM).thickness_nm[..., 0]
    wanted = 2.0 * student(0.95, NM.size - 1) * 1e-5 / np.sqrt(np.sum(slopes**2))
    assert widths[0] == pytest.approx(wanted, rel=0.03)
    assert student(0.95, 10.0) == pytest.approx(2.228139, abs=3e-5)  # Abramowitz & Stegun, table 26.10


def test_all_plausible_solutions_are_told() -> None:
    """Three points a fringe and much noise: neighbours in order are as good as the right one."""
    text = "air / PMMA ? / Si"
    nm = np.linspace(600.0, 640.0, 90)
    values = noisy(clean(text, 3000.0, nm=nm), 12.0, seed=3)
    result = ir.fit_thickness(nm, values, text, thickness_range_nm=(1000.0, 6000.0))
    assert len(result) >= 3
    order_nm = 620.0 / (2.0 * 1.49)
    assert min(abs(solution.thickness_nm - 3000.0) for solution in result) < 0.2 * order_nm
    assert all(solution.weight >= 0.0 for solution in result)
    weights = [solution.weight for solution in result]
    assert weights == sorted(weights, reverse=True)
    # More light tells them apart.
    assert len(ir.fit_thickness(nm, noisy(clean(text, 3000.0, nm=nm), 55.0), text)) == 1


def test_two_thicknesses() -> None:
    text = "air / SiO2 ? / Si3N4 ? / Si"
    result = ir.fit_thickness(NM, noisy(clean(text, 210.0, 95.0)), text, gain=1.0, thickness_range_nm=(20.0, 400.0))
    assert np.abs(np.array(result.best.thickness_nm) - [210.0, 95.0]).max() < 1.0
    assert len(result.best.interval_nm) == 2
    by_name = ir.fit_thickness(
        NM,
        noisy(clean(text, 210.0, 95.0)),
        ir.Stack.parse("air / SiO2 1 / Si3N4 1 / Si"),
        layer=["SiO2", "Si3N4"],
        gain=1.0,
        thickness_range_nm=(20.0, 400.0),
    )
    assert by_name.best.thickness_nm == pytest.approx(result.best.thickness_nm, abs=1e-3)


def test_one_index_and_cauchy() -> None:
    nm = np.arange(420.0, 900.0, 1.0)
    film = ir.Stack([1.0, ir.Layer(1.62, 812.0), "Si"])
    values = noisy(np.asarray(film.reflectance(nm)), 45.0)
    result = ir.fit_thickness(nm, values, [1.0, 1.5, "Si"], gain=1.0, index="constant")
    assert result.best.thickness_nm == pytest.approx(812.0, abs=1.0)
    assert result.best.index[1]["n"] == pytest.approx(1.62, abs=0.003)
    assert 0.0 < result.best.index[1]["n_sd"] < 0.01

    n = 1.58 + 9e-3 * (1e3 / nm) ** 2
    values = np.array([ir.Stack([1.0, ir.Layer(a, 812.0), "Si"]).reflectance(b) for a, b in zip(n, nm, strict=True)])
    result = ir.fit_thickness(nm, noisy(values, 50.0), [1.0, 1.5, "Si"], gain=1.0, baseline="none", index="cauchy")
    assert result.best.thickness_nm == pytest.approx(812.0, abs=3.0)
    found = result.best.index[1]
    assert found["A"] == pytest.approx(1.58, abs=0.006) and found["B_um2"] == pytest.approx(9e-3, abs=1e-3)


@pytest.mark.parametrize(
    ("quantity", "polarization"), [("reflectance", "s"), ("reflectance", "p"), ("transmittance", "unpolarized")]
)
def test_at_an_angle(quantity: str, polarization: str) -> None:
    text, how = "air / Ta2O5 ? / N-BK7", {"angle_deg": 50.0, "polarization": polarization}
    values = noisy(clean(text, 777.0, quantity=quantity, **how))
    result = ir.fit_thickness(NM, values, text, quantity=quantity, **how)
    assert result.best.thickness_nm == pytest.approx(777.0, abs=1.0)


def test_a_slab_that_is_too_thick_to_interfere() -> None:
    text = "air / Ta2O5 ? / N-BK7 1e6 incoherent / air"
    result = ir.fit_thickness(NM, noisy(clean(text, 512.0)), text)
    assert result.best.thickness_nm == pytest.approx(512.0, abs=1.0)


# --- what real spectra have


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


@pytest.mark.parametrize("text", ["air / SiO2 ? / Si", "air / PMMA ? / N-BK7"])
def test_a_lamp_that_drifted(text: str) -> None:
    """An even gain fails; a bent one is taken, and the result says so."""
    nm = np.arange(470.0, 1000.0, 1.0)
    x = np.linspace(-1.0, 1.0, nm.size)
    values = noisy(clean(text, 2500.0, nm=nm), 35.0) * (1.0 + 0.1 * x - 0.2 * x**2)
    result = ir.fit_thickness(nm, values, text)
    assert result.best.thickness_nm == pytest.approx(2500.0, abs=3.0)
    assert any("even gain does not fit" in note for note in result.notes)
    told = ir.fit_thickness(nm, values, text, gain="quadratic", baseline="quadratic")
    assert told.best.thickness_nm == pytest.approx(2500.0, abs=3.0)
    assert told.best.gain_bend < 0.0 < told.best.gain_slope
    assert not any("even gain" in note for note in told.notes)


@pytest.mark.parametrize("thickness_nm", [2500.0, 6000.0, 20_000.0])
def test_counts_that_were_not_divided_by_the_lamp(thickness_nm: float) -> None:
    """A halogen lamp's bell over the fringes: they are found, and the notes say what was done."""
    nm = np.arange(470.0, 1000.0, 0.4)
    lamp = np.exp(-(((nm - 680.0) / 170.0) ** 2))
    random = np.random.default_rng(4)
    counts = (
        4e4 * lamp * clean("air / PMMA ? / Si", thickness_nm, nm=nm) + 300.0 + 20.0 * random.standard_normal(nm.size)
    )
    result = ir.fit_thickness(nm, counts, "air / PMMA ? / Si")
    assert result.best.thickness_nm == pytest.approx(thickness_nm, rel=2e-3)
    assert any("divided by its own smooth course" in note or "even gain" in note for note in result.notes)


def test_a_film_that_a_little_drift_hides_is_found() -> None:
    """Pale fringes under 5 % of drift: every film suits a lamp that bends as it likes, and the right one was not looked at."""
    nm = np.arange(470.0, 1000.0, 0.8)
    x = np.linspace(-1.0, 1.0, nm.size)
    values = noisy(clean("air / PMMA ? / N-BK7", 687.6, nm=nm), 35.0) * (1.0 - 0.04 * x + 0.03 * x * x)
    result = ir.fit_thickness(nm, values, "air / PMMA ? / N-BK7")
    assert result.verdict == "clear" and result.best.thickness_nm == pytest.approx(687.6, rel=0.01)


def test_a_lamp_alone_is_no_clear_film() -> None:
    nm = np.arange(470.0, 1000.0, 0.8)
    counts = 4e4 * np.exp(-(((nm - 680.0) / 170.0) ** 2)) + 20.0 * np.random.default_rng(4).standard_normal(nm.size)
    result = ir.fit_thickness(nm, counts, "air / PMMA ? / Si")
    assert result.verdict in ("none", "ambiguous") and all(one.weight < 0.95 for one in result)


def test_a_lamp_with_bumps_between_two_lengths_is_no_film() -> None:
    """Curves of 20 and of 50 nm describe bumps of 21 and 26 nm badly: with these alone 668 nm of soap were "clear"."""
    nm = np.arange(450.0, 850.0, 2.6)
    light = np.exp(-(((nm - 648.0) / 376.0) ** 2))
    for size, where, width in ((0.29, 725.0, 25.5), (0.38, 527.0, 21.0)):
        light = light * (1.0 + size * np.exp(-0.5 * ((nm - where) / width) ** 2))
    noise = 200.0 * (0.3 + np.sqrt(light)) * np.random.default_rng(1).standard_normal(nm.size)
    result = ir.fit_thickness(nm, 2e4 * light + noise, "air / soap ? / air", thickness_range_nm=(1.0, 3000.0))
    assert result.verdict in ("none", "ambiguous") and result.no_film > 0.1


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


@pytest.mark.parametrize("count", [4, 40])
def test_a_plateau_that_nothing_leads_up_to_is_no_full_channel(count: int) -> None:
    # What software writes where it divides by nothing.
    values = noisy(clean("air / soap ? / air", 612.0))
    values[-count:] = 9.3
    found = ir.fit_thickness(NM, values, stack="air / soap ? / air")
    assert (found.verdict, found.best.thickness_nm) == ("clear", pytest.approx(612.0, rel=2e-3))
    assert any(f"{count} of {NM.size} points dropped: at the largest value" in note for note in found.notes)


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


def bumps(seed: int, nm: Floats = NM) -> Floats:
    """A lamp with a bump of 40 % and 25 nm that nobody divided out."""
    random = np.random.default_rng(seed)
    where = random.uniform(nm[0], nm[-1])
    return np.asarray(1.0 + 0.4 * np.exp(-0.5 * ((nm - where) / 25.0) ** 2) - 0.3 * ((nm - 600.0) / 200.0) ** 2)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_bump_of_the_lamp_is_no_thin_film(seed: int) -> None:
    """Fringes win over the bump; where there are none, the bump is no film."""
    random = np.random.default_rng(seed)
    light = 2e4 * bumps(seed)
    truth = random.uniform(900.0, 3000.0)
    noise = 20.0 * random.standard_normal(NM.size)
    film = ir.fit_thickness(NM, light * (clean("air / soap ? / air", truth) + 0.01) + noise, "air / soap ? / air")
    assert film.best.thickness_nm == pytest.approx(truth, rel=0.01)
    assert film.verdict == "clear"
    empty = ir.fit_thickness(NM, 0.05 * light + noise, "air / soap ? / air")
    assert empty.verdict in ("none", "ambiguous") and all(one.weight < 0.95 for one in empty)


@pytest.mark.parametrize("thickness_nm", [25.0, 90.0, 640.0])
def test_dark_and_reference_make_counts_a_reflectance(thickness_nm: float) -> None:
    """A lamp with bumps, divided by what it gives on bare silicon: thin films too are told, and none where there is none."""
    random = np.random.default_rng(7)
    light, dark = 3e4 * bumps(4), 400.0
    base = np.asarray(ir.Stack(["air", "Si"]).reflectance(NM))
    seen = clean("air / SiO2 ? / Si", thickness_nm)
    noise = random.standard_normal((3, NM.size))
    how = {
        "dark": dark + 2.0 * noise[0],
        "reference": light * base + dark + 30.0 * noise[1],
        "reference_stack": "air / Si",
    }
    result = ir.fit_thickness(NM, light * seen + dark + 30.0 * noise[2], "air / SiO2 ? / Si", **how)
    assert result.best.thickness_nm == pytest.approx(thickness_nm, rel=0.02, abs=1.0)
    assert result.best.gain == pytest.approx(1.0, abs=0.05)
    bare = ir.fit_thickness(NM, light * base + dark + 30.0 * noise[2], "air / SiO2 ? / Si", **how)
    assert bare.verdict != "clear" or bare.best.precision_interval_nm[1] < 8.0


def test_a_reference_without_light_is_refused() -> None:
    ones = np.ones(NM.size)
    values = clean("air / soap ? / air", 500.0)
    for reference, words in (
        (0.0 * ones, "points, at least 12"),
        (ones[:-1], "one length"),
        (ones * np.nan, "at least 12"),
    ):
        with pytest.raises(ValueError, match=words):
            ir.fit_thickness(NM, values, "air / soap ? / air", reference=reference)
    half = np.where(NM < 500.0, 0.0, 5e4)
    result = ir.fit_thickness(NM, 5e4 * noisy(values), "air / soap ? / air", reference=half, dark=0.0 * ones)
    assert result.wavelength_nm.min() >= 500.0 and any("no light in the reference" in note for note in result.notes)
    with pytest.raises(ValueError, match="go with a reference"):
        ir.fit_thickness(NM, values, "air / soap ? / air", dark=ones)


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


@pytest.mark.parametrize("seed", [1, 2])
def test_a_baseline_of_counts_beside_a_reference(seed: int) -> None:
    """A dark that has drifted is, divided by the reference, largest where the lamp is dim: it was 1 nm, or no film at all."""
    random = np.random.default_rng(seed)
    nm = np.arange(430.0, 900.0, 1.5)
    light = 3e4 * (0.08 + np.exp(-(((nm - 640.0) / 130.0) ** 2)))
    light *= 1.0 + 0.5 * np.exp(-0.5 * ((nm - 520.0) / 25.0) ** 2)
    base = np.asarray(ir.Stack(["air", "Si"]).reflectance(nm))
    x = np.linspace(-1.0, 1.0, nm.size)
    drift = 2500.0 * (1.0 + 0.6 * x + 0.3 * x * x)
    noise = 15.0 * random.standard_normal((3, nm.size))
    seen = light * clean("air / SiO2 ? / Si", 875.0, nm=nm) + drift + 300.0 + noise[0]
    how = {"dark": 300.0 + noise[2], "reference": light * base + 300.0 + noise[1], "reference_stack": "air / Si"}
    result = ir.fit_thickness(nm, seen, "air / SiO2 ? / Si", **how, **EXACT)
    best = result.best
    assert result.verdict == "clear" and best.kappa == 1.0
    assert abs(best.thickness_nm - 875.0) < 3.0 * best.sd_nm < 0.6


def test_a_thin_film_behind_a_dim_light_is_a_range() -> None:
    random = np.random.default_rng(4)
    for counts, verdict in ((60.0, "ambiguous"), (6e4, "clear")):
        light = counts * bumps(4)
        seen, mirror = (
            light * one + 200.0 + 2.0 * random.standard_normal(NM.size)
            for one in (clean("air / soap ? / air", 60.0), np.ones(NM.size))
        )
        dark = 200.0 + 2.0 * random.standard_normal(NM.size)
        result = ir.fit_thickness(NM, seen, "air / soap ? / air", dark=dark, reference=mirror)
        assert result.verdict == verdict
        assert result.best.accuracy_interval_nm[0] < 60.0 < result.best.accuracy_interval_nm[1]


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
    even = np.array([0.0, 1.0, 0.3, 0.0, 0.0, 1.0, 0.0])

    def filled(thickness_nm: float, row: Floats) -> float:
        spectrum = clean("air / soap ? / air", thickness_nm)
        return held.log_probability(engine, spectrum[~over], spectrum[over], row)

    assert filled(750.0, even) > -1.0 and filled(640.0, even) < -100.0
    # A lamp that may bend makes up for what an even one does not.
    bent = even.copy()
    bent[3] = 0.3
    assert filled(640.0, bent) > -20.0


def test_an_index_that_is_not_sure_widens_the_interval() -> None:
    values = noisy(clean("air / SiO2 ? / Si", 1234.5))
    sure, unsure = (
        ir.fit_thickness(
            NM, values, "air / SiO2 ? / Si", index_tolerance=size, wavelength_tolerance_nm=0.0
        ).best.interval_nm
        for size in (0.0, 0.01)
    )
    assert np.ptp(sure) < 1.0
    assert np.ptp(unsure) == pytest.approx(2.0 * 1.96 * 0.01 * 1234.5, rel=0.02)


def test_an_index_of_which_nothing_was_told_is_in_the_accuracy() -> None:
    """Fringes show n h: the accuracy holds 1 % of the index, a note says so, and the interval takes it as exact."""
    values = noisy(clean("air / SiO2 ? / Si", 612.0))
    result = ir.fit_thickness(NM, values, "air / SiO2 ? / Si")
    best = result.best
    assert best.nm_per_percent_of_index == pytest.approx(6.12, rel=0.03)
    assert best.accuracy_nm == pytest.approx(6.12, rel=0.03) and best.sd_nm == best.precision_nm < 0.1
    assert np.ptp(best.accuracy_interval_nm) == pytest.approx(2.0 * 1.96 * 6.12, rel=0.03)
    assert best.interval_nm == pytest.approx(best.precision_interval_nm)
    assert np.ptp(best.precision_interval_nm) == pytest.approx(2.0 * 1.96 * best.precision_nm, rel=0.1)
    assert (
        sum(
            "said of the film's index" in note and f"{best.nm_per_percent_of_index:.2g} nm" in note
            for note in result.notes
        )
        == 1
    )
    for stated in (0.0, 0.01):
        told = ir.fit_thickness(NM, values, "air / SiO2 ? / Si", index_tolerance=stated)
        assert not any("index" in note for note in told.notes)
        assert told.best.nm_per_percent_of_index == pytest.approx(6.12, rel=0.03)
        assert told.best.precision_interval_nm == pytest.approx(best.precision_interval_nm)
        assert told.best.sd_nm == pytest.approx(np.hypot(best.precision_nm, 612.0 * stated), rel=0.03)
    # A thin film shows how large n is: 1 % of it is several per cent of the thickness.
    values = noisy(clean("air / soap ? / air", 20.0))
    thin = ir.fit_thickness(NM, values, "air / soap ? / air", gain=1.0, baseline="none")
    assert 0.04 < thin.best.nm_per_percent_of_index / 20.0 < 0.06


@pytest.mark.parametrize("off", [-0.01, 0.01])
def test_a_film_of_another_index_lies_within_the_accuracy(off: float) -> None:
    """Data of a film whose index differs by 1 % from what was said of it, with no word about that."""
    for n, truth in ((1.45, 900.0), (1.6, 2300.0)):
        film = ir.Stack([1.0, ir.Layer(n * (1.0 + off), truth), "Si"])
        result = ir.fit_thickness(NM, noisy(np.asarray(film.reflectance(NM))), [1.0, n, "Si"])
        low, high = result.best.accuracy_interval_nm
        assert result.verdict == "clear" and low < truth < high
        assert not result.best.precision_interval_nm[0] < truth < result.best.precision_interval_nm[1]


@pytest.mark.parametrize("off", [-1.0, 1.0])
def test_wavelengths_that_are_off_move_the_film_as_the_interval_says(off: float) -> None:
    """Of a known index: what a nm of all wavelengths moves is what `wavelength_tolerance_nm` makes of it."""
    for text, truth in (("air / SiO2 ? / Si", 900.0), ("air / soap ? / air", 2300.0)):
        values = noisy(clean(text, truth, nm=NM + off))
        result = ir.fit_thickness(NM, values, text, index_tolerance=0.0, wavelength_tolerance_nm=1.0)
        moved = abs(result.best.thickness_nm - truth)
        told = np.sqrt(result.best.sd_nm**2 - result.best.precision_nm**2)
        assert moved == pytest.approx(told, rel=0.25), (text, moved, told)
        plain = ir.fit_thickness(NM, values, text)
        assert plain.best.accuracy_interval_nm[0] < truth < plain.best.accuracy_interval_nm[1]


def test_of_two_layers_the_index_of_each_moves_both() -> None:
    """What fits find under indices that are off by hand is what the intervals hold."""
    stack, truth = "air / SiO2 ? / Si3N4 ? / Si", (210.0, 95.0)
    values = noisy(clean(stack, *truth), 60.0)
    how: dict[str, Any] = {"gain": 1.0, "thickness_range_nm": [(150.0, 280.0), (60.0, 130.0)]}
    tolerances = {"index_tolerance": 1e-3, "wavelength_tolerance_nm": 0.0}
    best = ir.fit_thickness(NM, values, stack, **how, **tolerances).best
    found = np.array(best.thickness_nm)
    squares = np.zeros(2)
    first, *layers, last = ir.Stack.parse(stack.replace("?", "1")).media
    for place in range(2):
        media = [np.asarray(one.index(NM), complex) for one in layers]
        media[place] = media[place] * 1.001
        tables = ["\n".join(f"{a},{b.real:.17g},{b.imag:.17g}" for a, b in zip(NM, one, strict=True)) for one in media]
        items = [ir.Medium._from_text(f"nm,n,k\n{table}\n", "layer") for table in tables]
        moved = ir.fit_thickness(NM, values, [first, *items, last], **how, **EXACT).best
        squares += (np.array(moved.thickness_nm) - found) ** 2
    told = np.sqrt(np.array(best.sd_nm) ** 2 - np.array(best.precision_nm) ** 2)
    assert told == pytest.approx(np.sqrt(squares), rel=0.2)


def test_orders_of_a_thick_film_are_not_one_for_its_index() -> None:
    """1 % of 30 um is more than an order: neighbours stand beside each other, each with its own precision."""
    best = ir.fit_thickness(NM, noisy(clean("air / SiO2 ? / Si", 612.0)), "air / SiO2 ? / Si").best
    shared = {"sd_nm": 300.0, "precision_nm": 1.0, "fitted": best.fitted}
    films = [
        replace(
            best, thickness_nm=h, interval_nm=(h - 588.0, h + 588.0), precision_interval_nm=(h - 2.0, h + 2.0), **shared
        )
        for h in (30_000.0, 30_001.0, 30_208.0)
    ]
    assert [one[0].thickness_nm for one in apart([(film, 0.0, False) for film in films])] == [30_000.0, 30_208.0]


@pytest.mark.parametrize("light", [1.0, None])
def test_a_baseline_that_drifts_under_an_even_response(light: float | None) -> None:
    """Stray light that no lamp bends: half the mean, slanted and bowed. As an even one it was "doubtful", kappa 10."""
    x = np.linspace(-1.0, 1.0, NM.size)
    for text, truth in (("air / SiO2 ? / Si", 900.0), ("air / soap ? / air", 1400.0)):
        film = clean(text, truth)
        drift = 0.4 * film.mean() * (1.0 + 0.7 * x - 0.25 * (x * x - 0.3))
        values = (film + drift + 0.01 * film.mean() * np.random.default_rng(8).standard_normal(NM.size)) * (
            light or 3e4
        )
        result = ir.fit_thickness(NM, values, text, gain=light)
        assert (result.verdict, result.best.kappa) == ("clear", 1.0)
        low, high = result.best.precision_interval_nm
        assert abs(result.best.thickness_nm - truth) < 1.5 * (high - low) and high - low < 6.0
        assert light is None or any("stray light changes" in note for note in result.notes)
    # And a baseline alone is no film.
    assert ir.fit_thickness(NM, values - (light or 3e4) * film, text, gain=light).verdict in ("none", "ambiguous")


def test_a_spectrum_of_noise_alone_is_never_clear() -> None:
    """Percent of the dark end of a spectrometer: nothing but noise, of hundreds of per cent."""
    random = np.random.default_rng(3)
    for scale in (1.0, 9.3):
        result = ir.fit_thickness(NM, scale * random.standard_normal(NM.size), "air / SiO2 ? / Si")
        assert result.verdict != "clear"


# --- arguments


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"stack": 5}, "stack must be"),
        ({"stack": "air / air"}, "no layer"),
        ({"stack": "air / soap 100 / water 100 / air"}, "2 coherent layers"),
        ({"stack": "air / soap ? incoherent / air"}, "incoherent"),
        ({"stack": ir.Stack(["air", ir.Layer("soap", np.array([1.0, 2.0])), "air"])}, "one thickness a layer"),
        ({"layer": 2}, "layer must be 1 to 1"),
        ({"layer": "water"}, "names of|name of"),
        ({"quantity": "absorptance"}, "quantity"),
        ({"polarization": "x"}, "polarization"),
        ({"angle_deg": 90.0}, "angle_deg"),
        ({"angle_deg": [1.0, 2.0]}, "angle_deg must be a number"),
        ({"gain": 0.0}, "gain must be"),
        ({"gain": -1.0}, "gain"),
        ({"gain": "bent"}, "gain"),
        ({"gain": np.nan}, "gain"),
        ({"baseline": "cubic"}, "baseline"),
        ({"resolution_nm": -1.0}, "resolution_nm"),
        ({"resolution_nm": np.inf}, "resolution_nm"),
        ({"index": "sellmeier"}, "index must be"),
        ({"index": {2: "constant"}}, "layer must be"),
        ({"noise": -1.0}, "no usable point"),
        ({"noise": [1.0, 2.0]}, "noise must be one number"),
        ({"probability": 0.0}, "probability"),
        ({"probability": 1.0}, "probability"),
        ({"thickness_range_nm": (5.0, 5.0)}, "low < high"),
        ({"thickness_range_nm": (-5.0, 5.0)}, "low < high"),
        ({"thickness_range_nm": (1.0, 1e9)}, "1e6"),
        ({"thickness_range_nm": "thin"}, "thickness_range_nm"),
        ({"thickness_range_nm": (1.0, 2.0, 3.0)}, "thickness_range_nm"),
        ({"wavelength_nm": NM[:-1]}, "one length"),
        ({"wavelength_nm": NM[:5], "measured": NM[:5]}, "too few"),
        ({"wavelength_nm": [], "measured": []}, "no usable point"),
        ({"wavelength_nm": -NM}, "no usable point"),
        ({"measured": np.full(NM.size, np.nan)}, "no usable point"),
        ({"measured": NM.reshape(10, -1)}, "along one axis"),
        ({"measured": NM + 1j}, "real numbers"),
        ({"measured": ["a"] * NM.size}, "must be real numbers"),
        ({"measured": None}, "measured"),
        ({"wavelength_nm": np.full(NM.size, 550.0)}, "too few"),
    ],
)
def test_arguments_are_refused_in_words(change: dict[str, Any], words: str) -> None:
    arguments: dict[str, Any] = {"wavelength_nm": NM, "measured": clean("air / soap ? / air", 300.0)}
    arguments = {**arguments, "stack": "air / soap ? / air", **change}
    with pytest.raises(ValueError, match=words):
        ir.fit_thickness(**arguments)


@pytest.mark.parametrize("scale", [1e-290, 1e-30, 1e30, 1e290])
def test_sizes_of_the_unit_do_not_matter(scale: float) -> None:
    values = noisy(clean("air / soap ? / air", 700.0))
    result = ir.fit_thickness(NM, scale * values, "air / soap ? / air")
    assert result.best.thickness_nm == pytest.approx(700.0, abs=0.5)


# --- what it answers


def test_answers_are_plain_values() -> None:
    values = noisy(clean("air / soap ? / air", 700.0))
    result = ir.fit_thickness(NM, values, "air / soap ? / air")
    told = json.loads(json.dumps(result.to_dict()))
    assert told["solutions"][0]["thickness_nm"] == result.best.thickness_nm
    assert result[0] is result.best and result[:1] == (result.best,) and list(result) == list(result.solutions)
    assert "700" in str(result) or "699" in str(result)
    assert "95 %" in str(result)
    best = result.best
    np.testing.assert_allclose(best.misfit, np.sqrt(np.mean((result.measured - best.fitted) ** 2)), rtol=1e-12)


def test_plot_shows_data_and_every_curve() -> None:
    import matplotlib.pyplot as plt

    nm = np.linspace(600.0, 640.0, 90)
    values = noisy(clean("air / PMMA ? / Si", 3000.0, nm=nm), 12.0, seed=3)
    result = ir.fit_thickness(nm, values, "air / PMMA ? / Si", thickness_range_nm=(1000.0, 6000.0))
    ax = result.plot(title="a film", theme="dark")
    curves = [line for line in ax.get_lines() if line.get_gid() == "fitted"]
    points = [line for line in ax.get_lines() if line.get_gid() == "measured"]
    assert len(curves) == min(len(result), 5) and len(points) == 1
    np.testing.assert_array_equal(np.asarray(points[0].get_ydata()), result.measured)
    np.testing.assert_array_equal(np.asarray(curves[0].get_ydata()), result.best.fitted)
    assert f"{len(result) - 1} more plausible solution" in " ".join(
        text.get_text() for text in ax.figure.findobj(plt.Text)
    )
    plt.close(ax.figure)


# --- the models' derivatives, which the least squares steer by


@pytest.mark.parametrize(
    ("text", "index", "parameters"),
    [
        ("air / soap ? / air", None, [700.0, 1.2]),
        ("air / SiO2 ? / Si", None, [1500.0, 2.0]),
        ("air / SiO2 ? / Si", "cauchy", [600.0, 1.45, 4e-3, 1.5]),
        ("air / TiO2 ? / Ti", "constant", [120.0, 2.3, 0.8]),
        ("air / SiO2 ? / Si3N4 ? / Si", None, [210.0, 95.0, 0.7]),
        ("air / Ta2O5 ? / N-BK7 1e6 incoherent / air", None, [300.0, 0.5]),
    ],
)
def test_derivatives_of_the_models(text: str, index: str | None, parameters: list[float]) -> None:
    nm = np.linspace(500.0, 700.0, 9)
    problem = fit_model.read_problem(text, None, index, "reflectance", 30.0, "unpolarized")
    of = fit_model.harmonics(problem, nm)
    models = [fit_model.GeneralModel(problem, nm)]
    models += [] if of is None else [fit_model.HarmonicModel(of)]  # type: ignore[list-item]
    start = np.array(parameters)
    start[-1] = (start[-1] / FWHM) ** 2
    for model in models:
        _, slopes = model.both(start)
        for place in range(start.size - (model is models[0])):
            step = np.zeros(start.size)
            step[place] = 1e-4 * max(abs(start[place]), 1e-3)
            difference = (model.value(start + step) - model.value(start - step)) / (2.0 * step[place])
            np.testing.assert_allclose(slopes[:, place], difference, rtol=2e-5, atol=2e-6 * np.abs(difference).max())
    if len(models) == 2:
        # Two roads to one spectrum: the harmonics to second order of the line, and the average itself.
        np.testing.assert_allclose(
            models[0].value(start), models[1].value(start), atol=2e-4 * np.ptp(models[0].value(start))
        )


def hard() -> Any:
    """bench/fit_hard.py."""
    spec = importlib.util.spec_from_file_location("fit_hard", ROOT / "bench" / "fit_hard.py")
    assert spec is not None and spec.loader is not None
    bench = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = bench  # its dataclasses ask for their module
    spec.loader.exec_module(bench)
    return bench


def test_a_thin_film_by_a_reference_that_drifted_is_not_a_thick_one_without_fringes() -> None:
    """37 nm of oxide, the lamp changed by 2 % since the reference, the index off by up to 1 %.

    Under an even gain of 1 such a film is no minimum; thick films, their fringes lost in a line of 14 nm, were "clear".
    """
    row = hard().one(("known thin", "oxide", 41_001))
    assert row.truth_nm == pytest.approx(36.9, abs=0.05)
    assert abs(row.found_nm - row.truth_nm) < 6.0 and row.verdict in ("clear", "ambiguous")


def test_intervals_under_an_unknown_lamp_are_as_wide_as_the_errors() -> None:
    """60 films of 1.5 to 12 fringes under lamps with bumps: errors over standard deviations.

    With lamps of one length at a time, no finer bumps on them, their root mean square is 1.23.
    """
    bench = hard()
    errors = []
    for seed in range(52_001, 52_021):
        for name in bench.STACKS:
            of = bench.spectrum("lamp", name, seed)
            problem = read_problem(of.text, None, None, "reflectance", 0.0, "unpolarized")
            model = model_of(problem, of.wavelength_nm)
            second = of.counts[2:] - 2.0 * of.counts[1:-1] + of.counts[:-2]
            sd = np.full(of.counts.size, np.std(second) / np.sqrt(6.0))
            engine = Engine(Measured(of.wavelength_nm, of.counts, sd, 0.2), Light(None, True, False, True))
            peak = climb(engine, lambda h, model=model: model.value(np.array([h, 0.0])), of.truth_nm, 0.3, (1.0, 5e4))
            errors.append((peak.thickness_nm - of.truth_nm) / peak.sd_nm)
    size = np.abs(np.array(errors))
    assert 0.6 < np.sqrt(np.mean(size**2)) < 1.15
    # 68 % within three standard deviations of a share of 60.
    assert 0.5 < np.mean(size < 1.0) < 0.86
