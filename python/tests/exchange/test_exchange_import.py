"""The way in: what we wrote comes back, what others write is read or told, and units a thousand times off are refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import iridesce as ir
from conftest import Run


def only(scene: ir.Scene) -> dict[str, Any]:
    return scene.to_dict()["object"][0]


@pytest.mark.parametrize(("target", "file"), [("gltf", "film.gltf"), ("openpbr", "film.mtlx")])
def test_a_film_comes_back(tmp_path: Path, target: str, file: str) -> None:
    ir.export("air / soap 320 / air", target, tmp_path)
    scene, left_out = ir.import_scene(tmp_path / file)
    film = only(scene)["surface"]["film"]
    assert film["thickness_nm"] == pytest.approx(320.0)
    assert film["medium"] == pytest.approx(ir.Medium("soap").index(550.0).real, rel=1e-6)
    assert any("light" in sentence for sentence in left_out)


@pytest.mark.parametrize(("target", "file"), [("gltf", "film.gltf"), ("openpbr", "film.mtlx")])
def test_a_metal_comes_back_without_its_k_and_says_so(tmp_path: Path, target: str, file: str) -> None:
    ir.export("air / TiO2 60 / Ti", target, tmp_path)
    scene, left_out = ir.import_scene(tmp_path / file)
    coating = only(scene)["surface"]["coating"]
    assert coating["layers"][0]["thickness_nm"] == pytest.approx(60.0)
    assert any("k" in sentence and "metal" in sentence for sentence in left_out)


def test_a_scene_comes_back_from_gltf(tmp_path: Path) -> None:
    before = ir.Scene.load("wafer")
    ir.export(before, "gltf", tmp_path)
    after, _ = ir.import_scene(tmp_path / "scene.gltf")
    old, new = before.to_dict(), after.to_dict()
    names = {item["name"]: item for item in new["object"]}
    oxide = next(item for item in old["object"] if item["name"] == "oxide-250")
    again = names["oxide-250"]
    assert again["surface"]["coating"]["layers"][0]["thickness_nm"] == pytest.approx(250.0)
    centers = [np.array(item["shape"]["rectangle"]["center"]) for item in (oxide, again)]
    assert np.allclose(centers[1], centers[0] * 0.01, atol=1e-6)  # metres
    assert new["camera"]["fov_deg"] == pytest.approx(old["camera"]["fov_deg"])
    assert np.allclose(new["camera"]["position"], np.array(old["camera"]["position"]) * 0.01)
    assert "disk" in names["wafer"]["shape"]


def test_a_bubble_comes_back_as_a_sphere(tmp_path: Path) -> None:
    ir.export("soap-bubble", "gltf", tmp_path)
    scene, left_out = ir.import_scene(tmp_path / "scene.gltf")
    sphere = only(scene)["shape"]["sphere"]
    assert sphere["radius"] == pytest.approx(0.04, rel=1e-4) and np.allclose(sphere["center"], 0.0, atol=1e-6)
    film = only(scene)["surface"]["film"]["thickness_nm"]
    assert film["map"] == "bubble_thickness.png" and film["channel"] == "G" and film["min_nm"] < film["max_nm"]
    assert not any("thickness" in sentence for sentence in left_out)


def test_a_ramp_comes_back_as_its_map(tmp_path: Path) -> None:
    ir.export("air / soap ? / air", "gltf", tmp_path, vary=(100.0, 400.0))
    scene, _ = ir.import_scene(tmp_path / "film.gltf")
    film = only(scene)["surface"]["film"]["thickness_nm"]
    assert film == {**film, "map": "film_thickness.png", "min_nm": 100.0, "max_nm": 400.0, "channel": "G"}
    grid = ir.thickness.ThicknessMap.load(tmp_path / "film_thickness.png", min_nm=100.0, max_nm=400.0, channel="G")
    assert grid.thickness_nm[0, 0] == pytest.approx(100.0) and grid.thickness_nm[-1, 0] == pytest.approx(400.0)


def test_standard_surface_counts_in_nm(tmp_path: Path) -> None:
    (tmp_path / "x.mtlx").write_text(
        '<materialx version="1.39"><standard_surface name="oil" type="surfaceshader">'
        '<input name="thin_film_thickness" type="float" value="450"/><input name="thin_film_IOR" type="float" value="1.47"/>'
        '<input name="specular_IOR" type="float" value="1.33"/><input name="specular_roughness" type="float" value="0"/>'
        "</standard_surface></materialx>"
    )
    scene, _ = ir.import_scene(tmp_path / "x.mtlx")
    coating = only(scene)["surface"]["coating"]
    assert coating["layers"] == [{"medium": 1.47, "thickness_nm": 450.0}] and coating["substrate"] == 1.33


MITSUBA = """<scene version="3.0.0">
  <default name="n" value="1.4"/>
  <sensor type="perspective"><float name="fov" value="40"/><string name="fov_axis" value="y"/>
    <transform name="to_world"><lookat origin="0, 0, 10" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="320"/><integer name="height" value="200"/></film></sensor>
  <bsdf type="dielectric" id="glass"><float name="int_ior" value="$n"/></bsdf>
  <shape type="sphere" id="ball"><point name="center" x="1" y="2" z="3"/><float name="radius" value="2"/><ref id="glass"/></shape>
  <shape type="rectangle" id="floor">
    <transform name="to_world"><scale value="5"/><rotate x="1" angle="-90"/><translate y="-2"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.3, 0.4"/></bsdf></bsdf></shape>
  <shape type="disk"><bsdf type="conductor"><string name="material" value="Ag"/></bsdf></shape>
  <shape type="obj"><string name="filename" value="x.obj"/></shape>
  <emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>
