"""Meshes, transforms, instances, walls of bubbles and bumps go out, and what formats hold comes back the same."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import readers

import iridesce as ir
from iridesce.exchange import exr, png
from iridesce.exchange.geometry import Mesh, Surface
from iridesce.exchange.pieces import turned
from iridesce.exchange.targets.mitsuba import ply_bytes
from iridesce.exchange.walls import walls

TILTED = {"scale": [1.0, 1.5, 0.8], "rotate_deg": [20.0, 30.0, 40.0], "translate": [-3.0, 1.0, 0.0]}
PUT = [
    {"translate": [0.0, -2.5, 0.0]},
    {"rotate_deg": [0.0, 0.0, 70.0], "translate": [2.0, -2.5, 0.5]},
    {"scale": [-1.0, 1.0, 1.0], "translate": [4.0, -2.5, 0.0]},
]
BALLS = [
    {"center": [2.0, 1.5, 0.0], "radius": 1.0},
    {"center": [3.0, 1.5, 0.0], "radius": 0.8},
    {"center": [2.4, 2.3, 0.1], "radius": 0.6},
]


def wavy() -> Mesh:
    """A hill over a square, smooth, with u and v."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 9))
    x, y = 2.0 * u - 1.0, 2.0 * v - 1.0
    z = 0.4 * np.exp(-2.0 * (x * x + y * y))
    slope = np.stack([1.6 * x / 0.4 * 0.4 * z, 1.6 * y * z, np.ones_like(z)], axis=-1).reshape(-1, 3)
    corner = np.arange(81).reshape(9, 9)
    a, b, c, d = (corner[i : 8 + i, j : 8 + j].ravel() for i, j in ((0, 0), (0, 1), (1, 1), (1, 0)))
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    normals = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    return Mesh(np.stack([x, y, z], -1).reshape(-1, 3), normals, np.stack([u.ravel(), v.ravel()], 1), triangles)


def made(folder: Path, **more: Any) -> ir.Scene:
    """Everything that geometry can be, matt and with films of constant index, under an even sky."""
    (folder / "hill.ply").write_bytes(ply_bytes(wavy()))
    steps = np.zeros((8, 8, 3), np.uint16)
    steps[:4] = 60000  # light above, dark below
    (folder / "halves.png").write_bytes(png.png_bytes(steps, {}))
    ramp = np.repeat(np.linspace(0, 65535, 64).astype(np.uint16)[None, :, None], 4, axis=0)
    (folder / "ramp.png").write_bytes(png.png_bytes(ramp, {}))
    film = {"film": {"medium": 1.4, "thickness_nm": 350.0}}
    hill = {"mesh": {"file": "hill.ply"}}
    objects = [
        {"name": "hill", "shape": hill, "transform": TILTED, "surface": film},
        {"name": "copies", "shape": hill, "instances": PUT, "surface": {"diffuse": {"reflectance": [0.7, 0.4, 0.2]}}},
        {
            "name": "pipe",
            "shape": {"cylinder": {"center": [-3.0, -2.5, 0.0], "axis": [1.0, 1.0, 0.5], "radius": 0.5, "height": 2.0}},
            "surface": {"diffuse": {"reflectance": {"map": "halves.png"}}},
        },
        {
            "name": "foam",
            "shape": {"bubbles": {"spheres": BALLS}},
            "surface": {"film": {"medium": 1.33, "thickness_nm": 300.0, "inner_thickness_nm": 450.0}},
        },
        {
            "name": "egg",
            "shape": {"sphere": {"center": [0, 0, 0], "radius": 1.0}},
            "transform": {"scale": [0.6, 0.9, 0.6], "translate": [0.0, 2.0, 0.0]},
            "priority": 2,
            "surface": {"dielectric": {"medium": 1.5}},
        },
    ]
    tree = {
        "version": 1,
        "unit": "cm",
        "camera": {"position": [0, 0, 16], "resolution": [64, 64]},
        "object": objects,
        "light": [{"environment": {"illuminant": "D65"}}],
        **more,
    }
    path = folder / "made.json"
    path.write_text(json.dumps(tree))
    return ir.Scene.load(path)


