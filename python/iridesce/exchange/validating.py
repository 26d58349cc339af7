"""``ir.validate``: a picture or a table of any renderer against a chart, and the likely cause of what differs."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import color
from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, refusal
from iridesce.exchange import charts, exr, faults, lut, png
from iridesce.exchange.charts import Summary
from iridesce.exchange.films import ANGLES_DEG, COUNT
from iridesce.exchange.report import words
from iridesce.exchange.suite import RANGE_NM, THICKNESS_NM, Chart, charts_named
from iridesce.files.arrays import array_of
from iridesce.files.whole import read_whole
from iridesce.image import Image

# A picture closer than this in the mean is right: no eye tells, and there is no cause to seek.
_RIGHT = 0.1
# A cause must explain this share of the error, and be that much better than any other.
_EXPLAINED = 0.6
_CLEARLY = 0.7
_MOST_BYTES = 2**30

Causes = tuple[str, ...]
CAUSES: Causes = (
    "unit",
    "illuminant E",
    "k missing",
    "schlick",
    "v flipped",
    "8-bit thickness",
    "cie rgb matrix",
    "transposed matrix",
    "rec709 clip",
    "half period",
)
"""What `ValidationReport.cause` may say."""


@dataclass(frozen=True)
class ValidationReport:
    """How far a picture or table is from a chart, and why.

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(50.0, 1200.0, 24)), "air"])
    >>> chart = film.color(angle_deg=np.array([0, 15, 30, 45, 60, 75, 85.0])[:, None])
    >>> ir.validate(chart, "C1").delta_e["max"] < 1e-6, ir.validate(chart[::-1], "C1").cause
    (True, 'v flipped')
    """

    chart: str
    """The chart's name; of a group the one that is nearest."""
    delta_e: dict[str, float]
    """CIEDE2000: ``mean``, ``p95``, ``max``, both sides times 1 / (largest Y of the chart)."""
    by_angle: dict[float, float]
    """The mean at each angle, degrees."""
    cause: str | None
    """One of `CAUSES` where one fault, and only one, explains most of the difference."""
    text: str
    """The verdict in words."""

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON.

        Returns  a new dict: chart, delta_e, by_angle, cause, text
        Raises   nothing

        >>> from iridesce.exchange import ValidationReport
        >>> ValidationReport("C1", {"mean": 0.0}, {15.0: 0.0}, None, "right").to_dict()["by_angle"]
        {'15': 0.0}
        """
        angles = {f"{angle:g}": value for angle, value in self.by_angle.items()}
        return {
            "chart": self.chart,
            "delta_e": self.delta_e,
            "by_angle": angles,
            "cause": self.cause,
            "text": self.text,
        }

    def __str__(self) -> str:
        return self.text


def validate(picture_or_array: str | os.PathLike[str] | Image | ArrayLike, chart: str) -> ValidationReport:
    """Compare what a renderer shows with a chart of the reference suite, computed by the core.

    picture_or_array  XYZ, white Y = 1, as an array (rows, columns, 3) or an `Image`; or a file: ``.exr`` (a table of
                      `export`, channels X, Y, Z, or R, G, B in linear Rec.709), ``.png`` (a table of `export`, else sRGB),
                      ``.npy`` (XYZ). Layout of charts: 24 k x 7 k pixels, thickness 50 to 1200 nm across, 0, 15, 30, 45,
                      60, 75, 85 degrees from the top; else of tables: thickness across, cos(theta) 0 (top) to 1
    chart             "C1" soap, "C2" soap transmitted, "C3" oil on water, "C4" MgF2 on glass, "C5" SiO2 on Si, "C6" TiO2 on
                      Ti, "C7" furnace, "C8-A", "C8-FL2", "C8-FL11", "C8-LED-B1", "C8-sodium", "C9-0nm", "C9-1nm", "C9-2nm",
                      "C9-5nm", "C9-8bit"; "C8" or "C9": the nearest of its group
    Returns           ValidationReport
    Raises            ValueError naming the file or argument, and what is allowed

    A cause is named where the picture is what the exact chart becomes by that one fault, or much nearer to it than to the
    truth, and nearer than to any other.

    >>> import numpy as np, iridesce as ir
    >>> t = np.linspace(50.0, 1200.0, 24)
    >>> angle = np.array([0, 15, 30, 45, 60, 75, 85.0])[:, None]
    >>> flat = ir.Stack(["air", ir.Layer("soap", t), "air"]).color(angle_deg=angle, illuminant="E")
    >>> report = validate(flat, "C1")
    >>> report.cause, round(report.delta_e["mean"], 1)
    ('illuminant E', 4.0)
    """
    named = charts_named(chart)
    xyz, reading, table = _read(picture_or_array)
    reports = [_compared(one, xyz, reading, table) for one in named]
    return min(reports, key=lambda report: report.delta_e["mean"])


def _compared(chart: Chart, xyz: Floats, reading: str, table: lut.Lut | None) -> ValidationReport:
    white = color.illuminant(chart.illuminant)
    thickness, angle = faults.grids()
    true = chart.truth()
    seen, flipped = (_on_chart(side, table) for side in (xyz, xyz[::-1]))
    values = charts.differences(seen, true, white)
    told = charts.summary(values)
    mean = float(values.mean())
    cause, explanation = None, ""
    if mean > _RIGHT:
        candidates = list(faults.hypotheses(chart, thickness, angle))
        best: dict[str, float] = {}
        for name, wrong in candidates:
            # A fault that hardly shows on this chart explains nothing of it.
            if float(charts.differences(wrong, true, white).mean()) < _EXPLAINED * mean:
                continue
            left = float(charts.differences(seen, wrong, white).mean())
            best[name] = min(left, best.get(name, np.inf))
        best["v flipped"] = float(charts.differences(flipped, true, white).mean())
        cause, explanation = _judged(best, mean)
    text = _text(chart, told, cause, explanation, reading, float(seen[..., 1].mean() / true[..., 1].mean()))
    angles = told["by_angle"]
    assert isinstance(angles, dict)
    plain = {key: value for key, value in told.items() if not isinstance(value, dict)}
    return ValidationReport(chart.name, plain, angles, cause, text)


def _judged(left: dict[str, float], mean: float) -> tuple[str | None, str]:
    """The one cause that explains most of the difference; none where two explain it alike."""
    ranked = sorted(left.items(), key=lambda pair: pair[1])
    (name, rest), *others = ranked
    if rest > _EXPLAINED * mean:
        return None, f"no single known fault explains it (nearest: {name}, which leaves {rest:.2g})"
    if others and rest > _CLEARLY * others[0][1]:
        return None, f"two faults explain it alike: {name} leaves {rest:.2g}, {others[0][0]} {others[0][1]:.2g}"
    return name, f"with that fault alone the difference would be {rest:.2g}"


_MEANINGS = {
    "unit": "the thickness is a thousand times too small or too large (nm, um)",
    "illuminant E": "colours are summed under equal energy instead of D65",
    "k missing": "the metal's absorption is left out",
    "schlick": "Schlick's reflectance stands for Fresnel's, without polarisation",
    "v flipped": "the rows are upside down",
    "8-bit thickness": "the thickness has been through 8 bits",
    "cie rgb matrix": "CIE RGB is shown as if it were Rec.709",
    "transposed matrix": "the matrix from XYZ to RGB is transposed",
    "rec709 clip": "what lies outside Rec.709 is cut off",
    "half period": "the path in the film is counted twice",
}


def _text(chart: Chart, told: Summary, cause: str | None, explanation: str, reading: str, ratio: float) -> str:
    angles = told["by_angle"]
    assert isinstance(angles, dict)
    lines = [
        f"{chart.name} ({chart.title}; {chart.stack}, {chart.illuminant}): CIEDE2000 {words(told)}",
        "by angle: " + ", ".join(f"{angle:g} deg {value:.3g}" for angle, value in angles.items()),
        f"read as {reading}",
    ]
    if cause is not None:
        lines.append(f"likely cause: {cause}: {_MEANINGS[cause]}; {explanation}")
    elif explanation:
        lines.append(f"cause: {explanation}")
    else:
        lines.append("right: no eye sees a difference")
    if not 0.9 < ratio < 1.1:
        lines.append(f"its mean Y is {ratio:.3g} times the chart's: look at exposure and scale, too")
    return "\n".join(lines)


def _on_chart(xyz: Floats, table: lut.Lut | None) -> Floats:
    """24 x 7 colours: the means of the middle of each patch, or a table read at the chart's places."""
    if table is not None:
        thickness, angle = faults.grids()
        return lut.Lut(xyz, table.range_nm, "", "", "").sample(thickness, np.cos(np.radians(angle)))
    side = xyz.shape[1] // COUNT
    cut = side // 4  # the edges of patches are blended in rendered charts
    patches = xyz.reshape(len(ANGLES_DEG), side, COUNT, side, 3)
    return np.asarray(patches[:, cut : side - cut, :, cut : side - cut].mean(axis=(1, 3)))


