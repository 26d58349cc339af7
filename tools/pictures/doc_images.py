"""Draw the small pictures of the documentation that are computed: docs/images/{range,method,chart}-*.png.

    python tools/pictures/doc_images.py            # all of them, about a minute
    python tools/pictures/doc_images.py range      # those whose name begins so
    python tools/pictures/doc_images.py --list

Colours are those of `Stack.color`, exposed so that the brightest of a picture is nearly white and brought into sRGB with
their hue kept. Nothing is drawn by hand: every picture follows from the call written in its function.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import published_charts as charts
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import iridesce as ir

Floats = NDArray[np.float64]

IMAGES = Path(__file__).resolve().parents[2] / "docs" / "images"
INK = "#333333"
STYLE = {
    "font.size": 8,
    "font.family": "DejaVu Sans",
    "axes.edgecolor": "#999999",
    "axes.linewidth": 0.6,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "figure.dpi": 110,
    "savefig.dpi": 110,
}

PICTURES: dict[str, Callable[[], Figure]] = {}


def picture(function: Callable[[], Figure]) -> Callable[[], Figure]:
    """List a function under the file name that its own name gives."""
    PICTURES[function.__name__.replace("_", "-")] = function
    return function


# ---------------------------------------------------------------------------------------------------------------------
# Parts


def srgb(xyz: Floats, brightest: float | None = None, exposure: float = 0.8) -> Floats:
    """XYZ as a screen shows it: the brightest gets a luminance of `exposure`, hues are kept.

    At an exposure of 1 the brightest would be white, whatever its colour.
    """
    exposed = exposure * xyz / (xyz[..., 1].max() if brightest is None else brightest)
    return ir.color.map_gamut(ir.color.convert(exposed, "xyz", "srgb"), "srgb", "hue")[0]


def film(medium: Any, thickness_nm: Any, first: Any = "air", last: Any = "air") -> ir.Stack:
    return ir.Stack([first, ir.Layer(medium, thickness_nm), last])


def bare(axes: Axes) -> None:
    """No ticks on the left, no frame above."""
    axes.set_yticks([])
    for side in ("top", "left", "right"):
        axes.spines[side].set_visible(False)


def strip(axes: Axes, xyz: Floats, x: Floats, label: str, brightest: float | None = None) -> None:
    """A band of colours over x, with its name on the left."""
    axes.imshow(srgb(xyz, brightest)[None], extent=(x[0], x[-1], 0.0, 1.0), aspect="auto", interpolation="nearest")
    axes.set_ylabel(label, rotation=0, ha="right", va="center", labelpad=4)
    bare(axes)


def strips(rows: list[tuple[str, Floats, Floats]], xlabel: str, exposures: tuple[float, ...] | None = None) -> Figure:
    """Bands under each other over one axis; rows of (label, x, XYZ), each exposed by itself."""
    figure, all_axes = plt.subplots(
        len(rows), 1, figsize=(6.4, 0.34 * len(rows) + 0.45), sharex=True, squeeze=False, layout="constrained"
    )
    figure.get_layout_engine().set(hspace=0.0, h_pad=0.01)
    for axes, (label, x, xyz), exposure in zip(all_axes[:, 0], rows, exposures or len(rows) * (0.8,), strict=True):
        strip(axes, xyz, x, label, brightest=xyz[:, 1].max() * 0.8 / exposure)
        axes.tick_params(bottom=axes is all_axes[-1, 0])
    all_axes[-1, 0].set_xlabel(xlabel)
    return figure


def chart(axes: Axes, xyz: Floats, x: Floats, y: Floats, xlabel: str, ylabel: str) -> None:
    """A plane of colours: rows of `xyz` are y upwards, columns x."""
    extent = (x[0], x[-1], y[0], y[-1])
    axes.imshow(srgb(xyz), extent=extent, aspect="auto", origin="lower", interpolation="bilinear")
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel)


def wide(height: float = 2.2) -> tuple[Figure, Axes]:
    figure, axes = plt.subplots(figsize=(6.4, height), layout="constrained")
    return figure, axes


# ---------------------------------------------------------------------------------------------------------------------
# docs/guide/worked-example.md: the ranges


@picture
def range_thickness() -> Figure:
    """A free soap film in three spans of thickness."""
    figure, all_axes = plt.subplots(4, 1, figsize=(6.4, 3.4), layout="constrained")
    spans = (("black film", 120.0), ("bubble", 1200.0), ("young film", 5000.0), ("thick film", 20000.0))
    for axes, (label, end) in zip(all_axes, spans, strict=True):
        nm = np.linspace(0.0, end, 1200)
        strip(axes, film("soap", nm).color(), nm, label, brightest=0.079)
    all_axes[-1].set_xlabel("thickness of the film, nm")
    return figure


@picture
def range_n2() -> Figure:
    """Index of a free film against its thickness: the colours move in proportion to 1 / n2 and grow brighter."""
    figure, axes = wide()
    nm, n2 = np.linspace(0.0, 1000.0, 640), np.linspace(1.1, 2.4, 160)
    rows = [film(complex(n), nm).color() for n in n2]
    xyz = np.array([row / row[:, 1].max() for row in rows])
    chart(axes, xyz, nm, n2, "thickness, nm (each row exposed by itself)", "index n2 of the film")
    return figure


@picture
def range_n3() -> Figure:
    """Index of what lies under the film: purity eps is at its best at n3 = n1 and at n3 = n2^2 / n1."""
    figure, axes = wide()
    nm, n3 = np.linspace(0.0, 1000.0, 640), np.linspace(1.0, 2.4, 160)
    rows = [film(1.5, nm, last=complex(n)).color() for n in n3]
    xyz = np.array([row / row[:, 1].max() for row in rows])
    chart(axes, xyz, nm, n3, "thickness of a film of n2 = 1.5, nm (each row exposed by itself)", "index n3 below it")
    for value, name in ((1.5, "n3 = n2: no film"), (2.25, "n3 = n2$^2$")):
        axes.axhline(value, color=INK, linewidth=0.6, linestyle=":")
        axes.text(990.0, value + 0.02, name, color=INK, ha="right", va="bottom", fontsize=7)
    return figure


@picture
def range_angle() -> Figure:
    """Angle against thickness: tilting a film makes it act thinner."""
    figure, axes = wide()
    nm, angle_deg = np.linspace(0.0, 1000.0, 640), np.linspace(0.0, 85.0, 170)
    rows = film("soap", nm[None, :]).color(angle_deg=angle_deg[:, None])
    xyz = rows / rows[..., 1].max(axis=1)[:, None, None]
    chart(axes, xyz, nm, angle_deg, "thickness of a soap film, nm (each row exposed by itself)", "angle, degrees")
    return figure


@picture
def range_wavelength() -> Figure:
    """One wavelength at a time: fringes of lambda / (2 n2), each in the colour of its light."""
    figure, axes = wide()
    nm, wavelength_nm = np.linspace(0.0, 1000.0, 640), np.linspace(400.0, 700.0, 150)
    reflectance = film("soap", nm[None, :]).reflectance(wavelength_nm[:, None])
    hue = ir.color.color_matching(wavelength_nm)
    hue = hue / hue.sum(axis=1, keepdims=True)
    white = ir.color.illuminant("D65").white()
    rgb = ir.color.map_gamut(ir.color.convert(0.5 * white + 0.5 * hue, "xyz", "linear-srgb"), "linear-srgb", "hue")[0]
    rgb = (rgb - rgb.min(axis=1, keepdims=True)) / (rgb.max(axis=1) - rgb.min(axis=1))[:, None]
    light = rgb[:, None, :] * (reflectance / reflectance.max())[..., None]
    extent = (nm[0], nm[-1], wavelength_nm[0], wavelength_nm[-1])
    encoded = ir.color.convert(ir.color.convert(light, "linear-srgb", "xyz"), "xyz", "srgb").clip(0.0, 1.0)
    axes.imshow(encoded, extent=extent, aspect="auto", origin="lower", interpolation="bilinear")
    axes.set_xlabel("thickness of a soap film, nm")
    axes.set_ylabel("wavelength, nm")
    return figure


@picture
def range_illuminant() -> Figure:
    """The same soap film under six lamps, each as an eye sees it that has adapted to the lamp."""
    nm = np.linspace(0.0, 1500.0, 1200)
    rows = []
    for name, label in (("D65", "D65"), ("A", "A"), ("FL2", "F2"), ("FL11", "F11"), ("LED-B1", "LED-B1")):
        rows.append((label, nm, film("soap", nm).color(illuminant=name, space="linear-srgb", adaptation="bradford")))
    rows = [(label, x, ir.color.convert(rgb, "linear-srgb", "xyz")) for label, x, rgb in rows]
    # A line has no white to adapt to: it keeps its own yellow, which a screen shows at half its brightness only.
    rows.append(("sodium", nm, film("soap", nm).color(illuminant="lines:589.158*2,589.756")))
    return strips(rows, "thickness of a soap film, nm", exposures=(*5 * (0.8,), 0.42))


@picture
def range_films() -> Figure:
    """Films that people meet, on what they meet them on."""
    nm = np.linspace(0.0, 1000.0, 1200)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rows = [
            ("soap film in air", nm, film("soap", nm).color()),
            ("air gap in glass", nm, film("air", nm, "N-BK7", "N-BK7").color()),
            ("oil (n = 1.47) on water", nm, film(1.47, nm, "air", "water").color()),
            ("MgF2 on glass", nm, film("MgF2", nm, "air", "N-BK7").color()),
            ("SiO2 on silicon", nm, film("SiO2", nm, "air", "Si").color()),
            ("TiO2 on titanium", nm, film("TiO2", nm, "air", "Ti").color()),
            ("Nb2O5 on niobium", nm, film("Nb2O5", nm, "air", "Nb").color()),
        ]
    return strips(rows, "thickness of the film, nm (each row exposed by itself)")


@picture
def range_bubbles() -> Figure:
    """The built-in bubble with films of one thickness each."""
    thicknesses = (30.0, 120.0, 240.0, 400.0, 1000.0, 5000.0)
    figure, all_axes = plt.subplots(1, len(thicknesses), figsize=(6.4, 1.2))
    figure.subplots_adjust(left=0.0, right=1.0, bottom=0.0, top=0.86, wspace=0.03)
    scene = ir.Scene.load("soap-bubble")
    for axes, thickness_nm in zip(all_axes, thicknesses, strict=True):
        still = scene.with_value("object.bubble.surface.film.thickness_nm", thickness_nm)
        image = ir.render(still, size=(112, 112), samples=32)
        axes.imshow(image.rgb(exposure="auto"))
        axes.set_title(f"{thickness_nm:.0f} nm", fontsize=8, pad=2)
        axes.axis("off")
    return figure


# ---------------------------------------------------------------------------------------------------------------------
# docs/evidence/interference-color-1991.md


def horseshoe(axes: Axes) -> None:
    """The spectrum locus and the line of purples."""
    nm = np.arange(400.0, 701.0, 1.0)
    xyz = ir.color.color_matching(nm)
    xy = xyz[:, :2] / xyz.sum(axis=1, keepdims=True)
    axes.plot(*np.vstack([xy, xy[:1]]).T, color="#777777", linewidth=0.8)
    for mark in (460, 480, 500, 520, 540, 560, 580, 600, 620):
        x, y = xy[mark - 400]
        out = np.array([x, y]) - 0.333
        out *= 0.03 / np.hypot(*out)
        axes.plot(x, y, ".", color="#777777", markersize=2)
        axes.text(x + out[0], y + out[1], str(mark), fontsize=6, ha="center", va="center", color="#777777")


def path(axes: Axes, xyz: Floats, nm: Floats, marks: tuple[float, ...]) -> None:
    """The path of chromaticity as a film thickens, each piece in its own colour."""
    xy = xyz[:, :2] / xyz.sum(axis=1, keepdims=True)
    bright = xyz / xyz[:, 1:2] * 0.35  # one luminance, so that dark stretches show their hue
    colours = ir.color.map_gamut(ir.color.convert(bright, "xyz", "srgb"), "srgb", "hue")[0]
    for i in range(len(nm) - 1):
        axes.plot(*xy[i : i + 2].T, color=colours[i], linewidth=1.8, solid_capstyle="round")
    for mark in marks:
        i = int(np.abs(nm - mark).argmin())
        axes.plot(*xy[i], "o", color=INK, markersize=1.8)
        axes.annotate(f"{mark:.0f}", xy[i], xytext=(3, 2), textcoords="offset points", fontsize=6)


@picture
def method_locus() -> Figure:
    """The figure of 1991: the path of a soap film's colour, on the road of 1991 and exact."""
    figure, both = plt.subplots(1, 2, figsize=(6.8, 3.9), sharex=True, sharey=True, layout="constrained")
    nm = np.arange(20.0, 1500.0, 2.0)
    marks = (100.0, 160.0, 200.0, 240.0, 280.0, 320.0, 340.0, 380.0, 420.0, 480.0, 500.0)
    roads = (
        ("1991: two beams, illuminant C, NTSC", ir.color.dias1991(film(1.33, nm))[0], "C", "ntsc1953"),
        ("exact, dispersive: water, D65, sRGB", film("water", nm).color(), "D65", "srgb"),
    )
    primaries = {
        "ntsc1953": ((0.67, 0.33), (0.21, 0.71), (0.14, 0.08)),
        "srgb": ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06)),
    }
    for axes, (title, xyz, light, space) in zip(both, roads, strict=True):
        horseshoe(axes)
        corners = np.array([*primaries[space], primaries[space][0]])
        axes.plot(*corners.T, color="#aaaaaa", linewidth=0.7, linestyle="--")
        path(axes, xyz, nm, marks)
        axes.plot(*ir.color.illuminant(light).xy, "+", color="black", markersize=7, markeredgewidth=0.8)
        axes.set_title(title, fontsize=8)
        axes.set_xlabel("x")
        axes.set_aspect("equal")
        axes.set(xlim=(0.0, 0.76), ylim=(0.0, 0.88))
    both[0].set_ylabel("y")
    return figure


