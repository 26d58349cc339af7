"""One writer: links and rights kept, whole or not at all, whatever ends the process."""

from __future__ import annotations

import copy
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import command_line
import iridesce as ir
from iridesce.files.whole import write_whole


def test_links_and_rights_are_kept(tmp_path: Path) -> None:
    real, link = tmp_path / "real.csv", tmp_path / "link.csv"
    real.touch()
    real.chmod(0o600)
    link.symlink_to(real)
    write_whole(link, b"answer\n")
    assert link.is_symlink()
    assert real.read_bytes() == b"answer\n"
    assert real.stat().st_mode & 0o777 == 0o600


def test_the_umask_is_never_touched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For the moment in which it was 0, files of other threads were open to everybody."""
    monkeypatch.setattr(os, "umask", lambda _: pytest.fail("the umask was set"))
    monkeypatch.chdir(tmp_path)
    write_whole(Path("x"), b"1")
    assert Path("x").read_bytes() == b"1"


def run(code: str, **options: object) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, stdout=subprocess.PIPE, **options)  # type: ignore[call-overload,no-any-return]


def test_a_killed_writer_leaves_the_old_file_or_the_new(tmp_path: Path) -> None:
    path = tmp_path / "x.bin"
    old, new = b"a" * (1 << 20), b"b" * (1 << 20)
    write_whole(path, old)
    code = (
        "from pathlib import Path; from iridesce.files.whole import write_whole\n"
        "print('ready', flush=True)\n"
        f"while True:\n  write_whole(Path({str(path)!r}), b'b' * (1 << 20)); write_whole(Path({str(path)!r}), b'a' * (1 << 20))\n"
    )
    for attempt in range(6):
        process = run(code)
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(0.003 + 0.017 * attempt)
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert path.read_bytes() in (old, new)


def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "x.exr"
    path.write_bytes(b"old")
    code = f"""
import resource, signal
import numpy as np
import iridesce as ir
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
image = ir.Image(np.random.default_rng(1).random((200, 200, 3)))
table = ir.thickness.ThicknessMap(np.random.default_rng(1).random((300, 300)))
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
for save in (lambda: image.save({str(path)!r}), lambda: table.save({str(path)!r})):
    try:
        save()
    except OSError as error:
        assert {str(path)!r} in str(error), error
        print("refused")
"""
    process = run(code)
    said, complained = process.communicate(timeout=60)
    assert said.split() == [b"refused", b"refused"], complained.decode()
    assert path.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["x.exr"]


@pytest.mark.parametrize(
    ("shell", "code"),
    [
        ('{} color "air / soap 320 / air" > /dev/full', 1),
        ("{} --help > /dev/full", 1),
        ("{} media > /dev/full", 1),
        ('{} color "air / soap 320 / air" 2> /dev/full', 0),
        ('{} color "air / soap 320 / air" >&-', 0),
        ("{} --help >&-", 0),
        ('{} color "air / soap x / air" 2>&-', 3),
        ('{} color "air / soap x / air" 2> /dev/full', 3),
    ],
)
def test_streams_that_take_nothing(shell: str, code: int) -> None:
    """Each of these ended in a traceback, or in failure after success."""
    command = shell.format(f"{sys.executable} -m iridesce")
    done = subprocess.run(command, shell=True, capture_output=True, text=True, timeout=60)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr


def test_colour_tables_are_copied_and_pickled() -> None:
    film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=0.0), "air"])
    table = ir.ColorTable(film, (0.0, 300.0), angle_deg=(0.0, 20.0), illuminant=["D65", "A"], max_delta_e=1.0)
    for made in (pickle.loads(pickle.dumps(table)), copy.deepcopy(table), copy.copy(table)):
        assert made.illuminants == table.illuminants
        np.testing.assert_array_equal(made.color(123.0, 10.0, illuminant="A"), table.color(123.0, 10.0, illuminant="A"))


def test_images_take_real_numbers_only() -> None:
    for wrong in (np.ones((2, 2, 3), complex), np.array([[["a", "b", "c"]]]), np.ones((1,) * 33)):
        with pytest.raises(ValueError, match=r"^xyz must"):
            ir.Image(wrong)
    deep: object = 1.0
    for _ in range(70):
        deep = [deep]
    with pytest.raises(ValueError, match=r"^xyz must"):
        ir.Image(deep)  # type: ignore[arg-type]


def test_one_setting_takes_one_line() -> None:
    import typer

    from iridesce.cli.reading import assignment

    with pytest.raises(typer.BadParameter, match="wanted one KEY=VALUE"):
        assignment("a=1\nb=3")
    for value in ("[" * 20_000, "9" * 5000):
        with pytest.raises(ValueError, match="--set a: "):
            assignment(f"a={value}")
    assert assignment("a = 3") == ("a", 3)


def frames(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in sorted(folder.glob("frame_*"))}


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["empty", "half", "gone"])
def test_damaged_frames_are_drawn_again(tmp_path: Path, damage: str) -> None:
    folder = tmp_path / "shot"
    command = ["animate", "soap-bubble", "--seconds", "0.1", "--fps", "20"]
    command += ["--size", "16x12", "--samples", "1", "-o", str(folder), "--format", "png"]
    assert command_line.run(command, tmp_path).returncode == 0
    whole = frames(folder)
    broken = folder / "frame_00001.png"
    harm: dict[str, Callable[[], object]] = {
        "empty": lambda: broken.write_bytes(b""),
        "half": lambda: broken.write_bytes(whole[broken.name][: len(whole[broken.name]) // 2]),
        "gone": broken.unlink,
    }
    harm[damage]()
    done = command_line.run([*command, "--resume"], tmp_path)
    assert done.returncode == 0 and frames(folder) == whole
    assert "1 of them drawn now" in done.stderr
    assert damage == "gone" or "it is drawn again" in done.stderr


def test_a_frame_that_cannot_be_made_again_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    command = ["flow", "late", "--time", "0.02", "--fps", "50"]
    command += ["--columns", "64", "--set", "regeneration=0", "-o", str(folder)]
    assert command_line.run(command, tmp_path).returncode == 0
    (folder / "frame_00000.tif").write_bytes(b"")
    command[command.index("0.02")] = "0.04"
    done = command_line.run([*command, "--resume"], tmp_path)
    assert done.returncode == 3, done.stderr
    assert "frame_00000.tif" in done.stderr
    assert "cannot make it again" in done.stderr
