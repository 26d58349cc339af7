"""Make the stored films of the built-in scenes anew: python tools/data/stored_films.py

The list below must match the one in crates/scene/src/films.rs, which says how they are kept. Another machine's last
digits differ and grow as a film stirs itself, by far less than a nanometre in these times.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

from iridesce import _core

FOLDER = Path(__file__).resolve().parents[2] / "crates" / "scene" / "films"
STEP_NM = 0.1
STORED = {"free-bubble": (0.8, 1), "bubble-on-bath": (4.0, 1), "vertical-film": (4.0, 1)}


def main() -> None:
    for preset, (time_s, seed) in STORED.items():
        start = time.perf_counter()
        columns = int(_core.Flow(preset, None, seed, [], None, None, None).thickness_nm().shape[1])
        film = _core.Flow(preset, None, seed, [], None, None, None)
        for step in range(1, round(time_s / 0.005) + 1):
            film.advance_to(step * 0.005, None)
        steps = np.round(film.map(None) / STEP_NM)
        Image.fromarray(steps.astype(np.uint16)).save(FOLDER / f"{preset}.png", optimize=True)
        share = film.black_share()
        if share is not None:
            black = np.round(share * 255.0).astype(np.uint8)
            Image.fromarray(black).save(FOLDER / f"{preset}-black.png", optimize=True)
        size = sum(path.stat().st_size for path in FOLDER.glob(f"{preset}*.png"))
        print(
            f"{preset} {time_s:g} s, {columns} columns: {time.perf_counter() - start:.1f} s, {size} bytes",
            file=sys.stderr,
        )


if __name__ == "__main__":
    main()
