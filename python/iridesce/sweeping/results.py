"""What a sweep gives back: points, values in their order, what failed; as labelled arrays if asked."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from iridesce._notebook import facts_html
from iridesce.image import Image
from iridesce.sweeping.grid import Grid, Point

if TYPE_CHECKING:
    from iridesce.sweeping.subjects import Subject


class Pictures(Sequence[Any]):
    """Pictures of a sweep, each read when it is asked for; None where a point failed.

    ``numpy.asarray`` of them is one float32 array of XYZ, (points, height, width, 3), where all are of one size.
    """

    def __init__(self, makers: Sequence[Callable[[], Image | None]]) -> None:
        self._makers = tuple(makers)

    def __len__(self) -> int:
        return len(self._makers)

    @overload
    def __getitem__(self, place: int) -> Image | None: ...
    @overload
    def __getitem__(self, place: slice) -> Pictures: ...
    def __getitem__(self, place: int | slice) -> Any:
        if isinstance(place, slice):
            return Pictures(self._makers[place])
        return self._makers[place]()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        planes = [None if picture is None else picture.xyz for picture in self]
        known = next((plane for plane in planes if plane is not None), None)
        if known is None or any(plane is not None and plane.shape != known.shape for plane in planes):
            raise ValueError("pictures of several sizes, or of none, make no array")
        empty = np.full(known.shape, np.nan, np.float32)
        stacked = np.stack([empty if plane is None else plane for plane in planes])
        return stacked if dtype is None else stacked.astype(dtype)

    def __repr__(self) -> str:
        return f"<{len(self)} pictures>"


class SweepResult:
    """What `iridesce.sweep` found.

    points    a dict for each point: key to value
    values    in their order: one array, (points, ...), where all values are numbers or arrays of one shape, NaN where a
              point failed; else a list, None where a point failed. Pictures are read when they are asked for
    failed    (point, message) of each point that failed by itself
    store     the folder, or None

    ``len``, iteration and ``result[i]`` go by values; a slice gives a smaller result; a dict, ``result[{"angle_deg": 45.0}]``,
    picks the one value whose point has these values, or all of them as a smaller result.

    >>> import iridesce as ir
    >>> swept = ir.sweep("air / soap 320 / air", {"layers.0.thickness_nm": [0.0, 100.0], "angle_deg": [0.0, 45.0]})
    >>> swept.values.shape, len(swept), swept.failed
    ((4, 3), 4, [])
    >>> swept.points[1]
    {'layers.0.thickness_nm': 0.0, 'angle_deg': 45.0}
    >>> swept[{"angle_deg": 45.0}].values.shape
    (2, 3)
    """

    def __init__(
        self,
        subject: Subject,
        grid: Grid,
        points: list[Point],
        values: Sequence[Any],
        failed: list[tuple[Point, str]],
        store: Any = None,
    ) -> None:
        self._subject = subject
        self._grid = grid
        self.points = points
        self.values: Any = values
        self.failed = failed
        self.store = store

    @property
    def quantity(self) -> Any:
        """What is kept of each point: a word or a function."""
        return self._subject.quantity

    def __len__(self) -> int:
        return len(self.points)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.values)

    def __getitem__(self, place: Any) -> Any:
        if isinstance(place, Mapping):
            unknown = [key for key in place if key not in self._grid.keys]
            if unknown:
                raise KeyError(f"{unknown[0]!r} does not vary; these do: {', '.join(self._grid.keys)}")
            chosen = [
                number
                for number, point in enumerate(self.points)
                if all(key in point and point[key] == value for key, value in place.items())
            ]
            if not chosen:
                raise KeyError(f"no point has {dict(place)!r:.200}")
            return self.values[chosen[0]] if len(chosen) == 1 else self._part(chosen)
        if isinstance(place, slice):
            return self._part(list(range(len(self)))[place])
        return self.values[place]

    def _part(self, chosen: list[int]) -> SweepResult:
        points = [self.points[number] for number in chosen]
        if isinstance(self.values, np.ndarray):
            values: Any = self.values[chosen]
        elif isinstance(self.values, Pictures):
            values = Pictures([self.values._makers[number] for number in chosen])
        else:
            values = [self.values[number] for number in chosen]
        failed = [one for one in self.failed if any(one[0] is point for point in points)]
        return SweepResult(self._subject, Grid(points), points, values, failed, self.store)

    def to_xarray(self) -> Any:
        """Values with named axes and coordinates: an axis for each key of an outer product, "point" for a list or a part.

        Returns    xarray.DataArray; NaN where a point failed; pictures as XYZ with axes y, x, channel
        Raises     ImportError where xarray is missing; ValueError where values have several shapes

        >>> import iridesce as ir
        >>> vary = {"layers.0.thickness_nm": [0.0, 100.0, 200.0], "wavelength_nm": [500.0, 600.0]}
        >>> labelled = ir.sweep("air / soap 320 / air", vary, quantity="reflectance").to_xarray()
        >>> labelled.dims, round(float(labelled.sel({"layers.0.thickness_nm": 100.0, "wavelength_nm": 500.0})), 6)
        (('layers.0.thickness_nm', 'wavelength_nm'), 0.078873)
        """
        try:
            xarray = importlib.import_module("xarray")
        except ImportError:
            raise ImportError('to_xarray needs xarray: pip install "iridesce[xarray]"') from None
        try:
            values = np.asarray(self.values)
        except ValueError:
            values = np.asarray(None)
        if values.dtype == object:
            raise ValueError("to_xarray needs values of one shape; these have several, or none")
        is_whole = self._grid.axes is not None and len(self.points) == len(self._grid.points)
        coordinates: dict[str, Any] = {}
        if is_whole and self._grid.axes is not None:
            names = list(self._grid.axes)
            coordinates.update({key: (key, _coordinate(one)) for key, one in self._grid.axes.items()})
            values = values.reshape(*self._grid.shape, *values.shape[1:])
        else:
            names = ["point"]
            for key in self._grid.keys:
                coordinates[key] = ("point", _coordinate([point.get(key) for point in self.points]))
        constant = {
            key: one for key, one in self.points[0].items() if all(key in p and p[key] == one for p in self.points)
        }
        varied = {key: None for point in self.points for key in point}
        for axis in self._subject.last_axes(values.shape[len(names) :], {**varied, **constant}):
            names.append(axis.name)
            if axis.coordinates is not None:
                coordinates[axis.name] = (axis.name, np.asarray(axis.coordinates))
        quantity = self.quantity if isinstance(self.quantity, str) else getattr(self.quantity, "__name__", "value")
        attributes = {"base": _described(self._subject), "failed_points": len(self.failed)}
        return xarray.DataArray(values, dims=names, coords=coordinates, name=quantity, attrs=attributes)

    def __repr__(self) -> str:
        failed = f", {len(self.failed)} failed" if self.failed else ""
        return f"<iridesce.SweepResult {len(self)} points of {', '.join(self._grid.keys)}{failed}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: how many points of what, and what failed."""
        facts = [("points", str(len(self))), ("varied", ", ".join(self._grid.keys))]
        facts += [("failed", f"{point}: {message}") for point, message in self.failed[:5]]
        if len(self.failed) > 5:
            facts.append(("failed", f"{len(self.failed) - 5} more"))
        return facts_html("iridesce.SweepResult", facts)


