"""Charts: what is drawn is what was computed, where it says it is; themes; hostile arguments."""

from __future__ import annotations

import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import colour
import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.text import Annotation, Text

import iridesce as ir
from iridesce.plot import strip

SOAP = "air / 1.333 / air"
WAVELENGTH_NM = np.arange(360.0, 831.0)
# Text that a font lacks becomes a box: matplotlib warns, and a warning is a failure here.
pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(autouse=True)
def _closed_figures() -> Iterator[None]:
    yield
    plt.close("all")


def drawn(ax: Axes, gid: str) -> list[Any]:
    """Everything on the Axes of that name."""
    found = [artist for artist in ax.get_children() if artist.get_gid() == gid]
    assert found, gid
    return found


def xyz_by_colour_science(reflectance: np.ndarray) -> np.ndarray:
    """XYZ under D65 with the tables of colour-science: (..., 471) gives (..., 3)."""
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    cmf = np.asarray(observer[WAVELENGTH_NM])
    table = colour.SDS_ILLUMINANTS["D65"]
    power = np.interp(WAVELENGTH_NM, table.wavelengths, table.values)
    # The CIE table ends at 830 nm, the light's at 830 nm: the sums have the same ends.
    return (reflectance * power) @ cmf / (power @ cmf[:, 1])


def free_film(thickness_nm: np.ndarray, n: float = 1.333) -> np.ndarray:
    """R of a film in air at the normal, by the closed form: (m, 471)."""
    face = ((n - 1.0) / (n + 1.0)) ** 2
    coefficient = 4.0 * face / (1.0 - face) ** 2
    s = np.sin(2.0 * np.pi * n * thickness_nm[:, None] / WAVELENGTH_NM) ** 2
    return coefficient * s / (1.0 + coefficient * s)


def chromaticity(xyz: np.ndarray) -> np.ndarray:
    return xyz[..., :2] / xyz.sum(axis=-1, keepdims=True)


def encoded(xyz: np.ndarray) -> np.ndarray:
    """sRGB of colours inside the gamut, by the standard's own matrix and curve (IEC 61966-2-1)."""
    matrix = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
    linear = xyz @ np.transpose(matrix)
    assert ((linear > -1e-3) & (linear < 1.001)).all(), "this check is for colours inside sRGB"
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


# --- locus


def path_of(ax: Axes, model: str = "exact") -> np.ndarray:
    """The points of a path, from its pieces."""
    (path,) = drawn(ax, f"path-{model}")
    if not isinstance(path, LineCollection):
        return np.column_stack(path.get_data())
    pieces = np.array(path.get_segments())
    np.testing.assert_array_equal(pieces[1:, 0], pieces[:-1, 1])
    return np.vstack([pieces[0, :1], pieces[:, 1]])


def test_locus_is_the_path_that_colour_science_finds() -> None:
    thickness_nm = np.array([10.0, 90.0, 180.0, 240.0, 310.0, 400.0, 470.0, 900.0, 1500.0])
    wanted = chromaticity(xyz_by_colour_science(free_film(thickness_nm)))
    got = path_of(ir.plot.locus(SOAP, thickness_nm))
    np.testing.assert_allclose(got, wanted, atol=2e-5)  # tables of five digits


def test_locus_in_u_v_is_the_same_path() -> None:
    thickness_nm = np.linspace(50.0, 900.0, 40)
    xy = path_of(ir.plot.locus(SOAP, thickness_nm))
    wanted = colour.xy_to_Luv_uv(xy)
    np.testing.assert_allclose(path_of(ir.plot.locus(SOAP, thickness_nm, diagram="uv")), wanted, atol=1e-12)


@pytest.mark.parametrize("model", ["two-beam", "both"])
def test_two_beam_path(model: str) -> None:
    thickness_nm = np.linspace(100.0, 800.0, 15)
    stack = ir.Stack(["air", ir.Layer(1.5, thickness_nm), 1.3])
    wavelength_nm, weight = WAVELENGTH_NM, 0.0
    r12, r23 = -0.2, 0.2 / 2.8
    delta = 4.0 * np.pi * 1.5 * thickness_nm[:, None] / wavelength_nm
    weight = r12**2 + r23**2 + 2.0 * r12 * r23 * np.cos(delta)
    ax = ir.plot.locus(stack, model=model)
    np.testing.assert_allclose(path_of(ax, "two-beam"), chromaticity(xyz_by_colour_science(weight)), atol=2e-5)
    if model == "both":
        np.testing.assert_allclose(path_of(ax), chromaticity(stack.color()), atol=1e-12)
        assert "two-beam form of 1991" in [text.get_text() for text in ax.get_legend().get_texts()]


