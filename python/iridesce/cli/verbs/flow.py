"""The verb ``flow``: a film from its physics into a folder of frames, resumable."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from iridesce._progress import progress_bar
from iridesce.arguments.refusals import complaint
from iridesce.arguments.scalars import whole
from iridesce.cli.answers import note, print_json
from iridesce.cli.options import JsonOption
from iridesce.cli.reading import assignment
from iridesce.cli.run_folder import RunFolder
from iridesce.files import rows
from iridesce.files.whole import append, read_whole, write_whole

if TYPE_CHECKING:
    from iridesce.thickness.simulation import Simulation

# A checkpoint has some hundred bytes for each of its cells, at most 16384 x 8192.
_MOST_BYTES = 16 << 30
# Ten thousand frames of a thousand heights.
_MOST_CSV = 1 << 30
_HISTORY = (
    *("time_s", "mean_nm", "min_nm", "max_nm", "black_share"),
    *("evaporated", "swallowed", "blackened", "drained"),
)
_PROFILE = ("time_s", "height_m", "mean_nm", "min_nm", "max_nm")
_CHECKPOINT = "checkpoint.irflow"
_FORMATS = ("tif", "exr", "npy")


def verb(
    preset: Annotated[str, typer.Argument(help="bubble-on-bath, free-bubble, giant-bubble, late; see --list.")] = "",
    time: Annotated[float, typer.Option("--time", metavar="S", help="Time of the last frame, s.")] = 4.0,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder for the frames.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the run in the folder.")] = False,
    fps: Annotated[float, typer.Option("--fps", help="Frames per second.")] = 30.0,
    seed: Annotated[int, typer.Option(help="Another seed, another film.")] = 1,
    columns: Annotated[int | None, typer.Option(help="Cells around the bubble; the preset's own if not given.")] = None,
    initial: Annotated[
        Path | None,
        typer.Option(
            "--initial",
            metavar="FILE",
            help="Thickness at the start, a map in nm (.tif, .exr, .npy): rows from top to bottom, a dome's from pole to rim.",
        ),
    ] = None,
    history: Annotated[
        Path | None,
        typer.Option(
            "--history",
            metavar="FILE.csv",
            help="Write mean, least and greatest thickness, the black share and where liquid went, a row for each frame.",
        ),
    ] = None,
    profiles: Annotated[
        Path | None,
        typer.Option(
            "--profiles",
            metavar="FILE.csv",
            help="Write mean, least and greatest thickness of each height, a row for each frame and height.",
        ),
    ] = None,
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
    from iridesce.thickness import ThicknessMap

    changes: dict[str, Any] = {key: _real(key, value) for key, value in map(assignment, set_ or [])}
    columns = _columns(columns, changes)
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
    run = RunFolder.of(
        output,
        "a run",
        preset=preset,
        fps=fps,
        seed=seed,
        columns=columns,
        format=format_,
        set=changes,
        initial=None if initial is None else str(initial),
    )
    tables = [
        _FrameRows(path, names) for path, names in ((history, _HISTORY), (profiles, _PROFILE)) if path is not None
    ]
    if history is not None and profiles is not None and history.resolve() == profiles.resolve():
        raise typer.BadParameter(f"is the same file as --history, {history}", param_hint="--profiles")
    for table in tables:
        rows.check(table.path, (".csv",))
    start = None if initial is None else ThicknessMap.load(initial)
    checkpoint = None
    if resume:
        run.taken_up()
        place = output / _CHECKPOINT
        # Interrupted before its first frame, a run starts again.
        checkpoint = read_whole(str(place), _MOST_BYTES) if place.exists() else None
    else:
        run.check_new(may_hold_other_files=True)
    film = thickness.simulate(preset, time, fps, seed, columns, checkpoint, initial=start, **changes)
    if checkpoint is not None:
        _check_frames(output, film.frame, format_)
        for table in tables if film.ruptured_s is None else []:
            table.take_up([frame / fps for frame in range(film.frame)])
    if checkpoint is None:
        run.start(parameters=_plain(film.parameters))
    try:
        written = _write(film, output, format_, tables)
    except KeyboardInterrupt:
        note(f"frame {film.frame} was not finished; the same command with --resume goes on from there")
        raise
    if film.ruptured_s is not None:
        note(f"the film burst at {film.ruptured_s:g} s")
    if as_json:
        print_json({"files": [str(path) for path in written], **film.facts})
    else:
        print(output)
    note(f"{len(written)} frames, {film.facts['step']:g} steps in all")


def _check_frames(folder: Path, count: int, ending: str) -> None:
    """The frames before a checkpoint must be there and whole: the film has flowed on and cannot make them again."""
    from iridesce.thickness import ThicknessMap

    for number in range(count):
        path = folder / f"frame_{number:05d}.{ending}"
        try:
            ThicknessMap.load(path)
        except ValueError as error:
            why = f"the film stands after frame {count - 1} and cannot make it again; start afresh in another folder"
            raise ValueError(f"{error}: {why}") from None


class _FrameRows:
    """Rows of CSV that grow by one or more with each frame, at the end of a file that holds all frames before."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        self.path = path
        self.names = tuple(names)
        # What the file begins with, until it is written.
        self._text = ",".join(names) + "\n"

    def take_up(self, times_s: list[float]) -> None:
        """Go on with the rows of the frames that a run has: none may be missing, later ones are left out."""
        why = f"{self.path} does not hold the rows of the frames before, which cannot be made again"
        if not self.path.exists():
            raise ValueError(f"{why}: there is no such file")
        lines = read_whole(str(self.path), _MOST_CSV).decode("utf-8", "replace").splitlines(keepends=True)
        if not lines or lines[0] != self._text:
            raise ValueError(f"{why}: its first line is not {self._text.strip()}")
        wanted = {f"{time_s:.10g}" for time_s in times_s}
        kept = [line for line in lines[1:] if line.split(",")[0] in wanted]
        if {line.split(",")[0] for line in kept} != wanted:
            raise ValueError(f"{why}: it has {len(kept)} rows of {len(wanted)} frames")
        self._text += "".join(kept)

    def add(self, columns: dict[str, list[float]]) -> None:
        more = rows.csv_text(columns).partition("\n")[2]
        if self._text:
            write_whole(self.path, (self._text + more).encode())
            self._text = ""
        else:
            append(self.path, more.encode())


