"""What colours, tables of them and lamps refuse: the parts of each message, and its words."""

from __future__ import annotations

import pytest

import iridesce as ir
from refused import Case, check

STRIP = ir.plot.strip
FILM = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])
TWO = ir.Stack(["air", ir.Layer("soap", 320.0), ir.Layer("water", 100.0), "air"])
MANY = ir.Stack(["air", ir.Layer("soap", [1.0, 2.0]), ir.Layer("water", 100.0), "air"])
BOTH = ir.Stack(["air", ir.Layer("soap", [1.0, 2.0]), ir.Layer("water", [1.0, 2.0]), "air"])
TABLE = ir.ColorTable(FILM, (0.0, 100.0), angle_deg=0.0, max_delta_e=1.0)

CASES: list[Case] = [
    (
        lambda: FILM.color(wavelength_nm=[[500.0, 600.0]]),
        "wavelength_nm must have one axis, got shape (1, 2)",
        *("wavelength_nm", "shape (1, 2)", "have one axis", ""),
    ),
    (
        lambda: ir.color.dias1991(TWO),
        "dias1991 needs exactly one coherent layer, got 2 layers",
        *("stack", "2 layers", "one of exactly one coherent layer", ""),
    ),
    (
        lambda: ir.color.dias1991(FILM, matrix=[1.0, 2.0]),
        None,
        *("matrix", "shape (2,)", '"printed", "full" or an array of shape (3, 3)', ""),
    ),
    (
        lambda: ir.color.dias1991("air / soap 3 / air"),
        None,
        *("stack", "'air / soap 3 / air'", "an iridesce.Stack", ""),
    ),
    (
        lambda: ir.color.convert([0.1, 0.1, 0.1], "xyz", "lab", white=(0.0, 1.0)),
        None,
        *("white", "(0.0, 1.0)", "a name, an Illuminant, (x, y) or (X, Y, Z), all > 0", ""),
    ),
    (
        lambda: ir.color.spectrum_to_xyz([[500.0, 600.0]], [1.0, 1.0]),
        "wavelength_nm must have one axis, got shape (1, 2)",
        *("wavelength_nm", "shape (1, 2)", "have one axis", ""),
    ),
    (
        lambda: ir.color.spectrum_to_xyz([500.0, 600.0], [1.0, 1.0, 1.0]),
        "the last axis of values must match wavelength_nm: shapes (3,) and (2,)",
        *("values", "shape (3,)", "values with 2 entries along the last axis", ""),
    ),
    (
        lambda: ir.color.rgb_matrix("lab"),
        ("space 'lab' has no primaries; RGB spaces: srgb display-p3 rec2020 linear-srgb acescg ntsc1953"),
        *("space", "'lab'", "one of srgb display-p3 rec2020 linear-srgb acescg ntsc1953", ""),
    ),
    (lambda: ir.color.camera(3), None, *("camera", "3", "a name or a path", "")),
    (lambda: ir.color.illuminant(3), None, *("illuminant", "3", "a name, a path or an Illuminant", "")),
    (lambda: ir.ColorTable("air / soap 3 / air"), None, *("stack", "'air / soap 3 / air'", "an iridesce.Stack", "")),
    (lambda: ir.ColorTable(FILM, max_delta_e=[0.1, 0.2]), None, *("max_delta_e", "shape (2,)", "a single number", "")),
    (lambda: ir.ColorTable(FILM, layer=1), None, *("layer", "1", "a whole number from 0 to 0", "")),
    (
        lambda: ir.ColorTable(TWO),
        "layer must say which of the 2 layers varies, 0 to 1 (none holds an array of thicknesses)",
        *("layer", "None", "a whole number from 0 to 1", ""),
    ),
    (
        lambda: ir.ColorTable(BOTH),
        "layer must say which of the 2 layers varies, 0 to 1 (several hold an array of thicknesses)",
        *("layer", "None", "a whole number from 0 to 1", ""),
    ),
    (
        lambda: ir.ColorTable(MANY, layer=1),
        "all layers but the varying one must have one thickness; layer 0 has an array",
        *("layer", "1", "the one whose thickness is an array", ""),
    ),
    (
        lambda: ir.ColorTable(FILM, illuminant=[]),
        "illuminant must not be empty",
        *("illuminant", "[]", "not empty", ""),
    ),
    (
        lambda: ir.ColorTable(FILM, illuminant=["D65", "D65"]),
        "illuminant must not name 'D65' twice",
        *("illuminant", "['D65', 'D65']", "different names", ""),
    ),
    (
        lambda: ir.ColorTable(FILM, quantity=["reflectance", "reflectance"]),
        "quantity must not name 'reflectance' twice",
        *("quantity", "['reflectance', 'reflectance']", "different names", ""),
    ),
    (lambda: TABLE.color(100.0, illuminant="A"), None, *("illuminant", "'A'", "one of the table's, D65", "")),
    (
        lambda: TABLE.color(100.0, quantity="transmittance"),
        None,
        *("quantity", "'transmittance'", "one of the table's, reflectance", ""),
    ),
    (
        lambda: TABLE.ramp(size=(0, 4)),
        None,
        *("size", "(0, 4)", "(width, height), each >= 1, 67108864 pixels at most", ""),
    ),
    (
        lambda: FILM.color_uncertainty([1.0, 2.0]),
        None,
        *("thickness_sd_nm", "shape (2,)", "one number or one a layer (1)", ""),
    ),
    (
        lambda: ir.Stack(["air", ir.Layer("soap", 0.0), "air"]).color_derivatives(space="xyy"),
        'space="xyy" has no derivatives at the colour XYZ = [0.0, 0.0, 0.0]',
        *("space", "'xyy'", "one with derivatives at every colour of the film", ""),
    ),
    (
        lambda: STRIP("air / soap / air", exposure="bright"),
        None,
        *("exposure", "'bright'", '"auto", "common" or stops from -64 to 64', ""),
    ),
    (
        lambda: ir.color.convert([[50.0, 0.0, 0.0], [1e308, 0.0, 0.0]], "lab", "xyz"),
        "the colour [1e+308, 0.0, 0.0] at index (1,) has no finite colour in 'xyz'",
        *("values", "[1e+308, 0.0, 0.0]", "colours with a finite answer", "at index (1,)"),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)
