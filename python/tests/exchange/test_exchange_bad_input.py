"""Films that a target cannot hold: written with the loss told, or refused with the target that can; nothing half written."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import iridesce as ir
from iridesce.exchange import lut
from iridesce.exchange.exporting import TARGETS

KNOBS = ("gltf", "openpbr", "usd")
"""Targets with one film of one index."""

SCENES = ("gltf", "usd", "mitsuba")
"""Targets that hold geometry, camera and lights."""

BARE = ("gltf", "openpbr", "usd", "cycles")
"""Targets that take a surface without a film."""

THIN = np.linspace(50.0, 600.0, 3)

# What is asked for, and the sentence of targets with knobs; all others hold it whole.
HARD: dict[str, tuple[Any, str]] = {
    "several layers": (
        ir.Stack(["air", ir.Layer("soap", THIN), ir.Layer("TiO2", 100.0), ir.Layer("SiO2", 120.0), "N-BK7"]),
        "layer TiO2 under the film as a film of its own.*lut, osl and mitsuba hold it whole",
    ),
    "an absorbing film": (
        ir.Stack(["air", ir.Layer(2.0 + 0.5j, THIN), "N-BK7"]),
        "absorption of the film.*use lut",
    ),
    "an incoherent slab": (
        ir.Stack(["air", ir.Layer("soap", THIN), ir.Layer("N-BK7", 1e6, coherent=False), "air"]),
        "slab N-BK7, which is incoherent.*lut, osl and mitsuba hold it whole",
    ),
}


@pytest.fixture(autouse=True)
def small_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is told does not depend on how many texels a table has."""
    monkeypatch.setattr(lut, "SIZE", (16, 4))
    monkeypatch.setattr(lut, "CUBE_SIZE", 64)
    monkeypatch.setattr(lut, "_POINTS", 50)
    monkeypatch.setattr(lut, "_CUBE_POINTS", 50)


def whole(report: ir.exchange.ExportReport, folder: Path) -> bool:
    """Every file that is told is there, and no other; the error is a number."""
    there = sorted(path for path in folder.rglob("*") if path.is_file())
    return (
        sorted(report.files) == there and all(path.stat().st_size for path in there) and report.delta_e["mean"] >= 0.0
    )


@pytest.mark.parametrize("name", HARD)
@pytest.mark.parametrize("to", TARGETS)
def test_a_film_that_knobs_cannot_say_is_told_or_held_whole(to: str, name: str, tmp_path: Path) -> None:
    stack, loss = HARD[name]
    report = ir.export(stack, to, tmp_path / "out")
    assert whole(report, tmp_path / "out")
    told = " | ".join(report.dropped)
    if to in KNOBS:
        assert re.search(loss, told), told
        assert report.delta_e["mean"] > 1.0, "the loss is no loss"
    else:
        assert not any(word in told for word in ("TiO2", "absorption", "incoherent")), told
    if to == "cycles":
        assert any("table: the physical knobs would be off by" in note for note in report.notes)


@pytest.mark.parametrize("to", TARGETS)
def test_a_scene_with_a_flow_leaves_as_far_as_the_target_goes(to: str, tmp_path: Path) -> None:
    report = ir.export("soap-film-frame", to, tmp_path / "out")
    assert whole(report, tmp_path / "out")
    assert any("geometry, camera and lights" in one for one in report.dropped) == (to not in SCENES)
    if to in ("lut", "cube", "shader", "osl"):
        assert any("its thickness differs from place to place" in note for note in report.notes)
    else:
        assert any(path.suffix in (".png", ".exr", ".npz") for path in report.files), "no map of the film"


@pytest.mark.parametrize("to", TARGETS)
def test_a_bare_surface_is_written_or_the_targets_that_can_are_named(to: str, tmp_path: Path) -> None:
    bare = ir.Stack(["air", "Ti"])
    if to in BARE:
        assert whole(ir.export(bare, to, tmp_path / "out"), tmp_path / "out")
        return
    with pytest.raises(ValueError, match="gltf, openpbr, usd and cycles take bare surfaces"):
        ir.export(bare, to, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ((600.0, 100.0), "vary must run from a thinner to a thicker film, got 600 to 100 nm"),
        ((100.0, 100.0), "vary must run from a thinner to a thicker film"),
        ((-5.0, 100.0), r"vary must be >= 0 and finite, got -5.0 at index \(0,\)"),
        ((0.0, np.inf), "vary must be >= 0 and finite, got inf"),
        ((0.0, 1e9), r"vary must end at 100000 nm or below \(thicker films are grey\), got 1e\+09 nm"),
        ((0.0, 100.0, 200.0), r"vary must be two thicknesses \(A, B\) in nm"),
        ("0:1200", "vary must be real numbers"),
    ],
)
@pytest.mark.parametrize("to", TARGETS)
def test_impossible_ranges_are_refused_everywhere(to: str, vary: Any, message: str, tmp_path: Path) -> None:
    with pytest.raises(ir.ArgumentError, match=message) as caught:
        ir.export("air / soap ? / air", to, tmp_path / "out", vary=vary)
    assert caught.value.argument == "vary"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("to", ["unreal", "GLTF", "", None, 3, b"lut"])
def test_an_unknown_target_brings_the_list_of_all(to: Any, tmp_path: Path) -> None:
    with pytest.raises(ir.ArgumentError, match=f"to must be one of {', '.join(TARGETS)}, got") as caught:
        ir.export("air / soap ? / air", to, tmp_path / "out", vary=(0.0, 100.0))
    assert caught.value.argument == "to"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("to", TARGETS)
def test_a_file_in_the_way_leaves_nothing_half_written(to: str, tmp_path: Path) -> None:
    made = ir.export("air / soap 300 / air", to, tmp_path / "out")
    last = made.files[-1].relative_to(tmp_path / "out")
    (tmp_path / "again" / last).mkdir(parents=True)
    with pytest.raises(IsADirectoryError):
        ir.export("air / soap 300 / air", to, tmp_path / "again")
    assert [path for path in (tmp_path / "again").rglob("*") if path.is_file()] == []


def test_a_slab_has_no_fringes_that_a_wide_table_would_hold() -> None:
    glass = ir.Stack(["air", ir.Layer("N-BK7", 1e6, coherent=False), "air"])
    from iridesce import color
    from iridesce.exchange.films import film_of

    table = lut.table(film_of(glass, None, None, None, color.illuminant("D65")), "reflectance")
    assert table.xyz.shape[1] == lut.SIZE[0] and table.range_nm == (0.0, 2e6)