def _read(source: Any) -> tuple[Floats, str, lut.Lut | None]:
    """XYZ, how it was read, and the table's frame where it is one."""
    table = None
    if isinstance(source, Image):
        xyz, kind = np.asarray(source.xyz, dtype=np.float64), "XYZ of a picture"
    elif isinstance(source, str | os.PathLike):
        xyz, kind, table = _read_file(os.fspath(source))
    else:
        xyz = plain_reals("picture_or_array", source, "a file, an Image or an array of XYZ (real numbers)")
        kind = "an array of XYZ"
    if xyz.ndim != 3 or xyz.shape[2] != 3:
        raise refusal("picture_or_array", "the shape (rows, columns, 3)", Words(xyz.shape), must="have")
    if not np.isfinite(xyz).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(xyz))[0])
        raise refusal("picture_or_array", "finite", Words(xyz[place]), f"at index {place}")
    height, width = xyz.shape[:2]
    rows = len(ANGLES_DEG)
    if table is None and width % COUNT == 0 and height * COUNT == width * rows:
        return xyz, f"{kind}: a chart of {COUNT} x {rows} patches", None
    if table is None and not (width >= 2 * height >= 8):
        raise refusal(
            "picture_or_array",
            f"a chart of {COUNT}k x {rows}k pixels or a table of thickness x cos(theta) (such as 512 x 64)",
            Words(f"{width} x {height}"),
        )
    if table is None:
        table = lut.Lut(xyz, RANGE_NM, "", "", "")
    low, high = table.range_nm
    if low > THICKNESS_NM[0] + 1e-9 or high < THICKNESS_NM[-1] - 1e-9:
        raise ValueError(
            f"the table spans {low:g} to {high:g} nm; the chart needs {RANGE_NM[0]:g} to {RANGE_NM[1]:g} nm"
        )
    return xyz, f"{kind}: a table of {width} x {height}, {low:g} to {high:g} nm, cos 0 on top", table


