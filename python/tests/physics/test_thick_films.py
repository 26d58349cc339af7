"""Films of many fringes: exact as long as a lamp shows them, their mean beyond, and in laser light to any thickness."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import iridesce as ir
from physics.scenes import build, film, lit, plane, view

N = 1.33
STILL = view([0, 0, 9], [0, 0, 0], (2, 2), orthographic_height=1.0)


def mirrored(thickness_nm: np.ndarray | float, nm: np.ndarray) -> np.ndarray:
    """R of a film in air, head on (Airy)."""
    r = ((N - 1.0) / (N + 1.0)) ** 2
    s = np.sin(2.0 * np.pi * N * np.asarray(thickness_nm) / nm) ** 2
    f = 4.0 * r / (1.0 - r) ** 2
    return f * s / (1.0 + f * s)


PHASE_MEAN = 1.0 - 1.0 / np.sqrt(1.0 + 4.0 * ((N - 1) / (N + 1)) ** 2 / (1.0 - ((N - 1) / (N + 1)) ** 2) ** 2)


@functools.cache
def weights(lamp: str) -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths 0.01 nm apart, finer than any fringe here, and X, Y, Z weights of a lamp of Y = 1."""
    nm = np.arange(360.0, 830.001, 0.01)
    xyz = ir.color.color_matching(nm) * ir.color.illuminant(lamp).power(nm)[:, None]
    return nm, xyz / xyz[:, 1].sum()


def seen(thickness_nm, lamp: str, camera=STILL, **render) -> np.ndarray:
    """The picture of what a film mirrors, before a black ground."""
    ground = plane([0, 0, -5], [0, 0, 1], {"diffuse": {"reflectance": 0.0}})
    sheet = plane([0, 0, 0], [0, 0, 1], film([N, 0.0], thickness_nm))
    return ir.render(build([sheet, ground], camera, [lit(lamp)], **{"samples": 1, **render})).xyz.astype(float)


def difference(a: np.ndarray, b: np.ndarray, lamp: str) -> float:
    """CIEDE2000, exposed so that the film's mean is half as bright as white, under its own lamp."""
    scale = 0.5 / PHASE_MEAN
    lab = [ir.color.convert(value * scale, "xyz", "lab", white=lamp) for value in (a, b)]
    return float(ir.color.delta_e(*lab))


@pytest.mark.parametrize("lamp", ["D65", "FL2", "FL11"])
@pytest.mark.parametrize("thickness_um", [31.0, 48.3, 97.1, 160.0, 333.0, 1000.0])
def test_colours_of_thick_films_are_those_of_a_fine_sum(lamp, thickness_um):
    nm, xyz = weights(lamp)
    wanted = mirrored(1e3 * thickness_um, nm) @ xyz
    assert difference(seen(1e3 * thickness_um, lamp)[0, 0], wanted, lamp) < 0.12


@pytest.mark.parametrize(("lamp", "from_pixel"), [("D65", 6), ("FL2", 20)])
def test_a_wedge_of_a_millimetre_shows_no_false_fringes(lamp, from_pixel):
    """0 to 1 mm over a hundred pixels: 45 fringes a pixel."""
    camera = view([0, 0, 9], [0, 0, 0], (100, 2), orthographic_height=0.02)
    wedge = {"wedge": {"from": [-0.5, 0, 0], "to": [0.5, 0, 0], "start_nm": 0.0, "end_nm": 1e6}}
    image = seen(wedge, lamp, camera, samples=4)
    white = weights(lamp)[1].sum(axis=0)
    np.testing.assert_allclose(
        image[:, from_pixel:], np.broadcast_to(PHASE_MEAN * white, image[:, from_pixel:].shape), rtol=2e-3
    )


def test_sodium_light_makes_noise_of_what_a_pixel_cannot_show_and_no_pattern():
    camera = view([0, 0, 9], [0, 0, 0], (100, 40), orthographic_height=0.4)
    wedge = {"wedge": {"from": [-0.5, 0, 0], "to": [0.5, 0, 0], "start_nm": 0.0, "end_nm": 1e6}}
    y = seen(wedge, "lines:589.0*2,589.592", camera, samples=4)[..., 1]
    columns = y.mean(axis=0) / PHASE_MEAN - 1.0
    # R of one wavelength spreads by 0.7 of its mean; of 160 samples a column.
    assert np.abs(columns).max() < 4.0 * 0.75 / np.sqrt(160.0)
    assert abs(y.mean() / PHASE_MEAN - 1.0) < 4.0 * 0.75 / np.sqrt(16000.0)


@pytest.mark.parametrize("thickness_nm", [1e6 + 12.0, 1e7, 1e7 - 50.0, 1e7 - 100.0])
def test_a_laser_sees_the_phase_of_ten_millimetres(thickness_nm):
    y = seen(thickness_nm, "lines:632.8")[..., 1]
    np.testing.assert_allclose(y, mirrored(thickness_nm, np.array(632.8)), atol=2e-6)
