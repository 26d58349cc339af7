"""Layers whose index changes with depth against exact solutions, and rough faces."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import iridesce as ir


def exact(first: float, last: float, k0: float, thickness_nm: float, pair: object) -> tuple[float, float]:
    """R and T at normal incidence from two solutions of u'' + (k0 n)^2 u = 0: functions z -> (u, u')."""
    (u1, s1), (u2, s2) = (pair(z) for z in (mpmath.mpf(0), mpmath.mpf(thickness_nm)))  # type: ignore[operator]
    # Below: u = t exp(i k0 last (z - d)); above: exp(i k0 first z) + r exp(-i k0 first z). Two unknown weights of the pair.
    a, b = u2  # values of both solutions at the bottom
    c, d = s2
    i = mpmath.mpc(0, 1)
    # c1 u' = i k0 last u at the bottom, up to a factor
    w = (d - i * k0 * last * b, -(c - i * k0 * last * a))
    top, slope = w[0] * u1[0] + w[1] * u1[1], w[0] * s1[0] + w[1] * s1[1]
    r = (i * k0 * first * top - slope) / (i * k0 * first * top + slope)
    t = (w[0] * a + w[1] * b) * (1 + r) / top
    return float(abs(r) ** 2), float(last / mpmath.mpf(first) * abs(t) ** 2)


def exponential(top: float, bottom: float, k0: float, thickness_nm: float) -> object:
    """n = top exp(g z): Bessel functions of order 0 of k0 n/g."""
    g = mpmath.log(mpmath.mpf(bottom) / top) / thickness_nm

    def at(z: mpmath.mpf) -> tuple[tuple[mpmath.mpf, ...], tuple[mpmath.mpf, ...]]:
        x = k0 * top * mpmath.exp(g * z) / g
        return (mpmath.besselj(0, x), mpmath.bessely(0, x)), (
            -g * x * mpmath.besselj(1, x),
            -g * x * mpmath.bessely(1, x),
        )

    return at


def linear(top: float, bottom: float, k0: float, thickness_nm: float) -> object:
    """n^2 linear in z: Airy functions of -(k0/a)^(2/3) n^2, a the slope of n^2."""
    slope = (mpmath.mpf(bottom) ** 2 - mpmath.mpf(top) ** 2) / thickness_nm
    scale = (k0 / slope) ** (mpmath.mpf(2) / 3)

    def at(z: mpmath.mpf) -> tuple[tuple[mpmath.mpf, ...], tuple[mpmath.mpf, ...]]:
        x, turn = -scale * (mpmath.mpf(top) ** 2 + slope * z), -scale * slope
        return (mpmath.airyai(x), mpmath.airybi(x)), (
            turn * mpmath.airyai(x, derivative=1),
            turn * mpmath.airybi(x, derivative=1),
        )

    return at


@pytest.mark.parametrize("profile", ["exponential", "linear"])
@pytest.mark.parametrize(
    ("thickness_nm", "tolerance"), [(120.0, 1e-3), (120.0, 1e-5), (120.0, 1e-7), (2000.0, 1e-3), (2000.0, 1e-5)]
)
def test_slices_keep_the_tolerance(profile: str, tolerance: float, thickness_nm: float) -> None:
    top, bottom, nm = 1.38, 2.3, 550.0

    def n(z: float) -> float:
        share = z / thickness_nm
        if profile == "exponential":
            return top * (bottom / top) ** share
        return float(np.sqrt(top**2 + (bottom**2 - top**2) * share))

    layers = ir.Layer.graded(thickness_nm, n, wavelength_nm=nm, tolerance=tolerance)
    with mpmath.workdps(30):
        k0 = 2 * mpmath.pi / nm
        pair = (exponential if profile == "exponential" else linear)(top, bottom, k0, thickness_nm)
        for first, last in ((1.0, 1.5), (1.38, 2.3), (1.0, 4.0)):
            r, t = exact(first, last, k0, thickness_nm, pair)
            stack = ir.Stack([first, *layers, last])
            assert abs(stack.reflectance(nm) - r) < tolerance
            assert abs(stack.transmittance(nm) - t) < tolerance
            assert r + t == pytest.approx(1.0, abs=1e-14)
    assert sum(float(layer.thickness_nm) for layer in layers) == pytest.approx(thickness_nm, rel=1e-14)


def test_slices_err_as_their_square() -> None:
    counts = [len(ir.Layer.graded(400.0, 1.0, 1.5, tolerance=tolerance)) for tolerance in (1e-2, 1e-4, 1e-6)]
    assert counts[0] < counts[1] < counts[2] <= 1024
    assert (
        4 <= counts[2] / counts[1] <= 32
    )  # a hundredth of the error: ten times the slices, to a factor of two each way


def test_profile_of_two_media() -> None:
    """A constant profile is one layer of the mixture; the default runs from the first to the second."""
    mixed = ir.Medium.mixture("air", "SiO2", 0.3)
    layers = ir.Layer.graded(200.0, "air", "SiO2", lambda depth: 0.3)
    nm = np.linspace(400.0, 700.0, 31)
    np.testing.assert_allclose(
        ir.Stack(["air", *layers, "N-BK7"]).reflectance(nm, 40.0),
        ir.Stack(["air", ir.Layer(mixed, 200.0), "N-BK7"]).reflectance(nm, 40.0),
        rtol=0.0,
        atol=1e-14,
    )
    ramp = ir.Layer.graded(600.0, "air", "SiO2")
    n = [float(np.real(layer.medium.index(550.0))) for layer in ramp]
    assert n == sorted(n) and n[0] < 1.05 and n[-1] > 1.44
    # A soft transition of several wavelengths reflects next to nothing.
    assert ir.Stack(["air", *ir.Layer.graded(3000.0, "air", "SiO2"), "SiO2"]).reflectance(550.0) < 1e-4


def test_absorbing_profiles_and_arrays_of_thickness() -> None:
    layers = ir.Layer.graded(np.array([[50.0], [80.0]]), "SiO2", "Ag", tolerance=1e-4)
    stack = ir.Stack(["air", *layers, "Ag"])
    nm = np.linspace(400.0, 700.0, 7)
    reflectance = stack.reflectance(nm)
    assert reflectance.shape == (2, 7) and np.all((reflectance > 0.0) & (reflectance < 1.0))
    single = ir.Stack(["air", *ir.Layer.graded(80.0, "SiO2", "Ag", tolerance=1e-4), "Ag"])
    np.testing.assert_allclose(reflectance[1], single.reflectance(nm), atol=1e-13)


def test_a_rough_face_reflects_less_as_its_square() -> None:
    """Nearly transparent media: R falls by exp(-(4 pi rms/lambda)^2), that is to first order by its square."""
    nm = 600.0
    smooth = ir.Stack([1.5, 1.501]).reflectance(nm)
    for rms in (2.0, 6.0):
        rough = ir.Stack([1.5, ir.Layer.rough(rms, 1.5, 1.501), 1.501]).reflectance(nm)
        wanted = (4.0 * np.pi * 1.5 * rms / nm) ** 2
        assert 1.0 - rough / smooth == pytest.approx(wanted, rel=0.05)
    assert ir.Stack(["air", ir.Layer.rough(0.0, "air", "Si"), "Si"]).reflectance(nm) == pytest.approx(
        ir.Stack(["air", "Si"]).reflectance(nm), abs=1e-15
    )


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: ir.Layer.graded(100.0, "air"), "second must be a medium"),
        (lambda: ir.Layer.graded(100.0, lambda z: 1.5, "air"), "second and profile must be None"),
        (lambda: ir.Layer.graded(100.0, "air", "SiO2", lambda x: 2.0), "shares from 0 to 1"),
        (lambda: ir.Layer.graded(100.0, "air", "SiO2", 0.5), "profile must be None or a function"),
        (lambda: ir.Layer.graded(100.0, "air", "SiO2", rule="mean"), "rule must be"),
        (lambda: ir.Layer.graded(-1.0, "air", "SiO2"), "thickness_nm"),
        (lambda: ir.Layer.graded(100.0, "air", "SiO2", tolerance=0.0), "tolerance"),
        (lambda: ir.Layer.graded(3e4, 1.0, 1.5, tolerance=1e-12), "is not reached with 1024 slices"),
        (lambda: ir.Layer.graded(100.0, "air", "SiO2", wavelength_nm=-5.0), "wavelength_nm"),
        (lambda: ir.Layer.graded(100.0, lambda z: complex("nan")), "n = NaN"),
        (lambda: ir.Layer.rough(-1.0, "air", "Si"), "rms_nm"),
    ],
)
def test_refusals(call: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        call()  # type: ignore[operator]
