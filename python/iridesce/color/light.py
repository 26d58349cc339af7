"""Light: illuminants, and the eyes of the standard observers."""

from __future__ import annotations

import os
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import _core
from iridesce._notebook import swatch
from iridesce.arguments.operands import Floats, reals, scalar
from iridesce.arguments.refusals import refusal
from iridesce.arguments.scalars import text
from iridesce.color.screen import chromatic
from iridesce.files.report import ReadReport, of_core
from iridesce.files.whole import read_whole

_CSV_SUFFIXES = {".csv", ".txt", ".tsv"}


class Illuminant:
    """A light source: relative spectral power, a continuous part and true lines. Made by :func:`illuminant`.

    >>> import iridesce as ir
    >>> lamp = ir.color.illuminant("lines:589.158*2,589.756")
    >>> lamp
    Illuminant('lines:589.158*2,589.756')
    >>> lamp.lines
    ((589.158, 2.0), (589.756, 1.0))
    """

    __slots__ = ("_core", "_origin", "_read")

    _core: Any
    _origin: tuple[str, ...]
    _read: ReadReport | None

    def __init__(self, name: str | os.PathLike[str] | Illuminant) -> None:
        made = illuminant(name)
        self._core, self._origin, self._read = made._core, made._origin, made._read

    @classmethod
    def _wrap(cls, core: Any, *origin: str) -> Illuminant:
        made = object.__new__(cls)
        made._core, made._origin, made._read = core, origin, None
        return made

    @classmethod
    def from_csv(cls, text: str, label: str = "csv") -> Illuminant:
        """A light source from CSV text: lines ``wavelength_nm,power``, header and ``#`` comments optional.

        Columns, separators, decimal commas, units and the order of the rows are read as those of spectra are; power a little
        below 0 is noise and counts as 0.

        text      wavelengths in vacuum nm (or as the column's name says); power >= 0; linear between the rows, zero outside
        label     its name, also in errors
        Returns   Illuminant
        Raises    ValueError naming the line

        >>> Illuminant.from_csv("nm,power\\n400,1\\n700,4", "lamp").power(500.0)
        2.0
        """
        return cls._from_bytes(text.encode("utf-8", "surrogateescape"), label)

    @classmethod
    def _from_bytes(cls, content: bytes, label: str) -> Illuminant:
        core, plain = _core.Illuminant.from_bytes(content, label)
        made = cls._wrap(core, content.decode("utf-8", "surrogateescape"), label)
        made._read = of_core(plain)
        return made

    @property
    def read(self) -> ReadReport | None:
        """How its table was understood: columns, units and why (`ReadReport`); None for a light that is no table's."""
        return self._read

    @property
    def name(self) -> str:
        """Its name: the CIE's spelling, the text of a formula, or the label of a CSV text."""
        return str(self._core.name)

    @property
    def lines(self) -> tuple[tuple[float, float], ...]:
        """The lines: (vacuum wavelength in nm, relative power); empty for a continuous source."""
        return tuple(self._core.lines)

    def power(self, wavelength_nm: ArrayLike) -> Any:
        """Relative power of the continuous part per nm; zero outside its table, linear within.

        wavelength_nm   vacuum wavelength, finite           (...,)
        Returns         float64                             (...,); a float for a scalar
        Raises          ValueError

        >>> import iridesce as ir
        >>> ir.color.illuminant("D65").power([380.0, 560.0, 790.0]).tolist()
        [49.9755, 100.0, 0.0]
        """
        nm = reals("wavelength_nm", wavelength_nm)
        return scalar(self._core.power(np.ascontiguousarray(nm.reshape(-1))).reshape(nm.shape))

    def white(self, observer: str = "cie1931") -> Floats:
        """XYZ of the light itself with Y = 1: plain sum over 360..830 nm at 1 nm, lines as lines.

        observer    "cie1931" | "cie1964"
        Returns     float64 (3,)
        Raises      ValueError

        >>> import iridesce as ir
        >>> ir.color.illuminant("D65").white().round(5).tolist()
        [0.95047, 1.0, 1.08883]
        """
        return np.array(self._core.white(text("observer", observer)))

    @property
    def xy(self) -> tuple[float, float]:
        """Chromaticity for the CIE 1931 observer.

        >>> import iridesce as ir
        >>> tuple(round(v, 4) for v in ir.color.illuminant("A").xy)
        (0.4476, 0.4074)
        """
        white = self.white()
        x, y, _ = white / white.sum()
        return float(x), float(y)

    def __repr__(self) -> str:
        return f"Illuminant({self.name!r})"

    def _repr_html_(self) -> str:
        """What a notebook shows: the light's colour, name and chromaticity."""
        x, y = self.xy
        both = chromatic(np.stack([self.white(), illuminant("D65").white()]))
        return f"{swatch(both)} <strong>{escape(self.name)}</strong> x = {x:.4f}, y = {y:.4f} (right: D65)"

    def __eq__(self, other: object) -> bool:
        return self._origin == other._origin if isinstance(other, Illuminant) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._origin)

    def __reduce__(self) -> tuple[Any, tuple[str, ...]]:
        return (Illuminant.from_csv if len(self._origin) == 2 else illuminant), self._origin


