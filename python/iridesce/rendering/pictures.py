"""From a scene to its picture."""

from __future__ import annotations

import math
import operator
import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce._picture_files import seen_spectra
from iridesce._progress import Told, check_progress, watched
from iridesce.arguments.refusals import refusal
from iridesce.arguments.scalars import checked_threads, number, optional_whole
from iridesce.errors import ResourceError
from iridesce.image import Image
from iridesce.rendering.journal import Keep, check_same, head_of
from iridesce.scene import Scene

__all__ = ["draw", "render"]

_MAX_SIDE = 2**32 - 1


def render(
    scene: Scene | str | os.PathLike[str] | dict[str, Any],
    samples: int | None = None,
    seed: int | None = None,
    size: tuple[int, int] | None = None,
    threads: int | None = None,
    backend: str = "cpu",
    progress: Told = None,
    *,
    until: float | None = None,
    time_s: float | None = None,
    crop: tuple[int, int, int, int] | None = None,
    spectral_nm: npt.ArrayLike | None = None,
    stokes: bool = False,
    resume: str | os.PathLike[str] | None = None,
    shard: tuple[int, int] | None = None,
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
    until      relative error > 0: passes of samples go on until the median of sigma(Y) / max(Y, 1 % of the mean Y), over
               the pixels whose sigma is not 0, is below it, never before 4 passes; at most ``samples`` if that is given, the
               scene's own number does not limit
    time_s     seconds > 0: passes go on as long as another one fits into the time, never before 4
    crop       (x, y, width, height) in pixels: only this part, with the same bytes as in the whole
    spectral_nm  vacuum wavelengths, 360 to 830 nm, ascending: ``image.spectra`` is the radiance at each; single wavelengths are
               computed exactly, not interpolated
    stokes     True: ``image.stokes`` is the Stokes vector of X, of Y and of Z, and with ``spectral_nm`` ``image.spectral_stokes``
               that of each wavelength. They are of the light before ``camera.polarizer_deg``; branches are then chosen by it,
               so that such a picture has other noise. Four times the work
    resume     path of a journal: finished tiles are read from it, if it is there, and written to it. It stays when the
               picture is whole
    shard      (I, N), I from 1: only every N-th tile from the I-th on; elsewhere ``samples`` and colours are 0.
               ``ir.merge`` puts shards together
    Returns    an :class:`iridesce.Image`
    Raises     ValueError for a wrong argument, and for a journal of another render, which says what differs (scene, seed,
               size, samples, crop, planes, version, SIMD level); iridesce.SceneError for a wrong scene;
               iridesce.ResourceError, before anything is computed, for a picture that does not fit into memory;
               KeyboardInterrupt on Ctrl-C

    ``None`` takes the scene's own value. The same scene, samples, seed, size and SIMD level give the same bytes for any
    number of threads. A pixel is the plain mean over its own square; nothing is denoised or clamped.

    >>> import iridesce as ir
    >>> image = ir.render("soap-bubble", samples=1, size=(8, 6))
    >>> image.xyz.shape, image.metadata["samples"]
    ((6, 8, 3), 1)
    >>> part = ir.render("soap-bubble", samples=1, size=(8, 6), crop=(2, 1, 4, 3))
    >>> bool((part.xyz == image.xyz[1:4, 2:6]).all())
    True
    """
    keep = None if resume is None else Keep(Path(resume), 0.0, True)
    asked = {"samples": samples, "seed": seed, "size": size, "threads": threads, "until": until, "time_s": time_s}
    return draw(
        scene,
        {**asked, "crop": crop, "shard": shard, "spectral_nm": spectral_nm, "stokes": stokes},
        keep,
        progress,
        backend,
    )


def draw(
    scene: Scene | str | os.PathLike[str] | dict[str, Any],
    given: dict[str, Any],
    keep: Keep | None,
    progress: Told = None,
    backend: str = "cpu",
) -> Image:
    """`render` with any journal; ``given`` has its arguments by name. Internal."""
    if backend != "cpu":
        gpu = "(this iridesce has no GPU back end built in)" if backend == "gpu" else ""
        raise refusal("backend", '"cpu"', backend, gpu)
    asked = _asked(given)
    check_progress(progress)

    if not isinstance(scene, Scene):
        scene = Scene.load(scene)
    for name in scene._core.extended_media():
        warnings.warn(
            f'the data of medium "{name}" stop inside 360..830 nm; the render continues them as ir.media() states',
            stacklevel=3,
        )
    for note in scene._core.notes():
        warnings.warn(note, stacklevel=2)
    tree = scene.to_dict()
    if keep is not None:
        keep.head = head_of(scene, tree, _identity(tree, asked))
        if keep.resume:
            check_same(keep.path, keep.head)
        asked["keep"] = (keep.path, keep.head, keep.after_s, keep.resume)
    with watched(progress, "rendering") as tell:
        xyz, planes, spectral, info, surfaces, notes = _core.render_scene(scene._core, asked, tell)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    samples, seed, seconds, simd, threads = info
    # The scene as it was rendered: what it says can be rendered again.
    crop, shard = asked["crop"], asked["shard"]
    whole = asked["size"] or tree["camera"]["resolution"]
    tree["camera"] = {**tree["camera"], "resolution": list(whole)}
    tree["render"] = {**tree.get("render", {}), "samples": samples, "seed": seed}
    facts = {
        "samples": samples,
        "seed": seed,
        "seconds": seconds,
        "threads": threads,
        "backend": backend,
        "simd": simd,
        "version": _core.__version__,
        **({} if crop is None else {"crop": crop}),
        **({} if shard is None else {"shard": f"{shard[0]}/{shard[1]}"}),
        "scene": tree,
    }
    if asked["spectral_nm"]:
        spectral["spectral_nm"] = np.array(asked["spectral_nm"])
    if "spectral_stokes" in spectral:
        spectral["spectra"] = seen_spectra(spectral["spectral_stokes"], tree)
    return Image._of_render(xyz, planes, spectral, facts, surfaces)


def _asked(given: dict[str, Any]) -> dict[str, Any]:
    """The arguments of a render, checked, as the core takes them."""
    positive = {}
    for name in ("until", "time_s", "settled"):
        value = given.get(name)
        positive[name] = None if value is None else number(name, value, low=0.0, high=math.inf, includes_low=False)
    return {
        "samples": optional_whole("samples", given.get("samples"), 1, _core.MAX_SAMPLES),
        "seed": optional_whole("seed", given.get("seed"), 0, 2**64 - 1),
        "threads": checked_threads(given.get("threads")),
        "size": _size(given.get("size")),
        "crop": _wholes("crop", given.get("crop"), 4, "(x, y, width, height), four whole numbers"),
        "shard": _wholes("shard", given.get("shard"), 2, "(I, N), two whole numbers"),
        "spectral_nm": _wavelengths(given.get("spectral_nm")),
        "stokes": _flag("stokes", given.get("stokes", False)),
        **positive,
        "keep": None,
    }


def _identity(tree: dict[str, Any], asked: dict[str, Any]) -> dict[str, Any]:
    """What of the arguments the bytes of a picture depend on."""
    by_itself = asked["until"] is not None or asked["time_s"] is not None
    samples = asked["samples"] or tree["render"]["samples"]
    return {
        "seed": tree["render"]["seed"] if asked["seed"] is None else asked["seed"],
        "size": list(asked["size"] or tree["camera"]["resolution"]),
        # Passes can go on to any end.
        "samples": "passes" if by_itself else samples,
        "crop": asked["crop"],
        "planes": {"spectral_nm": asked["spectral_nm"], "stokes": asked["stokes"]},
    }


def _wavelengths(value: npt.ArrayLike | None) -> list[float]:
    """Ascending wavelengths within what eyes see; their order and range are for the core to check."""
    if value is None:
        return []
    try:
        array = np.atleast_1d(np.asarray(value))
        is_masked = isinstance(value, np.ma.MaskedArray)
        if is_masked or array.dtype.kind not in "iuf" or array.ndim != 1 or not np.isfinite(array).all():
            raise ValueError
    except (TypeError, ValueError):
        raise refusal("spectral_nm", "ascending wavelengths in nm, (wavelengths,)", value) from None
    if not array.size:
        raise refusal("spectral_nm", "one wavelength at least, or None", value)
    return [float(nm) for nm in array]


def _flag(name: str, value: object) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise refusal(name, "True or False", value)
    return bool(value)


def _wholes(name: str, value: object, count: int, wanted: str) -> tuple[int, ...] | None:
    if value is None:
        return None
    try:
        numbers = [operator.index(number) for number in value]  # type: ignore[attr-defined]
    except TypeError:
        numbers = []
    if isinstance(value, (str, bytes)) or len(numbers) != count or min(numbers) < 0 or max(numbers) > _MAX_SIDE:
        raise refusal(name, f"{wanted} from 0 on, or None", value)
    return tuple(numbers)


def _size(size: object) -> tuple[int, int] | None:
    if size is None:
        return None
    try:
        sides = [operator.index(side) for side in size]  # type: ignore[attr-defined]
    except TypeError:
        sides = []
    if isinstance(size, (str, bytes)) or len(sides) != 2 or min(sides) < 1:
        raise refusal("size", "(width, height), two whole numbers of at least 1, or None", size)
    width, height = sides
    if max(sides) > _MAX_SIDE:
        raise ResourceError(f"an image of {width} x {height} pixels cannot fit; at most {_MAX_SIDE} a side")
    return width, height
