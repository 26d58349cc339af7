"""The verb ``calibrate``: what a rig's channels see, from a photograph of a lens of known radius."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from iridesce.cli.answers import note, print_json
from iridesce.cli.options import JsonOption
from iridesce.cli.reading import reading


def verb(
    photo: Annotated[
        str, typer.Argument(metavar="PHOTO", help="Newton's rings under the lens, in the rig.", show_default=False)
    ],
    stack: Annotated[str, typer.Option("--stack", help='What light meets: "N-BK7 / air ? / N-BK7".')],
    lens: Annotated[float, typer.Option("--lens", metavar="RADIUS_MM", help="Radius of curvature of the lens, mm.")],
    pixel: Annotated[float, typer.Option("--pixel", metavar="UM", help="Side of a pixel on the film, um.")],
    center: Annotated[
        str | None, typer.Option("--center", metavar="X,Y", help="Middle of the rings, pixels; found if not given.")
    ] = None,
    flat: Annotated[
        str | None, typer.Option("--flat", metavar="PHOTO", help="A white surface in the same light.")
    ] = None,
    dark: Annotated[str | None, typer.Option("--dark", metavar="PHOTO", help="A picture without light.")] = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Calibration to write, .json.", show_default="rig.json")
    ] = Path("rig.json"),
    as_json: JsonOption = False,
) -> None:
    """Calibrate a camera and its lamp by a lens of known radius: its rings are a spectrometer."""
    if output.suffix.lower() != ".json":
        raise typer.BadParameter(f"the name must end in .json, got {str(output)!r}", param_hint="-o")
    middle = None if center is None else _center(center)
    from iridesce.files.whole import check_place

    check_place(output)
    import iridesce as ir

    with reading():
        rig = ir.CameraCalibration.from_known(
            photo, stack, ir.thickness.lens_gap(lens), pixel_um=pixel, center=middle, flat=flat, dark=dark
        )
    rig.save(output)
    scale = 1.96 * rig.scale_sd
    if as_json:
        facts = {
            "file": str(output),
            "stack": rig.stack,
            "center": rig.center,
            "gap_nm": rig.gap_nm,
            "misfit": rig.misfit,
        }
        print_json({**facts, "haze": list(rig.haze), "scale_interval": [1.0 - scale, 1.0 + scale]})
        return
    print(output)
    assert rig.center is not None
    note(
        f"rings about ({rig.center[0]:.1f}, {rig.center[1]:.1f}), gap {rig.gap_nm:+.1f} nm, {100.0 * rig.misfit:.1f} % of the "
        f"contrast left over; scale to {100.0 * scale:.2g} % (95 %), the lens being exact"
    )


def _center(text: str) -> tuple[float, float]:
    x, comma, y = text.partition(",")
    try:
        if not comma:
            raise ValueError
        return float(x), float(y)
    except ValueError:
        raise typer.BadParameter(f"wanted a pixel, as in 320,240, got {text!r:.60}", param_hint="--center") from None
