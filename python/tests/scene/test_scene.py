"""Scenes: read, written, changed; every error says where. Bad input of all kinds: `test_bad_input.py`."""

from __future__ import annotations

import collections
import copy
import json
import os
import pickle
import shutil
import types
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from conftest import ROOT, Run
from iridesce.scene import scene_names, scene_text

FILM = "object.bubble.surface.film"
FULL = {
    "version": 1,
    "unit": "mm",
    "camera": {
        "position": [0.0, 1.0, 16.0],
        "target": [0.0, 0.5, 0.0],
        "up": [0.0, 1.0, 0.0],
        "fov_deg": 30.0,
        "resolution": [8, 6],
    },
    "render": {"samples": 2, "seed": 18446744073709551615, "max_depth": 8},
    "object": [
        {
            "name": "bubble",
            "shape": {"sphere": {"center": [0.0, 0.0, 0.0], "radius": 2.5}},
            "surface": {
                "film": {
                    "medium": [1.36, 0.001],
                    "thickness_nm": {"gradient": {"top": 10.0, "bottom": 700.0, "exponent": 0.5}},
                    "outside": "air",
                }
            },
        }
    ],
    "light": [
        {"environment": {"builtin": "studio", "rotation_deg": 12.5, "radiance": 2.0}},
        {"environment": {"illuminant": "lines:589.158*2,589.756", "radiance": 0.25}},
    ],
}
LEAST = {"version": 1, "camera": {}, "object": [{}], "light": [{"environment": {"illuminant": "D65"}}]}
SCENES = sorted([*(ROOT / "scenes").glob("*.toml"), *(ROOT / "scenes").glob("*.json")])


def test_a_scene_with_every_key_comes_back_as_it_was():
    given = copy.deepcopy(FULL)
    scene = ir.Scene.load(given)
    assert scene.to_dict() == FULL
    assert json.loads(scene.to_json()) == FULL
    assert given == FULL, "the dict is left as it was"
    scene.to_dict()["camera"]["fov_deg"] = 3.0
    assert scene.to_dict() == FULL, "a scene does not change through the dict it gave"


def test_what_is_left_out_is_filled_in():
    tree = ir.Scene.load(LEAST).to_dict()
    assert tree["unit"] == "cm"
    assert tree["camera"] == {
        "position": [0.0, 0.0, 16.0],
        "target": [0.0, 0.0, 0.0],
        "up": [0.0, 1.0, 0.0],
        "fov_deg": 35.0,
        "resolution": [512, 512],
    }
    assert tree["render"] == {"samples": 64, "seed": 1, "max_depth": 16}
    assert tree["object"][0]["name"] == "bubble"
    assert tree["object"][0]["surface"]["film"]["outside"] == "air"
    assert tree["light"] == [{"environment": {"illuminant": "D65", "radiance": 1.0}}]


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.name)
def test_every_scene_file_round_trips(path, monkeypatch, tmp_path):
    scene = ir.Scene.load(path)
    monkeypatch.chdir(path.parent)  # paths in a dict start from the current folder
    again = ir.Scene.load(scene.to_dict())
    assert again == scene
    assert again.to_dict() == scene.to_dict()
    shutil.copytree(path.parent / "maps", tmp_path / "maps")
    (tmp_path / "again.toml").write_text(scene.check())
    assert ir.Scene.load(tmp_path / "again.toml").to_dict() == scene.to_dict()


def test_every_scene_file_renders():
    assert len(SCENES) >= 7
    for path in SCENES:
        xyz = ir.render(path, size=(12, 8), samples=1).xyz
        assert np.isfinite(xyz).all(), path
        assert (xyz[..., 1] > 0.0).any(), path


def test_the_furnace_hides_its_film():
    for name in ("furnace.toml", "furnace.json"):
        assert np.abs(ir.render(ROOT / "scenes" / name).xyz[..., 1] - 1.0).max() <= 1e-4


def test_built_in_scenes():
    assert "soap-bubble" in scene_names()
    for name in scene_names():
        scene = ir.Scene.load(name)
        assert ir.Scene.load(scene.to_dict()) == scene
        assert repr(scene).startswith("<iridesce.Scene ")
    with pytest.raises(ir.SceneError, match='did you mean "soap-bubble"'):
        ir.Scene.load("soap-buble")
    with pytest.raises(ir.SceneError, match='did you mean "soap-bubble"'):
        scene_text("soapbubble")


