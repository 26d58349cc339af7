"""The verbs ``chart`` and ``media`` as a user meets them."""

from __future__ import annotations

import io
import json
import re
import resource
import signal
import time
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from typer.testing import CliRunner

import iridesce as ir
from conftest import Run
from iridesce.cli.entry import application
from iridesce.files.whole import write_whole

app = application()

SOAP = "air / soap / air"


def pixels(path: Path) -> np.ndarray:
    return np.asarray(matplotlib.image.imread(io.BytesIO(path.read_bytes()), format="png"))


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (("locus", SOAP), "locus-air-soap-air.png"),
        (("strip", SOAP), "strip-air-soap-air.png"),
        (("strip", "newton"), "strip-newton.png"),
        (("angle", "air / SiO2 ? / Si"), "angle-air-SiO2-Si.png"),
        (("strip", "air / main/SiO2/Malitson/x / Si", "-o", "x.png"), ""),
    ],
)
def test_chart_writes_a_picture_under_a_sensible_name(
    iridesce: Run, tmp_path: Path, arguments: tuple[str, ...], name: str
) -> None:
    started = time.perf_counter()
    finished = iridesce("chart", *arguments)
    if not name:
        assert finished.returncode == 3 and list(tmp_path.iterdir()) == []
        return
    assert finished.returncode == 0, finished.stderr
    assert time.perf_counter() - started < 15.0, "about a second where nothing else runs"
    assert finished.stdout == f"{name}\n"
    assert [path.name for path in tmp_path.iterdir()] == [name]
    picture = pixels(tmp_path / name)
    assert picture.shape[1] >= 1000
    assert picture[..., :3].std() > 0.05


def test_chart_strip_has_the_colours_of_the_library(iridesce: Run, tmp_path: Path) -> None:
    finished = iridesce("chart", "strip", SOAP, "--range", "0:1000", "--size", "1200x300", "--title", "", "-o", "s.png")
    assert finished.returncode == 0, finished.stderr
    row = pixels(tmp_path / "s.png")[100, :, :3]
    inside = np.flatnonzero(np.abs(row - 1.0).max(axis=1) > 0.02)
    strip = row[inside[0] + 2 : inside[-1] - 1]
    thickness_nm = np.linspace(0.0, 1000.0, len(strip))
    linear = ir.Stack(["air", ir.Layer("soap", thickness_nm), "air"]).color(space="linear-srgb")
    wanted, _ = ir.color.map_gamut(ir.color.convert(linear / linear.max(), "linear-srgb", "srgb"), "srgb", "hue")
    assert np.median(np.abs(strip - wanted)) < 0.02
    assert np.corrcoef(strip.ravel(), wanted.ravel())[0, 1] > 0.99


def test_chart_options_change_the_picture(tmp_path: Path) -> None:
    """In this process: thirty new ones would take half a minute."""
    file = tmp_path / "a.png"

    def picture(kind: str, *arguments: str) -> bytes:
        finished = CliRunner().invoke(app, ["chart", kind, SOAP, "--size", "400x440", *arguments, "-o", str(file)])
        assert finished.exit_code == 0, finished.output
        return file.read_bytes()

    plain = picture("locus")
    assert picture("locus") == plain, "the same chart is the same file"
    for arguments in (
        ("--to", "1000"),
        ("--from", "100"),
        ("--range", "100:900"),
        ("--angle", "45"),
        ("--illuminant", "A"),
        ("--polarization", "s"),
        ("--quantity", "transmittance"),
        ("--model", "two-beam"),
        ("--model", "both"),
        ("--model", "exact", "--model", "two-beam"),
        ("--diagram", "uv"),
        ("--gamut", "none"),
        ("--tick", "50"),
        ("--zoom",),
        ("--theme", "dark"),
        ("--title", "My film"),
    ):
        assert picture("locus", *arguments) != plain, arguments
    assert picture("locus", "--from", "100", "--to", "900") == picture("locus", "--range", "100:900")
    assert picture("strip", "--angle", "0", "--angle", "50") != picture("strip")
    assert picture("strip", "--retardation") != picture("strip")
    assert picture("strip", "--orders") != picture("strip")
    assert picture("strip", "--exposure", "3") != picture("strip")
    assert picture("angle", "--angle", "0:60") != picture("angle")


