"""Results with named axes and units for xarray (the extra ``xarray``): a method of `iridesce.Stack`. Internal."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable, Sequence
from typing import Any, ParamSpec

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import real_operand
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import one_of
from iridesce.optics.layer import Layer
from iridesce.optics.multilayer import Multilayer

P = ParamSpec("P")

_QUANTITIES = ("reflectance", "transmittance", "absorptance", "psi", "delta")
_POLARIZATIONS = ("s", "p", "unpolarized")
_UNITS = {"psi": "degree", "delta": "degree"}
_NAMES = {
    "wavelength_nm": ("vacuum wavelength", "nm"),
    "angle_deg": ("angle of incidence in the first medium", "degree"),
    "thickness_nm": ("thickness", "nm"),
}


def _also_quantity_first(labelled: Callable[P, Any]) -> Callable[P, Any]:
    """Takes the order of before, too: quantity, wavelength, angle, polarisation."""

    @functools.wraps(labelled)
    def either(*args: Any, **named: Any) -> Any:
        if len(args) > 1 and _are_words(args[1]):
            stack, quantity, *rest = args
            return labelled(stack, *rest, quantity=quantity, **named)
        return labelled(*args, **named)

    return either


def _are_words(value: Any) -> bool:
    return isinstance(value, str) or (isinstance(value, list | tuple) and any(isinstance(word, str) for word in value))


@_also_quantity_first
def to_xarray(
    self: Multilayer,
    wavelength_nm: npt.ArrayLike = 550.0,
    angle_deg: npt.ArrayLike = 0.0,
    polarization: str | Sequence[str] = "unpolarized",
    quantity: str | Sequence[str] = "reflectance",
) -> Any:
    """R, T, A, psi or delta as an xarray object: named axes with coordinates, units and the stack in its attributes.

    Every argument that is not a single value becomes an axis of its own (no broadcasting), in the order thickness,
    wavelength, angle, polarisation. A layer whose thickness is an array of one axis adds the axis "thickness_nm", or
    "thickness_nm_2" for layer 2 of several; single values become scalar coordinates.

    wavelength_nm  vacuum wavelength, > 0                          () or (n,)
    angle_deg      incidence in the first medium, [0, 90)          () or (m,)
    polarization   "s", "p", "unpolarized", or several of them; psi and delta have no such axis
    quantity       "reflectance", "transmittance", "absorptance", "psi", "delta", or several of them. It may also stand
                   first, as it once did
    Returns        xarray.DataArray; an xarray.Dataset for several quantities
    Raises         ImportError where xarray is missing; ValueError as for the quantity, and for arrays with more axes

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(0.0, 500.0, 6)), "air"])
    >>> labelled = film.to_xarray([500.0, 600.0], [0.0, 45.0], ["s", "p"])
    >>> labelled.dims, labelled.attrs["units"]
    (('thickness_nm', 'wavelength_nm', 'angle_deg', 'polarization'), '1')
    >>> round(float(labelled.sel(thickness_nm=100.0, wavelength_nm=500.0, angle_deg=0.0, polarization="s")), 6)
    0.078873
    """
    xarray = _xarray()
    names = [quantity] if isinstance(quantity, str) else list(quantity)
    states = [polarization] if isinstance(polarization, str) else list(polarization)
    for name in names:
        one_of("quantity", name, _QUANTITIES)
    for state in states:
        one_of("polarization", state, _POLARIZATIONS)
    if not names or not states:
        raise complaint(
            "quantity and polarization must name one or more",
            "quantity" if not names else "polarization",
            "one or more",
            Words("none"),
        )
    axes, spread = _axes(self, wavelength_nm, angle_deg)
    arrays = {name: _array(xarray, spread, name, axes, states, not isinstance(polarization, str)) for name in names}
    if isinstance(quantity, str):
        return arrays[quantity]
    return xarray.Dataset(arrays, attrs={"stack": repr(self)})


def _xarray() -> Any:
    try:
        return importlib.import_module("xarray")
    except ImportError:
        raise ImportError('to_xarray needs xarray: pip install "iridesce[xarray]"') from None


def _axes(self: Multilayer, wavelength_nm: npt.ArrayLike, angle_deg: npt.ArrayLike) -> tuple[dict[str, Any], Any]:
    """Coordinates by name in the order of the axes, and the stack and arguments spread along them."""
    several = len(self.layers) > 1
    given: dict[str, Any] = {}
    for number, layer in enumerate(self.layers, start=1):
        if np.ndim(layer.thickness_nm):
            given[f"thickness_nm_{number}" if several else "thickness_nm"] = layer.thickness_nm
    given["wavelength_nm"] = real_operand("wavelength_nm", wavelength_nm, low=0.0, includes_low=False).full()
    given["angle_deg"] = real_operand("angle_deg", angle_deg, low=0.0, high=90.0).full()
    for name, values in given.items():
        if np.ndim(values) > 1:
            raise refusal(name, "one axis or none", Words(f"shape {np.shape(values)}"), must="have")
    lengths = [name for name, values in given.items() if np.ndim(values)]
    full = {
        name: np.reshape(values, _along(lengths, name)) if name in lengths else values for name, values in given.items()
    }
    layers = [
        Layer(
            layer.medium,
            full.get(f"thickness_nm_{number}" if several else "thickness_nm", layer.thickness_nm),
            layer.coherent,
        )
        for number, layer in enumerate(self.layers, start=1)
    ]
    stack = type(self)([self.first, *layers, self.last])
    return given, (stack, full["wavelength_nm"], full["angle_deg"])


def _along(lengths: list[str], name: str) -> tuple[int, ...]:
    return tuple(-1 if other == name else 1 for other in lengths)


def _array(xarray: Any, spread: Any, name: str, axes: dict[str, Any], states: list[str], several: bool) -> Any:
    stack, wavelength_nm, angle_deg = spread
    dims = [axis for axis, values in axes.items() if np.ndim(values)]
    shape = [len(axes[axis]) for axis in dims]
    coords = {}
    for axis, values in axes.items():
        long_name, unit = _NAMES[axis if axis in _NAMES else "thickness_nm"]
        layer = axis.removeprefix("thickness_nm").removeprefix("_")
        attrs = {"long_name": f"{long_name} of layer {layer}" if layer.isdigit() else long_name, "units": unit}
        coords[axis] = (axis if axis in dims else (), values, attrs)
    attrs = {"long_name": name, "units": _UNITS.get(name, "1"), "stack": repr(stack)}
    if name in _UNITS:
        values = stack.ellipsometry(wavelength_nm, angle_deg)[0 if name == "psi" else 1]
        return xarray.DataArray(np.reshape(values, shape), dims=dims, coords=coords, name=name, attrs=attrs)
    stacked = [np.reshape(getattr(stack, name)(wavelength_nm, angle_deg, state), shape) for state in states]
    if several:
        coords["polarization"] = ("polarization", states, {"long_name": "polarisation"})
        return xarray.DataArray(
            np.stack(stacked, axis=-1), dims=[*dims, "polarization"], coords=coords, name=name, attrs=attrs
        )
    coords["polarization"] = ((), states[0], {"long_name": "polarisation"})
    return xarray.DataArray(stacked[0], dims=dims, coords=coords, name=name, attrs=attrs)
