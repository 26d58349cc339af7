"""`Stack.to_xarray`: names, coordinates, units and values."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import iridesce as ir

xarray = pytest.importorskip("xarray")
NM = np.array([450.0, 550.0, 650.0])
ANGLE = np.array([0.0, 45.0])


def test_axes_coordinates_units_and_values() -> None:
    thickness = np.array([100.0, 200.0, 300.0, 400.0])
    film = ir.Stack(["air", ir.Layer("soap", thickness), "air"])
    found = film.to_xarray("reflectance", NM, ANGLE, ["s", "p"])
    assert isinstance(found, xarray.DataArray) and found.name == "reflectance"
    assert found.dims == ("thickness_nm", "wavelength_nm", "angle_deg", "polarization")
    assert found.shape == (4, 3, 2, 2)
    for axis, values, unit in (
        ("thickness_nm", thickness, "nm"),
        ("wavelength_nm", NM, "nm"),
        ("angle_deg", ANGLE, "degree"),
    ):
        np.testing.assert_array_equal(found[axis], values)
        assert found[axis].attrs["units"] == unit and found[axis].attrs["long_name"]
    assert found["polarization"].values.tolist() == ["s", "p"]
    assert found.attrs["units"] == "1" and found.attrs["long_name"] == "reflectance" and "soap" in found.attrs["stack"]
    for state in ("s", "p"):
        wanted = film_values(thickness, state)
        np.testing.assert_array_equal(found.sel(polarization=state), wanted)


def film_values(thickness: np.ndarray, state: str) -> np.ndarray:
    film = ir.Stack(["air", ir.Layer("soap", thickness[:, None, None]), "air"])
    return np.asarray(film.reflectance(NM[:, None], ANGLE, state))


def test_single_values_are_scalar_coordinates() -> None:
    found = ir.Stack(["air", ir.Layer("soap", 320.0), "air"]).to_xarray("absorptance", 550.0, 30.0, "p")
    assert found.dims == () and float(found["wavelength_nm"]) == 550.0 and float(found["angle_deg"]) == 30.0
    assert str(found["polarization"].values) == "p" and found["wavelength_nm"].attrs["units"] == "nm"


def test_several_layers_and_quantities() -> None:
    a, b = np.array([50.0, 60.0]), np.array([70.0, 80.0, 90.0])
    stack = ir.Stack(["air", ir.Layer("TiO2", a), ir.Layer("SiO2", 100.0), ir.Layer("TiO2", b), "N-BK7"])
    found = stack.to_xarray(["reflectance", "transmittance", "psi", "delta"], NM, 50.0)
    assert isinstance(found, xarray.Dataset) and list(found) == ["reflectance", "transmittance", "psi", "delta"]
    assert found["reflectance"].dims == ("thickness_nm_1", "thickness_nm_3", "wavelength_nm")
    assert found["thickness_nm_3"].attrs == {"long_name": "thickness of layer 3", "units": "nm"}
    assert found["psi"].attrs["units"] == found["delta"].attrs["units"] == "degree"
    one = ir.Stack(["air", ir.Layer("TiO2", 60.0), ir.Layer("SiO2", 100.0), ir.Layer("TiO2", 70.0), "N-BK7"])
    at = {"thickness_nm_1": 60.0, "thickness_nm_3": 70.0, "wavelength_nm": 550.0}
    assert float(found["reflectance"].sel(at)) == one.reflectance(550.0, 50.0)
    assert float(found["delta"].sel(at)) == one.ellipsometry(550.0, 50.0)[1]


def test_the_order_of_before_is_understood() -> None:
    film = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])
    for now, before in (
        (film.to_xarray(NM, [0.0, 45.0], "s", "transmittance"), film.to_xarray("transmittance", NM, [0.0, 45.0], "s")),
        (film.to_xarray(NM, quantity=["psi", "delta"], angle_deg=45.0), film.to_xarray(["psi", "delta"], NM, 45.0)),
        (film.to_xarray(), film.to_xarray("reflectance")),
        (film.to_xarray(wavelength_nm=NM, quantity="reflectance"), film.to_xarray("reflectance", wavelength_nm=NM)),
    ):
        assert now.identical(before)


def test_refusals(monkeypatch: pytest.MonkeyPatch) -> None:
    film = ir.Stack(["air", ir.Layer("soap", 320.0), "air"])
    for arguments, words in (
        (("color",), "quantity"),
        (([],), "not be empty"),
        (("reflectance", NM[:, None]), "one axis"),
        (("reflectance", -NM), "wavelength_nm"),
        (("reflectance", NM, 95.0), "angle_deg"),
        (("reflectance", NM, 0.0, "x"), "polarization"),
    ):
        with pytest.raises(ValueError, match=words):
            film.to_xarray(*arguments)
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match=r'pip install "iridesce\[xarray\]"'):
        film.to_xarray()
