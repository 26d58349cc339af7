"""The models' derivatives, which the least squares steer by."""

from __future__ import annotations

import numpy as np
import pytest

from iridesce.inverse import model as fit_model
from iridesce.optics.averages import FWHM


@pytest.mark.parametrize(
    ("text", "index", "parameters"),
    [
        ("air / soap ? / air", None, [700.0, 1.2]),
        ("air / SiO2 ? / Si", None, [1500.0, 2.0]),
        ("air / SiO2 ? / Si", "cauchy", [600.0, 1.45, 4e-3, 1.5]),
        ("air / TiO2 ? / Ti", "constant", [120.0, 2.3, 0.8]),
        ("air / SiO2 ? / Si3N4 ? / Si", None, [210.0, 95.0, 0.7]),
        ("air / Ta2O5 ? / N-BK7 1e6 incoherent / air", None, [300.0, 0.5]),
    ],
)
def test_derivatives_of_the_models(text: str, index: str | None, parameters: list[float]) -> None:
    nm = np.linspace(500.0, 700.0, 9)
    problem = fit_model.read_problem(text, None, index, "reflectance", 30.0, "unpolarized")
    of = fit_model.harmonics(problem, nm)
    models = [fit_model.GeneralModel(problem, nm)]
    models += [] if of is None else [fit_model.HarmonicModel(of)]  # type: ignore[list-item]
    start = np.array(parameters)
    start[-1] = (start[-1] / FWHM) ** 2
    for model in models:
        _, slopes = model.both(start)
        for place in range(start.size - (model is models[0])):
            step = np.zeros(start.size)
            step[place] = 1e-4 * max(abs(start[place]), 1e-3)
            difference = (model.value(start + step) - model.value(start - step)) / (2.0 * step[place])
            np.testing.assert_allclose(slopes[:, place], difference, rtol=2e-5, atol=2e-6 * np.abs(difference).max())
    if len(models) == 2:
        # Two roads to one spectrum: the harmonics to second order of the line, and the average itself.
        np.testing.assert_allclose(
            models[0].value(start), models[1].value(start), atol=2e-4 * np.ptp(models[0].value(start))
        )
