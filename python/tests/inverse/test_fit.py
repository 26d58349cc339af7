"""`ir.fit_thickness` on spectra whose thickness is known. Scores over thousands: bench/fit_scores.py, bench/fit_trials.py."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from fit_spectra import EXACT, NM, clean, noisy

import iridesce as ir
from iridesce.inverse.solve import student


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
        ({"index": {2: "constant"}}, "index must be by layer: 1 to 1"),
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
