"""Bad input, item by item: what a stranger can get wrong, through the Python API and the command line.

Every case asks for the right kind of error, for the words a user needs to find the mistake, and that files already on
disk stay as they were.
"""

from __future__ import annotations

import copy
import json
import math
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from conftest import Run
from oracles import environment

SOAP = "object.bubble.surface.film"
QUICK = ("--size", "8x6", "--samples", "1")
GOOD = {
    "version": 1,
    "camera": {"position": [0.0, 0.0, 4.0], "target": [0.0, 0.0, 0.0], "resolution": [8, 6]},
    "render": {"samples": 1, "seed": 1},
    "object": [
        {
            "name": "bubble",
            "shape": {"sphere": {"center": [0.0, 0.0, 0.0], "radius": 1.0}},
            "surface": {"film": {"medium": 1.33, "thickness_nm": {"gradient": {"top": 0.0, "bottom": 800.0}}}},
        }
    ],
    "light": [{"environment": {"illuminant": "D65", "radiance": 1.0}}],
}
TOML = """\
version = 1
[camera]
position = [0.0, 0.0, 4.0]
target = [0.0, 0.0, 0.0]
resolution = [8, 6]
[render]
samples = 1
[[object]]
name = "bubble"
shape = { sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 } }
surface = { film = { medium = 1.33, thickness_nm = 300.0 } }
[[light]]
environment = { illuminant = "D65" }
"""


def changed(path, value):
    """GOOD with one value replaced; ``path`` is a tuple of keys and indices."""
    tree = copy.deepcopy(GOOD)
    inner = tree
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return tree


def without(*path):
    """GOOD with one key left out."""
    tree = copy.deepcopy(GOOD)
    inner = tree
    for key in path[:-1]:
        inner = inner[key]
    del inner[path[-1]]
    return tree


def test_the_good_scene_is_good(iridesce: Run, tmp_path):
    """All cases below change one thing in these two; they must be right to begin with."""
    assert ir.render(GOOD).xyz.shape == (6, 8, 3)
    (tmp_path / "good.toml").write_text(TOML)
    assert iridesce("render", "good.toml").returncode == 0


# --- NaN, infinities, negative lengths

FILM = ("object", 0, "surface", "film")
SPHERE = ("object", 0, "shape", "sphere")
LIGHT = ("light", 0, "environment")
BAD_NUMBERS = [
    (("camera", "position"), [math.nan, 0.0, 4.0], "position"),
    (("camera", "target"), [0.0, math.inf, 0.0], "target"),
    (("camera", "up"), [0.0, math.nan, 0.0], "up"),
    (("camera", "fov_deg"), math.nan, "fov_deg"),
    (("camera", "fov_deg"), -35.0, "fov_deg"),
    (("camera", "fov_deg"), 0.0, "fov_deg"),
    (("camera", "fov_deg"), 180.0, "fov_deg"),
    (("camera", "orthographic_height"), -1.0, "orthographic_height"),
    (("camera", "orthographic_height"), math.inf, "orthographic_height"),
    ((*SPHERE, "radius"), math.nan, "radius"),
    ((*SPHERE, "radius"), -1.0, "radius"),
    ((*SPHERE, "radius"), 0.0, "radius"),
    ((*SPHERE, "radius"), math.inf, "radius"),
    ((*SPHERE, "center"), [0.0, -math.inf, 0.0], "center"),
    ((*FILM, "thickness_nm"), math.nan, "thickness_nm"),
    ((*FILM, "thickness_nm"), -12.0, "thickness_nm"),
    ((*FILM, "thickness_nm"), math.inf, "thickness_nm"),
    ((*FILM, "thickness_nm", "gradient", "top"), -1.0, "top"),
    ((*FILM, "thickness_nm", "gradient", "bottom"), math.nan, "bottom"),
    ((*FILM, "thickness_nm", "gradient", "exponent"), -2.0, "exponent"),
    ((*FILM, "thickness_nm", "gradient", "exponent"), math.inf, "exponent"),
    ((*FILM, "medium"), math.nan, "medium"),
    ((*FILM, "medium"), -1.33, "medium"),
    ((*FILM, "medium"), [1.33, math.inf], "medium"),
    ((*FILM, "outside"), [1.0, 0.5], "outside"),
    ((*LIGHT, "radiance"), math.nan, "radiance"),
    ((*LIGHT, "radiance"), -1.0, "radiance"),
    ((*LIGHT, "rotation_deg"), math.inf, "rotation_deg"),
    (("render", "samples"), -4, "samples"),
    (("render", "samples"), 0, "samples"),
    (("render", "samples"), 1.5, "samples"),
    (("render", "seed"), -1, "seed"),
    (("render", "max_depth"), 0, "max_depth"),
    (("render", "max_depth"), -3, "max_depth"),
]


@pytest.mark.parametrize(("path", "value", "said"), BAD_NUMBERS, ids=lambda v: str(v))
def test_bad_numbers_in_a_scene(path, value, said):
    with pytest.raises(ir.SceneError) as caught:
        ir.render(changed(path, value))
    assert said in str(caught.value)
    assert said in (caught.value.key or "")


