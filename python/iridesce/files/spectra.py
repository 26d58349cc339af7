"""Spectra as spectrometers write them: CSV in any of its dialects. Internal; `read_spectrum` is offered by `iridesce.fit`."""

from __future__ import annotations

import csv
import math
import os
import re
from typing import NamedTuple

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.files.jcamp import is_jcamp, read_jcamp
from iridesce.files.whole import read_whole

_MOST_BYTES = 64 << 20
_MISSING = {"", "nan", "na", "n/a", "-", "--", "---", "null", "none", "#n/a", "inf", "-inf", "+inf", "over", "*****"}
# Separators with the decimal sign they leave free, the least ambiguous first.
_DIALECTS = (("\t", "."), ("\t", ","), (";", "."), (";", ","), (",", "."), (None, "."), (None, ","), (",", ","))
_UNITS = {"nm": 1.0, "um": 1e3, "angstrom": 0.1, "m": 1e9}
_PER_CM_NM = 1e7  # nm in a cm
_EV_NM = 1239.841984  # h c in eV nm, CODATA 2018 (exact by definition of the SI)
_WORDS = {
    "um": r"\b(um|\u00b5m|\u03bcm|micron\w*|micromet\w*)\b",
    "cm-1": r"(cm\s*\^?\s*-1|1/cm|wave\s*numbers?|cm\u207b\u00b9)",
    "ev": r"\b(ev|electron\s*volts?|photon energy)\b",
    "angstrom": r"(\u00e5|\u212b|angstr)",
    "nm": r"\b(nm|nanomet\w*)\b",
}
_QUANTITY = {
    "reflectance": r"(refl|%\s*r\b|\br\s*[\[(%]|^r$|\bref\b(?!erence))",
    "transmittance": r"(trans|%\s*t\b|\bt\s*[\[(%]|^t$)",
}


class Spectrum(NamedTuple):
    """A spectrum from a file.

    wavelength_nm   as in the file's order, converted to nm                     (n,)
    measured        the chosen column; percent as ratios; NaN for missing       (n,)
    column          its name, or its number
    notes           how the file was understood

    >>> import iridesce as ir
    >>> spectrum = ir.fit.Spectrum(np.array([500.0, 510.0]), np.array([0.042, 0.044]), "R [%]", ())
    >>> nm, measured, *_ = spectrum
    >>> float(measured[nm == 510.0][0])
    0.044
    """

    wavelength_nm: Floats
    measured: Floats
    column: str
    notes: tuple[str, ...]


def read_spectrum(
    path: str | os.PathLike[str],
    column: str | int | None = None,
    unit: str | None = None,
    quantity: str = "reflectance",
) -> Spectrum:
    """Read a spectrum from the text file of a spectrometer.

    Separators comma, semicolon, tab or spaces; decimal point or decimal comma; any number of header lines; comments; more
    columns than two; missing values; UTF-8, UTF-16 or Latin-1; JCAMP-DX that is not compressed. Wavelengths in nm, um,
    Angstrom, 1/cm or eV, as a header says or their size tells; percent by a header's % or by values above 1.5.

    path       the file
    column     name (part of it) or number (1 is the first) of the measurement; None: one that is named after the quantity,
               or else the second
    unit       "nm", "um", "angstrom", "cm-1" or "ev"; None: as the file tells
    quantity   "reflectance" or "transmittance": which column to prefer
    Returns    `Spectrum`; how the file was understood is in its notes
    Raises     ValueError naming the file: missing, no two columns of numbers, an unknown column

    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "film.csv")
    ...     _ = file.write_text("Probe 7; 25 ms\\nWellenl\u00e4nge [\u00b5m];R [%]\\n0,500;4,2\\n0,510;4,4\\n0,520;4,1\\n")
    ...     spectrum = read_spectrum(file)
    >>> spectrum.wavelength_nm.tolist(), spectrum.measured.round(6).tolist()
    ([500.0, 510.0, 520.0], [0.042, 0.044, 0.041])
    """
    label = os.fspath(path)
    label = label if isinstance(label, str) else os.fsdecode(label)
    text = _text(label)
    notes: list[str] = []
    if is_jcamp(text):
        x, y, x_unit, y_unit = read_jcamp(label, text)
        table = np.stack([x, y], axis=1)
        header: list[str] = []
        names = [x_unit or "x", y_unit or "y"]
        notes.append("the file is JCAMP-DX")
    else:
        table, header, dialect = _rows(label, text.splitlines())
        names = _names(header, dialect, table.shape[1])
    place = _column(label, column, names, table.shape[1], quantity, notes)
    wavelength_nm = _wavelengths(label, table[:, 0], unit, names[0], " ".join(header), notes)
    values = table[:, place].copy()
    said = names[place].lower() or (header[-1].lower() if header and table.shape[1] == 2 else "")
    finite = values[np.isfinite(values)]
    top = float(np.max(finite, initial=0.0))
    if ("%" in said or "percent" in said) and top > 0.0:
        values /= 100.0
        notes.append("values are in percent, as the header says")
    elif 1.5 < top <= 130.0 and float(np.min(finite, initial=0.0)) > -10.0:
        values /= 100.0
        notes.append(f"values reach {top:.4g}: taken as percent")
    elif top > 130.0:
        notes.append(f"values reach {top:.4g}: counts; only their shape is used")
    name = names[place] or f"column {place + 1}"
    return Spectrum(wavelength_nm, values, name, tuple(notes))


