"""Film spheres lit through each other: the renderer against field matrices, and against a blind one.

Each case places spheres so that one ray is mirrored by all of them in turn, in planes of incidence turned against each
other; a soft lamp stands where the ray leaves, so that the chain of mirrors gives most of the light in a tiny window.
"""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from oracles import environment, spectra
from oracles.camera import camera_rays
from oracles.comparison import relative_error, report
from oracles.film import film_amplitudes
from oracles.film_sphere import FilmSphere
from oracles.mueller import diattenuating_retarder, frame_turn
from oracles.polarised_trace import Bounce, Tracer, chain_of_spheres
from physics.scenes import scene

SILVERY = 0.2 + 3.0j  # strong retarder: turns linear into elliptic light

# name: bounces (medium, nm, angle, turn), lamp's peak, field of view in degrees, Y without polarisation / true Y
CHAINS = {
    "planes parallel": ([(spectra.water_index, 300.0, 55.0, 30.0), (1.5, 250.0, 50.0, 0.0)], 200.0, 0.02, 0.505),
    "planes crossed": ([(spectra.water_index, 300.0, 46.0, 0.0), (1.33, 280.0, 47.0, 90.0)], 1000.0, 0.02, 7.08),
    "planes turned by 70": ([(1.7, 200.0, 58.0, 20.0), (spectra.water_index, 350.0, 52.0, 70.0)], 200.0, 0.02, 4.08),
    "elliptic light between": (
        [(2.4, 60.0, 59.0, 0.0), (SILVERY, 100.0, 73.0, 60.0), (SILVERY, 60.0, 65.0, -45.0), (2.0, 200.0, 51.0, -45.0)],
        200.0,
        0.001,
        2.84,
    ),
}


def build(name, resolution=(3, 3)):
    bounces, peak, fov_deg, ratio = CHAINS[name]
    spheres, camera, leaving = chain_of_spheres([Bounce(*b, radius=3.0) for b in bounces])
    camera |= {"fov_deg": fov_deg, "resolution": list(resolution)}
    return spheres, camera, environment.bake(environment.lobe(leaving, 20.0, peak, 0.01), 512), ratio


@pytest.mark.parametrize("name", CHAINS)
def test_spheres_lit_through_each_other(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    spheres, camera, lamp, ratio = build(name)
    environment.write_exr(tmp_path / "lamp.exr", lamp)
    light = lambda d: environment.lookup(lamp, d)  # noqa: E731
    # one ray in the middle of each pixel: averaging over 2 x 2 moves no pixel by more than 0.12 %
    wanted = Tracer(spheres, light, depth=12, threshold=1e-5).picture(camera, points=1)
    blind = Tracer(spheres, light, depth=12, threshold=1e-5, polarised=False).picture(camera, points=1)
    assert blind[1, 1, 1] / wanted[1, 1, 1] == pytest.approx(ratio, rel=0.02)  # the case is worth its name
    got = ir.render(scene(spheres, camera, {"map": "lamp.exr"}, samples=1024, seed=2, max_depth=16)).xyz
    assert relative_error(got, wanted).max() < 0.01, report(got, wanted, 0.01)
    assert relative_error(got, blind).min() > 0.3


def test_the_elliptic_case_needs_all_four_stokes_parameters():
    """Light that loses its V between the mirrors comes out two and a half times too bright."""
    stokes = np.tile([1.0, 0.0, 0.0, 0.0], (len(spectra.WAVELENGTH_NM), 1))
    linear_only = stokes.copy()
    for index, thickness_nm, angle_deg, turn_deg in reversed(CHAINS["elliptic light between"][0]):
        film = film_amplitudes(index, thickness_nm, np.cos(np.radians(angle_deg)), spectra.WAVELENGTH_NM)
        matrix = frame_turn(np.radians(turn_deg)).T @ diattenuating_retarder(film.r_s, film.r_p)
        stokes = np.einsum("wij,wj->wi", matrix, stokes)
        linear_only = np.einsum("wij,wj->wi", matrix, linear_only)
        linear_only[:, 3] = 0.0
    luminance = spectra.xyz_weights()[:, 1]
    assert (linear_only[:, 0] @ luminance) / (stokes[:, 0] @ luminance) > 2.0


@pytest.mark.slow
def test_one_sphere_before_another(tmp_path, monkeypatch):
    """Both kinds of branches: bubbles seen through the walls of others, under a smooth light."""
    monkeypatch.chdir(tmp_path)
    sky = environment.bake(environment.smooth_grey)
    environment.write_exr(tmp_path / "smooth.exr", sky)
    spheres = [
        FilmSphere(1.6, 200.0, 420.0, center=(0.0, 0.0, 0.0), radius=1.0),
        FilmSphere(
            spectra.water_index, 250.0, 550.0, center=(0.9, 0.5, -1.6), radius=1.0
        ),  # overlaps nothing, lies behind
        FilmSphere(2.0, 150.0, 150.0, center=(-0.5, -0.4, 0.5), radius=0.6),  # cuts the first
    ]
    camera = {"position": [0.3, 0.4, 5.0], "target": [0.2, 0.1, 0.0], "fov_deg": 30.0, "resolution": [12, 12]}
    # single rays: one pixel of 1/500 of a degree around each place, so that no pixel average blurs the comparison
    for column, row in ((5.3, 6.1), (8.1, 4.4), (3.4, 7.2), (6.9, 5.0), (9.8, 3.1)):
        origin, direction = camera_rays(camera, column, row)
        window = {
            "position": origin.tolist(),
            "target": (origin + 5.0 * direction).tolist(),
            "fov_deg": 0.002,
            "resolution": [1, 1],
        }
        tracer = Tracer(spheres, lambda d: environment.lookup(sky, d), depth=22, threshold=1e-6)
        wanted = tracer.picture(window, points=1)
        got = ir.render(scene(spheres, window, {"map": "smooth.exr"}, samples=1024, max_depth=16)).xyz
        limit = 0.003 + 2.0 * tracer.left_out  # the sky is nowhere more than twice its mean
        assert tracer.left_out < 0.002
        assert relative_error(got, wanted).max() < limit, report(got, wanted, limit)
