"""``ir.sweep`` on this machine: points, values, what fails, what is refused before anything runs."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import iridesce as ir

SOAP = "air / soap 320 / air"
NM = "layers.0.thickness_nm"
FILM = "object.bubble.surface.film.thickness_nm"
TINY = ir.Scene.load("soap-bubble").with_value("camera.resolution", [12, 8]).with_value("render.samples", 1)


def test_an_outer_product_is_in_order_and_each_value_is_the_stacks_own() -> None:
    swept = ir.sweep(SOAP, {NM: [100.0, 320.0], "angle_deg": [0.0, 60.0], "space": ["lab"]})
    assert [(point[NM], point["angle_deg"]) for point in swept.points] == [(100, 0), (100, 60), (320, 0), (320, 60)]
    for point, value in zip(swept.points, swept.values, strict=True):
        own = ir.Stack(["air", ir.Layer("soap", point[NM]), "air"]).color(point["angle_deg"], space="lab")
        np.testing.assert_array_equal(value, own)
    assert np.ptp(swept.values[:, 0]) > 10.0, "the points differ"


def test_quantities_and_their_arguments() -> None:
    oxide = ir.Stack(["air", ir.Layer("SiO2", 100.0), "Si"])
    vary = {"wavelength_nm": [500.0, 600.0], "angle_deg": [70.0]}
    for quantity in ("reflectance", "transmittance", "absorptance"):
        wanted = getattr(oxide, quantity)([500.0, 600.0], 70.0)
        np.testing.assert_array_equal(ir.sweep(oxide, vary, quantity=quantity).values, wanted)
    psi, delta = oxide.ellipsometry([500.0, 600.0], 70.0)
    np.testing.assert_array_equal(ir.sweep(oxide, vary, quantity="psi").values, psi)
    np.testing.assert_array_equal(ir.sweep(oxide, vary, quantity="delta").values, delta)
    spectra = ir.sweep(oxide, {"layers.0.medium": ["SiO2", [1.7, 0.0]]}, quantity="reflectance")
    assert spectra.values.shape == (2, 401) and not np.allclose(*spectra.values)
    assert spectra.to_xarray().sel(wavelength_nm=555.0).dims == ("layers.0.medium",)


def test_a_list_of_points_is_taken_as_it_is() -> None:
    points = [{NM: 100.0}, {NM: 200.0, "angle_deg": 45.0}, {"last": 1.5}]
    swept = ir.sweep(SOAP, points)
    assert swept.points == points
    np.testing.assert_array_equal(swept[2], ir.Stack(["air", ir.Layer("soap", 320.0), 1.5]).color())
    assert swept.to_xarray().dims == ("point", "channel")


def test_pictures_are_those_of_render() -> None:
    swept = ir.sweep(TINY, {FILM: [200.0, 400.0, 600.0]}, threads=2)
    for point, picture in zip(swept.points, swept.values, strict=True):
        np.testing.assert_array_equal(picture.xyz, ir.render(TINY.with_value(FILM, point[FILM])).xyz)
    assert np.asarray(swept.values).shape == (3, 8, 12, 3)
    assert swept.to_xarray().dims == (FILM, "y", "x", "channel")
    assert len({picture.xyz.tobytes() for picture in swept.values}) == 3


def test_a_function_receives_the_point() -> None:
    def thickest(stack: ir.Stack) -> float:
        return max(layer.thickness_nm for layer in stack.layers)

    assert ir.sweep(SOAP, {NM: [1.0, 2.0]}, quantity=thickest).values.tolist() == [1.0, 2.0]
    wide = ir.sweep(TINY, {"camera.fov_deg": [20.0, 30.0]}, quantity=lambda scene: scene.to_dict()["camera"]["fov_deg"])
    assert wide.values.tolist() == [20.0, 30.0]
    shapes = ir.sweep(SOAP, {NM: [1.0, 2.0]}, quantity=lambda stack: np.zeros(int(stack.layers[0].thickness_nm)))
    assert [value.shape for value in shapes.values] == [(1,), (2,)]
    with pytest.raises(ValueError, match="one shape"):
        shapes.to_xarray()


def test_what_fails_is_kept_and_does_not_stop_the_rest() -> None:
    def picky(stack: ir.Stack) -> Any:
        if stack.layers[0].thickness_nm == 2.0:
            raise RuntimeError("two")
        return "a text" if stack.layers[0].thickness_nm == 3.0 else 7

    swept = ir.sweep(SOAP, {NM: [1.0, 2.0, 3.0, 4.0]}, quantity=picky)
    assert [point[NM] for point, _ in swept.failed] == [2.0, 3.0]
    assert swept.failed[0][1] == "RuntimeError: two" and "numbers, an array" in swept.failed[1][1]
    assert swept.values[[0, 3]].tolist() == [7.0, 7.0] and np.isnan(swept.values[[1, 2]]).all()
    silver = ir.sweep("air / Ag 20 / 1.5", {"wavelength_nm": [500.0, 9e4]}, quantity="reflectance")
    assert len(silver.failed) == 1 and '"Ag" has data' in silver.failed[0][1]


@pytest.mark.parametrize(
    ("base", "vary", "words"),
    [
        (SOAP, {"layers.1.thickness_nm": [1.0]}, "layers 0 to 0"),
        (SOAP, {NM: [1.0, 2.0, -3.0]}, "layers.0: thickness_nm must .*got -3"),
        (SOAP, {"angle_deg": [0.0, 90.0]}, "angle_deg must be"),
        (SOAP, {"illuminant": ["D65", "D56"]}, "D56"),
        (SOAP, {"angel_deg": [0.0]}, "known: layers.N"),
        (SOAP, [{NM: 1.0}, {NM: "thin"}], "thickness_nm"),
        (SOAP, {}, "empty"),
        (SOAP, {NM: []}, "empty"),
        (SOAP, {NM: 5.0}, "list of values"),
        (SOAP, "angle_deg", "dict of key"),
        (SOAP, [], "empty list"),
        (TINY, {"object.bubble.surface.film.thicknes_nm": [1.0]}, "did you mean"),
        (TINY, {"object.blase.shape": [1.0]}, "blase"),
        (TINY, {FILM: [100.0, -1.0]}, "thickness_nm"),
    ],
)
def test_impossible_keys_and_values_are_named_before_the_first_point(base: Any, vary: Any, words: str) -> None:
    asked: list[Any] = []
    with pytest.raises(ValueError, match=words):
        ir.sweep(base, vary, progress=lambda *told: asked.append(told))
    assert not asked


@pytest.mark.parametrize(
    "given",
    [{"quantity": "colour"}, {"threads": 0}, {"shard": (0, 2)}, {"shard": (3, 2)}, {"shard": "1/2"}, {"client": 7}],
)
def test_other_arguments_are_refused(given: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(given))):
        ir.sweep(SOAP, {NM: [1.0]}, **given)


def test_progress_counts_points_and_an_exception_from_it_stops() -> None:
    told: list[tuple[int, int]] = []
    ir.sweep(SOAP, {NM: [1.0, 2.0, 3.0]}, progress=lambda done, total: told.append((done, total)))
    assert told == [(0, 3), (1, 3), (2, 3), (3, 3)]

    def stop(done: int, total: int) -> None:
        if done == 1:
            raise KeyboardInterrupt

    before = threading.active_count()
    began = time.monotonic()
    large = TINY.with_value("camera.resolution", [512, 512]).with_value("render.samples", 8)
    with pytest.raises(KeyboardInterrupt):
        ir.sweep(
            large.with_value(FILM, 400.0), {"camera.fov_deg": np.linspace(150.0, 170.0, 60)}, progress=stop, threads=2
        )
    assert threading.active_count() == before, "renders that were under way have stopped"
    assert time.monotonic() - began < 20.0


def test_parts_of_a_result() -> None:
    swept = ir.sweep(SOAP, {NM: [1.0, 2.0], "angle_deg": [0.0, 45.0]})
    np.testing.assert_array_equal(swept[{NM: 2.0, "angle_deg": 45.0}], swept.values[3])
    assert [point[NM] for point in swept[{"angle_deg": 45.0}].points] == [1.0, 2.0]
    assert len(swept[1:3]) == 2 and len(list(swept)) == 4
    with pytest.raises(KeyError, match="does not vary"):
        swept[{"angle": 45.0}]
    with pytest.raises(KeyError, match="no point"):
        swept[{NM: 7.0}]
    assert "4 points" in repr(swept) and "varied" in swept._repr_html_()


def test_shards_make_one_whole(tmp_path: Path) -> None:
    vary = {NM: np.linspace(0.0, 500.0, 7)}
    whole = ir.sweep(SOAP, vary, store=tmp_path / "whole")
    parts = [ir.sweep(SOAP, vary, store=tmp_path / "parts", shard=(i, 3)) for i in (1, 2, 3)]
    assert [len(part) for part in parts] == [3, 2, 2]
    told: list[int] = []
    joined = ir.sweep(SOAP, vary, store=tmp_path / "parts", progress=lambda done, total: told.append(done))
    assert told == [7], "nothing is left to make"
    np.testing.assert_array_equal(joined.values, whole.values)
    for path in [*(tmp_path / "whole").rglob("*.npy"), tmp_path / "whole" / "sweep.json"]:
        assert path.read_bytes() == (tmp_path / "parts" / path.relative_to(tmp_path / "whole")).read_bytes()