def test_path_has_its_own_colours() -> None:
    thickness_nm = np.array([298.0, 299.0, 300.0, 560.0, 561.0, 562.0])  # inside sRGB
    ax = ir.plot.locus(SOAP, thickness_nm)
    (path,) = drawn(ax, "path-exact")
    xyz = xyz_by_colour_science(free_film(np.array([298.5, 299.5, 560.5, 561.5])))
    matrix = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
    brightest = (xyz @ matrix.T).max(axis=-1, keepdims=True)
    np.testing.assert_allclose(path.get_colors()[[0, 1, 3, 4], :3], encoded(xyz / brightest), atol=3e-3)


def test_dots_stand_at_their_thickness() -> None:
    ax = ir.plot.locus(SOAP, (0.0, 1000.0), tick_nm=50.0)
    wanted = chromaticity(xyz_by_colour_science(free_film(np.arange(50.0, 1001.0, 50.0))))
    (dots,) = drawn(ax, "ticks")
    np.testing.assert_allclose(np.column_stack(dots.get_data()), wanted, atol=2e-4)  # between samples 2.5 nm apart
    labels = drawn(ax, "tick-label")
    assert len(labels) >= 10
    for label in labels:
        np.testing.assert_allclose(label.xy, wanted[round(float(label.get_text()) / 50.0) - 1], atol=2e-4)


@pytest.mark.parametrize("columns", [1, 3])
@pytest.mark.parametrize("zoom", [False, True])
def test_labels_cover_neither_each_other_nor_the_path(zoom: bool, columns: int) -> None:
    """Places hold for the size that the figure has then: a layout that later charts may change is left out."""
    layout = "constrained" if columns == 1 else "none"
    figure, axes = plt.subplots(1, columns, figsize=(14, 6), layout=layout, squeeze=False)
    for ax in axes[0]:
        ir.plot.locus("air / SiO2 / Si", (0.0, 1500.0), tick_nm=10.0, zoom=zoom, ax=ax)
    figure.canvas.draw()
    for ax in axes[0]:
        boxes = [Text.get_window_extent(label) for label in drawn(ax, "tick-label")]  # without its line to the dot
        assert len(boxes) >= (8 if zoom else 3)
        path = ax.transData.transform(path_of(ax))
        for i, box in enumerate(boxes):
            assert not any(box.overlaps(other) for other in boxes[:i])
            assert not ((path > box.min) & (path < box.max)).all(axis=1).any()


def test_diagram_has_the_spectrum_the_white_and_the_gamuts() -> None:
    ax = ir.plot.locus(SOAP, gamuts=["srgb", "display-p3", "rec2020", "ntsc1953"], illuminant="A")
    wanted = {
        "srgb": [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)],
        "display-p3": [(0.680, 0.320), (0.265, 0.690), (0.150, 0.060)],
        "rec2020": [(0.708, 0.292), (0.170, 0.797), (0.131, 0.046)],
        "ntsc1953": [(0.67, 0.33), (0.21, 0.71), (0.14, 0.08)],
    }
    for space, corners in wanted.items():
        (triangle,) = drawn(ax, f"gamut-{space}")
        np.testing.assert_allclose(np.column_stack(triangle.get_data()), [*corners, corners[0]], atol=1e-9)
    (white,) = drawn(ax, "white")
    np.testing.assert_allclose(np.ravel(white.get_data()), [0.44757, 0.40745], atol=2e-5)
    (outline,) = drawn(ax, "spectral-locus")
    vertices = outline.get_xy()
    np.testing.assert_allclose(vertices[520 - 390], [0.07430, 0.83380], atol=1e-4)
    np.testing.assert_allclose(vertices[600 - 390], [0.62704, 0.37249], atol=1e-4)
    (purple,) = drawn(ax, "purple-line")
    np.testing.assert_allclose(np.column_stack(purple.get_data()), vertices[[0, 700 - 390]], atol=1e-12)
    assert ax.get_aspect() == 1.0


def test_where_the_film_is_black_the_path_has_no_point() -> None:
    assert len(path_of(ir.plot.locus(SOAP, [0.0, 100.0, 200.0]))) == 2
    with pytest.raises(ValueError, match="black at every thickness"):
        ir.plot.locus("air / 1.0 / air")


# --- strip


def image_of(ax: Axes, row: int = 0) -> np.ndarray:
    return np.asarray(ax.images[row].get_array())


def centers(ax: Axes, row: int = 0) -> np.ndarray:
    """Where the columns of a strip have their middles."""
    left, right, _, _ = ax.images[row].get_extent()
    count = image_of(ax, row).shape[1]
    return left + (right - left) * (np.arange(count) + 0.5) / count


