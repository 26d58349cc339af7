"""Colour tables: the error they state, their files, their refusals."""

from __future__ import annotations

import base64
import os
import signal
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import iridesce as ir

AIR_FILM = ir.Stack(["air", ir.Layer("soap", thickness_nm=0.0), "air"])


@pytest.fixture(scope="module")
def soap() -> ir.ColorTable:
    return ir.ColorTable(
        AIR_FILM, (0.0, 900.0), (0.0, 70.0), illuminant=["D65", "A"], quantity=["reflectance", "transmittance"]
    )


def with_varying(stack: ir.Stack, layer: int, thickness_nm: Any) -> ir.Stack:
    layers = list(stack.layers)
    layers[layer] = ir.Layer(layers[layer].medium, thickness_nm, layers[layer].coherent)
    return ir.Stack([stack.first, *layers, stack.last])


STACKS: dict[str, tuple[ir.Stack, dict[str, Any]]] = {
    "soap": (AIR_FILM, {"thickness_nm": (0.0, 2000.0)}),
    "soap s": (AIR_FILM, {"thickness_nm": (0.0, 1000.0), "polarization": "s", "angle_deg": (0.0, 60.0)}),
    "through soap": (AIR_FILM, {"thickness_nm": (0.0, 1000.0), "quantity": "transmittance"}),
    "oxide on silicon": (ir.Stack(["air", ir.Layer("SiO2", 0.0), "Si"]), {"thickness_nm": (0.0, 700.0)}),
    "titanium": (ir.Stack(["air", ir.Layer("TiO2", 0.0), "Ti"]), {"thickness_nm": (0.0, 300.0), "illuminant": "A"}),
    "silver": (
        ir.Stack(["air", ir.Layer("Ag", 0.0), 1.52]),
        {"thickness_nm": (0.0, 120.0), "quantity": "absorptance", "observer": "cie1964"},
    ),
    "laser": (AIR_FILM, {"thickness_nm": (100.0, 1500.0), "illuminant": "laser:632.99", "angle_deg": (10.0, 50.0)}),
    "three layers": (
        ir.Stack([1.33, ir.Layer("TiO2", 60.0), ir.Layer("SiO2", 0.0), ir.Layer("TiO2", 60.0), "N-BK7"]),
        {"thickness_nm": (20.0, 500.0), "layer": 1, "angle_deg": (0.0, 50.0)},
    ),
    "under glass": (
        ir.Stack(["air", ir.Layer("N-BK7", 1e6, coherent=False), ir.Layer("MgF2", 0.0), "air"]),
        {"thickness_nm": (0.0, 400.0), "layer": 1, "angle_deg": 30.0},
    ),
    # Through the critical angle of the gap, 41 degrees.
    "frustrated": (
        ir.Stack([1.52, ir.Layer("air", 0.0), 1.52]),
        {"thickness_nm": (0.0, 300.0), "angle_deg": (20.0, 60.0)},
    ),
    "rough": (AIR_FILM, {"thickness_nm": (0.0, 1000.0), "max_delta_e": 2.0}),
}


@pytest.mark.parametrize("name", STACKS)
def test_stated_error_holds_at_fresh_points(name: str) -> None:
    stack, how = STACKS[name]
    table = ir.ColorTable(stack, **how)
    assert table.max_delta_e <= how.get("max_delta_e", 0.1)
    random = np.random.default_rng(20261123)
    t = random.uniform(*table.thickness_nm, 6000)
    angle = np.repeat(random.uniform(*table.angle_deg, 60), 100)
    # Corners too, and the thin end, where colours are dark and errors show.
    t[:4] = [*table.thickness_nm, *table.thickness_nm]
    angle[:4] = [table.angle_deg[0]] * 2 + [table.angle_deg[1]] * 2
    t[-600:] = table.thickness_nm[0] + (t[-600:] - table.thickness_nm[0]) * 0.02
    exact = with_varying(stack, table.layer, t).color(
        angle,
        how.get("polarization", "unpolarized"),
        table.illuminants[0],
        table.observer,
        "lab",
        table.quantities[0],
    )
    found = ir.color.delta_e(table.color(t, angle, "lab"), exact)
    assert found.max() <= table.max_delta_e
    assert found.mean() <= table.max_delta_e
    # And what is stated is not just said: errors of that order are there.
    assert found.max() >= 0.02 * table.max_delta_e


