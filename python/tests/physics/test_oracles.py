"""The oracles against other programs, closed forms and each other: no renderer is involved here."""

from __future__ import annotations

import numpy as np
import pytest
import tmm

from oracles import environment, spectra
from oracles.camera import camera_rays
from oracles.film import film_amplitudes, film_powers
from oracles.film_sphere import FilmSphere, picture, radiance_xyz
from oracles.mueller import diattenuating_retarder, frame_turn
from oracles.polarised_trace import Bounce, Tracer, chain_of_spheres, film_matrices, power_of_unpolarised
from oracles.ztest import z_test

CAMERA = {"position": [0.3, 0.5, 4.0], "target": [0.0, 0.1, 0.0], "fov_deg": 35.0, "resolution": [10, 8]}


def test_grid_water_and_white():
    nm = np.array([400.0, 435.8, 486.1, 546.1, 589.3, 656.3, 700.0, 780.0])
    wanted = [1.34356, 1.34059, 1.33749, 1.33483, 1.33335, 1.33151, 1.33052, 1.32896]  # computed apart from this code
    assert spectra.water_index(nm) == pytest.approx(wanted, abs=6e-6)
    x, y, z = spectra.xyz_weights().sum(axis=0)
    assert (x / (x + y + z), y / (x + y + z)) == pytest.approx((0.31272, 0.32903), abs=2e-5)
    assert y == pytest.approx(1.0, abs=1e-14)
    published = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    assert spectra.xyz_from_rec709() == pytest.approx(np.array(published), abs=2e-4)  # IEC 61966-2-1, four digits


@pytest.mark.parametrize("index", [1.33, 2.4, 0.43 + 2.455j])
@pytest.mark.parametrize("angle_deg", [0.0, 40.0, 85.0])
def test_film_against_tmm(index, angle_deg):
    cosine = np.cos(np.radians(angle_deg))
    for thickness_nm, nm in ((20.0, 450.0), (333.0, 555.0)):
        ours = film_amplitudes(index, thickness_nm, cosine, nm)
        for pol, r, t in (("s", ours.r_s, ours.t_s), ("p", ours.r_p, ours.t_p)):
            them = tmm.coh_tmm(pol, [1.0, index, 1.0], [np.inf, thickness_nm, np.inf], np.radians(angle_deg), nm)
            assert abs(r - them["r"]) < 1e-12
            assert abs(r) ** 2 == pytest.approx(them["R"], abs=1e-13)
            assert abs(t) ** 2 == pytest.approx(them["T"], abs=1e-13)
            assert abs(t - them["t"]) < 1e-12
        powers = film_powers(index, np.array([cosine]), np.array([nm])).at(np.array([thickness_nm]))
        for found, wanted in zip(powers, ((ours.r_s, ours.r_p), (ours.t_s, ours.t_p)), strict=True):
            assert found[:, 0, 0] == pytest.approx(np.abs(wanted) ** 2, abs=1e-13)


def test_film_is_isotropic_at_normal_incidence():
    a = film_amplitudes(1.5 + 0.2j, 100.0, 1.0, 550.0)
    assert a.r_p == pytest.approx(-a.r_s)
    assert a.t_p == pytest.approx(a.t_s)
    r, t, mirrored = film_matrices(
        type(a)(*(np.atleast_1d(v) for v in a)), np.array([0.0, 0.0, -1.0]), np.array([0.0, 0.0, 1.0])
    )
    across = np.diag([1.0, 1.0, 0.0])
    assert r[0][:2, :2] == pytest.approx(a.r_s * across[:2, :2])
    assert t[0][:2, :2] == pytest.approx(a.t_s * across[:2, :2])
    assert mirrored == pytest.approx([0.0, 0.0, 1.0])


@pytest.mark.parametrize(("thickness", "index"), [((0.0, 800.0), 1.33), ((5000.0, 5000.0), 2.4)])
def test_closed_form_white_furnace(thickness, index):
    sphere = FilmSphere(index, *thickness)
    xyz = picture(sphere, CAMERA, lambda d: np.ones(d.shape[:-1]), points=1)
    assert np.abs(xyz[..., 1] - 1.0).max() < 1e-9


