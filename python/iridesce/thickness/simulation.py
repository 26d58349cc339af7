"""Films that flow, frame by frame. Public names are in ``iridesce.thickness``; the physics in ``docs/guide/living-films.md``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from iridesce import _core
from iridesce._progress import Tell, Told, check_progress, watched
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import allowed_range, number, whole
from iridesce.thickness.thickness_map import ThicknessMap, array, refuse_where

_MAX_SEED = 2**64 - 1
# A row of `Simulation.history`, and of `Simulation.profile`.
_HISTORY = np.dtype(
    [
        (name, np.float64)
        for name in (
            *("time_s", "mean_nm", "min_nm", "max_nm", "black_share"),
            *("evaporated", "swallowed", "blackened", "drained"),
        )
    ]
)
_PROFILE = np.dtype([(name, np.float64) for name in ("height_m", "mean_nm", "min_nm", "max_nm")])
# Beyond this a frame's number times its length is no longer a time to the nanosecond.
_MAX_SECONDS = 1e6


class Frame(NamedTuple):
    """A film at one time.

    >>> frame = Frame(0.5, np.full((1, 2), 300.0))
    >>> time_s, thickness_nm = frame
    >>> time_s, thickness_nm.shape
    (0.5, (1, 2))
    """

    time_s: float
    """Time since the start, s."""
    thickness_nm: NDArray[np.float64]
    """Thickness, nm, row 0 on top, (rows, columns); of a dome its own rows alone."""


class _Start(NamedTuple):
    """What a film begins with, and needs again beside a checkpoint."""

    preset: str
    columns: int | None
    seed: int
    changes: list[tuple[str, float]]
    initial_nm: NDArray[np.float64] | None
    sides: str | None

    def film(self, checkpoint: bytes | None) -> _core.Flow:
        """The film at its start, or where a checkpoint says."""
        initial = None if self.initial_nm is None else _core.ThicknessMap(self.initial_nm)
        return _core.Flow(self.preset, self.columns, self.seed, self.changes, checkpoint, initial, self.sides)


class Simulation(Iterator[Frame]):
    """A film that flows, as `simulate` makes it: iterate for its frames.

    It can be copied and pickled, and the copy goes on to the same bytes; a function that is told of its progress stays
    with the first.

    >>> film = simulate("late", time_s=0.1, frames_per_second=20)
    >>> [round(frame.time_s, 2) for frame in film]
    [0.0, 0.05, 0.1]
    """

    def __init__(
        self,
        start: _Start,
        core: _core.Flow,
        time_s: float,
        frames_per_second: float,
        first: int,
        progress: Told = None,
    ) -> None:
        self._start = start
        self._core = core
        self._end = time_s
        self._rate = frames_per_second
        self._next = first
        self._progress = progress
        self._history: list[tuple[float, ...]] = []
        # A frame that rounding puts just past the end is the last one.
        self._count = math.floor(time_s * frames_per_second + 1e-9) + 1

    def __next__(self) -> Frame:
        if self._next >= self._count or self.ruptured_s is not None:
            raise StopIteration
        with watched(self._progress, "flowing") as tell:
            self._core.advance_to(self._next / self._rate, None if tell is None else self._over_all_frames(tell))
        self._next += 1
        self._history.append(tuple(self._core.summary()))
        return Frame(float(self.facts["time_s"] or 0.0), self._core.thickness_nm())

    def _over_all_frames(self, tell: Tell) -> Tell:
        """From the steps of one frame to those of all."""
        before = max(self._next - 1, 0)
        frames = max(self._count - 1, 1)

        def told(done: int, total: int, stage: str) -> None:
            if total > 0:
                tell(before * total + done, frames * total, stage)

        return told

    def __len__(self) -> int:
        """How many frames are left, unless the film bursts."""
        return max(self._count - self._next, 0)

    @property
    def frame(self) -> int:
        """Number of the frame that comes next; the first is 0."""
        return self._next

    @property
    def facts(self) -> dict[str, float | None]:
        """Time, steps, effort of the last step, and where liquid went.

        ``time_s``; ``step``; ``substeps`` and ``iterations`` of the last step; ``volume_m3`` of the film now and
        ``start_m3``; ``evaporated_m3``, ``swallowed_m3`` (by the meniscus), ``blackened_m3`` and ``drained_m3``, which
        together with the volume stay the start; ``ruptured_s``, None if the film did not burst.

        >>> film = simulate("late", time_s=0.1)
        >>> _ = list(film)
        >>> gone = sum(film.facts[f"{way}_m3"] for way in ("evaporated", "swallowed", "blackened", "drained"))
        >>> abs((film.facts["volume_m3"] + gone) / film.facts["start_m3"] - 1.0) < 1e-12
        True
        """
        return self._core.facts()

    @property
    def history(self) -> NDArray[np.void]:
        """How thick the film was in each frame made so far, and where its liquid went: a structured array.

        ``time_s``; ``mean_nm`` over the area, ``min_nm`` and ``max_nm`` of its cells; ``black_share``, the share of the
        area that is black film or thinner than ``black_below_nm``; ``evaporated``, ``swallowed`` (by the meniscus),
        ``blackened`` (out of film that turned black) and ``drained`` (down between the faces), shares >= 0 of the first
        volume: with the mean over the first mean they sum to 1. After a checkpoint it begins with the frame after that;
        the shares are those since the film's own start.

        >>> film = simulate("late", time_s=0.1, frames_per_second=20)
        >>> _ = list(film)
        >>> film.history["time_s"].round(2).tolist()
        [0.0, 0.05, 0.1]
        >>> kept = film.history["mean_nm"] / film.history["mean_nm"][0]
        >>> gone = sum(film.history[way] for way in ("evaporated", "swallowed", "blackened", "drained"))
        >>> bool(abs(kept + gone - 1.0).max() < 1e-12)
        True
        """
        return np.array(self._history, dtype=_HISTORY)

    @property
    def summary(self) -> np.void:
        """How thick the film is now, and where its liquid went: what would be a row of `history`.

        >>> film = simulate("late", time_s=0.1, frames_per_second=20)
        >>> _ = list(film)
        >>> bool(film.summary == film.history[-1])
        True
        """
        now: np.void = np.array([tuple(self._core.summary())], dtype=_HISTORY)[0]
        return now

    def profile(self) -> NDArray[np.void]:
        """The film now, row by row from the top: a structured array of ``height_m`` (of a row's middle above the film's
        lowest place), ``mean_nm``, ``min_nm`` and ``max_nm`` along it.

        Returns  structured array                                                               (rows,)
        Raises   nothing

        >>> profile = simulate("bubble-on-bath").profile()
        >>> profile.shape, bool(0.0249 < profile["height_m"][0] < 0.025)
        ((96,), True)
        """
        return np.array([tuple(row) for row in self._core.profile()], dtype=_PROFILE)

    @property
    def ruptured_s(self) -> float | None:
        """When the film burst, s; None if it did not. The frame of that step is its last.

        Film thinner than ``rupture_nm`` bursts by chance, ``rupture_per_m2_s`` times per m2 of it and second, at a time
        that hangs on the seed alone; ``rupture_nm=0`` never does, ``rupture_per_m2_s=inf`` at once.

        >>> film = simulate("late", time_s=1.0, thickness_nm=20.0, columns=64, regeneration=0.0, rupture_per_m2_s=1e4)
        >>> _ = list(film)
        >>> film.ruptured_s is not None and film.ruptured_s <= len(film.history) / 30.0
        True
        """
        return self.facts["ruptured_s"]

    @property
    def parameters(self) -> dict[str, Any]:
        """Every number that the film follows, by its name; the unit is in the name. ``sides`` of a plane is a word.

        >>> simulate("late").parameters["thickness_nm"]
        260.0
        """
        sides = self._core.sides()
        return dict(self._core.parameters()) | ({} if sides is None else {"sides": sides})

    def map(self, columns: int | None = None) -> ThicknessMap:
        """The film now as a map for a whole sphere, to be laid over it by u and v.

        columns  cells around, 16 to 16384, as finely as the film is to be seen: smooth between its own cells, with the
                 edges of its black film as a scene draws them. None: its own cells as they are
        Returns  ThicknessMap; a dome is mirrored below its rim
        Raises   ValueError for a number of columns that is none

        >>> film = simulate("bubble-on-bath", time_s=0.0)
        >>> next(film).thickness_nm.shape, (film.map().height, film.map().width)
        ((96, 384), (192, 384))
        >>> film.map(columns=1536).thickness_nm.shape
        (768, 1536)
        """
        return ThicknessMap(self._core.map(None if columns is None else whole("columns", columns, 16, 16384)))

    def checkpoint(self) -> bytes:
        """The film now, with all that is needed to go on to the same bytes: `simulate` takes it as ``checkpoint``.

        Returns  bytes
        Raises   nothing

        >>> film = simulate("late", time_s=0.1, frames_per_second=20)
        >>> _ = next(film), next(film)
        >>> again = simulate("late", time_s=0.1, frames_per_second=20, checkpoint=film.checkpoint())
        >>> bool((next(again).thickness_nm == next(film).thickness_nm).all())
        True
        """
        return self._core.checkpoint()

    def __reduce__(self) -> tuple[Any, ...]:
        progress = self._progress if isinstance(self._progress, bool) else None
        made = (self._start, self._core.checkpoint(), self._end, self._rate, self._next, progress)
        return _restored, (*made, list(self._history))

    def __repr__(self) -> str:
        return f"<iridesce.thickness.Simulation at {self.facts['time_s']:g} s, {len(self)} frames left>"


def _restored(
    start: _Start,
    checkpoint: bytes,
    time_s: float,
    frames_per_second: float,
    first: int,
    progress: Told,
    history: list[tuple[float, ...]],
) -> Simulation:
    """A film as it was when it was pickled."""
    film = Simulation(start, start.film(checkpoint), time_s, frames_per_second, first, progress)
    film._history = list(history)
    return film


def simulate(
    preset: str,
    time_s: float = 4.0,
    frames_per_second: float = 30.0,
    seed: int = 1,
    columns: int | None = None,
    checkpoint: bytes | None = None,
    progress: Told = None,
    *,
    initial: ThicknessMap | ArrayLike | None = None,
    **parameters: float | str,
) -> Simulation:
    """A soap film from its physics, frame by frame: gravity, Marangoni tension, air, evaporation, black film.

    preset             one of `presets`; ``...-time-lapse`` has ``speed`` 6: it loses its liquid six times sooner
    time_s             time of the last frame, s, >= 0; the first is at 0
    frames_per_second  > 0. The film's own steps divide the time between two frames evenly
    seed               0 to 2**64 - 1: another seed, another film. The same seed gives the same bytes on any number of
                       threads
    columns            cells around the bubble, even; the preset's own if None, with rows to match
    checkpoint         what `Simulation.checkpoint` gave: goes on with the frame after it. All else must be the same,
                       except `time_s`
    progress           called as ``progress(done, total)`` in steps of the whole run while a frame is made (with
                       ``stage="flowing"`` if it takes that); an exception from it stops the film after a whole step. True
                       draws a bar on stderr
    initial            thickness at the start instead of noise: a ThicknessMap or an array in nm, rows from top to bottom
                       (a dome's: from pole to rim, a whole bubble's: from pole to pole), columns from side to side or
                       around. It is brought onto the film's grid with its volume kept; ``thickness_nm`` is then its
                       mean. A checkpoint wants it again
    **parameters       any number of `Simulation.parameters` but ``columns`` and ``rows``, in the unit of its name;
                       ``humidity`` (0 to 1) instead of ``evaporation_nm_s``. ``speed`` multiplies all that takes liquid
                       and nothing that moves. ``sides`` of a plane: ``"menisci"``, borders of a frame along which it
                       regenerates, or ``"periodic"``, the middle of a wide frame, which repeats
    Returns            Simulation, an iterator of Frame: time in s and thickness in nm
    Raises             ValueError naming the parameter, its value and what is allowed: an unknown preset, a negative
                       viscosity, a radius of zero, a grid too coarse for the patches, a checkpoint of another run; while
                       it runs, for a number that stops being one, with step, time and place
    Source             the equations and their tests are in ``docs/guide/living-films.md``

    >>> for time_s, thickness_nm in simulate("bubble-on-bath", time_s=0.05, frames_per_second=20):
    ...     print(round(time_s, 2), thickness_nm.shape, round(float(thickness_nm.max())) > 800)
    0.0 (96, 384) True
    0.05 (96, 384) True
    >>> wedge = simulate("vertical-film", initial=[[200.0], [300.0], [400.0]])
    >>> round(wedge.parameters["thickness_nm"], 9), next(wedge).thickness_nm[[0, -1], 0].round().tolist()
    (300.0, [200.0, 400.0])
    """
    if preset not in _core.flow_presets():
        raise refusal("preset", f"one of {', '.join(_core.flow_presets())}", preset)
    end, rate = number("time_s", time_s), number("frames_per_second", frames_per_second)
    if not 0.0 <= end <= _MAX_SECONDS:
        raise refusal("time_s", f"from 0 to {_MAX_SECONDS:g}", time_s)
    if not 1e-3 <= rate <= 1e6:
        raise refusal("frames_per_second", "from 0.001 to 1e6", frames_per_second)
    check_progress(progress)
    if columns is not None:
        columns = whole("columns", columns, 16, 16384)
    sides = parameters.pop("sides", None)
    if not (sides is None or isinstance(sides, str)):
        raise refusal("sides", '"menisci" or "periodic"', sides)
    changes = [(name, number(name, value)) for name, value in parameters.items()]
    if not (checkpoint is None or isinstance(checkpoint, bytes)):
        raise refusal("checkpoint", "bytes or None", Words(type(checkpoint).__name__))
    seed = whole("seed", seed, 0, _MAX_SEED)
    start = _Start(preset, columns, seed, changes, _initial(initial, parameters), sides)
    core = start.film(checkpoint)
    first = 0
    if checkpoint is not None:
        reached = float(core.facts()["time_s"] or 0.0)
        first = round(reached * rate) + 1
        if core.facts()["ruptured_s"] is not None:
            # A film bursts at a time of its own: the frame of that time was its last.
            first = math.ceil(reached * rate - 1e-9) + 1
        elif abs((first - 1) / rate - reached) > 1e-9 * max(reached, 1.0):
            raise complaint(
                f"the checkpoint is at {reached:g} s, between two frames of frames_per_second {rate:g}; "
                "give the one that it was made with",
                "frames_per_second",
                "the rate that the checkpoint was made with",
                rate,
            )
    return Simulation(start, core, end, rate, first, progress)


def _initial(
    initial: ThicknessMap | ArrayLike | None, parameters: dict[str, float | str]
) -> NDArray[np.float64] | None:
    if initial is None:
        return None
    for name in ("thickness_nm", "noise"):
        if name in parameters:
            raise complaint(
                f"initial and {name} exclude each other: the thickness at the start is given, got both",
                name,
                "left out beside initial",
                Words("both"),
            )
    values = initial.thickness_nm if isinstance(initial, ThicknessMap) else array("initial", initial)
    if values.ndim != 2 or 0 in values.shape:
        raise refusal("initial", "the shape (rows, columns), both >= 1", Words(values.shape), must="have")
    allowed = f"{allowed_range(0.0, math.inf, True)}, in nm"
    refuse_where(~(np.isfinite(values) & (values >= 0.0)), values, "initial", allowed)
    if not values.any():
        raise refusal("initial", "some liquid", Words("0.0 everywhere"), must="hold")
    return np.array(values, dtype=np.float64, order="C")


def presets() -> list[str]:
    """Names of the films that `simulate` knows.

    Returns  list of texts
    Raises   nothing

    >>> "bubble-on-bath" in presets()
    True
    """
    return _core.flow_presets()
