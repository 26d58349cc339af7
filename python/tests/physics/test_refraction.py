"""Lenses, balls and prisms: where light goes, and in which state, against a ray tracer that shares nothing with them."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from oracles import environment, spectra
from oracles.camera import camera_rays
from oracles.surface_trace import Face, Flat, Round, SurfaceTracer
from physics.scenes import (
    DARK,
    WHITE,
    build,
    cap,
    coating,
    dielectric,
    diffuse,
    disk,
    emitter,
    lit,
    metal,
    plane,
    rectangle,
    sphere,
    view,
)

pytestmark = pytest.mark.filterwarnings("ignore:the data of medium")
FRAUNHOFER = (486.13, 587.56, 656.27)  # F, d, C in nm
FCD_LAMP = "lines:" + ",".join(str(nm) for nm in FRAUNHOFER)
BLACK = diffuse(0.0)


def index_of(name):
    """The index of a medium as a function of one wavelength."""
    medium = ir.Medium(name)
    return lambda nm: complex(medium.index(nm, extrapolate="hold"))


def render(objects, camera, lights=(WHITE,), **settings):
    xyz = ir.render(build(objects, camera, lights, **settings)).xyz.astype(np.float64)
    assert np.isfinite(xyz).all()
    return xyz


# ---- a plano-convex lens ------------------------------------------------------------------------------------------------

CURVATURE, THICK = 100.0, 2.0  # mm


def lens(medium):
    """Plane face up, towards the camera, at z = 0; the round one bulges down. Its faces as the tracer wants them, too."""
    vertex = -THICK
    objects = [
        disk([0, 0, 0], [0, 0, 1], 12.0, dielectric(medium)),
        cap([0, 0, vertex], [0, 0, -1], CURVATURE, 12.0, dielectric(medium)),
    ]
    n = index_of(medium) if isinstance(medium, str) else medium
    round_face = Round((0.0, 0.0, vertex + CURVATURE), CURVATURE, (0.0, 0.0, -1.0), float(np.sqrt(CURVATURE**2 - 144)))
    return objects, [Face(Flat((0, 0, 0), (0, 0, 1), 12.0), 1.0, n), Face(round_face, 1.0, n)]


def width_of_beam(medium, nm, lamp_radius, distance):
    """Radius (mm) of the parallel beam that a small lamp behind the lens fills, by area of the picture."""
    objects, _ = lens(medium)
    lamp = disk([0, 0, -THICK - distance], [0, 0, 1], lamp_radius, emitter(1.0, f"lines:{nm}"))
    height = 6.0
    camera = view([0, 0, 50], [0, 0, 0], (64, 64), orthographic_height=height)
    got = render([*objects, lamp], camera, [DARK], samples=64, max_depth=1, unit="mm")[..., 1]
    n = float(np.real(ir.Medium(medium).index(nm)))
    full = (4.0 * n / (n + 1.0) ** 2) ** 2
    # ghosts of two reflections inside are below a hundredth
    return float(np.sqrt(np.clip(got / full, 0.0, 1.0)[got > 0.02].sum() * (height / 64) ** 2 / np.pi))


def meridional_height(n, beam, distance):
    """Where a ray parallel to the axis at the height ``beam`` meets the plane at ``distance`` behind the vertex, exactly."""
    sag = CURVATURE - np.sqrt(CURVATURE**2 - beam**2)
    inside = np.arcsin(beam / CURVATURE)  # angle to the normal within the glass; the plane face does not bend it
    bend = np.arcsin(n * np.sin(inside)) - inside
    return beam - (distance + sag) * np.tan(bend)


@pytest.mark.parametrize("medium", [1.5168, "N-BK7", "N-SF11"])
def test_a_lens_focuses_where_it_should(medium):
    """A lamp at 1.5 focal lengths: the width of its beam tells the focal length, for three colours."""
    lamp, focal = 1.0, {}
    for nm in FRAUNHOFER:
        n = float(np.real(ir.Medium(medium).index(nm)))
        paraxial = CURVATURE / (n - 1.0)
        distance = 1.5 * paraxial
        got = width_of_beam(medium, nm, lamp, distance)
        low, high = 1.5, 2.5
        for _ in range(60):  # the ray that meets the rim of the lamp on the far side
            middle = 0.5 * (low + high)
            low, high = (middle, high) if -meridional_height(n, middle, distance) < lamp else (low, middle)
        assert got == pytest.approx(low, rel=5e-4), nm
        focal[nm] = distance / (1.0 + lamp / got)
        assert focal[nm] == pytest.approx(paraxial, rel=2e-3)  # spherical aberration at f/50
    shift = (focal[FRAUNHOFER[2]] - focal[FRAUNHOFER[0]]) / focal[FRAUNHOFER[1]]
    n_f, n_d, n_c = (float(np.real(ir.Medium(medium).index(nm))) for nm in FRAUNHOFER)
    assert shift == pytest.approx((n_f - n_c) / (n_d - 1.0), abs=1e-3)  # 1 / Abbe number
    assert shift == pytest.approx({1.5168: 0.0, "N-BK7": 1 / 64.17, "N-SF11": 1 / 25.76}[medium], abs=1.5e-3)


# ---- images against the tracer ------------------------------------------------------------------------------------------


@pytest.fixture
def sky(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    baked = environment.bake(environment.smooth_grey)
    environment.write_exr(tmp_path / "sky.exr", baked)
    return lambda direction: float(environment.lookup(baked, direction))


SKY = {"environment": {"map": "sky.exr"}}
BALL_VIEW = view([0.4, 0.7, 4.0], [0.1, 0, 0], (9, 9), fov_deg=30.0)
LENS_VIEW = view([3.0, 4.0, 40.0], [0, 0, -2], (9, 9), fov_deg=36.0)
COATED = ((2.1, 90.0), (1.4, 140.0))
IMAGES = {
    "glass ball": (
        [sphere([0, 0, 0], 1, dielectric(1.5))],
        [Face(Round((0, 0, 0), 1.0), 1.0, 1.5)],
        BALL_VIEW,
    ),
    "glass shell": (
        [sphere([0, 0, 0], 1, dielectric(1.5)), sphere([0.1, 0, 0], 0.8, dielectric("air"))],
        [Face(Round((0, 0, 0), 1.0), 1.0, 1.5), Face(Round((0.1, 0, 0), 0.8), 1.5, 1.0)],
        BALL_VIEW,
    ),
    "drop in a ball": (
        [sphere([0, 0, 0], 1, dielectric(1.6)), sphere([-0.2, 0.1, 0.3], 0.5, dielectric(1.33))],
        [Face(Round((0, 0, 0), 1.0), 1.0, 1.6), Face(Round((-0.2, 0.1, 0.3), 0.5), 1.6, 1.33)],
        BALL_VIEW,
    ),
    "coated ball": (
        [sphere([0, 0, 0], 1, coating(COATED, 1.5))],
        [Face(Round((0, 0, 0), 1.0), 1.0, 1.5, COATED)],
        BALL_VIEW,
    ),
    "smoke-grey ball before a mirror": (
        [sphere([0, 0, 0], 1, dielectric([1.5, 2e-6])), rectangle([0, 0, -3], [4, 0, 0], [0, 4, 0], metal([0.2, 3.4]))],
        [
            Face(Round((0, 0, 0), 1.0), 1.0, 1.5 + 2e-6j),
            Face(Flat((0, 0, -3), (0, 0, 1), half=(4, 4, 0)), 1.0, 0.2 + 3.4j, opaque=True),
        ],
        BALL_VIEW,
    ),
    "lens": (*lens(1.5168), LENS_VIEW),
}


@pytest.mark.parametrize("name", IMAGES)
def test_pictures_through_glass(name, sky):
    """Single rays at places all over the picture; every branch with its polarisation, no dispersion."""
    objects, faces, camera = IMAGES[name]
    # clear glass of one index treats all wavelengths alike: one tells
    coated = any(face.layers for face in faces) or "grey" in name
    nms = spectra.WAVELENGTH_NM[::10] if coated else np.array([550.0])
    weights = spectra.lamp().weights[::10, 1]
    weights = weights / weights.sum() if coated else np.ones(1)
    tracer = SurfaceTracer(faces, sky, depth=40, threshold=1e-5 if coated else 1e-6)
    rng = np.random.default_rng(7)
    compared = 0
    for column, row in rng.uniform(1.0, 8.0, (5 if coated else 14, 2)):
        origin, direction = camera_rays(camera, column, row)
        window = view(origin.tolist(), (origin + 5.0 * direction).tolist(), fov_deg=2e-4)
        tracer.left_out = 0.0
        wanted = np.array([tracer.radiance(origin, direction, nm) for nm in nms]) @ weights
        if tracer.left_out > 1e-4:
            continue  # light that runs around inside for very long
        compared += 1
        got = float(render(objects, window, [SKY], samples=4096)[0, 0, 1])
        # faint branches live by chance; a 10 nm sum stands for the coating's colour
        assert got == pytest.approx(wanted, rel=1e-3 if coated else 2e-4), (column, row)
    assert compared >= 5


PRISM_VIEW = view([0, 0, 8], [0, 0, 0], (1, 1), orthographic_height=1e-3)


def prism_scene(lamp):
    """A prism of flint, cut from two large faces; behind it three lamps and a black wall stand side by side."""
    up, tilt = np.radians(15.0), np.radians(15.0)
    first = (0.0, float(np.sin(up)), float(np.cos(up)))
    second = (0.0, float(np.sin(tilt)), float(-np.cos(tilt)))
    n = index_of("N-SF11")
    objects = [
        disk([0, 0, 0], first, 2.0, dielectric("N-SF11")),
        disk([0, 0, -1], second, 2.0, dielectric("N-SF11")),
    ]
    faces = [Face(Flat((0, 0, 0), first, 2.0), 1.0, n), Face(Flat((0, 0, -1), second, 2.0), 1.0, n)]
    return objects, faces


def landing(faces, nm, z=-20.0):
    """Height at which the straight passage through the prism meets the plane at z."""
    tracer = SurfaceTracer([*faces], depth=3)
    place, ray = np.array([0.0, 0.0, 8.0]), np.array([0.0, 0.0, -1.0])
    for _ in range(2):
        distance, face = tracer.nearest(place, ray)
        place = place + distance * ray
        normal = face.shape.normal(place)
        n0, n1 = (face.front, face.back) if ray @ normal < 0 else (face.back, face.front)
        value = lambda n: (n(nm) if callable(n) else complex(n)).real  # noqa: E731
        facing = normal if ray @ normal < 0 else -normal
        bend, cosine = value(n0) / value(n1), -float(ray @ facing)
        ray = bend * ray + (bend * cosine - np.sqrt(1 - bend**2 * (1 - cosine**2))) * facing
    return float((place + (z - place[2]) / ray[2] * ray)[1]), ray


def passed(medium: str, angle_deg: float, apex_deg: float, nm: np.ndarray) -> np.ndarray:
    """Natural light through both faces of a prism in one plane of incidence (Fresnel)."""
    n = np.real(ir.Medium(medium).index(nm, extrapolate="hold"))
    first = np.radians(angle_deg)
    within = np.radians(apex_deg) - np.arcsin(np.sin(first) / n)
    total = np.zeros_like(nm)
    for s in (True, False):
        share = np.ones_like(nm)
        for outer, inner, beyond in (
            (first, np.arcsin(np.sin(first) / n), n),
            (np.arcsin(n * np.sin(within)), within, n),
        ):
            a, b = (np.cos(outer), beyond * np.cos(inner)) if s else (np.cos(inner), beyond * np.cos(outer))
            share = share * 4.0 * a * b / (a + b) ** 2
        total += 0.5 * share
    return total


def test_a_prism_spreads_daylight_without_bands():
    """Strips of daylight behind flint, each a few nanometres wide: a ray trace in steps of 1 nm says what is seen of each.

    Between its 32 nodes, 15 nm apart in the green, the spectrum of a parted path is interpolated linearly: 3 %.
    """
    objects, faces = prism_scene("D65")
    nm = np.arange(360.0, 831.0)
    at = np.array([landing(faces, one)[0] for one in nm])
    light = ir.color.color_matching(nm) * ir.color.illuminant("D65").power(nm)[:, None]
    light *= (passed("N-SF11", 15.0, 30.0, nm) / light[:, 1].sum())[:, None]
    # What falls between two wavelengths is shared out: a hundredth of a nanometre each.
    fine = np.arange(360.0, 830.0, 0.01)
    places, xyz = np.interp(fine, nm, at), np.stack([np.interp(fine, nm, c) for c in light.T], axis=-1) * 0.01
    for middle in (452.0, 487.0, 531.0, 566.0, 604.0, 648.0):
        height, half = (
            np.interp(middle, nm, at),
            abs(np.interp(middle + 4.0, nm, at) - np.interp(middle - 4.0, nm, at)) / 2,
        )
        strip = rectangle([0, float(height), -20], [5, 0, 0], [0, float(half), 0], emitter(1.0))
        wall = rectangle([0, float(height), -21], [50, 0, 0], [0, 50, 0], BLACK)
        got = render([*objects, strip, wall], PRISM_VIEW, [DARK], samples=65536)[0, 0]
        wanted = xyz[np.abs(places - height) < half].sum(axis=0)
        np.testing.assert_allclose(got, wanted, rtol=0.03, atol=0.03 * wanted.max(), err_msg=str(middle))


def test_a_prism_sends_every_line_its_own_way():
    """Behind the prism one line falls on a lamp, the others on black: on average just that line is seen."""
    objects, faces = prism_scene(FCD_LAMP)
    light = spectra.line_lamp(*((nm, 1.0) for nm in FRAUNHOFER))
    heights = [landing(faces, nm)[0] for nm in FRAUNHOFER]
    assert np.abs(np.diff(heights)).min() > 0.05
    for i, height in enumerate(heights):
        half = 0.02
        lamp = rectangle([0, height, -20], [5, 0, 0], [0, half, 0], emitter(1.0, FCD_LAMP))
        wall = rectangle([0, height, -21], [50, 0, 0], [0, 50, 0], BLACK)
        seen = [
            *faces,
            Face(Flat((0, height, -20), (0, 0, 1), half=(5, half, 0)), emits=1.0),
            Face(Flat((0, height, -21), (0, 0, 1), half=(50, 50, 0)), emits=0.0),
        ]
        tracer = SurfaceTracer(seen, 1.0, depth=10)
        spectrum = np.array(
            [tracer.radiance(np.array([0, 0, 8.0]), np.array([0, 0, -1.0]), nm) for nm in light.wavelength_nm]
        )
        assert np.argmax(spectrum) == i and spectrum[i] > 0.7
        # white light all around: what other bands would find is made up for by its mean, and must cancel
        seeds = np.stack(
            [render([*objects, lamp, wall], PRISM_VIEW, [lit(FCD_LAMP)], samples=256, seed=s)[0, 0] for s in range(16)]
        )
        wanted = spectrum @ light.weights
        z = (seeds.mean(axis=0) - wanted) / (seeds.std(axis=0, ddof=1) / 4.0 + 1e-6)
        assert np.abs(z).max() < 5.0, (seeds.mean(axis=0), wanted)
        assert seeds.mean(axis=0) == pytest.approx(wanted, abs=0.01)


@pytest.mark.parametrize("line", range(3))
def test_one_face_sends_every_line_its_own_way(line):
    """A lamp under flint where one line lands, black around it: lost bands must be made up for like the others."""
    light = spectra.line_lamp(*((nm, 1.0) for nm in FRAUNHOFER))
    n = np.real(ir.Medium("N-SF11").index(light.wavelength_nm))
    places = -20.0 * np.tan(np.arcsin(np.sin(np.radians(60.0)) / n))
    lamp = rectangle([places[line], -20, 0], [0.03, 0, 0], [0, 0, -5], emitter(1.0, FCD_LAMP))
    face = Face(Flat((0, 0, 0), (0, 1, 0)), 1.0, lambda nm: n[np.argmin(abs(light.wavelength_nm - nm))])
    below = [
        Face(Flat((places[line], -20, 0), (0, 1, 0), half=(0.03, 0, 5)), emits=1.0),
        Face(Flat((0, -21, 0), (0, 1, 0)), emits=0.0),
    ]
    objects = [plane([0, 0, 0], [0, 1, 0], dielectric("N-SF11")), lamp, plane([0, -21, 0], [0, 1, 0], BLACK)]
    tracer = SurfaceTracer([face, *below], 1.0)
    away = np.array([-np.sin(np.radians(60.0)), -np.cos(np.radians(60.0)), 0.0])
    wanted = np.array([tracer.radiance(-8.0 * away, away, nm) for nm in light.wavelength_nm]) @ light.weights
    camera = view((-8.0 * away).tolist(), [0, 0, 0], orthographic_height=1e-3)
    seeds = np.stack([render(objects, camera, [lit(FCD_LAMP)], samples=256, seed=s)[0, 0] for s in range(16)])
    z = (seeds.mean(axis=0) - wanted) / (seeds.std(axis=0, ddof=1) / 4.0 + 1e-6)
    assert np.abs(z).max() < 5.0, (seeds.mean(axis=0), wanted)
    assert seeds.mean(axis=0) == pytest.approx(wanted, abs=0.01)


def test_a_prism_parts_daylight(sky):
    """The same under a sky, with its whole spectrum."""
    objects, faces = prism_scene("D65")
    nms = spectra.WAVELENGTH_NM[::5]
    weights = spectra.lamp().weights[::5]
    weights = weights / weights[:, 1].sum()
    tracer = SurfaceTracer(faces, sky, depth=10)
    spectrum = np.array([tracer.radiance(np.array([0, 0, 8.0]), np.array([0, 0, -1.0]), nm) for nm in nms])
    wanted = spectrum @ weights
    seeds = np.stack([render(objects, PRISM_VIEW, [SKY], samples=256, seed=s)[0, 0] for s in range(16)])
    assert seeds.mean(axis=0) == pytest.approx(wanted, rel=1e-3)


@pytest.mark.parametrize("window_nm", [(452.0, 458.0), (548.0, 556.0), (585.0, 590.0), (610.0, 640.0)])
def test_a_prism_spreads_daylight_without_a_gap(window_nm):
    """Behind the prism a slit lets through what lands between two wavelengths: the sum over these alone, in steps of 1 nm.

    What is carried between two nodes, 9 nm apart at 540 nm, is linear there: of lamp times observer that leaves
    h^2 / 12 times the curvature, 1 % of the maximum of y at its sides.
    """
    objects, faces = prism_scene("D65")
    ends = [landing(faces, nm)[0] for nm in window_nm]
    middle, half = sum(ends) / 2, abs(ends[1] - ends[0]) / 2
    slit = rectangle([0, middle, -20], [5, 0, 0], [0, half, 0], emitter(1.0))
    wall = rectangle([0, middle, -21], [50, 0, 0], [0, 50, 0], BLACK)
    nms = np.arange(window_nm[0] + 0.05, window_nm[1], 0.1)
    through = np.array([passes(faces, nm) for nm in nms])
    lamp = spectra.lamp()
    full = np.array([np.interp(nms, lamp.wavelength_nm, w) for w in np.asarray(lamp.weights).T])
    wanted = full @ through * 0.1
    seeds = np.stack(
        [render([*objects, slit, wall], PRISM_VIEW, [lit("D65", 0.0)], samples=4096, seed=s)[0, 0] for s in range(16)]
    )
    error = seeds.std(axis=0, ddof=1) / 4.0
    assert np.abs(seeds.mean(axis=0) - wanted) == pytest.approx(0.0, abs=float(4 * error.max() + 0.02 * wanted.max()))
    assert error.max() < 0.05 * wanted.max()


def passes(faces, nm):
    """Share of the light that goes straight through both faces, unpolarised."""
    tracer = SurfaceTracer([*faces], 1.0, depth=3)
    place, ray = np.array([0.0, 0.0, 8.0]), np.array([0.0, 0.0, -1.0])
    share = np.ones(2)
    for _ in range(2):
        distance, face = tracer.nearest(place, ray)
        place = place + distance * ray
        normal = face.shape.normal(place)
        n0, n1 = (face.front, face.back) if ray @ normal < 0 else (face.back, face.front)
        value = lambda n: (n(nm) if callable(n) else complex(n)).real  # noqa: E731
        facing = normal if ray @ normal < 0 else -normal
        a, b = value(n0), value(n1)
        cos0 = -float(ray @ facing)
        cos1 = float(np.sqrt(1 - (a / b) ** 2 * (1 - cos0**2)))
        r = np.array([(a * cos0 - b * cos1) / (a * cos0 + b * cos1), (b * cos0 - a * cos1) / (b * cos0 + a * cos1)])
        share *= 1 - r**2
        ray = a / b * ray + (a / b * cos0 - cos1) * facing
    return share.mean()


# ---- polarisation -------------------------------------------------------------------------------------------------------


def mirrors(angles_deg, turns_deg, start=(0.0, 0.0, 8.0)):
    """Flat faces that mirror a ray along -z in turn, and where it goes in the end: [(point, normal), ..], direction."""
    place, ray, sideways = np.array(start), np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])
    faces = []
    for angle, turn in zip(np.radians(angles_deg), np.radians(turns_deg), strict=True):
        sideways = np.cos(turn) * sideways + np.sin(turn) * np.cross(ray, sideways)
        place = place + 4.0 * ray
        normal = -np.cos(angle) * ray + np.sin(angle) * sideways
        faces.append((place, normal))
        ray = ray + 2.0 * np.cos(angle) * normal
        across = np.cross(ray, normal)
        sideways = np.cross(across, ray) / np.linalg.norm(across)
    return faces, place, ray


SURFACES = {
    "coated silicon": (((1.46, 280.0),), 3.9 + 0.02j),
    "silver": ((), 0.05 + 3.5j),
    "oxide on titanium": (((2.4, 60.0),), 2.5 + 3.3j),
}


@pytest.mark.parametrize("turn_deg", [0.0, 35.0, 90.0])
@pytest.mark.parametrize("second", SURFACES)
@pytest.mark.parametrize("first", SURFACES)
def test_mirrors_turned_against_each_other(first, second, turn_deg):
    """Three mirrors in planes turned against each other: field matrices tell how much light is left, for each line."""
    kinds = [SURFACES[first], SURFACES[second], SURFACES["coated silicon"]]
    faces, place, ray = mirrors([60.0, 68.0, 57.0], [0.0, turn_deg, 50.0])
    objects, traced = [], []
    for (point, normal), (layers, substrate) in zip(faces, kinds, strict=True):
        word = [substrate.real, substrate.imag]
        surface = coating([*layers], word) if layers else metal(word)
        objects.append(disk(point.tolist(), normal.tolist(), 0.5, surface))
        traced.append(Face(Flat(tuple(point), tuple(normal), 0.5), 1.0, substrate, layers, opaque=True))
    lamp = place + 4.0 * ray
    objects.append(disk(lamp.tolist(), (-ray).tolist(), 0.5, emitter(1.0, FCD_LAMP)))
    traced.append(Face(Flat(tuple(lamp), tuple(-ray), 0.5), emits=1.0))
    light = spectra.line_lamp(*((nm, 1.0) for nm in FRAUNHOFER))
    camera = view([0, 0, 8], [0, 0, 0], orthographic_height=1e-4)
    got = render(objects, camera, [DARK], samples=4)[0, 0]
    sent = np.array([0.0, 0.0, 8.0]), np.array([0.0, 0.0, -1.0])
    tracer, blind = SurfaceTracer(traced, 0.0), SurfaceTracer(traced, 0.0, polarised=False)
    wanted = np.array([tracer.radiance(*sent, nm) for nm in light.wavelength_nm]) @ light.weights
    unpolarised = np.array([blind.radiance(*sent, nm) for nm in light.wavelength_nm]) @ light.weights
    assert got == pytest.approx(wanted, rel=3e-5)
    if first == second == "coated silicon":
        assert abs(unpolarised[1] / wanted[1] - 1.0) > 0.1


@pytest.mark.parametrize("turn_deg", [0.0, 45.0, 90.0])
def test_a_plate_at_brewsters_angle_polarises_what_it_passes(turn_deg):
    """Through a glass plate at Brewster's angle on to a coated mirror: p light passes whole, s light does not."""
    n, brewster = 1.5, np.degrees(np.arctan(1.5))
    faces, _, _ = mirrors([brewster], [0.0])
    # the plate is passed, not mirrored: the mirror stands straight on
    point, normal = faces[0]
    turn, angle = np.radians(turn_deg), np.radians(60.0)
    ray = np.array([0.0, 0.0, -1.0])
    # a plate of two faces shifts the ray: the mirror is wide
    mirror_normal = -np.cos(angle) * ray + np.sin(angle) * np.array([-np.sin(turn), np.cos(turn), 0.0])
    back = point - 0.05 * normal
    away = ray + 2.0 * np.cos(angle) * mirror_normal
    base = np.array([0.0, 0.0, 0.0])
    lamp = base + 6.0 * away
    layers = ((2.4, 60.0),)
    objects = [
        disk(point.tolist(), normal.tolist(), 3.0, dielectric(n)),
        disk(back.tolist(), (-normal).tolist(), 3.0, dielectric(n)),
        disk(base.tolist(), mirror_normal.tolist(), 3.0, coating(layers, [2.5, 3.3])),
        disk(lamp.tolist(), (-away).tolist(), 1.5, emitter(1.0, FCD_LAMP)),
    ]
    traced = [
        Face(Flat(tuple(point), tuple(normal), 3.0), 1.0, n),
        Face(Flat(tuple(back), tuple(-normal), 3.0), 1.0, n),
        Face(Flat(tuple(base), tuple(mirror_normal), 3.0), 1.0, 2.5 + 3.3j, layers, opaque=True),
        Face(Flat(tuple(lamp), tuple(-away), 1.5), emits=1.0),
    ]
    light = spectra.line_lamp(*((nm, 1.0) for nm in FRAUNHOFER))
    camera = view([0, 0, 8], [0, 0, 0], orthographic_height=1e-4)
    got = render(objects, camera, [DARK], samples=4096)[0, 0]
    sent = np.array([0.0, 0.0, 8.0]), np.array([0.0, 0.0, -1.0])
    tracer = SurfaceTracer(traced, 0.0, depth=16)
    wanted = np.array([tracer.radiance(*sent, nm) for nm in light.wavelength_nm]) @ light.weights
    assert got == pytest.approx(wanted, rel=2e-4)


