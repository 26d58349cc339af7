"""Rough surfaces: the white furnace from both sides, what a rough film passes, and a rough mirror against the sum over its
normals.

What is tested of the facets alone (normalisation, chi-square, reciprocity) stands in ``crates/render/src/microfacet.rs``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import iridesce as ir
from oracles import environment
from physics.scenes import (
    WHITE,
    coating,
    dielectric,
    diffuse,
    disk,
    emitter,
    film,
    lit,
    metal,
    plane,
    sphere,
    view,
)

ROUGHNESSES: list[Any] = [0.1, 0.3, 0.6, 1.0, [0.2, 0.7]]
#: A mirror that takes away 5e-6 of the light: R = ((1 - n)^2 + k^2) / ((1 + n)^2 + k^2).
MIRROR = [2e-6, 1.0]


def rough(surface: dict[str, Any], roughness: Any) -> dict[str, Any]:
    ((kind, table),) = surface.items()
    return {kind: {**table, "roughness": roughness}}


def shot(camera: dict[str, Any], objects: list[Any], lights: list[Any], samples: int = 16, seed: int = 1) -> Any:
    """XYZ of every pixel."""
    render = {"samples": samples, "seed": seed}
    return ir.render({"version": 1, "camera": camera, "render": render, "object": objects, "light": lights}).xyz


def mean_and_error(values: Any) -> tuple[float, float]:
    return float(values.mean()), float(values.std() / np.sqrt(values.size))


SURFACES = {
    "film": film(1.33, 430.0),
    "coating": coating([(2.3, 60.0), (1.38, 95.0)], 1.5),
    "dielectric": dielectric(1.5),
    "metal": metal(MIRROR),
}


# ---- white furnace ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("roughness", ROUGHNESSES, ids=str)
@pytest.mark.parametrize("kind", SURFACES)
@pytest.mark.parametrize("side", ["outside", "inside"])
def test_furnace(kind, roughness, side):
    """Nothing is taken away, so nothing is seen: from outside over all angles, limb included, and from within."""
    surface = rough(SURFACES[kind], roughness)
    ball = sphere([0.0] * 3, 1.0, surface)
    if side == "outside":
        camera, objects = view([0.0, 0.0, 4.0], [0.0] * 3, (24, 24), orthographic_height=2.0), [ball]
    elif kind == "metal":
        # From within nothing would ever be seen: the back of a thin piece of it.
        camera, objects = (
            view([0.0, 2.0, 4.0], [0.0] * 3, (24, 24), fov_deg=20.0),
            [disk([0.0] * 3, [0, 0, -1], 2.0, surface)],
        )
    else:
        camera, objects = view([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], (24, 24), fov_deg=90.0), [ball]
    lights = [WHITE]
    white = shot(camera, objects, lights)
    assert np.isfinite(white).all()
    mean, error = mean_and_error(white[..., 1])
    # Where a walk chooses between mirrored and refracted light, Y hangs on the choice only where the odds are clamped.
    assert error < 1e-3 and abs(mean - 1.0) < 1e-3, (mean, error)
    # Colours do: they are white within their noise.
    for channel, wanted in ((0, 0.95047), (2, 1.08883)):
        mean, error = mean_and_error(white[..., channel])
        assert abs(mean - wanted) < 4.5 * error + 1e-4, (channel, mean, error)


# ---- reciprocity ------------------------------------------------------------------------------------------------------


def towards(angle_deg: float, azimuth_deg: float) -> Any:
    angle, azimuth = np.radians([angle_deg, azimuth_deg])
    return np.array([np.sin(angle) * np.cos(azimuth), np.cos(angle), np.sin(angle) * np.sin(azimuth)])


@pytest.mark.parametrize("roughness", ROUGHNESSES, ids=str)
@pytest.mark.parametrize("kind", [*SURFACES, "dielectric from within"])
def test_reciprocity(kind, roughness):
    """Camera and a small lamp change places over a rough ground: L / cos of the lamp's angle is the same, all bounces counted.

    Through the ground n^2 comes in: f(in, out) / n_out^2 = f(out, in) / n_in^2 (Veach, thesis, 5.2), and since L / n^2 is what
    rays carry, a lamp within glass has n^2 of its stated radiance. The lamp is so small that over it the lobe is a plane within
    1e-3; the two stand 0.7 alpha off the mirror's (or the bent) direction.
    """
    index = 1.5
    through = kind == "dielectric from within"
    surface = rough(SURFACES[kind.split()[0]], roughness)
    ground = plane([0.0] * 3, [0.0, 1.0, 0.0], surface)
    least, alpha = float(np.min(roughness)) ** 2, float(np.max(roughness)) ** 2
    tilt, turn = np.degrees(0.7 * alpha), np.degrees(least)
    first, second = towards(40.0, 90.0), towards(40.0 + tilt, 270.0 - turn)
    if through:
        bent = np.degrees(np.arcsin(np.sin(np.radians(40.0)) / index))
        second = -towards(bent + 0.3 * tilt, 90.0 - 0.3 * turn)
    factor = index**2 if through else 1.0
    there_and_back(ground, first, second, 1.2 * least, lambda eye: factor if eye[1] < 0 else 1.0)


def there_and_back(ground: Any, first: Any, second: Any, radius: float, factor: Any) -> None:
    """L / cos of the lamp's angle both ways, with the ``factor`` of where the camera is; the lamp is a disk 40 away."""
    found = []
    for eye, light in ((first, second), (second, first)):
        lamp = disk(list(40.0 * light), list(-light), radius, emitter(1.0))
        camera = view(list(5.0 * eye), [0.0] * 3, (16, 16), orthographic_height=0.01, up=[1.0, 0.0, 0.0])
        seen = shot(camera, [ground, lamp], [lit("D65", 0.0)], 48)[..., 1]
        mean, error = mean_and_error(seen)
        found.append(np.array([mean, error]) / abs(light[1]) * factor(eye))
    (there, there_error), (back, back_error) = found
    assert there > 0 and there_error < 0.05 * there, "enough light to tell"
    assert abs(there - back) < 4.5 * np.hypot(there_error, back_error) + 2e-3 * there, found


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_matt_surface_is_reciprocal_and_hides_in_a_furnace(side):
    """From its front and its back: it reflects to both."""
    matt = diffuse(1.0)
    ground = plane([0.0] * 3, [0.0, side, 0.0], matt)
    for tilt, turn in ((20.0, 30.0), (75.0, 100.0)):
        there_and_back(ground, towards(40.0, 90.0), towards(tilt, 270.0 - turn), 0.3, lambda eye: 1.0)
    camera = view([0.0, 2.0, 4.0], [0.0] * 3, (24, 24), fov_deg=20.0)
    for thing in (sphere([0.0] * 3, 1.0, matt), disk([0.0] * 3, [0, 0, side], 2.0, matt)):
        white = shot(camera, [thing], [WHITE])
        for channel, wanted in enumerate((0.95047, 1.0, 1.08883)):
            mean, error = mean_and_error(white[..., channel])
            assert error < 1e-3 and abs(mean - wanted) < 1e-3, (channel, mean, error)


