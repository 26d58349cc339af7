"""Single values: what is taken, and how what is not is told."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from iridesce.arguments.scalars import checked_threads, file_name, number, one_of, optional_whole, text, whole


@pytest.mark.parametrize("value", [3, 3.0, np.float32(3.0), np.int64(3), np.array(3.0)])
def test_numbers(value: Any) -> None:
    assert number("x", value) == 3.0
    assert type(number("x", value)) is float


@pytest.mark.parametrize("value", ["3", b"3", True, np.True_, None, [3.0], np.array([3.0]), 3j, 10**400])
def test_what_is_no_number(value: Any) -> None:
    with pytest.raises(ValueError, match="x must be a number, got "):
        number("x", value)


@pytest.mark.parametrize(
    ("value", "bounds", "said"),
    [
        (-1.0, {"low": 0.0}, "x must be >= 0 and finite, got -1.0"),
        (0.0, {"low": 0.0, "includes_low": False}, "x must be > 0 and finite, got 0.0"),
        (90, {"low": 0.0, "high": 90.0}, "x must be >= 0 and < 90, got 90.0"),
        (math.inf, {"low": 0.0}, "x must be >= 0 and finite, got inf"),
        (math.nan, {"high": 1.0}, "x must be < 1, got nan"),
    ],
)
def test_numbers_out_of_bounds(value: float, bounds: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=r"^x must be ") as caught:
        number("x", value, **bounds)
    assert str(caught.value) == said


def test_whole_numbers() -> None:
    assert whole("n", np.int32(7), 1, 9) == 7
    assert optional_whole("n", None, 1, 9) is None
    assert checked_threads(1024) == 1024
    for value in (0, 10, 3.0, "3", True, np.True_, None, [3]):
        with pytest.raises(ValueError, match="n must be a whole number from 1 to 9, got "):
            whole("n", value, 1, 9)
    with pytest.raises(ValueError, match="threads must be a whole number from 1 to 1024, or None, got 0"):
        checked_threads(0)


def test_words() -> None:
    assert one_of("space", "xyz", ("xyz", "lab")) == text("space", "xyz") == "xyz"
    for value in ("XYZ", None, 1, ["xyz"]):
        with pytest.raises(ValueError, match='space must be "xyz" or "lab", got '):
            one_of("space", value, ("xyz", "lab"))
    with pytest.raises(ValueError, match="name must be a string, got 3"):
        text("name", 3)


def test_file_names() -> None:
    assert file_name(Path("a") / "b.PNG", (".png", ".exr")) == str(Path("a") / "b.PNG")
    assert file_name("a.tif") == "a.tif"
    for value, said in (
        (b"a.png", "must be a file name ending in .png or .exr, got b'a.png'"),
        (3, "a file name ending in .png or .exr, got 3"),
        ("a.gif", "must end in .png or .exr, got"),
    ):
        with pytest.raises(ValueError, match=said):
            file_name(value, (".png", ".exr"))
    for value in ("", "a\0.png"):
        with pytest.raises(ValueError, match="without a zero byte"):
            file_name(value)