def illuminant(name: str | os.PathLike[str] | Illuminant) -> Illuminant:
    """A light source by name.

    ================================  ==================================================================================
    ``A C D50 D55 D65 D75 E`` ...     CIE tables at 5 nm, linear between, zero outside: :func:`illuminants` lists them;
                                      ``F2`` is ``FL2``, letter case does not matter
    ``blackbody:2856``                Planck's radiator, temperature in K; 100 at 560 nm
    ``daylight:6504``                 CIE daylight of that correlated colour temperature, 4000..25000 K
    ``lines:589.158*2,589.756``       true lines: vacuum nm within 360..830, ``*`` relative power (1 unless given)
    ``laser:632.99``                  one line
    a path                            CSV ``wavelength_nm,power``: see :meth:`Illuminant.from_csv`
    ================================  ==================================================================================

    Returns    Illuminant
    Raises     ValueError: unknown name, number out of range, file missing or not such a table
    Source     CIE 15:2004 and CIE 015:2018, as listed beside the tables

    >>> import iridesce as ir
    >>> ir.color.illuminant("f2")
    Illuminant('FL2')
    >>> [round(ir.color.illuminant(name).power(450.0), 2) for name in ("A", "blackbody:2856")]
    [33.09, 33.1]
    """
    if isinstance(name, Illuminant):
        return name
    if not isinstance(name, (str, os.PathLike)):
        raise refusal("illuminant", "a name, a path or an Illuminant", name)
    named = os.fspath(name)
    if isinstance(name, str):
        try:
            core = _core.Illuminant.named(named)
            return Illuminant._wrap(core, core.name)
        except ValueError:
            if not _is_file_name(named):
                raise
    return Illuminant._from_bytes(_read_lamp(named), named)


def _is_file_name(text: str) -> bool:
    try:
        return Path(text).suffix.lower() in _CSV_SUFFIXES or Path(text).is_file()
    except (OSError, ValueError):  # a name no file system takes
        return False


def _read_lamp(name: str) -> bytes:
    try:
        return read_whole(name, _core.MAX_LAMP_BYTES, "no table of a lamp is")
    except ValueError as error:
        raise ValueError(f"illuminant file {name!r} cannot be read: {error}") from None


def illuminants() -> list[str]:
    """Names of the tabulated illuminants.

    Returns    list of str
    Raises     nothing

    >>> import iridesce as ir
    >>> ir.color.illuminants()[:4]
    ['A', 'B', 'C', 'D50']
    """
    return list(_core.illuminant_names())


def color_matching(wavelength_nm: ArrayLike, observer: str = "cie1931") -> Floats:
    """Colour-matching functions of a CIE standard observer: the 1 nm table, linear between, zero outside 360..830 nm.

    wavelength_nm   vacuum wavelength, finite                (...,)
    observer        "cie1931" (2 degrees) | "cie1964" (10 degrees)
    Returns         xbar, ybar, zbar, float64                (..., 3)
    Raises          ValueError

    >>> import iridesce as ir
    >>> ir.color.color_matching(560.0).tolist()
    [0.5945, 0.995, 0.0039]
    """
    nm = reals("wavelength_nm", wavelength_nm)
    rows = _core.color_matching(np.ascontiguousarray(nm.reshape(-1)), text("observer", observer))
    return np.asarray(rows).reshape(*nm.shape, 3)


def as_illuminant(light: str | os.PathLike[str] | Illuminant) -> Illuminant:
    """A light as it is; a name or a path as a light."""
    return light if isinstance(light, Illuminant) else illuminant(light)