def test_a_built_in_name_wins_over_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("soap-bubble").write_text("nonsense")
    assert ir.Scene.load("soap-bubble").to_dict()["camera"]["resolution"] == [512, 512]
    for path in (f".{os.sep}soap-bubble", Path("soap-bubble")):
        with pytest.raises(ir.SceneError, match="not valid TOML"):
            ir.Scene.load(path)
    Path("mine").write_text(scene_text("soap-bubble"))
    assert ir.Scene.load("mine") == ir.Scene.load("soap-bubble")


# --- what a dict may hold


def test_dicts_may_hold_numpy_paths_tuples_and_models(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "scenes" / "maps" / "two-windows.exr", tmp_path)
    tree = copy.deepcopy(FULL)
    tree["camera"].update(position=np.array([0.0, 1.0, 16.0], dtype=np.float32), resolution=(np.int64(8), np.uint8(6)))
    tree["render"]["samples"] = np.float64(2.0)
    film = tree["object"][0]["surface"]["film"]
    film.update(medium=1.36 + 0.001j, thickness_nm=ir.thickness.gradient(10, np.float32(700), exponent=0.5))
    tree["light"][0]["environment"] = types.MappingProxyType({"map": Path("two-windows.exr")})
    scene = ir.Scene.load(collections.OrderedDict(tree))
    expected = copy.deepcopy(FULL)
    expected["light"][0]["environment"] = {"map": "two-windows.exr", "rotation_deg": 0.0, "radiance": 1.0}
    assert scene.to_dict() == expected
    uniform = scene.with_value(f"{FILM}.thickness_nm", ir.thickness.uniform(320))
    assert uniform.to_dict()["object"][0]["surface"]["film"]["thickness_nm"] == 320.0


class Changes(dict):
    """Converting it changes the table it stands in."""

    def to_scene(self):
        raise AssertionError("a mapping is a table")


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (None, "got None"),
        (b"35", "got a value of type bytes"),
        ({35.0}, "got a value of type set"),
        (object(), "got a value of type object"),
        (float("nan"), "got NaN"),
        (True, "got true"),
        ("35", 'got "35"'),
        (10**400, "got inf"),
        ([35.0], "got [35.0]"),
        (np.array([[1.0, 2.0]]), "got a list of 1"),
        (np.array("35"), 'got "35"'),
        (np.datetime64("2026-01-01"), "got a value of type"),
        (Changes(a=1), 'got a table with "a"'),
        (1j, "got [0.0, 1.0]"),
    ],
)
def test_values_of_the_wrong_type_are_named(value, said):
    tree = copy.deepcopy(FULL)
    tree["camera"]["fov_deg"] = value
    for call in (lambda: ir.Scene.load(tree), lambda: ir.Scene.load(FULL).with_value("camera.fov_deg", value)):
        with pytest.raises(ir.SceneError) as caught:
            call()
        assert said in str(caught.value)
        assert "camera.fov_deg must be an angle" in str(caught.value)
        assert (caught.value.key, caught.value.file, caught.value.line) == ("camera.fov_deg", None, None)


@pytest.mark.parametrize(
    ("change", "said", "key"),
    [
        ({3: 4}, "keys of a scene are texts", None),
        ({"\ud800": 4}, "must be Unicode", None),
        ({"unit": "\ud800"}, "must be Unicode", "unit"),
        ({"light": [None] * 100_001}, "at most 100000 entries", "light"),
        ({"light": np.zeros(10**9, dtype=np.int8)}, "at most 100000 entries", "light"),
        ({"light": [{"environment": None}]}, "light.0.environment must be a table", "light.0.environment"),
        ({"object": {"name": "bubble"}}, "[[object]]", "object"),
        ({"object": [{}] * 100_001}, "at most 100000 entries", "object"),
        ({"light": FULL["light"] * 129}, "at most 256 tables", "light"),
    ],
    ids=range(9),
)
def test_dicts_that_are_no_scenes(change, said, key):
    with pytest.raises(ir.SceneError) as caught:
        ir.Scene.load({**FULL, **change})
    assert said in str(caught.value)
    assert caught.value.key == key