def _read_file(name: str) -> tuple[Floats, str, lut.Lut | None]:
    ending = Path(name).suffix.lower()
    if ending not in (".exr", ".png", ".npy"):
        raise refusal("picture_or_array", "an .exr, a .png or an .npy", name)
    content = read_whole(name, _MOST_BYTES, "no chart has")
    if ending == ".npy":
        try:
            return array_of(content).astype(np.float64), "XYZ", None
        except (ValueError, TypeError) as error:
            raise ValueError(f"{name}: no array of numbers ({error})") from None
    table = lut.read(content, name)
    if table is not None:
        return table.xyz, f"XYZ of a table ({table.stack}, {table.quantity}, {table.illuminant})", table
    to_xyz = np.linalg.inv(color.rgb_matrix("linear-srgb"))
    if ending == ".png":
        file = png.read_png(content, name)
        if file.values.shape[2] < 3:
            raise ValueError(f"{name}: a picture in grey shows no colours")
        encoded = file.values[..., :3] / file.peak
        return np.asarray(color.convert(encoded, "srgb", "xyz")), "sRGB", None
    channels, _ = exr.read_exr(content, name)
    for trio, kind in (("RGB", "linear Rec.709"), ("XYZ", "XYZ")):
        for prefix in ("", "XYZ."):
            if trio == "RGB" and prefix:
                continue
            if {prefix + letter for letter in trio} <= set(channels):
                values = np.stack([channels[prefix + letter] for letter in trio], axis=-1).astype(np.float64)
                return (values @ to_xyz.T if trio == "RGB" else values), kind, None
    raise ValueError(f"{name}: it holds the channels {', '.join(sorted(channels))}; wanted R, G, B or X, Y, Z")