@pytest.fixture
def scene(tmp_path: Path) -> ir.Scene:
    return made(tmp_path)


def in_the_world(scene: ir.Scene, name: str, metres: float) -> np.ndarray:
    """Vertices and normals of a mesh, once for each instance."""
    number = next(i for i, item in enumerate(scene.to_dict()["object"]) if item["name"] == name)
    mesh, placements = scene._core.body(number)
    assert mesh is not None
    positions, normals = mesh[0] * metres, np.asarray(mesh[1], dtype=np.float64)
    found = []
    for placement in placements:
        linear = placement[:, :3]
        turned_normals = normals @ np.linalg.inv(linear)
        turned_normals /= np.linalg.norm(turned_normals, axis=1, keepdims=True)
        found.append(np.concatenate([positions @ linear.T + placement[:, 3] * metres, turned_normals], axis=1))
    return np.stack(found)


def alike(one: ir.Scene, other: ir.Scene, most: float) -> None:
    """The same picture but for noise and for edges of few pixels."""
    pictures = [ir.render(scene, samples=8, seed=3, size=(48, 48)).xyz.astype(np.float64) for scene in (one, other)]
    apart = np.abs(pictures[0] - pictures[1]).sum(axis=-1)
    assert float(np.median(apart)) < 0.01 and float(apart.mean()) < most, (np.median(apart), apart.mean())
    assert np.ptp(pictures[0][..., 1]) > 0.2, "nothing to see"


def test_a_gltf_comes_back_with_meshes_transforms_and_instances(scene: ir.Scene, tmp_path: Path) -> None:
    report = ir.export(scene, "gltf", tmp_path / "out")
    assert any("egg: its priority" in sentence for sentence in report.dropped)
    assert not any("not written" in sentence for sentence in report.dropped)
    again, left_out = ir.import_scene(tmp_path / "out" / "scene.gltf")
    names = {item["name"]: item for item in again.to_dict()["object"]}
    assert (
        len(names["copies"]["instances"]) == 3
        and "transform" in names["hill"]
        and "part" in names["hill"]["shape"]["mesh"]
    )
    for name in ("hill", "copies"):
        before, after = in_the_world(scene, name, 0.01), in_the_world(again, name, 1.0)
        assert np.allclose(before[..., :3], after[..., :3], atol=1e-8) and np.allclose(
            before[..., 3:], after[..., 3:], atol=1e-6
        )
    egg = names["egg"]
    assert egg["shape"]["sphere"]["radius"] == pytest.approx(0.01, rel=1e-4)
    assert np.allclose(np.diag(np.array(egg["transform"]["matrix"])[:, :3]), [0.6, 0.9, 0.6])
    assert names["foam-walls"]["surface"]["film"]["thickness_nm"] == pytest.approx(450.0)
    assert not any("mesh" in sentence for sentence in left_out), left_out
    alike(scene, again, 0.03)


def test_a_mitsuba_scene_comes_back_with_meshes_transforms_and_instances(scene: ir.Scene, tmp_path: Path) -> None:
    ir.export(scene, "mitsuba", tmp_path / "out")
    again, left_out = ir.import_scene(tmp_path / "out" / "scene.xml")
    before, after = in_the_world(scene, "hill", 1.0), in_the_world(again, "hill", 1.0)
    assert np.allclose(before, after, atol=1e-6)
    names = {item["name"]: item for item in again.to_dict()["object"]}
    assert len(names["copies"]["instances"]) == 2 and "transform" in names["copies_mirrored"]  # the mirrored one apart
    copies = in_the_world(scene, "copies", 1.0)
    assert np.allclose(in_the_world(again, "copies", 1.0), copies[:2], atol=1e-6)
    assert np.allclose(in_the_world(again, "copies_mirrored", 1.0)[0], copies[2], atol=1e-6)
    assert names["hill"]["surface"]["film"]["medium"] == 1.4 and names["pipe"]["uv"]["scale"] == [1.0, -1.0]
    assert not any("mesh" in sentence or "group" in sentence for sentence in left_out), left_out
    # The pipe's map lies as it did: its own brightness and all.
    alike(scene, again, 0.05)


