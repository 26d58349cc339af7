"""Thickness models: how thick a film is, where. Each goes into a scene as ``thickness_nm`` and gives a map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from iridesce import _core

__all__ = ["ThicknessMap", "ThicknessModel", "gradient", "uniform"]


@dataclass(frozen=True)
class ThicknessMap:
    """A grid of thicknesses; row 0 on top.

    thickness_nm  (height, width) float64, nm
    """

    thickness_nm: NDArray[np.float64]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.thickness_nm, dtype=dtype, copy=bool(copy) or None)


class ThicknessModel:
    """A film's thickness as a function of relative height; make one with :func:`uniform` or :func:`gradient`."""

    __slots__ = ("_core", "_scene")

    def __init__(self, core: _core.Thickness, scene: float | dict[str, Any]):
        self._core = core
        self._scene = scene

    def at_height(self, s: ArrayLike) -> NDArray[np.float64] | float:
        """Thickness at relative height.

        s        height over the object's own bounding box, 0 at the bottom, 1 on top (clamped); any shape
        Returns  nm, float64, the shape of ``s``; a float for a scalar
        Raises   ValueError where ``s`` is not finite

        >>> gradient(100.0, 900.0).at_height(0.25)
        700.0
        """
        heights = np.asarray(s, dtype=np.float64)
        if not np.isfinite(heights).all():
            at = tuple(int(i) for i in np.argwhere(~np.isfinite(heights))[0])
            raise ValueError(f"s must be finite, got {heights[at]} at index {at}")
        flat = self._core.at_height(np.ascontiguousarray(heights).reshape(-1))
        return float(flat[0]) if heights.ndim == 0 else flat.reshape(heights.shape)

    def map(self, width: int, height: int) -> ThicknessMap:
        """The model on a grid, sampled at the middles of its cells.

        width, height  cells, >= 1
        Returns        a ThicknessMap of shape (height, width), row 0 on top
        Raises         ValueError for a size below 1

        >>> gradient(100.0, 900.0).map(2, 4).thickness_nm[:, 0].tolist()
        [200.0, 400.0, 600.0, 800.0]
        """
        for name, value in (("width", width), ("height", height)):
            if int(value) != value or value < 1:
                raise ValueError(f"{name} must be a whole number >= 1, got {value}")
        column = np.asarray(self.at_height(1.0 - (np.arange(int(height)) + 0.5) / int(height)))
        return ThicknessMap(np.repeat(column[:, None], int(width), axis=1))

    def to_scene(self) -> float | dict[str, Any]:
        """The model as a scene writes it.

        Returns  a number or a dict

        >>> uniform(320.0).to_scene()
        320.0
        """
        return self._scene

    def __repr__(self) -> str:
        return f"<iridesce thickness model {self._scene}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ThicknessModel) and self._scene == other._scene

    def __hash__(self) -> int:
        return hash(repr(self._scene))


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number, got {value!r}") from None


def uniform(thickness_nm: float) -> ThicknessModel:
    """The same thickness everywhere.

    thickness_nm  nm, finite, >= 0
    Returns       a ThicknessModel
    Raises        ValueError naming the value

    >>> uniform(320.0).at_height(0.7)
    320.0
    """
    value = _number("thickness_nm", thickness_nm)
    return ThicknessModel(_core.Thickness.uniform(value), value)


def gradient(top: float, bottom: float, exponent: float = 1.0) -> ThicknessModel:
    """A power law in height: ``bottom + (top - bottom) s**exponent``.

    top, bottom  nm at the highest and lowest point, finite, >= 0
    exponent     finite, > 0; 1 is linear
    Returns      a ThicknessModel
    Raises       ValueError naming the argument and the value

    >>> round(gradient(0.0, 800.0, exponent=0.5).at_height(0.25), 6)
    400.0
    """
    values = {
        "top": _number("top", top),
        "bottom": _number("bottom", bottom),
        "exponent": _number("exponent", exponent),
    }
    return ThicknessModel(_core.Thickness.gradient(**values), {"gradient": values})
