"""The verbs ``lut``, ``export`` and ``validate``: films and scenes for other programs, and whether those are right."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from iridesce.cli.commands import JsonOption, _note, _print_json, _reading, _size, app
from iridesce.cli.entry import answers_errors

if TYPE_CHECKING:
    from iridesce.exchange.report import ExportReport

GROWING_HELP = (
    'Media and layers separated by " / "; the layer that varies has ? for its thickness: "air / soap ? / air",'
    ' "air / SiO2 ? / Si3N4 80 / Si".'
)
TABLES = (".exr", ".png", ".cube")

GrowingArgument = Annotated[str, typer.Argument(metavar="STACK", help=GROWING_HELP, show_default=False)]
VaryOption = Annotated[
    str | None, typer.Option("--vary", metavar="A:B", help="The range of the thickness, nm.", show_default=False)
]
LightOption = Annotated[str, typer.Option("--illuminant", help="D65, A, FL2, blackbody:2856, lines:589.158, ...")]


@app.command()
@answers_errors
def lut(
    stack: GrowingArgument,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help=f"File to write: {', '.join(TABLES)}.", show_default="film.exr"),
    ] = None,
    vary: VaryOption = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Thicknesses x cosines of .exr and .png.", show_default="512x64")
    ] = None,
    quantity: Annotated[str, typer.Option("--quantity", help="reflectance or transmittance.")] = "reflectance",
    illuminant: LightOption = "D65",
    as_json: JsonOption = False,
) -> None:
    """A table of exact colours over thickness and cos(theta), linear XYZ; its error is stated in it."""
    path = output or Path("film.exr")
    ending = path.suffix.lower()
    if ending not in TABLES:
        raise typer.BadParameter(f"the name must end in {', '.join(TABLES)}, got {str(path)!r}", param_hint="-o")
    width_height = None if size is None else _size(size)
    range_nm = _range(vary)
    from iridesce.files.whole import check_place, write_whole

    check_place(path)
    with _reading():
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
        _print_json({**facts, "illuminant": film.illuminant.name, "delta_e": stated, "notes": film.notes})
        return
    print(path)
    _note(
        f"{film.text_for_table}, {low:g} to {high:g} nm, {film.illuminant.name}, {quantity}; read linearly CIEDE2000 mean"
        f" {stated['mean']:.3f}, p99 {stated['p99']:.3f}, max {stated['max']:.2f}"
    )
    for note in film.notes:
        _note(note)


@app.command()
@answers_errors
def export(
    source: Annotated[
        str, typer.Argument(metavar="STACK|SCENE", help=f"A scene, or a stack. {GROWING_HELP}", show_default=False)
    ],
    to: Annotated[str, typer.Option("--to", metavar="TARGET", help="lut, cube, shader, osl, ...", show_default=False)],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="DIR", help="Folder to write into.", show_default=False)
    ],
    vary: VaryOption = None,
    thickness: Annotated[
        Path | None, typer.Option("--thickness", metavar="MAP", help="Where the film is how thick.", show_default=False)
    ] = None,
    illuminant: LightOption = "D65",
    fit: Annotated[bool, typer.Option("--fit", help="Fit the target's knobs to the truth.")] = False,
    as_json: JsonOption = False,
) -> None:
    """A film, or a scene, for another program; tells what is lost and how far its colours are from the truth."""
    range_nm = _range(vary)
    with _reading():
        from iridesce.exchange import export as write

        loaded = _source(source)
    report: ExportReport = write(loaded, to, output, vary=range_nm, thickness=thickness, illuminant=illuminant, fit=fit)
    if as_json:
        _print_json(report.to_dict())
        return
    for path in report.files:
        print(path)
    _note(report.text)


@app.command()
@answers_errors
def validate(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A picture or table: .exr, .png, .npy.")],
    chart: Annotated[str, typer.Option("--chart", help="C1 to C9, C8-FL2, ...; see docs/guide/exchange.md.")],
    as_json: JsonOption = False,
) -> None:
    """Compare a renderer's picture of a chart, or a table of colours, with the truth; name the likely cause."""
    with _reading():
        from iridesce.exchange import validate as compare

        report = compare(file, chart)
    if as_json:
        _print_json(report.to_dict())
        return
    print(report.text)


def _source(source: str) -> Any:
    """A stack's text as it is; anything else is a scene."""
    if re.search(r"(?<!\S)/(?!\S)", source):
        return source
    from iridesce.cli.commands import _load

    return _load(source, allow_outside=False)


def _range(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    first, colon, last = text.partition(":")
    try:
        if not colon:
            raise ValueError
        return float(first), float(last)
    except ValueError:
        message = f"wanted two thicknesses in nm, as in 0:1200, got {text!r}"
        raise typer.BadParameter(message, param_hint="--vary") from None