</scene>"""


def test_mitsubas_subset(tmp_path: Path) -> None:
    (tmp_path / "x.xml").write_text(MITSUBA)
    scene, left_out = ir.import_scene(tmp_path / "x.xml")
    tree = scene.to_dict()
    ball, floor, disk = tree["object"]
    assert ball["shape"]["sphere"] == {"center": [1.0, 2.0, 3.0], "radius": 2.0}
    assert ball["surface"]["dielectric"]["medium"] == 1.4
    u, v = (np.array(floor["shape"]["rectangle"][key]) for key in "uv")
    assert np.allclose(np.cross(u, v), [0.0, 25.0, 0.0], atol=1e-9) and floor["shape"]["rectangle"]["center"][1] == -2.0
    assert floor["surface"]["diffuse"]["reflectance"] == [0.2, 0.3, 0.4] and disk["surface"]["metal"]["medium"] == "Ag"
    assert tree["camera"]["fov_deg"] == pytest.approx(40.0) and tree["camera"]["resolution"] == [320, 200]
    assert np.allclose(tree["camera"]["position"], [0, 0, 10]) and np.allclose(tree["camera"]["target"], [0, 0, 0])
    assert tree["light"][0]["environment"] | {} == {
        **tree["light"][0]["environment"],
        "illuminant": "D65",
        "radiance": 0.5,
    }
    assert any("obj file, which does not lie beside" in sentence for sentence in left_out)


def test_our_own_mitsuba_scene_comes_back(tmp_path: Path) -> None:
    tree = ir.Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", 400.0).to_dict()
    ir.export(tree, "mitsuba", tmp_path)
    scene, left_out = ir.import_scene(tmp_path / "scene.xml")
    assert only(scene)["surface"]["film"]["thickness_nm"] == 400.0 and only(scene)["shape"]["sphere"]["radius"] == 4.0
    assert scene.to_dict()["camera"]["fov_deg"] == pytest.approx(35.0)
    assert only(scene)["surface"]["film"]["medium"] == "soap" and not any("film" in one for one in left_out)
    text = (tmp_path / "scene.xml").read_text()
    (tmp_path / "scene.xml").write_text("\n".join(line for line in text.splitlines() if '"stack"' not in line))
    assert any("what the film is made of" in sentence for sentence in ir.import_scene(tmp_path / "scene.xml")[1])


# --- faults of a thousand


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_unit_that_is_a_thousand_times_off_is_refused(tmp_path: Path, factor: float) -> None:
    ir.export("air / soap 300 / air", "gltf", tmp_path)
    tree = json.loads((tmp_path / "film.gltf").read_text())
    film = tree["materials"][0]["extensions"]["KHR_materials_iridescence"]
    film["iridescenceThicknessMaximum"] *= factor
    (tmp_path / "film.gltf").write_text(json.dumps(tree))
    with pytest.raises(ValueError, match=r"film\.gltf.*a thousand times too"):
        ir.import_scene(tmp_path / "film.gltf")
    ir.export("air / soap 300 / air", "openpbr", tmp_path)
    text = (tmp_path / "film.mtlx").read_text()
    (tmp_path / "film.mtlx").write_text(text.replace('value="0.3"', f'value="{0.3 * factor}"'))
    with pytest.raises(ValueError, match=r"film\.mtlx.*a thousand times too"):
        ir.import_scene(tmp_path / "film.mtlx")


def test_an_odd_thickness_is_told(tmp_path: Path) -> None:
    ir.export("air / soap 3 / air", "gltf", tmp_path)
    _, left_out = ir.import_scene(tmp_path / "film.gltf")
    assert any("unusual" in sentence for sentence in left_out)


# --- bad input

ONE_MESH = (
    '{"asset": {}, "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],'
    '"accessors": [{"bufferView": 0, "componentType": 5126, "count": 9, "type": "VEC3"}],'
    '"bufferViews": [{"buffer": 0, "byteLength": 8}], "buffers": [{"uri": "%s", "byteLength": 3}]}'
)
ONE = '<input name="thin_film_weight" value="one"/>'
SHORT = '<transform name="to_world"><matrix value="1 2"/></transform>'


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("x.gltf", "{}", "no asset"),
        ("x.gltf", "no json", "no glTF"),
        ("x.gltf", '{"asset": {"version": "2.0"}, "nodes": []}', "nothing that a scene can hold"),
        ("x.gltf", '{"asset": {}, "scenes": [{"nodes": [7]}], "nodes": []}', "damaged glTF"),
        ("x.gltf", '{"asset": {}, "nodes": [{"children": [0]}]}', "in a circle"),
        ("x.gltf", ONE_MESH % "data:,AAAA", "beyond its buffer"),
        ("x.gltf", ONE_MESH % "../secret", "outside the file"),
        ("x.glb", "glTF", "cut short"),
        ("x.mtlx", "<materialx", "no XML"),
        ("x.mtlx", "<scene/>", "no MaterialX"),
        ("x.mtlx", "<materialx/>", "nothing that a scene can hold"),
        ("x.mtlx", '<!DOCTYPE a [<!ENTITY b "c">]><materialx>&b;</materialx>', "entities"),
        ("x.mtlx", f"<materialx><open_pbr_surface>{ONE}</open_pbr_surface></materialx>", "a number"),
        ("x.xml", "<materialx/>", "no scene of Mitsuba"),
        ("x.xml", '<scene><shape type="sphere"><float name="radius" value="big"/></shape></scene>', "a number"),
        ("x.xml", f'<scene><shape type="sphere">{SHORT}</shape></scene>', "16 numbers"),
        ("x.obj", "v 0 0 0", "ending in .gltf"),
    ],
)  # fmt: skip
def test_bad_files_are_refused_in_words(tmp_path: Path, name: str, content: str, message: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(ValueError, match=message):
        ir.import_scene(tmp_path / name)


def test_files_are_asked_for_by_their_decoded_names(tmp_path: Path) -> None:
    ir.export("soap-bubble", "gltf", tmp_path)
    (tmp_path / "scene.bin").rename(tmp_path / "my b\u00fcffer.bin")
    (tmp_path / "bubble_thickness.png").rename(tmp_path / "my map.png")
    text = (tmp_path / "scene.gltf").read_text("utf-8")
    text = text.replace("scene.bin", "my%20b%C3%BCffer.bin").replace("bubble_thickness.png", "my%20map.png")
    (tmp_path / "scene.gltf").write_text(text, "utf-8")
    scene, _ = ir.import_scene(tmp_path / "scene.gltf")
    assert scene.to_dict()["object"][0]["surface"]["film"]["thickness_nm"]["map"] == "my map.png"


def test_bad_questions() -> None:
    with pytest.raises(ValueError, match=r"missing\.gltf: no such file"):
        ir.import_scene("missing.gltf")
    with pytest.raises(ValueError, match="path must be a file"):
        ir.import_scene(3)  # type: ignore[arg-type]


def test_the_verb(iridesce: Run, tmp_path: Path) -> None:
    ir.export("air / soap 320 / air", "openpbr", tmp_path)
    finished = iridesce("import", "film.mtlx", "-o", "scene.toml")
    assert finished.returncode == 0 and "left out: no light" in finished.stderr
    assert iridesce("check", "scene.toml").returncode == 0
    answer = json.loads(iridesce("import", "film.mtlx", "--json").stdout)
    assert answer["scene"]["object"][0]["surface"]["film"]["thickness_nm"] == 320.0 and answer["left_out"]
    (tmp_path / "bad.mtlx").write_text("<a>")
    assert iridesce("import", "bad.mtlx").returncode == 3
    assert iridesce("import", "film.mtlx", "-o", "scene.json").returncode == 2
