"""Errors in the words of the command line: the option that was typed, not the argument of the library."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

from conftest import Run
from iridesce.arguments.refusals import complaint, refusal
from iridesce.cli.option_words import in_option_words, option_of, options_of

FIT = ("fit", "film.csv", "--stack", "air / SiO2 ? / Si")
MAP = ("thickness", "photo.npy", "--stack", "air / soap ? / air")
RECIPES = ("recipes", "lab 45 50 -30", "--media", "SiO2", "--substrate", "Si")
CALIBRATE = ("calibrate", "photo.npy", "--stack", "N-BK7 / air ? / N-BK7")


@pytest.mark.parametrize(
    ("words", "begins"),
    [
        ((*FIT, "--range", "900:300"), "--range must be 0 <= low < high"),
        ((*FIT, "--angle", "95"), "--angle must be"),
        ((*FIT, "--resolution", "-1"), "--resolution must be"),
        ((*FIT, "--wavelength-tolerance", "-1"), "--wavelength-tolerance must be"),
        ((*FIT, "--index-tolerance", "2"), "--index-tolerance must be"),
        ((*FIT, "--gain", "-1"), "--gain must be"),
        ((*FIT, "--quantity", "psi"), "--quantity must be"),
        ((*MAP, "--range", "900:300"), "--range must be 0 <= low < high"),
        ((*MAP, "--angle-tolerance", "-1"), "--angle-tolerance must be"),
        ((*MAP, "--camera", "none-such"), "--camera must be"),
        ((*CALIBRATE, "--lens", "-3", "--pixel", "3"), "--lens must be"),
        ((*CALIBRATE, "--lens", "300", "--pixel", "-3"), "--pixel must be"),
        ((*RECIPES, "--range", "900:300"), "--range must be 0 <= low < high"),
        ((*RECIPES, "--max-delta-e", "-3"), "--max-delta-e must be"),
    ],
)
def test_the_option_is_named(iridesce: Run, tmp_path: Path, words: tuple[str, ...], begins: str) -> None:
    (tmp_path / "film.csv").write_text("".join(f"{nm},{0.1 + 1e-4 * (nm % 37)}\n" for nm in range(420, 700, 5)))
    np.save(tmp_path / "photo.npy", np.full((16, 16, 3), 0.2))
    finished = iridesce(*words)
    assert finished.returncode == 3, finished.stderr
    errors = [line for line in finished.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 1 and errors[0].startswith(f"error: {begins}"), finished.stderr


def test_prose_stays_as_it_is() -> None:
    """A word is an option's where the sentence begins with it, or where nothing else is written so."""
    from iridesce.cli.verbs.fit import verb

    error = complaint("the stack has no layer; thin films need gain=1.0", "stack", "a stack with a layer", None)
    assert in_option_words(verb, error) == "the stack has no layer; thin films need --gain 1.0"
    assert in_option_words(verb, refusal("stack", "text", 3)) == "--stack must be text, got 3"
    assert in_option_words(verb, refusal("wavelength_nm", "> 0", -1)) == "wavelength_nm must be > 0, got -1"
    assert in_option_words(verb, ValueError("thickness_range_nm")) == "thickness_range_nm"


@pytest.mark.parametrize("name", ["fit", "thickness", "calibrate", "recipes"])
def test_every_option_is_found(name: str) -> None:
    """By the name that --help shows."""
    verb = importlib.import_module(f"iridesce.cli.verbs.{name}").verb
    options = options_of(verb)
    assert options["stack" if name != "recipes" else "media"].startswith("--")
    assert {"--json", "--output"} <= set(options.values())
    assert option_of(options, "none_such_nm") is None
