"""What the user typed: sizes, ranges, assignments, scenes."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from iridesce.scene import Scene


@contextlib.contextmanager
def reading() -> Iterator[None]:
    """Input that cannot be read is bad input, while output that cannot be written is a failure."""
    try:
        yield
    except OSError as error:
        raise ValueError(f"{error.filename}: {error.strerror}" if error.filename else str(error)) from error


def size_in_pixels(text: str) -> tuple[int, int]:
    # As many digits as Python turns into a number: a monstrous size is a matter of resources, not of usage.
    match = re.fullmatch(r"\s*(\d{1,4000})\s*[xX\u00d7]\s*(\d{1,4000})\s*", text)
    if match is None:
        raise typer.BadParameter(f"wanted width x height in pixels, as in 640x480, got {text!r}", param_hint="--size")
    return int(match[1]), int(match[2])


def crop_in_pixels(text: str) -> tuple[int, ...]:
    match = re.fullmatch(r"\s*(\d{1,10})\s*,\s*(\d{1,10})\s*,\s*(\d{1,10})\s*,\s*(\d{1,10})\s*", text)
    if match is None:
        message = f"wanted x, y, width and height in pixels, as in 100,50,320,240, got {text!r:.60}"
        raise typer.BadParameter(message, param_hint="--crop")
    return tuple(int(word) for word in match.groups())


def exposure_in_stops(text: str) -> float | str:
    if text == "auto":
        return text
    try:
        return float(text)
    except ValueError:
        message = f'wanted a number of stops or "auto", got {text!r}'
        raise typer.BadParameter(message, param_hint="--exposure") from None


def assignment(text: str) -> tuple[str, Any]:
    """``KEY=VALUE``, the value written as in a scene file; what is no TOML value is taken as a string."""
    from iridesce.arguments.scalars import shown
    from iridesce.files.trees import NotATree, from_toml

    key, equals, value = text.partition("=")
    key = key.strip()
    if not equals or not key:
        raise typer.BadParameter(f"wanted KEY=VALUE, got {text!r:.80}", param_hint="--set")
    try:
        tree = from_toml(f"value = {value}", f"--set {shown(key)}")
    except NotATree:
        return key, value.strip()
    if len(tree) > 1:
        # A second line would be another key, and would be dropped.
        raise typer.BadParameter(f"wanted one KEY=VALUE, got more after the value of {shown(key)}", param_hint="--set")
    return key, tree["value"]


def angles_in_degrees(text: str) -> list[float]:
    """``0,45`` as numbers; their range is for the stack to check."""
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        message = f"wanted one angle in degrees or several with commas between, as in 0,45, got {text!r:.60}"
        raise typer.BadParameter(message, param_hint="--angle") from None


def wavelength_grid(
    start: float, stop: float, step: float, names: tuple[str, str, str] = ("--from", "--to", "--step")
) -> Any:
    """Wavelengths from `start` to `stop`, the end included when a whole number of steps leads to it; ``names`` are what the
    user calls the three."""
    import math

    import numpy as np

    from iridesce.errors import ResourceError

    for option, value in zip(names, (start, stop, step), strict=True):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{option} must be > 0 and finite, in nm, got {value:g}")
    if stop < start:
        raise ValueError(f"{names[1]} must not be below {names[0]}, got {start:g} to {stop:g} nm")
    steps = (stop - start) / step
    if steps > 1e7:
        raise ResourceError(f"{names[2]} {step:g} asks for {steps:.3g} wavelengths, at most 1e7 are allowed")
    # A hair more than the quotient, or rounding would lose the last point of, say, 0.1 nm steps.
    return start + step * np.arange(int(steps * (1.0 + 1e-12) + 1e-9) + 1)


def wavelengths_of(text: str) -> Any:
    """``FROM:TO:STEP`` in nm, both ends included."""
    words = text.split(":")
    try:
        start, stop, step = (float(word) for word in words)
    except ValueError:
        message = f"wanted FROM:TO:STEP in nm, as in 400:700:10, got {text!r:.60}"
        raise typer.BadParameter(message, param_hint="--spectral") from None
    return wavelength_grid(start, stop, step, ("FROM of --spectral", "TO of --spectral", "STEP of --spectral"))


def pair(text: str, option: str, unit: str) -> tuple[float, float]:
    first, colon, last = text.partition(":")
    try:
        if not colon:
            raise ValueError
        return float(first), float(last)
    except ValueError:
        raise typer.BadParameter(f"wanted two numbers in {unit}, as in 0:60, got {text!r}", param_hint=option) from None


def ends(
    range_: str | None, start: float | None, end: float | None, default: tuple[float, float]
) -> tuple[float, float]:
    """The range in nm from ``--range A:B``, or from ``--from`` and ``--to``."""
    if range_ is None:
        return default[0] if start is None else start, default[1] if end is None else end
    if start is not None or end is not None:
        raise typer.BadParameter("--range says it all: leave out --from and --to", param_hint="--range")
    return pair(range_, "--range", "nm")


def load_scene(scene: str, allow_outside: bool) -> Scene:
    from iridesce.scene import Scene

    with reading():
        return Scene.load(scene, allow_outside=allow_outside)


def is_stack_text(source: str) -> bool:
    """Whether a word names a stack, as in ``air / soap 320 / air``, rather than a scene."""
    return re.search(r"(?<!\S)/(?!\S)", source) is not None


def changed_scene(scene: Scene, changes: list[tuple[str, Any]]) -> Scene:
    """The scene with what --set says."""
    for key, value in changes:
        scene = scene.with_value(key, value)
    return scene


def thickness_range(text: str | None) -> tuple[float, float] | None:
    """Two thicknesses in nm from ``--vary A:B``."""
    if text is None:
        return None
    first, colon, last = text.partition(":")
    try:
        if not colon:
            raise ValueError
        return float(first), float(last)
    except ValueError:
        message = f"wanted two thicknesses in nm, as in 0:1200, got {text!r}"
        raise typer.BadParameter(message, param_hint="--vary") from None


def plain_name(scene: str) -> str:
    """What a scene's pictures are called: its name, or its file's name without the ending."""
    return Path(scene).stem if scene.endswith((".toml", ".json")) else Path(scene).name


def check_picture(path: Path) -> None:
    """Find out before a long render, not after it, that its picture has nowhere to go."""
    if path.suffix.lower() not in {".png", ".exr"}:
        raise typer.BadParameter(f"the name must end in .png or .exr, got {str(path)!r}", param_hint="-o")

    from iridesce.image import check_output

    check_output(path)


def shard_of(text: str | None) -> tuple[int, int] | None:
    """``I/N``, I from 1 to N."""
    if text is None:
        return None
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text.strip())
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise typer.BadParameter(f"wanted I/N with I from 1 to N, as in 2/4, got {text!r:.60}", param_hint="--shard")
    return int(match[1]), int(match[2])


def varied(texts: list[str]) -> dict[str, list[Any]]:
    """``KEY=A:B:N`` (N values from A to B, both among them) or ``KEY=V1,V2``, values as in a scene file or plain words."""
    found: dict[str, list[Any]] = {}
    for text in texts:
        key, equals, values = text.partition("=")
        key, values = key.strip(), values.strip()
        if not equals or not key or not values:
            raise typer.BadParameter(f"wanted KEY=A:B:N or KEY=V1,V2, got {text!r:.80}", param_hint="--vary")
        if key in found:
            raise typer.BadParameter(f"{key} is given twice", param_hint="--vary")
        found[key] = _range(key, values) or _listed(key, values)
    return found


def _range(key: str, text: str) -> list[Any] | None:
    """The values of ``A:B:N``; None for what is none."""
    parts = text.split(":")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        return None
    if len(numbers) == 1:
        return None
    if len(numbers) != 3 or not numbers[2].is_integer() or not 1 <= numbers[2] <= 1_000_000:
        raise typer.BadParameter(
            f"{key}: wanted A:B:N, N a whole number from 1 to 1000000, got {text!r:.80}", param_hint="--vary"
        )
    import numpy as np

    found: list[Any] = np.linspace(numbers[0], numbers[1], int(numbers[2])).tolist()
    return found


def _listed(key: str, text: str) -> list[Any]:
    from iridesce.files.trees import NotATree, from_toml

    where = f"--vary {key}"
    try:
        tree = from_toml(f"value = [{text}]", where)
        if len(tree) == 1 and isinstance(tree["value"], list):
            return tree["value"]
    except NotATree:
        pass
    found: list[Any] = []
    for word in text.split(","):
        try:
            found.append(from_toml(f"value = {word}", where)["value"])
        except NotATree:
            found.append(word.strip())
    return found
