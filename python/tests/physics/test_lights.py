"""Lights without size, suns, many lights at once: irradiance in closed form.

A matt surface of reflectance rho under the irradiance E has the radiance rho E / pi, the same in every direction.
"""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from physics.scenes import (
    DARK,
    WHITE,
    build,
    coating,
    dielectric,
    diffuse,
    disk,
    emitter,
    film,
    lit,
    metal,
    plane,
    sphere,
    view,
)

FLOOR = plane([0, 0, 0], [0, 1, 0], diffuse(1.0))
BLACK = diffuse(0.0)


def directional(direction, irradiance=1.0, **more):
    return {"directional": {"direction": list(direction), "irradiance": irradiance, **more}}


def sun(direction, irradiance=1.0, **more):
    return {"sun": {"direction": list(direction), "irradiance": irradiance, **more}}


def point(position, intensity=1.0, **more):
    return {"point": {"position": list(position), "intensity": intensity, **more}}


def spot(position, intensity=1.0, **more):
    return {"spot": {"position": list(position), "intensity": intensity, **more}}


def look_at(x=0.0, z=0.0, **more):
    """A tiny parallel view of the floor, from low enough to pass beneath the lamps."""
    return view([x + 0.3, 0.2, z], [x, 0, z], **{"orthographic_height": 1e-6, **more})


def shown(objects, lights, camera=None, **settings):
    """XYZ of a picture of one pixel."""
    scene = build(objects, camera or look_at(), lights, **{"samples": 16, **settings})
    return ir.render(scene).xyz[0, 0].astype(np.float64)


# ---- irradiance ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle_deg", [0.0, 60.0, 85.0])
def test_directional_light_falls_by_the_cosine(angle_deg):
    a = np.radians(angle_deg)
    found = shown([FLOOR], [directional([3.0 * np.sin(a), 3.0 * np.cos(a), 0.0], 2.0)])[1]
    assert found == pytest.approx(2.0 * np.cos(a) / np.pi, rel=2e-6)


def test_light_from_below_the_floor_does_not_reach_it():
    assert shown([FLOOR], [directional([0.1, -1.0, 0.0]), point([0, -1, 0]), DARK])[1] == 0.0


@pytest.mark.parametrize("x", [0.0, 0.5, 2.0])
def test_a_point_falls_by_the_square_of_its_distance(x):
    found = shown([FLOOR], [point([0, 1, 0], 3.0)], look_at(x))[1]
    assert found == pytest.approx(3.0 / (np.pi * (1.0 + x * x) ** 1.5), rel=2e-6)


def test_things_hide_a_point_only_if_they_stand_before_it():
    lamp = point([0, 1, 0])
    assert shown([FLOOR, disk([0, 0.5, 0], [0, 1, 0], 0.1, BLACK)], [lamp])[1] == 0.0
    assert shown([FLOOR, disk([0, 1.5, 0], [0, 1, 0], 0.1, BLACK)], [lamp])[1] == pytest.approx(1.0 / np.pi, rel=2e-6)


def test_a_spot_is_full_in_its_cone_and_gone_beyond_its_edge():
    """From 2 above the floor: cos / r^2, times 1 up to 30 degrees, 1/2 in the middle of the edge, 0 from 40 on."""
    lamp = spot([0, 2, 0], 5.0, cone_deg=60.0, soft_deg=10.0)
    for angle_deg, share in ((0.0, 1.0), (29.9, 1.0), (35.0, 0.5), (40.1, 0.0)):
        a = np.radians(angle_deg)
        wanted = share * 5.0 * np.cos(a) * (np.cos(a) / 2.0) ** 2 / np.pi
        assert shown([FLOOR], [lamp], look_at(2.0 * np.tan(a)))[1] == pytest.approx(wanted, rel=1e-4, abs=1e-12)


@pytest.mark.parametrize(("diameter_deg", "worst"), [(0.53, 1e-4), (20.0, 2e-3), (120.0, 1e-2)])
def test_a_sun_has_the_irradiance_that_it_states(diameter_deg, worst):
    """Overhead E; aslant E cos, as long as the whole disc is above the floor."""
    lamp = {"irradiance": 2.0, "angular_diameter_deg": diameter_deg}
    for angle_deg in (0.0, 25.0):
        a = np.radians(angle_deg)
        found = shown([FLOOR], [sun([np.sin(a), np.cos(a), 0.0], **lamp)], samples=4096)[1]
        assert found == pytest.approx(2.0 * np.cos(a) / np.pi, rel=worst)


