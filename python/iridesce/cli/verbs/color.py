"""The verb ``color``: the colour of a stack."""

from __future__ import annotations

import sys
from typing import Annotated, Any

import typer

from iridesce.cli.answers import print_json
from iridesce.cli.options import (
    AnglesOption,
    CsvOption,
    IlluminantOption,
    JsonOption,
    PolarizationOption,
    StackArgument,
    TableOption,
)
from iridesce.cli.reading import angles_in_degrees, reading


def verb(
    stack: StackArgument,
    angle: AnglesOption = "0",
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

    degrees = angles_in_degrees(angle)
    with reading():
        parsed = ir.Stack.parse(stack)

        def in_space(name: str, degree: float, **options: Any) -> list[float]:
            values = parsed.color(
                angle_deg=degree,
                polarization=polarization,
                illuminant=illuminant,
                observer=observer,
                quantity=quantity,
                space=name,
                **options,
            )
            return [float(value) for value in values]

        def all_of(degree: float) -> tuple[dict[str, list[float]], list[float]]:
            answer = {name: in_space(name, degree) for name in ("xyz", "xyy", "lab", "lch")}
            answer["srgb"] = in_space("srgb", degree, gamut="hue")
            return answer, in_space("linear-srgb", degree)

        told = [({space: in_space(space, degree)}, []) if space is not None else all_of(degree) for degree in degrees]
    rest = {"polarization": polarization, "illuminant": illuminant, "observer": observer, "quantity": quantity}
    questions = [{"stack": stack, "angle_deg": degree, **rest} for degree in degrees]
    facts: list[dict[str, Any]] = [
        {} if space is not None else {"hex": _hex(answer["srgb"]), "in_srgb": _in_gamut(linear)}
        for answer, linear in told
    ]
    if output is not None or as_csv:
        lines = [
            {**question, **fact, **_numbered(answer)}
            for question, fact, (answer, _) in zip(questions, facts, told, strict=True)
        ]
        table = {name: [line[name] for line in lines] for name in lines[0]}
        if output is not None:
            rows.write(output, table, {})
            print(output)
        else:
            print(rows.csv_text(table), end="")
    elif as_json:
        answers = [
            {**question, **({"space": space, "values": answer[space]} if space is not None else answer), **fact}
            for question, fact, (answer, _) in zip(questions, facts, told, strict=True)
        ]
        print_json(answers[0] if len(answers) == 1 else answers)
    else:
        for degree, (answer, linear) in zip(degrees, told, strict=True):
            if space is not None:
                print(" ".join(f"{value:.6g}" for value in answer[space]))
                continue
            if len(degrees) > 1:
                print(f"{degree:g} degrees")
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
