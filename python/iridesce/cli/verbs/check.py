"""The verb ``check``: a scene validated, with all its defaults."""

from __future__ import annotations

from iridesce.cli.answers import print_json
from iridesce.cli.options import JsonOption, OutsideOption, SceneArgument
from iridesce.cli.reading import load_scene


def verb(scene: SceneArgument, allow_outside: OutsideOption = False, as_json: JsonOption = False) -> None:
    """Validate a scene and print it with all its defaults, as TOML."""
    tree = load_scene(scene, allow_outside).to_dict()
    if as_json:
        print_json(tree)
    else:
        from iridesce.files.toml import dumps

        print(dumps(tree), end="")
