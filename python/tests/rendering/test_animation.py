"""The verb ``animate``: frames, video, resuming; camera paths against closed forms."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import command_line
import iridesce as ir
from iridesce.rendering import animation
from iridesce.rendering.pictures import draw

SMALL = ("--size", "48x32", "--samples", "1", "--columns", "304", "--fps", "20")
CAMERA = {"position": [0.0, 0.0, 16.0], "target": [0.0, 0.0, 0.0], "up": [0.0, 1.0, 0.0], "fov_deg": 35.0}


def iridesce(*words: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return command_line.run(words, folder, environment or None)


def frames_of(video: Path) -> tuple[int, float]:
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    count, seconds = imageio_ffmpeg.count_frames_and_secs(str(video))
    return int(count), float(seconds)


# --- the verb


def test_a_video_of_every_kind_has_its_frames(tmp_path: Path) -> None:
    for name in ("bubble.mp4", "bubble.webm", "bubble.gif"):
        done = iridesce("animate", "soap-bubble", "--seconds", "0.2", *SMALL, "-o", name, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        assert done.stdout.strip() == name
        count, seconds = frames_of(tmp_path / name)
        assert (count, seconds) == (4, pytest.approx(0.2, abs=0.051))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bubble.gif", "bubble.mp4", "bubble.webm"]


def test_interrupted_footage_goes_on_to_the_same_frames(tmp_path: Path) -> None:
    words = ("animate", "soap-bubble", "--seconds", "0.3", "--orbit", "10", *SMALL)
    straight = iridesce(*words, "-o", "one", "--json", folder=tmp_path)
    assert straight.returncode == 0, straight.stderr
    assert json.loads(straight.stdout)["drawn"] == 6
    # What is left after the fourth frame: that state comes from a shorter run of the same film.
    assert iridesce(*words, "-o", "two", folder=tmp_path).returncode == 0
    for number in (2, 3, 4, 5):
        (tmp_path / "two" / f"frame_{number:05d}.png").unlink()
    (tmp_path / "two" / "film_0.irflow").unlink()
    refused = iridesce(*words, "-o", "two", folder=tmp_path)
    assert refused.returncode == 3 and "--resume" in refused.stderr
    again = iridesce(*words, "-o", "two", "--resume", "--json", folder=tmp_path)
    assert again.returncode == 0, again.stderr
    assert json.loads(again.stdout)["drawn"] == 4
    for path in sorted((tmp_path / "one").iterdir()):
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes(), path.name
    pictures = {path.read_bytes() for path in (tmp_path / "one").glob("*.png")}
    assert len(pictures) == 6, "every frame differs"


def test_a_spoiled_state_of_a_film_costs_time_and_nothing_else(tmp_path: Path) -> None:
    words = ("animate", "soap-bubble", "--seconds", "0.1", *SMALL, "-o", "run")
    assert iridesce(*words, folder=tmp_path).returncode == 0
    last = tmp_path / "run" / "frame_00001.png"
    before = last.read_bytes()
    last.unlink()
    (tmp_path / "run" / "film_0.irflow").write_bytes(b"rubbish")
    again = iridesce(*words, "--resume", folder=tmp_path)
    assert again.returncode == 0 and "Traceback" not in again.stderr, again.stderr
    assert last.read_bytes() == before


def test_films_go_on_from_where_they_were_kept(tmp_path: Path) -> None:
    code = (
        "import iridesce as ir; from pathlib import Path; from iridesce.rendering import animation\n"
        "film = animation.FlowingFilm('', 'late', 9, None); seen = []\n"
        "base = ir.Scene.load({'version': 1, 'camera': {}, 'light': [{'environment': {'illuminant': 'D65'}}], 'object': "
        "[{'surface': {'film': {'thickness_nm': {'flow': {'preset': 'late', 'seed': 9, 'time_s': 0.0}}}}}]})\n"
        "def at(s):\n"
        "    now = base.with_value('object.0.surface.film.thickness_nm.flow.time_s', s)\n"
        "    image = ir.render(now, samples=1, size=(16, 16), progress=lambda done, total, stage: seen.append((stage, total)))\n"
        "    return image.channels['thickness_nm'].tobytes().hex()\n"
    )
    keep = "at(0.05); animation.keep_films(base, [film], Path('.')); print(at(0.1))"
    take = (
        "animation.take_up_films(base, [film], Path('.')); "
        "print(at(0.1), *[total for stage, total in seen if stage == 'flowing'][:1])"
    )
    said = []
    for rest in (keep, take):
        done = subprocess.run([sys.executable, "-c", code + rest], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        said.append(done.stdout.split())
    assert said[1][0] == said[0][0]
    assert int(said[1][1]) == 10, "of 20 steps, the second process makes the last ten"


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_leaves_whole_frames_and_a_film_to_go_on_with(tmp_path: Path) -> None:
    words = ["animate", "soap-bubble", "--seconds", "60", *SMALL, "-o", "long.mp4"]
    with subprocess.Popen(
        [sys.executable, "-m", "iridesce", *words], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    ) as process:
        folder = tmp_path / "long.frames"
        until = time.monotonic() + 60
        while not (folder / "frame_00002.png").exists() and time.monotonic() < until:
            time.sleep(0.02)
        os.kill(process.pid, signal.SIGINT)
        try:
            _, said = process.communicate(timeout=60)
        finally:
            process.kill()  # nothing, if it has ended
    assert process.returncode == 130, said
    assert "Traceback" not in said
    assert not (tmp_path / "long.mp4").exists() and not list(folder.glob(".*"))
    frames = sorted(folder.glob("*.png"))
    assert len(frames) >= 3 and all(path.read_bytes()[-8:-4] == b"IEND" for path in frames)
    assert (folder / "film_0.irflow").exists() and "stops" in json.loads((folder / "run.json").read_text())


def test_frames_are_the_scene_at_their_times(tmp_path: Path) -> None:
    done = iridesce(
        *("animate", "soap-bubble", "--seconds", "0.1", *SMALL, "--start", "0.1", "--speed", "2", "--exposure", "1"),
        *("--format", "both", "-o", "run"),
        folder=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    key = "object.bubble.surface.film.thickness_nm"
    # The second frame was drawn over the first; this one stands alone.
    scene = ir.Scene.load("soap-bubble").with_value(key, ir.thickness.flow("free-bubble", 0.2, columns=304))
    image = animation.draw_frame(scene, 1, (48, 32), None)
    image.save(tmp_path / "wanted.png", exposure=1.0)
    image.save(tmp_path / "wanted.exr")
    assert (tmp_path / "wanted.exr").read_bytes() == (tmp_path / "run" / "frame_00001.exr").read_bytes()
    assert_same_picture(tmp_path / "wanted.png", tmp_path / "run" / "frame_00001.png")


def assert_same_picture(wanted: Path, frame: Path) -> None:
    """Frames are packed in less time: the same pixels, facts and colour space in other bytes."""
    with Image.open(wanted) as one, Image.open(frame) as other:
        assert (np.asarray(one) == np.asarray(other)).all() and one.info == other.info


def test_a_frame_is_drawn_where_something_may_have_changed_and_nowhere_else(tmp_path: Path) -> None:
    scene = ir.Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", 300.0)
    first = animation.draw_frame(scene, 4, (200, 100), None)
    left, top, width, height = first._surfaces or (0, 0, 0, 0)
    shown = np.argwhere(first.channels["object"] >= 0)
    assert shown.min(0).tolist() >= [top, left] and shown.max(0).tolist() < [top + height, left + width]
    assert 0.3 < width * height / (200 * 100) < 0.7
    later = scene.with_value("object.bubble.surface.film.thickness_nm", 400.0)
    alone, over = (
        animation.draw_frame(later, 4, (200, 100), None),
        animation.draw_frame(later, 4, (200, 100), None, first),
    )
    assert (alone.xyz == over.xyz).all() and (alone.xyz != first.xyz).any()
    for name, plane in alone.channels.items():
        np.testing.assert_array_equal(plane, over.channels[name])
    assert over.metadata["scene"] == alone.metadata["scene"] and "crop" not in over.metadata
    # What lies behind is really taken over, not drawn.
    dark = first._of_render(np.zeros_like(first.xyz), dict(first._planes), {}, first.metadata, first._surfaces)
    assert left > 0 and (animation.draw_frame(later, 4, (200, 100), None, dark).xyz[:, :left] == 0.0).all()
    # Of a film that shines brighter than a screen: what stands still is developed once, and counted.
    frames = animation.Frames(still=True)
    lean = animation.draw_frame(later, 4, (200, 100), None, first, planes=False)
    assert set(lean.channels) < set(over.channels)
    for number, image in enumerate((first, lean, first)):
        frames.save(image, tmp_path / "frame.png", 2.0)
        image.save(tmp_path / "wanted.png", exposure=2.0)
        assert_same_picture(tmp_path / "wanted.png", tmp_path / "frame.png")
        with Image.open(tmp_path / "frame.png") as frame:
            assert float(frame.info["overexposed"]) > 0.01, number


def test_settled_frames_look_like_whole_ones() -> None:
    flow = ir.thickness.flow("free-bubble", 0.1, columns=304)
    scene = ir.Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", flow)
    # From the middle of the bubble to its rim, as footage of 1280 x 720 shows it.
    asked = {"samples": 12, "size": (1280, 720), "crop": (640, 330, 304, 48)}
    plain, settled = draw(scene, asked, None), draw(scene, {**asked, "settled": animation.SETTLED}, None)
    stops, film = plain.exposure_stops(), plain.channels["object"] >= 0
    lab = [ir.color.convert(image.rgb(exposure=stops)[film], "srgb", "lab") for image in (plain, settled)]
    difference = ir.color.delta_e(*lab)
    assert 0.0 < np.median(difference) < 0.5 and np.percentile(difference, 95) < 3.0
    assert settled.channels["samples"][film].mean() < 6.0


def test_without_ffmpeg_there_are_frames(tmp_path: Path) -> None:
    (tmp_path / "imageio_ffmpeg.py").write_text("raise ImportError\n")
    words = ("animate", "soap-bubble", "--seconds", "0.05", *SMALL, "-o", "bubble.mp4")
    done = iridesce(*words, folder=tmp_path, PATH=str(tmp_path), PYTHONPATH=str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert "iridesce[video]" in done.stderr and done.stdout.strip() == "bubble.frames"
    assert (tmp_path / "bubble.frames" / "frame_00000.png").exists() and not (tmp_path / "bubble.mp4").exists()


def test_what_cannot_be_is_refused_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "path.toml").write_text("[[key]]\ntime_s = 0.0\nposition = [0.0, 1.0]\n")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("keep")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "run.json").write_text("[]")
    for words, code, part in [
        (("soap-bubble",), 2, "-o"),
        (("soap-bubble", "-o", "x.avi"), 2, ".mp4"),
        (("soap-bubble", "-o", "x.mp4", "--format", "exr"), 2, "png"),
        (("soap-bubble", "-o", "x.mp4", "--format", "jpg"), 2, "png, exr or both"),
        (("soap-bubble", "-o", "none/x.mp4"), 1, "the folder none does not exist"),
        (("soap-bubble", "-o", "x.mp4", "--seconds", "0"), 3, "--seconds must be > 0"),
        (("soap-bubble", "-o", "x.mp4", "--fps", "nan"), 3, "--fps must be > 0"),
        (("soap-bubble", "-o", "x.mp4", "--seconds", "1e6"), 3, "100000 frames"),
        (("soap-bubble", "-o", "x.mp4", "--start", "-1"), 3, "--start must be >= 0"),
        (("soap-bubble", "-o", "x.mp4", "--speed", "inf"), 3, "--speed must be >= 0"),
        (("soap-bubble", "-o", "x.mp4", "--orbit", "inf"), 3, "finite number of degrees"),
        (("soap-bubble", "-o", "x.mp4", "--columns", "33"), 3, "columns must be even"),
        (("wafer", "-o", "x.mp4"), 3, "nothing moves"),
        (("wafer", "-o", "x.mp4", "--camera", "path.toml"), 3, "key 0: position must be three numbers"),
        (("wafer", "-o", "x.mp4", "--camera", "none.toml"), 3, "none.toml"),
        (("soap-bubble", "-o", "full"), 3, "not empty"),
        (("soap-bubble", "-o", "empty", "--resume"), 3, "no footage to resume"),
        (("soap-bubble", "-o", "other", "--resume"), 3, "not the description of footage"),
    ]:
        done = iridesce("animate", *words, folder=tmp_path)
        assert done.returncode == code, (words, done.stderr)
        assert part in done.stderr and "Traceback" not in done.stderr, (words, done.stderr)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["full", "other", "path.toml"]


def test_other_footage_is_not_gone_on_with(tmp_path: Path) -> None:
    words = ("animate", "soap-bubble", "--seconds", "0.05", *SMALL, "-o", "run")
    assert iridesce(*words, folder=tmp_path).returncode == 0
    before = {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()}
    other = iridesce(*words, "--orbit", "5", "--resume", folder=tmp_path)
    assert other.returncode == 3 and "another orbit: 0.0, not 5.0" in other.stderr
    assert before == {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()}


def test_what_ffmpeg_says_is_told_and_frames_stay(tmp_path: Path) -> None:
    fake = tmp_path / "ffmpeg"
    fake.write_text("#!/bin/sh\necho 'no such encoder' >&2\nexit 1\n")
    fake.chmod(0o755)
    words = ("animate", "soap-bubble", "--seconds", "0.05", *SMALL, "-o", "bubble.mp4")
    done = iridesce(*words, folder=tmp_path, PATH=f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    assert done.returncode == 1 and "no such encoder" in done.stderr and "Traceback" not in done.stderr
    assert (tmp_path / "bubble.frames" / "frame_00000.png").exists() and not (tmp_path / "bubble.mp4").exists()
    # Nothing is lost: with an ffmpeg that works the same command goes on.
    again = iridesce(*words, "--resume", "--json", folder=tmp_path)
    assert again.returncode == 0 and json.loads(again.stdout)["drawn"] == 0
    assert frames_of(tmp_path / "bubble.mp4")[0] == 1


# --- the camera


def test_an_orbit_is_a_circle_about_the_target() -> None:
    camera: dict[str, Any] = {**CAMERA, "position": [3.0, 2.0, 4.0], "target": [0.0, 1.0, 0.0]}
    path = animation.camera_path(camera, 8.0, 90.0, None)
    assert path.moves
    for time_s in (0.0, 2.0, 8.0):
        angle = math.radians(90.0 * time_s / 8.0)
        x = 3.0 * math.cos(angle) + 4.0 * math.sin(angle)
        z = 4.0 * math.cos(angle) - 3.0 * math.sin(angle)
        assert path.at(time_s)["position"] == pytest.approx([x, 2.0, z], abs=1e-12)
    assert not animation.camera_path(camera, 8.0, 0.0, None).moves


def test_keys_are_met_and_joined_smoothly(tmp_path: Path) -> None:
    file = tmp_path / "path.toml"
    file.write_text(
        "[[key]]\ntime_s = 0\nposition = [0, 0, 16]\n"
        "[[key]]\ntime_s = 1.0\nposition = [4, 0, 12]\nfov_deg = 30\n"
        "[[key]]\ntime_s = 3.0\ntarget = [0, 2, 0]\n"
    )
    path = animation.camera_path(CAMERA, 4.0, 0.0, file)
    assert path.at(0.0) == {"position": [0, 0, 16], "target": [0, 0, 0], "fov_deg": 35.0}
    assert path.at(1.0) == {"position": [4, 0, 12], "target": [0, 0, 0], "fov_deg": 30}
    assert path.at(9.0) == {"position": [4, 0, 12], "target": [0, 2, 0], "fov_deg": 30}
    places = np.array([path.at(t)["position"] + path.at(t)["target"] for t in np.linspace(0.0, 3.0, 3001)])
    speeds = np.diff(places, axis=0) * 1000.0
    assert np.abs(speeds[0]).max() < 0.05 and np.abs(speeds[-1]).max() < 0.05, "it starts and ends at rest"
    assert np.abs(np.diff(speeds, axis=0)).max() < 0.05, "and never jerks"


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("", "[[key]]"),
        ("[[keys]]\ntime_s = 0\n", "[[key]]"),
        ("[[key]]\nposition = [0, 0, 1]\n", "key 0 has no time_s"),
        ("[[key]]\ntime_s = 0\nroll = 3\n", "unknown 'roll'"),
        ("[[key]]\ntime_s = nan\n", "time_s must be a number"),
        ("[[key]]\ntime_s = 0\nfov_deg = [3]\n", "fov_deg must be a number"),
        ("[[key]]\ntime_s = 1\n[[key]]\ntime_s = 1\n", "time_s must grow"),
        ("\x00", "no TOML"),
    ],
)
def test_bad_camera_paths_are_refused(tmp_path: Path, text: str, part: str) -> None:
    file = tmp_path / "path.toml"
    file.write_text(text)
    with pytest.raises(ValueError, match=re.escape(part)) as error:
        animation.camera_path(CAMERA, 4.0, 0.0, file)
    assert str(file) in str(error.value)
