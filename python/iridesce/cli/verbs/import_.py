"""The verb ``import``: what another program wrote, as a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from iridesce.cli.answers import note, print_json
from iridesce.cli.options import JsonOption
from iridesce.cli.reading import reading


def verb(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A .gltf, .glb, .mtlx, or Mitsuba's .xml.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Scene file to write, .toml; without it it is printed.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Read a film or scene of another program; tells what is left out."""
    if output is not None and output.suffix.lower() != ".toml":
        raise typer.BadParameter(f"the name must end in .toml, got {str(output)!r}", param_hint="-o")
    from iridesce.files.whole import check_place, write_whole

    if output is not None:
        check_place(output)
    with reading():
        from iridesce.exchange import import_scene

        scene, left_out = import_scene(file)
    text = scene.check()
    if output is not None and "map = " in text and output.resolve().parent != file.resolve().parent:
        note(f"{output} names pictures beside {file}: keep it there")
    if output is not None:
        write_whole(output, text.encode("utf-8"))
    if as_json:
        print_json({"scene": scene.to_dict(), "left_out": left_out, "file": None if output is None else str(output)})
        return
    print(text if output is None else output, end="" if output is None else "\n")
    for sentence in left_out:
        note(f"left out: {sentence}")
