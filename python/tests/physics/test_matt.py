"""Matt surfaces and lights of finite size: irradiance in closed form, through films, in corners, and all over a cavity.

A matt surface of reflectance rho under the irradiance E has the radiance rho E / pi, the same in every direction.
"""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from oracles import environment, spectra
from oracles.surface_trace import stack_amplitudes
from physics.scenes import (
    DARK,
    WHITE,
    build,
    dielectric,
    diffuse,
    disk,
    emitter,
    film,
    lit,
    plane,
    rectangle,
    sphere,
    view,
)

pytestmark = pytest.mark.filterwarnings("ignore:the data of medium")
LINES = ((450.0, 1.0), (532.0, 0.7), (633.0, 2.0))
LINE_LAMP = "lines:" + ",".join(f"{nm}*{power}" for nm, power in LINES)
LIGHT = spectra.line_lamp(*LINES)
BLACK = diffuse(0.0)
FLOOR = plane([0, 0, 0], [0, 1, 0], diffuse(0.5))


def look_at(x=0.0, z=0.0, height=0.2, aside=0.3):
    """A tiny parallel view of the floor, from low enough to pass beneath the lamps."""
    return view([x + aside, height, z], [x, 0, z], orthographic_height=1e-6)


def outgoing(objects, camera, lights=(DARK,), *, samples=64, seeds=24, **settings):
    """Mean Y of many seeds and its standard error; the picture has one pixel."""
    loaded = ir.Scene.load(build(objects, camera, lights, samples=samples, **settings))
    y = np.array([float(ir.render(loaded, seed=seed).xyz[0, 0, 1]) for seed in range(seeds)])
    assert np.isfinite(y).all()
    return y.mean(), y.std(ddof=1) / np.sqrt(seeds)


def agrees(found, wanted, worst=3e-3):
    """Within chance (five standard errors), and chance small enough to see ``worst``.

    Branches that meet a small lamp by luck are too rare for their spread to be seen; they bring at most its share of the
    hemisphere, below 1e-4 where it is not seen.
    """
    mean, error = found
    assert error < worst * wanted, (mean, error, wanted)
    assert abs(mean - wanted) < 5.0 * error + 1e-4 * wanted, (mean, error, wanted)


# ---- irradiance of simple lamps -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("x", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("radius", [0.01, 0.3, 0.7])
def test_a_glowing_ball(radius, x):
    """E = pi L (r / d)^2 cos(theta), as long as the whole ball stands above the floor."""
    lamp = sphere([0, 1, 0], radius, emitter(3.0))
    distance2 = 1.0 + x * x
    wanted = 0.5 * 3.0 * radius**2 / distance2**1.5
    agrees(outgoing([FLOOR, lamp], look_at(x), samples=256), wanted)


@pytest.mark.parametrize("radius", [0.05, 1.0, 8.0])
def test_a_glowing_disk_overhead(radius):
    """E = pi L r^2 / (r^2 + h^2) on the axis."""
    lamp = disk([0, 1, 0], [0, -1, 0], radius, emitter(2.0))
    agrees(outgoing([FLOOR, lamp], look_at(), samples=256), 0.5 * 2.0 * radius**2 / (radius**2 + 1.0))


@pytest.mark.parametrize(("a", "b"), [(0.1, 0.2), (1.0, 0.5), (6.0, 4.0)])
def test_a_glowing_rectangle_overhead(a, b):
    """The form factor of a rectangle a x b over its corner, four times."""
    lamp = rectangle([0, 1, 0], [a, 0, 0], [0, 0, b], emitter(2.0))
    p, q = np.hypot(1.0, a), np.hypot(1.0, b)
    corner = (a / p * np.arctan(b / p) + b / q * np.arctan(a / q)) / (2.0 * np.pi)
    agrees(outgoing([FLOOR, lamp], look_at(), samples=256), 0.5 * 2.0 * 4.0 * corner)


