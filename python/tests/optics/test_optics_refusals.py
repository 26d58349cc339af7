"""What media, layers and stacks refuse: argument, value, what is allowed and place of each message, and its words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from refused import Case, check

FILM = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])
SLAB = ir.Stack(["air", ir.Layer("N-BK7", 1e6, coherent=False), "air"])
MANY = ir.Stack(["air", *[ir.Layer("N-BK7", 1e6, coherent=False)] * 30, "air"])
DARK = ir.Stack(["air", ir.Layer("Ag", 20.0), "air"])
MIXED, GRADED = ir.Medium.mixture, ir.Layer.graded

CASES: list[Case] = [
    (
        lambda: ir.Medium(Path("soap.csv")),
        (
            "a medium is a built-in name, a real or complex number or a Medium, got the path "
            "'soap.csv'; a file is read by Medium.from_file(path)"
        ),
        *("medium", "PosixPath('soap.csv')", "a built-in name, a real or complex number or a Medium", ""),
    ),
    (
        lambda: ir.Medium(b"soap"),
        "a medium is a built-in name, a real or complex number or a Medium, got bytes b'soap'",
        *("medium", "b'soap'", "a built-in name, a real or complex number or a Medium", ""),
    ),
    (
        lambda: ir.Medium(np.array([1.3, 1.4])),
        ("a medium is a built-in name, a real or complex number or a Medium, got an array of shape (2,)"),
        *("medium", "an array of shape (2,)", "a built-in name, a real or complex number or a Medium", ""),
    ),
    (
        lambda: ir.Medium("soap\ud800"),
        "unknown medium 'soap\\ud800'",
        *("medium", "'soap\\ud800'", "a built-in name", ""),
    ),
    (
        lambda: ir.Medium("main/nothing/nobody"),
        '"main/nothing/nobody" is neither a built-in medium nor a page of refractiveindex.info',
        *("medium", "'main/nothing/nobody'", "a built-in medium or a page of refractiveindex.info", ""),
    ),
    (lambda: ir.Medium.from_file(3), None, *("path", "int 3", "a path", "")),
    (lambda: ir.Medium("soap").index(500.0, extrapolate="far"), None, *("extrapolate", "'far'", 'None or "hold"', "")),
    (
        lambda: ir.Medium("soap").index(np.ma.array([500.0], mask=[True])),
        None,
        *("wavelength_nm", "a masked array", "an array without a mask", ""),
    ),
    (
        lambda: ir.Medium("soap").index([[500.0], [1.0, 2.0]]),
        None,
        *("wavelength_nm", "rows of different lengths", "numbers in an array or a scalar", ""),
    ),
    (lambda: ir.Medium("soap").index("blue"), None, *("wavelength_nm", "str 'blue'", "real numbers", "")),
    (lambda: MIXED("air", "SiO2", 1.5), None, *("fraction", "float 1.5", "a number from 0 to 1", "")),
    (lambda: MIXED("air", "SiO2", "half"), None, *("fraction", "str 'half'", "a number from 0 to 1", "")),
    (lambda: MIXED("air", "SiO2", 0.5, 3), None, *("rule", "int 3", "a string", "")),
    (
        lambda: MIXED("water", "glycerol", 0.5, weight_density=(0.0, 1.0)),
        None,
        *(
            "weight_density",
            "tuple (0.0, 1.0)",
            "two or three densities > 0: of the first, of the second, of the mixture",
            "",
        ),
    ),
    (
        lambda: MIXED("water", "glycerol", 0.5, weight_density="heavy"),
        None,
        *(
            "weight_density",
            "str 'heavy'",
            "two or three densities > 0: of the first, of the second, of the mixture",
            "",
        ),
    ),
    (
        lambda: MIXED("water", "glycerol", 0.5, "bruggeman", weight_density=(1.0, 1.2, 1.1)),
        ("a density of the mixture is for rule=\"lorentz-lorenz\" only, got tuple (1.0, 1.2, 1.1) for 'bruggeman'"),
        *("weight_density", "(1.0, 1.2, 1.1)", 'two densities unless rule is "lorentz-lorenz"', ""),
    ),
    (
        lambda: ir.Stack.parse(3),
        'a stack as text looks like "air / soap 320 / air", got 3',
        *("stack", "3", 'text like "air / soap 320 / air"', ""),
    ),
    (
        lambda: ir.Stack.parse("air /  / air"),
        'item 2 of the stack is empty; it should look like "air / soap 320 / air"',
        *("stack", "nothing", 'items like those of "air / soap 320 / air"', "for item 2"),
    ),
    (
        lambda: ir.Stack.parse("air 3 / soap 3 / air"),
        "item 1 of the stack, 'air 3': the first and the last item are a medium without thickness",
        *(
            "stack",
            "a thickness",
            "one that starts and ends with a medium without thickness",
            "in item 1 of the stack, 'air 3'",
        ),
    ),
    (
        lambda: ir.Stack.parse("air / 1.5+ 3 / air"),
        "item 2 of the stack, '1.5+ 3': an index is written n or n+kj, got '1.5+'",
        *("index", "'1.5+'", "n or n+kj", "in item 2 of the stack, '1.5+ 3'"),
    ),
    (
        lambda: ir.Stack("air / air"),
        "a Stack takes a list, got 'air / air'; Stack.parse reads text like \"air / soap 320 / air\"",
        *("stack", "'air / air'", "a list of media and layers", ""),
    ),
    (
        lambda: ir.Stack("air / " * 99),
        (
            "a Stack takes a list, got 'air / air / air / air / air / air / air / air / air / ai...; "
            'Stack.parse reads text like "air / soap 320 / air"'
        ),
        *("stack", "'air / air / air / air / air / air / air / air / air / ai...", "a list of media and layers", ""),
    ),
    (
        lambda: ir.Stack(3),
        "a Stack takes a list of media and layers, got 3",
        *("stack", "3", "a list of media and layers", ""),
    ),
    (
        lambda: ir.Stack([ir.Layer("soap", 1.0), "air"]),
        None,
        *("item 0 of a Stack", "Layer('soap', thickness_nm=1.0)", "a medium without thickness", ""),
    ),
    (
        lambda: ir.Stack(["air", "soap", "air"]),
        None,
        *("item 1 of a Stack", "'soap'", "a Layer(medium, thickness_nm=...)", ""),
    ),
    (
        lambda: FILM.amplitudes(550.0, 0.0, "unpolarized"),
        'amplitudes exist for polarization "s" or "p" only, got "unpolarized"',
        *("polarization", "'unpolarized'", '"s" or "p"', ""),
    ),
    (
        lambda: SLAB.amplitudes(550.0, 0.0, "s"),
        (
            "amplitudes of a stack need coherent layers; layer 1, Layer('N-BK7', "
            "thickness_nm=1000000.0, coherent=False), is incoherent"
        ),
        *("stack", "Layer('N-BK7', thickness_nm=1000000.0, coherent=False)", "one of coherent layers", "for layer 1"),
    ),
    (
        lambda: SLAB.ellipsometry(550.0, 60.0),
        (
            "ellipsometry of a stack need coherent layers; layer 1, Layer('N-BK7', "
            "thickness_nm=1000000.0, coherent=False), is incoherent"
        ),
        *("stack", "Layer('N-BK7', thickness_nm=1000000.0, coherent=False)", "one of coherent layers", "for layer 1"),
    ),
    (
        lambda: SLAB.two_beam_purity(550.0),
        (
            "the two-beam form takes exactly one layer, a coherent one, got Stack(['air', "
            "Layer('N-BK7', thickness_nm=1000000.0, cohe..."
        ),
        *(
            "stack",
            "Stack(['air', Layer('N-BK7', thickness_nm=1000000.0, cohe...",
            "one of exactly one layer, a coherent one, for the two-beam form",
            "",
        ),
    ),
    (
        lambda: DARK.two_beam_purity(550.0),
        "the two-beam form takes real indices: every medium must have k = 0",
        *("stack", "an absorbing one", "one of media with k = 0 for the two-beam form", ""),
    ),
    (
        lambda: MANY.two_beam_purity(550.0),
        (
            "the two-beam form takes exactly one layer, a coherent one, got Stack(['air', "
            "Layer('N-BK7', thickness_nm=1000000.0, cohe..."
        ),
        *(
            "stack",
            "Stack(['air', Layer('N-BK7', thickness_nm=1000000.0, cohe...",
            "one of exactly one layer, a coherent one, for the two-beam form",
            "",
        ),
    ),
    (lambda: ir.Layer("soap", 1.0, coherent="no"), None, *("coherent", "'no'", "True or False", "")),
    (
        lambda: GRADED(100.0, lambda depth: 1.5, "SiO2"),
        "first is a function of the depth: second and profile must be None, got 'SiO2' and None",
        *("second", "'SiO2'", "None where first is a function of the depth", ""),
    ),
    (
        lambda: GRADED(100.0, lambda depth: 1.5, None, 3),
        "first is a function of the depth: second and profile must be None, got None and 3",
        *("profile", "3", "None where first is a function of the depth", ""),
    ),
    (
        lambda: GRADED(100.0, "air"),
        None,
        *("second", "None", "a medium, unless first is a function of the depth in nm", ""),
    ),
    (lambda: GRADED(100.0, "air", "SiO2", 3), None, *("profile", "3", "None or a function of the depth (0 to 1)", "")),
    (
        lambda: GRADED(100.0, "air", "SiO2", lambda depth: 2.0),
        "profile must give shares from 0 to 1, got 2.0 at depth 0",
        *("profile", "2.0", "a function that gives shares from 0 to 1", "at depth 0"),
    ),
    (
        lambda: GRADED(100.0, "air", "SiO2", tolerance=[1e-5, 1e-4]),
        None,
        *("tolerance", "shape (2,)", "one number", ""),
    ),
    (
        lambda: FILM.field_profile([[0.0]], 550.0),
        "depth_nm must have one axis, got shape (1, 1)",
        *("depth_nm", "shape (1, 1)", "have one axis", ""),
    ),
    (
        lambda: SLAB.field_profile([0.0], 550.0),
        (
            "fields of a stack need coherent layers; layer 1, Layer('N-BK7', thickness_nm=1000000.0, "
            "coherent=False), is incoherent"
        ),
        *("stack", "Layer('N-BK7', thickness_nm=1000000.0, coherent=False)", "one of coherent layers", "for layer 1"),
    ),
    (
        lambda: FILM.reflectance_averaged(550.0, thickness_sd_nm=[1.0, 2.0]),
        None,
        *("thickness_sd_nm", "shape (2,)", "one number a layer (1 of them)", ""),
    ),
    (
        lambda: SLAB.reflectance_averaged(550.0, thickness_sd_nm=1.0),
        "thickness_sd_nm of an incoherent slab must be 0 (layer 1), got 1; it has no phase",
        *("thickness_sd_nm", "1.0", "0 for an incoherent slab", "for layer 1"),
    ),
    (
        lambda: FILM.to_xarray([550.0], quantity=()),
        "quantity and polarization must name one or more",
        *("quantity", "none", "one or more", ""),
    ),
    (
        lambda: FILM.to_xarray([550.0], polarization=()),
        "quantity and polarization must name one or more",
        *("polarization", "none", "one or more", ""),
    ),
    (
        lambda: FILM.to_xarray([[550.0, 560.0]]),
        "wavelength_nm must have one axis or none, got shape (1, 2)",
        *("wavelength_nm", "shape (1, 2)", "have one axis or none", ""),
    ),
    (
        lambda: MANY.mueller(550.0),
        (
            "the Mueller matrix of a stack takes at most 2 incoherent slabs, got 30 in Stack(['air', "
            "Layer('N-BK7', thickness_nm=1000000.0, cohe..."
        ),
        *("stack", "30", "one of at most 2 incoherent slabs", ""),
    ),
    (
        lambda: ir.Medium(10**400),
        "a medium is a built-in name, a real or complex number or a Medium, got int 1" + 59 * "0" + "...",
        *("medium", "1" + 56 * "0" + "...", "a built-in name, a real or complex number or a Medium", ""),
    ),
    (
        lambda: ir.fit_thickness([500.0], [0.1], ir.Stack(["air", ir.Layer("soap", [1.0, 2.0]), "air"])),
        "a fit needs one thickness a layer, got 2 for layer 1",
        *("thickness_nm", "2", "one number a layer", "for layer 1"),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)
