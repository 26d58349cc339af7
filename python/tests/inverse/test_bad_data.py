"""What is no measurement, through `ir` and the verbs: a clear error, or a verdict that says no; never a sure number."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
import tifffile
from fit_spectra import NM, clean, noisy
from test_photograph import draining, mapped, photograph, swirls

import iridesce as ir
from conftest import Run

SOAP = "air / soap ? / air"
GOOD = 3e4 * noisy(clean(SOAP, 640.0))
BLACK = np.zeros(NM.size)
LAMP = 1e4 * np.exp(-(((NM - 600.0) / 120.0) ** 2))
# 0 in the middle of the spectrum.
GAP = np.where(abs(NM - 600.0) < 20.0, 0.0, LAMP)


@pytest.fixture(autouse=True)
def _no_warnings() -> Iterator[None]:
    """Words of numpy about its own arithmetic are no answer."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.mark.parametrize(
    ("measured", "options", "verdicts"),
    [
        (BLACK, {}, {"none"}),
        (BLACK, {"gain": 1.0}, {"none"}),
        (BLACK + 7.0, {}, {"none"}),
        (BLACK, {"reference": LAMP}, {"none"}),
        (BLACK, {"reference": LAMP, "dark": BLACK + 3.0}, {"none", "doubtful"}),
        (LAMP, {"reference": LAMP}, {"none"}),
        (-GOOD, {}, {"none", "doubtful"}),
        (np.where(GOOD.mean() < GOOD, 1.0, 0.0), {}, {"none", "doubtful", "ambiguous"}),
        (np.minimum(GOOD, np.sort(GOOD)[12]), {}, {"none", "doubtful", "ambiguous"}),
        (np.where(NM == 500.0, 1.0, 0.0), {}, {"none", "doubtful"}),
    ],
)
def test_spectra_that_show_no_film(measured: Any, options: dict[str, Any], verdicts: set[str]) -> None:
    result = ir.fit_thickness(NM, measured, SOAP, thickness_range_nm=(1.0, 3000.0), **options)
    assert result.verdict in verdicts and result.notes
    plt.close(result.plot().figure)


def test_a_reference_that_is_zero_somewhere_leaves_the_other_channels() -> None:
    for reference in (GAP, np.where(GAP > 0.0, GAP, np.nan)):
        result = ir.fit_thickness(NM, LAMP * noisy(clean(SOAP, 640.0)), SOAP, reference=reference)
        assert result.verdict == "clear" and result.best.thickness_nm == pytest.approx(640.0, abs=0.3)
        assert any("no light in the reference" in note for note in result.notes)


def both(first: Any, second: Any, nm: Any = NM, **options: Any) -> list[ir.Measurement]:
    return [
        ir.Measurement("reflectance", nm, values, angle, **options) for values, angle in ((first, 0.0), (second, 45.0))
    ]


@pytest.mark.parametrize(("first", "second", "options"), [(0.0, 0.0, {}), (3.0, 2.0, {}), (0.05, 0.05, {"gain": 1.0})])
def test_even_spectra_together_show_no_film(first: float, second: float, options: dict[str, Any]) -> None:
    """(At every fourth wavelength: where nothing varies more of them tell nothing, and take their time.)"""
    parts = both(BLACK[::4] + first, BLACK[::4] + second, NM[::4], **options)
    result = ir.fit_thickness(measurements=parts, stack=SOAP, thickness_range_nm=(100.0, 1500.0))
    assert result.verdict == "none"


@pytest.mark.parametrize(
    ("parts", "verdicts"),
    [
        # Fringes upside down: as a film of 640 nm they were "clear".
        (both(-GOOD, -3e4 * noisy(clean(SOAP, 640.0, angle_deg=45.0))), {"none", "doubtful"}),
        (both(-GOOD, 3e4 * noisy(clean(SOAP, 640.0, angle_deg=45.0))), {"none", "doubtful"}),
    ],
)
def test_spectra_together_that_show_no_film(parts: list[ir.Measurement], verdicts: set[str]) -> None:
    result = ir.fit_thickness(measurements=parts, stack=SOAP, thickness_range_nm=(100.0, 1500.0))
    assert result.verdict in verdicts


