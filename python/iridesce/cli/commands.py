"""The verbs of the command line: a thin reader of the same API that Python users have.

Everything heavy is imported inside the verbs, so that `iridesce --help` does not pay for it.
Answers go to stdout, progress and notes to stderr.
"""

from __future__ import annotations

import contextlib
import json
import re
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from iridesce.cli.entry import answers_errors

if TYPE_CHECKING:
    from iridesce.image import Image
    from iridesce.scene import Scene

app = typer.Typer(
    help="Interference colour: from a film to its spectrum, its colour and its picture.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Exit codes: 0 done, 1 failed, 2 wrong usage, 3 bad input, 4 resource limit, 130 interrupted.",
)

STACK_HELP = 'Media and layers separated by " / "; layers add their nm: "air / soap 320 / air", "air / TiO2 60 / Ti".'

SceneArgument = Annotated[
    str, typer.Argument(help="A scene file, or the name of a built-in scene.", show_default=False)
]
StackArgument = Annotated[str, typer.Argument(help=STACK_HELP, show_default=False)]
AngleOption = Annotated[float, typer.Option("--angle", help="Degrees from the normal in the first medium, 0 to < 90.")]
PolarizationOption = Annotated[str, typer.Option("--polarization", help="s, p or unpolarized.")]
OutsideOption = Annotated[
    bool, typer.Option("--allow-outside", help="Let the scene name files outside its own folder.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Answer in JSON.")]
CsvOption = Annotated[bool, typer.Option("--csv", help="Answer in CSV.")]
TableOption = Annotated[
    Path | None, typer.Option("-o", "--output", help="Write the answer into this file: .csv or .json.")
]


@app.callback(invoke_without_command=True)
def root(
    version: Annotated[bool, typer.Option("--version", help="Print the version and leave.")] = False,
) -> None:
    """Interference colour: from a film to its spectrum, its colour and its picture."""
    if version:
        from iridesce import __version__

        print(f"iridesce {__version__}")
        raise typer.Exit


# --- pictures ------------------------------------------------------------------------------------------------------


@app.command()
@answers_errors
def render(
    scene: SceneArgument,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--output",
            help="Picture to write, .png or .exr; may be given twice. Without it both are written here.",
        ),
    ] = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Width and height in pixels, as in 640x480.")] = None,
    samples: Annotated[int | None, typer.Option(help="Camera rays per pixel.")] = None,
    seed: Annotated[int | None, typer.Option(help="Another seed gives other, independent noise.")] = None,
    threads: Annotated[int | None, typer.Option(help="Threads; all cores if not given.")] = None,
    exposure: Annotated[str, typer.Option(metavar="E", help='Stops for the .png, or "auto".')] = "auto",
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change one value of the scene; may be given many times."),
    ] = None,
    allow_outside: OutsideOption = False,
    as_json: JsonOption = False,
) -> None:
    """Draw a scene: writes its picture as .png (to look at) and .exr (all the numbers)."""
    width_height = None if size is None else _size(size)
    stops = _exposure(exposure)
    changes = [_assignment(text) for text in set_ or []]
    loaded = _changed(_load(scene, allow_outside), changes)
    paths = output or [Path(_plain_name(scene) + suffix) for suffix in (".png", ".exr")]
    for path in paths:
        _check_output(path)

    import iridesce as ir

    started = time.perf_counter()
    image = ir.render(loaded, samples=samples, seed=seed, size=width_height, threads=threads, progress=True)
    for path in paths:
        image.save(path, exposure=stops)
    seconds = time.perf_counter() - started
    if as_json:
        facts = {key: value for key, value in image.metadata.items() if key != "scene"}
        _print_json({"files": [str(path) for path in paths], **facts})
    else:
        for path in paths:
            print(path)
    _note(_summary(image, seconds))


@app.command()
@answers_errors
def scenes(as_json: JsonOption = False) -> None:
    """List the built-in scenes."""
    from iridesce.scene import scene_names

    names = scene_names()
    if as_json:
        _print_json(names)
    else:
        print("\n".join(names))