def test_mitsuba_lays_maps_and_instances_as_we_do(tmp_path: Path) -> None:
    """Light above and dark below on a square and on instances of a mesh, one of them in a mirror."""
    mi = readers.module("mitsuba")
    mi.set_variant("scalar_spectral")
    tree = made(tmp_path).to_dict()
    halves = {"diffuse": {"reflectance": {"map": "halves.png"}}}
    square = {"rectangle": {"center": [-1.5, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0]}}
    put = [{"translate": [1.5, 0.0, 0.0]}, {"scale": [-0.5, 0.5, 0.5], "translate": [0.0, 2.0, 0.0]}]
    far = {
        "name": "far",
        "shape": {"sphere": {"center": [90, 0, 0], "radius": 1}},
        "surface": {"metal": {"medium": "Al"}},
    }
    tree["object"] = [
        {"name": "square", "shape": square, "surface": halves},
        {"name": "hills", "shape": {"mesh": {"file": "hill.ply"}}, "instances": put, "surface": halves},
        far,
    ]
    (tmp_path / "two.json").write_text(json.dumps(tree))
    scene = ir.Scene.load(tmp_path / "two.json")
    ir.export(scene, "mitsuba", tmp_path / "out")
    loaded = mi.load_file(str(tmp_path / "out" / "scene.xml"))
    theirs = np.array(mi.render(loaded, spp=16))[..., 1].reshape(16, 4, 16, 4).mean(axis=(1, 3))
    ours = ir.render(scene, samples=16, size=(64, 64)).xyz[..., 1].reshape(16, 4, 16, 4).mean(axis=(1, 3))
    assert np.abs(theirs - ours).mean() < 0.01
    assert np.abs(theirs - ours[::-1]).mean() > 0.05, "any picture would pass"


def test_usd_holds_the_same_points(scene: ir.Scene, tmp_path: Path) -> None:
    readers.module("pxr")
    from pxr import Usd, UsdGeom, UsdShade

    ir.export(scene, "usd", tmp_path / "out")
    stage = Usd.Stage.Open(str(tmp_path / "out" / "scene.usda"))
    cache = UsdGeom.XformCache()

    def points(path: str) -> np.ndarray:
        prim = stage.GetPrimAtPath(path)
        own = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get(), dtype=np.float64)
        matrix = np.array(cache.GetLocalToWorldTransform(prim))
        return own @ matrix[:3, :3] + matrix[3, :3]

    assert np.allclose(points("/World/hill_shape"), in_the_world(scene, "hill", 1.0)[0, :, :3], atol=1e-5)
    copies = in_the_world(scene, "copies", 1.0)
    for number in range(3):
        path = f"/World/copies_shape/at_{number + 1}/mesh"
        assert np.allclose(points(path), copies[number, :, :3], atol=1e-5)
        bound, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)).ComputeBoundMaterial()
        assert bound.GetPath() == "/World/copies_plain"
    assert (
        not stage.GetPrimAtPath("/World/copies_shape_one").IsDefined()
        or stage.GetPrimAtPath("/World/copies_shape_one").IsAbstract()
    )


