"""`ir.fit_series`: the lamp is learnt, thin films are told by it, films jump and burst. Scores: bench/fit_series.py."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import iridesce as ir
from conftest import Run
from iridesce.inverse import series as series_module
from iridesce.inverse.course import Course
from iridesce.inverse.model import read_problem
from iridesce.inverse.spectrum_light import Light, size_of_light

Floats = npt.NDArray[np.float64]
NM = np.arange(450.0, 850.0, 4.0)
SOAP = "air / soap ? / air"
LAMP = 2e4 * np.exp(-(((NM - 650.0) / 220.0) ** 2)) * (1.0 + 0.4 * np.exp(-0.5 * ((NM - 560.0) / 25.0) ** 2))


def counts(h: Floats, seed: int = 1, noise: float = 30.0, varies: float = 0.1) -> Floats:
    random = np.random.default_rng(seed)
    film = np.asarray(ir.Stack(["air", ir.Layer("soap", h[:, None]), "air"]).reflectance(NM))
    size = np.exp(varies * random.standard_normal(h.size))[:, None]
    return np.asarray(size * LAMP * (film + 0.005) + noise * random.standard_normal(film.shape))


def fit(spectra: Any, **how: Any) -> Any:
    how.setdefault("thickness_range_nm", (1.0, 2500.0))
    how.setdefault("index_tolerance", 0.0)
    how.setdefault("wavelength_tolerance_nm", 0.0)
    return ir.fit_series(NM, spectra, SOAP, **how)


@pytest.fixture(scope="module")
def thinning() -> tuple[Floats, Any]:
    """From 1 700 to 60 nm, a patch half as thick again passing, and gone at the end."""
    h = 1700.0 * np.exp(-np.linspace(0.0, 3.6, 90)) + 15.0
    h[30:34] *= 1.5
    h[85:] = 0.0
    return h, fit(counts(h), time_s=0.5 * np.arange(90.0))


def test_a_film_is_followed_to_where_one_spectrum_tells_nothing(thinning: tuple[Floats, Any]) -> None:
    h, series = thinning
    film = h > 0.0
    error = np.abs(series.thickness_nm - h)[film]
    assert series.learnt and (error < 0.04 * h[film] + 3.0).mean() > 0.97
    right = (error < 0.04 * h[film] + 3.0)[series.verdict[film] == "clear"]
    assert right.size > 70 and right.mean() > 0.98
    # The thinnest have less than half a fringe: their size tells them apart, and the light's own varies by 10 %.
    assert series.verdict[80] == "ambiguous"
    low, high = series.interval_nm[80]
    assert low < h[80] < high and 0.08 < (high - low) / h[80] < 0.6


def test_how_far_the_size_of_the_light_varies_is_learnt() -> None:
    """Few show little, a trend may go on, and nothing is known to less than 3 %."""
    random = np.random.default_rng(4)
    middle, spread = size_of_light(3.0 * np.exp(0.1 * random.standard_normal(400)))
    assert abs(middle - 3.0) < 0.03 and abs(spread - 0.1) < 0.015
    assert size_of_light(np.array([0.9, 1.0, 1.1, 1.0, 0.95]))[1] > 1.3 * 0.074
    # (The last third of this one has 0.2 / 1.15 more than the first.)
    assert size_of_light(np.linspace(1.0, 1.3, 60))[1] > 0.174
    assert size_of_light(np.ones(50))[1] == 0.03


@pytest.mark.parametrize("off", [-0.01, 0.01])
def test_a_thin_film_moves_with_its_index_by_more_than_its_share(off: float) -> None:
    """R goes with (n^2 - 1)^2 h^2: 1 % of n is 4.6 % of 20 nm of soap, where n h is held alone it would be 1 %."""
    h = np.linspace(30.0, 20.0, 12)
    n = np.real(np.asarray(ir.Medium("soap").index(NM))) * (1.0 + off)
    inside = np.exp(4j * np.pi * n * h[:, None] / NM)
    r = (1.0 - n) / (1.0 + n)
    light = np.abs(r * (1.0 - inside) / (1.0 - r * r * inside)) ** 2
    seen = light + 1e-5 * np.random.default_rng(2).standard_normal(light.shape)
    how = {"gain": 1.0, "baseline": "none", "thickness_range_nm": (1.0, 200.0)}
    series = fit(seen, index_tolerance=0.01, **how)
    moved = np.abs(series.thickness_nm - h)
    # One standard deviation off.
    assert (
        (moved > 0.03 * h).all()
        and (moved < 1.3 * series.accuracy_nm).all()
        and (moved > 0.5 * series.accuracy_nm).all()
    )
    assert (series.interval_nm[:, 0] < h).all() and (h < series.interval_nm[:, 1]).all()


def test_the_lamp_is_learnt(thinning: tuple[Floats, Any]) -> None:
    _, series = thinning
    share = series.response / LAMP
    assert np.std(share / share.mean()) < 0.02
    assert series.response.mean() == pytest.approx(1.0)


@pytest.mark.parametrize("share", [0.85, 0.7])
def test_channels_that_are_full_in_some_spectrum_are_left_out(share: float) -> None:
    # A detector that is full at the lamp's brightest: taken for values its plateau is a lamp of another course in each spectrum.
    h = 1500.0 * np.exp(-np.linspace(0.0, 1.0, 40))
    spectra = counts(h, varies=0.0)
    series = fit(np.minimum(spectra, share * spectra.max()))
    assert any("channels dropped: full" in note for note in series.notes)
    assert (np.abs(series.thickness_nm / h - 1.0) < 0.01).mean() > 0.95
    assert (series.verdict == "clear").mean() > 0.9


def test_where_nearly_all_channels_are_full_none_is_left_out_and_nothing_is_sure() -> None:
    spectra = counts(1500.0 * np.exp(-np.linspace(0.0, 1.0, 40)), varies=0.0)
    lost = fit(np.minimum(spectra[::10], 0.05 * spectra.max()), thickness_range_nm=(500.0, 1700.0))
    assert any("too many to go without" in note for note in lost.notes) and not (lost.verdict == "clear").any()


def test_a_burst_film_is_none(thinning: tuple[Floats, Any]) -> None:
    h, series = thinning
    assert set(series.verdict[h == 0.0]) == {"none"} and np.isnan(series.thickness_nm[h == 0.0]).all()
    assert series.counts()["none"] == 5


def test_intervals_hold_the_truth(thinning: tuple[Floats, Any]) -> None:
    """Of some 80 intervals of 95 %: within four standard deviations, 0.10."""
    h, series = thinning
    part = (series.verdict == "clear") & (np.abs(series.thickness_nm - h) < 0.04 * h + 3.0)
    low, high = series.interval_nm[part].T
    assert ((low <= h[part]) & (h[part] <= high)).mean() > 0.85
    wide = fit(counts(h)[:40], index_tolerance=0.01)
    assert np.nanmedian(np.ptp(wide.interval_nm, axis=1)) > 2.0 * np.nanmedian(np.ptp(series.interval_nm[:40], axis=1))
    # Where nothing is said of index and wavelengths, the accuracy holds what is usual of both, and the interval neither.
    unsaid = fit(counts(h)[:40], index_tolerance=None, wavelength_tolerance_nm=None)
    part = unsaid.verdict == "clear"
    sd = np.ptp(unsaid.interval_nm[part], axis=1) / (2.0 * 1.96)
    told = np.hypot(unsaid.precision_nm[part], np.hypot(0.01, 0.3 / 640.0) * unsaid.thickness_nm[part])
    assert unsaid.accuracy_nm[part] == pytest.approx(told, rel=0.02)
    assert sd == pytest.approx(unsaid.precision_nm[part], rel=0.02)
    assert any("said of the film's index" in note for note in unsaid.notes) and not wide.notes
    assert unsaid.precision_nm[part] == pytest.approx(wide.precision_nm[part])


def course(h: Floats, seed: int) -> Course:
    """Spectra of these films under a lamp that is learnt from them, the films known."""
    spectra = counts(h, seed)
    problem = read_problem(SOAP, None, None, "reflectance", 0.0, "unpolarized")
    one = Course(problem, NM, spectra, np.full(NM.size, 30.0), Light(None, None, True), (1.0, 2500.0), 0.0)
    assert one.learn(h, np.ones(h.size, dtype=bool))
    return one


def test_a_learnt_lamp_is_as_uncertain_as_it_says() -> None:
    """Lamps learnt from the same films under other noise scatter by what `lamp_unknown` says, up to their size."""
    h = np.linspace(1300.0, 1100.0, 8)
    learnt = [course(h, seed) for seed in range(24)]
    lamps = np.array([one.lamp for one in learnt])
    seen = np.std(lamps / lamps.mean(axis=0) / (lamps / lamps.mean(axis=0)).mean(axis=1)[:, None], axis=0)
    told = learnt[0].lamp_unknown
    told = np.linalg.norm(told - told.mean(axis=0), axis=1)
    assert 0.8 < np.median(seen / told) < 1.2, np.median(seen / told)


def test_films_move_with_the_lamp_as_their_intervals_say() -> None:
    """Each unknown change of the lamp, put into it by hand, moves the film found as `errors_of_all` sums."""
    h = np.linspace(1300.0, 1100.0, 8)
    one = course(h, 3)
    found = one.candidates().thickness_nm[:, 0]
    told, lamp = one.errors_of_all(found)[0], one.lamp
    moved = []
    for change in one.lamp_unknown.T:
        one.lamp = lamp * (1.0 + change)
        moved.append(one.candidates().thickness_nm[:, 0] - found)
    np.testing.assert_allclose(np.linalg.norm(moved, axis=0), told, rtol=0.15)


def test_a_series_is_kept_and_shown(thinning: tuple[Floats, Any], tmp_path: Path) -> None:
    h, series = thinning
    series.save(tmp_path / "x.csv")
    lines = (tmp_path / "x.csv").read_text().splitlines()
    assert len(lines) == h.size + 1 and lines[0].startswith("time_s,thickness_nm,low_nm,high_nm,verdict")
    series.save(tmp_path / "x.json")
    assert json.loads((tmp_path / "x.json").read_text())["thickness_nm"][-1] is None
    data = series.to_xarray()
    assert data.thickness_nm.shape == (h.size,) and float(data.time_s[2]) == 1.0
    assert "90" in series._repr_html_() and "clear" in str(series)
    assert series.plot().get_xlabel() == "time (s)"
    with pytest.raises(ValueError, match="path must end"):
        series.save(tmp_path / "x.txt")


def test_a_reference_makes_one_thin_film_enough() -> None:
    random = np.random.default_rng(3)
    h = np.linspace(60.0, 50.0, 12)
    film = np.asarray(ir.Stack(["air", ir.Layer("SiO2", h[:, None]), "Si"]).reflectance(NM))
    dark = 300.0 + 2.0 * random.standard_normal(NM.size)
    mirror = LAMP * np.asarray(ir.Stack.parse("air / Si").reflectance(NM)) + 300.0
    seen = LAMP * film + 300.0 + 10.0 * random.standard_normal(film.shape)
    series = ir.fit_series(NM, seen, "air / SiO2 ? / Si", dark=dark, reference=mirror, reference_stack="air / Si")
    assert np.abs(series.thickness_nm - h).max() < 2.0 and set(series.verdict) == {"clear"}


@pytest.mark.parametrize("gain", [1.0, None])
def test_clean_spectra_are_clear_to_a_picometre(gain: float | None) -> None:
    """Without noise whatever is left is the fit's own: coarse steps, or a lamp that took what a wrong film left."""
    path = np.r_[np.linspace(900.0, 870.0, 6), np.linspace(1250.0, 1200.0, 6)]
    clean = np.asarray(ir.Stack(["air", ir.Layer("soap", path[:, None]), "air"]).reflectance(NM))
    series = fit(clean, gain=gain)
    assert set(series.verdict) == {"clear"} and series.notes == ()
    assert np.abs(series.thickness_nm - path).max() < 1e-3
    assert np.abs(series.response - 1.0).max() < 1e-3


