"""Averages over spectral width and thickness spread: closed forms, brute force, limits, refusals."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import iridesce as ir

FWHM = np.sqrt(8.0 * np.log(2.0))


def brute(stack_at: Callable[[np.ndarray], ir.Stack], sd_nm: float, wavelength_nm: float, **question) -> float:
    """The Gaussian mean by the trapezoid rule on 60 001 points over 8 sd."""
    x = np.linspace(-8.0, 8.0, 60_001)
    weights = np.exp(-0.5 * x * x)
    quantity = question.pop("quantity", "reflectance")
    values = getattr(stack_at(sd_nm * x), quantity)(wavelength_nm, **question)
    return float((weights * values).sum() / weights.sum())


@pytest.mark.parametrize("quantity", ["reflectance", "transmittance"])
@pytest.mark.parametrize("polarization", ["s", "p", "unpolarized"])
@pytest.mark.parametrize("sd_nm", [3.0, 40.0, 120.0])
def test_the_series_of_a_clear_layer_is_the_gaussian_mean(quantity: str, polarization: str, sd_nm: float) -> None:
    def stack(offset_nm: float | np.ndarray) -> ir.Stack:
        return ir.Stack(
            ["air", ir.Layer(2.3, 58.0), ir.Layer(1.46, 1200.0 + offset_nm), ir.Layer(0.2 + 3.4j, 15.0), 1.5]
        )

    found = getattr(stack(0.0), quantity + "_averaged")(550.0, 35.0, polarization, thickness_sd_nm=[0.0, sd_nm, 0.0])
    wanted = brute(stack, sd_nm, 550.0, angle_deg=35.0, polarization=polarization, quantity=quantity)
    assert found.value == pytest.approx(wanted, abs=1e-13)
    assert found.error <= 1e-12


def test_the_series_meets_its_limits() -> None:
    film = ir.Stack(["air", ir.Layer(1.5, 4000.0), 1.7])
    wavelength_nm = np.linspace(400.0, 700.0, 31)
    thin = film.reflectance_averaged(wavelength_nm, 20.0, thickness_sd_nm=1e-9).value
    np.testing.assert_allclose(thin, film.reflectance(wavelength_nm, 20.0), atol=1e-12)
    wide = film.reflectance_averaged(wavelength_nm, 20.0, thickness_sd_nm=600.0).value
    slab = ir.Stack(["air", ir.Layer(1.5, 4000.0, coherent=False), 1.7])
    np.testing.assert_allclose(wide, slab.reflectance(wavelength_nm, 20.0), atol=1e-14)


@pytest.mark.parametrize(
    ("n", "thickness_nm", "sd_nm"),
    [(2.0 + 0.3j, 120.0, 8.0), (0.06 + 3.6j, 12.0, 4.0), (1.33, 10.0, 4.0), (1.0, 300.0, 10.0)],
    ids=["absorbing", "metal cut at 0", "thin, cut at 0", "beyond the critical angle"],
)
def test_other_layers_are_averaged_by_a_rule(n: complex, thickness_nm: float, sd_nm: float) -> None:
    def stack(offset_nm: float | np.ndarray) -> ir.Stack:
        return ir.Stack([1.5, ir.Layer(n, thickness_nm + offset_nm), 1.5])

    found = stack(0.0).reflectance_averaged(550.0, 50.0, "p", thickness_sd_nm=sd_nm)
    x = np.linspace(max(-7.0, -thickness_nm / sd_nm), 7.0, 200_001)
    density = np.exp(-0.5 * x * x)
    density[[0, -1]] *= 0.5
    wanted = float((density * stack(sd_nm * x).reflectance(550.0, 50.0, "p")).sum() / density.sum())
    assert found.value == pytest.approx(wanted, abs=1e-9)
    assert 0.0 < found.error <= 1e-9


@pytest.mark.parametrize("shape", ["gaussian", "rectangle", "triangle"])
def test_resolution_keeps_dispersion(shape: str) -> None:
    film = ir.Stack(["air", ir.Layer("SiO2", 9000.0), "Si"])
    found = film.reflectance_averaged([500.0, 601.3], resolution_nm=3.0, resolution_shape=shape)
    if shape == "gaussian":
        x = np.linspace(-7.0, 7.0, 40_001) * 3.0 / FWHM
        density = np.exp(-0.5 * (x * FWHM / 3.0) ** 2)
    elif shape == "rectangle":
        x = (np.arange(40_000) + 0.5) / 40_000 * 3.0 - 1.5
        density = np.ones_like(x)
    else:
        x = np.linspace(-3.0, 3.0, 40_001)
        density = 1.0 - np.abs(x) / 3.0
    spectra = film.reflectance(np.add.outer([500.0, 601.3], x))
    np.testing.assert_allclose(found.value, (density * spectra).sum(axis=1) / density.sum(), atol=2e-8)


def test_widths_add_as_they_should() -> None:
    """Two Gaussian lines in series are one of the root of the sum of squares; a spread and a line commute."""
    film = ir.Stack(["air", ir.Layer(1.33, 6000.0), "air"])
    both = film.reflectance_averaged(550.0, resolution_nm=1.2, bandwidth_nm=1.6).value
    assert both == pytest.approx(film.reflectance_averaged(550.0, resolution_nm=2.0).value, abs=1e-9)
    mixed = film.reflectance_averaged(550.0, resolution_nm=1.2, thickness_sd_nm=25.0).value
    x = np.linspace(-7.0, 7.0, 2001)
    density = np.exp(-0.5 * x * x)
    lines = [film.reflectance_averaged(550.0 + 1.2 / FWHM * s, thickness_sd_nm=25.0).value for s in x[::20]]
    assert mixed == pytest.approx(float(np.dot(density[::20], lines) / density[::20].sum()), abs=1e-9)


@pytest.mark.parametrize("thickness_nm", [320.0, 1e5 + 3.25, 1e7 + 12.5])
def test_a_line_of_a_lamp_is_exact_at_any_thickness(thickness_nm: float) -> None:
    """Y of a film under one line is its reflectance there, whatever the thickness; two lines add by their luminance."""
    film = ir.Stack(["air", ir.Layer(1.33, thickness_nm), "air"])
    r0 = (0.33 / 2.33) ** 2
    finesse = 4.0 * r0 / (1.0 - r0) ** 2

    def exact(wavelength_nm: float) -> float:
        s = np.sin(2.0 * np.pi * 1.33 * thickness_nm / wavelength_nm) ** 2
        return float(finesse * s / (1.0 + finesse * s))

    for line in (589.158, 589.756):
        assert film.color(illuminant=f"laser:{line}")[1] == pytest.approx(exact(line), abs=2e-10)
    doublet = film.color(illuminant="lines:589.158*2,589.756")[1]
    share = (doublet - exact(589.756)) / (exact(589.158) - exact(589.756))
    assert share == pytest.approx(2.0 / 3.0, abs=0.003)  # ybar falls by 0.9 % from one line to the other


def test_scalars_shapes_and_stated_error() -> None:
    film = ir.Stack(["air", ir.Layer(1.33, np.array([[300.0], [5000.0]])), "air"])
    found = film.reflectance_averaged([500.0, 550.0, 600.0], resolution_nm=1.0)
    assert found.value.shape == found.error.shape == (2, 3) and found.error.max() <= 1e-9
    one = ir.Stack(["air", ir.Layer(1.33, 5000.0), "air"]).reflectance_averaged(600.0, resolution_nm=1.0)
    assert isinstance(one.value, float) and one.value == pytest.approx(found.value[1, 2], abs=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"resolution_nm": -1.0}, "resolution_nm must be >= 0"),
        ({"resolution_shape": "sinc"}, "resolution_shape must be"),
        ({"thickness_sd_nm": [1.0, 2.0]}, "one number a layer"),
        ({"thickness_sd_nm": float("nan")}, "thickness_sd_nm must be"),
        ({"tolerance": 0.0}, "tolerance must be > 0"),
        ({"resolution_nm": 400.0}, "below 0 nm"),
        ({"resolution_nm": [1.0, 2.0]}, "resolution_nm must be a number"),
    ],
)
def test_refusals(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ir.Stack(["air", ir.Layer(1.33, 300.0), "air"]).reflectance_averaged(550.0, **arguments)


def test_an_unreachable_tolerance_is_said_so() -> None:
    film = ir.Stack(["air", ir.Layer(1.33, 1e8), "air"])
    with pytest.raises(ir.ResourceError, match="tolerance"):
        film.reflectance_averaged(550.0, resolution_nm=5.0, resolution_shape="rectangle")
    slab = ir.Stack(["air", ir.Layer(1.33, 1e3), ir.Layer(1.5, 1e6, coherent=False), "air"])
    with pytest.raises(ValueError, match="incoherent slab must be 0"):
        slab.reflectance_averaged(550.0, thickness_sd_nm=[0.0, 5.0])
    assert slab.reflectance_averaged(550.0, thickness_sd_nm=[5.0, 0.0]).value > 0.0
