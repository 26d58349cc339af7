"""The verb ``flow``: a film from its physics into a folder of frames, resumable."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from iridesce._progress import progress_bar
from iridesce.cli.commands import JsonOption, _assignment, _note, _print_json, app
from iridesce.cli.entry import answers_errors
from iridesce.files.whole import write_whole

if TYPE_CHECKING:
    from iridesce.thickness.simulation import Simulation

_RUN = "run.json"
_CHECKPOINT = "checkpoint.irflow"
_FORMATS = ("tif", "exr", "npy")


@app.command()
@answers_errors
def flow(
    preset: Annotated[str, typer.Argument(help="bubble-on-bath, free-bubble, giant-bubble, late; see --list.")] = "",
    time: Annotated[float, typer.Option("--time", metavar="S", help="Time of the last frame, s.")] = 4.0,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder for the frames.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the run in the folder.")] = False,
    fps: Annotated[float, typer.Option("--fps", help="Frames per second.")] = 30.0,
    seed: Annotated[int, typer.Option(help="Another seed, another film.")] = 1,
    columns: Annotated[int | None, typer.Option(help="Cells around the bubble; the preset's own if not given.")] = None,
    format_: Annotated[str, typer.Option("--format", help="Of the frames: tif, exr or npy, all in nm.")] = "tif",
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change one parameter, as in radius_m=0.03; may be repeated."),
    ] = None,
    list_: Annotated[
        bool, typer.Option("--list", help="List the presets, or the parameters of the one given.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Let a soap film flow: thickness frames in nm, over a whole sphere, and a checkpoint to go on from."""
    from iridesce import thickness

    changes: dict[str, Any] = {key: _real(key, value) for key, value in map(_assignment, set_ or [])}
    if list_:
        _list(preset, seed, columns, changes, as_json)
        return
    if not preset:
        raise typer.BadParameter(
            "name a preset, as in `iridesce flow bubble-on-bath --time 4 -o run`", param_hint="PRESET"
        )
    if output is None:
        raise typer.BadParameter("name a folder for the frames", param_hint="-o")
    if format_ not in _FORMATS:
        raise typer.BadParameter(f"must be one of {', '.join(_FORMATS)}, got {format_!r}", param_hint="--format")
    run = {"preset": preset, "fps": fps, "seed": seed, "columns": columns, "format": format_, "set": changes}
    checkpoint = _checkpoint(output, run, resume)
    film = thickness.simulate(preset, time, fps, seed, columns, checkpoint, **changes)
    output.mkdir(parents=True, exist_ok=True)
    if checkpoint is None:
        write_whole(
            output / _RUN, (json.dumps({**run, "parameters": _plain(film.parameters)}, indent=1) + "\n").encode()
        )
    try:
        written = _write(film, output, format_)
    except KeyboardInterrupt:
        _note(f"frame {film.frame} was not finished; the same command with --resume goes on from there")
        raise
    if film.ruptured_s is not None:
        _note(f"the film burst at {film.ruptured_s:g} s")
    if as_json:
        _print_json({"files": [str(path) for path in written], **film.facts})
    else:
        print(output)
    _note(f"{len(written)} frames, {film.facts['step']:g} steps in all")


def _write(film: Simulation, folder: Path, ending: str) -> list[Path]:
    written = []
    total = film.frame + len(film)
    with progress_bar("flowing", counted=True) as advance:
        for _ in film:
            path = folder / f"frame_{film.frame - 1:05d}.{ending}"
            film.map().save(path)
            write_whole(folder / _CHECKPOINT, film.checkpoint())
            written.append(path)
            advance(film.frame, total)
    return written


def _checkpoint(folder: Path, run: dict[str, Any], resume: bool) -> bytes | None:
    """The checkpoint of the folder's run, if it is to go on; ``ValueError`` where that or a fresh start is not possible."""
    description = folder / _RUN
    if not resume:
        if description.exists():
            raise ValueError(f"{folder} holds a run; --resume goes on with it, another folder starts afresh")
        return None
    if not description.exists():
        raise ValueError(f"{folder} holds no run to resume: no {_RUN}")
    try:
        before = json.loads(description.read_bytes())
        old = {key: before[key] for key in run}
    except (ValueError, KeyError, TypeError, UnicodeDecodeError):
        raise ValueError(f"{description} is not the description of a run") from None
    for key, value in run.items():
        if old[key] != value:
            raise ValueError(
                f"{folder} holds a run with {key} {old[key]!r:.80}, not {value!r:.80}; --resume takes the same"
            )
    place = folder / _CHECKPOINT
    # Interrupted before its first frame, a run starts again.
    return place.read_bytes() if place.exists() else None


def _list(preset: str, seed: int, columns: int | None, changes: dict[str, Any], as_json: bool) -> None:
    from iridesce import thickness

    if not preset:
        names = thickness.presets()
        if as_json:
            _print_json(names)
        else:
            print("\n".join(names))
        return
    parameters = _plain(thickness.simulate(preset, 0.0, seed=seed, columns=columns, **changes).parameters)
    if as_json:
        _print_json(parameters)
    else:
        print("\n".join(f"{name} = {value}" for name, value in parameters.items()))


def _plain(parameters: dict[str, float]) -> dict[str, float | str]:
    """JSON knows no infinity."""
    return {name: value if abs(value) < float("inf") else "inf" for name, value in parameters.items()}


def _real(key: str, value: Any) -> float:
    if isinstance(value, str) and value in ("inf", "infinity"):
        return float("inf")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"--set {key} must be a number, got {value!r:.60}")
    return float(value)
