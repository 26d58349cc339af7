"""Light of small lamps over mirrors and through lenses, against closed forms and rays from the lamp."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from oracles.ball_caustic import BallCaustic
from physics.scenes import (
    DARK,
    build,
    cap,
    dielectric,
    diffuse,
    disk,
    emitter,
    film,
    metal,
    plane,
    rectangle,
    sphere,
    view,
)

BALL = BallCaustic()
DIM = 2e-3  # between floor and mirror light goes to and fro: once more is little, and no branch is left to chance
SILVER = rectangle([-1, 1, 0], [0, 0, 3], [0, 3, 0], metal("Ag"))


def floor(reflectance):
    return plane([0, 0, 0], [0, 1, 0], diffuse(reflectance))


def lamp(center, radius=1e-3):
    """A lamp of intensity 1."""
    return sphere(center, radius, emitter(1.0 / (np.pi * radius**2)))


def point(position, intensity=1.0):
    return {"point": {"position": list(position), "intensity": intensity}}


def irradiance(objects, lights, x, reflectance=DIM, samples=64, **view_of):
    """Y of the irradiance of the floor at a place, and its spread over seeds."""
    camera = view([x + 0.3, 0.2, 0.01], [x, 0, 0], orthographic_height=1e-4, **view_of)
    scene = ir.Scene.load(build([floor(reflectance), *objects], camera, [*lights, DARK], samples=samples))
    found = np.array([ir.render(scene, seed=seed).xyz[0, 0] for seed in range(4)], dtype=np.float64)
    return found.mean(axis=0) * np.pi / reflectance, found.std(axis=0, ddof=1) * np.pi / reflectance / 2.0


def ball_scene(**settings):
    """The bench's picture: the middle of a glass ball's caustic, seen aslant."""
    ball = sphere([0, BALL.height, 0], BALL.radius, dielectric(BALL.index))
    camera = view([3, 1, 0], [0, 0, 0], (24, 8), orthographic_height=0.06)
    things = [floor(0.5), ball, lamp([0, BALL.lamp_height, 0])]
    return ir.Scene.load(build(things, camera, [DARK], **{"samples": 64, **settings}))


def ball_picture():
    """What it shows, from rays of the lamp."""
    edges = np.linspace(0.0, 0.14, 71)
    profile = BALL.irradiance(edges)
    fine = 16
    across = ((np.arange(24 * fine) + 0.5) / (12 * fine) - 1.0) * 0.09
    along = ((np.arange(8 * fine) + 0.5) / (4 * fine) - 1.0) * 0.03 * np.sqrt(10.0)
    shown = np.interp(np.hypot(across, along[:, None]), 0.5 * (edges[1:] + edges[:-1]), profile)
    return 0.5 / np.pi * shown.reshape(8, fine, 24, fine).mean(axis=(1, 3))


def test_a_ball_of_glass_throws_the_light_that_rays_from_the_lamp_do():
    wanted = ball_picture()
    scene = ball_scene(samples=32)
    found = np.array([ir.render(scene, seed=seed).xyz[..., 1] for seed in range(6)], dtype=np.float64)
    means = found.mean(axis=(1, 2))
    error = means.std(ddof=1) / np.sqrt(len(means))
    assert error < 2e-3 * wanted.mean()
    assert abs(means.mean() - wanted.mean()) < 4.0 * error + 2e-3 * wanted.mean()
    # and place by place: the middle is seven times as bright as the edges
    assert np.mean((found.mean(axis=0) / wanted - 1.0) ** 2) < 1e-3


def test_a_crop_and_any_threads_have_the_bytes_of_the_whole():
    scene = ball_scene(samples=4)
    whole = ir.render(scene).xyz
    assert np.array_equal(ir.render(scene, threads=1).xyz, whole)
    assert np.array_equal(ir.render(scene, crop=(5, 2, 9, 4)).xyz, whole[2:6, 5:14])


@pytest.mark.parametrize("x", [0.0, 0.7])
@pytest.mark.parametrize("is_lamp", [True, False])
def test_a_mirror_shows_its_lamp_a_second_time(x, is_lamp):
    """A lamp 1 above the floor and 1 before a wall of silver: its image stands as far behind it."""
    objects, lights = ([SILVER, lamp([0, 1, 0])], []) if is_lamp else ([SILVER], [point([0, 1, 0])])
    found, error = irradiance(objects, lights, x)
    far2 = (x + 2.0) ** 2 + 1.0
    angle_deg = np.degrees(np.arccos((x + 2.0) / np.sqrt(far2)))
    reflectance = ir.Stack(["air", "Ag"]).color(angle_deg=angle_deg)
    wanted = reflectance / far2**1.5
    wanted[1] += 1.0 / (1.0 + x * x) ** 1.5
    assert abs(found[1] - wanted[1]) < 4.0 * error[1] + 2e-3 * wanted[1]
    assert error[1] < 2e-3 * wanted[1]


def test_a_film_throws_its_own_colour():
    """A film 2 above the floor, the lamp half way: its image is 3 away, in the film's colour."""
    sheet = disk([0, 2, 0], [0, -1, 0], 1.0, film(1.33, 300.0))
    with_it, _ = irradiance([sheet], [point([0, 1, 0])], 0.0)
    without, _ = irradiance([], [point([0, 1, 0])], 0.0)
    wanted = ir.Stack(["air", ir.Layer(1.33, thickness_nm=300.0), "air"]).color(angle_deg=0.0) / 9.0
    assert with_it - without == pytest.approx(wanted, rel=2e-2)


