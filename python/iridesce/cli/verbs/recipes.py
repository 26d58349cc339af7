"""The verb ``recipes``: films that show a colour."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from iridesce.cli.answers import note, print_json, tell, terminal_columns
from iridesce.cli.chart_file import FORMATS, write_chart
from iridesce.cli.options import AngleOption, IlluminantOption, JsonOption, SizeOption, ThemeOption
from iridesce.cli.reading import pair


def verb(
    target: Annotated[
        str,
        typer.Argument(
            help='A colour: space and three numbers, "lab 45 50 -30", "xyy 0.3 0.3 0.2"; or "#2040a0" (sRGB).',
            show_default=False,
        ),
    ],
    media: Annotated[str, typer.Option("--media", help="What layers may be made of: SiO2,TiO2.")],
    substrate: Annotated[str, typer.Option("--substrate", help="What they stand on: Si.")],
    outside: Annotated[str, typer.Option(help="What is above.")] = "air",
    illuminant: IlluminantOption = "D65",
    observer: Annotated[str, typer.Option(help="cie1931 or cie1964.")] = "cie1931",
    angle: AngleOption = 0.0,
    layers: Annotated[str, typer.Option(help="Numbers of layers: 1,2 or 3.")] = "1,2",
    range_: Annotated[str, typer.Option("--range", metavar="A:B", help="Of each layer, nm.")] = "5:400",
    max_delta_e: Annotated[
        float, typer.Option("--max-delta-e", help="CIEDE2000 up to which a film counts as the colour.")
    ] = 2.0,
    sigma: Annotated[
        float | None,
        typer.Option(
            help="Standard deviation of each layer when made, relative; 0.01 if not given.", show_default=False
        ),
    ] = None,
    sigma_nm: Annotated[float | None, typer.Option("--sigma-nm", help="The same in nm, instead.")] = None,
    limit_delta_e: Annotated[
        float, typer.Option("--limit-delta-e", help="CIEDE2000 up to which a made film is accepted.")
    ] = 2.0,
    count: Annotated[int, typer.Option(help="At most so many, of best yield.")] = 20,
    coupon: Annotated[
        list[str] | None,
        typer.Option(
            "--coupon",
            metavar="VOLT=NM",
            help="An anodised sample of yours, VOLT=NM or VOLT=L,a,b; at least two, then volts are told.",
        ),
    ] = None,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o", "--output", help="Plot of the reachable colours (.png, .pdf, .svg), or table (.csv, .json)."
        ),
    ] = None,
    theme: ThemeOption = "light",
    size: SizeOption = None,
    as_json: JsonOption = False,
) -> None:
    """Films of one, two or three layers that show a colour, the safest to make first."""
    from iridesce.files import rows

    files = output or []
    for file in files:
        rows.check(file, (*FORMATS, *rows.FORMATS))
    space, values = _target(target)
    named = [_medium(one.strip()) for one in media.split(",") if one.strip()]
    counts = _counts(layers)
    thickness_range = pair(range_, "--range", "nm")
    coupons = None if coupon is None else [_coupon(one) for one in coupon]

    import iridesce as ir
    from iridesce._progress import progress_bar

    films: dict[str, Any] = {
        "media": named,
        "substrate": _medium(substrate),
        "outside": _medium(outside),
        "space": space,
        "illuminant": illuminant,
        "observer": observer,
        "angle_deg": angle,
        "layers": counts,
        "thickness_range_nm": thickness_range,
    }
    with progress_bar("tables", counted=True) as advance:
        found = ir.recipes(
            values,
            **films,
            max_delta_e=max_delta_e,
            sigma=sigma,
            sigma_nm=sigma_nm,
            limit_delta_e=limit_delta_e,
            count=count,
            coupons=coupons,
            progress=advance,
        )
    for file in files:
        if file.suffix.lower() in rows.FORMATS:
            told = [one.to_dict() for one in found]
            columns = {name: [_word(one[name]) for one in told] for name in told[0]}
            rows.write(file, columns, {"target": values, "space": space})
        else:
            write_chart(file, size, lambda ax: ir.plot.reachable(**films, target=values, ax=ax, theme=theme))
    for remark in found.notes:
        note(f"note: {remark}")
    if as_json:
        print_json(
            {
                "target": values,
                "space": space,
                "lab": [float(one) for one in found.target],
                "reachable": found[0].reachable,
                "recipes": [one.to_dict() for one in found],
                "notes": list(found.notes),
                "files": [str(file) for file in files],
            }
        )
        return
    _tell(found.rows())
    for file in files:
        print(file)


_HEAD = ["stack", "CIEDE2000", "yield", "a nm", "volts"]


def _tell(rows: list[list[str]]) -> None:
    """A table; on a terminal that is too narrow for it, a sentence a film."""
    lines = [_HEAD, *rows]
    widths = [max(len(line[column]) for line in lines) for column in range(5)]
    columns = terminal_columns()
    if columns is None or sum(widths) + 8 <= columns:
        for line in lines:
            print("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())
        return
    for stack, *values in rows:
        facts = [f"{name} {value}" for name, value in zip(_HEAD[1:], values, strict=True) if value]
        tell(f"{stack}: {', '.join(facts)}")


def _target(text: str) -> tuple[str, list[float]]:
    words = text.replace(",", " ").split()
    try:
        if len(words) == 1 and words[0].startswith("#") and len(words[0]) == 7:
            return "srgb", [int(words[0][place : place + 2], 16) / 255.0 for place in (1, 3, 5)]
        if len(words) == 4:
            return words[0].lower(), [float(one) for one in words[1:]]
    except ValueError:
        pass
    wanted = f'wanted a space and three numbers, as in "lab 45 50 -30", or "#2040a0", got {text!r:.60}'
    raise typer.BadParameter(wanted, param_hint="TARGET")


def _medium(text: str) -> Any:
    """A name, a number, or n+kj."""
    try:
        return complex(text)
    except ValueError:
        return text


def _counts(text: str) -> list[int]:
    try:
        return [int(one) for one in text.split(",")]
    except ValueError:
        raise typer.BadParameter(
            f"wanted 1, 2, 3 with commas between, got {text!r:.40}", param_hint="--layers"
        ) from None


def _coupon(text: str) -> tuple[float, Any]:
    volt, _, value = text.partition("=")
    try:
        numbers = [float(one) for one in value.split(",")]
        if len(numbers) in (1, 3):
            return float(volt), numbers[0] if len(numbers) == 1 else numbers
    except ValueError:
        pass
    wanted = f"wanted VOLT=NM or VOLT=L,a,b, as in 30=62, got {text!r:.60}"
    raise typer.BadParameter(wanted, param_hint="--coupon")


def _word(value: Any) -> Any:
    return (
        " ".join(f"{one:.6g}" if isinstance(one, float) else str(one) for one in value)
        if isinstance(value, list)
        else value
    )
