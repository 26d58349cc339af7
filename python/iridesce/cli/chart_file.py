"""A chart drawn into a file: .png, .pdf or .svg, whole or not at all."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import typer

from iridesce.arguments.refusals import Words, refusal
from iridesce.cli.reading import reading, size_in_pixels

FORMATS = (".png", ".pdf", ".svg")
DPI = 160.0  # pixels of a .png to the inch: text is as large in all three formats


def write_panels(path: Path, pixels: tuple[int, int], panels: int, draw: Callable[[list[Any]], None]) -> None:
    """Draw and write; everything that can be wrong with name and size is found before the drawing."""
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise typer.BadParameter(f"the name must end in {', '.join(FORMATS)}, got {str(path)!r}", param_hint="-o")
    width, height = pixels
    if width < 160 or height < 120:
        raise refusal("--size", "at least 160x120 for a chart", Words(f"{width}x{height}"))
    from iridesce.errors import ResourceError
    from iridesce.files.whole import check_place, write_whole

    if width > 2**14 or height > 2**14:
        raise ResourceError(f"--size must be at most {2**14}x{2**14} for a chart, got {width:.6g}x{height:.6g}")
    check_place(path)

    import matplotlib
    from matplotlib.figure import Figure

    # Text stays text in .svg files; the salt makes the same chart the same bytes.
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "iridesce"}):
        figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
        figure.set_layout_engine("constrained", w_pad=0.1, h_pad=0.1)
        axes = [figure.add_subplot(1, panels, 1 + panel) for panel in range(panels)]
        with reading():
            draw(axes)
        buffer = io.BytesIO()
        dates = {".png": {}, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}[ending]
        figure.savefig(buffer, format=ending[1:], dpi=DPI, metadata=dates)
    write_whole(path, buffer.getvalue())


def write_chart(path: Path, size: str | None, draw: Callable[[Any], object]) -> None:
    """One chart of another verb into a file."""

    def one(axes: list[Any]) -> None:
        draw(axes[0])

    write_panels(path, (1250, 800) if size is None else size_in_pixels(size), 1, one)
