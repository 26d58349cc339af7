"""How what a stack does changes with its thicknesses and indices: methods of `iridesce.Stack`. Internal."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, new_array, scalar
from iridesce.arguments.scalars import one_of
from iridesce.optics.multilayer import Multilayer

POLARIZATIONS = ("s", "p", "unpolarized")
POWERS = ("reflectance", "transmittance", "absorptance")


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


def derivatives(
    self: Multilayer,
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
    quantity = one_of("quantity", quantity, (*POWERS, "psi", "delta"))
    polarization = one_of("polarization", polarization, POLARIZATIONS)
    is_power = quantity in POWERS
    if not is_power:
        self._must_be_coherent("derivatives of psi and delta")
    shape, arguments = self._arguments(wavelength_nm, angle_deg)
    layers, count = len(self.layers), math.prod(shape)
    new_array("the derivatives", (*shape, 3 * layers + 3))
    parts = [np.empty((count, *tail)) for tail in ((), (layers,), (layers + 1,), (layers + 1,), ())]
    at = 1 if quantity == "delta" else 0
    for which, elements in self._elements(shape, arguments):
        values, slopes = rows(self, quantity if is_power else "ellipsometry", polarization, elements)
        found = named(values[:, at], slopes.reshape(len(values), -1, 3 * layers + 3)[:, at], layers)
        for part, piece in zip(parts, found, strict=True):
            part[which] = piece
    value, thickness, n, k, n_first = (part.reshape((*shape, *part.shape[1:])) for part in parts)
    return Derivatives(scalar(value), thickness, n, k, scalar(n_first))


def rows(self: Multilayer, quantity: str, polarization: str, elements: tuple[Any, ...]) -> tuple[Floats, Floats]:
    """Values and slopes as the core gives them, a row an element."""
    indices, thickness_nm, wavelength_nm, angle_deg = elements
    width = 2 if quantity == "ellipsometry" else 1
    values = np.empty((wavelength_nm.size, width))
    slopes = np.empty((wavelength_nm.size, width * (3 * len(self.layers) + 3)))
    coherent = [layer.coherent for layer in self.layers]
    _core.stack_derivatives(
        quantity, polarization, indices, thickness_nm, coherent, wavelength_nm, angle_deg, values, slopes
    )
    return values, slopes


def named(value: Floats, rows: Floats, layers: int) -> Derivatives:
    """From rows of the core (thicknesses, n of all media, k of all but the first)."""
    return Derivatives(
        scalar(value),
        np.ascontiguousarray(rows[..., :layers]),
        np.ascontiguousarray(rows[..., layers + 1 : 2 * layers + 2]),
        np.ascontiguousarray(rows[..., 2 * layers + 2 :]),
        scalar(np.ascontiguousarray(rows[..., layers])),
    )