def test_a_dict_that_changes_while_it_is_read():
    tree = copy.deepcopy(FULL)

    class Meddler:
        def to_scene(self):
            tree["camera"].clear()
            tree["camera"].update({f"key-{i}": i for i in range(1000)})
            return 2.0

    tree["camera"]["fov_deg"] = Meddler()
    assert ir.Scene.load(tree).to_dict()["camera"]["fov_deg"] == 2.0


def test_errors_of_conversions_come_through():
    class Broken:
        def to_scene(self):
            raise ZeroDivisionError("mine")

    class Endless:
        def to_scene(self):
            return self

    with pytest.raises(ZeroDivisionError, match="mine"):
        ir.Scene.load(FULL).with_value("camera.fov_deg", Broken())
    with pytest.raises(ir.SceneError, match="nested deeper than 64"):
        ir.Scene.load(FULL).with_value("camera.fov_deg", Endless())


@pytest.mark.parametrize("source", [None, 3, b"soap-bubble", ["soap-bubble"], np.array(1.0), Path, ir.Image])
def test_what_is_no_scene(source):
    with pytest.raises(ir.SceneError, match="a scene is a built-in name, a path, a dict or"):
        ir.Scene.load(source)


def test_a_scene_is_made_by_load_only():
    scene = ir.Scene.load(FULL)
    assert ir.Scene.load(scene) is scene
    with pytest.raises(TypeError, match=r"ir\.Scene\.load"):
        ir.Scene(FULL)


# --- files


@pytest.mark.parametrize("path", sorted((ROOT / "scenes" / "bad").glob("*.toml")), ids=lambda path: path.stem)
def test_bad_scenes_tell_their_place(path, monkeypatch):
    """The first line is the message: `# scenes/bad/NAME.toml:LINE: what`."""
    monkeypatch.chdir(ROOT)
    relative = path.relative_to(ROOT)
    expected = path.read_text().split("\n", 1)[0].removeprefix("# ")
    with pytest.raises((ir.SceneError, ir.ResourceError)) as caught:
        ir.Scene.load(relative).resolve()
    assert str(caught.value) == expected
    if isinstance(caught.value, ir.ResourceError):
        assert path.stem == "monstrous-image"
        return
    assert caught.value.file == str(relative)
    line = expected.removeprefix(f"{relative}:").split(":")[0]
    assert caught.value.line == (int(line) if line.isdigit() else None)
    if "not valid TOML" not in expected and "is empty" not in expected:
        assert caught.value.key


