"""Single values as they come from users: words, numbers, whole numbers, file names; each check once.

Every error names the argument, says what is allowed, and what was given.
"""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Sequence
from typing import Any

from iridesce.arguments.refusals import complaint, refusal

MOST_THREADS = 1024
MOST_STOPS = 64.0
"""An exposure is within so many stops, as the core has it (`develop.rs`)."""


def text(name: str, value: object) -> str:
    """A string as it is."""
    if not isinstance(value, str):
        raise refusal(name, "a string", value)
    return value


def optional_text(name: str, value: object) -> str | None:
    """A string, or ``None``."""
    return None if value is None else text(name, value)


def shown(given: str, most: int = 60) -> str:
    """A text of unknown origin as part of a message: what a terminal would obey is escaped, and the rest cut.

    >>> shown("a\\x1b[2Jb"), shown("x" * 99, most=5)
    ('a\\\\x1b[2Jb', 'xxxxx...')
    """
    cut = given[:most] + ("..." if len(given) > most else "")
    return "".join(x if x.isprintable() else x.encode("unicode_escape").decode("ascii") for x in cut)


def one_of(name: str, value: object, allowed: Sequence[str]) -> str:
    """``value`` where it is one of the words, else a ``ValueError`` that lists them."""
    if isinstance(value, str) and value in allowed:
        return value
    quoted = [f'"{word}"' for word in allowed]
    raise refusal(name, f"{', '.join(quoted[:-1])} or {quoted[-1]}", value)


def number(
    name: str, value: Any, *, low: float = -math.inf, high: float = math.inf, includes_low: bool = True
) -> float:
    """A plain number; where bounds are given a finite one within [low, high), or (low, high)."""
    # float("3") and float(array([3])) would pass, but are slips; so are True and False.
    try:
        # numpy's complex numbers lose their imaginary part in float(), and its masked ones become NaN, both with a warning.
        kind = getattr(getattr(value, "dtype", None), "kind", "f")
        is_slip = kind not in "iufO" or hasattr(value, "mask") or getattr(value, "ndim", 0) != 0
        if isinstance(value, str | bytes) or is_bool(value) or is_slip:
            raise TypeError
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        raise refusal(name, "a number", value) from None
    bounded = low > -math.inf or high < math.inf
    if bounded and not (math.isfinite(found) and (found >= low if includes_low else found > low) and found < high):
        raise refusal(name, allowed_range(low, high, includes_low), found)
    return found


def whole(name: str, value: object, least: int, most: int, *, optional: bool = False) -> int:
    """A whole number within bounds; ``optional`` only tells that None would have been allowed."""
    try:
        found = None if is_bool(value) else operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        found = None
    if found is None or not least <= found <= most:
        raise refusal(name, f"a whole number from {least} to {most}{', or None' if optional else ''}", value)
    return found


def optional_whole(name: str, value: object, least: int, most: int) -> int | None:
    """``None``, or a whole number within bounds."""
    return None if value is None else whole(name, value, least, most, optional=True)


def checked_threads(threads: object) -> int | None:
    """``None`` (all cores), or a count from 1 to 1024."""
    return optional_whole("threads", threads, 1, MOST_THREADS)


def file_name(path: object, endings: Sequence[str] = ()) -> str:
    """A path as a text with one of the endings, if any are asked for."""
    ending = f" ending in {' or '.join(endings)}" if endings else ""
    if not isinstance(path, str | os.PathLike):
        raise refusal("path", f"a file name{ending}", path)
    name = os.fsdecode(os.fspath(path))
    if endings and os.path.splitext(name)[1].lower() not in endings:
        raise complaint(
            f"path must end in {' or '.join(endings)}, got {name!r:.200}",
            "path",
            f"a name that ends in {' or '.join(endings)}",
            name,
        )
    if not name or "\0" in name:
        raise refusal("path", "a file name without a zero byte", name)
    return name


def is_bool(value: object) -> bool:
    """Whether a value is True or False, numpy's too: a slip where a number is asked for."""
    return type(value).__name__ in ("bool", "bool_")


def allowed_range(low: float, high: float, includes_low: bool) -> str:
    """``>= 0 and < 90``, ``> 0 and finite``."""
    from iridesce import _core  # late: the command line checks words before there is anything to compute

    return _core.range_words(low, includes_low, high)
