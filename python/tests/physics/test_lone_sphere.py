"""The renderer against the closed form of a lone film sphere, pixel by pixel (python/tests/oracles/film_sphere.py)."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from oracles import environment, spectra
from oracles.camera import camera_rays
from oracles.comparison import relative_error, report
from oracles.film_sphere import FilmSphere, picture
from physics.scenes import scene

WITHIN = 0.003  # 0.3 %, asked of 99 % of the pixels
SAMPLES = 144

OUTSIDE = {"position": [1.5, 2.0, 3.4], "target": [0.1, 0.05, 0.0], "fov_deg": 36.0, "resolution": [42, 32]}
PARALLEL = {"position": [-2.0, 0.7, 3.0], "target": [0.0, 0.0, 0.1], "orthographic_height": 2.6, "resolution": [40, 40]}
INSIDE = {"position": [0.3, -0.2, 0.1], "target": [-1.0, 0.4, -0.7], "fov_deg": 75.0, "resolution": [32, 32]}
TILTED = {**OUTSIDE, "up": [0.4, 1.0, 0.2], "resolution": [40, 30]}
CLOSE = {**OUTSIDE, "fov_deg": 17.0, "resolution": [40, 30]}  # within the disc, no limb in sight

CASES = {
    "soap, draining": (FilmSphere(spectra.water_index, 0.0, 800.0), OUTSIDE, 0.0),
    "soap, thick, turned light": (FilmSphere(spectra.water_index, 600.0, 2000.0), CLOSE, 40.0),
    "parallel rays": (FilmSphere(1.33, 300.0, 300.0), PARALLEL, -70.0),
    "strong film, curved law, tilted camera": (FilmSphere(1.9, 100.0, 500.0, 2.0), TILTED, 0.0),
    "strongest film": (FilmSphere(2.4, 250.0, 250.0), CLOSE, 200.0),
    "from within": (FilmSphere(1.5, 50.0, 700.0), INSIDE, 25.0),
    # (Few pixels: light goes round in it a hundred times, and the closed form takes as long.)
    "thin metal": (FilmSphere(0.4 + 2.4j, 10.0, 30.0), {**TILTED, "resolution": [14, 10]}, 0.0),
    "small and away from the origin": (
        FilmSphere(1.45, 200.0, 400.0, 0.5, (10.0, -3.0, 2.0), 0.05),
        {"position": [10.1, -2.9, 2.25], "target": [10.0, -3.0, 2.0], "fov_deg": 24.0, "resolution": [20, 20]},
        0.0,
    ),
}


@pytest.fixture
def smooth_map(tmp_path, monkeypatch):
    """A smooth grey map on disc, and the same float32 texels; the folder becomes the current one."""
    monkeypatch.chdir(tmp_path)
    image = environment.bake(environment.smooth_grey)
    environment.write_exr(tmp_path / "smooth.exr", image)
    return image


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_closed_form(case, smooth_map):
    sphere, camera, rotation_deg = CASES[case]
    light = {"map": "smooth.exr", "rotation_deg": rotation_deg, "radiance": 0.8}
    wanted = picture(sphere, camera, lambda d: 0.8 * environment.lookup(smooth_map, d, rotation_deg))
    got = ir.render(scene([sphere], camera, light, samples=SAMPLES, seed=7, max_depth=16)).xyz
    error = relative_error(got, wanted)
    assert np.mean(error <= WITHIN) >= 0.99, report(got, wanted, WITHIN)
    assert error.max() < 0.03, report(got, wanted, WITHIN)


def test_the_comparison_would_see_small_mistakes(smooth_map):
    """One per cent of thickness, 0.01 of index or two degrees of map put more than 1 % of pixels out of bounds."""
    # Without the limb, where light goes round a hundred times.
    camera = {**CLOSE, "fov_deg": 12.0, "resolution": [20, 14]}
    sphere = FilmSphere(1.9, 300.0, 900.0)

    def look(s=sphere, turn=0.0, c=camera):
        return picture(s, c, lambda d: environment.lookup(smooth_map, d, turn), points=1)

    wanted = look()
    for other in (
        look(FilmSphere(1.9, 303.0, 909.0)),
        look(FilmSphere(1.91, 300.0, 900.0)),
        look(FilmSphere(1.9, 900.0, 300.0)),
        look(turn=2.0),
        look(c={**camera, "fov_deg": 12.2}),
        wanted[::-1],
        wanted[:, ::-1],
    ):
        assert np.mean(relative_error(other, wanted) <= WITHIN) < 0.99


@pytest.mark.slow
@pytest.mark.parametrize("depth", [1, 2, 4])
def test_closed_form_whatever_the_depth(depth, smooth_map):
    """What is left at max_depth is closed or chosen without bias, never dropped: the same answer at every depth."""
    sphere = FilmSphere(2.0, 150.0, 450.0)
    camera = {**CLOSE, "resolution": [24, 18]}
    wanted = picture(sphere, camera, lambda d: environment.lookup(smooth_map, d))
    got = ir.render(scene([sphere], camera, {"map": "smooth.exr"}, samples=1024, seed=3, max_depth=depth)).xyz
    # random choices at small depth leave noise; a dropped remainder would show as a lack of light everywhere
    error = relative_error(got, wanted)
    assert np.median(error) < 0.01, report(got, wanted, 0.01)
    assert abs(got[..., 1].mean() / wanted[..., 1].mean() - 1.0) < 5e-4, report(got, wanted, 0.01)


@pytest.mark.parametrize(
    ("illuminant", "light"),
    [
        ("A", spectra.lamp("A")),
        ("laser:550", spectra.line_lamp((550.0, 1.0))),
        ("lines:589.158*2,589.756", spectra.line_lamp((589.158, 2.0), (589.756, 1.0))),
    ],
)
def test_closed_form_under_other_lamps(illuminant, light):
    """Absorbing film, so that a uniform light shows the film's spectrum; lines are true lines."""
    sphere = FilmSphere(1.8 + 0.25j, 100.0, 500.0)
    camera = {**CLOSE, "resolution": [24, 18]}
    wanted = picture(sphere, camera, 2.5, light)
    got = ir.render(scene([sphere], camera, {"illuminant": illuminant, "radiance": 2.5}, samples=1024, seed=5)).xyz
    error = relative_error(got[..., :2], wanted[..., :2])  # Z of a yellow line is next to nothing
    assert np.mean(error <= WITHIN) >= 0.99, report(got[..., :2], wanted[..., :2], WITHIN)
    assert np.abs(got[..., 2] - wanted[..., 2]).max() < 0.01 * 2.5


