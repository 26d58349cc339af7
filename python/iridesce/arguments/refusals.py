"""Errors with parts: what Python's own checks raise, in the words of the core."""

from __future__ import annotations

from iridesce.errors import ArgumentError


def refusal(argument: str, allowed: str, given: object, place: str = "") -> ArgumentError:
    """``argument must be allowed, got given place``; ``given`` is shown as Python writes it, a `Words` as it is.

    >>> refusal("samples", "a whole number >= 1", 0.5)
    ArgumentError('samples must be a whole number >= 1, got 0.5')
    """
    from iridesce import _core

    shown = str(given) if isinstance(given, Words) else short(given)
    place = place.strip()
    return ArgumentError(_core.argument_words(argument, allowed, shown, place), argument, allowed, shown, place)


class Words(str):
    """What was given, in words of ours: ``shape (3, 4)``."""


def short(value: object) -> str:
    """A value as Python writes it, cut at 60 characters."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
