"""Error and efficiency of a render of the bench bubble.

usage: efficiency.py REFERENCE.npy IMAGE.npy SECONDS       both (height, width, 3) linear sRGB, row 0 on top

relMSE      = mean of (x - reference)^2 / (reference^2 + 0.01) over the disc of the bubble and the three channels
efficiency  = 1 / (relMSE x wall seconds of the whole process)

Error falls as 1 / samples for a plain Monte Carlo, so efficiency does not depend on how many samples were taken there;
stratified samples do better than that and their efficiency grows.
"""

from __future__ import annotations

import sys

import numpy as np

FOV_DEG = 35.0  # full vertical angle of the bench camera
DISTANCE = 4.0  # camera to centre, in radii
RIM = 0.985  # the outermost 1.5 % of the disc, where a pixel straddles the limb, is left out
FLOOR = 0.01  # keeps dark pixels from ruling the mean; linear sRGB squared


def bubble_disc(height: int, width: int) -> np.ndarray:
    """(height, width) bool: pixels whose centre sees the bubble."""
    row, column = np.mgrid[0:height, 0:width]
    half = np.tan(np.radians(FOV_DEG / 2.0))
    x = (2.0 * (column + 0.5) / width - 1.0) * half * width / height
    y = (2.0 * (row + 0.5) / height - 1.0) * half
    return np.hypot(x, y) < RIM * np.tan(np.arcsin(1.0 / DISTANCE))


def relative_mse(image: np.ndarray, reference: np.ndarray) -> float:
    """relMSE over the disc; images (height, width, 3)."""
    if image.shape != reference.shape:
        raise ValueError(f"image and reference must have one shape, got {image.shape} and {reference.shape}")
    disc = bubble_disc(*image.shape[:2])
    wanted = reference.astype(np.float64)[disc]
    difference = image.astype(np.float64)[disc] - wanted
    return float(np.mean(difference**2 / (wanted**2 + FLOOR)))


def efficiency(image: np.ndarray, reference: np.ndarray, seconds: float) -> float:
    """1 / (relMSE x seconds)."""
    return 1.0 / (relative_mse(image, reference) * seconds)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    wanted, got, wall = np.load(sys.argv[1]), np.load(sys.argv[2]), float(sys.argv[3])
    print(f"relMSE {relative_mse(got, wanted):.3e}  seconds {wall:.3f}  efficiency {efficiency(got, wanted, wall):.1f}")