def halves(axes: Axes, left: Floats, right: Floats, inside: NDArray[np.bool_], captions: tuple[str, str]) -> None:
    """The left half of one picture beside the right half of another."""
    middle = left.shape[1] // 2
    shown = np.where(np.arange(left.shape[1])[None, :, None] < middle, left, right)
    shown[~inside] = 0.0
    axes.imshow(shown, interpolation="bilinear")
    axes.axvline(middle - 0.5, color="white", linewidth=0.8, ymin=0.005, ymax=0.995)
    axes.axis("off")
    for x, caption in zip((0.25, 0.75), captions, strict=True):
        axes.text(x, -0.04, caption, transform=axes.transAxes, ha="center", va="top", fontsize=8)


@picture
def method_bubble_rings() -> Figure:
    """The two pictures of 1991, in closed form: a bubble and Newton's rings, two beams on the left, exact on the right."""
    figure, (bubble, rings) = plt.subplots(1, 2, figsize=(6.4, 3.4), layout="constrained")
    pixels = 360
    v, u = np.meshgrid(*(2 * [(np.arange(pixels) + 0.5) / pixels * 2.0 - 1.0]), indexing="ij")
    radius = np.hypot(u, v)
    inside = radius < 0.985
    # The front of a sphere from far away: sin(theta) is the distance from the middle; 0 nm on top, 800 below.
    angle_deg = np.degrees(np.arcsin(radius[inside]))
    nm = 400.0 * (1.0 + v[inside])
    planes = []
    for xyz in (ir.color.dias1991(film(1.33, nm), angle_deg)[0], film("soap", nm).color(angle_deg=angle_deg)):
        # The exact limb is ten times as bright as the middle: bright places are held back, chromaticity kept.
        held = xyz / (0.05 + xyz[:, 1:2])
        plane = np.zeros((pixels, pixels, 3))
        plane[inside] = srgb(held, brightest=1.0)
        planes.append(plane)
    halves(bubble, planes[0], planes[1], inside, ("1991", "exact"))
    # A lens of R = 1 m on a flat plate, both of n = 1.5; the picture is 3.6 mm wide.
    gap_nm = (1.8 * radius[inside]) ** 2 / (2.0 * 1000.0) * 1e6
    two_beam = ir.color.dias1991(film("air", gap_nm, 1.5, 1.5))[0]
    exact = film("air", gap_nm, "N-BK7", "N-BK7").color()
    planes = []
    for xyz in (two_beam, exact):
        plane = np.zeros((pixels, pixels, 3))
        plane[inside] = srgb(xyz)
        planes.append(plane)
    halves(rings, planes[0], planes[1], inside, ("1991", "exact"))
    return figure


