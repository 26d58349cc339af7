"""Writes python/tests/data/scene_references.json: every built-in scene, and how much one picture may differ from it.

python tools/data/scene_references.py [SCENE]...        some minutes; scenes that are named are made anew, the others stay

Each scene is drawn 32 x 24 pixels, and blocks of 8 x 8 pixels are kept: the mean of X, Y, Z over many seeds, its standard
error, and the standard deviation of a picture of SAMPLES samples a pixel. `python/tests/rendering/test_scene_references.py`
holds one such picture against them.
"""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import iridesce as ir
from iridesce.scene import scene_names

PATH = Path(__file__).resolve().parents[2] / "python" / "tests" / "data" / "scene_references.json"
SIZE, BLOCK, SAMPLES, SEEDS, MANY = (32, 24), 8, 4, 24, 32


def blocks(image: ir.Image) -> NDArray[np.float64]:
    """(3, 4, 3): rows, columns, XYZ."""
    xyz = np.asarray(image.xyz, dtype=np.float64)
    height, width = xyz.shape[:2]
    return xyz.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean(axis=(1, 3))


def reference(name: str) -> dict[str, Any]:
    scene = ir.Scene.load(name)

    def drawn(samples: int, first: int) -> NDArray[np.float64]:
        seeds = range(first, first + SEEDS)
        return np.array([blocks(ir.render(scene, size=SIZE, samples=samples, seed=seed)) for seed in seeds])

    few, many = drawn(SAMPLES, 1000), drawn(MANY, 2000)
    rounded = {
        "mean": many.mean(axis=0),
        "error": many.std(axis=0, ddof=1) / SEEDS**0.5,
        "deviation": few.std(axis=0, ddof=1),
    }
    return {key: [float(f"{value:.4g}") for value in values.ravel()] for key, values in rounded.items()}


def main() -> None:
    warnings.simplefilter("ignore")
    stored = json.loads(PATH.read_text()) if PATH.exists() else {}
    for name in sys.argv[1:] or scene_names():
        stored[name] = reference(name)
        print(name, flush=True)
        text = json.dumps(dict(sorted(stored.items())), separators=(",", ":"))
        PATH.write_text(text.replace('},"', '},\n"') + "\n")


if __name__ == "__main__":
    main()
