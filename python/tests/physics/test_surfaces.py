"""Coated, bare and absorbing surfaces against closed forms: flat faces at known angles, plates, total reflection.

A parallel view makes every pixel one angle, so a picture of a flat face is one number; line lamps leave no sum over
wavelengths to differ in.
"""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from oracles import spectra
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
    film,
    lit,
    plane,
    rectangle,
    slanted,
    sphere,
    view,
)

pytestmark = pytest.mark.filterwarnings("ignore:the data of medium")
LINES = ((450.0, 1.0), (532.0, 0.7), (589.3, 1.0), (633.0, 2.0))
LINE_LAMP = "lines:" + ",".join(f"{nm}*{power}" for nm, power in LINES)
LIGHT = spectra.line_lamp(*LINES)
BLACK = diffuse(0.0)


def render(objects, camera, lights=(WHITE,), **settings):
    xyz = ir.render(build(objects, camera, lights, **settings)).xyz.astype(np.float64)
    assert np.isfinite(xyz).all()
    return xyz


# ---- white furnace ----------------------------------------------------------------------------------------------------

GLASS_BALL = sphere([0, 0, 0], 1.0, dielectric(1.5))
AROUND = view([0.0, 0.3, 4.0], [0, 0, 0], (16, 16), fov_deg=30.0)
WHITE_MATT = diffuse(1.0)
LENS = [
    cap([0, 0, 0.2], [0, 0, 1], 2.0, 0.8, dielectric("N-BK7")),
    cap([0, 0, -0.2], [0, 0, -1], 2.0, 0.8, dielectric("N-BK7")),
]
SLAB = [plane([0, 0.1, 0], [0, 1, 0], dielectric(1.5)), plane([0, -0.1, 0], [0, -1, 0], dielectric(1.5))]
FURNACES = {
    "glass ball": ([GLASS_BALL], AROUND),
    "antireflection": ([sphere([0, 0, 0], 1, coating([("MgF2", 100.0)], "N-BK7"))], AROUND),
    "three layers": ([sphere([0, 0, 0], 1, coating([(2.3, 60.0), (1.38, 100.0), (2.3, 60.0)], 1.52))], AROUND),
    "glass in water in glass": (
        [GLASS_BALL, sphere([0, 0, 0], 0.8, dielectric("water")), sphere([0.1, 0, 0], 0.4, dielectric(1.7))],
        AROUND,
    ),
    "air in glass": ([GLASS_BALL, sphere([0.1, 0, 0], 0.6, dielectric("air"))], AROUND),
    "film in water": (
        [sphere([0, 0, 0], 1, dielectric("water")), sphere([0, 0, 0], 0.7, film(1.5, 300.0, outside="water"))],
        AROUND,
    ),
    "rutile behind flint": (
        [sphere([0, 0, 0], 1, dielectric("N-SF11")), sphere([0.3, 0.3, -2.5], 1, dielectric("rutile-o"))],
        AROUND,
    ),
    "plate of rectangles": (
        [
            rectangle([0, 0, 0.1], [1, 0, 0], [0, 1, 0], dielectric(1.5)),
            rectangle([0, 0, -0.1], [0, 1, 0], [1, 0, 0], dielectric(1.5)),
        ],
        AROUND,
    ),
    "plate of disks": (
        [disk([0, 0, 0.1], [0, 0, 1], 1, dielectric(1.5)), disk([0, 0, -0.1], [0, 0, -1], 1, dielectric(1.5))],
        AROUND,
    ),
    "lens": (LENS, AROUND),
    "slab of planes": (SLAB, view([0, 3, 1], [0, 0, 0], (16, 16), fov_deg=60.0)),
    "within a slab": (SLAB, view([0, 0, 0], [0, 1, 0], (16, 16), fov_deg=60.0, up=[0, 0, 1])),
    "within a ball": ([GLASS_BALL], view([0.2, 0.1, 0.3], [1, 0, 0], (16, 16), fov_deg=90.0)),
    "matt in glass": ([GLASS_BALL, sphere([0, 0.1, 0], 0.5, WHITE_MATT)], AROUND),
    "matt through a film": ([sphere([0, 0, 0], 1, film("soap", 300.0)), sphere([0, 0, 0], 0.5, WHITE_MATT)], AROUND),
    "matt corners": (
        [
            sphere([0, 0, 0], 1, WHITE_MATT),
            sphere([0.5, 0.5, -2], 1, WHITE_MATT),
            plane([0, -1, 0], [0, 1, 0], WHITE_MATT),
        ],
        AROUND,
    ),
    # All of the light meets the face from below, much of it near the critical angles of some wavelengths only.
    "matt under flint": (
        [plane([0, 0, 0], [0, 1, 0], dielectric("N-SF11")), plane([0, -1, 0], [0, 1, 0], WHITE_MATT)],
        view([0, 3, 4], [0, 0, 0], (16, 16), fov_deg=30.0),
    ),
    "matt under rutile": (
        [plane([0, 0, 0], [0, 1, 0], dielectric("rutile-o")), plane([0, -1, 0], [0, 1, 0], WHITE_MATT)],
        view([0, 3, 4], [0, 0, 0], (16, 16), fov_deg=30.0),
    ),
}


