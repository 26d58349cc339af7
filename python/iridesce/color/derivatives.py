"""How the colour of a stack changes with its thicknesses and indices: methods of `iridesce.Stack`. Internal."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce._notebook import rows_html
from iridesce.arguments.operands import Floats, broadcast_shape, place, real_operand
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import one_of
from iridesce.color.films import stack_color
from iridesce.color.light import Illuminant
from iridesce.color.light import illuminant as named_illuminant
from iridesce.optics.derivatives import POLARIZATIONS, POWERS, Derivatives, named, rows
from iridesce.optics.multilayer import Multilayer

# Elements a pass, so that a colour map of many points does not need all its spectra at once.
_PASS = 1 << 17


class ColorUncertainty(NamedTuple):
    """A colour with its error bars.

    value           the colour                                         (..., 3)
    sd              standard deviation of each of its three values     (..., 3)
    covariance      of the three values                                (..., 3, 3)
    """

    value: Floats
    sd: Floats
    covariance: Floats

    def __repr__(self) -> str:
        if self.value.ndim > 1:
            return f"<iridesce.ColorUncertainty of shape {self.value.shape}>"
        shown = ", ".join(f"{value:.6g} +- {sd:.2g}" for value, sd in zip(self.value, self.sd, strict=True))
        return f"<iridesce.ColorUncertainty {shown}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: each colour with its error bars."""
        values, spreads = self.value.reshape(-1, 3), self.sd.reshape(-1, 3)
        rows = [
            [str(number), *(f"{value:.4g} \u00b1 {sd:.2g}" for value, sd in zip(one, spread, strict=True))]
            for number, (one, spread) in enumerate(zip(values, spreads, strict=True))
        ]
        return rows_html(("", "1", "2", "3"), rows, 60)


