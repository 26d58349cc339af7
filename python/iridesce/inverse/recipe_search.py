"""From a colour to the films that show it.

>>> import iridesce as ir
>>> blue = ir.Stack(["air", ir.Layer("SiO2", thickness_nm=110.0), "Si"]).color(space="lab")
>>> found = ir.recipes(blue, media=["SiO2"], substrate="Si", layers=(1,))
>>> round(found[0].thickness_nm[0], 2), found[0].delta_e < 0.01
(110.0, True)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import number, one_of, whole
from iridesce.color.film_tables import Conditions, FilmTable, film_tables
from iridesce.color.light import as_illuminant
from iridesce.color.spaces import convert, delta_e
from iridesce.inverse.coupons import Growth, growth
from iridesce.inverse.recipe import Recipe, RecipeList
from iridesce.optics.medium import Medium, as_medium
from iridesce.stack import Layer, Stack

# Points of the tables within this colour difference of the target may lead to films that meet it.
_BASIN = 9.0
# After a step on the table a film has to be within this of what is allowed, before it is computed exactly.
_SLACK = 1.0
_STEPS, _LONGEST_NM = 4, 12.0
_SIGMA = 0.01  # where nothing is said of it
# A nm for slopes: colours of 5 nm sums are smooth far below it.
_SLOPE_NM = 0.25
# Films closer than this, or that no eye tells apart on the way from one to the other, are one.
_SAME_NM, _SAME_DELTA_E = 1.0, 0.02
_ROUGH_DRAWS, _DRAWS = 256, 2048
# Nodes of the polynomials on which draws are evaluated, per layer: some, and more for each radian of phase.
_NODES, _NODES_PER_RADIAN, _MOST_NODES = 6, 3.0, 40
_REACH = 4.0


@dataclass
class _Family:
    """Films of one ordered choice of media."""

    media: tuple[Medium, ...]
    thickness_nm: Floats
    """(films, layers)"""
    slope: Floats
    """Lab a nm, (films, 3, layers)"""
    lab: Floats


def recipes(
    target: npt.ArrayLike,
    *,
    media: Sequence[Any],
    substrate: Any,
    outside: Any = "air",
    space: str = "lab",
    illuminant: Any = "D65",
    observer: str = "cie1931",
    angle_deg: float = 0.0,
    layers: Any = (1, 2),
    thickness_range_nm: Any = (5.0, 400.0),
    max_delta_e: float = 2.0,
    sigma: float | None = None,
    sigma_nm: float | None = None,
    limit_delta_e: float = 2.0,
    count: int | None = 20,
    coupons: Any = None,
    progress: Callable[..., object] | None = None,
) -> RecipeList:
    """All films of one and two layers that show a colour, the safest to make first.

    Every ordered choice of media is tabulated over thickness (once; kept in the user's cache folder, see ``iridesce
    info``); the minima of the colour difference in each table are refined on the exact colour by Gauss and Newton. Of
    three layers, whose films of one colour form curves, the one of best yield for each choice of media is given.

    target         colour in ``space``                                                           (3,)
    media          what layers may be made of: names, indices, `Medium`
    substrate, outside  what stands below and above
    space          of the target, and of ``Recipe.color``: see `ir.color.convert`
    illuminant, observer, angle_deg  how it is seen, unpolarised
    layers         numbers of layers, of 1, 2 and 3
    thickness_range_nm  of each layer, (low, high)
    max_delta_e    CIEDE2000 up to which a film counts as that colour
    sigma, sigma_nm  standard deviation of each layer's thickness when it is made, relative or in nm; of neither: 0.01 of it
    limit_delta_e  CIEDE2000 up to which a made film is accepted: ``yield_`` is the share of normal draws that are
    count          at most so many, of best yield; None: all
    coupons        [(volt, nm), ...] or [(volt, (L, a, b)), ...] of your own anodised samples, at least two voltages:
                   recipes of one layer then carry ``volts`` and ``volts_sd``
    progress       called with (done, total) while tables are built
    Returns        `RecipeList`, a list of `Recipe` sorted by yield. Where no film comes within ``max_delta_e``: the nearest
                   alone, with ``reachable`` False
    Raises         ValueError naming the argument; ResourceError for more tables than are made

    >>> import iridesce as ir
    >>> found = ir.recipes([45.0, 0.0, -30.0], media=["TiO2"], substrate="Ti", layers=(1,), max_delta_e=6.0)
    >>> found[0].stack, found[0].reachable
    (Stack(['air', Layer('TiO2', thickness_nm=...), 'Ti']), True)
    """
    low, high = _range(thickness_range_nm)
    chosen = _media(media)
    counts = _counts(layers)
    conditions = Conditions(
        as_medium(outside),
        as_medium(substrate),
        as_illuminant(illuminant),
        one_of("observer", observer, ("cie1931", "cie1964")),
        number("angle_deg", angle_deg, low=0.0, high=90.0),
        (low, high),
    )
    most = number("max_delta_e", max_delta_e, low=0.0, high=1e3, includes_low=False)
    limit = number("limit_delta_e", limit_delta_e, low=0.0, high=1e3, includes_low=False)
    spread = _spread(sigma, sigma_nm)
    how_many = None if count is None else whole("count", count, 1, 1_000_000, optional=True)
    white = conditions.white()
    lab = _target(target, space, white)
    conditions.check(chosen)
    grown = None if coupons is None else growth(coupons, chosen, conditions)
    search = _Search(conditions, lab, most)
    families = [one for table in film_tables(chosen, conditions, counts, progress) for one in search.starts(table)]
    if not families:
        raise complaint(
            "no layer of these media has two faces that reflect: media beside themselves, the substrate or the outside",
            "media",
            "media of which a layer has two faces that reflect",
            Words("none"),
        )
    made = _Made(conditions, white, lab, space, spread, limit, grown)
    films = search.refined(families)
    near = [one for one in films if one[2] <= most]
    if not near:
        recipe = replace(made.recipes([search.nearest(chosen, counts, films)], _DRAWS)[0], reachable=False)
        note = f"not reachable: the nearest is off by {recipe.delta_e:.3g} (CIEDE2000), max_delta_e is {most:g}"
        return RecipeList([recipe], lab, (note,))
    rough = made.straight_yields(near, _ROUGH_DRAWS)
    order = [int(place) for place in np.argsort(-rough, kind="stable")]
    order = _one_of_three(near, order)
    # The rough yields are good to a few points: some more than are asked for are looked at closely.
    order = order if how_many is None else order[: how_many + 10]
    found = made.recipes([near[place] for place in order], _DRAWS)
    found.sort(key=lambda one: (-one.yield_, one.delta_e))
    notes = [f"{len(near)} films within {most:g}; the {how_many} of best yield are given"]
    return RecipeList(found[:how_many], lab, tuple(notes if how_many is not None and len(near) > how_many else []))


_Film = tuple[tuple[Medium, ...], Floats, float, Floats, Floats]
"""Media, thicknesses, CIEDE2000, Lab, slope (3, layers)."""


class _Search:
    """Films near one colour."""

    def __init__(self, conditions: Conditions, target: Floats, most: float) -> None:
        self.conditions, self.target, self.most = conditions, target, most
        self.metric = _metric(target)

    def starts(self, table: FilmTable) -> list[_Family]:
        """Minima of the colour difference on a table, each moved by one step."""
        turned = self.metric.astype(np.float32)
        away = table.lab.reshape(3, -1) - self.target.astype(np.float32)[:, None]
        size = ((turned @ away) ** 2).sum(axis=0).reshape(table.lab.shape[1:])
        least = int(size.argmin())
        padded = np.pad(size, 1, constant_values=np.inf)
        inside = np.stack(np.nonzero(size < max((self.most + _BASIN) ** 2, 1.01 * size.flat[least])))
        strides = np.array(padded.strides) // padded.itemsize
        flat = padded.reshape(-1)
        at = strides @ (inside + 1)
        lowest = np.ones(at.size, dtype=bool)
        for shift in product((-1, 0, 1), repeat=size.ndim):
            if any(shift):
                other = flat[at + int(strides @ np.array(shift))]
                # On a plateau one of two neighbours is a minimum, not both.
                lowest &= (flat[at] < other) if shift > (0,) * size.ndim else (flat[at] <= other)
        places = inside[:, lowest]
        if not places.size:
            places = np.array(np.unravel_index([least], size.shape))
        steps = np.array([axis[1] - axis[0] for axis in table.axes])
        lab = table.lab[(slice(None), *places)].T.astype(np.float64)
        slope = np.empty((places.shape[1], 3, len(steps)))
        for axis, step in enumerate(steps):
            up, down = places.copy(), places.copy()
            up[axis] = np.minimum(up[axis] + 1, size.shape[axis] - 1)
            down[axis] = np.maximum(down[axis] - 1, 0)
            rise = table.lab[(slice(None), *up)] - table.lab[(slice(None), *down)]
            slope[:, :, axis] = (rise / ((up[axis] - down[axis]) * step)).T
        move = np.clip(self._step(lab, slope), -steps, steps)
        start = np.stack([axis[place] for axis, place in zip(table.axes, places, strict=True)], axis=1)
        moved = np.clip(start + move, *self.conditions.range_nm)
        reached = lab + np.einsum("kij,kj->ki", slope, moved - start)
        left = np.linalg.norm((reached - self.target) @ self.metric.T, axis=1)
        good = left < self.most + _SLACK
        good[int(left.argmin())] = True
        return [_Family(table.media, moved[good], slope[good], reached[good])]

    def _step(self, lab: Floats, slope: Floats) -> Floats:
        """Gauss and Newton in the metric of CIEDE2000 at the target, damped where a layer does not show."""
        columns = np.einsum("ij,kjl->kil", self.metric, slope)
        left = (self.target - lab) @ self.metric.T
        normal = np.einsum("kil,kim->klm", columns, columns)
        size = normal.shape[1]
        damping = 1e-6 * np.trace(normal, axis1=1, axis2=2) + 1e-9
        normal[:, range(size), range(size)] += damping[:, None]
        right = np.einsum("kil,ki->kl", columns, left)
        return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])

    def refined(self, families: list[_Family]) -> list[_Film]:
        """Exact thicknesses and colours of all starts that can still win, each film once."""
        left = [np.linalg.norm((one.lab - self.target) @ self.metric.T, axis=1) for one in families]
        # Where nothing is within reach only what is nearest matters.
        limit = max(self.most + _SLACK, min(float(one.min()) for one in left) + _SLACK)
        films: list[_Film] = []
        for family, size in zip(families, left, strict=True):
            if (size <= limit).any():
                films += self._family(family.media, family.thickness_nm[size <= limit], limit)
        return films

    def _family(self, media: tuple[Medium, ...], h: Floats, limit: float) -> list[_Film]:
        low, high = self.conditions.range_nm
        lab, slope = self._slopes(media, h)
        for _ in range(_STEPS):
            moved = np.clip(h + np.clip(self._step(lab, slope), -_LONGEST_NM, _LONGEST_NM), low, high)
            reached = self.conditions.color(media, list(moved.T), "lab", coarse=True)
            # Broyden's update: slopes follow the way that was gone, at no cost.
            by = moved - h
            missed = reached - lab - np.einsum("kil,kl->ki", slope, by)
            slope = slope + np.einsum("ki,kl->kil", missed, by / np.maximum((by * by).sum(axis=1), 1e-12)[:, None])
            near = np.linalg.norm((reached - self.target) @ self.metric.T, axis=1)
            # What stays far after a step will not be within reach after the next.
            good = near <= max(limit, float(near.min()))
            h, lab, slope = moved[good], reached[good], slope[good]
        exact = self.conditions.color(media, list(h.T), "lab")
        h = np.clip(h + np.clip(self._step(exact, slope), -0.5, 0.5), low, high)
        exact = self.conditions.color(media, list(h.T), "lab")
        difference = np.atleast_1d(delta_e(exact, self.target))
        kept: list[_Film] = []
        for place in np.argsort(difference, kind="stable"):
            one = (media, h[place], float(difference[place]), exact[place], slope[place])
            if not any(self._same(one, other) for other in kept):
                kept.append(one)
        return kept

    def _same(self, one: _Film, other: _Film) -> bool:
        by = np.abs(one[1] - other[1])
        # A layer that does not show may be of any thickness.
        shows = np.linalg.norm(self.metric @ one[4], axis=0) * by
        return bool(((by < _SAME_NM) | (shows < _SAME_DELTA_E)).all())

    def nearest(self, media: list[Medium], counts: list[int], films: list[_Film]) -> _Film:
        """Of all films the nearest in CIEDE2000, where all are far: the metric at the target does not reach there."""
        low, high = self.conditions.range_nm
        best = min(films, key=lambda one: one[2])
        of, start, reach = best[0], best[1], np.full(best[1].size, 2.0)
        least = best[2]
        for table in film_tables(media, self.conditions, counts):
            few = tuple(slice(None, None, 1 if len(table.axes) == 1 else 2) for _ in table.axes)
            lab = np.moveaxis(table.lab[(slice(None), *few)], 0, -1).astype(np.float64)
            away = np.asarray(delta_e(lab, self.target))
            place = np.unravel_index(int(away.argmin()), away.shape)
            if away[place] < least:
                least, of = float(away[place]), table.media
                axes = [axis[part] for axis, part in zip(table.axes, few, strict=True)]
                start = np.array([axis[one] for axis, one in zip(axes, place, strict=True)])
                reach = np.array([axis[1] - axis[0] for axis in axes])
        for _ in range(7):
            # Ever finer grids around the best.
            steps = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 5)] * start.size, indexing="ij"), axis=-1)
            trials = np.clip(start + reach * steps.reshape(-1, start.size), low, high)
            lab = self.conditions.color(of, list(trials.T), "lab")
            away = np.asarray(delta_e(lab, self.target))
            start, reach = trials[int(away.argmin())], 0.5 * reach
        exact = self.conditions.color(of, list(start[:, None]), "lab")
        _, slope = self._slopes(of, start[None, :])
        return of, start, float(delta_e(exact[0], self.target)), exact[0], slope[0]

    def _slopes(self, media: tuple[Medium, ...], h: Floats) -> tuple[Floats, Floats]:
        """Colours and their slopes, (films, 3) and (films, 3, layers), by central differences of coarse sums."""
        count = h.shape[1]
        moves = np.concatenate([np.zeros((1, count)), np.eye(count) * _SLOPE_NM, -np.eye(count) * _SLOPE_NM])
        trials = np.maximum(h[:, None, :] + moves, 0.0)
        lab = self.conditions.color(media, list(np.moveaxis(trials, -1, 0)), "lab", coarse=True)
        run = np.stack([trials[:, 1 + i, i] - trials[:, 1 + count + i, i] for i in range(count)], axis=1)
        return lab[:, 0], (lab[:, 1 : count + 1] - lab[:, count + 1 :]).transpose(0, 2, 1) / run[:, None, :]


def _metric(lab: Floats) -> Floats:
    """C so that |C d| is CIEDE2000 for a small difference d: the root of its quadratic form, by differences of 0.1."""
    step = 0.1
    moves = [np.eye(3)[i] + (np.eye(3)[j] if j != i else 0.0) for i in range(3) for j in range(i, 3)]
    sizes = (np.atleast_1d(delta_e(lab + step * np.array(moves), lab)) / step) ** 2
    form = np.zeros((3, 3))
    pairs = [(i, j) for i in range(3) for j in range(i, 3)]
    for (i, j), size in zip(pairs, sizes, strict=True):
        form[i, j] = size
    for i, j in pairs:
        if i != j:
            form[i, j] = form[j, i] = 0.5 * (form[i, j] - form[i, i] - form[j, j])
    values, vectors = np.linalg.eigh(form)
    return np.asarray(np.sqrt(np.maximum(values, 1e-3))[:, None] * vectors.T)


class _Made:
    """What happens when films are made: yields, slopes, volts."""

    def __init__(
        self,
        conditions: Conditions,
        white: Floats,
        target: Floats,
        space: str,
        spread: Callable[[Floats], Floats],
        limit: float,
        grown: Growth | None,
    ) -> None:
        self.conditions, self.white, self.target, self.space = conditions, white, target, space
        self.spread, self.limit, self.grown = spread, limit, grown
        self.metric = _metric(target)

    def yields(self, films: list[_Film], draws: int) -> Floats:
        """Shares of normal draws of all layers whose colour is accepted.

        XYZ is a trigonometric sum of the thicknesses, so a polynomial on Chebyshev's nodes through it is exact to far below
        what is asked; draws are a lattice (Kronecker's, by powers of the generalised golden ratio: error falls nearly as
        1 / draws), not chance.
        """
        out = np.empty(len(films))
        groups: dict[tuple[tuple[Medium, ...], int], list[int]] = {}
        for place, film in enumerate(films):
            groups.setdefault((film[0], self._nodes(film)), []).append(place)
        for (media, nodes), places in groups.items():
            count = len(media)
            basis = _basis(count, nodes, draws)
            h = np.array([films[place][1] for place in places])
            sd = self.spread(h)
            unit = _REACH * np.cos((np.arange(nodes) + 0.5) * np.pi / nodes)
            grid = np.stack([one.reshape(-1) for one in np.meshgrid(*[unit] * count, indexing="ij")], axis=-1)
            trials = np.maximum(h[:, None, :] + sd[:, None, :] * grid, 0.0)
            xyz = self.conditions.color(media, list(np.moveaxis(trials, -1, 0)), "xyz", coarse=True)
            # What the coarse sum misses is alike nearby.
            centre = self.conditions.color(media, list(h.T), "xyz", coarse=True)
            exact = convert(np.array([films[place][3] for place in places]), "lab", "xyz", white=self.white)
            drawn = np.matmul(basis, xyz) + (exact - centre)[:, None, :]
            lab = convert(drawn, "xyz", "lab", white=self.white)
            out[places] = (np.asarray(delta_e(lab, self.target)) <= self.limit).mean(axis=1)
        return out

    def straight_yields(self, films: list[_Film], draws: int) -> Floats:
        """The same to first order of the colour: quick, to tell which are worth more."""
        out = np.empty(len(films))
        for count in {len(film[0]) for film in films}:
            places = [place for place, film in enumerate(films) if len(film[0]) == count]
            h, lab, slope = (np.array([films[place][part] for place in places]) for part in (1, 3, 4))
            drawn = lab[:, None, :] + np.einsum("kil,dl,kl->kdi", slope, _draws(count, draws), self.spread(h))
            out[places] = (np.asarray(delta_e(drawn, self.target)) <= self.limit).mean(axis=1)
        return out

    def _nodes(self, film: _Film) -> int:
        index = max(abs(complex(medium.index(450.0, extrapolate="hold"))) for medium in film[0])
        radians = 4.0 * np.pi * index * _REACH * float(self.spread(film[1]).max()) / 450.0
        return int(min(_NODES + np.ceil(_NODES_PER_RADIAN * radians), _MOST_NODES if len(film[0]) < 3 else 14))

    def recipes(self, films: list[_Film], draws: int) -> list[Recipe]:
        shares = self.yields(films, draws)
        found = []
        for film, share in zip(films, shares, strict=True):
            media, h, difference, lab, slope = film
            layers = [Layer(medium, float(thickness)) for medium, thickness in zip(media, h, strict=True)]
            volts, volts_sd = (
                (None, None) if self.grown is None or len(media) != 1 else self.grown.volts_for(float(h[0]))
            )
            found.append(
                Recipe(
                    Stack([self.conditions.outside, *layers, self.conditions.substrate]),
                    difference,
                    float(share),
                    tuple(float(one) for one in np.linalg.norm(self.metric @ slope, axis=0)),
                    convert(lab, "lab", self.space, white=self.white),
                    True,
                    volts,
                    volts_sd,
                    lab,
                )
            )
        return found


@lru_cache(maxsize=16)
def _draws(layers: int, draws: int) -> Floats:
    """Normal numbers, (draws, layers), evenly spread."""
    # x^(layers + 1) = x + 1: the generalised golden ratio.
    ratio = 1.5
    for _ in range(60):
        ratio = (1.0 + ratio) ** (1.0 / (layers + 1))
    index = np.arange(1, draws + 1)
    return np.stack([_normal((0.5 + index * ratio ** -(axis + 1)) % 1.0) for axis in range(layers)], axis=1)


@lru_cache(maxsize=16)
def _basis(layers: int, nodes: int, draws: int) -> Floats:
    """Values at the draws of the polynomials that are 1 at one node each: (draws, nodes^layers)."""
    x = np.clip(_draws(layers, draws) / _REACH, -1.0, 1.0)
    angle = (np.arange(nodes) + 0.5) * np.pi / nodes
    degree = np.arange(nodes)
    to_series = np.cos(np.multiply.outer(degree, angle)) * (np.where(degree == 0, 1.0, 2.0) / nodes)[:, None]
    basis = np.ones((draws, 1))
    for axis in range(layers):
        one = np.cos(np.multiply.outer(np.arccos(x[:, axis]), degree)) @ to_series
        basis = (basis[:, :, None] * one[:, None, :]).reshape(draws, -1)
    return basis


def _normal(share: npt.NDArray[Any]) -> Floats:
    """The normal quantile."""
    from statistics import NormalDist

    quantile = NormalDist().inv_cdf
    return np.array([quantile(float(one)) for one in share])


def _one_of_three(films: list[_Film], order: list[int]) -> list[int]:
    """Films of three layers: the first of each choice of media."""
    seen: set[tuple[Medium, ...]] = set()
    kept = []
    for place in order:
        media = films[place][0]
        if len(media) == 3:
            if media in seen:
                continue
            seen.add(media)
        kept.append(place)
    return kept


# --- what was given


def _range(given: Any) -> tuple[float, float]:
    try:
        low, high = plain_reals("thickness_range_nm", given, "(low, high) in nm").tolist()
    except (TypeError, ValueError):
        raise refusal("thickness_range_nm", "(low, high) in nm", given) from None
    if not 0.0 <= low < high <= 10_000.0:
        raise refusal("thickness_range_nm", "0 <= low < high <= 10 000", Words((low, high)))
    return low, high


def _media(given: Any) -> list[Medium]:
    if isinstance(given, str) or not hasattr(given, "__iter__"):
        raise refusal("media", "a list of media", given)
    made: list[Medium] = []
    for one in given:
        medium = as_medium(one)
        if medium not in made:
            made.append(medium)
    if not made:
        raise refusal("media", "a list of one or more media", Words("none"))
    return made


def _counts(given: Any) -> list[int]:
    listed = [given] if isinstance(given, int | np.integer) and not isinstance(given, bool) else given
    try:
        counts = sorted({whole("layers", one, 1, 3) for one in listed})
    except TypeError:
        raise refusal("layers", "a list of 1, 2 and 3", given) from None
    if not counts:
        raise refusal("layers", "a list of 1, 2 and 3", Words("none"))
    return counts


def _spread(sigma: Any, sigma_nm: Any) -> Callable[[Floats], Floats]:
    """Standard deviations of thicknesses."""
    if sigma is not None and sigma_nm is not None:
        raise refusal("sigma_nm", "left out beside sigma", Words("both"))
    if sigma_nm is not None:
        size = number("sigma_nm", sigma_nm, low=0.0, high=1e4)
        return lambda h: np.full_like(h, size)
    share = _SIGMA if sigma is None else number("sigma", sigma, low=0.0, high=1.0)
    return lambda h: share * h


def _target(given: Any, space: str, white: Floats) -> Floats:
    values = plain_reals("target", given, "three numbers")
    if values.shape != (3,) or not np.isfinite(values).all():
        raise refusal("target", "three finite numbers", given)
    lab = convert(values, space, "lab", white=white)
    if not -1e-6 <= lab[0] <= 300.0:
        words = f"target has a lightness L of {lab[0]:.3g}; films have 0 to 100 (is space={space!r} right?)"
        raise complaint(words, "target", "of a lightness from 0 to 100", Words(f"L = {lab[0]:.3g}"))
    return lab