def _tell(film: Simulation, tables: list[_FrameRows]) -> None:
    """The frame just made, as rows."""
    now = film.summary
    for table in tables:
        if table.names == _HISTORY:
            table.add({name: [float(now[name])] for name in _HISTORY})
        else:
            profile = film.profile()
            times = [float(now["time_s"])] * len(profile)
            table.add({"time_s": times} | {name: profile[name].tolist() for name in _PROFILE[1:]})


def _write(film: Simulation, folder: Path, ending: str, tables: list[_FrameRows]) -> list[Path]:
    written = []
    total = film.frame + len(film)
    with progress_bar("flowing", counted=True) as advance:
        for _ in film:
            path = folder / f"frame_{film.frame - 1:05d}.{ending}"
            film.map().save(path)
            _tell(film, tables)
            write_whole(folder / _CHECKPOINT, film.checkpoint())
            written.append(path)
            advance(film.frame, total)
    return written


def _list(preset: str, seed: int, columns: int | None, changes: dict[str, Any], as_json: bool) -> None:
    from iridesce import thickness

    if not preset:
        names = thickness.presets()
        if as_json:
            print_json(names)
        else:
            print("\n".join(names))
        return
    parameters = _plain(thickness.simulate(preset, 0.0, seed=seed, columns=columns, **changes).parameters)
    if as_json:
        print_json(parameters)
    else:
        print("\n".join(f"{name} = {value}" for name, value in parameters.items()))


def _plain(parameters: dict[str, Any]) -> dict[str, float | str]:
    """JSON knows no infinity."""
    return {name: "inf" if value == float("inf") else value for name, value in parameters.items()}


def _columns(columns: int | None, changes: dict[str, Any]) -> int | None:
    """``--set columns=192`` means ``--columns 192``; the other options are no parameters of the film either."""
    for key, option in (
        ("seed", "--seed"),
        ("time_s", "--time"),
        ("frames_per_second", "--fps"),
        ("rows", "--columns"),
    ):
        if key in changes:
            raise typer.BadParameter(f"{key} is set by the option {option}", param_hint="--set")
    given = changes.pop("columns", None)
    if given is None:
        return columns
    if columns is not None and columns != given:
        raise typer.BadParameter(f"columns={given:g} and --columns {columns} exclude each other", param_hint="--set")
    return whole("columns", int(given) if given.is_integer() else given, 16, 16384)


def _real(key: str, value: Any) -> float | str:
    if key == "sides":
        return str(value)
    if isinstance(value, str) and value in ("inf", "infinity"):
        return float("inf")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise complaint(f"--set {key} must be a number, got {value!r:.60}", f"--set {key}", "a number", value)
    return float(value)
