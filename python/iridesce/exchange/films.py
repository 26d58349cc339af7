"""A film as it leaves: a stack, which of its layers varies, over what range, and what that looks like. Internal."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import color
from iridesce.arguments.operands import Floats, real_operand
from iridesce.arguments.refusals import Words, complaint, refusal, short, within
from iridesce.color.films import GREY_NM
from iridesce.exchange.appearance import Roughness
from iridesce.optics.stack_text import parse_items
from iridesce.stack import Layer, Stack

ANGLES_DEG = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0)
"""The angles of every chart and report, degrees in the first medium."""

COUNT = 24
"""Thicknesses of a chart, both ends included."""

TABLE_NM = (0.0, 2000.0)
"""The range of a table where nobody names one: that of `ColorTable`."""

DISPERSES = 0.005
"""A change of n over the visible below which one number stands for it."""

# The cosine that stands for grazing light, where R goes to its limit in proportion to it.
_GRAZING = 1e-7


@dataclass(frozen=True, eq=False)
class Film:
    """One film of one surface, ready to be written for another program."""

    stack: Stack
    layer: int | None
    """Which of ``stack.layers`` varies; ``None`` for a bare surface."""
    range_nm: tuple[float, float]
    """Least and greatest thickness; equal where it is the same everywhere."""
    illuminant: color.Illuminant
    name: str = "film"
    thickness_nm: Floats | None = None
    """A map of the thickness over u and v, row 0 on top, where there is one."""
    free: bool = False
    """A film with the same clear medium on both sides, which light passes."""
    notes: list[str] = field(default_factory=list)
    roughness: Roughness | None = None
    """``None`` for a mirror."""

    @property
    def varies(self) -> bool:
        """Whether the thickness differs from place to place."""
        return self.range_nm[0] < self.range_nm[1]

    @property
    def transmits(self) -> bool:
        """Whether light comes out behind: the last medium does not absorb."""
        return bool(np.all(extended_index(self.stack.last, [450.0, 550.0, 650.0]).imag == 0.0))

    def at(self, thickness_nm: ArrayLike) -> Stack:
        """The stack whose varying layer is that thick."""
        if self.layer is None:
            return self.stack
        layers = list(self.stack.layers)
        layers[self.layer] = Layer(layers[self.layer].medium, thickness_nm, layers[self.layer].coherent)
        return Stack([self.stack.first, *layers, self.stack.last])

    def xyz(self, thickness_nm: ArrayLike, angle_deg: ArrayLike, quantity: str = "reflectance") -> Floats:
        """The true colour under the film's own light, white = 1: thicknesses and angles broadcast, + an axis of 3."""
        shape = np.broadcast_shapes(np.shape(thickness_nm), np.shape(angle_deg))
        with self.hushed():
            stack = self.at(thickness_nm)
            result = stack.color(angle_deg=angle_deg, illuminant=self.illuminant, quantity=quantity)
        return np.ascontiguousarray(np.broadcast_to(result, (*shape, 3)))

    @contextmanager
    def hushed(self) -> Iterator[None]:
        """What the core warns of (media beyond their data) becomes a note of the report, once."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
        for warning in caught:
            if str(warning.message) not in self.notes:
                self.notes.append(str(warning.message))

    def thicknesses(self, count: int = COUNT) -> Floats:
        """The thicknesses of a chart over the film's range; one where it is the same everywhere."""
        return np.linspace(*self.range_nm, count if self.varies else 1)

    def table_range(self) -> tuple[float, float]:
        """What a table spans: the film's range, or for a film of one thickness 0 to twice that, to 2000 nm at least."""
        if self.layer is None:
            raise complaint(
                f"a table needs a stack with a layer, got {short(self.stack)}",
                "stack",
                "a stack with a layer",
                self.stack,
            )
        return self.range_nm if self.varies else (TABLE_NM[0], max(TABLE_NM[1], 2.0 * self.range_nm[1]))

    @property
    def text(self) -> str:
        """The stack in one line, as the command line writes it; ``?`` for the thickness that varies."""
        return stack_text(self.stack, self.layer if self.varies else None)

    @property
    def text_for_table(self) -> str:
        """The same with ``?`` for the thickness that a table runs over."""
        return stack_text(self.stack, self.layer)


def extended_index(medium: Any, wavelength_nm: ArrayLike) -> Any:
    """n + ik where colour sums take it: a built-in medium goes on beyond its data by its stated extension."""
    values, _ = medium._core.index_extended(
        np.ascontiguousarray(np.asarray(wavelength_nm, dtype=np.float64)).reshape(-1)
    )
    return np.asarray(values)


def grazing_deg(cos_theta: ArrayLike) -> Floats:
    """Degrees of a cosine; 0 stands for the limit of grazing light, which is not an angle of `Stack`."""
    return np.degrees(np.arccos(np.clip(np.asarray(cos_theta, dtype=np.float64), _GRAZING, 1.0)))


