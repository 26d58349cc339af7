"""The verbs of exchange as a user types them: files, notes, exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from conftest import Run
from iridesce.exchange import lut


def test_lut_writes_each_kind_of_table(iridesce: Run, tmp_path: Path) -> None:
    for name in ("x.exr", "x.png", "x.cube"):
        finished = iridesce("lut", "air / soap ? / air", "--vary", "0:1200", "-o", name)
        assert finished.returncode == 0 and finished.stdout == f"{name}\n", finished.stderr
        assert "CIEDE2000 mean 0.0" in finished.stderr
    read = lut.read((tmp_path / "x.exr").read_bytes(), "x.exr")
    assert read is not None and read.xyz.shape == (64, 512, 3) and read.range_nm == (0.0, 1200.0)


def test_lut_answers_in_json(iridesce: Run, tmp_path: Path) -> None:
    options = ("--vary", "0:600", "-o", "x.png", "--size", "64x16", "--quantity", "transmittance", "--illuminant", "A")
    finished = iridesce("lut", "air / soap / air", *options, "--json")
    answer = json.loads(finished.stdout)
    assert answer["thickness_nm"] == [0.0, 600.0] and answer["illuminant"] == "A" and answer["delta_e"]["mean"] > 0.0
    read = lut.read((tmp_path / "x.png").read_bytes(), "x.png")
    assert read is not None and read.xyz.shape == (16, 64, 3) and read.quantity == "transmittance"


def test_export_prints_files_and_the_report(iridesce: Run, tmp_path: Path) -> None:
    finished = iridesce("export", "air / soap ? / air", "--to", "cube", "--vary", "0:1200", "-o", "out")
    assert finished.returncode == 0 and Path(finished.stdout.strip()) == Path("out/film.cube")
    assert "left out: polarisation" in finished.stderr and "by angle" in finished.stderr
    report = json.loads(
        iridesce("export", "air / soap ? / air", "--to", "cube", "--vary", "0:1200", "-o", "out", "--json").stdout
    )
    assert list(report["delta_e"]) == ["mean", "p95", "max", "by_angle"] and "85" in report["delta_e"]["by_angle"]


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("lut", "air / soap ? / air", "-o", "x.jpg"), 2, "x.jpg"),
        (("lut", "air / soap ? / air", "--vary", "0-1200", "-o", "x.exr"), 2, "0:1200"),
        (("lut", "air / soap ? / air", "--vary", "1200:0", "-o", "x.exr"), 3, "thinner to a thicker"),
        (("lut", "air / soup ? / air", "-o", "x.exr"), 3, "soup"),
        (("lut", "air / TiO2 ? / Ti", "--quantity", "transmittance", "-o", "x.exr"), 3, "absorbs"),
        (("lut", "air / soap ? / air", "--quantity", "phase", "-o", "x.exr"), 3, "quantity must be"),
        (("lut", "air / soap ? / air", "--size", "1x1", "-o", "x.exr"), 3, "each >= 2"),
        (("lut", "air / soap ? / air", "-o", "no/such/x.exr"), 1, "the folder no/such does not exist"),
        (("export", "air / soap ? / air", "--to", "unreal", "-o", "out"), 3, "to must be one of"),
        (("export", "no-such-scene", "--to", "lut", "-o", "out"), 3, "no-such-scene"),
    ],
)
def test_wrong_commands(iridesce: Run, tmp_path: Path, arguments: tuple[str, ...], code: int, message: str) -> None:
    finished = iridesce(*arguments)
    assert finished.returncode == code and message in finished.stderr, finished.stderr
    assert list(tmp_path.iterdir()) == []