@pytest.mark.parametrize(
    ("name", "bad"),
    [
        ("samples", 0),
        ("samples", -1),
        ("samples", 2.5),
        ("samples", math.nan),
        ("samples", "many"),
        ("seed", -1),
        ("seed", 2**64),
        ("seed", 0.5),
        ("threads", 0),
        ("threads", -2),
        ("threads", math.inf),
        ("size", (0, 6)),
        ("size", (8, -6)),
        ("size", (8,)),
        ("size", (8, 6, 3)),
        ("size", (math.nan, 6)),
        ("size", "8x6"),
        ("size", 8),
        ("backend", "gpu"),
        ("backend", "abacus"),
        ("progress", 3),
    ],
)
def test_bad_arguments_of_render(name, bad):
    with pytest.raises(ValueError, match=name):
        ir.render(GOOD, **{name: bad})


def film(thickness_nm=300.0):
    return ir.Stack(["air", ir.Layer(1.33, thickness_nm=thickness_nm), "air"])


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, -500.0, 0.0])
def test_bad_wavelengths(bad):
    with pytest.raises(ValueError, match="wavelength_nm"):
        film().reflectance(bad)
    with pytest.raises(ValueError, match=r"\(1, 2\)|\[1, 2\]"):  # its place in the array
        film().reflectance(np.array([[400.0, 500.0, 600.0], [400.0, 500.0, bad]]))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, 90.0, 1e300])
def test_bad_angles(bad):
    with pytest.raises(ValueError, match="angle_deg"):
        film().reflectance(550.0, angle_deg=bad)
    with pytest.raises(ValueError, match="angle_deg"):
        film().color(angle_deg=[0.0, bad])


@pytest.mark.parametrize("bad", [math.nan, math.inf, -12.0])
def test_bad_thicknesses(bad):
    with pytest.raises(ValueError, match="thickness_nm"):
        film(bad).reflectance(550.0)
    with pytest.raises(ValueError, match="thickness_nm"):
        film([1.0, 2.0, bad]).color()


@pytest.mark.parametrize("bad", [math.nan, math.inf, 0.0, -1.5, complex(1.5, math.nan), complex(math.inf, 0.0)])
def test_bad_indices(bad):
    with pytest.raises(ValueError, match=r"index|medium|n "):
        ir.Stack(["air", ir.Layer(bad, thickness_nm=100.0), "air"]).reflectance(550.0)


# --- empty arrays, shapes that do not broadcast


def test_empty_arrays():
    """An array without elements is a mistake upstream: it is named, not answered with another empty array."""
    with pytest.raises(ValueError, match=r"wavelength_nm.*empty"):
        film().reflectance(np.empty(0))
    with pytest.raises(ValueError, match=r"angle_deg.*empty"):
        film().reflectance(550.0, angle_deg=[])
    with pytest.raises(ValueError, match=r"thickness_nm.*empty"):
        film(np.empty((0, 3))).reflectance(550.0)
    with pytest.raises(ValueError, match=r"thickness_nm.*empty"):
        film(np.empty(0)).color()
    with pytest.raises(ValueError, match="wavelength_nm"):
        film().color(wavelength_nm=np.empty(0))
    with pytest.raises(ValueError, match=r"wavelength_nm|values"):
        ir.color.spectrum_to_xyz(np.empty(0), np.empty(0))
    with pytest.raises(ValueError):  # noqa: PT011  any wording
        ir.Stack([])


def test_shapes_that_do_not_broadcast():
    for call in (
        lambda: film().reflectance(np.linspace(400, 700, 95), angle_deg=np.linspace(0, 80, 81)),
        lambda: film(np.ones(5)).reflectance(np.linspace(400, 700, 7)),
        lambda: film(np.ones(5)).color(angle_deg=np.zeros(4)),
        lambda: film(np.ones(5)).amplitudes(np.linspace(400, 700, 7), 0.0, "s"),
    ):
        with pytest.raises(ValueError, match=r"broadcast.*\(\d+,?\)"):
            call()
    with pytest.raises(ValueError, match=r"\d"):
        ir.color.spectrum_to_xyz(np.linspace(400, 700, 31), np.ones(30))
    with pytest.raises(ValueError, match=r"\(4,\)|3"):
        ir.color.convert(np.ones(4), "xyz", "lab")
    with pytest.raises(ValueError, match=r"out|shape"):
        film().reflectance(np.linspace(400, 700, 7), out=np.empty(6))


# --- unknown media and keys


@pytest.mark.parametrize("medium", ["unobtainium", "", "sopa", "../water", "WATER "])
def test_unknown_media(medium, iridesce: Run):
    with pytest.raises(ValueError, match="medium"):
        ir.Medium(medium)
    with pytest.raises(ir.SceneError, match="medium"):
        ir.render(changed((*FILM, "medium"), medium))
    finished = iridesce("render", "soap-bubble", *QUICK, "--set", f"{SOAP}.medium={json.dumps(medium)}")
    assert finished.returncode == 3, finished.stderr
    assert "medium" in finished.stderr