def test_strip_shows_the_colour_at_its_thickness() -> None:
    thickness_nm = np.linspace(285.0, 305.0, 21)  # inside sRGB
    ax = strip(SOAP, thickness_nm, exposure=2.0)
    np.testing.assert_allclose(centers(ax), thickness_nm, atol=1e-9)
    wanted = encoded(4.0 * xyz_by_colour_science(free_film(thickness_nm)))
    np.testing.assert_allclose(image_of(ax)[0], wanted, atol=2e-3)  # the standard's matrix has four digits
    assert "shown 4 times as bright" in drawn(ax, "subtitle")[0].get_text()
    assert ax.get_xlabel() == "1.333 thickness (nm)"
    assert ax.get_xlim() == (285.0, 305.0)


def test_strips_stand_below_each_other_with_their_labels() -> None:
    ax = strip({"soap": "air / soap / air", "oxide": "air / SiO2 / Si"}, (0, 400), angle_deg=[0, 60])
    labels = ["soap, 0°", "soap, 60°", "oxide, 0°", "oxide, 60°"]
    assert [label.get_text() for label in ax.get_yticklabels()] == labels
    low, high = ax.get_ylim()
    assert low > high, "the first strip is on top"
    for row, (text, angle) in enumerate([("soap", 0.0), ("soap", 60.0), ("SiO2", 0.0), ("SiO2", 60.0)]):
        _, _, bottom, top = ax.images[row].get_extent()
        assert bottom > row > top
        last = "air" if text == "soap" else "Si"
        stack = ir.Stack(["air", ir.Layer(text, centers(ax, row).clip(0.0)), last])
        linear = stack.color(angle, space="linear-srgb")
        scaled = ir.color.convert(linear / linear.max(), "linear-srgb", "srgb")
        wanted, _ = ir.color.map_gamut(scaled, "srgb", "hue")
        np.testing.assert_allclose(image_of(ax, row)[0], np.clip(wanted, 0.0, 1.0), atol=1e-9)


def test_common_exposure_keeps_strips_comparable() -> None:
    rows = ["air / 1.1 / air", "air / 1.9 / air"]
    each, common = (strip(rows, exposure=exposure) for exposure in ("auto", "common"))
    assert image_of(each, 0).max() == pytest.approx(1.0)
    assert image_of(each, 1).max() == pytest.approx(1.0)
    assert image_of(common, 1).max() == pytest.approx(1.0)
    # Peaks go as (2 r / (1 + r^2))^2 with r = (n - 1)/(n + 1), and light as the 2.2nd power of the screen's values.
    assert image_of(common, 0).max() < 0.2


def test_newtons_scale_is_that_of_colour_science() -> None:
    retardation_nm = np.linspace(238.0, 262.0, 13)  # "almost white": inside sRGB
    ax = strip("newton", retardation_nm=retardation_nm, exposure=-1.0)
    spectra = np.sin(np.pi * retardation_nm[:, None] / WAVELENGTH_NM) ** 2
    np.testing.assert_allclose(image_of(ax)[0], encoded(0.5 * xyz_by_colour_science(spectra)), atol=2e-3)
    assert ax.get_title(loc="left") == "Newton's colour scale"
    assert ax.get_xlabel() == "retardation (nm)"


def test_orders_end_at_550_1100_1650_nm() -> None:
    ax = strip()
    assert {float(line.get_xdata()[0]) for line in drawn(ax, "order")} == {550.0, 1100.0, 1650.0}
    assert [text.get_text() for text in drawn(ax, "order-name")] == ["I", "II", "III", "IV"]
    assert [float(text.get_position()[0]) for text in drawn(ax, "order-name")] == [275.0, 825.0, 1375.0, 1925.0]
    # The eye's least luminance of the first orders lies near those ends (physical optics knows them as violet tints).
    retardation_nm = centers(ax)
    luminance = xyz_by_colour_science(np.sin(np.pi * retardation_nm[:, None] / WAVELENGTH_NM) ** 2)[:, 1]
    inner = luminance[1:-1]
    least = retardation_nm[1:-1][(inner < luminance[:-2]) & (inner < luminance[2:])]
    np.testing.assert_allclose(least[:3], [550.0, 1100.0, 1650.0], atol=20.0)


def test_orders_of_a_film_follow_its_index_and_angle() -> None:
    ax = strip("air / 1.5 / air", (0, 500), angle_deg=[0, 60], orders=True)
    by_row: dict[int, set[float]] = {0: set(), 1: set()}
    for line in drawn(ax, "order"):
        by_row[round(float(np.mean(line.get_ydata())) - 0.0)].add(round(float(line.get_xdata()[0]), 6))
    assert by_row[0] == {round(550.0 / 3.0, 6), round(1100.0 / 3.0, 6)}
    cosine = np.sqrt(1.0 - (np.sin(np.radians(60.0)) / 1.5) ** 2)
    assert by_row[1] == {round(550.0 / 3.0 / cosine, 6), round(1100.0 / 3.0 / cosine, 6)}


