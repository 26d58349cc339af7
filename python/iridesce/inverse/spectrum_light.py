"""What is known of the light of a series, before and after it is looked at, and the films that may be. Internal."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats
from iridesce.inverse.solve import student

# The size of a spectrum, relative: before anything is learnt, and never known better than this.
LEVEL, _LEAST_LEVEL = 0.4, 0.03


@dataclass(frozen=True)
class Light:
    """What is known of the lamp before the series is looked at."""

    lamp: Floats | None
    """Its course where it is known (ones, for referenced data), else None."""
    gain: float | None
    stray: bool


@dataclass
class Found:
    """Candidates of every spectrum, (spectra, candidates), NaN where there are fewer."""

    thickness_nm: Floats
    sd_nm: Floats
    log_mass: Floats
    none: Floats
    """Log evidence of no film."""
    kappa: Floats


def least_of(rows: npt.NDArray[np.intp], costs: Floats, none: Floats) -> Floats:
    """The least of each row's costs and of no film's."""
    out = none.copy()
    np.minimum.at(out, rows, costs)
    return out


def size_of_light(gains: Floats) -> tuple[float, float]:
    """The size of the next spectrum, and its relative standard deviation, from those of some, in the order of time.

    Of few little is known: as Student's distribution is wider than the normal one. What the last third has more than the first
    may go on.
    """
    middle = float(np.median(gains))
    relative = gains / middle
    count, third = len(gains), max(len(gains) // 3, 1)
    sd = (
        float(np.std(relative, ddof=1)) * student(0.95, count - 1.0) / student(0.95, 1e6) * math.sqrt(1.0 + 1.0 / count)
    )
    trend = float(relative[-third:].mean() - relative[:third].mean())
    return middle, min(max(math.hypot(sd, trend), _LEAST_LEVEL), LEVEL)
