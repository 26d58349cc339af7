"""Every measurement of docs/evidence/performance.md on this machine.

usage: run.py [--peer PYTHON | --fetch-peer] [--repeats N] [--reference-samples N] [--no-jobs] [--out FOLDER]

Without a peer it measures the four jobs, the bench bubble and the speed-up from one thread to two. With ``--peer
PYTHON``, a Python that has `mitsuba` 3.9.1 and `numpy`, or ``--fetch-peer``, which makes such an environment under
FOLDER, the peer is rendered in the same go and in turn, and the ratio is printed. Times are whole processes as a user
starts them; medians of N repeats. Pictures for the errors are rendered again through the Python API: the same scene,
seed and samples give the same bytes. Everything is written to FOLDER (default target/bench), the results as
result.json.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import statistics
import subprocess
import sys
import time
import venv
from pathlib import Path
from typing import Any

import numpy as np

import iridesce as ir

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from efficiency import bubble_disc, relative_mse  # noqa: E402  found through the line above
from studio import write_studio  # noqa: E402

PEER_PACKAGES = ("mitsuba==3.9.1", "numpy")
OUR_SAMPLES = (4, 16, 64)
PEER_SAMPLES = 256
PEER_REFERENCE_SAMPLES = 4096  # 16 times the picture's: less would add its own noise to the peer's error
REFERENCE_SEED = 1001
LINEAR_SRGB = np.array(  # XYZ to linear sRGB, IEC 61966-2-1
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB

BUBBLE = """\
version = 1

[camera]
position = [0.0, 0.0, 4.0]
target = [0.0, 0.0, 0.0]
fov_deg = 35.0
resolution = [512, 512]

[render]
samples = 64
seed = 1
max_depth = 16

[[object]]
name = "bubble"
shape = { sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 } }
surface = { film = { medium = 1.33, thickness_nm = { gradient = { top = 0.0, bottom = 800.0 } } } }

