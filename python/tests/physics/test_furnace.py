"""White furnace: in a uniform light of radiance 1 a film that takes nothing away must be invisible.

Every lossless film reflects R and passes 1 - R at each wavelength and polarisation, so whatever the branches do, the
light towards the camera is that of the surroundings: Y = 1 and the chromaticity of D65 in every pixel, limb included.
"""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from oracles import spectra
from oracles.comparison import report
from oracles.film_sphere import FilmSphere, picture
from physics.scenes import scene

FURNACE = {"illuminant": "D65", "radiance": 1.0}
LIMIT = 1e-4
# The sphere fills the view but for its corners, so that the limb passes through many pixels.
AROUND = {"position": [0.0, 0.4, 4.0], "target": [0.0, 0.0, 0.0], "fov_deg": 30.0, "resolution": [40, 40]}
# The limb alone, magnified: 2 degrees across its uppermost point, where angles run from 75 to 90 degrees.
LIMB = {"position": [0.0, 0.0, 4.0], "target": [0.0, 0.9682458, 0.25], "fov_deg": 2.0, "resolution": [24, 24]}
WITHIN = {"position": [0.5, -0.3, 0.2], "target": [-1.0, 0.2, 0.3], "fov_deg": 90.0, "resolution": [32, 32]}
PARALLEL = {"position": [3.0, 1.0, 2.0], "target": [0.0, 0.0, 0.0], "orthographic_height": 2.1, "resolution": [40, 40]}


def worst(spheres, camera, *, samples=4, max_depth=16, seed=1):
    """The largest |XYZ - white|, white scaled to Y = 1."""
    xyz = ir.render(scene(spheres, camera, FURNACE, samples=samples, max_depth=max_depth, seed=seed)).xyz
    assert np.isfinite(xyz).all()
    return np.abs(xyz - spectra.xyz_weights().sum(axis=0)).max(axis=(0, 1)), xyz


@pytest.mark.parametrize("index", [1.0001, 1.33, 1.6, 2.0, 2.4])
@pytest.mark.parametrize(
    "thickness_nm", [(0.0, 0.0), (3.0, 3.0), (100.0, 100.0), (0.0, 1000.0), (777.0, 777.0), (0.0, 5000.0)]
)
def test_any_index_and_thickness(index, thickness_nm):
    error, xyz = worst([FilmSphere(index, *thickness_nm)], AROUND)
    assert np.abs(xyz[..., 1] - 1.0).max() <= LIMIT
    # X and Z lean on the same weights; 2e-4 leaves room for the renderer's own sum over wavelengths
    assert error.max() <= 2e-4, error


@pytest.mark.parametrize("camera", [LIMB, WITHIN, PARALLEL], ids=["limb", "within", "parallel"])
@pytest.mark.parametrize("index", [1.33, 2.4])
@pytest.mark.parametrize("max_depth", [1, 2, 3, 16])
def test_every_view_and_depth(camera, index, max_depth):
    _, xyz = worst([FilmSphere(index, 50.0, 900.0)], camera, max_depth=max_depth)
    assert np.abs(xyz[..., 1] - 1.0).max() <= LIMIT


@pytest.mark.parametrize("max_depth", [1, 2, 16])
def test_two_spheres(max_depth):
    """One beside the other and one cut by it: light runs between them in every plane of incidence."""
    beside = [FilmSphere(1.33, 0.0, 900.0), FilmSphere(1.8, 200.0, 500.0, center=(0.7, 0.4, -1.9))]
    cut = [FilmSphere(2.4, 150.0, 150.0), FilmSphere(1.5, 0.0, 600.0, center=(0.5, 0.3, 0.6), radius=0.8)]
    for spheres in (beside, cut):
        _, xyz = worst(spheres, {**AROUND, "resolution": [24, 24]}, max_depth=max_depth)
        assert np.abs(xyz[..., 1] - 1.0).max() <= LIMIT


def test_a_film_of_the_medium_around_it_is_not_there():
    """Index 1 in air: no light is turned, whatever the thickness."""
    _, xyz = worst([FilmSphere(1.0, 0.0, 5000.0)], AROUND)
    assert np.abs(xyz[..., 1] - 1.0).max() <= 2e-6


@pytest.mark.parametrize(("index", "thickness_nm"), [(0.4 + 2.4j, 20.0), (1.5 + 0.01j, 500.0), (3.0 + 2.0j, 5.0)])
def test_an_absorbing_film_darkens_as_computed(index, thickness_nm):
    sphere = FilmSphere(index, thickness_nm, thickness_nm)
    camera = {**AROUND, "resolution": [24, 24]}
    wanted = picture(sphere, camera, 1.0)
    got = ir.render(scene([sphere], camera, FURNACE, samples=1024)).xyz
    seen = wanted[..., 1] < 0.99  # more than a sliver of the sphere
    assert seen.mean() > 0.5
    assert (got[..., 1] <= 1.0 + LIMIT).all()
    assert (got[..., 1][seen] < 1.0).all()
    error = np.abs(got - wanted).max(axis=-1)
    assert np.mean(error <= 0.003) >= 0.99, report(got, wanted, 0.003)


@pytest.mark.parametrize("radiance", [1e-6, 1.0, 1e6])
def test_radiance_is_a_plain_factor(radiance):
    tree = scene(
        [FilmSphere(1.33, 0.0, 900.0)], {**AROUND, "resolution": [16, 16]}, {**FURNACE, "radiance": radiance}, samples=4
    )
    xyz = ir.render(tree).xyz
    assert np.abs(xyz[..., 1] / radiance - 1.0).max() <= LIMIT


@pytest.mark.parametrize(("index", "thickness_nm"), [(1.8 + 0.05j, 50.0), (1.8 + 0.05j, 100.0), (0.4 + 2.4j, 20.0)])
def test_what_an_absorbing_sphere_keeps_is_not_handed_back(index, thickness_nm):
    """Light caught between absorbing walls is lost: closing its path as if the film took nothing would brighten it."""
    sphere = FilmSphere(index, thickness_nm, thickness_nm)
    for y in (0.0, 0.5, 0.8):
        place = [0.0, y, float(np.sqrt(1.0 - y * y))]
        camera = {"position": [0.0, 0.0, 4.0], "target": place, "fov_deg": 0.001, "resolution": [1, 1]}
        wanted = picture(sphere, camera, 1.0, points=1)[0, 0]
        got = ir.render(scene([sphere], camera, FURNACE, samples=4096)).xyz[0, 0]
        assert got == pytest.approx(wanted, abs=2e-4)
