"""Single values as they come from users: words, numbers, whole numbers; each check once."""

from __future__ import annotations


def text(name: str, value: object) -> str:
    """A string as it is."""
    if not isinstance(value, str):
        raise ValueError(f"{name} must be a string, got {value!r}")
    return value


def optional_text(name: str, value: object) -> str | None:
    """A string, or ``None``."""
    return None if value is None else text(name, value)
