"""Films that flow, as users meet them: frames, scenes, the verb; the laws are tested in Rust (``docs/guide/living-films.md``)."""

from __future__ import annotations

import copy
import json
import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import command_line
import iridesce as ir
from iridesce.thickness import ThicknessMap, flow, presets, simulate

# A bare film is coarse and quick; patches would want a finer grid.
QUICK: dict[str, Any] = {"columns": 64, "regeneration": 0.0}


def test_frames_come_at_their_times() -> None:
    film = simulate("bubble-on-bath", time_s=0.1, frames_per_second=30, **QUICK)
    frames = list(film)
    assert [frame.time_s for frame in frames] == [0.0, 1 / 30, 2 / 30, 0.1]
    assert all(frame.thickness_nm.shape == (16, 64) and frame.thickness_nm.dtype == np.float64 for frame in frames)
    edges = np.cos(np.linspace(0.0, np.pi / 2, 17))
    mean = np.average(frames[0].thickness_nm.mean(axis=1), weights=edges[:-1] - edges[1:])
    assert mean == pytest.approx(450.0, rel=1e-12)
    assert not np.array_equal(frames[0].thickness_nm, frames[-1].thickness_nm)
    assert film.facts["step"] == 21  # seven steps of at most 5 ms in each thirtieth of a second


def test_seeds_and_repeats() -> None:
    def last(seed: int) -> Any:
        return list(simulate("free-bubble", time_s=0.05, frames_per_second=20, seed=seed, **QUICK))[-1].thickness_nm

    assert np.array_equal(last(3), last(3))
    assert not np.array_equal(last(3), last(4))


def test_a_checkpoint_goes_on_to_the_same_bytes() -> None:
    straight = simulate("late", time_s=0.2, frames_per_second=20, **QUICK)
    frames = list(straight)
    stopped = simulate("late", time_s=0.1, frames_per_second=20, **QUICK)
    list(stopped)
    resumed = simulate("late", time_s=0.2, frames_per_second=20, checkpoint=stopped.checkpoint(), **QUICK)
    rest = list(resumed)
    assert [frame.time_s for frame in rest] == [frame.time_s for frame in frames[3:]]
    assert np.array_equal(rest[-1].thickness_nm, frames[-1].thickness_nm)
    assert resumed.checkpoint() == straight.checkpoint()


def test_liquid_is_booked() -> None:
    film = simulate("late", time_s=0.5, frames_per_second=4, columns=192, patch_m=4e-3, regeneration=0.5)
    list(film)
    facts = film.facts
    ways = [facts[f"{way}_m3"] for way in ("evaporated", "swallowed", "blackened", "drained")]
    assert all(way is not None and way > 0.0 for way in ways)
    total = sum(way or 0.0 for way in ways) + (facts["volume_m3"] or 0.0)
    assert abs(total / (facts["start_m3"] or 1.0) - 1.0) < 1e-12


def test_parameters_are_what_was_asked() -> None:
    film = simulate("bubble-on-bath", radius_m=0.03, viscosity_pa_s=2e-3, humidity=0.5)
    assert film.parameters["radius_m"] == 0.03
    assert film.parameters["viscosity_pa_s"] == 2e-3
    # Vapour diffuses from the outer face: D c (1 - RH) / (rho R).
    assert film.parameters["evaporation_nm_s"] == pytest.approx(2.5e-5 * 17.3e-3 * 0.5 / (1000 * 0.03) * 1e9)
    for name in presets():
        assert simulate(name).parameters["thickness_nm"] > 0.0


