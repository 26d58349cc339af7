"""Analytic derivatives against differences in arbitrary precision and against differences of the public functions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mpmath
import numpy as np
import pytest

import iridesce as ir

AIR = 1.0


def reflected(
    n: Sequence[complex], d_nm: Sequence[float], wavelength_nm: float, angle_deg: float, p: bool
) -> mpmath.mpf:
    """R by recursive Airy summation from the exit side, 60 digits; another road than the march of the core."""
    with mpmath.workdps(60):
        n = [mpmath.mpmathify(value) for value in n]
        across = n[0] * mpmath.sin(mpmath.radians(mpmath.mpf(angle_deg)))
        kz = [mpmath.sqrt(one * one - across * across) for one in n]
        kz = [-one if one.imag < 0 else one for one in kz]
        q = [k / (one * one) if p else k for k, one in zip(kz, n, strict=True)]
        r = (q[-2] - q[-1]) / (q[-2] + q[-1])
        for j in range(len(n) - 3, -1, -1):
            turn = mpmath.exp(2j * kz[j + 1] * 2 * mpmath.pi * mpmath.mpmathify(d_nm[j]) / wavelength_nm)
            face = (q[j] - q[j + 1]) / (q[j] + q[j + 1])
            r = (face + r * turn) / (1 + face * r * turn)
        return abs(r) ** 2


def difference(f: Callable[[mpmath.mpf], mpmath.mpf]) -> float:
    """Central difference with 60 digits and a step of 1e-15: good to 1e-28."""
    with mpmath.workdps(60):
        h = mpmath.mpf("1e-15")
        return float((f(h) - f(-h)) / (2 * h))


CASES = [
    ([1.0, 1.33, 1.0], [320.0]),
    ([1.0, 2.3 + 0.05j, 1.46, 4.0 + 0.03j], [60.0, 210.0]),
    ([1.5, 0.06 + 3.6j, 1.0, 1.7 + 0.2j], [30.0, 500.0]),
    ([1.2, 2.35, 1.38, 2.35, 1.38, 2.35, 1.52], [58.5, 99.6, 58.5, 99.6, 58.5]),
]


@pytest.mark.parametrize(("n", "d_nm"), CASES)
@pytest.mark.parametrize("angle_deg", [0.0, 37.0, 63.0])
@pytest.mark.parametrize("polarization", ["s", "p"])
def test_reflectance_against_arbitrary_precision(
    n: list[complex], d_nm: list[float], angle_deg: float, polarization: str
) -> None:
    stack = ir.Stack([n[0], *(ir.Layer(index, d) for index, d in zip(n[1:-1], d_nm, strict=True)), n[-1]])
    found = stack.derivatives("reflectance", 550.0, angle_deg, polarization)
    p = polarization == "p"

    def at(place: int, h: complex, of: str) -> mpmath.mpf:
        indices, thickness = list(map(mpmath.mpmathify, n)), list(map(mpmath.mpmathify, d_nm))
        (thickness if of == "d" else indices)[place] += h
        return reflected(indices, thickness, 550.0, angle_deg, p)

    wanted = [difference(lambda h, j=j: at(j, h, "d")) for j in range(len(d_nm))]
    np.testing.assert_allclose(found.thickness_nm, wanted, rtol=1e-11, atol=1e-14)
    by_n = [difference(lambda h, j=j: at(j, h, "n")) for j in range(len(n))]
    by_k = [difference(lambda h, j=j: at(j, 1j * h, "n")) for j in range(1, len(n) - 1)]
    np.testing.assert_allclose([found.n_first, *found.n], by_n, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(found.k[:-1], by_k, rtol=1e-10, atol=1e-12)
    assert found.value == pytest.approx(stack.reflectance(550.0, angle_deg, polarization), abs=1e-14)


def steps(f: Callable[[float], float], h: float) -> float:
    """Richardson's rule on central differences."""
    central = [(f(s) - f(-s)) / (2.0 * s) for s in (h, 0.5 * h)]
    return (4.0 * central[1] - central[0]) / 3.0


