"""The path of a film's colour in the chromaticity diagram. Internal."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.plot import _diagram
from iridesce.plot._arguments import Family, StackLike, family, one_angle, samples, words
from iridesce.plot._style import SMALL, Theme, begin, circumstances, heading, number, shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MODELS = ("exact", "two-beam")
_NEAR = (4.5, 9.0, 15.0)  # gaps between dot and text, points; beyond the first a thin line joins them
_CASING = "#17181d"
_IN_WORDS = {"exact": "exact", "two-beam": "two-beam form of 1991"}


def locus(
    stack: StackLike,
    thickness_nm: ArrayLike | None = None,
    angle_deg: float = 0.0,
    *,
    layer: int | str | None = None,
    illuminant: str | os.PathLike[str] | color.Illuminant = "D65",
    polarization: str = "unpolarized",
    quantity: str = "reflectance",
    model: str = "exact",
    diagram: str = "xy",
    gamuts: str | Sequence[str] = ("srgb", "rec2020"),
    tick_nm: float | None = None,
    zoom: bool = False,
    title: str | None = None,
    theme: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The path of a film's colour in the CIE 1931 diagram as the film thickens: the figure of the 1991 paper.

    The path is drawn in its own colours (as bright as sRGB shows them), with dots every ``tick_nm`` and their thickness
    in nm beside them where there is room. Around it: the spectral colours, the line of purples, triangles of screens,
    the light's white point. Thicknesses at which the film is black have no chromaticity and are left out.

    stack          `iridesce.Stack` or text such as "air / soap / air"; see `iridesce.plot`
    thickness_nm   (first, last), filled in steps of 2 nm or a little more, or ascending values taken as they are, up to
                   1e5 nm; None: the values that the layer has, or 0 to 2000 nm                            (n,)
    angle_deg      incidence in the first medium, [0, 90)
    layer          the layer that grows, where there are several
    illuminant, polarization, quantity  as for `Stack.color`
    model          "exact", "two-beam" (the form of 1991), or "both": the two-beam path as a thin dashed line over it
    diagram        "xy" | "uv" (CIE 1976 u', v')
    gamuts         any of "srgb", "display-p3", "rec2020", "ntsc1953", "acescg"
    tick_nm        distance of the dots; None: a round one
    zoom           True: the limits fit the path instead of the whole diagram
    title, theme, ax  see `iridesce.plot`
    Returns        the Axes
    Raises         ValueError naming the argument, the value and what is allowed
    Source         the figure: M. L. Dias, IEEE Computer Graphics and Applications 11(2), 1991; CIE 15:2004

    >>> import iridesce as ir
    >>> ax = ir.plot.locus("air / soap / air", thickness_nm=(0, 1000), model="both", gamuts="ntsc1953", illuminant="C")
    >>> ax.get_xlabel(), [line.get_label() for line in ax.get_lines() if line.get_gid() == "gamut-ntsc1953"]
    ('$x$', ['NTSC 1953'])
    """
    film = family(stack, layer)
    thickness = samples("thickness_nm", thickness_nm, film.own_thicknesses(), (0.0, 2000.0), step=2.0)
    angle = one_angle(angle_deg)
    (place,) = words("diagram", _only(diagram), _diagram.DIAGRAMS)
    triangles = words("gamuts", gamuts, tuple(_diagram.GAMUTS), may_be_none=True)
    models = list(_MODELS) if model == "both" else words("model", _only(model), (*_MODELS, "both"))
    step = _tick_step(tick_nm, thickness)
    light = color.illuminant(illuminant)
    paths = [_lit_path(film, thickness, angle, polarization, light, quantity, one) for one in models]

    ax, look = begin(ax, theme, (6.4, 7.0))
    _diagram.draw(ax, look, place, triangles, light.white(), shortened(light.name))
    white = _diagram.chromaticity(light.white(), place)
    for one, (nm, xyz) in zip(models, paths, strict=True):
        points = _diagram.chromaticity(xyz, place)
        if one == "two-beam" and len(paths) == 2:
            ax.plot(*points.T, color=look.ink, linewidth=0.9, linestyle=(0, (3, 1.5)), zorder=5, label=_IN_WORDS[one])
            ax.get_lines()[-1].set_gid("path-two-beam")
            continue
        _draw_path(ax, points, xyz, f"path-{one}")
        if zoom:
            _zoom(ax, points, white)
        main = nm, points
    # The corner of each diagram that holds no colours.
    handles, labels = ax.get_legend_handles_labels()
    style: dict[str, Any] = {"frameon": False, "labelcolor": look.ink, "fontsize": SMALL}
    ax.legend(handles, labels, loc="best" if zoom else "upper right" if place == "xy" else "lower right", **style)
    which = _IN_WORDS[models[0]] if len(models) == 1 else "exact, and two-beam form of 1991 (dashed)"
    facts = circumstances(
        which,
        f"illuminant {shortened(light.name)}",
        f"{number(angle)}\u00b0",
        polarization=polarization,
        quantity=quantity,
    )
    heading(ax, look, title, film.name, f"{facts}\n{thickness[0]:g} to {thickness[-1]:g} nm, a dot every {step:g} nm")
    _mark_thicknesses(ax, look, *main, step, white)
    return ax


