"""Write the studio light of the bench: a dim gradient with six soft boxes, latitude-longitude, linear Rec.709.

usage: studio.py FOLDER

FOLDER/studio.exr        y up: row 0 looks to +y, the middle column to -z, columns grow towards +x (what iridesce reads)
FOLDER/studio_zup.exr    the same light for a z-up world whose camera stands on -y and looks to +y (what the peer reads)

Needs numpy only; the EXR writer is that of the tests' oracles.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python" / "tests"))
from oracles.environment import write_exr

# (first and last column as shares of the width, lowest and highest elevation in degrees, linear Rec.709 radiance)
SOFT_BOXES = [
    (0.60, 0.69, 0.0, 55.0, (14.0, 14.0, 14.0)),
    (0.82, 0.87, -20.0, 50.0, (9.0, 9.0, 9.0)),
    (0.735, 0.765, 60.0, 80.0, (25.0, 24.0, 22.0)),
    (0.02, 0.10, -5.0, 45.0, (6.0, 6.4, 7.0)),
    (0.40, 0.46, 5.0, 40.0, (5.0, 4.8, 4.4)),
    (0.20, 0.23, -30.0, -10.0, (3.0, 3.0, 3.0)),
]
EDGE_COLUMNS = 0.004  # a box fades in over this share of the width
EDGE_DEG = 1.0  # and over this elevation


def studio_z_up(height: int = 512, width: int = 1024) -> np.ndarray:
    """(height, width, 3) float32 radiance; a quarter of the width from the left looks to +y, the middle to +x."""
    row, column = np.mgrid[0:height, 0:width]
    u = (column + 0.5) / width
    up = 1.0 - (row + 0.5) / height  # 0 at the nadir, 1 at the zenith
    elevation_deg = (up - 0.5) * 180.0
    image = (0.03 + 0.17 * up**1.5)[..., None] * np.array([0.92, 1.0, 1.12])
    for first, last, low_deg, high_deg, radiance in SOFT_BOXES:
        across = np.clip((u - first) / EDGE_COLUMNS, 0, 1) * np.clip((last - u) / EDGE_COLUMNS, 0, 1)
        along = np.clip((elevation_deg - low_deg) / EDGE_DEG, 0, 1) * np.clip(
            (high_deg - elevation_deg) / EDGE_DEG, 0, 1
        )
        cover = (across * along)[..., None]
        image = image * (1.0 - cover) + cover * np.array(radiance)
    return image.astype(np.float32)


def studio_y_up(height: int = 512, width: int = 1024) -> np.ndarray:
    """The same light turned so that the middle column is what the camera sees straight ahead."""
    return np.roll(studio_z_up(height, width), width // 4, axis=1)


def write_studio(folder: Path) -> None:
    """Write both files into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    write_exr(folder / "studio.exr", studio_y_up())
    write_exr(folder / "studio_zup.exr", studio_z_up())


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    write_studio(Path(sys.argv[1]))
