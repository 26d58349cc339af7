"""Calibration: a lens of known radius gives the rig's channels, and films measured with them have the right scale."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from test_photograph import FILM, NM, draining, response, right

import iridesce as ir

Floats = npt.NDArray[np.float64]
GAP = "N-BK7 / air ? / N-BK7"
RADIUS_MM, PIXEL_UM = 100.0, 6.0
# A rig whose channels have no name: measured curves bent, under a lamp of its own, badly balanced.
WEIGHTS = response("sigma-sd-merrill", "A") * (0.7 + 0.3 * np.sin(NM / 40.0))[:, None] * np.array([1.3, 1.0, 0.6])
HAZE = np.array([0.05, 0.06, 0.08])


def seen(media: list[Any], nm: Floats, seed: int) -> Floats:
    """The rig's picture of a film."""
    grid = np.linspace(nm.min(), nm.max() + 1.0, 2500)
    curves = ir.Stack([media[0], ir.Layer(media[1], grid[:, None]), media[2]]).reflectance(NM) @ WEIGHTS
    light = 8.0 * np.stack([np.interp(nm, grid, curve) for curve in curves.T], axis=-1) + HAZE
    return np.asarray(light + 0.004 * np.random.default_rng(seed).normal(size=light.shape))


@pytest.fixture(scope="module")
def rings() -> tuple[Floats, Floats]:
    """Newton's rings about (97.3, 82.6), and the gap."""
    y, x = np.mgrid[0:160, 0:200]
    gap = ir.thickness.lens_gap(RADIUS_MM).at_radius(np.hypot(x - 97.3, y - 82.6) * PIXEL_UM * 1e-3)
    return seen(["N-BK7", "air", "N-BK7"], np.asarray(gap), 1), np.asarray(gap)


@pytest.fixture(scope="module")
def rig(rings: tuple[Floats, Floats]) -> ir.CameraCalibration:
    lens = ir.thickness.lens_gap(RADIUS_MM)
    return ir.CameraCalibration.from_known(rings[0], GAP, lens, pixel_um=PIXEL_UM)


def test_the_centre_of_the_rings_is_found(rig: ir.CameraCalibration) -> None:
    assert rig.center is not None
    assert rig.center == pytest.approx((97.3, 82.6), abs=0.1)
    assert abs(rig.gap_nm) < 3.0
    assert rig.misfit < 0.02


def test_the_channels_are_those_of_the_rig(rig: ir.CameraCalibration) -> None:
    truth = np.stack([np.interp(rig.wavelength_nm, NM, one) for one in WEIGHTS.T], axis=1)
    truth *= rig.response.sum() / truth.sum()
    mean = [(curves * rig.wavelength_nm[:, None]).sum(axis=0) / curves.sum(axis=0) for curves in (rig.response, truth)]
    np.testing.assert_allclose(mean[0], mean[1], atol=1.5)  # nm
    np.testing.assert_allclose(rig.response.sum(axis=0), truth.sum(axis=0), rtol=0.02)


def test_a_calibration_is_shown(rig: ir.CameraCalibration) -> None:
    import matplotlib.pyplot as plt

    ax = rig.plot(title="a rig", theme="dark")
    curves = [line for line in ax.get_lines() if line.get_gid() == "channel"]
    for line, channel in zip(curves, rig.response.T, strict=True):
        np.testing.assert_allclose(np.asarray(line.get_ydata()), channel / rig.response.max())
    assert GAP in rig._repr_html_() and f"gap {rig.gap_nm:.1f} nm" in str(rig)
    plt.close(ax.figure)


def test_a_film_in_the_same_rig_has_the_right_scale(rig: ir.CameraCalibration) -> None:
    nm = draining()
    found = ir.map_thickness(seen(["air", 1.33, "air"], nm, 2), FILM, calibration=rig, thickness_range_nm=(0.0, 1200.0))
    assert right(found, nm).mean() > 0.98
    assert abs(np.nanmedian(found.thickness_nm / nm) - 1.0) < 0.003
    assert found.calibration["camera"] == "calibration"
    low, high = found.scale_interval
    assert 0.985 < low < 1.0 < high < 1.015


