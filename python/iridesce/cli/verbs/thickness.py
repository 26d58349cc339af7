"""The verb ``thickness``: film thickness at every pixel of a photograph."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from iridesce.cli.answers import note, print_json
from iridesce.cli.options import AngleOption, JsonOption, ThreadsOption
from iridesce.cli.reading import pair, reading


def verb(
    photo: Annotated[
        str,
        typer.Argument(metavar="PHOTO", help="OpenEXR, NPY, TIFF (16 bit: linear), PNG or JPEG.", show_default=False),
    ],
    stack: Annotated[
        str, typer.Option("--stack", help='Media and layers, ? for what is unknown: "air / soap ? / air".')
    ],
    calibration: Annotated[
        str | None, typer.Option("--calibration", metavar="FILE", help="What `iridesce calibrate` wrote for this rig.")
    ] = None,
    camera: Annotated[
        str | None,
        typer.Option(
            "--camera", help="nikon-d5100, sigma-sd-merrill, srgb, xyz or a file of sensitivities; tried if not given."
        ),
    ] = None,
    illuminant: Annotated[
        str | None, typer.Option("--illuminant", help="D65, A, LED-B3, blackbody:2856, ...; tried if not given.")
    ] = None,
    angle: AngleOption = 0.0,
    range_: Annotated[str, typer.Option("--range", metavar="A:B", help="Thicknesses to look among, nm.")] = "0:2000",
    at: Annotated[
        list[str] | None,
        typer.Option("--at", metavar="X,Y=NM", help="A pixel whose thickness is known; may be given many times."),
    ] = None,
    flat: Annotated[
        str | None, typer.Option("--flat", metavar="PHOTO", help="A white surface in the same light.")
    ] = None,
    dark: Annotated[str | None, typer.Option("--dark", metavar="PHOTO", help="A picture without light.")] = None,
    index_tolerance: Annotated[
        float, typer.Option("--index-tolerance", help="Standard deviation of the film's index, relative.")
    ] = 0.0,
    angle_tolerance: Annotated[
        float, typer.Option("--angle-tolerance", help="Standard deviation of the angle, degrees.")
    ] = 0.0,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", help="Map to write: pages of a .tif, or a chart (.png, .pdf, .svg).", show_default=False
        ),
    ] = None,
    threads: ThreadsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Film thickness at every pixel of a photograph, with how sure its order is, an interval, and what else it could be."""
    endings = (".tif", ".tiff", ".png", ".pdf", ".svg")
    if output is not None and output.suffix.lower() not in endings:
        raise typer.BadParameter(f"the name must end in {', '.join(endings)}, got {str(output)!r}", param_hint="-o")
    ties = [_tie(text) for text in at or []]
    low, high = pair(range_, "--range", "nm")
    from iridesce.files.whole import check_place

    if output is not None:
        check_place(output)
    import iridesce as ir

    with reading():
        found = ir.map_thickness(
            photo,
            stack,
            calibration=calibration,
            camera=camera,
            illuminant=illuminant,
            angle_deg=angle,
            thickness_range_nm=(low, high),
            flat=flat,
            dark=dark,
            tie_points=ties or None,
            index_tolerance=index_tolerance,
            angle_tolerance_deg=angle_tolerance,
            threads=threads,
            progress=True,
        )
    if output is not None and output.suffix.lower().startswith(".tif"):
        found.save(output)
    elif output is not None:
        import io

        from iridesce.files.whole import write_whole

        buffer = io.BytesIO()
        found.plot().savefig(buffer, format=output.suffix.lower()[1:], dpi=160)
        write_whole(output, buffer.getvalue())
    if as_json:
        print_json({"file": photo, "stack": stack, **found.to_dict()})
        return
    first, *notes = str(found).splitlines()
    print(first)
    for line in notes:
        note(line.removeprefix("note: "))


def _tie(text: str) -> tuple[float, float, float]:
    place, equals, nm = text.partition("=")
    x, comma, y = place.partition(",")
    try:
        if not (equals and comma):
            raise ValueError
        return float(x), float(y), float(nm)
    except ValueError:
        raise typer.BadParameter(
            f"wanted a pixel and its thickness in nm, as in 120,80=350, got {text!r:.60}", param_hint="--at"
        ) from None
