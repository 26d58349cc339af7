"""What exports, imports and their checks refuse: the parts of each message, and its words."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from iridesce.exchange.films import checked_range
from iridesce.exchange.lut import single_file
from iridesce.exchange.suite import CHARTS, GROUPS, charts_named
from refused import Case, check

ANY_CHART = f"one of {', '.join([*CHARTS, *GROUPS])}"
SOAP = "air / soap ? / air"
TWO = "air / soap 5 / water 5 / air"
BARE = ir.Stack(["air", "Si"])
DULL = {
    "version": 1,
    "camera": {},
    "light": [{"environment": {"illuminant": "D65"}}],
    "object": [{"shape": {"sphere": {}}, "surface": {"diffuse": {"reflectance": 0.5}}}],
}
GIVEN = {"illuminant": "D65", "size": None, "quantity": "reflectance"}
METAL = ir.Stack(["air", ir.Layer("SiO2", [0.0, 9.0]), "Si"])


def one(stack, ending=".exr", vary=None, **changes):
    return single_file(stack, ending, vary=vary, **{**GIVEN, **changes})


CASES: list[Case] = [
    (
        lambda: ir.export(SOAP, "pdf", "x"),
        None,
        *("to", "'pdf'", "one of lut, cube, gltf, openpbr, usd, cycles, mitsuba, shader, osl", ""),
    ),
    (lambda: ir.export(SOAP, "lut", ""), None, *("path", "''", "a folder", "")),
    (lambda: ir.export(SOAP, "lut", "x", fit="yes"), None, *("fit", "'yes'", "True or False", "")),
    (
        lambda: ir.export("air / soap ? / water ? / air", "lut", "x"),
        "only one layer may leave out its thickness, got 'air / soap ? / water ? / air'",
        *("stack", "'air / soap ? / water ? / air'", "a stack of which one layer at most leaves out its thickness", ""),
    ),
    (
        lambda: ir.export("soap-bubble", "lut", "x", vary=(0.0, 1.0)),
        "vary and thickness go with a stack; the films of a scene have their own thicknesses",
        *("vary", "(0.0, 1.0)", "left out for a scene", ""),
    ),
    (
        lambda: ir.export("soap-bubble", "lut", "x", thickness=[[1.0]]),
        "vary and thickness go with a stack; the films of a scene have their own thicknesses",
        *("thickness", "list", "left out for a scene", ""),
    ),
    (
        lambda: ir.export(SOAP, "lut", "x", vary=(0.0, 100.0), thickness=[[1.0, 200.0]]),
        "thickness runs from 1 to 200 nm, beyond vary = 0 to 100 nm",
        *("thickness", "1 to 200 nm", "within vary = 0 to 100 nm", ""),
    ),
    (
        lambda: ir.export(TWO, "lut", "x", vary=(0.0, 100.0)),
        (
            "which of the 2 layers varies? Give that one an array of thicknesses, in text a ? for its "
            "thickness (none of them has one)"
        ),
        *("stack", "none of 2", "a stack of which one layer has an array of thicknesses", ""),
    ),
    (
        lambda: ir.export(BARE, "lut", "x", vary=(0.0, 100.0)),
        "a thickness that varies needs a stack with a layer, got Stack(['air', 'Si'])",
        *("stack", "Stack(['air', 'Si'])", "a stack with a layer", ""),
    ),
    (
        lambda: ir.export(BARE, "lut", "x"),
        '"lut" writes films; there is none here (gltf, openpbr, usd and cycles take bare surfaces)',
        *("stack_or_scene", "one without", "a stack with a layer or a scene with a film", ""),
    ),
    (
        lambda: ir.export(DULL, "lut", "x"),
        "the scene has no surface that interferes: no film, coating, dielectric or metal",
        *("scene", "one without", "a scene with a film, a coating, a dielectric or a metal", ""),
    ),
    (
        lambda: one(BARE),
        "a table needs a stack with a layer, got Stack(['air', 'Si'])",
        *("stack", "Stack(['air', 'Si'])", "a stack with a layer", ""),
    ),
    (lambda: checked_range("vary", [1.0]), None, *("vary", "[1.0]", "two thicknesses (A, B) in nm", "")),
    (
        lambda: checked_range("vary", [2.0, 1.0]),
        "vary must run from a thinner to a thicker film, got 2 to 1 nm",
        *("vary", "2 to 1 nm", "run from a thinner to a thicker film", ""),
    ),
    (
        lambda: checked_range("vary", [0.0, 1e9]),
        "vary must end at 100000 nm or below (thicker films are grey), got 1e+09 nm",
        *("vary", "1e+09 nm", "end at 100000 nm or below (thicker films are grey)", ""),
    ),
    (
        lambda: one(METAL, quantity="transmittance"),
        "air / SiO2 ? / Si: nothing comes out behind Si, which absorbs",
        *("quantity", "'transmittance'", "reflectance where the last medium absorbs", ""),
    ),
    (
        lambda: one(METAL, size=(1, 4)),
        None,
        *("size", "(1, 4)", "(width, height), each >= 2, 4194304 texels at most", ""),
    ),
    (
        lambda: one(METAL, ".cube", size=(4, 4)),
        "a .cube has 1024 entries; size goes with .exr and .png",
        *("size", "(4, 4)", "left out for a .cube", ""),
    ),
    (lambda: charts_named("soup"), None, *("chart", "'soup'", ANY_CHART, "")),
    (lambda: ir.import_scene(3), None, *("path", "3", "a file ending in .gltf, .glb, .mtlx, .xml", "")),
    (lambda: ir.import_scene("x.pdf"), None, *("path", "'x.pdf'", "a file ending in .gltf, .glb, .mtlx, .xml", "")),
    (
        lambda: ir.validate(np.ones((4, 4)), chart="C1"),
        "picture_or_array must have the shape (rows, columns, 3), got (4, 4)",
        *("picture_or_array", "(4, 4)", "have the shape (rows, columns, 3)", ""),
    ),
    (
        lambda: ir.validate(np.full((4, 8, 3), np.nan), chart="C1"),
        None,
        *("picture_or_array", "nan", "finite", "at index (0, 0, 0)"),
    ),
    (
        lambda: ir.validate(np.ones((5, 5, 3)), chart="C1"),
        None,
        *(
            "picture_or_array",
            "5 x 5",
            "a chart of 24k x 7k pixels or a table of thickness x cos(theta) (such as 512 x 64)",
            "",
        ),
    ),
    (
        lambda: ir.validate("x.gif", chart="C1"),
        None,
        *("picture_or_array", "'x.gif'", "an .exr, a .png or an .npy", ""),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)
