"""Sweeps on workers of Dask: the same bytes, files by content, deaths of workers and of the scheduler, what is refused."""

from __future__ import annotations

import functools
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import command_line
import iridesce as ir
from iridesce.cli.entry import application

distributed = pytest.importorskip("distributed", reason="the extra dask is not installed")

from iridesce.sweeping import cluster as clusters  # noqa: E402
from iridesce.sweeping import worker as workers  # noqa: E402

SOAP = "air / soap 320 / air"
NM = "layers.0.thickness_nm"


def points(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "points").iterdir()}


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """Two worker processes that nothing outside this machine can reach."""
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, silence_logs=50
        ) as local,
        distributed.Client(local, set_as_default=False) as found,
    ):
        yield found


def test_workers_give_the_bytes_of_this_machine(client: Any, tmp_path: Path) -> None:
    scene = ir.Scene.load("soap-bubble").with_value("camera.resolution", [8, 6]).with_value("render.samples", 1)
    vary = {"object.bubble.surface.film.thickness_nm": [100.0, 250.0, 400.0], "render.seed": [1, 2]}
    here = ir.sweep(scene, vary, store=tmp_path / "here")
    there = ir.sweep(scene, vary, store=tmp_path / "there", client=client)
    assert not there.failed and points(tmp_path / "here") == points(tmp_path / "there")
    assert (tmp_path / "here" / "sweep.json").read_bytes() == (tmp_path / "there" / "sweep.json").read_bytes()
    # Without a store values come over the wire; by an address, too.
    sent = ir.sweep(scene, vary, client=client.scheduler.address)
    np.testing.assert_array_equal(np.asarray(sent.values), np.asarray(here.values))