def test_many_instances_are_instanced(scene: ir.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from iridesce.exchange.targets import gltf, usd

    monkeypatch.setattr(gltf, "MOST_NODES", 2)
    monkeypatch.setattr(usd, "MOST_PRIMS", 2)
    tree = scene.to_dict()
    turns = [
        {"rotate_deg": [40.0 * i, 100.0 * i, -70.0 * i], "scale": 1.0 + i, "translate": [i, 0, 0]} for i in range(5)
    ]
    tree["object"] = [tree["object"][0], {**tree["object"][1], "instances": turns}]
    (tmp_path / "many.json").write_text(json.dumps(tree))
    many = ir.Scene.load(tmp_path / "many.json")
    report = ir.export(many, "gltf", tmp_path / "out")
    assert any("EXT_mesh_gpu_instancing" in note for note in report.notes)
    again, _ = ir.import_scene(tmp_path / "out" / "scene.gltf")
    before, after = in_the_world(many, "copies", 0.01), in_the_world(again, "copies", 1.0)
    assert np.allclose(before[..., :3], after[..., :3], atol=1e-7) and np.allclose(
        before[..., 3:], after[..., 3:], atol=1e-5
    )
    readers.module("pxr")
    from pxr import Usd, UsdGeom

    ir.export(many, "usd", tmp_path / "out")
    stage = Usd.Stage.Open(str(tmp_path / "out" / "scene.usda"))
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath("/World/copies_shape"))
    own = np.array(UsdGeom.Mesh(stage.GetPrimAtPath("/World/copies_shape/one")).GetPointsAttr().Get(), dtype=np.float64)
    matrices = np.array(instancer.ComputeInstanceTransformsAtTime(Usd.TimeCode.Default(), Usd.TimeCode.Default()))
    seen = own @ matrices[:, :3, :3] + matrices[:, 3:, :3]
    assert np.allclose(seen, before[..., :3] * 100.0, atol=5e-3)  # half floats
    # A mirror image is no rotation: then nodes stand for all.
    assert turned(np.array([np.diag([-1.0, 1.0, 1.0, 1.0])[:3]])) is None


def test_the_validator_finds_nothing_in_geometry(scene: ir.Scene, tmp_path: Path) -> None:
    ir.export(scene, "gltf", tmp_path / "out")
    report = readers.node("validate.mjs", {"file": str(tmp_path / "out" / "scene.gltf")})
    assert report["issues"]["numErrors"] == 0, report["issues"]["messages"]
    assert report["issues"]["numWarnings"] == 0, report["issues"]["messages"]


def test_a_thickness_by_place_lies_on_a_mesh(tmp_path: Path) -> None:
    """A gradient and a wedge on meshes, one of them turned: what comes back is as thick where it was."""
    tree = made(tmp_path).to_dict()
    hill, copies = tree["object"][:2]
    hill["surface"] = {"film": {"medium": 1.4, "thickness_nm": {"gradient": {"top": 100.0, "bottom": 600.0}}}}
    wedge = {"from": [-1.0, 0.0, 0.0], "to": [5.0, 0.0, 0.0], "start_nm": 200.0, "end_nm": 500.0}
    copies["surface"] = {"film": {"medium": 1.4, "thickness_nm": {"wedge": wedge}}}
    tree["object"] = [hill, copies]
    (tmp_path / "laid.json").write_text(json.dumps(tree))
    scene = ir.Scene.load(tmp_path / "laid.json")
    report = ir.export(scene, "gltf", tmp_path / "out")
    assert {"hill", "copies", "copies-2", "copies-3"} == set(report.films or ()), (
        "a wedge differs from instance to instance"
    )
    again, _ = ir.import_scene(tmp_path / "out" / "scene.gltf")
    before, after = (
        ir.render(one, samples=4, seed=3, size=(64, 64)).channels["thickness_nm"].astype(np.float64)
        for one in (scene, again)
    )
    both = np.isfinite(before) & np.isfinite(after)
    assert both.sum() > 300 and (np.isfinite(before) != np.isfinite(after)).sum() < 20
    apart = np.abs(before - after)[both]
    assert np.median(apart) < 0.1 and np.percentile(apart, 95.0) < 2.0, (np.median(apart), np.percentile(apart, 95.0))
    assert np.ptp(before[both]) > 300.0


