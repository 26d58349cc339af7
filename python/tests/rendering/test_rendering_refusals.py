"""What renders refuse: the parts of each message, and its words."""

from __future__ import annotations

import numpy as np
import pytest

import iridesce as ir
from iridesce.rendering.animation import camera_path
from refused import Case, check

ONE = {"samples": 1, "size": (2, 2)}
SCENE = "soap-bubble"
GREY = np.ones((2, 3, 3))
PICTURE = ir.Image(GREY)
STOPS = 'a number of stops from -64 to 64 or "auto"'


def _ragged() -> str:
    """numpy's own words, which differ from release to release."""
    with pytest.raises(ValueError, match="sequence") as caught:
        np.asarray([[1.0], [1.0, 2.0]])
    return str(caught.value)


RAGGED = _ragged()

CASES: list[Case] = [
    (lambda: ir.merge("a.exr"), None, *("images", "'a.exr'", "a list of two images or paths at least", "")),
    (lambda: ir.merge([ir.Image(np.ones((1, 1, 3)))]), None, *("images", "1", "two at least", "")),
    (
        lambda: ir.render(SCENE, **ONE, backend="gpu"),
        None,
        *("backend", "'gpu'", '"cpu"', "(this iridesce has no GPU back end built in)"),
    ),
    (lambda: ir.render(SCENE, **ONE, backend="tpu"), None, *("backend", "'tpu'", '"cpu"', "")),
    (
        lambda: ir.render(SCENE, **ONE, spectral_nm="blue"),
        None,
        *("spectral_nm", "'blue'", "ascending wavelengths in nm, (wavelengths,)", ""),
    ),
    (
        lambda: ir.render(SCENE, **ONE, spectral_nm=[]),
        None,
        *("spectral_nm", "[]", "one wavelength at least, or None", ""),
    ),
    (lambda: ir.render(SCENE, **ONE, stokes=3), None, *("stokes", "3", "True or False", "")),
    (
        lambda: ir.render(SCENE, **ONE, crop=(0, 0, 1)),
        None,
        *("crop", "(0, 0, 1)", "(x, y, width, height), four whole numbers from 0 on, or None", ""),
    ),
    (
        lambda: ir.render(SCENE, samples=1, size=(2, 0)),
        None,
        *("size", "(2, 0)", "(width, height), two whole numbers of at least 1, or None", ""),
    ),
    (
        lambda: ir.render(SCENE, samples=1, size=3),
        None,
        *("size", "3", "(width, height), two whole numbers of at least 1, or None", ""),
    ),
    (
        lambda: camera_path({"fov_deg": 35.0}, 1.0, float("inf"), None),
        None,
        *("turn_deg", "inf", "a finite number of degrees", ""),
    ),
    (
        lambda: ir.Image(np.ma.masked_array(GREY, mask=GREY > 2.0)),
        None,
        *("xyz", "a masked array", "an array without a mask", ""),
    ),
    (
        lambda: ir.Image([[1.0], [1.0, 2.0]]),
        "xyz must be an array of numbers, got [[1.0], [1.0, 2.0]]: " + RAGGED,
        *("xyz", "[[1.0], [1.0, 2.0]]", "an array of numbers", ""),
    ),
    (lambda: ir.Image([[["a"]]]), None, *("xyz", "an array of type <U1", "an array of real numbers", "")),
    (
        lambda: ir.Image(GREY[0]),
        None,
        *("xyz", "shape (3, 3)", "of shape (height, width, 3), with at least one pixel", ""),
    ),
    (
        lambda: ir.Image(GREY, depth=np.ones((3, 3))),
        None,
        *("depth", "shape (3, 3)", "of shape (2, 3) like xyz", ""),
    ),
    (
        lambda: ir.Image(GREY, normal=np.ones((2, 3))),
        None,
        *("normal", "shape (2, 3)", "of shape (2, 3, 3) like xyz", ""),
    ),
    (lambda: PICTURE.save("x.png", bits=12), None, *("bits", "12", "8 or 16", "")),
    (lambda: PICTURE.rgb(exposure="bright"), None, *("exposure", "'bright'", STOPS, "")),
    (lambda: PICTURE.rgb(exposure=65.0), None, *("exposure", "65.0", STOPS, "")),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)
