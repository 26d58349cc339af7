"""Tables of exact colours over thickness and cosine: what every program that reads a texture can show. Internal.

Columns are thickness from A to B, rows cos(theta) from 0 (top) to 1, both at texel centres:
u = (0.5 + (W - 1)(t - A)/(B - A)) / W, v from the top = (0.5 + (H - 1) cos) / H.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from iridesce import _core, color
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import complaint, refusal
from iridesce.arguments.scalars import one_of
from iridesce.exchange import charts, exr, png
from iridesce.exchange.films import ANGLES_DEG, COUNT, Film, film_of, grazing_deg
from iridesce.stack import Stack

SIZE = (512, 64)
CUBE_SIZE = 1024
QUANTITIES = ("reflectance", "transmittance")
ENDINGS = (".exr", ".png", ".cube")

_MOST_TEXELS = 2**22
_WIDE_NM = 3000.0
_MOST_COLUMNS = 4096
_POINTS = 20_000
_CUBE_POINTS = 4096
_PNG_SCALE = "iridesce:scale"
# Below 20 nm a film is nearly black and CIEDE2000 has no eye behind it: the greatest error there is told apart.
_BLACK_NM = 20.0


@dataclass(frozen=True, eq=False)
class Lut:
    """A table of one quantity of a film: XYZ, white = 1, row 0 is grazing light."""

    xyz: NDArray[np.float64]
    range_nm: tuple[float, float]
    quantity: str
    illuminant: str
    stack: str

    def sample(self, thickness_nm: ArrayLike, cos_theta: ArrayLike) -> Floats:
        """What a linear filter with clamped edges reads, + an axis of 3."""
        height, width = self.xyz.shape[:2]
        low, high = self.range_nm
        share = (np.asarray(thickness_nm, dtype=np.float64) - low) / (high - low)
        return bilinear(self.xyz, share * (width - 1), np.asarray(cos_theta, dtype=np.float64) * (height - 1))

    def attributes(self) -> dict[str, exr.Attribute]:
        """Every fact of the table, for the head of its file."""
        light = color.illuminant(self.illuminant)
        return {
            "iridesce:illuminant": self.illuminant,
            "iridesce:illuminant_white_xyz": tuple(float(x) for x in light.white()),
            "iridesce:layout": "columns: thickness A..B, rows from the top: cos(theta) 0..1, both at texel centres",
            "iridesce:observer": "cie1931",
            "iridesce:polarization": "unpolarized",
            "iridesce:quantity": self.quantity,
            "iridesce:space": "xyz",
            "iridesce:stack": self.stack,
            "iridesce:thickness_nm": self.range_nm,
            "iridesce:white": "perfect white Y = 1",
            "software": f"iridesce {_core.__version__}",
        }


def table(film: Film, quantity: str, size: tuple[int, int] | None = None) -> Lut:
    """The table of a film over its range, in double precision; of a wide range with as many columns as fringes need."""
    low, high = film.table_range()
    width, height = size or SIZE
    fringes = film.layer is not None and film.stack.layers[film.layer].coherent
    if size is None and fringes and high - low > _WIDE_NM:
        width = min(_MOST_COLUMNS, int(np.ceil(width * (high - low) / _WIDE_NM)))
    xyz = _computed(
        film.at(0.0), film.layer, film.illuminant, (low, high), quantity, (width, height), tuple(film.notes)
    )
    return Lut(xyz, (low, high), quantity, film.illuminant.name, film.text_for_table)


@lru_cache(maxsize=8)
def _computed(
    stack: Stack,
    layer: int | None,
    light: color.Illuminant,
    ends: tuple[float, float],
    quantity: str,
    size: tuple[int, int],
    notes: tuple[str, ...],
) -> Floats:
    """Objects of one scene often wear the same film: each table is made once."""
    film = Film(stack, layer, ends, light, notes=list(notes))
    thickness = np.linspace(*ends, size[0])[None, :]
    cosine = np.linspace(0.0, 1.0, size[1])[:, None]
    xyz = film.xyz(thickness, grazing_deg(cosine), quantity)
    xyz.flags.writeable = False
    return xyz


def stored(lut: Lut, dtype: Any = np.float16) -> Lut:
    """The table as a file of that precision holds it."""
    return Lut(lut.xyz.astype(dtype).astype(np.float64), lut.range_nm, lut.quantity, lut.illuminant, lut.stack)


def error(lut: Lut, film: Film) -> dict[str, float]:
    """How far linear reading of the table is from the truth at 20 000 places drawn evenly: CIEDE2000.

    mean, p99, max above 20 nm; both sides times 1 / (largest Y of the film's chart).
    """
    draws = np.random.Generator(np.random.PCG64(1)).random((2, _POINTS))
    low, high = lut.range_nm
    thickness, cosine = low + (high - low) * draws[0], draws[1]
    true = film.xyz(thickness, grazing_deg(cosine), lut.quantity)
    grid = np.linspace(low, high, COUNT)
    peak = film.xyz(grid[None, :], np.array(ANGLES_DEG)[:, None], lut.quantity)[..., 1].max()
    scale = 1.0 / peak if peak > 0.0 else 1.0
    sides = [
        color.convert(xyz * scale, "xyz", "lab", white=film.illuminant) for xyz in (lut.sample(thickness, cosine), true)
    ]
    values = np.asarray(color.delta_e(*sides))
    seen = values[thickness > _BLACK_NM]
    return {
        "mean": float(values.mean()),
        "p99": float(np.percentile(values, 99.0)),
        "max": float((seen if seen.size else values).max()),
    }


def chart_differences(lut: Lut, film: Film) -> Floats:
    """The table read as a renderer reads it, against the truth, on the chart of the film."""
    thickness, angles = film.thicknesses()[None, :], np.array(ANGLES_DEG)[:, None]
    seen = lut.sample(thickness, np.cos(np.radians(angles)))
    return charts.differences(seen, charts.truth(film, lut.quantity), film.illuminant)


def exr_file(lut: Lut, stated: dict[str, float]) -> bytes:
    """Half XYZ with every fact and the error as attributes."""
    half = lut.xyz.astype(np.float16)
    facts = {**lut.attributes(), **{f"iridesce:delta_e_{name}": value for name, value in stated.items()}}
    return exr.exr_bytes({name: half[..., axis] for axis, name in enumerate("XYZ")}, facts)


def png_scale(lut: Lut) -> float:
    """What 65535 stands for: the greatest value of the table, 1 at least a lit one."""
    peak = float(lut.xyz.max())
    return peak if peak > 0.0 else 1.0


def png_stored(lut: Lut) -> Lut:
    """The table as the 16-bit PNG holds it."""
    scale = png_scale(lut)
    steps = np.rint(np.clip(lut.xyz, 0.0, None) * (65535.0 / scale))
    return Lut(steps * (scale / 65535.0), lut.range_nm, lut.quantity, lut.illuminant, lut.stack)


def png_file(lut: Lut, stated: dict[str, float]) -> bytes:
    """XYZ x 65535 / scale; the scale and every fact as text."""
    scale = png_scale(lut)
    steps = np.rint(np.clip(lut.xyz, 0.0, None) * (65535.0 / scale)).astype(np.uint16)
    facts = {**lut.attributes(), **{f"iridesce:delta_e_{name}": value for name, value in stated.items()}}
    texts = {name: _fact_text(value) for name, value in facts.items()}
    return png.png_bytes(steps, {_PNG_SCALE: repr(scale), **texts})


def ramp(film: Film, quantity: str) -> tuple[tuple[float, float], Floats]:
    """The colours at 0 degrees over the film's table range."""
    low, high = film.table_range()
    return (low, high), film.xyz(np.linspace(low, high, CUBE_SIZE), 0.0, quantity)


def cube_file(film: Film, quantity: str, stated: dict[str, float]) -> bytes:
    """A 1-D .cube: linear XYZ at 0 degrees over thickness, domain A..B nm (Adobe, "Cube LUT Specification" 1.0)."""
    (low, high), xyz = ramp(film, quantity)
    head = [
        f"# iridesce {_core.__version__}: linear CIE 1931 XYZ of the {quantity} of a film at 0 degrees",
        "# input: thickness in nm; output: X, Y, Z, the perfect white has Y = 1",
        f"# stack: {film.text_for_table}",
        f"# illuminant: {film.illuminant.name}",
        f"# thickness: {low:.9g} to {high:.9g} nm",
        f"# error of linear interpolation, CIEDE2000: mean {stated['mean']:.4f}, max {stated['max']:.4f}",
        f'TITLE "{film.text_for_table.replace(chr(34), "")}"',
        f"LUT_1D_SIZE {len(xyz)}",
        f"DOMAIN_MIN {low:.9g} {low:.9g} {low:.9g}",
        f"DOMAIN_MAX {high:.9g} {high:.9g} {high:.9g}",
    ]
    rows = [" ".join(f"{value:.7g}" for value in row) for row in xyz]
    return ("\n".join([*head, *rows]) + "\n").encode("ascii", "replace")


def cube_error(film: Film, quantity: str) -> dict[str, float]:
    """The .cube read linearly between its entries, against the truth at 0 degrees: CIEDE2000 mean, p99, max."""
    (low, high), xyz = ramp(film, quantity)
    places = np.random.Generator(np.random.PCG64(1)).random(_CUBE_POINTS)
    rounded = np.array([[float(f"{value:.7g}") for value in row] for row in xyz])
    seen = bilinear(rounded[None], places * (len(xyz) - 1), np.zeros_like(places))
    true = film.xyz(low + (high - low) * places, 0.0, quantity)
    values = charts.differences(seen, true, film.illuminant)
    return {"mean": float(values.mean()), "p99": float(np.percentile(values, 99.0)), "max": float(values.max())}


def bilinear(values: Floats, column: Floats, row: Floats) -> Floats:
    """Linear between the entries of (rows, columns, 3), clamped at the edges."""
    height, width = values.shape[:2]
    x = np.clip(column, 0.0, width - 1.0)
    y = np.clip(row, 0.0, height - 1.0)
    x, y = np.broadcast_arrays(x, y)
    left, top = np.minimum(x.astype(int), max(width - 2, 0)), np.minimum(y.astype(int), max(height - 2, 0))
    right, below = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    dx, dy = (x - left)[..., None], (y - top)[..., None]
    above = values[top, left] * (1.0 - dx) + values[top, right] * dx
    beneath = values[below, left] * (1.0 - dx) + values[below, right] * dx
    return np.asarray(above * (1.0 - dy) + beneath * dy)


def checked_size(size: object) -> tuple[int, int]:
    """(width, height) of a table: two texels each way at least, four million in all at most."""
    try:
        width, height = (int(side) for side in size)  # type: ignore[attr-defined]
        if (width, height) != tuple(size) or min(width, height) < 2 or width * height > _MOST_TEXELS:  # type: ignore[arg-type]
            raise ValueError
    except (TypeError, ValueError):
        raise refusal("size", f"(width, height), each >= 2, {_MOST_TEXELS} texels at most", size) from None
    return width, height


def single_file(
    stack: Any, ending: str, *, vary: object, illuminant: Any, size: object, quantity: str, layer: int | None = None
) -> tuple[bytes, dict[str, float], Film]:
    """The content of one table file, its error, and its film: what the verb ``lut`` writes."""
    one_of("quantity", quantity, QUANTITIES)
    film = film_of(stack, layer, vary, None, color.illuminant(illuminant))
    if quantity == "transmittance" and not film.transmits:
        raise complaint(
            f"{film.text_for_table}: nothing comes out behind {stack.last.name}, which absorbs",
            "quantity",
            "reflectance where the last medium absorbs",
            quantity,
        )
    if ending == ".cube":
        if size is not None:
            raise complaint(
                f"a .cube has {CUBE_SIZE} entries; size goes with .exr and .png", "size", "left out for a .cube", size
            )
        stated = cube_error(film, quantity)
        return cube_file(film, quantity, stated), stated, film
    lut = table(film, quantity, None if size is None else checked_size(size))
    if ending == ".exr":
        stated = error(stored(lut), film)
        return exr_file(lut, stated), stated, film
    stated = error(png_stored(lut), film)
    return png_file(lut, stated), stated, film


def read(content: bytes, label: str) -> Lut | None:
    """The table in an .exr or .png that this package wrote; ``None`` where the file is a picture of another kind."""
    ending = os.path.splitext(label)[1].lower()
    if ending == ".exr":
        channels, facts = exr.read_exr(content, label)
        if "iridesce:thickness_nm" not in facts or not {"X", "Y", "Z"} <= set(channels):
            return None
        xyz = np.stack([channels[name] for name in "XYZ"], axis=-1).astype(np.float64)
        ends = facts["iridesce:thickness_nm"]
    else:
        file = png.read_png(content, label)
        if _PNG_SCALE not in file.texts or file.values.shape[2] != 3:
            return None
        facts = dict(file.texts)
        xyz = file.values.astype(np.float64) * (_number(file.texts[_PNG_SCALE], label) / file.peak)
        ends = tuple(_number(word, label) for word in file.texts.get("iridesce:thickness_nm", "").split())
    if not isinstance(ends, tuple) or len(ends) != 2 or not ends[0] < ends[1]:
        raise ValueError(f"{label}: the table's range of thickness cannot be read, got {ends!r}")
    names = ("iridesce:quantity", "iridesce:illuminant", "iridesce:stack")
    quantity, light, stack = (str(facts.get(name, "")) for name in names)
    return Lut(xyz, (float(ends[0]), float(ends[1])), quantity, light, stack)


def _number(text: str, label: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{label}: {text!r:.40} is no number of a table") from None


def _fact_text(value: exr.Attribute) -> str:
    return " ".join(repr(one) for one in value) if isinstance(value, tuple) else str(value)
