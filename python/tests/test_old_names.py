"""Programs and pickles that name modules as they were called before there were packages."""

from __future__ import annotations

import base64
import importlib
import json
import pickle
import subprocess
import sys

import pytest

import iridesce as ir
from conftest import ROOT
from iridesce._moved import MOVED

# Written by the flat package of November 2026, commit 1b68242, protocol 4.
PICKLES: dict[str, str] = json.loads((ROOT / "python" / "tests" / "data" / "pickles.json").read_text())


@pytest.mark.parametrize("name", sorted(PICKLES))
def test_a_pickle_of_before_is_read(name: str) -> None:
    value = pickle.loads(base64.b64decode(PICKLES[name]))
    assert type(value).__name__ == name.partition(".")[0]
    again = pickle.loads(pickle.dumps(value))
    assert type(again) is type(value)
    assert repr(again) == repr(value)


def test_what_was_pickled_is_what_is_made_now() -> None:
    film = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])
    made = {
        "Medium": ir.Medium("SiO2"),
        "Stack": film,
        "Layer": film.layers[0],
        "Illuminant": ir.color.illuminant("FL2"),
        "ThicknessModel": ir.thickness.gradient(1.0, 2.0),
        "Scene": ir.Scene.load("wafer"),
    }
    for name, value in made.items():
        assert pickle.loads(base64.b64decode(PICKLES[name])) == value, name


def test_a_pickle_is_read_before_anything_is_imported() -> None:
    code = "import base64, pickle, sys; print(type(pickle.loads(base64.b64decode(sys.argv[1]))).__module__)"
    for name, module in {
        "ThicknessMap": "iridesce.thickness.thickness_map",
        "FitResult": "iridesce.inverse.results",
    }.items():
        command = [sys.executable, "-c", code, PICKLES[name]]
        assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip() == module


@pytest.mark.parametrize("old", sorted(MOVED))
def test_an_old_name_is_the_same_module(old: str) -> None:
    module = importlib.import_module(old)
    assert module is importlib.import_module(MOVED[old])
    assert module.__name__ == MOVED[old] == module.__spec__.name
    assert getattr(ir, old.partition(".")[2]) is module


def test_names_imported_from_old_places() -> None:
    from iridesce.color_table import ColorTable
    from iridesce.fit import FitResult, fit_thickness, read_spectrum
    from iridesce.medium import Medium, media

    from iridesce.cli import main
    from iridesce.image import Image
    from iridesce.rendering import render
    from iridesce.scene import Scene, scene_names, scene_text
    from iridesce.stack import Layer, Stack
    from iridesce.thickness import ThicknessMap, simulate

    assert (ColorTable, Image, Medium, Scene, Layer, Stack) == (
        *(ir.ColorTable, ir.Image, ir.Medium, ir.Scene),
        *(ir.Layer, ir.Stack),
    )
    assert (fit_thickness, media, render) == (ir.fit_thickness, ir.media, ir.render)
    assert (FitResult, read_spectrum) == (ir.fit.FitResult, ir.fit.read_spectrum)
    assert (ThicknessMap, simulate) == (ir.thickness.ThicknessMap, ir.thickness.simulate)
    assert all(callable(one) for one in (main, scene_names, scene_text))


def test_a_name_that_never_was_stays_unknown() -> None:
    with pytest.raises(ModuleNotFoundError, match=r"iridesce\.films"):
        importlib.import_module("iridesce.films")
    with pytest.raises(AttributeError, match="films"):
        ir.films  # noqa: B018
