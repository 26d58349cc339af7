"""Writing a scene tree as TOML (reading it is the core's). Internal."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any


def dumps(tree: Mapping[str, Any]) -> str:
    """A tree of plain values as TOML: tables and arrays of tables at the top, inline tables below.

    Returns
        The text, ending in a newline; reading it gives the same tree (entries that are ``None`` are left out).

    Raises
        TypeError: a value that TOML cannot say.

    >>> print(dumps({"version": 1, "camera": {"up": [0.0, 1.0]}, "light": [{"sun": {"radiance": 2.0}}]}), end="")
    version = 1
    <BLANKLINE>
    [camera]
    up = [0.0, 1.0]
    <BLANKLINE>
    [[light]]
    sun = { radiance = 2.0 }
    """
    plain: list[str] = []
    tables: list[str] = []
    for key, value in tree.items():
        if isinstance(value, Mapping):
            tables.append("\n".join([f"[{_key(key)}]", *_entries(value)]))
        elif isinstance(value, Sequence) and value and all(isinstance(item, Mapping) for item in value):
            tables += ["\n".join([f"[[{_key(key)}]]", *_entries(item)]) for item in value]
        elif value is not None:
            plain.append(f"{_key(key)} = {_value(value)}")
    return "\n\n".join([*(["\n".join(plain)] if plain else []), *tables]) + "\n"


def _entries(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(key)} = {_value(value)}" for key, value in table.items() if value is not None]


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _string(key)


def _string(text: str) -> str:
    # JSON's escapes are TOML's, but for DEL, which JSON leaves as it is and TOML forbids.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else {math.inf: "inf", -math.inf: "-inf"}.get(value, "nan")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_entries(value)) + " }" if value else "{}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    raise TypeError(f"TOML has no form for {type(value).__name__}")
