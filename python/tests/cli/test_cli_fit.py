"""The verb ``fit`` as a user meets it."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

import iridesce as ir
from conftest import Run

STACK = "air / SiO2 ? / Si"


@pytest.fixture
def spectrum(tmp_path: Path) -> Path:
    """A film of 612 nm as a German spectrometer writes it."""
    nm = np.arange(420.0, 760.0, 1.0)
    values = ir.Stack.parse("air / SiO2 612 / Si").reflectance(nm)
    values = values + 1e-3 * np.random.default_rng(1).standard_normal(nm.size)
    rows = [f"{a:.1f};{100.0 * b:.4f}".replace(".", ",") for a, b in zip(nm, values, strict=True)]
    file = tmp_path / "film.csv"
    file.write_text("Wellenl\u00e4nge [nm];Reflexion [%]\n" + "\n".join(rows) + "\n", encoding="latin-1")
    return file


def test_words_json_curves_and_picture(iridesce: Run, tmp_path: Path, spectrum: Path) -> None:
    finished = iridesce("fit", spectrum.name, "--stack", STACK, "-o", "fit.png", "-o", "fit.csv", "-o", "fit.json")
    assert finished.returncode == 0, finished.stderr
    assert "clear, 1 plausible solution, 340 points" in finished.stdout and "612." in finished.stdout.replace(
        "611.9", "612."
    )
    assert finished.stdout.endswith("fit.png\nfit.csv\nfit.json\n")
    assert "percent" in finished.stderr
    picture = matplotlib.image.imread(io.BytesIO((tmp_path / "fit.png").read_bytes()), format="png")
    assert picture.shape[1] >= 700 and picture[..., :3].std() > 0.05
    rows = list(csv.DictReader((tmp_path / "fit.csv").read_text().splitlines()))
    assert len(rows) == 340 and list(rows[0]) == ["wavelength_nm", "measured", "fitted_1"]
    assert all(abs(float(row["fitted_1"]) - float(row["measured"])) < 0.006 for row in rows)
    told = json.loads((tmp_path / "fit.json").read_text())
    assert told["solutions"][0]["thickness_nm"] == pytest.approx(612.0, abs=0.5)
    assert told["fitted_1"][0] == pytest.approx(float(rows[0]["fitted_1"]), rel=1e-9)


def test_json_is_the_answer_of_the_library(iridesce: Run, spectrum: Path) -> None:
    finished = iridesce(
        "fit", spectrum.name, "--stack", STACK, "--gain", "1", "--range", "300:900", "--from", "450", "--to", "700",
        "--resolution", "0", "--baseline", "none", "--probability", "0.68", "--json",
    )  # fmt: skip
    assert finished.returncode == 0, finished.stderr
    told = json.loads(finished.stdout)
    read = ir.fit.read_spectrum(spectrum)
    nm, measured, column = read.wavelength_nm, read.measured, read.column
    inside = (nm >= 450.0) & (nm <= 700.0)
    result = ir.fit_thickness(
        nm[inside], measured[inside], STACK, gain=1.0, thickness_range_nm=(300.0, 900.0), resolution_nm=0.0,
        baseline="none", probability=0.68,
    )  # fmt: skip
    assert told["column"] == column and told["points"] == 251
    assert told["solutions"] == json.loads(json.dumps(result.to_dict()))["solutions"]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("none.csv", "--stack", STACK), 3, "no such file"),
        (("film.csv",), 2, "--stack"),
        (("film.csv", "--stack", "air / SiO2 / Si"), 0, ""),
        (("film.csv", "--stack", "air / unobtainium ? / Si"), 3, "unobtainium"),
        (("film.csv", "--stack", STACK, "--gain", "much"), 2, "much"),
        (("film.csv", "--stack", STACK, "--range", "9:1"), 3, "low < high"),
        (("film.csv", "--stack", STACK, "--range", "thin"), 2, "--range"),
        (("film.csv", "--stack", STACK, "--column", "7"), 3, "column"),
        (("film.csv", "--stack", STACK, "--unit", "inch"), 3, "unit"),
        (("film.csv", "--stack", STACK, "-o", "fit.doc"), 3, "fit.doc"),
        (("film.csv", "--stack", STACK, "-o", "nowhere/fit.csv"), 1, "nowhere"),
        (("film.csv", "--stack", STACK, "--from", "2000"), 3, "usable point"),
    ],
)
def test_wrong_use(
    iridesce: Run, tmp_path: Path, spectrum: Path, arguments: tuple[str, ...], code: int, words: str
) -> None:
    before = sorted(path.name for path in tmp_path.iterdir())
    finished = iridesce("fit", *arguments)
    assert finished.returncode == code, finished.stderr
    assert words in finished.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_several_files_are_a_row_each(iridesce: Run, tmp_path: Path, spectrum: Path) -> None:
    (tmp_path / "again.csv").write_bytes(spectrum.read_bytes())
    finished = iridesce("fit", spectrum.name, "again.csv", "--stack", STACK, "--json")
    assert finished.returncode == 0, finished.stderr
    told = json.loads(finished.stdout)
    assert [one["file"] for one in told] == ["film.csv", "again.csv"]
    assert [one["verdict"] for one in told] == ["clear", "clear"]
    assert told[0]["solutions"] == told[1]["solutions"]
    refused = iridesce("fit", spectrum.name, "again.csv", "--stack", STACK, "-o", "x.csv")
    assert refused.returncode == 2 and "one file" in refused.stderr


def test_a_file_that_is_no_spectrum_stops_no_other(iridesce: Run, tmp_path: Path, spectrum: Path) -> None:
    """Each bad file has its error, the others are fitted, and the exit code is that of bad input."""
    (tmp_path / "words.csv").write_text("no table\nat all\n")
    (tmp_path / "few.csv").write_text("".join(f"{nm}.0;{nm / 1e4}\n" for nm in (420, 430, 440, 450)))
    (tmp_path / "again.csv").write_bytes(spectrum.read_bytes())
    files = ("words.csv", spectrum.name, "lost.csv", "few.csv", "again.csv")
    finished = iridesce("fit", *files, "--stack", STACK)
    assert finished.returncode == 3
    assert "film.csv: air / SiO2 ? / Si: clear" in finished.stdout and "again.csv: air / SiO2" in finished.stdout
    errors = [line for line in finished.stderr.splitlines() if line.startswith("error: ")]
    assert [line.split(":")[1].strip() for line in errors] == ["words.csv", "lost.csv", "few.csv"]
    assert "holds no table" in errors[0] and "usable points are too few" in errors[2]
    told = iridesce("fit", *files, "--stack", STACK, "--json")
    assert told.returncode == 3
    listed = json.loads(told.stdout)
    assert [one["file"] for one in listed] == list(files)
    assert [one.get("verdict", "") for one in listed] == ["", "clear", "", "", "clear"]
    assert "holds no table" in listed[0]["error"] and "error" not in listed[1]
    alone = iridesce("fit", "words.csv", "--stack", STACK)
    assert alone.returncode == 3 and alone.stdout == ""
    # What is wrong of an option is told once, not of every file.
    refused = iridesce("fit", spectrum.name, "again.csv", "--stack", STACK, "--angle", "95")
    assert refused.returncode == 3 and refused.stderr.count("error: ") == 1 and refused.stdout == ""


def test_counts_with_dark_and_reference(iridesce: Run, tmp_path: Path) -> None:
    """Values below 130 are counts, no percent, where a reference stands beside them."""
    nm = np.arange(420.0, 760.0, 2.0)
    random = np.random.default_rng(1)
    light = 100.0 * (1.0 + 0.4 * np.exp(-0.5 * ((nm - 560.0) / 25.0) ** 2))
    film = np.asarray(ir.Stack.parse("air / SiO2 75 / Si").reflectance(nm))
    base = np.asarray(ir.Stack(["air", "Si"]).reflectance(nm))
    for name, values in {"film": light * film + 1.8, "reference": light * base + 1.8, "dark": 1.8 + 0.0 * nm}.items():
        noise = 0.02 * random.standard_normal(nm.size)
        (tmp_path / f"{name}.csv").write_text("\n".join(f"{a},{b}" for a, b in zip(nm, values + noise, strict=True)))
    arguments = ("--dark", "dark.csv", "--reference", "reference.csv", "--reference-stack", "air / Si", "--json")
    finished = iridesce("fit", "film.csv", "--stack", STACK, *arguments)
    assert finished.returncode == 0, finished.stderr
    told = json.loads(finished.stdout)
    assert told["verdict"] == "clear" and told["solutions"][0]["thickness_nm"] == pytest.approx(75.0, abs=1.0)
    assert told["solutions"][0]["gain"] == pytest.approx(1.0, abs=0.05)


def test_defaults_are_those_of_the_library() -> None:
    """What the command line leaves unsaid means what Python means by it."""
    import inspect

    from iridesce.cli.verbs.fit import verb

    said = {name: one.default for name, one in inspect.signature(verb).parameters.items()}
    library = {name: one.default for name, one in inspect.signature(ir.fit_thickness).parameters.items()}
    names = {"angle": "angle_deg", "range_": "thickness_range_nm", "resolution": "resolution_nm"}
    compared = {names.get(name, name): default for name, default in said.items() if names.get(name, name) in library}
    assert {"angle_deg", "baseline", "gain", "quantity", "probability", "index"} <= set(compared)
    for name, default in compared.items():
        if name not in ("wavelength_nm", "measured", "stack"):
            assert default == library[name], name