def coloured(direction):
    """Smooth linear Rec.709 with greys, pure blue, dark red and highlights above 1."""
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.stack(
        [0.02 + (1 + x) ** 2, np.maximum(0.0, 1.5 * y) ** 2, 3.0 * (1 - z) ** 2 + 0.3 * (1 + x * y)], axis=-1
    )


@pytest.mark.parametrize("rotation_deg", [0.0, 130.0])
@pytest.mark.parametrize("ahead", [(0, 0, -1), (0, 0, 1), (1, 0.3, 0.2), (-0.5, 0.9, 0.4), (0.2, -1, 0.1)])
def test_background_gives_the_map_back(rotation_deg, ahead, tmp_path, monkeypatch):
    """Where no object is in the way the picture's linear Rec.709 is the map's own, to 1e-3 of the brightest channel."""
    monkeypatch.chdir(tmp_path)
    image = environment.bake(coloured, 128)
    environment.write_exr(tmp_path / "coloured.exr", image)
    behind = FilmSphere(1.33, 300.0, 300.0, center=tuple(-5.0 * np.array(ahead, dtype=float)), radius=1.0)
    light = {"map": "coloured.exr", "rotation_deg": rotation_deg, "radiance": 1.5}
    # wide for the place of every pixel, narrow (texels are 1.4 degrees wide) for its exact value
    for fov_deg, limit in ((60.0, 0.02), (1.0, 1e-3)):
        camera = {"position": [0.0, 0.0, 0.0], "target": list(ahead), "fov_deg": fov_deg, "resolution": [24, 16]}
        got = ir.render(scene([behind], camera, light, samples=64)).xyz.astype(float)
        got = got @ np.linalg.inv(spectra.xyz_from_rec709()).T
        row, column = np.mgrid[0:16, 0:24]
        offsets = (np.arange(8) + 0.5) / 8
        wanted = np.mean(
            [
                1.5 * environment.lookup(image, camera_rays(camera, column + dx, row + dy)[1], rotation_deg)
                for dx in offsets
                for dy in offsets
            ],
            axis=0,
        )
        error = np.abs(got - wanted).max(axis=-1) / wanted.max(axis=-1)
        i = np.unravel_index(error.argmax(), error.shape)
        assert error.max() < limit, f"worst {error.max():.2e} at {i}: got {got[i]}, wanted {wanted[i]}"