def test_points_broadcast_and_spaces_agree(soap: ir.ColorTable) -> None:
    t, angle = np.linspace(0.0, 900.0, 7)[:, None], np.array([0.0, 33.0, 70.0])
    xyz = soap.color(t, angle)
    assert xyz.shape == (7, 3, 3) and xyz.dtype == np.float64
    assert np.array_equal(xyz, soap(t, angle))
    for row in range(7):
        for column in range(3):
            alone = soap.color(float(t[row, 0]), float(angle[column]))
            assert alone.shape == (3,)
            assert np.array_equal(alone, xyz[row, column])
    white = ir.color.illuminant("A").white()
    under_a = soap.color(t, angle, illuminant="A", quantity="transmittance")
    for space in ("lab", "srgb", "oklab", "xyy"):
        wanted = ir.color.convert(under_a, "xyz", space, white=white)
        found = soap.color(t, angle, space, illuminant="A", quantity="transmittance")
        assert np.allclose(found, wanted, rtol=0.0, atol=1e-9), space
    adapted = soap.color(t, angle, "srgb", illuminant="A", adaptation="bradford")
    assert np.allclose(
        adapted,
        ir.color.convert(soap.color(t, angle, illuminant="A"), "xyz", "srgb", white=white, adaptation="bradford"),
        atol=1e-9,
    )
    inside = soap.color(t, angle, "srgb", gamut="clip")
    assert np.array_equal(inside, np.clip(soap.color(t, angle, "srgb"), 0.0, 1.0))
    assert np.array_equal(soap.color(t[:, 0]), soap.color(t[:, 0], 0.0))  # None is the least angle


def test_out_and_threads(soap: ir.ColorTable) -> None:
    t = np.random.default_rng(3).uniform(0.0, 900.0, 30_000)
    angle = t[::-1] / 900.0 * 70.0
    wanted = soap.color(t, angle)
    out = np.full((30_000, 3), np.nan)
    assert soap.color(t, angle, out=out, threads=2) is out
    assert np.array_equal(out, wanted)
    assert np.array_equal(soap.color(t[::2], angle[::2].astype(np.float64), threads=1), wanted[::2])
    frozen = t.copy()
    frozen.flags.writeable = False
    assert np.array_equal(soap.color(frozen, angle), wanted)


def test_ranges_come_from_the_stack_where_they_are_not_given() -> None:
    film = ir.Stack(["air", ir.Layer(1.4, thickness_nm=np.linspace(50.0, 300.0, 5)), 1.5])
    assert ir.ColorTable(film, angle_deg=0.0).thickness_nm == (50.0, 300.0)
    assert ir.ColorTable(AIR_FILM, angle_deg=0.0).thickness_nm == (0.0, 2000.0)
    two = ir.Stack(["air", ir.Layer(2.3, 50.0), ir.Layer(1.4, thickness_nm=[10.0, 90.0]), 1.5])
    table = ir.ColorTable(two, angle_deg=[5.0, 25.0, 15.0])
    assert (table.layer, table.thickness_nm, table.angle_deg) == (1, (10.0, 90.0), (5.0, 25.0))
    assert table.stack == "air / 2.3 50 / 1.4 10..90 / 1.5"
    assert "air / 2.3 50 / 1.4 10..90 / 1.5" in repr(table) and "CIEDE2000" in repr(table)


# --- files


def test_a_file_gives_the_same_table_and_the_same_bytes(soap: ir.ColorTable, tmp_path: Path) -> None:
    first, second = tmp_path / "a.exr", tmp_path / "b.exr"
    soap.save(first)
    again = ir.ColorTable.load(first)
    again.save(second)
    assert first.read_bytes() == second.read_bytes()
    t, angle = np.linspace(0.0, 900.0, 500), np.linspace(0.0, 70.0, 500)
    for light in soap.illuminants:
        for quantity in soap.quantities:
            ours = soap.color(t, angle, illuminant=light, quantity=quantity)
            assert np.array_equal(ours, again.color(t, angle, illuminant=light, quantity=quantity))
            assert soap.error(light, quantity) == again.error(light, quantity)
    for name in (
        "max_delta_e",
        "mean_delta_e",
        "thickness_nm",
        "angle_deg",
        "stack",
        "observer",
        "polarization",
        "nodes",
    ):
        assert getattr(soap, name) == getattr(again, name), name
    assert soap.illuminants == again.illuminants == ("D65", "A")
    assert repr(soap) == repr(again)