def _coordinate(values: Sequence[Any]) -> Any:
    """Coordinates that xarray can select by: numbers and texts as they are, anything else as text."""
    array = (
        np.asarray([None] * len(values)) if any(isinstance(one, list | dict) for one in values) else np.asarray(values)
    )
    return np.asarray([repr(one) for one in values]) if array.dtype == object or array.ndim != 1 else array


def _described(subject: Subject) -> str:
    return repr(subject.stack) if subject.kind == "stack" else repr(subject.scene)  # type: ignore[union-attr]


def joined(values: list[Any]) -> Any:
    """One array where all values that are there have one shape, NaN for None; else the list as it is."""
    there = [value for value in values if value is not None]
    if not there or any(isinstance(value, Image) for value in there):
        return values
    arrays = [np.asarray(value) for value in there]
    if any(array.shape != arrays[0].shape for array in arrays):
        return values
    dtype = np.result_type(*(array.dtype for array in arrays))
    if len(there) == len(values):
        return np.stack([np.asarray(value, dtype) for value in values])
    # A failed point is NaN, which whole numbers and truths do not have.
    dtype = dtype if dtype.kind in "fc" else np.dtype(np.float64)
    empty = np.full(arrays[0].shape, np.nan, dtype)
    return np.stack([empty if value is None else np.asarray(value, dtype) for value in values])