@pytest.mark.parametrize(
    ("changes", "part"),
    [
        ({"viscosity_pa_s": -1.0}, "viscosity_pa_s must be a finite number > 0, got -1.0"),
        ({"radius_m": 0.0}, "radius_m must be a finite number > 0"),
        ({"radius_m": float("nan")}, "radius_m must be"),
        ({"viscosity": 1.0}, "viscosity_pa_s"),
        ({"columns": 64}, "columns must be at least 316"),
        ({"columns": 401}, "even"),
        ({"columns": 0}, "columns must be a whole number"),
        ({"columns": 16384}, "cells"),
        ({"seed": -1}, "seed must be"),
        ({"seed": True}, "seed must be"),
        ({"time_s": -1.0}, "time_s"),
        ({"time_s": "4"}, "time_s must be a number"),
        ({"frames_per_second": 0.0}, "frames_per_second"),
        ({"humidity": 1.5}, "humidity"),
        ({"checkpoint": b"no"}, "checkpoint is not one of iridesce"),
        ({"checkpoint": "no"}, "checkpoint must be bytes"),
        ({"black_nm": 100.0}, "black_nm must be at most black_below_nm"),
    ],
)
def test_impossible_films_are_refused(changes: dict[str, Any], part: str) -> None:
    with pytest.raises(ValueError, match=part):
        simulate("bubble-on-bath", **changes)


def test_unknown_presets_name_the_known() -> None:
    for refused in (lambda: simulate("soup"), lambda: flow("soup", 1.0)):
        with pytest.raises(ValueError, match="bubble-on-bath"):
            refused()