def test_a_sun_is_seen_as_a_disc_of_its_radiance():
    nothing = sphere([0, -1e6, 0], 1.0, BLACK)
    lamp = sun([0, 0, -2], 3.0, angular_diameter_deg=2.0)
    inside = shown([nothing], [lamp], view([0, 0, 0], [0, 0, -1], fov_deg=1.0))[1]
    assert inside == pytest.approx(3.0 / (np.pi * np.sin(np.radians(1.0)) ** 2), rel=1e-5)
    beside = view([0, 0, 0], [0, np.sin(np.radians(1.8)), -np.cos(np.radians(1.8))], fov_deg=1.0)
    assert shown([nothing], [lamp], beside)[1] == 0.0


def test_suns_that_overlap_add():
    """Two discs around one direction, one of them polarised, seen straight and in a mirror."""
    lights = [
        sun([0, 0, -1], 1.0, angular_diameter_deg=2.0),
        sun([0, 0, -1], 2.0, angular_diameter_deg=4.0),
        lit("D65", 5.0),
    ]
    lights[0]["sun"]["polarized_deg"] = 20.0
    wanted = 1.0 / (np.pi * np.sin(np.radians(1.0)) ** 2) + 2.0 / (np.pi * np.sin(np.radians(2.0)) ** 2) + 5.0
    nothing = sphere([0, -1e6, 0], 1.0, BLACK)
    assert shown([nothing], lights, view([0, 0, 0], [0, 0, -1], fov_deg=1.0))[1] == pytest.approx(wanted, rel=1e-5)
    mirror = disk([0, 0, 1], [0, 0, -1], 0.5, {"metal": {"medium": "Ag"}})
    reflectance = ir.Stack(["air", "Ag"]).color()[1]
    seen = shown([mirror], lights, view([0, 0, 0], [0, 0, 1], fov_deg=0.2))[1]
    assert seen == pytest.approx(wanted * reflectance, rel=1e-3)


def test_lamps_have_their_colour():
    """Also where their lines are the only light there is."""
    nothing = sphere([0, -1e6, 0], 1.0, BLACK)
    grid = np.arange(360.0, 831.0)
    for name in ("lines:589.158*2,589.756", "A", "FL2"):
        white = shown([nothing], [lit(name)], view([0, 0, 0], [0, 0, -1]))
        if name == "A":
            assert white == pytest.approx(ir.color.spectrum_to_xyz(grid, np.ones(471), illuminant=name), rel=1e-5)
        for lamp in (directional([0, 1, 0], np.pi, illuminant=name), point([0, 1, 0], np.pi, illuminant=name)):
            assert shown([FLOOR], [lamp]) == pytest.approx(white, rel=1e-4)


def test_films_pass_what_they_pass():
    """A point above a film above the floor: T of the film, twice where there are two."""
    passed = ir.Stack(["air", ir.Layer(1.33, thickness_nm=300.0), "air"])
    sheets = [disk([0, y, 0], [0, 1, 0], 0.5, film(1.33, 300.0)) for y in (0.5, 0.6, 1.5)]
    found = shown([FLOOR, sheets[0], sheets[2]], [point([0, 1, 0], np.pi), DARK])
    # the floor is seen past the sheets; between them and the floor light goes to and fro
    wanted = passed.color(quantity="transmittance")[1]
    assert wanted < 0.98
    assert found[1] > wanted
    black = plane([0, 0, 0], [0, 1, 0], diffuse(0.01))
    once = shown([black, sheets[0]], [point([0, 1, 0], np.pi)], samples=64)[1] / 0.01
    assert once == pytest.approx(wanted, rel=2e-3)


# ---- many lights --------------------------------------------------------------------------------------------------------