@pytest.mark.parametrize("max_depth", [1, 2, 4, 16])
@pytest.mark.parametrize("name", FURNACES)
def test_what_takes_nothing_away_is_invisible(name, max_depth):
    """Y = 1 and the white of the light in every pixel: no branch is lost, doubled or closed at the wrong radiance."""
    objects, camera = FURNACES[name]
    xyz = render(objects, camera, samples=4, max_depth=max_depth)
    error = np.abs(xyz - spectra.xyz_weights().sum(axis=0))
    assert error[..., 1].max() < 1e-4
    assert error.max() < 2e-4


KEPT_IN = {
    "ball": ([GLASS_BALL], view([0.9, 0, 0], [0.9, 0, -1], (8, 8), fov_deg=20.0)),
    "slab": (SLAB, view([0, 0, 0], [1, 0, 0], (8, 8), fov_deg=60.0)),
}


@pytest.mark.parametrize("max_depth", [1, 16])
@pytest.mark.parametrize("name", KEPT_IN)
def test_light_that_total_reflection_keeps_in_comes_to_an_end(name, max_depth):
    """A ray beyond the critical angle never gets out of a ball or a slab; the walk must end all the same."""
    objects, camera = KEPT_IN[name]
    xyz = render(objects, camera, samples=4, max_depth=max_depth)
    # The few walks that chance keeps alive longest have weights of hundreds, which cancel in single precision.
    assert np.abs(xyz[..., 1] - 1.0).max() < 0.05
    assert np.abs(np.median(xyz[..., 1]) - 1.0) < 1e-4


# ---- flat faces -------------------------------------------------------------------------------------------------------

# name: layers, substrate
FLAT = {
    "silica on silicon": ([("SiO2", 320.0)], "Si"),
    "oxide on titanium": ([("TiO2", 60.0)], "Ti"),
    "oil on black water": ([(1.47, 410.0)], "water"),
    "magnesium fluoride on glass": ([("MgF2", 100.0)], "N-BK7"),
    "bare gold": ([], "Au"),
    "bare glass": ([], "N-BK7"),
    "silver mirror, protected": ([("SiO2", 150.0)], "Ag"),
    "silver so thin that light passes": ([("Ag", 20.0)], "N-BK7"),
    "a wine-dark stack": ([(2.35, 55.0), (1.46, 90.0), (2.35, 55.0), (1.46, 90.0), ([0.9, 6.0], 8.0)], 1.52),
}


def stack_of(layers, substrate, first="air"):
    number = lambda m: complex(*m) if isinstance(m, list) else m  # noqa: E731
    return ir.Stack([first, *(ir.Layer(number(m), thickness_nm=d) for m, d in layers), number(substrate)])


def line_xyz(values):
    """XYZ of a spectrum at the lines."""
    return np.asarray(values) @ LIGHT.weights


