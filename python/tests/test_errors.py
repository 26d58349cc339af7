"""Errors with parts: argument, value, allowed and place of every message that is made from them."""

from __future__ import annotations

import ast
import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import iridesce as ir
from conftest import ROOT
from iridesce.errors import ArgumentError

FILM = ir.Stack(["air", ir.Layer("soap", thickness_nm=320.0), "air"])
SCENE = "soap-bubble"
FINITE, ABOVE, LEAST = "finite", "> 0 and finite", ">= 0 and finite"

# what is called, then argument, given, allowed, place
CASES: list[tuple[Callable[[], Any], str, str, str, str]] = [
    (lambda: FILM.reflectance([[550.0, 0.0]]), "wavelength_nm", "0.0", ABOVE, "at index (0, 1)"),
    (lambda: FILM.reflectance(np.nan), "wavelength_nm", "nan", ABOVE, ""),
    (lambda: FILM.reflectance(550.0, [0.0, 90.0]), "angle_deg", "90.0", ">= 0 and < 90", "at index (1,)"),
    (lambda: ir.Layer("soap", [[1.0], [-2.0]]), "thickness_nm", "-2.0", LEAST, "at index (1, 0)"),
    (lambda: FILM.reflectance("blue"), "wavelength_nm", "'blue' of type <U4", "real numbers", ""),
    (
        lambda: FILM.reflectance(np.full((1,) * 33, 550.0)),
        "wavelength_nm",
        "33 axes",
        "an array of at most 32 axes",
        "",
    ),
    (lambda: FILM.reflectance(550.0, 0.0, "x"), "polarization", "'x'", '"s", "p" or "unpolarized"', ""),
    (lambda: FILM.reflectance(550.0, threads=0), "threads", "0", "a whole number from 1 to 1024, or None", ""),
    (
        lambda: FILM.color(quantity="shine"),
        "quantity",
        "'shine'",
        '"reflectance", "transmittance" or "absorptance"',
        "",
    ),
    (lambda: ir.Medium("soap").index([500.0, -1.0]), "wavelength_nm", "-1.0", ABOVE, "at index (1,)"),
    (
        lambda: ir.color.spectrum_to_xyz([500.0, 0.0], [1.0, 1.0]),
        "wavelength_nm",
        "0.0",
        ABOVE,
        "at index (1,)",
    ),
    (lambda: ir.render(SCENE, samples=0), "samples", "0", "a whole number from 1 to 1048576, or None", ""),
    (lambda: ir.render(SCENE, seed=-1), "seed", "-1", f"a whole number from 0 to {2**64 - 1}, or None", ""),
    (lambda: ir.render(SCENE, threads=True), "threads", "True", "a whole number from 1 to 1024, or None", ""),
    (
        lambda: ir.render(SCENE, progress=3),
        "progress",
        "3",
        "a function of (done, total) or (done, total, stage), True, False or None",
        "",
    ),
    (lambda: ir.Image(np.full((1, 2, 3), np.nan)), "xyz", "nan", FINITE, "at index (0, 0, 0)"),
    (
        lambda: ir.Image(np.ones((2, 2, 3), complex)),
        "xyz",
        "an array of type complex128",
        "an array of real numbers",
        "",
    ),
    (lambda: ir.thickness.gradient(-1.0, 5.0), "top", "-1.0", f"{LEAST}, in nm", ""),
    (lambda: ir.thickness.gradient(1.0, 5.0, 0.0), "exponent", "0.0", ABOVE, ""),
    (lambda: ir.thickness.lens_gap(0.0), "radius_mm", "0.0", ABOVE, ""),
    (
        lambda: ir.thickness.wedge((0, 0, 0), (0, 0, 0), 1.0, 2.0),
        "to_point",
        "[0.0, 0.0, 0.0]",
        "a point away from the other end [0.0, 0.0, 0.0]",
        "",
    ),
    (lambda: ir.thickness.ThicknessMap([[1.0, -1.0]]), "thickness_nm", "-1.0", LEAST, "at row 0, column 1"),
    (
        lambda: ir.thickness.simulate("late", viscosity_pa_s=-1.0),
        "viscosity_pa_s",
        "-1.0",
        "a finite number > 0",
        "",
    ),
    (lambda: ir.thickness.simulate("late", columns=15), "columns", "15", "a whole number from 16 to 16384", ""),
    (lambda: ir.thickness.simulate("late", time_s=-1.0), "time_s", "-1.0", "from 0 to 1e+06", ""),
    (lambda: ir.thickness.simulate("vertical-film", sides=1), "sides", "1", '"menisci" or "periodic"', ""),
    (lambda: ir.thickness.simulate("vertical-film", sides="glass"), "sides", '"glass"', '"menisci" or "periodic"', ""),
    (
        lambda: ir.thickness.simulate("late", sides="menisci"),
        "sides",
        '"menisci"',
        "left out for a bubble, which has none",
        "",
    ),
    (
        lambda: ir.thickness.simulate("late", initial=[[1.0, -2.0]]),
        "initial",
        "-2.0",
        f"{LEAST}, in nm",
        "at index (0, 1)",
    ),
    (lambda: ir.thickness.lens_gap(1000.0).at_radius([1.0, -1.0]), "distance_mm", "-1.0", ">= 0", "at index (1,)"),
    (
        lambda: ir.ColorTable(FILM, (0.0, 400.0)).color([100.0, 500.0]),
        "thickness_nm",
        "500.0",
        "within the table's 0 to 400",
        "at index (1,)",
    ),
    (
        lambda: ir.fit_thickness(NM, NM, OPEN, thickness_range_nm=(5.0, 1.0)),
        *("thickness_range_nm", "[[5.0, 1.0]]", "0 <= low < high", ""),
    ),
    (lambda: ir.fit_thickness(NM, NM, FILM, layer=7), "layer", "7", "1 to 1 or the name of one of the layers soap", ""),
    (
        lambda: ir.sweep(FILM, {"angle_deg": [1.0]}, shard=(3, 2)),
        *("shard", "(3, 2)", "(i, n), whole numbers with 1 <= i <= n", ""),
    ),
    (lambda: ir.export(OPEN, "cube", 3), "path", "3", "a folder", ""),  # type: ignore[arg-type]
    (lambda: ir.plot.spectrum(FILM, angle_deg=95.0), "angle_deg", "95.0", ">= 0 and < 90", ""),
    (lambda: FILM.color(wavelength_nm=[550.0]), "wavelength_nm", "1", "two wavelengths at least", ""),
    (lambda: FILM.color(adaptation="x"), "adaptation", '"x"', '"bradford" or None', ""),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[1]} {case[2]}"[:40])