def _text(label: str) -> str:
    content = read_whole(label, _MOST_BYTES, "no spectrum is")
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _split(line: str, separator: str | None) -> list[str]:
    if separator is not None and '"' in line:
        try:
            words = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
        except csv.Error:
            words = line.split(separator)
    else:
        words = line.split(separator) if separator is not None else line.split()
    return [word.strip().strip('"').strip("'").strip() for word in words]


def _parse(line: str, dialect: tuple[str | None, str]) -> list[float] | None:
    """The numbers of a row; None for a line that is none. Missing values are NaN, but not the first."""
    separator, decimal = dialect
    line = line.strip()
    if not line or line[0] in "#!%":
        return None
    words = _split(line, separator)
    while len(words) > 1 and words[-1] == "":
        words.pop()
    if len(words) < 2:
        return None
    numbers = []
    for place, word in enumerate(words):
        if decimal == ",":
            # A point beside a decimal comma could only group thousands, which no spectrometer does.
            if "." in word:
                return None
            word = word.replace(",", ".")
        if place and word.lower() in _MISSING:
            numbers.append(math.nan)
            continue
        try:
            numbers.append(float(word))
        except ValueError:
            if place < 2:
                return None
            numbers.append(math.nan)
    return numbers if math.isfinite(numbers[0]) else None


def _rows(label: str, lines: list[str]) -> tuple[Floats, list[str], tuple[str | None, str]]:
    """The table, the lines above it, and the dialect that reads most of it."""
    best: tuple[int, int, list[list[float]], int, tuple[str | None, str]] | None = None
    for order, dialect in enumerate(_DIALECTS):
        parsed = [(number, row) for number, line in enumerate(lines) if (row := _parse(line, dialect)) is not None]
        if not parsed:
            continue
        # The rows of the commonest width; a header line of two numbers is not one of them.
        widths = [len(row) for _, row in parsed]
        width = max(set(widths), key=lambda one: (widths.count(one), one))
        kept = [(number, row) for number, row in parsed if len(row) == width]
        known = sum(math.isfinite(row[1]) for _, row in kept)
        if known and (best is None or (known, -order) > (best[0], best[1])):
            best = (known, -order, [row for _, row in kept], kept[0][0], dialect)
    if best is None or len(best[2]) < 2:
        raise ValueError(f"{label}: holds no table of two or more columns of numbers (wavelength, measurement)")
    header = [line for line in lines[: best[3]] if line.strip()]
    return np.array(best[2]), header, best[4]


def _names(header: list[str], dialect: tuple[str | None, str], width: int) -> list[str]:
    """Names of the columns: header lines of as many words, one above the other (names, then units); empty without any."""
    names = [""] * width
    for line in header[-4:]:
        words = _split(line.lstrip("#!% "), dialect[0])
        while len(words) > width and words[-1] == "":
            words.pop()
        if len(words) == width and any(re.search(r"[^\W\d]", word) for word in words):
            names = [f"{name} {word}".strip() for name, word in zip(names, words, strict=True)]
    return names


def _column(label: str, column: str | int | None, names: list[str], width: int, quantity: str, notes: list[str]) -> int:
    if isinstance(column, str) and column.strip().isdigit():
        column = int(column)
    if isinstance(column, int) and not isinstance(column, bool):
        if not 2 <= column <= width:
            raise ValueError(f"{label}: column must be 2 to {width}, got {column}")
        return column - 1
    if isinstance(column, str):
        found = [place for place in range(1, width) if column.lower() in names[place].lower()]
        exact = [place for place in found if names[place].lower() == column.lower()]
        if len(exact or found) != 1:
            raise ValueError(f"{label}: {len(found)} columns are named {column!r}; there are {names[1:]}")
        return (exact or found)[0]
    if column is not None:
        raise ValueError(f"column must be None, a name or a number, got {column!r}")
    pattern = _QUANTITY.get(quantity, r"(?!)")
    named = [place for place in range(1, width) if re.search(pattern, names[place].lower())]
    place = named[0] if named else 1
    if width > 2:
        notes.append(f"column {place + 1} of {width} is used" + (f": {names[place]!r}" if names[place] else ""))
    return place


def _wavelengths(label: str, values: Floats, unit: str | None, name: str, header: str, notes: list[str]) -> Floats:
    if unit is not None:
        key = unit.strip().lower().replace("\u00b5", "u").replace("\u03bc", "u")
        if key not in (*_UNITS, "cm-1", "ev") or key == "m":
            raise ValueError(f'unit must be "nm", "um", "angstrom", "cm-1" or "ev", got {unit!r}')
    else:
        key = _said(name) or _said(header) or _guessed(label, values, notes)
        if key != "nm":
            notes.append(f"wavelengths are in {key}")
    with np.errstate(divide="ignore"):
        if key == "cm-1":
            return np.asarray(_PER_CM_NM / values)
        if key == "ev":
            return np.asarray(_EV_NM / values)
    return np.asarray(values * _UNITS[key])


def _said(text: str) -> str | None:
    for key, pattern in _WORDS.items():
        if re.search(pattern, text.lower()):
            return key
    return None


def _guessed(label: str, values: Floats, notes: list[str]) -> str:
    """The unit by the size of the numbers."""
    middle = float(np.median(values))
    if 100.0 <= middle <= 3000.0:
        return "nm"
    if 0.1 <= middle <= 20.0:
        return "um"
    if middle < 1e-4 and middle > 0.0:
        return "m"
    raise ValueError(
        f"{label}: its first column, around {middle:g}, is no wavelength in nm or um; say the unit: nm, um, angstrom, cm-1, ev"
    )