# ---- what a rough film passes -----------------------------------------------------------------------------------------


def seen_normals(alpha: float, towards: Any, count: int = 400) -> tuple[Any, Any]:
    """Normals and their shares among those seen from a direction, by quadrature over stretched slopes (GGX)."""
    t = (np.arange(count) + 0.5) / count
    phi = (np.arange(count) + 0.5) / count * 2 * np.pi
    t, phi = (grid.ravel() for grid in np.meshgrid(t, phi))
    slope = alpha * np.sqrt(1 / t**2 - 1)
    h = np.stack([slope * np.cos(phi), slope * np.sin(phi), np.ones_like(t)], axis=-1)
    cos = 1 / np.linalg.norm(h, axis=-1)
    h *= cos[:, None]
    # D cos dOmega = 2 t dt dphi / (2 pi); seen: max(w . h, 0) D / sigma.
    weight = 2 * t * np.maximum(h @ np.asarray(towards), 0.0) / cos
    return h, weight / weight.sum()


@pytest.mark.parametrize("angle_deg", [0.0, 40.0])
@pytest.mark.parametrize("seen_by", ["camera", "floor"])
def test_a_rough_film_passes_the_mean_over_the_facets_seen(angle_deg, seen_by):
    """A lamp straight behind a film of roughness 0.3: what a second facet passes is less than 2e-3 of it here.

    The camera comes through the film to the lamp; or it sees a matt floor that the lamp lights through it.
    """
    index, thickness_nm, roughness = 1.5, 380.0, 0.3
    angle = np.radians(angle_deg)
    towards = np.array([np.sin(angle), 0.0, np.cos(angle)])
    h, share = seen_normals(roughness**2, towards)
    angles = np.degrees(np.arccos(np.clip(h @ towards, 0, 1)))
    grid = np.linspace(0.0, 89.9, 300)
    stack = ir.Stack(["air", ir.Layer(index, thickness_nm), "air"])
    y = np.array([stack.color(angle_deg=float(a), quantity="transmittance")[1] for a in grid])
    expected = float(np.interp(angles, grid, y) @ share)
    sheet = disk([0.0] * 3, [0, 0, 1], 3.0, rough(film(index, thickness_nm), roughness))
    lamp = disk(list(-40.0 * towards), list(towards), 0.5, emitter(1.0))
    dark = [lit("D65", 0.0)]
    if seen_by == "camera":
        camera = view(list(5.0 * towards), [0.0] * 3, (16, 16), orthographic_height=0.2)
        seen = shot(camera, [sheet, lamp], dark, 64)[..., 1]
    else:
        # The floor faces the lamp, 6 in front of the film; the camera looks at it from between them.
        side = np.array([0.0, 1.0, 0.0])
        floor = disk(list(6.0 * towards), list(-towards), 0.5, diffuse(0.8))
        camera = view(list(5.5 * towards + 0.7 * side), list(6.0 * towards), (16, 16), orthographic_height=0.01)
        bare = shot(camera, [floor, lamp], dark, 64)[..., 1].mean()
        seen = shot(camera, [floor, sheet, lamp], dark, 64)[..., 1] / bare
    mean, error = mean_and_error(seen)
    assert mean == pytest.approx(expected, abs=4 * error + 2e-3), (mean, error, expected)


