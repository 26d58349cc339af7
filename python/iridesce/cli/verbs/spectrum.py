"""The verb ``spectrum``: R, T and A of a stack against wavelength."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from iridesce.cli.answers import print_json
from iridesce.cli.options import AngleOption, CsvOption, JsonOption, PolarizationOption, StackArgument, TableOption
from iridesce.cli.reading import reading, wavelength_grid


def verb(
    stack: StackArgument,
    angle: AngleOption = 0.0,
    polarization: PolarizationOption = "unpolarized",
    from_: Annotated[float, typer.Option("--from", help="First vacuum wavelength, nm.")] = 380.0,
    to: Annotated[float, typer.Option("--to", help="Last vacuum wavelength, nm.")] = 780.0,
    step: Annotated[float, typer.Option("--step", help="Step, nm.")] = 5.0,
    resolution: Annotated[
        float, typer.Option(help="Full width of the instrument's Gaussian line, nm: averages R and T over it.")
    ] = 0.0,
    output: TableOption = None,
    as_csv: CsvOption = False,
    as_json: JsonOption = False,
) -> None:
    """Reflectance, transmittance and absorptance of a stack against wavelength, as CSV unless --json says otherwise."""
    from iridesce.files import rows

    if as_csv and as_json:
        raise typer.BadParameter("--csv and --json exclude each other", param_hint="--csv")
    if output is not None:
        rows.check(output)
    import iridesce as ir

    wavelength_nm = wavelength_grid(from_, to, step)
    with reading():
        parsed = ir.Stack.parse(stack)
        columns = {"wavelength_nm": wavelength_nm, **_powers(parsed, wavelength_nm, angle, polarization, resolution)}
    lists = {name: [float(value) for value in values] for name, values in columns.items()}
    question = {"stack": stack, "angle_deg": angle, "polarization": polarization, "resolution_nm": resolution}
    if output is not None:
        rows.write(output, lists, question)
        print(output)
    elif as_json:
        print_json({**question, **lists})
    else:
        print(rows.csv_text(lists), end="")


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
