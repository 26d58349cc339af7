"""The top of a probability: found along ridges and at bounds, and never below where the search began."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from iridesce.inverse.summit import summit

Floats = npt.NDArray[np.float64]
FREE = (np.full(2, -np.inf), np.full(2, np.inf))


def ridge(points: Floats) -> Floats:
    """Student's t of four degrees of freedom across x + 100 y = 40, 0.05 wide; normal along it, y = 0.003 wide about 0."""
    across = (points[..., 0] + 100.0 * points[..., 1] - 40.0) / 0.05
    return np.asarray(-2.5 * np.log1p(across**2 / 4.0) - 0.5 * (points[..., 1] / 0.003) ** 2)


def test_a_ridge_whose_flanks_bend_upwards() -> None:
    found = summit(
        ridge, lambda x: None, np.array([41.3, -0.004]), np.array([0.8, 6e-5]), np.array([8.0, 4.5e-3]), FREE
    )
    assert found.is_settled
    # 5 / 4 of the curvature of a normal density: Student's at its top.
    across = 0.05 / np.sqrt(5.0 / 4.0)
    wanted = np.array([[across**2 + 0.3**2, -100.0 * 0.003**2], [-100.0 * 0.003**2, 0.003**2]])
    assert np.abs(found.x - np.array([40.0, 0.0])).max() < 0.05 * 0.3
    # Differences over 0.3 of a standard deviation see a flank of Student's as 5 % flatter.
    assert np.allclose(found.covariance, wanted, rtol=0.1)


def test_a_top_beyond_a_bound_is_as_wide_as_the_fall_from_it() -> None:
    def plain(points: Floats) -> Floats:
        across = (points[..., 0] + 100.0 * points[..., 1] - 40.0) / 0.05
        return np.asarray(-0.5 * across**2 - 0.5 * (points[..., 1] / 0.003) ** 2)

    bounds = (np.array([42.0, -np.inf]), np.array([90.0, np.inf]))
    found = summit(plain, lambda x: None, np.array([45.0, 0.0]), np.array([0.8, 6e-5]), np.array([8.0, 4.5e-3]), bounds)
    assert found.is_settled and found.x[0] == 42.0
    # Along the bound a normal density of two errors; beyond it the slope of that across the ridge.
    ridge_of, own = (100.0 / 0.05) ** 2, 1.0 / 0.003**2
    y = -0.02 * ridge_of / (ridge_of + own)
    sd = 1.0 / np.sqrt(ridge_of + own)
    assert abs(found.x[1] - y) < 0.1 * sd and abs(found.covariance[1, 1] / sd**2 - 1.0) < 0.05
    slope = (2.0 + 100.0 * y) / 0.05**2
    assert abs(found.covariance[0, 0] * slope**2 - 1.0) < 0.2


def test_where_nothing_is_a_top_none_is_claimed() -> None:
    start = np.array([0.0, 0.0])
    found = summit(lambda p: p[..., 0] * 0.01, lambda x: None, start, np.ones(2), np.ones(2), FREE)
    assert not found.is_settled and found.x[0] > 1.0


@pytest.mark.parametrize("step", [(0.8, 6e-5), (3.0, 9e-5), (1e-6, 1e-9), (5.0, 0.05)])
def test_a_start_on_the_top_itself_is_found_to_be_one(step: tuple[float, float]) -> None:
    """No move goes up from there, however short: steps that are too short are to grow again."""
    found = summit(ridge, lambda x: None, np.array([40.0 + 1e-5, 1e-8]), np.array(step), np.array([8.0, 4.5e-3]), FREE)
    assert found.is_settled
    assert np.allclose(np.sqrt(np.diag(found.covariance)), [0.303, 0.003], rtol=0.1)