@pytest.mark.parametrize("thickness_nm", [40_000.0, 40_075.0, 40_175.0])
def test_a_lobe_that_spans_many_fringes_shows_their_mean_over_its_facets(thickness_nm):
    """40 um in the light of one line at 40 degrees: a smooth film shows one place of a fringe, facets of alpha 0.09 a dozen.

    Facets are drawn at random; their mean is that of the exact film over all that are seen, here by quadrature.
    """
    index, roughness, nm = 1.5, 0.3, 550.0
    angle = np.radians(40.0)
    eye = np.array([np.sin(angle), 0.0, np.cos(angle)])
    h, share = seen_normals(roughness**2, eye, 1000)
    cosine = np.clip(h @ eye, 0.0, 1.0)
    stack = ir.Stack(["air", ir.Layer(index, thickness_nm), "air"])
    grid = np.linspace(0.0, 89.99, 40_000)
    expected = float(np.interp(np.degrees(np.arccos(cosine)), grid, stack.transmittance(nm, grid)) @ share)
    orders = 2.0 * thickness_nm / nm * np.sqrt(index**2 - 1.0 + np.quantile(cosine, [0.05, 0.95]) ** 2)
    assert np.ptp(orders) > 10
    lamp = disk(list(-40.0 * eye), list(eye), 0.5, emitter(1.0, f"lines:{nm}*1"))
    camera = view(list(5.0 * eye), [0.0] * 3, (24, 24), orthographic_height=0.2)

    def seen(*surfaces: Any) -> Any:
        sheets = [disk([0.0] * 3, [0, 0, 1], 3.0, surface) for surface in surfaces]
        return shot(camera, [*sheets, lamp], [lit("D65", 0.0)], 64)[..., 1]

    bare = seen().mean()
    mean, error = mean_and_error(seen(rough(film(index, thickness_nm), roughness)) / bare)
    # (What a second facet passes is less than 2e-3.)
    assert error < 1e-3 and mean == pytest.approx(expected, abs=4.0 * error + 2e-3), (mean, error, expected)
    smooth = seen(film(index, thickness_nm)).mean() / bare
    assert smooth == pytest.approx(float(stack.transmittance(nm, 40.0)), abs=2e-3)
    assert abs(smooth - expected) > 0.02, "one facet alone would show another"


