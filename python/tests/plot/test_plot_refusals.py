"""What charts refuse: the parts of each message, and its words."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pytest

import iridesce as ir
from refused import Case, check

SOAP = "air / soap / air"
FILM = "air / soap 320 / air"
TWO = "air / soap 5 / SiO2 5 / air"
STRIP, WHICH = ir.plot.strip, ir.plot.reachable

CASES: list[Case] = [
    (
        lambda: STRIP("newton", thickness_nm=(0.0, 100.0)),
        'thickness_nm and retardation_nm exclude each other, and "newton" has a retardation only',
        *("retardation_nm", "both", "given instead of thickness_nm, or left out", ""),
    ),
    (
        lambda: STRIP(SOAP, (0.0, 100.0), retardation_nm=(0.0, 100.0)),
        'thickness_nm and retardation_nm exclude each other, and "newton" has a retardation only',
        *("retardation_nm", "both", "given instead of thickness_nm, or left out", ""),
    ),
    (
        lambda: STRIP("newton", retardation_nm=(0.0, 1e6)),
        None,
        *("retardation_nm", "1e+06", "at most 100000 nm in a chart (such films have no colour left)", ""),
    ),
    (
        lambda: STRIP([]),
        "stack must not be an empty list",
        *("stack", "an empty list", "one stack or more", ""),
    ),
    (lambda: STRIP(3), None, *("stack", "3", "a Stack, its text, or a list or dict of them", "")),
    (lambda: STRIP(SOAP, [0.0, 1.0, 5.0]), None, *("thickness_nm", "steps from 1 to 4", "evenly spaced", "")),
    (
        lambda: STRIP(["N-BK7 / air / N-BK7"], angle_deg=80.0, retardation_nm=(0.0, 100.0)),
        ("no wave runs through air at 80 degrees from N-BK7 (total reflection), so its retardation has no value"),
        *("angle_deg", "80.0", "below total reflection", ""),
    ),
    (lambda: ir.plot.locus(SOAP, theme="pink"), None, *("theme", "'pink'", '"light", "dark" or None', "")),
    (lambda: ir.plot.locus(SOAP, ax=3), None, *("ax", "3", "a matplotlib Axes or None", "")),
    (
        lambda: ir.plot.spectrum(FILM, ax=plt.figure().add_subplot(projection="polar")),
        "ax must have straight axes, got the projection 'polar'",
        *("ax", "the projection 'polar'", "have straight axes", ""),
    ),
    (lambda: ir.plot.spectrum(FILM, title=3), None, *("title", "3", "text or None", "")),
    (
        lambda: ir.plot.spectrum(FILM, angle_deg=[float(k) for k in range(40)]),
        "40 curves were asked for, a chart shows 24 at most",
        *("stack", "40", "24 curves at most", ""),
    ),
    (
        lambda: ir.plot.spectrum([FILM, SOAP[:6] + "soap 3 / air"], angle_deg=[0.0, 10.0, 20.0, 30.0, 40.0, 50.0]),
        ("6 angles and polarisations were asked for; beside several stacks or quantities a chart shows 4 at most"),
        *("angle_deg", "6", "4 angles and polarisations at most", ""),
    ),
    (
        lambda: ir.plot.spectrum(FILM, [500.0]),
        None,
        *("wavelength_nm", "[500.0]", "two ascending numbers or an ascending array", ""),
    ),
    (lambda: ir.plot.spectrum([3]), None, *("stack", "3", "an iridesce.Stack or its text", "")),
    (
        lambda: ir.plot.spectrum(FILM, quantity=[]),
        None,
        *("quantity", "none", "one or more of 'reflectance', 'transmittance', 'absorptance'", ""),
    ),
    (
        lambda: ir.plot.spectrum(FILM, quantity="shine"),
        None,
        *("quantity", "'shine'", "one or more of 'reflectance', 'transmittance', 'absorptance'", ""),
    ),
    (
        lambda: ir.plot.spectrum(FILM, polarization=["s", "s"]),
        "polarization must not name the same twice, got ['s', 's']",
        *("polarization", "['s', 's']", "different ones", ""),
    ),
    (
        lambda: ir.plot.locus("air / air 5 / air"),
        "air / air / air is black at every thickness asked for: it has no path",
        *("stack", "air / air / air", "a film with light in it", ""),
    ),
    (lambda: ir.plot.locus(SOAP, tick_nm=0.0), None, *("tick_nm", "0.0", "> 0, in nm, or None", "")),
    (
        lambda: ir.plot.locus(SOAP, (0.0, 1000.0), tick_nm=0.1),
        "tick_nm=0.1 asks for more than 1000 dots",
        *("tick_nm", "0.1", "one that makes 1000 dots at most", ""),
    ),
    (lambda: ir.plot.locus(SOAP, angle_deg=[0.0, 1.0]), None, *("angle_deg", "shape (2,)", "one number here", "")),
    (
        lambda: ir.plot.locus(SOAP, (0.0, 1e9)),
        None,
        *("thickness_nm", "1e+09", "at most 100000 nm in a chart (such films have no colour left)", ""),
    ),
    (
        lambda: ir.plot.locus(SOAP, [100.0]),
        None,
        *("thickness_nm", "[100.0]", "two numbers, the ends of a range, or an ascending array", ""),
    ),
    (
        lambda: ir.plot.chart(SOAP, angle_deg=[0.0]),
        None,
        *("angle_deg", "[0.0]", "two ascending numbers or an ascending array", ""),
    ),
    (lambda: ir.plot.locus(3), None, *("stack", "3", "an iridesce.Stack or its text", "")),
    (
        lambda: ir.plot.locus("air / soap / SiO2 / air"),
        "only one layer of a chart may leave out its thickness, got 'air / soap / SiO2 / air'",
        *("stack", "'air / soap / SiO2 / air'", "a stack of which one layer at most leaves out its thickness", ""),
    ),
    (
        lambda: ir.plot.locus("air / soap / SiO2 / air", layer=1),
        "only one layer of a chart may leave out its thickness, got 'air / soap / SiO2 / air'",
        *("stack", "'air / soap / SiO2 / air'", "a stack of which one layer at most leaves out its thickness", ""),
    ),
    (
        lambda: ir.plot.locus("air / soap 5 / SiO2 ? / air", layer=1),
        "item 3 of the stack, 'SiO2 ?': a layer that does not grow needs its thickness in nm",
        *("thickness_nm", "nothing", "given for a layer that does not grow", "in item 3 of the stack, 'SiO2 ?'"),
    ),
    (
        lambda: ir.plot.locus("air / air"),
        "a chart needs a layer that grows, got 'air / air', which has none",
        *("stack", "air / air", "a stack with a layer that grows", ""),
    ),
    (
        lambda: ir.plot.locus(TWO),
        (
            "'air / soap 5 nm / SiO2 5 nm / air' has 2 layers: say which grows, by layer=1 to 2 or the "
            'name of its medium, or in text by "?" for its thickness'
        ),
        *("layer", "None", "1 to 2 or the name of a medium", ""),
    ),
    (lambda: ir.plot.locus(TWO, layer=3), None, *("layer", "3", "1 to 2 or the name of a medium", "")),
    (
        lambda: ir.plot.locus(TWO, layer="water"),
        "layer must name one of the layers soap, SiO2; no layer of 'water'",
        *("layer", "'water'", "the name of one of the layers soap, SiO2", ""),
    ),
    (
        lambda: ir.plot.medium("soap", [500.0]),
        None,
        *("wavelength_nm", "[500.0]", "two ascending numbers or an ascending array", ""),
    ),
    (lambda: WHICH(media="SiO2", substrate="Si"), None, *("media", "'SiO2'", "a list of one or more media", "")),
    (
        lambda: WHICH(media=["SiO2"], substrate="Si", thickness_range_nm=(5.0, 1.0)),
        None,
        *("thickness_range_nm", "(5.0, 1.0)", "(low, high) with low < high", ""),
    ),
    (
        lambda: WHICH(media=["SiO2"], substrate="Si", layers=(1,), lightness=(99.0, 100.0)),
        "no film of these media has a lightness within (99.0, 100.0)",
        *("lightness", "(99.0, 100.0)", "one that some film of these media has", ""),
    ),
    (
        lambda: WHICH(media=["SiO2"], substrate="Si", layers=(1,), target=[[1.0, 2.0, 3.0]]),
        None,
        *("target", "[[1.0, 2.0, 3.0]]", "three numbers", ""),
    ),
    (
        lambda: STRIP("newton", retardation_nm=[0.0, 5e4]),
        None,
        *("retardation_nm", "50000", "at most 30000 nm", ""),
    ),
    (
        lambda: ir.plot.medium(ir.Medium._from_text("nm,n,k\n500,1.5,0\n", "one.csv")),
        'medium "one.csv" has data at 500 nm only: that is no curve',
        *("media", "'one.csv'", "media with data at more than one wavelength", ""),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)
