"""Scenes in time: which films flow, where the camera goes, frames on disk, and a video of them. Internal to the verb."""

from __future__ import annotations

import math
import shutil
import subprocess
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from iridesce import _core
from iridesce.arguments.refusals import refusal
from iridesce.files.trees import from_toml
from iridesce.files.whole import check_place, read_whole, write_whole
from iridesce.image import Image
from iridesce.rendering.pictures import draw
from iridesce.scene import Scene

# Relative error of Y in nine tenths of a tile's pixels below which it takes no more samples: 4.5 of 12 on the bubble of
# `soap-bubble`, whose frames then differ from such with all samples by CIEDE2000 0.19 in the median, 2.1 in the worst twentieth;
# those of another seed by 0.08 and 1.6, those with an error of 0.04 by 0.09 and 0.7 (docs/evidence/performance.md).
SETTLED = 0.1
# What a video file's ending asks of ffmpeg. Quality where nothing of the film's fine structure is lost to the eye.
# A path of a key for each frame of an hour has some ten MiB.
_MOST_PATH_BYTES = 16 << 20
_MOST_FILM_BYTES = 16 << 30

_CODECS = {
    ".mp4": ("-c:v", "libx264", "-preset", "slow", "-crf", "14", "-pix_fmt", "yuv420p", "-movflags", "+faststart"),
    ".mov": ("-c:v", "libx264", "-preset", "slow", "-crf", "14", "-pix_fmt", "yuv420p", "-movflags", "+faststart"),
    ".mkv": ("-c:v", "libx264", "-preset", "slow", "-crf", "14", "-pix_fmt", "yuv420p"),
    ".webm": ("-c:v", "libvpx-vp9", "-crf", "20", "-b:v", "0", "-pix_fmt", "yuv420p"),
}
VIDEOS = (*_CODECS, ".gif")
# Frames are sRGB; video players expect the matrix of Rec.709 and are told so. Even sides, which halved colour needs.
_TO_VIDEO = (
    "scale=trunc(iw/2)*2:trunc(ih/2)*2:out_color_matrix=bt709:out_range=tv",
    *("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-color_range", "tv"),
)
_TO_GIF = "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=sierra2_4a"


@dataclass(frozen=True)
class FlowingFilm:
    """A film of a scene that flows: where in the scene, and which."""

    key: str
    preset: str
    seed: int
    columns: int | None

    @property
    def which(self) -> tuple[str, int, int | None]:
        return self.preset, self.seed, self.columns


def flowing_films(tree: dict[str, Any]) -> list[FlowingFilm]:
    """Every thickness of a scene that is a film that flows."""
    found = []
    for number, item in enumerate(tree["object"]):
        surface = item["surface"]
        places = [("film", surface["film"])] if "film" in surface else []
        if "coating" in surface:
            layers = enumerate(surface["coating"]["layers"])
            places += [(f"coating.layers.{i}", layer) for i, layer in layers]
        for place, layer in places:
            thickness = layer["thickness_nm"]
            if isinstance(thickness, dict) and "flow" in thickness:
                flow = thickness["flow"]
                key = f"object.{number}.surface.{place}.thickness_nm.flow"
                found.append(FlowingFilm(key, flow["preset"], flow["seed"], flow.get("columns")))
    return found


# ---------------------------------------------------------------------------------------------------------------------
# The camera


@dataclass(frozen=True)
class CameraPath:
    """Where the camera is: keys in time, joined by cubic curves, and a turn about the target on top of that.

    values  (time in s, nine numbers: position, target; the field of view or the height of the view) in order of time
    """

    zoom: str
    up: tuple[float, float, float]
    keys: tuple[tuple[float, tuple[float, ...]], ...]
    turn_deg: float
    seconds: float

    def at(self, time_s: float) -> dict[str, Any]:
        """The camera's keys of a scene at a time."""
        values = _between(self.keys, time_s)
        position, target, zoom = values[0:3], values[3:6], values[6]
        angle = math.radians(self.turn_deg) * (time_s / self.seconds if self.seconds > 0.0 else 0.0)
        way = [a - b for a, b in zip(position, target, strict=True)]
        turned = _turned(way, self.up, angle)
        return {
            "position": [a + b for a, b in zip(target, turned, strict=True)],
            "target": list(target),
            self.zoom: zoom,
        }

    @property
    def moves(self) -> bool:
        return self.turn_deg != 0.0 or len({values for _, values in self.keys}) > 1


