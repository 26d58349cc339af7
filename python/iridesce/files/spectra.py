"""Spectra as spectrometers write them: text in any of its dialects. Internal; `read_spectrum` is offered by `iridesce.fit`."""

from __future__ import annotations

import os
from typing import NamedTuple

from iridesce import _core
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import refusal
from iridesce.files.report import ReadReport, of_core
from iridesce.files.whole import read_whole

_QUANTITIES = ("reflectance", "transmittance")


class Spectrum(NamedTuple):
    """A spectrum from a file.

    wavelength_nm   ascending, converted to nm, each once                       (n,)
    measured        the chosen column; percent as ratios; NaN for missing       (n,)
    column          its name, or its number
    notes           what to know of how the file was understood
    read            all of how it was understood: `ReadReport`

    >>> import numpy as np, iridesce as ir
    >>> spectrum = ir.fit.Spectrum(np.array([500.0, 510.0]), np.array([0.042, 0.044]), "R [%]", ())
    >>> nm, measured, *_ = spectrum
    >>> float(measured[nm == 510.0][0])
    0.044
    """

    wavelength_nm: Floats
    measured: Floats
    column: str
    notes: tuple[str, ...]
    read: ReadReport = ReadReport("")


def read_spectrum(
    path: str | os.PathLike[str],
    column: str | int | None = None,
    unit: str | None = None,
    quantity: str = "reflectance",
    *,
    wavelength_column: str | int | None = None,
    unit_y: str | None = None,
    range_nm: tuple[float, float] | None = None,
) -> Spectrum:
    """Read a spectrum from the text file of a spectrometer.

    Separators comma, semicolon, tab or spaces; decimal point or decimal comma; any number of header lines; comments; more
    columns than two; missing values; UTF-8, UTF-16 or Windows-1252; JCAMP-DX that is not compressed. Wavelengths in nm, um,
    Angstrom, 1/cm or eV by the axis's own name, else by their size. Beside dark, reference and sample, a column Reflectance
    is taken; without it (sample - dark) / (reference - dark). Absorbance becomes a transmittance. Where two readings are
    left, the answer is a question that names both.

    path       the file: an ordinary one of at most 64 MiB
    column     name (part of it) or number (1 is the first) of the measurement; None: as the names tell
    unit       of the axis: "nm", "um", "angstrom", "cm-1" or "ev"; None: as the file tells
    quantity   "reflectance" or "transmittance": which column to prefer
    wavelength_column   name or number of the axis; None: as the names tell, else the first that does not number the rows
    unit_y     "ratio", "percent", "counts" or "absorbance"; None: by the column's name, else by the 95th percentile of
               the values: up to 1.5 ratios, from 2.5 to 130 percent, above counts
    range_nm   the part that will be used, nm: what tells percent from ratios
    Returns    `Spectrum`; how the file was understood is in its ``read``, what to know of that in its ``notes``
    Raises     ValueError naming the file: missing, no ordinary file, no two columns of numbers, an unknown column, two
               readings that are both plausible with the option that chooses

    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "film.csv")
    ...     _ = file.write_text("Nr. 7; 25 ms\\nWellenl\u00e4nge [\u00b5m];R [%]\\n0,500;4,2\\n0,510;4,4\\n0,520;4,1\\n")
    ...     spectrum = read_spectrum(file)
    >>> spectrum.wavelength_nm.tolist(), spectrum.measured.round(6).tolist()
    ([500.0, 510.0, 520.0], [0.042, 0.044, 0.041])
    >>> spectrum.read.taken[0]
    Taken(role='wavelength', name='Wellenl\u00e4nge [\u00b5m]', unit='um', why='its own name')
    """
    label = os.fspath(path)
    label = label if isinstance(label, str) else os.fsdecode(label)
    if quantity not in _QUANTITIES:
        raise refusal("quantity", f"one of {', '.join(map(repr, _QUANTITIES))}", quantity)
    places = (_place("column", column), _place("wavelength_column", wavelength_column))
    for name, value in (("unit", unit), ("unit_y", unit_y)):
        if not (value is None or isinstance(value, str)):
            raise refusal(name, "a string or None", value)
    content = read_whole(label, _core.MAX_SPECTRUM_BYTES, "no spectrum is")
    try:
        nm, values, name, plain = _core.read_spectrum(content, *places, unit, unit_y, quantity, range_nm)
    except ValueError as error:
        raise ValueError(f"{label}: {error}") from None
    read = of_core(plain)
    return Spectrum(nm, values, name, read.sentences, read)


def _place(argument: str, value: object) -> str | None:
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, int) and not isinstance(value, bool):
        return str(value)
    raise refusal(argument, "None, a name or a number", value)