def test_a_near_miss_is_named():
    with pytest.raises(ValueError, match="soap"):
        ir.Medium("saop")
    tree = changed((*FILM, "thicknes_nm"), 3.0)
    with pytest.raises(ir.SceneError, match="thickness_nm"):
        ir.Scene.load(tree)


@pytest.mark.parametrize(
    ("path", "near"),
    [
        (("camara",), "camera"),
        (("camera", "fov"), "fov_deg"),
        (("render", "sample"), "samples"),
        (("object", 0, "shapes"), "shape"),
        ((*SPHERE, "radios"), "radius"),
        ((*FILM, "thickness"), "thickness_nm"),
        ((*FILM, "thickness_nm", "gradient", "botom"), "bottom"),
        ((*LIGHT, "radience"), "radiance"),
    ],
    ids=lambda v: str(v),
)
def test_unknown_keys_suggest_the_nearest(path, near):
    with pytest.raises(ir.SceneError, match=near) as caught:
        ir.Scene.load(changed(path, 1.0))
    assert path[-1] in str(caught.value)


def test_an_unknown_key_is_named_with_file_and_line(iridesce: Run, tmp_path):
    (tmp_path / "typo.toml").write_text(TOML.replace("thickness_nm = 300.0", "thicknes_nm = 300.0"))
    with pytest.raises(ir.SceneError) as caught:
        ir.Scene.load(tmp_path / "typo.toml")
    assert caught.value.line == 11
    assert Path(caught.value.file).name == "typo.toml"
    assert "thicknes_nm" in caught.value.key
    finished = iridesce("render", "typo.toml")
    assert finished.returncode == 3
    assert "typo.toml:11" in finished.stderr
    assert 'did you mean "thickness_nm"' in finished.stderr


@pytest.mark.parametrize("name", ["version", "camera", "object", "light"])
def test_missing_parts(name):
    with pytest.raises(ir.SceneError, match=name):
        ir.render(without(name))


@pytest.mark.parametrize(
    "tree",
    [
        {},
        [],
        changed(("version",), 2),
        changed(("version",), "one"),
        changed(("object",), []),
        changed(("light",), []),
        changed(("unit",), "furlong"),
        changed(("camera",), 3),
        changed(("camera", "position"), [0.0, 4.0]),
        changed(("camera", "position"), "far"),
        changed(("camera", "resolution"), [8]),
        changed(("camera", "resolution"), [8.5, 6]),
        changed(("object", 0, "shape"), {}),
        changed(("object", 0, "shape"), {"sphere": {"radius": 1.0}, "cube": {}}),
        changed(("object", 0, "surface"), {"varnish": {}}),
        changed((*FILM, "thickness_nm"), "thick"),
        changed((*FILM, "thickness_nm"), {"gradient": {"top": 1.0}}),
        changed((*FILM, "thickness_nm"), {}),
        changed((*FILM, "thickness_nm"), True),
        changed((*LIGHT, "illuminant"), "D66"),
        changed(LIGHT, {"map": 3}),
        changed(LIGHT, {"map": "a.exr", "illuminant": "D65"}),
        changed(LIGHT, {"builtin": "cellar"}),
        changed(LIGHT, {}),
    ],
    ids=[str(i) for i in range(24)],
)
def test_trees_of_the_wrong_shape(tree):
    with pytest.raises((ir.SceneError, ValueError)) as caught:
        ir.render(tree)
    assert str(caught.value)


def test_nesting_without_end():
    """A tree that is too deep, or contains itself, is refused; it neither hangs nor overflows the stack."""
    deep: dict = {}
    for _ in range(20_000):
        deep = {"a": deep}
    with pytest.raises((ValueError, RecursionError)):
        ir.Scene.load(changed(("camera", "position"), deep))
    loop = copy.deepcopy(GOOD)
    loop["camera"]["target"] = loop
    with pytest.raises((ValueError, RecursionError)):
        ir.Scene.load(loop)


@pytest.mark.parametrize("scene", [None, 3, 4.5, b"soap-bubble", [GOOD]])
def test_what_is_no_scene(scene):
    with pytest.raises((ValueError, TypeError)):
        ir.render(scene)


