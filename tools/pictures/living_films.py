"""Draw docs/images/living-films.png: films of three presets as time passes, seen from the side.

Run from the root of the repository: python tools/pictures/living_films.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.image import imsave

import iridesce as ir
from iridesce.thickness import ThicknessMap, simulate

SHOWN = {
    "bubble-on-bath-time-lapse": (0.25, 0.75, 1.5, 2.0, 2.5),
    "late": (0.25, 1.0, 2.0, 4.0, 6.0),
    "free-bubble": (0.1, 0.25, 0.5, 1.0, 2.0),
}
SIZE = 180
# Columns, four to a cell or two.
FINE = 1536
ROOM = 8
# The brightest film, about a sixth of the light, becomes white.
WHITE = 0.18


def colors() -> np.ndarray:
    """Linear sRGB of a film from 0 to 4000 nm in steps of 1 nm."""
    film = ir.Layer("soap", thickness_nm=np.arange(4001.0))
    return np.asarray(ir.Stack(["air", film, "air"]).color(space="linear-srgb"))


def view(film: ThicknessMap, dome: bool, table: np.ndarray) -> np.ndarray:
    """A ball of the film, four rays a pixel; encoded, SIZE x SIZE (a dome's lower half left out)."""
    side = 2 * SIZE
    along = (np.arange(side) + 0.5) / SIZE - 1.0
    x, y = np.meshgrid(along, -along)
    seen = (x * x + y * y < 1.0) & ((y > 0.0) | (not dome))
    z = np.sqrt(np.clip(1.0 - x * x - y * y, 0.0, None))
    u = 0.5 + np.arctan2(x, z) / (2 * np.pi)
    v = 0.5 + np.arcsin(np.clip(y, -1.0, 1.0)) / np.pi
    thickness = np.asarray(film.sample(u, v))
    linear = table[np.clip(thickness.round().astype(int), 0, len(table) - 1)] * seen[..., None] / WHITE
    linear = linear.reshape(SIZE, 2, SIZE, 2, 3).mean(axis=(1, 3)).clip(0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def main() -> None:
    """Let the films flow and draw them."""
    table = colors()
    rows = []
    for preset, times in SHOWN.items():
        film = simulate(preset, time_s=max(times), frames_per_second=20, rupture_nm=0.0)
        balls = []
        for frame in film:
            if any(abs(frame.time_s - time) < 1e-9 for time in times):
                balls.append(view(film.map(columns=FINE), "free" not in preset, table))
        row = np.concatenate([np.pad(ball, ((ROOM, ROOM), (ROOM, ROOM), (0, 0))) for ball in balls], axis=1)
        rows.append(row[: SIZE // 2 + 2 * ROOM] if "free" not in preset else row)
    imsave(Path("docs/images/living-films.png"), np.concatenate(rows).clip(0.0, 1.0))


if __name__ == "__main__":
    main()
