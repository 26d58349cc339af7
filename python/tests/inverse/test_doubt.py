"""What a second look finds where the first is in doubt: uneven films, and spectra that step."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import iridesce as ir
from iridesce.inverse.doubt import best_step, sharpest_step
from iridesce.inverse.solve import Data

Floats = npt.NDArray[np.float64]


def film(text: str, nm: Floats, thickness_nm: float) -> Floats:
    return np.asarray(ir.Stack.parse(text.replace("?", repr(float(thickness_nm)))).reflectance(nm))


def noisy(clean: Floats, seed: int, share: float = 0.018) -> Floats:
    return np.asarray(clean + share * np.std(clean) * np.random.default_rng(seed).standard_normal(clean.size))


def test_an_uneven_film_whose_fringes_are_left_at_one_end() -> None:
    """4.7 radians of spread at 600 nm, 2.8 at 1 000: the fringes there are a fiftieth of what they were."""
    nm, text = np.arange(600.0, 1000.0, 0.5), "air / PMMA ? / Si"
    spread = np.linspace(-6.0, 6.0, 241)
    weights = np.exp(-0.5 * spread**2) / np.exp(-0.5 * spread**2).sum()
    seen = sum(w * film(text, nm, 12_400.0 * (1.0 + 0.012 * x)) for x, w in zip(spread, weights, strict=True))
    found: Any = ir.fit_thickness(nm, 700.0 * noisy(np.asarray(seen), 3), text)
    assert found.verdict == "clear"
    assert abs(found.best.thickness_nm - 12_400.0) < 3.0
    low, high = found.best.accuracy_interval_nm
    assert low < 12_400.0 < high


def test_two_detectors_that_do_not_meet() -> None:
    """A film of next to the index of its base: the step is twice as large as its fringe."""
    nm, text = np.arange(470.0, 1000.0, 2.0), "air / PMMA ? / N-BK7"
    seen = film(text, nm, 310.0) * (1.0 - 0.06 * (nm > 672.5))
    found: Any = ir.fit_thickness(nm, 5.0 * noisy(seen, 5), text, thickness_range_nm=(20.0, 1000.0))
    assert found.verdict in ("clear", "ambiguous")
    low, high = found.best.interval_nm
    assert low < 310.0 < high and high - low < 30.0
    assert any("steps at 673.0 nm" in note for note in found.notes)


def planted(size: float) -> tuple[Data, Floats]:
    nm = np.arange(450.0, 750.0, 1.0)
    spectrum = film("air / SiO2 ? / Si", nm, 800.0)
    seen = (2.0 * spectrum + 0.1) * (1.0 + size * (nm >= 600.0)) + 0.03 * (nm >= 600.0)
    return Data(nm, noisy(seen, 1, 0.01), np.ones_like(nm), None, 0, 1), spectrum


@pytest.mark.parametrize("size", [-0.1, 0.05])
def test_a_planted_step_is_found_with_its_size(size: float) -> None:
    data, spectrum = planted(size)
    step = best_step(data, [spectrum[::-1].copy(), spectrum])
    assert step is not None and step.wavelength_nm == 599.5
    assert step.gain == pytest.approx(size, abs=0.006) and step.offset == pytest.approx(0.03, abs=0.006)
    assert step.log_share < 0.0


def test_the_sharpest_step_needs_no_film() -> None:
    data, _ = planted(0.05)
    step = sharpest_step(data)
    assert step is not None and step.wavelength_nm == 599.5 and 0.03 < step.gain < 0.2


def test_of_too_few_channels_no_step_is_told() -> None:
    nm = np.arange(450.0, 490.0, 1.0)
    data = Data(nm, nm, np.ones_like(nm), None, 0, 1)
    assert best_step(data, [nm]) is None and sharpest_step(data) is None