def test_many_lamps_add_up():
    """Nine balls, of which only one is asked at a time."""
    places = [(x, z) for x in (-1.0, 0.0, 1.0) for z in (-1.0, 0.0, 1.0)]
    lamps = [sphere([x, 1.0, z], 0.2, emitter(1.0 + i)) for i, (x, z) in enumerate(places)]
    wanted = sum(0.5 * (1.0 + i) * 0.04 / (1.0 + x * x + z * z) ** 1.5 for i, (x, z) in enumerate(places))
    agrees(outgoing([FLOOR, *lamps], look_at(), samples=4096), wanted)


def test_lamps_hide_lamps_and_floors_hide_them_too():
    """A large dim disk hides a bright one; a lamp under the floor gives nothing."""
    near = disk([0, 1, 0], [0, -1, 0], 1.0, emitter(1.0))
    far = disk([0, 2, 0], [0, -1, 0], 1.5, emitter(100.0))
    below = sphere([0, -2, 0], 1.0, emitter(1000.0))
    # from the origin the far one is seen to 1.5 / 2, less than the near one's 1 / 1
    agrees(outgoing([FLOOR, near, far, below], look_at(), samples=256), 0.5 * 0.5)


@pytest.mark.parametrize("x", [0.5, 1.0, 3.0])
def test_a_wall_takes_its_share_of_the_sky(x):
    """A black wall of height 1 along z: the floor sees (1 + cos(phi)) / 2 of the sky, phi the wall's angular height."""
    wall = rectangle([0, 0.5, 0], [0, 0.5, 0], [0, 0, 2e4], BLACK)
    phi = np.arctan(1.0 / x)
    camera = view([x + 0.3, 0.2, 0], [x, 0, 0], orthographic_height=1e-6)
    agrees(outgoing([FLOOR, wall], camera, [WHITE], samples=256), 0.5 * (1.0 + np.cos(phi)) / 2.0)


@pytest.mark.parametrize("sharpness", [0.0, 20.0, 3000.0])
def test_a_map_lights_the_floor(tmp_path, monkeypatch, sharpness):
    """The integral of a map times the cosine, whether the light comes from everywhere or from a spot of one degree."""
    monkeypatch.chdir(tmp_path)
    lobe = environment.lobe(np.array([0.48, 0.6, 0.64]), sharpness, 5.0, 0.05)
    baked = environment.bake(lobe if sharpness else environment.smooth_grey, 512)
    environment.write_exr(tmp_path / "sky.exr", baked)
    y, weight = np.polynomial.legendre.leggauss(700)
    y, weight = (y + 1.0) / 2.0, weight / 2.0  # heights 0..1: the upper half
    azimuth = 2.0 * np.pi * (np.arange(1400) + 0.5) / 1400
    level = np.sqrt(1.0 - y**2)
    directions = np.stack(
        np.broadcast_arrays(level[:, None] * np.sin(azimuth), y[:, None], -level[:, None] * np.cos(azimuth)), axis=-1
    )
    wanted = 0.5 * 2.0 * float((weight * y) @ environment.lookup(baked, directions).mean(axis=1))
    agrees(outgoing([FLOOR], look_at(), [{"environment": {"map": "sky.exr"}}], samples=256), wanted)


