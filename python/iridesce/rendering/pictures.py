"""From a scene to its picture."""

from __future__ import annotations

import operator
import os
import warnings
from typing import Any

from iridesce import _core
from iridesce._progress import Told, check_progress, watched
from iridesce.arguments.scalars import checked_threads, optional_whole
from iridesce.errors import ResourceError
from iridesce.image import Image
from iridesce.scene import Scene

__all__ = ["render"]

_MAX_SIDE = 2**32 - 1


def render(
    scene: Scene | str | os.PathLike[str] | dict[str, Any],
    samples: int | None = None,
    seed: int | None = None,
    size: tuple[int, int] | None = None,
    threads: int | None = None,
    backend: str = "cpu",
    progress: Told = None,
) -> Image:
    """Renders a scene.

    scene      a Scene, the name of a built-in one, a path, or a dict of the same shape as a scene file
    samples    camera rays per pixel, each with the whole spectrum and all branches that matter, 1 to 1048576
    seed       0 to 2**64 - 1; different seeds give independent noise
    size       (width, height) in pixels
    threads    worker threads, 1 to 1024; None uses all cores, or RAYON_NUM_THREADS
    backend    ``"cpu"``, the only one built in
    progress   called as ``progress(done_pixels, total_pixels)`` from the calling thread, some thirty times a second at
               most and once at the end; an exception from it stops the work and is passed on. A function with a third
               parameter ``stage`` hears of every stage, as ``progress(done, total, stage=...)``: ``"reading"`` (maps),
               ``"flowing"`` (steps of the scene's films), ``"rendering"`` (pixels). True draws a bar on stderr
    Returns    an :class:`iridesce.Image`
    Raises     ValueError for a wrong argument; iridesce.SceneError for a wrong scene; iridesce.ResourceError, before
               anything is computed, for a picture that does not fit into memory; KeyboardInterrupt on Ctrl-C

    ``None`` takes the scene's own value. The same scene, samples, seed, size and SIMD level give the same bytes for any
    number of threads. A pixel is the plain mean over its own square; nothing is denoised or clamped.

    >>> import iridesce as ir
    >>> image = ir.render("soap-bubble", samples=1, size=(8, 6))
    >>> image.xyz.shape, image.metadata["samples"]
    ((6, 8, 3), 1)
    """
    if backend != "cpu":
        gpu = " (this iridesce has no GPU back end built in)" if backend == "gpu" else ""
        raise ValueError(f'backend must be "cpu", got {backend!r}{gpu}')
    samples = optional_whole("samples", samples, 1, _core.MAX_SAMPLES)
    seed = optional_whole("seed", seed, 0, 2**64 - 1)
    threads = checked_threads(threads)
    size = _size(size)
    check_progress(progress)

    if not isinstance(scene, Scene):
        scene = Scene.load(scene)
    for name in scene._core.extended_media():
        warnings.warn(
            f'the data of medium "{name}" stop inside 360..830 nm; the render continues them as ir.media() states',
            stacklevel=2,
        )
    tree = scene.to_dict()
    with watched(progress, "rendering") as tell:
        xyz, depth, thickness_nm, normal, info = _core.render_scene(scene._core, samples, seed, size, threads, tell)
    samples, seed, seconds, simd, threads = info
    # The scene as it was rendered: what it says can be rendered again.
    tree["camera"] = {**tree["camera"], "resolution": [xyz.shape[1], xyz.shape[0]]}
    tree["render"] = {**tree.get("render", {}), "samples": samples, "seed": seed}
    facts = {
        "samples": samples,
        "seed": seed,
        "seconds": seconds,
        "threads": threads,
        "backend": backend,
        "simd": simd,
        "version": _core.__version__,
        "scene": tree,
    }
    return Image._of_render(xyz, {"depth": depth, "thickness_nm": thickness_nm, "normal": normal}, facts)


def _size(size: object) -> tuple[int, int] | None:
    if size is None:
        return None
    try:
        sides = [operator.index(side) for side in size]  # type: ignore[attr-defined]
    except TypeError:
        sides = []
    if isinstance(size, (str, bytes)) or len(sides) != 2 or min(sides) < 1:
        raise ValueError(f"size must be (width, height), two whole numbers of at least 1, or None, got {size!r}")
    width, height = sides
    if max(sides) > _MAX_SIDE:
        raise ResourceError(f"an image of {width} x {height} pixels cannot fit; at most {_MAX_SIDE} a side")
    return width, height
