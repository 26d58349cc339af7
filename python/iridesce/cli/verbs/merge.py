"""The verb ``merge``: shards of a picture, or runs of other seeds, put together."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from iridesce.cli.answers import note
from iridesce.cli.reading import check_picture


def verb(
    files: Annotated[
        list[Path], typer.Argument(help="EXR files of render: shards, or other seeds.", show_default=False)
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Picture to write, .exr or .png.", show_default=False)],
) -> None:
    """Put shards of a render together, or renders of the same scene with other seeds, weighted by samples."""
    if len(files) < 2:
        raise typer.BadParameter("two files at least", param_hint="FILES")
    check_picture(output)

    import iridesce as ir

    image = ir.merge(files)
    image.save(output)
    print(output)
    samples = image.channels["samples"]
    least, most = int(samples.min()), int(samples.max())
    count = f"{most}" if least == most else f"{least} to {most}"
    note(f"{image.width} x {image.height} pixels, {count} samples a pixel")
