"""Thickness models: how thick a film is, where. Each goes into a scene as ``thickness_nm`` and gives a map.

>>> import iridesce as ir
>>> drained = ir.thickness.gradient(top=20.0, bottom=900.0, exponent=0.8)
>>> scene = ir.Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", drained)
>>> ir.Stack(["air", ir.Layer("soap", thickness_nm=drained.map(2, 3)), "air"]).color().shape
(3, 2, 3)
"""

from __future__ import annotations

import operator
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from iridesce import _core
from iridesce._notebook import facts_html
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import allowed_range, file_name, number, whole
from iridesce.errors import ResourceError
from iridesce.thickness.simulation import presets
from iridesce.thickness.thickness_map import ThicknessMap, array, refuse_where

_MAX_CELLS = 2**30


# What each kind follows, and which method asks it; all follow anything where they are uniform.
_METHODS = {"gradient": "at_height", "wedge": "at_point", "lens_gap": "at_radius", "map": "map", "flow": "map"}
_EXTENT_KINDS = ("wedge", "lens_gap")


class ThicknessModel:
    """A film's thickness as a function of place: `uniform`, `gradient`, `wedge`, `lens_gap`, `map`, `flow` make one. Immutable.

    >>> gradient(0.0, 800.0)
    gradient(top=0.0, bottom=800.0, exponent=1.0)
    """

    __slots__ = ("_core", "_films", "_kind", "_values")

    def __init__(self, kind: str, values: Mapping[str, Any]) -> None:
        if kind != "uniform" and kind not in _METHODS:
            known = ", ".join(f'"{name}"' for name in ("uniform", *_METHODS))
            raise refusal("kind", f"one of {known}", kind)
        self._kind = kind
        self._values: dict[str, Any] = {name: _parameter(name, value) for name, value in values.items()}
        # A map is read when it is asked: the scene that it is meant for may lie in another folder. A film flows then, too.
        self._core = None if kind in ("map", "flow") else getattr(_core.Thickness, kind)(**self._values)
        # Where a film that has been asked for stands, for the next time it is.
        self._films = _core.FlowContext() if kind == "flow" else None

    def at_height(self, s: ArrayLike) -> NDArray[np.float64] | float:
        """Thickness at relative height, of a gradient.

        s        height over the object's own bounding box, 0 at the bottom, 1 on top (clamped)    (...,)
        Returns  nm, float64; a float for a scalar                                                 shape of s
        Raises   ValueError where `s` is not finite, with the place; for a model that does not follow height

        >>> gradient(100.0, 900.0).at_height(0.25)
        700.0
        """
        return self._evaluate("at_height", "s", s)

    def at_point(self, points: ArrayLike) -> NDArray[np.float64] | float:
        """Thickness at points of the scene, of a wedge.

        points   x, y, z in scene units                                        (..., 3)
        Returns  nm, float64; a float for one point                            (...,)
        Raises   ValueError where a coordinate is not finite, with the place; for another last axis; for a model that
                 does not follow points

        >>> wedge((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), 0.0, 800.0).at_point([[1.0, 5.0, 0.0], [9.0, 0.0, 0.0]])
        array([200., 800.])
        """
        return self._evaluate("at_point", "points", points)

    def at_radius(self, distance_mm: ArrayLike) -> NDArray[np.float64] | float:
        """Thickness at a distance from the axis, of a gap under a lens.

        distance_mm  mm, >= 0; beyond the lens's radius of curvature the value there            (...,)
        Returns      nm, float64; a float for a scalar                                          shape of distance_mm
        Raises       ValueError where a distance is negative or not finite, with the place; for a model that does not
                     follow a distance

        >>> round(lens_gap(1000.0).at_radius(10.0), 4)
        50001.2501
        """
        return self._evaluate("at_radius", "distance_mm", distance_mm)

    def _evaluate(self, method: str, name: str, values: ArrayLike) -> NDArray[np.float64] | float:
        if self._kind not in ("uniform", *(kind for kind, own in _METHODS.items() if own == method)):
            raise complaint(
                f"a {self._kind} is not asked by {method}; use {_METHODS[self._kind]}",
                "model",
                "asked by its own method",
                Words(method),
            )
        places = array(name, values)
        refuse_where(~np.isfinite(places), places, name, "finite")
        if method == "at_radius":
            refuse_where(places < 0.0, places, name, ">= 0")
        shape = places.shape
        if method == "at_point":
            if places.ndim == 0 or shape[-1] != 3:
                raise refusal(name, "a last axis of 3 coordinates", Words(f"the shape {shape}"), must="have")
            shape = shape[:-1]
            places = places.reshape(-1, 3)
        else:
            places = places.reshape(-1)
        flat: NDArray[np.float64] = getattr(self._core, method)(np.ascontiguousarray(places))
        return flat.reshape(shape) if shape else float(flat[0])

    def map(self, width: int, height: int, extent: Sequence[float] | None = None) -> ThicknessMap:
        """The model on a grid, sampled at the middles of its cells, row 0 on top.

        width, height  cells, >= 1
        extent         left, right, bottom, top of the grid, as matplotlib's ``imshow`` takes it; only a wedge and a gap
                       under a lens need one. Wedge: x and y of the scene, at z = 0, in scene units. Gap: mm from where
                       it is narrowest. A gradient fills the grid from bottom to top, a map from edge to edge
        Returns        ThicknessMap of shape (height, width)
        Raises         ValueError for a size below 1, an extent that is missing, not asked for or without an area, a map
                       whose file cannot be used; ResourceError for more than 2**30 cells

        >>> gradient(100.0, 900.0).map(2, 4).thickness_nm[:, 0].tolist()
        [200.0, 400.0, 600.0, 800.0]
        >>> lens_gap(1000.0).map(3, 1, extent=(-3.0, 3.0, -0.5, 0.5)).thickness_nm.round(2).tolist()
        [[2000.0, 0.0, 2000.0]]
        """
        sides = {"width": width, "height": height}
        for name, value in sides.items():
            try:
                sides[name] = operator.index(value)
            except TypeError:
                sides[name] = 0
            if sides[name] < 1:
                raise refusal(name, "a whole number >= 1", value)
        if sides["width"] * sides["height"] > _MAX_CELLS:
            raise ResourceError(f"a map has at most {_MAX_CELLS} cells, got {width} x {height}")
        if extent is not None and self._kind not in _EXTENT_KINDS:
            raise complaint(
                f"extent is for a wedge or a gap under a lens; a {self._kind} spans the whole object",
                "extent",
                f"left out for a {self._kind}",
                extent,
            )
        ends = None
        if extent is not None:
            given = array("extent", extent)
            if given.shape != (4,):
                raise refusal("extent", "left, right, bottom and top", extent)
            ends = (float(given[0]), float(given[1]), float(given[2]), float(given[3]))
        if self._core is not None:
            return ThicknessMap(self._core.map(**sides, extent=ends))
        if self._films is not None:
            own = self._values
            which = (own["preset"], own["time_s"], own["seed"], own.get("columns"))
            return ThicknessMap(_core.flow_map(self._films, *which, sides["width"], sides["height"], None))
        u = (np.arange(sides["width"]) + 0.5) / sides["width"]
        v = 1.0 - (np.arange(sides["height"]) + 0.5) / sides["height"]
        whole = ThicknessMap.load(**self._values)
        return ThicknessMap(whole.sample(u[None, :], v[:, None]))

    def to_scene(self) -> float | dict[str, Any]:
        """The model as a scene writes it.

        Returns  a number or a dict
        Raises   nothing

        >>> uniform(320.0).to_scene()
        320.0
        """
        if self._kind == "uniform":
            return float(self._values["thickness_nm"])
        if self._kind == "map":
            named = {"map": self._values["path"], "min_nm": self._values["min_nm"], "max_nm": self._values["max_nm"]}
            return {name: value for name, value in named.items() if value is not None}
        plain = {name: list(value) if isinstance(value, tuple) else value for name, value in self._values.items()}
        return {self._kind: {name.removesuffix("_point"): value for name, value in plain.items()}}

    def __repr__(self) -> str:
        given = {name: value for name, value in self._values.items() if value is not None}
        return f"{self._kind}({', '.join(f'{name}={value!r}' for name, value in given.items())})"

    def _repr_html_(self) -> str:
        """What a notebook shows: the law, and for one that follows height its thickness from the bottom to the top."""
        facts = [("law", repr(self))]
        if self._kind in ("uniform", "gradient"):
            nm = np.ravel(self.at_height([0.0, 0.25, 0.5, 0.75, 1.0]))
            facts.append(("at heights 0, 1/4 ... 1", ", ".join(f"{value:.4g}" for value in nm) + " nm"))
        return facts_html("iridesce.thickness", facts)

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


