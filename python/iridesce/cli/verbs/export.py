"""The verb ``export``: films and scenes for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from iridesce.cli.answers import note, print_json
from iridesce.cli.options import VARYING_HELP, IlluminantOption, JsonOption, VaryOption
from iridesce.cli.reading import is_stack_text, load_scene, reading, thickness_range

if TYPE_CHECKING:
    from iridesce.exchange.report import ExportReport


def verb(
    source: Annotated[
        str, typer.Argument(metavar="STACK|SCENE", help=f"A scene, or a stack. {VARYING_HELP}", show_default=False)
    ],
    to: Annotated[
        str,
        typer.Option(
            "--to",
            metavar="TARGET",
            help="lut, cube, shader, osl, mitsuba, cycles, gltf, openpbr or usd.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="DIR", help="Folder to write into.", show_default=False)
    ],
    vary: VaryOption = None,
    thickness: Annotated[
        Path | None, typer.Option("--thickness", metavar="MAP", help="Where the film is how thick.", show_default=False)
    ] = None,
    illuminant: IlluminantOption = "D65",
    fit: Annotated[bool, typer.Option("--fit", help="Fit the target's knobs to the truth.")] = False,
    as_json: JsonOption = False,
) -> None:
    """A film, or a scene, for another program; tells what is lost and how far its colours are from the truth."""
    range_nm = thickness_range(vary)
    with reading():
        from iridesce.exchange import export as write

        loaded = _source(source)
    report: ExportReport = write(loaded, to, output, vary=range_nm, thickness=thickness, illuminant=illuminant, fit=fit)
    if as_json:
        print_json(report.to_dict())
        return
    for path in report.files:
        print(path)
    note(report.text)


def _source(source: str) -> Any:
    """A stack's text as it is; anything else is a scene."""
    if is_stack_text(source):
        return source
    return load_scene(source, allow_outside=False)
