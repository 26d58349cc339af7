"""Shapes of every kind against each other and against closed forms: meshes, transforms, instances, cylinders, bubbles.

- a mesh of a sphere is drawn as the sphere, a moved object as one that was written there, instances as copies
- the walls of bubbles in balance meet at 120 degrees, and bulge as the pressures say
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import iridesce as ir

SOAP = {"film": {"medium": "soap", "thickness_nm": 420.0}}


def scene(*objects: dict, light: dict | None = None, **camera: object) -> dict:
    """A small scene; the camera stands on +z."""
    return {
        "version": 1,
        "camera": {"position": [0.0, 0.0, 16.0], "resolution": [48, 48], **camera},
        "render": {"samples": 4, "max_depth": 6},
        "object": [{"name": f"o{i}", **made} for i, made in enumerate(objects)],
        "light": [{"environment": light or {"builtin": "studio"}}],
    }


def ball(
    radius: float = 4.0, center: tuple[float, float, float] = (0.0, 0.0, 0.0), surface: dict | None = None
) -> dict:
    return {"shape": {"sphere": {"center": list(center), "radius": radius}}, "surface": surface or SOAP}


def icosphere(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices on the unit sphere, and counter-clockwise faces."""
    g = (1 + 5**0.5) / 2
    points = [(a, b * g, 0.0) for a in (-1, 1) for b in (-1, 1)]
    points = np.array([np.roll(p, k) for k in range(3) for p in points], float)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    near = np.linalg.norm(points[:, None] - points[None], axis=2) < 1.1
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    faces = [(i, j, k) if np.linalg.det(points[[i, j, k]]) > 0 else (i, k, j) for i, j, k in faces]
    for _ in range(levels):
        made: dict[tuple[int, int], int] = {}
        all_points = list(points)

        def middle(a: int, b: int, made=made, all_points=all_points) -> int:
            key = (min(a, b), max(a, b))
            if key not in made:
                point = all_points[a] + all_points[b]
                made[key] = len(all_points)
                all_points.append(point / np.linalg.norm(point))
            return made[key]

        faces = [
            face
            for a, b, c in faces
            for ab, bc, ca in [(middle(a, b), middle(b, c), middle(c, a))]
            for face in [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        ]
        points = np.array(all_points)
    return points, np.array(faces)


def write_ply(path: Path, points: np.ndarray, faces: np.ndarray, **more: np.ndarray) -> str:
    """Vertices with further properties, doubles all."""
    names = ["x", "y", "z", *more]
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    head += [f"property double {name}" for name in names]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    rows = np.column_stack([points, *more.values()])
    lines = [" ".join(repr(float(v)) for v in row) for row in rows]
    lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(head + lines) + "\n")
    return path.name


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def smooth_ball(here: Path, levels: int = 5) -> dict:
    """A mesh of the unit sphere with normals, scaled to radius 4."""
    points, faces = icosphere(levels)
    normals = dict(zip(("nx", "ny", "nz"), points.T, strict=True))
    file = write_ply(here / "ball.ply", points, faces, **normals)
    return {"shape": {"mesh": {"file": file}}, "transform": {"scale": 4.0}, "surface": SOAP}


def test_a_mesh_of_a_sphere_is_drawn_as_the_sphere(here: Path) -> None:
    # Chords of 20480 triangles sink by 1.1e-3 of the radius; the mean over the disk forgives what the rim shows.
    whole = ir.render(scene(ball()), seed=2).xyz
    mesh = ir.render(scene(smooth_ball(here)), seed=2).xyz
    difference = np.abs(mesh - whole)[..., 1]
    assert np.median(difference) < 2e-3 and abs((mesh - whole)[..., 1].mean()) < 2e-3 * whole[..., 1].mean()


