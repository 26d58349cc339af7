"""Sweeps measured: overhead a point, efficiency with 1 and 2 processes, kills survived with equal bytes, the scheduler's death.

    python bench/sweeps.py [--kills 50] [--only overhead]

Overhead: processor time of `ir.sweep` a point (which other work on the machine stretches least), less that of the same calls
in a plain loop, which writes a file a point where the sweep has a store (so: checks, digests, the index).
Efficiency: points a second of two worker processes over twice those of one, in turn, the median of three.
Scheduler: from its death (SIGKILL, some points into a sweep) to the end of the command; then --resume, and its bytes.
"""

from __future__ import annotations

import argparse
import functools
import json
import logging
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import iridesce as ir

SOAP = "air / soap 320 / air"
NM = "layers.0.thickness_nm"
FILM = "object.bubble.surface.film.thickness_nm"


def seconds(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def processor_seconds(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began


def overhead(points: int) -> None:
    values = np.linspace(0.0, 1000.0, points).tolist()
    scene = ir.Scene.load("soap-bubble").with_value("camera.resolution", [64, 48]).with_value("render.samples", 1)

    def colors(folder: Path | None) -> None:
        for nm in values:
            found = ir.Stack(["air", ir.Layer("soap", nm), "air"]).color()
            if folder is not None:
                np.save(folder / f"{nm}.npy", found)

    def pictures(folder: Path | None) -> None:
        for nm in values[: points // 4]:
            found = ir.render(scene.with_value(FILM, nm), threads=1)
            if folder is not None:
                found.save(folder / f"{nm}.exr")

    for name, base, key, loop, count in (
        ("color", SOAP, NM, colors, points),
        ("image", scene, FILM, pictures, points // 4),
    ):
        measured(name, base, {key: values[:count]}, loop, count)


def measured(name: str, base: Any, vary: dict[str, Any], loop: Callable[[Path | None], object], count: int) -> None:
    rows: dict[str, list[float]] = {"loop": [], "files": [], "memory": [], "store": [], "again": []}
    for _ in range(5):
        with tempfile.TemporaryDirectory() as folder:
            rows["loop"].append(processor_seconds(functools.partial(loop, None)))
            rows["files"].append(processor_seconds(functools.partial(loop, Path(folder))))
            rows["memory"].append(processor_seconds(lambda: ir.sweep(base, vary, threads=1)))
            store = Path(folder) / "store"
            rows["store"].append(processor_seconds(functools.partial(ir.sweep, base, vary, threads=1, store=store)))
            rows["again"].append(processor_seconds(functools.partial(ir.sweep, base, vary, store=store)))
    ms = {what: 1e3 * statistics.median(times) / count for what, times in rows.items()}
    print(f"{name}: loop {ms['loop']:.2f} ms a point, {ms['files']:.2f} with a file each;")
    print(
        f"    beyond it {ms['memory'] - ms['loop']:.2f} ms in memory, {ms['store'] - ms['files']:.2f} ms into a store;"
    )
    print(f"    a finished store is read at {ms['again']:.2f} ms")


def efficiency(distributed: Any, count: int) -> None:
    scene = ir.Scene.load("soap-bubble").with_value("camera.resolution", [96, 72]).with_value("render.samples", 16)
    vary = {FILM: np.linspace(100.0, 700.0, count)}
    rates: dict[int, list[float]] = {1: [], 2: []}
    clusters = {
        n: distributed.LocalCluster(n_workers=n, threads_per_worker=1, host="127.0.0.1", dashboard_address=None)
        for n in (1, 2)
    }
    clients = {n: distributed.Client(cluster, set_as_default=False) for n, cluster in clusters.items()}
    for client in clients.values():
        ir.sweep(scene, {FILM: [1.0, 2.0]}, client=client)
    for _ in range(3):
        for n, client in clients.items():
            rates[n].append(count / seconds(lambda c=client: ir.sweep(scene, vary, client=c)))  # type: ignore[misc]
    one, two = (statistics.median(rates[n]) for n in (1, 2))
    print(f"processes: 1 {one:.1f} points/s, 2 {two:.1f} points/s, efficiency {two / one / 2:.2f}")
    for n in (1, 2):
        clients[n].close()
        clusters[n].close()


def slow(stack: Any) -> Any:
    time.sleep(0.15)
    return stack.color()


def started(address: str, name: str) -> subprocess.Popen[bytes]:
    """A worker without Dask's nanny, which gives up where a worker dies while it starts."""
    command = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny"]
    paths = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(
        [*command, "--no-dashboard", "--host", "127.0.0.1", "--name", name],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": paths},
    )


def kills(distributed: Any, wanted: int) -> None:
    """Of three workers one that is at work is killed every 0.8 s, and another started in its place, as batch systems do."""
    points = 8 * wanted
    vary = {NM: np.linspace(0.0, 1000.0, points)}
    with (
        tempfile.TemporaryDirectory() as folder,
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address=None, silence_logs=50) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        done, killed = threading.Event(), 0
        rng = np.random.default_rng(1)
        workers = {name: started(cluster.scheduler_address, name) for name in ("0", "1", "2")}
        client.wait_for_workers(3)

        def kill() -> None:
            nonlocal killed
            while killed < wanted and not done.wait(0.8):
                there = [str(one["name"]) for one in client.scheduler_info(n_workers=-1)["workers"].values()]
                alive = sorted(set(there) & set(workers))
                if not alive:
                    continue
                victim = workers.pop(alive[int(rng.integers(len(alive)))])
                victim.kill()
                victim.wait()
                killed += 1
                name = str(killed + 2)
                workers[name] = started(cluster.scheduler_address, name)

        killer = threading.Thread(target=kill)
        killer.start()
        try:
            there = ir.sweep(SOAP, vary, quantity=slow, store=Path(folder) / "there", client=client)
        finally:
            done.set()
            killer.join()
            for worker in workers.values():
                worker.kill()
        ir.sweep(SOAP, vary, quantity=slow, store=Path(folder) / "here")
        files = {p.name: p.read_bytes() for p in (Path(folder) / "here" / "points").iterdir()}
        others = {p.name: p.read_bytes() for p in (Path(folder) / "there" / "points").iterdir()}
    print(
        f"kills: {killed} workers during {points} points, {len(there.failed)} failed, "
        f"{sum(map(len, files.values()))} bytes in {len(files)} files {'equal' if files == others else 'DIFFERENT'}"
    )


def deaths_of_schedulers(tries: int) -> None:
    sweep = [sys.executable, "-m", "iridesce", "sweep", "soap-bubble", "--set", "camera.resolution=[64,64]"]
    sweep += ["--set", "render.samples=16", "--vary", "camera.fov_deg=20:40:60", "-o"]
    late, left, codes = [], [], []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        subprocess.run([*sweep, "whole"], cwd=folder, check=True, capture_output=True)
        whole = {p.name: p.read_bytes() for p in (folder / "whole" / "points").iterdir()}
        for number in range(tries):
            told = folder / f"{number}.json"
            command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0"]
            scheduler = subprocess.Popen(
                [*command, "--no-dashboard", "--scheduler-file", str(told)], stderr=subprocess.DEVNULL
            )
            while not told.exists():
                time.sleep(0.1)
            address = json.loads(told.read_text())["address"]
            worker = started(address, "0")
            client = subprocess.Popen(
                [*sweep, f"{number}", "--dask", address], cwd=folder, stderr=subprocess.PIPE, text=True
            )
            points = folder / f"{number}" / "points"
            while len(list(points.glob("*"))) < 5 and client.poll() is None:
                time.sleep(0.02)
            scheduler.kill()
            began = time.monotonic()
            client.communicate()
            late.append(time.monotonic() - began)
            codes.append(client.returncode)
            left.append(60 - len(list(points.glob("*"))))
            worker.kill()
            scheduler.wait()
            worker.wait()
            subprocess.run([*sweep, f"{number}", "--resume"], cwd=folder, check=True, capture_output=True)
            found = {p.name: p.read_bytes() for p in points.iterdir()}
            if found != whole:
                raise AssertionError(f"try {number}: other bytes after --resume")
    print(
        f"scheduler: killed {tries} times with {min(left)} to {max(left)} of 60 points left; the command ended "
        f"{statistics.median(late):.1f} s later in the median, {max(late):.1f} at worst, exit codes {sorted(set(codes))}; "
        f"after --resume all {len(whole)} files have the bytes of a sweep without Dask"
    )


if __name__ == "__main__":
    reading = argparse.ArgumentParser(description=__doc__)
    reading.add_argument("--kills", type=int, default=50)
    reading.add_argument("--points", type=int, default=400)
    reading.add_argument("--only", choices=("overhead", "efficiency", "kills", "scheduler"), help="one of the four")
    given = reading.parse_args()
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore")
    if given.only in (None, "overhead"):
        overhead(given.points)
    try:
        import distributed
    except ImportError:
        print("processes, kills: the extra dask is not installed")
    else:
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        if given.only in (None, "efficiency"):
            efficiency(distributed, given.points // 10)
        if given.only in (None, "kills"):
            kills(distributed, given.kills)
        if given.only in (None, "scheduler"):
            deaths_of_schedulers(5)
