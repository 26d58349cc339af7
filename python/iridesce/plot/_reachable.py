"""Which colours films of given media can have: the plane of a* and b*, and its edge."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import number, one_of, whole
from iridesce.color.film_tables import Conditions, film_tables
from iridesce.color.light import as_illuminant
from iridesce.optics.medium import as_medium
from iridesce.plot._style import Theme, begin, heading

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Cells of the plane, in units of a* and b*.
_CELL = 2.0
# Points of a table are up to 6 units apart where there is one layer; colours between them are on the straight way.
_PARTS = {1: 12, 2: 2, 3: 1}


def reachable(
    *,
    media: Sequence[Any],
    substrate: Any,
    outside: Any = "air",
    layers: Any = (1, 2),
    illuminant: Any = "D65",
    observer: str = "cie1931",
    angle_deg: float = 0.0,
    thickness_range_nm: tuple[float, float] = (5.0, 400.0),
    target: ArrayLike | None = None,
    space: str = "lab",
    lightness: tuple[float, float] | None = None,
    ax: Axes | None = None,
    title: str | None = None,
    theme: str | None = None,
) -> Axes:
    """The colours that films of these media reach, in the plane of a* and b*, and their edge.

    Every film of the tables that `ir.recipes` looks in is a point; cells of 2 units that hold one are filled with their
    mean colour, and the line around them is the edge of the reachable colours.

    media, substrate, outside, layers, illuminant, observer, angle_deg, thickness_range_nm  as for `ir.recipes`
    target, space  a colour to mark, in ``space``                                          (3,)
    lightness      (low, high): of films of such L* alone; None: of all
    ax, title, theme  as for every chart
    Returns        the Axes
    Raises         ValueError naming the argument; ResourceError for more tables than are made

    >>> import iridesce as ir
    >>> ax = ir.plot.reachable(media=["SiO2"], substrate="Si", layers=(1,), target=[45.0, 50.0, -30.0])
    >>> ax.get_xlabel()
    '$a^*$'
    """
    if isinstance(media, str) or not list(media):
        raise refusal("media", "a list of one or more media", media)
    low, high = (number("thickness_range_nm", one, low=0.0, high=10_001.0) for one in thickness_range_nm)
    if not low < high:
        raise refusal("thickness_range_nm", "(low, high) with low < high", Words((low, high)))
    conditions = Conditions(
        as_medium(outside),
        as_medium(substrate),
        as_illuminant(illuminant),
        one_of("observer", observer, ("cie1931", "cie1964")),
        number("angle_deg", angle_deg, low=0.0, high=90.0),
        (low, high),
    )
    counts = [layers] if isinstance(layers, int) else list(layers)
    counts = sorted({whole("layers", one, 1, 3) for one in counts})
    films = [as_medium(one) for one in media]
    films = [one for place, one in enumerate(films) if one not in films[:place]]
    conditions.check(films)
    sums, count = _cells(films, conditions, counts, lightness)
    ax, look = begin(ax, theme, (6.4, 6.0))
    held = np.argwhere(count > 0)
    if not held.size:
        raise complaint(
            f"no film of these media has a lightness within {lightness!r}",
            "lightness",
            "one that some film of these media has",
            lightness,
        )
    _draw_cells(ax, look, sums, count)
    points = [_CELL * (held - count.shape[0] // 2)]
    if target is not None:
        lab = color.convert(np.asarray(target, dtype=np.float64), space, "lab", white=conditions.white())
        if lab.shape != (3,):
            raise refusal("target", "three numbers", target)
        _mark(ax, look, lab)
        points.append(lab[None, 1:])
    _frame(ax, look, np.concatenate(points))
    names = ", ".join(one.name for one in films)
    layered = " or ".join(str(one) for one in counts) + (" layer" if counts == [1] else " layers")
    words = f"{layered} of {names} on {conditions.substrate.name}, {low:g} to {high:g} nm each, {conditions.illuminant.name}"
    heading(ax, look, title, "Reachable colours", words)
    return ax


def _draw_cells(ax: Axes, look: Theme, sums: Floats, count: Floats) -> None:
    """The cells that hold a film in their mean colours, and the edge around them."""
    half = count.shape[0] // 2
    mean = np.zeros((*count.shape, 3))
    mean[count > 0] = sums[count > 0] / count[count > 0][:, None]
    rgb = color.map_gamut(color.convert(mean, "lab", "srgb"))[0]
    pixels = np.dstack([np.clip(rgb, 0.0, 1.0), (count > 0).astype(float)])
    extent = (-(half + 0.5) * _CELL, (half + 0.5) * _CELL) * 2
    # Rows are b*, columns a*.
    ax.imshow(
        pixels.transpose(1, 0, 2), origin="lower", extent=extent, interpolation="nearest", zorder=1, gid="reachable"
    )
    axis = _CELL * np.arange(-half, half + 1)
    edge = ax.contour(axis, axis, (count > 0).T.astype(float), levels=[0.5], colors=[look.ink], linewidths=1.2)
    edge.set_gid("edge")


def _mark(ax: Axes, look: Theme, lab: Floats) -> None:
    style: dict[str, Any] = {"linestyle": "none", "marker": "x", "markersize": 10.0, "markeredgewidth": 2.0}
    ax.plot([lab[1]], [lab[2]], color=look.ink, zorder=5, gid="target", **style)


def _frame(ax: Axes, look: Theme, every: Floats) -> None:
    """A square around all points of the plane."""
    middle, size = 0.5 * (every.max(axis=0) + every.min(axis=0)), 0.55 * float(np.ptp(every, axis=0).max()) + 4.0
    ax.set_xlim(middle[0] - size, middle[0] + size)
    ax.set_ylim(middle[1] - size, middle[1] + size)
    ax.set_aspect("equal")
    ax.set_xlabel("$a^*$")
    ax.set_ylabel("$b^*$")
    ax.grid(color=look.faint, linewidth=0.6, zorder=0)
    ax.set_axisbelow(True)


def _between(lab: Floats, axis: int, parts: int) -> Floats:
    """So many points for each along an axis, by straight lines."""
    steps = np.linspace(0.0, lab.shape[axis] - 1, parts * (lab.shape[axis] - 1) + 1)
    low = np.minimum(steps.astype(int), lab.shape[axis] - 2)
    share = (steps - low).reshape([-1 if place == axis else 1 for place in range(lab.ndim)])
    return np.asarray((1.0 - share) * lab.take(low, axis) + share * lab.take(low + 1, axis))


def _cells(films: Any, conditions: Conditions, counts: list[int], lightness: Any) -> tuple[Floats, Floats]:
    """Sums of Lab and numbers of films in each cell, a* along the first axis."""
    size = 2 * int(160.0 / _CELL) + 1
    sums, count = np.zeros((size * size, 3)), np.zeros(size * size)
    for table in film_tables(films, conditions, counts):
        lab = table.lab.astype(np.float64)
        for axis in range(1, lab.ndim):
            lab = _between(lab, axis, _PARTS[lab.ndim - 1])
        lab = lab.reshape(3, -1)
        if lightness is not None:
            lab = lab[:, (lab[0] >= lightness[0]) & (lab[0] <= lightness[1])]
        places = np.clip(np.rint(lab[1:] / _CELL).astype(int) + size // 2, 0, size - 1)
        flat = places[0] * size + places[1]
        count += np.bincount(flat, minlength=size * size)
        for part in range(3):
            sums[:, part] += np.bincount(flat, lab[part], minlength=size * size)
    return sums.reshape(size, size, 3), count.reshape(size, size)