def test_films_line_up_by_retardation() -> None:
    """An air gap in glass so weak that only two waves matter is Newton's scale itself."""
    ax = strip(["newton", "1.001 / 1.0 / 1.001"], retardation_nm=(0, 2200))
    assert np.abs(image_of(ax, 0) - image_of(ax, 1)).max() < 2e-3


# --- chart


def test_chart_is_thickness_against_angle() -> None:
    thickness_nm, angle_deg = np.linspace(285.0, 305.0, 9), np.array([0.0, 4.0, 8.0])
    ax = ir.plot.chart(SOAP, thickness_nm, angle_deg, exposure=2.0)
    image = image_of(ax)
    assert image.shape == (3, 9, 3)
    np.testing.assert_allclose(image[0], encoded(4.0 * xyz_by_colour_science(free_film(thickness_nm))), atol=2e-3)
    stack = ir.Stack(["air", ir.Layer(1.333, thickness_nm), "air"])
    np.testing.assert_allclose(image[2], encoded(4.0 * stack.color(8.0)), atol=2e-3)
    assert ax.images[0].origin == "lower"
    np.testing.assert_allclose(ax.images[0].get_extent(), [283.75, 306.25, -2.0, 10.0])
    assert ax.get_xlim() == (285.0, 305.0) and ax.get_ylim() == (0.0, 8.0)
    assert ax.get_ylabel() == "angle of incidence in air (°)"


def test_chart_brightens_each_angle() -> None:
    image = image_of(ir.plot.chart("air / soap / air", (0, 600)))
    assert image.shape == (171, 401, 3)
    np.testing.assert_allclose(image.max(axis=(1, 2)), 1.0, atol=1e-6)
    common = image_of(ir.plot.chart("air / soap / air", (0, 600), exposure="common"))
    assert common[0].max() < 0.7
    assert common[-1].max() == pytest.approx(1.0)


# --- spectrum


def test_spectrum_is_in_percent_and_labelled() -> None:
    stacks = {"bare": "air / 1.5", "coated": "air / 1.38 100 / 1.5"}
    ax = ir.plot.spectrum(stacks, (400, 700), 30.0, "s")
    lines = drawn(ax, "curve")
    assert [line.get_label() for line in lines] == ["bare", "coated"]
    wavelength_nm = lines[0].get_xdata()
    assert (wavelength_nm[0], wavelength_nm[-1]) == (400.0, 700.0)
    cosine, inside = np.cos(np.radians(30.0)), np.sqrt(2.25 - 0.25)
    np.testing.assert_allclose(lines[0].get_ydata(), 100.0 * ((cosine - inside) / (cosine + inside)) ** 2, rtol=1e-12)
    coated = ir.Stack.parse(stacks["coated"]).reflectance(wavelength_nm, 30.0, "s")
    np.testing.assert_allclose(lines[1].get_ydata(), 100.0 * coated, rtol=1e-12)
    assert ax.get_ylabel() == "reflectance (%)"
    assert ax.get_xlabel() == "vacuum wavelength (nm)"
    assert ax.get_xlim() == (400.0, 700.0)
    assert ax.get_ylim()[0] == 0.0
    assert drawn(ax, "subtitle")[0].get_text() == "30°, s-polarised"


def test_spectrum_tells_everything_apart() -> None:
    quantities = ("reflectance", "transmittance", "absorptance")
    ax = ir.plot.spectrum("air / Ag 20 / 1.5", quantity=quantities, angle_deg=(0, 60))
    lines = drawn(ax, "curve")
    assert len({(line.get_color(), str(line._dash_pattern)) for line in lines}) == 6
    assert [line.get_label() for line in lines[:3]] == ["reflectance, 0°", "reflectance, 60°", "transmittance, 0°"]
    total = sum(np.asarray(line.get_ydata()) for line in lines[0::2])
    np.testing.assert_allclose(total, 100.0, atol=1e-10)
    ir.plot.spectrum("air / 1.7", ax=ax)
    assert len(drawn(ax, "curve")) == 7
    assert drawn(ax, "curve")[-1].get_color() not in {line.get_color() for line in lines}
    assert len(drawn(ax, "visible")) == 1


