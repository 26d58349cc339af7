"""Pictures without their backdrop: what is seen straight and unbent of an environment is told by ``alpha`` instead."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from physics.scenes import WHITE, build, dielectric, diffuse, emitter, film, metal, plane, sphere, view

BUBBLE = sphere([0, 0, 0], 1.0, film("soap", 420.0))
CAMERA = view([0, 0, 6], [0, 0, 0], (24, 24), fov_deg=30.0)
SKY = {"environment": {"builtin": "sky"}}
STUDIO = {"environment": {"builtin": "studio"}}


def seen(objects, lights=(WHITE,), camera=CAMERA, render=None, **options) -> ir.Image:
    """A picture, without its backdrop unless ``render`` says so."""
    return ir.render(build(objects, camera, lights, **{"samples": 16, "backdrop": False, **(render or {})}), **options)


def luminance(image: ir.Image) -> np.ndarray:
    return image.xyz[..., 1].astype(float)


def test_a_picture_that_does_not_ask_has_no_such_plane():
    asked = build([BUBBLE], CAMERA, [WHITE], samples=2, backdrop=True)
    silent = build([BUBBLE], CAMERA, [WHITE], samples=2)
    assert "alpha" not in ir.render(asked).channels
    assert ir.render(asked).xyz.tobytes() == ir.render(silent).xyz.tobytes()
    assert ir.Scene.load(asked).to_dict() == ir.Scene.load(silent).to_dict()
    assert ir.Scene.load({**silent, "render": {"backdrop": False}}).to_dict()["render"]["backdrop"] is False


def test_alpha_is_0_where_nothing_is_met_and_1_at_what_is_opaque_or_bends():
    camera = view([0, 0, 8], [0, 0, 0], (48, 8), orthographic_height=2.0)
    surfaces = [metal("Au"), diffuse(0.5), dielectric("N-BK7"), emitter(1.0)]
    image = seen([sphere([3 * i - 4.5, 0, 0], 0.9, one) for i, one in enumerate(surfaces)], camera=camera)
    alpha, middles, between = image.channels["alpha"], [6, 18, 30, 42], [0, 12, 24, 36, 47]
    assert (alpha[3:5, middles] == 1.0).all()
    assert (alpha[:, between] == 0.0).all()
    assert (image.xyz[:, between] == 0.0).all()
    assert (luminance(image)[3:5, middles] > 0.1).all(), "what they mirror, refract and emit stays"


@pytest.mark.parametrize("max_depth", [1, 2, 16])
@pytest.mark.parametrize(
    "inside", [None, metal("Au"), dielectric("N-BK7"), {"film": {"medium": "Ag", "thickness_nm": 90.0}}]
)
def test_the_picture_and_what_shines_through_make_the_whole(inside, max_depth):
    """The same paths: rounding alone is between them, wherever chance has cut a path short."""
    objects = [BUBBLE] + ([sphere([0.2, 0, 0], 0.4, inside)] if inside else [])
    whole, image = (
        seen(objects, render={"backdrop": has_backdrop, "max_depth": max_depth}) for has_backdrop in (True, False)
    )
    alpha = image.channels["alpha"].astype(float)
    np.testing.assert_allclose(luminance(image) + (1.0 - alpha), luminance(whole), rtol=3e-6)
    assert np.ptp(alpha) > 0.1
    assert image.channels["variance"].shape == alpha.shape


@pytest.mark.parametrize("polarizer", [{}, {"polarizer_deg": 0.0}])
@pytest.mark.parametrize("asked", [{}, {"stokes": True}])
@pytest.mark.parametrize("lamp", ["D65", "lines:589.158*2,589.756"])
def test_a_film_covers_by_what_it_does_not_pass(lamp, asked, polarizer):
    """Seen at 50 degrees; through a polariser by what swings in the plane of incidence. White light counts, not the lamp's."""
    angle = np.deg2rad(50.0)
    camera = view([0, 9 * np.sin(angle), 9 * np.cos(angle)], [0, 0, 0], (2, 2), orthographic_height=1.0, **polarizer)
    light = {"environment": {"illuminant": lamp}}
    image = seen([plane([0, 0, 0], [0, 0, 1], film("soap", 700.0))], [light], camera, **asked)
    nm = np.arange(360.0, 831.0)
    stack = ir.Stack(["air", ir.Layer("soap", thickness_nm=700.0), "air"])
    mirrored = stack.reflectance(nm, 50.0, "p" if polarizer else "unpolarized")
    weights = white_luminance(nm)
    np.testing.assert_allclose(image.channels["alpha"], weights @ mirrored / weights.sum(), rtol=3e-3)
    bare = seen([BUBBLE], [light], view([0, 9, 9], [0, 9, 10], (2, 2), fov_deg=20.0, **polarizer), **asked)
    assert (bare.channels["alpha"] == 0.0).all()
    assert (bare.xyz == 0.0).all()


