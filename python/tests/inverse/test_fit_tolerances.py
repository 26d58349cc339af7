"""How well an index and the wavelengths are known, and what of it intervals and accuracies hold."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fit_spectra import EXACT, NM, clean, noisy

import iridesce as ir
from iridesce.inverse.results import apart


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
