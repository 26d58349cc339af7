"""Jones and Mueller matrices and the field inside: methods of `iridesce.Stack`. Internal."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, new_array, real_operand
from iridesce.arguments.refusals import Words, complaint, refusal, short
from iridesce.arguments.scalars import one_of
from iridesce.optics.multilayer import Multilayer

Complexes = npt.NDArray[np.complex128]

_DIRECTIONS = ("reflection", "transmission")


class FieldProfile(NamedTuple):
    """Fields against depth, for incident light whose electric field has modulus 1.

    depth_nm            depth below the first interface                                              (depths,)
    electric            E along x (in the plane of incidence), y (across it), z (into the stack)     (..., depths, 3)
    magnetic            H times the impedance of vacuum, along the same                              (..., depths, 3)
    flux                power that flows along z, relative to the incident one                       (..., depths)
    absorbed_per_nm     power absorbed per nm of depth, relative to the incident one                 (..., depths)
    """

    depth_nm: Floats
    electric: Complexes
    magnetic: Complexes
    flux: Floats
    absorbed_per_nm: Floats

    @property
    def squared(self) -> Floats:
        """|E|^2, relative to the incident one, (..., depths)."""
        return np.asarray((np.abs(self.electric) ** 2).sum(axis=-1))


def jones(
    self: Multilayer,
    wavelength_nm: npt.ArrayLike,
    angle_deg: npt.ArrayLike = 0.0,
    direction: str = "reflection",
) -> Complexes:
    """Jones matrix ((r_s, 0), (0, r_p)), or t: from the incident (E_s, E_p) to the leaving one.

    The frames are (s, p, direction of light), p = k x s, as in docs/reference/conventions.md: a mirror has r_p = -r_s at normal
    incidence. t is a ratio of electric fields; powers carry the factor of `transmittance`.

    wavelength_nm, angle_deg  as for `reflectance`
    direction      "reflection" or "transmission"
    Returns        complex128, broadcast shape + (2, 2)
    Raises         ValueError as for `amplitudes`, also for stacks with incoherent slabs (see `mueller`); ResourceError

    >>> import iridesce as ir
    >>> ir.Stack(["air", 1.5]).jones(550.0).real.round(12).tolist()
    [[-0.2, 0.0], [0.0, 0.2]]
    """
    which = _DIRECTIONS.index(one_of("direction", direction, _DIRECTIONS))
    s = np.asarray(self.amplitudes(wavelength_nm, angle_deg, "s")[which])
    p = np.asarray(self.amplitudes(wavelength_nm, angle_deg, "p")[which])
    matrix = new_array("jones", (*s.shape, 2, 2), np.complex128)
    matrix[...] = 0.0
    matrix[..., 0, 0], matrix[..., 1, 1] = s, p
    return matrix


def mueller(
    self: Multilayer,
    wavelength_nm: npt.ArrayLike,
    angle_deg: npt.ArrayLike = 0.0,
    direction: str = "reflection",
) -> Floats:
    """Mueller matrix: from the incident Stokes vector to the reflected or transmitted one, in power.

    I = |E_s|^2 + |E_p|^2, Q = |E_s|^2 - |E_p|^2, U + iV = 2 E_s conj(E_p), in the frames of docs/reference/conventions.md. With C
    the mean of r_s conj(r_p): M = ((m, d, 0, 0), (d, m, 0, 0), (0, 0, Re C, -Im C), (0, 0, Im C, Re C)), m and d half the sum
    and half the difference of the reflectances of s and p. Entry (0, 0) is the reflectance, or transmittance, of
    unpolarised light. Incoherent slabs depolarise: |C| < sqrt(R_s R_p).

    wavelength_nm, angle_deg  as for `reflectance`
    direction      "reflection" or "transmission"
    Returns        float64, broadcast shape + (4, 4)
    Raises         ValueError as for `reflectance`; ResourceError
    Source         docs/reference/theory.md, section 5; Born & Wolf, Principles of Optics, sec. 1.4 (Stokes parameters)

    >>> import iridesce as ir
    >>> ir.Stack(["air", 1.5]).mueller(550.0, 56.309932474).round(4)[:2, :2].tolist()
    [[0.074, 0.074], [0.074, 0.074]]
    """
    direction = one_of("direction", direction, _DIRECTIONS)
    shape, arguments = self._arguments(wavelength_nm, angle_deg)
    slabs = sum(not layer.coherent for layer in self.layers)
    if slabs > _core.MOST_SLABS:
        raise complaint(
            f"the Mueller matrix of a stack takes at most {_core.MOST_SLABS} incoherent slabs, got {slabs} in {short(self)}",
            "stack",
            f"one of at most {_core.MOST_SLABS} incoherent slabs",
            Words(slabs),
        )
    matrix: Floats = new_array("mueller", (*shape, 4, 4))
    out = matrix.reshape(-1, 16)
    coherent = [layer.coherent for layer in self.layers]
    for which, (indices, thickness_nm, wavelengths, angles) in self._elements(shape, arguments):
        _core.stack_mueller(direction, indices, thickness_nm, coherent, wavelengths, angles, out[which])
    return matrix


def field_profile(
    self: Multilayer,
    depth_nm: npt.ArrayLike,
    wavelength_nm: npt.ArrayLike,
    angle_deg: npt.ArrayLike = 0.0,
    polarization: str = "s",
) -> FieldProfile:
    """Electric and magnetic field, power flow and absorption against depth.

    d(flux)/dz = -k0 Im(n^2) |E|^2 / (n_first cos(theta)), which is ``absorbed_per_nm``: over a layer it adds up to
    `layer_absorptance`. x lies in the plane of incidence along the light, y across it, z into the stack; incident s light
    has E = (0, 1, 0), p light E = (-cos, 0, sin) at the first interface. An interface belongs to what lies below it.

    depth_nm       depth below the first interface; negative in the first medium, where incident and reflected light
                   cross                                                                               (depths,)
    wavelength_nm  vacuum wavelength, > 0                                                              (...,)
    angle_deg      incidence in the first medium, [0, 90)                                              (...,) broadcasts
    polarization   "s" or "p"
    Returns        `FieldProfile`: electric, magnetic (..., depths, 3) complex128; flux, absorbed_per_nm (..., depths)
    Raises         ValueError as for `amplitudes`: also for "unpolarized" and incoherent slabs; ResourceError

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer(0.06 + 3.6j, thickness_nm=20.0), 1.5])
    >>> inside = film.field_profile(np.linspace(0.0, 20.0, 2001)[:-1] + 0.005, 550.0)
    >>> bool(abs(0.01 * inside.absorbed_per_nm.sum() - film.layer_absorptance(550.0)[0]) < 1e-7)
    True
    """
    polarization = one_of("polarization", polarization, ("s", "p"))
    self._must_be_coherent("fields")
    depth = real_operand("depth_nm", depth_nm)
    if len(depth.shape) > 1:
        raise refusal("depth_nm", "one axis", Words(f"shape {depth.shape}"), must="have")
    depths = np.ascontiguousarray(depth.full().reshape(-1))
    shape, arguments = self._arguments(wavelength_nm, angle_deg)
    fields = new_array("field_profile", (*shape, depths.size, 6), np.complex128)
    power = new_array("field_profile", (*shape, depths.size, 2))
    rows = math.prod(shape)
    flat, flat_power = fields.reshape(rows, -1), power.reshape(rows, -1)
    for which, elements in self._elements(shape, arguments):
        _core.stack_fields(polarization, *elements, depths, flat[which], flat_power[which])
    return FieldProfile(depths, fields[..., :3], fields[..., 3:], power[..., 0], power[..., 1])
