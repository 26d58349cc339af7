"""Charts (``ir.plot``): the path of a film's colour, colour strips, thickness against angle, spectra, indices.

Every chart takes a matplotlib Axes (``ax=None`` makes a figure) and returns it, so that titles, limits and notes can be
changed afterwards. matplotlib is imported by the first call, not before.

``stack``      an `iridesce.Stack`, or its text. In a text the growing layer may leave out its thickness:
               ``"air / soap / air"``, ``"air / SiO2 ? / Si"``. ``layer`` names it where there are several: its medium,
               or its number counted from 1 in the order light meets them.
``theme``      ``"light"``, ``"dark"``, or ``None``: whichever suits the background that the figure has already
``title``      ``None`` writes one; ``""`` writes none
``exposure``   films reflect little: ``"auto"`` makes the brightest colour of each strip, or of each angle of a chart,
               as bright as the screen can; ``"common"`` treats all alike, so that they can be compared; a number
               is stops, 0 for the colours as they are. What was done stands under the title.

Colours are exact sums (`Stack.color`), then brought into sRGB with their hue kept.
"""

from __future__ import annotations

from iridesce.plot._chart import chart
from iridesce.plot._locus import locus
from iridesce.plot._medium import medium
from iridesce.plot._reachable import reachable
from iridesce.plot._spectrum import spectrum
from iridesce.plot._strip import strip

__all__ = ["chart", "locus", "medium", "reachable", "spectrum", "strip"]


def __dir__() -> list[str]:
    return __all__
