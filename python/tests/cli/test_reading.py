"""Words of the command line about what was typed and what was drawn."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import iridesce as ir
from iridesce.cli.reading import wavelength_grid, wavelengths_of
from iridesce.cli.verbs.render import _summary


def test_a_refusal_names_the_option_that_was_typed() -> None:
    with pytest.raises(ValueError, match="TO of --spectral must not be below FROM of --spectral, got 700 to 400 nm"):
        wavelengths_of("700:400:50")
    with pytest.raises(ValueError, match="STEP of --spectral must be > 0"):
        wavelengths_of("400:700:0")
    with pytest.raises(ValueError, match="--to must not be below --from"):
        wavelength_grid(700.0, 400.0, 10.0)


def test_sizes_that_differ_are_told_whole() -> None:
    pictures = [
        ir.render("newtons-rings", size=size, samples=1, seed=seed) for size, seed in (((6, 4), 1), ((6, 5), 2))
    ]
    with pytest.raises(ValueError, match=r"cannot be merged: size \[6, 4\] and \[6, 5\]"):
        ir.merge(pictures)


def test_colours_outside_a_screen_are_told_for_the_screen_that_was_asked(tmp_path: Path) -> None:
    image = ir.render("newtons-rings-sodium", size=(4, 4), samples=1)
    for space, gamut, words in (
        ("srgb", "hue", r"outside sRGB.*\(hue kept in the .png\)"),
        ("display-p3", "clip", r"outside Display P3.*\(cut off in the .png\)"),
    ):
        image.save(tmp_path / "x.png", space=space, gamut=gamut)
        assert re.search(words, _summary(image, 0.0))
