"""The thin lens's circle of confusion, and Newton's rings measured in the picture."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from physics.scenes import DARK, build, coating, dielectric, diffuse, disk, emitter, lit, plane, view

# ---- the thin lens ------------------------------------------------------------------------------------------------------


def spot(lamp_radius, distance, lens, width, pixels=48, samples=256, projection="fov_deg"):
    """(Y, x, y) of a lamp straight ahead; x and y are places on the lamp's own plane that pixels look at."""
    extent = {"orthographic_height": width}
    if projection == "fov_deg":
        extent = {"fov_deg": float(np.degrees(2.0 * np.arctan(0.5 * width / distance)))}
    camera = view([0, 0, 0], [0, 0, -1], (pixels, pixels), **extent, **lens)
    lamp = disk([0, 0, -distance], [0, 0, 1], lamp_radius, emitter(1.0))
    y = ir.render(build([lamp], camera, [DARK], samples=samples)).xyz[..., 1].astype(np.float64)
    place = width * ((np.arange(pixels) + 0.5) / pixels - 0.5)
    return y, place[None, :] * np.ones((pixels, 1)), -place[:, None] * np.ones((1, pixels))


@pytest.mark.parametrize("projection", ["fov_deg", "orthographic_height"])
@pytest.mark.parametrize(("distance", "focus"), [(10.0, 6.0), (10.0, 15.0), (10.0, 9.0)])
def test_the_circle_of_confusion(distance, focus, projection):
    """Rays of a pixel spread over a disk of radius a |D - F| / F at the distance D, evenly."""
    aperture, lamp = 0.4, 0.05 if abs(distance - focus) > 2.0 else 0.012
    radius = aperture * abs(distance - focus) / focus
    lens = {"aperture_radius": aperture, "focus_distance": focus}
    width = 2.6 * (radius + lamp)
    y, px, py = spot(lamp, distance, lens, width, projection=projection)
    pixel = (width / len(y)) ** 2
    assert y.sum() * pixel == pytest.approx(np.pi * lamp**2, rel=0.01)  # light is spread, not lost
    r2 = px**2 + py**2
    # an even disk has <r^2> = radius^2 / 2; the lamp's own disk and the pixel's square add theirs
    wanted = radius**2 / 2.0 + lamp**2 / 2.0 + pixel / 6.0
    assert (y * r2).sum() / y.sum() == pytest.approx(wanted, rel=0.02)
    assert abs((y * px).sum() / y.sum()) < 0.01 * radius and abs((y * py).sum() / y.sum()) < 0.01 * radius
    inside, outside = r2 < (radius - 1.6 * lamp) ** 2, r2 > (radius + 1.6 * lamp) ** 2
    if inside.sum() > 20:
        assert y[inside].mean() == pytest.approx((lamp / radius) ** 2, rel=0.05)
    assert (y[outside] == 0.0).all()


@pytest.mark.parametrize("projection", ["fov_deg", "orthographic_height"])
def test_what_is_in_focus_is_sharp(projection):
    """In the plane of focus, which is flat, a lens changes nothing, off the axis as little as on it."""
    lens = {"aperture_radius": 0.4, "focus_distance": 10.0}
    y, px, py = spot(1.0, 10.0, lens, 3.0, samples=16, projection=projection)
    pinhole, _, _ = spot(1.0, 10.0, {}, 3.0, samples=16, projection=projection)
    rim = np.abs(np.hypot(px, py) - 1.0) < 3.0 / 48
    assert y[~rim] == pytest.approx(pinhole[~rim], abs=1e-6)
    assert y.sum() == pytest.approx(pinhole.sum(), rel=2e-3)


def test_a_lens_looks_at_all_of_it_alike():
    """Half of the lens is covered: what lies far behind the focus is half as bright, whichever half it is."""
    for side in (-1.0, 1.0):
        cover = {"shape": {"rectangle": {"center": [side * 0.5, 0, -0.1], "u": [0.5, 0, 0], "v": [0, 1, 0]}}}
        cover["surface"] = diffuse(0.0)
        far = plane([0, 0, -100], [0, 0, 1], emitter(1.0))
        lens = {"aperture_radius": 0.4, "focus_distance": 1e6}
        camera = view([0, 0, 0], [0, 0, -1], (1, 1), fov_deg=1e-4, **lens)
        y = ir.render(build([cover, far], camera, [DARK], samples=4096)).xyz[0, 0, 1]
        assert y == pytest.approx(0.5, abs=2e-3)


