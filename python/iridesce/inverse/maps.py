"""Thickness maps as answers: the likeliest thickness of each pixel, how sure its order is, what else it could be."""

from __future__ import annotations

import io
import math
import os
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from iridesce.arguments.scalars import file_name, number
from iridesce.thickness import ThicknessMap

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Values = npt.NDArray[np.float32]

# What fixes the order of a region, by its number in `anchors`.
ANCHORS = ("none", "color", "black film", "tie point")
SURE = 0.95
_LABELS = ("best nm", "low nm", "high nm", "confidence", "second nm", "second weight")


@dataclass(frozen=True, eq=False)
class ThicknessResult:
    """What a photograph says of a film.

    thickness_nm   the likeliest thickness; NaN where masked and where nothing can be told             (h, w)
    confidence     probability that its order is right (within a quarter of 550 nm / n); NaN as above  (h, w)
    low_nm, high_nm  hold the thickness with 95 % where the order is right, scale included             (h, w)
    candidates_nm, weights  the likeliest thicknesses and their probabilities, best first, NaN-padded  (h, w, k)
    scale_interval  (low, high): factors common to all pixels, 95 %
    anchor         what fixes the order of most pixels: "tie point", "black film" (the film goes down to nothing: also contact
                   or bare base), "color" (orders of which colours differ), "none"
    anchors        the same of each pixel's region: index of "none", "color", "black film", "tie point"   (h, w)
    notes          what a user should know, and why a map is not to be trusted
    calibration    camera, lamp, balance, gain, haze, noise, clip, temper, slopes, misfit and bias: how the picture was understood

    >>> import numpy as np
    >>> import iridesce as ir
    >>> nm = np.linspace(150.0, 600.0, 64) + np.zeros((48, 1))
    >>> film = ir.Stack(["air", ir.Layer("soap", nm), "air"])
    >>> photo = film.color(space="linear-srgb") + np.random.default_rng(1).normal(0.0, 5e-4, (48, 64, 3))
    >>> found = ir.map_thickness(photo, "air / soap ? / air", camera="srgb", illuminant="D65")
    >>> bool(np.mean(abs(found.thickness_nm - nm) < 10.0) > 0.98), found.anchor
    (True, 'color')
    """

    thickness_nm: Values = field(repr=False)
    confidence: Values = field(repr=False)
    low_nm: Values = field(repr=False)
    high_nm: Values = field(repr=False)
    candidates_nm: Values = field(repr=False)
    weights: Values = field(repr=False)
    scale_interval: tuple[float, float]
    anchor: str
    anchors: npt.NDArray[np.uint8] = field(repr=False)
    notes: tuple[str, ...]
    calibration: dict[str, Any]

    @property
    def best(self) -> ThicknessMap:
        """The likeliest thickness as a map, which holds numbers alone: 0 where nothing can be told (see ``thickness_nm``)."""
        return ThicknessMap(np.nan_to_num(self.thickness_nm, nan=0.0))

    @property
    def sure(self) -> float:
        """Share of the pixels with an answer whose confidence is above 0.95; 0 without any."""
        known = np.isfinite(self.thickness_nm)
        return float(np.mean(self.confidence[known] > SURE)) if known.any() else 0.0

    def save(self, path: str | os.PathLike[str], *, unknown_nm: float | None = None) -> None:
        """Pages of a TIFF, float32, in nm, which ImageJ opens as a stack: best, low, high, confidence, second candidate, its
        weight.

        path       ends in .tif or .tiff
        unknown_nm  what is written where there is no answer. None: NaN, which ImageJ leaves out of every mean, and which
                   `ThicknessMap.load` refuses, as no scene can be made of it; a number: this thickness, with confidence and
                   weight 0, so that every page can be loaded
        Raises     ValueError: another ending, unknown_nm < 0 or not finite; OSError where it cannot be written

        >>> import pathlib, tempfile
        >>> import numpy as np
        >>> import iridesce as ir
        >>> nm = np.linspace(150.0, 600.0, 64) + np.zeros((48, 1))
        >>> photo = ir.Stack(["air", ir.Layer("soap", nm), "air"]).color(space="linear-srgb")
        >>> mask = nm > 500.0
        >>> found = ir.map_thickness(photo, "air / soap ? / air", camera="srgb", illuminant="D65", mask=mask)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     found.save(pathlib.Path(folder, "map.tif"), unknown_nm=0.0)
        ...     grid = ir.thickness.ThicknessMap.load(pathlib.Path(folder, "map.tif"), page=1)
        >>> grid.width, float(grid.thickness_nm[mask].max()), bool(abs(grid.thickness_nm - nm)[~mask].max() < 10.0)
        (64, 0.0, True)
        """
        from iridesce.files.whole import write_whole

        name = file_name(path, (".tif", ".tiff"))
        pages = [self.thickness_nm, self.low_nm, self.high_nm, self.confidence]
        pages += [self.candidates_nm[..., 1], self.weights[..., 1]]
        if unknown_nm is not None:
            thickness = np.float32(number("unknown_nm", unknown_nm, low=0.0, high=math.inf))
            filled = (thickness, thickness, thickness, np.float32(0.0), thickness, np.float32(0.0))
            pages = [np.where(np.isnan(page), value, page) for page, value in zip(pages, filled, strict=True)]
        write_whole(Path(name), _tiff(pages, _LABELS))

    def to_dict(self) -> dict[str, Any]:
        """The answer over all pixels, as plain values for JSON.

        Returns    dict of pixels, mapped, sure, thickness_nm (5, 50, 95 %), scale_interval, anchor, notes, calibration
        Raises     nothing

        >>> import numpy as np
        >>> import iridesce as ir
        >>> found = ir.map_thickness(np.zeros((8, 8, 3)), "air / soap ? / air", camera="srgb", illuminant="D65")
        >>> found.to_dict()["sure"], found.to_dict()["mapped"]
        (0.0, 0)
        """
        known = np.isfinite(self.thickness_nm)
        values = self.thickness_nm[known]
        return {
            "pixels": int(known.size),
            "mapped": int(known.sum()),
            "sure": round(self.sure, 4),
            "thickness_nm": [round(float(v), 2) for v in np.percentile(values, [5, 50, 95])] if known.any() else [],
            "scale_interval": [round(float(v), 5) for v in self.scale_interval],
            "anchor": self.anchor,
            "notes": list(self.notes),
            "calibration": self.calibration,
        }

    def at(self, x: float, y: float) -> list[tuple[float, float]]:
        """Candidates of one pixel.

        x, y       column and row, 0 at the top left
        Returns    (thickness in nm, probability), best first; empty where nothing can be told
        Raises     ValueError outside the picture

        >>> import numpy as np
        >>> import iridesce as ir
        >>> found = ir.map_thickness(np.zeros((8, 8, 3)), "air / soap ? / air", camera="srgb", illuminant="D65")
        >>> found.at(3, 4)
        []
        """
        height, width = self.thickness_nm.shape
        column = round(number("x", x, low=0.0, high=width - 1.0))
        row = round(number("y", y, low=0.0, high=height - 1.0))
        pairs = zip(self.candidates_nm[row, column], self.weights[row, column], strict=True)
        return [(float(nm), float(weight)) for nm, weight in pairs if np.isfinite(nm)]

    def plot(self, at: tuple[float, float] | None = None) -> Figure:
        """The map, the confidence, the width of the interval, and the candidates of one pixel or the second ones of all.

        at         (x, y): candidates of this pixel are shown; None: the second candidate of every pixel
        Returns    a matplotlib figure of four panels
        Raises     ValueError outside the picture; ImportError naming the extra where matplotlib is missing

        >>> import numpy as np
        >>> import iridesce as ir
        >>> found = ir.map_thickness(np.full((8, 8, 3), 0.05), "air / soap ? / air", camera="srgb", illuminant="D65")
        >>> len(found.plot().axes) >= 4
        True
        """
        from iridesce.plot import _map

        return _map.plot(self, at)

    def __str__(self) -> str:
        told = self.to_dict()
        words = ", ".join(f"{value:.0f}" for value in told["thickness_nm"]) or "no"
        first = (
            f"{told['mapped']} of {told['pixels']} pixels, thickness {words} nm (5, 50, 95 %), sure of the order on "
            f"{100.0 * told['sure']:.0f} %, scale {self.scale_interval[0]:.3f} to {self.scale_interval[1]:.3f}, "
            f"anchor: {self.anchor}"
        )
        return "\n".join([first, *(f"note: {note}" for note in self.notes)])

    def _repr_html_(self) -> str:
        """What a notebook shows: the map in grey, and the words."""
        import base64

        shown = base64.b64encode(_thumbnail(self.thickness_nm)).decode()
        words = "<br>".join(escape(line) for line in str(self).splitlines())
        return f'<img alt="thickness map" src="data:image/png;base64,{shown}"><br>{words}'


def _thumbnail(values: Values) -> bytes:
    """A PNG of at most 256 pixels a side, grey from the least to the greatest."""
    import struct
    import zlib

    step = max(1, -(-max(values.shape) // 256))
    small = values[::step, ::step].astype(np.float64)
    known = np.isfinite(small)
    low, high = (float(small[known].min()), float(small[known].max())) if known.any() else (0.0, 1.0)
    grey = np.where(known, 30.0 + 225.0 * (small - low) / max(high - low, 1e-9), 0.0).astype(np.uint8)
    rows = b"".join(b"\0" + row.tobytes() for row in grey)

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", grey.shape[1], grey.shape[0], 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def _tiff(pages: list[Values], labels: tuple[str, ...]) -> bytes:
    """Pages of float32, which ImageJ opens as slices, each with its name."""
    import tifffile

    buffer = io.BytesIO()
    metadata = {"axes": "ZYX", "Labels": list(labels)}
    tifffile.imwrite(buffer, np.stack(pages).astype(np.float32), imagej=True, metadata=metadata)
    return buffer.getvalue()
