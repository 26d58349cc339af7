"""The committed reference suite is whole, small, and says what the core says."""

from __future__ import annotations

import csv
import hashlib
import json

import numpy as np
import pytest

import iridesce as ir
from conftest import ROOT
from iridesce.exchange import exr, suite

FOLDER = ROOT / "reference"
INDEX = json.loads((FOLDER / "index.json").read_text())
BOARD = json.loads((FOLDER / "board.json").read_text())


def test_the_index_tells_every_file() -> None:
    there = {
        path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*") if path.is_file() and path.parent != FOLDER
    }
    assert there == set(INDEX["sha256"])
    for name, digest in INDEX["sha256"].items():
        assert hashlib.sha256((FOLDER / name).read_bytes()).hexdigest() == digest, name
    assert sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()) <= 8 * 2**20
    assert INDEX["licence"] == "CC0-1.0"


@pytest.mark.parametrize("name", suite.CHARTS)
def test_a_chart_is_what_the_core_computes(name: str) -> None:
    entry, chart = INDEX["charts"][name], suite.CHARTS[name]
    assert (entry["stack"], entry["quantity"], entry["illuminant"]) == (chart.stack, chart.quantity, chart.illuminant)
    channels, facts = exr.read_exr((FOLDER / "charts" / f"{name}.exr").read_bytes(), name)
    seen = np.stack([channels[letter] for letter in "XYZ"], axis=-1)
    assert np.allclose(seen, chart.truth(), rtol=1e-6, atol=1e-9) and facts["iridesce:stack"] == chart.stack
    rows = list(csv.DictReader((FOLDER / "charts" / f"{name}.csv").open()))
    assert len(rows) == 168 and float(rows[24]["angle_deg"]) == 15.0 and float(rows[1]["thickness_nm"]) == 100.0
    table = np.array([[float(row[letter]) for letter in "XYZ"] for row in rows]).reshape(7, 24, 3)
    assert np.allclose(table, chart.truth(), rtol=1e-5, atol=1e-9)
    assert ir.validate(table, name).delta_e["max"] < 0.01


@pytest.mark.parametrize("name", ["C1", "C2", "C3", "C4", "C5", "C6"])
def test_a_table_and_the_spectra_agree_with_the_core(name: str) -> None:
    chart = suite.CHARTS[name]
    report = ir.validate(FOLDER / INDEX["charts"][name]["table"], name)
    assert report.delta_e["mean"] < 0.1 and report.cause is None
    row = next(
        row
        for row in csv.DictReader((FOLDER / "charts" / f"{name}.csv").open())
        if float(row["thickness_nm"]) == 300.0 and float(row["angle_deg"]) == 45.0
    )
    stack = chart.film().at(300.0)
    ask = stack.reflectance if chart.quantity == "reflectance" else stack.transmittance
    assert float(row["550nm"]) == pytest.approx(ask(550.0, 45.0), rel=1e-4)


def test_the_board_has_five_renderers_each_with_version_date_and_command() -> None:
    assert len({row["renderer"] for row in BOARD["rows"]}) >= 5
    page = (ROOT / "docs" / "evidence" / "renderers.md").read_text()
    for row in BOARD["rows"]:
        assert row["version"] and row["date"].startswith("20") and row["command"]
        assert row.get("charts") or row.get("scenes")
        for found in row.get("scenes", {}).values():
            assert f"{found['mean']:.2f} | {found['p95']:.2f}" in page
        for name, found in row.get("charts", {}).items():
            if "predicted_mean" in found:
                assert abs(found["mean"] - found["predicted_mean"]) <= 0.5, (row["renderer"], name)
            assert f"{found['mean']:.2f} / {found['max']:.1f}" in page


def test_the_gltf_beside_a_scene_holds_its_geometry() -> None:
    for name, entry in INDEX["scenes"].items():
        scene = ir.Scene.load(FOLDER / entry["scene"]).to_dict()
        again, _ = ir.import_scene(FOLDER / entry["gltf"])
        tree = again.to_dict()
        assert [item["name"] for item in tree["object"]] == [item["name"] for item in scene["object"]], name
        metres = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}[scene["unit"]]
        assert np.allclose(tree["camera"]["position"], np.array(scene["camera"]["position"]) * metres, atol=1e-6)
        for one, other in zip(scene["object"], tree["object"], strict=True):
            ((kind, keys),) = one["shape"].items()
            if kind in ("sphere", "rectangle", "disk"):
                found = other["shape"][kind]
                assert np.allclose(found["center"], np.array(keys["center"]) * metres, atol=1e-6), (name, one["name"])