@pytest.mark.parametrize("angle_deg", [0.0, 50.0])
def test_light_from_one_direction_reaches_the_bed_of_a_pool(angle_deg):
    """Water on a dim bed, a parallel light: E cos T on the bed, of which T / n^2 comes up again."""
    index, a = 1.33, np.radians(angle_deg)
    water = plane([0, 0, 0], [0, 1, 0], dielectric(index))
    bed = plane([0, -1, 0], [0, 1, 0], diffuse(DIM))
    light = {"directional": {"direction": [np.sin(a), np.cos(a), 0.0], "irradiance": np.pi}}
    camera = view([0, 2, 0], [0, 0, 0], orthographic_height=0.1, up=[1, 0, 0])
    found = ir.render(build([water, bed], camera, [light, DARK], samples=16)).xyz[0, 0, 1]
    face = ir.Stack(["air", index])
    passed = [1.0 - face.color(angle_deg=angle)[1] for angle in (angle_deg, 0.0)]
    assert found / DIM == pytest.approx(np.cos(a) * passed[0] * passed[1] / index**2, rel=2e-3)


def test_a_sun_through_glass_is_as_bright_as_rays_from_one_direction():
    """A ball under the sun: its disc and a parallel light of the same irradiance throw the same mean light."""
    ball = sphere([0, BALL.height, 0], BALL.radius, dielectric(BALL.index))
    camera = view([0.3, 0.2, 0.01], [0, 0, 0], (4, 4), orthographic_height=0.02)
    way = {"direction": [0.0, 1.0, 0.0], "irradiance": 1.0}
    disc = {"sun": {**way, "angular_diameter_deg": 0.1}}
    means = []
    for light in (disc, {"directional": way}):
        scene = ir.Scene.load(build([floor(0.5), ball], camera, [light, DARK], samples=64))
        means.append(ir.render(scene).xyz[..., 1].mean(dtype=np.float64))
    assert means[0] == pytest.approx(means[1], rel=1e-2)
    assert means[0] > 1.5 * 0.5 / np.pi  # it is a lens


@pytest.mark.parametrize(("medium", "polarized_deg"), [(1.5, None), ("water", 30.0)])
def test_both_ways_of_finding_a_lamp_share_it(medium, polarized_deg):
    """A disk as a lamp, large enough that branches meet it through the ball, and a cap as flat, which they alone find."""
    surface = emitter(10.0)
    if polarized_deg is not None:
        surface["emitter"]["polarized_deg"] = polarized_deg
    lamps = [disk([0, 4, 0], [0, -1, 0], 0.1, surface), cap([0, 4, 0], [0, -1, 0], 1e3, 0.1, surface)]
    ball = sphere([0, BALL.height, 0], BALL.radius, dielectric(medium))
    camera = view([3, 1, 0], [0, 0, 0], (8, 8), orthographic_height=0.06)
    found = []
    for thing, samples in zip(lamps, (64, 256), strict=True):
        scene = ir.Scene.load(build([floor(0.5), ball, thing], camera, [DARK], samples=samples))
        means = np.array([ir.render(scene, seed=seed).xyz.mean(axis=(0, 1), dtype=np.float64) for seed in range(8)])
        found.append((means.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(len(means))))
    (guided, small), (plain, large) = found
    assert np.all(small < 0.1 * guided) and np.all(large < 0.15 * plain)
    assert np.all(np.abs(guided - plain) < 4.0 * np.hypot(small, large))
