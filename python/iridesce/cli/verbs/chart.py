"""The verb ``chart``: the charts of ``ir.plot`` as files. Reads options, draws, writes whole files."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from iridesce.arguments.refusals import Words, complaint
from iridesce.cli.answers import answers_errors, print_json
from iridesce.cli.chart_file import write_panels
from iridesce.cli.options import (
    AngleOption,
    IlluminantOption,
    JsonOption,
    PolarizationOption,
    QuantityOption,
    SizeOption,
    ThemeOption,
)
from iridesce.cli.reading import pair, size_in_pixels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GROWING_HELP = (
    'Media and layers separated by " / "; the layer that grows leaves out its thickness: "air / soap / air",'
    ' "air / SiO2 ? / Si 500 / air".'
)
GrowingArgument = Annotated[str, typer.Argument(metavar="STACK", help=GROWING_HELP, show_default=False)]
OutputOption = Annotated[
    Path | None,
    typer.Option("-o", "--output", help="File to write: .png, .pdf or .svg.", show_default="CHART-STACK.png"),
]
RangeOption = Annotated[
    str | None, typer.Option("--range", metavar="A:B", help="First and last thickness, nm.", show_default=False)
]
FromOption = Annotated[float | None, typer.Option("--from", help="First thickness, nm.", show_default=False)]
ToOption = Annotated[float | None, typer.Option("--to", help="Last thickness, nm.", show_default=False)]
LayerOption = Annotated[
    str | None, typer.Option("--layer", help="The layer that grows: its number, from 1, or its medium.")
]
ModelOption = Annotated[str, typer.Option("--model", help="exact or two-beam.")]
ExposureOption = Annotated[
    str, typer.Option("--exposure", help='Stops (0: as it is), "auto", or "common" for all strips or angles alike.')
]
TitleOption = Annotated[str | None, typer.Option("--title", help='Instead of the stack; "" for none.')]

group = typer.Typer(
    help="Charts of a film that thickens: its path in the CIE diagram, its strip of colours, thickness against angle.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@group.command()
@answers_errors
def locus(
    stack: GrowingArgument,
    output: OutputOption = None,
    range_: RangeOption = None,
    from_: FromOption = None,
    to: ToOption = None,
    angle: AngleOption = 0.0,
    layer: LayerOption = None,
    illuminant: IlluminantOption = "D65",
    polarization: PolarizationOption = "unpolarized",
    quantity: QuantityOption = "reflectance",
    model: Annotated[
        list[str] | None,
        typer.Option(help="exact, two-beam, or both in one diagram; given twice: side by side.", show_default="exact"),
    ] = None,
    diagram: Annotated[str, typer.Option(help="xy (CIE 1931) or uv (CIE 1976).")] = "xy",
    gamut: Annotated[
        list[str] | None,
        typer.Option(
            help="srgb, display-p3, rec2020, ntsc1953, acescg or none; may be repeated.", show_default="srgb rec2020"
        ),
    ] = None,
    tick: Annotated[float | None, typer.Option(help="nm from dot to dot.", show_default=False)] = None,
    zoom: Annotated[bool, typer.Option("--zoom", help="Fit the limits to the path.")] = False,
    theme: ThemeOption = "light",
    size: SizeOption = None,
    title: TitleOption = None,
    as_json: JsonOption = False,
) -> None:
    """The path of the film's colour in the CIE diagram as it thickens, 0 to 2000 nm unless said otherwise."""
    models = model or ["exact"]
    triangles = [] if gamut == ["none"] else gamut or ["srgb", "rec2020"]

    def draw(axes: list[Axes]) -> None:
        from iridesce import plot

        for one, ax in zip(models, axes, strict=True):
            plot.locus(
                stack,
                _thicknesses(range_, from_, to, 2000.0),
                angle,
                layer=_layer(layer),
                illuminant=illuminant,
                polarization=polarization,
                quantity=quantity,
                model=one,
                diagram=diagram,
                gamuts=triangles,
                tick_nm=tick,
                zoom=zoom,
                title=title,
                theme=theme,
                ax=ax,
            )

    if len(models) > 4:
        raise complaint(
            f"--model may be given four times at most, got {len(models)}",
            "--model",
            "given four times at most",
            Words(len(models)),
        )
    _make("locus", stack, output, size, (1000 * len(models), 1100), len(models), draw, as_json)


