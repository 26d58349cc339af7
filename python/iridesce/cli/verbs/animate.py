"""The verb ``animate``: films that flow, a camera that moves, frames and a video, in one go and resumable."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from iridesce._progress import progress_bar
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.cli.answers import note, print_json, quiet_dask
from iridesce.cli.options import DaskOption, JsonOption, OutsideOption, SceneArgument, SetOption, ThreadsOption
from iridesce.cli.reading import assignment, changed_scene, exposure_in_stops, load_scene, size_in_pixels
from iridesce.cli.run_folder import RunFolder
from iridesce.files.whole import check_place, read_whole, write_whole

if TYPE_CHECKING:
    from collections.abc import Sequence
    from concurrent.futures import Future

    from iridesce.image import Image
    from iridesce.rendering.animation import CameraPath, FlowingFilm
    from iridesce.scene import Scene

_MOST_FRAMES = 100_000
_DRAFT_SAMPLES = 2
# A frame of 2**27 pixels in all its planes has some ten GiB.
_MOST_FRAME_BYTES = 16 << 30


def verb(
    scene: SceneArgument,
    seconds: Annotated[float, typer.Option(metavar="S", help="Length of the footage, s.")] = 10.0,
    fps: Annotated[float, typer.Option(metavar="N", help="Frames per second.")] = 30.0,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Video (.mp4, .mov, .mkv, .webm, .gif), or a folder for the frames."),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with footage that was interrupted.")] = False,
    start: Annotated[float, typer.Option("--start", metavar="S", help="Age of the films at the first frame, s.")] = 0.0,
    speed: Annotated[float, typer.Option(help="Seconds of the films' time per second of footage.")] = 1.0,
    orbit: Annotated[
        float, typer.Option(metavar="DEG", help="Turn the camera about its target by this in all, degrees.")
    ] = 0.0,
    camera: Annotated[
        Path | None,
        typer.Option(help="Camera path, TOML: [[key]] with time_s and some of position, target, fov_deg."),
    ] = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Width and height in pixels, as in 1280x720.")] = None,
    samples: Annotated[
        int | None,
        typer.Option(help="Camera rays per pixel at most, 12 if not given; fewer where the picture has settled."),
    ] = None,
    columns: Annotated[
        int | None, typer.Option(help="Cells around of films that flow; their own if not given.")
    ] = None,
    threads: ThreadsOption = None,
    exposure: Annotated[
        str, typer.Option(metavar="E", help='Stops, or "auto": found in the first frame, the same for all.')
    ] = "auto",
    format_: Annotated[str, typer.Option("--format", help="Of the frames: png, exr, or both.")] = "png",
    keep_frames: Annotated[bool, typer.Option("--keep-frames", help="Keep the frames beside the video.")] = False,
    draft: Annotated[
        bool,
        typer.Option(
            "--draft",
            help="To look at motion and colours: a third of the width and height (of the scene's, or of --size), 2 rays per "
            "pixel unless --samples, films by their preview presets unless --columns: fewer cells, longer steps, no fine folds.",
        ),
    ] = False,
    dask: DaskOption = None,
    set_: SetOption = None,
    allow_outside: OutsideOption = False,
    as_json: JsonOption = False,
) -> None:
    """Footage of a scene: its films flow, the camera moves, every frame is drawn and all are joined into a video.

    Frames and the state of the films are kept until the video is whole: --resume goes on after the last frame.
    """
    from iridesce.rendering import animation

    if output is None:
        raise typer.BadParameter("name a video or a folder, as in -o bubble.mp4", param_hint="-o")
    formats = {"png": ["png"], "exr": ["exr"], "both": ["png", "exr"]}.get(format_)
    if formats is None:
        raise typer.BadParameter(f"must be png, exr or both, got {format_!r}", param_hint="--format")
    count = _frames(seconds, fps)
    _check_times(start, speed)
    width_height = None if size is None else size_in_pixels(size)
    stops = exposure_in_stops(exposure)
    destination = _destination(output, formats)
    folder = destination.folder

    loaded = changed_scene(load_scene(scene, allow_outside), [assignment(text) for text in set_ or []])
    if draft:
        loaded = _draft(loaded) if columns is None else loaded
        samples = _DRAFT_SAMPLES if samples is None else samples
        width_height = _third(width_height or loaded.to_dict()["camera"]["resolution"])
    loaded, films = _films(loaded, columns)
    path = animation.camera_path(loaded.to_dict()["camera"], seconds, orbit, camera)
    _check_motion(scene, films, path)
    run = RunFolder.of(
        folder,
        "footage",
        scene=loaded.to_dict(),
        fps=fps,
        start=start,
        speed=speed,
        seconds=seconds,
        orbit=orbit,
        camera=[[time_s, list(values)] for time_s, values in path.keys],
        size=width_height,
        samples=12 if samples is None else samples,
        format=format_,
        exposure=stops,
    )
    known_stops = None
    if not resume:
        run.check_new()
    else:
        known_stops = run.taken_up().get("stops")
        animation.take_up_films(loaded, films, folder)
    began = time.perf_counter()
    shot = _Shot(loaded, films, path, start, speed, fps, run, formats, threads)
    if dask is None:
        if not resume:
            run.start()
        drawn, used_stops = _draw(shot, count, known_stops)
    else:
        quiet_dask()
        drawn, used_stops = _draw_by(dask, shot, count, known_stops, is_new=not resume)
    answer = _joined(destination, shot, count, keep_frames)
    took = time.perf_counter() - began
    if as_json:
        facts = {"file": str(answer), "frames": count, "drawn": drawn, "exposure": used_stops, "seconds": took}
        print_json(facts)
    else:
        print(answer)
    note(f"{count} frames, {drawn} of them drawn now, {took:.1f} s")


@dataclass(frozen=True)
class _Destination:
    """Where the frames go, and the video if there is to be one and a program that makes it."""

    folder: Path
    video: Path | None
    ffmpeg: str | None


def _destination(output: Path, formats: list[str]) -> _Destination:
    from iridesce.rendering import animation

    if output.suffix.lower() not in animation.VIDEOS:
        if output.suffix and not output.is_dir():
            raise typer.BadParameter(
                f"the name must end in {', '.join(animation.VIDEOS)}, or in nothing for a folder of frames, "
                f"got {str(output)!r}",
                param_hint="-o",
            )
        return _Destination(output, None, None)
    check_place(output)
    if "png" not in formats:
        raise typer.BadParameter("a video is made of png frames: --format png or both", param_hint="--format")
    ffmpeg = animation.find_ffmpeg()
    if ffmpeg is None:
        note('no ffmpeg found, so there will be frames and no video; install ffmpeg, or pip install "iridesce[video]"')
    return _Destination(output.with_suffix(".frames"), output, ffmpeg)


@dataclass(frozen=True)
class _Shot:
    """All that a frame needs."""

    scene: Scene
    films: list[FlowingFilm]
    path: CameraPath
    start: float
    speed: float
    fps: float
    run: RunFolder
    formats: list[str]
    threads: int | None


def _draw(shot: _Shot, count: int, stops: float | None) -> tuple[int, float]:
    """Every frame that is not there yet; how many those were, and the exposure of all."""
    import warnings

    from iridesce.rendering import animation

    asked, folder = shot.run.asked, shot.run.folder
    size = None if asked["size"] is None else (asked["size"][0], asked["size"][1])
    width, height = shot.scene.to_dict()["camera"]["resolution"]
    wanted = size or (int(width), int(height))
    names = [list(animation.frame_names(folder, number, shot.formats)) for number in range(count)]
    missing = [n for n in range(count) if stops is None or not all(is_whole(file, wanted) for file in names[n])]

    def scene(number: int) -> Scene:
        time_s = number / shot.fps
        return animation.scene_at(shot.scene, shot.films, shot.start + shot.speed * time_s, shot.path.at(time_s))

    frames = animation.Frames(still=not shot.path.moves)

    def save(image: Image, files: list[Path], exposure: float, standing: list[bytes | None]) -> None:
        for file in files:
            frames.save(image, file, exposure)
        animation.write_films(standing, folder)

    done = count - len(missing)
    saved: Future[Any] | None = None
    before: Image | None = None
    with progress_bar("frames", counted=True) as advance, animation.Beside() as beside:
        advance(done, count)
        flowed = beside.flow(scene(missing[0])) if missing else None
        for drawn, number in enumerate(missing, start=1):
            assert flowed is not None
            _waited(flowed)
            # The films stand at this frame now, and flow on to the next while it is drawn.
            standing = animation.standing_films(shot.scene, shot.films)
            if drawn < len(missing):
                flowed = beside.flow(scene(missing[drawn]))
            with warnings.catch_warnings():
                # What there is to say of media is said once.
                warnings.simplefilter("default" if drawn == 1 else "ignore")
                planes = shot.formats != ["png"]
                image = animation.draw_frame(scene(number), asked["samples"], size, shot.threads, before, planes)
            if not shot.path.moves:
                before = image
            if stops is None:
                stops = image.exposure_stops(asked["exposure"])
                shot.run.start(stops=stops)
            if saved is not None:
                _waited(saved)
                advance(done + drawn - 1, count)
            saved = beside.do(save, image, names[number], stops, standing)
        if saved is not None:
            _waited(saved)
            advance(count, count)
    return len(missing), 0.0 if stops is None else stops


def _waited(asked: Future[Any]) -> None:
    """Wait for what is done beside; Ctrl-C is heard within 50 ms on every platform, and its errors are told here."""
    from concurrent.futures import TimeoutError

    while True:
        try:
            asked.result(timeout=0.05)
        except TimeoutError:
            if asked.done():
                raise
        else:
            return


def _draw_by(address: str, shot: _Shot, count: int, stops: float | None, is_new: bool) -> tuple[int, float]:
    """As `_draw`, by the workers of a cluster: the first frame, which finds the exposure, then all others side by side.

    Nothing is written before there are workers: where nobody answers, no folder is left.
    """
    from iridesce.rendering import animation
    from iridesce.sweeping.cluster import opened
    from iridesce.sweeping.frames import draw_frame
    from iridesce.sweeping.subjects import SceneSubject

    asked, folder = shot.run.asked, shot.run.folder
    own_size = shot.scene.to_dict()["camera"]["resolution"]
    size = (int(x) for x in asked["size"] or own_size)
    wanted = (next(size), next(size))
    names = [list(animation.frame_names(folder, number, shot.formats)) for number in range(count)]
    missing = [n for n in range(count) if stops is None or not all(is_whole(file, wanted) for file in names[n])]
    subject = SceneSubject(shot.scene, "image")
    files = subject.files([])

    def item(number: int, exposure: float | str) -> tuple[Any, ...]:
        time_s = number / shot.fps
        film_s = shot.start + shot.speed * time_s
        how = {"samples": asked["samples"], "size": asked["size"]}
        return shot.films, film_s, shot.path.at(time_s), how, shot.formats, exposure, shot.threads

    drawn = 0
    with progress_bar("frames", counted=True) as advance, opened(address, files=list(files)) as cluster:
        assert cluster is not None
        if is_new:
            shot.run.start()
        already = count - len(missing)
        advance(already, count)
        while missing:
            # The exposure of the first frame is that of all.
            now = missing if stops is not None else missing[:1]
            exposure = asked["exposure"] if stops is None else stops
            for place, answer, error in cluster.ask(draw_frame, subject, [item(n, exposure) for n in now], files):
                if error is not None:
                    raise error
                if stops is None:
                    stops = float(answer[0])
                    shot.run.start(stops=stops)
                for file, content in zip(names[now[place]], answer[1], strict=True):
                    write_whole(file, content)
                drawn += 1
                advance(already + drawn, count)
            missing = missing[len(now) :]
    return drawn, 0.0 if stops is None else stops


def _joined(destination: _Destination, shot: _Shot, count: int, keep_frames: bool) -> Path:
    """What the footage is in: a video of the frames, or their folder."""
    from iridesce.rendering import animation

    if destination.video is None or destination.ffmpeg is None:
        return destination.folder
    animation.write_video(destination.ffmpeg, destination.folder, shot.fps, count, destination.video)
    if not keep_frames:
        _remove(shot.run, count, shot.formats, len(shot.films))
    return destination.video


def _check_motion(scene: str, films: list[FlowingFilm], path: CameraPath) -> None:
    if not films and not path.moves:
        raise complaint(
            f"nothing moves: {scene} has no film that flows; give its thickness_nm as {{ flow = ... }}, or --orbit or "
            "--camera",
            "scene",
            "a scene with a film that flows, unless --orbit or --camera is given",
            scene,
        )


def _third(size: Sequence[int]) -> tuple[int, int]:
    width, height = size
    return max(int(width) // 3, 1), max(int(height) // 3, 1)


def _draft(scene: Scene) -> Scene:
    """Films by the presets that are made for looking: coarser, in longer steps."""
    from iridesce.rendering.animation import flowing_films
    from iridesce.thickness import presets

    for film in flowing_films(scene.to_dict()):
        preview = f"{film.preset}-preview"
        if preview in presets():
            scene = scene.with_value(f"{film.key}.preset", preview)
    return scene


def _frames(seconds: float, fps: float) -> int:
    for option, value in (("--seconds", seconds), ("--fps", fps)):
        if not (math.isfinite(value) and value > 0.0):
            raise refusal(option, "> 0 and finite", Words(f"{value:g}"))
    count = seconds * fps
    if count > _MOST_FRAMES:
        raise complaint(
            f"--seconds {seconds:g} at --fps {fps:g} is more than {_MOST_FRAMES} frames",
            "--seconds",
            f"{_MOST_FRAMES} frames at most",
            Words(f"{seconds:g} at --fps {fps:g}"),
        )
    return max(round(count), 1)


def _check_times(start: float, speed: float) -> None:
    if not (math.isfinite(start) and start >= 0.0):
        raise refusal("--start", ">= 0 and finite, in s", Words(f"{start:g}"))
    if not (math.isfinite(speed) and speed >= 0.0):
        raise refusal("--speed", ">= 0 and finite", Words(f"{speed:g}"))


def _films(scene: Scene, columns: int | None) -> tuple[Scene, list[FlowingFilm]]:
    from iridesce.rendering.animation import flowing_films

    if columns is not None:
        for film in flowing_films(scene.to_dict()):
            scene = scene.with_value(f"{film.key}.columns", columns)
    return scene, flowing_films(scene.to_dict())


def is_whole(file: Path, size: tuple[int, int]) -> bool:
    """Whether a frame is there to its last byte. An interrupted machine may leave a name with nothing, or half, behind it."""
    from iridesce import _core

    if not file.exists():
        return False
    try:
        fault = _core.picture_fault(read_whole(str(file), _MOST_FRAME_BYTES), *size)
    except ValueError as error:
        fault = str(error)
    if fault is not None:
        note(f"{file}: {fault}; it is drawn again")
    return fault is None


def _remove(run: RunFolder, count: int, formats: list[str], films: int) -> None:
    """What this verb wrote, and the folder if that was all."""
    from iridesce.rendering.animation import frame_names

    for number in range(count):
        for file in frame_names(run.folder, number, formats):
            file.unlink(missing_ok=True)
    for number in range(films):
        (run.folder / f"film_{number}.irflow").unlink(missing_ok=True)
    run.remove()
