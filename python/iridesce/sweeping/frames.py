"""Frames of footage, and shards of one picture, on workers. Films that flow stay where they stood, for a worker's next frame."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from iridesce._progress import progress_bar
from iridesce.image import Image
from iridesce.rendering import merge, render
from iridesce.rendering.animation import FlowingFilm, Frames, scene_at
from iridesce.rendering.animation import draw_frame as frame_picture
from iridesce.scene import Scene
from iridesce.sweeping.cluster import opened
from iridesce.sweeping.subjects import SceneSubject
from iridesce.sweeping.worker import Sent, subject_at_home


def draw_frame(
    sent: Sent,
    films: Sequence[FlowingFilm],
    film_s: float,
    camera: dict[str, Any],
    asked: dict[str, Any],
    formats: Sequence[str],
    exposure: float | str,
    threads: int | None,
) -> tuple[float, list[bytes]]:
    """Draw a frame as ``animate`` does here: the stops it was developed with, and the content of its files.

    A film flows on from where this worker's last frame left it, so that frames in order cost each worker one course of it.
    """
    subject = subject_at_home(sent)
    assert isinstance(subject, SceneSubject)
    now = scene_at(subject.scene, films, film_s, camera)
    image = frame_picture(now, asked["samples"], asked["size"], threads or 1)
    stops = image.exposure_stops(exposure)
    contents = []
    with tempfile.TemporaryDirectory(prefix="iridesce-") as folder:
        for ending in formats:
            path = Path(folder) / f"frame.{ending}"
            Frames(still=False).save(image, path, stops)
            contents.append(path.read_bytes())
    return stops, contents


def draw_shard(sent: Sent, asked: dict[str, Any], shard: tuple[int, int]) -> bytes:
    """Draw every N-th tile of a picture: the content of its EXR file."""
    subject = subject_at_home(sent)
    assert isinstance(subject, SceneSubject)
    with tempfile.TemporaryDirectory(prefix="iridesce-") as folder:
        path = Path(folder) / "shard.exr"
        render(subject.scene, **{**asked, "threads": asked["threads"] or 1}, shard=shard).save(path)
        return path.read_bytes()


# Shards for each thread of the workers: the last ones are short then, and a death costs little.
_SHARDS = 4


def draw_in_shards(client: Any, scene: Scene, asked: dict[str, Any]) -> Image:
    """A picture whose tiles the workers of a cluster draw; the bytes of ``render``."""
    subject = SceneSubject(scene, "image")
    files = subject.files([])
    with (
        opened(client, files=list(files)) as cluster,
        progress_bar("rendering") as advance,
        tempfile.TemporaryDirectory(prefix="iridesce-") as folder,
    ):
        assert cluster is not None
        count = _SHARDS * cluster.threads
        advance(0, count)
        parts = [Path(folder) / f"{number:05d}.exr" for number in range(count)]
        items = [(asked, (number + 1, count)) for number in range(count)]
        for done, (place, content, error) in enumerate(cluster.ask(draw_shard, subject, items, files), start=1):
            if error is not None:
                raise error
            parts[place].write_bytes(content)
            advance(done, count)
        return merge(parts)