@group.command()
@answers_errors
def strip(
    stack: Annotated[
        list[str],
        typer.Argument(metavar="STACK...", help=GROWING_HELP + ' "newton" is Newton\'s scale.', show_default=False),
    ],
    output: OutputOption = None,
    range_: RangeOption = None,
    from_: FromOption = None,
    to: ToOption = None,
    angle: Annotated[
        list[float] | None, typer.Option("--angle", help="Degrees; may be repeated: one strip each.", show_default="0")
    ] = None,
    layer: LayerOption = None,
    retardation: Annotated[
        bool, typer.Option("--retardation", help="The range is one of retardation, 2 n d cos(theta), with its orders.")
    ] = False,
    orders: Annotated[bool, typer.Option("--orders", help="Mark the orders on a scale of thickness, too.")] = False,
    illuminant: IlluminantOption = "D65",
    polarization: PolarizationOption = "unpolarized",
    quantity: QuantityOption = "reflectance",
    model: ModelOption = "exact",
    exposure: ExposureOption = "auto",
    theme: ThemeOption = "light",
    size: SizeOption = None,
    title: TitleOption = None,
    as_json: JsonOption = False,
) -> None:
    """Strips of colour, one for each stack and angle, 0 to 2000 nm unless said otherwise (Newton's scale: to 2200)."""
    angles = angle or [0.0]
    newton = any(one.strip().lower() == "newton" for one in stack)
    by_retardation = retardation or newton
    across = _thicknesses(range_, from_, to, 2200.0 if by_retardation else 2000.0)

    def draw(axes: list[Axes]) -> None:
        from iridesce import plot

        plot.strip(
            stack,
            None if by_retardation else across,
            angles,
            layer=_layer(layer),
            retardation_nm=across if by_retardation else None,
            orders=by_retardation or orders,
            illuminant=illuminant,
            polarization=polarization,
            quantity=quantity,
            model=model,
            exposure=_stops(exposure),
            title=title,
            theme=theme,
            ax=axes[0],
        )

    rows = sum(1 if one.strip().lower() == "newton" else len(angles) for one in stack)
    name = stack[0] if len(stack) == 1 else " ".join(stack)
    _make("strip", name, output, size, (1360, 210 + 82 * rows), 1, draw, as_json)


@group.command()
@answers_errors
def angle(
    stack: GrowingArgument,
    output: OutputOption = None,
    range_: RangeOption = None,
    from_: FromOption = None,
    to: ToOption = None,
    angle: Annotated[str, typer.Option("--angle", metavar="A:B", help="First and last angle, degrees.")] = "0:85",
    layer: LayerOption = None,
    illuminant: IlluminantOption = "D65",
    polarization: PolarizationOption = "unpolarized",
    quantity: QuantityOption = "reflectance",
    model: ModelOption = "exact",
    exposure: ExposureOption = "auto",
    theme: ThemeOption = "light",
    size: SizeOption = None,
    title: TitleOption = None,
    as_json: JsonOption = False,
) -> None:
    """All colours of the film: thickness, 0 to 2000 nm unless said otherwise, against the angle of incidence."""
    across = _thicknesses(range_, from_, to, 2000.0)
    up = pair(angle, "--angle", "degrees")

    def draw(axes: list[Axes]) -> None:
        from iridesce import plot

        plot.chart(
            stack,
            across,
            up,
            layer=_layer(layer),
            illuminant=illuminant,
            polarization=polarization,
            quantity=quantity,
            model=model,
            exposure=_stops(exposure),
            title=title,
            theme=theme,
            ax=axes[0],
        )

    _make("angle", stack, output, size, (1200, 800), 1, draw, as_json)


# --- what the user typed -------------------------------------------------------------------------------------------


def _thicknesses(range_: str | None, start: float | None, end: float | None, default_end: float) -> tuple[float, float]:
    """The range from ``--range A:B``, or from ``--from`` and ``--to``."""
    if range_ is not None:
        if start is not None or end is not None:
            raise typer.BadParameter("--range says it all: leave out --from and --to", param_hint="--range")
        return pair(range_, "--range", "nm")
    return (0.0 if start is None else start, default_end if end is None else end)


def _layer(text: str | None) -> int | str | None:
    return int(text) if text is not None and re.fullmatch(r"\d{1,9}", text) else text


def _stops(text: str) -> float | str:
    if text in ("auto", "common"):
        return text
    try:
        return float(text)
    except ValueError:
        message = f'wanted a number of stops, "auto" or "common", got {text!r}'
        raise typer.BadParameter(message, param_hint="--exposure") from None


# --- the file ------------------------------------------------------------------------------------------------------


def _make(
    kind: str,
    stack: str,
    output: Path | None,
    size: str | None,
    pixels: tuple[int, int],
    panels: int,
    draw: Callable[[list[Any]], None],
    as_json: bool,
) -> None:
    """Draw one chart of one or more panels and write it."""
    path = output or Path(f"{kind}-{_slug(stack)}.png")
    write_panels(path, pixels if size is None else size_in_pixels(size), panels, draw)
    if as_json:
        print_json({"files": [str(path)]})
    else:
        print(path)


def _slug(stack: str) -> str:
    """A file's name from a stack: ``air-soap-air``."""
    words = re.sub(r"[^A-Za-z0-9.+]+", "-", stack).strip("-.")
    return words[:80].strip("-.") or "film"