def test_walls_of_bubbles_lie_where_two_claim_alike() -> None:
    outer, inner = walls(BALLS)
    assert inner is not None and inner.normals is not None
    claims = np.stack(
        [
            ((mesh.positions - b["center"]) ** 2).sum(axis=1) / b["radius"] - b["radius"]
            for mesh in (inner,)
            for b in BALLS
        ]
    )
    least = np.sort(claims, axis=0)
    assert np.abs(least[0] - least[1]).max() < 1e-6 and least[0].max() < 1e-9
    # Two alike in balance: each a ball without the cap of a quarter of its height, between them a disk.
    outer, inner = walls([{"center": [0, 0, 0], "radius": 1.0}, {"center": [1.0, 0, 0], "radius": 1.0}])
    a, b, c = (outer.positions[outer.triangles[:, k]] for k in range(3))
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)
    assert volume == pytest.approx(2.0 * np.pi * (4.0 / 3.0 - 0.25 * 2.5 / 3.0), rel=3e-3)
    assert inner is not None
    a, b, c = (inner.positions[inner.triangles[:, k]] for k in range(3))
    area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    assert area == pytest.approx(0.75 * np.pi, rel=3e-3) and np.allclose(np.abs(inner.normals[:, 0]), 1.0)
    assert walls([{"center": [0, 0, 0], "radius": 1.0}])[1] is None


def test_a_closed_cylinder_holds_its_volume_and_its_chart() -> None:
    tube = Surface("cylinder", {"center": [0, 1, 0], "axis": [0, 2, 0], "radius": 2.0, "height": 3.0, "open": False})
    mesh = tube.mesh(fine=True)
    a, b, c = (mesh.positions[mesh.triangles[:, k]] for k in range(3))
    assert float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0) == pytest.approx(12.0 * np.pi, rel=1e-3)
    front, right = tube.points([0.5, 0.75], [0.0, 1.0])
    assert np.allclose(front, [0.0, -0.5, 2.0]) and np.allclose(right, [2.0, 2.5, 0.0])
    assert np.allclose(tube.span(np.array([1.0, 1.0, 0.0])), [1.0 - 3.5, 1.0 + 3.5])


def test_a_bump_is_as_steep_as_it_was(tmp_path: Path) -> None:
    """Heights that rise by 0.2 along u over a square 4 wide: normals lean back by atan(0.05), in glTF and in a scene."""
    tree = made(tmp_path).to_dict()
    tree["object"] = [
        {
            "name": "slope",
            "shape": {"rectangle": {"center": [0, 0, 0], "u": [2, 0, 0], "v": [0, 2, 0]}},
            "bump": {"map": "ramp.png", "height": 0.2},
            "surface": {"metal": {"medium": "Al"}},
        }
    ]
    (tmp_path / "slope.json").write_text(json.dumps(tree))
    for target in ("gltf", "usd", "mitsuba"):
        ir.export(ir.Scene.load(tmp_path / "slope.json"), target, tmp_path / target)
    for target in ("gltf", "usd"):
        values = png.read_png((tmp_path / target / "slope_normal.png").read_bytes(), "normals").values / 65535.0
        normal = 2.0 * values[2, 30] - 1.0
        # 63 steps from the first middle of a texel to the last of 64.
        assert -normal[0] / normal[2] == pytest.approx(0.05 * 64 / 63, rel=1e-3) and abs(normal[1]) < 1e-4
    root = json.loads((tmp_path / "gltf" / "scene.gltf").read_text())
    assert root["images"][root["materials"][0]["normalTexture"]["index"]]["uri"] == "slope_normal.png"
    assert "geometry_normal.connect" in (tmp_path / "usd" / "scene.usda").read_text()
    heights, _ = exr.read_exr((tmp_path / "mitsuba" / "slope_bump.exr").read_bytes(), "bump")
    assert heights["Y"][0, 0] == 0.0 and heights["Y"][0, -1] == 1.0
    again, _ = ir.import_scene(tmp_path / "mitsuba" / "scene.xml")
    assert again.to_dict()["object"][0]["bump"] == {"map": "slope_bump.exr", "height": 0.2}


# --- what others wrote