# ---- what is left to chance where wavelengths part ----------------------------------------------------------------------

STUDIO = {"environment": {"builtin": "studio"}}
DENSE = plane([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], dielectric("N-SF11"))
# Seen by nobody; yet where it is, nobody can tell that no light is lost.
FAR_GREY = sphere([0.0, 1e7, 0.0], 1.0, diffuse(0.5))


@pytest.mark.parametrize("samples", [1, 16])
@pytest.mark.parametrize("max_depth", [1, 16])
@pytest.mark.parametrize("place", ["over a floor", "from within", "beside a wall"])
def test_no_pixel_is_darker_than_black(place, max_depth, samples):
    """Glass that disperses, and something that absorbs: one band of a path's light is followed, and the others add nothing.

    (What all of them are expected to find was added for certain and taken off again from the one: pixels of -6 times the mean.)
    """
    camera = view([0.0, 2.0, 6.0], [0.0, 0.7, 0.0], (40, 40), fov_deg=40.0)
    objects = [sphere([0.0, 1.2, 0.0], 1.0, dielectric("N-SF11")), plane([0.0] * 3, [0.0, 1.0, 0.0], diffuse(0.3))]
    if place == "from within":
        camera, objects = view([0.0, -1.0, 0.0], [0.3, 0.0, 0.2], (40, 40), fov_deg=60.0), [DENSE]
    elif place == "beside a wall":
        camera = view([0.0, -1.0, 0.0], [0.3, 0.0, 0.2], (40, 40), fov_deg=60.0)
        objects = [DENSE, rectangle([0.5, 0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.6], diffuse(0.3))]
    xyz = render(objects, camera, [STUDIO], samples=samples, max_depth=max_depth)
    # The outermost nodes of the spectrum may weigh a little less than nothing (splines).
    assert xyz.min() >= -1e-4 * xyz.mean() and xyz.mean() > 0.01


def test_what_passes_beside_the_critical_angle_is_the_same_whatever_else_there_is():
    """From within dense glass, where red light gets out and green does not: the mean with and without something grey far away."""
    angle = np.radians(34.2)
    camera = view([0.0, -1.0, 0.0], [float(np.tan(angle)), 0.0, 0.0], (48, 48), fov_deg=0.3)
    both = [render(objects, camera, [STUDIO], samples=64) for objects in ([DENSE], [DENSE, FAR_GREY])]
    means = np.array([xyz.mean(axis=(0, 1)) for xyz in both])
    errors = np.array([xyz.std(axis=(0, 1)) / 48 for xyz in both])
    assert (np.abs(means[0] - means[1]) < 4.5 * np.hypot(*errors)).all(), (means, errors)
    assert (errors[:, 0] < 0.02 * means[:, 0]).all()
