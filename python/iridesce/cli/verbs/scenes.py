"""The verb ``scenes``: the names of the built-in scenes."""

from __future__ import annotations

from iridesce.cli.answers import print_json
from iridesce.cli.options import JsonOption


def verb(as_json: JsonOption = False) -> None:
    """List the built-in scenes."""
    from iridesce.scene import scene_names

    names = scene_names()
    if as_json:
        print_json(names)
    else:
        print("\n".join(names))