@picture
def method_error() -> Figure:
    """CIEDE2000 between the two-beam form and the exact one, peak luminance matched, soap of n = 1.33 under D65."""
    figure, axes = wide(2.4)
    nm = np.arange(1.0, 2001.0)
    for angle_deg, color in ((0.0, "#2b6cb0"), (45.0, "#c05621"), (60.0, "#97266d")):
        lab = []
        for model in ("exact", "two-beam"):
            xyz = film(1.33, nm).color(angle_deg=angle_deg, model=model)
            lab.append(ir.color.convert(xyz / xyz[:, 1].max(), "xyz", "lab"))
        axes.plot(nm, ir.color.delta_e(*lab), color=color, linewidth=1.0, label=f"{angle_deg:.0f} degrees")
    axes.set(xlim=(0, 2000), ylim=(0, None), xlabel="thickness of a soap film, nm", ylabel="CIEDE2000")
    axes.legend(frameon=False)
    axes.grid(color="#eeeeee", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return figure


# ---------------------------------------------------------------------------------------------------------------------
# docs/evidence/published-charts.md


def named_strip(axes: Axes, rows: list[charts.Row], at: Floats, xyz: Floats, scale: Callable[[float], float]) -> None:
    """A band of computed colours with the names of a chart at their places, slanted above it."""
    axes.imshow(srgb(xyz, exposure=0.5)[None], extent=(at[0], at[-1], 0.0, 1.0), aspect="auto", interpolation="nearest")
    bare(axes)
    for row in rows:
        x = scale(row.at)
        if at[0] <= x <= at[-1]:
            axes.plot([x, x], [1.0, 1.06], color="#777777", linewidth=0.5, clip_on=False)
            axes.text(x, 1.09, row.wording.replace('"', ""), rotation=62, ha="left", va="bottom", fontsize=5.8)


@picture
def chart_sio2() -> Figure:
    """SiO2 on silicon in two halves, with the names of the chart."""
    figure, both = plt.subplots(2, 1, figsize=(6.8, 4.6), layout="constrained")
    for axes, (start, end) in zip(both, ((30.0, 520.0), (510.0, 1000.0)), strict=True):
        nm = np.linspace(start, end, 1200)
        named_strip(axes, charts.SIO2_ON_SI, nm, film("SiO2", nm, "air", "Si").color(), float)
    both[1].set_xlabel("SiO2 on silicon, nm (computed, D65); names as printed")
    return figure


@picture
def chart_titanium() -> Figure:
    """TiO2 on titanium with the names of the voltage chart, 2.4 nm to the volt above 5 nm."""
    figure, axes = plt.subplots(figsize=(6.4, 2.1), layout="constrained")
    nm = np.linspace(0.0, 240.0, 1200)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        xyz = film("TiO2", nm, "air", "Ti").color()
    named_strip(axes, charts.TITANIUM, nm, xyz, lambda volt: 5.0 + 2.4 * volt)
    axes.set_xlabel("TiO2 on titanium, nm (computed, D65); names at 5 nm + 2.4 nm per volt")
    return figure


def main() -> int:
    wanted = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    names = [name for name in PICTURES if not wanted or any(name.startswith(prefix) for prefix in wanted)]
    if "--list" in sys.argv:
        print(*names, sep="\n")
        return 0
    if not names:
        print(f"no picture begins with {wanted}; --list names them", file=sys.stderr)
        return 2
    with plt.rc_context(STYLE):
        for name in names:
            figure = PICTURES[name]()
            target = IMAGES / f"{name}.png"
            # No version or date in the file: the same picture is the same bytes.
            figure.savefig(target, metadata={"Software": None})
            plt.close(figure)
            print(f"{target.name}: {target.stat().st_size / 1024:.0f} KiB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