def test_a_large_or_deep_file_is_refused_at_once(tmp_path):
    path = tmp_path / "scene.toml"
    for text, said in [
        ("a = " + "[" * 10_000_000, "recur"),
        ("# " + "x" * 100_000_000, "longer than 16 MiB"),
        ("a" + ".a" * 1_000_000 + " = 1", r"recur|nested|TOML"),
    ]:
        path.write_text(text)
        with pytest.raises(ir.SceneError, match=said) as caught:
            ir.Scene.load(path)
        assert caught.value.file == str(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_is_not_waited_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.toml")
    with pytest.raises(ir.SceneError, match="no ordinary file"):
        ir.Scene.load("pipe.toml")
    with pytest.raises(ir.SceneError, match="no ordinary file"):
        ir.Scene.load({**LEAST, "light": [{"environment": {"map": "pipe.toml"}}]})


def test_files_outside_the_folder_are_the_users_choice(tmp_path, iridesce: Run):
    inside = tmp_path / "inside"
    inside.mkdir()
    shutil.copy(ROOT / "scenes" / "maps" / "two-windows.exr", tmp_path / "map.exr")
    text = scene_text("soap-bubble").replace('builtin = "studio"', 'map = "../map.exr"')
    (inside / "scene.toml").write_text(text)
    with pytest.raises(ir.SceneError, match="allow_outside=True") as caught:
        ir.Scene.load(inside / "scene.toml")
    assert caught.value.line == text.split("map =")[0].count("\n") + 1
    assert caught.value.key == "light.0.environment.map"
    scene = ir.Scene.load(inside / "scene.toml", allow_outside=True)
    assert scene.with_value("render.samples", 2).to_dict()["light"][0]["environment"]["map"] == "../map.exr"
    assert pickle.loads(pickle.dumps(scene)) == scene
    refused = iridesce("check", "inside/scene.toml")
    assert refused.returncode == 3
    assert "--allow-outside" in refused.stderr
    assert iridesce("check", "inside/scene.toml", "--allow-outside").returncode == 0
    drawn = ("render", "inside/scene.toml", "--size", "8x6", "--samples", "1", "-o", "out.png")
    assert iridesce(*drawn).returncode == 3
    assert iridesce(*drawn, "--allow-outside").returncode == 0


def test_a_scene_keeps_its_folder_when_the_program_moves(tmp_path, monkeypatch):
    shutil.copy(ROOT / "scenes" / "maps" / "two-windows.exr", tmp_path / "map.exr")
    tree = {**LEAST, "light": [{"environment": {"map": "map.exr"}}]}
    monkeypatch.chdir(tmp_path)
    from_dict = ir.Scene.load(tree)
    Path("scene.toml").write_text(from_dict.check())
    from_file = ir.Scene.load("scene.toml")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir("elsewhere")
    for scene in (from_dict, from_file):
        assert scene.with_value("render.samples", 2).to_dict()["render"]["samples"] == 2
        assert pickle.loads(pickle.dumps(scene)).to_dict() == scene.to_dict()
    with pytest.raises(ir.SceneError, match="no such file"):
        ir.Scene.load(tree)


# --- changing one value


def test_with_value_gives_a_new_scene():
    scene = ir.Scene.load("soap-bubble")
    thick = scene.with_value(f"{FILM}.thickness_nm", 400.0)
    assert thick.to_dict()["object"][0]["surface"]["film"]["thickness_nm"] == 400.0
    assert scene != thick
    assert scene == ir.Scene.load("soap-bubble")
    assert hash(scene) == hash(ir.Scene.load("soap-bubble"))
    back = thick.with_value(f"{FILM}.thickness_nm", {"gradient": {"top": 1, "bottom": 2}})
    assert back.to_dict()["object"][0]["surface"]["film"]["thickness_nm"] == {
        "gradient": {"top": 1.0, "bottom": 2.0, "exponent": 1.0}
    }
    lit = back.with_value("light.0.environment.illuminant", "A").with_value("light.0.environment.radiance", 3)
    assert lit.to_dict()["light"][0]["environment"]["radiance"] == 3.0
    assert "builtin" not in lit.to_dict()["light"][0]["environment"]
    assert lit.with_value("object.0.name", "b").to_dict()["object"][0]["name"] == "b"


@pytest.mark.parametrize(
    ("path", "value", "key", "said"),
    [
        ("camera.fov", 3.0, "camera.fov", 'did you mean "fov_deg"'),
        ("object.buble.shape", 3.0, "object.buble", 'did you mean "bubble"'),
        ("object.7.shape", 3.0, "object.7", "known here: bubble"),
        ("light.1.environment", {}, "light.1", "numbers from 0 to 0"),
        (f"{FILM}.thickness_nm", -12.0, f"{FILM}.thickness_nm", "got -12.0"),
        (f"{FILM}.medium", "sopa", f"{FILM}.medium", 'did you mean "soap"'),
        ("render", 3, "render", "render must be a table with the keys samples, seed, max_depth and backdrop"),
        ("", 3, "", "is no path into a scene"),
    ],
)
def test_with_value_says_what_is_wrong(path, value, key, said):
    with pytest.raises(ir.SceneError) as caught:
        ir.Scene.load("soap-bubble").with_value(path, value)
    assert said in str(caught.value)
    assert caught.value.key == key


def test_with_value_of_a_file_names_the_file_but_no_line():
    """The value at fault stands in no line of the file."""
    path = ROOT / "scenes" / "minimal.toml"
    with pytest.raises(ir.SceneError) as caught:
        ir.Scene.load(path).with_value("camera.fov_deg", 200)
    assert (caught.value.file, caught.value.line) == (str(path), None)
    for wrong in (None, 3, ["camera"]):
        with pytest.raises(ir.SceneError, match="path must be a text"):
            ir.Scene.load(path).with_value(wrong, 3)
    with pytest.raises(ir.ResourceError, match="pixels"):
        ir.Scene.load(path).with_value("camera.resolution", [10**7, 10**7])


# --- the studio


def test_the_studio_is_made_at_once_and_is_light():
    """Its panels give the bubble something to mirror; straight ahead, behind the bubble, it is dark and even."""
    blank = {**LEAST, "light": [{"environment": {"builtin": "studio"}}], "render": {"samples": 4}}
    scene = ir.Scene.load(blank).with_value("object.0.shape.sphere", {"center": [0, 1000, 0], "radius": 0.001})
    ahead = ir.render(scene, size=(32, 32)).xyz
    assert ahead.min() > 0.0
    assert ahead.max() < 0.15, "the background stays dark"
    behind = ir.render(scene.with_value("camera.target", [0, 0, 32]).with_value("camera.fov_deg", 120), size=(64, 64))
    assert behind.xyz.max() > 3.0
    assert np.isfinite(behind.xyz).all()
    # D65 grey or close to it: no panel is coloured beyond the reach of a lamp's tint.
    xy = behind.xyz[..., :2] / behind.xyz.sum(axis=-1, keepdims=True)
    assert np.abs(xy - [0.3127, 0.3290]).max() < 0.03


# --- every shape, surface and thickness model

BROAD = copy.deepcopy(FULL)
BROAD["camera"] |= {"aperture_radius": 0.1, "focus_distance": 12.0}
BROAD["object"] = [
    {
        "name": "plate",
        "shape": {"rectangle": {"center": [0.0, 1.0, 0.0], "u": [2.0, 0.0, 0.0], "v": [0.5, 1.0, 0.0]}},
        "surface": {
            "coating": {
                "layers": [
                    {
                        "medium": "TiO2-siefke",
                        "thickness_nm": {"gradient": {"top": 1.0, "bottom": 9.0, "exponent": 1.0}},
                    },
                    {"medium": [1.46, 0.0], "thickness_nm": 90.0},
                ],
                "substrate": "N-BK7",
            }
        },
    },
    {
        "name": "gap",
        "shape": {"disk": {"center": [0.0, 0.0, 0.0], "normal": [0.0, 3.0, 4.0], "radius": 2.0}},
        "surface": {
            "film": {
                "medium": "air",
                "thickness_nm": {"lens_gap": {"radius_mm": 500.0, "contact_gap_nm": 3.0}},
                "outside": "N-BK7",
            }
        },
    },
    {
        "name": "slick",
        "shape": {"plane": {"point": [0.0, -3.0, 0.0], "normal": [0.0, 1.0, 0.0]}},
        "surface": {
            "film": {
                "medium": "soap",
                "thickness_nm": {
                    "wedge": {"from": [0.0, 0.0, 0.0], "to": [1.0, 0.0, 2.0], "start_nm": 5.0, "end_nm": 400.0}
                },
                "outside": "air",
            }
        },
    },
    {
        "name": "dome",
        "shape": {
            "cap": {
                "center": [0.0, 0.0, 0.0],
                "axis": [0.0, 1.0, 0.0],
                "radius_of_curvature": -4.0,
                "aperture_radius": 2.0,
            }
        },
        "surface": {"dielectric": {"medium": 1.5}},
    },
    {
        "name": "ball",
        "shape": {"sphere": {"center": [9.0, 0.0, 0.0], "radius": 1.0}},
        "surface": {"metal": {"medium": "Au"}},
    },
    {
        "name": "wall",
        "shape": {"disk": {"center": [0.0, 0.0, -9.0], "normal": [0.0, 0.0, 1.0], "radius": 5.0}},
        "surface": {"diffuse": {"reflectance": [0.5, 0.25, 1.0]}},
    },
    {
        "name": "lamp",
        "shape": {"disk": {"center": [0.0, 9.0, 0.0], "normal": [0.0, -1.0, 0.0], "radius": 1.0}},
        "surface": {"emitter": {"illuminant": "FL2", "radiance": 5.0}},
    },
]
BROAD["light"] = [{"environment": {"builtin": "sky", "rotation_deg": 12.5, "radiance": 2.0}}]


def test_every_shape_and_surface_comes_back_as_it_was():
    scene = ir.Scene.load(BROAD)
    assert scene.to_dict() == BROAD
    assert json.loads(scene.to_json()) == BROAD
    assert pickle.loads(pickle.dumps(scene)) == scene


def test_check_writes_a_file_that_means_the_same(tmp_path):
    scene = ir.Scene.load(BROAD)
    (tmp_path / "again.toml").write_text(scene.check())
    assert ir.Scene.load(tmp_path / "again.toml").to_dict() == BROAD


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("object.plate.shape.rectangle.u", [3.0, 0.0, 0.0]),
        ("object.plate.surface.coating.layers.0.thickness_nm.gradient.top", 2.0),
        ("object.plate.surface.coating.layers.1.thickness_nm", 100.0),
        ("object.plate.surface.coating.layers.1.medium", "MgF2"),
        ("object.plate.surface.coating.substrate", "N-BK7"),
        ("object.gap.surface.film.thickness_nm.lens_gap.radius_mm", 750.0),
        ("object.slick.surface.film.thickness_nm.wedge.from.1", 0.5),
        ("object.dome.shape.cap.radius_of_curvature", 4.0),
        ("object.wall.surface.diffuse.reflectance", 0.5),
        ("object.wall.surface.diffuse.reflectance.2", 0.5),
        ("object.lamp.surface.emitter.illuminant", "A"),
        ("camera.aperture_radius", 0.5),
    ],
)
def test_values_inside_are_set_by_path(path, value):
    changed = ir.Scene.load(BROAD).with_value(path, value).to_dict()
    node = changed
    for key in path.split("."):
        names = (
            [item["name"] for item in node if isinstance(item, dict) and "name" in item]
            if isinstance(node, list)
            else []
        )
        node = node[names.index(key) if key in names else int(key)] if isinstance(node, list) else node[key]
    assert node == value
    assert ir.Scene.load(changed).to_dict() == changed


