"""A small lamp through a glass ball onto a floor: pictures against rays from the lamp, and their noise beside a peer's.

    python bench/caustics.py [--radius 0.001] [--samples 16 64 256] [--seeds 8] [--threads 2]
                             [--peer PYTHON [--peer-samples 16384]]

The reference follows rays from the lamp through and off the ball (`oracles/ball_caustic.py` of the tests) onto each pixel. PYTHON
has `mitsuba` 3.9.1 and renders the same picture with `path` and with `ptracer`, in turn with ours; times are of single calls, the
first of which is not counted on either side.

    relMSE     = mean over pixels and seeds of (x / reference - 1)^2
    efficiency = 1 / (relMSE x seconds)
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python" / "tests"))
import iridesce as ir
from oracles.ball_caustic import BallCaustic

BALL = BallCaustic()
REFLECTANCE = 0.5
SIZE = (24, 8)
HEIGHT = 0.06  # of the picture; the view comes from 3 across and 1 up


def scene(radius: float, samples: int) -> ir.Scene:
    """The middle of the caustic, a lamp of intensity 1."""
    return ir.Scene.load(
        {
            "version": 1,
            "camera": {
                "position": [3.0, 1.0, 0.0],
                "target": [0, 0, 0],
                "orthographic_height": HEIGHT,
                "resolution": list(SIZE),
            },
            "render": {"samples": samples},
            "object": [
                {"name": "floor", "shape": {"plane": {}}, "surface": {"diffuse": {"reflectance": REFLECTANCE}}},
                {
                    "name": "ball",
                    "shape": {"sphere": {"center": [0, BALL.height, 0], "radius": BALL.radius}},
                    "surface": {"dielectric": {"medium": BALL.index}},
                },
                {
                    "name": "lamp",
                    "shape": {"sphere": {"center": [0, BALL.lamp_height, 0], "radius": radius}},
                    "surface": {"emitter": {"radiance": 1.0 / (np.pi * radius**2)}},
                },
            ],
            "light": [{"environment": {"illuminant": "D65", "radiance": 0.0}}],
        }
    )


def reference(fine: int = 16) -> np.ndarray:
    """Y of every pixel, of a lamp without size."""
    edges = np.linspace(0.0, 0.14, 281)
    profile = BALL.irradiance(edges, rays=4_000_000)
    width, height = SIZE
    across = ((np.arange(width * fine) + 0.5) / (0.5 * width * fine) - 1.0) * HEIGHT / 2.0 * width / height
    along = ((np.arange(height * fine) + 0.5) / (0.5 * height * fine) - 1.0) * HEIGHT / 2.0 * np.sqrt(10.0)
    shown = np.interp(np.hypot(across, along[:, None]), 0.5 * (edges[1:] + edges[:-1]), profile)
    return REFLECTANCE / np.pi * shown.reshape(height, fine, width, fine).mean(axis=(1, 3))


def row(name: str, samples: int, pictures: np.ndarray, seconds: list[float], wanted: np.ndarray) -> None:
    """Prints one row of the table."""
    means = pictures.mean(axis=(1, 2)) / wanted.mean()
    error = float(np.mean((pictures / wanted - 1.0) ** 2))
    took = float(np.median(seconds))
    spread = means.std(ddof=1) / np.sqrt(len(means))
    print(
        f"| {name} | {samples} | {took:.3f} | {means.mean():.4f} +- {spread:.4f} | {error:.2e} | {1.0 / (error * took):.3g} |",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--radius", type=float, default=0.001)
    parser.add_argument("--samples", type=int, nargs="+", default=[16, 64, 256])
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--peer", help="a Python that has the peer")
    parser.add_argument("--peer-samples", type=int, default=16384)
    asked = parser.parse_args()
    wanted = reference()
    print("| | samples/pixel | s | mean over the reference | relMSE | efficiency |\n|---|---|---|---|---|---|")
    for samples in asked.samples:
        own = scene(asked.radius, samples)
        ir.render(own, samples=1, threads=asked.threads)
        pictures, seconds = [], []
        for seed in range(asked.seeds):
            start = time.perf_counter()
            pictures.append(ir.render(own, seed=seed, threads=asked.threads).xyz[..., 1].astype(np.float64))
            seconds.append(time.perf_counter() - start)
        row("iridesce", samples, np.array(pictures), seconds, wanted)
    for integrator in ("path", "ptracer") if asked.peer else ():
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "peer.npy"
            command = [asked.peer, str(Path(__file__).with_name("peer_caustics.py")), integrator]
            command += [str(asked.peer_samples), str(out), "--seeds", str(asked.seeds), "--radius", str(asked.radius)]
            command += ["--threads", str(asked.threads)]
            told = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
            seconds = [json.loads(line)["seconds"] for line in told if line.startswith("{")]
            row(f"mitsuba {integrator}", asked.peer_samples, np.load(out).astype(np.float64), seconds, wanted)


if __name__ == "__main__":
    main()