def test_spectrum_goes_as_far_as_the_data() -> None:
    assert ir.plot.spectrum("air / rutile-o 100 / air").get_xlim() == (430.0, 780.0)
    assert ir.plot.spectrum("air / 1.5").get_xlim() == (380.0, 780.0)


def test_band_under_a_spectrum_is_the_visible_one() -> None:
    ax = ir.plot.spectrum("air / 1.5", (300.0, 900.0))
    (band,) = drawn(ax, "visible")
    pieces = np.array(band.get_segments())
    assert pieces[0, 0, 0] == 380.0
    assert pieces[-1, 1, 0] == 780.0
    middle = pieces[:, 0, 0] + 0.5 * (780.0 - 380.0) / 240

    def at(nm: float) -> np.ndarray:
        return band.get_colors()[int(np.argmin(np.abs(middle - nm))), :3]

    assert at(450.0).argmax() == 2 and at(530.0).argmax() == 1 and at(640.0).argmax() == 0
    assert at(575.0)[2] < 0.5 * at(575.0)[:2].min(), "yellow"
    assert at(381.0).max() < 0.35 and at(779.0).max() < 0.2, "dark where the eye sees nothing"
    ax = ir.plot.spectrum("air / 1.5", (1000.0, 2000.0))
    assert not [one for one in ax.collections if one.get_gid() == "visible"]


# --- medium


def test_medium_shows_n_and_k() -> None:
    ax = ir.plot.medium("Ti", (400.0, 800.0))
    titanium = ir.Medium("Ti")
    (n,) = drawn(ax, "n")
    (right,) = [one for one in ax.figure.axes if one is not ax]
    (k,) = drawn(right, "k")
    index = titanium.index(n.get_xdata())
    np.testing.assert_array_equal(n.get_ydata(), index.real)
    np.testing.assert_array_equal(k.get_ydata(), index.imag)
    assert ax.get_ylabel() == "refractive index n" and right.get_ylabel() == "extinction coefficient k"
    subtitle = drawn(ax, "subtitle")[0].get_text()
    assert "Johnson and R. W. Christy" in subtitle.replace("\n", " ")
    assert subtitle.splitlines()[-1] == "data 188 to 1937 nm"


def test_medium_marks_where_the_data_end() -> None:
    ax = ir.plot.medium("rutile-o")
    (data,), (dashed,) = drawn(ax, "n"), drawn(ax, "n-extended")
    x, y = data.get_data()
    assert x[0] == 360.0
    inside = ~np.isnan(y)
    assert x[inside].min() >= 430.0 > x[~inside].max()
    beyond = ~np.isnan(dashed.get_ydata())
    assert x[beyond].max() == pytest.approx(430.0, abs=1.0)
    squared = x[0] / 1000.0  # the formula of Devore: n^2 = 5.913 + 0.2441 / (L^2 - 0.0803)
    assert dashed.get_ydata()[0] == pytest.approx(np.sqrt(5.913 + 0.2441 / (squared**2 - 0.0803)), rel=1e-12)
    (shade,) = drawn(ax, "extension")
    assert shade.get_x() == 360.0
    assert shade.get_x() + shade.get_width() == pytest.approx(430.0, abs=1.0)
    assert len(ax.figure.axes) == 1, "k = 0 needs no axis"
    with pytest.raises(ValueError, match="430-1530 nm"):
        ir.plot.medium("rutile-o", (300.0, 800.0))


@pytest.mark.parametrize("name", list(ir.media()))
def test_every_medium_can_be_plotted(name: str) -> None:
    ax = ir.plot.medium(name)
    assert np.isfinite(drawn(ax, "n")[0].get_ydata()).any()
    assert np.isfinite(ax.get_ylim()).all()


# --- all charts

CHARTS: dict[str, Callable[..., Axes]] = {
    "locus": lambda **options: ir.plot.locus("air / soap / air", **options),
    "strip": lambda **options: strip("air / soap / air", **options),
    "chart": lambda **options: ir.plot.chart("air / soap / air", (0, 500), **options),
    "spectrum": lambda **options: ir.plot.spectrum("air / soap 320 / air", **options),
    "medium": lambda **options: ir.plot.medium("TiO2-siefke", **options),
}


def luminance(color: Any) -> float:
    return float(np.dot(np.asarray(to_rgb(color)) ** 2.2, [0.2126, 0.7152, 0.0722]))


