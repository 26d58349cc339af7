"""Every built-in scene against stored means of its blocks, with their errors (tools/data/scene_references.py makes them)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from iridesce.scene import scene_names

STORED = json.loads((Path(__file__).parents[1] / "data" / "scene_references.json").read_text())
SIZE, BLOCK, SAMPLES = (32, 24), 8, 4
#: Hardly ever reached by chance: blocks of noisy scenes are skewed, and their spread is itself known from 24 pictures
#: (Student's t).
MOST_Z, MOST_BIAS = 7.0, 5.0


def deviations(name: str, factor: float = 1.0) -> tuple[float, float]:
    """Of one picture: the largest z of its blocks, and that of their sum, block by block weighed by its spread."""
    xyz = factor * np.asarray(ir.render(name, size=SIZE, samples=SAMPLES, seed=77).xyz, dtype=np.float64)
    rows, columns = SIZE[1] // BLOCK, SIZE[0] // BLOCK
    blocks = xyz.reshape(rows, BLOCK, columns, BLOCK, 3).mean(axis=(1, 3)).ravel()
    mean, error, deviation = (np.array(STORED[name][key]) for key in ("mean", "error", "deviation"))
    # Wider machine words round otherwise, and stored numbers have four digits.
    spread = np.sqrt(error**2 + deviation**2 + (3e-4 * mean) ** 2 + 1e-12)
    z = (blocks - mean) / spread
    # X, Y and Z of a block go together.
    bias = z.reshape(-1, 3).mean(axis=1).sum() / (z.size / 3) ** 0.5
    return float(np.abs(z).max()), abs(float(bias))


@pytest.mark.parametrize("name", scene_names())
def test_scenes_are_as_they_were(name):
    worst, bias = deviations(name)
    assert worst < MOST_Z
    assert bias < MOST_BIAS


@pytest.mark.parametrize("name", ["soap-bubble", "wafer"])
def test_a_picture_that_is_brighter_by_six_percent_is_seen(name):
    worst, bias = deviations(name, 1.06)
    assert worst > MOST_Z or bias > MOST_BIAS