def white_luminance(nm: np.ndarray) -> np.ndarray:
    import colour

    d65 = colour.SDS_ILLUMINANTS["D65"]
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    return np.interp(nm, d65.wavelengths, d65.values) * np.interp(nm, observer.wavelengths, observer.values[:, 1])


def test_the_sun_of_a_sky_goes_with_it_and_a_sun_of_its_own_stays():

    towards = (-0.4, 0.7, -0.6)
    camera = view([0, 0, 0], towards, (16, 16), fov_deg=6.0)
    far = sphere([0, 0, 50], 1.0, film("soap", 420.0))
    sun = {"sun": {"direction": list(towards), "angular_diameter_deg": 2.0, "irradiance": 1.0}}
    pictures = {
        has_sky: seen([far], [SKY, sun] if has_sky else [sun], camera, {"samples": 4}) for has_sky in (True, False)
    }

    assert luminance(pictures[False]).max() > 100.0
    np.testing.assert_allclose(pictures[True].xyz, pictures[False].xyz, rtol=1e-6)
    assert (pictures[True].channels["alpha"] == 0.0).all()
    # Two suns at one place, and polarised ones, go another way through the integrator.
    polarized = [{"sun": {**sun["sun"], "polarized_deg": 30.0}}]
    film_before = [plane([0, 0, 0], [-x for x in towards], film("soap", 420.0))]
    camera = view([-5 * x for x in towards], [0, 0, 0], (16, 16), fov_deg=6.0)
    one, other = (seen(film_before, [SKY, *suns], camera, {"samples": 4}) for suns in ([sun], polarized))
    np.testing.assert_allclose(one.channels["alpha"], other.channels["alpha"], rtol=1e-5)
    assert 0.0 < one.channels["alpha"].min() < one.channels["alpha"].max() < 0.3
    np.testing.assert_allclose(luminance(one).sum(), luminance(other).sum(), rtol=0.05)


def test_spectra_and_stokes_vectors_are_without_it_too():
    asked = {"spectral_nm": [500.0, 600.0], "stokes": True}
    image = seen([BUBBLE], [STUDIO], **asked)
    whole = seen([BUBBLE], [STUDIO], render={"backdrop": True}, **asked)
    assert (image.spectra[0, 0] == 0.0).all()
    assert (image.stokes[0, 0] == 0.0).all()
    assert (whole.spectra[0, 0] > 0.0).any()
    # S0 of the three colours are the picture's own.
    np.testing.assert_allclose(image.stokes[..., 0], image.xyz, rtol=1e-5, atol=1e-7)


def test_crops_journals_shards_merges_and_files_keep_alpha(tmp_path):
    tree = build([BUBBLE], CAMERA, [STUDIO], samples=4, backdrop=False)
    size = {"size": (50, 37)}
    whole = ir.render(tree, **size)
    alpha = whole.channels["alpha"]
    assert alpha.max() > 0.05
    crop = ir.render(tree, **size, crop=(20, 9, 16, 12))
    assert crop.channels["alpha"].tobytes() == alpha[9:21, 20:36].tobytes()
    shards = [ir.render(tree, **size, shard=(i, 2)) for i in (1, 2)]
    assert ir.merge(shards).channels["alpha"].tobytes() == alpha.tobytes()
    journal = tmp_path / "journal"
    ir.render(tree, **size, resume=journal)
    assert ir.render(tree, **size, resume=journal).channels["alpha"].tobytes() == alpha.tobytes()
    other = ir.render(tree, **size, seed=2)
    mean = 0.5 * (alpha.astype(float) + other.channels["alpha"])
    np.testing.assert_allclose(ir.merge([whole, other]).channels["alpha"], mean, atol=1e-7)
    whole.save(tmp_path / "x.exr")
    loaded = ir.Image.load(tmp_path / "x.exr")
    assert loaded.channels["alpha"].tobytes() == alpha.tobytes()
    assert loaded.scene["render"]["backdrop"] is False
