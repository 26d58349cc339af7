"""How pictures are compared with what an oracle says."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


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
