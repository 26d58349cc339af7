"""What the channels of a calibrated rig see, over wavelength. Internal; `CameraCalibration.plot` calls it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from iridesce.arguments.operands import Floats
from iridesce.plot._style import begin, heading, legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Each channel in its own colour, and with a line of its own for eyes and printers that tell none.
_CHANNELS = (("red", "#c8372d", "solid"), ("green", "#2e8b3d", (0, (5, 1.5))), ("blue", "#2f62c4", (0, (1.5, 1.2))))


class Rig(Protocol):
    """What is drawn of a calibration."""

    @property
    def wavelength_nm(self) -> Floats: ...
    @property
    def response(self) -> Floats: ...
    @property
    def stack(self) -> str: ...
    @property
    def misfit(self) -> float: ...


def plot(rig: Rig, ax: Axes | None, title: str | None, theme: str | None) -> Axes:
    """A curve for each channel, over the largest of all."""
    ax, look = begin(ax, theme, (7.6, 4.6))
    largest = max(float(rig.response.max()), 1e-300)
    for column, (name, tone, dashes) in zip(rig.response.T, _CHANNELS, strict=True):
        ax.plot(
            rig.wavelength_nm, column / largest, color=tone, linestyle=dashes, linewidth=1.8, label=name, gid="channel"
        )
    ax.axhline(0.0, color=look.faint, linewidth=0.7, zorder=0)
    ax.set_xlim(rig.wavelength_nm[0], rig.wavelength_nm[-1])
    ax.set_xlabel("vacuum wavelength (nm)")
    ax.set_ylabel("response, of the largest")
    legend(ax, look)
    heading(
        ax, look, title, rig.stack, f"learnt from this film, which leaves {100.0 * rig.misfit:.1f} % of its contrast"
    )
    return ax