def test_checkpoints_of_other_runs_are_refused() -> None:
    film = simulate("late", time_s=0.05, frames_per_second=20, **QUICK)
    list(film)
    content = film.checkpoint()
    with pytest.raises(ValueError, match=r"viscosity_pa_s 0\.0015, not viscosity_pa_s 0\.002"):
        simulate("late", checkpoint=content, viscosity_pa_s=2e-3, **QUICK)
    with pytest.raises(ValueError, match="seed 1, not seed 2"):
        simulate("late", checkpoint=content, seed=2, **QUICK)
    with pytest.raises(ValueError, match="between two frames"):
        simulate("late", checkpoint=content, frames_per_second=30, **QUICK)
    for damaged in (content[:-1], content[: len(content) // 2], content[:100] + b"\xff" + content[101:]):
        with pytest.raises(ValueError, match="cut short or damaged"):
            simulate("late", checkpoint=damaged, **QUICK)


def test_scenes_take_films_that_flow() -> None:
    bubble = ir.Scene.load("soap-bubble")
    key = "object.bubble.surface.film.thickness_nm"
    scene = bubble.with_value(key, {"flow": {"preset": "free-bubble", "time_s": 0.02}})
    written = scene.to_dict()["object"][0]["surface"]["film"]["thickness_nm"]
    assert written == {"flow": {"preset": "free-bubble", "time_s": 0.02, "seed": 1, "columns": 384}}
    assert bubble.with_value(key, flow("free-bubble", 0.02)).to_dict() == scene.to_dict()
    assert bubble.with_value(f"{key}.flow.columns", 304).to_dict() == (
        bubble.with_value(key, flow("free-bubble", 0.8, columns=304)).to_dict()
    )
    image = ir.render(scene, samples=1, size=(24, 24))
    seen = image.channels["thickness_nm"]
    expected = flow("free-bubble", 0.02).map(384, 192).thickness_nm
    assert np.nanmin(seen) > expected.min() - 1.0 and np.nanmax(seen) < expected.max() + 1.0
    assert np.nanstd(seen) > 20.0
    for bad, part in [
        ({"preset": "soup", "time_s": 1.0}, "preset must be one of"),
        ({"preset": "late"}, "time_s"),
        ({"preset": "late", "time_s": -1.0}, "time_s"),
        ({"preset": "late", "time_s": 1.0, "sed": 1}, "seed"),
        ({"preset": "late", "time_s": 1.0, "columns": 17.5}, "columns must be a whole number from 16 to 16384"),
        ({"preset": "late", "time_s": 1.0, "columns": 33}, "columns must be even"),
        ({"preset": "late", "time_s": 1.0, "columns": 32}, "columns"),
    ]:
        with pytest.raises(ir.SceneError, match=part):
            bubble.with_value(key, {"flow": bad})


def test_a_dome_lies_on_its_cap_as_on_its_sphere() -> None:
    thickness_nm = {"flow": {"preset": "bubble-on-bath", "time_s": 0.0}}
    camera = {"position": [0.0, 6.0, 9.0], "target": [0.0, 1.0, 0.0], "resolution": [40, 40]}
    seen = []
    for shape in (
        {"sphere": {"center": [0.0, 0.0, 0.0], "radius": 2.0}},
        {"cap": {"center": [0, 2, 0], "axis": [0, 1, 0], "radius_of_curvature": 2.0, "aperture_radius": 2.0}},
    ):
        film = {"name": "film", "shape": shape, "surface": {"film": {"thickness_nm": thickness_nm}}}
        light = [{"environment": {"illuminant": "D65"}}]
        image = ir.render({"version": 1, "camera": camera, "object": [film], "light": light}, samples=1)
        seen.append(image.channels["thickness_nm"][:20])  # above the rim
    both = np.isfinite(seen[0]) & np.isfinite(seen[1])
    assert both.sum() > 100
    assert np.abs(seen[0] - seen[1])[both].max() < 0.01


# Each kept film against the one that flows now: (preset, time in s, columns, rows).
STORED = [("free-bubble", 0.8), ("bubble-on-bath", 4.0), ("vertical-film", 4.0)]


@pytest.mark.slow
@pytest.mark.parametrize(("preset", "time_s"), STORED)
def test_films_that_come_with_the_program_are_what_their_presets_give(preset: str, time_s: float) -> None:
    film = simulate(preset, time_s=time_s, frames_per_second=200.0)
    grid = [frame.thickness_nm for frame in film][-1]
    rows, columns = film.map().thickness_nm.shape
    kept = flow(preset, time_s).map(columns, rows).thickness_nm
    # Rounded to 0.1 nm, and a film that stirs itself for seconds keeps of another machine's last digits what it likes.
    off = np.abs(kept - film.map(columns).thickness_nm)
    assert np.median(off) <= 0.051 and np.percentile(off, 99.0) < 0.5, (np.median(off), off.max())
    assert grid.std() > 50.0


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_a_scene_whose_film_flows_for_long_can_be_stopped(tmp_path: Path) -> None:
    change = "import iridesce as ir; ir.Scene.load('soap-bubble').with_value("
    change += "'object.bubble.surface.film.thickness_nm.flow.time_s', 600.0).resolve()"
    words = [sys.executable, "-c", f"import sys; print('on', flush=True); {change}"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "on\n"
        time.sleep(2.0)
        os.kill(process.pid, signal.SIGINT)
        try:
            _, said = process.communicate(timeout=30)
        finally:
            process.kill()
    assert "KeyboardInterrupt" in said and process.returncode != 0


def iridesce(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return command_line.run(words, folder)


WORDS = ("flow", "late", "--fps", "20", "--columns", "64", "--set", "regeneration=0.0")


def test_the_verb_writes_frames_and_goes_on(tmp_path: Path) -> None:
    straight = iridesce(*WORDS, "--time", "0.2", "-o", "one", folder=tmp_path)
    assert straight.returncode == 0, straight.stderr
    assert sorted(path.name for path in (tmp_path / "one").glob("frame_*")) == [f"frame_{k:05d}.tif" for k in range(5)]
    first = ThicknessMap.load(tmp_path / "one" / "frame_00000.tif")
    assert (first.width, first.height) == (64, 32)
    assert 200.0 < first.thickness_nm.mean() < 300.0
    assert iridesce(*WORDS, "--time", "0.1", "-o", "two", folder=tmp_path).returncode == 0
    again = iridesce(*WORDS, "--time", "0.2", "-o", "two", folder=tmp_path)
    assert again.returncode == 3 and "--resume" in again.stderr
    resumed = iridesce(*WORDS, "--time", "0.2", "-o", "two", "--resume", "--json", folder=tmp_path)
    assert resumed.returncode == 0, resumed.stderr
    assert [Path(name).name for name in json.loads(resumed.stdout)["files"]] == ["frame_00003.tif", "frame_00004.tif"]
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes(), path.name


def test_the_verb_refuses_what_cannot_be(tmp_path: Path) -> None:
    assert iridesce(*WORDS, "--time", "0.05", "-o", "run", folder=tmp_path).returncode == 0
    for words, code, part in [
        (("flow", "late", "--time", "1", "-o", "run", "--resume"), 3, "another fps: 20.0, not 30.0"),
        (("flow", "late", "--time", "1", "-o", "none", "--resume"), 3, "no run to resume"),
        (("flow", "soup", "--time", "1", "-o", "soup"), 3, "preset must be one of"),
        (("flow", "late", "--time", "1"), 2, "-o"),
        (("flow", "late", "--set", "viscosity_pa_s=-1", "-o", "thin"), 3, "viscosity_pa_s"),
        (("flow", "late", "--set", "viscosity_pa_s=x", "-o", "thin"), 3, "viscosity_pa_s"),
        (("flow", "late", "--format", "jpg", "-o", "jpg"), 2, "tif"),
    ]:
        done = iridesce(*words, folder=tmp_path)
        assert done.returncode == code, (words, done.stderr)
        assert part in done.stderr, done.stderr
        assert "Traceback" not in done.stderr
    (tmp_path / "run" / "checkpoint.irflow").write_bytes(b"rubbish")
    broken = iridesce(*WORDS, "--time", "0.1", "-o", "run", "--resume", folder=tmp_path)
    assert broken.returncode == 3 and "checkpoint" in broken.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run"]


def test_history_and_profiles_are_the_film_s_own(tmp_path: Path) -> None:
    film = simulate("late", time_s=0.4, frames_per_second=10, columns=192, patch_m=4e-3, regeneration=0.5)
    assert film.history.shape == (0,)
    means = []
    for frame in film:
        edges = np.cos(np.linspace(0.0, np.pi / 2, len(frame.thickness_nm) + 1))
        area = (edges[:-1] - edges[1:])[:, None] * np.ones(frame.thickness_nm.shape)
        means.append(np.average(frame.thickness_nm, weights=area))
        last = film.history[-1]
        share = film._core.black_share()
        thin = frame.thickness_nm < film.parameters["black_below_nm"]
        if share is None:
            assert last["black_share"] == pytest.approx(np.average(thin, weights=area), abs=1e-12)
        else:
            share = share[: len(thin)]
            thinnest = film.parameters["black_nm"]
            rest = thinnest + (frame.thickness_nm - thinnest) / np.maximum(1.0 - share, 1e-300)
            black = np.where((share < 1.0) & (rest < film.parameters["black_below_nm"]), 1.0, share)
            assert last["black_share"] == pytest.approx(np.average(black, weights=area), abs=1e-12)
        assert (last["min_nm"], last["max_nm"]) == pytest.approx((frame.thickness_nm.min(), frame.thickness_nm.max()))
        profile = film.profile()
        assert np.allclose(profile["mean_nm"], frame.thickness_nm.mean(axis=1), rtol=1e-12)
        middles = (np.arange(48) + 0.5) * np.pi / 2 / 48
        assert np.allclose(profile["height_m"], 0.025 * np.cos(middles), atol=1e-12)
    history = film.history
    assert history.dtype.names == (
        *("time_s", "mean_nm", "min_nm", "max_nm", "black_share"),
        *("evaporated", "swallowed", "blackened", "drained"),
    )
    assert history["time_s"].tolist() == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert history["mean_nm"] == pytest.approx(means, rel=1e-12)
    ways = [history[way] for way in ("evaporated", "swallowed", "blackened", "drained")]
    assert all((way >= 0.0).all() and way[-1] > 0.0 for way in ways)
    assert np.abs(history["mean_nm"] / history["mean_nm"][0] + sum(ways) - 1.0).max() < 1e-12
    # The verb writes the same, also when it goes on later.
    words = ("flow", "late", "--fps", "10", "--columns", "192", "--set", "patch_m=4e-3", "--set", "regeneration=0.5")
    words = (*words, "-o", "run", "--history", "history.csv", "--profiles", "profiles.csv")
    for more in (("--time", "0.2"), ("--time", "0.4", "--resume")):
        done = iridesce(*words, *more, folder=tmp_path)
        assert done.returncode == 0, done.stderr
    read = np.genfromtxt(tmp_path / "history.csv", delimiter=",", names=True)
    assert read.dtype.names == history.dtype.names and len(read) == 5
    for name in read.dtype.names:
        assert read[name] == pytest.approx(history[name], rel=1e-8, abs=1e-12), name
    profiles = np.genfromtxt(tmp_path / "profiles.csv", delimiter=",", names=True)
    assert len(profiles) == 5 * 48 and profiles["mean_nm"][-48:] == pytest.approx(film.profile()["mean_nm"], rel=1e-8)
    (tmp_path / "history.csv").write_text("time_s,mean_nm\n0,1\n")
    for wrong, part in [
        ((*words, "--time", "0.5", "--resume"), "does not hold the rows"),
        (("flow", "late", "-o", "new", "--history", "history.txt"), "must end in .csv"),
        (("flow", "late", "-o", "new", "--history", "a.csv", "--profiles", "a.csv"), "the same file"),
    ]:
        done = iridesce(*wrong, folder=tmp_path)
        assert done.returncode in (2, 3) and part in " ".join(done.stderr.split()), done.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("done", [0, 2])
@pytest.mark.parametrize("initial", [None, [[200.0], [300.0]]], ids=["noise", "given"])
def test_copies_and_pickles_go_on_to_the_same_bytes(done: int, initial: Any) -> None:
    how: dict[str, Any] = {"initial": initial, "progress": lambda *_: None, "sides": "periodic", "speed": 2.0, **QUICK}
    film = simulate("vertical-film", time_s=0.15, frames_per_second=20, seed=3, **how)
    for _ in range(done):
        next(film)
    others = [pickle.loads(pickle.dumps(film)), copy.deepcopy(film), copy.copy(film)]
    assert [(one.frame, len(one)) for one in others] == [(done, 4 - done)] * 3
    frames = list(film)
    for other in others:
        assert other.parameters == film.parameters and len(other.history) == done
        again = list(other)
        assert [one.time_s for one in again] == [one.time_s for one in frames]
        assert all(np.array_equal(a.thickness_nm, b.thickness_nm) for a, b in zip(again, frames, strict=True))
        assert other.history.tobytes() == film.history.tobytes()


def test_a_film_that_burst_is_pickled_as_it_is() -> None:
    film = simulate("late", time_s=1.0, thickness_nm=20.0, columns=64, regeneration=0.0, rupture_per_m2_s=1e4)
    count = len(list(film))
    other = pickle.loads(pickle.dumps(film))
    assert other.ruptured_s == film.ruptured_s is not None
    assert len(other.history) == count and list(other) == []


def test_a_film_starts_from_a_given_thickness(tmp_path: Path) -> None:
    def areas(rows: int, preset: str) -> Any:
        edges = np.cos(np.linspace(0.0, np.pi / 2, rows + 1))
        return edges[:-1] - edges[1:] if "vertical" not in preset else np.ones(rows)

    rng = np.random.default_rng(3)
    for preset in ("bubble-on-bath", "vertical-film"):
        for shape in ((50, 90), (7, 5), (400, 1000)):
            given = 300.0 + 400.0 * rng.random(shape)
            given[: shape[0] // 2] += 200.0  # thick on top: rows are not upside down
            film = simulate(preset, time_s=0.05, frames_per_second=20, initial=given)
            first = next(film).thickness_nm
            own = np.average(first.mean(axis=1), weights=areas(len(first), preset))
            assert own == pytest.approx(np.average(given.mean(axis=1), weights=areas(shape[0], preset)), rel=1e-12)
            assert film.parameters["thickness_nm"] == pytest.approx(own, rel=1e-12) and film.parameters["noise"] == 0.0
            assert first.min() > given.min() - 1e-9 and first.max() < given.max() + 1e-9
            assert first[: len(first) // 2 - 20].mean() > first[len(first) // 2 + 20 :].mean() + 60.0
            assert film.facts["start_m3"] == pytest.approx(film.facts["volume_m3"])
    # A frame of one run starts another, as it is; a checkpoint of that one goes on.
    frame = list(simulate("late", time_s=0.1, frames_per_second=10, **QUICK))[-1].thickness_nm
    film = simulate("late", time_s=0.2, frames_per_second=10, initial=ThicknessMap(frame), **QUICK)
    assert np.abs(next(film).thickness_nm - frame).max() < 1e-12
    content = film.checkpoint()
    again = simulate("late", time_s=0.2, frames_per_second=10, initial=frame, checkpoint=content, **QUICK)
    assert np.array_equal(next(again).thickness_nm, next(film).thickness_nm)
    np.save(tmp_path / "start.npy", frame)
    done = iridesce(*WORDS, "--time", "0", "-o", "run", "--initial", "start.npy", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    written = ThicknessMap.load(tmp_path / "run" / "frame_00000.tif").thickness_nm
    assert np.abs(written[:16] - frame).max() < 1e-4
    nan = [[1.0, float("nan")]]
    for bad, part in [
        ({"initial": [1.0, 2.0]}, r"initial must have the shape \(rows, columns\), both >= 1, got \(2,\)"),
        ({"initial": nan}, r"initial must be >= 0 and finite, in nm, got nan at index \(0, 1\)"),
        ({"initial": [[-1.0]]}, r"got -1\.0 at index \(0, 0\)"),
        ({"initial": [[0.0]]}, "must hold some liquid"),
        ({"initial": "soup"}, "initial must be real numbers"),
        ({"initial": [[1.0]], "noise": 0.1}, "initial and noise exclude each other"),
        ({"initial": [[1.0]], "thickness_nm": 9.0}, "initial and thickness_nm exclude each other"),
        ({"initial": [[900.0]], "checkpoint": content, **QUICK}, "thickness_nm"),
    ]:
        with pytest.raises(ValueError, match=part):
            simulate("late", **bad)  # type: ignore[arg-type]


def test_frames_have_borders_or_repeat(tmp_path: Path) -> None:
    frame, wide = (
        simulate(name, time_s=0.5, frames_per_second=2)
        for name in ("vertical-film-preview", "vertical-film-wide-preview")
    )
    # The wide film ends below at a wire, as it does at its sides; the other stands on a bath.
    film = {"sides": "periodic", "bottom_meniscus_m": 0.0}
    again = simulate("vertical-film-preview", time_s=0.5, frames_per_second=2, **film)  # type: ignore[arg-type]
    last = [list(film)[-1].thickness_nm for film in (frame, wide, again)]
    assert np.array_equal(last[1], last[2]) and np.abs(last[0] - last[1]).max() > 20.0
    assert [film.parameters["sides"] for film in (frame, wide, again)] == ["menisci", "periodic", "periodic"]
    # At a wire all round, two borders of 6 cm and one of 10 cm swallow more than the last alone; a bath's meniscus less.
    wired = simulate("vertical-film-preview", time_s=0.5, frames_per_second=2, bottom_meniscus_m=0.0)
    list(wired)
    swallowed = [film.history["swallowed"][-1] for film in (frame, wired, wide)]
    assert swallowed[1] / swallowed[2] == pytest.approx((0.12 + 0.1) / 0.1, rel=0.15)
    assert swallowed[0] < swallowed[1] - 0.881 * swallowed[2]
    assert "sides" not in simulate("late").parameters
    lapse = simulate("late-time-lapse").parameters
    assert lapse.pop("speed") == 6.0 and lapse == {k: v for k, v in simulate("late").parameters.items() if k != "speed"}
    for preset, sides, part in [
        ("vertical-film", "glass", 'sides must be "menisci" or "periodic", got "glass"'),
        ("vertical-film", 1.0, 'sides must be "menisci" or "periodic", got 1.0'),
        ("late", "menisci", 'sides must be left out for a bubble, which has none, got "menisci"'),
    ]:
        with pytest.raises(ValueError, match=part):
            simulate(preset, sides=sides)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="speed must be a finite number > 0"):
        simulate("late", speed=0.0)
    done = iridesce(
        "flow", "vertical-film-preview", "--set", "sides=periodic", "--time", "0", "-o", "run", folder=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "run" / "run.json").read_text())["parameters"]["sides"] == "periodic"


@pytest.mark.skipif(sys.platform == "win32", reason="limits of files")
def test_a_disk_that_fills_loses_nothing(tmp_path: Path) -> None:
    import resource

    assert iridesce(*WORDS, "--time", "0.2", "-o", "one", folder=tmp_path).returncode == 0
    assert iridesce(*WORDS, "--time", "0.1", "-o", "two", folder=tmp_path).returncode == 0
    before = {path.name: path.read_bytes() for path in (tmp_path / "two").iterdir()}
    # Room for a frame, but not for the checkpoint after it: what is written past the limit fails as on a full disk.
    frame, checkpoint = len(before["frame_00000.tif"]), len(before["checkpoint.irflow"])
    limit = (frame + checkpoint) // 2
    assert frame < limit < checkpoint
    full = subprocess.run(
        [sys.executable, "-m", "iridesce", *WORDS, "--time", "0.2", "-o", "two", "--resume"],
        cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
    )  # fmt: skip
    assert full.returncode == 1, full.stderr
    assert "two/checkpoint.irflow" in full.stderr and "Traceback" not in full.stderr
    after = {path.name: path.read_bytes() for path in (tmp_path / "two").iterdir()}
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) <= {"frame_00003.tif"}
    # With room again it goes on to the same bytes.
    assert iridesce(*WORDS, "--time", "0.2", "-o", "two", "--resume", folder=tmp_path).returncode == 0
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes(), path.name


def test_a_film_that_bursts_ends_its_run(tmp_path: Path) -> None:
    words = (*WORDS, "--set", "evaporation_nm_s=500", "--set", "rupture_nm=60", "--set", "noise=0")
    words = (*words, "--set", "rupture_per_m2_s=inf", "--set", "spots_per_m2_s=0", "--time", "2")
    done = iridesce(*words, "--json", "-o", "run", "--history", "history.csv", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    facts = json.loads(done.stdout)
    # 260 nm less 200 nm at 500 nm/s, to a step.
    assert facts["ruptured_s"] == pytest.approx(0.4, abs=0.0101)
    assert f"the film burst at {facts['ruptured_s']:g} s" in done.stderr
    assert len(facts["files"]) == len(list((tmp_path / "run").glob("frame_*.tif"))) == 9
    table = (tmp_path / "history.csv").read_text()
    assert len(table.splitlines()) == 10
    again = iridesce(*words, "--resume", "-o", "run", "--history", "history.csv", folder=tmp_path)
    assert again.returncode == 0 and "0 frames" in again.stderr
    assert len(list((tmp_path / "run").glob("frame_*.tif"))) == 9
    assert (tmp_path / "history.csv").read_text() == table


def test_a_film_bursts_by_chance_between_two_frames() -> None:
    thin: dict[str, Any] = {"thickness_nm": 28.0, "noise": 0.0, "evaporation_nm_s": 0.0, **QUICK}
    film = simulate("bubble-on-bath", time_s=60.0, frames_per_second=3.0, **thin)
    frames = list(film)
    assert film.ruptured_s is not None and len(frames) < 60 and len(film.history) == len(frames)
    # It stands at the end of the step in which it burst, which is no frame's time, and goes no further.
    assert 0.0 <= frames[-1].time_s - film.ruptured_s <= 0.005 and (frames[-1].time_s * 3.0) % 1.0 > 1e-3
    again = simulate("bubble-on-bath", time_s=60.0, frames_per_second=3.0, checkpoint=film.checkpoint(), **thin)
    assert again.ruptured_s == film.ruptured_s and again.frame == len(frames) and list(again) == []
    other = simulate("bubble-on-bath", time_s=60.0, frames_per_second=1.0, seed=2, **thin)
    assert len(list(other)) > 0 and other.ruptured_s not in (None, film.ruptured_s)
    assert other.summary == other.history[-1]
    never = simulate("bubble-on-bath", time_s=4.0, frames_per_second=1.0, rupture_nm=0.0, **thin)
    assert len(list(never)) == 5 and never.ruptured_s is None


def test_long_steps_are_divided_or_refused() -> None:
    # Steps of a tenth of a second take sub-steps and stay in range.
    film = simulate("free-bubble", time_s=0.5, frames_per_second=10, step_s=0.1, **QUICK)
    frames = list(film)
    assert (film.facts["substeps"] or 0) > 1 and film.facts["step"] == 5
    assert all(frame.thickness_nm.min() > 0.0 and frame.thickness_nm.max() < 2000.0 for frame in frames)
    hurricane = simulate(
        "free-bubble", time_s=100.0, frames_per_second=0.02, step_s=50.0, wind_m_s=100.0, rupture_nm=0.0, **QUICK
    )
    next(hurricane)
    with pytest.raises(
        ValueError,
        match=r"^step_s, 50 s, is too long at step 2, 50 s: \d+ sub-steps would be needed, 400 are allowed$",
    ):
        list(hurricane)
    # What there was before is still there.
    assert hurricane.facts["time_s"] == 50.0


def test_frames_that_lean_and_are_shaken() -> None:
    plane: dict[str, Any] = {"time_s": 0.1, "frames_per_second": 10, **QUICK}
    upright, leaning, shaken = (
        list(simulate("vertical-film", **plane, **change))[-1].thickness_nm
        for change in ({}, {"tilt_deg": 60.0}, {"shake_m_s2": 5.0, "shake_hz": 4.0})
    )
    assert np.abs(upright - leaning).max() > 5.0 and np.abs(upright - shaken).max() > 5.0
    for preset, changes, part in [
        ("vertical-film", {"tilt_deg": 91.0}, r"tilt_deg must be from 0 \(vertical\) to 90 \(level\), got 91\.0"),
        ("vertical-film", {"shake_hz": 0.0}, r"shake_hz must be a finite number > 0, got 0\.0"),
        ("late", {"tilt_deg": 5.0}, r"tilt_deg must be 0 for a bubble, which has no frame, got 5\.0"),
    ]:
        with pytest.raises(ValueError, match=part):
            simulate(preset, **changes)


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_leaves_whole_files_and_a_run_to_resume(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "iridesce", "flow", "late", "--time", "60", "-o", "run"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        place = tmp_path / "run" / "checkpoint.irflow"
        until = time.monotonic() + 60
        while not place.exists() and time.monotonic() < until:
            time.sleep(0.05)
        os.kill(process.pid, signal.SIGINT)
        try:
            _, said = process.communicate(timeout=60)
        finally:
            process.kill()  # nothing, if it has ended
    assert process.returncode == 130, said
    assert "--resume" in said and "Traceback" not in said
    frames = sorted((tmp_path / "run").glob("frame_*.tif"))
    assert frames and all(ThicknessMap.load(path).width == 384 for path in frames)
    assert not list((tmp_path / "run").glob(".*"))


def test_lists(tmp_path: Path) -> None:
    assert iridesce("flow", "--list", folder=tmp_path).stdout.split() == presets()
    listed = json.loads(iridesce("flow", "late", "--list", "--json", folder=tmp_path).stdout)
    assert listed["thickness_nm"] == 260.0 and listed["surfactant_exchange_s"] == "inf"
