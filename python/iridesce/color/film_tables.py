"""Colours of all films of one, two or three layers out of given media, as tables over thickness. Internal.

What recipes and the edge of the reachable colours are looked up in. A table is built once and kept in the user's cache
folder, one file an ordered choice of media, named by all that it follows from: indices, light, observer, angle, range.
"""

from __future__ import annotations

import itertools
import threading
import warnings
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats
from iridesce.color.films import stack_color
from iridesce.color.light import Illuminant
from iridesce.color.spaces import spectrum_to_xyz
from iridesce.errors import ResourceError
from iridesce.files import cache
from iridesce.optics.layer import Layer
from iridesce.optics.medium import Medium
from iridesce.optics.multilayer import Multilayer
from iridesce.optics.wavelengths import VISIBLE_NM, in_steps

# Tables start and refine nothing: colours at 5 nm are within 0.04 of Lab for films below a micrometre (measured, D65).
COARSE_NM = in_steps(VISIBLE_NM, 5.0)
_COARSE_HOLDS_NM = 1000.0
# Steps of thickness by the number of layers, times the index: 2.5 nm for two layers of titania. A step of 5 nm misses one
# planted film in 48.
_STEP_NM = {1: 3.0, 2: 6.0, 3: 20.0}
_FINEST_NM, _COARSEST_NM = {1: 0.5, 2: 1.5, 3: 5.0}, {1: 2.0, 2: 4.0, 3: 14.0}
MOST_COLORS = 40_000_000
_FORMAT = b"film table 1"


@dataclass(frozen=True)
class Conditions:
    """What films stand between, and the light they are seen in."""

    outside: Medium
    substrate: Medium
    illuminant: Illuminant
    observer: str
    angle_deg: float
    range_nm: tuple[float, float]

    def stack(self, media: Sequence[Medium], thickness_nm: Sequence[npt.ArrayLike]) -> Multilayer:
        """The films as a stack; thicknesses broadcast."""
        layers = [Layer(medium, thickness) for medium, thickness in zip(media, thickness_nm, strict=True)]
        return Multilayer([self.outside, *layers, self.substrate])

    def color(
        self, media: Sequence[Medium], thickness_nm: Sequence[npt.ArrayLike], space: str, coarse: bool = False
    ) -> Floats:
        """Their colours, (..., 3), by the exact sum or by a coarse one; what is warned of is warned of by `warn`."""
        grid = None
        if coarse and sum(float(np.max(one, initial=0.0)) for one in thickness_nm) <= _COARSE_HOLDS_NM:
            grid = COARSE_NM
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            return stack_color(
                self.stack(media, thickness_nm),
                self.angle_deg,
                illuminant=self.illuminant,
                observer=self.observer,
                space=space,
                wavelength_nm=grid,
            )

    def check(self, media: Sequence[Medium]) -> None:
        """The errors of a colour of these media, and one warning for all that are used beyond their data."""
        stack = self.stack(media, [1.0] * len(media))
        stack_color(stack, self.angle_deg, illuminant=self.illuminant, observer=self.observer)

    def white(self) -> Floats:
        """XYZ of the perfect reflector."""
        nm = in_steps(VISIBLE_NM, 1.0)
        return spectrum_to_xyz(nm, np.ones_like(nm), self.illuminant, self.observer)

    def _key(self, media: Sequence[Medium], axes: Sequence[Floats]) -> str:
        indices = [
            np.broadcast_to(np.asarray(one.index(COARSE_NM, extrapolate="hold"), complex), COARSE_NM.shape).tobytes()
            for one in (self.outside, *media, self.substrate)
        ]
        light = self.illuminant
        power = np.asarray(light.power(in_steps(VISIBLE_NM, 1.0)), dtype=np.float64).tobytes()
        facts = repr((light.lines, self.observer, self.angle_deg)).encode()
        return cache.name_of(_FORMAT, *indices, power, facts, *(axis.tobytes() for axis in axes))