def stack_text(stack: Stack, varying: int | None = None) -> str:
    """A stack as the command line writes it."""
    words = [_medium_text(stack.first)]
    for number, layer in enumerate(stack.layers):
        values = layer._thickness.values
        nm = "?" if number == varying or values.size > 1 else f"{float(values.flat[0]):.10g}"
        words.append(f"{_medium_text(layer.medium)} {nm}{'' if layer.coherent else ' incoherent'}")
    return " / ".join([*words, _medium_text(stack.last)])


def _medium_text(medium: Any) -> str:
    index = medium._core.constant_index
    if index is None or medium.name in ("air", "vacuum"):
        return str(medium.name)
    return f"{index[0]:.10g}" if index[1] == 0.0 else f"{index[0]:.10g}{index[1]:+.10g}j"


def read_stack(text: str) -> tuple[Stack, int | None]:
    """A stack from text whose varying layer may leave its thickness out, or write ``?`` for it; and which that is."""
    first, *middle, last = parse_items(text, open_layers=True)
    layers = []
    for item in middle:
        try:
            layers.append(Layer(item.medium, item.thickness_nm, item.coherent))
        except ValueError as error:
            raise within(item.where, error) from None
    is_open = [number for number, item in enumerate(middle) if item.is_open]
    if len(is_open) > 1:
        raise complaint(
            f"only one layer may leave out its thickness, got {text!r}",
            "stack",
            "a stack of which one layer at most leaves out its thickness",
            text,
        )
    return Stack([first.medium, *layers, last.medium]), is_open[0] if is_open else None


def film_of(
    stack: Stack,
    layer: int | None,
    vary: object,
    thickness_nm: Floats | None,
    illuminant: color.Illuminant,
    name: str = "film",
) -> Film:
    """The film of a stack: which layer varies, and over what range."""
    notes: list[str] = []
    layer = _varying(stack, layer, vary is not None or thickness_nm is not None)
    if layer is None:
        return Film(stack, None, (0.0, 0.0), illuminant, name, free=_is_free(stack), notes=notes)
    own = stack.layers[layer]._thickness.values
    if vary is not None:
        extent = checked_range("vary", vary)
    elif thickness_nm is not None:
        extent = (float(thickness_nm.min()), float(thickness_nm.max()))
    else:
        extent = (float(own.min()), float(own.max()))
        if own.size > 1 and own.ndim > 1:
            thickness_nm = np.asarray(own) if own.ndim == 2 else None
    if thickness_nm is not None and vary is not None:
        low, high = float(thickness_nm.min()), float(thickness_nm.max())
        if low < extent[0] or high > extent[1]:
            raise complaint(
                f"thickness runs from {low:g} to {high:g} nm, beyond vary = {extent[0]:g} to {extent[1]:g} nm",
                "thickness",
                f"within vary = {extent[0]:g} to {extent[1]:g} nm",
                Words(f"{low:g} to {high:g} nm"),
            )
    return Film(stack, layer, extent, illuminant, name, thickness_nm, _is_free(stack), notes)


def checked_range(name: str, value: object) -> tuple[float, float]:
    """``(A, B)`` nm, 0 <= A < B <= 1e5."""
    operand = real_operand(name, value, low=0.0)
    if operand.shape != (2,):
        raise refusal(name, "two thicknesses (A, B) in nm", value)
    low, high = (float(end) for end in operand.full())
    if not low < high:
        raise refusal(name, "from a thinner to a thicker film", Words(f"{low:g} to {high:g} nm"), must="run")
    if high > GREY_NM:
        raise refusal(name, f"at {GREY_NM:g} nm or below (thicker films are grey)", Words(f"{high:g} nm"), must="end")
    return low, high


def _varying(stack: Stack, layer: int | None, must: bool) -> int | None:
    count = len(stack.layers)
    if layer is not None:
        return layer
    if count == 0:
        if must:
            raise complaint(
                f"a thickness that varies needs a stack with a layer, got {short(stack)}",
                "stack",
                "a stack with a layer",
                stack,
            )
        return None
    arrays = [number for number, one in enumerate(stack.layers) if one._thickness.values.size > 1]
    if len(arrays) == 1:
        return arrays[0]
    if count == 1:
        return 0
    if len(arrays) > 1 or must:
        raise complaint(
            f"which of the {count} layers varies? Give that one an array of thicknesses, in text a ? for its thickness"
            f" ({len(arrays) or 'none'} of them {'has' if len(arrays) < 2 else 'have'} one)",
            "stack",
            "a stack of which one layer has an array of thicknesses",
            Words(f"{len(arrays) or 'none'} of {count}"),
        )
    return int(np.argmax([one.coherent for one in stack.layers]))


def _is_free(stack: Stack) -> bool:
    return stack.first == stack.last and bool(stack.layers)
