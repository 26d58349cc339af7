"""What the command line itself refuses, options as typed: the parts of each message, and its words."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from iridesce.cli import answers
from iridesce.cli.entry import application
from iridesce.errors import ArgumentError

FILM = "air / soap / air"
ANIMATE = ("animate", "soap-bubble", "-o", "bubble.mp4")

# What is typed; its words, where they are not "argument must be allowed, got given"; argument, value and what is allowed.
CASES: list[tuple[tuple[str, ...], str | None, str, str, str]] = [
    (
        ("chart", "strip", FILM, "--size", "100x100", "-o", "x.png"),
        None,
        *("--size", "100x100", "at least 160x120 for a chart"),
    ),
    (
        ("chart", "locus", FILM, *(5 * ("--model", "exact")), "-o", "x.png"),
        "--model may be given four times at most, got 5",
        *("--model", "5", "given four times at most"),
    ),
    ((*ANIMATE, "--seconds", "-1"), None, *("--seconds", "-1", "> 0 and finite")),
    ((*ANIMATE, "--fps", "inf"), None, *("--fps", "inf", "> 0 and finite")),
    (
        (*ANIMATE, "--seconds", "10000", "--fps", "1000"),
        "--seconds 10000 at --fps 1000 is more than 100000 frames",
        *("--seconds", "10000 at --fps 1000", "100000 frames at most"),
    ),
    ((*ANIMATE, "--start", "-1"), None, *("--start", "-1", ">= 0 and finite, in s")),
    ((*ANIMATE, "--speed", "nan"), None, *("--speed", "nan", ">= 0 and finite")),
    (
        ("animate", "wafer", "-o", "frames"),
        "nothing moves: wafer has no film that flows; give its thickness_nm as { flow = ... }, or --orbit or --camera",
        *("scene", "'wafer'", "a scene with a film that flows, unless --orbit or --camera is given"),
    ),
    (
        ("flow", "early", "--set", "gravity_m_s2=x"),
        "--set gravity_m_s2 must be a number, got 'x'",
        *("--set gravity_m_s2", "'x'", "a number"),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(
    case: tuple[tuple[str, ...], str | None, str, str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    typed, words, argument, given, allowed = case
    told: list[Exception] = []
    spoken = answers._words
    monkeypatch.setattr(answers, "_words", lambda verb, error: told.append(error) or spoken(verb, error))
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(application([typed[0]]), list(typed))
    (error,) = told
    assert isinstance(error, ArgumentError)
    assert (error.argument, error.given, error.allowed, error.place) == (argument, given, allowed, "")
    assert result.stderr == f"error: {words or f'{argument} must be {allowed}, got {given}'}\n"
    assert (result.exit_code, list(tmp_path.iterdir())) == (3, [])
