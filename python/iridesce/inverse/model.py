"""Models of a measured spectrum: what a stack with unknown thicknesses looks like through a spectrometer. Internal.

A model takes parameters (thicknesses in nm, then index parameters, then the variance of the instrument's line in nm^2) and gives
the spectrum and its analytic derivatives. Gain and baseline are linear and belong to the solver.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint, refusal, within
from iridesce.optics.averages import layer_airy
from iridesce.optics.layer import check_one_thickness
from iridesce.optics.medium import Medium
from iridesce.optics.stack_text import parse_items
from iridesce.stack import Layer, Stack

Complexes = npt.NDArray[np.complex128]

INDEX_MODELS = ("constant", "cauchy")
# A line narrower than this (sd, nm) is a point; its square is where derivatives with respect to the variance are taken.
_POINT_NM = 0.002
# Harmonics below this share of the reflectance are left out.
_FAINTEST = 1e-10


@dataclass(frozen=True)
class Problem:
    """What is asked: a stack, which of its layers (0 is the first) have unknown thickness, and how light meets it."""

    stack: Stack
    unknown: tuple[int, ...]
    quantity: str
    angle_deg: float
    polarization: str
    index: tuple[str | None, ...]
    """For each unknown layer: None, or the model of its index."""

    def with_thickness(self, thickness_nm: Any) -> Stack:
        """The stack with the unknown thicknesses filled in; they may be arrays."""
        layers = list(self.stack.layers)
        for place, value in zip(self.unknown, thickness_nm, strict=True):
            layers[place] = Layer(layers[place].medium, value, layers[place].coherent)
        return Stack([self.stack.first, *layers, self.stack.last])

    @property
    def index_count(self) -> int:
        """Number of index parameters."""
        return sum({None: 0, "constant": 1, "cauchy": 2}[model] for model in self.index)


class Model(Protocol):
    """A spectrum that depends on parameters."""

    def value(self, parameters: Floats) -> Floats:
        """The spectrum, (wavelengths,)."""

    def both(self, parameters: Floats, sharp: bool = False) -> tuple[Floats, Floats]:
        """The spectrum and its derivatives, (wavelengths,) and (wavelengths, parameters).

        ``sharp``: the derivative with respect to the variance is not needed and may be left 0.
        """


# --- reading the stack


def read_problem(stack: Any, layer: Any, index: Any, quantity: str, angle_deg: float, polarization: str) -> Problem:
    """A stack as text with ``?``, as a `Stack`, or as a list whose layers may be bare media."""
    made, unknown = _read_stack(stack, layer)
    for place in unknown:
        if not made.layers[place].coherent:
            raise complaint(
                f"layer {place + 1} is incoherent: it has no fringes that could tell its thickness",
                "layer",
                "a coherent layer",
                Words(place + 1),
            )
    check_one_thickness(made.layers, "a fit")
    return Problem(made, unknown, quantity, angle_deg, polarization, _read_index(index, made, unknown))


def _read_stack(stack: Any, layer: Any) -> tuple[Stack, tuple[int, ...]]:
    open_places: list[int] = []
    if isinstance(stack, str):
        first, *middle, last = parse_items(stack, open_layers=True)
        layers = []
        for place, item in enumerate(middle):
            try:
                layers.append(Layer(item.medium, item.thickness_nm, item.coherent))
            except ValueError as error:
                raise within(item.where, error) from None
            open_places += [place] if item.is_open else []
        made = Stack([first.medium, *layers, last.medium])
    elif isinstance(stack, Stack):
        made = stack
    elif isinstance(stack, list | tuple) and len(stack) >= 2:
        items = list(stack)
        for place in range(1, len(items) - 1):
            if not isinstance(items[place], Layer):
                items[place] = Layer(items[place], 0.0)
                open_places.append(place - 1)
        made = Stack(items)
    else:
        raise refusal("stack", "an iridesce.Stack, a list, or text like 'air / soap ? / air'", stack)
    if layer is None:
        places = open_places or [place for place, one in enumerate(made.layers) if one.coherent]
        if not made.layers:
            raise complaint(
                f"the stack has no layer whose thickness could be found: {made!r}",
                "stack",
                "a stack with a layer",
                made,
            )
        if not open_places and len(places) != 1:
            raise complaint(
                f"the stack has {len(places)} coherent layers: say which thickness is unknown, by layer=1 to "
                f"{len(made.layers)} (or several: [1, 2]), or in text by '?'",
                "layer",
                f"1 to {len(made.layers)}, or several of them",
                None,
            )
        return made, tuple(places)
    named = list(layer) if np.iterable(layer) and not isinstance(layer, str) else [layer]
    places = [_place(one, made) for one in named]
    if not places or len(set(places)) != len(places):
        raise refusal("layer", "one or more different layers", layer, must="name")
    missing = [place + 1 for place in open_places if place not in places]
    if missing:
        raise complaint(
            f"layer {missing[0]} has no thickness and is not among the unknown ones, layer={layer!r}",
            "layer",
            f"all that have no thickness, {missing[0]} among them",
            layer,
        )
    return made, tuple(sorted(places))


def _place(layer: Any, stack: Stack, argument: str = "layer", by: str = "") -> int:
    if isinstance(layer, str):
        found = [place for place, one in enumerate(stack.layers) if one.medium.name == layer]
        if len(found) == 1:
            return found[0]
    elif isinstance(layer, int | np.integer) and not isinstance(layer, bool) and 1 <= layer <= len(stack.layers):
        return int(layer) - 1
    names = ", ".join(one.medium.name for one in stack.layers)
    raise refusal(argument, f"{by}1 to {len(stack.layers)} or the name of one of the layers {names}", layer)


def _read_index(index: Any, stack: Stack, unknown: tuple[int, ...]) -> tuple[str | None, ...]:
    if index is None or isinstance(index, str):
        models: list[Any] = [index] * len(unknown)
    elif isinstance(index, dict):
        places = {_place(layer, stack, "index", "by layer: "): model for layer, model in index.items()}
        if not set(places) <= set(unknown):
            raise complaint(
                f"index names a layer whose thickness is not unknown, got {index!r}",
                "index",
                "of layers whose thickness is unknown",
                index,
            )
        models = [places.get(place) for place in unknown]
    else:
        raise refusal("index", 'None, "constant", "cauchy" or a dict of these by layer', index)
    for model in models:
        if model is not None and model not in INDEX_MODELS:
            raise refusal("index", 'None, "constant" or "cauchy"', model)
    return tuple(models)


def describe(problem: Problem) -> str:
    """The stack as text, unknown thicknesses as ``?``."""
    words = [problem.stack.first.name]
    for place, layer in enumerate(problem.stack.layers):
        thickness = "?" if place in problem.unknown else f"{float(layer.thickness_nm):g}"
        words.append(f"{layer.medium.name} {thickness}" + ("" if layer.coherent else " incoherent"))
    return re.sub(r"\s+", " ", " / ".join([*words, problem.stack.last.name]))


# --- one clear layer: harmonics of its round trip


class Harmonics(NamedTuple):
    """R or T of a layer of thickness d: base + 2 Re sum_m c_m exp(i m rate d), and how all of it changes with wavelength.

    Seen through a line of variance v, with s = m d rate' (phase a nm of wavelength), each harmonic becomes

        (c + i s v c') exp(i m rate d) exp(-s^2 v/2) exp(i m d rate'' v (1 - s^2 v)/2)

    to second order of the phase and first of the amplitude over the line: good to 1e-4 of the fringes for lines of 3 nm.
    """

    base: Floats
    c: Complexes
    """(harmonics, wavelengths)"""
    c_slope: Complexes
    rate: Floats
    """Phase of a round trip, radians a nm."""
    rate_slope: Floats
    rate_curve: Floats


def uneven(of: Harmonics, wavelength_nm: Floats) -> Harmonics:
    """The same film, its fringes paled by a thickness that differs over the spot: by a line that grows with the wavelength.

    Phases m rate d spread by their own share, not by their slope: for a spread of s, relative, variance (s mean wavelength)^2.
    """
    still = np.zeros_like(of.rate)
    return of._replace(c_slope=0.0 * of.c, rate_slope=of.rate / float(np.mean(wavelength_nm)), rate_curve=still)


def by_index(problem: Problem, wavelength_nm: Floats, thickness_nm: float) -> Floats:
    """How R or T of a film changes with its index n times h held: n dR/dn - h dR/dh, for a relative change of n."""
    index, thickness = relative_slopes(problem, wavelength_nm, [thickness_nm], 0)
    return index - thickness


def relative_slopes(
    problem: Problem, wavelength_nm: Floats, thickness_nm: Sequence[float], which: int
) -> tuple[Floats, Floats]:
    """How R or T changes with index and thickness of an unknown layer, each for a relative change: n dR/dn, h dR/dh."""
    stack, place = problem.stack, problem.unknown[which]
    layers = len(stack.layers)
    held = [np.asarray(medium.index(wavelength_nm, extrapolate="hold")) for medium in stack.media]
    indices = np.stack([np.broadcast_to(one, wavelength_nm.shape).astype(np.complex128) for one in held], axis=1)
    thickness = np.array([float(layer.thickness_nm) for layer in stack.layers])
    thickness[list(problem.unknown)] = thickness_nm
    values, rows = np.empty((wavelength_nm.size, 1)), np.empty((wavelength_nm.size, 3 * layers + 3))
    _core.stack_derivatives(
        problem.quantity,
        problem.polarization,
        np.ascontiguousarray(indices),
        np.ascontiguousarray(np.broadcast_to(thickness, (wavelength_nm.size, layers))),
        [layer.coherent for layer in stack.layers],
        wavelength_nm,
        np.full(wavelength_nm.size, problem.angle_deg),
        values,
        rows,
    )
    return indices[:, place + 1].real * rows[:, layers + 1 + place], thickness_nm[which] * rows[:, place]


# Wavelengths are moved by this much, nm, for changes with wavelength: about a line's width, so that the kinks of a table of
# indices count as little as they do through a line.
_MOVE_NM = 1.5


def harmonics(problem: Problem, wavelength_nm: Floats) -> Harmonics | None:
    """The harmonics of a single unknown layer that is clear, in a coherent stack, its index known; else None."""
    if len(problem.unknown) != 1 or problem.index != (None,):
        return None
    if not all(layer.coherent for layer in problem.stack.layers):
        return None
    moved = [_harmonics(problem, wavelength_nm + shift) for shift in (-_MOVE_NM, 0.0, _MOVE_NM)]
    before, at, after = moved
    if before is None or at is None or after is None:
        return None
    orders = min(len(c) for _, c, _ in (before, at, after))
    return Harmonics(
        at[0],
        at[1][:orders],
        (after[1][:orders] - before[1][:orders]) / (2.0 * _MOVE_NM),
        at[2],
        (after[2] - before[2]) / (2.0 * _MOVE_NM),
        (after[2] - 2.0 * at[2] + before[2]) / _MOVE_NM**2,
    )


def _harmonics(problem: Problem, wavelength_nm: Floats) -> tuple[Floats, Complexes, Floats] | None:
    """Base, harmonics and the rate at these wavelengths alone; media hold their ends."""
    rate = phase_rate(problem, wavelength_nm)
    if rate is None:
        return None
    place = problem.unknown[0]
    angle = np.array(problem.angle_deg)
    parts = ("s", "p") if problem.polarization == "unpolarized" else (problem.polarization,)
    parts = parts[:1] if problem.angle_deg == 0.0 else parts
    base: Floats = np.zeros_like(wavelength_nm)
    sums: list[Complexes] = []
    for part in parts:
        airy = layer_airy(problem.stack, place, wavelength_nm, angle, part, hold=True)
        r_above, t_squared, r_inside, r_below, passed, _ = np.moveaxis(airy, -1, 0)
        q, e = r_inside * r_below, t_squared * r_below
        left = 1.0 - np.abs(q) ** 2
        if problem.quantity == "transmittance":
            mean, first = passed.real / left, passed.real / left * q
        else:
            mean = np.abs(r_above) ** 2 + np.abs(e) ** 2 / left
            first = r_above.conj() * e + np.abs(e) ** 2 * q / left
        base = base + mean
        term = first
        for order in range(200):
            if order and np.abs(term).max() < _FAINTEST:
                break
            if order == len(sums):
                sums.append(np.zeros_like(term))
            sums[order] = sums[order] + term
            term = term * q
    return base / len(parts), np.array(sums) / len(parts), rate


def phase_rate(problem: Problem, wavelength_nm: Floats, which: int = 0) -> Floats | None:
    """Phase of a round trip in an unknown layer in radians a nm; None where it absorbs or is evanescent."""
    medium = problem.stack.layers[problem.unknown[which]].medium
    index = np.broadcast_to(np.asarray(medium.index(wavelength_nm, extrapolate="hold")), wavelength_nm.shape)
    first = np.asarray(problem.stack.first.index(wavelength_nm, extrapolate="hold")).real
    square = index.real**2 - (first * np.sin(np.radians(problem.angle_deg))) ** 2
    if np.any(index.imag != 0.0) or np.any(square <= 0.0):
        return None
    return np.asarray(4.0 * np.pi * np.sqrt(square) / wavelength_nm)


def quarter_wave_nm(problem: Problem, wavelength_nm: Floats) -> float:
    """Of the first unknown layer, in the middle of the spectrum: films within it are of one order."""
    middle = float(np.median(wavelength_nm))
    medium = problem.stack.layers[problem.unknown[0]].medium
    return middle / (4.0 * max(float(np.real(medium.index(middle, extrapolate="hold"))), 1.0))


class HarmonicModel:
    """A single clear layer; parameters (thickness, variance)."""

    def __init__(self, of: Harmonics) -> None:
        self.of = of
        self.orders = np.arange(1, len(of.c) + 1)[:, None]

    def value(self, parameters: Floats) -> Floats:
        return self.both(parameters)[0]

    def both(self, parameters: Floats, sharp: bool = False) -> tuple[Floats, Floats]:
        d, v = float(parameters[0]), float(parameters[1])
        of, m = self.of, self.orders
        # Powers of one exponential: each costs a product instead of a sine and a cosine.
        turn = np.exp(1j * of.rate * d)
        powers = np.cumprod(np.broadcast_to(turn, (len(of.c), turn.size)), axis=0)
        s = m * of.rate_slope * d
        bend = m * of.rate_curve * d
        # The line takes this from the logarithm of each harmonic, and its derivative with respect to v.
        line = -0.5 * s * s * v + 0.5j * bend * v * (1.0 - s * s * v)
        line_by_v = -0.5 * s * s + 0.5j * bend * (1.0 - 2.0 * s * s * v)
        line_by_d = -s * s * v / d if d > 0.0 else 0.0 * s
        carried = 2.0 * powers * (np.exp(line) if v > 0.0 else 1.0)
        amplitude = of.c + 1j * s * v * of.c_slope
        terms = amplitude * carried
        by_d = (terms * (1j * m * of.rate + line_by_d)).real.sum(axis=0)
        by_d += (1j * m * of.rate_slope * v * of.c_slope * carried).real.sum(axis=0)
        by_v = (terms * line_by_v + 1j * s * of.c_slope * carried).real.sum(axis=0)
        return of.base + terms.real.sum(axis=0), np.stack([by_d, by_v], axis=1)

    def many(self, d: Floats, v: float) -> Floats:
        """Spectra of many thicknesses, (thicknesses, wavelengths), the line to first order: for a search."""
        rate, slope = self.of.rate, self.of.rate_slope
        turn = np.exp(1j * np.multiply.outer(d, rate))
        damping = np.multiply.outer(d * d, 0.5 * slope * slope * v) if v > 0.0 else None
        total = np.broadcast_to(self.of.base, turn.shape).copy()
        power = turn
        for order, coefficient in enumerate(self.of.c, start=1):
            if order > 1:
                power = power * turn
            term = 2.0 * (coefficient * power).real
            total += term if damping is None else term * np.exp(-(order**2) * damping)
        return total


# --- everything else: the derivatives of the core, averaged over the line


class GeneralModel:
    """Any stack; parameters (thicknesses, index parameters, variance)."""

    def __init__(self, problem: Problem, wavelength_nm: Floats) -> None:
        self.problem = problem
        self.wavelength_nm = wavelength_nm
        self.coherent = [layer.coherent for layer in problem.stack.layers]
        self.fixed_nm = np.array([float(layer.thickness_nm) for layer in problem.stack.layers])

    def start_index(self) -> Floats:
        """Index parameters of the media as they are: n, or Cauchy's A and B (um^2) by least squares."""
        start: list[float] = []
        for place, model in zip(self.problem.unknown, self.problem.index, strict=True):
            n = np.broadcast_to(
                np.asarray(self.problem.stack.layers[place].medium.index(self.wavelength_nm, extrapolate="hold")).real,
                self.wavelength_nm.shape,
            )
            if model == "constant":
                start.append(float(n.mean()))
            elif model == "cauchy":
                basis = np.stack([np.ones_like(n), (1e3 / self.wavelength_nm) ** 2], axis=1)
                start += [float(value) for value in np.linalg.lstsq(basis, n, rcond=None)[0]]
        return np.array(start)

    def value(self, parameters: Floats) -> Floats:
        return self.both(parameters, sharp=True)[0]

    def both(self, parameters: Floats, sharp: bool = False) -> tuple[Floats, Floats]:
        unknown = len(self.problem.unknown)
        layers = len(self.fixed_nm)
        variance = float(parameters[-1])
        nodes, weights, sd = self._line(parameters[:unknown], variance)
        if sharp and variance <= _POINT_NM**2:
            nodes, weights = np.zeros(1), np.ones(1)
        nm = (self.wavelength_nm[:, None] + sd * nodes).reshape(-1)
        indices, slopes = self._indices(nm, parameters[unknown:-1])
        thickness = self.fixed_nm.copy()
        thickness[list(self.problem.unknown)] = parameters[:unknown]
        values = np.empty((nm.size, 1))
        rows = np.empty((nm.size, 3 * layers + 3))
        _core.stack_derivatives(
            self.problem.quantity,
            self.problem.polarization,
            indices,
            np.ascontiguousarray(np.broadcast_to(thickness, (nm.size, layers))),
            self.coherent,
            nm,
            np.full(nm.size, self.problem.angle_deg),
            values,
            rows,
        )
        columns = [rows[:, place] for place in self.problem.unknown]
        for place, model in zip(self.problem.unknown, self.problem.index, strict=True):
            by_n = rows[:, layers + 1 + place]
            columns += [] if model is None else [by_n]
            columns += [by_n * (1e3 / nm) ** 2] if model == "cauchy" else []
        # The spectrum's own slope, by which a wider line changes it: phases fall as 1/lambda, indices disperse.
        media = layers + 2
        by_nm = -(rows[:, :layers] * thickness).sum(axis=1) / nm
        by_nm += (rows[:, layers : layers + media] * slopes.real).sum(axis=1)
        by_nm += (rows[:, layers + media :] * slopes.imag[:, 1:]).sum(axis=1)
        shape = (self.wavelength_nm.size, nodes.size)

        def mean(column: Floats) -> Floats:
            return np.asarray((column.reshape(shape) * weights).sum(axis=1))

        by_variance = (by_nm.reshape(shape) * (weights * nodes)).sum(axis=1) / (2.0 * sd)
        return mean(values[:, 0]), np.stack([*map(mean, columns), by_variance], axis=1)

    def _line(self, thickness_nm: Floats, variance: float) -> tuple[Floats, Floats, float]:
        """Gauss-Hermite nodes (in sd) and weights: enough of them for the finest fringe."""
        sd = max(np.sqrt(max(variance, 0.0)), _POINT_NM)
        finest = self.wavelength_nm.min()
        path = 3.0 * float(np.sum(thickness_nm)) + float(self.fixed_nm[self.coherent].sum()) * 3.0
        spread = 4.0 * np.pi * path * sd / finest**2
        count = int(np.clip(5 + 4 * np.ceil(spread), 3, 61)) if variance > _POINT_NM**2 else 3
        nodes, weights = np.polynomial.hermite_e.hermegauss(count)
        return np.asarray(nodes), np.asarray(weights / weights.sum()), float(sd)

    def _indices(self, nm: Floats, index_parameters: Floats) -> tuple[Complexes, Complexes]:
        """Indices of all media (wavelengths, media), and how they change with wavelength."""
        columns, slopes = [], []
        for medium in self.problem.stack.media:
            value, slope = _index_and_slope(medium, nm)
            columns.append(value)
            slopes.append(slope)
        at = 0
        for place, model in zip(self.problem.unknown, self.problem.index, strict=True):
            if model is None:
                continue
            k = columns[place + 1].imag
            if model == "constant":
                n, by_nm = np.full(nm.size, index_parameters[at]), np.zeros(nm.size)
            else:
                per_um = (1e3 / nm) ** 2
                n = index_parameters[at] + index_parameters[at + 1] * per_um
                by_nm = -2.0 * index_parameters[at + 1] * per_um / nm
            columns[place + 1] = n + 1j * k
            slopes[place + 1] = by_nm + 1j * slopes[place + 1].imag
            at += 1 if model == "constant" else 2
        return np.ascontiguousarray(np.stack(columns, axis=1)), np.stack(slopes, axis=1)


def _index_and_slope(medium: Medium, nm: Floats) -> tuple[Complexes, Complexes]:
    def at(shift: float) -> Complexes:
        return np.array(np.broadcast_to(np.asarray(medium.index(nm + shift, extrapolate="hold")), nm.shape))

    if medium.kind == "constant":
        return at(0.0), np.zeros(nm.size, dtype=np.complex128)
    step = 0.05
    return at(0.0), (at(step) - at(-step)) / (2.0 * step)
