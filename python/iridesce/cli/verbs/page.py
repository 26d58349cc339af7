"""The verb ``page``: interference colour in a browser, from one file that needs no network."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def verb(
    scene: Annotated[
        str | None,
        typer.Argument(help="What it opens with: bubble, rings, slick, titanium, wafer or film.", show_default=False),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Write the file here instead of opening it.")
    ] = None,
) -> None:
    """Open the page in a browser: a living bubble, Newton's rings, oil, titanium, a wafer, any film. Needs no network."""
    import webbrowser

    from iridesce.files.whole import write_whole
    from iridesce.page import page_link, page_path

    link = page_link(scene)
    if output is not None:
        write_whole(output, page_path().read_bytes())
        print(output)
        return
    print(link)
    if not webbrowser.open(link):
        raise OSError(f"no browser could be started; open {link} yourself, or write the file with -o")