def test_many_lights_of_all_kinds_add_up():
    """Eleven lights of every kind, of which two are asked at a time, and a sky: the sum of each alone."""
    places = [(x, 1.0 + 0.1 * i, 0.3 * i - 0.5) for i, x in enumerate((-1.0, -0.2, 0.4, 1.3))]
    lights = [point(place, 0.5 + i) for i, place in enumerate(places)]
    lights += [spot(place, 2.0, cone_deg=50.0, soft_deg=5.0, target=[0, 0, 0]) for place in places[:2]]
    lights += [directional([0.3, 1.0, 0.2], 0.7), sun([-0.5, 1.0, 0.0], 0.8), lit("D65", 0.3)]
    lamps = [sphere([0.9, 1.2, -0.9], 0.2, emitter(3.0)), disk([-1.0, 1.6, 0.9], [0.3, -1, 0], 0.3, emitter(2.0))]
    alone = sum(shown([FLOOR], [light], samples=256)[1] for light in lights)
    alone += sum(shown([FLOOR, lamp], [DARK], samples=4096)[1] for lamp in lamps)
    # black where the lamps hide each other and the sky: their own shadows are taken off
    hidden = sum(1.0 - shown([FLOOR, {**lamp, "surface": BLACK}], [WHITE], samples=1024)[1] for lamp in lamps)
    scene = build([FLOOR, *lamps], look_at(), lights, samples=4096)
    found = np.array([ir.render(scene, seed=seed).xyz[0, 0, 1] for seed in range(8)], dtype=np.float64)
    error = found.std(ddof=1) / np.sqrt(len(found))
    assert error < 0.005 * alone
    assert abs(found.mean() - (alone - 0.3 * hidden)) < 5.0 * error + 1e-3 * alone


def test_a_faint_lamp_makes_no_noise():
    """A lamp of 1e-6 beside a studio leaves the noise of a picture what it was: choices are made by all of the light."""

    def noise(lights):
        camera = view([0, 0, 16], [0, 0, 0], (12, 12), fov_deg=35.0)
        glass = sphere([0, 0, 0], 4.0, dielectric("N-BK7"))
        inside = sphere([0, 0, 0], 2.0, film(1.0, 500.0, "N-BK7"))
        scene = ir.Scene.load(build([glass, inside], camera, lights, samples=4))
        xyz = np.array([ir.render(scene, seed=seed).xyz for seed in range(12)], dtype=np.float64)
        return np.sqrt(xyz.var(axis=0, ddof=1).mean())

    studio = {"environment": {"builtin": "studio"}}
    without = noise([studio])
    for faint in (lit("laser:700", 1e-6), directional([0, 1, 0], 1e-6, illuminant="laser:700")):
        assert noise([studio, faint]) == pytest.approx(without, rel=0.1)


# ---- what is refused, and told ------------------------------------------------------------------------------------------


def test_a_point_within_glass_is_refused():
    glass = sphere([0, 1, 0], 0.5, dielectric(1.5))
    with pytest.raises(ir.SceneError, match=r"light\.0\.point\.position lies within") as caught:
        ir.render(build([FLOOR, glass], look_at(), [point([0, 1.1, 0])]))
    assert caught.value.key == "light.0.point.position"
    ir.render(build([FLOOR, sphere([0, 1, 0], 0.5, film(1.33, 100.0))], look_at(), [point([0, 1.1, 0])], samples=1))


@pytest.mark.parametrize(
    ("light", "key"),
    [
        (sun([0, 0, 0]), "light.0.sun.direction"),
        (sun([0, 1, 0], -1.0), "light.0.sun.irradiance"),
        (sun([0, 1, 0], angular_diameter_deg=0.0), "light.0.sun.angular_diameter_deg"),
        (point([0, 1, 0], float("nan")), "light.0.point.intensity"),
        (spot([0, 0, 0]), "light.0.spot.target"),
        (spot([0, 1, 0], cone_deg=200.0), "light.0.spot.cone_deg"),
        ({"directional": {}}, "light.0.directional.direction"),
        ({"point": {"position": [0, 1, 0]}, "sun": {"direction": [0, 1, 0]}}, "light.0.point"),
    ],
)
def test_lights_that_are_refused(light, key):
    with pytest.raises(ir.SceneError) as caught:
        ir.Scene.load(build([FLOOR], look_at(), [light]))
    assert caught.value.key == key


def test_a_scene_that_nothing_can_light_is_told():
    with pytest.warns(UserWarning, match="no size"):
        ir.render(build([sphere([0, 0, 0], 1.0, dielectric(1.5))], look_at(), [directional([0, 1, 0])], samples=1))


SHELL = sphere([0, 0, 0], 1.0, diffuse(0.5)) | {"name": "shell"}
LAMP = sphere([0.1, 0, 0], 0.1, emitter(1.0)) | {"name": "lamp"}
CAN = {"cylinder": {"radius": 1.0, "height": 2.0, "open": False}}


