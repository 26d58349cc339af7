"""The verb ``spectrum``: R, T and A of a stack against wavelength."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from iridesce.cli.answers import print_json
from iridesce.cli.options import AnglesOption, CsvOption, JsonOption, PolarizationOption, SpectrumOption, StackArgument
from iridesce.cli.reading import angles_in_degrees, ends, reading, wavelength_grid


def verb(
    stack: StackArgument,
    angle: AnglesOption = "0",
    polarization: PolarizationOption = "unpolarized",
    range_: Annotated[
        str | None, typer.Option("--range", metavar="A:B", help="First and last vacuum wavelength, nm.")
    ] = None,
    from_: Annotated[
        float | None, typer.Option("--from", help="First vacuum wavelength, nm (380).", show_default=False)
    ] = None,
    to: Annotated[
        float | None, typer.Option("--to", help="Last vacuum wavelength, nm (780).", show_default=False)
    ] = None,
    step: Annotated[float, typer.Option("--step", help="Step, nm.")] = 5.0,
    resolution: Annotated[
        float, typer.Option(help="Full width of the instrument's Gaussian line, nm: averages R and T over it.")
    ] = 0.0,
    output: SpectrumOption = None,
    as_csv: CsvOption = False,
    as_json: JsonOption = False,
) -> None:
    """Reflectance, transmittance and absorptance of a stack against wavelength, as CSV unless --json says otherwise.

    -o FILE writes a table (.csv, .json) or a plot (.png, .pdf, .svg).
    """
    from iridesce.files import rows

    if as_csv and as_json:
        raise typer.BadParameter("--csv and --json exclude each other", param_hint="--csv")
    plotted = output is not None and output.suffix.lower() in _PLOTS
    if output is not None and not plotted:
        rows.check(output)
    import iridesce as ir
    from iridesce.optics.wavelengths import SPECTRUM_NM

    wavelength_nm = wavelength_grid(*ends(range_, from_, to, SPECTRUM_NM), step)
    degrees = angles_in_degrees(angle)
    if plotted and resolution != 0.0:
        raise typer.BadParameter("a plot shows the stack itself: leave out --resolution", param_hint="--resolution")
    with reading():
        parsed = ir.Stack.parse(stack)
        if plotted and output is not None:
            _plot_spectrum(parsed, wavelength_nm, degrees, polarization, output)
            print(output)
            return
        columns = {"wavelength_nm": wavelength_nm}
        for degree in degrees:
            ending = f"_{degree:g}deg" if len(degrees) > 1 else ""
            powers = _powers(parsed, wavelength_nm, degree, polarization, resolution)
            columns |= {f"{name}{ending}": values for name, values in powers.items()}
    lists = {name: [float(value) for value in values] for name, values in columns.items()}
    question = {
        "stack": stack,
        "angle_deg": degrees[0] if len(degrees) == 1 else degrees,
        "polarization": polarization,
        "resolution_nm": resolution,
    }
    if output is not None:
        rows.write(output, lists, question)
        print(output)
    elif as_json:
        print_json({**question, **lists})
    else:
        print(rows.csv_text(lists), end="")


_PLOTS = (".png", ".pdf", ".svg")


def _plot_spectrum(stack: Any, wavelength_nm: Any, degrees: list[float], polarization: str, output: Path) -> None:
    from iridesce import plot
    from iridesce.cli.chart_file import write_chart

    quantities = ["reflectance", "transmittance", "absorptance"] if len(degrees) == 1 else ["reflectance"]
    write_chart(
        output,
        None,
        lambda ax: plot.spectrum(
            stack, wavelength_nm, quantity=quantities, angle_deg=degrees, polarization=polarization, ax=ax
        ),
    )


def _powers(stack: Any, wavelength_nm: Any, angle: float, polarization: str, resolution: float) -> dict[str, Any]:
    """R, T and A, through an instrument where it has a width."""
    if resolution == 0.0:
        names = ("reflectance", "transmittance", "absorptance")
        return {name: getattr(stack, name)(wavelength_nm, angle, polarization) for name in names}
    seen = {
        name: getattr(stack, f"{name}_averaged")(wavelength_nm, angle, polarization, resolution_nm=resolution).value
        for name in ("reflectance", "transmittance")
    }
    return {**seen, "absorptance": 1.0 - seen["reflectance"] - seen["transmittance"]}
