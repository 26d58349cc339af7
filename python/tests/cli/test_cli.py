"""The command line as a user meets it: a new process each time, its exit code and both of its streams."""

from __future__ import annotations

import csv
import io
import json
import os
import pty
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from conftest import ROOT, Run

VERBS = ("render", "color", "spectrum", "chart", "media", "scenes", "check", "info")
QUICK = ("--size", "24x16", "--samples", "1")
SOAP = "air / soap 320 / air"


def on_terminal(*arguments: str, cwd: Path, **env: str) -> str:
    """What a terminal of 256 colours would show: both streams of a command that runs inside a pseudo-terminal."""
    ours, theirs = pty.openpty()
    base = {key: value for key, value in os.environ.items() if key not in {"NO_COLOR", "FORCE_COLOR"}}
    process = subprocess.Popen(
        [sys.executable, "-m", "iridesce", *arguments],
        cwd=cwd,
        env={**base, "TERM": "xterm-256color", "COLUMNS": "120", **env},
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
    )
    os.close(theirs)
    shown = b""
    while True:
        try:
            piece = os.read(ours, 65536)
        except OSError:  # the other side is closed
            break
        if not piece:
            break
        shown += piece
    os.close(ours)
    assert process.wait(60) == 0, shown
    return shown.decode()


# --- help and usage


def test_help_names_every_verb(iridesce: Run) -> None:
    shown = iridesce("--help")
    assert shown.returncode == 0
    for verb in VERBS:
        assert verb in shown.stdout
        assert iridesce(verb, "--help").returncode == 0


def test_help_is_light() -> None:
    """numpy, matplotlib and the core cost more than the help itself: nothing of them may be loaded for it."""
    command = [sys.executable, "-X", "importtime", "-m", "iridesce", "--help"]
    finished = subprocess.run(command, capture_output=True, text=True, check=True)
    loaded = {
        line.rpartition("|")[2].strip() for line in finished.stderr.splitlines() if line.startswith("import time")
    }
    assert "typer" in loaded
    assert loaded & {"numpy", "matplotlib", "tifffile", "iridesce._core", "asyncio"} == set()


def test_script_and_module_are_the_same() -> None:
    script = Path(sys.executable).with_name("iridesce")
    by_script = subprocess.run([script, "--version"], capture_output=True, text=True, check=True).stdout
    assert by_script == f"iridesce {ir.__version__}\n"


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("paint",),
        ("render",),
        ("render", "soap-bubble", "--sizes", "3x3"),
        ("render", "soap-bubble", "--size", "big"),
        ("render", "soap-bubble", "--size", "3"),
        ("render", "soap-bubble", "--size=-3x3"),
        ("render", "soap-bubble", "--samples", "many"),
        ("render", "soap-bubble", "--exposure", "bright"),
        ("render", "soap-bubble", "--set", "camera.fov_deg"),
        ("render", "soap-bubble", "-o", "bubble.jpg"),
        ("color", SOAP, "--angle", "steep"),
    ],
)
def test_wrong_usage(iridesce: Run, tmp_path: Path, arguments: tuple[str, ...]) -> None:
    finished = iridesce(*arguments)
    assert finished.returncode == 2
    assert finished.stderr or not arguments
    assert list(tmp_path.iterdir()) == []


# --- render


def test_render_writes_both_pictures(iridesce: Run, tmp_path: Path) -> None:
    finished = iridesce("render", "soap-bubble", *QUICK)
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout.split() == ["soap-bubble.png", "soap-bubble.exr"]
    assert "24 x 16" in finished.stderr
    assert "\x1b" not in finished.stderr, "no bar and no colour where stderr is no terminal"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["soap-bubble.exr", "soap-bubble.png"]
    assert (tmp_path / "soap-bubble.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert (tmp_path / "soap-bubble.exr").read_bytes()[:4] == b"\x76\x2f\x31\x01"


def test_render_obeys_its_options(iridesce: Run, tmp_path: Path) -> None:
    def picture(name: str, *arguments: str) -> bytes:
        finished = iridesce("render", "soap-bubble", *QUICK, "-o", name, *arguments)
        assert finished.returncode == 0, finished.stderr
        return (tmp_path / name).read_bytes()

    first = picture("first.png", "--exposure", "0", "--threads", "1")
    assert picture("again.png", "--exposure", "0", "--threads", "2") == first, "the number of threads changes nothing"
    assert picture("seed.png", "--exposure", "0", "--seed", "77") != first
    assert picture("dark.png", "--exposure", "-2") != first
    assert picture("even.png", "--exposure", "0", "--set", "object.bubble.surface.film.thickness_nm=400") != first


def test_render_says_in_json_how_it_was_made(iridesce: Run, tmp_path: Path) -> None:
    finished = iridesce("render", "soap-bubble", *QUICK, "--seed", "5", "-o", "a.png", "-o", "b.exr", "--json")
    answer = json.loads(finished.stdout)
    assert answer["files"] == ["a.png", "b.exr"]
    assert (answer["samples"], answer["seed"], answer["backend"]) == (1, 5, "cpu")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "b.exr"]