# --- files missing, truncated or of the wrong kind


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, holding one good map."""
    monkeypatch.chdir(tmp_path)
    environment.write_exr(tmp_path / "good.exr", environment.bake(environment.smooth_grey, 16))
    return tmp_path


def with_map(name):
    return changed(LIGHT, {"map": name})


def test_a_missing_map(folder, iridesce: Run):
    assert ir.render(with_map("good.exr")).xyz.shape == (6, 8, 3)
    with pytest.raises(ir.SceneError, match=r"missing\.exr"):
        ir.render(with_map("missing.exr"))
    (folder / "scene.toml").write_text(TOML.replace('illuminant = "D65"', 'map = "missing.exr"'))
    finished = iridesce("render", "scene.toml")
    assert finished.returncode == 3
    assert "missing.exr" in finished.stderr


def test_truncated_maps(folder):
    """Cut at every kind of place: in the magic number, the header, the offset table, a scan line, one byte short."""
    whole = (folder / "good.exr").read_bytes()
    for length in [0, 1, 3, 4, 8, 40, 150, 300, 350, 450, len(whole) // 2, len(whole) - 400, len(whole) - 1]:
        (folder / "cut.exr").write_bytes(whole[:length])
        with pytest.raises(ir.SceneError, match=r"cut\.exr"):
            ir.render(with_map("cut.exr"))


def test_damaged_maps(folder):
    """Random bytes changed: an error or a picture without NaN, never a crash."""
    whole = (folder / "good.exr").read_bytes()
    rng = np.random.default_rng(7)
    refused = 0
    for _ in range(200):
        bad = bytearray(whole)
        for place in rng.integers(0, 420, size=3):
            bad[place] = rng.integers(0, 256)
        (folder / "bad.exr").write_bytes(bytes(bad))
        try:
            xyz = ir.render(with_map("bad.exr"), size=(2, 2)).xyz
        except ir.SceneError:
            refused += 1
        else:
            assert np.isfinite(xyz).all()
    assert 20 < refused < 200


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_maps_with_impossible_radiance(folder, value):
    image = environment.bake(environment.smooth_grey, 16)
    image[5, 7] = value
    environment.write_exr(folder / "bad.exr", image)
    with pytest.raises(ir.SceneError, match=r"bad\.exr"):
        ir.render(with_map("bad.exr"))


def test_maps_of_the_wrong_kind(folder):
    (folder / "text.exr").write_text("not a picture")
    (folder / "picture.exr").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    (folder / "folder.exr").mkdir()
    for name in ("text.exr", "picture.exr", "folder.exr", "", ".", "good.exr\0", "good.exr/inside.exr"):
        with pytest.raises(ir.SceneError):
            ir.render(with_map(name))


def test_a_map_that_promises_too_much(folder):
    """A header that claims 2^31 x 2^31 texels is refused before memory is asked for."""
    whole = (folder / "good.exr").read_bytes()
    window = np.array([0, 0, 31, 15], dtype="<i4").tobytes()
    assert whole.count(window) == 2
    huge = np.array([0, 0, 2**31 - 2, 2**31 - 2], dtype="<i4").tobytes()
    (folder / "huge.exr").write_bytes(whole.replace(window, huge))
    with pytest.raises(ValueError, match=r"huge\.exr"):
        ir.render(with_map("huge.exr"))


# --- shapes, surfaces and thickness models that cannot be

NAN = math.nan
DISK = {"disk": {"center": [0.0, 0.0, 0.0], "normal": [0.0, 1.0, 1.0], "radius": 1.0}}
RECTANGLE = {"rectangle": {"center": [0.0, 0.0, 0.0], "u": [1.0, 0.0, 0.0], "v": [0.0, 1.0, 0.0]}}
CAP = {"cap": {"center": [0.0, 0.0, 0.0], "axis": [0.0, 1.0, 0.0], "radius_of_curvature": 2.0, "aperture_radius": 1.0}}
WEDGE = {"wedge": {"from": [0.0, 0.0, 0.0], "to": [1.0, 0.0, 0.0], "start_nm": 0.0, "end_nm": 500.0}}
GAP = {"lens_gap": {"radius_mm": 1000.0, "contact_gap_nm": 0.0}}
COATING = {"coating": {"layers": [{"medium": 1.5, "thickness_nm": 100.0}], "substrate": 2.0}}


def scene_of(shape, surface):
    tree = copy.deepcopy(GOOD)
    tree["object"][0]["shape"], tree["object"][0]["surface"] = copy.deepcopy(shape), copy.deepcopy(surface)
    return tree


def filmed(thickness_nm):
    return {"film": {"medium": 1.33, "thickness_nm": thickness_nm}}


@pytest.mark.parametrize("shape", [DISK, RECTANGLE, CAP, {"plane": {}}])
def test_the_good_shapes_are_good(shape):
    ir.Scene.load(scene_of(shape, COATING))
    for thickness_nm in (WEDGE, 5.0) if "plane" in shape else (WEDGE, 5.0, GAP):
        ir.Scene.load(scene_of(shape, filmed(thickness_nm)))


BAD_SHAPES = [
    *((DISK, ("normal",), bad) for bad in ([0, 0, 0], [NAN, 0, 1], [0, 1], "up", [1e10, 0, 0], [0, 0, 1e-300])),
    *((DISK, ("radius",), bad) for bad in (0.0, -1.0, NAN, math.inf, "1")),
    *((RECTANGLE, ("u",), bad) for bad in ([0, 0, 0], [math.inf, 0, 0], [0, 0, 1e-12], [])),
    *((RECTANGLE, ("v",), bad) for bad in ([0, 0, 0], [2, 0, 0], [-1, 0, 1e-9], [1, 2, 3, 4])),
    *((CAP, ("axis",), bad) for bad in ([0, 0, 0], [NAN, NAN, NAN])),
    *((CAP, ("radius_of_curvature",), bad) for bad in (0.0, NAN, math.inf, -math.inf, 1e-12)),
    *((CAP, ("aperture_radius",), bad) for bad in (0.0, -1.0, 2.1, NAN, math.inf)),
    *(({"plane": {"point": [0, 0, 0], "normal": [0, 1, 0]}}, ("normal",), bad) for bad in ([0, 0, 0], None, 3.0)),
]


@pytest.mark.parametrize(("shape", "path", "bad"), BAD_SHAPES, ids=str)
def test_bad_shapes(shape, path, bad):
    tree = scene_of(shape, filmed(5.0))
    kind = next(iter(shape))
    tree["object"][0]["shape"][kind][path[0]] = bad
    with pytest.raises(ir.SceneError) as caught:
        ir.render(tree)
    assert caught.value.key == f"object.bubble.shape.{kind}.{path[0]}"


BAD_MODELS = [
    *((WEDGE, "from", bad) for bad in ([NAN, 0, 0], [1], None, 1e10)),
    *((WEDGE, "to", bad) for bad in ([0, 0, 0], [math.inf, 0, 0], "there")),
    *((WEDGE, "start_nm", bad) for bad in (NAN, -1.0, math.inf, 1.1e7, "0")),
    *((WEDGE, "end_nm", bad) for bad in (NAN, -1.0, math.inf, 1.1e7, [5.0])),
    *((GAP, "radius_mm", bad) for bad in (NAN, -1.0, 0.0, math.inf, 1e-10, 1e13)),
    *((GAP, "contact_gap_nm", bad) for bad in (NAN, -1.0, math.inf, 1.1e7)),
]


@pytest.mark.parametrize(("model", "key", "bad"), BAD_MODELS, ids=str)
def test_bad_thickness_models(model, key, bad):
    tree = scene_of(DISK, filmed(model))
    kind = next(iter(model))
    tree["object"][0]["surface"]["film"]["thickness_nm"][kind][key] = bad
    with pytest.raises(ir.SceneError) as caught:
        ir.render(tree)
    assert caught.value.key == f"object.bubble.surface.film.thickness_nm.{kind}.{key}"


@pytest.mark.parametrize(
    ("shape", "model", "said"),
    [
        ({"plane": {}}, {"gradient": {"top": 0.0, "bottom": 5.0}}, "no lowest and no highest point"),
        ({"disk": {"normal": [0.0, -2.0, 0.0]}}, {"gradient": {"top": 0.0, "bottom": 5.0}}, "no height"),
        ({"rectangle": {"u": [1, 0, 0], "v": [0, 1e-12, 1]}}, {"gradient": {"top": 0.0, "bottom": 5.0}}, "no height"),
        ({"plane": {}}, GAP, "wider than any lens"),
        (DISK, {"lens_gap": {"radius_mm": 9.99}}, "reaches 10.0 mm from its middle"),
        ({"disk": {"radius": 30.0}}, GAP, "at most 1e7 all over the shape"),
        (DISK, WEDGE | GAP, "got both wedge and lens_gap"),
        (DISK, {"gradient": {"top": 0.0, "bottom": 5.0}, "max_nm": 5.0}, "goes with a map"),
        (DISK, {}, "needs one of"),
        (DISK, {"wegde": {}}, 'did you mean "wedge"'),
    ],
)
def test_models_that_do_not_fit_their_shape(shape, model, said):
    for surface, place in (
        (filmed(model), "film.thickness_nm"),
        ({"coating": {"layers": [{"medium": 1.5, "thickness_nm": model}], "substrate": 2.0}}, "coating.layers.0"),
    ):
        with pytest.raises(ir.SceneError, match=said) as caught:
            ir.render(scene_of(shape, surface))
        assert f"surface.{place}" in (caught.value.key or "")


@pytest.mark.parametrize(
    ("surface", "key"),
    [
        ({"coating": {}}, "coating.substrate"),
        ({"coating": {"substrate": -1.5}}, "coating.substrate"),
        ({"coating": {"substrate": 1.5, "layers": 5}}, "coating.layers"),
        ({"coating": {"substrate": 1.5, "layers": [None]}}, "coating.layers.0"),
        ({"coating": {"substrate": 1.5, "layers": [{"medium": 1.5}]}}, "coating.layers.0.thickness_nm"),
        ({"coating": {"substrate": 1.5, "layers": [{"thickness_nm": 5}]}}, "coating.layers.0.medium"),
        ({"coating": {"substrate": 1.5, "layers": [{"medium": 1.5, "thickness_nm": NAN}]}}, "layers.0.thickness_nm"),
        ({"coating": {"substrate": 1.5, "layers": [{"medium": 1.5, "thickness_nm": 1.0}] * 1001}}, "coating.layers"),
        ({"coating": {"substrate": 1.5, "layers": [{"medium": 1.5, "thickness_nm": 6e6}] * 2}}, "coating.layers"),
        ({"dielectric": {"medium": "unobtainium"}}, "dielectric.medium"),
        ({"dielectric": {"medium": 0.0}}, "dielectric.medium"),
        ({"dielectric": {"medium": 1e-12}}, "dielectric.medium"),
        ({"metal": {"medium": [0.1, -3.0]}}, "metal.medium"),
        ({"metal": 3}, "metal"),
        ({"diffuse": {"reflectance": -0.1}}, "diffuse.reflectance"),
        ({"diffuse": {"reflectance": 1.0000001}}, "diffuse.reflectance"),
        ({"diffuse": {"reflectance": NAN}}, "diffuse.reflectance"),
        ({"diffuse": {"reflectance": [0.1, 0.2]}}, "diffuse.reflectance"),
        ({"diffuse": {"reflectance": [0.1, 0.2, "red"]}}, "diffuse.reflectance"),
        ({"diffuse": {"reflectance": None}}, "diffuse.reflectance"),
        ({"emitter": {"illuminant": "moon"}}, "emitter.illuminant"),
        ({"emitter": {"illuminant": "missing.csv"}}, "emitter.illuminant"),
        ({"emitter": {"illuminant": 6500}}, "emitter.illuminant"),
        ({"emitter": {"radiance": math.inf}}, "emitter.radiance"),
        ({"emitter": {"radiance": -1.0}}, "emitter.radiance"),
        ({"film": {}, "metal": {}}, "surface"),
    ],
    ids=str,
)
def test_bad_surfaces(surface, key):
    with pytest.raises(ir.SceneError) as caught:
        ir.render(scene_of({"sphere": {}}, surface))
    assert key in (caught.value.key or "")


@pytest.mark.parametrize(
    ("key", "bad"),
    [("aperture_radius", bad) for bad in (-0.1, NAN, math.inf, 1e-12, "wide")]
    + [("focus_distance", bad) for bad in (0.0, -1.0, NAN, math.inf, None)],
)
def test_bad_lenses(key, bad):
    with pytest.raises(ir.SceneError) as caught:
        ir.render(changed(("camera", key), bad))
    assert caught.value.key == f"camera.{key}"


# --- thickness maps


def with_thickness(name, **ends):
    return scene_of({"sphere": {}}, filmed({"map": name, **ends}))


def test_bad_thickness_maps(folder, iridesce: Run):
    np.save(folder / "good.npy", np.full((4, 4), 300.0))
    np.save(folder / "whole.npy", np.full((4, 4), 30, dtype=np.uint8))
    assert ir.render(with_thickness("good.npy")).xyz.shape == (6, 8, 3)
    key = "object.bubble.surface.film.thickness_nm"
    (folder / "empty.npy").write_bytes(b"")
    (folder / "folder.npy").mkdir()
    np.save(folder / "thick.npy", np.full((4, 4), 2e7))
    np.save(folder / "nan.npy", np.full((4, 4), NAN))
    for name, ends, said, at in [
        ("missing.npy", {}, "no such file", "map"),
        ("empty.npy", {}, "it is empty", "map"),
        ("folder.npy", {}, "it is a folder", "map"),
        ("nan.npy", {}, "it holds NaN at row 0, column 0", "map"),
        ("good.exr\0", {}, "cannot open", "map"),
        (3, {}, "must be a text", "map"),
        ("good.npy", {"min_nm": 0.0}, "must be left out", "min_nm"),
        ("good.npy", {"max_nm": 0.0}, "must be left out", "max_nm"),
        ("whole.npy", {}, "must be given: the map holds whole numbers", "min_nm"),
        ("whole.npy", {"min_nm": 0.0}, "must be given: the map holds whole numbers", "max_nm"),
        ("whole.npy", {"min_nm": -1.0, "max_nm": 1.0}, "from 0 to 1e7", "min_nm"),
        ("whole.npy", {"min_nm": 0.0, "max_nm": NAN}, "from 0 to 1e7", "max_nm"),
        ("whole.npy", {"min_nm": 2.0, "max_nm": 1.0}, "must be at least min_nm", "max_nm"),
    ]:
        with pytest.raises(ir.SceneError, match=said) as caught:
            ir.render(with_thickness(name, **ends))
        assert caught.value.key == f"{key}.{at}", (name, ends)
    with pytest.raises(ir.SceneError, match="at most 1e7"):
        ir.render(with_thickness("thick.npy"))
    text = TOML.replace("thickness_nm = 300.0", 'thickness_nm = { map = "nan.npy" }')
    (folder / "scene.toml").write_text(text)
    finished = iridesce("render", "scene.toml", cwd=folder)
    assert finished.returncode == 3
    assert "scene.toml:11" in finished.stderr


def test_damaged_thickness_maps(folder):
    """Random bytes changed, or the end cut off: an error or a map of thicknesses, never a crash."""
    rng = np.random.default_rng(8)
    grid = ir.thickness.ThicknessMap(rng.uniform(0.0, 900.0, (8, 8)))
    for name in ("film.tif", "film.exr", "film.npy"):
        grid.save(folder / name)
        whole = (folder / name).read_bytes()
        refused = 0
        for turn in range(200):
            bad = bytearray(whole[: rng.integers(0, len(whole))] if turn % 4 == 0 else whole)
            for place in rng.integers(0, max(len(bad), 1), size=3):
                bad[place : place + 1] = rng.bytes(1)
            (folder / name).write_bytes(bytes(bad))
            try:
                found = ir.thickness.ThicknessMap.load(folder / name).thickness_nm
            except ValueError:
                refused += 1
            else:
                assert np.isfinite(found).all() and (found >= 0.0).all()
        assert 20 < refused < 200, name


def test_a_thickness_map_that_promises_too_much(folder):
    header = b"{'descr': '<f4', 'fortran_order': False, 'shape': (2147483647, 2147483647), }"
    (folder / "huge.npy").write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    with pytest.raises(ValueError, match="at most 134217728"):
        ir.thickness.ThicknessMap.load(folder / "huge.npy")


@pytest.mark.parametrize(
    "content",
    [b"", b"\xff\xfe\x00", b"version = ", b"version = 1\nversion = 1\n", b"[[[[", TOML[:200].encode(), bytes(1000)],
    ids=[str(i) for i in range(7)],
)
def test_scene_files_of_the_wrong_kind(folder, iridesce: Run, content):
    (folder / "bad.toml").write_bytes(content)
    with pytest.raises(ir.SceneError) as caught:
        ir.render(folder / "bad.toml")
    assert "bad.toml" in f"{caught.value} {caught.value.file}"
    finished = iridesce("check", "bad.toml")
    assert finished.returncode == 3
    assert "bad.toml" in finished.stderr


def test_missing_scene_files(folder, iridesce: Run):
    for name in ("missing.toml", "folder-without/scene.toml"):
        with pytest.raises(ir.SceneError, match="toml"):
            ir.Scene.load(name)
        assert iridesce("render", name).returncode == 3
    (folder / "is-a-folder.toml").mkdir()
    with pytest.raises(ValueError, match="is-a-folder"):
        ir.Scene.load(folder / "is-a-folder.toml")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("empty.csv", ""),
        ("words.csv", "nm,n,k\nred,green,blue\n"),
        ("one.csv", "500\n600\n"),
        ("nan.csv", "400,1.5\n500,nan\n"),
        ("falling.csv", "500,1.5\n400,1.6\n500,1.7\n"),
        ("negative.csv", "-400,1.5\n500,1.6\n"),
        ("binary.csv", "\0\0\0\0"),
        ("empty.yml", ""),
        ("wrong.yml", "DATA: 3\n"),
        ("unknown.yml", "DATA:\n  - type: formula 99\n    wavelength_range: 0.3 0.9\n    coefficients: 1 2 3\n"),
        ("cut.yml", "DATA:\n  - type: tabulated nk\n    data: |\n        0.4 1.5\n"),
    ],
)
def test_bad_medium_files(folder, name, content):
    (folder / name).write_text(content)
    with pytest.raises(ValueError, match=name.split(".")[0]):
        ir.Medium.from_file(folder / name)


def test_missing_medium_file(folder):
    with pytest.raises((ValueError, OSError), match=r"missing\.yml"):
        ir.Medium.from_file(folder / "missing.yml")


# --- a zero-size or monstrous image


@pytest.mark.parametrize("resolution", [[0, 6], [8, 0], [0, 0], [-8, 6]])
def test_an_image_without_pixels(resolution, iridesce: Run):
    with pytest.raises(ir.SceneError, match="resolution"):
        ir.render(changed(("camera", "resolution"), resolution))
    with pytest.raises(ValueError, match="size"):
        ir.render(GOOD, size=tuple(resolution))
    width, height = resolution
    finished = iridesce("render", "soap-bubble", f"--size={width}x{height}", "--samples", "1")
    assert finished.returncode in ((2,) if width < 0 else (3,)), finished.stderr


@pytest.mark.parametrize("size", [(10**6, 10**6), (2**31, 2**31), (2**32 - 1, 1000), (2**63, 2**63), (10**30, 1)])
def test_a_monstrous_image(size, iridesce: Run, tmp_path):
    """Refused before it is begun, at once, with the kind of error that says "too big" rather than "wrong"."""
    with pytest.raises(ir.ResourceError) as caught:
        ir.render(GOOD, size=size)
    assert str(size[0]) in str(caught.value).replace(",", "").replace("_", "")
    finished = iridesce("render", "soap-bubble", "--size", f"{size[0]}x{size[1]}", timeout=20)
    assert finished.returncode == 4, finished.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_monstrous_image_in_the_scene():
    with pytest.raises(ir.ResourceError):
        ir.render(changed(("camera", "resolution"), [10**6, 10**6]))


def test_a_monstrous_spectrum(iridesce: Run):
    """An answer of 10^15 numbers cannot fit."""
    thickness_nm = np.broadcast_to(300.0, (10**5, 1, 1))
    with pytest.raises(ir.ResourceError):
        film(thickness_nm).reflectance(
            np.broadcast_to(550.0, (1, 10**5, 1)), angle_deg=np.broadcast_to(0.0, (1, 1, 10**5))
        )
    assert iridesce("spectrum", "air / soap 300 / air", "--step", "1e-12", timeout=20).returncode == 4


# --- a scene that points outside its folder


def test_a_map_outside_the_folder(tmp_path, monkeypatch, iridesce: Run):
    inside, outside = tmp_path / "inside", tmp_path / "outside"
    inside.mkdir()
    outside.mkdir()
    environment.write_exr(outside / "secret.exr", environment.bake(environment.smooth_grey, 16))
    (inside / "link.exr").symlink_to(outside / "secret.exr")
    (inside / "door").symlink_to(outside)
    monkeypatch.chdir(inside)
    for name in (
        "../outside/secret.exr",
        str(outside / "secret.exr"),
        "link.exr",
        "door/secret.exr",
        "door/../outside/secret.exr",
    ):
        with pytest.raises(ir.SceneError, match=r"folder|outside"):
            ir.render(with_map(name))
        (inside / "scene.toml").write_text(TOML.replace('illuminant = "D65"', f'map = "{name}"'))
        finished = iridesce("render", "scene.toml", cwd=inside)
        assert finished.returncode == 3, name
        assert "folder" in finished.stderr
    # the way in is open where it stays inside
    (inside / "maps").mkdir()
    environment.write_exr(inside / "maps" / "sky.exr", environment.bake(environment.smooth_grey, 16))
    assert ir.render(with_map("maps/../maps/sky.exr")).xyz.shape == (6, 8, 3)


# --- a camera that looks at itself


@pytest.mark.parametrize(
    ("camera", "said"),
    [
        ({"target": [0.0, 0.0, 4.0]}, "target"),
        ({"target": [0.0, 0.0, 4.0 + 1e-320]}, "target"),
        ({"up": [0.0, 0.0, 0.0]}, "up"),
        ({"up": [0.0, 0.0, -3.0]}, "up"),
        ({"position": [0.0, 4.0, 0.0]}, "up"),
    ],
)
def test_a_camera_that_cannot_look(camera, said, iridesce: Run, tmp_path):
    with pytest.raises(ir.SceneError, match=said):
        ir.render(changed(("camera",), {**GOOD["camera"], **camera}))
    text = TOML
    for key, value in camera.items():
        text = text.replace("[camera]\n", f"[camera]\n{key} = {value}\n")
        default = {"target": "target = [0.0, 0.0, 0.0]\n", "position": "position = [0.0, 0.0, 4.0]\n", "up": ""}[key]
        text = text.replace(default, "", 1) if default else text
    (tmp_path / "blind.toml").write_text(text)
    finished = iridesce("render", "blind.toml")
    assert finished.returncode == 3, finished.stderr
    assert said in finished.stderr


# --- an unwritable output


def test_unwritable_output(folder, iridesce: Run):
    image = ir.render(GOOD)
    (folder / "taken.png").mkdir()
    (folder / "file").write_text("precious")
    before = sorted(p.name for p in folder.iterdir())
    for name in ("nowhere/out.png", "nowhere/out.exr", "taken.png", "file/out.png", "x" * 300 + ".png"):
        with pytest.raises(OSError, match=r"out|taken|file|xxx"):
            image.save(name)
        assert iridesce("render", "soap-bubble", *QUICK, "-o", name).returncode == 1
    for name in ("out.bmp", "out", "", "out.png\0"):
        with pytest.raises((ValueError, OSError)):
            image.save(name)
    assert (folder / "file").read_text() == "precious"
    assert sorted(p.name for p in folder.iterdir()) == before, "no file and no half-written one was left"


def test_a_limit_on_file_size_loses_nothing(folder):
    """The disc fills up half-way (a limit of 100 bytes a file stands in for it): the old pictures stay, whole."""
    (folder / "kept.png").write_bytes(b"precious")
    (folder / "kept.exr").write_bytes(b"precious too")
    code = (
        "import resource, signal, iridesce as ir\n"
        "image = ir.render('soap-bubble', size=(64, 64), samples=1)\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))\n"
        "for name in ('kept.png', 'kept.exr'):\n"
        "    try:\n"
        "        image.save(name)\n"
        "    except OSError as error:\n"
        "        print('refused', name in str(error))\n"
    )
    finished = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=folder, check=False)
    assert finished.stdout.split() == ["refused", "True", "refused", "True"], finished.stderr
    assert (folder / "kept.png").read_bytes() == b"precious"
    assert (folder / "kept.exr").read_bytes() == b"precious too"
    assert sorted(p.name for p in folder.iterdir()) == ["good.exr", "kept.exr", "kept.png"]


@pytest.mark.parametrize("exposure", [math.nan, math.inf, "bright", None, [0.0]])
def test_a_bad_exposure_keeps_the_old_picture(folder, exposure):
    (folder / "kept.png").write_bytes(b"precious")
    image = ir.render(GOOD)
    with pytest.raises((ValueError, TypeError), match="exposure"):
        image.save("kept.png", exposure=exposure)
    assert (folder / "kept.png").read_bytes() == b"precious"
    with pytest.raises(ValueError, match="gamut"):
        image.rgb(gamut="wide")
    with pytest.raises(ValueError, match="space"):
        image.rgb(space="cmyk")


# --- and what errors are


def test_errors_are_value_errors_that_travel():
    """They survive pickling, as they must to come back from a worker process, with all they know."""
    for error in (ir.SceneError("what", file="a.toml", line=3, key="camera.fov_deg"), ir.ResourceError("too big")):
        assert isinstance(error, ValueError)
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error)
        assert str(again) == str(error)
        assert vars(again) == vars(error)