def test_the_sun_of_the_sky_lights_the_floor():
    """The disc as it is seen, times its solid angle and cosine, and the sky around it by quadrature of what is seen."""
    elevation, azimuth, radius = np.radians(35.0), np.radians(-40.0), np.radians(0.266)
    sun = np.array([np.cos(elevation) * np.sin(azimuth), np.sin(elevation), -np.cos(elevation) * np.cos(azimuth)])
    sky = {"environment": {"builtin": "sky"}}
    nothing = sphere([0, -1e6, 0], 1.0, BLACK)

    def seen(direction, fov_deg, pixels, samples, up=(0.0, 1.0, 0.0)):
        camera = view([0, 0, 0], list(direction), (pixels, pixels), fov_deg=fov_deg, up=list(up))
        return ir.render(build([nothing], camera, [sky], samples=samples)).xyz[..., 1].astype(np.float64)

    disc = seen(sun, 0.1, 4, 16).mean()
    beside = seen(sun + np.array([0.0, np.radians(1.0), 0.0]), 0.1, 4, 16).mean()
    assert disc > 1000.0 * beside
    edge = seen(sun, 2.0, 100, 16)  # the disc's own size
    area = np.count_nonzero(edge > 0.5 * disc) * (2.0 / 100) ** 2
    assert area == pytest.approx(np.pi * 0.266**2, rel=0.03)
    # five faces of a cube around the origin: solid angle times height of every pixel
    pixels = 200
    place = (2.0 * (np.arange(pixels) + 0.5) / pixels - 1.0) * np.ones((pixels, 1))
    down, across = -place.T, place
    solid = (2.0 / pixels) ** 2 / (1.0 + across**2 + down**2) ** 1.5
    length = np.sqrt(1.0 + across**2 + down**2)
    total = 0.0
    for ahead in ((1, 0, 0), (-1, 0, 0), (0, 0, 1), (0, 0, -1)):
        face = np.minimum(seen(ahead, 90.0, pixels, 16), 30.0 * beside)  # without the sun
        total += float((face * solid * np.maximum(down, 0.0) / length).sum())
    total += float((seen((0, 1, 0), 90.0, pixels, 16, up=(0, 0, 1)) * solid / length).sum())
    wanted = 0.5 / np.pi * (total + (disc - beside) * np.pi * np.sin(radius) ** 2 * sun[1])
    mean, error = outgoing([FLOOR], look_at(), [sky], samples=1024)
    assert error < 1e-3 * wanted
    assert mean == pytest.approx(wanted, rel=4e-3)
    assert total / np.pi * 0.5 < 0.5 * wanted  # the sun is most of it


def test_two_skies_are_one_twice_as_bright():
    """Their suns cover each other: both are seen, in mirrors and bare, as by the floor."""
    once, half = {"environment": {"builtin": "sky"}}, {"environment": {"builtin": "sky", "radiance": 0.5}}
    elevation, azimuth = np.radians(35.0), np.radians(-40.0)
    sun = np.array([np.cos(elevation) * np.sin(azimuth), np.sin(elevation), -np.cos(elevation) * np.cos(azimuth)])
    mirrored = sun * [1.0, -1.0, 1.0]
    for objects, camera in (
        ([sphere([0, -1e6, 0], 1.0, BLACK)], view([0, 0, 0], sun.tolist(), (3, 3), fov_deg=1.0)),
        ([plane([0, -1, 0], [0, 1, 0], dielectric(1.5))], view([0, 0, 0], mirrored.tolist(), (3, 3), fov_deg=1.0)),
        ([FLOOR], look_at()),
    ):
        one, two = (ir.render(build(objects, camera, lights, samples=16)).xyz for lights in ([once], [half, half]))
        assert two == pytest.approx(one, rel=1e-5)


# ---- through films ------------------------------------------------------------------------------------------------------


def film_transmittance(index, thickness_nm, cosine):
    """Unpolarised T of a free film at the lines."""
    out = []
    for nm in LIGHT.wavelength_nm:
        _, _, t_s, t_p = stack_amplitudes([1.0, index, 1.0], [thickness_nm], float(cosine), float(nm))
        out.append(0.5 * (abs(t_s) ** 2 + abs(t_p) ** 2))
    return np.array(out)


DIM = plane([0, 0, 0], [0, 1, 0], diffuse(0.001))  # what it sends back up to the film is of no account


@pytest.mark.parametrize("angle_deg", [0.0, 60.0])
def test_a_film_before_a_small_lamp_takes_what_it_reflects(angle_deg):
    """Straight through, with the transmittance of the film for natural light."""
    angle, far = np.radians(angle_deg), 10.0
    lamp = sphere([far * np.sin(angle), far * np.cos(angle), 0], 0.05, emitter(1e4, LINE_LAMP))
    pane = rectangle([5, 1, 0], [20, 0, 0], [0, 0, 20], film(1.8, 130.0))
    bare = 0.001 * 1e4 * (0.05 / far) ** 2 * np.cos(angle)
    passed = float(film_transmittance(1.8, 130.0, np.cos(angle)) @ LIGHT.weights[:, 1])
    assert passed < 0.95
    agrees(outgoing([DIM, lamp, pane], look_at()), bare * passed, worst=1e-4)


