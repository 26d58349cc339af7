"""What users ask other packages for, one test each; docs/guide/questions.md answers the same in words."""

from __future__ import annotations

from itertools import pairwise

import mpmath
import numpy as np
import pytest

import iridesce as ir


def test_opaque_tungsten_on_top_gives_no_nan() -> None:
    """100 um of tungsten over a coated glass: exp(2 x 3 300) would overflow; R is that of bulk tungsten and T is 0."""
    nm = np.linspace(300.0, 2000.0, 341)
    for thickness_nm in (1e4, 1e5, 1e9):
        stack = ir.Stack(["air", ir.Layer("W", thickness_nm), ir.Layer("SiO2", 100.0), "N-BK7"])
        for angle in (0.0, 60.0, 89.9):
            for polarization in ("s", "p", "unpolarized"):
                reflectance = stack.reflectance(nm, angle, polarization)
                bare = ir.Stack(["air", "W"]).reflectance(nm, angle, polarization)
                np.testing.assert_allclose(reflectance, bare, rtol=1e-13)
                transmittance = stack.transmittance(nm, angle, polarization)
                assert np.all((transmittance >= 0.0) & (transmittance < 1e-30))
                np.testing.assert_allclose(
                    stack.layer_absorptance(nm, angle, polarization).sum(axis=-1), 1.0 - reflectance, atol=1e-13
                )
    r, t = stack.amplitudes(nm, 0.0, "s")
    assert np.isfinite(r).all() and np.all(t == 0.0)
    assert np.isfinite(stack.ellipsometry(nm, 60.0)).all()
    assert np.isfinite(stack.derivatives("reflectance", nm, 60.0).thickness_nm).all()


@pytest.mark.parametrize("k", [3e-8, 1e-12, 1e-300])
@pytest.mark.parametrize("angle_deg", [0.0, 41.0, 42.0, 80.0])
@pytest.mark.parametrize("polarization", ["s", "p"])
def test_a_trace_of_absorption_in_the_last_medium(k: float, angle_deg: float, polarization: str) -> None:
    """k = 3e-8 below, also beyond the critical angle: R and T as with 50 digits, and as without it to the order of k."""
    stack = ir.Stack([1.5, ir.Layer(1.38, 250.0), complex(1.0, k)])
    with mpmath.workdps(50):
        n = [mpmath.mpf("1.5"), mpmath.mpf(1.38), mpmath.mpc(1.0, k)]
        n[0] = mpmath.mpf(1.5)
        along = n[0] * mpmath.sin(mpmath.radians(mpmath.mpf(angle_deg)))
        kz = [mpmath.sqrt(one * one - along * along) for one in n]
        kz = [-one if one.imag < 0 else one for one in kz]
        q = [a / (one * one) if polarization == "p" else a for a, one in zip(kz, n, strict=True)]
        turn = mpmath.exp(4j * mpmath.pi * kz[1] * 250 / 550)
        faces = [(a - b) / (a + b) for a, b in pairwise(q)]
        wanted = float(abs((faces[0] + faces[1] * turn) / (1 + faces[0] * faces[1] * turn)) ** 2)
    reflectance = stack.reflectance(550.0, angle_deg, polarization)
    transmittance = stack.transmittance(550.0, angle_deg, polarization)
    assert reflectance == pytest.approx(wanted, rel=1e-12)
    assert transmittance == pytest.approx(1.0 - reflectance, abs=1e-14)
    if angle_deg > 41.9:
        # What is left of total reflection is of the order of k.
        assert 0.0 <= transmittance < 100.0 * k + 1e-15


def test_transmittance_down_to_1e_300() -> None:
    """Silver of 30 um: T = 1e-300 and less, relative error as of 50 digits; below the smallest double it is 0, never NaN."""
    nm, n = 550.0, complex(0.06, 3.6)
    for thickness_nm in (100.0, 1000.0, 8000.0):
        with mpmath.workdps(60):
            index = mpmath.mpc(n.real, n.imag)
            phase = 2 * mpmath.pi * index * mpmath.mpf(thickness_nm) / nm
            top, bottom = (1 - index) / (1 + index), (index - mpmath.mpf(1.5)) / (index + mpmath.mpf(1.5))
            t = (2 / (1 + index)) * (2 * index / (index + mpmath.mpf(1.5))) * mpmath.exp(1j * phase)
            wanted = mpmath.mpf(1.5) * abs(t / (1 + top * bottom * mpmath.exp(2j * phase))) ** 2
        found = ir.Stack([1.0, ir.Layer(n, thickness_nm), 1.5]).transmittance(nm)
        assert found == pytest.approx(float(wanted), rel=1e-12)
    assert 1e-300 < float(ir.Stack([1.0, ir.Layer(n, 8380.0), 1.5]).transmittance(nm)) < 1e-298
    assert ir.Stack([1.0, ir.Layer(n, 20_000.0), 1.5]).transmittance(nm) == 0.0