def moved(stack: ir.Stack, layer: int, by_nm: float = 0.0, by_index: complex = 0.0) -> ir.Stack:
    layers = list(stack.layers)
    old = layers[layer]
    index = complex(old.medium.index(550.0)) + by_index
    layers[layer] = ir.Layer(index, old.thickness_nm + by_nm, old.coherent)
    return ir.Stack([stack.first, *layers, stack.last])


MIXED = ir.Stack(
    ["air", ir.Layer(2.1 + 0.01j, 140.0), ir.Layer(1.5 + 1e-6j, 2e4, coherent=False), ir.Layer(1.8, 90.0), 1.3]
)
COHERENT = ir.Stack(["air", ir.Layer(2.1 + 0.01j, 140.0), ir.Layer(1.5, 700.0), 3.9 + 0.02j])


@pytest.mark.parametrize("quantity", ["reflectance", "transmittance", "absorptance", "psi", "delta"])
@pytest.mark.parametrize("stack", [MIXED, COHERENT], ids=["incoherent", "coherent"])
def test_every_quantity_against_differences(quantity: str, stack: ir.Stack) -> None:
    if quantity in ("psi", "delta"):
        if stack is MIXED:
            with pytest.raises(ValueError, match="coherent"):
                stack.derivatives(quantity, 550.0, 50.0)
            return

        def value(of: ir.Stack) -> float:
            return of.ellipsometry(550.0, 50.0)[0 if quantity == "psi" else 1]
    else:

        def value(of: ir.Stack) -> float:
            return getattr(of, quantity)(550.0, 50.0)

    found = stack.derivatives(quantity, 550.0, 50.0)
    assert found.value == pytest.approx(value(stack), abs=1e-12)
    for layer in range(len(stack.layers)):
        wanted = steps(lambda h, j=layer: value(moved(stack, j, by_nm=h)), 0.02)
        assert found.thickness_nm[layer] == pytest.approx(wanted, rel=1e-6, abs=1e-8)
        wanted = steps(lambda h, j=layer: value(moved(stack, j, by_index=h)), 1e-4)
        assert found.n[layer] == pytest.approx(wanted, rel=1e-6, abs=1e-7)
        if stack.layers[layer].medium.index(550.0).imag > 1e-3:
            wanted = steps(lambda h, j=layer: value(moved(stack, j, by_index=1j * h)), 1e-4)
            assert found.k[layer] == pytest.approx(wanted, rel=1e-6, abs=1e-7)


def test_shapes_broadcast() -> None:
    film = ir.Stack(["air", ir.Layer(1.33, np.array([[100.0], [200.0]])), ir.Layer(1.5, 50.0), 1.6])
    found = film.derivatives("transmittance", [500.0, 550.0, 600.0], 20.0)
    assert found.value.shape == (2, 3) and found.n_first.shape == (2, 3)
    assert found.thickness_nm.shape == (2, 3, 2)
    assert found.n.shape == found.k.shape == (2, 3, 3)
    one = ir.Stack(["air", ir.Layer(1.33, 200.0), ir.Layer(1.5, 50.0), 1.6]).derivatives("transmittance", 600.0, 20.0)
    np.testing.assert_array_equal(found.n[1, 2], one.n)
    bare = ir.Stack(["air", 1.5]).derivatives("reflectance", 550.0)
    # R = ((n - 1)/(n + 1))^2, dR/dn = 4 (n - 1)/(n + 1)^3
    assert bare.thickness_nm.shape == (0,) and bare.n[0] == pytest.approx(4 * 0.5 / 2.5**3, rel=1e-14)


