"""Jones and Mueller matrices, fields and absorption against depth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import iridesce as ir

STACK = ir.Stack([1.3, ir.Layer(2.1 + 0.02j, 180.0), ir.Layer(0.06 + 3.6j, 25.0), ir.Layer(1.4, 300.0), 3.0 + 0.4j])
CLEAR = ir.Stack(["air", ir.Layer(2.3, 130.0), ir.Layer(1.46, 90.0), 1.5])


def stokes(e_s: complex, e_p: complex) -> np.ndarray:
    cross = 2.0 * e_s * np.conj(e_p)
    return np.array([abs(e_s) ** 2 + abs(e_p) ** 2, abs(e_s) ** 2 - abs(e_p) ** 2, cross.real, cross.imag])


def test_jones_is_the_amplitudes() -> None:
    wavelength_nm = np.array([450.0, 650.0])
    for direction, which in (("reflection", 0), ("transmission", 1)):
        found = STACK.jones(wavelength_nm, 40.0, direction)
        assert found.shape == (2, 2, 2)
        np.testing.assert_array_equal(found[:, 0, 0], STACK.amplitudes(wavelength_nm, 40.0, "s")[which])
        np.testing.assert_array_equal(found[:, 1, 1], STACK.amplitudes(wavelength_nm, 40.0, "p")[which])
        assert not found[:, 0, 1].any() and not found[:, 1, 0].any()


@pytest.mark.parametrize("direction", ["reflection", "transmission"])
def test_mueller_does_to_stokes_vectors_what_jones_does_to_fields(direction: str) -> None:
    jones, mueller = CLEAR.jones(520.0, 55.0, direction), CLEAR.mueller(520.0, 55.0, direction)
    power = CLEAR.reflectance if direction == "reflection" else CLEAR.transmittance
    r_s, r_p = jones[0, 0], jones[1, 1]
    flux = power(520.0, 55.0, "s") / abs(r_s) ** 2
    for e_s, e_p in ((1.0, 0.0), (0.0, 1.0), (0.6, 0.8j), (0.3 - 0.2j, 0.9 + 0.1j)):
        wanted = flux * stokes(r_s * e_s, r_p * e_p)
        np.testing.assert_allclose(mueller @ stokes(e_s, e_p), wanted, atol=1e-14)
    assert mueller[0, 0] == pytest.approx(power(520.0, 55.0), abs=1e-15)
    # A Mueller matrix that comes from a Jones matrix does not depolarise: trace(M M^T) = 4 M00^2.
    assert np.trace(mueller @ mueller.T) == pytest.approx(4.0 * mueller[0, 0] ** 2, rel=1e-13)


def test_a_mirror_turns_circular_light_round() -> None:
    mirror = ir.Stack(["air", "Ag"]).mueller(550.0)
    assert mirror[2, 2] == pytest.approx(-mirror[0, 0]) and mirror[3, 3] == pytest.approx(-mirror[0, 0])


def test_psi_and_delta_are_in_the_mueller_matrix() -> None:
    psi, delta = np.radians(STACK.ellipsometry(600.0, 65.0))
    m = STACK.mueller(600.0, 65.0) / STACK.mueller(600.0, 65.0)[0, 0]
    assert m[0, 1] == pytest.approx(np.cos(2.0 * psi), abs=1e-13)
    assert m[2, 2] == pytest.approx(np.sin(2.0 * psi) * np.cos(delta), abs=1e-13)
    # r_s conj(r_p) has the phase -delta.
    assert m[3, 2] == pytest.approx(-np.sin(2.0 * psi) * np.sin(delta), abs=1e-13)


def test_incoherent_slabs_depolarise_as_the_mean_over_their_phase() -> None:
    def plate(thickness_nm: float | np.ndarray, coherent: bool) -> ir.Stack:
        return ir.Stack(["air", ir.Layer(2.0, 80.0), ir.Layer(1.5 + 1e-7j, thickness_nm, coherent), 1.33])

    found = plate(1e5, coherent=False).mueller(550.0, 62.0)
    kz = np.sqrt(1.5**2 - np.sin(np.radians(62.0)) ** 2)
    turns = 1e5 + np.arange(4096) / 4096 * 550.0 / (2.0 * kz)
    np.testing.assert_allclose(found, plate(turns, coherent=True).mueller(550.0, 62.0).mean(axis=0), atol=2e-7)
    assert np.trace(found @ found.T) < 3.999 * found[0, 0] ** 2
    two = ir.Stack(["air", ir.Layer(1.5, 1e5, False), ir.Layer(1.4, 1e5, False), 1.33]).mueller(550.0, 40.0)
    assert two[0, 0] > 0.0
    with pytest.raises(ValueError, match="at most 2"):
        ir.Stack(["air", *[ir.Layer(1.5, 1e5, False)] * 3, 1.33]).mueller(550.0)


# --- fields


def gauss(f: Callable[[np.ndarray], np.ndarray], low: float, high: float) -> np.ndarray:
    nodes, weights = np.polynomial.legendre.leggauss(120)
    x = 0.5 * (high - low) * (nodes + 1.0) + low
    return 0.5 * (high - low) * (f(x) * weights).sum(axis=-1)


@pytest.mark.parametrize("polarization", ["s", "p"])
@pytest.mark.parametrize("angle_deg", [0.0, 48.0, 80.0])
def test_absorption_adds_up_to_the_layers(polarization: str, angle_deg: float) -> None:
    wavelength_nm = np.array([450.0, 550.0, 700.0])
    wanted = STACK.layer_absorptance(wavelength_nm, angle_deg, polarization)
    top = 0.0
    for number, layer in enumerate(STACK.layers):
        bottom = top + layer.thickness_nm
        found = gauss(
            lambda z: STACK.field_profile(z, wavelength_nm, angle_deg, polarization).absorbed_per_nm, top, bottom
        )
        np.testing.assert_allclose(found, wanted[:, number], atol=1e-12)
        top = bottom
    # What passes the last interface is absorbed behind it: exp decay to the end.
    below = gauss(
        lambda z: STACK.field_profile(top + z, wavelength_nm, angle_deg, polarization).absorbed_per_nm, 0.0, 4000.0
    )
    np.testing.assert_allclose(below, STACK.transmittance(wavelength_nm, angle_deg, polarization), rtol=1e-6)


@pytest.mark.parametrize("polarization", ["s", "p"])
def test_flux_is_the_poynting_vector_and_matches_r_and_t(polarization: str) -> None:
    depth_nm = np.array([-400.0, -1.0, 0.0, 90.0, 190.0, 300.0, 505.0, 600.0])
    found = STACK.field_profile(depth_nm, 600.0, 40.0, polarization)
    e, h = found.electric, found.magnetic
    incident = 1.3 * np.cos(np.radians(40.0))
    poynting = (np.cross(e, h.conj())[:, 2]).real / incident
    np.testing.assert_allclose(found.flux, poynting, atol=1e-14)
    assert found.flux[:3] == pytest.approx([1.0 - STACK.reflectance(600.0, 40.0, polarization)] * 3, abs=1e-13)
    last = ir.Stack([1.3, *STACK.layers, 3.0 + 0.4j]).field_profile([505.0], 600.0, 40.0, polarization)
    assert last.flux[0] == pytest.approx(STACK.transmittance(600.0, 40.0, polarization), abs=1e-13)


def test_fields_obey_maxwell() -> None:
    """i k x E = i H and i k x H = -i n^2 E, by differences along depth inside each layer."""
    for polarization in ("s", "p"):
        for z, index in ((-50.0, 1.3), (70.0, 2.1 + 0.02j), (190.0, 0.06 + 3.6j), (400.0, 1.4), (700.0, 3.0 + 0.4j)):
            h = 1e-2
            found = STACK.field_profile([z - h, z, z + h], 600.0, 40.0, polarization)
            k0, kx = 2.0 * np.pi / 600.0, 1.3 * np.sin(np.radians(40.0))
            e, b = found.electric, found.magnetic
            d_e, d_b = (e[2] - e[0]) / (2 * h * k0), (b[2] - b[0]) / (2 * h * k0)

            def curl(f: np.ndarray, d: np.ndarray, kx: float = kx) -> np.ndarray:
                return np.array([-d[1], d[0] - 1j * kx * f[2], 1j * kx * f[1]])

            np.testing.assert_allclose(curl(e[1], d_e), 1j * b[1], atol=2e-6)
            np.testing.assert_allclose(curl(b[1], d_b), -1j * index**2 * e[1], atol=2e-5)


def test_incident_light_is_of_unit_field() -> None:
    # Index-matched: only the incident wave, E_p = (-cos, 0, sin).
    found = ir.Stack([1.5, 1.5]).field_profile([-10.0, 0.0, 10.0], 500.0, 30.0, "p")
    np.testing.assert_allclose(found.squared, 1.0, atol=1e-14)
    np.testing.assert_allclose(found.electric[1], [-np.cos(np.pi / 6), 0.0, 0.5], atol=1e-14)


def test_shapes_and_refusals() -> None:
    found = STACK.field_profile(np.arange(5.0), [[500.0], [600.0]], [0.0, 30.0, 60.0])
    assert found.electric.shape == (2, 3, 5, 3) and found.flux.shape == (2, 3, 5)
    assert STACK.field_profile(3.0, 500.0).electric.shape == (1, 3)
    for arguments, message in (
        (([0.0], 500.0, 0.0, "unpolarized"), "polarization must be"),
        (([[0.0]], 500.0), "one axis"),
        (([float("nan")], 500.0), "depth_nm must be finite"),
    ):
        with pytest.raises(ValueError, match=message):
            STACK.field_profile(*arguments)
    with pytest.raises(ValueError, match="coherent"):
        ir.Stack(["air", ir.Layer(1.5, 1e5, False), "air"]).field_profile([0.0], 500.0)
    with pytest.raises(ValueError, match="direction must be"):
        STACK.jones(500.0, 0.0, "up")