def test_a_measurement_that_shows_nothing_is_told_beside_others() -> None:
    parts = both(GOOD, BLACK)
    result = ir.fit_thickness(measurements=parts, stack=SOAP, thickness_range_nm=(300.0, 900.0))
    assert "reflectance, 45 degrees: it does not vary with wavelength: it shows no film" in result.notes
    assert abs(result.best.thickness_nm - 640.0) < 1.0


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (lambda: both(GOOD * 1e200, GOOD), "reflectance, 0 degrees reach .*e.203, whose squares no number holds"),
        (lambda: both(GOOD, GOOD * 1e-200), "reflectance, 45 degrees reach .*e-197, whose squares no number holds"),
        (lambda: both(GOOD, BLACK * np.nan), "reflectance, 45 degrees has 0 usable points"),
        (lambda: [ir.Measurement("reflectance", [500.0], [1.0])], "has 1 usable points"),
    ],
)
def test_measurements_that_are_none_are_refused_by_name(parts: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ir.fit_thickness(measurements=parts(), stack=SOAP)


FILMS = 2e4 * np.stack([noisy(clean(SOAP, h), seed=int(h)) for h in np.linspace(1400.0, 1100.0, 13).tolist()])
ROWS = np.arange(13)[:, None]


@pytest.mark.parametrize(
    ("spectra", "words"),
    [
        ([*FILMS[:2], FILMS[2][:-3]], "a value at each of 340 wavelengths, got 337 in spectrum 2"),
        (FILMS[:, :-2], "the shape .n, 340. for 340 wavelengths"),
        (FILMS[0], "the shape .n, 340."),
        ([], "the shape .n, 340."),
        (FILMS[:0], "the shape .n, 340."),
    ],
)
def test_series_of_unequal_lengths_are_refused(spectra: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ir.fit_series(NM, spectra, SOAP)


@pytest.mark.parametrize("empty", [0.0, 5.0, np.nan, np.inf])
@pytest.mark.parametrize("options", [{}, {"reference": 2e4 + BLACK}, {"reference": np.where(GAP > 0.0, 2e4, 0.0)}])
def test_spectra_of_a_series_that_show_nothing_are_none(empty: float, options: dict[str, Any]) -> None:
    series = ir.fit_series(NM, np.where(ROWS == 4, empty, FILMS), SOAP, **options)
    assert series.verdict[4] == "none" and np.isnan(series.thickness_nm[4])
    assert (np.delete(series.verdict, 4) == "clear").all()
    every = ir.fit_series(NM, np.where(ROWS >= 0, empty, FILMS), SOAP, **options)
    assert (every.verdict == "none").all() and every.notes
    assert "no film" in every._repr_html_()
    plt.close("all")


# --- photographs


def test_pictures_that_are_full_on_most_pixels() -> None:
    """A channel that is full on half of the picture and more was none: 90 % full, 4 % of the pixels were sure and wrong."""
    nm = draining()
    picture = photograph(nm)
    half = mapped(np.minimum(picture, 0.35))
    assert sum("is full at 0.35" in note for note in half.notes) == 3
    sure = half.confidence > 0.9
    assert half.sure > 0.3 and (np.abs(half.thickness_nm - nm)[sure] < 103.0).all()
    for level in (0.24, 0.2, 0.15):
        found = mapped(np.minimum(picture, level))
        assert found.sure == 0.0 and any("of the picture is full" in note for note in found.notes)


def test_a_picture_of_which_no_pixel_is_whole_is_not_sure() -> None:
    """Some channel of each is full: how much the model misses nobody knows, and was taken to be without end."""
    for options in ({}, {"clip": 0.3}):
        found = mapped(np.minimum(photograph(swirls()), 0.3), **options)
        assert found.sure == 0.0 and found.to_dict()["calibration"]["misfit"] is None
        assert any("no order is sure" in note for note in found.notes)


def test_darks_and_flats_of_any_unit() -> None:
    nm = draining()
    picture = 4000.0 * photograph(nm)
    dark = np.full_like(picture, 300.0)
    found = mapped(picture + dark, dark=dark)
    assert found.sure > 0.9 and np.median(np.abs(found.thickness_nm - nm)) < 5.0
    flat = np.full_like(picture, 5000.0)
    flat[10:20, 30:40] = 0.0
    found = mapped(picture + dark, dark=dark, flat=flat)
    assert np.isnan(found.thickness_nm[10:20, 30:40]).all() and found.sure > 0.9
    assert "flat is not brighter than dark at 100 pixels: they are left out" in found.notes
    for flat in (0.0 * picture, dark - 1.0):
        with pytest.raises(ValueError, match="flat must be brighter than dark"):
            mapped(picture + dark, dark=dark, flat=flat)
    with pytest.raises(ValueError, match="holds no number at all that is finite and below"):
        mapped(picture * 1e200)
    assert "thickness no nm" in str(mapped(0.0 * picture))


# --- verbs


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    spectra = {
        "good": GOOD, "next": 3e4 * noisy(clean(SOAP, 630.0)), "black": BLACK, "gap": GAP, "short": GOOD[:-9],
        "nan": np.full(NM.size, np.nan), "one": GOOD[:1],
    }  # fmt: skip
    for name, values in spectra.items():
        rows = zip(NM, values, strict=False)
        (tmp_path / f"{name}.csv").write_text("".join(f"{nm:.1f};{value:.3f}\n" for nm, value in rows))
    picture = photograph(draining())
    pictures = {"film": picture, "dark": 0.0 * picture, "one": picture[:1, :1], "even": 0.3 + 0.0 * picture}
    for name, light in pictures.items():
        sixteen = (np.clip(light, 0.0, 1.0) * 65535.0).astype(np.uint16)
        tifffile.imwrite(tmp_path / f"{name}.tif", sixteen, photometric="rgb")
    return tmp_path


THREE = "air / SiO2 ? / TiO2 ? / SiO2 ? / Si"
CAMERA = ["--stack", "air / 1.33 ? / air", "--camera", "nikon-d5100", "--illuminant", "D65"]
RINGS = ["--stack", "N-BK7 / air ? / N-BK7", "--lens", "1000", "--pixel", "40"]
BLUE = ["recipes", "lab 45 50 -30", "--media", "SiO2", "--substrate", "Si"]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["fit", "black.csv", "--stack", SOAP], 0, "none, 0 plausible solutions"),
        (["fit", "nan.csv", "--stack", SOAP], 3, "holds no number"),
        (["fit", "one.csv", "--stack", SOAP], 3, "no table of two or more columns"),
        (["fit", "good.csv", "--stack", "air / Si"], 3, "no layer whose thickness could be found"),
        (["fit", "good.csv", "--stack", THREE], 3, "3 unknown thicknesses"),
        (["fit", "good.csv", "--stack", "air / soop ? / air"], 3, 'did you mean "soap"'),
        (["fit", "good.csv", "--stack", SOAP, "--reference", "black.csv"], 3, "check dark and reference"),
        (["fit", "good.csv", "--stack", SOAP, "--reference", "short.csv"], 3, "short.csv: its wavelengths are not"),
        (["fit", "good.csv", "black.csv", "--series", "--stack", SOAP], 0, "black.csv: none, no film"),
        (["fit", "black.csv", "black.csv", "--series", "--stack", SOAP], 0, "no spectrum varies with wavelength"),
        (["fit", "good.csv", "short.csv", "--series", "--stack", SOAP], 3, "short.csv: its wavelengths are not"),
        (["fit", "good.csv", "one.csv", "--series", "--stack", SOAP], 3, "one.csv: holds no table"),
        (["fit", "good.csv", "next.csv", "--series", "--stack", THREE], 3, "a series has one unknown thickness"),
        (["thickness", "dark.tif", *CAMERA], 0, "thickness no nm"),
        (["thickness", "even.tif", *CAMERA], 0, "all pixels have one colour"),
        (["thickness", "one.tif", *CAMERA], 3, "at least 8 x 8 pixels, got 1 x 1"),
        (["thickness", "film.tif", *CAMERA, "--flat", "dark.tif"], 3, "flat must be brighter than dark"),
        (["thickness", "film.tif", "--stack", THREE], 3, "one unknown thickness"),
        (["thickness", "film.tif", *CAMERA[:2], "--camera", "box"], 3, "nikon-d5100"),
        (["thickness", "film.tif", *CAMERA[:2], "--illuminant", "D66"], 3, 'unknown illuminant "D66"'),
        (["calibrate", "dark.tif", *RINGS], 3, "it shows no film"),
        (["calibrate", "even.tif", *RINGS], 3, "it shows no film"),
        (["calibrate", "one.tif", *RINGS], 3, "at least 8 x 8 pixels"),
        (["calibrate", "film.tif", "--stack", THREE, *RINGS[2:]], 3, "one unknown thickness, got 3"),
        (["recipes", "lab nan 50 -30", *BLUE[2:]], 3, "three finite numbers"),
        (["recipes", "lab 0 0 0", *BLUE[2:]], 0, "not reachable"),
        ([*BLUE, "--illuminant", "D66"], 3, 'unknown illuminant "D66"'),
        ([*BLUE[:2], "--media", "SiO3", *BLUE[4:]], 3, 'did you mean "SiO2"'),
    ],
)
def test_verbs_say_no(iridesce: Run, folder: Path, words: list[str], code: int, said: str) -> None:
    done = iridesce(*words)
    assert done.returncode == code and said in done.stdout + done.stderr
    assert "Warning" not in done.stderr
