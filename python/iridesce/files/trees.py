"""Trees of values from texts of other people: TOML and JSON, refused in words that say where."""

from __future__ import annotations

import json
import tomllib
from typing import Any


class NotATree(ValueError):
    """A text that is no TOML or JSON at all, as opposed to one that is and cannot be used."""


def from_toml(text: str, where: str) -> dict[str, Any]:
    """A TOML text as a tree.

    where    what to call it in a message: a file, an option and its key
    Raises   NotATree for what is no TOML; ValueError for brackets without end and whole numbers of thousands of digits,
             which Python would answer in words of its own

    >>> from_toml("a = 1", "x.toml")
    {'a': 1}
    """
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError(f"{where}: tables or lists are nested too deeply") from None
    except tomllib.TOMLDecodeError as error:
        raise NotATree(f"{where}: no TOML: {error}") from None
    except ValueError:
        raise ValueError(f"{where}: a whole number has more digits than any number that is used") from None


def from_json(text: str | bytes, where: str) -> Any:
    """A JSON text as a tree; as `from_toml`.

    >>> from_json("[1, 2]", "run.json")
    [1, 2]
    """
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError(f"{where}: tables or lists are nested too deeply") from None
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise NotATree(f"{where}: no JSON: {error}") from None
    except ValueError:
        raise ValueError(f"{where}: a whole number has more digits than any number that is used") from None