def camera_path(camera: dict[str, Any], seconds: float, turn_deg: float, file: Path | None) -> CameraPath:
    """The path that a file of keys says, or a camera that stays; both may turn about their target.

    ``ValueError`` naming the file, the key and what is allowed.
    """
    zoom = "fov_deg" if "fov_deg" in camera else "orthographic_height"
    if not math.isfinite(turn_deg):
        raise refusal("turn_deg", "a finite number of degrees", turn_deg)
    own = {"position": camera["position"], "target": camera["target"], zoom: camera[zoom]}
    rows = [{"time_s": 0.0, **own}] if file is None else _read_keys(file, own, zoom)
    keys = tuple((float(row["time_s"]), (*row["position"], *row["target"], float(row[zoom]))) for row in rows)
    up = tuple(float(x) for x in camera["up"])
    return CameraPath(zoom, (up[0], up[1], up[2]), keys, turn_deg, seconds)


def _is_number(value: object) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number beyond any other
        return False


def _shown(value: object) -> str:
    """What was given, for a message: short, whatever it is."""
    try:
        return f"{value!r:.80}"
    except (ValueError, RecursionError):
        return f"something of type {type(value).__name__}"


def _read_keys(file: Path, own: dict[str, Any], zoom: str) -> list[dict[str, Any]]:
    content = read_whole(str(file), _MOST_PATH_BYTES, "no camera path is")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{file}: no TOML file: {error}") from None
    tree = from_toml(text, str(file))
    rows = tree.get("key")
    if set(tree) != {"key"} or not isinstance(rows, list) or not rows:
        raise ValueError(f"{file}: wanted tables [[key]], each with time_s and some of {', '.join(own)}")
    keys: list[dict[str, Any]] = []
    for number, row in enumerate(rows):
        place = f"{file}: key {number}"
        for name, value in row.items():
            if name not in ("time_s", *own):
                raise ValueError(f"{place}: unknown {name!r}; wanted time_s, {', '.join(own)}")
            wanted = 3 if name in ("position", "target") else 1
            numbers = value if isinstance(value, list) else [value]
            good = all(_is_number(x) for x in numbers)
            if not good or len(numbers) != wanted or (wanted == 3) != isinstance(value, list):
                raise ValueError(
                    f"{place}: {name} must be {'three numbers' if wanted == 3 else 'a number'}, got {_shown(value)}"
                )
        if "time_s" not in row:
            raise ValueError(f"{place} has no time_s")
        if keys and not row["time_s"] > keys[-1]["time_s"]:
            raise ValueError(
                f"{place}: time_s must grow from key to key, got {row['time_s']!r} after {keys[-1]['time_s']!r}"
            )
        # What a key leaves out stays as it was.
        keys.append({**(keys[-1] if keys else own), **row})
    return keys


def _between(keys: Sequence[tuple[float, tuple[float, ...]]], time_s: float) -> tuple[float, ...]:
    """Cubic Hermite curves whose slope at a key is the mean of the slopes on its two sides, none at both ends."""
    last = len(keys) - 1
    if time_s <= keys[0][0]:
        return keys[0][1]
    if time_s >= keys[last][0]:
        return keys[last][1]
    at = max(i for i in range(last) if keys[i][0] <= time_s)
    (start, a), (end, b) = keys[at], keys[at + 1]
    width = end - start
    f = (time_s - start) / width

    def slope(i: int, k: int) -> float:
        if i in (0, last):
            return 0.0
        (t0, v0), (t1, v1), (t2, v2) = keys[i - 1], keys[i], keys[i + 1]
        return 0.5 * ((v1[k] - v0[k]) / (t1 - t0) + (v2[k] - v1[k]) / (t2 - t1))

    g, h = f * f, f * f * f
    return tuple(
        (2 * h - 3 * g + 1) * a[k]
        + (h - 2 * g + f) * width * slope(at, k)
        + (3 * g - 2 * h) * b[k]
        + (h - g) * width * slope(at + 1, k)
        for k in range(len(a))
    )


