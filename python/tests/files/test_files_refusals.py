"""What readers and writers of files refuse: the parts of each message, and its words."""

from __future__ import annotations

from pathlib import Path

import pytest

from iridesce.files.rows import check as checked_rows
from iridesce.files.spectra import read_spectrum
from iridesce.files.whole import read_whole
from refused import Case, check

CASES: list[Case] = [
    (
        lambda: read_whole("a\0b", 10),
        "path 'a\\x00b': embedded null byte",
        *("path", "'a\\x00b'", "a file name without a zero byte", ""),
    ),
    (
        lambda: read_spectrum("x.csv", quantity="shine"),
        None,
        *("quantity", "'shine'", "one of 'reflectance', 'transmittance'", ""),
    ),
    (lambda: read_spectrum("x.csv", unit=3), None, *("unit", "3", "a string or None", "")),
    (lambda: read_spectrum("x.csv", unit_y=3), None, *("unit_y", "3", "a string or None", "")),
    (lambda: read_spectrum("x.csv", column=1.5), None, *("column", "1.5", "None, a name or a number", "")),
    (
        lambda: checked_rows(Path("x.txt")),
        "the name of an output must end in .csv, .json, got 'x.txt'",
        *("output", "'x.txt'", "a name that ends in .csv, .json", ""),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)
