"""Answers on a terminal that is narrower than they are."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from iridesce.cli.verbs import fit, info, recipes

COLUMNS = 30


class Terminal(io.StringIO):
    """A terminal in stdout's place."""

    def isatty(self) -> bool:
        return True


def spectrum(folder: Path) -> Path:
    nm = np.arange(420.0, 760.0, 2.0)
    film = ir.Stack(["air", ir.Layer("SiO2", thickness_nm=700.0), "Si"]).reflectance(nm)
    file = folder / "s.csv"
    file.write_text("".join(f"{a:.1f},{b:.6f}\n" for a, b in zip(nm, film, strict=True)))
    return file


ANSWERS = {
    "info": lambda _: info.verb(),
    "info --full": lambda _: info.verb(full=True),
    "recipes": lambda _: recipes.verb("lab 40 10 -40", media="SiO2", substrate="Si", layers="1", max_delta_e=20.0),
    "fit": lambda folder: fit.verb([spectrum(folder)], stack="air / SiO2 ? / Si", gain="1"),
}


@pytest.mark.parametrize("name", ANSWERS)
def test_lines_fit_a_narrow_terminal(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(COLUMNS))
    said: dict[str, str] = {}
    for where, stream in {"terminal": Terminal(), "file": io.StringIO()}.items():
        monkeypatch.setattr(sys, "stdout", stream)
        ANSWERS[name](tmp_path)
        said[where] = stream.getvalue()
    monkeypatch.undo()
    assert max(map(len, said["file"].splitlines())) > COLUMNS, "files get whole lines"
    # (A word longer than a line, such as a path, stays in one piece.)
    for line in said["terminal"].splitlines():
        assert len(line) <= COLUMNS or len(line.split()) == 1, line
    lost = words(said["file"]) - words(said["terminal"])
    assert lost <= {"stack", "volts"}, "of a table that became sentences the heads of films and of an empty column"


def words(text: str) -> set[str]:
    return {word.strip(":,") for word in text.split()}


def test_lines_that_fit_are_left_alone() -> None:
    from iridesce.cli.answers import fitted

    text = "a  b\n\n  c    d"
    assert fitted(text, 9) == fitted(text, None) == text
    assert fitted("  name   some words of it", 16) == "  name   some\n    words of it"
