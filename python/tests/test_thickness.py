"""Thickness models and maps: the power law, sampling, refusals."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import iridesce as ir

RNG = np.random.default_rng(11)


def test_the_power_law():
    model = ir.thickness.gradient(top=20.0, bottom=900.0, exponent=0.8)
    s = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(model.at_height(s), 900.0 + (20.0 - 900.0) * s**0.8, rtol=1e-14)
    assert model.at_height(s.reshape(1, 101, 1)).shape == (1, 101, 1)
    assert isinstance(model.at_height(0.5), float)
    assert model.at_height([]).shape == (0,)
    assert (model.at_height(-1.0), model.at_height(2.0)) == (900.0, 20.0), "clamped"
    backwards = s[::-1]
    np.testing.assert_array_equal(model.at_height(backwards), model.at_height(s)[::-1])
    np.testing.assert_array_equal(ir.thickness.uniform(320.0).at_height(s), 320.0)


def test_a_map_has_the_model_at_the_middles_of_its_cells():
    model = ir.thickness.gradient(100.0, 900.0, 2.0)
    grid = model.map(3, 5)
    assert (grid.width, grid.height, grid.thickness_nm.shape, grid.thickness_nm.dtype) == (3, 5, (5, 3), np.float64)
    for row in range(5):
        np.testing.assert_allclose(grid.thickness_nm[row], model.at_height(1.0 - (row + 0.5) / 5), rtol=1e-15)
    assert not grid.thickness_nm.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        grid.thickness_nm[0, 0] = 1.0


def test_sampling_is_bilinear():
    values = RNG.uniform(0.0, 1000.0, (7, 4))
    grid = ir.thickness.ThicknessMap(values)
    v, u = np.mgrid[0:7, 0:4]
    np.testing.assert_allclose(grid.sample((u + 0.5) / 4, 1.0 - (v + 0.5) / 7), values, rtol=1e-12)
    # Between middles: against weights written out.
    x, y = RNG.uniform(0.0, 3.0, 50), RNG.uniform(0.0, 6.0, 50)
    i, j = x.astype(int), y.astype(int)
    fx, fy = x - i, y - j
    expected = (
        values[j, i] * (1 - fx) * (1 - fy)
        + values[j, i + 1] * fx * (1 - fy)
        + values[j + 1, i] * (1 - fx) * fy
        + values[j + 1, i + 1] * fx * fy
    )
    np.testing.assert_allclose(grid.sample((x + 0.5) / 4, 1.0 - (y + 0.5) / 7), expected, rtol=1e-12)
    assert grid.sample(-3.0, 2.0) == values[0, 0]
    assert grid.sample(np.zeros((2, 1)), np.zeros(3)).shape == (2, 3)
    assert isinstance(grid.sample(0.5, 0.5), float)


def test_maps_take_any_array_and_keep_their_own():
    values = np.asfortranarray(np.arange(12, dtype=np.float32).reshape(3, 4))[:, ::-1]
    values.flags.writeable = False
    grid = ir.thickness.ThicknessMap(values)
    np.testing.assert_array_equal(grid, values)
    own = np.ones((2, 2))
    grid = ir.thickness.ThicknessMap(own)
    own[:] = 5.0
    assert grid.thickness_nm.max() == 1.0
    assert np.array(grid, copy=True).flags.writeable
    assert ir.thickness.ThicknessMap([[1, 2]]).thickness_nm.tolist() == [[1.0, 2.0]]


def test_maps_and_models_are_values():
    grid, model = ir.thickness.gradient(1.0, 2.0).map(2, 2), ir.thickness.gradient(1.0, 2.0)
    assert grid == ir.thickness.gradient(1.0, 2.0).map(2, 2)
    assert grid != ir.thickness.uniform(1.0).map(2, 2)
    assert model == ir.thickness.gradient(1, 2, exponent=1)
    assert model != ir.thickness.gradient(1, 2, exponent=2)
    assert model != ir.thickness.uniform(1.0)
    for value in (grid, model, ir.thickness.uniform(3.5)):
        again = pickle.loads(pickle.dumps(value))
        assert again == value
        assert hash(again) == hash(value)
        assert repr(again) == repr(value)
    assert eval(repr(model), vars(ir.thickness)) == model


def test_a_map_colours_a_film():
    grid = ir.thickness.gradient(100.0, 700.0).map(2, 5)
    colors = ir.Stack(["air", ir.Layer("soap", thickness_nm=grid), "air"]).color()
    assert colors.shape == (5, 2, 3)
    one = ir.Stack(["air", ir.Layer("soap", thickness_nm=float(grid.thickness_nm[3, 1])), "air"]).color()
    np.testing.assert_allclose(colors[3, 1], one, rtol=1e-12)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, "3", b"3", None, [1.0], 1j, True, 10**400])
def test_bad_parameters_are_named(bad):
    with pytest.raises(ValueError, match="thickness_nm must be"):
        ir.thickness.uniform(bad)
    with pytest.raises(ValueError, match="top must be"):
        ir.thickness.gradient(bad, 1.0)
    with pytest.raises(ValueError, match="bottom must be"):
        ir.thickness.gradient(1.0, bad)
    with pytest.raises(ValueError, match="exponent must be"):
        ir.thickness.gradient(1.0, 1.0, bad)


def test_an_exponent_of_zero_is_refused():
    with pytest.raises(ValueError, match=r"exponent must be a finite exponent > 0, got 0\.0"):
        ir.thickness.gradient(1.0, 2.0, 0.0)


def test_bad_coordinates_are_named_with_their_place():
    model = ir.thickness.gradient(1.0, 2.0)
    with pytest.raises(ValueError, match=r"s must be finite, got nan at index \(1, 0\)"):
        model.at_height([[0.0, 1.0], [math.nan, 1.0]])
    with pytest.raises(ValueError, match=r"s must be finite, got inf$"):
        model.at_height(math.inf)
    for bad in ("0.5", [None], 1j, [[0.0], [0.0, 1.0]]):
        with pytest.raises(ValueError, match="s must be real numbers"):
            model.at_height(bad)
    grid = model.map(2, 2)
    with pytest.raises(ValueError, match=r"v must be finite, got nan at index \(1,\)"):
        grid.sample(0.0, [0.0, math.nan])
    with pytest.raises(ValueError, match=r"u and v must broadcast: shapes \(2,\) and \(3,\)"):
        grid.sample([0.0, 1.0], [0.0, 1.0, 0.5])


@pytest.mark.parametrize("size", [(0, 1), (1, 0), (-1, 1), (1.5, 1), ("2", 1), (None, 1), (math.nan, 1)])
def test_bad_sizes(size):
    with pytest.raises(ValueError, match="must be a whole number >= 1"):
        ir.thickness.uniform(1.0).map(*size)


def test_a_map_that_cannot_fit():
    with pytest.raises(ir.ResourceError, match="1073741824 cells"):
        ir.thickness.uniform(1.0).map(10**6, 10**6)
    with pytest.raises(ir.ResourceError):
        ir.thickness.uniform(1.0).map(2**70, 2**70)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (3.0, r"shape \(height, width\), both >= 1, got \(\)"),
        ([1.0, 2.0], r"got \(2,\)"),
        (np.zeros((2, 0)), r"got \(2, 0\)"),
        (np.zeros((2, 2, 2)), r"got \(2, 2, 2\)"),
        ([[1.0, math.nan]], "at row 0, column 1"),
        ([[1.0], [-2.0]], r"got -2\.0 at row 1, column 0"),
        ([[1.0, math.inf]], "at row 0, column 1"),
        ([["a"]], "must be real numbers"),
        ([[1j]], "must be real numbers"),
        (None, "must be real numbers"),
    ],
)
def test_bad_maps(values, said):
    with pytest.raises(ValueError, match=said):
        ir.thickness.ThicknessMap(values)


def test_the_renderer_sees_the_same_thickness():
    """The plane `thickness_nm` of a picture is the model at the height of what is seen there."""
    model = ir.thickness.gradient(100.0, 900.0, 0.6)
    tree = {
        "version": 1,
        "camera": {"orthographic_height": 2.0, "resolution": [65, 65]},
        "object": [{"shape": {"sphere": {"radius": 1.0}}, "surface": {"film": {"thickness_nm": model}}}],
        "light": [{"environment": {"illuminant": "E"}}],
    }
    column = ir.render(tree, samples=1).channels["thickness_nm"][:, 32]
    height = 1.0 - (np.arange(65) + 0.5) / 65
    np.testing.assert_allclose(column[1:-1], model.at_height(height)[1:-1], rtol=0.0, atol=12.0)
