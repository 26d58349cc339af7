"""The chromaticity diagram under a locus: spectral colours, the colours themselves, gamuts of screens. Internal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.color.screen import chromatic
from iridesce.plot._style import Theme

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Polygon

DIAGRAMS = ("xy", "uv")
GAMUTS = {
    "srgb": "sRGB",
    "display-p3": "Display P3",
    "rec2020": "Rec. 2020",
    "ntsc1953": "NTSC 1953",
    "acescg": "ACEScg",
}
_DASHES = {
    "srgb": "solid",
    "display-p3": (0, (6, 2)),
    "rec2020": (0, (3, 1.5)),
    "ntsc1953": (0, (1, 1.5)),
    "acescg": (0, (6, 2, 1, 2)),
}
_LIMITS = {"xy": ((-0.03, 0.77), (-0.03, 0.88)), "uv": ((-0.02, 0.65), (-0.02, 0.62))}
_LABELS = {"xy": ("$x$", "$y$"), "uv": ("$u'$", "$v'$")}
_MARKED_NM = (*range(460, 641, 20), 700)


def chromaticity(xyz: Floats, diagram: str) -> Floats:
    """x, y or u', v' of colours that are not black: (..., 2). CIE 1931; u', v' of CIE 1976."""
    x, y, z = np.moveaxis(np.asarray(xyz, dtype=np.float64), -1, 0)
    if diagram == "xy":
        upper, lower = (x, y), x + y + z
    else:
        upper, lower = (4.0 * x, 9.0 * y), x + 15.0 * y + 3.0 * z
    return np.asarray(np.stack(upper, axis=-1) / lower[..., None], dtype=np.float64)


def primaries(space: str) -> Floats:
    """XYZ of the red, green and blue of an RGB space: (3, 3)."""
    return np.asarray(np.linalg.inv(color.rgb_matrix(space)).T, dtype=np.float64)


def spectral_locus(wavelength_nm: Floats, diagram: str) -> Floats:
    """Chromaticities of pure wavelengths for the CIE 1931 observer: (..., 2)."""
    return chromaticity(color.color_matching(wavelength_nm), diagram)


def draw(ax: Axes, theme: Theme, diagram: str, gamuts: list[str], white: Floats, white_name: str) -> None:
    """Everything but the path of the film."""
    from matplotlib.patches import Polygon

    # Beyond 700 nm the locus stands still; below 390 nm the table's last digits make it tremble.
    outline = spectral_locus(np.arange(390.0, 701.0), diagram)
    shape = Polygon(outline, closed=True, transform=ax.transData, facecolor="none", edgecolor="none")
    ax.add_patch(shape)
    shape.set_gid("spectral-locus")
    _fill(ax, theme, diagram, shape)
    ax.plot(*outline.T, color=theme.muted, linewidth=1.1, zorder=2, solid_joinstyle="round")
    purple = outline[[0, -1]]
    ax.plot(*purple.T, color=theme.muted, linewidth=0.9, linestyle=(0, (4, 2)), zorder=2, gid="purple-line")
    _mark_wavelengths(ax, theme, diagram, outline.mean(axis=0))
    for space in gamuts:
        _draw_gamut(ax, theme, diagram, space)
    x, y = chromaticity(white, diagram)
    ax.plot(
        [x],
        [y],
        linestyle="none",
        marker="D",
        markersize=6.0,
        color=theme.paper,
        markeredgecolor=theme.ink,
        markeredgewidth=1.2,
        zorder=6,
        label=f"white: {white_name}",
        gid="white",
    )
    (left, right), (low, high) = _LIMITS[diagram]
    ax.set(xlim=(left, right), ylim=(low, high), aspect="equal", adjustable="box")
    ax.set_xlabel(_LABELS[diagram][0])
    ax.set_ylabel(_LABELS[diagram][1])


def _fill(ax: Axes, theme: Theme, diagram: str, shape: Polygon) -> None:
    """The diagram's colours, faintly: they are a map for the path, not the picture."""
    from matplotlib.colors import to_rgb

    (left, right), (low, high) = _LIMITS[diagram]
    across, up = np.meshgrid(np.linspace(left, right, 300), np.linspace(low, high, 300))
    if diagram == "uv":  # CIE 1976: x = 9 u' / (6 u' - 16 v' + 12), y = 4 v' / (6 u' - 16 v' + 12)
        scale = np.maximum(6.0 * across - 16.0 * up + 12.0, 1e-6)
        across, up = 9.0 * across / scale, 4.0 * up / scale
    y = np.maximum(up, 1e-4)
    linear = np.stack([across, y, 1.0 - across - y], axis=-1) @ color.rgb_matrix("linear-srgb").T
    linear = 0.5 * (linear + np.sqrt(linear**2 + 0.01))  # a soft floor, where the hard one leaves creases too
    # A soft maximum: the hard one leaves creases from the white to the corners of the gamut.
    linear /= np.maximum((linear**5).mean(axis=-1, keepdims=True) ** 0.2 * 1.2, 1e-6)
    rgb = np.clip(color.convert(np.clip(linear, 0.0, 1.0), "linear-srgb", "srgb"), 0.0, 1.0)
    share = 0.34 if theme.name == "light" else 0.30
    rgb = (1.0 - share) * np.asarray(to_rgb(theme.paper)) + share * rgb
    image = ax.imshow(rgb, extent=(left, right, low, high), origin="lower", interpolation="bilinear", zorder=1)
    image.set_clip_path(shape)


def _mark_wavelengths(ax: Axes, theme: Theme, diagram: str, middle: Floats) -> None:
    for nm in _MARKED_NM:
        here, ahead = spectral_locus(np.array([nm, min(nm + 2.0, 702.0)]), diagram)
        along = ahead - here
        outward = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-12)
        if outward @ (here - middle) < 0.0:
            outward = -outward
        if nm == 700:
            outward = np.array([1.0, 0.0])
        ax.plot(*here[:, None], marker="o", markersize=2.4, color=theme.muted, zorder=2)
        ax.annotate(
            f"{nm} nm" if nm == 520 else f"{nm}",
            here,
            xytext=(9.0 * outward[0], 9.0 * outward[1]),
            textcoords="offset points",
            color=theme.muted,
            fontsize="x-small",
            ha="center" if abs(outward[0]) < 0.5 else ("left" if outward[0] > 0 else "right"),
            va="center",
            zorder=2,
        )


def _draw_gamut(ax: Axes, theme: Theme, diagram: str, space: str) -> None:
    corners = chromaticity(primaries(space), diagram)
    ring = np.concatenate([corners, corners[:1]])
    ax.plot(
        *ring.T,
        color=theme.ink,
        linewidth=0.9,
        linestyle=_DASHES[space],
        alpha=0.75,
        zorder=3,
        label=GAMUTS[space],
        gid=f"gamut-{space}",
    )


def own_colors(xyz: Floats) -> Floats:
    """The colours in which a path is drawn: one for each of its pieces."""
    return chromatic(0.5 * (xyz[1:] + xyz[:-1]))