@pytest.mark.parametrize(
    ("objects", "lights", "position", "words"),
    [
        ([SHELL], [point([0.1, 0, 0])], [0, 0, 5], 'light.0.point.position lies inside object "shell"'),
        ([SHELL], [DARK, spot([0.1, 0, 0])], [0, 0, 5], 'light.1.spot.position lies inside object "shell"'),
        (
            [SHELL, sphere([0.1, 0, 0], 0.2, emitter(1.0)) | {"name": "lamp"}],
            [WHITE],
            [0, 0, 5],
            'object "lamp" glows inside',
        ),
        ([{**SHELL, "shape": CAN}], [point([0, 0.9, 0])], [0, 0, 5], "light.0.point.position lies inside"),
        (
            [{**SHELL, "transform": {"translate": [9, 0, 0]}}],
            [point([9, 0, 0.5])],
            [0, 0, 5],
            "light.0.point.position lies inside",
        ),
        ([{**SHELL, "instances": [{}, {"translate": [9, 0, 0]}]}], [point([9, 0, 0.5])], [0, 0, 5], "lies inside"),
        ([SHELL], [WHITE], [0, 0.5, 0.5], 'camera.position lies inside object "shell"'),
        *[
            ([{**SHELL, "surface": surface}, LAMP], [WHITE], [0, 0, 5], 'object "lamp" glows inside object "shell"')
            for surface in (metal("Ag"), dielectric("Si"), coating([("SiO2", 300.0)], "Si"))
        ],
        (
            [SHELL, {**LAMP, "transform": {"scale": 4.0}, "instances": [{}, {"translate": [-0.9, 0, 0]}]}],
            [DARK],
            [0, 0, 5],
            'object "lamp" glows inside',
        ),
        ([{**SHELL, "surface": metal("Ag")}], [WHITE], [0, 0.5, 0.5], 'camera.position lies inside object "shell"'),
    ],
)
def test_a_light_that_an_opaque_shell_shuts_in_is_told(objects, lights, position, words):
    scene = build(objects, view(position, [0, 0, 0], (2, 2), orthographic_height=0.1), lights, samples=1)
    with pytest.warns(UserWarning, match="closed and opaque") as told:
        picture = ir.render(scene)
    assert any(words in str(warning.message) for warning in told), [str(warning.message) for warning in told]
    assert "camera" not in words or picture.xyz.max() == 0.0


@pytest.mark.parametrize(
    ("objects", "lights", "position"),
    [
        ([SHELL], [point([0, 0, 1.1])], [0, 0, 5]),
        ([SHELL], [point([0, 0, 0])], [0, 0.5, 0.5]),
        ([SHELL, sphere([0, 0, 0], 0.2, emitter(1.0))], [DARK], [0, 0.5, 0.5]),
        ([SHELL, sphere([0, 0, 1.0], 0.2, emitter(1.0))], [DARK], [0, 0, 5]),
        ([{**SHELL, "shape": {"cylinder": {"radius": 1.0, "height": 2.0}}}], [point([0, 0, 0])], [0, 0, 5]),
        ([{**SHELL, "surface": film("soap", 300.0)}, FLOOR], [point([0, 0.5, 0])], [0, 0, 5]),
        ([{**SHELL, "surface": dielectric("N-BK7")}, LAMP], [DARK], [0, 0, 5]),
        ([{**SHELL, "surface": coating([("Ag", 300.0)], "N-BK7")}, LAMP], [DARK], [0, 0, 5]),
        # One of two lamps is seen; glass of a higher priority opens a window in the metal.
        ([SHELL, {**LAMP, "instances": [{}, {"translate": [2, 0, 0]}]}], [DARK], [0, 0, 5]),
        (
            [
                {**SHELL, "surface": metal("Ag")},
                LAMP,
                sphere([0, 0, 0.6], 0.55, dielectric("N-BK7")) | {"priority": 1},
            ],
            [DARK],
            [0, 0, 5],
        ),
    ],
)
@pytest.mark.filterwarnings("error")
def test_a_light_that_is_seen_is_not_told_of(objects, lights, position):
    scene = build(objects, view(position, [0, 0.1, 0], (2, 2), orthographic_height=0.1), lights, samples=1)
    ir.render(scene)