@pytest.mark.parametrize("space", ["xyz", "xyy", "lab", "lch", "oklab", "srgb", "rec2020", "linear-srgb", "acescg"])
@pytest.mark.parametrize("illuminant", ["D65", "lines:589.158*2,589.756,435.8"])
def test_colour_against_differences(space: str, illuminant: str) -> None:
    def color(thickness_nm: float, step_n: float = 0.0) -> np.ndarray:
        film = ir.Stack(["air", ir.Layer(1.8 + step_n + 0.01j, thickness_nm), "Si"])
        return film.color(30.0, illuminant=illuminant, space=space, adaptation="bradford")

    film = ir.Stack(["air", ir.Layer(1.8 + 0.01j, 480.0), "Si"])
    found = film.color_derivatives(30.0, illuminant=illuminant, space=space, adaptation="bradford")
    np.testing.assert_allclose(found.value, color(480.0), rtol=1e-12)
    for channel in range(3):
        wanted = steps(lambda h, c=channel: color(480.0 + h)[c], 0.05)
        assert found.thickness_nm[channel, 0] == pytest.approx(wanted, rel=1e-6, abs=1e-8)
        wanted = steps(lambda h, c=channel: color(480.0, h)[c], 1e-4)
        assert found.n[channel, 0] == pytest.approx(wanted, rel=1e-6, abs=1e-6)


def test_colour_of_thick_films_uses_the_refined_sum() -> None:
    film = ir.Stack(["air", ir.Layer("soap", np.array([300.0, 30_000.0])), "air"])
    found = film.color_derivatives(space="xyz")
    for place, thickness in enumerate((300.0, 30_000.0)):
        wanted = steps(lambda h, t=thickness: ir.Stack(["air", ir.Layer("soap", t + h), "air"]).color()[1], 0.05)
        assert found.thickness_nm[place, 1, 0] == pytest.approx(wanted, rel=1e-6, abs=1e-10)


