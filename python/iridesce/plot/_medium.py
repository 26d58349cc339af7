"""The index of a medium against wavelength. Internal."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from iridesce.arguments.operands import Floats, real_operand
from iridesce.arguments.refusals import complaint, refusal
from iridesce.optics.medium import Medium, MediumLike
from iridesce.optics.wavelengths import VISIBLE_NM
from iridesce.plot._style import SMALL, Theme, begin, heading

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SHOWN_NM = (300.0, 1000.0)


def medium(
    medium: MediumLike,
    wavelength_nm: ArrayLike | None = None,
    *,
    title: str | None = None,
    theme: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Refractive index n (left axis) and extinction k (right axis) against wavelength, the source under the title.

    Full lines are data; dashed lines in a shaded field are the stated extension by which colour sums and renders
    continue them over 360..830 nm. Where k is zero throughout, only n is drawn.

    medium         name, `iridesce.Medium`, or a number
    wavelength_nm  (first, last) or ascending values, vacuum nm; None: 300 to 1000 nm as far as there are data, and
                   360 to 830 nm where they are extended                                                       (n,)
    title, theme, ax  see `iridesce.plot`
    Returns        the Axes of n
    Raises         ValueError naming the argument, the value and what is allowed; a wavelength that neither the data nor
                   their extension reach

    >>> import iridesce as ir
    >>> ax = ir.plot.medium("TiO2-siefke")
    >>> ax.get_ylabel(), ax.get_title(loc="left")
    ('refractive index n', 'TiO2-siefke')
    """
    shown = medium if isinstance(medium, Medium) else Medium(medium)
    wavelengths = _wavelengths(shown, wavelength_nm)
    index, extended = _index(shown, wavelengths)
    n, k = index.real, index.imag
    absorbs = bool(np.any(k != 0.0))

    ax, look = begin(ax, theme, (7.6, 4.6))
    _curve(ax, wavelengths, n, extended, look.series[0], "n")
    ax.set_xlim(wavelengths[0], wavelengths[-1])
    ax.set_xlabel("vacuum wavelength (nm)")
    ax.set_ylabel("refractive index n", color=look.series[0] if absorbs else look.ink)
    _room(ax, n, least=0.02)
    if absorbs:
        right = ax.twinx()
        right.set_gid("k-axis")
        right.patch.set_visible(False)
        _curve(right, wavelengths, k, extended, look.series[1], "k")
        right.set_ylabel("extinction coefficient k", color=look.series[1])
        _room(right, k, least=1e-4, floor=0.0 if k.min() >= 0.0 else None)
        for side, spine in right.spines.items():
            spine.set_visible(side == "right")
            spine.set_color(look.series[1])
        ax.spines["left"].set_color(look.series[0])
        ax.tick_params(axis="y", color=look.series[0], labelcolor=look.series[0])
        right.tick_params(axis="y", color=look.series[1], labelcolor=look.series[1])
    _mark_extension(ax, look, wavelengths, extended)
    span = shown.range_nm
    reach = "the same at every wavelength" if span is None else f"data {span[0]:g} to {span[1]:g} nm"
    reach += "; dashed: extended" if extended.any() else ""
    clear = "" if absorbs else "; k = 0 throughout"
    source = "\n".join(textwrap.wrap(" ".join(shown.source.split()), 96, max_lines=3, placeholder=" \u2026"))
    heading(ax, look, title, shown.name, f"{source}\n{reach}{clear}" if source else f"{reach}{clear}")
    return ax


def _wavelengths(medium: Medium, value: ArrayLike | None) -> Floats:
    if value is None:
        first, last = medium.range_nm or _SHOWN_NM
        low, high = max(first, _SHOWN_NM[0]), min(last, _SHOWN_NM[1])
        if medium.extension is not None:
            low, high = min(low, VISIBLE_NM[0]), max(high, VISIBLE_NM[1])
        if not low < high:  # data of another part of the spectrum
            low, high = first, last
        if not low < high:
            raise complaint(
                f'medium "{medium.name}" has data at {first:g} nm only: that is no curve',
                "media",
                "media with data at more than one wavelength",
                medium.name,
            )
        return np.linspace(low, high, 701)
    given = real_operand("wavelength_nm", value, low=0.0, includes_low=False).full()
    if given.ndim != 1 or given.size < 2 or not (np.diff(given) > 0.0).all():
        raise refusal("wavelength_nm", "two ascending numbers or an ascending array", value)
    return given.copy() if given.size > 2 else np.linspace(given[0], given[1], 701)


def _index(medium: Medium, wavelengths: Floats) -> tuple[NDArray[np.complex128], NDArray[np.bool_]]:
    """The index, and where it is the extension."""
    span = medium.range_nm
    outside = np.zeros(wavelengths.shape, dtype=bool)
    if span is not None:
        # The ends of a table in um are not the same doubles as its ends in nm.
        outside = (wavelengths < span[0] * (1.0 - 1e-12)) | (wavelengths > span[1] * (1.0 + 1e-12))
        if not outside.all():
            wavelengths = np.where(outside, wavelengths, np.clip(wavelengths, *span))
    reached = (wavelengths >= VISIBLE_NM[0]) & (wavelengths <= VISIBLE_NM[1])
    if not outside.any() or medium.extension is None or not reached[outside].all():
        return np.asarray(medium.index(wavelengths)), outside  # its error names what is out of reach
    return np.asarray(medium._core.index_extended(np.ascontiguousarray(wavelengths))[0]), outside


def _curve(ax: Axes, x: Floats, y: Floats, extended: NDArray[np.bool_], color: str, name: str) -> None:
    """Full where there are data, dashed where they are extended; the dashes begin where the line ends."""
    for inside, style, gid in ((~extended, "solid", name), (extended, (0, (2.5, 1.5)), f"{name}-extended")):
        if not inside.any():
            continue
        wider = inside.copy()
        if gid != name:
            wider[:-1] |= inside[1:]
            wider[1:] |= inside[:-1]
        ax.plot(x, np.where(wider, y, np.nan), color=color, linestyle=style, linewidth=1.9, zorder=3, gid=gid)


def _room(ax: Axes, values: Floats, least: float, floor: float | None = None) -> None:
    """Limits with air above and below; a curve that hardly changes is not blown up to look as if it did."""
    low, high = float(values.min()), float(values.max())
    air = max(0.08 * (high - low), least)
    ax.set_ylim(low - air if floor is None else floor, high + air)


def _mark_extension(ax: Axes, theme: Theme, wavelengths: Floats, extended: NDArray[np.bool_]) -> None:
    if not extended.any():
        return
    edges = np.flatnonzero(np.diff(np.concatenate([[0], extended.astype(int), [0]])))
    for first, beyond in edges.reshape(-1, 2):
        start, end = wavelengths[max(first - (first > 0), 0)], wavelengths[min(beyond, wavelengths.size - 1)]
        ax.axvspan(start, end, color=theme.faint, alpha=0.45, linewidth=0.0, zorder=0, gid="extension")
        share = (end - start) / (wavelengths[-1] - wavelengths[0])
        if share < 0.05:  # no room for the word
            continue
        ax.annotate(
            "extended",
            (0.5 * (start + end), 0.0),
            xycoords=ax.get_xaxis_transform(),
            xytext=(0.0, 6.0),
            textcoords="offset points",
            color=theme.muted,
            fontsize=SMALL,
            ha="center",
            rotation=0 if share > 0.15 else 90,
            va="bottom",
        )
