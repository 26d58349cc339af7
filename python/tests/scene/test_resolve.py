"""Scenes are recipes: reading, checking and changing them reads no map and lets no film flow; `resolve` does, once."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

import iridesce as ir

MINUTES = {"preset": "giant-bubble", "time_s": 600.0}


def scene_of(*flows: dict[str, Any]) -> dict[str, Any]:
    def thing(number: int, flow: dict[str, Any]) -> dict[str, Any]:
        film = {"medium": "soap", "thickness_nm": {"flow": flow}}
        sphere = {"center": [10.0 * number, 0.0, 0.0], "radius": 4.0}
        return {"name": f"b{number}", "shape": {"sphere": sphere}, "surface": {"film": film}}

    objects = [thing(number, flow) for number, flow in enumerate(flows)]
    return {"version": 1, "camera": {}, "object": objects, "light": [{"environment": {"illuminant": "D65"}}]}


def test_a_film_of_ten_minutes_is_read_checked_and_changed_at_once() -> None:
    """It would flow for an hour."""
    began = time.perf_counter()
    scene = ir.Scene.load(scene_of(MINUTES))
    changed = scene.with_value("object.b0.surface.film.thickness_nm.flow.seed", 7)
    assert 'preset = "giant-bubble"' in changed.check()
    assert time.perf_counter() - began < 1.0
    with pytest.raises(ir.SceneError, match=r"flow\.columns must be even, got 401"):
        scene.with_value("object.b0.surface.film.thickness_nm.flow.columns", 401)


def test_a_map_is_named_when_the_scene_is_read_and_used_when_it_is_resolved(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(
        'version = 1\n[camera]\n[[object]]\n[[light]]\nenvironment = { map = "studio.exr" }\n'
    )
    with pytest.raises(ir.SceneError, match="there is no such file"):
        ir.Scene.load(tmp_path / "scene.toml")
    (tmp_path / "studio.exr").write_bytes(b"no picture")
    scene = ir.Scene.load(tmp_path / "scene.toml")
    for use in (scene.resolve, lambda: ir.render(scene, samples=1, size=(4, 4))):
        with pytest.raises(ir.SceneError, match="neither OpenEXR nor Radiance HDR") as caught:
            use()
        assert caught.value.line == 5 and caught.value.key == "light.0.environment.map"


def test_films_flow_once_for_a_scene_and_all_that_comes_from_it() -> None:
    """Nine films, of which one is asked for at three times."""
    flows = [{"preset": "late", "time_s": 0.02, "seed": seed} for seed in range(6)]
    flows += [{"preset": "late", "time_s": 0.03 + 0.01 * k, "seed": 0} for k in range(3)]
    told: list[tuple[str, int, int]] = []

    def tell(done: int, total: int, stage: str) -> None:
        told.append((stage, done, total))

    scene = ir.Scene.load(scene_of(*flows), progress=tell)
    # Four steps of each of six films, and six more of the first.
    assert told[-1] == ("flowing", 30, 30)
    told.clear()
    moved = scene.with_value("camera.position", [0.0, 1.0, 50.0])
    began = time.perf_counter()
    moved.resolve(tell)
    assert not told and time.perf_counter() - began < 0.5, "nothing flows again"
    later = moved.with_value("object.b3.surface.film.thickness_nm.flow.time_s", 0.03)
    later.resolve(tell)
    assert told[-1] == ("flowing", 2, 2), "a film goes on from where it stands"
    again = ir.Scene.load(scene_of(*flows[:1]))
    told.clear()
    again.resolve(tell)
    assert told[-1] == ("flowing", 4, 4), "another scene has films of its own"


def test_what_cannot_be_rendered_is_told_before_a_film_flows() -> None:
    began = time.perf_counter()
    for wrong in ({"size": (10**6, 10**6)}, {"samples": 0}):
        with pytest.raises(ValueError, match=r"samples|image of"):
            ir.render(scene_of(MINUTES), **wrong)
    assert time.perf_counter() - began < 2.0


def test_progress_is_told_by_stages_and_its_exception_stops_the_work() -> None:
    seen: list[str] = []

    def stages(done: int, total: int, stage: str) -> None:
        assert 0 <= done <= total
        seen.append(stage)

    ir.render(scene_of({"preset": "late", "time_s": 0.1}), samples=1, size=(64, 64), progress=stages)
    assert list(dict.fromkeys(seen)) == ["flowing", "rendering"]

    plain: list[tuple[int, int]] = []
    news = scene_of({"preset": "late", "time_s": 0.1})
    ir.render(news, samples=1, size=(64, 64), progress=lambda done, total: plain.append((done, total)))
    assert {total for _, total in plain} == {64 * 64}, "a function of two hears of one thing"

    class Enough(Exception):
        pass

    def stop(done: int, total: int) -> None:
        raise Enough

    scene = ir.Scene.load(scene_of(MINUTES))
    for work in (lambda: scene.resolve(stop), lambda: ir.render(scene, progress=lambda *_, stage: stop(0, 0))):
        began = time.perf_counter()
        with pytest.raises(Enough):
            work()
        assert time.perf_counter() - began < 5.0
    film = ir.thickness.simulate("late", time_s=60.0, frames_per_second=0.1, progress=stop)
    next(film)
    with pytest.raises(Enough):
        next(film)
    with pytest.raises(ValueError, match="progress must be a function"):
        ir.Scene.load("soap-bubble", progress=3)  # type: ignore[arg-type]


def test_the_steps_of_a_simulation_are_counted_over_all_its_frames() -> None:
    told: list[tuple[int, int]] = []
    film = ir.thickness.simulate("late", 0.1, 20.0, progress=lambda done, total: told.append((done, total)))
    assert len(list(film)) == 3
    assert told[-1] == (20, 20) and {total for _, total in told} == {20}
    assert [done for done, _ in told] == sorted(done for done, _ in told)


def test_scenes_are_resolved_from_several_threads() -> None:
    scene = ir.Scene.load(scene_of({"preset": "late", "time_s": 0.05}))
    seen: list[bytes] = []

    def work() -> None:
        image = ir.render(scene, samples=1, size=(16, 16), threads=1)
        seen.append(image.channels["thickness_nm"].tobytes())

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(seen) == 3 and len(set(seen)) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize(
    "work", ["scene.resolve()", "ir.render(scene)", "ir.thickness.flow('giant-bubble', 600.0).map(8, 4)"]
)
def test_ctrl_c_is_heard_while_a_film_flows(work: str) -> None:
    code = (
        "import iridesce as ir, os, signal, threading, time\n"
        f"scene = ir.Scene.load({scene_of(MINUTES)!r})\n"
        "sent = []\n"
        "def send():\n"
        "    time.sleep(1.0); sent.append(time.perf_counter()); os.kill(os.getpid(), signal.SIGINT)\n"
        "threading.Thread(target=send, daemon=True).start()\n"
        "try:\n"
        f"    {work}\n"
        "except KeyboardInterrupt:\n"
        "    print(time.perf_counter() - sent[0])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    # A loaded machine makes one step longer; alone it is 0.1 s.
    assert float(done.stdout) < 3.0
