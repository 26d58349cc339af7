"""The verb ``lut``: a table of colours for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from iridesce.cli.answers import note, print_json
from iridesce.cli.options import IlluminantOption, JsonOption, VaryingArgument, VaryOption
from iridesce.cli.reading import reading, size_in_pixels, thickness_range

TABLES = (".exr", ".png", ".cube")


def verb(
    stack: VaryingArgument,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help=f"File to write: {', '.join(TABLES)}.", show_default="film.exr"),
    ] = None,
    vary: VaryOption = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Thicknesses x cosines of .exr and .png.", show_default="512x64")
    ] = None,
    quantity: Annotated[str, typer.Option("--quantity", help="reflectance or transmittance.")] = "reflectance",
    illuminant: IlluminantOption = "D65",
    as_json: JsonOption = False,
) -> None:
    """A table of exact colours over thickness and cos(theta), linear XYZ; its error is stated in it."""
    path = output or Path("film.exr")
    ending = path.suffix.lower()
    if ending not in TABLES:
        raise typer.BadParameter(f"the name must end in {', '.join(TABLES)}, got {str(path)!r}", param_hint="-o")
    width_height = None if size is None else size_in_pixels(size)
    range_nm = thickness_range(vary)
    from iridesce.files.whole import check_place, write_whole

    check_place(path)
    with reading():
        from iridesce.exchange.films import read_stack
        from iridesce.exchange.lut import single_file

        parsed, layer = read_stack(stack)
        content, stated, film = single_file(
            parsed, ending, vary=range_nm, illuminant=illuminant, size=width_height, quantity=quantity, layer=layer
        )
    write_whole(path, content)
    low, high = film.table_range()
    if as_json:
        facts = {"file": str(path), "stack": film.text_for_table, "thickness_nm": [low, high], "quantity": quantity}
        print_json({**facts, "illuminant": film.illuminant.name, "delta_e": stated, "notes": film.notes})
        return
    print(path)
    note(
        f"{film.text_for_table}, {low:g} to {high:g} nm, {film.illuminant.name}, {quantity}; read linearly CIEDE2000 mean"
        f" {stated['mean']:.3f}, p99 {stated['p99']:.3f}, max {stated['max']:.2f}"
    )
    for remark in film.notes:
        note(remark)