# A cube from -1 to 1, its faces outwards.
CORNERS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)
THIN = {"scale": [0.2, 2, 0.2], "translate": [9, 0, 0]}
SQUARES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def cube(path, squares=SQUARES):
    """An OBJ file as an object's shape."""
    lines = ["v {} {} {}".format(*corner) for corner in CORNERS]
    lines += ["f " + " ".join(str(corner + 1) for corner in square) for square in squares]
    path.write_text("\n".join(lines) + "\n")
    return {"shape": {"mesh": {"file": str(path)}}, "name": "shell"}


@pytest.mark.parametrize(
    ("placed", "surface", "lamp", "lights", "position", "words"),
    [
        ({}, diffuse(0.5), None, [point([0.9, 0.9, 0.9])], [0, 0, 5], "light.0.point.position lies inside"),
        ({}, metal("Ag"), LAMP, [WHITE], [0, 0, 5], 'object "lamp" glows inside object "shell"'),
        ({}, coating([], "Si"), LAMP, [WHITE], [0, 0, 5], 'object "lamp" glows inside object "shell"'),
        ({"transform": THIN}, diffuse(0.5), None, [point([9, 1.5, 0])], [0, 0, 5], "lies inside"),
        ({"instances": [{}, {"translate": [9, 0, 0]}]}, diffuse(0.5), None, [point([9, 0.5, 0])], [0, 0, 5], "lies inside"),
        ({}, diffuse(0.5), None, [WHITE], [0, 0.5, 0.9], 'camera.position lies inside object "shell"'),
        ({}, diffuse(0.5), sphere([0, 0, 1.6], 0.5, emitter(1.0)), [DARK], [0, 0.5, 0.9], "camera.position lies inside"),
    ],
)  # fmt: skip
def test_a_light_that_a_closed_mesh_shuts_in_is_told(placed, surface, lamp, lights, position, words, tmp_path):
    shell = {**cube(tmp_path / "cube.obj"), **placed, "surface": surface}
    objects = [shell, *([lamp] if lamp else [])]
    scene = build(objects, view(position, [0, 0, 0], (2, 2), orthographic_height=0.1), lights, samples=1)
    with pytest.warns(UserWarning, match="closed and opaque") as told:
        picture = ir.render(ir.Scene.load(scene, allow_outside=True))
    assert sum(words in str(warning.message) for warning in told) == 1, [str(warning.message) for warning in told]
    assert "camera" not in words or picture.xyz.max() == 0.0


@pytest.mark.parametrize(
    ("squares", "surface", "lamp", "lights", "position"),
    [
        (SQUARES, diffuse(0.5), None, [point([1.1, 0.9, 0.9])], [0, 0, 5]),
        (SQUARES[1:], diffuse(0.5), None, [point([0, 0, 0.9])], [0, 0, 5]),
        # Half in and half out.
        (SQUARES, diffuse(0.5), sphere([0, 0.9, 0.1], 0.2, emitter(1.0)), [DARK], [0, 0, 5]),
        (SQUARES, metal("Ag"), sphere([0.9, 0, 0.9], 0.2, emitter(1.0)), [DARK], [0, 0, 5]),
        (SQUARES, dielectric("N-BK7"), LAMP, [DARK], [0, 0, 5]),
        (SQUARES, diffuse(0.5), sphere([0, 0, 1.2], 0.5, emitter(1.0)), [DARK], [0, 0.5, 0.9]),
    ],
)
@pytest.mark.filterwarnings("error")
def test_a_light_that_a_mesh_lets_out_is_not_told_of(squares, surface, lamp, lights, position, tmp_path):
    objects = [{**cube(tmp_path / "cube.obj", squares), "surface": surface}, *([lamp] if lamp else [])]
    scene = build(objects, view(position, [0, 0.1, 0], (2, 2), orthographic_height=0.1), lights, samples=1)
    ir.render(ir.Scene.load(scene, allow_outside=True))


def test_a_lamp_of_a_mesh_in_a_matt_ball_is_told_once(tmp_path):
    lamp = {**cube(tmp_path / "cube.obj"), "name": "lamp", "transform": {"scale": 0.5}, "surface": emitter(1.0)}
    scene = build(
        [SHELL, lamp], view([0, 0, 5], [0, 0, 0], (2, 2), orthographic_height=0.1), [DARK, point([0, 0.95, 0])]
    )
    with pytest.warns(UserWarning, match="closed and opaque") as told:
        ir.render(ir.Scene.load(scene, allow_outside=True), samples=1)
    words = sorted(str(warning.message).split(" inside")[0] for warning in told)
    assert words == ["light.1.point.position lies", 'object "lamp" glows']