def test_an_open_body_is_told_and_can_be_drawn(scene: ir.Scene, tmp_path: Path) -> None:
    tree = scene.to_dict()
    tree["object"] = [tree["object"][0]]
    (tmp_path / "hill.json").write_text(json.dumps(tree))
    ir.export(ir.Scene.load(tmp_path / "hill.json"), "gltf", tmp_path / "out")
    path = tmp_path / "out" / "scene.gltf"
    root = json.loads(path.read_text())
    root["materials"][0]["extensions"]["KHR_materials_ior"] = {"ior": 1.5}
    path.write_text(json.dumps(root))
    again, left_out = ir.import_scene(path)
    assert any("hill: its coating" in sentence and "open" in sentence for sentence in left_out)
    ir.render(again, samples=1, size=(8, 8))


def test_nodes_that_hang_twice_are_refused_soon(tmp_path: Path) -> None:
    """A tree of 2^60 nodes in a small file."""
    nodes = [{"children": [i + 1, i + 1]} for i in range(60)] + [{}]
    (tmp_path / "x.gltf").write_text(json.dumps({"asset": {}, "scenes": [{"nodes": [0]}], "nodes": nodes}))
    with pytest.raises(ValueError, match="hangs below two others"):
        ir.import_scene(tmp_path / "x.gltf")


def test_a_part_is_named_in_the_scene_language(scene: ir.Scene, tmp_path: Path) -> None:
    ir.export(scene, "gltf", tmp_path / "out")
    tree = scene.to_dict()
    tree["object"] = tree["object"][:1]
    tree["object"][0]["shape"] = {"mesh": {"file": "out/scene.gltf", "part": "/meshes/0"}}
    (tmp_path / "part.json").write_text(json.dumps(tree))
    part = ir.Scene.load(tmp_path / "part.json")
    assert np.allclose(in_the_world(part, "hill", 1.0), in_the_world(scene, "hill", 1.0), atol=1e-5)
    tree["object"][0]["shape"]["mesh"]["part"] = "/meshes/99"
    (tmp_path / "part.json").write_text(json.dumps(tree))
    with pytest.raises(ir.SceneError, match=r"/meshes/M.*M below"):
        ir.render(ir.Scene.load(tmp_path / "part.json"), samples=1, size=(8, 8))


@pytest.mark.parametrize("to", ["mitsuba", "gltf", "usd"])
@pytest.mark.parametrize("body", ["dielectric", "metal", "coating"])
def test_a_film_on_the_face_of_a_body_goes_out_as_its_coating(to: str, body: str, tmp_path: Path) -> None:
    # One place, written in two ways.
    ball: dict[str, Any] = {"shape": {"sphere": {"radius": 1.0}}, "transform": {"translate": [1.0, 2.0, 0.0]}}
    matrix = {"matrix": [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 0]]}
    layer = {"medium": "MgF2", "thickness_nm": 120.0}
    inner = [{"medium": "TiO2", "thickness_nm": 60.0}] if body == "coating" else []
    medium = "Ag" if body == "metal" else "N-BK7"
    bare = {"coating": {"layers": inner, "substrate": medium}} if inner else {body: {"medium": medium}}
    coating = {"coating": {"layers": [layer, *inner], "substrate": medium}}
    wanted = [{**ball, "name": "ball", "surface": coating}]
    given = [
        {**ball, "name": "skin", "transform": matrix, "surface": {"film": layer}},
        {**ball, "name": "ball", "surface": bare},
    ]
    reports = []
    for name, objects in (("given", given), ("wanted", wanted)):
        scene = {"version": 1, "camera": {}, "object": objects, "light": [{"environment": {"builtin": "studio"}}]}
        reports.append(ir.export(scene, to, tmp_path / name))
    assert [path.name for path in reports[0].files] == [path.name for path in reports[1].files]
    for mine, theirs in zip(reports[0].files, reports[1].files, strict=True):
        assert mine.read_bytes() == theirs.read_bytes(), mine.name