@pytest.mark.parametrize("angle_deg", [0.0, 20.0, 45.0, 56.6, 75.0, 88.0])
@pytest.mark.parametrize("name", FLAT)
def test_flat_faces_reflect_what_the_stack_does(name, angle_deg):
    """Every pixel of a flat face is the stack's own reflectance; what passes ends on black."""
    layers, substrate = FLAT[name]
    surface = coating(layers, substrate) if layers else dielectric(substrate)
    objects = [plane([0, 0, 0], [0, 1, 0], surface), plane([0, -1, 0], [0, 1, 0], BLACK)]
    wanted = line_xyz(stack_of(layers, substrate).reflectance(LIGHT.wavelength_nm, angle_deg))
    got = render(objects, slanted(angle_deg), [lit(LINE_LAMP)], samples=4)
    # single precision: 2^-24 times a few dozen operations
    assert np.abs(got / wanted - 1.0).max() < 5e-6


@pytest.mark.parametrize("angle_deg", [0.0, 45.0, 75.0])
@pytest.mark.parametrize("name", FLAT)
def test_flat_faces_have_the_colour_of_the_stack(name, angle_deg):
    """The same under daylight: 32 spline-weighted wavelengths against the 1 nm sum."""
    layers, substrate = FLAT[name]
    surface = coating(layers, substrate) if layers else dielectric(substrate)
    objects = [plane([0, 0, 0], [0, 1, 0], surface), plane([0, -1, 0], [0, 1, 0], BLACK)]
    wanted = stack_of(layers, substrate).color(angle_deg=angle_deg, space="xyz")
    got = render(objects, slanted(angle_deg, (2, 2)), samples=4)
    # tables of metals have corners between the 32 wavelengths
    limit = 6e-4 if substrate == "Au" else 3e-4
    assert np.abs(got - wanted).max() < limit * wanted.max()


@pytest.mark.parametrize("angle_deg", [0.0, 45.0, 75.0])
@pytest.mark.parametrize("name", ["magnesium fluoride on glass", "bare glass", "silver so thin that light passes"])
def test_flat_faces_pass_what_the_stack_does(name, angle_deg):
    """An emitter beneath the face: one passage, no way back, attenuated by nothing (the lamp's lines are in the clear)."""
    layers, _ = FLAT[name]
    surface = coating(layers, 1.52) if layers else dielectric(1.52)
    objects = [plane([0, 0, 0], [0, 1, 0], surface), plane([0, -1, 0], [0, 1, 0], emitter(1.0, LINE_LAMP))]
    wanted = line_xyz(stack_of(layers, 1.52).transmittance(LIGHT.wavelength_nm, angle_deg))
    got = render(objects, slanted(angle_deg), [DARK], samples=4)
    assert np.abs(got / wanted - 1.0).max() < 5e-6


@pytest.mark.parametrize("angle_deg", [10.0, 35.0, 41.0, 41.2, 60.0, 80.0])
def test_from_inside_and_beyond_the_critical_angle(angle_deg):
    """Seen from within glass: the coating stands in the other order, and beyond the critical angle nothing is lost."""
    layers = [(2.0, 80.0), (1.38, 120.0)]
    objects = [plane([0, 0, 0], [0, -1, 0], coating(layers, 1.52)), plane([0, -1, 0], [0, 1, 0], BLACK)]
    wanted = line_xyz(stack_of(layers, 1.52).reversed().reflectance(LIGHT.wavelength_nm, angle_deg))
    # The lamp stands within the glass.
    lamp = sphere([0, 0, 0], 1000.0, emitter(1.0, LINE_LAMP))
    got = render([*objects, lamp], slanted(angle_deg), [DARK], samples=4)
    # at 41.1 degrees q = n cos of what passes is a difference of squares: 2^-24 n^2 / q of it is rounding
    assert np.abs(got / wanted - 1.0).max() < 1e-4
    if angle_deg > 42.0:
        assert np.abs(got[..., 1] - 1.0).max() < 1e-6


# ---- thickness that varies --------------------------------------------------------------------------------------------


def gauss(low, high, points=8):
    node, weight = np.polynomial.legendre.leggauss(points)
    return low + (high - low) * (node + 1.0) / 2.0, weight / 2.0


