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


def test_ghosts_on_the_table_of_the_coated_lens_are_no_bright_pixels():
    """A face of the lens mirrors a hundredth of the windows onto the table, 60 times as bright as it. Left to chance down to
    a quarter of what the table sends on, a sample that finds one adds five times the mean of the picture to its pixel;
    at a tenth, two."""
    mean = 0.127  # of Y over the whole picture
    for seed in range(1, 9):
        image = ir.render("coated-lens", size=(160, 120), samples=8, seed=seed, crop=(40, 102, 70, 18))
        assert np.asarray(image.xyz)[..., 1].max() < 5.0 * mean
