"""What the exported films become in the programs they are for: valid, in the right unit, the right way up, and as far
from the truth as the report says.

Predicted (the twin) against measured (the real reader): CIEDE2000 means within 0.5 on five charts of 168 colours.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import materialx_glsl
import numpy as np
import pytest
import readers

import iridesce as ir
from iridesce.exchange.films import film_of, read_stack
from iridesce.exchange.knobs import differences, knobs_of
from iridesce.exchange.package import Package
from iridesce.exchange.targets import gltf as gltf_target
from iridesce.exchange.targets import openpbr

HERE = Path(__file__).parent
STACKS = {
    "C1": "air / soap ? / air",
    "C3": "air / 1.47 ? / water",
    "C4": "air / MgF2 ? / N-BK7",
    "C5": "air / SiO2 ? / Si",
    "C6": "air / TiO2 ? / Ti",
}
RANGE_NM = (50.0, 1200.0)
TO_XYZ = np.linalg.inv(ir.color.rgb_matrix("linear-srgb"))
WITHIN = 0.5

Exported = tuple[Path, dict[str, ir.exchange.ExportReport]]


def grid() -> tuple[np.ndarray, np.ndarray]:
    angle = np.array([0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0])[:, None]
    t, cosine = np.broadcast_arrays(np.linspace(*RANGE_NM, 24)[None], np.cos(np.radians(angle)))
    return t.ravel(), cosine.ravel()


def exported(target: str, folder: Path, charts: tuple[str, ...] = tuple(STACKS)) -> dict[str, ir.exchange.ExportReport]:
    return {name: ir.export(STACKS[name], target, folder / name, vary=RANGE_NM) for name in charts}


# --- glTF


@pytest.fixture(scope="module")
def gltf(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    folder = tmp_path_factory.mktemp("gltf")
    return folder, exported("gltf", folder)


def test_three_js_shows_what_the_report_predicts(gltf: Exported) -> None:
    folder, reports = gltf
    t, cosine = grid()
    question = {
        "chromium": readers.chromium(),
        "folder": str(folder),
        "files": [f"{name}/film.gltf" for name in STACKS],
        "thickness_nm": t.tolist(),
        "cosine": cosine.tolist(),
    }
    answer = readers.node("three.mjs", question)
    assert answer["revision"] == "187"
    for name, seen in zip(STACKS, answer["answers"], strict=True):
        rgb = np.array(seen["rgb"]).reshape(7, 24, 4)[..., :3]
        measured = ir.validate(rgb @ TO_XYZ.T, name)
        assert abs(measured.delta_e["mean"] - reports[name].delta_e["mean"]) <= WITHIN, name
        # Its own fifth power explains what is left.
        stack, layer = read_stack(STACKS[name])
        film = film_of(stack, layer, RANGE_NM, None, ir.color.illuminant("D65"))
        three = differences(gltf_target.show_three, knobs_of(film, Package(), "gltf"), film).mean()
        assert abs(measured.delta_e["mean"] - three) <= 0.05, name
        assert measured.cause == "schlick", name
        assert seen["range"] == list(RANGE_NM) and seen["flipY"] is False and seen["colorSpace"] == "", name
        assert (seen["transmission"], seen["metalness"]) == ((0, 1) if name in ("C5", "C6") else (1, 0))


@pytest.mark.parametrize("scene", ["soap-bubble", "titanium", "newtons-rings"])
def test_the_validator_finds_nothing(tmp_path: Path, scene: str) -> None:
    ir.export(scene, "gltf", tmp_path)
    report = readers.node("validate.mjs", {"file": str(tmp_path / "scene.gltf")})
    assert report["issues"]["numErrors"] == report["issues"]["numWarnings"] == 0, report["issues"]["messages"]
    assert report["info"]["drawCallCount"] >= 1


def test_the_validator_finds_a_fault_that_is_made(gltf: Exported, tmp_path: Path) -> None:
    tree = json.loads((gltf[0] / "C1" / "film.gltf").read_text())
    tree["materials"][0]["extensions"]["KHR_materials_iridescence"]["iridescenceIor"] = 0.5
    (tmp_path / "x.gltf").write_text(json.dumps(tree))
    (tmp_path / "film.bin").write_bytes((gltf[0] / "C1" / "film.bin").read_bytes())
    (tmp_path / "film_thickness.png").write_bytes((gltf[0] / "C1" / "film_thickness.png").read_bytes())
    assert readers.node("validate.mjs", {"file": str(tmp_path / "x.gltf")})["issues"]["numErrors"] > 0


# --- MaterialX


def test_materialx_validates_and_makes_shaders(tmp_path: Path) -> None:
    mx = readers.module("MaterialX")
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    for name in STACKS:
        ir.export(STACKS[name], "openpbr", tmp_path / name, vary=RANGE_NM)
        document = mx.createDocument()
        mx.readFromXmlFile(document, str(tmp_path / name / "film.mtlx"))
        document.importLibrary(library)
        valid, message = document.validate()
        assert valid, message
        materials = document.getMaterialNodes()
        assert [one.getName() for one in materials] == (
            ["film", "film_conductor"] if name in ("C5", "C6") else ["film"]
        )
        surface = document.getChild("film_surface")
        assert surface.getInputValue("thin_film_weight") == 1.0
        # um: the remap of the map's 0..1.
        um = document.getDescendant("film_thickness/um")
        assert [um.getInputValue(end) for end in ("outlow", "outhigh")] == pytest.approx([0.05, 1.2], rel=1e-6)
        for material in materials:
            from MaterialX import PyMaterialXGenGlsl, PyMaterialXGenShader

            generator = PyMaterialXGenGlsl.EsslShaderGenerator.create()
            context = PyMaterialXGenShader.GenContext(generator)
            context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
            shader = generator.generate(material.getName(), material, context)
            assert "mx_fresnel_airy" in shader.getSourceCode("pixel")


def test_materialx_refuses_a_fault_that_is_made(tmp_path: Path) -> None:
    mx = readers.module("MaterialX")
    ir.export(STACKS["C1"], "openpbr", tmp_path, vary=RANGE_NM)
    text = (tmp_path / "film.mtlx").read_text().replace('name="thin_film_ior"', 'name="thin_film_index"')
    document, library = mx.createDocument(), mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    mx.readFromXmlString(document, text)
    document.importLibrary(library)
    assert not document.validate()[0]


def test_materialx_glsl_shows_what_the_report_predicts() -> None:
    mx = readers.module("MaterialX")
    t, cosine = grid()
    makers, names, predicted = [], [], []

    def vec3(values: np.ndarray) -> str:
        return f"vec3({', '.join(f'{x:.9f}' for x in values)})"

    for name, text in STACKS.items():
        stack, layer = read_stack(text)
        film = film_of(stack, layer, RANGE_NM, None, ir.color.illuminant("D65"))
        knobs = knobs_of(film, Package(), "openpbr", openpbr.CONDUCTOR_NM)
        tail = f"p.x, {knobs.film_ior:.9f}))"
        if knobs.base_ior is not None:
            makers.append(f"mx_fresnel_airy(p.y, mx_init_fresnel_dielectric({knobs.base_ior:.9f}, {tail}")
        else:
            makers.append(
                f"mx_fresnel_airy(p.y, mx_init_fresnel_schlick({vec3(knobs.f0)}, vec3(1.0), vec3(1.0), 5.0, {tail}"
            )
            index = knobs.index
            assert index is not None
            names.append(name)
            predicted.append(float(differences(openpbr.show, knobs, film).mean()))
            makers.append(
                f"mx_fresnel_airy(p.y, mx_init_fresnel_conductor({vec3(index.real)}, {vec3(index.imag)}, {tail}"
            )
        names.append(name)
        show = openpbr.show if knobs.base_ior is not None else openpbr.show_conductor
        predicted.append(float(differences(show, knobs, film).mean()))
    places = np.stack([t, cosine, np.arange(len(t), dtype=float)], axis=1).ravel().tolist()
    argument = {"source": materialx_glsl.source(mx), "calls": makers, "places": places, "count": len(t)}
    question = {"chromium": readers.chromium(), "call": materialx_glsl.RUN, "argument": argument}
    answers = readers.node("browser.mjs", question)["answer"]
    for name, twin, seen in zip(names, predicted, answers, strict=True):
        rgb = np.array(seen).reshape(7, 24, 4)[..., :3]
        measured = ir.validate(rgb @ TO_XYZ.T, name)
        assert abs(measured.delta_e["mean"] - twin) <= WITHIN, name
        if name in ("C1", "C3", "C4"):
            assert measured.cause == "cie rgb matrix", name


# --- USD


def test_usd_opens_with_the_same_numbers(tmp_path: Path) -> None:
    readers.module("pxr")
    from pxr import Usd, UsdGeom, UsdShade

    report = ir.export("soap-bubble", "usd", tmp_path)
    stage = Usd.Stage.Open(str(tmp_path / "scene.usda"))
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert UsdGeom.GetStageMetersPerUnit(stage) == pytest.approx(0.01) and UsdGeom.GetStageUpAxis(stage) == "Y"
    material = UsdShade.Material(stage.GetPrimAtPath("/World/bubble"))
    shader = material.ComputeSurfaceSource("mtlx")[0]
    assert shader.GetIdAttr().Get() == "ND_open_pbr_surface_surfaceshader"
    facts = stage.GetPrimAtPath("/World/bubble").GetCustomDataByKey("iridesce")
    um = UsdShade.Shader(stage.GetPrimAtPath("/World/bubble/um"))
    ends = [um.GetInput(end).Get() for end in ("outlow", "outhigh")]
    assert ends == pytest.approx([facts["thickness_min_nm"] / 1000.0, facts["thickness_max_nm"] / 1000.0], rel=1e-6)
    film_ior = ir.Medium("soap").index(550.0).real
    assert shader.GetInput("thin_film_ior").Get() == pytest.approx(film_ior, rel=1e-6)
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/bubble_shape"))
    points = np.array(mesh.GetPointsAttr().Get())
    assert np.allclose(np.linalg.norm(points, axis=1), 4.0, atol=1e-5)
    bound = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()[0]
    assert bound.GetPath() == "/World/bubble"
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/camera")).GetCamera()
    assert camera.GetFieldOfView(camera.FOVVertical) == pytest.approx(35.0, abs=1e-4)
    assert np.allclose(camera.transform.ExtractTranslation(), (0.0, 0.0, 16.0))
    assert any("transmission lobe" in sentence for sentence in report.dropped)
    # v upwards in USD: the top of the ball is v = 1.
    st = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
    assert st[np.argmax(points[:, 1]), 1] == pytest.approx(1.0)


@pytest.mark.parametrize("scene", ["titanium", "wafer", "newtons-rings", "oil-slick"])
def test_usd_opens_every_scene(tmp_path: Path, scene: str) -> None:
    readers.module("pxr")
    from pxr import Usd

    ir.export(scene, "usd", tmp_path)
    stage = Usd.Stage.Open(str(tmp_path / "scene.usda"))
    assert len([prim for prim in stage.Traverse() if prim.GetTypeName() == "Mesh"]) >= 2


# --- Cycles


@pytest.mark.slow
@pytest.mark.parametrize("name", STACKS)
def test_cycles_shows_what_the_report_predicts(tmp_path: Path, name: str) -> None:
    readers.blender()
    report = exported("cycles", tmp_path, (name,))[name]
    script = tmp_path / name / "film_cycles.py"
    answer = readers.run_blender(HERE / "blender_chart.py", script, "film", 512)
    measured = ir.validate(np.array(answer["rgb"]) @ TO_XYZ.T, name)
    assert abs(measured.delta_e["mean"] - report.delta_e["mean"]) <= WITHIN
    kind = {"C5": "ShaderNodeBsdfMetallic", "C6": "ShaderNodeBsdfAnisotropic"}.get(name, "ShaderNodeBsdfPrincipled")
    assert kind in answer["nodes"]
    if name == "C6":  # the table: right to a twentieth, so its rows and columns are where they should be
        assert measured.delta_e["mean"] < 0.05 and measured.cause is None


@pytest.mark.slow
def test_osl_in_cycles_reads_the_table_the_right_way_up(tmp_path: Path) -> None:
    readers.blender()
    report = ir.export(STACKS["C1"], "osl", tmp_path, vary=RANGE_NM)
    shader, table = tmp_path / "iridesce_film.osl", tmp_path / "film_reflectance.exr"
    answer = readers.run_blender(HERE / "blender_chart.py", shader, "film", 4, table, *RANGE_NM)
    measured = ir.validate(np.array(answer["rgb"]), "C1")
    assert measured.delta_e["mean"] == pytest.approx(report.delta_e["mean"], abs=0.02) and measured.cause is None
    assert measured.delta_e["mean"] < 0.05


# --- Mitsuba


@pytest.mark.slow
@pytest.mark.parametrize("name", ["C1", "C6"])
def test_mitsuba_renders_the_plugin(tmp_path: Path, name: str) -> None:
    readers.module("mitsuba")
    library = readers.llvm()
    report = exported("mitsuba", tmp_path, (name,))[name]
    assert report.delta_e["mean"] < 0.1
    finished = subprocess.run(
        [sys.executable, str(HERE / "mitsuba_chart.py"), str(tmp_path / name), "film_film.npz", *map(str, RANGE_NM)],
        capture_output=True,
        text=True,
        env={**os.environ, "DRJIT_LIBLLVM_PATH": library},
        check=False,
        timeout=300,
    )
    assert finished.returncode == 0, finished.stderr
    measured = ir.validate(np.array(json.loads(finished.stdout)["xyz"]), name)
    assert measured.delta_e["mean"] < 0.4  # of which the noise of 131 072 samples of four wavelengths is most


# --- units: the number in the file is the thickness, or a thousandth of it


@pytest.mark.parametrize("seed", range(5))
def test_exported_thicknesses_keep_their_unit(tmp_path: Path, seed: int) -> None:
    t = float(np.random.default_rng(seed).uniform(5.0, 5000.0))
    stack = ir.Stack(["air", ir.Layer("soap", t), "air"])
    for target in ("gltf", "openpbr", "usd", "cycles", "mitsuba", "osl"):
        ir.export(stack, target, tmp_path / target)
    tree = json.loads((tmp_path / "gltf" / "film.gltf").read_text())
    extension = tree["materials"][0]["extensions"]["KHR_materials_iridescence"]
    assert extension["iridescenceThicknessMaximum"] == t == extension["iridescenceThicknessMinimum"]
    files = {"openpbr": "film.mtlx", "usd": "film.usda", "cycles": "film_cycles.py"}
    texts = {target: (tmp_path / target / name).read_text() for target, name in files.items()}
    written = {
        "openpbr": texts["openpbr"].split('thin_film_thickness" type="float" value="')[1].split('"')[0],
        "usd": texts["usd"].split("inputs:thin_film_thickness = ")[1].split("\n")[0],
    }
    for text in written.values():
        assert abs(float(text) * 1000.0 - t) <= np.spacing(t)
    assert float(texts["cycles"].split("THICKNESS_NM = ")[1].split("\n")[0]) == pytest.approx(t, rel=1e-8)
    with np.load(tmp_path / "mitsuba" / "film_film.npz") as file:
        assert file["thickness_nm"].tolist() == [t, t]


def test_fit_brings_the_target_nearer(tmp_path: Path) -> None:
    plain = ir.export(STACKS["C6"], "gltf", tmp_path / "a", vary=RANGE_NM)
    fitted = ir.export(STACKS["C6"], "gltf", tmp_path / "b", vary=RANGE_NM, fit=True)
    assert plain.delta_e["mean"] > 13.0 and fitted.delta_e["mean"] < 10.5
    note = next(note for note in fitted.notes if "fit:" in note)
    assert f"{plain.delta_e['mean']:.2f} with the physical values, {fitted.delta_e['mean']:.2f}" in note


def test_what_a_target_cannot_hold_is_told(tmp_path: Path) -> None:
    two = ir.export("air / MgF2 90 / TiO2 ? / N-BK7", "gltf", tmp_path, vary=(50.0, 100.0))
    assert any("MgF2 above the film" in sentence for sentence in two.dropped)
    absorbing = ir.export("air / Fe3O4 ? / Fe", "openpbr", tmp_path, vary=(10.0, 100.0))
    assert any("absorption of the film" in sentence for sentence in absorbing.dropped)
    slab = ir.export("air / soap 1e4 incoherent / air", "gltf", tmp_path)
    assert any("incoherent" in sentence for sentence in slab.dropped)
    gap = ir.export("newtons-rings", "gltf", tmp_path)
    assert any("lower index than the medium outside" in sentence for sentence in gap.dropped)


def test_the_same_bytes_each_time(tmp_path: Path) -> None:
    for target in ("gltf", "openpbr", "usd", "cycles", "mitsuba"):
        first, second = (ir.export("soap-bubble", target, tmp_path / f"{target}{which}") for which in "ab")
        for a, b in zip(first.files, second.files, strict=True):
            assert a.read_bytes() == b.read_bytes(), a.name
            assert str(tmp_path).encode() not in a.read_bytes(), a.name


def test_the_first_row_of_a_map_is_the_top_in_every_target(tmp_path: Path) -> None:
    from iridesce.exchange import png

    grid = np.array([[100.0, 200.0], [300.0, 400.0]])
    ir.thickness.ThicknessMap(grid).save(tmp_path / "map.npy")
    for target in ("gltf", "openpbr", "usd", "cycles"):
        ir.export("air / soap ? / air", target, tmp_path / target, thickness=tmp_path / "map.npy")
        file = png.read_png((tmp_path / target / "film_thickness.png").read_bytes(), target)
        assert file.peak == 65535
        assert np.allclose(100.0 + 300.0 * file.values[..., 1] / file.peak, grid, atol=0.01), target
    tree = json.loads((tmp_path / "gltf" / "film.gltf").read_text())
    film = tree["materials"][0]["extensions"]["KHR_materials_iridescence"]
    assert (film["iridescenceThicknessMinimum"], film["iridescenceThicknessMaximum"]) == (100.0, 400.0)
    # v is turned for glTF, which counts from the top: the highest point of the ball reads the first row.
    points = np.frombuffer((tmp_path / "gltf" / "film.bin").read_bytes(), "<f4")
    view = {key: tree["bufferViews"][tree["accessors"][n]["bufferView"]] for key, n in
            tree["meshes"][0]["primitives"][0]["attributes"].items()}  # fmt: skip
    place, uv = (
        points[view[key]["byteOffset"] // 4 :][: view[key]["byteLength"] // 4] for key in ("POSITION", "TEXCOORD_0")
    )
    top = int(np.argmax(place.reshape(-1, 3)[:, 1]))
    assert uv.reshape(-1, 2)[top, 1] == 0.0
