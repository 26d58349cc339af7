"""What charts are asked: stacks of which one layer grows, ranges of thickness, lists of things. Internal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from iridesce.arguments.operands import Floats, real_operand
from iridesce.arguments.refusals import Words, complaint, refusal, within
from iridesce.color.films import GREY_NM
from iridesce.optics.medium import Medium
from iridesce.optics.stack_text import parse_items
from iridesce.plot._style import number
from iridesce.stack import Layer, Stack

StackLike: TypeAlias = "Stack | str"
Stacks: TypeAlias = "StackLike | Sequence[StackLike] | Mapping[str, StackLike]"


@dataclass(frozen=True)
class Family:
    """Stacks that differ in the thickness of one layer: ``position`` counts from 0."""

    stack: Stack
    position: int

    def at(self, thickness_nm: ArrayLike) -> Stack:
        """The stack whose growing layer is that thick."""
        layers = list(self.stack.layers)
        growing = layers[self.position]
        layers[self.position] = Layer(growing.medium, thickness_nm, growing.coherent)
        return Stack([self.stack.first, *layers, self.stack.last])

    @property
    def medium(self) -> Medium:
        """What the growing layer is made of."""
        return self.stack.layers[self.position].medium

    @property
    def name(self) -> str:
        """Like the text of the stack, the growing layer without its thickness."""
        return stack_name(self.stack, self.position)

    def own_thicknesses(self) -> Floats | None:
        """The thicknesses that the layer brought along, where it brought several."""
        values = np.asarray(self.stack.layers[self.position].thickness_nm, dtype=np.float64)
        return values.reshape(-1) if values.size > 1 else None

    def optical_factor(self, angle_deg: float, wavelength_nm: float = 550.0) -> float:
        """Retardation per thickness, 2 n cos(theta) inside the growing layer, with the real part of its index."""
        first, n = (float(medium.index(wavelength_nm).real) for medium in (self.stack.first, self.medium))
        across = first * np.sin(np.radians(angle_deg))
        if not n > across:
            raise complaint(
                f"no wave runs through {self.medium.name} at {number(angle_deg)} degrees from {self.stack.first.name}"
                " (total reflection), so its retardation has no value",
                "angle_deg",
                "below total reflection",
                angle_deg,
            )
        return float(2.0 * np.sqrt(n * n - across * across))


def family(stack: StackLike, layer: int | str | None = None) -> Family:
    """A stack or its text, and which of its layers grows."""
    if isinstance(stack, str):
        return _from_text(stack, layer)
    if not isinstance(stack, Stack):
        raise refusal("stack", "an iridesce.Stack or its text", stack)
    return Family(stack, _growing(stack, layer, None))


def _from_text(text: str, layer: int | str | None) -> Family:
    first, *middle, last = parse_items(text, open_layers=True)
    layers = []
    for item in middle:
        try:
            layers.append(Layer(item.medium, item.thickness_nm, item.coherent))
        except ValueError as error:
            raise within(item.where, error) from None
    stack = Stack([first.medium, *layers, last.medium])
    missing = [position for position, item in enumerate(middle) if item.is_open]
    if len(missing) > 1:
        raise complaint(
            f"only one layer of a chart may leave out its thickness, got {text!r}",
            "stack",
            "a stack of which one layer at most leaves out its thickness",
            text,
        )
    position = _growing(stack, layer, missing[0] if missing else None)
    if missing and position != missing[0]:
        raise complaint(
            f"{middle[missing[0]].where}: a layer that does not grow needs its thickness in nm",
            "thickness_nm",
            "given for a layer that does not grow",
            Words("nothing"),
            f"in {middle[missing[0]].where}",
        )
    return Family(stack, position)


def _growing(stack: Stack, layer: int | str | None, missing: int | None) -> int:
    """The position of the growing layer: the one named, left open, given as an array, or the only one."""
    layers = stack.layers
    if not layers:
        raise complaint(
            f"a chart needs a layer that grows, got {stack_name(stack)!r}, which has none",
            "stack",
            "a stack with a layer that grows",
            Words(stack_name(stack)),
        )
    if layer is None:
        arrays = [position for position, one in enumerate(layers) if np.size(one.thickness_nm) > 1]
        candidates = [missing] if missing is not None else arrays or list(range(len(layers)))
        if len(candidates) > 1:
            raise complaint(
                f"{stack_name(stack)!r} has {len(layers)} layers: say which grows, by layer=1 to {len(layers)} or"
                ' the name of its medium, or in text by "?" for its thickness',
                "layer",
                f"1 to {len(layers)} or the name of a medium",
                None,
            )
        return candidates[0]
    if isinstance(layer, str):
        named = [position for position, one in enumerate(layers) if one.medium.name == layer]
        if len(named) != 1:
            problem = "no layer" if not named else f"{len(named)} layers"
            names = ", ".join(one.medium.name for one in layers)
            raise complaint(
                f"layer must name one of the layers {names}; {problem} of {layer!r}",
                "layer",
                f"the name of one of the layers {names}",
                layer,
            )
        return named[0]
    if isinstance(layer, bool) or not isinstance(layer, int | np.integer) or not 1 <= layer <= len(layers):
        raise refusal("layer", f"1 to {len(layers)} or the name of a medium", layer)
    return int(layer) - 1


# Letters of a title that stay on a chart of the usual size.
_LONGEST_NAME = 72


def stack_name(stack: Stack, growing: int | None = None) -> str:
    """A stack in words: ``air / TiO2 50 nm / Ti``; of many layers only their number and thickness."""
    words = [stack.first.name]
    for position, layer in enumerate(stack.layers):
        fixed = position != growing and np.size(layer.thickness_nm) == 1
        words.append(
            f"{layer.medium.name} {float(np.ravel(layer.thickness_nm)[0]):.6g} nm" if fixed else layer.medium.name
        )
    whole = " / ".join([*words, stack.last.name])
    if len(whole) <= _LONGEST_NAME or len(stack.layers) < 2:
        return whole
    total = sum(float(np.max(layer.thickness_nm)) for layer in stack.layers)
    return f"{stack.first.name} / {len(stack.layers)} layers, {total:.6g} nm / {stack.last.name}"


def listed(stacks: Stacks) -> list[tuple[str | None, StackLike]]:
    """One stack or many, with the labels of a dict."""
    if isinstance(stacks, Stack | str):
        return [(None, stacks)]
    if isinstance(stacks, Mapping):
        entries: list[tuple[str | None, StackLike]] = [(str(label), stack) for label, stack in stacks.items()]
    elif isinstance(stacks, Sequence):
        entries = [(None, stack) for stack in stacks]
    else:
        raise refusal("stack", "a Stack, its text, or a list or dict of them", stacks)
    if not entries:
        raise complaint("stack must not be an empty list", "stack", "one stack or more", Words("an empty list"))
    return entries


def samples(
    name: str, value: ArrayLike | None, own: Floats | None, default: tuple[float, float], step: float
) -> Floats:
    """Ascending values >= 0: two numbers are the ends of a range, filled in steps of about ``step``."""
    if value is None:
        value = default if own is None else own
    given = real_operand(name, value, low=0.0).full()
    if given.ndim != 1 or given.size < 2:
        raise refusal(name, "two numbers, the ends of a range, or an ascending array", value)
    if not (np.diff(given) > 0.0).all():
        raise complaint(f"{name} must ascend, got {value!r:.80}", name, "ascending", value)
    if given[-1] > GREY_NM:
        raise refusal(
            name, f"at most {GREY_NM:g} nm in a chart (such films have no colour left)", Words(f"{given[-1]:g}")
        )
    if given.size > 2:
        return given.copy()
    count = int(np.clip((given[1] - given[0]) / step, 400, 4000)) + 1
    return np.linspace(given[0], given[1], count)


def even(name: str, values: Floats) -> Floats:
    """The same values, or an error: a picture has columns of one width."""
    steps = np.diff(values)
    if np.ptp(steps) > 1e-6 * steps.mean():
        raise refusal(name, "evenly spaced", Words(f"steps from {steps.min():g} to {steps.max():g}"))
    return values


def one_angle(angle_deg: ArrayLike) -> float:
    """A single angle of incidence."""
    angle = real_operand("angle_deg", angle_deg, low=0.0, high=90.0).full()
    if angle.size != 1:
        raise refusal("angle_deg", "one number here", Words(f"shape {angle.shape}"))
    return float(angle.reshape(-1)[0])


def angles(angle_deg: ArrayLike) -> list[float]:
    """One angle or several."""
    return [float(angle) for angle in real_operand("angle_deg", angle_deg, low=0.0, high=90.0).full().reshape(-1)]


def words(name: str, value: str | Sequence[str], allowed: tuple[str, ...], may_be_none: bool = False) -> list[str]:
    """One word or several of those allowed."""
    chosen = [value] if isinstance(value, str) else list(value) if isinstance(value, Sequence) else [value]
    for word in chosen:
        if not isinstance(word, str) or word not in allowed:
            raise refusal(name, f"one or more of {', '.join(map(repr, allowed))}", value)
    if not chosen and not may_be_none:
        raise refusal(name, f"one or more of {', '.join(map(repr, allowed))}", Words("none"))
    if len(set(chosen)) != len(chosen):
        raise complaint(f"{name} must not name the same twice, got {value!r:.80}", name, "different ones", value)
    return chosen
