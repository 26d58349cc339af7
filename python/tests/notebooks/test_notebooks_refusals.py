"""What widgets and the page refuse: the parts of each message, and its words."""

from __future__ import annotations

import pytest

import iridesce as ir
from iridesce.page import page_link
from refused import Case, check

BARE = ir.Stack(["air", "Si"])
BUBBLE = ir.Scene.load("soap-bubble")
WEDGE = {"wedge": {"from": [0, 0, 0], "to": [1, 0, 0], "start_nm": 1.0, "end_nm": 2.0}}
NM = "object.bubble.surface.film.thickness_nm"

CASES: list[Case] = [
    (
        lambda: ir.widget(BARE),
        "a widget shows a layer that varies, and Stack(['air', 'Si']) has none",
        *("what", "Stack(['air', 'Si'])", "a stack with a layer that varies", ""),
    ),
    (lambda: ir.widget("bubble", thickest_nm=1.0), None, *("thickest_nm", "1.0", "from 50 to 10000", "")),
    (
        lambda: ir.widget("wafer"),
        ("a widget shows a bubble, and this scene has none: an object with a sphere and the surface film"),
        *("scene", "none", "one with a bubble: a sphere and the surface film", ""),
    ),
    (
        lambda: ir.widget(BUBBLE.with_value(NM, 0.0)),
        "the bubble of this scene has no thickness",
        *("scene", "none", "one whose bubble has a thickness", ""),
    ),
    (
        lambda: page_link("soup"),
        "the page has the scenes bubble, rings, slick, titanium, wafer, film, got 'soup'",
        *("scene", "'soup'", "one of bubble, rings, slick, titanium, wafer, film", ""),
    ),
    (
        lambda: ir.widget(BUBBLE.with_value(NM, WEDGE)),
        "a widget shows bubbles whose thickness_nm is a number, a gradient or a flow, got ['wedge']",
        *("scene", "['wedge']", "one whose thickness_nm is a number, a gradient or a flow", ""),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)