def contrast(a: Any, b: Any) -> float:
    """The contrast ratio of WCAG 2."""
    dark, bright = sorted((luminance(a), luminance(b)))
    return (bright + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("name", CHARTS)
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_chart_can_be_read_in_both_themes(name: str, theme: str) -> None:
    ax = CHARTS[name](theme=theme)
    figure = ax.figure
    figure.canvas.draw()  # a missing glyph or a layout that does not fit would warn
    ground = figure.get_facecolor()
    assert (luminance(ground) > 0.5) == (theme == "light")
    texts = [ax.title, ax._left_title, ax.xaxis.label, ax.yaxis.label, *ax.get_xticklabels(), *ax.get_yticklabels()]
    texts += [text for text in ax.texts if text.get_gid() == "subtitle"]
    for text in texts:
        if text.get_text():
            assert contrast(text.get_color(), ground) > 4.5, text
            box = text.get_window_extent()
            if text.get_gid() != "subtitle" and text is not ax._left_title:
                continue
            assert box.y1 <= figure.bbox.height + 0.5 and box.x1 <= figure.bbox.width + 0.5, f"{text} is cut off"


@pytest.mark.parametrize("name", CHARTS)
def test_every_chart_takes_an_axes_and_gives_it_back(name: str) -> None:
    figure, (left, right) = plt.subplots(1, 2)
    assert CHARTS[name](ax=right) is right
    assert not left.has_data()
    assert CHARTS[name]().figure is not figure
    assert CHARTS[name](title="Mine").get_title(loc="left") == "Mine"
    bare = CHARTS[name](title="")
    assert bare.get_title(loc="left") == ""
    assert not [text for text in bare.texts if text.get_gid() == "subtitle"]


@pytest.mark.parametrize("name", CHARTS)
def test_without_a_theme_the_figure_decides(name: str) -> None:
    with plt.style.context("dark_background"):
        ax = CHARTS[name]()
        assert luminance(ax.figure.get_facecolor()) < 0.05
        assert luminance(ax._left_title.get_color()) > 0.5
    ax = CHARTS[name]()
    assert luminance(ax._left_title.get_color()) < 0.05


def test_matplotlib_waits_for_the_first_chart() -> None:
    code = (
        "import sys, iridesce as ir; ir.plot.locus; assert 'matplotlib' not in sys.modules;"
        "ir.plot.strip(); assert 'matplotlib' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_growing_layer() -> None:
    """Left open, named, numbered, an array, or the only one: always the same film."""
    thickness_nm = np.linspace(20.0, 200.0, 10)
    wanted = chromaticity(ir.Stack(["air", ir.Layer("SiO2", thickness_nm), ir.Layer("Si", 50.0), 1.5]).color())
    fixed = ir.Stack.parse("air / SiO2 7 / Si 50 / 1.5")
    array = ir.Stack(["air", ir.Layer("SiO2", thickness_nm), ir.Layer("Si", 50.0), 1.5])
    for ax in (
        ir.plot.locus("air / SiO2 / Si 50 / 1.5", thickness_nm),
        ir.plot.locus("air / SiO2 ? / Si 50 / 1.5", thickness_nm),
        ir.plot.locus(fixed, thickness_nm, layer="SiO2"),
        ir.plot.locus(fixed, thickness_nm, layer=1),
        ir.plot.locus(array, thickness_nm),
        ir.plot.locus(array),
    ):
        np.testing.assert_allclose(path_of(ax), wanted, atol=1e-12)
        assert ax.get_title(loc="left") == "air / SiO2 / Si 50 nm / 1.5"
    second = ir.plot.locus("air / SiO2 7 / Si / 1.5", thickness_nm)
    stack = ir.Stack(["air", ir.Layer("SiO2", 7.0), ir.Layer("Si", thickness_nm), 1.5])
    np.testing.assert_allclose(path_of(second), chromaticity(stack.color()), atol=1e-12)
    with pytest.raises(ValueError, match="has 2 layers: say which grows"):
        ir.plot.locus(fixed)


def test_arguments_stay_as_they_were() -> None:
    thickness_nm, angle_deg = np.linspace(0.0, 300.0, 20), np.array([0.0, 30.0])
    before = thickness_nm.copy(), angle_deg.copy()
    ir.plot.locus(SOAP, thickness_nm)
    strip(SOAP, thickness_nm, angle_deg)
    ir.plot.chart(SOAP, thickness_nm, angle_deg)
    np.testing.assert_array_equal(before[0], thickness_nm)
    np.testing.assert_array_equal(before[1], angle_deg)


NAN = float("nan")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: ir.plot.locus("air"), "two or more items"),
        (lambda: ir.plot.locus("air / soap"), "needs a layer that grows"),
        (lambda: ir.plot.locus(ir.Stack(["air", 1.5])), "needs a layer that grows"),
        (lambda: ir.plot.locus(None), "stack must be an iridesce.Stack or its text, got None"),
        (lambda: ir.plot.locus(["air", "soap", "air"]), "stack must be an iridesce.Stack or its text"),
        (lambda: ir.plot.locus("air / sopa / air"), 'did you mean "soap"'),
        (lambda: ir.plot.locus("air / soap / SiO2 / air"), "only one layer of a chart may leave out"),
        (lambda: ir.plot.locus("air / soap / SiO2 5 / air", layer=2), "a layer that does not grow needs its thickness"),
        (lambda: ir.plot.locus("air / soap x / air"), "must be a number, got 'x'"),
        (lambda: ir.plot.locus("air / soap -1 / air"), "item 2 of the stack"),
        (lambda: ir.plot.locus("air / soap / air", layer=0), "layer must be 1 to 1 or the name"),
        (lambda: ir.plot.locus("air / soap / air", layer=True), "layer must be 1 to 1 or the name"),
        (lambda: ir.plot.locus("air / soap / air", layer="oil"), "no layer of 'oil'"),
        (lambda: ir.plot.locus("air / 2.0 1 / 2.0 1 / air", layer="2"), "2 layers of '2'"),
        (lambda: ir.plot.locus(SOAP, (0, NAN)), "thickness_nm must be >= 0 and finite, got nan at index (1,)"),
        (lambda: ir.plot.locus(SOAP, (0, np.inf)), "thickness_nm must be >= 0 and finite"),
        (lambda: ir.plot.locus(SOAP, (-1, 5)), "thickness_nm must be >= 0"),
        (lambda: ir.plot.locus(SOAP, (5, 5)), "thickness_nm must ascend"),
        (lambda: ir.plot.locus(SOAP, [100, 300, 200]), "thickness_nm must ascend"),
        (lambda: ir.plot.locus(SOAP, 300.0), "thickness_nm must be two numbers"),
        (lambda: ir.plot.locus(SOAP, []), "thickness_nm must not be empty"),
        (lambda: ir.plot.locus(SOAP, "thick"), "thickness_nm must be real numbers"),
        (lambda: ir.plot.locus(SOAP, (0, 1e6)), "thickness_nm must be at most 100000 nm"),
        (lambda: ir.plot.locus(SOAP, angle_deg=90), "angle_deg must be >= 0 and < 90"),
        (lambda: ir.plot.locus(SOAP, angle_deg=[0, 10]), "angle_deg must be one number here"),
        (lambda: ir.plot.locus(SOAP, model="triple"), "model must be one or more of 'exact', 'two-beam', 'both'"),
        (lambda: ir.plot.locus("air / SiO2 / Si", model="two-beam"), "real"),
        (lambda: ir.plot.locus(SOAP, diagram="lab"), "diagram must be"),
        (lambda: ir.plot.locus(SOAP, gamuts="cmyk"), "gamuts must be one or more of 'srgb'"),
        (lambda: ir.plot.locus(SOAP, gamuts=["srgb", "srgb"]), "must not name the same twice"),
        (lambda: ir.plot.locus(SOAP, gamuts=5), "gamuts must be"),
        (lambda: ir.plot.locus(SOAP, illuminant="D66"), "D66"),
        (lambda: ir.plot.locus(SOAP, polarization="x"), "polarization must be"),
        (lambda: ir.plot.locus(SOAP, quantity="gloss"), "quantity must be"),
        (lambda: ir.plot.locus(SOAP, tick_nm=0), "tick_nm must be > 0"),
        (lambda: ir.plot.locus(SOAP, tick_nm=NAN), "tick_nm must be > 0"),
        (lambda: ir.plot.locus(SOAP, tick_nm=1e-6), "more than 1000 dots"),
        (lambda: ir.plot.locus(SOAP, theme="pink"), 'theme must be "light", "dark" or None'),
        (lambda: ir.plot.locus(SOAP, ax="axes"), "ax must be a matplotlib Axes or None"),
        (lambda: ir.plot.locus(SOAP, ax=plt.subplots(subplot_kw={"projection": "polar"})[1]), "straight axes"),
        (lambda: ir.plot.locus(SOAP, title=5), "title must be text or None"),
        (lambda: strip([]), "must not be an empty list"),
        (lambda: strip(5), "stack must be a Stack, its text, or a list or dict"),
        (lambda: strip("newton", (0, 500)), "exclude each other"),
        (lambda: strip(SOAP, (0, 500), retardation_nm=(0, 500)), "exclude each other"),
        (lambda: strip(SOAP, [0, 1, 3]), "thickness_nm must be evenly spaced"),
        (lambda: strip("newton", retardation_nm=(0, 1e5)), "retardation_nm must be at most 30000 nm"),
        (lambda: strip("1.5 / 1.0 / 1.5", angle_deg=60, retardation_nm=(0, 9)), "total reflection"),
        (lambda: strip(SOAP, exposure="bright"), 'exposure must be "auto", "common" or stops'),
        (lambda: strip(SOAP, exposure=NAN), "exposure must be"),
        (lambda: strip(SOAP, exposure=True), "exposure must be"),
        (lambda: strip(SOAP, observer="cie1930"), "cie1930"),
        (lambda: ir.plot.chart(SOAP, angle_deg=30), "angle_deg must be two ascending numbers"),
        (lambda: ir.plot.chart(SOAP, angle_deg=(60, 0)), "angle_deg must be two ascending numbers"),
        (lambda: ir.plot.chart(SOAP, angle_deg=(0, 90)), "angle_deg must be >= 0 and < 90"),
        (lambda: ir.plot.chart(SOAP, angle_deg=(0, 10, 30)), "angle_deg must be evenly spaced"),
        (lambda: ir.plot.spectrum("air / soap / air"), "needs its thickness in nm"),
        (lambda: ir.plot.spectrum(ir.Stack(["air", ir.Layer(1.3, [1.0, 2.0]), "air"])), "one thickness a layer"),
        (lambda: ir.plot.spectrum("air / 1.5", 500.0), "wavelength_nm must be two ascending"),
        (lambda: ir.plot.spectrum("air / 1.5", (0, 500)), "wavelength_nm must be > 0"),
        (lambda: ir.plot.spectrum("air / Ag", (300, 3000)), 'medium "Ag" has data for'),
        (lambda: ir.plot.spectrum("air / 1.5", quantity=[]), "quantity must be one or more"),
        (lambda: ir.plot.spectrum("air / 1.5", quantity="R"), "quantity must be one or more"),
        (lambda: ir.plot.spectrum("air / 1.5", polarization=["s", None]), "polarization must be one or more"),
        (lambda: ir.plot.spectrum("air / 1.5", angle_deg=range(50)), "a chart shows 24 at most"),
        (lambda: ir.plot.medium("unobtainium"), "unknown medium"),
        (lambda: ir.plot.medium("Ti", (300, 3000)), "188-1937 nm"),
        (lambda: ir.plot.medium(-1.0), "n >= 0"),
        (lambda: ir.plot.medium("Ti", (500, 400)), "wavelength_nm must be two ascending"),
    ],
)
def test_hostile(call: Callable[[], Axes], said: str) -> None:
    figures = plt.get_fignums()
    with pytest.raises(ValueError) as caught:  # noqa: PT011  (the text is checked below)
        call()
    assert said in str(caught.value)
    assert len(plt.get_fignums()) <= len(figures) + 1


