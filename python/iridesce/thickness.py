"""Thickness models: how thick a film is, where. Each goes into a scene as ``thickness_nm`` and gives a map.

>>> import iridesce as ir
>>> drained = ir.thickness.gradient(top=20.0, bottom=900.0, exponent=0.8)
>>> scene = ir.Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", drained)
>>> ir.Stack(["air", ir.Layer("soap", thickness_nm=drained.map(2, 3)), "air"]).color().shape
(3, 2, 3)
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from iridesce import _core
from iridesce.errors import ResourceError

__all__ = ["ThicknessMap", "ThicknessModel", "gradient", "uniform"]

_MAX_CELLS = 2**30


def __dir__() -> list[str]:
    return __all__


class ThicknessMap:
    """A grid of thicknesses; row 0 on top, values at the middles of the cells. Immutable.

    thickness_nm  nm, finite, >= 0                                                     (height, width)
    Raises        ValueError naming the value and its place: another shape, no cells, not finite, negative

    It stands for its array wherever numpy or `iridesce.Layer` wants one.

    >>> grid = ThicknessMap([[100.0, 200.0], [300.0, 400.0]])
    >>> grid, grid.width, grid.height
    (<iridesce.thickness.ThicknessMap 2 x 2, 100 to 400 nm>, 2, 2)
    """

    __slots__ = ("_core", "_thickness_nm")

    def __init__(self, thickness_nm: ArrayLike) -> None:
        values = _array("thickness_nm", thickness_nm)
        if values.ndim != 2 or 0 in values.shape:
            raise ValueError(f"thickness_nm must have the shape (height, width), both >= 1, got {values.shape}")
        self._core = _core.ThicknessMap(np.ascontiguousarray(values))
        self._thickness_nm: NDArray[np.float64] = values.copy()
        self._thickness_nm.flags.writeable = False

    @property
    def thickness_nm(self) -> NDArray[np.float64]:
        """The values, nm, float64, read-only, (height, width)."""
        return self._thickness_nm

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self._thickness_nm.shape[1])

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self._thickness_nm.shape[0])

    def sample(self, u: ArrayLike, v: ArrayLike) -> NDArray[np.float64] | float:
        """Thickness between the cells: bilinear between their middles, the outermost values beyond them.

        u        0 at the left edge, 1 at the right; finite                                (...,)
        v        0 at the bottom edge, 1 on top; finite                                    (...,) broadcasts
        Returns  nm, float64; a float for scalars                                          broadcast shape
        Raises   ValueError where a coordinate is not finite, or shapes do not broadcast

        >>> ThicknessMap([[100.0, 200.0], [300.0, 400.0]]).sample(0.5, [0.25, 0.5, 1.0])
        array([350., 250., 150.])
        """
        across, up = _array("u", u), _array("v", v)
        for name, values in (("u", across), ("v", up)):
            _refuse_where(~np.isfinite(values), values, f"{name} must be finite")
        try:
            across, up = np.broadcast_arrays(across, up)
        except ValueError:
            raise ValueError(f"u and v must broadcast: shapes {across.shape} and {up.shape}") from None
        flat = self._core.sample(np.ascontiguousarray(across).reshape(-1), np.ascontiguousarray(up).reshape(-1))
        return float(flat[0]) if across.ndim == 0 else flat.reshape(across.shape)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy:
            return np.array(self._thickness_nm, dtype=dtype)
        return np.asarray(self._thickness_nm, dtype=dtype)

    def __repr__(self) -> str:
        least, most = float(self._thickness_nm.min()), float(self._thickness_nm.max())
        return f"<iridesce.thickness.ThicknessMap {self.width} x {self.height}, {least:g} to {most:g} nm>"

    def _repr_png_(self) -> bytes:
        """What a notebook shows: false colours from the least thickness (dark) to the greatest."""
        from iridesce import _notebook

        return _notebook.map_png(self._thickness_nm)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ThicknessMap) and np.array_equal(self._thickness_nm, other._thickness_nm)

    def __hash__(self) -> int:
        return hash((self._thickness_nm.shape, self._thickness_nm.tobytes()))

    def __reduce__(self) -> tuple[Any, ...]:
        return (ThicknessMap, (self._thickness_nm,))


class ThicknessModel:
    """A film's thickness as a function of relative height; make one with `uniform` or `gradient`. Immutable.

    >>> gradient(0.0, 800.0)
    gradient(top=0.0, bottom=800.0, exponent=1.0)
    """

    __slots__ = ("_core", "_kind", "_values")

    def __init__(self, kind: str, values: dict[str, float]) -> None:
        make: dict[str, Callable[..., _core.Thickness]] = {
            "uniform": _core.Thickness.uniform,
            "gradient": _core.Thickness.gradient,
        }
        if kind not in make:
            raise ValueError(f'kind must be "uniform" or "gradient", got {kind!r:.60}')
        self._kind = kind
        self._values = {name: _number(name, value) for name, value in values.items()}
        self._core = make[kind](**self._values)

    def at_height(self, s: ArrayLike) -> NDArray[np.float64] | float:
        """Thickness at relative height.

        s        height over the object's own bounding box, 0 at the bottom, 1 on top (clamped)    (...,)
        Returns  nm, float64; a float for a scalar                                                 shape of s
        Raises   ValueError where `s` is not finite, with the place

        >>> gradient(100.0, 900.0).at_height(0.25)
        700.0
        """
        heights = _array("s", s)
        _refuse_where(~np.isfinite(heights), heights, "s must be finite")
        flat = self._core.at_height(np.ascontiguousarray(heights).reshape(-1))
        return float(flat[0]) if heights.ndim == 0 else flat.reshape(heights.shape)

    def map(self, width: int, height: int) -> ThicknessMap:
        """The model on a grid, sampled at the middles of its cells, row 0 on top.

        width, height  cells, >= 1
        Returns        ThicknessMap of shape (height, width)
        Raises         ValueError for a size below 1; ResourceError for more than 2**30 cells

        >>> gradient(100.0, 900.0).map(2, 4).thickness_nm[:, 0].tolist()
        [200.0, 400.0, 600.0, 800.0]
        """
        sides = {"width": width, "height": height}
        for name, value in sides.items():
            try:
                sides[name] = operator.index(value)
            except TypeError:
                sides[name] = 0
            if sides[name] < 1:
                raise ValueError(f"{name} must be a whole number >= 1, got {value!r:.60}")
        if sides["width"] * sides["height"] > _MAX_CELLS:
            raise ResourceError(f"a map has at most {_MAX_CELLS} cells, got {width} x {height}")
        return ThicknessMap(self._core.map(**sides))

    def to_scene(self) -> float | dict[str, Any]:
        """The model as a scene writes it.

        Returns  a number or a dict
        Raises   nothing

        >>> uniform(320.0).to_scene()
        320.0
        """
        return self._values["thickness_nm"] if self._kind == "uniform" else {self._kind: dict(self._values)}

    def __repr__(self) -> str:
        return f"{self._kind}({', '.join(f'{name}={value}' for name, value in self._values.items())})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ThicknessModel) and (self._kind, self._values) == (other._kind, other._values)

    def __hash__(self) -> int:
        return hash((self._kind, tuple(self._values.values())))

    def __reduce__(self) -> tuple[Any, ...]:
        return (ThicknessModel, (self._kind, self._values))


def uniform(thickness_nm: float) -> ThicknessModel:
    """The same thickness everywhere.

    thickness_nm  nm, finite, >= 0
    Returns       ThicknessModel
    Raises        ValueError naming the value

    >>> uniform(320.0).at_height(0.7)
    320.0
    """
    return ThicknessModel("uniform", {"thickness_nm": thickness_nm})


def gradient(top: float, bottom: float, exponent: float = 1.0) -> ThicknessModel:
    """A power law in height: ``bottom + (top - bottom) s**exponent``, s = 0 at the bottom and 1 on top.

    top, bottom  nm at the highest and lowest point, finite, >= 0
    exponent     finite, > 0; 1 is linear
    Returns      ThicknessModel
    Raises       ValueError naming the argument and the value

    >>> round(gradient(0.0, 800.0, exponent=0.5).at_height(0.25), 6)
    400.0
    """
    return ThicknessModel("gradient", {"top": top, "bottom": bottom, "exponent": exponent})


def _number(name: str, value: Any) -> float:
    # float("3") and float(array([3])) would pass, but are slips.
    try:
        if isinstance(value, (str, bytes, bool)) or np.ndim(value) != 0:
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} must be a number, got {value!r:.60}") from None


def _array(name: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "fiu":
            raise TypeError
        return array.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be real numbers, got {values!r:.60}") from None


def _refuse_where(wrong: NDArray[np.bool_], values: NDArray[np.float64], rule: str) -> None:
    """Names the first value that breaks a rule, and its place."""
    if wrong.any():
        at = tuple(int(i) for i in np.argwhere(wrong)[0])
        raise ValueError(f"{rule}, got {values[at]}{f' at index {at}' if at else ''}")