def test_error_bars_are_those_of_a_sample() -> None:
    """20000 films with a seeded Gaussian thickness: sd and correlation of their colours."""
    film = ir.Stack(["air", ir.Layer("soap", 420.0), "air"])
    bars = film.color_uncertainty(0.5)
    sample_nm = 420.0 + 0.5 * np.random.default_rng(4).standard_normal(20_000)
    colors = ir.Stack(["air", ir.Layer("soap", sample_nm), "air"]).color(space="lab")
    np.testing.assert_allclose(bars.sd, colors.std(axis=0), rtol=0.02)
    np.testing.assert_allclose(bars.covariance, np.cov(colors.T), rtol=0.05, atol=1e-3)
    both = ir.Stack(["air", ir.Layer(1.4, 100.0), ir.Layer(2.0, 150.0), "Si"])
    np.testing.assert_allclose(
        both.color_uncertainty([1.0, 2.0]).covariance,
        both.color_uncertainty([1.0, 0.0]).covariance + both.color_uncertainty([0.0, 2.0]).covariance,
        rtol=1e-12,
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: s.derivatives("colour", 550.0), 'quantity must be "reflectance"'),
        (lambda s: s.derivatives("reflectance", 550.0, 90.0), "angle_deg must be"),
        (lambda s: s.derivatives("reflectance", -1.0), "wavelength_nm must be"),
        (lambda s: s.derivatives("reflectance", 550.0, 0.0, "x"), "polarization must be"),
        (lambda s: s.color_derivatives(space="cmyk"), "unknown colour space"),
        (lambda s: s.color_uncertainty(-1.0), "thickness_sd_nm must be"),
        (lambda s: s.color_uncertainty([1.0, 2.0]), "one a layer"),
        (lambda s: ir.Stack([1.5, 1.5]).color_derivatives(space="oklab"), "no derivatives at the colour"),
        (lambda s: ir.Stack([1.5, 1.5]).derivatives("psi", 550.0, 30.0), "no derivatives|nothing is reflected"),
        (lambda s: ir.Stack([2.0, 1.0]).derivatives("reflectance", 550.0, 30.0), "critical angle"),
    ],
)
def test_refusals(call: Callable[[ir.Stack], object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call(ir.Stack(["air", ir.Layer(1.33, 300.0), "air"]))


EVERY = [
    ir.Stack([1.2, ir.Layer(2.1 + 0.01j, 140.0), ir.Layer(1.5 + 0.4j, 60.0), ir.Layer(1.8, 90.0), 3.9 + 0.02j]),
    ir.Stack([1.2, ir.Layer(2.1 + 0.01j, 140.0), ir.Layer(1.5, 2e4, coherent=False), ir.Layer(1.8, 90.0), 1.3]),
]


def nudged(stack: ir.Stack, medium: int, by: complex) -> ir.Stack:
    """The stack with the index of one medium (0 is the first) moved."""
    media = [complex(one.index(550.0)) + (by if place == medium else 0.0) for place, one in enumerate(stack.media)]
    layers = [
        ir.Layer(index, layer.thickness_nm, layer.coherent)
        for index, layer in zip(media[1:-1], stack.layers, strict=True)
    ]
    return ir.Stack([media[0].real, *layers, media[-1]])


@pytest.mark.parametrize("stack", EVERY, ids=["coherent", "incoherent"])
@pytest.mark.parametrize("polarization", ["s", "p", "unpolarized"])
@pytest.mark.parametrize("quantity", ["reflectance", "transmittance", "absorptance", "psi", "delta"])
def test_every_derivative_of_every_quantity(quantity: str, polarization: str, stack: ir.Stack) -> None:
    """By every thickness, every n (first and last media too) and every k that may move both ways: 1e-6 of the largest."""
    ellipsometric = quantity in ("psi", "delta")
    if ellipsometric and (polarization != "unpolarized" or stack is EVERY[1]):
        return  # one answer for both polarisations, and none with slabs: tested above

    def value(of: ir.Stack) -> float:
        if ellipsometric:
            return float(of.ellipsometry(550.0, 40.0)[0 if quantity == "psi" else 1])
        return float(getattr(of, quantity)(550.0, 40.0, polarization))

    found = stack.derivatives(quantity, 550.0, 40.0, *(() if ellipsometric else (polarization,)))
    by_d = [steps(lambda h, j=j: value(moved(stack, j, by_nm=h)), 0.02) for j in range(3)]
    np.testing.assert_allclose(found.thickness_nm, by_d, rtol=0.0, atol=1e-6 * np.abs(by_d).max())
    by_n = [steps(lambda h, j=j: value(nudged(stack, j, h)), 1e-4) for j in range(5)]
    np.testing.assert_allclose([found.n_first, *found.n], by_n, rtol=0.0, atol=1e-6 * np.abs(by_n).max())
    absorbing = [j for j in range(1, 5) if stack.media[j].index(550.0).imag > 1e-3]
    by_k = [steps(lambda h, j=j: value(nudged(stack, j, 1j * h)), 1e-4) for j in absorbing]
    np.testing.assert_allclose(found.k[np.array(absorbing) - 1], by_k, rtol=0.0, atol=1e-6 * np.abs(by_k).max())


@pytest.mark.parametrize("quantity", ["reflectance", "transmittance"])
@pytest.mark.parametrize("space", ["xyz", "lab", "srgb"])
def test_every_derivative_of_colour(space: str, quantity: str) -> None:
    """By both thicknesses, all n and all k of a stack of two layers, 1e-6 of the largest of each kind."""
    stack = ir.Stack([1.1, ir.Layer(2.1 + 0.01j, 140.0), ir.Layer(1.5 + 0.1j, 260.0), 1.7 + 0.02j])

    def color(of: ir.Stack) -> np.ndarray:
        return np.asarray(of.color(30.0, space=space, quantity=quantity))

    found = stack.color_derivatives(30.0, space=space, quantity=quantity)
    for channel in range(3):
        by_d = [steps(lambda h, j=j, c=channel: color(moved(stack, j, by_nm=h))[c], 0.05) for j in range(2)]
        by_n = [steps(lambda h, j=j, c=channel: color(nudged(stack, j, h))[c], 1e-4) for j in range(4)]
        by_k = [steps(lambda h, j=j, c=channel: color(nudged(stack, j, 1j * h))[c], 1e-4) for j in range(1, 4)]
        np.testing.assert_allclose(found.thickness_nm[channel], by_d, rtol=0.0, atol=1e-6 * np.abs(by_d).max())
        all_n = [found.n_first[channel], *found.n[channel]]
        np.testing.assert_allclose(all_n, by_n, rtol=0.0, atol=1e-6 * np.abs(by_n).max())
        np.testing.assert_allclose(found.k[channel], by_k, rtol=0.0, atol=1e-6 * np.abs(by_k).max())