def test_files_travel_by_content(client: Any, tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    np.save(tmp_path / "maps" / "film.npy", np.linspace(100.0, 600.0, 128).reshape(8, 16).astype(np.float32))
    (tmp_path / "scene.toml").write_text(
        "version = 1\ncamera = { position = [0.0, 0.0, 16.0], resolution = [8, 6] }\nrender = { samples = 1 }\n"
        "[[object]]\nshape = { sphere = { radius = 4.0 } }\n"
        'surface = { film = { medium = "soap", thickness_nm = { map = "maps/film.npy" } } }\n'
        '[[light]]\nenvironment = { builtin = "studio" }\n'
    )
    vary = {"camera.fov_deg": [30.0, 40.0]}
    ir.sweep(tmp_path / "scene.toml", vary, store=tmp_path / "here")

    def lay_it_out(text: str) -> bool:
        # On the worker: the map must be in a folder of its own, not read where the client has it.
        import gc

        from iridesce.sweeping.subjects import SceneSubject

        found = [one for one in gc.get_objects() if isinstance(one, SceneSubject)]
        return any((one.folder / "maps" / "film.npy").is_file() and str(one.folder) != text for one in found)

    there = ir.sweep(tmp_path / "scene.toml", vary, store=tmp_path / "there", client=client)
    assert not there.failed and points(tmp_path / "here") == points(tmp_path / "there")
    assert any(client.run(functools.partial(lay_it_out, str(tmp_path))).values())
    # Another content under the same name is another file.
    np.save(tmp_path / "maps" / "film.npy", np.full((8, 16), 300.0, np.float32))
    other = ir.sweep(tmp_path / "scene.toml", vary, client=client)
    assert not np.array_equal(other.values[0].xyz, there.values[0].xyz)
    np.testing.assert_array_equal(other.values[1].xyz, ir.sweep(tmp_path / "scene.toml", vary).values[1].xyz)


def test_functions_travel_and_what_fails_is_kept(client: Any) -> None:
    swept = ir.sweep(
        SOAP, {NM: [0.0, 1.0, 2.0]}, quantity=lambda stack: 1 / stack.layers[0].thickness_nm, client=client
    )
    assert [point[NM] for point, _ in swept.failed] == [0.0] and "ZeroDivisionError" in swept.failed[0][1]
    assert swept.values[1:].tolist() == [1.0, 0.5]
    lock = threading.Lock()
    with pytest.raises(ValueError, match="quantity cannot be sent"):
        ir.sweep(SOAP, {NM: [0.0]}, quantity=lambda stack: lock, client=client)


def _slow(stack: Any) -> Any:
    import time

    time.sleep(0.1)
    return stack.color()


def killed_during_a_sweep(client: Any, store: Path, count: int, kills: int, seed: int = 0) -> tuple[Any, int]:
    """A sweep during which workers are killed, one after another; its result, and how many were."""
    rng = np.random.default_rng(seed)
    done = threading.Event()
    killed = 0

    def kill() -> None:
        nonlocal killed
        while killed < kills and not done.wait(0.2):
            alive = [one.pid for one in client.cluster.workers.values() if one.pid]
            if alive:
                os.kill(alive[int(rng.integers(len(alive)))], signal.SIGKILL)
                killed += 1

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that there are no workers for a moment
            swept = ir.sweep(SOAP, {NM: np.linspace(0.0, 500.0, count)}, quantity=_slow, store=store, client=client)
    finally:
        done.set()
        killer.join()
    return swept, killed


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_deaths_of_workers_cost_time_and_nothing_else(client: Any, tmp_path: Path) -> None:
    swept, killed = killed_during_a_sweep(client, tmp_path / "there", 12, 2)
    assert killed == 2 and not swept.failed
    ir.sweep(SOAP, {NM: np.linspace(0.0, 500.0, 12)}, quantity=_slow, store=tmp_path / "here")
    assert points(tmp_path / "here") == points(tmp_path / "there")


def test_a_point_that_kills_its_worker_each_time_fails_alone(
    client: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(clusters, "_ROUNDS", 0)
    before = client.run_on_scheduler(lambda dask_scheduler: dask_scheduler.allowed_failures)
    client.run_on_scheduler(lambda dask_scheduler: setattr(dask_scheduler, "allowed_failures", 0))

    def deadly(stack: Any) -> float:
        if stack.layers[0].thickness_nm == 2.0:
            os._exit(1)
        return float(stack.layers[0].thickness_nm)

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            swept = ir.sweep(SOAP, {NM: [1.0, 2.0, 3.0]}, quantity=deadly, client=client, store=tmp_path / "s")
    finally:
        client.run_on_scheduler(lambda dask_scheduler, n: setattr(dask_scheduler, "allowed_failures", n), n=before)
    assert {point[NM] for point, _ in swept.failed} >= {2.0} and "worker died" in swept.failed[0][1]
    assert (tmp_path / "s" / "points" / "000001.json").exists()


def test_what_all_points_need_is_carried_again_and_no_point_is_blamed(
    client: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    before = client.run_on_scheduler(lambda dask_scheduler: dask_scheduler.allowed_failures)
    client.run_on_scheduler(lambda dask_scheduler: setattr(dask_scheduler, "allowed_failures", 0))
    died = tmp_path / "died"

    def carried(value: Any) -> Any:
        if not died.exists():
            died.touch()
            os._exit(1)
        return value

    monkeypatch.setattr(clusters, "carry", carried)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # A content that no other sweep has: what is on the cluster already is not carried again.
            swept = ir.sweep("air / soap 317 / air", {NM: [1.0, 2.0, 3.0]}, client=client)
    finally:
        client.run_on_scheduler(lambda dask_scheduler, n: setattr(dask_scheduler, "allowed_failures", n), n=before)
    assert died.exists() and not swept.failed


def test_several_levels_and_other_versions_are_refused() -> None:
    own = ir.__version__
    assert clusters._one_level({"a": {"version": own, "simd": "avx2"}, "b": {"version": own, "simd": "avx2"}}) == "avx2"
    for answers, words in (
        (
            {"a": {"version": own, "simd": "avx2"}, "b": {"version": own, "simd": "sse2"}},
            "1 of avx2, 1 of sse2.*IRIDESCE_SIMD",
        ),
        ({"tcp://a": {"version": "0.0.1", "simd": "avx2"}}, "tcp://a has iridesce 0.0.1"),
        ({"tcp://a": {"missing": "No module named 'iridesce'"}}, "tcp://a has no iridesce"),
    ):
        with pytest.raises(ValueError, match=words):
            clusters._one_level(answers)
    with pytest.raises(workers.WrongWorker, match=r"0\.0\.1"):
        workers.check_worker(("0.0.1", "avx2"))
    space: dict[str, Any] = {}
    exec(workers.PROBE, space)
    assert space["probe"]()["version"] == own


def test_no_scheduler_at_the_address(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(clusters, "CONNECT_S", 0.5)
    with pytest.raises(ConnectionError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        ir.sweep(SOAP, {NM: [1.0]}, client="tcp://127.0.0.1:9")
    # What nobody answers leaves nothing behind.
    words = ["soap-bubble", "--seconds", "0.1", "--dask", "tcp://127.0.0.1:9", "-o", str(tmp_path / "run")]
    said = CliRunner().invoke(application(["animate"]), ["animate", *words])
    assert said.exit_code == 1 and not list(tmp_path.iterdir()), said.output
    with pytest.raises(ValueError, match=r"must be an address such as .*, got 'xx://y:1'"):
        ir.sweep(SOAP, {NM: [1.0]}, client="xx://y:1")
    with pytest.raises(ValueError, match="relative to its scene"):
        clusters.check_names(["/maps/film.exr"])


def iridesce(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return command_line.run(words, folder)


def test_frames_by_workers_are_those_of_this_machine(client: Any, tmp_path: Path) -> None:
    words = ("animate", "soap-bubble", "--seconds", "0.15", "--fps", "20", "--orbit", "10", "--size", "24x16")
    words += ("--samples", "1", "--columns", "304")
    address = ("--dask", client.scheduler.address)
    for where, more in (("here", ()), ("there", address)):
        done = iridesce(*words, "-o", where, *more, folder=tmp_path)
        assert done.returncode == 0, done.stderr
    frames = sorted((tmp_path / "here").glob("*.png"))
    assert len(frames) == 3 and len({frame.read_bytes() for frame in frames}) == 3
    (tmp_path / "there" / "frame_00001.png").unlink()
    again = iridesce(*words, "-o", "there", "--resume", "--json", *address, folder=tmp_path)
    assert again.returncode == 0 and '"drawn": 1' in again.stdout, again.stderr
    for frame in frames:
        assert frame.read_bytes() == (tmp_path / "there" / frame.name).read_bytes()


def test_a_picture_by_workers_has_the_bytes_of_render(client: Any, tmp_path: Path) -> None:
    from iridesce.sweeping.frames import draw_in_shards

    scene = ir.Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", 400.0)
    asked = {"samples": 1, "seed": 3, "size": (70, 50), "crop": None, "threads": None}
    draw_in_shards(client, scene, asked).save(tmp_path / "there.exr")
    ir.render(scene, **asked).save(tmp_path / "here.exr")
    assert (tmp_path / "there.exr").read_bytes() == (tmp_path / "here.exr").read_bytes()
    refused = iridesce("render", "soap-bubble", "--dask", "local:1", "--time", "3", folder=tmp_path)
    assert refused.returncode == 2 and "--until" in refused.stderr


def test_fits_by_workers_are_those_of_this_machine(client: Any, tmp_path: Path) -> None:
    from iridesce.sweeping.fits import fit_each

    nm = np.linspace(450.0, 750.0, 60)
    questions = [
        {"wavelength_nm": nm, "measured": ir.Stack(["air", ir.Layer("SiO2", t), "Si"]).reflectance(nm), "gain": 1.0}
        for t in (300.0, 400.0)
    ]
    questions = [{**one, "stack": "air / SiO2 ? / Si", "thickness_range_nm": (200.0, 500.0)} for one in questions]
    found = fit_each(client, questions)
    assert [one.to_dict() for one in found] == [ir.fit_thickness(**one).to_dict() for one in questions]
    with pytest.raises(ValueError, match="measured"):
        fit_each(client, [{**questions[0], "measured": np.full(60, np.nan)}])


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_the_schedulers_death_ends_the_client_and_resume_goes_on(tmp_path: Path) -> None:
    python = [sys.executable, "-m"]
    with subprocess.Popen(
        [
            *(*python, "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"),
            *("--scheduler-file", str(tmp_path / "scheduler.json")),
        ],
        stderr=subprocess.DEVNULL,
    ) as scheduler:
        until = time.monotonic() + 60
        while not (tmp_path / "scheduler.json").exists() and time.monotonic() < until:
            time.sleep(0.1)
        import json

        address = json.loads((tmp_path / "scheduler.json").read_text())["address"]
        with subprocess.Popen(
            [
                *(*python, "distributed.cli.dask_worker", address, "--nthreads", "1", "--host", "127.0.0.1"),
                *("--no-dashboard", "--no-nanny", "--death-timeout", "5"),
            ],
            stderr=subprocess.DEVNULL,
        ) as worker:
            words = ["sweep", "soap-bubble", "--set", "camera.resolution=[32,32]", "--set", "render.samples=4"]
            words += ["--vary", "camera.fov_deg=20:40:80", "-o", "s"]
            with subprocess.Popen(
                [*python, "iridesce", *words, "--dask", address], cwd=tmp_path, stderr=subprocess.PIPE, text=True
            ) as sweep:
                while len(list(tmp_path.glob("s/points/*"))) < 3 and time.monotonic() < until:
                    time.sleep(0.05)
                scheduler.kill()
                began = time.monotonic()
                _, said = sweep.communicate(timeout=60)
                assert time.monotonic() - began < 30.0
                worker.kill()
    assert sweep.returncode == 1 and "is gone" in said and "Traceback" not in said, said
    assert 3 <= len(list(tmp_path.glob("s/points/*.exr"))) < 80
    again = subprocess.run([*python, "iridesce", *words, "--resume"], cwd=tmp_path, capture_output=True, text=True)
    assert again.returncode == 0 and len(list(tmp_path.glob("s/points/*.exr"))) == 80, again.stderr
