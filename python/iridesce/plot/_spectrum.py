"""Spectra of stacks. Internal."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from iridesce.arguments.operands import Floats, real_operand
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.color.screen import monochromatic
from iridesce.optics.layer import check_one_thickness
from iridesce.optics.stack_text import parse_items
from iridesce.optics.wavelengths import SPECTRUM_NM
from iridesce.plot._arguments import StackLike, Stacks, angles, listed, stack_name, words
from iridesce.plot._style import Theme, begin, heading, legend, number
from iridesce.stack import Stack

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_QUANTITIES = ("reflectance", "transmittance", "absorptance")
_POLARIZATIONS = ("unpolarized", "s", "p")
_MOST_CURVES = 24
_DASHES = ("solid", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (6, 1.5, 1.5, 1.5)))


def spectrum(
    stack: Stacks,
    wavelength_nm: ArrayLike | None = None,
    angle_deg: ArrayLike = 0.0,
    polarization: str | Sequence[str] = "unpolarized",
    quantity: str | Sequence[str] = "reflectance",
    *,
    title: str | None = None,
    theme: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Spectra in percent, with a band of the visible colours under them.

    One curve for every stack, angle, polarisation and quantity asked for. A second call on the same Axes adds its
    curves to those that are there.

    stack          a stack or its text, "air / MgF2 100 / N-BK7"; a list of them; a dict {label: stack}
    wavelength_nm  (first, last) or ascending values, vacuum nm, within the data of all media; None: 380 to 780 nm as far
                   as all media have data                                                                      (n,)
    angle_deg      incidence in the first medium, [0, 90); one or several
    polarization   "s", "p", "unpolarized", or several of them
    quantity       "reflectance", "transmittance", "absorptance", or several of them
    title, theme, ax  see `iridesce.plot`
    Returns        the Axes; y in percent
    Raises         ValueError naming the argument, the value and what is allowed

    >>> import iridesce as ir
    >>> ax = ir.plot.spectrum({"bare": "air / N-BK7", "coated": "air / MgF2 100 / N-BK7"})
    >>> [line.get_label() for line in ax.get_lines()], round(float(ax.get_lines()[0].get_ydata()[0]), 2)
    (['bare', 'coated'], 4.44)
    """
    stacks = [(label, _stack(one)) for label, one in listed(stack)]
    wavelengths = _wavelengths(_known_visible([one for _, one in stacks]) if wavelength_nm is None else wavelength_nm)
    wanted = words("quantity", quantity, _QUANTITIES)
    states = words("polarization", polarization, _POLARIZATIONS)
    degrees = angles(angle_deg)
    curves = _curves(stacks, wanted, states, degrees, wavelengths)

    ax, look = begin(ax, theme, (7.6, 4.6))
    used = len({line.get_color() for line in ax.get_lines() if line.get_gid() == "curve"})
    for label, color, style, values in curves:
        turns, place = divmod(used + color, len(look.series))
        ax.plot(
            wavelengths,
            values,
            color=look.series[place],
            linestyle=_DASHES[(style + turns) % len(_DASHES)],
            linewidth=1.8,
            zorder=3,
            label=label,
            gid="curve",
        )
    _limits(ax)
    _band(ax, look)
    ax.set_xlabel("vacuum wavelength (nm)")
    ax.set_ylabel(f"{wanted[0]} (%)" if len(wanted) == 1 else "share of the light (%)")
    ax.grid(axis="y", color=look.faint, linewidth=0.7, zorder=0)
    ax.set_axisbelow(True)
    legend(ax, look)
    facts = [f"{number(degrees[0])}\u00b0"] * (len(degrees) == 1)
    facts += [f"{states[0]}-polarised" if states[0] in ("s", "p") else "unpolarised"] * (len(states) == 1)
    own = stack_name(stacks[0][1]) if len(stacks) == 1 else wanted[0].capitalize() if len(wanted) == 1 else "Spectra"
    heading(ax, look, title, own, ", ".join(facts))
    return ax


