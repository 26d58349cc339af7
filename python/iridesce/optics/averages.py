"""Partial coherence: averages over the width of a spectral line and the spread of a thickness. Internal."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, Operand, broadcast_shape, real_operand
from iridesce.arguments.scalars import number, one_of
from iridesce.errors import ResourceError
from iridesce.optics.layer import Layer
from iridesce.optics.multilayer import Multilayer

SHAPES = ("gaussian", "rectangle", "triangle")
FWHM = math.sqrt(8.0 * math.log(2.0))
"""Full width at half maximum of a Gaussian over its standard deviation."""

_TAIL = 7.0  # standard deviations: 2.6e-12 of a Gaussian lies beyond, and the weights are normalised
_FEWEST, _MOST = 16, 4096  # nodes of a rule
_EVALUATIONS = 1 << 28
_PASS = 1 << 20
# A Gaussian of thicknesses is cut at 0; from this many standard deviations on nothing is cut, and the series is exact.
_CLEAR_OF_ZERO = 6.0

Rule = Callable[[int], tuple[Floats, Floats]]


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
    rules = []
    for name, width_nm, form in lines:
        one_of(f"{name}_shape", form, SHAPES)
        width = number(f"{name}_nm", width_nm, low=0.0)
        if width > 0.0:
            rules.append(line_rule(form, width))
    accuracy = number("tolerance", tolerance, low=0.0, includes_low=False)
    sd = real_operand("thickness_sd_nm", thickness_sd_nm, low=0.0)
    count = len(self.layers)
    if sd.shape not in ((), (count,)) or (sd.shape == () and count != 1 and float(sd.values) > 0.0):
        raise ValueError(f"thickness_sd_nm must be one number a layer ({count} of them), got shape {sd.shape}")
    spreads = np.broadcast_to(sd.full(), (count,))
    shape, arguments = self._arguments(wavelength_nm, angle_deg)
    uneven = [place for place in range(count) if spreads[place] > 0.0]
    for place in uneven:
        if not self.layers[place].coherent:
            raise ValueError(f"thickness_sd_nm of an incoherent slab must be 0 (layer {place + 1}); it has no phase")
    flat = [np.broadcast_to(argument.full(), shape).reshape(-1) for argument in arguments]
    problem = _Problem(self, quantity, polarization, flat, spreads, uneven)
    value, error = problem.solve(rules, accuracy)
    if shape == ():
        return Averaged(float(value[0]), float(error[0]))
    return Averaged(value.reshape(shape), error.reshape(shape))


def line_rule(shape: str, fwhm: float) -> Rule:
    """Nodes (offsets, in the unit of the width) and weights of an average over a line, for a number of nodes."""
    if shape == "gaussian":
        sd = fwhm / FWHM
        return lambda count: _scaled(count, -_TAIL * sd, _TAIL * sd, lambda x: np.exp(-0.5 * (x / sd) ** 2))
    if shape == "rectangle":
        return lambda count: _scaled(count, -0.5 * fwhm, 0.5 * fwhm, lambda x: np.ones_like(x))
    return lambda count: _joined(
        _scaled(count, -fwhm, 0.0, lambda x: 1.0 + x / fwhm), _scaled(count, 0.0, fwhm, lambda x: 1.0 - x / fwhm)
    )


@functools.lru_cache(maxsize=16)
def _legendre(count: int) -> tuple[Floats, Floats]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return np.asarray(nodes), np.asarray(weights)


def _plain(count: int) -> tuple[Floats, Floats]:
    """Nodes on (0, 1)."""
    return _scaled(count, 0.0, 1.0, lambda x: np.ones_like(x))


def _scaled(count: int, low: float, high: float, density: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
    nodes, weights = _legendre(count)
    x = low + 0.5 * (high - low) * (nodes + 1.0)
    weighted = weights * density(x)
    return x, weighted / weighted.sum()


def _joined(first: tuple[Floats, Floats], second: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    return np.concatenate([first[0], second[0]]), 0.5 * np.concatenate([first[1], second[1]])


class _Problem:
    """One stack over a flat list of points."""

    def __init__(
        self,
        stack: Multilayer,
        quantity: str,
        polarization: str,
        flat: list[Floats],
        spreads: Floats,
        uneven: list[int],
    ) -> None:
        self.stack, self.quantity, self.polarization = stack, quantity, polarization
        self.wavelength_nm, self.angle_deg, *self.thickness_nm = flat
        self.spreads, self.uneven = spreads, uneven
        self.in_series = self._has_series()

    def _has_series(self) -> bool:
        """Whether the one uneven layer is clear, in a coherent stack, and thick enough that no Gaussian is cut at 0."""
        if len(self.uneven) != 1 or not all(layer.coherent for layer in self.stack.layers):
            return False
        place = self.uneven[0]
        medium = self.stack.layers[place].medium
        index = np.asarray(medium.index(self.wavelength_nm, extrapolate="hold"))
        first = np.asarray(self.stack.first.index(self.wavelength_nm, extrapolate="hold")).real
        travels = index.real > first * np.sin(np.radians(self.angle_deg))
        thick = self.thickness_nm[place] >= _CLEAR_OF_ZERO * self.spreads[place]
        return bool(np.all((index.imag == 0.0) & travels & thick))

    def solve(self, rules: list[Rule], tolerance: float) -> tuple[Floats, Floats]:
        lines = len(rules)
        rules = [*rules, *([] if self.in_series else [_plain] * len(self.uneven))]
        if not rules:
            exact = self.at(self.wavelength_nm, {})
            return exact, np.full_like(exact, 1e-13)
        nodes = _FEWEST
        last = self._sum(rules, lines, nodes)
        while True:
            nodes *= 2
            points = self.wavelength_nm.size * nodes ** len(rules)
            if nodes > _MOST or points > _EVALUATIONS:
                raise ResourceError(
                    f"the average needs more than {nodes // 2} nodes a variable to reach tolerance={tolerance:g}; "
                    "give a larger tolerance or fewer points"
                )
            value = self._sum(rules, lines, nodes)
            error = np.abs(value - last)
            if error.max(initial=0.0) <= tolerance:
                return value, np.maximum(error, 1e-13)
            last = value

    def _sum(self, rules: list[Rule], lines: int, count: int) -> Floats:
        """The tensor product of the rules, worked through in passes that fit in memory."""
        made = [rule(count) for rule in rules]
        offsets = [mesh.reshape(-1) for mesh in np.meshgrid(*(nodes for nodes, _ in made), indexing="ij")]
        weights = np.prod(np.meshgrid(*(weights for _, weights in made), indexing="ij"), axis=0).reshape(-1)
        shifts = sum(offsets[:lines]) if lines else np.zeros_like(weights)
        total = np.zeros_like(self.wavelength_nm)
        norm = np.zeros_like(self.wavelength_nm)
        step = max(1, _PASS // max(1, self.wavelength_nm.size))
        for start in range(0, weights.size, step):
            part = slice(start, start + step)
            wavelength = self.wavelength_nm + np.reshape(np.asarray(shifts)[part], (-1, 1))
            if wavelength.min(initial=1.0) <= 0.0:
                raise ValueError("the line is wider than its wavelength: it reaches below 0 nm")
            thickness: dict[int, Floats] = {}
            weight = np.broadcast_to(weights[part, None], wavelength.shape)
            if not self.in_series:
                for place, share in zip(self.uneven, offsets[lines:], strict=True):
                    # From 0 or the lower tail to the upper tail: a rule over both sides of the cut would not converge.
                    sd, middle = float(self.spreads[place]), self.thickness_nm[place]
                    low = np.maximum(-_TAIL * sd, -middle)
                    offset = low + (_TAIL * sd - low) * share[part, None]
                    weight = weight * np.exp(-0.5 * (offset / sd) ** 2)
                    thickness[place] = np.maximum(middle + offset, 0.0)
            values = self.at(wavelength, thickness)
            total += (weight * values).sum(axis=0)
            norm += weight.sum(axis=0)
        return np.asarray(total / norm)

    def at(self, wavelength_nm: Floats, thickness: dict[int, Floats]) -> Floats:
        """The quantity at wavelengths (..., points), one of the thicknesses perhaps averaged by its series."""
        layers = [
            Layer(layer.medium, thickness.get(place, self.thickness_nm[place]), layer.coherent)
            for place, layer in enumerate(self.stack.layers)
        ]
        stack = Multilayer([self.stack.first, *layers, self.stack.last])
        if not self.in_series:
            found = getattr(stack, self.quantity)(wavelength_nm, self.angle_deg, self.polarization)
            return np.asarray(found)
        place = self.uneven[0]
        return series(
            stack, place, float(self.spreads[place]), self.quantity, wavelength_nm, self.angle_deg, self.polarization
        )


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
    indices, thickness_nm, wavelengths, angles = stack._elements(shape, arguments, hold=hold)
    _core.stack_layer_airy(polarization, indices, thickness_nm, wavelengths, angles, place, out.reshape(-1, 6))
    return out


def series(
    stack: Multilayer,
    place: int,
    sd_nm: float,
    quantity: str,
    wavelength_nm: Floats,
    angle_deg: Floats,
    polarization: str,
) -> Floats:
    """The average over a Gaussian thickness of one clear layer, in closed form."""
    if polarization == "unpolarized":
        parts = [series(stack, place, sd_nm, quantity, wavelength_nm, angle_deg, one) for one in ("s", "p")]
        return np.asarray(0.5 * (parts[0] + parts[1]))
    airy = layer_airy(stack, place, wavelength_nm, angle_deg, polarization)
    per_nm = 4.0 * np.pi * airy[..., 5].real / wavelength_nm
    turn = np.exp(1j * per_nm * stack.layers[place].thickness_nm)
    return damped(airy, turn, 0.5 * (per_nm * sd_nm) ** 2, quantity)


def damped(
    airy: npt.NDArray[np.complex128], turn: npt.NDArray[np.complex128], damping: Floats, quantity: str
) -> Floats:
    """R or T of a layer whose round trip is ``turn``, its m-th harmonic times exp(-m^2 damping)."""
    r_above, t_squared, r_inside, r_below, passed, _ = np.moveaxis(airy, -1, 0)
    q = r_inside * r_below * turn
    size = np.abs(q) ** 2
    head = t_squared * r_below * turn
    if quantity == "transmittance":
        base = passed.real * np.abs(turn) / (1.0 - size)
        factor = base * q
    else:
        base = np.abs(r_above) ** 2 + np.abs(head) ** 2 / (1.0 - size)
        factor = r_above.conj() * head + np.abs(head) ** 2 * q / (1.0 - size)
    total = base.copy()
    largest, power = float(np.sqrt(size.max(initial=0.0))), np.ones_like(q)
    weakest = float(np.min(damping, initial=np.inf))
    for order in range(1, 100_000):
        total += 2.0 * np.exp(-(order**2) * damping) * (factor * power).real
        # The next term, and all after it, are below the last digit.
        if largest**order * math.exp(-min((order + 1) ** 2 * weakest, 700.0)) < 1e-17 * (1.0 - largest):
            break
        power = power * q
    return np.asarray(total)