def _turned(v: Sequence[float], axis: Sequence[float], angle: float) -> list[float]:
    """Rodrigues' rotation."""
    length = math.sqrt(sum(x * x for x in axis))
    n = [x / length for x in axis]
    cross = [n[1] * v[2] - n[2] * v[1], n[2] * v[0] - n[0] * v[2], n[0] * v[1] - n[1] * v[0]]
    along = sum(a * b for a, b in zip(n, v, strict=True))
    sine, cosine = math.sin(angle), math.cos(angle)
    return [v[i] * cosine + cross[i] * sine + n[i] * along * (1.0 - cosine) for i in range(3)]


# ---------------------------------------------------------------------------------------------------------------------
# Scenes, frame by frame


def scene_at(scene: Scene, films: Sequence[FlowingFilm], film_s: float, camera: dict[str, Any]) -> Scene:
    """The scene with its films at one time of theirs, and its camera in one place."""
    for key, value in camera.items():
        scene = scene.with_value(f"camera.{key}", value)
    for film in films:
        scene = scene.with_value(f"{film.key}.time_s", film_s)
    return scene


def draw_frame(
    now: Scene,
    samples: int,
    size: tuple[int, int] | None,
    threads: int | None,
    before: Image | None = None,
    planes: bool = True,
) -> Image:
    """The picture of a frame, with no more samples than it takes to settle.

    before   a frame of the same scene by the same camera, at which only films have flowed since: where it shows no surface
             it is taken as it is, with the same bytes as if it were drawn again
    planes   whether to join more than what a PNG shows
    """
    asked = {"samples": samples, "size": size, "threads": threads, "settled": SETTLED}
    if before is None or before._surfaces is None:
        return draw(now, asked, None)
    x, y, width, height = part = before._surfaces
    drawn = draw(now, {**asked, "crop": part}, None)
    place = (slice(y, y + height), slice(x, x + width))

    def whole(old: Any, new: Any) -> Any:
        joined = old.copy()
        joined[place] = new
        return joined

    wanted = [name for name in before._planes if planes or name == "alpha"]
    joined = {name: whole(before._planes[name], drawn._planes[name]) for name in wanted}
    facts = {name: value for name, value in drawn._facts.items() if name != "crop"}
    return Image._of_render(whole(before._xyz, drawn._xyz), joined, {}, facts, part)


class Frames:
    """Saves frames one after the other, each with the pixels and facts that `Image.save` gives it, in files made quickly.

    still   whether what shows no surface stays as it is from frame to frame: it is developed once
    """

    def __init__(self, still: bool) -> None:
        self._still = still
        self._rgb: Any = None
        self._around = (0, 0)

    def save(self, image: Image, file: Path, exposure: float) -> None:
        """One frame; files are whole or not there."""
        if file.suffix != ".png":
            image.save(file)
            return
        if not self._still or image._surfaces is None or "alpha" in image._planes:
            image._save_png(str(file), exposure, "srgb", "hue", 8, is_quick=True)
            return
        x, y, width, height = image._surfaces
        place = (slice(y, y + height), slice(x, x + width))
        rgb, inside = _developed(image._xyz[place], exposure)
        if self._rgb is None:
            self._rgb, counts = _developed(image._xyz, exposure)
            self._around = (counts[0] - inside[0], counts[1] - inside[1])
        self._rgb[place] = rgb
        pixels = image.width * image.height
        out_of_gamut, overexposed = ((a + b) / pixels for a, b in zip(self._around, inside, strict=True))
        facts = image._file_facts()
        facts += [("exposure", exposure), ("space", "srgb"), ("gamut", "hue")]
        facts += [("out_of_gamut", out_of_gamut), ("overexposed", overexposed)]
        _core.check_output(str(file))
        _core.save_png(str(file), self._rgb, 8, "srgb", facts, True)