def _curves(
    stacks: list[tuple[str | None, Stack]],
    wanted: list[str],
    states: list[str],
    degrees: list[float],
    wavelengths: Floats,
) -> list[tuple[str, int, int, Floats]]:
    """Of each curve its label, the number of its colour, that of its dashes, and its values in percent."""
    count = len(stacks) * len(wanted) * len(states) * len(degrees)
    if count > _MOST_CURVES:
        raise complaint(
            f"{count} curves were asked for, a chart shows {_MOST_CURVES} at most",
            "stack",
            f"{_MOST_CURVES} curves at most",
            Words(count),
        )
    # Colours tell stacks and quantities apart; then dashes tell angles and polarisations. One thing has all colours.
    by_color = len(stacks) * len(wanted)
    by_style = len(degrees) * len(states)
    if by_color > 1 and by_style > len(_DASHES):
        raise complaint(
            f"{by_style} angles and polarisations were asked for; beside several stacks or quantities"
            f" a chart shows {len(_DASHES)} at most",
            "angle_deg",
            f"{len(_DASHES)} angles and polarisations at most",
            Words(by_style),
        )
    curves: list[tuple[str, int, int, Floats]] = []
    for row, ((label, one), name) in enumerate(product(stacks, wanted)):
        for column, (angle, state) in enumerate(product(degrees, states)):
            parts = [label or stack_name(one)] if len(stacks) > 1 or label else []
            parts += [name] * (len(wanted) > 1)
            parts += [f"{number(angle)}\u00b0"] * (len(degrees) > 1) + [state] * (len(states) > 1)
            values = 100.0 * getattr(one, name)(wavelengths, angle, state)
            curves.append(
                (", ".join(parts) or stack_name(one), *((row, column) if by_color > 1 else (column, 0)), values)
            )
    return curves


def _wavelengths(value: ArrayLike) -> Floats:
    given = real_operand("wavelength_nm", value, low=0.0, includes_low=False).full()
    if given.ndim != 1 or given.size < 2 or not (np.diff(given) > 0.0).all():
        raise refusal("wavelength_nm", "two ascending numbers or an ascending array", value)
    if given.size > 2:
        return given.copy()
    # Half a nanometre shows the fringes of 50 um of soap; a wider range is drawn with as many points.
    return np.linspace(given[0], given[1], int(np.clip(2.0 * (given[1] - given[0]), 200, 4000)) + 1)


def _known_visible(stacks: list[Stack]) -> tuple[float, float]:
    """What all media have data for within the visible; all of it where they share nothing, for the error of the stack."""
    spans = [span for stack in stacks for medium in stack.media if (span := medium.range_nm) is not None]
    low = max([SPECTRUM_NM[0], *(span[0] for span in spans)])
    high = min([SPECTRUM_NM[1], *(span[1] for span in spans)])
    return (low, high) if low < high else SPECTRUM_NM


def _stack(stack: StackLike) -> Stack:
    if isinstance(stack, str):
        parse_items(stack)  # its error tells what a text looks like
        stack = Stack.parse(stack)
    if not isinstance(stack, Stack):
        raise refusal("stack", "an iridesce.Stack or its text", stack)
    check_one_thickness(stack.layers, "a spectrum")
    return stack


def _limits(ax: Axes) -> None:
    """x: just the data of all curves; y: from 0, or less where something amplifies, to a little above the highest."""
    curves = [line for line in ax.get_lines() if line.get_gid() == "curve"]
    x = np.concatenate([np.asarray(line.get_xdata(), dtype=float) for line in curves])
    y = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in curves])
    low, high = min(float(y.min()), 0.0), max(float(y.max()), 1e-9)
    # Rounding leaves 1e-14 % of absorption in clear stacks: that is zero.
    ax.set(xlim=(x.min(), x.max()), ylim=(0.0 if low > -1e-9 else 1.06 * low, max(1.06 * high, 1e-6)))


def _band(ax: Axes, theme: Theme) -> None:
    """The visible colours between the axis and its numbers, as thick as the numbers are high, at any size of figure."""
    from matplotlib.collections import LineCollection
    from matplotlib.transforms import ScaledTranslation, blended_transform_factory

    for old in [one for one in ax.collections if one.get_gid() == "visible"]:
        old.remove()
    left, right = ax.get_xlim()
    start, end = max(left, SPECTRUM_NM[0]), min(right, SPECTRUM_NM[1])
    if start >= end:
        return
    figure = ax.get_figure(root=True)
    assert figure is not None, "Axes always have a figure"
    edges = np.linspace(start, end, 241)
    # Each piece reaches below the next one: pieces that only touch leave hairlines in PDF and SVG.
    pieces = [[(edges[i], 0.0), (edges[min(i + 2, 240)], 0.0)] for i in range(240)]
    below = blended_transform_factory(ax.transData, ax.transAxes) + ScaledTranslation(
        0.0, -5.0 / 72.0, figure.dpi_scale_trans
    )
    band = LineCollection(
        pieces,
        colors=monochromatic(0.5 * (edges[1:] + edges[:-1])),
        linewidths=7.0,
        capstyle="butt",
        transform=below,
        clip_on=False,
    )
    band.set_gid("visible")
    ax.add_collection(band, autolim=False)
    ax.tick_params(axis="x", length=0.0, pad=12.0)