def test_glass_of_a_closed_mesh_and_the_open_edge(here: Path) -> None:
    glass = {"dielectric": {"medium": "N-BK7"}}
    made = {**smooth_ball(here, 4), "surface": glass}
    light = {"illuminant": "D65"}
    image = ir.render(scene(made, light=light)).xyz[..., 1]
    # In an even light clear glass is not seen, but for what shading normals lose at the rim.
    assert abs(np.median(image) - 1.0) < 1e-4 and image.mean() > 0.985
    points, faces = icosphere(1)
    write_ply(here / "open.ply", points, faces[:-1])
    with pytest.raises(ir.SceneError, match=r"must be closed, since a medium fills it: the edge from \["):
        ir.render(scene({"shape": {"mesh": {"file": "open.ply"}}, "surface": glass}))


def test_what_is_moved_is_what_was_written_there(here: Path) -> None:
    moved = {"scale": 0.5, "rotate_deg": [90.0, 0.0, 0.0], "translate": [1.0, 0.0, 0.0]}
    pairs = [
        (ball(4.0), ball(2.0, (1.0, 0.0, 0.0))),
        (
            {"shape": {"disk": {"normal": [0.0, 1.0, 0.0]}}, "surface": SOAP},
            {"shape": {"disk": {"center": [1.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0], "radius": 2.0}}, "surface": SOAP},
        ),
        (
            {"shape": {"rectangle": {"u": [4.0, 0.0, 0.0], "v": [0.0, 0.0, -4.0]}}, "surface": SOAP},
            {
                "shape": {"rectangle": {"center": [1.0, 0.0, 0.0], "u": [2.0, 0.0, 0.0], "v": [0.0, 2.0, 0.0]}},
                "surface": SOAP,
            },
        ),
    ]
    for written, there in pairs:
        a, b = ir.render(scene({**written, "transform": moved})), ir.render(scene(there))
        assert np.array_equal(a.xyz, b.xyz)
    # A sphere that is stretched is an ellipsoid: x^2/16 + y^2/4 + z^2 = 1.
    stretched = {**ball(1.0), "transform": {"scale": [4.0, 2.0, 1.0]}}
    depth = ir.render(scene(stretched, orthographic_height=12.0)).channels["depth"]
    x = (np.arange(48) + 0.5) / 48 * 12 - 6
    y = -x[:, None]
    inside = 1 - x**2 / 16 - y**2 / 4
    assert np.array_equal(np.isfinite(depth), inside > 0)
    met = inside > 0
    assert np.allclose(depth[met], 16 - np.sqrt(inside[met]), atol=2e-6)


def test_instances_are_copies(here: Path) -> None:
    places = [[-3.0, 1.0, 0.0], [2.0, -1.0, 1.0], [0.5, 3.0, -2.0]]
    gradient = {"film": {"medium": "soap", "thickness_nm": {"gradient": {"top": 100.0, "bottom": 600.0}}}}
    once = ball(1.5, surface=gradient)
    copies = [ball(1.5, tuple(place), gradient) for place in places]
    listed = {**once, "instances": [{"translate": place} for place in places]}
    wanted = ir.render(scene(*copies)).xyz
    assert np.array_equal(ir.render(scene(listed)).xyz, wanted)
    rows = np.zeros((3, 3, 4))
    rows[:, :, :3] = np.eye(3)
    rows[:, :, 3] = places
    np.save(here / "places.npy", rows)
    assert np.array_equal(ir.render(scene({**once, "instances": {"file": "places.npy"}})).xyz, wanted)
    np.save(here / "flat.npy", rows * np.array([1.0, 0.0, 1.0, 1.0]))
    with pytest.raises(ir.SceneError, match="must have an inverse"):
        ir.render(scene({**once, "instances": {"file": "flat.npy"}}))