def test_the_medium_around_a_film_must_be_somewhere():
    with pytest.raises(
        ir.SceneError, match=r"must be the medium that the film lies in, here air \(n = 1\), got \"N-BK7\""
    ):
        ir.Scene.load(BROAD).with_value("object.plate.surface.coating.substrate", "Si").with_value(
            "object.dome.surface.dielectric.medium", 1.6
        )


def test_thickness_maps_lie_beside_the_scene(tmp_path):
    inside = tmp_path / "scene"
    (inside / "maps").mkdir(parents=True)
    for file in (tmp_path / "film.npy", inside / "maps" / "film.npy"):
        ir.thickness.uniform(150.0).map(2, 2).save(file)
    film = {"medium": "soap", "thickness_nm": {"map": "maps/film.npy"}}
    tree = {**LEAST, "object": [{"surface": {"film": film}}]}
    file = inside / "scene.json"
    file.write_text(json.dumps(tree))
    scene = ir.Scene.load(file)
    (inside / "maps" / "film.npy").write_bytes(b"no longer a map")
    again = scene.with_value("render.samples", 2)
    assert again.to_dict()["object"][0]["surface"]["film"]["thickness_nm"] == {"map": "maps/film.npy"}
    ir.thickness.uniform(150.0).map(2, 2).save(inside / "maps" / "film.npy")
    film["thickness_nm"]["map"] = "../film.npy"
    file.write_text(json.dumps(tree))
    with pytest.raises(ir.SceneError, match="lies outside the scene's folder") as caught:
        ir.Scene.load(file)
    assert caught.value.key == "object.bubble.surface.film.thickness_nm.map"
    ir.Scene.load(file, allow_outside=True)


def test_the_thickness_plane_looks_through_clear_faces() -> None:
    """Behind the lens of Newton's rings it shows the gap, r^2 / (2 R) to 1e-6; on a slick the oil; on a wafer its oxide."""
    image = ir.render("newtons-rings", size=(9, 9), samples=1)
    row = (np.arange(9) - 4.0) * 4.8 / 9  # mm
    square = row[:, None] ** 2 + row[None, :] ** 2
    gap_nm = 1e6 * square / (1000.0 + np.sqrt(1000.0**2 - square))
    np.testing.assert_allclose(image.channels["thickness_nm"], gap_nm, rtol=1e-6, atol=1e-3)
    assert np.nanmin(ir.render("oil-slick", size=(9, 9), samples=1).channels["thickness_nm"]) > 20.0
    wafer = ir.render("wafer", size=(33, 33), samples=1).channels["thickness_nm"]
    assert {2.0, 50.0, 500.0} <= set(np.unique(wafer[np.isfinite(wafer)]).tolist()) and np.isnan(wafer[0, 0])