@dataclass(frozen=True)
class FilmTable:
    """Colours of one ordered choice of media, from the outside in."""

    media: tuple[Medium, ...]
    axes: tuple[Floats, ...]
    """Thicknesses of each layer, evenly spaced, nm."""
    lab: npt.NDArray[np.float32]
    """(3, thicknesses of the first layer, of the second, ...)"""


def choices(media: Sequence[Medium], conditions: Conditions, layers: Sequence[int]) -> list[tuple[Medium, ...]]:
    """Ordered choices of media in which each film has two faces that reflect: none beside itself."""
    found = []
    for count in layers:
        for chosen in itertools.product(media, repeat=count):
            row = (conditions.outside, *chosen, conditions.substrate)
            if all(one != other for one, other in itertools.pairwise(row)):
                found.append(chosen)
    return found


def film_tables(
    media: Sequence[Medium],
    conditions: Conditions,
    layers: Sequence[int],
    progress: Callable[[float, float], object] | None = None,
) -> Iterator[FilmTable]:
    """The table of every choice, one after the other."""
    chosen = choices(media, conditions, layers)
    every = [tuple(_axis(medium, conditions, len(one)) for medium in one) for one in chosen]
    size = sum(int(np.prod([axis.size for axis in axes], dtype=np.int64)) for axes in every)
    if size > MOST_COLORS:
        raise ResourceError(
            f"{len(chosen)} choices of media make {size:.3g} colours, at most {MOST_COLORS:.3g} are tabulated: "
            "give fewer media, fewer layers, or a narrower thickness_range_nm"
        )
    for done, (one, axes) in enumerate(zip(chosen, every, strict=True)):
        yield FilmTable(one, axes, _table(one, axes, conditions))
        if progress is not None:
            progress(done + 1, len(chosen))


def _axis(medium: Medium, conditions: Conditions, count: int) -> Floats:
    low, high = conditions.range_nm
    index = np.abs(np.asarray(medium.index(550.0, extrapolate="hold")))
    step = float(np.clip(_STEP_NM[count] / max(float(index), 1e-3), _FINEST_NM[count], _COARSEST_NM[count]))
    return np.linspace(low, high, max(2, int(np.ceil((high - low) / step)) + 1))


# What was looked up last stays in memory, up to so much.
_recent: OrderedDict[str, npt.NDArray[np.float32]] = OrderedDict()
_RECENT_BYTES = 256 << 20
_lock = threading.Lock()


def _table(media: tuple[Medium, ...], axes: tuple[Floats, ...], conditions: Conditions) -> npt.NDArray[np.float32]:
    name = conditions._key(media, axes)
    shape = (3, *(axis.size for axis in axes))
    with _lock:
        if name in _recent:
            _recent.move_to_end(name)
            return _recent[name]
    kept = cache.load(name)
    if kept is not None and len(kept) == 4 * int(np.prod(shape)):
        lab = np.frombuffer(kept, dtype="<f4").reshape(shape)
    else:
        lab = _built(media, axes, conditions)
        cache.keep(name, lab.astype("<f4", copy=False).tobytes())
    with _lock:
        _recent[name] = lab
        total = sum(one.nbytes for one in _recent.values())
        while total > _RECENT_BYTES and len(_recent) > 1:
            total -= _recent.popitem(last=False)[1].nbytes
    return lab


def _built(media: tuple[Medium, ...], axes: tuple[Floats, ...], conditions: Conditions) -> npt.NDArray[np.float32]:
    out = np.empty((3, *(axis.size for axis in axes)), dtype=np.float32)
    # By parts, so that Ctrl-C is heard and little memory is held.
    rest = int(np.prod([axis.size for axis in axes[1:]], dtype=np.int64))
    step = max(1, 20_000 // max(rest, 1))
    for start in range(0, axes[0].size, step):
        part = slice(start, start + step)
        grids = np.meshgrid(axes[0][part], *axes[1:], indexing="ij", sparse=True)
        out[:, part] = np.moveaxis(conditions.color(media, grids, "lab", coarse=True), -1, 0)
    return out
