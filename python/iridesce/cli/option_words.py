"""What an argument of the library is called where it was typed: the words of errors in the words of options. Internal."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from iridesce.errors import ArgumentError

# Options whose name is not that of their argument without its unit.
_OTHERWISE = {
    "thickness_range_nm": "--range",
    "tie_points": "--at",
    "coupons": "--coupon",
    "radius_mm": "--lens",
    "range_nm": "--from and --to",
}
_UNITS = r"_(nm|deg|mm|um|s)$"


def options_of(verb: Callable[..., Any]) -> dict[str, str]:
    """The option of each argument that a verb has one for, by the name of its parameter: ``angle`` is ``--angle``."""
    import inspect
    import typing

    from typer.models import OptionInfo

    hints = typing.get_type_hints(verb, include_extras=True)
    found: dict[str, str] = {}
    for name in inspect.signature(verb).parameters:
        for told in getattr(hints.get(name), "__metadata__", ()):
            if isinstance(told, OptionInfo):
                # (In an `Annotated` typer takes the first name for the default.)
                long = [one for one in (told.default, *(told.param_decls or ())) if str(one).startswith("--")]
                found[name.rstrip("_")] = str(long[0]) if long else f"--{name.replace('_', '-')}"
    return found


def option_of(options: Mapping[str, str], argument: str) -> str | None:
    """What the user typed for an argument of the library, ``thickness_range_nm``; None where it is no option."""
    if argument in _OTHERWISE:
        wanted = _OTHERWISE[argument]
        return wanted if wanted.split()[0] in options.values() else None
    return options.get(argument) or options.get(re.sub(_UNITS, "", argument))


def in_option_words(verb: Callable[..., Any], error: BaseException) -> str:
    """The sentence of an error, arguments under the names of the verb's options.

    The argument that was refused, where the sentence begins with it, and every name with an underscore or an equals sign: the
    rest is prose ("the stack has no layer").
    """
    words = str(error)
    if not isinstance(error, ArgumentError):
        return words
    options = options_of(verb)

    def named(match: re.Match[str]) -> str:
        option = option_of(options, match[1])
        begins = match.start() == 0 and match[1] == error.argument
        if option is None or not (begins or "_" in match[1] or match[2]):
            return match[0]
        return option + (" " if match[2] else "")

    return re.sub(r"(?<![\w.-])([a-z][a-z_]*)(?:(=)(?=\S)|(?!\w|\.\w))", named, words)
