"""Recipes as points: how near their colours are, how safely they are made. Internal; `RecipeList.plot` calls it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from iridesce import color
from iridesce.plot._style import begin, heading

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_NAMED = 6


def plot(found: Sequence[Any], ax: Axes | None, title: str | None, theme: str | None) -> Axes:
    """A point a recipe, in its own colour; the best are named."""
    ax, look = begin(ax, theme, (7.6, 4.6))
    lab = np.array([one.lab for one in found]).reshape(-1, 3)
    rgb = color.map_gamut(color.convert(lab, "lab", "srgb"))[0] if len(found) else np.empty((0, 3))
    ax.scatter(
        [one.delta_e for one in found],
        [100.0 * one.yield_ for one in found],
        c=np.clip(rgb, 0.0, 1.0),
        s=90.0,
        edgecolors=look.muted,
        linewidths=0.8,
        zorder=3,
        gid="recipes",
    )
    for one in found[:_NAMED]:
        ax.annotate(
            one.text,
            (one.delta_e, 100.0 * one.yield_),
            xytext=(8, 0),
            textcoords="offset points",
            va="center",
            fontsize=8,
            color=look.muted,
        )
    ax.set_xlim(left=0.0)
    ax.set_ylim(-3.0, 103.0)
    ax.set_xlabel("CIEDE2000 from the target")
    ax.set_ylabel("yield (%)")
    ax.grid(axis="y", color=look.faint, linewidth=0.7, zorder=0)
    words = f"{len(found)} film{'' if len(found) == 1 else 's'}"
    if len(found) == 1 and not found[0].reachable:
        words = "not reachable; the nearest film"
    heading(ax, look, title, "Films of one colour", words)
    return ax