[[light]]
environment = { map = "studio.exr" }
"""


def timed(command: list[str]) -> float:
    """Wall seconds of a whole process."""
    start = time.perf_counter()
    finished = subprocess.run(command, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - start
    if finished.returncode != 0:
        sys.exit(f"{' '.join(command)} left with {finished.returncode}:\n{finished.stderr}")
    return seconds


def ours(folder: Path, samples: int, threads: int = 2) -> float:
    """Seconds of `iridesce render` on the bench bubble, its picture written as EXR."""
    command = [sys.executable, "-m", "iridesce", "render", str(folder / "bubble.toml"), "-o", str(folder / "ours.exr")]
    return timed([*command, "--samples", str(samples), "--seed", "1", "--threads", str(threads)])


def our_picture(folder: Path, samples: int, seed: int) -> np.ndarray:
    """(512, 512, 3) linear sRGB."""
    return ir.render(folder / "bubble.toml", samples=samples, seed=seed).xyz.astype(np.float64) @ LINEAR_SRGB.T


def peer(python: Path, folder: Path, samples: int, seed: int, out: str) -> float:
    """Seconds of the peer on the same bubble; writes FOLDER/out."""
    command = [str(python), str(HERE / "peer_mitsuba.py"), str(samples), str(folder / out)]
    return timed([*command, "--environment", str(folder / "studio_zup.exr"), "--seed", str(seed)])


def fetch_peer(folder: Path) -> Path:
    """Make a virtual environment with the peer, once."""
    python = folder / "peer" / "bin" / "python"
    if not python.exists():
        venv.create(folder / "peer", with_pip=True)
        timed([str(python), "-m", "pip", "install", "--quiet", *PEER_PACKAGES])
    return python


def measure_bubble(folder: Path, peer_python: Path | None, repeats: int, reference_samples: int) -> dict[str, Any]:
    """Error, time and efficiency of every side, taken in turn."""
    times: dict[str, list[float]] = {}
    for _ in range(repeats):
        for samples in OUR_SAMPLES:
            times.setdefault(f"iridesce {samples}", []).append(ours(folder, samples))
        times.setdefault("iridesce 64, one thread", []).append(ours(folder, 64, threads=1))
        if peer_python:
            times.setdefault(f"peer {PEER_SAMPLES}", []).append(peer(peer_python, folder, PEER_SAMPLES, 1, "peer.npy"))
    medians = {side: statistics.median(seconds) for side, seconds in times.items()}

    reference = our_picture(folder, reference_samples, REFERENCE_SEED)
    disc = bubble_disc(*reference.shape[:2])
    rows: dict[str, dict[str, float]] = {}
    for samples in OUR_SAMPLES:
        side = f"iridesce {samples}"
        one, two = our_picture(folder, samples, 1), our_picture(folder, samples, 2)
        error = relative_mse(one, reference)
        rows[side] = {
            "wall_s": medians[side],
            "spread_s": max(times[side]) - min(times[side]),
            "relMSE": error,
            "relMSE_other_seed": relative_mse(two, reference),
            "efficiency": 1.0 / (error * medians[side]),
            # independent noise: the difference of two seeds has twice the error of one
            "relMSE_between_seeds": relative_mse(one, two),
        }
    result: dict[str, Any] = {
        "rows": rows,
        "mean_luminance": float((reference @ LUMINANCE)[disc].mean()),
        "speed_up_1_to_2_threads": medians["iridesce 64, one thread"] / medians["iridesce 64"],
    }
    if peer_python:
        peer(peer_python, folder, PEER_REFERENCE_SAMPLES, REFERENCE_SEED, "peer_reference.npy")
        peer_reference = np.load(folder / "peer_reference.npy").astype(np.float64)
        error = relative_mse(np.load(folder / "peer.npy"), peer_reference)
        side = f"peer {PEER_SAMPLES}"
        rows[side] = {
            "wall_s": medians[side],
            "spread_s": max(times[side]) - min(times[side]),
            "relMSE": error,
            "efficiency": 1.0 / (error * medians[side]),
        }
        for row in rows.values():
            row["times_the_peer"] = row["efficiency"] / rows[side]["efficiency"]
        result["peer_mean_luminance"] = float((peer_reference @ LUMINANCE)[disc].mean())
        result["difference_of_references"] = relative_mse(reference, peer_reference)
    return result


def machine() -> dict[str, Any]:
    """What the figures belong to."""
    commit = subprocess.run(
        ["git", "-C", str(HERE), "describe", "--always", "--dirty"], capture_output=True, text=True, check=False
    )
    names = [line.split(":")[1].strip() for line in _lines("/proc/cpuinfo") if line.startswith("model name")]
    return {
        "date": datetime.date.today().isoformat(),
        "commit": commit.stdout.strip(),
        "version": ir.__version__,
        "processor": names[0] if names else platform.processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
    }


def _lines(path: str) -> list[str]:
    try:
        return Path(path).read_text().splitlines()
    except OSError:
        return []


def show(result: dict[str, Any]) -> None:
    """The tables of docs/evidence/performance.md."""
    print(" ".join(f"{key}: {value};" for key, value in result["machine"].items()))
    if "jobs" in result:
        print("\n| job | cold s | warm s | spread s | rate |\n|---|---|---|---|---|")
        for name, job in result["jobs"].items():
            rate = f"{job['rate']:.3g} {job['unit']}"
            print(f"| `{name}` | {job['cold_s']:.3f} | {job['warm_s']:.3f} | {job['spread_s']:.3f} | {rate} |")
    bubble = result["bubble"]
    print("\n| samples a pixel | wall s | spread s | relMSE | efficiency | times the peer |\n|---|---|---|---|---|---|")
    for side, row in bubble["rows"].items():
        ratio = f"{row['times_the_peer']:.0f}" if "times_the_peer" in row else ""
        figures = f"{row['wall_s']:.2f} | {row['spread_s']:.2f} | {row['relMSE']:.2e} | {row['efficiency']:.3g}"
        print(f"| {side} | {figures} | {ratio} |")
    for key, value in bubble.items():
        if key != "rows":
            print(f"{key.replace('_', ' ')}: {value:.4g}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    chosen = parser.add_mutually_exclusive_group()
    chosen.add_argument("--peer", type=Path, help="a Python that has the peer")
    chosen.add_argument("--fetch-peer", action="store_true", help="make an environment with the peer")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--reference-samples", type=int, default=1024)
    parser.add_argument("--no-jobs", action="store_true", help="the bubble only")
    parser.add_argument("--out", type=Path, default=HERE.parent / "target" / "bench")
    options = parser.parse_args()

    folder = options.out.resolve()
    write_studio(folder)
    (folder / "bubble.toml").write_text(BUBBLE)
    python = fetch_peer(folder) if options.fetch_peer else options.peer
    result: dict[str, Any] = {"machine": machine()}
    if not options.no_jobs:
        from jobs import measure

        result["jobs"] = measure(options.repeats)
    result["bubble"] = measure_bubble(folder, python, options.repeats, options.reference_samples)
    (folder / "result.json").write_text(json.dumps(result, indent=2))
    show(result)


if __name__ == "__main__":
    main()