def test_lights_add(smooth_map):
    """A map and a uniform light together are the sum of each alone."""
    tree = scene(
        [FilmSphere(1.33, 300.0, 300.0)], {**OUTSIDE, "resolution": [32, 24]}, {"map": "smooth.exr"}, samples=16
    )
    uniform = {"illuminant": "D65", "radiance": 0.5}
    one = ir.render(tree).xyz
    two = ir.render({**tree, "light": [{"environment": uniform}]}).xyz
    both = ir.render({**tree, "light": [tree["light"][0], {"environment": uniform}]}).xyz
    assert np.abs(both - (one + two)).max() < 2e-4


def test_planes_of_depth_thickness_and_normal(smooth_map):
    """Distance along the ray, thickness at the hit and the outward normal, against the geometry at pixel centres."""
    sphere = FilmSphere(1.33, 100.0, 700.0, 1.5, (0.2, -0.1, 0.3), 1.2)
    camera = {**OUTSIDE, "resolution": [80, 60]}
    image = ir.render(scene([sphere], camera, {"map": "smooth.exr"}, samples=16))
    row, column = np.mgrid[0:60, 0:80] + 0.5
    origin, direction = camera_rays(camera, column.ravel(), row.ravel())
    hits, distance, _ = sphere.first_hit(origin, direction)
    place = origin + distance[:, None] * direction
    normal = (place - np.array(sphere.center)) / sphere.radius
    steep = -np.sum(normal * direction, axis=-1)
    inner, outer = hits & (steep > 0.35), ~hits
    # well clear of the limb, so that no sub-sample of an outer pixel hits
    relative = origin - np.array(sphere.center)
    miss = np.linalg.norm(np.cross(relative, direction), axis=-1)
    outer &= miss > sphere.radius * 1.05
    planes = {k: np.asarray(v, dtype=float) for k, v in image.channels.items()}
    assert {"depth", "thickness_nm", "normal"} <= set(planes)
    depth, thickness = planes["depth"].ravel(), planes["thickness_nm"].ravel()
    normals = planes["normal"].reshape(-1, 3)
    assert inner.sum() > 500
    assert outer.sum() > 500
    assert np.isposinf(depth[outer]).all()
    assert np.isnan(thickness[outer]).all()
    assert np.abs(depth - distance)[inner].max() < 0.05  # a pixel is 0.04 wide at the sphere
    assert np.median(np.abs(depth - distance)[inner]) < 0.01
    assert np.abs(thickness - sphere.thickness_nm(place[:, 1]))[inner].max() < 30.0  # 600 nm over 40 pixels or so
    assert np.median(np.abs(thickness - sphere.thickness_nm(place[:, 1]))[inner]) < 6.0
    assert np.abs(normals - normal)[inner].max() < 0.1
