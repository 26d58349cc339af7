"""Arguments and options that several verbs take, each once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

STACK_HELP = 'Media and layers separated by " / "; layers add their nm: "air / soap 320 / air", "air / TiO2 60 / Ti".'
VARYING_HELP = (
    'Media and layers separated by " / "; the layer that varies has ? for its thickness: "air / soap ? / air",'
    ' "air / SiO2 ? / Si3N4 80 / Si".'
)

SceneArgument = Annotated[
    str, typer.Argument(help="A scene file, or the name of a built-in scene.", show_default=False)
]
StackArgument = Annotated[str, typer.Argument(help=STACK_HELP, show_default=False)]
AngleOption = Annotated[float, typer.Option("--angle", help="Degrees from the normal in the first medium, 0 to < 90.")]
AnglesOption = Annotated[
    str, typer.Option("--angle", help="Degrees from the normal in the first medium, 0 to < 90; several as in 0,45.")
]
PolarizationOption = Annotated[str, typer.Option("--polarization", help="s, p or unpolarized.")]
OutsideOption = Annotated[
    bool, typer.Option("--allow-outside", help="Let the scene name files outside its own folder.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Answer in JSON.")]
CsvOption = Annotated[bool, typer.Option("--csv", help="Answer in CSV.")]
TableOption = Annotated[
    Path | None, typer.Option("-o", "--output", help="Write the answer into this file: .csv or .json.")
]
SpectrumOption = Annotated[
    Path | None, typer.Option("-o", "--output", help="Write a table (.csv, .json) or a plot (.png, .pdf, .svg).")
]
IlluminantOption = Annotated[str, typer.Option("--illuminant", help="D65, A, FL2, blackbody:2856, lines:589.158, ...")]
QuantityOption = Annotated[str, typer.Option("--quantity", help="reflectance, transmittance or absorptance.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change one value of the scene; may be given many times."),
]
ThreadsOption = Annotated[int | None, typer.Option("--threads", help="Threads; all cores if not given.")]
ThemeOption = Annotated[str, typer.Option("--theme", help="light or dark.")]
SizeOption = Annotated[
    str | None,
    typer.Option("--size", metavar="WxH", help="Pixels of a .png; a .pdf or .svg has 160 of them to the inch."),
]
VaryingArgument = Annotated[str, typer.Argument(metavar="STACK", help=VARYING_HELP, show_default=False)]
VaryOption = Annotated[
    str | None, typer.Option("--vary", metavar="A:B", help="The range of the thickness, nm.", show_default=False)
]
DaskOption = Annotated[
    str | None,
    typer.Option(
        "--dask",
        metavar="ADDRESS",
        help='Workers of a Dask scheduler, tcp://host:8786; or "local:N", N processes of this machine.',
        show_default=False,
    ),
]
