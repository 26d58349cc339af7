"""Stacks as one line of text: ``air / MgF2 100 / N-BK7 1e6 incoherent / air``."""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation
from typing import NamedTuple

from iridesce.arguments.refusals import Words, complaint

EXAMPLE = '"air / soap 320 / air"'


class Item(NamedTuple):
    """One item: a medium, and for a layer its thickness; ``where`` names it in errors."""

    where: str
    medium: str | complex
    thickness_nm: float
    coherent: bool
    is_open: bool = False
    """The thickness was left out (it reads 0)."""


def parse_items(text: object, open_layers: bool = False) -> list[Item]:
    """The items of a stack; the first and the last have no thickness (it reads 0).

    ``open_layers``: a layer may leave its thickness out, or write ``?`` for it, as in ``air / soap / air``.
    """
    if not isinstance(text, str):
        raise complaint(
            f"a stack as text looks like {EXAMPLE}, got {text!r:.200}", "stack", f"text like {EXAMPLE}", text
        )
    words = [item.split() for item in _items(text)]
    if len(words) < 2:
        raise complaint(
            f'a stack needs two or more items separated by " / ", as in {EXAMPLE}, got {text!r:.200}',
            "stack",
            f"two or more items, as in {EXAMPLE}",
            text,
        )
    ends = (1, len(words))
    return [_parse_item(item, number, number in ends, open_layers) for number, item in enumerate(words, start=1)]


_UNITS_NM = {"nm": 1.0, "um": 1e3, "\u00b5m": 1e3, "\u03bcm": 1e3, "micron": 1e3, "mm": 1e6, "A": 0.1, "\u00c5": 0.1}
_LENGTH = re.compile(rf"([-+.\d][-+.\deE]*?)({'|'.join(_UNITS_NM)})?$")


def _items(text: str) -> list[str]:
    """Between slashes with a space beside them; a text without any is divided at every slash (pages of
    refractiveindex.info have slashes in their names)."""
    spaced = re.split(r"\s+/\s*|\s*/\s+|^/|/$", text)
    return spaced if len(spaced) > 1 else text.split("/")


def _with_unit(words: list[str]) -> list[str]:
    """The words of a layer with its thickness as one number in nm: of ``0.32um``, ``320 nm``, ``0.32 um``."""
    match = _LENGTH.match(words[1]) if len(words) > 1 else None
    if match is None:
        return words
    number, unit = match.groups()
    rest = words[2:]
    if unit is None and rest and rest[0] in _UNITS_NM:
        unit, rest = rest[0], rest[1:]
    if unit is None:
        return words
    try:
        # Multiplied in decimals: 0.32 um is 320 nm, not 320.00000000000006.
        nm = float(Decimal(number) * Decimal(str(_UNITS_NM[unit])))
    except (InvalidOperation, ValueError, OverflowError):
        return words
    return [words[0], repr(nm), *rest]


def _parse_item(words: list[str], number: int, is_end: bool, open_layers: bool) -> Item:
    if not words:
        raise complaint(
            f"item {number} of the stack is empty; it should look like {EXAMPLE}",
            "stack",
            f"items like those of {EXAMPLE}",
            Words("nothing"),
            f"for item {number}",
        )
    where = f"item {number} of the stack, {' '.join(words)!r:.100}"
    medium = _parse_medium(words[0], where)
    if is_end:
        if len(words) > 1:
            raise complaint(
                f"{where}: the first and the last item are a medium without thickness",
                "stack",
                "one that starts and ends with a medium without thickness",
                Words("a thickness"),
                f"in {where}",
            )
        return Item(where, medium, 0.0, True)
    if open_layers and words[1:] in ([], ["?"], ["incoherent"], ["?", "incoherent"]):
        return Item(where, medium, 0.0, words[-1] != "incoherent", is_open=True)
    words = _with_unit(words)
    if len(words) < 2:
        raise complaint(
            f'{where}: a layer needs its thickness in nm, as in "{words[0]} 320"',
            "thickness_nm",
            "a number",
            Words("nothing"),
            f"in {where}",
        )
    if words[2:] not in ([], ["incoherent"]):
        raise complaint(
            f'{where}: after the thickness only "incoherent" may follow, got {" ".join(words[2:])!r:.100}',
            "stack",
            '"incoherent", or nothing, after a thickness',
            " ".join(words[2:]),
            f"in {where}",
        )
    try:
        thickness_nm = float(words[1])
    except ValueError:
        raise complaint(
            f"{where}: the thickness in nm must be a number, got {words[1]!r:.100}",
            "thickness_nm",
            "a number",
            words[1],
            f"in {where}",
        ) from None
    return Item(where, medium, thickness_nm, len(words) == 2)


def _parse_medium(word: str, where: str) -> str | complex:
    """A name, or an index where the word begins like a number."""
    if not re.match(r"[-+.\d]", word):
        return word
    try:
        index = complex(word)
    except ValueError:
        raise complaint(
            f"{where}: an index is written n or n+kj, got {word!r:.100}", "index", "n or n+kj", word, f"in {where}"
        ) from None
    return index if index.imag else index.real
