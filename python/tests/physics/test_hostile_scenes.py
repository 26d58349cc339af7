"""Determinism with everything in one scene; cameras, sizes and touching shapes that invite NaN; scenes that cannot be."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from physics.scenes import (
    WHITE,
    build,
    cap,
    coating,
    dielectric,
    diffuse,
    disk,
    emitter,
    film,
    lit,
    metal,
    plane,
    rectangle,
    sphere,
    view,
)

pytestmark = pytest.mark.filterwarnings("ignore:the data of medium")
SKY = {"environment": {"builtin": "sky"}}


def everything(size=1.0):
    """Every shape and every surface, films and coatings of several thicknesses, seen through a lens; metres."""
    s = size
    sag = (0.8 - np.sqrt(0.8**2 - 0.3**2)) * s  # the faces of the lens meet at their rim
    gap = {"lens_gap": {"radius_mm": 5e7 * s, "contact_gap_nm": 10.0}}
    wedge = {"wedge": {"from": [-2 * s, 0, 0], "to": [2 * s, 0, 0], "start_nm": 0.0, "end_nm": 900.0}}
    return [
        plane([0, -s, 0], [0, 1, 0], diffuse([0.6, 0.5, 0.4])),
        sphere([-1.1 * s, 0, 0], 0.5 * s, film("soap", {"gradient": {"top": 0.0, "bottom": 900.0}})),
        sphere([0, 0, 0], 0.5 * s, dielectric("N-SF11")),
        sphere([0, 0, 0], 0.3 * s, dielectric("air")),
        sphere([0, 0, 0], 0.1 * s, diffuse(0.7)),
        sphere([1.1 * s, 0, 0], 0.5 * s, coating([("TiO2", wedge)], "Ti")),
        disk([0, 0, -2 * s], [0, 0.2, 1], s, coating([("SiO2", 320.0)], "Si")),
        rectangle([-1.5 * s, 1 * s, -s], [0.5 * s, 0, 0], [0, 0, 0.5 * s], metal("Au")),
        sphere([0.5 * s, 1.5 * s, 0.5 * s], 0.2 * s, emitter(5.0, "A")),
        rectangle([0, 2 * s, 0], [0.3 * s, 0, 0], [0, 0, 0.3 * s], emitter(2.0, "lines:546.07,589.3")),
        cap([0.6 * s, 0, s + sag], [0, 0, 1], 0.8 * s, 0.3 * s, dielectric("N-BK7")),
        cap([0.6 * s, 0, s - sag], [0, 0, -1], 0.8 * s, 0.3 * s, dielectric("N-BK7")),
        disk([-0.5 * s, -0.5 * s, s], [0, 1, 0.5], 0.3 * s, coating([("SiO2", gap), ("air", 100.0)], "Si")),
    ]


def eye(size=1.0, resolution=(24, 20)):
    lens = {"aperture_radius": 0.03 * size, "focus_distance": 4.0 * size}
    return view([0.4 * size, 0.5 * size, 4.0 * size], [0, 0, 0], resolution, fov_deg=50.0, **lens)


def test_threads_change_nothing():
    loaded = ir.Scene.load(build(everything(), eye(), [SKY, lit("FL2", 0.2)], samples=4, unit="m"))
    one = ir.render(loaded, seed=3, threads=1).xyz
    assert np.isfinite(one).all()
    for threads in (2, 3):
        assert ir.render(loaded, seed=3, threads=threads).xyz.tobytes() == one.tobytes()
    assert ir.render(loaded, seed=4, threads=1).xyz.tobytes() != one.tobytes()


def test_seeds_differ_within_their_noise():
    """Halves of many seeds have the same mean: |z| over blocks of pixels stays where chance leaves it."""
    loaded = ir.Scene.load(build(everything(), eye(resolution=(16, 12)), [SKY], samples=16, unit="m"))
    images = np.stack([ir.render(loaded, seed=s).xyz[..., 1] for s in range(32)]).astype(np.float64)
    blocks = images.reshape(32, 3, 4, 4, 4).mean(axis=(2, 4))
    one, two = blocks[:16], blocks[16:]
    spread = np.sqrt(one.var(axis=0, ddof=1) / 16 + two.var(axis=0, ddof=1) / 16)
    z = (one.mean(axis=0) - two.mean(axis=0)) / (spread + 1e-9)
    assert np.abs(z).max() < 4.5
    assert 0.3 < np.mean(z**2) < 2.5


@pytest.mark.parametrize("max_depth", [1, 3])
def test_depth_changes_noise_only(max_depth):
    loaded = {
        depth: ir.Scene.load(
            build(everything(), eye(resolution=(8, 6)), [lit("D65")], samples=64, unit="m", max_depth=depth)
        )
        for depth in (max_depth, 32)
    }
    means = {
        depth: np.array([ir.render(scene, seed=s).xyz[..., 1].mean(dtype=np.float64) for s in range(24)])
        for depth, scene in loaded.items()
    }
    spread = np.sqrt(sum(m.var(ddof=1) / 24 for m in means.values()))
    assert spread < 5e-3
    assert abs(means[max_depth].mean() - means[32].mean()) < 4.0 * spread


@pytest.mark.parametrize("size", [1e-6, 1e-3, 1e3])
def test_sizes_from_a_micrometre_to_a_kilometre(size):
    """Nothing absorbs here and films keep their thickness, so the picture of a scene does not hang on its size."""
    clear = [thing for thing in everything(size) if "lens_gap" not in str(thing) and "N-" not in str(thing["surface"])]
    same = [thing for thing in everything() if "lens_gap" not in str(thing) and "N-" not in str(thing["surface"])]
    got = ir.render(build(clear, eye(size), [SKY], samples=4, unit="m")).xyz
    wanted = ir.render(build(same, eye(), [SKY], samples=4, unit="m")).xyz
    assert np.isfinite(got).all()
    # rounding may send single rays past an edge
    off = np.abs(got - wanted).max(axis=-1) > 1e-3 * wanted.max(axis=-1)
    assert off.mean() < 0.03


BALL = sphere([0, 0, 0], 1.0, dielectric(1.5))
FLOOR = plane([0, 0, 0], [0, 1, 0], diffuse(1.0))
PLACES = {
    "in the middle of glass": ([BALL], view([0, 0, 0], [1, 0, 0], (6, 6), fov_deg=90.0)),
    "just inside": ([BALL], view([0, 0, 1 - 1e-12], [1, 0, 1 - 1e-12], (6, 6), fov_deg=90.0)),
    "just outside": ([BALL], view([0, 0, 1 + 1e-12], [0, 0, 0], (6, 6), fov_deg=90.0)),
    "on a floor, looking along it": ([FLOOR], view([0, 0, 0], [1, 0, 0], (6, 6), fov_deg=60.0)),
    "on a floor, looking up": ([FLOOR], view([0, 0, 0], [0, 1, 0], (6, 6), fov_deg=60.0, up=[0, 0, 1])),
    "straight along a plane": ([FLOOR], view([0, 0, 0], [1, 0, 0], (3, 3), orthographic_height=1.0)),
    "grazing glass": (
        [plane([0, 0, 0], [0, 1, 0], dielectric(1.5))],
        view([0, 1e-9, 0], [1, 0, 0], (8, 8), fov_deg=1e-6),
    ),
    "grazing metal": (
        [plane([0, 0, 0], [0, 1, 0], coating([("TiO2", 50.0)], "Ti"))],
        view([0, 1e-9, 0], [1, 0, 0], (8, 8), fov_deg=1e-6),
    ),
    "inside a lamp": ([sphere([0, 0, 0], 1, emitter(1.0))], view([0, 0, 0], [1, 0, 0], (4, 4), fov_deg=90.0)),
    "on a lamp": ([sphere([0, 0, 0], 1, emitter(1.0)), FLOOR], view([0, 1, 0], [0, 2, 0.1], (4, 4), fov_deg=90.0)),
    "a matt floor that touches a lamp": (
        [FLOOR, sphere([0, 1, 0], 1, emitter(1.0))],
        view([0, 2, 4], [0, 0, 0], (9, 9), fov_deg=10.0),
    ),
    "a lamp in the floor": (
        [FLOOR, sphere([0, 0, 0], 1, emitter(1.0)), disk([2, 0, 0], [0, 1, 0], 0.5, emitter(1.0))],
        view([0, 2, 4], [0, 0, 0], (9, 9), fov_deg=50.0),
    ),
    "glass on a floor": (
        [FLOOR, sphere([0, 1, 0], 1, dielectric(1.5))],
        view([0, 2, 4], [0, 0.1, 0], (9, 9), fov_deg=20.0),
    ),
    "a film on a floor": (
        [FLOOR, sphere([0, 1, 0], 1, film("soap", 300.0)), disk([2, 0, 0], [0, 1, 0], 1.0, film("soap", 300.0))],
        view([0, 2, 4], [0, 0.1, 0], (9, 9), fov_deg=50.0),
    ),
    "two balls that touch": (
        [BALL, sphere([0, 2, 0], 1, dielectric(1.8))],
        view([0, 1, 4], [0, 1, 0], (9, 9), fov_deg=10.0),
    ),
    "a hair of a ball": ([sphere([0, 0, 0], 1e-7, dielectric(1.5))], view([0, 0, 4], [0, 0, 0], (3, 3), fov_deg=1e-6)),
    "a ball a million times the view": (
        [sphere([0, -1e6, 0], 1e6, dielectric(1.5))],
        view([0, 1, 4], [0, 0, 0], (6, 6), fov_deg=30.0),
    ),
}


@pytest.mark.parametrize("name", PLACES)
def test_awkward_places(name):
    """Finite everywhere and, as nothing but bare metal takes light away, as white as the surroundings on average."""
    objects, camera = PLACES[name]
    xyz = ir.render(build(objects, camera, [WHITE], samples=16)).xyz
    assert np.isfinite(xyz).all() and (xyz >= 0.0).all()
    assert abs(float(xyz[..., 1].mean(dtype=np.float64)) - 1.0) < 0.05, xyz[..., 1]


# ---- scenes that cannot be ----------------------------------------------------------------------------------------------


def refused(objects, camera, match):
    with pytest.raises(ir.SceneError, match=match) as caught:
        ir.render(build(objects, camera, [WHITE], samples=1))
    return caught.value


OUT = view([0, 0.3, 4], [0, 0, 0], (6, 6), fov_deg=30.0)


def test_films_must_lie_in_their_medium():
    error = refused([sphere([0, 0, 0], 1, film("soap", 300.0, outside="water"))], OUT, "water")
    assert error.key == "object.object-0.surface.film.outside"
    inside = [sphere([0, 0, 0], 1, dielectric("water")), sphere([0, 0, 0], 0.5, film("soap", 300.0))]
    assert refused(inside, OUT, "air").key == "object.object-1.surface.film.outside"
    # also when only the question for lights comes to it
    pane = disk([0, 2, 0], [0, 1, 0], 0.5, film("soap", 300.0, outside="water"))
    floor = plane([0, 0, 0], [0, 1, 0], diffuse(0.5))
    lamp = sphere([0, 4, 0], 0.3, emitter(1.0))
    refused([pane, floor, lamp], view([0.6, 0.5, 0], [0, 0, 0], (2, 2), fov_deg=5.0), "water")


def test_bodies_must_be_closed():
    lone = rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0], dielectric(1.5))
    error = refused([lone], view([0, 0, -4], [0, 0, 0], (6, 6), fov_deg=20.0), "close the body")
    assert error.key.startswith("object.object-0")
    assert "object-0" in str(error) and "1.5" in str(error)


def test_nesting_has_an_end():
    shells = [sphere([0, 0, 0], 1.0 - 0.05 * i, dielectric(1.3 + 0.02 * i)) for i in range(12)]
    error = refused(shells, OUT, "7")
    assert error.key.startswith("object.")


def test_a_path_that_carries_nothing_ends():
    """A rough ball of glass in glass mirrors nothing: beyond `max_depth` what it mirrored went on among both for ever."""
    glass = {"dielectric": {"medium": 1.5, "roughness": 0.5}}
    tree = {
        "version": 1,
        "camera": {"position": [0.0, 0.5, 6.0], "fov_deg": 30.0, "resolution": [16, 16]},
        "render": {"max_depth": 1, "samples": 4},
        "object": [
            {"name": "outer", "shape": {"sphere": {"radius": 1.0}}, "surface": glass},
            {"name": "inner", "shape": {"sphere": {"center": [0.2, 0.1, 0.3], "radius": 0.5}}, "surface": glass},
        ],
        "light": [
            {"spot": {"position": [1.0, 2.0, 2.0], "target": [0.0, 0.0, 0.0], "cone_deg": 40.0, "intensity": 3.0}}
        ],
    }
    assert np.isfinite(ir.render(tree).xyz).all()


@pytest.mark.parametrize("roughness", [0.0, 0.3])
def test_two_films_in_one_place_are_told(roughness):
    """A straight way to a light went to and fro between them for ever."""
    film = {"film": {"medium": 1.33, "thickness_nm": 300.0, "roughness": roughness}}
    tree = {
        "version": 1,
        "camera": {"position": [0.0, 0.5, 6.0], "fov_deg": 30.0, "resolution": [8, 8]},
        "render": {"max_depth": 1, "samples": 1},
        "object": [{"shape": {"sphere": {"radius": 1.0}}, "surface": film} for _ in range(2)],
        "light": [{"environment": {"builtin": "studio"}}],
    }
    with pytest.warns(UserWarning, match="lie in one place"):
        told = drawn(tree)
    assert roughness == 0.0 or "another film lies in the same place" in told


def drawn(tree):
    """What an error of a render says, or nothing."""
    try:
        ir.render(tree)
    except ir.SceneError as error:
        return str(error)
    return ""