def test_exact_data_under_a_lamp() -> None:
    """Below 1e-4 of the light nothing is noise: neither curves of lamps nor grids are as good, and no film was found."""
    path = np.linspace(1500.0, 900.0, 12)
    clean = np.asarray(ir.Stack(["air", ir.Layer("soap", path[:, None]), "air"]).reflectance(NM))
    series = fit(clean * (200.0 + 1000.0 * np.exp(-(((NM - 560.0) / 90.0) ** 2))))
    assert set(series.verdict) == {"clear"} and np.abs(series.thickness_nm - path).max() < 1.0


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_few_thin_films_teach_no_lamp_and_are_so_many_single_fits(noise: float) -> None:
    """The mean of films that hardly change holds their fringe: as the lamp it made 430 nm a clear 1380."""
    path = np.array([431.0, 430.0, 429.0])
    clean = np.asarray(ir.Stack(["air", ir.Layer("soap", path[:, None]), "air"]).reflectance(NM))
    series = fit(clean + noise * np.random.default_rng(0).standard_normal(clean.shape), probability=0.999)
    assert not series.learnt and set(series.verdict) == {"clear"}
    assert np.abs(series.thickness_nm - path).max() < 0.5 + 1e3 * noise
    assert (series.interval_nm[:, 0] <= path).all() and (path <= series.interval_nm[:, 1]).all()


