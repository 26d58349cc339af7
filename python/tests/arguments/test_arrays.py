"""What numpy would make numbers of with a loss is refused wherever an array is asked for."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import iridesce as ir

NM = np.linspace(400.0, 800.0, 60)
FILM = ir.Stack(["air", ir.Layer("soap", 500.0), "air"])
VALUES = FILM.reflectance(NM)
SPECTRA = np.stack([VALUES] * 3)
PHOTO = np.random.default_rng(1).random((16, 16, 3))
CHART = np.random.default_rng(2).random((7, 24, 3))
ASKED = "air / soap ? / air"

Change = Callable[[Any], Any]
TAKES: dict[str, Callable[[Change], object]] = {
    "fit_thickness range": lambda of: ir.fit_thickness(NM, VALUES, ASKED, thickness_range_nm=of((400.0, 600.0))),
    "Measurement": lambda of: ir.Measurement("reflectance", NM, of(VALUES)),
    "Measurement wavelengths": lambda of: ir.Measurement("reflectance", of(NM), VALUES),
    "fit_series": lambda of: ir.fit_series(NM, of(SPECTRA), ASKED),
    "fit_series wavelengths": lambda of: ir.fit_series(of(NM), SPECTRA, ASKED),
    "fit_series times": lambda of: ir.fit_series(NM, SPECTRA, ASKED, time_s=of([0.0, 1.0, 2.0])),
    "map_thickness angle": lambda of: mapped(angle_deg=of(np.ones((16, 16)))),
    "map_thickness noise": lambda of: mapped(noise=of([0.1, 0.1, 0.1])),
    "map_thickness clip": lambda of: mapped(clip=of([0.9, 0.9, 0.9])),
    "map_thickness ties": lambda of: mapped(tie_points=of([(1.0, 2.0, 300.0)])),
    "map_thickness range": lambda of: mapped(thickness_range_nm=of((0.0, 800.0))),
    "recipes target": lambda of: ir.recipes(of([45.0, 20.0, -30.0]), media=["SiO2"], substrate="Si"),
    "recipes range": lambda of: ir.recipes(
        [45.0, 20.0, -30.0], media=["SiO2"], substrate="Si", thickness_range_nm=of((5.0, 400.0))
    ),
    "recipes coupons": lambda of: ir.recipes(
        [45.0, 20.0, -30.0], media=["TiO2"], layers=(1,), substrate="Ti", coupons=of([(10.0, 20.0), (20.0, 40.0)])
    ),
    "validate": lambda of: ir.validate(of(CHART), "C1"),
    "lens_gap": lambda of: ir.thickness.lens_gap(of(1000.0)),
    "spectral_nm": lambda of: ir.render("soap-bubble", size=(2, 2), samples=1, spectral_nm=of([500.0, 600.0])),
    "ThicknessMap": lambda of: ir.thickness.ThicknessMap(of(np.full((4, 4), 300.0))),
    "index": lambda of: ir.Medium("soap").index(of(NM)),
    "Image": lambda of: ir.Image(of(PHOTO)),
}
# Where a masked value is one that is not known, and left out.
LEFT_OUT = ("Measurement", "Measurement wavelengths", "fit_series", "map_thickness angle")


def mapped(**options: Any) -> object:
    return ir.map_thickness(PHOTO, ASKED, camera="srgb", illuminant="D65", **options)


def masked(value: Any) -> Any:
    values = np.asarray(value)
    return np.ma.masked_array(values, mask=np.arange(values.size).reshape(values.shape) % 2 == 0)


CHANGES: dict[str, Change] = {
    "complex": lambda value: np.asarray(value) + 0.5j,
    "texts": lambda value: np.asarray(value).astype(str),
    "dates": lambda value: np.asarray(value).astype(int).astype("M8[s]"),
    "masked": masked,
}


@pytest.mark.parametrize(
    ("name", "change"),
    [(name, change) for name in TAKES for change in CHANGES if change != "masked" or name not in LEFT_OUT],
)
def test_what_is_no_real_number_is_refused_without_a_warning(name: str, change: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ir.ArgumentError):
            TAKES[name](CHANGES[change])


def test_values_too_large_for_single_precision_are_refused_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ir.ArgumentError, match="must be finite"):
            ir.Image(np.full((2, 2, 3), 1e300))