def test_render_takes_a_file(iridesce: Run, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(iridesce("check", "soap-bubble").stdout)
    assert iridesce("render", "mine.toml", *QUICK).stdout.split() == ["mine.png", "mine.exr"]


def test_bar_on_a_terminal(tmp_path: Path) -> None:
    shown = on_terminal("render", "soap-bubble", *QUICK, cwd=tmp_path)
    assert "rendering" in shown
    assert "left" in shown


def test_no_color_is_obeyed(tmp_path: Path) -> None:
    colored = on_terminal("color", SOAP, cwd=tmp_path)
    assert "\x1b[" in colored, "a swatch"
    plain = on_terminal("color", SOAP, cwd=tmp_path, NO_COLOR="1")
    assert "\x1b[" not in plain
    assert "XYZ" in plain


def test_existing_pictures_survive_a_failure(iridesce: Run, tmp_path: Path) -> None:
    kept = tmp_path / "soap-bubble.png"
    kept.write_bytes(b"precious")
    for arguments, code in (
        (("--size", "0x0"), 3),
        (("--size", "99999999x99999999"), 4),
        (("--size", f"{10**30}x1"), 4),
        (("--samples", "0"), 3),
        (("--threads", "0"), 3),
        (("--set", "camera.fov=3"), 3),
        (("--set", "camera.fov_deg=-3"), 3),
        (("--set", 'object.bubble.surface.film.medium="unobtainium"'), 3),
        (("--set", "object.bubble.surface.film.thickness_nm=nan"), 3),
        (("-o", "soap-bubble.png", "-o", "nowhere/bubble.exr"), 1),
        (("-o", "soap-bubble.png", "-o", "soap-bubble.png/bubble.exr"), 1),
    ):
        finished = iridesce("render", "soap-bubble", *arguments)
        assert finished.returncode == code, f"{arguments}: {finished.stderr}"
        assert finished.stderr.startswith("error: "), finished.stderr
        assert finished.stdout == ""
        assert kept.read_bytes() == b"precious"
        assert list(tmp_path.iterdir()) == [kept]


def test_a_folder_is_not_overwritten(iridesce: Run, tmp_path: Path) -> None:
    (tmp_path / "out.png").mkdir()
    finished = iridesce("render", "soap-bubble", *QUICK, "-o", "out.png")
    assert finished.returncode == 1
    assert "out.png" in finished.stderr


def test_a_whole_new_file_takes_the_old_one_s_place(iridesce: Run, tmp_path: Path) -> None:
    old = tmp_path / "bubble.png"
    old.write_bytes(b"old")
    assert iridesce("render", "soap-bubble", *QUICK, "-o", "bubble.png").returncode == 0
    assert old.read_bytes()[:4] == b"\x89PNG"
    assert list(tmp_path.iterdir()) == [old], "no temporary file stays"


@pytest.mark.parametrize("delay_s", [0.4, 1.5])
def test_ctrl_c(tmp_path: Path, delay_s: float) -> None:
    """Ctrl-C is answered long before the picture would be done, leaving no file and no traceback.

    How soon is measured in docs/evidence/performance.md; a busy machine must not fail a test.
    """
    (tmp_path / "soap-bubble.png").write_bytes(b"precious")
    process = subprocess.Popen(
        [sys.executable, "-m", "iridesce", "render", "soap-bubble", "--size", "2000x2000", "--samples", "4096"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(delay_s)
    assert process.poll() is None
    start = time.perf_counter()
    process.send_signal(signal.SIGINT)
    try:
        stdout, stderr = process.communicate(timeout=30)
    finally:
        process.kill()  # a render that nothing stopped would take its two hours
    assert time.perf_counter() - start < 10.0
    # Python itself answers while it is starting, before a line of ours has run.
    starting = {-signal.SIGINT} if delay_s < 1.0 else set()
    assert process.returncode in {130} | starting
    assert stdout == ""
    if process.returncode == 130:
        assert "Traceback" not in stderr
        assert len(stderr.splitlines()) <= 1, "a note at most"
    assert [path.name for path in tmp_path.iterdir()] == ["soap-bubble.png"]
    assert (tmp_path / "soap-bubble.png").read_bytes() == b"precious"


# --- scenes


def test_scenes_lists_the_built_in_ones(iridesce: Run) -> None:
    names = iridesce("scenes").stdout.split()
    assert "soap-bubble" in names
    assert json.loads(iridesce("scenes", "--json").stdout) == names


SCENE_FILES = sorted([*(ROOT / "scenes").glob("*.toml"), *(ROOT / "crates" / "scene" / "scenes").glob("*.toml")])


@pytest.mark.parametrize("path", SCENE_FILES, ids=lambda path: path.name)
def test_check_prints_a_scene_that_reads_back(iridesce: Run, tmp_path: Path, path: Path) -> None:
    finished = iridesce("check", str(path))
    assert finished.returncode == 0, finished.stderr
    tree = tomllib.loads(finished.stdout)
    assert json.loads(iridesce("check", str(path), "--json").stdout) == tree
    if "map" not in finished.stdout:  # a map lies beside its scene
        (tmp_path / "again.toml").write_text(finished.stdout)
        assert iridesce("check", "again.toml").stdout == finished.stdout


def test_check_warns_of_what_ends_a_render(iridesce: Run, tmp_path: Path) -> None:
    (tmp_path / "pool.toml").write_text(
        "version = 1\n[camera]\nposition = [0, 4, 16]\n[[object]]\nname = 'pool'\n"
        "shape = { disk = { center = [0, 0, 0], normal = [0, 1, 0], radius = 4.0 } }\n"
        "surface = { coating = { layers = [{ medium = 1.47, thickness_nm = 300 }], substrate = 'water' } }\n"
        "[[object]]\nname = 'floor'\nshape = { plane = { point = [0, -1, 0], normal = [0, 1, 0] } }\n"
        "surface = { diffuse = { reflectance = 0.5 } }\n[[light]]\nenvironment = { builtin = 'studio' }\n"
    )
    checked = iridesce("check", "pool.toml")
    assert checked.returncode == 0 and 'object "pool": "water" lies behind a disk' in checked.stderr
    drawn = iridesce("render", "pool.toml", "--size", "64x48", "--samples", "4", "-o", "pool.png")
    assert drawn.returncode == 3 and "close the body that the medium fills" in drawn.stderr


def test_check_fills_in_the_defaults(iridesce: Run, tmp_path: Path) -> None:
    (tmp_path / "least.toml").write_text(
        "version = 1\n[camera]\nposition = [0, 0, 16]\n[[object]]\nname = 'a'\n"
        "shape = { sphere = { radius = 4.0 } }\n"
        "surface = { film = { medium = 'soap', thickness_nm = 300 } }\n"
        "[[light]]\nenvironment = { builtin = 'studio' }\n"
    )
    finished = iridesce("check", "least.toml")
    assert finished.returncode == 0, finished.stderr
    tree = tomllib.loads(finished.stdout)
    assert tree["unit"] == "cm"
    assert tree["camera"]["fov_deg"] == 35.0
    assert tree["render"] == {"samples": 64, "seed": 1, "max_depth": 16}
    assert tree["object"][0]["surface"]["film"]["outside"] == "air"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", ""),
        ("version = 1\n", "camera"),
        ("version = 1\n[camera\n", "bad.toml:2"),
        ("version = 1\n\n[camera]\nfov_degg = 3\n", "fov_deg"),
        ("\0\x01\x02", "bad.toml"),
    ],
)
def test_a_bad_scene_is_refused_with_its_place(iridesce: Run, tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "bad.toml").write_text(text)
    for verb in ("check", "render"):
        finished = iridesce(verb, "bad.toml")
        assert finished.returncode == 3
        assert finished.stderr.startswith("error: ")
        assert said in finished.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["bad.toml"]


@pytest.mark.parametrize(
    ("scene", "said"),
    [("soap-buble", "soap-bubble"), ("missing.toml", "missing.toml"), (".", ""), ("", "")],
)
def test_an_unknown_scene_is_refused(iridesce: Run, scene: str, said: str) -> None:
    finished = iridesce("check", scene)
    assert finished.returncode == 3, finished.stderr
    assert said in finished.stderr


# --- numbers


def test_color_is_that_of_the_library(iridesce: Run) -> None:
    stack = ir.Stack(["air", ir.Layer("soap", thickness_nm=320.0), "air"])
    answer = json.loads(iridesce("color", SOAP, "--angle", "30", "--illuminant", "A", "--json").stdout)
    for space in ("xyz", "xyy", "lab", "lch"):
        wanted = stack.color(angle_deg=30.0, illuminant="A", space=space)
        np.testing.assert_allclose(answer[space], wanted, rtol=0, atol=1e-15)
    printed = iridesce("color", SOAP, "--space", "oklab").stdout.split()
    np.testing.assert_allclose([float(word) for word in printed], stack.color(space="oklab"), rtol=1e-5)
    polarized = iridesce("color", SOAP, "--angle", "60", "--polarization", "p", "--space", "xyz", "--json").stdout
    wanted = stack.color(angle_deg=60.0, polarization="p")
    np.testing.assert_allclose(json.loads(polarized)["values"], wanted, rtol=0, atol=1e-15)


def test_color_for_people(iridesce: Run) -> None:
    shown = iridesce("color", SOAP)
    assert shown.returncode == 0
    assert {"XYZ", "sRGB"} <= {line.split()[0] for line in shown.stdout.splitlines()}
    assert "\x1b" not in shown.stdout


def test_spectrum_is_csv(iridesce: Run) -> None:
    arguments = ("spectrum", "air / TiO2 60 / Ti", "--from", "400", "--to", "700", "--step", "0.1", "--angle", "45")
    rows = list(csv.reader(io.StringIO(iridesce(*arguments).stdout)))
    assert rows[0] == ["wavelength_nm", "reflectance", "transmittance", "absorptance"]
    table = np.array(rows[1:], dtype=float)
    np.testing.assert_allclose(table[:, 0], np.linspace(400.0, 700.0, 3001), rtol=1e-9)
    stack = ir.Stack(["air", ir.Layer("TiO2", thickness_nm=60.0), "Ti"])
    np.testing.assert_allclose(table[:, 1], stack.reflectance(np.linspace(400.0, 700.0, 3001), 45.0), rtol=1e-9)
    np.testing.assert_allclose(table[:, 1:].sum(axis=1), 1.0, atol=1e-9)
    answer = json.loads(iridesce(*arguments, "--json").stdout)
    np.testing.assert_allclose(answer["reflectance"], table[:, 1], rtol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("color", ""), 3),
        (("color", "air"), 3),
        (("color", "air / soap / air"), 3),
        (("color", "air / soap -5 / air"), 3),
        (("color", "air / soap nan / air"), 3),
        (("color", "air / unobtainium 300 / air"), 3),
        (("color", "air / sop 300 / air"), 3),
        (("color", SOAP, "--angle", "90"), 3),
        (("color", SOAP, "--angle", "nan"), 3),
        (("color", SOAP, "--polarization", "x"), 3),
        (("color", SOAP, "--illuminant", "D66"), 3),
        (("color", SOAP, "--illuminant", "missing.csv"), 3),
        (("color", SOAP, "--observer", "cie1930"), 3),
        (("color", SOAP, "--space", "cmyk"), 3),
        (("color", SOAP, "--quantity", "glossiness"), 3),
        (("spectrum", SOAP, "--from", "nan"), 3),
        (("spectrum", SOAP, "--from", "-1"), 3),
        (("spectrum", SOAP, "--from", "700", "--to", "400"), 3),
        (("spectrum", SOAP, "--step", "0"), 3),
        (("spectrum", SOAP, "--step", "1e-9"), 4),
        (("media", "unobtainium"), 3),
    ],
)
def test_bad_input(iridesce: Run, arguments: tuple[str, ...], code: int) -> None:
    finished = iridesce(*arguments)
    assert finished.returncode == code, finished.stderr
    assert finished.stderr.startswith("error: ")
    assert finished.stdout == ""