def test_a_map_of_thickness_will_do_and_a_file_keeps_it(rings: tuple[Floats, Floats], tmp_path: Path) -> None:
    made = ir.CameraCalibration.from_known(rings[0], GAP, rings[1])
    made.save(tmp_path / "rig.json")
    read = ir.CameraCalibration.load(tmp_path / "rig.json")
    for name in ("haze", "misfit", "gap_nm", "center", "stack", "made"):
        assert getattr(read, name) == getattr(made, name)
    np.testing.assert_array_equal(read.response, made.response)
    nm = draining()
    light = seen(["air", 1.33, "air"], nm, 2)
    options: dict[str, Any] = {"thickness_range_nm": (0.0, 1200.0)}
    one = ir.map_thickness(light, FILM, calibration=tmp_path / "rig.json", **options)
    other = ir.map_thickness(light, FILM, calibration=made, **options)
    assert one.thickness_nm.tobytes() == other.thickness_nm.tobytes()


def test_a_contact_gap_is_found(rings: tuple[Floats, Floats]) -> None:
    raised = seen(["N-BK7", "air", "N-BK7"], rings[1] + 25.0, 3)
    lens = ir.thickness.lens_gap(RADIUS_MM)
    found = ir.CameraCalibration.from_known(raised, GAP, lens, pixel_um=PIXEL_UM, center=(97.3, 82.6))
    assert found.gap_nm == pytest.approx(25.0, abs=5.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"thickness_nm": ir.thickness.lens_gap(100.0)}, "pixel_um is needed"),
        ({"thickness_nm": ir.thickness.lens_gap(100.0), "pixel_um": -1.0}, "pixel_um must be"),
        ({"thickness_nm": ir.thickness.lens_gap(100.0), "pixel_um": 6.0, "center": 3}, "center must be"),
        ({"thickness_nm": np.zeros((3, 3))}, "a value for each pixel"),
        ({"thickness_nm": np.full((160, 200), -5.0)}, "must be >= 0"),
        ({"thickness_nm": np.full((160, 200), 300.0)}, "spans 0 nm"),
        ({"thickness_nm": np.random.default_rng(1).uniform(0.0, 3000.0, (160, 200))}, "does not show this film"),
        ({"image": np.full((160, 200, 3), 0.3)}, "one value throughout"),
        ({"stack": "N-BK7 / air ? / SiO2 ? / N-BK7"}, "one unknown thickness"),
        ({"mask": np.ones((160, 200), dtype=bool)}, "leave no pixel"),
    ],
)
def test_what_cannot_calibrate_is_refused(rings: tuple[Floats, Floats], change: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"stack": GAP, "thickness_nm": rings[1], **change}
    with pytest.raises(ValueError, match=words):
        ir.CameraCalibration.from_known(given.pop("image", rings[0]), **given)


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"format": "iridesce camera calibration"}', "{" * 9000])
def test_what_is_no_calibration_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "rig.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"rig\.json: "):
        ir.CameraCalibration.load(path)


def test_a_damaged_calibration_is_refused(rig: ir.CameraCalibration, tmp_path: Path) -> None:
    path = tmp_path / "rig.json"
    rig.save(path)
    tree = json.loads(path.read_text())
    for key, value in (("response", [[0, 0, 0]] * 39), ("wavelength_nm", tree["wavelength_nm"][::-1]), ("haze", [1])):
        path.write_text(json.dumps({**tree, key: value}))
        with pytest.raises(ValueError, match=re.escape("rig.json")):
            ir.CameraCalibration.load(path)


def test_channels_that_a_colour_matrix_mixed_are_signed(rig: ir.CameraCalibration, tmp_path: Path) -> None:
    """sRGB sees some wavelengths with a negative weight; a raw picture's channels none."""
    assert rig.response.min() >= 0.0
    gap = np.linspace(0.0, 2500.0, 200) + np.zeros((20, 1))
    shown = ir.Stack(["N-BK7", ir.Layer("air", gap), "N-BK7"]).color(space="linear-srgb")
    mixed = ir.CameraCalibration.from_known(shown, GAP, gap)
    assert mixed.misfit < 0.02 and mixed.response[:, 0].min() < -0.2 * mixed.response[:, 0].max()
    mixed.save(tmp_path / "rig.json")
    nm = draining()
    picture = np.asarray(ir.Stack(["air", ir.Layer("soap", nm), "air"]).color(space="linear-srgb"))
    picture = picture + 4e-4 * np.random.default_rng(4).normal(size=picture.shape)
    found = ir.map_thickness(picture, FILM, calibration=tmp_path / "rig.json", thickness_range_nm=(0.0, 1200.0))
    assert right(found, nm).mean() > 0.98
    assert abs(np.nanmedian(found.thickness_nm / nm) - 1.0) < 0.005