@pytest.mark.parametrize("radius", [0.5, 20.0])
def test_a_film_before_a_large_lamp(radius):
    """Both ways of looking find the lamp through the film; together they must count it once at every angle."""
    lamp = disk([0, 2, 0], [0, -1, 0], radius, emitter(1e3, LINE_LAMP))
    pane = plane([0, 1, 0], [0, 1, 0], film(1.8, 130.0))
    node, weight = np.polynomial.legendre.leggauss(64)
    rim = np.arctan(radius / 2.0)
    theta, weight = rim * (node + 1.0) / 2.0, rim * weight / 2.0
    passed = np.array([film_transmittance(1.8, 130.0, np.cos(t)) for t in theta]) @ LIGHT.weights[:, 1]
    wanted = 0.001 * 1e3 * float(weight @ (2.0 * passed * np.sin(theta) * np.cos(theta)))
    agrees(outgoing([DIM, lamp, pane], look_at(), samples=256), wanted)


def test_two_films_crossed_know_of_polarisation():
    """The light on its way through two tilted films in crossed planes is partly polarised by the first."""
    lamp = sphere([0, 10, 0], 0.05, emitter(1e4, LINE_LAMP))
    tilt = np.radians(60.0)
    first = disk([0, 4, 0], [np.sin(tilt), np.cos(tilt), 0], 2.0, film(2.4, 60.0))
    for normal, same in (([np.sin(tilt), np.cos(tilt), 0], True), ([0, np.cos(tilt), np.sin(tilt)], False)):
        second = disk([0, 7, 0], normal, 2.0, film(2.4, 60.0))
        wanted = 0.0
        for i, nm in enumerate(LIGHT.wavelength_nm):
            _, _, t_s, t_p = stack_amplitudes([1.0, 2.4, 1.0], [60.0], 0.5, float(nm))
            s, p = abs(t_s) ** 2, abs(t_p) ** 2
            wanted += LIGHT.weights[i, 1] * ((s * s + p * p) / 2.0 if same else s * p)
        wanted *= 0.001 * 1e4 * (0.05 / 10.0) ** 2
        agrees(outgoing([DIM, lamp, first, second], look_at()), wanted, worst=1e-3)


def test_matt_light_is_natural():
    """Lit through a polarising film and seen in a polarising mirror: the product of what each does to natural light."""
    brewster, tilt = np.arctan(1.5), np.radians(60.0)
    # black glass at Brewster's angle, off which the camera looks straight down at the floor
    down, come = np.array([0.0, -1.0, 0.0]), np.array([np.sin(2 * brewster), np.cos(2 * brewster), 0.0])
    normal = (down - come) / np.linalg.norm(down - come)
    place = np.array([0.0, 0.5, 0.0])
    mirror = disk(place.tolist(), normal.tolist(), 0.05, dielectric(1.5))
    inside = disk((place - 0.01 * normal).tolist(), normal.tolist(), 0.06, BLACK)
    camera = view((place - 2.0 * come).tolist(), place.tolist(), orthographic_height=1e-6)
    # the lamp stands aside, so that the mirror does not hide it; its film is crossed with the mirror
    to_lamp = np.array([0.0, 10.0, 3.0])
    distance = float(np.linalg.norm(to_lamp))
    lamp = sphere(to_lamp.tolist(), 0.05, emitter(1e5, LINE_LAMP))
    facing = np.array([0.0, np.cos(tilt), -np.sin(tilt)])
    pane = disk((0.6 * to_lamp).tolist(), facing.tolist(), 2.0, film(2.4, 60.0))
    floor = plane([0, 0, 0], [0, 1, 0], diffuse(0.02))
    reflected = float(ir.Stack(["air", 1.5]).reflectance(550.0, np.degrees(brewster)))
    passed = float(film_transmittance(2.4, 60.0, abs(to_lamp @ facing) / distance) @ LIGHT.weights[:, 1])
    wanted = reflected * 0.02 * 1e5 * (0.05 / distance) ** 2 * (10.0 / distance) * passed
    agrees(outgoing([floor, lamp, pane, mirror, inside], camera, samples=256), wanted)


