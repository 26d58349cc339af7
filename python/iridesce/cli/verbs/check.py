"""The verb ``check``: a scene validated, with all its defaults; the scene language as a schema."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from iridesce.cli.answers import note, print_json
from iridesce.cli.options import JsonOption, OutsideOption
from iridesce.cli.reading import load_scene


def verb(
    scene: Annotated[
        str | None, typer.Argument(help="A scene file, or the name of a built-in scene.", show_default=False)
    ] = None,
    allow_outside: OutsideOption = False,
    as_json: JsonOption = False,
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON Schema of the scene language, for editors, and leave.")
    ] = False,
) -> None:
    """Validate a scene, in milliseconds, and print it with all its defaults, as TOML."""
    if schema:
        if scene is not None:
            raise typer.BadParameter("takes no scene: it describes them all", param_hint="--schema")
        from iridesce import _core

        print_json(json.loads(_core.scene_schema()))
        return
    if scene is None:
        raise typer.BadParameter("name a scene, or --schema", param_hint="SCENE")
    loaded = load_scene(scene, allow_outside)
    for words in loaded._core.notes():
        note(words)
    tree = loaded.to_dict()
    if as_json:
        print_json(tree)
    else:
        from iridesce.files.toml import dumps

        print(dumps(tree), end="")
