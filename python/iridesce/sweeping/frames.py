"""One frame of footage on a worker. Films that flow stay where they stood, for the worker's next frame."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from iridesce.rendering import render
from iridesce.rendering.animation import FlowingFilm, scene_at
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
    image = render(now, samples=asked["samples"], size=asked["size"], threads=threads or 1)
    stops = image.exposure_stops(exposure)
    contents = []
    with tempfile.TemporaryDirectory(prefix="iridesce-") as folder:
        for ending in formats:
            path = Path(folder) / f"frame.{ending}"
            image.save(path, exposure=stops)
            contents.append(path.read_bytes())
    return stops, contents
