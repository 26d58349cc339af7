"""Numbers of `iridesce spectrum` and `iridesce color` as JSON, CSV and files."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from conftest import Run

STACK = "air / SiO2 300 / Si"


def test_spectrum_is_one_table_in_every_form(iridesce: Run, tmp_path: Path) -> None:
    grid = ("--from", "400", "--to", "700", "--step", "50", "--angle", "30", "--polarization", "p")
    told = json.loads(iridesce("spectrum", STACK, *grid, "--json").stdout)
    nm = np.arange(400.0, 701.0, 50.0)
    stack = ir.Stack.parse(STACK)
    np.testing.assert_array_equal(told["wavelength_nm"], nm)
    assert told["stack"] == STACK and told["angle_deg"] == 30.0 and told["polarization"] == "p"
    for quantity in ("reflectance", "transmittance", "absorptance"):
        np.testing.assert_allclose(told[quantity], getattr(stack, quantity)(nm, 30.0, "p"), rtol=1e-14)
    printed = iridesce("spectrum", STACK, *grid, "--csv").stdout
    assert iridesce("spectrum", STACK, *grid, "-o", "s.csv").stdout == "s.csv\n"
    assert iridesce("spectrum", STACK, *grid, "-o", "s.json").stdout == "s.json\n"
    assert json.loads((tmp_path / "s.json").read_text()) == told
    for text in (printed, (tmp_path / "s.csv").read_text()):
        rows = list(csv.DictReader(text.splitlines()))
        assert next(iter(rows[0])) == "wavelength_nm" and len(rows) == 7
        found = [float(row["reflectance"]) for row in rows]
        np.testing.assert_allclose(found, told["reflectance"], rtol=1e-9)


def test_color_is_one_row_in_every_form(iridesce: Run, tmp_path: Path) -> None:
    told = json.loads(iridesce("color", STACK, "--json").stdout)
    np.testing.assert_allclose(told["lab"], ir.Stack.parse(STACK).color(space="lab"), rtol=1e-13)
    assert told["hex"].startswith("#") and told["stack"] == STACK
    assert iridesce("color", STACK, "-o", "c.csv").stdout == "c.csv\n"
    printed = iridesce("color", STACK, "--csv").stdout
    assert printed == (tmp_path / "c.csv").read_text()
    (row,) = csv.DictReader(printed.splitlines())
    numbers = [float(value) for name, value in row.items() if name.startswith("lab")]
    np.testing.assert_allclose(numbers, told["lab"], rtol=1e-9)
    one = json.loads(iridesce("color", STACK, "--space", "oklab", "--json").stdout)
    np.testing.assert_allclose(one["values"], ir.Stack.parse(STACK).color(space="oklab"), rtol=1e-13)


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("spectrum", STACK, "--csv", "--json"), 2, "exclude"),
        (("spectrum", STACK, "-o", "s.xls"), 3, ".csv, .json"),
        (("spectrum", STACK, "-o", "nowhere/s.csv"), 1, "nowhere"),
        (("color", STACK, "-o", "s.xls"), 3, ".csv, .json"),
        (("spectrum", "air / SiO2 thick / Si"), 3, "number"),
    ],
)
def test_wrong_use(iridesce: Run, tmp_path: Path, arguments: tuple[str, ...], code: int, words: str) -> None:
    finished = iridesce(*arguments)
    assert finished.returncode == code and words in finished.stderr, finished.stderr
    assert list(tmp_path.iterdir()) == []
