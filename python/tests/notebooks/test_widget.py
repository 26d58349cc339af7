"""The notebook widget without a browser, and the notebooks of the docs, cell by cell."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import iridesce as ir
from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def table(widget: Any) -> tuple[Any, Any, Any]:
    rows, columns, last_nm, last_deg = widget._shape[:4]
    nodes = np.frombuffer(widget._nodes, dtype=np.float32).reshape(int(rows), int(columns), 6)
    return nodes, np.linspace(0.0, last_nm, int(columns)), np.linspace(0.0, last_deg, int(rows))


def test_a_film_is_told_in_numbers_and_follows_its_traits() -> None:
    film = ir.widget("air / soap 320 / air")
    assert (film.thickness_nm, film.angle_deg, film.illuminant) == (320.0, 0.0, "D65")
    before = film.description
    film.angle_deg, film.thickness_nm = 30.0, 412.5
    expected = ir.Stack.parse("air / soap 412.5 / air")
    assert film.description != before
    assert film.description.endswith(" ".join(f"{v:.4f}" for v in expected.color(30.0)))
    spectrum = np.frombuffer(film._spectrum, dtype=np.float32)
    assert np.abs(spectrum - expected.reflectance(np.arange(380.0, 781.0, 2.0), 30.0)).max() < 1e-6


def test_its_table_holds_the_colours_of_the_stack_under_its_lamp() -> None:
    film = ir.widget("air / TiO2 60 / Ti", illuminant="A", thickest_nm=300.0)
    for lamp in ["A", "D65"]:
        film.illuminant = lamp
        nodes, nm, deg = table(film)
        stack = ir.Stack(["air", ir.Layer("TiO2", thickness_nm=nm[None, ::9]), "Ti"])
        exact = stack.color(deg[::8, None], illuminant=lamp)
        white = ir.color.illuminant(lamp).white()
        labs = [ir.color.convert(values, "xyz", "lab", white=lamp) for values in (exact, nodes[::8, ::9, :3])]
        assert ir.color.delta_e(*labs).max() < 0.11
        assert np.allclose(film._shape[4:7], white)


def test_what_it_cannot_show_is_refused() -> None:
    import traitlets

    for wrong, words in [("air / Si", "layer"), ("titanium", "bubble"), ("no-such-scene", "scene")]:
        with pytest.raises(ValueError, match=words):
            ir.widget(wrong)
    film = ir.widget("air / soap 320 / air")
    for name, value in [("thickness_nm", -1.0), ("thickness_nm", 1e9), ("angle_deg", 89.0), ("illuminant", "candle")]:
        with pytest.raises(traitlets.TraitError):
            setattr(film, name, value)
    assert film.thickness_nm == 320.0


def test_a_bubble_has_the_thickness_of_its_scene() -> None:
    drained = ir.Scene.load("soap-bubble").with_value(
        "object.bubble.surface.film.thickness_nm", ir.thickness.gradient(top=0.0, bottom=800.0)
    )
    bubble = ir.widget(drained)
    assert bubble.kind == "bubble" and bubble.thickness_nm == pytest.approx(400.0, rel=1e-3)
    columns, rows = bubble._field_size
    shares = np.frombuffer(bubble._field, dtype=np.float32).reshape(rows, columns)
    assert shares[0].max() < 0.01 and shares[-1].min() > 1.99
    assert bubble._repr_png_()[1:4] == b"PNG"


def test_its_built_files_come_with_the_package() -> None:
    folder = Path(ir.__file__).parent / "notebooks"
    script = (folder / "widget.js").read_text(encoding="utf-8")
    assert "export" in script and "fetch(" not in script
    assert "node_modules" not in script, "the widget names folders of the machine that built it"
    assert (folder / "widget.css").stat().st_size > 200


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    codes = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert len(codes) >= 3
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, code in enumerate(codes):
        exec(compile(code, f"{path.name} cell {number}", "exec"), names)
    assert "iridesce" in sys.modules


def test_there_are_three() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["first-film", "fit-a-spectrum", "render-a-bubble"]