@pytest.mark.parametrize("inside", [False, True])
@pytest.mark.parametrize("index", [1.33, 0.3 + 2.5j])
def test_closed_form_against_field_matrices(index, inside):
    """Two programs that share the film's amplitudes only: a chain of scalars and a tree of 3 x 3 matrices."""
    sphere = FilmSphere(index, 50.0, 20.0 if isinstance(index, complex) else 700.0, 0.7, (0.1, -0.2, 0.3), 1.5)
    tracer = Tracer([sphere], environment.smooth_grey, depth=400, threshold=1e-13)
    camera = {**CAMERA, "position": [0.5, -0.4, 1.0]} if inside else CAMERA
    for column, row in ((5.0, 4.0), (3.2, 2.1), (6.9, 5.5), (4.0, 1.5)):
        origin, direction = camera_rays(camera, column, row)
        wanted = radiance_xyz(sphere, origin[None], direction[None], environment.smooth_grey)[0]
        assert tracer.xyz(origin, direction) == pytest.approx(wanted, rel=1e-9)
    assert tracer.left_out < 1e-10


def test_field_matrices_lose_nothing_between_two_spheres():
    spheres, camera, _ = chain_of_spheres([Bounce(1.6, 300.0, 55.0, 20.0), Bounce(1.8, 250.0, 50.0, 60.0)])
    tracer = Tracer(spheres, lambda d: np.float64(1.0), depth=14, threshold=1e-9)
    origin, direction = camera_rays({**camera, "fov_deg": 1.0, "resolution": [1, 1]}, 0.5, 0.5)
    assert tracer.xyz(origin, direction)[1] == pytest.approx(1.0, abs=max(1e-6, 2 * tracer.left_out))
    assert tracer.left_out < 1e-3


@pytest.mark.parametrize("index", [1.33, 2.4, 0.4 + 2.4j])
@pytest.mark.parametrize("turns_deg", [(0.0,), (90.0,), (35.0,), (30.0, 70.0), (-50.0, 45.0, 20.0)])
def test_field_matrices_against_mueller_algebra(index, turns_deg):
    """Plates in turned planes of incidence: fields in world coordinates against Stokes vectors in turned frames."""
    angles_deg = (55.0, 48.0, 62.0, 40.0)
    ray, sideways = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])
    nm = spectra.WAVELENGTH_NM
    fields = np.broadcast_to(np.eye(3, dtype=complex), (len(nm), 3, 3))
    stokes = np.tile([1.0, 0.0, 0.0, 0.0], (len(nm), 1))
    start, s_before = ray, None
    for angle_deg, turn_deg in zip(angles_deg, (0.0, *turns_deg), strict=False):
        theta, turn = np.radians(angle_deg), np.radians(turn_deg)
        sideways = np.cos(turn) * sideways + np.sin(turn) * np.cross(ray, sideways)
        normal = -np.cos(theta) * ray + np.sin(theta) * sideways
        film = film_amplitudes(index, 180.0, np.cos(theta), nm)
        reflection, _, mirrored = film_matrices(film, ray, normal)
        fields = reflection @ fields
        s = np.cross(ray, sideways)
        if s_before is not None:
            # angle from the old s to the new one, counted from s towards p = k x s
            phi = np.arctan2(s @ np.cross(ray, s_before), s @ s_before)
            stokes = stokes @ frame_turn(phi).T
        stokes = np.einsum("wij,wj->wi", diattenuating_retarder(film.r_s, film.r_p), stokes)
        sideways = np.cross(np.cross(ray, sideways), mirrored)
        ray, s_before = mirrored, s
    assert power_of_unpolarised(fields, start) == pytest.approx(stokes[:, 0], rel=1e-10, abs=1e-16)


