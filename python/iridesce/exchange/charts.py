"""Charts of thickness against angle, and how far one is from another: CIEDE2000 on a common scale. Internal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.exchange.films import ANGLES_DEG, Film

Summary = dict[str, float | dict[float, float]]


def truth(film: Film, quantity: str = "reflectance") -> Floats:
    """The chart of a film, XYZ: the seven angles from the top, thicknesses across."""
    return film.xyz(film.thicknesses()[None, :], np.array(ANGLES_DEG)[:, None], quantity)


def differences(seen: Floats, true: Floats, white: color.Illuminant) -> Floats:
    """CIEDE2000 of each entry, both sides multiplied by 1 / (largest Y of the true chart): films are dim."""
    peak = float(true[..., 1].max())
    scale = 1.0 / peak if peak > 0.0 else 1.0
    a, b = (color.convert(np.asarray(side) * scale, "xyz", "lab", white=white) for side in (seen, true))
    return np.asarray(color.delta_e(a, b))


def summary(values: Floats, claims_deg: Sequence[float] = ANGLES_DEG) -> Summary:
    """mean, p95 and max over the angles that a target claims, and the mean at each angle of a chart of differences."""
    claimed = values[[angle in claims_deg for angle in ANGLES_DEG]]
    return {
        "mean": float(claimed.mean()),
        "p95": float(np.percentile(claimed, 95.0)),
        "max": float(claimed.max()),
        "by_angle": {angle: float(row.mean()) for angle, row in zip(ANGLES_DEG, values, strict=True)},
    }
