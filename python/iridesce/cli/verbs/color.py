"""The verb ``color``: the colour of a stack."""

from __future__ import annotations

import sys
from typing import Annotated, Any

import typer

from iridesce.cli.answers import print_json
from iridesce.cli.options import (
    AngleOption,
    CsvOption,
    IlluminantOption,
    JsonOption,
    PolarizationOption,
    StackArgument,
    TableOption,
)
from iridesce.cli.reading import reading


def verb(
    stack: StackArgument,
    angle: AngleOption = 0.0,
    polarization: PolarizationOption = "unpolarized",
    illuminant: IlluminantOption = "D65",
    observer: Annotated[str, typer.Option(help="cie1931 or cie1964.")] = "cie1931",
    space: Annotated[
        str | None, typer.Option(help="Print three numbers in this space only: xyz, lab, srgb, ... (as in Python).")
    ] = None,
    quantity: Annotated[str, typer.Option(help="reflectance or transmittance.")] = "reflectance",
    output: TableOption = None,
    as_csv: CsvOption = False,
    as_json: JsonOption = False,
) -> None:
    """The colour of a stack."""
    from iridesce.files import rows

    if output is not None:
        rows.check(output)
    import iridesce as ir

    with reading():
        parsed = ir.Stack.parse(stack)

        def in_space(name: str, **options: Any) -> list[float]:
            values = parsed.color(
                angle_deg=angle,
                polarization=polarization,
                illuminant=illuminant,
                observer=observer,
                quantity=quantity,
                space=name,
                **options,
            )
            return [float(value) for value in values]

        question = {
            "stack": stack,
            "angle_deg": angle,
            "polarization": polarization,
            "illuminant": illuminant,
            "observer": observer,
            "quantity": quantity,
        }
        if space is not None:
            values = in_space(space)
            table = {name: [value] for name, value in {**question, **_numbered({space: values})}.items()}
            if output is not None:
                rows.write(output, table, {})
                print(output)
            elif as_csv:
                print(rows.csv_text(table), end="")
            elif as_json:
                print_json({**question, "space": space, "values": values})
            else:
                print(" ".join(f"{value:.6g}" for value in values))
            return
        answer = {name: in_space(name) for name in ("xyz", "xyy", "lab", "lch")}
        answer["srgb"] = in_space("srgb", gamut="hue")
        linear = in_space("linear-srgb")
    facts = {"hex": _hex(answer["srgb"]), "in_srgb": _in_gamut(linear)}
    table = {name: [value] for name, value in {**question, **facts, **_numbered(answer)}.items()}
    if output is not None:
        rows.write(output, table, {})
        print(output)
        return
    if as_csv:
        print(rows.csv_text(table), end="")
        return
    if as_json:
        print_json({**question, **answer, **facts})
        return
    _print_color(answer, linear)


def _numbered(colors: dict[str, list[float]]) -> dict[str, float]:
    """Three numbers a space as columns: lab_1, lab_2, lab_3."""
    return {
        f"{name}_{number}": value for name, values in colors.items() for number, value in enumerate(values, start=1)
    }


def _hex(srgb: list[float]) -> str:
    return "#" + "".join(f"{round(255.0 * min(max(value, 0.0), 1.0)):02x}" for value in srgb)


def _in_gamut(linear: list[float]) -> bool:
    return all(-1e-9 <= value <= 1.0 + 1e-9 for value in linear)


def _print_color(answer: dict[str, list[float]], linear: list[float]) -> None:
    """The colour for people: numbers, and on a terminal a swatch as it is and one as bright as sRGB can show it."""
    lines = [
        ("XYZ", "{:.5f} {:.5f} {:.5f}".format(*answer["xyz"])),
        ("x, y", "{:.4f} {:.4f}".format(*answer["xyy"])),
        ("L* a* b*", "{:.2f} {:.2f} {:.2f}".format(*answer["lab"])),
        ("L* C* h", "{:.2f} {:.2f} {:.1f}".format(*answer["lch"])),
        ("sRGB", _hex(answer["srgb"]) + ("" if _in_gamut(linear) else "  (outside sRGB; nearest of the same hue)")),
    ]
    from iridesce.color import convert

    peak = max(max(linear), 1e-12)
    bright = [float(value) for value in convert([max(value, 0.0) / peak for value in linear], "linear-srgb", "srgb")]
    if sys.stdout.isatty():
        from rich.console import Console
        from rich.text import Text

        console = Console(highlight=False)
        if console.color_system is not None:
            swatch = Text("  as it is  ", style=f"on {_hex(answer['srgb'])}")
            swatch.append("  brightened  ", style=f"black on {_hex(bright)}")
            console.print(swatch)
    lines.append(("brightened", _hex(bright)))
    for label, value in lines:
        print(f"{label:<11} {value}")