# ---- against another renderer -----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("alpha", [0.04, 0.1])
def test_a_rough_metal_is_that_of_mitsuba(alpha):
    """A ball of n + ik = 0.5 + 3i under a round lamp, against Mitsuba's ``roughconductor`` (GGX, unpolarised).

    Mitsuba loses what a second facet would mirror: at these alphas less than 0.4 % of the light that is mirrored once.
    """
    mitsuba: Any = pytest.importorskip("mitsuba")
    mitsuba.set_variant("scalar_rgb")
    size, height = 24, 2.2
    look = mitsuba.ScalarTransform4f().look_at(origin=[0, 0, 6], target=[0, 0, 0], up=[0, 1, 0])
    peer = mitsuba.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 3},
            "sensor": {
                "type": "orthographic",
                "to_world": look @ mitsuba.ScalarTransform4f().scale([height / 2, height / 2, 1]),
                "film": {
                    "type": "hdrfilm",
                    "width": size,
                    "height": size,
                    "rfilter": {"type": "box"},
                    "component_format": "float32",
                },
                "sampler": {"type": "independent", "sample_count": 512},
            },
            "ball": {
                "type": "sphere",
                "bsdf": {"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "eta": 0.5, "k": 3.0},
            },
            "lamp": {
                "type": "sphere",
                "center": [0, 4, 3],
                "radius": 1.0,
                "emitter": {"type": "area", "radiance": 1.0},
            },
        }
    )
    theirs = np.array([np.array(mitsuba.render(peer, seed=seed))[..., 1] for seed in range(4)])
    camera = view([0.0, 0.0, 6.0], [0.0] * 3, (size, size), orthographic_height=height)
    objects = [
        sphere([0.0] * 3, 1.0, rough(metal([0.5, 3.0]), float(np.sqrt(alpha)))),
        sphere([0.0, 4.0, 3.0], 1.0, emitter(1.0)),
    ]
    ours = np.array([shot(camera, objects, [lit("D65", 0.0)], 256, seed)[..., 1] for seed in range(1, 5)])
    # Left and right are alike; which way a picture runs does not matter then.
    difference = (ours.mean(0) - theirs.mean(0)).sum() / theirs.mean(0).sum()
    sums = [runs.sum((1, 2)) for runs in (ours, theirs)]
    noise = np.sqrt(sum(runs.var(ddof=1) / runs.size for runs in sums)) / theirs.mean(0).sum()
    assert noise < 0.02 and -4 * noise < difference < 4 * noise + 4e-3, (difference, noise)