def test_names_beyond_ascii_survive_a_file(tmp_path: Path) -> None:
    lamp = tmp_path / "gl\u00fchlampe \u4e00.csv"
    lamp.write_text("wavelength_nm,power\n" + "".join(f"{nm},{nm - 300}\n" for nm in range(360, 831, 5)))
    table = ir.ColorTable(AIR_FILM, (0.0, 200.0), 0.0, illuminant=str(lamp))
    table.save(tmp_path / "t.exr")
    again = ir.ColorTable.load(tmp_path / "t.exr")
    assert again.illuminants == table.illuminants
    assert "\u4e00" in again.illuminants[0]


def test_damaged_and_foreign_files_are_refused(soap: ir.ColorTable, tmp_path: Path) -> None:
    file = tmp_path / "t.exr"
    soap.save(file)
    whole = file.read_bytes()
    broken = tmp_path / "broken.exr"
    for length in (0, 4, 300, len(whole) // 3, len(whole) - 1):
        broken.write_bytes(whole[:length])
        with pytest.raises(ValueError, match=r"broken\.exr"):
            ir.ColorTable.load(broken)
    # Whatever is changed in it, the answer is a table or a ValueError.
    random = np.random.default_rng(5)
    refused = 0
    for _ in range(120):
        bytes_ = bytearray(whole)
        for place in random.integers(0, 4000, 3):
            bytes_[place] = random.integers(0, 256)
        broken.write_bytes(bytes_)
        try:
            colors = ir.ColorTable.load(broken)
        except ValueError:
            refused += 1
        else:
            assert np.isfinite(colors.color(colors.thickness_nm[0])).all()
    assert refused > 60
    ir.Image(np.full((4, 4, 3), 0.5)).save(tmp_path / "picture.exr")
    with pytest.raises(ValueError, match=r"picture\.exr: it is no colour table"):
        ir.ColorTable.load(tmp_path / "picture.exr")
    with pytest.raises(FileNotFoundError):
        ir.ColorTable.load(tmp_path / "none.exr")


@pytest.mark.parametrize("path", ["table", "table.tif", "x\0.exr", 5, None])
def test_file_names_are_checked(soap: ir.ColorTable, path: Any) -> None:
    with pytest.raises(ValueError, match="path must"):
        soap.save(path)
    with pytest.raises(ValueError, match="path must"):
        ir.ColorTable.load(path)


def test_nothing_is_left_where_a_file_cannot_be_written(soap: ir.ColorTable, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        soap.save(tmp_path / "no" / "t.exr")
    (tmp_path / "t.exr").mkdir()
    with pytest.raises(OSError, match="folder"):
        soap.save(tmp_path / "t.exr")
    assert [path.name for path in tmp_path.iterdir()] == ["t.exr"]


# --- pictures


def test_ramp_is_the_table(soap: ir.ColorTable, tmp_path: Path) -> None:
    picture = soap.ramp((91, 8), illuminant="A")
    assert picture.shape == (8, 91, 3)
    t, angle = np.linspace(0.0, 900.0, 91), np.linspace(0.0, 70.0, 8)[:, None]
    assert np.array_equal(picture.xyz, soap.color(t, angle, illuminant="A").astype(np.float32))
    assert np.array_equal(picture.channels["thickness_nm"][3], t.astype(np.float32))
    soap.save(tmp_path / "t.png")
    header = (tmp_path / "t.png").read_bytes()[:24]
    assert header[1:4] == b"PNG" and int.from_bytes(header[16:20]) == 1024 and int.from_bytes(header[20:24]) == 256


def test_a_notebook_shows_the_ramp_and_the_error(soap: ir.ColorTable) -> None:
    html = soap._repr_html_()
    picture = html.split("base64,")[1].split('"')[0]
    assert base64.b64decode(picture)[1:4] == b"PNG"
    assert f"{soap.max_delta_e:.2g}" in html and "D65, A" in html and "soap 0..900" in html


# --- long work


def test_progress_is_told_and_can_stop_the_work() -> None:
    told: list[tuple[int, int]] = []
    ir.ColorTable(
        AIR_FILM, (0.0, 3000.0), illuminant=["D65", "A"], progress=lambda done, total: told.append((done, total))
    )
    assert told and all(0 < done <= total for done, total in told)
    assert [done for done, _ in told] == sorted({done for done, _ in told})
    assert told[-1][0] == told[-1][1]

    def stop(done: int, total: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        ir.ColorTable(AIR_FILM, (0.0, 30_000.0), progress=stop)


def test_ctrl_c_stops_the_work() -> None:
    timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        ir.ColorTable(AIR_FILM, (0.0, 60_000.0), max_delta_e=0.001)
    timer.join()


# --- refusals


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"thickness_nm": (-1.0, 5.0)}, "thickness_nm must be >= 0"),
        ({"thickness_nm": (0.0, np.nan)}, "thickness_nm"),
        ({"thickness_nm": (0.0, 0.0)}, "thickness_nm"),
        ({"thickness_nm": []}, "thickness_nm must not be empty"),
        ({"thickness_nm": "thick"}, "thickness_nm"),
        ({"thickness_nm": (0.0, 1e9)}, "fringes"),
        ({"angle_deg": (0.0, 90.0)}, "angle_deg must be >= 0 and < 90"),
        ({"angle_deg": None}, "angle_deg"),
        ({"illuminant": []}, "illuminant must not be empty"),
        ({"illuminant": ["D65", "d65"]}, "'D65' twice"),
        ({"illuminant": "moonlight"}, "moonlight"),
        ({"observer": "me"}, "observer must be"),
        ({"polarization": "x"}, "polarization must be"),
        ({"quantity": "colour"}, "quantity must be"),
        ({"quantity": ["reflectance", "reflectance"]}, "twice"),
        ({"layer": 1}, "layer must be a whole number from 0 to 0"),
        ({"layer": True}, "layer must be"),
        ({"max_delta_e": 0.0}, "max_delta_e must be > 0"),
        ({"max_delta_e": [0.1, 0.2]}, "max_delta_e must be a single number"),
        ({"thickness_nm": (100.0, 110.0), "angle_deg": 0.0, "max_delta_e": 1e-12}, "was reached"),
        ({"progress": 5}, "progress must be"),
    ],
)
def test_wrong_arguments_are_named(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ir.ColorTable(AIR_FILM, **{"thickness_nm": (0.0, 100.0), "angle_deg": (0.0, 10.0), **wrong})


def test_wrong_stacks_are_named() -> None:
    with pytest.raises(ValueError, match=r"stack must be an iridesce\.Stack"):
        ir.ColorTable("air / soap 320 / air")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="needs a stack with a layer"):
        ir.ColorTable(ir.Stack(["air", 1.5]))
    two = ir.Stack(["air", ir.Layer(2.3, 50.0), ir.Layer(1.4, 80.0), 1.5])
    with pytest.raises(ValueError, match="layer must say which of the 2 layers varies, 0 to 1 \\(none holds"):
        ir.ColorTable(two)
    both = ir.Stack(["air", ir.Layer(2.3, [1.0, 2.0]), ir.Layer(1.4, [1.0, 2.0]), 1.5])
    with pytest.raises(ValueError, match="several hold"):
        ir.ColorTable(both)
    with pytest.raises(ValueError, match="layer 1 has an array"):
        ir.ColorTable(both, layer=0)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"thickness_nm": 900.001}, "thickness_nm must be within the table's 0 to 900, got 900.001"),
        ({"thickness_nm": np.array([[1.0, 2.0], [3.0, -1.0]])}, r"got -1.0 at index \(1, 1\)"),
        ({"thickness_nm": np.array([1.0, np.nan])}, r"got nan at index \(1,\)"),
        ({"thickness_nm": [1.0, np.inf]}, "thickness_nm must be finite"),
        ({"thickness_nm": np.empty(0)}, "thickness_nm must not be empty"),
        ({"thickness_nm": 1j}, "thickness_nm must be real"),
        ({"angle_deg": 71.0}, "angle_deg must be within the table's 0 to 70, got 71.0"),
        ({"thickness_nm": [1.0, 2.0], "angle_deg": [1.0, 2.0, 3.0]}, "thickness_nm and angle_deg must broadcast"),
        ({"space": "cmyk"}, "space must be"),
        ({"illuminant": "D50"}, "illuminant must be one of the table's, D65, A, got 'D50'"),
        ({"quantity": "absorptance"}, "quantity must be one of the table's, reflectance, transmittance"),
        ({"adaptation": "cat02"}, "adaptation must be"),
        ({"gamut": "hue"}, "gamut= needs an RGB space"),
        ({"gamut": "cut"}, "gamut must be"),
        ({"threads": 0}, "threads must be"),
        ({"out": np.empty(3, np.float32)}, "out must be of type float64"),
        ({"out": np.empty((2, 3))}, "out must have the shape"),
    ],
)
def test_wrong_questions_are_named(soap: ir.ColorTable, wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        soap.color(**{"thickness_nm": 100.0, **wrong})


@pytest.mark.parametrize("size", [(0, 5), (5, -1), (2.5, 4), 7, (1, 2, 3), (2**20, 2**20), "ab"])
def test_wrong_sizes_are_named(soap: ir.ColorTable, size: Any) -> None:
    with pytest.raises(ValueError, match="size must be"):
        soap.ramp(size)
