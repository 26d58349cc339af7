"""``ir.sweep``: check all, look up what a store holds, make the rest here or on a cluster, give everything back in order."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from iridesce import _core
from iridesce._progress import Told, check_progress, watched
from iridesce.arguments.refusals import refusal
from iridesce.arguments.scalars import checked_threads, file_name
from iridesce.sweeping.cluster import opened
from iridesce.sweeping.grid import Grid
from iridesce.sweeping.needed import digests
from iridesce.sweeping.points import Made, Task, make_here
from iridesce.sweeping.results import Pictures, SweepResult, joined
from iridesce.sweeping.store import Store
from iridesce.sweeping.subjects import Subject, describe_quantity, subject_of

Advance = Callable[[int, int], object]


def sweep(
    base: Any,
    vary: Mapping[str, Any] | Sequence[Mapping[str, Any]],
    *,
    quantity: str | Callable[[Any], Any] | None = None,
    store: str | os.PathLike[str] | None = None,
    client: Any = None,
    threads: int | None = None,
    progress: Told = None,
    shard: tuple[int, int] | None = None,
) -> SweepResult:
    """One scene or stack at many points: pictures, colours, spectra or a function's answers, in one order.

    base       a scene (name, path, dict, `Scene`) or a stack (`Stack`, or text such as "air / soap 320 / air")
    vary       key to values: the outer product, the last key fastest; or a list of dicts, one a point. Keys of a scene are
               those of `Scene.with_value`; of a stack "layers.0.thickness_nm" (nm), "layers.0.medium", "layers.0.coherent",
               "first", "last", and the arguments of the quantity: "angle_deg", "polarization", "wavelength_nm" (nm),
               for colours "illuminant", "observer", "space", ... as in `Stack.color`
    quantity   what is kept of each point. Of scenes "image" (if None); of stacks "color" (if None), "reflectance",
               "transmittance", "absorptance", "layer_absorptance", "psi", "delta" (over 380..780 nm at 1 nm unless
               "wavelength_nm" varies); or a function of the point's Scene or Stack that answers numbers, an array or an
               `Image`. On a cluster it must be picklable
    store      a folder for what has been made, files of EXR, NPY and JSON: the same call goes on where another stopped, and
               shards share it. Points that failed are tried again
    client     None: threads of this machine. An address ("tcp://host:8786"), "local" or "local:N" (N processes of this
               machine, bound to loopback), or a ``dask.distributed.Client``: its workers (the extra `dask`)
    threads    1 to 1024; on this machine None: all, or RAYON_NUM_THREADS. On a cluster: of each point, None: 1
    progress   called as ``progress(done, total)`` in points; an exception from it stops the work; True draws a bar with
               the time left
    shard      (i, n), i from 1: only points i - 1, i - 1 + n, ..; the result has these alone
    Returns    `SweepResult`: points, values, failed
    Raises     ValueError, SceneError before the first point runs: a key or value that is not allowed, a store of another
               sweep (with the difference), workers of another version or of several SIMD levels, a function that cannot be
               sent; ConnectionError: no scheduler at the address (after 10 s), or it is gone; OSError: a store that cannot be
               written, a full disk among it; ImportError without dask; KeyboardInterrupt on Ctrl-C. What was made until
               then stays in the store

    A point that fails by itself is kept with its message in ``failed``; the others go on. The death of a worker costs the
    points it was at: they are made again. Values do not depend on threads, workers, shards or restarts, to the last byte of
    their files (at one SIMD level).

    >>> import iridesce as ir
    >>> swept = ir.sweep("air / soap 320 / air", {"layers.0.thickness_nm": [100.0, 320.0], "space": ["srgb"]})
    >>> swept.values.round(3).tolist()
    [[0.3, 0.312, 0.301], [0.294, 0.304, 0.078]]
    """
    check_progress(progress)
    threads = checked_threads(threads)
    chosen = checked_shard(shard)
    folder = None if store is None else Path(file_name(store))
    subject = subject_of(base, quantity)
    grid = Grid(vary)
    check_points(subject, grid)
    numbers = list(range(len(grid.points)) if chosen is None else range(chosen[0] - 1, len(grid.points), chosen[1]))
    files = subject.files(grid.to_check())
    with opened(client, subject.quantity, list(files)) as cluster, watched(progress, "sweeping", "points") as tell:
        simd = _core.SIMD_LEVEL if cluster is None else cluster.simd
        kept = None if folder is None else Store(folder, _header(subject, grid, files, simd))
        finished = {number for number in numbers if kept is not None and _is_finished(kept, number)}
        tasks = [Task(number, grid.points[number]) for number in numbers if number not in finished]

        def advance(done: int) -> None:
            if tell is not None:
                tell(len(finished) + done, len(numbers), "sweeping")

        advance(0)
        if cluster is None:
            made: Iterator[Made] = make_here(subject, tasks, kept, threads)
        else:
            made = cluster.make(subject, tasks, files, kept, threads)
        values: dict[int, Any] = {}
        messages: dict[int, str] = {}
        for count, (number, value, message) in enumerate(made, start=1):
            if message is not None:
                messages[number] = message
            elif kept is None:
                values[number] = value
            advance(count)
    if kept is not None:
        kept.tidy()
    return _gathered(subject, grid, numbers, values, messages, kept)


def checked_shard(shard: object) -> tuple[int, int] | None:
    """``(i, n)`` with 1 <= i <= n, or None."""
    if shard is None:
        return None
    if isinstance(shard, tuple | list) and len(shard) == 2:
        first, last = shard
        if all(isinstance(one, int) and not isinstance(one, bool) for one in shard) and 1 <= first <= last:
            return first, last
    raise refusal("shard", "(i, n), whole numbers with 1 <= i <= n", shard)


def check_points(subject: Subject, grid: Grid) -> None:
    """Every value of every key, before the first point runs."""
    for point in grid.to_check():
        subject.check(point)


def _is_finished(store: Store, number: int) -> bool:
    entry = store.done.get(number)
    return entry is not None and not entry.has_failed


def _header(subject: Subject, grid: Grid, files: Mapping[str, Path], simd: str) -> dict[str, Any]:
    return {
        "base": subject.described(),
        **grid.described(),
        "quantity": describe_quantity(subject.quantity),
        "files": digests(files),
        "version": _core.__version__,
        "simd": simd,
    }


def _gathered(
    subject: Subject,
    grid: Grid,
    numbers: list[int],
    values: dict[int, Any],
    messages: dict[int, str],
    store: Store | None,
) -> SweepResult:
    points = [grid.points[number] for number in numbers]
    failed = [(grid.points[number], messages[number]) for number in numbers if number in messages]

    def value(number: int) -> Any:
        if number in messages:
            return None
        return values[number] if store is None else store.value(number)

    names = {} if store is None else store.done
    if any(number in names and names[number].file.endswith(".exr") for number in numbers):
        # Read when asked for: hundreds of pictures are more than a memory holds.
        found: Any = Pictures([_later(value, number) for number in numbers])
    else:
        found = joined([value(number) for number in numbers])
        if isinstance(found, list) and any(_is_picture(one) for one in found):
            found = Pictures([_later(value, number) for number in numbers])
    return SweepResult(subject, grid, points, found, failed, None if store is None else store.folder)


def _later(value: Callable[[int], Any], number: int) -> Callable[[], Any]:
    return lambda: value(number)


def _is_picture(value: Any) -> bool:
    return hasattr(value, "xyz")
