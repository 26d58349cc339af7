"""Streams that cannot be written, and options that users expect."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import Run

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full")
COLOR = ("color", "air / soap 320 / air")


def run(*arguments: str, **streams: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "iridesce", *arguments], text=True, check=False, timeout=120, **streams
    )  # type: ignore[call-overload]


@needs_full
def test_lost_notes_are_no_failure(tmp_path: Path) -> None:
    with FULL.open("w") as full:
        done = run(
            "render", "soap-bubble", "--size", "8x6", "--samples", "1", "-o", "x.png",
            stdout=subprocess.PIPE, stderr=full, cwd=tmp_path,
        )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "x.png\n")
    assert (tmp_path / "x.png").read_bytes().endswith(b"IEND\xaeB`\x82")


@needs_full
@pytest.mark.parametrize("arguments", [COLOR, ("--help",), ("info",), ("color", "--help")])
def test_a_lost_answer_is_a_failure_told_in_one_line(arguments: tuple[str, ...]) -> None:
    with FULL.open("w") as full:
        done = run(*arguments, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and "No space left on device" in done.stderr, done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="closed streams of POSIX")
def test_a_closed_stderr_is_no_failure() -> None:
    command = f"{sys.executable} -m iridesce color 'air / soap 320 / air' --space xyz 2>&-"
    done = subprocess.run(["sh", "-c", command], stdout=subprocess.PIPE, text=True, check=False, timeout=120)
    assert done.returncode == 0 and len(done.stdout.split()) == 3


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_letters_that_a_terminal_does_not_have_are_no_failure(encoding: str, tmp_path: Path) -> None:
    """`media` cuts long lines by an ellipsis; names of files may hold any letters, and bytes that are none."""
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "COLUMNS": "40"}
    done = run("media", stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment, encoding=encoding)
    assert done.returncode == 0 and not done.stderr, done.stderr
    assert ("\\u2026" if encoding != "utf-8" else "\u2026") in done.stdout
    command = [sys.executable, "-m", "iridesce", "lut", "air / soap ? / air", "--vary", "0:100", "--json"]
    for name in ("\u5149.cube", *(["b\udcf6se.cube"] if sys.platform == "linux" else [])):
        answer = subprocess.run(
            [*command, "-o", name], stdout=subprocess.PIPE, env=environment, cwd=tmp_path, check=False, timeout=120
        )
        assert answer.returncode == 0 and (tmp_path / name).exists()


# --- what users type


def test_several_angles(iridesce: Run) -> None:
    told = json.loads(iridesce(*COLOR, "--angle", "0,45", "--json").stdout)
    for one, angle in zip(told, ("0", "45"), strict=True):
        assert one == json.loads(iridesce(*COLOR, "--angle", angle, "--json").stdout)
    rows = iridesce("spectrum", "air / soap 320 / air", "--angle", "0,45", "--step", "200", "--csv").stdout.splitlines()
    head = next(line for line in rows if not line.startswith("#"))
    assert head.split(",")[:2] == ["wavelength_nm", "reflectance_0deg"] and head.endswith("absorptance_45deg")
    assert iridesce(*COLOR, "--angle", "0;45").returncode == 2


def test_a_spectrum_is_plotted(iridesce: Run, tmp_path: Path) -> None:
    assert iridesce("spectrum", "air / soap 320 / air", "-o", "x.png").stdout == "x.png\n"
    assert (tmp_path / "x.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    by_range = iridesce("spectrum", "air / soap 320 / air", "--range", "400:500", "--step", "50").stdout
    assert (
        by_range == iridesce("spectrum", "air / soap 320 / air", "--from", "400", "--to", "500", "--step", "50").stdout
    )
    assert iridesce("spectrum", "air / soap 320 / air", "--range", "400:500", "--to", "600").returncode == 2


def test_columns_of_a_film_may_be_set(iridesce: Run) -> None:
    def parameters(*arguments: str) -> dict[str, float]:
        return json.loads(iridesce("flow", "bubble-on-bath", "--list", "--json", *arguments).stdout)

    assert parameters("--set", "columns=512") == parameters("--columns", "512")
    assert parameters("--columns", "512")["columns"] == 512 != parameters()["columns"]
    both = iridesce("flow", "late", "--list", "--set", "columns=512", "--columns", "96")
    assert both.returncode == 2 and "exclude each other" in both.stderr
    assert iridesce("flow", "late", "--list", "--set", "columns=191.5").returncode == 3
    seed = iridesce("flow", "late", "--list", "--set", "seed=3")
    assert seed.returncode == 2 and "--seed" in seed.stderr
    wind = iridesce("flow", "late", "--list", "--set", "wind=1")
    assert wind.returncode == 3 and "wind_m_s" in wind.stderr


def test_one_assignment_each(iridesce: Run) -> None:
    two = iridesce("render", "soap-bubble", "--set", "render.samples=1\nrender.seed=3", "--size", "8x6")
    assert two.returncode == 2 and "one KEY=VALUE" in two.stderr


def test_lists_fit_a_terminal(iridesce: Run) -> None:
    short = iridesce("media", env={"COLUMNS": "80"}).stdout.splitlines()
    full = iridesce("media", "--full").stdout.splitlines()
    assert len(short) == len(full) > 50
    assert max(map(len, short)) <= 80 < max(map(len, full))
    assert len(iridesce("info").stdout.splitlines()) < 10 < len(iridesce("info", "--full").stdout.splitlines())


def test_threads_are_those_of_the_core(iridesce: Run) -> None:
    assert json.loads(iridesce("info", "--json", env={"RAYON_NUM_THREADS": "3"}).stdout)["threads"] == 3


def test_monochromatic_light_lies_outside_every_screen(iridesce: Run) -> None:
    small = ("--size", "12x12", "--samples", "2", "-o", "x.png")
    sodium = iridesce("render", "newtons-rings-sodium", *small).stderr
    assert "as monochromatic light always does" in sodium
    assert "monochromatic" not in iridesce("render", "newtons-rings", *small).stderr


def test_completion_is_offered(iridesce: Run) -> None:
    assert "--install-completion" in iridesce("--help").stdout
    env = {**os.environ, "_IRIDESCE_COMPLETE": "complete_bash", "COMP_WORDS": "iridesce re", "COMP_CWORD": "1"}
    done = run(stdout=subprocess.PIPE, env=env)
    assert "render" in done.stdout.split()