def coated_instances(folder: Path) -> ir.Scene:
    """Instances of a sheet with a film, and of boxes of glass with a film on their very faces."""
    tree = made(folder).to_dict()
    corners = 0.3 * np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float64)
    squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    halves = np.array([half for a, b, c, d in squares for half in ((a, b, c), (a, c, d))])
    (folder / "box.ply").write_bytes(ply_bytes(Mesh(corners, None, None, halves)))
    sheet, box = ({"mesh": {"file": file}} for file in ("hill.ply", "box.ply"))
    soap, skin = ({"film": {"medium": n, "thickness_nm": nm}} for n, nm in ((1.4, 350.0), (1.38, 120.0)))
    tree["object"] = [
        {"name": "sheets", "shape": sheet, "instances": PUT, "surface": soap},
        {"name": "skins", "shape": box, "instances": PUT, "surface": skin},
        {"name": "cubes", "shape": box, "instances": PUT, "surface": {"dielectric": {"medium": 1.5}}},
    ]
    (folder / "coated.json").write_text(json.dumps(tree))
    return ir.Scene.load(folder / "coated.json")


def placed_points(scene: ir.Scene, names: list[str], metres: float) -> np.ndarray:
    """The vertices of objects, once for each instance of each."""
    numbers = {item["name"]: number for number, item in enumerate(scene.to_dict()["object"])}
    found = []
    for name in names:
        mesh, placements = scene._core.body(numbers[name])
        assert mesh is not None
        found += [metres * (mesh[0] @ placement[:, :3].T + placement[:, 3]) for placement in placements]
    return np.stack(found)


@pytest.mark.parametrize(("to", "file", "metres"), [("gltf", "scene.gltf", 0.01), ("mitsuba", "scene.xml", 1.0)])
def test_instances_of_a_coated_mesh_keep_films_places_and_names(
    to: str, file: str, metres: float, tmp_path: Path
) -> None:
    scene = coated_instances(tmp_path)
    report = ir.export(scene, to, tmp_path / "out")
    assert {"sheets", "cubes"} == set(report.films or ())
    again, _ = ir.import_scene(tmp_path / "out" / file)
    surfaces = {item["name"]: item["surface"] for item in again.to_dict()["object"]}
    mirrored = ["sheets_mirrored", "cubes_mirrored"] if to == "mitsuba" else []  # it turns no mesh inside out
    assert sorted(surfaces) == sorted(["sheets", "cubes", *mirrored])
    for name in ("sheets", "cubes"):
        own = [name, *(other for other in mirrored if other.startswith(name))]
        assert np.allclose(placed_points(again, own, 1.0), placed_points(scene, [name], metres), atol=1e-6 * metres)
        for surface in (surfaces[other] for other in own):
            ((kind, keys),) = surface.items()
            layer = keys if kind == "film" else keys["layers"][0]
            assert (layer["medium"], layer["thickness_nm"]) == {"sheets": (1.4, 350.0), "cubes": (1.38, 120.0)}[name]
            assert kind == "film" or (len(keys["layers"]) == 1 and keys["substrate"] == 1.5)


def test_a_stage_holds_instances_of_a_coated_mesh(tmp_path: Path) -> None:
    ir.export(coated_instances(tmp_path), "usd", tmp_path / "out")
    text = (tmp_path / "out" / "scene.usda").read_text()
    assert "skins" not in text, "a film on a face is a layer of the body, and no object"
    for name, um in (("sheets", 0.35), ("cubes", 0.12)):
        material = text[text.index(f'def Material "{name}"') : text.index(f'class Xform "{name}_shape_one"')]
        assert f"float inputs:thin_film_thickness = {um}\n" in material
        instances = text[text.index(f'def Xform "{name}_shape"') :].split("def Xform ")[2:5]
        for put, block in zip(PUT, instances, strict=True):
            assert f"references = </World/{name}_shape_one>" in block
            assert ", ".join(repr(float(x)) for x in put["translate"]) in block
        one = text[text.index(f'class Xform "{name}_shape_one"') : text.index(f'def Xform "{name}_shape"')]
        assert f"rel material:binding = </World/{name}>" in one
