"""What cameras see: spectral sensitivities, measured ones of some cameras and such from files."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from iridesce.arguments.operands import Floats, reals
from iridesce.arguments.refusals import refusal
from iridesce.files.whole import read_whole
from iridesce.optics.wavelengths import SPECTRUM_NM, in_steps

_MOST_BYTES = 1 << 22
_BUILT_IN = ("nikon-d5100", "sigma-sd-merrill")
# Built-in cameras stand at these, nm; between the entries of a table its line, which no sample changes.
_NM = in_steps(SPECTRUM_NM, 5.0)
# How far typical cameras go along the second eigenvector of a channel, of the first: the spread of the measured ones.
_BENT = 0.25


@dataclass(frozen=True, eq=False)
class Camera:
    """Relative spectral sensitivities of the three channels of a camera.

    name           its name
    wavelength_nm  ascending                                                       (n,)
    sensitivity    red, green, blue, relative; linear between, zero outside       (n, 3)
    source         where they come from

    >>> import iridesce as ir
    >>> camera = ir.color.camera("nikon-d5100")
    >>> camera.wavelength_nm.size, int(camera.wavelength_nm[camera.sensitivity[:, 1].argmax()])
    (81, 530)
    """

    name: str
    wavelength_nm: Floats = field(repr=False)
    sensitivity: Floats = field(repr=False)
    source: str = field(default="", repr=False)

    def at(self, wavelength_nm: ArrayLike) -> Floats:
        """Sensitivities at these wavelengths.

        wavelength_nm  vacuum wavelengths, nm, finite     (...,)
        Returns        relative, zero outside the table   (..., 3)
        Raises         ValueError

        >>> import iridesce as ir
        >>> ir.color.camera("nikon-d5100").at([200.0, 530.0]).round(3).tolist()[0]
        [0.0, 0.0, 0.0]
        """
        nm = reals("wavelength_nm", wavelength_nm)
        columns = [np.interp(nm, self.wavelength_nm, one, left=0.0, right=0.0) for one in self.sensitivity.T]
        return np.stack(columns, axis=-1)


def cameras() -> list[str]:
    """Names of the cameras whose measured sensitivities are built in.

    Returns    names for `camera`, sorted
    Source     Darrodi et al., J. Opt. Soc. Am. A 32, 381 (2015), through colour-science (BSD-3-Clause)

    >>> import iridesce as ir
    >>> ir.color.cameras()
    ['nikon-d5100', 'sigma-sd-merrill']
    """
    return sorted(_BUILT_IN)


def camera(name: str | os.PathLike[str]) -> Camera:
    """A camera by name, or from a file of sensitivities.

    name       one of `cameras`, or a file: CSV with columns nm, r, g, b (a header line is optional, lines of # are comments),
               or the JSON of the rawtoaces data set
    Returns    Camera
    Raises     ValueError naming the file or the names that exist

    >>> import iridesce as ir
    >>> ir.color.camera("sigma-sd-merrill")
    Camera(name='sigma-sd-merrill')
    """
    if isinstance(name, Camera):
        return name
    text = os.fspath(name) if isinstance(name, str | os.PathLike) else None
    if not isinstance(text, str):
        raise refusal("camera", "a name or a path", name)
    if text.lower() in _BUILT_IN:
        table = _from_csv(text.lower(), _stored(f"{text.lower()}.csv"), "")
        return Camera(table.name, _NM, table.at(_NM), "Darrodi et al. 2015, doi 10.1364/JOSAA.32.000381")
    path = Path(text)
    if not path.exists() and not path.suffix:
        raise refusal(
            "camera", f"one of {', '.join(cameras())}, or a file of sensitivities (CSV nm,r,g,b or JSON)", text
        )
    content = read_whole(text, _MOST_BYTES, "no table of sensitivities is")
    try:
        words = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{text}: a table of sensitivities is UTF-8 text") from None
    return _from_json(text, words) if words.lstrip().startswith("{") else _from_csv(text, words, text)


def typical_cameras() -> list[Camera]:
    """What a camera of which nothing is known could be like: the first eigenvector of many measured ones, and the same bent
    either way along the second (Dyer et al., RAW to ACES Utility Data, 2017, through colour-science). Internal.
    """
    rows = np.loadtxt(_stored("basis.csv").splitlines(), delimiter=",", comments="#", skiprows=2)
    nm, basis = rows[:, 0], rows[:, 1:].reshape(-1, 2, 3)
    found = []
    for word, bend in (("typical", 0.0), ("typical, bent", _BENT), ("typical, bent back", -_BENT)):
        curves = np.maximum(basis[:, 0] + bend * basis[:, 1], 0.0)
        found.append(Camera(word, nm, curves / curves.max(axis=0), "colour-science, Dyer et al. 2017"))
    return found


def _stored(name: str) -> str:
    return resources.files("iridesce.color").joinpath("camera_data", name).read_text("utf-8")


def _from_csv(label: str, text: str, source: str) -> Camera:
    rows: list[list[float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split("#")[0].replace(";", ",").split(",")
        if not any(word.strip() for word in words):
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            if rows:
                raise ValueError(f"{label}:{number}: wanted four numbers nm,r,g,b, got {line!r:.60}") from None
            continue
        if len(row) != 4:
            raise ValueError(f"{label}:{number}: wanted four numbers nm,r,g,b, got {line!r:.60}")
        rows.append(row)
    return _checked(label, np.array(rows, dtype=np.float64).reshape(-1, 4), source)


def _from_json(label: str, text: str) -> Camera:
    """The layout of rawtoaces: header.model, spectral_data.data.main = {"380": [r, g, b], ...}."""
    try:
        tree = json.loads(text)
        header = tree.get("header", {})
        table = tree["spectral_data"]["data"]["main"]
        rows = [[float(nm), *(float(value) for value in values)] for nm, values in table.items()]
        array = np.array(rows, dtype=np.float64)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise ValueError(
            f"{label}: is not the JSON of camera sensitivities: wanted spectral_data.data.main with [r, g, b] at each wavelength"
        ) from None
    name = " ".join(str(header[key]) for key in ("manufacturer", "model") if header.get(key)) or label
    return _checked(label, array, label, name)


def _checked(label: str, rows: Floats, source: str, name: str | None = None) -> Camera:
    if rows.ndim != 2 or rows.shape[1] != 4 or rows.shape[0] < 8:
        raise ValueError(f"{label}: holds {rows.shape[0]} rows of nm,r,g,b; at least 8")
    if not np.isfinite(rows).all():
        raise ValueError(f"{label}: sensitivities and wavelengths must be finite")
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    nm, values = rows[:, 0], rows[:, 1:]
    if (np.diff(nm) <= 0.0).any() or nm[0] < 100.0 or nm[-1] > 3000.0:
        raise ValueError(f"{label}: wavelengths must be different ones in nm, got {nm[0]:g} to {nm[-1]:g}")
    if (values.max(axis=0) <= 0.0).any():
        raise ValueError(f"{label}: a channel sees nothing")
    return Camera(name or label, nm, np.ascontiguousarray(values), source)
