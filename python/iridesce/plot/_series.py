"""A film's thickness in time. Internal; `SeriesResult.plot` calls it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from iridesce.plot._style import begin, heading, legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot(series: Any, ax: Axes | None, title: str | None, theme: str | None) -> Axes:
    """Points with their intervals; filled where the verdict is clear."""
    ax, look = begin(ax, theme, (7.6, 4.6))
    seen = np.isfinite(series.thickness_nm)
    clear = seen & (series.verdict == "clear")
    for part, label, face in ((clear, "clear", look.series[0]), (seen & ~clear, "not clear", "none")):
        if not part.any():
            continue
        h = series.thickness_nm[part]
        spread = np.abs(series.interval_nm[part].T - h)
        ax.errorbar(
            series.time_s[part], h, yerr=spread, fmt="none", ecolor=look.series[0], elinewidth=0.8, alpha=0.5, zorder=2
        )
        ax.plot(
            series.time_s[part],
            h,
            linestyle="none",
            marker="o",
            markersize=float(np.clip(900.0 / part.sum(), 2.0, 5.0)),
            markerfacecolor=face,
            markeredgecolor=look.series[0],
            markeredgewidth=0.8,
            zorder=3,
            label=label,
            gid=label,
        )
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel("time (s)" if not np.array_equal(series.time_s, np.arange(len(series))) else "spectrum")
    ax.set_ylabel("thickness (nm)")
    ax.grid(axis="y", color=look.faint, linewidth=0.7, zorder=0)
    if seen.any() and not clear[seen].all():
        legend(ax, look)
    words = ", ".join(f"{count} {word}" for word, count in series.counts().items() if count)
    heading(ax, look, title, series.stack, f"{len(series)} spectra: {words}")
    return ax