def test_a_refusal_has_argument_value_allowed_and_place(case: tuple[Callable[[], Any], str, str, str, str]) -> None:
    call, argument, given, allowed, place = case
    with pytest.raises(ArgumentError) as caught:
        call()
    error = caught.value
    assert (error.argument, error.given, error.allowed, error.place) == (argument, given, allowed, place)
    assert str(error) == f"{argument} must be {allowed}, got {given}{' ' * bool(place)}{place}"


NM = np.linspace(450.0, 700.0, 60)
OPEN = "air / soap ? / air"

# Messages with another verb, a place before them, or a sentence of their own: what is called, words, then the parts.
SENTENCES: list[tuple[Callable[[], Any], str, str, str, str, str]] = [
    (
        lambda: ir.color.convert([1.0, 2.0], "xyz", "lab"),
        "values must have a last axis of 3, got shape (2,)",
        *("values", "shape (2,)", "have a last axis of 3", ""),
    ),
    (
        lambda: ir.merge([1, 2]),  # type: ignore[list-item]
        "images must hold images and paths, got 1 at index 0",
        *("images", "1", "hold images and paths", "at index 0"),
    ),
    (
        lambda: ir.Stack.parse("air / soap -3 / air"),
        "item 2 of the stack, 'soap -3': thickness_nm must be >= 0 and finite, got -3.0",
        *("thickness_nm", "-3.0", LEAST, "in item 2 of the stack, 'soap -3'"),
    ),
    (
        lambda: ir.fit_thickness(NM, NM[:5], OPEN),
        "wavelength_nm and measured must be of one length, got 60 and 5",
        *("measured", "5", "as long as wavelength_nm (60)", ""),
    ),
    (
        lambda: ir.Measurement("psi", NM, NM, angle_deg=0.0),
        "psi needs angle_deg > 0: at normal incidence s and p are the same",
        *("angle_deg", "0.0", "> 0 for psi and delta", ""),
    ),
    (
        lambda: ir.map_thickness_video([], OPEN, fps=3.0),
        "max_rate_nm_per_s and fps belong together: give both or neither",
        *("fps", "one of the two", "given with the other, or neither", ""),
    ),
    (
        lambda: ir.sweep(FILM, {"angle_deg": []}),
        "vary['angle_deg'] is empty; give it one value at least",
        *("vary['angle_deg']", "none", "a list of one value or more", ""),
    ),
    (
        lambda: ir.plot.locus(OPEN, [300.0, 100.0]),
        "thickness_nm must ascend, got [300.0, 100.0]",
        *("thickness_nm", "[300.0, 100.0]", "ascending", ""),
    ),
    (
        lambda: ir.ColorTable(ir.Stack(["air", "soap"])),
        "a colour table needs a stack with a layer, got Stack(['air', 'soap'])",
        *("stack", "Stack(['air', 'soap'])", "a stack with a layer", ""),
    ),
    (
        lambda: ir.Stack(["air", ir.Layer("TiO2", 100.0), "air"]).reflectance([500.0, 100.0]),
        'medium "TiO2" has data for 206.64-826.56 nm; wavelength_nm must be within them, got 100.0 at index (1,)',
        *("wavelength_nm", "100.0", "within 206.64-826.56", "at index (1,)"),
    ),
    (
        lambda: FILM.color(model="two-beam", polarization="s"),
        "model=\"two-beam\" knows no polarisation, got polarization='s'",
        *("polarization", "'s'", "unpolarized for the two-beam model", ""),
    ),
    (
        lambda: FILM.color(model="two-beam", quantity="transmittance"),
        "model=\"two-beam\" gives the reflectance only, got quantity='transmittance'",
        *("quantity", "'transmittance'", "reflectance for the two-beam model", ""),
    ),
    (
        lambda: ir.Stack(["air"]),
        "a Stack needs a first and a last medium, got ['air']",
        *("stack", "['air']", "a list with a first and a last medium", ""),
    ),
    (
        lambda: ir.Stack.parse("air"),
        'a stack needs two or more items separated by " / ", as in "air / soap 320 / air", got \'air\'',
        *("stack", "'air'", 'two or more items, as in "air / soap 320 / air"', ""),
    ),
    (
        lambda: ir.Stack.parse("air / soap / air"),
        "item 2 of the stack, 'soap': a layer needs its thickness in nm, as in \"soap 320\"",
        *("thickness_nm", "nothing", "a number", "in item 2 of the stack, 'soap'"),
    ),
    (
        lambda: ir.Stack.parse("air / soap x / air"),
        "item 2 of the stack, 'soap x': the thickness in nm must be a number, got 'x'",
        *("thickness_nm", "'x'", "a number", "in item 2 of the stack, 'soap x'"),
    ),
    (
        lambda: ir.Stack.parse("air / soap 3 loose / air"),
        "item 2 of the stack, 'soap 3 loose': after the thickness only \"incoherent\" may follow, got 'loose'",
        *("stack", "'loose'", '"incoherent", or nothing, after a thickness', "in item 2 of the stack, 'soap 3 loose'"),
    ),
    (
        lambda: ir.Stack([1.5 + 0.1j, "air"]).reflectance(550.0),
        "the first medium must have real n > 0 and k = 0, got (1.5+0.1j)",
        *("first", "(1.5+0.1j)", "a medium with real n > 0 and k = 0", ""),
    ),
    (
        lambda: ir.Stack(["air", 1.5 - 0.1j]).reflectance(550.0),
        "the last medium must have k >= 0 (gain only in finite layers), got (1.5-0.1j)",
        *("last", "(1.5-0.1j)", "a medium with k >= 0", ""),
    ),
]


