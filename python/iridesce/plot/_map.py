"""Four panels of a thickness map. Internal; `ThicknessResult.plot` calls it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Map(Protocol):
    """What is drawn: `iridesce.inverse.maps.ThicknessResult` is one."""

    @property
    def thickness_nm(self) -> Any: ...
    @property
    def confidence(self) -> Any: ...
    @property
    def low_nm(self) -> Any: ...
    @property
    def high_nm(self) -> Any: ...
    @property
    def candidates_nm(self) -> Any: ...
    @property
    def anchor(self) -> str: ...
    def at(self, x: float, y: float) -> list[tuple[float, float]]: ...


def plot(result: Map, at: tuple[float, float] | None) -> Figure:
    """Thickness, confidence, half width of the interval, and candidates."""
    import matplotlib.pyplot as plt

    chosen = None if at is None else result.at(*at)
    figure, axes = plt.subplots(2, 2, figsize=(9.0, 7.0), layout="constrained")
    ranges = [_range(result.thickness_nm), (0.0, 1.0), _range(0.5 * (result.high_nm - result.low_nm))]
    panels = [
        (result.thickness_nm, "thickness (nm)", "viridis"),
        (result.confidence, f"confidence in the order (anchor: {result.anchor})", "cividis"),
        (0.5 * (result.high_nm - result.low_nm), "half width of the 95 % interval (nm)", "magma"),
    ]
    for ax, (values, title, colours), (low, high) in zip(axes.flat, panels, ranges, strict=False):
        shown = ax.imshow(values, cmap=colours, vmin=low, vmax=high, interpolation="nearest")
        figure.colorbar(shown, ax=ax, shrink=0.85)
        ax.set_title(title, fontsize="medium")
    last = axes[1, 1]
    if chosen is None:
        low, high = ranges[0]
        shown = last.imshow(result.candidates_nm[..., 1], cmap="viridis", vmin=low, vmax=high, interpolation="nearest")
        figure.colorbar(shown, ax=last, shrink=0.85)
        last.set_title("second candidate (nm)", fontsize="medium")
    else:
        assert at is not None
        axes[0, 0].plot(*at, marker="+", color="white", markersize=12)
        last.bar([nm for nm, _ in chosen], [weight for _, weight in chosen], width=8.0)
        last.set(xlabel="thickness (nm)", ylabel="probability", ylim=(0.0, 1.0))
        last.set_title(f"candidates of pixel ({at[0]:g}, {at[1]:g})", fontsize="medium")
    return figure


def _range(values: Any) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0, 1.0
    low, high = (float(value) for value in np.percentile(known, [0.5, 99.5]))
    return low, max(high, low + 1.0)
