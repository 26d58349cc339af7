"""Strips of colour against thickness or retardation. Internal."""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.color.screen import gains, gains_in_words, readable_on, screen
from iridesce.optics.wavelengths import VISIBLE_NM, in_steps
from iridesce.plot._arguments import Family, Stacks, angles, even, family, listed, samples
from iridesce.plot._style import SMALL, Theme, begin, circumstances, heading, number, shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ORDER_NM = 550.0
"""Retardation of one order of Newton's scale: one wavelength of green light."""

_NEWTON = "newton"
_ROMAN = ("I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X")
# Steps of 1 nm resolve sin^2(pi G / lambda) at 360 nm up to a quarter turn of phase a step; colour ends long before.
_MOST_RETARDATION_NM = 3e4


@dataclass(frozen=True)
class _Row:
    """One strip; ``film`` is ``None`` for Newton's own scale."""

    label: str
    film: Family | None
    angle_deg: float


def strip(
    stack: Stacks = _NEWTON,
    thickness_nm: ArrayLike | None = None,
    angle_deg: ArrayLike = 0.0,
    *,
    layer: int | str | None = None,
    retardation_nm: ArrayLike | None = None,
    orders: bool | None = None,
    illuminant: str | os.PathLike[str] | color.Illuminant = "D65",
    observer: str = "cie1931",
    polarization: str = "unpolarized",
    quantity: str = "reflectance",
    model: str = "exact",
    exposure: float | str = "auto",
    title: str | None = None,
    theme: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Strips of colour: how a film changes as it thickens, for one or more stacks and angles, one below the other.

    Against ``retardation_nm``, G = 2 n d cos(theta) at 550 nm, films of any index and angle line up by their orders,
    and ``"newton"`` is Newton's colour scale: sin^2(pi G / lambda), two equal waves of which one lost half a turn, as in
    an air gap between glasses or a retarder between crossed polarisers. An order ends every 550 nm.

    stack          a stack or its text; a list of them; a dict {label: stack}; "newton" among them or alone
    thickness_nm   (first, last) or evenly spaced ascending values, up to 1e5 nm; None: the values the layer has, or 0 to
                   2000 nm                                                                                     (n,)
    angle_deg      incidence in the first medium, [0, 90); several: one strip each                              (m,)
    layer          the layer that grows, where there are several
    retardation_nm  (first, last) or evenly spaced values instead of ``thickness_nm``, up to 3e4 nm; "newton" alone has
                   0 to 2200 nm
    orders         mark where the retardation is 550, 1100, 1650 nm, ...; None: with ``retardation_nm`` only
    illuminant, observer, polarization, quantity, model  as for `Stack.color`
    exposure, title, theme, ax  see `iridesce.plot`
    Returns        the Axes; the strips are its images, from top to bottom
    Raises         ValueError naming the argument, the value and what is allowed
    Source         M. Born and E. Wolf, Principles of Optics, 7th ed., sec. 7.6 (films), 15.4 (crossed polarisers)

    >>> import iridesce as ir
    >>> ax = ir.plot.strip("air / soap / air", thickness_nm=(0, 1000), angle_deg=[0, 45])
    >>> [label.get_text() for label in ax.get_yticklabels()], len(ax.images)
    (['0\N{DEGREE SIGN}', '45\N{DEGREE SIGN}'], 2)
    """
    several = angles(angle_deg)
    rows = _rows(stack, several, layer)
    has_newton = any(row.film is None for row in rows)
    if thickness_nm is not None and (retardation_nm is not None or has_newton):
        raise complaint(
            'thickness_nm and retardation_nm exclude each other, and "newton" has a retardation only',
            "retardation_nm",
            "given instead of thickness_nm, or left out",
            Words("both"),
        )
    by_retardation = retardation_nm is not None or has_newton
    across = _retardations(retardation_nm) if by_retardation else _thicknesses(thickness_nm, rows)
    even("retardation_nm" if by_retardation else "thickness_nm", across)
    light = color.illuminant(illuminant)
    options = {"polarization": polarization, "observer": observer, "quantity": quantity, "model": model}
    colors = np.stack([_colors(row, across, by_retardation, light, options) for row in rows])
    factors = gains(colors, exposure)

    ax, look = begin(ax, theme, (8.6, 1.35 + 0.52 * len(rows)))
    shown = screen(colors, factors)
    _draw_rows(ax, look, rows, across, shown)
    growing = {row.film.medium.name for row in rows if row.film is not None}
    of_what = f"{growing.pop()} thickness" if len(growing) == 1 else "thickness"
    ax.set_xlabel("retardation (nm)" if by_retardation else f"{of_what} (nm)")
    if by_retardation if orders is None else orders:
        for number_, row in enumerate(rows):
            _mark_orders(ax, row, number_, across, by_retardation, shown[number_])
    only_angle = "" if len(several) > 1 or rows[0].film is None else f"{number(several[0])}\u00b0"
    facts = circumstances(
        f"illuminant {shortened(light.name)}",
        only_angle,
        gains_in_words(factors, "each strip"),
        polarization=polarization,
        quantity=quantity,
        model=model,
    )
    names = {row.film.name if row.film else "Newton's colour scale" for row in rows}
    heading(ax, look, title, names.pop() if len(names) == 1 else "Interference colours", facts)
    return ax


def _draw_rows(ax: Axes, look: Theme, rows: list[_Row], across: Floats, shown: Floats) -> None:
    """The strips from top to bottom, named on the left where there are several."""
    half = 0.5 * (across[1] - across[0])
    for number_, rgb in enumerate(shown):
        extent = (across[0] - half, across[-1] + half, number_ + 0.46, number_ - 0.46)
        ax.imshow(rgb[None], extent=extent, aspect="auto", interpolation="nearest", zorder=2)
    ax.set(xlim=(across[0], across[-1]), ylim=(len(rows) - 0.5, -0.5))
    ax.set_yticks(range(len(rows)), [row.label for row in rows] if len(rows) > 1 else [""])
    ax.tick_params(axis="y", length=0.0, labelcolor=look.ink, labelsize=SMALL)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)


def _retardations(asked: ArrayLike | None) -> Floats:
    across = samples("retardation_nm", asked, None, (0.0, 4.0 * ORDER_NM), step=1.0)
    if across[-1] > _MOST_RETARDATION_NM:
        raise refusal("retardation_nm", f"at most {_MOST_RETARDATION_NM:g} nm", Words(f"{across[-1]:g}"))
    return across


def _thicknesses(asked: ArrayLike | None, rows: list[_Row]) -> Floats:
    own = next((film.own_thicknesses() for row in rows if (film := row.film) is not None), None)
    return samples("thickness_nm", asked, own, (0.0, 2000.0), step=1.0)


def _rows(stack: Stacks, several: list[float], layer: int | str | None) -> list[_Row]:
    """Each stack at each angle, labelled by what tells it apart."""
    entries = listed(stack)
    rows = []
    for label, one in entries:
        if isinstance(one, str) and one.strip().lower() == _NEWTON:
            rows.append(_Row(label or "Newton's scale", None, 0.0))
            continue
        film = family(one, layer)
        name = label or film.name
        for angle in several:
            degrees = f"{number(angle)}\u00b0"
            by_angle = len(several) > 1
            rows.append(
                _Row(
                    f"{name}, {degrees}" if by_angle and len(entries) > 1 else degrees if by_angle else name,
                    film,
                    angle,
                )
            )
    return rows


def _colors(
    row: _Row, across: Floats, by_retardation: bool, light: color.Illuminant, options: dict[str, str]
) -> Floats:
    """XYZ along a strip: (n, 3)."""
    if row.film is None:
        return newton_xyz(across, light, options["observer"])
    thickness = across / row.film.optical_factor(row.angle_deg) if by_retardation else across
    return row.film.at(thickness).color(
        row.angle_deg,
        options["polarization"],
        light,
        options["observer"],
        quantity=options["quantity"],
        model=options["model"],
    )


def newton_xyz(retardation_nm: Floats, light: color.Illuminant, observer: str = "cie1931") -> Floats:
    """XYZ of sin^2(pi G / lambda), the scale with a black centre: (..., 3)."""
    wavelength_nm = in_steps(VISIBLE_NM, 1.0)
    spectra = np.sin(np.pi * retardation_nm[..., None] / wavelength_nm) ** 2
    return color.spectrum_to_xyz(wavelength_nm, spectra, light, observer)


def _mark_orders(ax: Axes, row: _Row, number_: int, across: Floats, by_retardation: bool, rgb: Floats) -> None:
    """Ends of the orders as notches at both edges of a strip, and the numbers of the first ten inside it."""
    per_nm = 1.0 if by_retardation or row.film is None else row.film.optical_factor(row.angle_deg)
    ends = ORDER_NM / per_nm * np.arange(0, np.floor(across[-1] * per_nm / ORDER_NM + 1e-9) + 2.0)
    for order, (start, end) in enumerate(pairwise(ends)):
        if across[0] < end < across[-1]:
            ink = readable_on(rgb[int(np.argmin(np.abs(across - end)))])
            for edge, inner in ((-0.46, -0.30), (0.46, 0.30)):
                ax.plot([end, end], [number_ + edge, number_ + inner], color=ink, linewidth=1.2, zorder=3, gid="order")
        middle = 0.5 * (max(start, across[0]) + min(end, across[-1]))
        fits = min(end, across[-1]) - max(start, across[0]) > 0.05 * (across[-1] - across[0])
        if order < len(_ROMAN) and fits:
            ink = readable_on(rgb[int(np.argmin(np.abs(across - middle)))])
            name = ax.text(
                middle, number_, _ROMAN[order], color=ink, fontsize=SMALL, ha="center", va="center", zorder=3
            )
            name.set_gid("order-name")
