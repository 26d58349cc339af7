"""A measured spectrum with the curves of its solutions. Internal; `FitResult.plot` calls it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.plot._style import begin, heading, legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_CURVES = 5
_DASHES = ("solid", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (6, 1.5, 1.5, 1.5)), (0, (3, 1, 1, 1)))


class Solution(Protocol):
    """What is drawn of one solution."""

    @property
    def thickness_nm(self) -> Any: ...
    @property
    def interval_nm(self) -> Any: ...
    @property
    def weight(self) -> float: ...
    @property
    def fitted(self) -> Floats: ...


class Fit(Protocol):
    """What is drawn of a fit: `iridesce.fit.FitResult` is one."""

    @property
    def wavelength_nm(self) -> Floats: ...
    @property
    def measured(self) -> Floats: ...
    @property
    def stack(self) -> str: ...
    @property
    def solutions(self) -> Sequence[Solution]: ...
    def __len__(self) -> int: ...


def plot(result: Fit, ax: Axes | None, title: str | None, theme: str | None) -> Axes:
    """Points, curves, and under the title what was found."""
    if getattr(result, "measurements", ()):
        return _together(result, ax, title, theme)
    ax, look = begin(ax, theme, (7.6, 4.6))
    nm, values = result.wavelength_nm, result.measured
    size = float(np.clip(1800.0 / nm.size, 1.2, 3.5))
    label = f"measured, {nm.size} points" if len(result) <= 3 else "measured"
    ax.plot(
        nm,
        values,
        linestyle="none",
        marker="o",
        markersize=size,
        markeredgewidth=0.0,
        color=look.muted,
        alpha=0.55,
        zorder=2,
        label=label,
        gid="measured",
    )
    for place, solution in enumerate(result.solutions[:_MOST_CURVES]):
        several = len(result) > 1
        ax.plot(
            nm,
            solution.fitted,
            color=look.series[place % len(look.series)],
            linestyle=_DASHES[place],
            linewidth=1.9 if place == 0 else 1.4,
            zorder=5 - place * 0.1,
            label=_words(solution) + (f", weight {solution.weight:.2g}" if several else ""),
            gid="fitted",
        )
    ax.set_xlim(nm[0], nm[-1])
    low, high = float(values.min()), float(values.max())
    # Of a measurement that does not vary, too.
    air = 0.08 * (high - low) or 0.08 * max(abs(high), 1e-12)
    ax.set_ylim(low - air, high + air * (3.5 if len(result) > 2 else 2.5))
    ax.set_xlabel("vacuum wavelength (nm)")
    ax.set_ylabel("measured" if not 0.0 <= low <= high <= 1.0 else "measured (ratio)")
    ax.grid(axis="y", color=look.faint, linewidth=0.7, zorder=0)
    ax.set_axisbelow(True)
    legend(ax, look)
    heading(ax, look, title, result.stack, _found(result))
    return ax


def _found(result: Fit) -> str:
    """What was found, for under the title."""
    if not result.solutions:
        return "no film can be told"
    best = result.solutions[0]
    more = len(result) - 1
    return f"{_interval(best)}" + (
        f"; {more} more plausible solution{'s' if more > 1 else ''}" if more else "; no other thickness is plausible"
    )


def _together(result: Any, ax: Axes | None, title: str | None, theme: str | None) -> Axes:
    """Measurements of a joint fit, each on its own scale, one above the other, with the curve of the best film."""
    ax, look = begin(ax, theme, (7.6, 5.4))
    best = result.solutions[0] if result.solutions else None
    end, ticks, labels = 0, [], []
    # Answers that were stored by earlier versions do not say how many points of each they used: all of them.
    points = result.points or [one.cleaned()[0].size for one in result.measurements]
    for level, (one, count) in enumerate(zip(result.measurements, points, strict=True)):
        part = slice(end, end + count)
        end += count
        nm, values = result.wavelength_nm[part], result.measured[part]
        low, size = float(values.min()), max(float(np.ptp(values)), 1e-12) / 0.85
        tone = look.series[level % len(look.series)]
        ax.plot(
            nm,
            (values - low) / size + level,
            linestyle="none",
            marker="o",
            markersize=2.4,
            markeredgewidth=0.0,
            color=look.muted,
            alpha=0.6,
            zorder=2,
            gid="measured",
        )
        if best is not None:
            ax.plot(nm, (best.fitted[part] - low) / size + level, color=tone, linewidth=1.7, zorder=4, gid="fitted")
        ticks += [level, level + 0.85]
        labels += [f"{low:.4g}", f"{low + 0.85 * size:.4g}"]
        ax.annotate(
            one.label,
            (0.01, level + 0.97),
            xycoords=("axes fraction", "data"),
            va="top",
            fontsize="small",
            color=tone,
        )
    ax.set_yticks(ticks, labels)
    ax.set_xlabel("vacuum wavelength (nm)")
    heading(ax, look, title, result.stack, _found(result))
    return ax


def _pairs(solution: Solution) -> list[tuple[float, tuple[float, float]]]:
    if isinstance(solution.thickness_nm, float):
        return [(solution.thickness_nm, solution.interval_nm)]
    return list(zip(solution.thickness_nm, solution.interval_nm, strict=True))


def _words(solution: Solution) -> str:
    return " + ".join(f"{value:.{_digits(high - low)}f} nm" for value, (low, high) in _pairs(solution))


def _interval(solution: Solution) -> str:
    return ", ".join(
        f"{low:.{_digits(high - low)}f} to {high:.{_digits(high - low)}f} nm" for _, (low, high) in _pairs(solution)
    )


def _digits(width: float) -> int:
    """As many digits as the interval is worth."""
    return 0 if width > 20.0 else 1 if width > 0.5 or width == 0.0 else 2