def test_chart_size_and_theme(iridesce: Run, tmp_path: Path) -> None:
    assert iridesce("chart", "angle", SOAP, "--size", "640x480", "--theme", "dark", "-o", "a.png").returncode == 0
    picture = pixels(tmp_path / "a.png")
    assert picture.shape[:2] == (480, 640)
    assert picture[0, 0, :3].max() < 0.15


def test_chart_as_svg_and_pdf(iridesce: Run, tmp_path: Path) -> None:
    for name in ("a.svg", "a.pdf"):
        answer = iridesce("chart", "locus", SOAP, "-o", name, "--json")
        assert json.loads(answer.stdout) == {"files": [name]}
        first = (tmp_path / name).read_bytes()
        assert iridesce("chart", "locus", SOAP, "-o", name).returncode == 0
        assert (tmp_path / name).read_bytes() == first, "no dates, no chance"
    svg = (tmp_path / "a.svg").read_text()
    assert ">air / soap / air<" in svg, "text stays text"
    assert 'id="path-exact"' in svg
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ((), 2, ""),
        (("pie", SOAP), 2, "pie"),
        (("locus",), 2, "STACK"),
        (("locus", SOAP, "-o", "a.jpg"), 2, ".png, .pdf, .svg"),
        (("locus", SOAP, "--range", "100"), 2, "as in 0:60"),
        (("locus", SOAP, "--range", "a:b"), 2, "as in 0:60"),
        (("locus", SOAP, "--range", "0:100", "--to", "50"), 2, "leave out --from"),
        (("locus", SOAP, "--size", "big"), 2, "640x480"),
        (("strip", SOAP, "--exposure", "bright"), 2, "stops"),
        (("angle", SOAP, "--angle", "steep"), 2, "degrees"),
        (("locus", ""), 3, "two or more items"),
        (("locus", "air / air"), 3, "needs a layer that grows"),
        (("locus", "air / soap / SiO2 / air"), 3, "only one layer"),
        (("locus", "air / soap 5 / SiO2 5 / air"), 3, "say which grows"),
        (("locus", "air / sop / air"), 3, "did you mean"),
        (("locus", SOAP, "--layer", "2"), 3, "layer must be 1 to 1"),
        (("locus", SOAP, "--range", "900:100"), 3, "must ascend"),
        (("locus", SOAP, "--from", "-5"), 3, "must be >= 0"),
        (("locus", SOAP, "--to", "nan"), 3, "finite"),
        (("locus", SOAP, "--to", "1e9"), 3, "at most 100000 nm"),
        (("locus", SOAP, "--angle", "90"), 3, "--angle must be"),
        (("locus", SOAP, "--illuminant", "missing.csv"), 3, "missing.csv"),
        (("locus", SOAP, "--theme", "pink"), 3, "theme must be"),
        (("locus", SOAP, "--gamut", "cmyk"), 3, "gamuts must be"),
        (("locus", SOAP, "--size", "10x10"), 3, "at least 160x120"),
        (("locus", *[SOAP], *["--model", "exact"] * 5), 3, "four times"),
        (("angle", SOAP, "--angle", "0:90"), 3, "--angle must be"),
        (("locus", SOAP, "--size", "99999x99999"), 4, "at most 16384x16384"),
        (("locus", SOAP, "--size", f"{10**30}x500"), 4, "at most 16384x16384"),
        (("locus", SOAP, "-o", "nowhere/a.png"), 1, "nowhere"),
        (("locus", SOAP, "-o", "kept.png/a.png"), 1, "kept.png"),
    ],
)
def test_chart_refuses_what_is_wrong(
    iridesce: Run, tmp_path: Path, arguments: tuple[str, ...], code: int, said: str
) -> None:
    kept = tmp_path / "kept.png"
    kept.write_bytes(b"precious")
    (tmp_path / "locus-air-soap-air.png").write_bytes(b"precious")
    finished = iridesce("chart", *arguments)
    assert finished.returncode == code, finished.stderr
    assert said in finished.stderr
    if code != 2:
        assert finished.stderr.startswith("error: ") and finished.stdout == ""
    assert {path.name for path in tmp_path.iterdir()} == {"kept.png", "locus-air-soap-air.png"}
    assert all(path.read_bytes() == b"precious" for path in tmp_path.iterdir())


