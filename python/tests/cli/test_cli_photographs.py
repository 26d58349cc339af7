"""The verbs ``thickness`` and ``calibrate`` as a user meets them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import tifffile

import iridesce as ir
from conftest import Run

FILM = "air / soap ? / air"
KNOWN = ("--camera", "srgb", "--illuminant", "D65", "--range", "0:900")


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """A film of 150 to 550 nm in a linear TIFF of 16 bits."""
    nm = np.linspace(150.0, 550.0, 64) + 20.0 * np.sin(np.linspace(0.0, 3.0, 48))[:, None]
    seen = np.asarray(ir.Stack(["air", ir.Layer("soap", nm), "air"]).color(space="linear-srgb"))
    light = 4.0 * seen + np.random.default_rng(1).normal(0.0, 0.002, seen.shape) + 0.02
    path = tmp_path / "film.tif"
    tifffile.imwrite(path, (65535.0 * np.clip(light, 0.0, 1.0)).astype(np.uint16), photometric="rgb")
    return path


def test_a_map_and_its_words(iridesce: Run, photo: Path, tmp_path: Path) -> None:
    finished = iridesce("thickness", photo.name, "--stack", FILM, *KNOWN, "-o", "map.tif")
    assert finished.returncode == 0, finished.stderr
    assert "sure of the order on 100 %" in finished.stdout and "anchor: color" in finished.stdout
    pages = tifffile.imread(tmp_path / "map.tif")
    found = ir.map_thickness(photo, FILM, camera="srgb", illuminant="D65", thickness_range_nm=(0.0, 900.0))
    np.testing.assert_array_equal(pages[0], found.thickness_nm)


def test_json_and_tie_points(iridesce: Run, photo: Path) -> None:
    finished = iridesce("thickness", photo.name, "--stack", FILM, *KNOWN, "--at", "0,0=150", "--json")
    assert finished.returncode == 0, finished.stderr
    told = json.loads(finished.stdout)
    assert told["anchor"] == "tie point" and told["sure"] > 0.95 and told["calibration"]["camera"] == "srgb"


def test_a_rig_is_calibrated_and_used(iridesce: Run, tmp_path: Path) -> None:
    wavelength = np.arange(380.0, 781.0, 4.0)
    weights = ir.color.camera("nikon-d5100").at(wavelength) * ir.color.illuminant("D65").power(wavelength)[:, None]
    weights = weights / weights.sum(axis=0)

    def seen(*media: str, nm: np.ndarray) -> np.ndarray:
        film = ir.Stack([media[0], ir.Layer(media[1], nm[..., None]), media[2]])
        light = film.reflectance(wavelength) @ weights
        return 6.0 * light + np.random.default_rng(1).normal(0.0, 0.003, light.shape) + 0.03

    y, x = np.mgrid[0:120, 0:120]
    gap = np.asarray(ir.thickness.lens_gap(100.0).at_radius(np.hypot(x - 60.0, y - 58.0) * 8e-3))
    np.save(tmp_path / "rings.npy", seen("N-BK7", "air", "N-BK7", nm=gap))
    nm = np.linspace(150.0, 550.0, 64) + 20.0 * np.sin(np.linspace(0.0, 3.0, 48))[:, None]
    np.save(tmp_path / "film.npy", seen("air", "soap", "air", nm=nm))
    given = ("--stack", "N-BK7 / air ? / N-BK7", "--lens", "100", "--pixel", "8")
    finished = iridesce("calibrate", "rings.npy", *given, "-o", "rig.json", "--json")
    assert finished.returncode == 0, finished.stderr
    assert json.loads(finished.stdout)["center"] == pytest.approx([60.0, 58.0], abs=0.2)
    finished = iridesce(
        "thickness", "film.npy", "--stack", FILM, "--calibration", "rig.json", "--range", "0:900", "--json"
    )
    assert finished.returncode == 0, finished.stderr
    told = json.loads(finished.stdout)
    assert told["sure"] > 0.97 and told["calibration"]["camera"] == "calibration"
    np.testing.assert_allclose(told["thickness_nm"], np.percentile(nm, [5, 50, 95]), rtol=0.02)


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("thickness", "film.tif", "--stack", FILM, "--at", "3=4"), 2, "wanted a pixel and its thickness"),
        (("thickness", "film.tif", "--stack", FILM, "-o", "map.jpg"), 2, "must end in .tif"),
        (("thickness", "film.tif", "--stack", FILM, "--camera", "box"), 3, "nikon-d5100"),
        (("thickness", "none.tif", "--stack", FILM), 3, "none.tif"),
        (("thickness", "film.tif", "--stack", "air / soap ? / SiO2 ? / Si"), 3, "one unknown thickness"),
        (("calibrate", "film.tif", "--stack", FILM, "--lens", "-3", "--pixel", "5"), 3, "--lens must be"),
        (("calibrate", "film.tif", "--stack", FILM, "--lens", "3", "--pixel", "5", "-o", "rig.txt"), 2, "end in .json"),
        (
            ("calibrate", "film.tif", "--stack", FILM, "--lens", "3", "--pixel", "5", "--center", "3"),
            2,
            "wanted a pixel",
        ),
    ],
)
def test_what_is_wrong_is_said(iridesce: Run, photo: Path, arguments: tuple[str, ...], code: int, words: str) -> None:
    finished = iridesce(*arguments)
    assert finished.returncode == code, finished.stderr
    assert words in " ".join(finished.stderr.replace("\u2502", " ").split())