def wedge(from_point: Sequence[float], to_point: Sequence[float], start_nm: float, end_nm: float) -> ThicknessModel:
    """Linear between two points: ``start_nm + (end_nm - start_nm) s``, s = 0 at the one and 1 at the other.

    s is the share of the way from `from_point` to `to_point`, along the line between them; it holds beyond both ends.

    from_point, to_point  x, y, z in scene units, finite, two different points
    start_nm, end_nm      nm at the two, finite, >= 0
    Returns               ThicknessModel
    Raises                ValueError naming the argument and the value

    >>> wedge((-2.0, 0.0, 0.0), (2.0, 0.0, 0.0), 0.0, 800.0).at_point((0.5, 3.0, -1.0))
    500.0
    """
    values = {"from_point": from_point, "to_point": to_point, "start_nm": start_nm, "end_nm": end_nm}
    return ThicknessModel("wedge", values)


def lens_gap(radius_mm: float, contact_gap_nm: float = 0.0) -> ThicknessModel:
    """The gap under a lens on a plate: ``contact_gap_nm + 1e6 (R - sqrt(R**2 - r**2))``, R and r in mm.

    In a scene r is the distance from the object's centre, on a cap from its axis; the scene's unit is taken into account.
    Under light of one wavelength it shows Newton's rings, dark at ``r**2 = m wavelength R``.

    radius_mm       R, the lens's radius of curvature, mm, finite, > 0
    contact_gap_nm  the gap where it is narrowest, nm, finite, >= 0
    Returns         ThicknessModel
    Raises          ValueError naming the argument and the value
    Source          the geometry of a sphere on a plane

    >>> tenth_ring_mm = (10 * 589.3e-6 * 1000.0) ** 0.5
    >>> round(lens_gap(1000.0).at_radius(tenth_ring_mm) / (589.3 / 2), 4)
    10.0
    """
    return ThicknessModel("lens_gap", {"radius_mm": radius_mm, "contact_gap_nm": contact_gap_nm})


