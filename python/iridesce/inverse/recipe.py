"""Films that show a colour: one, and a list of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from iridesce._notebook import rows_html
from iridesce.arguments.operands import Floats
from iridesce.stack import Stack

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Recipe:
    """Films that show a colour, and how safely they can be made.

    stack            the films on their substrate, a `Stack`
    delta_e          CIEDE2000 between its colour and the target
    yield_           share of films, each layer drawn normally about its thickness, whose colour is accepted
    delta_e_per_nm   for each layer, the colour difference that a nm makes
    color            its colour in the space of the target
    reachable        whether it is within ``max_delta_e``
    volts, volts_sd  by the user's coupons: voltage, and the standard deviation of the next sample in volts; else None

    >>> import iridesce as ir
    >>> recipe = ir.recipes([40.0, 10.0, -40.0], media=["SiO2"], substrate="Si", layers=(1,), max_delta_e=20.0)[0]
    >>> len(recipe.thickness_nm), len(recipe.delta_e_per_nm)
    (1, 1)
    """

    stack: Stack
    delta_e: float
    yield_: float
    delta_e_per_nm: tuple[float, ...]
    color: Floats
    reachable: bool = True
    volts: float | None = None
    volts_sd: float | None = None
    lab: Floats = field(default_factory=lambda: np.zeros(3), repr=False)

    @property
    def thickness_nm(self) -> tuple[float, ...]:
        """Of each layer, from the outside in."""
        return tuple(float(layer.thickness_nm) for layer in self.stack.layers)

    @property
    def text(self) -> str:
        """The stack as the command line takes it."""
        layers = [f"{layer.medium.name} {float(layer.thickness_nm):.4g}" for layer in self.stack.layers]
        return " / ".join([self.stack.first.name, *layers, self.stack.last.name])

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain values.

        Returns    dict

        >>> import iridesce as ir
        >>> found = ir.recipes([40.0, 10.0, -40.0], media=["SiO2"], substrate="Si", layers=(1,), max_delta_e=20.0)
        >>> found[0].to_dict()["media"]
        ['SiO2']
        """
        return {
            "stack": self.text,
            "media": [layer.medium.name for layer in self.stack.layers],
            "thickness_nm": list(self.thickness_nm),
            "delta_e": self.delta_e,
            "yield": self.yield_,
            "delta_e_per_nm": list(self.delta_e_per_nm),
            "color": [float(one) for one in self.color],
            "reachable": self.reachable,
            "volts": self.volts,
            "volts_sd": self.volts_sd,
        }


class RecipeList(list[Recipe]):
    """A list of `Recipe`, of best yield first, with ``target`` (Lab) and ``notes``.

    >>> import iridesce as ir
    >>> found = ir.recipes([90.0, 80.0, 0.0], media=["SiO2"], substrate="Si", layers=(1,))
    >>> len(found), found[0].reachable, found.notes[0][:13]
    (1, False, 'not reachable')
    """

    def __init__(self, found: Iterable[Recipe] = (), target: Floats | None = None, notes: tuple[str, ...] = ()) -> None:
        super().__init__(found)
        self.target = np.zeros(3) if target is None else target
        self.notes = notes

    def rows(self) -> list[list[str]]:
        """What is told of each: stack, CIEDE2000, yield, slopes, volts."""
        return [
            [
                one.text,
                f"{one.delta_e:.2f}",
                f"{100.0 * one.yield_:.1f} %",
                " ".join(f"{slope:.2f}" for slope in one.delta_e_per_nm),
                "" if one.volts is None else f"{one.volts:.1f} +- {one.volts_sd:.1f} V",
            ]
            for one in self
        ]

    def _repr_html_(self) -> str:
        table = rows_html(["stack", "CIEDE2000", "yield", "a nm", "volts"], self.rows(), 60)
        return table + "".join(f"<p>{note}</p>" for note in self.notes)

    def plot(self, ax: Axes | None = None, *, title: str | None = None, theme: str | None = None) -> Axes:
        """Yields over colour differences: what is near, and what is safe.

        ax, title, theme  as in `iridesce.plot`
        Returns    the Axes
        Raises     ValueError as there

        >>> import iridesce as ir
        >>> found = ir.recipes([40.0, 10.0, -40.0], media=["SiO2"], substrate="Si", layers=(1,), max_delta_e=20.0)
        >>> found.plot().get_xlabel()
        'CIEDE2000 from the target'
        """
        from iridesce.plot import _recipes

        return _recipes.plot(self, ax, title, theme)