def _lit_path(
    film: Family,
    thickness: Floats,
    angle: float,
    polarization: str,
    light: color.Illuminant,
    quantity: str,
    model: str,
) -> tuple[Floats, Floats]:
    """The thicknesses at which the film is not black, and its XYZ there."""
    xyz = film.at(thickness).color(angle, polarization, light, quantity=quantity, model=model)
    lit = xyz.sum(axis=-1) > 1e-12
    if lit.sum() < 2:
        raise complaint(
            f"{film.name} is black at every thickness asked for: it has no path",
            "stack",
            "a film with light in it",
            Words(film.name),
        )
    return thickness[lit], xyz[lit]


def _draw_path(ax: Axes, points: Floats, xyz: Floats, gid: str) -> None:
    """A path in its own colours."""
    from matplotlib.collections import LineCollection

    # The dark casing tells the path from the ground, which has the same colours.
    ax.plot(*points.T, color=_CASING, linewidth=3.4, zorder=4, solid_joinstyle="round", gid="casing")
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    path = LineCollection(list(pieces), colors=_diagram.own_colors(xyz), linewidths=2.0, capstyle="round", zorder=4.5)
    path.set_gid(gid)
    ax.add_collection(path, autolim=False)


def _only(value: Any) -> Any:
    """A single word where lists are not meant; anything else falls through to the error."""
    return [value]


def _tick_step(tick_nm: float | None, thickness: Floats) -> float:
    span = float(thickness[-1] - thickness[0])
    if tick_nm is None:
        wanted = span / 20.0
        power = 10.0 ** np.floor(np.log10(wanted))
        return float(next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= wanted))
    if isinstance(tick_nm, bool) or not isinstance(tick_nm, int | float | np.number) or not tick_nm > 0.0:
        raise refusal("tick_nm", "> 0, in nm, or None", tick_nm)
    if span / tick_nm > 1000.0:
        raise complaint(
            f"tick_nm={tick_nm:g} asks for more than 1000 dots", "tick_nm", "one that makes 1000 dots at most", tick_nm
        )
    return float(tick_nm)


def _zoom(ax: Axes, points: Floats, white: Floats) -> None:
    """Limits around the path and the white point, square, so that angles and distances stay true."""
    both = np.vstack([points, white])
    low, high = both.min(axis=0), both.max(axis=0)
    middle, half = (low + high) / 2.0, max(0.56 * float((high - low).max()), 0.01)
    ax.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))


