"""Polarised lamps and a polariser before the camera: Malus, Brewster, Fresnel's mirrors, and all signs."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from physics.scenes import DARK, WHITE, build, dielectric, diffuse, disk, emitter, film, plane, rectangle, sphere, view

BLACK = diffuse(0.0)
NOTHING = sphere([0, -1e6, 0], 1.0, BLACK)
AHEAD = view([0, 0, 0], [0, 0, -1], fov_deg=1.0)


def through(polarizer_deg, camera=AHEAD):
    return {**camera, "polarizer_deg": polarizer_deg}


def lamp(radiance=1.0, illuminant="D65", **more):
    return {"emitter": {"illuminant": illuminant, "radiance": radiance, **more}}


def shown(objects, lights, camera, **settings):
    return float(ir.render(build(objects, camera, lights, **{"samples": 4, **settings})).xyz[0, 0, 1])


@pytest.mark.parametrize("polarizer_deg", [0.0, 33.0, 90.0])
def test_half_of_natural_light_passes(polarizer_deg):
    camera = through(polarizer_deg)
    assert shown([NOTHING], [WHITE], camera) == pytest.approx(0.5, rel=1e-6)
    assert shown([disk([0, 0, -5], [0, 0, 1], 1.0, lamp(3.0))], [DARK], camera) == pytest.approx(1.5, rel=1e-6)
    studio = {"environment": {"builtin": "studio"}}
    whole = shown([NOTHING], [studio], view([0, 0, 0], [0.3, 0.8, -1], fov_deg=30.0))
    half = shown([NOTHING], [studio], through(polarizer_deg, view([0, 0, 0], [0.3, 0.8, -1], fov_deg=30.0)))
    assert half == pytest.approx(0.5 * whole, rel=1e-6)


@pytest.mark.parametrize("between", [[], [disk([0, 0, -3], [0, 0, 1], 1.0, film(1.33, 0.0))]])
@pytest.mark.parametrize(("own", "polarizer"), [(0.0, 0.0), (20.0, 65.0), (20.0, -25.0), (10.0, 100.0), (-30.0, 30.0)])
def test_malus(own, polarizer, between):
    """cos^2 of the angle between, for an emitter and a sun, straight and through a film of no thickness."""
    wanted = np.cos(np.radians(own - polarizer)) ** 2
    plate = disk([0, 0, -5], [0, 0, 1], 1.0, lamp(2.0, polarized_deg=own))
    assert shown([plate, *between], [DARK], through(polarizer)) == pytest.approx(2.0 * wanted, rel=1e-5, abs=1e-6)
    sun = {"sun": {"direction": [0, 0, -1], "angular_diameter_deg": 10.0, "polarized_deg": own}}
    radiance = 1.0 / (np.pi * np.sin(np.radians(5.0)) ** 2)
    found = shown([NOTHING, *between], [sun], through(polarizer))
    assert found == pytest.approx(radiance * wanted, rel=1e-5, abs=1e-5)


def test_polarised_light_keeps_its_strength():
    """Without a polariser a polarised lamp looks and lights like any other, whatever its angle."""
    plate = disk([0, 0, -5], [0, 0, 1], 1.0, lamp(2.0, polarized_deg=37.0))
    assert shown([plate], [DARK], AHEAD) == pytest.approx(2.0, rel=1e-6)
    floor = plane([0, 0, 0], [0, 1, 0], diffuse(1.0))
    camera = view([0.3, 0.2, 0], [0, 0, 0], orthographic_height=1e-6)
    kinds = (
        {"directional": {"direction": [0, 1, 0], "irradiance": np.pi, "polarized_deg": 70.0}},
        {"point": {"position": [0, 1, 0], "intensity": np.pi, "polarized_deg": -10.0}},
        {"spot": {"position": [0, 1, 0], "intensity": np.pi, "polarized_deg": -10.0}},
    )
    for light in kinds:
        assert shown([floor], [light], camera) == pytest.approx(1.0, rel=1e-5)


def test_the_glare_of_glass_vanishes_at_brewsters_angle():
    """Black glass: with the polariser upright the glare goes, across it half of R_s stays."""
    n = 1.5
    angle = np.arctan(n)
    camera = view([100 * np.sin(angle), 100 * np.cos(angle), 0], [0, 0, 0], orthographic_height=1e-3)
    glass = [plane([0, 0, 0], [0, 1, 0], dielectric(n)), plane([0, -1, 0], [0, 1, 0], BLACK)]
    r_s = ((n * n - 1.0) / (n * n + 1.0)) ** 2
    assert abs(shown(glass, [WHITE], through(0.0, camera))) < 1e-6
    assert shown(glass, [WHITE], through(90.0, camera)) == pytest.approx(0.5 * r_s, rel=1e-4)
    assert shown(glass, [WHITE], camera) == pytest.approx(0.5 * r_s, rel=1e-4)


def test_films_between_a_polarised_lamp_and_a_matt_surface():
    """At 56 degrees a film of water passes p light whole and s light less: T_s and T_p of the film."""
    angle = np.radians(56.0)
    direction = [np.sin(angle), np.cos(angle), 0.0]
    floor = plane([0, 0, 0], [0, 1, 0], diffuse(0.01))
    sheet = plane([0, 1, 0], [0, 1, 0], film(1.33, 300.0))
    camera = view([0.3, 0.2, 0], [0, 0, 0], orthographic_height=1e-6)
    stack = ir.Stack(["air", ir.Layer(1.33, thickness_nm=300.0), "air"])
    # the upright of the light lies in the plane of incidence: 0 is p, 90 is s
    for polarized_deg, polarization in ((0.0, "p"), (90.0, "s")):
        light = {"directional": {"direction": direction, "irradiance": np.pi, "polarized_deg": polarized_deg}}
        wanted = np.cos(angle) * stack.color(56.0, polarization, quantity="transmittance")[1]
        found = shown([floor, sheet], [light, DARK], camera, samples=64) / 0.01
        assert found == pytest.approx(wanted, rel=3e-3)
    by = {p: stack.color(56.0, p, quantity="transmittance")[1] for p in "sp"}
    assert by["p"] > 1.05 * by["s"]  # it matters


# ---- all signs ------------------------------------------------------------------------------------------------------------


def mirrored(field, light, normal, index, nm):
    """A complex field after a mirror of this index, and its new direction; r_p = -r_s at normal incidence."""
    normal = normal if normal @ light < 0 else -normal
    after = light - 2.0 * (light @ normal) * normal
    s = np.cross(normal, light)
    s = s / np.linalg.norm(s)
    angle = np.degrees(np.arccos(-light @ normal))
    (r_s, _), (r_p, _) = (ir.Stack(["air", index]).amplitudes(nm, angle, polarization) for polarization in "sp")
    return r_s * (field @ s) * s + r_p * (field @ np.cross(light, s)) * np.cross(after, s), after


@pytest.mark.parametrize("own", [0.0, 50.0, 110.0])
def test_two_metal_mirrors_turned_against_each_other(own):
    """Linear light becomes elliptic at the first mirror; what the second makes of it shows the sign of every component."""
    nm, index = 550.0, 0.6 + 2.5j
    normals = [np.array([0.55, 0.35, 0.76]), np.array([-0.65, -0.1, -0.75])]
    normals = [n / np.linalg.norm(n) for n in normals]
    # the camera's ray over both mirrors to the lamp
    places, directions = [np.zeros(3)], [np.array([0.0, 0.0, -1.0])]
    for normal in normals:
        places.append(places[-1] + 4.0 * directions[-1])
        directions.append(directions[-1] - 2.0 * (directions[-1] @ normal) * normal)
    places.append(places[-1] + 4.0 * directions[-1])

    def facing(place, normal, half, surface):
        u = np.cross(normal, [0.3, 1.0, 0.2])
        u = half * u / np.linalg.norm(u)
        return rectangle(place.tolist(), u.tolist(), np.cross(normal, u).tolist(), surface)

    metal = {"metal": {"medium": [index.real, index.imag]}}
    objects = [facing(place, normal, 0.3, metal) for place, normal in zip(places[1:3], normals, strict=True)]
    objects.append(facing(places[3], directions[2], 0.3, lamp(1.0, f"laser:{nm}", polarized_deg=own)))
    light = -directions[2]
    up = np.array([0.0, 1.0, 0.0]) - light * light[1]
    up /= np.linalg.norm(up)
    field = (np.cos(np.radians(own)) * up + np.sin(np.radians(own)) * np.cross(up, light)).astype(complex)
    for normal in normals[::-1]:
        field, light = mirrored(field, light, normal, index, nm)
    assert np.allclose(light, [0, 0, 1])
    found, wanted, linear = [], [], []
    for polarizer in (0.0, 45.0, 90.0, 135.0):
        a = np.radians(polarizer)
        # clockwise in the picture: from up (y) to the right (x)
        wanted.append(abs(field @ np.array([np.sin(a), np.cos(a), 0.0])) ** 2)
        camera = view([0, 0, 0], [0, 0, -1], fov_deg=0.05, polarizer_deg=polarizer)
        found.append(shown(objects, [DARK], camera))
        linear.append(shown(objects, [DARK], view([0, 0, 0], [0, 0, -1], fov_deg=0.05)))
    assert found == pytest.approx(wanted, rel=1e-3, abs=1e-4)
    assert linear[0] == pytest.approx(sum(wanted[::2]), rel=1e-3)


# ---- a microscope ---------------------------------------------------------------------------------------------------------


def test_a_microscope_averages_over_its_pupil():
    """Colours of a film under a high aperture: the mean of R over sin^2 from 0 to NA^2, in each polarisation."""
    aperture = 0.9
    camera = view([0, 5, 0], [0, 0, 0], (4, 4), orthographic_height=0.01, numerical_aperture=aperture, up=[0, 0, 1])
    coated = {"coating": {"layers": [{"medium": 1.46, "thickness_nm": 450.0}], "substrate": [4.1, 0.05]}}
    stack = ir.Stack(["air", ir.Layer(1.46, thickness_nm=450.0), 4.1 + 0.05j])
    node, weight = np.polynomial.legendre.leggauss(48)
    sine2 = aperture**2 * (node + 1.0) / 2.0
    wanted = (weight / 2.0) @ stack.color(np.degrees(np.arcsin(np.sqrt(sine2))))
    scene = build([plane([0, 0, 0], [0, 1, 0], coated)], camera, [WHITE], samples=4096)
    found = ir.render(scene).xyz.mean(axis=(0, 1), dtype=np.float64)
    assert found == pytest.approx(wanted, rel=5e-3)
    assert np.abs(stack.color() / wanted - 1.0).max() > 0.05  # it matters


def test_a_microscope_sees_uniform_light_as_it_is():
    camera = view([0, 0, 5], [0, 0, 0], orthographic_height=1.0, numerical_aperture=0.95)
    assert shown([NOTHING], [WHITE], camera, samples=64) == pytest.approx(1.0, rel=1e-6)


def test_a_microscope_is_sharp_at_its_target():
    """A dark half plane at the target's distance has a sharp edge; two lengths deeper its edge is a ramp."""

    def row(depth):
        camera = view([0, 0, 10], [0, 0, 0], (4, 1), orthographic_height=1.0, numerical_aperture=0.5)
        screen = rectangle([-500, 0, -depth], [500, 0, 0], [0, 500, 0], BLACK)
        return ir.render(build([screen], camera, [WHITE], samples=256)).xyz[0, :, 1]

    assert row(0.0).tolist() == pytest.approx([0.0, 0.0, 1.0, 1.0], abs=1e-6)
    soft = row(8.0)
    assert 0.2 < soft[0] < soft[3] < 0.8


