"""Jones and Mueller matrices and the field inside: methods of `iridesce.Stack`. Internal."""

from __future__ import annotations

from itertools import product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, new_array, real_operand
from iridesce.arguments.scalars import one_of
from iridesce.optics.layer import Layer
from iridesce.optics.multilayer import Multilayer

Complexes = npt.NDArray[np.complex128]

_DIRECTIONS = ("reflection", "transmission")
# Phases over which an incoherent slab is averaged: doubled until nothing changes any more.
_FEWEST_PHASES, _MOST_PHASES, _SAME = 8, 512, 1e-13


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
    which = _DIRECTIONS.index(one_of("direction", direction, _DIRECTIONS))
    power = self.transmittance if which else self.reflectance
    s, p = (np.asarray(power(wavelength_nm, angle_deg, polarization)) for polarization in ("s", "p"))
    cross = _cross(self, wavelength_nm, angle_deg, which)
    matrix: Floats = new_array("mueller", (*s.shape, 4, 4))
    matrix[...] = 0.0
    matrix[..., 0, 0] = matrix[..., 1, 1] = 0.5 * (s + p)
    matrix[..., 0, 1] = matrix[..., 1, 0] = 0.5 * (s - p)
    matrix[..., 2, 2] = matrix[..., 3, 3] = cross.real
    matrix[..., 3, 2] = cross.imag
    matrix[..., 2, 3] = -cross.imag
    return matrix


def _cross(self: Multilayer, wavelength_nm: npt.ArrayLike, angle_deg: npt.ArrayLike, which: int) -> Complexes:
    """The mean of a_s conj(a_p) over the phases of incoherent slabs; in transmission times the ratio of fluxes."""
    slabs = [place for place, layer in enumerate(self.layers) if not layer.coherent]
    if not slabs:
        return _coherent_cross(self, wavelength_nm, angle_deg, which)
    if len(slabs) > 2:
        raise ValueError(
            f"the Mueller matrix of a stack takes at most 2 incoherent slabs, got {len(slabs)} in {self!r}"
        )
    phases = _FEWEST_PHASES
    last = _phase_mean(self, slabs, phases, wavelength_nm, angle_deg, which)
    while phases < (_MOST_PHASES if len(slabs) == 1 else 64):
        phases *= 2
        mean = _phase_mean(self, slabs, phases, wavelength_nm, angle_deg, which)
        if np.max(np.abs(mean - last), initial=0.0) < _SAME:
            return mean
        last = mean
    return last


def _phase_mean(
    self: Multilayer, slabs: list[int], phases: int, wavelength_nm: npt.ArrayLike, angle_deg: npt.ArrayLike, which: int
) -> Complexes:
    """Exact but for terms of order (r r')^phases: the function is periodic in each phase."""
    wavelength, angle = np.asarray(wavelength_nm, dtype=float), np.asarray(angle_deg, dtype=float)
    first = np.asarray(self.first.index(wavelength)).real
    turns = []
    for slab in slabs:
        index = np.asarray(self.layers[slab].medium.index(wavelength))
        kz = np.sqrt(index**2 - (first * np.sin(np.radians(angle))) ** 2 + 0j)
        k0_d = 2.0 * np.pi * np.asarray(self.layers[slab].thickness_nm) / wavelength
        turns.append(np.where(_averages(index, kz, k0_d), wavelength / (2.0 * np.maximum(kz.real, 1e-30)), 0.0))
    total: Any = 0.0
    for shifts in product(range(phases), repeat=len(slabs)):
        layers = list(self.layers)
        for slab, turn, shift in zip(slabs, turns, shifts, strict=True):
            layers[slab] = Layer(layers[slab].medium, layers[slab].thickness_nm + turn * (shift / phases))
        for place, layer in enumerate(layers):
            layers[place] = Layer(layer.medium, layer.thickness_nm)
        moved = Multilayer([self.first, *layers, self.last])
        total = total + _coherent_cross(moved, wavelength, angle, which)
    return np.asarray(total / phases ** len(slabs))


def _averages(index: Any, kz: Any, k0_d: Any) -> Any:
    """Whether a slab has a phase to average; the rule of the solver (`averages` in crates/optics/src/stack/slabs.rs)."""
    of_kz, of_n = np.angle(kz), np.angle(index)
    theta = np.maximum(np.abs(of_kz), np.abs(2.0 * of_n - of_kz))
    growth = np.arcsinh(np.tan(np.minimum(theta, 1.5707)))
    passive = (index.imag <= 0.0) | ((theta < 0.5 * np.pi) & (growth <= kz.imag * k0_d))
    return (np.abs(kz.imag) < np.abs(kz.real)) & passive


def _coherent_cross(self: Multilayer, wavelength_nm: npt.ArrayLike, angle_deg: npt.ArrayLike, which: int) -> Complexes:
    s = np.asarray(self.amplitudes(wavelength_nm, angle_deg, "s")[which])
    p = np.asarray(self.amplitudes(wavelength_nm, angle_deg, "p")[which])
    if which == 0:
        return np.asarray(s * p.conj())
    # The flux of a wave with s and p is not the product of amplitudes alone: sqrt(T_s T_p) with its phase.
    sizes = [np.asarray(self.transmittance(wavelength_nm, angle_deg, polarization)) for polarization in ("s", "p")]
    both = np.abs(s) * np.abs(p)
    turned = np.where(both > 0.0, s * p.conj() / np.where(both > 0.0, both, 1.0), 1.0)
    return np.asarray(np.sqrt(sizes[0] * sizes[1]) * turned)


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
        raise ValueError(f"depth_nm must have one axis, got shape {depth.shape}")
    depths = np.ascontiguousarray(depth.full().reshape(-1))
    shape, arguments = self._arguments(wavelength_nm, angle_deg)
    fields = new_array("field_profile", (*shape, depths.size, 6), np.complex128)
    power = new_array("field_profile", (*shape, depths.size, 2))
    rows = int(np.prod(shape))
    _core.stack_fields(
        polarization,
        *self._elements(shape, arguments),
        depths,
        fields.reshape(rows, -1),
        power.reshape(rows, -1),
    )
    return FieldProfile(depths, fields[..., :3], fields[..., 3:], power[..., 0], power[..., 1])
