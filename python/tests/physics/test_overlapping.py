"""Bodies that lie over each other, of which `priority` says which one rules: closed forms for the ray along their common axis."""

from __future__ import annotations

from typing import Any

import pytest

import iridesce as ir
from physics.scenes import build, dielectric, disk, emitter, film, lit, plane, sphere

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