@pytest.mark.parametrize(
    ("camera", "key"),
    [
        ({"numerical_aperture": 0.5}, "camera.numerical_aperture"),
        ({"orthographic_height": 1.0, "numerical_aperture": 1.0}, "camera.numerical_aperture"),
        ({"orthographic_height": 1.0, "numerical_aperture": 0.5, "aperture_radius": 0.1}, "camera.aperture_radius"),
        ({"polarizer_deg": "upright"}, "camera.polarizer_deg"),
    ],
)
def test_cameras_that_are_refused(camera, key):
    with pytest.raises(ir.SceneError) as caught:
        ir.Scene.load(build([NOTHING], view([0, 0, 5], [0, 0, 0], **camera)))
    assert caught.value.key == key


def test_emitters_keep_their_keys():
    scene = ir.Scene.load(build([disk([0, 0, -5], [0, 0, 1], 1.0, lamp(polarized_deg=12.5))], through(7.0), [DARK]))
    again = ir.Scene.load(scene.to_dict())
    assert again.to_dict() == scene.to_dict()
    assert again.to_dict()["camera"]["polarizer_deg"] == 7.0
    assert again.to_dict()["object"][0]["surface"]["emitter"]["polarized_deg"] == 12.5
    assert emitter(1.0)["emitter"].keys() == {"illuminant", "radiance"}