# ---- light sampling ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("surface", ["metal", "dielectric"])
def test_a_bright_patch_of_a_map_is_looked_for(surface, tmp_path, monkeypatch):
    """A rough surface in a dark room with one window, which its own facets alone would seldom find."""
    monkeypatch.chdir(tmp_path)
    window = np.full((64, 128, 3), 0.05, dtype=np.float32)
    window[29:31, 6:8] = 40.0
    environment.write_exr(tmp_path / "window.exr", window)
    floor = disk((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 5.0, rough(SURFACES[surface], 0.45))
    camera = {"position": [0.0, 0.0, 4.0], "orthographic_height": 1e-3, "resolution": [32, 32]}
    y = shot(camera, [floor], [{"environment": {"map": "window.exr"}}], samples=4)[..., 1]
    assert y.std() < 0.5 * y.mean()


@pytest.mark.parametrize(("height", "texel"), [(512, (200, 300)), (512, (203, 302)), (2048, (800, 1200))], ids=str)
def test_a_sun_of_one_texel_gives_all_of_its_light(height, texel, tmp_path, monkeypatch):
    """What is between the middles of texels is looked up between them, so that 44 % of the light of one lie beyond its
    edges. Against a lamp from there with the irradiance radiance times solid angle, over a matt ball."""
    monkeypatch.chdir(tmp_path)
    width, (row, column) = 2 * height, texel
    sun = np.full((height, width, 3), 0.01, dtype=np.float32)
    sun[row, column] = 1e5 * (height / 512) ** 2
    environment.write_exr(tmp_path / "sun.exr", sun)
    ball, camera = sphere([0.0] * 3, 1.0, diffuse(0.5)), view([0.0, 0.5, 6.0], [0.0] * 3, (32, 32), fov_deg=22.0)
    theta, azimuth = np.pi * (row + 0.5) / height, 2.0 * np.pi * ((column + 0.5) / width - 0.5)
    towards_sun = [np.sin(theta) * np.sin(azimuth), np.cos(theta), -np.sin(theta) * np.cos(azimuth)]
    irradiance = float(sun[row, column, 0]) * 2.0 * np.pi / width * np.pi / height * np.sin(theta)
    lamp = {"directional": {"direction": towards_sun, "illuminant": "D65", "irradiance": irradiance}}
    told = shot(camera, [ball], [lamp, lit("D65", 0.01)], samples=64)[..., 1].mean()
    maps = [
        shot(camera, [ball], [{"environment": {"map": "sun.exr"}}], 64, seed)[..., 1].mean() for seed in range(1, 5)
    ]
    assert abs(np.mean(maps) / told - 1.0) < 0.01, (maps, told)


@pytest.mark.parametrize("roughness", [0.3, 0.6, 1.0, [0.2, 0.7]], ids=str)
def test_furnace_of_a_map(roughness, tmp_path, monkeypatch):
    """An opaque surface that takes nothing away is as bright as the map around it: by its own light, by that of two facets one
    after the other, of which maps are asked together, and by walks among more of them."""
    monkeypatch.chdir(tmp_path)
    environment.write_exr(tmp_path / "white.exr", np.ones((32, 64, 3), dtype=np.float32))
    camera = view([0.0, 0.0, 4.0], [0.0] * 3, (24, 24), orthographic_height=2.0)
    light = [{"environment": {"map": "white.exr"}}]
    white = shot(camera, [sphere([0.0, 0.0, 50.0], 1e-3, metal(MIRROR))], light)[0, 0]
    seen = shot(camera, [sphere([0.0] * 3, 1.5, rough(metal(MIRROR), roughness))], light, samples=1024)
    for channel in range(3):
        mean, error = mean_and_error(seen[..., channel] / white[channel])
        assert error < 1e-3 and abs(mean - 1.0) < 4.5 * error + 3e-4, (channel, mean, error)


@pytest.mark.parametrize("surface", ["metal", "coated"])
@pytest.mark.parametrize("roughness", [0.3, [0.5, 0.8]], ids=str)
def test_paths_that_part_bring_what_single_ones_do(surface, roughness, tmp_path, monkeypatch):
    """Where all light from far away is that of maps a rough surface sends several branches on, and asks the maps of two facets at
    once; beside a uniform light, here one that is as good as none, a single branch. With lamps of every kind, and objects that
    mirror each other."""
    monkeypatch.chdir(tmp_path)
    window = np.full((64, 128, 3), 0.05, dtype=np.float32)
    window[20:28, 60:70] = [30.0, 20.0, 10.0]
    window[34:38, 10:40] = [2.0, 6.0, 9.0]
    environment.write_exr(tmp_path / "window.exr", window)
    own = metal([0.2, 3.0]) if surface == "metal" else coating([("TiO2", 60.0)], "Ti")
    objects = [
        sphere([-0.9, 0.0, 0.0], 1.0, rough(own, roughness)),
        sphere([0.9, 0.0, 0.0], 0.8, rough(own, roughness)),
        disk([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], 3.0, rough(own, roughness)),
        sphere([0.0, 1.6, 0.6], 0.2, emitter(4.0)),
    ]
    camera = view([0.0, 0.5, 6.0], [0.0] * 3, (24, 16), fov_deg=30.0)
    lamps = [{"environment": {"map": "window.exr"}}, {"point": {"position": [2.0, 2.0, 2.0], "intensity": 2.0}}]
    pictures = [
        np.array([shot(camera, objects, lights, seed=seed) for seed in range(1, 17)])
        for lights in (lamps, [*lamps, lit("E", 1e-12)])
    ]
    several, one = (all_seeds.mean((1, 2)) for all_seeds in pictures)
    noise = np.sqrt((several.var(0, ddof=1) + one.var(0, ddof=1)) / len(one))
    difference = several.mean(0) - one.mean(0)
    assert (noise < 0.01 * one.mean(0)).all() and (np.abs(difference) < 4 * noise).all(), (difference, noise)
    # In bands of the picture, too.
    bands = [all_seeds.reshape(16, 4, 4, 4, 6, 3).mean((2, 4)) for all_seeds in pictures]
    spread = np.sqrt(sum(each.var(0, ddof=1) for each in bands) / 16)
    assert (np.abs(bands[0].mean(0) - bands[1].mean(0)) < 6 * spread).all()


# ---- fringes finer than the lobe --------------------------------------------------------------------------------------


@pytest.mark.parametrize("thickness", [3000.0, 10000.0])
def test_many_fringes_in_a_lobe_make_no_noise_of_colour(thickness):
    """Facets are drawn one by one. Where the lobe spans many fringes the spectrum of each spans them, too: under continuous light
    all of X, Y and Z are then as noisy as brightness alone is, and (Y over X, Z over X) what is left is little. At 300 nm, where
    fringes are as wide as the lobe, facets have colours."""

    def noise_of_colour(thickness: float) -> float:
        ball = sphere([0.0] * 3, 1.0, rough(coating([(1.5, thickness)], "Si"), 0.5))
        camera = view([0.0, 0.0, 4.0], [0.0] * 3, (32, 32), orthographic_height=1.6)
        xyz = np.array([shot(camera, [ball], [lit("E", 1.0)], 8, seed) for seed in range(1, 7)])
        seen = xyz[..., 1].min(0) > 0.0
        ratios = xyz[:, seen][..., [0, 2]] / xyz[:, seen][..., 1:2]
        return float((ratios.var(0, ddof=1) / ratios.mean(0) ** 2).mean())

    assert noise_of_colour(thickness) < 0.02 * noise_of_colour(300.0)


def seen_under_a_line(surface: dict[str, Any], lights: list[Any], samples: int, seeds: int) -> Any:
    """Y of every pixel on a ball, by seed."""
    camera = view([0.0, 0.0, 4.0], [0.0] * 3, (32, 32), orthographic_height=1.0)
    ball = sphere([0.0] * 3, 1.0, surface)
    return np.array([shot(camera, [ball], lights, samples, seed)[..., 1] for seed in range(1, seeds + 1)])


LINE = lit("lines:589.3", 1.0)


@pytest.mark.parametrize(("thickness", "roughness"), [(1e4, 0.5), (1e5, 0.5), (1e5, 0.2)])
def test_many_fringes_in_a_lobe_are_averaged_under_a_line(thickness, roughness):
    """A facet by itself shows one place of a fringe, and its light varies as R does over it (by 0.16 of the square of its mean).
    Sixteen of them together have a sixteenth of that; the rest is what angles do, and how often facets mirror twice."""
    lines = seen_under_a_line(rough(coating([(1.5, thickness)], "Si"), roughness), [LINE], 8, 8)
    nm = np.linspace(580.0, 600.0, 400)
    fringes = ir.Stack(["air", ir.Layer(1.5, 1e5), "Si"]).reflectance(nm)
    of_chance = float(fringes.var() / fringes.mean() ** 2)
    noise = 8 * float((lines.var(0, ddof=1) / lines.mean(0) ** 2).mean())
    assert of_chance > 0.1
    assert noise < 0.3 * of_chance, (noise, of_chance)


@pytest.mark.parametrize("roughness", [0.2, 0.5, [0.3, 0.8]], ids=str)
@pytest.mark.parametrize("lines", ["lines:589.3", "lines:435.8,546.1*2,640"])
@pytest.mark.parametrize("layers", [[(1.5, 900.0)], [(1.5, 6000.0)], [(2.3, 400.0), (1.38, 5000.0)]], ids=str)
def test_fringes_together_are_fringes_one_by_one(layers, lines, roughness):
    """A trace of white light, and facets are drawn one by one: the same mean, in X, Y and Z."""
    surface = rough(coating(layers, "Si"), roughness)
    camera = view([0.0, 0.0, 4.0], [0.0] * 3, (24, 24), orthographic_height=2.0)
    # Beside the camera, brighter than all around.
    lamp = sphere([2.0, 1.0, 3.0], 0.8, emitter(3.0, lines))
    together, apart = (
        np.array(
            [
                shot(camera, [sphere([0.0] * 3, 1.0, surface), lamp], [lit(lines, 1.0), *trace], 16, seed).mean((0, 1))
                for seed in range(1, 13)
            ]
        )
        for trace in ([], [lit("E", 1e-9)])
    )
    error = np.sqrt((together.var(0, ddof=1) + apart.var(0, ddof=1)) / 12)
    assert (np.abs(together.mean(0) - apart.mean(0)) < 4.5 * error).all(), (together.mean(0), apart.mean(0), error)
    assert (error < 2e-3 * apart.mean(0)).all()


@pytest.mark.parametrize("roughness", ROUGHNESSES, ids=str)
def test_furnace_of_fringes_under_a_line(roughness):
    """A clear layer on a mirror takes nothing away, however many fringes there are."""
    white = seen_under_a_line(rough(coating([(1.5, 7000.0)], MIRROR), roughness), [LINE], 16, 1)
    mean, error = mean_and_error(white)
    assert error < 1e-3 and abs(mean - 1.0) < 1e-3, (mean, error)