@pytest.mark.parametrize("polarization", ["s", "p", "unpolarized"])
def test_splitting_a_layer_in_two_changes_nothing(polarization: str) -> None:
    nm, angle = np.linspace(400.0, 800.0, 101), np.linspace(0.0, 89.0, 24)[:, None]
    whole = ir.Stack(["air", ir.Layer("TiO2", 120.0), ir.Layer("Ag", 24.0), ir.Layer("SiO2", 300.0), "N-BK7"])
    for place in range(3):
        layers = list(whole.layers)
        medium, thickness_nm = layers[place].medium, float(layers[place].thickness_nm)
        layers[place : place + 1] = [ir.Layer(medium, 0.25 * thickness_nm), ir.Layer(medium, 0.75 * thickness_nm)]
        split = ir.Stack([whole.first, *layers, whole.last])
        for quantity in ("reflectance", "transmittance", "absorptance"):
            np.testing.assert_allclose(
                getattr(split, quantity)(nm, angle, polarization),
                getattr(whole, quantity)(nm, angle, polarization),
                rtol=0.0,
                atol=1e-13,
            )
        shares = split.layer_absorptance(nm, angle, polarization)
        np.testing.assert_allclose(
            shares[..., place] + shares[..., place + 1],
            whole.layer_absorptance(nm, angle, polarization)[..., place],
            atol=1e-13,
        )


@pytest.mark.parametrize("polarization", ["s", "p", "unpolarized"])
def test_beyond_the_critical_angle_in_incoherent_stacks(polarization: str) -> None:
    """A plate of glass in water under a prism, light beyond the critical angle of one of its faces."""
    prism = 1.7
    # Beyond the critical angle of the last face: all light comes back, whatever slab it crosses.
    plate = ir.Stack([prism, ir.Layer(1.5, 1e6, coherent=False), 1.0])
    angle = np.linspace(37.0, 61.0, 25)
    np.testing.assert_allclose(plate.reflectance(550.0, angle, polarization), 1.0, rtol=1e-14)
    np.testing.assert_array_equal(plate.transmittance(550.0, angle, polarization), 0.0)
    # Beyond that of the slab itself: no wave in it, however it is called.
    gap = ir.Stack([prism, ir.Layer(1.0, 1e6, coherent=False), prism])
    np.testing.assert_allclose(gap.reflectance(550.0, angle, polarization), 1.0, rtol=1e-14)
    assert np.all(gap.transmittance(550.0, angle, polarization) < 1e-300)
    # A gap narrower than the wavelength lets light tunnel, incoherent or not.
    narrow = [ir.Stack([prism, ir.Layer(1.0, 120.0, coherent=kind), prism]) for kind in (True, False)]
    tunnelled = narrow[1].transmittance(550.0, angle, polarization)
    np.testing.assert_allclose(tunnelled, narrow[0].transmittance(550.0, angle, polarization), rtol=1e-14)
    assert np.all((tunnelled > 0.01) & (tunnelled < 1.0))
    np.testing.assert_allclose(narrow[1].reflectance(550.0, angle, polarization) + tunnelled, 1.0, rtol=1e-14)
    # Below all critical angles: the two faces' sum by hand.
    faces = [ir.Stack([prism, 1.5]), ir.Stack([1.5, 1.0])]
    inside = np.degrees(np.arcsin(prism * np.sin(np.radians(20.0)) / 1.5))
    for one in ("s", "p"):
        a, b = faces[0].reflectance(550.0, 20.0, one), faces[1].reflectance(550.0, inside, one)
        wanted = a + (1.0 - a) ** 2 * b / (1.0 - a * b)
        assert plate.reflectance(550.0, 20.0, one) == pytest.approx(wanted, rel=1e-13)