def test_a_cylinder_by_its_closed_form() -> None:
    # An axis askew: points satisfy |p - (p . a) a| = r, and lie within the ends.
    axis = np.array([1.0, 2.0, 0.5]) / np.linalg.norm([1.0, 2.0, 0.5])
    for is_open in (True, False):
        shape = {"cylinder": {"axis": axis.tolist(), "radius": 2.0, "height": 5.0, "open": is_open}}
        image = ir.render(scene({"shape": shape, "surface": SOAP}, orthographic_height=10.0), samples=1)
        depth = image.channels["depth"].astype(float)
        x = (np.arange(48) + 0.5) / 48 * 10 - 5
        points = np.stack([np.broadcast_to(x, (48, 48)), np.broadcast_to(-x[:, None], (48, 48)), 16 - depth], -1)
        met = np.isfinite(depth)
        along = points[met] @ axis
        radial = np.linalg.norm(points[met] - along[:, None] * axis, axis=1)
        on_side = np.abs(radial - 2.0) < 3e-6
        on_end = np.abs(np.abs(along) - 2.5) < 3e-6
        assert met.sum() > 300 and np.all(np.abs(along) < 2.5 + 3e-6)
        assert np.all(on_side) if is_open else np.all(on_side | on_end) and on_end.sum() > 20


