"""Partial coherence: averages over the width of a spectral line and the spread of a thickness. Internal.

The rules are `optics::coherence` of the core; here arguments are checked and broadcast.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, Operand, broadcast_shape, real_operand
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import number, one_of
from iridesce.optics.evaluation import index_at
from iridesce.optics.multilayer import Multilayer

SHAPES = ("gaussian", "rectangle", "triangle")
FWHM = math.sqrt(8.0 * math.log(2.0))
"""Full width at half maximum of a Gaussian over its standard deviation."""


class Averaged(NamedTuple):
    """An average and a bound of its numerical error, both of the broadcast shape."""

    value: Any
    error: Any


def reflectance_averaged(
    self: Multilayer,
    wavelength_nm: npt.ArrayLike,
    angle_deg: npt.ArrayLike = 0.0,
    polarization: str = "unpolarized",
    *,
    resolution_nm: float = 0.0,
    resolution_shape: str = "gaussian",
    bandwidth_nm: float = 0.0,
    bandwidth_shape: str = "gaussian",
    thickness_sd_nm: npt.ArrayLike = 0.0,
    tolerance: float = 1e-9,
) -> Averaged:
    """Reflectance as an instrument sees it: averaged over its resolution, the width of the source, and uneven films.

    The spread of the thickness of one clear layer is averaged in closed form. With z = exp(2 i kz k0 t) the stack has
    r = a + e/(1 - q), q proportional to z, and a Gaussian damps the m-th harmonic by D^(m^2), D = exp(-(2 kz k0 sd)^2/2):

    <R> = |a|^2 + |e|^2/(1 - |q|^2) + 2 Re sum_m D^(m^2) q^(m-1) (a* e + |e|^2 q/(1 - |q|^2)).

    All other averages (wavelength, absorbing or several uneven layers, incoherent slabs) are Gauss-Legendre rules, doubled
    until they agree. Dispersion is kept: media are read at every wavelength of the average, and must be known there.

    wavelength_nm, angle_deg, polarization  as for `reflectance`; wavelengths are the middles of the lines
    resolution_nm     full width at half maximum of the instrument's line, nm, >= 0
    resolution_shape  "gaussian", "rectangle" or "triangle" (a monochromator with equal slits)
    bandwidth_nm      the same of a narrow source, or of a second instrument in series
    bandwidth_shape   as resolution_shape
    thickness_sd_nm   standard deviation of the thickness, nm: of the only layer, or one a layer, independent of each
                      other; a Gaussian, cut at 0                                              () or (layers,)
    tolerance         wanted error
    Returns           `Averaged`: value, and error: the last change of the rule, of which the error is a small part
    Raises            ValueError as for `reflectance`; ResourceError where the tolerance needs too many evaluations
    Source            Airy's series, Born & Wolf, Principles of Optics, sec. 7.6; harmonics of a Gaussian

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=3000.0), "air"])
    >>> seen = film.reflectance_averaged([545.0, 550.0], resolution_nm=2.0, thickness_sd_nm=15.0)
    >>> seen.value.round(6).tolist(), bool(seen.error.max() < 1e-9)
    ([0.060931, 0.073187], True)
    """
    return _averaged(
        self,
        "reflectance",
        (wavelength_nm, angle_deg, polarization),
        [("resolution", resolution_nm, resolution_shape), ("bandwidth", bandwidth_nm, bandwidth_shape)],
        thickness_sd_nm,
        tolerance,
    )


def transmittance_averaged(
    self: Multilayer,
    wavelength_nm: npt.ArrayLike,
    angle_deg: npt.ArrayLike = 0.0,
    polarization: str = "unpolarized",
    *,
    resolution_nm: float = 0.0,
    resolution_shape: str = "gaussian",
    bandwidth_nm: float = 0.0,
    bandwidth_shape: str = "gaussian",
    thickness_sd_nm: npt.ArrayLike = 0.0,
    tolerance: float = 1e-9,
) -> Averaged:
    """Transmittance as an instrument sees it; all else as for `reflectance_averaged`.

    In closed form <T> = T_0 / (1 - |q|^2) (1 + 2 Re sum_m D^(m^2) q^m).

    wavelength_nm, angle_deg, polarization  as for `transmittance`
    resolution_nm, resolution_shape, bandwidth_nm, bandwidth_shape, thickness_sd_nm, tolerance  as for
                      `reflectance_averaged`
    Returns           `Averaged` (value, error)
    Raises            ValueError, ResourceError as for `reflectance_averaged`

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer(1.5, thickness_nm=40000.0), "air"])
    >>> round(float(film.transmittance_averaged(550.0, resolution_nm=10.0).value), 9) == round(1 - 0.08 / 1.04, 9)
    True
    """
    return _averaged(
        self,
        "transmittance",
        (wavelength_nm, angle_deg, polarization),
        [("resolution", resolution_nm, resolution_shape), ("bandwidth", bandwidth_nm, bandwidth_shape)],
        thickness_sd_nm,
        tolerance,
    )


def _averaged(
    self: Multilayer,
    quantity: str,
    question: tuple[Any, Any, str],
    lines: list[tuple[str, float, str]],
    thickness_sd_nm: npt.ArrayLike,
    tolerance: float,
) -> Averaged:
    wavelength_nm, angle_deg, polarization = question
    polarization = one_of("polarization", polarization, ("s", "p", "unpolarized"))
    lines_nm = []
    for name, width_nm, form in lines:
        one_of(f"{name}_shape", form, SHAPES)
        width = number(f"{name}_nm", width_nm, low=0.0)
        if width > 0.0:
            lines_nm.append((form, width))
    accuracy = number("tolerance", tolerance, low=0.0, includes_low=False)
    sd = real_operand("thickness_sd_nm", thickness_sd_nm, low=0.0)
    count = len(self.layers)
    if sd.shape not in ((), (count,)) or (sd.shape == () and count != 1 and float(sd.values) > 0.0):
        raise refusal("thickness_sd_nm", f"one number a layer ({count} of them)", Words(f"shape {sd.shape}"))
    spreads = np.broadcast_to(sd.full(), (count,))
    for place in range(count):
        if spreads[place] > 0.0 and not self.layers[place].coherent:
            raise complaint(
                f"thickness_sd_nm of an incoherent slab must be 0 (layer {place + 1}), got {spreads[place]:g}; it has no phase",
                "thickness_sd_nm",
                "0 for an incoherent slab",
                float(spreads[place]),
                f"for layer {place + 1}",
            )
    shape, arguments = self._arguments(wavelength_nm, angle_deg)
    for medium in self.media:
        index_at(medium, arguments[0].values)
    wavelength, angle, *thickness = (np.broadcast_to(argument.full(), shape).reshape(-1) for argument in arguments)
    value, error = _core.stack_averaged(
        quantity,
        polarization,
        [medium._core for medium in self.media],
        [layer.coherent for layer in self.layers],
        lines_nm,
        spreads.tolist(),
        accuracy,
        np.ascontiguousarray(wavelength),
        np.ascontiguousarray(angle),
        np.ascontiguousarray(np.stack(thickness, axis=-1) if count else np.empty((wavelength.size, 0))),
    )
    if shape == ():
        return Averaged(float(value[0]), float(error[0]))
    return Averaged(value.reshape(shape), error.reshape(shape))


def layer_airy(
    stack: Multilayer, place: int, wavelength_nm: Floats, angle_deg: Floats, polarization: str, hold: bool = False
) -> npt.NDArray[np.complex128]:
    """r_above, t_above^2, r_inside, r_below, passed and kz of a layer: see `LayerAiry` of the core; a last axis of 6.

    ``hold``: media keep the ends of their data beyond them.
    """
    arguments = [
        Operand("wavelength_nm", wavelength_nm, wavelength_nm.shape),
        Operand("angle_deg", angle_deg, angle_deg.shape),
    ]
    arguments += stack._thicknesses()
    shape = broadcast_shape(arguments)
    out = np.empty((*shape, 6), dtype=np.complex128)
    flat = out.reshape(-1, 6)
    for which, elements in stack._elements(shape, arguments, hold=hold):
        _core.stack_layer_airy(polarization, *elements, place, flat[which])
    return out