# ---- light to and fro ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("max_depth", [1, 2, 16])
@pytest.mark.parametrize("reflectance", [0.5, 0.9])
def test_an_integrating_sphere(reflectance, max_depth):
    """A lamp of radius a in the middle of a matt cavity of radius 1, s = a^2: B = rho L s / (1 - rho (1 - s)) all over."""
    a = 0.2
    wall, lamp = sphere([0, 0, 0], 1.0, diffuse(reflectance)), sphere([0, 0, 0], a, emitter(1.0))
    camera = view([0.5, 0.3, 0], [1, 0.2, 0.4], orthographic_height=1e-6)
    wanted = reflectance * a**2 / (1.0 - reflectance * (1.0 - a**2))
    agrees(
        outgoing([wall, lamp], camera, samples=512, max_depth=max_depth),
        wanted,
        worst=3e-2 if max_depth == 1 else 1e-2,
    )


@pytest.mark.parametrize("rgb", [[0.9, 0.5, 0.2], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]])
def test_coloured_walls_take_away_and_add_nothing(rgb):
    """The colour under daylight is the one that was asked for, and no wavelength comes back stronger than it went."""
    floor = [plane([0, 0, 0], [0, 1, 0], diffuse(rgb))]
    xyz = ir.render(build(floor, look_at(), [lit("D65")], samples=1)).xyz[0, 0].astype(float)
    assert np.linalg.solve(spectra.xyz_from_rec709(), xyz) == pytest.approx(rgb, abs=2e-3)
    for nm in range(380, 780, 20):
        y = ir.render(build(floor, look_at(), [lit(f"laser:{nm}")], samples=1)).xyz[0, 0, 1]
        assert -1e-6 <= y <= 1.0 + 1e-6, nm


@pytest.mark.parametrize("nm", [450, 550, 650])
def test_a_coloured_cavity(nm):
    """Its reflectance at one wavelength is measured under a laser; the sum over all reflections follows."""
    a, rgb = 0.3, [0.9, 0.5, 0.2]
    floor = [plane([0, 0, 0], [0, 1, 0], diffuse(rgb))]
    rho = float(ir.render(build(floor, look_at(), [lit(f"laser:{nm}")], samples=1)).xyz[0, 0, 1])
    wall, lamp = sphere([0, 0, 0], 1.0, diffuse(rgb)), sphere([0, 0, 0], a, emitter(1.0, f"laser:{nm}"))
    camera = view([0.5, 0.3, 0], [1, 0.2, 0.4], orthographic_height=1e-6)
    agrees(outgoing([wall, lamp], camera, samples=512), rho * a**2 / (1.0 - rho * (1.0 - a**2)), worst=1e-2)


@pytest.mark.parametrize("count", [1, 6])
def test_glowing_walls_of_a_furnace(count):
    """Lamps of the sky's own radiance: every surface has Y = 1 on average, however light is found."""
    lamps = [sphere([3.0 * np.cos(i), 0.8, 3.0 * np.sin(i)], 0.6, emitter(1.0)) for i in range(count)]
    floor = plane([0, 0, 0], [0, 1, 0], diffuse(1.0))
    ball = sphere([0, 0.5, 0], 0.5, dielectric("N-SF11"))
    bubble = sphere([1.0, 0.5, 1.0], 0.4, film("soap", 400.0))
    loaded = ir.Scene.load(
        build([floor, ball, bubble, *lamps], view([0, 2, 5], [0, 0.4, 0], (12, 12), fov_deg=40.0), samples=20)
    )
    # single pixels are skewed: a lamp that is met by luck is rare and bright
    means = np.array([ir.render(loaded, seed=s).xyz[..., 1].mean(dtype=np.float64) for s in range(110)])
    error = means.std(ddof=1) / np.sqrt(110)
    assert error < 5e-4
    assert abs(means.mean() - 1.0) < 4.0 * error