def map(path: str | os.PathLike[str], min_nm: float | None = None, max_nm: float | None = None) -> ThicknessModel:
    """A map from a file, laid over an object by its u and v (``docs/reference/conventions.md``).

    path            OpenEXR, TIFF, PNG or NPY, as `ThicknessMap.load` reads them. In a scene it starts from the scene's
                    folder; `ThicknessModel.map` looks for it from the current folder
    min_nm, max_nm  nm that 0 and the largest number stand for, of files of whole numbers; none for files of floats
    Returns         ThicknessModel; the file is read when the model is used
    Raises          ValueError naming the argument and the value

    >>> map("wings.png", min_nm=100.0, max_nm=600.0).to_scene()
    {'map': 'wings.png', 'min_nm': 100.0, 'max_nm': 600.0}
    """
    return ThicknessModel("map", {"path": path, "min_nm": min_nm, "max_nm": max_nm})


def flow(preset: str, time_s: float, seed: int = 1, columns: int | None = None) -> ThicknessModel:
    """A film that has flowed for some seconds, laid over a sphere by its u and v; a dome is mirrored below its rim.

    preset   one of `presets`
    time_s   0 to 600 s since the film was made
    seed     0 to 2**64 - 1; another seed, another film
    columns  cells around, 16 to 16384; None: the preset's own. Between cells the film is smooth (cubic)
    Returns  ThicknessModel; the film flows when the model is used, which takes several seconds for each of its own. The
             last few are remembered, and a later time goes on from an earlier one
    Raises   ValueError naming the argument and the value

    >>> flow("bubble-on-bath", 0.1).to_scene()
    {'flow': {'preset': 'bubble-on-bath', 'time_s': 0.1, 'seed': 1}}
    >>> grid = flow("late", 0.02).map(64, 32)
    >>> bool(200.0 < grid.thickness_nm.mean() < 300.0)
    True
    """
    if preset not in presets():
        raise refusal("preset", f"one of {', '.join(presets())}", preset)
    if not 0.0 <= number("time_s", time_s) <= 600.0:
        raise refusal("time_s", "from 0 to 600 s", time_s)
    values: dict[str, Any] = {"preset": preset, "time_s": time_s, "seed": whole("seed", seed, 0, 2**64 - 1)}
    if columns is not None:
        values["columns"] = whole("columns", columns, 16, 16384)
    return ThicknessModel("flow", values)


def _parameter(name: str, value: Any) -> Any:
    """One parameter of a model, checked for its type: a number, three of them, or a path."""
    if name in ("preset", "seed", "columns"):
        return value
    if name == "path":
        return file_name(value)
    if name.endswith("_point"):
        given = array(name, value)
        if given.shape != (3,):
            raise refusal(name, "three numbers, x, y and z", value)
        return tuple(float(x) for x in given)
    if name in ("min_nm", "max_nm"):
        return None if value is None else _thickness(name, value)
    return number(name, value)


def _thickness(name: str, value: Any) -> float:
    nm = number(name, value)
    if not 0.0 <= nm < float("inf"):
        unit = "" if name.endswith("_nm") else ", in nm"
        raise refusal(name, allowed_range(0.0, float("inf"), True) + unit, nm)
    return nm
