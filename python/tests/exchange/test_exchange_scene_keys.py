"""Roughness, maps and spectra of reflectance, lights without size: written where a target holds them, told where not."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import readers

import iridesce as ir
from iridesce.exchange import png

BRUSHED = [0.6, 0.2]
LIGHTS = [
    {"sun": {"direction": [0.0, 1.0, 0.0], "irradiance": 2.0, "angular_diameter_deg": 0.6}},
    {"directional": {"direction": [0.0, 3.0, 4.0], "irradiance": 5.0}},
    {"point": {"position": [0.0, 2.0, 0.0], "intensity": 8.0}},
    {"spot": {"position": [0.0, 3.0, 0.0], "target": [0.0, 0.0, 0.0], "cone_deg": 40.0, "soft_deg": 5.0}},
]


@pytest.fixture
def scene(tmp_path: Path) -> ir.Scene:
    """A rough coin, a brushed metal, a metal whose roughness is mapped, matt squares with a picture and a spectrum."""
    steps = np.linspace(0, 65535, 16).astype(np.uint16).reshape(4, 4)
    (tmp_path / "grey.png").write_bytes(png.png_bytes(steps[..., None], {}))
    (tmp_path / "rgb.png").write_bytes(png.png_bytes(np.repeat(steps[..., None], 3, axis=2), {}))
    (tmp_path / "paint.csv").write_text("nm,reflectance\n400,0.1\n550,0.1\n600,0.8\n700,0.8\n")
    layer = {"medium": "TiO2", "thickness_nm": 60.0}
    surfaces = {
        "coin": {"coating": {"layers": [layer], "substrate": "Ti", "roughness": 0.4}},
        "brushed": {"metal": {"medium": "Al", "roughness": BRUSHED}},
        "mapped": {"metal": {"medium": "Al", "roughness": {"map": "grey.png", "min": 0.2, "max": 0.6}}},
        "glass": {"dielectric": {"medium": 1.5, "roughness": 0.3}},
        "picture": {"diffuse": {"reflectance": {"map": "rgb.png"}}},
        "paint": {"diffuse": {"reflectance": {"spectrum": "paint.csv"}}},
    }
    tree: dict[str, Any] = {
        "version": 1,
        "camera": {"position": [0, 0, 30], "aperture_radius": 0.1},
        "object": [
            {"name": name, "shape": {"disk": {"center": [3.0 * i, 0, 0], "radius": 1.0}}, "surface": surface}
            for i, (name, surface) in enumerate(surfaces.items())
        ],
        "light": LIGHTS,
    }
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(tree))
    return ir.Scene.load(path)


def test_gltf_holds_them(scene: ir.Scene, tmp_path: Path) -> None:
    report = ir.export(scene, "gltf", tmp_path / "out")
    root = json.loads((tmp_path / "out" / "scene.gltf").read_text())
    by_name = {one["name"]: one for one in root["materials"]}
    assert by_name["coin"]["pbrMetallicRoughness"]["roughnessFactor"] == pytest.approx(0.4)
    # Of alpha 0.36 along u and 0.04 along v the lesser is the factor's square, the greater mix(0.04, 1, strength^2).
    brushed = by_name["brushed"]
    direction = brushed["extensions"]["KHR_materials_anisotropy"]
    assert brushed["pbrMetallicRoughness"]["roughnessFactor"] == pytest.approx(0.2)
    assert 0.04 + direction["anisotropyStrength"] ** 2 * 0.96 == pytest.approx(0.36)
    assert direction["anisotropyRotation"] == 0.0
    texture = root["textures"][by_name["mapped"]["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"]]
    file = tmp_path / "out" / root["images"][texture["source"]]["uri"]
    values = png.read_png(file.read_bytes(), "map").values / 65535.0
    assert values[0, 0, 1] == pytest.approx(0.2, abs=1e-4) and values[3, 3, 1] == pytest.approx(0.6, abs=1e-4)
    assert (values[..., 2] == 1.0).all(), "metallic must stay 1"
    texture = root["textures"][by_name["picture"]["pbrMetallicRoughness"]["baseColorTexture"]["index"]]
    picture = root["images"][texture["source"]]["uri"]
    assert (tmp_path / "out" / picture).read_bytes() == (tmp_path / "rgb.png").read_bytes()
    red, green, _, _ = by_name["paint"]["pbrMetallicRoughness"]["baseColorFactor"]
    assert red > 0.6 > 0.3 > green
    lights = root["extensions"]["KHR_lights_punctual"]["lights"]
    assert [one["type"] for one in lights] == ["directional", "directional", "point", "spot"]
    assert lights[2]["intensity"] == pytest.approx(8.0 * 1e-4, rel=1e-3), (
        "per steradian in metres: the scene counts in cm"
    )
    told = "\n".join(report.dropped)
    assert "paint: the spectrum" in told and "disc of the sun" in told and "camera: its lens" in told


def test_what_gltf_holds_comes_back(scene: ir.Scene, tmp_path: Path) -> None:
    ir.export(scene, "gltf", tmp_path / "out")
    again, left_out = ir.import_scene(tmp_path / "out" / "scene.gltf")
    tree = again.to_dict()
    by_name = {item["name"]: item["surface"] for item in tree["object"]}
    assert by_name["coin"]["coating"]["roughness"] == pytest.approx(0.4)
    assert by_name["brushed"]["coating"]["roughness"] == pytest.approx(BRUSHED, rel=1e-6)
    assert by_name["glass"]["dielectric"]["roughness"] == pytest.approx(0.3)
    assert by_name["mapped"]["coating"]["roughness"] == pytest.approx(0.4, abs=1e-3)  # the mean of 0.2 to 0.6
    assert by_name["picture"]["diffuse"]["reflectance"] == {"map": "picture_reflectance.png"}
    kinds = [next(iter(light.items())) for light in tree["light"]]
    assert [kind for kind, _ in kinds] == ["directional", "directional", "point", "spot"]
    assert np.allclose(np.array(kinds[1][1]["direction"]) * 5.0, [0.0, 3.0, 4.0], atol=1e-5)
    assert kinds[1][1]["irradiance"] == pytest.approx(5.0, rel=1e-3)
    assert kinds[3][1]["cone_deg"] == pytest.approx(40.0, rel=1e-3) and kinds[3][1]["soft_deg"] == pytest.approx(
        5.0, rel=1e-2
    )
    assert not any("light" in sentence for sentence in left_out)
    ir.render(again, samples=1, size=(8, 8))


def test_the_validator_finds_nothing_in_them(scene: ir.Scene, tmp_path: Path) -> None:
    ir.export(scene, "gltf", tmp_path / "out")
    report = readers.node("validate.mjs", {"file": str(tmp_path / "out" / "scene.gltf")})
    assert report["issues"]["numErrors"] == 0, report["issues"]["messages"]


def test_openpbr_holds_roughness(scene: ir.Scene, tmp_path: Path) -> None:
    ir.export(scene, "openpbr", tmp_path / "out")

    def inputs(name: str) -> dict[str, str]:
        root = ET.parse(tmp_path / "out" / f"{name}.mtlx").getroot()
        surface = next(root.iter("open_pbr_surface"))
        return {one.get("name", ""): one.get("value") or "graph" for one in surface.findall("input")}

    assert float(inputs("coin")["specular_roughness"]) == pytest.approx(0.4)
    brushed = inputs("brushed")
    share = 1.0 - float(brushed["specular_roughness_anisotropy"])
    along = float(brushed["specular_roughness"]) ** 2 * np.sqrt(2.0 / (1.0 + share**2))
    assert (along, share * along) == (pytest.approx(0.36), pytest.approx(0.04))
    assert inputs("mapped")["specular_roughness"] == "graph"
    scene_again, _ = ir.import_scene(tmp_path / "out" / "coin.mtlx")
    assert scene_again.to_dict()["object"][0]["surface"]["coating"]["roughness"] == pytest.approx(0.4)


def test_materialx_validates_them(scene: ir.Scene, tmp_path: Path) -> None:
    mx = readers.module("MaterialX")
    ir.export(scene, "openpbr", tmp_path / "out")
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    for name in ("coin", "brushed", "mapped"):
        document = mx.createDocument()
        mx.readFromXmlFile(document, str(tmp_path / "out" / f"{name}.mtlx"))
        document.importLibrary(library)
        valid, message = document.validate()
        assert valid, message


def test_usd_holds_them(scene: ir.Scene, tmp_path: Path) -> None:
    readers.module("pxr")
    from pxr import Usd, UsdGeom, UsdLux, UsdShade

    ir.export(scene, "usd", tmp_path / "out")
    stage = Usd.Stage.Open(str(tmp_path / "out" / "scene.usda"))
    shader = UsdShade.Shader(stage.GetPrimAtPath("/World/coin/surface"))
    assert shader.GetInput("specular_roughness").Get() == pytest.approx(0.4)
    for place in ("/World/mapped/surface", "/World/picture_plain/surface"):
        name = "base_color" if "picture" in place else "specular_roughness"
        source = UsdShade.Shader(stage.GetPrimAtPath(place)).GetInput(name).GetConnectedSource()
        assert source is not None and source[0].GetPrim().IsValid()
    sun = UsdLux.DistantLight(stage.GetPrimAtPath("/World/light_0"))
    assert sun.GetAngleAttr().Get() == pytest.approx(0.6) and sun.GetIntensityAttr().Get() == pytest.approx(2.0)
    assert sun.GetNormalizeAttr().Get()
    way = UsdGeom.Xformable(stage.GetPrimAtPath("/World/light_1")).GetLocalTransformation()
    assert np.allclose(way.TransformDir((0, 0, -1)), [0.0, -0.6, -0.8], atol=1e-6), "light goes along -z of its frame"
    point = UsdLux.SphereLight(stage.GetPrimAtPath("/World/light_2"))
    # normalize divides by 4 pi r^2, a side sees pi r^2 of it.
    assert point.GetIntensityAttr().Get() / 4.0 == pytest.approx(8.0) and point.GetTreatAsPointAttr().Get()
    shaping = UsdLux.ShapingAPI(stage.GetPrimAtPath("/World/light_3"))
    angle, soft = shaping.GetShapingConeAngleAttr().Get(), shaping.GetShapingConeSoftnessAttr().Get()
    assert angle == pytest.approx(25.0) and angle * (1.0 - soft) == pytest.approx(20.0)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/camera"))
    radius = 0.1 * camera.GetFocalLengthAttr().Get() / (2.0 * camera.GetFStopAttr().Get())
    assert radius == pytest.approx(0.1, rel=1e-6)


def test_mitsuba_holds_them_and_they_come_back(scene: ir.Scene, tmp_path: Path) -> None:
    report = ir.export(scene, "mitsuba", tmp_path / "out")
    root = ET.parse(tmp_path / "out" / "scene.xml").getroot()
    kinds = [one.get("type") for one in root.iter("bsdf")]
    assert kinds.count("roughconductor") == 2 and kinds.count("roughdielectric") == 1
    alpha = {
        one.get("name"): float(one.get("value", "")) for one in root.iter("float") if "alpha" in one.get("name", "")
    }
    assert alpha["alpha_u"] in (pytest.approx(0.36), pytest.approx(0.09))
    film = next(one for one in root.iter("bsdf") if one.get("type") == "iridesce_film")
    facets = {one.get("name"): float(one.get("value", "")) for one in film.findall("float")}
    assert (facets["alpha_u"], facets["alpha_v"]) == (pytest.approx(0.16), pytest.approx(0.16))
    assert any("coin: light that goes from facet to facet" in sentence for sentence in report.dropped)
    assert any("disc of the sun" in sentence for sentence in report.dropped)
    text = (
        '<scene version="3.0.0"><shape type="sphere" id="a"><bsdf type="roughconductor"><string name="material" value="Al"/>'
        '<float name="alpha" value="0.09"/><string name="distribution" value="ggx"/></bsdf></shape>'
        '<emitter type="point"><point name="position" value="1, 2, 3"/><rgb name="intensity" value="5, 5, 5"/></emitter>'
        '<emitter type="directional"><vector name="direction" x="0" y="-1" z="0"/>'
        '<spectrum name="irradiance" value="2"/></emitter>'
        '<emitter type="spot"><transform name="to_world"><lookat origin="0,5,0" target="0,0,0" up="0,0,1"/></transform>'
        '<float name="cutoff_angle" value="30"/><float name="beam_width" value="20"/>'
        '<spectrum name="intensity" value="7"/></emitter>'
        "</scene>"
    )
    (tmp_path / "x.xml").write_text(text)
    again, left_out = ir.import_scene(tmp_path / "x.xml")
    tree = again.to_dict()
    assert tree["object"][0]["surface"]["metal"]["roughness"] == pytest.approx(0.3)
    point, sun, spot = (next(iter(light.values())) for light in tree["light"])
    assert point["position"] == [1.0, 2.0, 3.0] and point["intensity"] == pytest.approx(5.0)
    assert sun["direction"] == [0.0, 1.0, 0.0] and sun["irradiance"] == pytest.approx(2.0)
    assert (spot["cone_deg"], spot["soft_deg"], spot["intensity"]) == pytest.approx((40.0, 10.0, 7.0))
    assert np.allclose(spot["target"], [0.0, 4.0, 0.0]) and not any("the light" in one for one in left_out)


def test_mitsuba_sees_the_lights_as_bright_as_we_do(tmp_path: Path) -> None:
    """A grey square under each light, straight from above: Y of its middle."""
    mi = readers.module("mitsuba")
    mi.set_variant("scalar_spectral")
    for light in LIGHTS[1:]:
        tree: dict[str, Any] = {
            "version": 1,
            "camera": {"position": [0, 5, 0], "up": [0, 0, -1], "orthographic_height": 0.05, "resolution": [4, 4]},
            "object": [
                {
                    "name": "floor",
                    "shape": {"rectangle": {"center": [0, 0, 0], "u": [1, 0, 0], "v": [0, 0, -1]}},
                    "surface": {"diffuse": {"reflectance": 0.5}},
                },
                {
                    "name": "far",
                    "shape": {"sphere": {"center": [50, 0, 0], "radius": 1}},
                    "surface": {"film": {"medium": "soap", "thickness_nm": 300.0}},
                },
            ],
            "light": [light],
        }
        scene = ir.Scene.load(tree)
        ir.export(scene, "mitsuba", tmp_path)
        text = (tmp_path / "scene.xml").read_text()
        # The film far away needs a variant of llvm; the light does not.
        (tmp_path / "plain.xml").write_text(_without_film(text))
        theirs = np.array(mi.render(mi.load_file(str(tmp_path / "plain.xml")), spp=256))[..., 1].mean()
        ours = ir.render(scene, samples=4).xyz[..., 1].mean()
        assert theirs == pytest.approx(ours, rel=0.01), light


def _without_film(text: str) -> str:
    root = ET.fromstring(text)
    for shape in root.findall("shape"):
        if any(one.get("type") == "iridesce_film" for one in shape.iter("bsdf")):
            root.remove(shape)
    return ET.tostring(root, encoding="unicode")


def test_tables_tell_of_roughness(scene: ir.Scene, tmp_path: Path) -> None:
    coin = scene.to_dict()
    coin["object"] = coin["object"][:1]
    report = ir.export(coin, "lut", tmp_path / "out")
    assert any("coin: its roughness" in sentence for sentence in report.dropped)
    ir.export(coin, "cycles", tmp_path / "out")
    assert "ROUGHNESS = 0.4" in (tmp_path / "out" / "coin_cycles.py").read_text()