def _mark_thicknesses(ax: Axes, theme: Theme, nm: Floats, points: Floats, step: float, white: Floats) -> None:
    """Dots at round thicknesses; labels where they cover neither one another nor the path."""
    marks = step * np.arange(np.ceil(nm[0] / step), np.floor(nm[-1] / step + 1e-9) + 1.0)
    marks = marks[(marks >= nm[0]) & (marks <= nm[-1])]
    if marks.size == 0:
        return
    at = np.column_stack([np.interp(marks, nm, points[:, axis]) for axis in (0, 1)])
    ax.plot(
        *at.T,
        linestyle="none",
        marker="o",
        markersize=4.2,
        color=theme.paper,
        markeredgecolor=theme.ink,
        markeredgewidth=0.9,
        zorder=5,
        gid="ticks",
    )
    _label(ax, theme, marks, at, points, white)


def _label(ax: Axes, theme: Theme, marks: Floats, at: Floats, points: Floats, white: Floats) -> None:
    """Texts beside dots, each in the nearest place that is free; without a free one a dot has no text.

    Places are found for the figure's present size and layout, in points (1/72 inch).
    """
    from matplotlib.font_manager import FontProperties
    from matplotlib.patheffects import withStroke

    figure = ax.get_figure(root=True)
    assert figure is not None, "Axes always have a figure"
    figure.draw_without_rendering()  # gives the axes the size at which texts will be beside their dots
    scale = 72.0 / figure.dpi

    def in_points(places: Floats) -> Floats:
        return np.asarray(ax.transData.transform(places)) * scale

    line, dots, center = _dense(in_points(points)), in_points(at), in_points(white[None, :])[0]
    size = FontProperties(size="x-small").get_size_in_points()
    taken: list[tuple[float, ...]] = []
    for mark, place, dot in zip(marks, at, dots, strict=True):
        text = f"{mark:g}"
        half = 0.5 * size * np.array([0.65 * len(text), 1.0])
        away = float(np.arctan2(*(dot - center)[::-1]))
        found = _free_place(dot, half, away, line, dots, taken)
        if found is None:
            continue
        middle, reach = found
        taken.append((*(dot + middle - half), *(dot + middle + half)))
        leader = {"arrowstyle": "-", "color": theme.ink, "linewidth": 0.6, "shrinkA": 0.5, "shrinkB": 2.0}
        ax.annotate(
            text,
            (place[0], place[1]),
            xytext=(middle[0], middle[1]),
            textcoords="offset points",
            color=theme.ink,
            fontsize="x-small",
            ha="center",
            va="center",
            zorder=7,
            gid="tick-label",
            annotation_clip=True,
            arrowprops=leader if reach > _NEAR[0] else None,
            path_effects=[withStroke(linewidth=1.6, foreground=theme.paper, alpha=0.7)],
        )


def _free_place(
    dot: Floats, half: Floats, away: float, line: Floats, dots: Floats, taken: list[tuple[float, ...]]
) -> tuple[Floats, float] | None:
    """Where a text's middle may stand as seen from its dot: near before far, away from the white point before towards."""
    for reach in _NEAR:
        for turn in (0.0, 0.5, -0.5, 1.0, -1.0, 1.6, -1.6, 2.2, -2.2, 2.7, -2.7, 3.14):
            direction = np.array([np.cos(away + turn), np.sin(away + turn)])
            middle = direction * (reach + np.abs(direction) @ half)
            box = (*(dot + middle - half), *(dot + middle + half))
            if not (_inside(line, box, 0.5) or _inside(dots, box, 1.5) or any(_overlap(box, one) for one in taken)):
                return middle, reach
    return None


def _dense(points: Floats, step: float = 2.0) -> Floats:
    """Points along a line, at most ``step`` apart: the samples of a path may leap over a text."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    here = np.linspace(0.0, along[-1], int(min(along[-1] / step, 20000.0)) + 2)
    return np.column_stack([np.interp(here, along, points[:, axis]) for axis in (0, 1)])


def _inside(points: Floats, box: tuple[float, ...], margin: float) -> bool:
    x, y = points.T
    left, low, right, high = box
    within = (x > left - margin) & (x < right + margin) & (y > low - margin) & (y < high + margin)
    return bool(within.any())


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[2] + 1.0 and b[0] < a[2] + 1.0 and a[1] < b[3] and b[1] < a[3]
