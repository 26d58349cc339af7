"""What is refused: a call, its words, and the parts argument, value, what is allowed and place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from iridesce.errors import ArgumentError

# What is called; its words, where they are not "argument must be allowed, got given place"; the four parts.
Case = tuple[Callable[[], Any], str | None, str, str, str, str]


def check(case: Case) -> None:
    """The call is refused with these parts and these words."""
    call, words, argument, given, allowed, place = case
    with pytest.raises(ArgumentError) as caught:
        call()
    error = caught.value
    assert (error.argument, error.given, error.allowed, error.place) == (argument, given, allowed, place)
    assert str(error) == (words or f"{argument} must be {allowed}, got {given}{' ' * bool(place)}{place}")
