"""What notebooks show."""

from __future__ import annotations

import io
import re
import warnings
from html.parser import HTMLParser

import matplotlib.image
import numpy as np
import pytest

import iridesce as ir


class Cells(HTMLParser):
    """The texts of the table cells; complains about tags that do not close."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.open: list[str] = []
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


def colors(html: str) -> list[str]:
    return re.findall(r"#[0-9a-f]{6}", html)


def test_stack_shows_its_layers_and_its_colour() -> None:
    stack = ir.Stack(["air", ir.Layer("MgF2", 100.0), ir.Layer(1.5 + 0.25j, 1e6, coherent=False), "N-BK7"])
    html = stack._repr_html_()
    rows = Cells(html).rows
    assert rows[0] == ["", "medium", "nm", "n at 550 nm"]
    assert rows[1] == ["first", "air", "", "1"]
    assert rows[2] == ["1", "MgF2", "100", "1.379"]
    assert rows[3] == ["2", "1.5+0.25j", "1e+06, incoherent", "1.5 +0.25i"]
    assert rows[4][:3] == ["last", "N-BK7", ""]
    shown = colors(html)
    rgb = stack.color(space="srgb", gamut="hue")
    assert shown[0] == "#" + "".join(f"{round(255 * float(value)):02x}" for value in rgb)
    assert "ff" in re.findall("..", shown[1][1:]), "the second swatch is as bright as it can be"
    assert len(shown) == 2


def test_stack_of_many_thicknesses_is_a_ramp() -> None:
    html = ir.Stack(["air", ir.Layer("soap", np.linspace(0, 900, 1000)), "air"])._repr_html_()
    assert Cells(html).rows[2][2] == "0 to 900, (1000,)"
    assert len(colors(html)) == 128
    grid = ir.Stack(["air", ir.Layer(1.3, np.ones((3, 1))), ir.Layer(1.4, np.ones(4)), "air"])._repr_html_()
    assert colors(grid) == []


def test_nothing_a_stack_may_hold_makes_it_raise() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for text in ("air / 1.5", "air / Ag 20 / rutile-o", "air / 1.3 1e12 / air"):
            Cells(ir.Stack.parse(text)._repr_html_())
        infrared = ir.Medium._from_text("nm,n\n2000,1.5\n3000,1.4", "<ir & more>")
        html = ir.Stack(["air", infrared])._repr_html_()
        assert "&lt;ir &amp; more&gt;" in html and "<ir" not in html
        assert colors(html) == []
        many = ir.Stack(["air", *[ir.Layer(1.3, 10.0), ir.Layer(1.4, 10.0)] * 500, "air"])._repr_html_()
        rows = Cells(many).rows
        assert len(rows) == 62 and rows[-2][1] == "\u2026 942 more" and rows[-1][0] == "last"


def test_medium_shows_its_source() -> None:
    rows = dict(Cells(ir.Medium("rutile-o")._repr_html_()).rows)
    assert rows["data"] == "430 to 1530 nm"
    assert "Devore" in rows["source"]
    assert rows["extended"].startswith("360-430 nm")
    assert rows["n at 550 nm"] == "2.648"
    assert "source" in dict(Cells(ir.Medium(1.5)._repr_html_()).rows) or ir.Medium(1.5).source == ""


def test_illuminant_shows_its_colour() -> None:
    html = ir.color.illuminant("A")._repr_html_()
    assert "x = 0.4476, y = 0.4074" in html
    lamp, daylight = list(dict.fromkeys(colors(html)))
    assert daylight == "#ffffff"
    red, green, blue = (int(lamp[i : i + 2], 16) for i in (1, 3, 5))
    assert red == 255 and red > green > blue


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (2000, 30), (1, 5000)])
def test_thickness_map_is_a_picture(shape: tuple[int, int]) -> None:
    grid = np.arange(np.prod(shape), dtype=float).reshape(shape)
    png = ir.thickness.ThicknessMap(grid)._repr_png_()
    picture = matplotlib.image.imread(io.BytesIO(png), format="png")[..., :3]
    assert max(picture.shape[:2]) <= 1024
    assert picture.shape[0] * shape[1] == pytest.approx(picture.shape[1] * shape[0], rel=0.1, abs=shape[1])
    if grid.size > 1:
        luminance = picture @ [0.2126, 0.7152, 0.0722]
        assert luminance[0, 0] < 0.2 < 0.7 < luminance[-1, -1]


@pytest.mark.filterwarnings("error")
def test_an_even_map_is_a_picture() -> None:
    png = ir.thickness.uniform(320.0).map(4, 4)._repr_png_()
    picture = matplotlib.image.imread(io.BytesIO(png), format="png")[..., :3]
    assert np.ptp(picture, axis=(0, 1)).max() <= 1.01 / 255.0  # one step: it is dithered


def test_image_is_a_picture() -> None:
    assert ir.Image(np.full((2, 3, 3), 0.2))._repr_png_()[:4] == b"\x89PNG"


def test_scenes_models_fits_and_uncertainties_are_shown() -> None:
    scene = Cells(ir.Scene.load("soap-bubble")._repr_html_()).rows
    assert ["object bubble", "sphere, film of soap"] in scene
    assert ["light", "environment, builtin studio"] in scene
    model = Cells(ir.thickness.gradient(0.0, 800.0)._repr_html_()).rows
    assert model[0] == ["law", "gradient(top=0.0, bottom=800.0, exponent=1.0)"]
    assert model[1][1] == "800, 600, 400, 200, 0 nm"
    assert len(Cells(ir.thickness.lens_gap(1000.0)._repr_html_()).rows) == 1
    film = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])
    colors = film.color_uncertainty(thickness_sd_nm=2.0, space="lab")
    assert repr(colors).startswith("<iridesce.ColorUncertainty 31.6") and "+-" in repr(colors)
    assert Cells(colors._repr_html_()).rows[1][1].startswith("31.62 \u00b1")
    nm = np.linspace(400.0, 800.0, 201)
    oxide = ir.Stack(["air", ir.Layer("SiO2", 1000.0), "Si"])
    fit = ir.fit_thickness(nm, oxide.reflectance(nm), oxide)
    assert len(fit._repr_html_()) > 100


def test_every_public_object_can_be_pickled_and_copied() -> None:
    import copy
    import pickle

    film = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])
    scene, model = ir.Scene.load("soap-bubble"), ir.thickness.gradient(0.0, 800.0)
    for one in (film, film.first, ir.color.illuminant("A"), scene, model, model.map(4, 3)):
        assert pickle.loads(pickle.dumps(one)) == one
        assert copy.deepcopy(one) == one