def test_thin_absorbing_slabs_stay_within_energy() -> None:
    """A sum over bounces in a slab thinner than a radian that absorbs would diverge: it counts as coherent."""
    thickness_nm = np.geomspace(0.1, 1e5, 400)
    media = (1.5 + 1.2j, 0.3 + 0.29j, 1.8 + 1.7j)
    slabs = ir.Stack([1.0, *(ir.Layer(medium, thickness_nm, coherent=False) for medium in media), 2.0])
    for polarization in ("s", "p"):
        reflectance = slabs.reflectance(550.0, 60.0, polarization)
        transmittance = slabs.transmittance(550.0, 60.0, polarization)
        shares = slabs.layer_absorptance(550.0, 60.0, polarization)
        np.testing.assert_allclose(reflectance + transmittance + shares.sum(axis=-1), 1.0, atol=1e-12)
        assert np.all(reflectance < 1.0)
        derivatives = slabs.derivatives("reflectance", 550.0, 60.0, polarization)
        np.testing.assert_allclose(derivatives.value, reflectance, atol=1e-12)


def test_error_bars_on_colour() -> None:
    """A film of 320 +- 2 nm: the error bar is that of 4 000 such films, to 5 % (their own scatter is 1.1 %)."""
    film = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])
    told = film.color_uncertainty(2.0)
    sample = 320.0 + 2.0 * np.random.default_rng(1).standard_normal(4000)
    colors = ir.Stack(["air", ir.Layer("soap", sample), "air"]).color(space="lab")
    np.testing.assert_allclose(told.sd[1:], colors.std(axis=0)[1:], rtol=0.05)
    np.testing.assert_allclose(told.value, film.color(space="lab"), rtol=1e-13)
    assert told.covariance.shape == (3, 3)


def test_searching_materials_by_range() -> None:
    """Which built-in media are known over a range of wavelengths, and which of them are clear and of high index there?"""
    low, high = 400.0, 1000.0
    known = [
        name for name in ir.media() if name.range_nm is None or name.range_nm[0] <= low <= high <= name.range_nm[1]
    ]
    assert {"SiO2", "N-BK7", "vacuum", "Si"} <= set(known)
    assert "glycerol" not in known and "PMMA" not in known
    nm = np.linspace(low, high, 61)
    indices = {name: np.broadcast_to(ir.Medium(name).index(nm), nm.shape) for name in known}
    clear = [name for name, n in indices.items() if n.real.min() > 2.0 and n.imag.max() == 0.0]
    assert "diamond" in clear and "SiO2" not in clear and "Si" not in clear
    for name in known:
        assert np.isfinite(indices[name]).all()
    with pytest.raises(ValueError, match="has data for"):
        ir.Medium("glycerol").index(low)


def test_fringes_in_transmission() -> None:
    """A film on glass shows in transmission the fringes that it has in reflection, upside down; so does what it is fitted to."""
    nm = np.linspace(450.0, 1000.0, 551)
    film = ir.Stack(["air", ir.Layer(2.1, 900.0), 1.52])
    reflectance, transmittance = film.reflectance(nm), film.transmittance(nm)
    np.testing.assert_allclose(reflectance + transmittance, 1.0, atol=1e-14)
    peaks = np.flatnonzero((transmittance[1:-1] > transmittance[:-2]) & (transmittance[1:-1] > transmittance[2:])) + 1
    dips = np.flatnonzero((reflectance[1:-1] < reflectance[:-2]) & (reflectance[1:-1] < reflectance[2:])) + 1
    np.testing.assert_array_equal(peaks, dips)
    # A film of higher index than both sides passes most where it is half-waves thick: 2 n d = m lambda, to the grid.
    orders = 2.0 * 2.1 * 900.0 / nm[peaks]
    np.testing.assert_allclose(orders, np.round(orders), atol=0.01)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(nm.size)
    plate = ir.Stack(["air", ir.Layer("Ta2O5", 900.0), ir.Layer("N-BK7", 1e6, coherent=False), "air"])
    found = ir.fit_thickness(nm, plate.transmittance(nm) + noise, plate, layer="Ta2O5", quantity="transmittance")
    assert found.best.thickness_nm == pytest.approx(900.0, abs=0.5)