# ---- Newton's rings -----------------------------------------------------------------------------------------------------

RADIUS_MM = 1000.0


def row_of_rings(lamp, x_from, x_to, pixels, samples=16):
    """(x of pixel centres in mm, Y) along one row through the contact; N-BK7 above and below an air gap."""
    gap = {"lens_gap": {"radius_mm": RADIUS_MM}}
    objects = [
        plane([0, 1, 0], [0, 1, 0], dielectric("N-BK7")),
        disk([0, 0, 0], [0, 1, 0], 30.0, coating([("air", gap)], "N-BK7")),
        plane([0, -1, 0], [0, 1, 0], diffuse(0.0)),
    ]
    pixel = (x_to - x_from) / pixels
    middle = 0.5 * (x_from + x_to)
    camera = view([middle, 5, 0], [middle, 0, 0], (pixels, 1), orthographic_height=pixel, up=[0, 0, -1])
    y = ir.render(build(objects, camera, [lit(lamp)], samples=samples, unit="mm")).xyz[0, :, 1]
    return x_from + pixel * (np.arange(pixels) + 0.5), y.astype(np.float64)


def test_dark_rings_lie_at_the_root_of_m_lambda_r():
    """Ten rings on both sides in a view 512 pixels wide, found as minima of a parabola in r^2."""
    pixels, nm = 512, 589.3
    x, y = row_of_rings(f"lines:{nm}", -3.0, 3.0, pixels, samples=64)
    per_ring = nm * 1e-6 * RADIUS_MM  # r^2 from ring to ring, mm^2
    worst = 0.0
    for side in (-1, 1):
        for m in range(1, 11):
            near = (np.sign(x) == side) & (np.abs(x**2 / per_ring - m) < 0.3)
            curve = np.polyfit(x[near] ** 2 - m * per_ring, y[near], 4)
            r2 = m * per_ring + min(np.roots(np.polyder(curve)), key=abs).real
            worst = max(worst, abs(np.sqrt(r2) - np.sqrt(m * per_ring)) / (6.0 / pixels))
    assert worst < 0.1, worst
    # at the contact the gap is black but for the cover's own reflection
    assert y[np.abs(x) < 0.1].min() < 0.5 * y.max()


def modulation(order, lamp, harmonic=1, rings=4, pixels=256):
    """Amplitude over mean of Y in r^2 at a whole multiple of the ring frequency, over some rings around an order."""
    per_ring = 589.3e-6 * RADIUS_MM
    x_from, x_to = np.sqrt(per_ring * (order - rings / 2)), np.sqrt(per_ring * (order + rings / 2))
    x, y = row_of_rings(lamp, x_from, x_to, pixels, samples=64)
    area = np.diff(np.linspace(x_from, x_to, pixels + 1) ** 2)
    wave = np.exp(2j * np.pi * harmonic * x**2 / per_ring)
    return 2.0 * abs((y * area * wave).sum()) / (y * area).sum()


def test_two_sodium_lines_lose_their_rings_and_find_them_again():
    """Equal lines 0.597 nm apart: nothing is left of the rings near order 493, all of them near 986.

    Where they vanish a faint pattern of twice their number stays: the second harmonic of many beams, which two lines half
    an order apart bring back in step.
    """
    sodium, single = "lines:588.995,589.592", "lines:589.2935"
    beat = 589.2935 / 0.597  # 987
    full = modulation(20.0, sodium)
    assert full > 0.5
    assert modulation(493.0, sodium) < 0.01 * full
    assert modulation(986.0, sodium) > 0.99 * full
    for share in (0.1, 0.25, 0.75):
        wanted = full * abs(np.cos(np.pi * share))
        assert modulation(share * beat, sodium) == pytest.approx(wanted, rel=0.02), share
    assert modulation(493.0, single) > 0.99 * full  # one line alone keeps them
    assert modulation(493.0, sodium, 2) == pytest.approx(modulation(20.0, sodium, 2), rel=0.02)