@pytest.mark.parametrize("case", SENTENCES, ids=lambda case: case[1][:40])
def test_a_sentence_of_its_own_has_the_same_parts(case: tuple[Callable[[], Any], str, str, str, str, str]) -> None:
    call, words, *parts = case
    with pytest.raises(ArgumentError) as caught:
        call()
    error = caught.value
    assert str(error) == words
    assert [error.argument, error.given, error.allowed, error.place] == parts


def test_python_and_the_core_say_the_same() -> None:
    from iridesce import _core

    with pytest.raises(ArgumentError) as ours:
        FILM.reflectance([550.0, -1.0])
    with pytest.raises(ArgumentError) as cores:
        _core.Medium.named("soap").index(np.array([550.0, -1.0]), False, (2,))
    assert str(ours.value) == str(cores.value)
    assert vars(ours.value) == vars(cores.value)


def test_an_unknown_parameter_brings_the_one_that_is_meant() -> None:
    with pytest.raises(ArgumentError, match=r"perhaps wind_m_s is meant") as caught:
        ir.thickness.simulate("late", wind=1.0)
    assert (caught.value.argument, caught.value.given) == ("parameter", '"wind"')


def test_values_of_any_length_and_any_character_fit_into_a_message() -> None:
    with pytest.raises(ArgumentError) as caught:
        FILM.reflectance(550.0, 0.0, "\x1b[2J" + "x" * 10_000)
    assert len(str(caught.value)) < 200
    assert str(caught.value).isprintable()