@pytest.mark.parametrize("angle_deg", [45.0, 50.0, 55.0, 60.0])
def test_what_leaving_polarisation_out_costs(angle_deg):
    """Two bounces near Brewster's angle: blind to it, twice too dark (planes parallel), far too bright (crossed)."""
    luminance = spectra.xyz_weights()[:, 1]
    film = film_amplitudes(1.33, 300.0, np.cos(np.radians(angle_deg)), spectra.WAVELENGTH_NM)
    r_s, r_p = np.abs(film.r_s) ** 2, np.abs(film.r_p) ** 2
    blind = ((r_s + r_p) / 2.0) ** 2 @ luminance
    parallel, crossed = (r_s**2 + r_p**2) / 2.0 @ luminance, r_s * r_p @ luminance
    m = diattenuating_retarder(film.r_s, film.r_p)
    assert (m @ m)[:, 0, 0] @ luminance == pytest.approx(parallel)
    assert (m @ frame_turn(np.pi / 2) @ m)[:, 0, 0] @ luminance == pytest.approx(crossed)
    assert 1.79 < parallel / blind <= 2.0
    assert 0.0 <= crossed / blind < 0.21


def test_z_test_passes_noise_and_sees_bias_and_dependence():
    rng = np.random.default_rng(1)
    truth = rng.uniform(0.5, 2.0, (20, 24, 3))
    noise = rng.exponential(1.0, (128, *truth.shape)) - 1.0  # skewed, as rendering noise is
    assert z_test(truth + 0.3 * noise, truth).passes()
    assert not z_test(truth * 1.005 + 0.3 * noise, truth).passes()
    one_pixel = truth + 0.3 * noise
    one_pixel[:, 3, 4, 1] += 0.3
    assert not z_test(one_pixel, truth).passes()
    assert not z_test(truth + 0.3 * np.repeat(noise[::4], 4, axis=0), truth).passes()  # seeds that repeat


def test_lookup_follows_the_written_conventions():
    """First row +y, middle column -z, columns grow towards +x; rotation from +z towards +x."""
    directions = environment.texel_directions(64, 128)
    assert directions[0, 5] == pytest.approx([0.0, 1.0, 0.0], abs=0.03)
    assert directions[32, 64] == pytest.approx([0.0, 0.0, -1.0], abs=0.05)
    assert directions[32, 96] == pytest.approx([1.0, 0.0, 0.0], abs=0.05)
    image = np.random.default_rng(2).random((64, 128)).astype(np.float32)
    assert environment.lookup(image, directions) == pytest.approx(image, abs=1e-6)
    # what the map shows at +z is seen towards +x after a quarter turn
    towards_z = environment.lookup(image, np.array([0.0, 0.0, 1.0]))
    assert environment.lookup(image, np.array([1.0, 0.0, 0.0]), 90.0) == pytest.approx(towards_z, abs=1e-9)
    smooth = environment.bake(environment.smooth_grey)
    sample = np.random.default_rng(3).normal(size=(1000, 3))
    sample /= np.linalg.norm(sample, axis=-1, keepdims=True)
    assert environment.lookup(smooth, sample) == pytest.approx(environment.smooth_grey(sample), abs=2e-4)


def test_camera_follows_the_written_conventions():
    """Row 0 on top, columns to the right, fov_deg the full vertical angle, whatever the aspect ratio."""
    camera = {"position": [0, 0, 5], "target": [0, 0, 0], "fov_deg": 40.0, "resolution": [20, 10]}
    _, top = camera_rays(camera, 10.0, 0.0)
    assert np.degrees(np.arctan2(top[1], -top[2])) == pytest.approx(20.0)
    _, right = camera_rays(camera, 20.0, 5.0)
    assert right[0] / -right[2] == pytest.approx(2.0 * np.tan(np.radians(20.0)))
    origin, direction = camera_rays({**camera, "orthographic_height": 3.0}, 0.0, 10.0)
    assert origin == pytest.approx([-3.0, -1.5, 5.0])
    assert direction == pytest.approx([0.0, 0.0, -1.0])