def test_vertices_say_how_thick_a_film_is(here: Path) -> None:
    points = np.array([[-4.0, -4.0, 0.0], [4.0, -4.0, 0.0], [4.0, 4.0, 0.0], [-4.0, 4.0, 0.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    file = write_ply(here / "sheet.ply", points, faces, thickness_nm=np.array([100.0, 500.0, 500.0, 100.0]))
    sheet = {"shape": {"mesh": {"file": file}}, "surface": {"film": {"thickness_nm": "vertex"}}}
    image = ir.render(scene(sheet, orthographic_height=8.0), samples=1)
    x = (np.arange(48) + 0.5) / 48
    assert np.allclose(image.channels["thickness_nm"], 100 + 400 * x, atol=1e-3)
    write_ply(here / "bare.ply", points, faces)
    bare = {"shape": {"mesh": {"file": "bare.ply"}}, "surface": {"film": {"thickness_nm": "vertex"}}}
    with pytest.raises(ir.SceneError, match="no vertex property thickness_nm"):
        ir.render(scene(bare))


def test_a_mesh_that_shines_is_found_by_its_area(here: Path) -> None:
    """A square lamp as two triangles lights a floor as the rectangle does; both techniques agree."""
    points = np.array([[-2.0, 3.0, -2.0], [2.0, 3.0, -2.0], [2.0, 3.0, 2.0], [-2.0, 3.0, 2.0]])
    file = write_ply(here / "lamp.ply", points, np.array([[0, 1, 2], [0, 2, 3]]))
    floor = {"shape": {"plane": {"point": [0.0, -2.0, 0.0]}}, "surface": {"diffuse": {"reflectance": 0.8}}}
    glow = {"emitter": {"radiance": 3.0}}
    lamps = [
        {"shape": {"mesh": {"file": file}}, "surface": glow},
        {
            "shape": {"rectangle": {"center": [0.0, 3.0, 0.0], "u": [2.0, 0.0, 0.0], "v": [0.0, 0.0, 2.0]}},
            "surface": glow,
        },
    ]
    dark = {"illuminant": "D65", "radiance": 0.0}
    mesh, rectangle = (ir.render(scene(floor, lamp, light=dark), samples=64).xyz[..., 1] for lamp in lamps)
    assert rectangle[30:].mean() > 0.05
    assert abs(mesh[30:].mean() / rectangle[30:].mean() - 1) < 0.02


def test_walls_of_bubbles_in_balance() -> None:
    """Two spheres and the wall between them: the three normals on the common circle are 120 degrees apart."""
    a, b = 3.0, 2.0
    d = np.sqrt(a * a + b * b - a * b)
    surface = {"film": {"thickness_nm": 300.0, "inner_thickness_nm": 600.0}}
    shape = {"bubbles": {"spheres": [{"center": [0.0, 0.0, 0.0], "radius": a}, {"center": [d, 0.0, 0.0], "radius": b}]}}
    image = ir.render(
        scene(
            {"shape": shape, "surface": surface},
            position=[1.0, 0.0, 16.0],
            target=[1.0, 0.0, 0.0],
            orthographic_height=9.0,
        ),
        samples=1,
    )
    assert set(np.unique(image.channels["thickness_nm"][np.isfinite(image.channels["thickness_nm"])])) == {300.0}
    # From within the larger bubble the smaller one is seen behind its wall, which bulges to here: its middle lies nearer
    # than the common circle, by what curvature 1/2 - 1/3 sinks.
    inside = scene({"shape": shape, "surface": surface}, position=[0.0, 0.0, 0.0], target=[1.0, 0.0, 0.0], fov_deg=30.0)
    image = ir.render(inside, samples=1)
    along = (d * d + a * a - b * b) / (2 * d)
    circle = np.sqrt(a * a - along * along)
    radius = a * b / (a - b)
    sag = radius - np.sqrt(radius**2 - circle**2)
    middle = image.channels["depth"][24, 24]
    assert image.channels["thickness_nm"][24, 24] == 600.0
    assert abs(middle - (along - sag)) < 2e-3
    normal_wall = np.array([along - (along - sag + radius), circle]) / radius
    normals = [np.array([along, circle]) / a, np.array([along - d, circle]) / b, normal_wall]
    angle = [np.degrees(np.arccos(abs(p @ q))) for p, q in [(normals[0], normals[1]), (normals[0], normals[2])]]
    assert np.allclose(angle, 60.0, atol=1e-9)
    with pytest.raises(ir.SceneError, match="must be a film"):
        ir.Scene.load(scene({"shape": shape, "surface": {"metal": {}}}))
    swallowed = {"bubbles": {"spheres": [{"radius": 3.0}, {"center": [2.0, 0.0, 0.0], "radius": 1.0}]}}
    with pytest.raises(ir.SceneError, match="wholly swallowed by bubble 0"):
        ir.Scene.load(scene({"shape": swallowed, "surface": SOAP}))


def test_any_number_of_objects() -> None:
    # Once there was a limit of 10 000.
    columns = 101
    grain = [
        {
            "shape": {"sphere": {"center": [i % columns - 50.0, i // columns - 50.0, 0.0], "radius": 0.2}},
            "surface": SOAP,
        }
        for i in range(columns * columns)
    ]
    image = ir.render(scene(*grain, position=[0.0, 0.0, 5.0], orthographic_height=3.0, resolution=[9, 9]), samples=1)
    # Nine of them are seen, of which the middle pixels of nine blocks are.
    assert (image.channels["thickness_nm"][1::3, 1::3] == 420.0).all()


def test_what_files_and_keys_get_wrong_is_named(here: Path) -> None:
    (here / "huge.ply").write_text(
        "ply\nformat ascii 1.0\nelement face 1000000000\nproperty list uchar int vertex_indices\nend_header\n"
    )
    (here / "no.obj").write_text("v 0 0 0\n")
    (here / "far.gltf").write_text('{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"../secret.bin"}]}')
    (here / "a.stl").write_text("solid")
    for file, words in [
        ("huge.ply", "declares 1000000000"),
        ("no.obj", "no faces"),
        ("far.gltf", "outside the scene's folder"),
        ("a.stl", r"a mesh is a file \.obj, \.ply"),
        ("missing.ply", 'cannot open "missing.ply"'),
    ]:
        with pytest.raises(ir.SceneError, match=words):
            ir.render(scene({"shape": {"mesh": {"file": file}}, "surface": SOAP}))
    for more, words in [
        ({"transform": {"matrix": [[1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 1, 0]]}}, "inverse"),
        ({"transform": {"scale": 0.0}}, "a factor other than 0"),
        ({"instances": []}, "at least one"),
        ({"uv": {"scale": [1.0]}}, "two numbers"),
        ({"priority": 1.5}, "a whole number from -1000 to 1000"),
    ]:
        with pytest.raises(ir.SceneError, match=words):
            ir.Scene.load(scene({**ball(), **more}))