@pytest.mark.parametrize("angle_deg", [0.0, 50.0])
def test_a_wedge_pixel_by_pixel(angle_deg):
    """z runs along the rows of the picture, the wedge with it: every row is one strip of thicknesses."""
    rows, height = 24, 4.0
    wedge = {"wedge": {"from": [0, 0, -2.0], "to": [0, 0, 2.0], "start_nm": 0.0, "end_nm": 900.0}}
    objects = [plane([0, 0, 0], [0, 1, 0], coating([("SiO2", wedge)], "Si"))]
    got = render(objects, slanted(angle_deg, (2, rows), height), [lit(LINE_LAMP)], samples=256)
    wanted = np.zeros((rows, 3))
    for row in range(rows):
        top = height / 2.0 - row * height / rows  # z of the pixel's upper edge
        z, weight = gauss(top, top - height / rows)
        nm = (z + 2.0) / 4.0 * 900.0
        stack = ir.Stack(["air", ir.Layer("SiO2", thickness_nm=nm[:, None]), "Si"])
        wanted[row] = line_xyz(weight @ stack.reflectance(LIGHT.wavelength_nm, angle_deg))
    assert np.abs(got / wanted[:, None] - 1.0).max() < 2e-4


def test_a_lens_gap_pixel_by_pixel():
    """An air gap between two faces of glass, under a flat cover: rings in one row of pixels."""
    pixels, width, radius_mm = 48, 1.6, 100.0
    gap = {"lens_gap": {"radius_mm": radius_mm, "contact_gap_nm": 30.0}}
    objects = [
        disk([0, 0, 0], [0, 1, 0], 3.0, coating([("air", gap)], 1.52)),
        disk([0, -1, 0], [0, 1, 0], 3.0, BLACK),
        plane([0, 1, 0], [0, 1, 0], dielectric(1.52)),
    ]
    # the gap lies within the glass under the cover
    camera = view([0, 4, 0], [0, 0, 0], (pixels, 1), orthographic_height=width / pixels, up=[0, 0, -1])
    got = render(objects, camera, [lit("lines:589.3")], samples=256, unit="mm")[0]
    x, weight = gauss(
        -width / 2 + width / pixels * np.arange(pixels)[:, None],
        -width / 2 + width / pixels * np.arange(1, pixels + 1)[:, None],
    )
    z, weight_z = gauss(-width / pixels / 2, width / pixels / 2, 4)
    r2 = x[..., None] ** 2 + z**2
    nm = 30.0 + 1e6 * r2 / (radius_mm + np.sqrt(radius_mm**2 - r2))
    through = 1.0 - ir.Stack(["air", 1.52]).reflectance(589.3)
    ring = ir.Stack([1.52, ir.Layer("air", thickness_nm=nm), 1.52]).reflectance(589.3)
    # between cover and gap light goes to and fro: an incoherent sum
    seen = (1.0 - through) + through**2 * ring / (1.0 - (1.0 - through) * ring)
    wanted = np.einsum("pij,i,j->p", seen, weight, weight_z)
    assert np.abs(got[:, 1] / wanted - 1.0).max() < 5e-4
    assert wanted.max() / wanted.min() > 2.0


# ---- plates -----------------------------------------------------------------------------------------------------------


def plate(medium, thickness, half=50.0):
    """Two faces of a plate in y, and an emitter beneath."""
    return [
        rectangle([0, 0, 0], [0, 0, half], [half, 0, 0], dielectric(medium)),
        rectangle([0, -thickness, 0], [half, 0, 0], [0, 0, half], dielectric(medium)),
        plane([0, -thickness - 1.0, 0], [0, 1, 0], emitter(1.0, LINE_LAMP)),
    ]


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 56.30993247, 75.0])
def test_a_clear_plate_adds_up_its_reflections(angle_deg):
    """(1 - R) / (1 + R) for s and for p, then the mean: s and p must not be mixed between the faces."""
    face = ir.Stack(["air", 1.5])
    wanted = np.mean([(1 - r) / (1 + r) for r in (face.reflectance(550.0, angle_deg, pol) for pol in "sp")])
    got = render(plate(1.5, 1.0), slanted(angle_deg), [DARK], samples=4096, max_depth=40)
    assert np.abs(got[..., 1] / wanted - 1.0).max() < 1e-4