def test_pictures_of_scenes_are_as_large_as_told() -> None:
    for name, entry in INDEX["scenes"].items():
        channels, _ = exr.read_exr((FOLDER / entry["picture"]).read_bytes(), name)
        assert set(channels) == {"X", "Y", "Z", "sigma_Y"} and channels["Y"].shape == (512, 512)
        scene = ir.Scene.load(FOLDER / entry["scene"])
        assert scene.to_dict()["camera"] == entry["camera"]
        # Drawn anew, coarsely: the same picture within its noise.
        again = ir.render(scene, samples=2, seed=9, size=(64, 64)).xyz[..., 1]
        stored = channels["Y"].reshape(64, 8, 64, 8).mean(axis=(1, 3))
        assert abs(float(again.mean()) - float(stored.mean())) < 0.05 * max(float(stored.mean()), 1e-3)


def test_the_flat_quads_show_chart_1() -> None:
    """S1 is C1 as a picture: each quad at its angle, thickness upwards, no quad in another's mirror."""
    channels, _ = exr.read_exr((FOLDER / "scenes" / "S1.exr").read_bytes(), "S1")
    xyz = np.stack([channels[letter] for letter in "XYZ"], axis=-1).astype(np.float64)
    seen, true = [], []
    for number, angle in enumerate((0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0)):
        column = round((2.0 * (number - 3) + 7.0) / 14.0 * 512)
        for row in range(30, 482, 40):
            height = 7.0 - (row + 0.5) * 14.0 / 512
            thickness = 50.0 + 1150.0 * (height + 6.5) / 13.0
            seen.append(xyz[row, column - 8 : column + 8].mean(axis=0))
            true.append(ir.Stack(["air", ir.Layer("soap", thickness), "air"]).color(angle_deg=angle))
    scale = 1.0 / np.array(true)[:, 1].max()
    lab = [ir.color.convert(np.array(side) * scale, "xyz", "lab") for side in (seen, true)]
    assert float(ir.color.delta_e(*lab).mean()) < 0.05 and float(ir.color.delta_e(*lab).max()) < 0.2
    assert float(ir.color.delta_e(lab[0], np.roll(lab[1], 1, axis=0)).mean()) > 5.0, "any picture would pass"


def test_the_rough_coin_is_lit_by_the_map_beside_it() -> None:
    """S5 under the studio map that other renderers take, against the stored picture under the built-in studio."""
    tree = ir.Scene.load(FOLDER / INDEX["scenes"]["S5"]["scene"]).to_dict()
    assert tree["object"][0]["surface"]["coating"]["roughness"] == 0.35
    tree["light"] = [{"environment": {"map": str(FOLDER / "scenes" / "studio.exr")}}]
    seen = ir.render(ir.Scene.load(tree), samples=64, seed=5, size=(32, 32)).xyz
    channels, _ = exr.read_exr((FOLDER / "scenes" / "S5.exr").read_bytes(), "S5")
    stored = np.stack([channels[letter].reshape(32, 16, 32, 16).mean(axis=(1, 3)) for letter in "XYZ"], axis=-1)
    # 64 rays a pixel of 16 x 16 stored ones: noise of some 5 %, of its mean over the coin some 0.3 %.
    coin = stored[..., 1] > 0.05
    assert coin.sum() > 300
    assert np.allclose(seen[coin].mean(axis=0), stored[coin].mean(axis=0), rtol=0.01)
    # Without facets the coin mirrors the studio's windows sharply.
    tree["object"][0]["surface"]["coating"]["roughness"] = 0.0
    smooth = ir.render(ir.Scene.load(tree), samples=64, seed=5, size=(32, 32)).xyz
    assert np.abs(smooth - stored)[coin].mean() > 3.0 * np.abs(seen - stored)[coin].mean()