def test_a_folder_is_not_overwritten(iridesce: Run, tmp_path: Path) -> None:
    (tmp_path / "a.png").mkdir()
    finished = iridesce("chart", "strip", SOAP, "-o", "a.png")
    assert (finished.returncode, finished.stdout) == (1, "")
    assert "it is a folder" in finished.stderr


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_bytes(b"old")
    write_whole(path, b"new")
    assert path.read_bytes() == b"new"

    # A limit on the size of files stands for a full disk; files/test_writing.py fills others.
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    heard = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2, limit[1]))
    try:
        with pytest.raises(OSError, match="cannot be written") as caught:
            write_whole(path, b"newer")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
        signal.signal(signal.SIGXFSZ, heard)
    assert caught.value.filename == str(path)
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]


# --- media


def test_media_in_full(iridesce: Run) -> None:
    shown = iridesce("media", "rutile-o").stdout
    assert "430-1530 nm" in shown
    assert "360-430 nm: the dispersion formula is continued" in shown
    assert "Devore" in shown
    rows = re.findall(r"^ *(\d+) nm   n = ([\d.]+)   k = 0$", shown, flags=re.M)
    wanted = [(f"{nm}", f"{ir.Medium('rutile-o').index(nm).real:.5f}") for nm in range(450, 701, 50)]
    assert rows == wanted
    answer = json.loads(iridesce("media", "rutile-o", "--json").stdout)
    assert answer["extension"].startswith("360-430 nm") and answer["note"]


def test_media_plots(iridesce: Run, tmp_path: Path) -> None:
    finished = iridesce("media", "Ti", "-o", "ti.svg", "--theme", "dark")
    assert finished.stdout.splitlines()[-1] == "ti.svg"
    svg = (tmp_path / "ti.svg").read_text()
    assert "refractive index n" in svg and "Johnson" in svg
    answer = json.loads(iridesce("media", "Ti", "-o", "ti.png", "--size", "400x300", "--json").stdout)
    assert answer["files"] == ["ti.png"]
    assert pixels(tmp_path / "ti.png").shape[:2] == (300, 400)


def test_media_search(iridesce: Run) -> None:
    names = [line.split()[0] for line in iridesce("media", "--search", "johnson CHRISTY").stdout.splitlines()]
    assert {"Ag", "Au", "Ti"} <= set(names) and "water" not in names


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (("-o", "a.png"), 2, "shows one medium"),
        (("Ti", "--search", "x"), 2, "leave out NAME"),
        (("Ti", "-o", "a.gif"), 2, ".png"),
        (("unobtainium", "-o", "a.png"), 3, "unobtainium"),
        (("Ti", "-o", "a.png", "--theme", "x"), 3, "theme"),
        (("Ti", "-o", "nowhere/a.png"), 1, "nowhere"),
    ],
)
def test_media_refuses_what_is_wrong(
    iridesce: Run, tmp_path: Path, arguments: tuple[str, ...], code: int, said: str
) -> None:
    finished = iridesce("media", *arguments)
    assert finished.returncode == code, finished.stderr
    assert said in finished.stderr
    assert list(tmp_path.iterdir()) == []
