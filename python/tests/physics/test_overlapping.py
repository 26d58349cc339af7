"""Bodies that lie over each other, of which `priority` says which one rules: closed forms for the ray along their common axis."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import iridesce as ir
from physics.scenes import build, coating, dielectric, disk, emitter, film, lit, metal, plane, sphere, view

GLASS, WATER = 1.5, 1.333
LAMP = disk([0, -3, 0], [0, 1, 0], 5.0, emitter(1.0))
POOL = plane([0, 0, 0], [0, 1, 0], dielectric(WATER))
PANE = disk([0, 0, 0], [0, 1, 0], 3.0, film("soap", 400.0))


def reflectance(a: float, b: float) -> float:
    """At normal incidence."""
    return ((a - b) / (a + b)) ** 2


def through(*indices: float) -> float:
    """What two faces between three media pass at normal incidence, all mirroring between them included."""
    first, second = reflectance(*indices[:2]), reflectance(*indices[1:])
    return (1.0 - first) * (1.0 - second) / (1.0 - first * second)


def straight_down(*objects: dict[str, Any]) -> float:
    """Y of one pixel that looks down the axis, at a lamp of radiance 1 below and nothing else."""
    camera = {
        "position": [0.0, 6.0, 0.0],
        "target": [0.0, 0.0, 0.0],
        "up": [0.0, 0.0, -1.0],
        "orthographic_height": 1e-3,
        "resolution": [1, 1],
    }
    objects = tuple(item | {"name": f"object-{i}"} for i, item in enumerate(objects))
    return float(ir.render(build(objects, camera, [lit("D65", 0.0)]), samples=16).xyz[0, 0, 1])


@pytest.mark.parametrize("priority", [1, -1])
@pytest.mark.parametrize("height", [0.0, 0.4, -0.6])
def test_a_ball_of_glass_half_in_water(priority, height):
    ball = sphere([0, height, 0], 1.0, dielectric(GLASS)) | {"priority": priority}
    # Whichever rules, light meets two faces: the ball's lower one, or the water's within the ball.
    assert straight_down(POOL, ball, LAMP) == pytest.approx(through(1.0, GLASS, WATER), rel=1e-5)
    assert straight_down(ball, POOL, LAMP) == pytest.approx(through(1.0, GLASS, WATER), rel=1e-5)


def test_a_bubble_of_air_in_the_surface_of_water():
    hole = sphere([0, 0, 0], 1.0, dielectric(1.0)) | {"priority": 1}
    # Air in air has no upper face, and the water's is not there within the hole.
    assert straight_down(POOL, hole, LAMP) == pytest.approx(1.0 - reflectance(1.0, WATER), rel=1e-5)


def test_a_film_that_pokes_out_of_glass():
    ball = sphere([0, 0, 0], 1.0, dielectric(GLASS))
    alone = through(1.0, GLASS, 1.0)
    within = straight_down(PANE, ball | {"priority": 1}, LAMP)
    assert within == pytest.approx(alone, rel=1e-5), "within the stronger body the film is not there"
    beside = sphere([2.0, 0, 0], 1.0, dielectric(GLASS)) | {"priority": 1}
    assert straight_down(PANE, beside, LAMP) == pytest.approx(straight_down(PANE, LAMP), rel=1e-5)
    assert abs(straight_down(PANE, LAMP) - alone) > 0.02


def test_equal_bodies_that_overlap_are_refused():
    ball = sphere([0, 0, 0], 1.0, dielectric(GLASS))
    with pytest.raises(ir.SceneError, match=r"\"1\.5\", in \"1\.333\""):
        straight_down(POOL, ball, LAMP)
    with pytest.raises(ir.SceneError, match=r"lies in air, in \"1\.5\""):
        straight_down(PANE, ball, LAMP)


# ---- a film on the very face of a body -------------------------------------------------------------------------------

SKIN = film(1.38, 300.0)
#: A body, and the same with the film among its layers.
BODIES = {
    "glass": (dielectric(1.5), coating([(1.38, 300.0)], 1.5)),
    "coated": (coating([(2.3, 60.0)], 1.5), coating([(1.38, 300.0), (2.3, 60.0)], 1.5)),
    "metal": (metal([0.5, 3.0]), coating([(1.38, 300.0)], [0.5, 3.0])),
}
PLACES: dict[str, Any] = {
    "ball": {"shape": {"sphere": {"radius": 1.0}}},
    "moved ball": {
        "shape": {"sphere": {"radius": 1.0}},
        "transform": {"scale": [1.0, 0.5, 0.8], "rotate_deg": [0.0, 20.0, 10.0]},
        "instances": [{"translate": [-0.5, 0.0, 0.0]}, {"translate": [0.6, 0.2, 0.0], "scale": 0.5}],
    },
    "plane": {"shape": {"plane": {}}},
    "can": {"shape": {"cylinder": {"radius": 0.8, "height": 1.0, "open": False}}},
}


def picture(*objects: dict[str, Any]) -> ir.Image:
    camera = view([0.0, 1.5, 4.0], [0.0, 0.0, 0.0], (24, 24), fov_deg=32.0)
    objects = tuple({"name": f"object-{i}"} | item for i, item in enumerate(objects))
    return ir.render(build(objects, camera, [{"environment": {"builtin": "studio"}}]), samples=4)


@pytest.mark.parametrize("priority", [0, 1, -1])
@pytest.mark.parametrize("film_first", [True, False])
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("body", BODIES)
def test_a_film_on_the_face_of_a_body_is_a_layer_of_its_coating(body, place, film_first, priority):
    bare, coated = BODIES[body]
    skin = {"name": "skin", "surface": SKIN, **PLACES[place]}
    ball = {"name": "body", "surface": bare, "priority": priority, **PLACES[place]}
    both = picture(*([skin, ball] if film_first else [ball, skin]))
    alone = picture({"name": "body", "surface": coated, **PLACES[place]})
    assert np.array_equal(both.xyz, alone.xyz)
    assert np.array_equal(both.channels["thickness_nm"], alone.channels["thickness_nm"], equal_nan=True)
    seen = both.channels["object"]
    assert set(np.unique(seen)) <= {-1, int(film_first)}, "the body is what is seen"
    assert not np.array_equal(both.xyz, picture(ball).xyz)


def test_a_film_on_a_ball_of_glass_in_closed_form():
    """Down the axis: film, glass, and the film again from within; all mirroring between the two faces included."""
    ball = sphere([0, 0, 0], 1.0, dielectric(GLASS)) | {"priority": 1}
    nm = np.arange(360.0, 831.0)
    weights = ir.color.color_matching(nm)[:, 1] * ir.color.illuminant("D65").power(nm)
    face = ir.Stack(["air", ir.Layer(1.38, thickness_nm=300.0), GLASS]).reflectance(nm)
    expected = float(((1.0 - face) / (1.0 + face)) @ weights / weights.sum())
    assert straight_down(ball, sphere([0, 0, 0], 1.0, SKIN), LAMP) == pytest.approx(expected, rel=1e-5)


def test_a_film_all_over_a_ball_half_in_water():
    """It lies between air and glass above, between water and glass below."""
    ball = sphere([0, 0, 0], 1.0, dielectric(GLASS)) | {"priority": 1}
    skin = sphere([0, 0, 0], 1.0, SKIN)
    nm = np.arange(360.0, 831.0)
    weights = ir.color.color_matching(nm)[:, 1] * ir.color.illuminant("D65").power(nm)
    layer = ir.Layer(1.38, thickness_nm=300.0)
    a, b = (ir.Stack([outer, layer, GLASS]).reflectance(nm) for outer in ("air", WATER))
    expected = float(((1.0 - a) * (1.0 - b) / (1.0 - a * b)) @ weights / weights.sum())
    assert straight_down(POOL, ball, skin, LAMP) == pytest.approx(expected, rel=1e-5)


def test_a_film_on_a_face_takes_its_thickness_from_its_own_keys(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.save("wedge.npy", np.linspace(0.0, 600.0, 64 * 32).reshape(32, 64).astype(np.float32))
    for thickness in (
        {"map": "wedge.npy"},
        {"gradient": {"top": 100.0, "bottom": 500.0}},
        {"swirls": {"min_nm": 0.0, "max_nm": 700.0}},
    ):
        skin = sphere([0, 0, 0], 1.0, film(1.38, thickness))
        both = picture(skin, sphere([0, 0, 0], 1.0, dielectric(1.5)))
        assert np.array_equal(both.xyz, picture(sphere([0, 0, 0], 1.0, coating([(1.38, thickness)], 1.5))).xyz)


def test_what_a_film_on_a_face_cannot_have_of_its_own_is_said():
    ball = sphere([0, 0, 0], 1.0, dielectric(GLASS)) | {"name": "ball"}
    skin = sphere([0, 0, 0], 1.0, SKIN) | {"name": "skin"}

    def refused(*objects: dict[str, Any]) -> str:
        with pytest.raises(ir.SceneError) as caught:
            ir.Scene.load(build(list(objects), view([0, 0, 5], [0, 0, 0])))
        return str(caught.value)

    rough = sphere([0, 0, 0], 1.0, {"film": {**SKIN["film"], "roughness": 0.3}}) | {"name": "skin"}
    wanted = (
        'object.skin.surface.film.roughness must be left out or be that of object "ball", on whose face the film lies'
    )
    assert wanted in refused(ball, rough)
    turned = skin | {"uv": {"scale": [2.0, 1.0]}}
    assert 'object.skin.uv must be that of object "ball", on whose face the film lies' in refused(ball, turned)
    second = skin | {"name": "other"}
    wanted = 'object.other lies on the face of object "ball", where the film of object "skin" lies already; write them'
    assert wanted in refused(skin, second, ball)
    matched = {"dielectric": {**dielectric(GLASS)["dielectric"], "roughness": 0.3}}
    ir.Scene.load(build([sphere([0, 0, 0], 1.0, matched) | {"name": "ball"}, rough], view([0, 0, 5], [0, 0, 0])))


def test_what_a_film_within_a_body_is_told_to_do():
    """A film just below the face is no film on it, and without a higher priority it lies in the wrong medium."""
    ball = sphere([0, 0, 0], 1.0, dielectric(GLASS))
    with pytest.raises(ir.SceneError, match=r"of bodies that overlap give one the higher priority"):
        straight_down(ball, sphere([0, 0, 0], 0.9, SKIN), LAMP)
