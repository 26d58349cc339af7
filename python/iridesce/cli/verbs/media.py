"""The verb ``media``: what the built-in media are, one of them in full, and its plot."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated, Any

import typer

from iridesce.cli.answers import note, print_json
from iridesce.cli.chart_file import write_chart
from iridesce.cli.options import JsonOption


def verb(
    name: Annotated[
        str | None,
        typer.Argument(help="Only this medium, with its index; also a page of refractiveindex.info: SiO2/Malitson."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Plot n and k into this file: .png, .pdf or .svg.")
    ] = None,
    search: Annotated[
        str | None,
        typer.Option("--search", help="Only media, and pages of refractiveindex.info, that hold these words."),
    ] = None,
    full: Annotated[bool, typer.Option("--full", help="Tell whole sources in the list.")] = False,
    theme: Annotated[str, typer.Option("--theme", help="Of the plot: light or dark.")] = "light",
    size: Annotated[str | None, typer.Option("--size", metavar="WxH", help="Of the plot, in pixels.")] = None,
    as_json: JsonOption = False,
) -> None:
    """The built-in media, their ranges and sources; one of them in full, and a plot of its n and k."""
    if name is None:
        if output is not None:
            raise typer.BadParameter(
                "a plot shows one medium: name it, as in `iridesce media Ti -o ti.png`", param_hint="-o"
            )
        _list_media(search, full, as_json)
        return
    if search is not None:
        raise typer.BadParameter("--search goes through all media: leave out NAME", param_hint="--search")
    import iridesce as ir

    medium = ir.Medium(name)
    row = {**_medium_row(medium), "note": medium.note, "extension": medium.extension, "index": _index_rows(medium)}
    files = {} if output is None else {"files": [str(output)]}
    if output is not None:
        from iridesce import plot

        write_chart(output, size or "1200x740", lambda ax: plot.medium(medium, theme=theme, ax=ax))
    if as_json:
        print_json({**row, **files})
        return
    _print_medium(row)
    if output is not None:
        print(output)


def _list_media(search: str | None, full: bool, as_json: bool) -> None:
    import iridesce as ir

    rows = [_medium_row(ir.Medium(entry)) for entry in ir.media()]
    if search is not None:
        words = search.lower().split()
        rows = [row for row in rows if all(word in f"{row['name']} {row['source']}".lower() for word in words)]
    pages = [] if search is None else _pages(search)
    if as_json:
        print_json(rows + [{"name": name, "kind": "page", "range_nm": None, "source": title} for name, title in pages])
        return
    width = None if full else _columns()
    for row in rows:
        print(_cut(f"{row['name']:<16} {_extent(row['range_nm']):<16} {row['source']}", width))
    for page, title in pages:
        print(_cut(f"{page:<28} {title}", width))


def _columns() -> int:
    """How wide the terminal is; where there is none, as wide as most are."""
    return shutil.get_terminal_size((100, 24)).columns


def _cut(line: str, width: int | None) -> str:
    """A line that fits the terminal; ``--full`` tells all of it."""
    return line if width is None or len(line) <= width else f"{line[: max(width - 1, 20)]}\u2026"


def _pages(search: str) -> list[tuple[str, str]]:
    """Pages of refractiveindex.info; a note instead where they are not on this machine."""
    from iridesce.optics import database

    try:
        return [(page.name, page.title) for page in database.search(search)]
    except database.MissingDatabase as missing:
        note(f"note: {missing}")
        return []


def _print_medium(row: dict[str, Any]) -> None:
    facts = [
        ("name", row["name"]),
        ("kind", row["kind"]),
        ("data", _extent(row["range_nm"])),
        ("source", row["source"]),
    ]
    facts += [("extended", row["extension"])] if row["extension"] else []
    facts += [("note", row["note"])] if row["note"] else []
    for label, value in facts:
        print(f"{label:<9} {value}")
    for wavelength_nm, n, k in row["index"]:
        print(f"{wavelength_nm:6g} nm   n = {n:.5f}   k = {k:.5g}")


def _extent(span: tuple[float, float] | None) -> str:
    return "any wavelength" if span is None else f"{span[0]:g}-{span[1]:g} nm"


def _medium_row(medium: Any) -> dict[str, Any]:
    return {"name": medium.name, "kind": medium.kind, "range_nm": medium.range_nm, "source": medium.source}


def _index_rows(medium: Any) -> list[tuple[float, float, float]]:
    """(nm, n, k) every 50 nm of the visible; for data of another region, at nine even steps of it."""
    span = medium.range_nm or (0.0, float("inf"))
    inside = [float(nm) for nm in range(400, 701, 50) if span[0] <= nm <= span[1]]
    if not inside:
        inside = [span[0] + (span[1] - span[0]) * step / 8 for step in range(9)]
    indices = [complex(medium.index(nm, extrapolate="hold")) for nm in inside]
    return [(nm, index.real, index.imag) for nm, index in zip(inside, indices, strict=True)]