def test_errors_travel_between_processes() -> None:
    with pytest.raises(ArgumentError) as caught:
        FILM.reflectance([550.0, -1.0])
    for again in (pickle.loads(pickle.dumps(caught.value)), copy.deepcopy(caught.value)):
        assert (type(again), str(again), vars(again)) == (ArgumentError, str(caught.value), vars(caught.value))


@pytest.mark.parametrize("kind", [ArgumentError, ir.SceneError, ir.ResourceError])
def test_one_except_catches_all(kind: type[Exception]) -> None:
    assert issubclass(kind, ValueError)


# --- where a ValueError has no parts

A_FILE = "what a file holds, which no argument names: the file, the place in it and what is wrong"
A_RUN = "what stands in a folder or a journal that a run should go on with"
PICTURES = "what several pictures or files say of each other"
WORKERS = "what a machine elsewhere has installed"

# Modules that raise a bare ValueError with words of its own: how many, and why they are about no argument.
BARE: dict[str, tuple[int, str]] = {
    "_picture_files.py": (2, A_FILE),
    "cli/reading.py": (3, "options as typed, before there is an argument"),
    "cli/run_folder.py": (5, A_RUN),
    "cli/verbs/fit.py": (2, PICTURES),
    "cli/verbs/flow.py": (4, A_RUN),
    "cli/verbs/sweep.py": (2, A_RUN),
    "color/camera_tables.py": (8, A_FILE),
    "color/color_table.py": (6, A_FILE),
    "color/light.py": (1, A_FILE),
    "exchange/exr.py": (9, A_FILE),
    "exchange/importers/common.py": (4, A_FILE),
    "exchange/importers/gltf.py": (15, A_FILE),
    "exchange/importers/materialx.py": (6, A_FILE),
    "exchange/importers/mitsuba.py": (3, A_FILE),
    "exchange/lut.py": (2, A_FILE),
    "exchange/png.py": (8, A_FILE),
    "exchange/validating.py": (4, A_FILE),
    "files/arrays.py": (3, A_FILE),
    "files/spectra.py": (1, A_FILE),
    "files/trees.py": (4, A_FILE),
    "files/whole.py": (1, A_FILE),
    "image.py": (1, A_FILE),
    "inverse/calibration.py": (3, A_FILE),
    "inverse/pictures.py": (3, A_FILE),
    "inverse/series_data.py": (1, PICTURES),
    "optics/database.py": (2, A_FILE),
    "rendering/animation.py": (6, A_FILE),
    "rendering/journal.py": (3, A_RUN),
    "rendering/merging.py": (5, PICTURES),
    "sweeping/cluster.py": (6, WORKERS),
    "sweeping/needed.py": (1, A_FILE),
    "sweeping/results.py": (2, "what the points of a sweep gave: of several shapes"),
    "sweeping/store.py": (4, A_RUN),
}


def bare_errors(root: Path) -> dict[str, int]:
    """Modules that raise ``ValueError("...")`` themselves, and how often; without words it is for the next ``except``."""
    found = {}
    for file in sorted(root.rglob("*.py")):
        raised = [
            node.exc for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(node, ast.Raise)
        ]
        calls = [one for one in raised if isinstance(one, ast.Call) and one.args]
        count = sum(isinstance(one.func, ast.Name) and one.func.id == "ValueError" for one in calls)
        if count:
            found[file.relative_to(root).as_posix()] = count
    return found


def test_a_value_error_about_an_argument_has_parts() -> None:
    found = bare_errors(ROOT / "python" / "iridesce")
    assert found == {name: count for name, (count, _) in BARE.items()}, (
        "about an argument? iridesce.arguments.refusals makes it; else count it here, with its reason"
    )


def test_a_bare_error_is_seen(tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "bare.py").write_text('def f(x):\n    raise ValueError(f"x must be 1, got {x}") from None\n')
    (tmp_path / "fine.py").write_text(
        'def f(x):\n    raise ValueError\n\n\ndef g(x):\n    raise refusal("x", "1", x)\n'
    )
    assert bare_errors(tmp_path) == {"p/bare.py": 1}