@pytest.mark.parametrize("angle_deg", [0.0, 40.0, 70.0])
@pytest.mark.parametrize("k", [1e-6, 1e-5])
def test_a_grey_plate_absorbs_along_the_slant(k, angle_deg):
    """Beer and Lambert between the faces, every time light crosses."""
    thickness_mm, n = 0.5, 1.5
    slant = np.sqrt(1.0 - (np.sin(np.radians(angle_deg)) / n) ** 2)
    passes = np.exp(-4.0 * np.pi * k * thickness_mm * 1e6 / slant / LIGHT.wavelength_nm)
    face = ir.Stack(["air", n])
    spectrum = 0.0
    for pol in "sp":
        r = face.reflectance(LIGHT.wavelength_nm, angle_deg, pol)
        spectrum = spectrum + 0.5 * (1 - r) ** 2 * passes / (1 - (r * passes) ** 2)
    got = render(plate([n, k], thickness_mm), slanted(angle_deg), [DARK], samples=4096, max_depth=40, unit="mm")
    assert np.abs(got / line_xyz(spectrum) - 1.0).max() < 1e-4


def test_absorbing_media_are_dark_without_end():
    """A half space of grey glass: nothing comes back from infinitely far, and no noise is made of it."""
    objects = [plane([0, 0, 0], [0, 1, 0], dielectric([1.5, 1e-7]))]
    got = render(objects, slanted(30.0, (8, 8)), samples=1)
    assert np.ptp(got[..., 1]) == 0.0
    assert got[0, 0, 1] == pytest.approx(float(ir.Stack(["air", 1.5]).reflectance(550.0, 30.0)), rel=1e-5)
    flint = [plane([0, 0, 0], [0, 1, 0], dielectric("N-SF11")), plane([0, -1, 0], [0, 1, 0], BLACK)]
    got = render(flint, slanted(60.0, (8, 8)), samples=1)
    assert np.ptp(got[..., 1]) < 1e-6


# ---- what a wide camera starts in -------------------------------------------------------------------------------------


def test_a_parallel_view_may_start_on_both_sides_of_a_surface():
    """Half of its rays start under water: each has its own medium. Above, the face mirrors; below, all comes out."""
    objects = [
        plane([0, 0, 0], [0, 1, 0], dielectric(1.5)),
        plane([0, 5, 0], [0, -1, 0], emitter(1.0)),
        plane([0, -5, 0], [0, 1, 0], BLACK),
    ]
    camera = view([0, 0, 0], [1, 1, 0], (4, 8), orthographic_height=2.0, up=[-1, 1, 0])
    got = render(objects, camera, [DARK], samples=4)[..., 1]
    assert got[:4] == pytest.approx(1.0, abs=1e-6)  # starts in air, goes up
    r = float(ir.Stack([1.5, "air"]).reflectance(550.0, 45.0))
    assert r == pytest.approx(1.0)
    assert got[4:] == pytest.approx(0.0, abs=1e-6)  # starts in glass, totally reflected down to black


@pytest.mark.parametrize("y", [3.0, 0.0, -3.0])
def test_a_slab_of_two_planes_is_between_them(y):
    """Whatever side the camera is on, a plate of two parallel planes is entered and left, never inside out."""
    up = view([0, y, 0], [0, y + 1, 0], orthographic_height=0.1, up=[0, 0, 1])
    lamp = plane([0, 10, 0], [0, -1, 0], emitter(1.0))
    slab = [plane([0, 1, 0], [0, 1, 0], dielectric(1.5)), plane([0, -1, 0], [0, -1, 0], dielectric(1.5))]
    got = render([*slab, lamp, plane([0, -10, 0], [0, 1, 0], BLACK)], up, [DARK], samples=16)[0, 0, 1]
    r = 0.04
    wanted = {3.0: 1.0, 0.0: (1 - r) / (1 - r * r), -3.0: (1 - r) / (1 + r)}[y]
    assert got == pytest.approx(wanted, rel=1e-4)