def test_odd_but_right() -> None:
    ir.plot.locus("air / soap / air", illuminant="laser:550").figure.canvas.draw()  # a path that stands still
    strip("air / 1.0 / air").figure.canvas.draw()  # black
    ir.plot.chart("1.5 / 1.0 / 1.5", (0, 500), (0, 80)).figure.canvas.draw()  # beyond total reflection
    ir.plot.spectrum("air / 1.0").figure.canvas.draw()  # zero everywhere
    ir.plot.medium(1.5).figure.canvas.draw()
    ir.plot.medium(1.5 - 0.1j).figure.canvas.draw()  # gain
    strip("air / soap / air", illuminant="lines:589.158*2,589.756", quantity="transmittance", polarization="p")
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        ir.plot.locus("air / rutile-o / air")
    assert any("extension" in str(one.message) for one in seen), "colours from extended data say so"


def test_text_is_text() -> None:
    """A dollar sign in a label is no formula, and a label may be anything."""
    ax = ir.plot.spectrum({"5 $ a piece $": "air / 1.5", "<b>": "air / 1.6"})
    ax.figure.canvas.draw()
    assert isinstance(drawn(ax, "subtitle")[0], Annotation)


def test_a_stack_of_many_layers_has_a_short_title() -> None:
    layers = [ir.Layer("SiO2" if number % 2 else "TiO2", 100.0) for number in range(20)]
    axes = ir.plot.spectrum(ir.Stack(["air", *layers, "N-BK7"]))
    assert axes.get_title(loc="left") == "air / 20 layers, 2000 nm / N-BK7"
    axes = ir.plot.spectrum([ir.Stack(["air", *layers, "N-BK7"]), ir.Stack(["air", *layers, "Si"])])
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "air / 20 layers, 2000 nm / N-BK7",
        "air / 20 layers, 2000 nm / Si",
    ]
    few = ir.plot.spectrum(ir.Stack(["air", *layers[:2], "N-BK7"]))
    assert few.get_title(loc="left") == "air / TiO2 100 nm / SiO2 100 nm / N-BK7"
