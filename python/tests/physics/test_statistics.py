"""Noise that is only noise: seeds, threads, samples, depth."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import iridesce as ir
from oracles import environment
from oracles.camera import camera_rays
from oracles.film_sphere import FilmSphere
from oracles.ztest import z_test
from physics.scenes import coating, film, scene, sphere
from physics.scenes import plane as half_space

CAMERA = {"position": [0.8, 0.6, 4.0], "target": [0.1, 0.0, 0.0], "fov_deg": 34.0, "resolution": [24, 20]}
# Two strong films that cut each other: long paths, and much left over at a small depth.
SPHERES = [
    FilmSphere(2.2, 100.0, 500.0),
    FilmSphere(1.7, 250.0, 250.0, center=(0.6, 0.3, -1.7), radius=0.9),
]


def contrasty(direction):
    """A sky with a soft lamp: smooth, yet bright enough in places that lost or doubled paths tell."""
    lamp = environment.lobe(np.array([0.6, 0.64, 0.48]), 30.0, 20.0, 0.0)
    return environment.smooth_grey(direction) + lamp(direction)


@pytest.fixture(scope="module")
def load(tmp_path_factory):
    """``load(max_depth=...)`` gives the scene, read once."""
    folder = tmp_path_factory.mktemp("sky")
    environment.write_exr(folder / "sky.exr", environment.bake(contrasty, 128))

    def scene_of(max_depth=16):
        return ir.Scene.load(scene(SPHERES, CAMERA, {"map": "sky.exr"}, samples=4, seed=1, max_depth=max_depth))

    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        yield scene_of


def renders(loaded, samples, seeds):
    """(n, height, width, 3) in float64."""
    return np.stack([ir.render(loaded, samples=samples, seed=seed).xyz for seed in seeds]).astype(np.float64)


def blocks(images):
    """Means over 4 x 4 pixels of (..., height, width, 3)."""
    *front, height, width, channels = images.shape
    return images.reshape(*front, height // 4, 4, width // 4, 4, channels).mean(axis=(-4, -2))


@pytest.fixture(scope="module")
def reference(load):
    """The mean of eight independent pictures at 256 samples and depth 32, and its standard error; of any depth it is the same."""
    images = renders(load(max_depth=32), 256, range(50_000, 50_008))
    return images.mean(axis=0), images.std(axis=0, ddof=1) / np.sqrt(8)


def test_threads_change_nothing(load):
    loaded = load()
    one = ir.render(loaded, samples=5, seed=9, threads=1)
    for threads in (2, 3, 7):
        other = ir.render(loaded, samples=5, seed=9, threads=threads)
        assert other.xyz.tobytes() == one.xyz.tobytes()
        for name, plane in one.channels.items():
            assert np.asarray(other.channels[name]).tobytes() == np.asarray(plane).tobytes(), name


def test_the_same_again_is_the_same(load):
    assert ir.render(load(), samples=3, seed=4).xyz.tobytes() == ir.render(load(), samples=3, seed=4).xyz.tobytes()


@pytest.mark.parametrize("samples", [1, 4, 7])
def test_seeds_differ(load, samples):
    images = renders(load(), samples, [0, 1, 2, 2**32, 2**64 - 1])
    for i in range(len(images)):
        for j in range(i):
            assert np.mean(images[i] != images[j]) > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("samples", [1, 16])
def test_seeds_are_independent_and_unbiased(load, reference, samples):
    """The mean of many seeds is the converged picture, within the standard error that independent seeds have."""
    wanted, error = reference
    result = z_test(renders(load(), samples, range(1, 1 + {1: 256, 16: 64}[samples])), wanted, error)
    assert result.passes(), result


@pytest.mark.slow
@pytest.mark.parametrize("max_depth", [1, 2, 5])
def test_depth_changes_noise_only(load, reference, max_depth):
    """What is left at max_depth is not dropped: the mean of many pictures at a small depth is that of a large one."""
    wanted, error = reference
    # A rare choice weighs much at small depths, so single pixels are skewed far from normal at any affordable number of
    # pictures; blocks of 4 x 4 are not.
    images = blocks(renders(load(max_depth=max_depth), 8, range(1000, 1120)))
    wanted, error = blocks(wanted), blocks(error)
    result = z_test(images, wanted, error)
    assert result.passes(), result
    # and this test would see half a per cent go missing
    assert not z_test(images * 0.995, wanted, error).passes()


@pytest.mark.slow
def test_what_depth_one_leaves_over_is_much(load, reference):
    """Half of the light in the middle of these spheres has met more than two films: dropping it could not go unseen."""
    xyz = ir.render(load(max_depth=1), samples=64).xyz
    wanted, _ = reference
    assert abs(xyz[..., 1].mean() / wanted[..., 1].mean() - 1.0) < 0.05


@pytest.mark.slow
def test_more_samples_less_error(load, reference):
    """Four times the samples: at most a third of the squared error in every step; plain Monte Carlo gets a quarter."""
    loaded = load()
    wanted, _ = reference
    errors = [float(np.mean((renders(loaded, n, range(70, 78)) - wanted) ** 2)) for n in (1, 4, 16, 64)]
    for coarse, fine in itertools.pairwise(errors):
        assert fine < coarse / 3.0, errors


@pytest.mark.parametrize("samples", [1, 2, 3, 5, 7, 12])
def test_a_pixel_is_the_mean_over_its_own_square(tmp_path, monkeypatch, samples):
    """Box filter without neighbours: any number of samples has the mean of very many, in every pixel."""
    monkeypatch.chdir(tmp_path)
    environment.write_exr(tmp_path / "sky.exr", environment.bake(environment.smooth_grey, 512))
    behind = FilmSphere(1.33, 300.0, 300.0, center=(0.0, 0.0, 20.0), radius=1.0)
    camera = {"position": [0.0, 0.0, 0.0], "target": [0.3, 0.2, -1.0], "fov_deg": 60.0, "resolution": [18, 12]}
    loaded = ir.Scene.load(scene([behind], camera, {"map": "sky.exr"}, samples=samples, max_depth=4))
    wanted = renders(loaded, 4096, [5])[0]
    result = z_test(renders(loaded, samples, range(200)), wanted)
    assert result.worst < result.limit, result
    assert abs(result.bias) < 4.0, result


@pytest.mark.parametrize("axis", [0, 1], ids=["across", "down"])
@pytest.mark.parametrize("samples", [4, 16, 64, 100, 256])
def test_samples_are_spread_over_the_pixel_both_ways(tmp_path, monkeypatch, axis, samples):
    """A sky that is linear across the pixel, or down it: stratified samples beat random ones by far, along either axis.

    n random places give an error of slope / sqrt(12 n); a sqrt(n) x sqrt(n) grid with jitter is sqrt(n) better. Half of
    what such a grid gains, with a factor of 2 to spare, is asked for.
    """
    monkeypatch.chdir(tmp_path)
    sky = environment.bake(lambda d: 2.0 + d[..., axis], 512)
    environment.write_exr(tmp_path / "sky.exr", sky)
    behind = FilmSphere(1.33, 300.0, 300.0, center=(0.0, 0.0, 20.0), radius=1.0)
    camera = {"position": [0.0, 0.0, 0.0], "target": [0.0, 0.0, -1.0], "fov_deg": 40.0, "resolution": [24, 16]}
    got = ir.render(scene([behind], camera, {"map": "sky.exr"}, samples=samples)).xyz[..., 1]
    row, column = np.mgrid[0:16, 0:24]
    grid = (np.arange(16) + 0.5) / 16
    wanted = np.mean(
        [environment.lookup(sky, camera_rays(camera, column + dx, row + dy)[1]) for dx in grid for dy in grid], axis=0
    )
    slope = 2.0 * np.tan(np.radians(20.0)) / 16.0  # radiance a pixel, in the middle of the picture
    random = slope / np.sqrt(12.0 * samples)
    assert np.std(got - wanted) < 2.0 * random / np.sqrt(np.sqrt(samples)), np.std(got - wanted) / random


@pytest.mark.parametrize("max_depth", [1, 2, 16])
@pytest.mark.parametrize("water", [1.333, "water"])
def test_no_pixel_is_darker_than_black(water, max_depth):
    """A bubble over an oil film under the studio. (Pixels of -7 times the mean where many branches are left to chance.)"""
    bubble = film("soap", {"gradient": {"top": 0.0, "bottom": 800.0}})
    tree = {
        "version": 1,
        "camera": {"position": [0.0, 2.0, 6.0], "target": [0.0, 0.7, 0.0], "fov_deg": 40.0, "resolution": [48, 48]},
        "render": {"max_depth": max_depth, "samples": 16},
        "object": [
            sphere((0.0, 1.2, 0.0), 1.0, bubble),
            half_space((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), coating([(1.47, 420.0)], water)),
        ],
        "light": [{"environment": {"builtin": "studio"}}],
    }
    for seed in (1, 2):
        assert ir.render(tree, seed=seed).xyz.min() > 0.0
