"""Scene dicts for the renderer from what the oracles are given, and how their pictures are compared."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .film_sphere import FilmSphere


def film_sphere_object(sphere: FilmSphere, medium: Any, name: str = "sphere") -> dict[str, Any]:
    """A scene's object table for ``sphere``; ``medium`` is the scene's own word for its index."""
    gradient = {"top": sphere.top_nm, "bottom": sphere.bottom_nm, "exponent": sphere.exponent}
    thickness = sphere.top_nm if sphere.top_nm == sphere.bottom_nm else {"gradient": gradient}
    return {
        "name": name,
        "shape": {"sphere": {"center": list(sphere.center), "radius": sphere.radius}},
        "surface": {"film": {"medium": medium, "thickness_nm": thickness}},
    }


def medium_of(sphere: FilmSphere) -> Any:
    """ "water" for a function of wavelength, a number or [n, k] otherwise."""
    if callable(sphere.index):
        return "water"
    index = complex(sphere.index)
    return [index.real, index.imag] if index.imag else index.real


def scene(
    spheres: Sequence[FilmSphere], camera: dict[str, Any], environment: dict[str, Any], **render: int
) -> dict[str, Any]:
    """A whole scene; ``environment`` is the light's table, ``render`` holds samples, seed, max_depth."""
    return {
        "version": 1,
        "camera": camera,
        "render": render,
        "object": [film_sphere_object(s, medium_of(s), f"sphere-{i}") for i, s in enumerate(spheres)],
        "light": [{"environment": environment}],
    }


def relative_error(got: NDArray[np.floating], wanted: NDArray[np.floating]) -> NDArray[np.float64]:
    """(height, width): the largest relative error of X, Y and Z in each pixel."""
    wanted = np.asarray(wanted, dtype=float)
    assert got.shape == wanted.shape, f"picture of shape {got.shape}, wanted {wanted.shape}"
    assert np.isfinite(got).all(), "the picture holds NaN or infinity"
    return np.asarray(np.abs(got.astype(float) - wanted) / np.abs(wanted)).max(axis=-1)


def report(got: NDArray[np.floating], wanted: NDArray[np.floating], limit: float) -> str:
    """Share of pixels within ``limit`` and the worst pixel, in words."""
    error = relative_error(got, wanted)
    row, column = np.unravel_index(np.argmax(error), error.shape)
    return (
        f"{100 * np.mean(error <= limit):.2f} % of pixels within {100 * limit:.2f} %, median {np.median(error):.2e}, "
        f"99th percentile {np.percentile(error, 99):.2e}; worst {error.max():.2e} at row {row}, column {column}: "
        f"got {got[row, column]}, wanted {wanted[row, column]}"
    )
