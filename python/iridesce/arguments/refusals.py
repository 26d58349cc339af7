"""Errors with parts: what Python's own checks raise, in the words of the core.

Every `ValueError` about an argument is made here. What `_core` finds wrong comes with the same parts.
"""

from __future__ import annotations

from iridesce.errors import ArgumentError


def refusal(argument: str, allowed: str, given: object, place: str = "", *, must: str = "be") -> ArgumentError:
    """``argument must be allowed, got given place``; ``given`` is shown as Python writes it, a `Words` as it is.

    Where another verb reads better it is ``must``, and the part ``allowed`` of the error begins with it.

    >>> refusal("samples", "a whole number >= 1", 0.5)
    ArgumentError('samples must be a whole number >= 1, got 0.5')
    >>> error = refusal("depth_nm", "one axis", Words("shape (2, 3)"), must="have")
    >>> print(error, error.allowed, sep="\\n")
    depth_nm must have one axis, got shape (2, 3)
    have one axis
    """
    from iridesce import _core

    place = place.strip()
    words = _core.argument_words(argument, allowed, _shown(given), place)
    if must != "be":
        words, allowed = words.replace(" must be ", f" must {must} ", 1), f"{must} {allowed}"
    return ArgumentError(words, argument, allowed, _shown(given), place)


def complaint(words: str, argument: str, allowed: str, given: object, place: str = "") -> ArgumentError:
    """A sentence of its own with the same parts: where two arguments do not go together, or the way out is longer.

    >>> error = complaint("give samples or target_noise, not both", "samples", "left out beside target_noise", 64)
    >>> print(error, error.argument, error.given, sep="\\n")
    give samples or target_noise, not both
    samples
    64
    """
    return ArgumentError(words, argument, allowed, _shown(given), place.strip())


def within(where: str, error: ValueError) -> ValueError:
    """The same error at a place that is named before its words, as in ``item 2: thickness_nm must be ...``.

    >>> within("item 2", refusal("thickness_nm", ">= 0 and finite", -1.0))
    ArgumentError('item 2: thickness_nm must be >= 0 and finite, got -1.0')
    """
    if not isinstance(error, ArgumentError):
        return ValueError(f"{where}: {error}")
    place = f"in {where} {error.place}".strip()
    return ArgumentError(f"{where}: {error}", error.argument, error.allowed, error.given, place)


class Words(str):
    """What was given, in words of ours: ``shape (3, 4)``."""


def short(value: object) -> str:
    """A value as Python writes it, cut at 60 characters."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _shown(given: object) -> str:
    return str(given) if isinstance(given, Words) else short(given)