@app.command()
@answers_errors
def check(scene: SceneArgument, allow_outside: OutsideOption = False, as_json: JsonOption = False) -> None:
    """Validate a scene and print it with all its defaults, as TOML."""
    tree = _load(scene, allow_outside).to_dict()
    if as_json:
        _print_json(tree)
    else:
        from iridesce.files.toml import dumps

        print(dumps(tree), end="")


# --- numbers -------------------------------------------------------------------------------------------------------


@app.command()
@answers_errors
def color(
    stack: StackArgument,
    angle: AngleOption = 0.0,
    polarization: PolarizationOption = "unpolarized",
    illuminant: Annotated[
        str, typer.Option(help="D65, A, FL2, blackbody:2856, lines:589.158, a CSV file, ...")
    ] = "D65",
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

    with _reading():
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
                _print_json({**question, "space": space, "values": values})
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
        _print_json({**question, **answer, **facts})
        return
    _print_color(answer, linear)


@app.command()
@answers_errors
def spectrum(
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

    wavelength_nm = _grid(from_, to, step)
    with _reading():
        parsed = ir.Stack.parse(stack)
        columns = {"wavelength_nm": wavelength_nm, **_powers(parsed, wavelength_nm, angle, polarization, resolution)}
    lists = {name: [float(value) for value in values] for name, values in columns.items()}
    question = {"stack": stack, "angle_deg": angle, "polarization": polarization, "resolution_nm": resolution}
    if output is not None:
        rows.write(output, lists, question)
        print(output)
    elif as_json:
        _print_json({**question, **lists})
    else:
        print(rows.csv_text(lists), end="")


def _numbered(colors: dict[str, list[float]]) -> dict[str, float]:
    """Three numbers a space as columns: lab_1, lab_2, lab_3."""
    return {
        f"{name}_{number}": value for name, values in colors.items() for number, value in enumerate(values, start=1)
    }


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


@app.command()
@answers_errors
def info(as_json: JsonOption = False) -> None:
    """Versions, threads, SIMD level, data sources."""
    import importlib.metadata
    import platform

    from iridesce import _core

    libraries = ("numpy", "matplotlib", "typer", "rich", "tifffile")
    facts: dict[str, Any] = {
        "iridesce": _core.__version__,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "threads": _threads(),
        "simd": _core.SIMD_LEVEL,
        "libraries": {library: importlib.metadata.version(library) for library in libraries},
        "data": _data_sources(),
    }
    if as_json:
        _print_json(facts)
        return
    for key in ("iridesce", "python", "platform", "threads", "simd"):
        print(f"{key:<10} {facts[key]}")
    print(f"{'libraries':<10} " + ", ".join(f"{name} {version}" for name, version in facts["libraries"].items()))
    print("data")
    for name, source in facts["data"].items():
        print(f"  {name:<16} {source}")


def _threads() -> int:
    """How many threads work when nobody says otherwise."""
    import os

    wish = os.environ.get("RAYON_NUM_THREADS", "")
    if wish.isdecimal() and int(wish) > 0:
        return int(wish)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# --- reading what the user typed -----------------------------------------------------------------------------------


def _size(text: str) -> tuple[int, int]:
    # As many digits as Python turns into a number: a monstrous size is a matter of resources, not of usage.
    match = re.fullmatch(r"\s*(\d{1,4000})\s*[xX\u00d7]\s*(\d{1,4000})\s*", text)
    if match is None:
        raise typer.BadParameter(f"wanted width x height in pixels, as in 640x480, got {text!r}", param_hint="--size")
    return int(match[1]), int(match[2])


def _exposure(text: str) -> float | str:
    if text == "auto":
        return text
    try:
        return float(text)
    except ValueError:
        message = f'wanted a number of stops or "auto", got {text!r}'
        raise typer.BadParameter(message, param_hint="--exposure") from None


def _assignment(text: str) -> tuple[str, Any]:
    """``KEY=VALUE``, the value written as in a scene file; what is no TOML value is taken as a string."""
    import tomllib

    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise typer.BadParameter(f"wanted KEY=VALUE, got {text!r}", param_hint="--set")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key.strip(), value.strip()


def _grid(start: float, stop: float, step: float) -> Any:
    """Wavelengths from `start` to `stop`, the end included when a whole number of steps leads to it."""
    import math

    import numpy as np

    from iridesce.errors import ResourceError

    for option, value in (("--from", start), ("--to", stop), ("--step", step)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{option} must be > 0 and finite, in nm, got {value:g}")
    if stop < start:
        raise ValueError(f"--to must not be below --from, got {start:g} to {stop:g} nm")
    steps = (stop - start) / step
    if steps > 1e7:
        raise ResourceError(f"--step {step:g} asks for {steps:.3g} wavelengths, at most 1e7 are allowed")
    # A hair more than the quotient, or rounding would lose the last point of, say, 0.1 nm steps.
    return start + step * np.arange(int(steps * (1.0 + 1e-12) + 1e-9) + 1)


@contextlib.contextmanager
def _reading() -> Iterator[None]:
    """Input that cannot be read is bad input, while output that cannot be written is a failure."""
    try:
        yield
    except OSError as error:
        raise ValueError(f"{error.filename}: {error.strerror}" if error.filename else str(error)) from error


def _load(scene: str, allow_outside: bool) -> Scene:
    from iridesce.scene import Scene

    with _reading(), _flowing():
        return Scene.load(scene, allow_outside=allow_outside)


def _changed(scene: Scene, changes: list[tuple[str, Any]]) -> Scene:
    """The scene with what --set says."""
    with _flowing():
        for key, value in changes:
            scene = scene.with_value(key, value)
    return scene


@contextlib.contextmanager
def _flowing() -> Iterator[None]:
    """A bar for films that flow while a scene is read; none where nothing flows."""
    from iridesce import _core
    from iridesce._progress import progress_bar

    with progress_bar("the film flows") as advance:
        _core.flow_watch(advance)
        try:
            yield
        finally:
            _core.flow_watch(None)


def _plain_name(scene: str) -> str:
    """What a scene's pictures are called: its name, or its file's name without the ending."""
    return Path(scene).stem if scene.endswith((".toml", ".json")) else Path(scene).name


def _check_output(path: Path) -> None:
    """Find out before a long render, not after it, that its picture has nowhere to go."""
    if path.suffix.lower() not in {".png", ".exr"}:
        raise typer.BadParameter(f"the name must end in .png or .exr, got {str(path)!r}", param_hint="-o")

    from iridesce.image import check_output

    check_output(path)


# --- writing the answer --------------------------------------------------------------------------------------------


def _print_json(value: Any) -> None:
    print(json.dumps(value, indent=2, ensure_ascii=False, default=_plain))


def _plain(value: Any) -> Any:
    """numpy's scalars and arrays as plain numbers and lists."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


def _note(text: str) -> None:
    print(text, file=sys.stderr)


def _summary(image: Image, seconds: float) -> str:
    height, width = image.xyz.shape[:2]
    metadata = image.metadata
    text = f"{width} x {height} pixels, {metadata['samples']} samples, seed {metadata['seed']}, {seconds:.2f} s"
    share = metadata.get("out_of_gamut")
    if isinstance(share, float) and share > 0.0:
        text += f"; {100.0 * share:.1f} % of the pixels lie outside sRGB (hue kept in the .png)"
    return text


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


def _media_names() -> list[str]:
    import iridesce as ir

    return [str(getattr(entry, "name", entry)) for entry in ir.media()]


def _data_sources() -> dict[str, str]:
    import iridesce as ir

    sources = {
        "observers": "CIE 1931 2 degrees and CIE 1964 10 degrees, 1 nm",
        "illuminants": "CIE 5 nm tables; CIE daylight components; Planck's law",
    }
    return {**sources, **{name: str(ir.Medium(name).source) for name in _media_names()}}
