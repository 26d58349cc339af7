"""z-tests for images: many pixels, one question."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ROUND_OFF = (
    2e-6  # relative; float32 sums of many terms, so a noise-free pixel is not asked for more than its arithmetic
)


@dataclass(frozen=True)
class ZTest:
    """How far a mean image lies from the wanted one in units of its own standard error."""

    worst: float  # largest |z| over all pixels
    limit: float  # what |z| stays below in all pixels with probability 0.9999 if nothing is wrong
    mean_square: float  # mean of z^2: near 1 if the images are independent, more if their errors agree
    bias: float  # z of the whole image's mean, which sees a small error shared by all pixels

    def passes(self) -> bool:
        """No pixel, nor the whole, is further off than chance allows (probability of a false alarm about 1 in 5000)."""
        return self.worst < self.limit and abs(self.bias) < 4.0 and 0.6 < self.mean_square < 1.5


def z_test(
    images: NDArray[np.floating], wanted: NDArray[np.floating], wanted_error: NDArray[np.floating] | float = 0.0
) -> ZTest:
    """``images`` (n, ...) independent estimates of ``wanted`` (...), whose own standard error is ``wanted_error``.

    The limit corrects for the number of pixels (Sidak) and for the spread being estimated from n images (Student's t,
    through the expansion of Abramowitz & Stegun 26.7.5).
    """
    images = images.astype(np.float64)
    count = len(images)
    mean = images.mean(axis=0)
    square = images.var(axis=0, ddof=1) / count + np.asarray(wanted_error) ** 2 + (ROUND_OFF * np.abs(wanted)) ** 2
    z = (mean - wanted) / np.sqrt(square)
    per_image = images.reshape(count, -1).mean(axis=1)
    floor = ROUND_OFF * abs(float(np.mean(wanted)))
    mean_error = float(np.mean(np.asarray(wanted_error)))  # fully shared between pixels at worst
    spread = np.sqrt(per_image.var(ddof=1) / count + mean_error**2 + floor**2)
    return ZTest(
        worst=float(np.abs(z).max()),
        limit=_student_limit(z.size, count - 1),
        mean_square=float(np.mean(z**2)),
        bias=float((per_image.mean() - np.mean(wanted)) / spread),
    )


def _student_limit(pixels: int, degrees: int, false_alarm: float = 1e-4) -> float:
    from statistics import NormalDist

    x = NormalDist().inv_cdf(1.0 - false_alarm / (2.0 * pixels))
    return (
        x
        + (x**3 + x) / (4 * degrees)
        + (5 * x**5 + 16 * x**3 + 3 * x) / (96 * degrees**2)
        + (3 * x**7 + 19 * x**5 + 17 * x**3 - 15 * x) / (384 * degrees**3)
    )
