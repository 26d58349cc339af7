"""What varies: an outer product of lists, or a list of points; as plain values, in one order for every run."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.errors import ResourceError
from iridesce.optics.medium import Medium
from iridesce.thickness.models import ThicknessModel

Point = dict[str, Any]

# Each point is a dict in memory and, in a store, a file.
MOST_POINTS = 1_000_000


class Grid:
    """The points of a sweep.

    axes     key to its values where the points are an outer product, the last key fastest; None where they were listed
    points   every point, in order
    """

    def __init__(self, vary: object) -> None:
        if isinstance(vary, Mapping):
            self.axes: dict[str, list[Any]] | None = {_key(key): _axis(key, values) for key, values in vary.items()}
            if not self.axes:
                words = 'vary is empty; name what varies, as in {"layers.0.thickness_nm": [100.0, 200.0]}'
                raise complaint(words, "vary", "a dict of one key or more", vary)
            count = math.prod(len(values) for values in self.axes.values())
            _refuse_too_many(count)
            self.points = [
                dict(zip(self.axes, values, strict=True)) for values in itertools.product(*self.axes.values())
            ]
            return
        if isinstance(vary, str | bytes) or not isinstance(vary, Sequence):
            raise refusal("vary", "a dict of key and values, or a list of dicts", vary)
        _refuse_too_many(len(vary))
        self.axes = None
        self.points = [_listed(number, point) for number, point in enumerate(vary)]
        if not self.points:
            raise complaint(
                "vary is an empty list; name at least one point", "vary", "a list of one point or more", vary
            )

    @property
    def shape(self) -> tuple[int, ...]:
        """Points along each axis of an outer product; of a list, how many there are."""
        return (len(self.points),) if self.axes is None else tuple(len(values) for values in self.axes.values())

    @property
    def keys(self) -> list[str]:
        """Every key that varies, in the order of its first use."""
        if self.axes is not None:
            return list(self.axes)
        return list(dict.fromkeys(key for point in self.points for key in point))

    def to_check(self) -> Iterator[Point]:
        """Points among which every value of every key occurs: of a product the first, with one key at a time changed."""
        if self.axes is None:
            yield from self.points
            return
        first = self.points[0]
        yield first
        for key, values in self.axes.items():
            yield from ({**first, key: value} for value in values[1:])

    def described(self) -> dict[str, Any]:
        """For a store: plain values as JSON writes them."""
        if self.axes is not None:
            return {"vary": {key: [describe(value) for value in values] for key, values in self.axes.items()}}
        return {"points": [described_point(point) for point in self.points]}


def described_point(point: Point) -> dict[str, Any]:
    """A point as JSON writes it."""
    return {key: describe(value) for key, value in point.items()}


def describe(value: Any) -> Any:
    """A value as JSON writes it: one text for one meaning. What has no text of its own is told by what it does."""
    if isinstance(value, Medium):
        return describe_medium(value)
    if isinstance(value, Mapping):
        return {str(key): describe(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [describe(one) for one in value]
    if isinstance(value, complex):
        return [value.real, value.imag]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return repr(value)


def describe_medium(medium: Medium) -> Any:
    """A name, ``[n, k]``, or what a medium of one's own is called with the digest of its index."""
    kind, *content = medium._origin
    if kind == "name":
        return content[0]
    if kind == "index":
        return [content[0].real, content[0].imag]
    import hashlib

    index = np.asarray(medium.index(np.arange(200.0, 2500.5, 0.5), extrapolate="hold"))
    return {"medium": medium.name, "index_sha256": hashlib.sha256(index.tobytes()).hexdigest()}


def plain(value: Any) -> Any:
    """Numpy's numbers and arrays, paths and thickness models as what a scene file would hold."""
    if isinstance(value, ThicknessModel):
        return plain(value.to_scene())
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    return value


def _key(key: object) -> str:
    if not isinstance(key, str) or not key:
        words = f'keys of vary are texts such as "angle_deg", got {key!r:.80}'
        raise complaint(words, "vary", 'a dict whose keys are texts such as "angle_deg"', key)
    return key


def _axis(key: str, values: object) -> list[Any]:
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        raise refusal(f"vary[{key!r}]", "a list of values", values)
    found = [plain(value) for value in itertools.islice(values, MOST_POINTS + 1)]
    if not found:
        name = f"vary[{key!r}]"
        raise complaint(
            f"{name} is empty; give it one value at least", name, "a list of one value or more", Words("none")
        )
    return found


def _listed(number: int, point: object) -> Point:
    if not isinstance(point, Mapping) or not point:
        raise refusal(f"vary[{number}]", "a dict of key and value", point)
    return {_key(key): plain(value) for key, value in point.items()}


def _refuse_too_many(count: int) -> None:
    if count > MOST_POINTS:
        raise ResourceError(f"vary asks for {count} points; at most {MOST_POINTS} are allowed")