def test_media_know_their_source_and_range(iridesce: Run) -> None:
    rows = json.loads(iridesce("media", "--json").stdout)
    assert {"water", "soap", "N-BK7", "Ti", "TiO2"} <= {row["name"] for row in rows}
    assert all(row["source"] for row in rows)
    listed = iridesce("media").stdout.splitlines()
    assert len(listed) == len(rows)
    one = json.loads(iridesce("media", "N-BK7", "--json").stdout)
    wavelength_nm, n, k = one["index"][3]
    assert wavelength_nm == 550.0
    assert n == pytest.approx(complex(ir.Medium("N-BK7").index(550.0)).real)
    assert k == pytest.approx(complex(ir.Medium("N-BK7").index(550.0)).imag)


def test_info_says_what_is_at_work(iridesce: Run) -> None:
    facts = json.loads(iridesce("info", "--json", env={"RAYON_NUM_THREADS": "3"}).stdout)
    assert facts["iridesce"] == ir.__version__
    assert facts["threads"] == 3
    assert facts["simd"]
    assert "CIE" in facts["data"]["illuminants"]
    assert "threads" in iridesce("info").stdout


def test_a_reader_that_leaves_early(tmp_path: Path) -> None:
    """`| head -1` closes the pipe: that is no fault and no traceback."""
    command = f"'{sys.executable}' -m iridesce spectrum 'air / 1.5' --step 0.01 | head -1"
    finished = subprocess.run(["bash", "-c", command], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert finished.stdout.startswith("wavelength_nm")
    assert finished.stderr == ""