def _developed(xyz: Any, exposure: float) -> tuple[Any, tuple[int, int]]:
    """What a display shows, and how many pixels lay outside its space and were too bright for it."""
    rgb, *shares = _core.develop_image(np.ascontiguousarray(xyz), "srgb", exposure, "hue")
    out_of_gamut, overexposed = (round(share * rgb.shape[0] * rgb.shape[1]) for share in shares)
    return rgb, (out_of_gamut, overexposed)


def standing_films(scene: Scene, films: Sequence[FlowingFilm]) -> list[bytes | None]:
    """Where the films stand; None for one that has not flowed."""
    return [scene._core.standing(*film.which) for film in films]


def keep_films(scene: Scene, films: Sequence[FlowingFilm], folder: Path) -> None:
    """Write where the films stand, so that another run can go on from there."""
    write_films(standing_films(scene, films), folder)


def write_films(standing: Sequence[bytes | None], folder: Path) -> None:
    """Write where films stood."""
    for number, content in enumerate(standing):
        if content is not None:
            write_whole(folder / f"film_{number}.irflow", content)


class Beside:
    """One thread that saves frames and lets films flow on while the next frame is drawn; whoever leaves stops it.

    >>> with Beside() as beside:
    ...     beside.do(len, "frame").result()
    5
    """

    def __init__(self) -> None:
        self._left = threading.Event()
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="iridesce")

    def __enter__(self) -> Beside:
        return self

    def __exit__(self, *_: object) -> None:
        self._left.set()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def do(self, work: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Do this after what was asked for before."""
        return self._pool.submit(work, *arguments)

    def flow(self, scene: Scene) -> Future[Any]:
        """Let the films of a scene flow; they stop where whoever asked has left."""

        def tell(*_: object) -> None:
            if self._left.is_set():
                raise InterruptedError

        return self.do(scene._core.resolve, tell)


def take_up_films(scene: Scene, films: Sequence[FlowingFilm], folder: Path) -> None:
    """Let films go on where they stood; those that are not kept flow from their beginning again."""
    for number, film in enumerate(films):
        kept = folder / f"film_{number}.irflow"
        if kept.exists():
            try:
                scene._core.stand(*film.which, read_whole(str(kept), _MOST_FILM_BYTES))
            except ValueError:
                # Of another version perhaps: the film is made again, which takes longer and ends the same.
                kept.unlink()


# ---------------------------------------------------------------------------------------------------------------------
# Video


def find_ffmpeg() -> str | None:
    """The user's ffmpeg, or that of the extra `video`; None if there is neither."""
    own = shutil.which("ffmpeg")
    if own is not None:
        return own
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return None


def write_video(ffmpeg: str, frames: Path, fps: float, count: int, path: Path) -> None:
    """Join frames into a video, whole or not at all. ``OSError`` with what ffmpeg said last if it fails."""
    check_place(path)
    part = path.with_name(f".{path.stem}.part{path.suffix}")
    ending = path.suffix.lower()
    if ending == ".gif":
        how: tuple[str, ...] = ("-filter_complex", _TO_GIF)
    else:
        how = ("-vf", _TO_VIDEO[0], *_CODECS[ending], *_TO_VIDEO[1:])
    source = ("-framerate", f"{fps:.10g}", "-start_number", "0", "-i", str(frames / "frame_%05d.png"))
    command = [ffmpeg, "-hide_banner", "-loglevel", "error", "-nostdin", "-y", *source]
    command += ["-frames:v", str(count), *how, str(part)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace")
        if done.returncode != 0:
            said = done.stderr.strip().splitlines()
            raise OSError(f"ffmpeg could not write {path}: {said[-1] if said else f'exit code {done.returncode}'}")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def frame_names(folder: Path, number: int, formats: Sequence[str]) -> Iterator[Path]:
    """The files of one frame."""
    for ending in formats:
        yield folder / f"frame_{number:05d}.{ending}"
