"""The verb ``fit``: film thickness from a spectrum."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from iridesce.cli.answers import note, print_json
from iridesce.cli.chart_file import FORMATS, write_chart
from iridesce.cli.options import AngleOption, JsonOption, PolarizationOption, SizeOption, ThemeOption
from iridesce.cli.reading import pair


def verb(
    spectrum: Annotated[
        Path, typer.Argument(help="The spectrometer's text file: wavelength and measurement.", show_default=False)
    ],
    stack: Annotated[
        str, typer.Option("--stack", help='Media and layers, ? for what is unknown: "air / SiO2 ? / Si".')
    ],
    angle: AngleOption = 0.0,
    polarization: PolarizationOption = "unpolarized",
    quantity: Annotated[str, typer.Option(help="reflectance or transmittance.")] = "reflectance",
    range_: Annotated[
        list[str] | None,
        typer.Option("--range", metavar="A:B", help="Thicknesses to look among, nm; once, or once for each ?."),
    ] = None,
    gain: Annotated[
        str | None,
        typer.Option(
            help='measured = gain x model; unknown if not given. 1 for a calibrated ratio; "linear": drifting.'
        ),
    ] = None,
    baseline: Annotated[str, typer.Option(help="Stray light: none, constant, linear or quadratic.")] = "constant",
    resolution: Annotated[
        float | None, typer.Option(help="Full width of the instrument's line, nm; found if not given.")
    ] = None,
    index: Annotated[
        str | None, typer.Option(help="Fit the index of the unknown layers too: constant or cauchy.")
    ] = None,
    column: Annotated[str | None, typer.Option(help="Name or number of the measurement's column.")] = None,
    wavelength_column: Annotated[
        str | None, typer.Option("--wavelength-column", help="Name or number of the axis's column.")
    ] = None,
    unit: Annotated[str | None, typer.Option(help="Of the wavelengths: nm, um, angstrom, cm-1, ev.")] = None,
    unit_y: Annotated[
        str | None, typer.Option("--unit-y", help="Of the measurement: ratio, percent, counts, absorbance.")
    ] = None,
    from_: Annotated[float, typer.Option("--from", help="Leave out wavelengths below, nm.")] = 0.0,
    to: Annotated[float, typer.Option("--to", help="Leave out wavelengths above, nm.")] = float("inf"),
    probability: Annotated[float, typer.Option(help="Of the intervals.")] = 0.95,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o", "--output", help="Plot (.png, .pdf, .svg) or curves (.csv, .json) to write; may be given twice."
        ),
    ] = None,
    theme: ThemeOption = "light",
    size: SizeOption = None,
    verbose: Annotated[bool, typer.Option("--verbose", help="Say all of how the file was read.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Film thickness from a reflectance or transmittance spectrum: every plausible solution with its interval."""
    from iridesce.files import rows

    files = output or []
    for file in files:
        rows.check(file, (*FORMATS, *rows.FORMATS))
    pairs = [pair(text, "--range", "nm") for text in range_ or []]

    import iridesce as ir

    read = ir.fit.read_spectrum(
        spectrum,
        column,
        unit,
        quantity,
        wavelength_column=wavelength_column,
        unit_y=unit_y,
        range_nm=(from_, to) if (from_, to) != (0.0, float("inf")) else None,
    )
    inside = ~((read.wavelength_nm < from_) | (read.wavelength_nm > to))
    result = ir.fit_thickness(
        read.wavelength_nm[inside],
        read.measured[inside],
        stack,
        quantity=quantity,
        angle_deg=angle,
        polarization=polarization,
        thickness_range_nm=None if not pairs else pairs[0] if len(pairs) == 1 else pairs,
        gain=_gain(gain),
        baseline=baseline,
        resolution_nm=resolution,
        index=index,
        probability=probability,
    )
    for file in files:
        if file.suffix.lower() in rows.FORMATS:
            columns: dict[str, Any] = {"wavelength_nm": result.wavelength_nm, "measured": result.measured}
            for number, solution in enumerate(result, start=1):
                columns[f"fitted_{number}"] = solution.fitted
            rows.write(file, columns, {"file": str(spectrum), **result.to_dict()})
        else:
            write_chart(file, size, lambda ax: result.plot(ax, theme=theme))
    if as_json:
        answer = {"file": str(spectrum), "column": read.column, "read": read.read.to_dict(), **result.to_dict()}
        print_json({**answer, "files": [str(file) for file in files]})
        return
    if verbose:
        note(f"{spectrum}: {read.read}")
    else:
        for remark in read.notes:
            note(f"note: {remark}")
    print(result)
    for file in files:
        print(file)


def _gain(text: str | None) -> float | str | None:
    if text is None or text == "linear":
        return text
    try:
        return float(text)
    except ValueError:
        raise typer.BadParameter(f'wanted a number or "linear", got {text!r}', param_hint="--gain") from None
