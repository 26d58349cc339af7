"""What thickness models, maps and films that flow refuse: the parts of each message, and its words."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from iridesce.thickness import ThicknessMap, ThicknessModel, flow, gradient, lens_gap, simulate, wedge
from iridesce.thickness import map as map_
from refused import Case, check

GRID = ThicknessMap([[1.0, 2.0], [3.0, 4.0]])
SLOPE = wedge((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0, 100.0)
PRESETS = f"one of {', '.join(ir.thickness.presets())}"

CASES: list[Case] = [
    (lambda: simulate("soup"), None, *("preset", "'soup'", PRESETS, "")),
    (lambda: simulate("late", frames_per_second=0.0), None, *("frames_per_second", "0.0", "from 0.001 to 1e6", "")),
    (lambda: simulate("late", checkpoint="no"), None, *("checkpoint", "str", "bytes or None", "")),
    (
        lambda: simulate("late", initial=[1.0, 2.0]),
        "initial must have the shape (rows, columns), both >= 1, got (2,)",
        *("initial", "(2,)", "have the shape (rows, columns), both >= 1", ""),
    ),
    (
        lambda: simulate("late", initial=[[0.0]]),
        "initial must hold some liquid, got 0.0 everywhere",
        *("initial", "0.0 everywhere", "hold some liquid", ""),
    ),
    (
        lambda: simulate("late", initial=[[1.0]], noise=0.1),
        "initial and noise exclude each other: the thickness at the start is given, got both",
        *("noise", "both", "left out beside initial", ""),
    ),
    (lambda: simulate("late", initial="soup"), None, *("initial", "'soup'", "real numbers", "")),
    (
        lambda: ThicknessMap([1.0, 2.0]),
        "thickness_nm must have the shape (height, width), both >= 1, got (2,)",
        *("thickness_nm", "(2,)", "have the shape (height, width), both >= 1", ""),
    ),
    (lambda: ThicknessMap("thick"), None, *("thickness_nm", "'thick'", "real numbers", "")),
    (lambda: ThicknessMap.load("x.tif", channel=3), None, *("channel", "3", "a string or None", "")),
    (lambda: ThicknessMap.load("x.tif", page=1.5), None, *("page", "1.5", "a whole number >= 1 or None", "")),
    (lambda: ThicknessMap.load("x.tif", page=0), None, *("page", "0", "a whole number >= 1 or None", "")),
    (
        lambda: GRID.sample([0.5, 0.5], [0.5, 0.5, 0.5]),
        "u and v must broadcast: shapes (2,) and (3,)",
        *("u and v", "(2,) and (3,)", "of shapes that broadcast", ""),
    ),
    (lambda: GRID.sample([0.5, np.nan], 0.5), None, *("u", "nan", "finite", "at index (1,)")),
    (
        lambda: GRID.save("x.jpg"),
        "path must end in .tif, .tiff, .exr, .npy, got 'x.jpg'",
        *("path", "'x.jpg'", "end in .tif, .tiff, .exr, .npy", ""),
    ),
    (
        lambda: GRID.save("x.npy", pixel_size=0.5),
        "pixel_size goes with a TIFF file, got 'x.npy'",
        *("pixel_size", "0.5", "left out unless the file is a TIFF", ""),
    ),
    (lambda: GRID.save("x.tif", pixel_size=0.5, unit=""), None, *("unit", "''", 'a short ASCII text such as "mm"', "")),
    (
        lambda: GRID.save("x.tif", pixel_size=(0.5, 0.0)),
        None,
        *("pixel_size", "(0.5, 0.0)", "one or two lengths from 1e-6 to 1e6", ""),
    ),
    (
        lambda: ThicknessMap([[1e300]]).save("x.tif"),
        "a map with 1e+300 nm does not fit single precision",
        *("thickness_nm", "1e+300", "within single precision", ""),
    ),
    (lambda: flow("soup", 1.0), None, *("preset", "'soup'", PRESETS, "")),
    (lambda: flow("late", -1.0), None, *("time_s", "-1.0", "from 0 to 600 s", "")),
    (
        lambda: ThicknessModel("wavy", {}),
        None,
        *("kind", "'wavy'", 'one of "uniform", "gradient", "wedge", "lens_gap", "map", "flow"', ""),
    ),
    (
        lambda: gradient(0.0, 1.0).at_radius(1.0),
        "a gradient is not asked by at_radius; use at_height",
        *("model", "at_radius", "asked by its own method", ""),
    ),
    (lambda: gradient(0.0, 1.0).map(0, 4), None, *("width", "0", "a whole number >= 1", "")),
    (
        lambda: gradient(0.0, 1.0).map(4, 4, extent=(0.0, 1.0, 0.0, 1.0)),
        "extent is for a wedge or a gap under a lens; a gradient spans the whole object",
        *("extent", "(0.0, 1.0, 0.0, 1.0)", "left out for a gradient", ""),
    ),
    (lambda: SLOPE.map(4, 4, extent=(0.0, 1.0)), None, *("extent", "(0.0, 1.0)", "left, right, bottom and top", "")),
    (
        lambda: SLOPE.at_point([1.0, 2.0]),
        "points must have a last axis of 3 coordinates, got the shape (2,)",
        *("points", "the shape (2,)", "have a last axis of 3 coordinates", ""),
    ),
    (
        lambda: wedge((0.0, 0.0), (1.0, 0.0, 0.0), 0.0, 100.0),
        None,
        *("from_point", "(0.0, 0.0)", "three numbers, x, y and z", ""),
    ),
    (lambda: lens_gap(1000.0).at_radius([0.0, np.inf]), None, *("distance_mm", "inf", "finite", "at index (1,)")),
    (lambda: map_("x.png", -1.0, 100.0), None, *("min_nm", "-1.0", ">= 0 and finite", "")),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)


def test_a_checkpoint_is_refused_at_another_rate() -> None:
    film = simulate("bubble-on-bath-small-preview", time_s=0.01, frames_per_second=1000.0)
    next(film), next(film)
    case = (
        lambda: simulate(
            "bubble-on-bath-small-preview", time_s=0.01, frames_per_second=300.0, checkpoint=film.checkpoint()
        ),
        "the checkpoint is at 0.001 s, between two frames of frames_per_second 300; give the one that it was made with",
        *("frames_per_second", "300.0", "the rate that the checkpoint was made with", ""),
    )
    check(case)