def test_single_fits_tell_the_probability_of_the_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of all films of it, not of the likeliest alone."""
    path = np.array([431.0, 430.0, 429.0])
    clean = np.asarray(ir.Stack(["air", ir.Layer("soap", path[:, None]), "air"]).reflectance(NM))
    whole = ir.fit_thickness(NM, clean[1], SOAP)
    best = whole.best
    two = (replace(best, weight=0.6), replace(best, thickness_nm=best.thickness_nm + 9.0, weight=0.37))
    far = replace(best, thickness_nm=best.thickness_nm + 250.0, weight=0.02)
    monkeypatch.setattr(series_module, "fit_thickness", lambda *_, **__: replace(whole, solutions=(*two, far)))
    series = fit(clean)
    assert not series.learnt and series.probability_of_order == pytest.approx(0.97)


@pytest.mark.parametrize("spectra", [np.zeros((6, NM.size)), np.full((6, NM.size), 7.0), np.full((6, NM.size), np.nan)])
def test_empty_series_are_none(spectra: Floats) -> None:
    series = fit(spectra)
    assert set(series.verdict) == {"none"} and np.isnan(series.thickness_nm).all()


@pytest.mark.slow
def test_noise_and_a_lamp_alone_are_never_clear() -> None:
    random = np.random.default_rng(5)
    for spectra in (random.standard_normal((4, NM.size)), LAMP + 30.0 * random.standard_normal((4, NM.size))):
        assert "clear" not in set(fit(spectra, thickness_range_nm=(1.0, 1200.0)).verdict)


@pytest.mark.slow
def test_a_series_that_is_short_and_still_begins_with_spectra_alone() -> None:
    h = np.linspace(1200.0, 1150.0, 6)
    series = fit(counts(h))
    assert series.learnt and np.abs(series.thickness_nm - h).max() < 5.0


def test_files(tmp_path: Path, iridesce: Run) -> None:
    h = np.linspace(1200.0, 1150.0, 6)
    names = []
    calibrated = ir.Stack(["air", ir.Layer("soap", h[:, None]), "air"]).reflectance(NM)
    for place, row in enumerate(calibrated + 1e-3 * np.random.default_rng(1).standard_normal(calibrated.shape)):
        names.append(f"s{place}.csv")
        (tmp_path / names[-1]).write_text("".join(f"{a:.1f},{b:.6f}\n" for a, b in zip(NM, row, strict=True)))
    series = ir.fit_series(None, [tmp_path / name for name in names], SOAP, gain=1.0)
    assert np.abs(series.thickness_nm - h).max() < 5.0
    told = iridesce("fit", *names, "--series", "--stack", SOAP, "--gain", "1", "--json", "-o", "x.csv")
    assert told.returncode == 0
    answer = json.loads(told.stdout)
    assert [round(row["thickness_nm"]) for row in answer["spectra"]] == [round(one) for one in series.thickness_nm]
    assert answer["spectra"][2]["file"] == "s2.csv" and (tmp_path / "x.csv").exists()
    (tmp_path / "short.csv").write_text("".join(f"{a:.1f},1\n" for a in NM[5:]))
    failed = iridesce("fit", *names, "short.csv", "--series", "--stack", SOAP)
    assert failed.returncode == 3 and "short.csv" in failed.stderr
    assert iridesce("fit", *names, "--series", "--index", "constant", "--stack", SOAP).returncode == 2


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"spectra": [[1.0, 2.0], [1.0]]}, "one length"),
        ({"spectra": np.ones(NM.size)}, "shape"),
        ({"time_s": [0.0]}, "one time a spectrum"),
        ({"time_s": [0.0, 0.0, 1.0, 2.0]}, "ascending"),
        ({"dark": NM}, "go with a reference"),
        ({"reference": 0.0 * NM}, "above the dark"),
        ({"gain": 0.0}, "gain must be"),
        ({"thickness_range_nm": (10.0, 1.0)}, "thickness_range_nm must be"),
        ({"stack": "air / SiO2 ? / SiO2 ? / Si"}, "one unknown thickness"),
        ({"stack": "air / soap 300 incoherent / air", "layer": 1}, "incoherent"),
        ({"wavelength_nm": None, "spectra": "x.csv"}, "list of paths"),
    ],
)
def test_bad_input(how: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"wavelength_nm": NM, "spectra": counts(np.linspace(500.0, 510.0, 4)), "stack": SOAP, **how}
    with pytest.raises(ValueError, match=words):
        ir.fit_series(given.pop("wavelength_nm"), given.pop("spectra"), given.pop("stack"), **given)