def color_derivatives(
    self: Multilayer,
    angle_deg: npt.ArrayLike = 0.0,
    polarization: str = "unpolarized",
    illuminant: Any = "D65",
    observer: str = "cie1931",
    space: str = "xyz",
    quantity: str = "reflectance",
    wavelength_nm: npt.ArrayLike | None = None,
    adaptation: str | None = None,
) -> Derivatives:
    """Derivatives of the colour with respect to every thickness and every index, analytic.

    dX = sum(S xbar dR) / sum(S ybar), then the derivatives of the colour space. An index changes by the same amount at
    every wavelength.

    angle_deg, polarization, illuminant, observer, space, quantity, wavelength_nm, adaptation  as for `color`
    Returns        `Derivatives`; value (..., 3), thickness_nm (..., 3, layers), n and k (..., 3, layers + 1),
                   n_first (..., 3); L, a, b a nm, hue in degrees a nm
    Raises         ValueError as for `color`; also where the space has no derivative: xyY and Oklab of black, the hue of
                   a grey

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=320.0), "air"])
    >>> film.color_derivatives(space="lab").thickness_nm[:, 0].round(4).tolist()
    [-0.0599, 0.3891, 0.7637]
    """
    polarization = one_of("polarization", polarization, POLARIZATIONS)
    quantity = one_of("quantity", quantity, POWERS)
    angle = real_operand("angle_deg", angle_deg, low=0.0, high=90.0)
    shape = broadcast_shape([angle, *self._thicknesses()])
    value = stack_color(
        self, angle.full(), polarization, illuminant, observer, space, quantity, "exact", wavelength_nm, adaptation
    )
    light = illuminant if isinstance(illuminant, Illuminant) else named_illuminant(illuminant)
    points = [np.broadcast_to(one.full(), shape).reshape(-1) for one in (angle, *self._thicknesses())]
    grid = None if wavelength_nm is None else np.asarray(wavelength_nm, dtype=np.float64)
    parts = np.ones(points[0].size, dtype=int) if grid is not None else _parts(self, points)
    slopes = np.empty((points[0].size, 3, 3 * len(self.layers) + 3))
    xyz = np.empty((points[0].size, 3))
    white = (1.0, 1.0, 1.0)
    for part in np.unique(parts):
        wavelengths, weights, white, _ = _core.color_weights(light._core, observer, grid, int(part))
        chosen = np.flatnonzero(parts == part)
        step = max(1, _PASS // wavelengths.size)
        for start in range(0, chosen.size, step):
            which = chosen[start : start + step]
            arguments = [
                real_operand("wavelength_nm", wavelengths),
                *(real_operand("point", one[which, None]) for one in points),
            ]
            parted = [
                rows(self, quantity, polarization, elements)
                for _, elements in self._elements((which.size, wavelengths.size), arguments, extended=True)
            ]
            powers, sloping = (np.concatenate(some) for some in zip(*parted, strict=True))
            xyz[which] = powers.reshape(which.size, -1) @ weights
            slopes[which] = np.einsum("wc,pwd->pcd", weights, sloping.reshape(which.size, wavelengths.size, -1))
    jacobian = _core.color_jacobian(xyz, space, white, adaptation).reshape(-1, 3, 3)
    if not np.isfinite(jacobian).all():
        wrong = int(np.argmin(np.isfinite(jacobian).all(axis=(1, 2))))
        where = place(np.unravel_index(wrong, shape)) if shape else ""
        raise complaint(
            f'space="{space}" has no derivatives at the colour XYZ = {xyz[wrong].tolist()}{where}',
            "space",
            "one with derivatives at every colour of the film",
            space,
            where,
        )
    turned = np.einsum("pij,pjd->pid", jacobian, slopes).reshape(*shape, 3, -1)
    return named(value, turned, len(self.layers))


def _parts(self: Multilayer, points: list[Floats]) -> npt.NDArray[np.int64]:
    """Into how many parts the colour sum divides its 1 nm steps at each point (angle, then thicknesses)."""
    angle_deg, *thickness_nm = points
    columns = np.stack(thickness_nm, axis=-1) if thickness_nm else np.empty((angle_deg.size, 0))
    media, coherent = [medium._core for medium in self.media], [layer.coherent for layer in self.layers]
    parts = _core.color_parts(media, coherent, np.ascontiguousarray(columns), np.ascontiguousarray(angle_deg))
    return np.asarray(parts, dtype=np.int64)


def color_uncertainty(
    self: Multilayer,
    thickness_sd_nm: npt.ArrayLike,
    angle_deg: npt.ArrayLike = 0.0,
    polarization: str = "unpolarized",
    illuminant: Any = "D65",
    observer: str = "cie1931",
    space: str = "lab",
    quantity: str = "reflectance",
) -> ColorUncertainty:
    """Error bars of a colour whose thicknesses are known with an error, to first order.

    covariance = J diag(sd^2) J^T, with J the derivatives of the colour with respect to the thicknesses, whose errors are
    taken as independent. First order: good while the colour runs straight over the error, some nm for a soap film.

    thickness_sd_nm  standard deviation of the thickness, nm, >= 0: one for all layers, or one a layer   () or (layers,)
    angle_deg, polarization, illuminant, observer, space, quantity  as for `color`
    Returns        `ColorUncertainty` (value, sd, covariance)
    Raises         ValueError as for `color_derivatives`

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=320.0), "air"])
    >>> film.color_uncertainty(2.0).sd.round(2).tolist()
    [0.12, 0.78, 1.53]
    """
    sd = real_operand("thickness_sd_nm", thickness_sd_nm, low=0.0)
    if sd.shape not in ((), (len(self.layers),)):
        raise refusal("thickness_sd_nm", f"one number or one a layer ({len(self.layers)})", Words(f"shape {sd.shape}"))
    slopes = color_derivatives(self, angle_deg, polarization, illuminant, observer, space, quantity)
    scaled = slopes.thickness_nm * sd.full()
    covariance = np.einsum("...id,...jd->...ij", scaled, scaled)
    deviation = np.sqrt(np.einsum("...ii->...i", covariance))
    return ColorUncertainty(slopes.value, deviation, covariance)
