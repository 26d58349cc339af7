"""Texts of other people on the command line: brackets without end, endless digits, second lines; the verb `check`."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

import command_line
import iridesce as ir

DEEP = "[" * 20_000 + "]" * 20_000
LONG = "9" * 5_000


def iridesce(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return command_line.run(words, folder, timeout=120)


@pytest.mark.parametrize(("value", "said"), [(DEEP, "nested too deeply"), (LONG, "more digits")])
def test_set_refuses_in_words(tmp_path: Path, value: str, said: str) -> None:
    done = iridesce("render", "soap-bubble", "--set", f"camera.fov_deg={value}", "-o", "x.png", folder=tmp_path)
    assert done.returncode == 3, done.stderr
    assert "--set camera.fov_deg" in done.stderr and said in done.stderr and len(done.stderr) < 500


def test_set_takes_one_line(tmp_path: Path) -> None:
    words = ("render", "soap-bubble", "--set", "camera.fov_deg=30\nrender.samples=3", "-o", "x.png")
    done = iridesce(*words, folder=tmp_path)
    said = " ".join(done.stderr.replace("\u2502", " ").split())
    assert done.returncode == 2 and "after the value of camera.fov_deg" in said
    assert not (tmp_path / "x.png").exists()


@pytest.mark.parametrize("text", [f"a = {DEEP}", f"[[key]]\ntime_s = {LONG}"])
def test_camera_files_are_refused_in_words(tmp_path: Path, text: str) -> None:
    (tmp_path / "camera.toml").write_text(text)
    done = iridesce("animate", "soap-bubble", "--camera", "camera.toml", "-o", "run", folder=tmp_path)
    assert done.returncode == 3 and "camera.toml" in done.stderr and "fault" not in done.stderr, done.stderr


@pytest.mark.parametrize("text", [DEEP, f'{{"fps": {LONG}}}', "[1, 2]"])
def test_descriptions_of_runs_are_refused_in_words(tmp_path: Path, text: str) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "run.json").write_text(text)
    done = iridesce("flow", "late", "--time", "0", "-o", "run", "--resume", folder=tmp_path)
    assert done.returncode == 3 and "run.json" in done.stderr and "fault" not in done.stderr, done.stderr


def test_check_tells_all_that_is_wrong(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text(
        'version = 1\n[camera]\nfov = 30\nup = 3\n[[object]]\nsurface = { film = { medium = "sopa", outside = 0 } }\n'
        "[[object]]\nshape = { sphere = { radius = -1, centre = [0, 0, 0] } }\n"
    )
    done = iridesce("check", "bad.toml", folder=tmp_path)
    assert done.returncode == 3 and done.stdout == ""
    for line in ("bad.toml:3:", "bad.toml:4:", "bad.toml:6:", "bad.toml:8:", 'needs the key "light"'):
        assert line in done.stderr, line
    with pytest.raises(ir.SceneError) as caught:
        ir.Scene.load(tmp_path / "bad.toml")
    places = {(error.line, error.key) for error in caught.value.errors}
    assert {(6, "object.bubble.surface.film.medium"), (6, "object.bubble.surface.film.outside")} <= places
    assert {(8, "object.bubble-2.shape.sphere.radius"), (8, "object.bubble-2.shape.sphere.centre")} <= places
    assert len(caught.value.errors) == 7 and caught.value.errors[0].line == caught.value.line


def test_check_prints_the_schema(tmp_path: Path) -> None:
    schema = json.loads(iridesce("check", "--schema", folder=tmp_path).stdout)
    assert schema["$defs"]["film"]["properties"]["medium"]["default"] == "soap"
    assert schema["$defs"]["scene"]["required"] == ["version", "camera", "object", "light"]
    assert iridesce("check", folder=tmp_path).returncode == 2
    assert iridesce("check", "soap-bubble", "--schema", folder=tmp_path).returncode == 2
