"""The verb ``validate``: whether another program's picture of a chart is right, and what is wrong if it is not."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from iridesce.cli.answers import print_json
from iridesce.cli.options import JsonOption
from iridesce.cli.reading import reading


def verb(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A picture or table: .exr, .png, .npy.")],
    chart: Annotated[str, typer.Option("--chart", help="C1 to C9, C8-FL2, ...; see docs/guide/exchange.md.")],
    as_json: JsonOption = False,
) -> None:
    """Compare a renderer's picture of a chart, or a table of colours, with the truth; name the likely cause."""
    with reading():
        from iridesce.exchange import validate as compare

        report = compare(file, chart)
    if as_json:
        print_json(report.to_dict())
        return
    print(report.text)
