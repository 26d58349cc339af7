"""How what a stack does changes with its thicknesses and indices: methods of `iridesce.Stack`. Internal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, broadcast_shape, new_array, one_of, place, real_operand

if TYPE_CHECKING:
    from iridesce.stack import Stack

_POLARIZATIONS = ("s", "p", "unpolarized")
_POWERS = ("reflectance", "transmittance", "absorptance")
# Elements a pass, so that a colour map of many points does not need all its spectra at once.
_PASS = 1 << 17


class Derivatives(NamedTuple):
    """A quantity and its derivatives; ``...`` is the broadcast shape, for colours with a last axis of 3.

    value           the quantity itself                                                                    (...)
    thickness_nm    with respect to each layer's thickness, per nm                                         (..., layers)
    n               with respect to n of each layer, then of the last medium                               (..., layers + 1)
    k               with respect to k of the same                                                          (..., layers + 1)
    n_first         with respect to n of the first medium (the angle in it stays)                          (...)
    """

    value: Any
    thickness_nm: Floats
    n: Floats
    k: Floats
    n_first: Any


class ColorUncertainty(NamedTuple):
    """A colour with its error bars.

    value           the colour                                         (..., 3)
    sd              standard deviation of each of its three values     (..., 3)
    covariance      of the three values                                (..., 3, 3)
    """

    value: Floats
    sd: Floats
    covariance: Floats


def derivatives(
    self: Stack,
    quantity: str,
    wavelength_nm: npt.ArrayLike,
    angle_deg: npt.ArrayLike = 0.0,
    polarization: str = "unpolarized",
) -> Derivatives:
    """Derivatives of R, T, A, psi or delta with respect to every thickness and every index, analytic.

    dr = 2 q / S^2 (h_top de - e_top dh), (de, dh) = dM (e, h)_bottom, for each layer matrix M, with the tangential fields
    (e, h) at its faces and S = q e + h at the first interface: one march up and one down serve all of them. Incoherent
    slabs are differentiated through their sums of powers.

    quantity       "reflectance", "transmittance", "absorptance", "psi" or "delta" (degrees)
    wavelength_nm  vacuum wavelength, > 0                          (...,)
    angle_deg      incidence in the first medium, [0, 90)          (...,) broadcasts
    polarization   "s", "p" or "unpolarized"; psi and delta take no notice of it
    Returns        `Derivatives` (value, thickness_nm, n, k, n_first): a layer that occurs twice has two entries, of which
                   the sum is the derivative with respect to what they share
    Raises         ValueError as for `reflectance`; also exactly at the critical angle of the last medium, and for psi
                   and delta of stacks with incoherent slabs or where a polarisation is not reflected; ResourceError
    Source         reciprocity of layer matrices of determinant 1; see docs/reference/theory.md

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=320.0), "air"])
    >>> slope = film.derivatives("reflectance", 550.0)
    >>> round(slope.value, 6), slope.thickness_nm.round(8).tolist()
    (0.075528, [-0.00031992])
    >>> near = ir.Stack(["air", ir.Layer(1.33, thickness_nm=[319.9, 320.1]), "air"]).reflectance(550.0)
    >>> round(float(np.diff(near)[0]) / 0.2, 8)
    -0.00031992
    """
    quantity = one_of("quantity", quantity, (*_POWERS, "psi", "delta"))
    polarization = one_of("polarization", polarization, _POLARIZATIONS)
    is_power = quantity in _POWERS
    if not is_power:
        self._must_be_coherent("derivatives of psi and delta")
    shape, arguments = self._arguments(wavelength_nm, angle_deg)
    parameters = 3 * len(self.layers) + 3
    width = 1 if is_power else 2
    new_array("the derivatives", (*shape, width * parameters))
    values, rows = _rows(self, quantity if is_power else "ellipsometry", polarization, self._elements(shape, arguments))
    at = 1 if quantity == "delta" else 0
    rows = rows.reshape(*shape, width, parameters)[..., at, :]
    return _named(values[:, at].reshape(shape), rows, len(self.layers))


def _rows(self: Stack, quantity: str, polarization: str, elements: tuple[Any, ...]) -> tuple[Floats, Floats]:
    indices, thickness_nm, wavelength_nm, angle_deg = elements
    width = 2 if quantity == "ellipsometry" else 1
    values = np.empty((wavelength_nm.size, width))
    rows = np.empty((wavelength_nm.size, width * (3 * len(self.layers) + 3)))
    coherent = [layer.coherent for layer in self.layers]
    _core.stack_derivatives(
        quantity, polarization, indices, thickness_nm, coherent, wavelength_nm, angle_deg, values, rows
    )
    return values, rows


def _named(value: Floats, rows: Floats, layers: int) -> Derivatives:
    """From rows of the core (thicknesses, n of all media, k of all but the first)."""
    first = rows[..., layers]
    scalar = value.ndim == 0
    return Derivatives(
        float(value) if scalar else value,
        np.ascontiguousarray(rows[..., :layers]),
        np.ascontiguousarray(rows[..., layers + 1 : 2 * layers + 2]),
        np.ascontiguousarray(rows[..., 2 * layers + 2 :]),
        float(first) if scalar else np.ascontiguousarray(first),
    )


def color_derivatives(
    self: Stack,
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
    # The colour stage comes after this one.
    from iridesce import color

    polarization = one_of("polarization", polarization, _POLARIZATIONS)
    quantity = one_of("quantity", quantity, _POWERS)
    angle = real_operand("angle_deg", angle_deg, low=0.0, high=90.0)
    shape = broadcast_shape([angle, *self._thicknesses()])
    value = self.color(
        angle.full(), polarization, illuminant, observer, space, quantity, "exact", wavelength_nm, adaptation
    )
    light = illuminant if isinstance(illuminant, color.Illuminant) else color.illuminant(illuminant)
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
            elements = self._elements((which.size, wavelengths.size), arguments, extended=True)
            powers, rows = _rows(self, quantity, polarization, elements)
            xyz[which] = powers.reshape(which.size, -1) @ weights
            slopes[which] = np.einsum("wc,pwd->pcd", weights, rows.reshape(which.size, wavelengths.size, -1))
    jacobian = _core.color_jacobian(xyz, space, white, adaptation).reshape(-1, 3, 3)
    if not np.isfinite(jacobian).all():
        wrong = int(np.argmin(np.isfinite(jacobian).all(axis=(1, 2))))
        where = place(np.unravel_index(wrong, shape)) if shape else ""
        raise ValueError(f'space="{space}" has no derivatives at the colour XYZ = {xyz[wrong].tolist()}{where}')
    rows = np.einsum("pij,pjd->pid", jacobian, slopes).reshape(*shape, 3, -1)
    return _named(value, rows, len(self.layers))


def _parts(self: Stack, points: list[Floats]) -> npt.NDArray[np.int64]:
    """Into how many parts the colour sum divides its 1 nm steps: powers of two, 2 n t cos(theta) step / lambda^2 <= 1/4."""
    wavelengths = np.arange(360.0, 831.0)
    n = [np.broadcast_to(medium._core.index_extended(wavelengths)[0], wavelengths.shape) for medium in self.media]
    angle_deg, *thickness_nm = points
    across = np.multiply.outer(np.sin(np.radians(angle_deg)) ** 2, n[0].real ** 2)
    fringe = np.zeros(angle_deg.size)
    for layer, index, thickness in zip(self.layers, n[1:-1], thickness_nm, strict=True):
        if layer.coherent:
            path = np.abs(np.sqrt(index**2 - across + 0j).real)
            fringe += thickness * (2.0 * path / wavelengths**2).max(axis=1)
    halvings = np.ceil(np.log2(np.maximum(fringe / 0.25, 1.0)))
    return np.asarray(2 ** np.minimum(halvings, 12).astype(np.int64))


def color_uncertainty(
    self: Stack,
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
        raise ValueError(
            f"thickness_sd_nm must be one number or one a layer ({len(self.layers)}), got shape {sd.shape}"
        )
    slopes = color_derivatives(self, angle_deg, polarization, illuminant, observer, space, quantity)
    scaled = slopes.thickness_nm * sd.full()
    covariance = np.einsum("...id,...jd->...ij", scaled, scaled)
    deviation = np.sqrt(np.einsum("...ii->...i", covariance))
    return ColorUncertainty(slopes.value, deviation, covariance)
