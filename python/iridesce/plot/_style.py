"""How charts look: two themes, the reader's own font, no more ink than is needed. Internal."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from iridesce import _core
from iridesce.arguments.refusals import Words, refusal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Theme:
    """Colours by their task: the ground, what is written, what supports it, what must hardly be seen, and curves."""

    name: str
    paper: str
    ink: str
    muted: str
    faint: str
    series: tuple[str, ...]


# The curves tell apart for colour-blind readers too: they differ in lightness as well as in hue.
LIGHT = Theme(
    "light",
    paper="#ffffff",
    ink="#1a1b20",
    muted="#5c616b",
    faint="#d5d8de",
    series=("#1667b7", "#d4541a", "#0d8a66", "#8f3fa8", "#a97b00", "#5c616b"),
)
DARK = Theme(
    "dark",
    paper="#14151a",
    ink="#eef0f4",
    muted="#a2a8b4",
    faint="#3a3d47",
    series=("#62b2f7", "#ff9263", "#49cfa4", "#d29cec", "#efc55c", "#a2a8b4"),
)
_THEMES = {theme.name: theme for theme in (LIGHT, DARK)}
# Text is set a little smaller than the labels of the axes, whose size is the reader's (rcParams).
SMALL = "small"


def theme_named(name: str | None) -> Theme | None:
    """The theme of a name; ``None`` for ``None``."""
    if name is None:
        return None
    if not isinstance(name, str) or name not in _THEMES:
        raise refusal("theme", '"light", "dark" or None', name)
    return _THEMES[name]


def begin(ax: Axes | None, theme: str | None, size_inches: tuple[float, float]) -> tuple[Axes, Theme]:
    """The Axes to draw in, dressed, and its theme. A theme that was asked for also paints the ground."""
    from matplotlib.axes import Axes

    wanted = theme_named(theme)
    if ax is None:
        import matplotlib.pyplot as plt

        own, ax = plt.subplots(figsize=size_inches)
        own.set_layout_engine("constrained", w_pad=0.1, h_pad=0.1)
    elif not isinstance(ax, Axes):
        raise refusal("ax", "a matplotlib Axes or None", ax)
    if ax.name != "rectilinear":
        raise refusal("ax", "straight axes", Words(f"the projection {ax.name!r}"), must="have")
    figure = ax.get_figure(root=True)
    assert figure is not None, "Axes always have a figure"
    if wanted is None:
        chosen = _theme_of(figure, ax)
    else:
        chosen = wanted
        figure.set_facecolor(chosen.paper)
        ax.set_facecolor(chosen.paper)
    _dress(ax, chosen)
    return ax, chosen


def _theme_of(figure: Figure, ax: Axes) -> Theme:
    """The theme that can be read on the ground as it is; its paper is that ground."""
    from matplotlib.colors import to_hex, to_rgba

    ground = to_rgba(figure.get_facecolor())
    if ground[3] < 0.5:  # a transparent figure: the page below is white more often than not
        return LIGHT
    luminance = sum(weight * value for weight, value in zip(_core.REC709_LUMINANCE, ground, strict=False))
    theme = LIGHT if luminance > 0.4 else DARK
    ax.set_facecolor(ground)
    return replace(theme, paper=to_hex(ground))


def _dress(ax: Axes, theme: Theme) -> None:
    for side, spine in ax.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(theme.muted)
        spine.set_linewidth(0.8)
    ax.tick_params(which="both", color=theme.muted, labelcolor=theme.muted, labelsize="medium", width=0.8, length=3.5)
    for label in (ax.xaxis.label, ax.yaxis.label):
        label.set_color(theme.ink)


def heading(ax: Axes, theme: Theme, title: str | None, own_title: str, subtitle: str) -> None:
    """The title at the left in bold, the circumstances below it; ``title=""`` leaves out both."""
    if title is not None and not isinstance(title, str):
        raise refusal("title", "text or None", title)
    if title == "":
        return
    lines = subtitle.count("\n") + 1 if subtitle else 0
    text = own_title if title is None else title
    ax.set_title(text, loc="left", color=theme.ink, fontweight="bold", fontsize="large", pad=8.0 + 11.5 * lines)
    if subtitle:
        ax.annotate(
            subtitle,
            (0.0, 1.0),
            xytext=(0.0, 6.0),
            xycoords="axes fraction",
            textcoords="offset points",
            color=theme.muted,
            fontsize=SMALL,
            linespacing=1.3,
            gid="subtitle",
        )


def legend(ax: Axes, theme: Theme) -> None:
    """A legend without a box, where there is something to tell apart."""
    handles, labels = ax.get_legend_handles_labels()
    if len(labels) <= 1:
        return
    style = {"frameon": False, "labelcolor": theme.ink, "fontsize": SMALL}
    if len(labels) > 4:  # too many to stay clear of the curves
        ax.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.01, 1.0), **style)
    else:
        ax.legend(handles, labels, loc="best", **style)


def circumstances(*parts: str, polarization: str, quantity: str = "reflectance", model: str = "exact") -> str:
    """What stands under a title, joined; what is as usual is not said."""
    unusual = [
        f"{polarization}-polarised" if polarization != "unpolarized" else "",
        quantity if quantity != "reflectance" else "",
        "two-beam form of 1991" if model == "two-beam" else "",
    ]
    return ", ".join(part for part in (*parts, *unusual) if part)


def shortened(name: str, most: int = 28) -> str:
    """A name cut where it would run over its neighbours."""
    return name if len(name) <= most else name[: most - 1] + "\u2026"


def number(value: float) -> str:
    """A number as short as it is: 45, 0.5, 1e+05."""
    return f"{value:.6g}"
