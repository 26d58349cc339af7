"""What arrays, numbers and file names are refused for: the parts of each message, and its words."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from refused import Case, check

FILM = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])
PICTURE = ir.Image(np.ones((1, 1, 3)))
LOCKED = np.zeros(2)
LOCKED.flags.writeable = False
TWO = [500.0, 550.0]

CASES: list[Case] = [
    (
        lambda: FILM.reflectance([]),
        "wavelength_nm must not be empty, got shape (0,)",
        *("wavelength_nm", "shape (0,)", "not empty", ""),
    ),
    (
        lambda: FILM.reflectance(np.ma.array([550.0], mask=[True])),
        "wavelength_nm must not be a masked array: fill or drop the masked entries",
        *("wavelength_nm", "a masked array", "an array without a mask", ""),
    ),
    (
        lambda: FILM.reflectance(TWO, [0.0, 1.0, 2.0]),
        "wavelength_nm and angle_deg must broadcast: shapes (2,) and (3,)",
        *("wavelength_nm and angle_deg", "(2,) and (3,)", "of shapes that broadcast", ""),
    ),
    (lambda: FILM.reflectance(TWO, out=[0.0, 0.0]), None, *("out", "list", "a numpy array", "")),
    (lambda: FILM.reflectance(TWO, out=np.zeros(2, np.float32)), None, *("out", "float32", "of type float64", "")),
    (
        lambda: FILM.reflectance(TWO, out=np.zeros(3)),
        "out must have the shape of the result, (2,), got (3,)",
        *("out", "(3,)", "of the shape of the result, (2,)", ""),
    ),
    (
        lambda: FILM.reflectance(TWO, out=np.zeros(4)[::2]),
        "out must be in C order (contiguous, last axis fastest)",
        *("out", "another order", "in C order", ""),
    ),
    (lambda: FILM.reflectance(TWO, out=LOCKED), "out must be writable", *("out", "a read-only array", "writable", "")),
    (lambda: FILM.reflectance_averaged(550.0, tolerance="small"), None, *("tolerance", "'small'", "a number", "")),
    (lambda: FILM.color(space=3), None, *("space", "3", "a string", "")),
    (lambda: PICTURE.save(3), None, *("path", "3", "a file name ending in .png or .exr", "")),
    (
        lambda: PICTURE.save("x.xyz"),
        "path must end in .png or .exr, got 'x.xyz'",
        *("path", "'x.xyz'", "a name that ends in .png or .exr", ""),
    ),
    (lambda: PICTURE.save("\0.png"), None, *("path", "'\\x00.png'", "a file name without a zero byte", "")),
    (
        lambda: FILM.reflectance([[550.0], [1.0, 2.0]]),
        None,
        *("wavelength_nm", "[[550.0], [1.0, 2.0]]", "a number or an array of numbers", ""),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)
