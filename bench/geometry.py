"""Rays through many triangles, spheres and instances, each beside a yardstick; prints a table.

usage: geometry.py [--threads N] [--repeats N] [--size N] [mesh | spheres | instances | memory | glasses | start]...

mesh       Mrays/s on a bumpy sphere of 1.0 million triangles, coherent (one view) and incoherent (a lens three
           times as wide as the sphere: neighbouring rays share neither origin nor direction). Ours are samples of a whole render
           of an emitter, with camera and framebuffer, but without what an emitter does not ask: places, normals, spectra by
           sample; beside them those of one plain sphere. `embreex`, where it is installed, tells the nearest hit of rays of
           that kind and no more.
spheres    time of a camera sample through 10^3, 10^4 and 10^5 spheres that cover the same area
instances  the same and the memory of 10^6 instances of a mesh of 80 triangles
memory     peak memory of a render of the mesh, above that of a render of one sphere
glasses    a camera sample through one ball of glass and through three nested ones, under the built-in studio
start      whole processes: seconds and peak memory of `iridesce render` on a picture of 16 x 16, and those of the bench
           bubble at 64 samples

Times are processor time by thread, the best of N repeats (of `glasses` the median of 5 N, in turn), since on a shared
machine the clock tells of the others: what threads wait for one another is not in them. Only ratios of one run mean
something.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SIDES = 708  # 2 * 708 * 707 triangles: 1.0 million
BUMP = 0.06
VIEWS: dict[str, dict[str, Any]] = {
    "coherent": {"position": [0.0, 0.0, 4.0], "fov_deg": 26.0},
    "incoherent": {"position": [0.0, 0.0, 4.0], "fov_deg": 26.0, "aperture_radius": 3.0, "focus_distance": 4.0},
}


def bumpy_sphere(sides: int) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Vertices and triangles of a closed sphere of radius 1 with waves on it."""
    theta = np.pi * np.arange(sides + 1)[:, None] / sides
    phi = 2 * np.pi * np.arange(sides)[None, :] / sides
    radius = 1.0 + BUMP * np.sin(9 * theta) * np.sin(theta) ** 2 * np.cos(11 * phi)
    grid = np.stack(
        [
            radius * np.sin(theta) * np.cos(phi),
            radius * np.cos(theta) * np.ones_like(phi),
            radius * np.sin(theta) * np.sin(phi),
        ],
        -1,
    )
    index = 1 + np.arange((sides - 1) * sides).reshape(sides - 1, sides)
    points = np.concatenate([grid[:1, 0], grid[1:-1].reshape(-1, 3), grid[-1:, 0]])
    right = np.roll(index, -1, axis=1)
    a, b, c, d = index[:-1].ravel(), right[:-1].ravel(), right[1:].ravel(), index[1:].ravel()
    last = len(points) - 1
    top = np.stack([np.zeros(sides, dtype=int), right[0], index[0]], axis=1)
    bottom = np.stack([np.full(sides, last), index[-1], right[-1]], axis=1)
    faces = np.concatenate([top, np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1), bottom])
    return points.astype(np.float32), faces.astype(np.int32)


def write_ply(path: Path, points: NDArray[np.float32], faces: NDArray[np.int32]) -> None:
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    rows = np.zeros(len(faces), dtype=[("count", "u1"), ("corner", "<i4", (3,))])
    rows["count"], rows["corner"] = 3, faces
    path.write_bytes("\n".join(head).encode() + points.astype("<f4").tobytes() + rows.tobytes())


def scene(shape: dict[str, Any], view: dict[str, Any], size: int, **more: Any) -> dict[str, Any]:
    glow = {"emitter": {"illuminant": "E", "radiance": 1.0}}
    return {
        "version": 1,
        "camera": {**view, "resolution": [size, size]},
        "object": [{"name": "thing", "shape": shape, "surface": glow, **more}],
        "light": [{"environment": {"illuminant": "E", "radiance": 0.0}}],
    }


def sample_s(loaded: Any, samples: int, threads: int) -> tuple[float, float]:
    """Processor seconds by thread of so many samples a pixel, without preparing, and the share of the picture covered."""
    import iridesce as ir

    clock, covered = [time.process_time()], 0.0
    for count in (1, 1 + samples):
        image = ir.render(loaded, samples=count, threads=threads)
        clock.append(time.process_time())
        covered = float(np.isfinite(image.channels["depth"]).mean())
    return (clock[2] - 2 * clock[1] + clock[0]) / threads, covered


def best_s(tree: dict[str, Any], samples: int, threads: int, repeats: int) -> tuple[float, float]:
    """The least of several times."""
    import iridesce as ir

    loaded = ir.Scene.load(tree, progress=False)
    return min(sample_s(loaded, samples, threads) for _ in range(repeats))


def enough(size: int) -> int:
    """Samples a pixel that stand out of the preparing, which is taken off."""
    return max(8, 2**23 // size**2)


def rays(view: dict[str, Any], count: int, seed: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Origins and directions of rays such as the camera's, pixel after pixel."""
    rng = np.random.default_rng(seed)
    side = round(count**0.5)
    x, y = np.meshgrid((np.arange(side) + 0.5) / side * 2 - 1, (np.arange(side) + 0.5) / side * 2 - 1)
    half = np.tan(np.deg2rad(view["fov_deg"]) / 2)
    way = np.stack([half * x.ravel(), half * y.ravel(), -np.ones(side * side)], axis=1)
    origin = np.zeros_like(way)
    if "aperture_radius" in view:
        r, phi = view["aperture_radius"] * np.sqrt(rng.random(side * side)), 2 * np.pi * rng.random(side * side)
        origin = np.stack([r * np.cos(phi), r * np.sin(phi), np.zeros(side * side)], axis=1)
        way = way * view["focus_distance"] - origin
    origin[:, 2] += view["position"][2]
    return origin.astype(np.float32), (way / np.linalg.norm(way, axis=1, keepdims=True)).astype(np.float32)


def embree(job: tuple[dict[str, Any], int, int]) -> tuple[int, float]:
    """Rays and seconds of the peer on one thread, best of the repeats."""
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    view, count, repeats = job
    points, faces = bumpy_sphere(SIDES)
    world = rtcore_scene.EmbreeScene()
    TriangleMesh(world, points[faces])
    origin, way = rays(view, count, os.getpid())
    world.run(origin[:64], way[:64])
    took = []
    for _ in range(repeats):
        start = time.process_time()
        world.run(origin, way)
        took.append(time.process_time() - start)
    return len(origin), min(took)


def mesh(arguments: argparse.Namespace, folder: Path) -> None:
    points, faces = bumpy_sphere(SIDES)
    write_ply(folder / "bumpy.ply", points, faces)
    size, samples = arguments.size, 2 * enough(arguments.size)
    print(f"\n{len(faces)} triangles, {arguments.threads} threads\n")
    print("| rays | Mrays/s | covered | one sphere | embreex | ratio |\n|---|---|---|---|---|---|")
    for name, view in VIEWS.items():
        took, covered = best_s(
            scene({"mesh": {"file": "bumpy.ply"}}, view, size), samples, arguments.threads, arguments.repeats
        )
        plain, _ = best_s(scene({"sphere": {"radius": 1.0}}, view, size), samples, arguments.threads, arguments.repeats)
        theirs = float("nan")
        try:
            import embreex  # noqa: F401

            with multiprocessing.get_context("spawn").Pool(arguments.threads) as pool:
                told = pool.map(embree, [(view, 1 << 20, arguments.repeats)] * arguments.threads)
            theirs = sum(n / seconds for n, seconds in told) / 1e6
        except ImportError:
            pass
        own, alone = (size * size * samples / seconds / 1e6 for seconds in (took, plain))
        print(f"| {name} | {own:.2f} | {covered:.2f} | {alone:.2f} | {theirs:.2f} | {own / theirs:.2f} |", flush=True)


def placed(count: int, radius: float, seed: int) -> Floats:
    """Transforms of so many spheres, random in a cube of half edge 1."""
    rng = np.random.default_rng(seed)
    rows = np.zeros((count, 3, 4))
    rows[:, [0, 1, 2], [0, 1, 2]] = radius
    rows[:, :, 3] = rng.uniform(-1.0, 1.0, (count, 3))
    return rows


def spheres(arguments: argparse.Namespace, folder: Path) -> None:
    print("\n| spheres | as | covered | ns a camera sample | against 1 000 |\n|---|---|---|---|---|")
    view = {"position": [0.0, 0.0, 9.0], "orthographic_height": 2.0}
    glow = {"emitter": {"illuminant": "E", "radiance": 1.0}}
    for way in ("instances", "objects"):
        first = 0.0
        for count in (1_000, 10_000, 100_000):
            rows = placed(count, float(np.sqrt(2.8 / (np.pi * count))), 7)  # 1 - exp(-0.7) of the view
            if way == "instances":
                np.save(folder / f"spheres-{count}.npy", rows)
                tree = scene(
                    {"sphere": {"radius": 1.0}}, view, arguments.size, instances={"file": f"spheres-{count}.npy"}
                )
            else:
                tree = scene({"sphere": {}}, view, arguments.size)
                tree["object"] = [
                    {
                        "name": f"s{i}",
                        "shape": {"sphere": {"center": row[:, 3].tolist(), "radius": float(row[0, 0])}},
                        "surface": glow,
                    }
                    for i, row in enumerate(rows)
                ]
            took, covered = best_s(tree, enough(arguments.size), arguments.threads, arguments.repeats)
            each = took * 1e9 / (arguments.size**2 * enough(arguments.size))
            first = first or each
            print(f"| {count} | {way} | {covered:.2f} | {each:.0f} | {each / first:.2f} |", flush=True)


def alone(code: str, folder: Path) -> dict[str, float]:
    """What a process of its own answers, with its peak memory."""
    tail = "\nimport resource\nfacts['mb'] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024\nprint(json.dumps(facts))"
    done = subprocess.run([sys.executable, "-c", code + tail], cwd=folder, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


_DRAW = """
import time, json, iridesce as ir
facts = {{}}
tree = json.loads('''{tree}''')
start = time.perf_counter()
image = ir.render(tree, samples={samples}, threads={threads})
facts['s'] = time.perf_counter() - start
"""


def drawn(tree: dict[str, Any], samples: int, threads: int, folder: Path) -> dict[str, float]:
    return alone(_DRAW.format(tree=json.dumps(tree), samples=samples, threads=threads), folder)


def instances(arguments: argparse.Namespace, folder: Path) -> None:
    points, faces = bumpy_sphere(7)
    write_ply(folder / "small.ply", points, faces)
    view = {"position": [0.0, 0.0, 9.0], "orthographic_height": 2.0}
    print(f"\nInstances of a mesh of {len(faces)} triangles\n")
    print("| instances | s to the first sample | peak MB | ns a further sample |\n|---|---|---|---|")
    for count in (1_000, 1_000_000):
        np.save(folder / f"many-{count}.npy", placed(count, float(np.sqrt(2.8 / (np.pi * count))), 7))
        tree = scene({"mesh": {"file": "small.ply"}}, view, arguments.size, instances={"file": f"many-{count}.npy"})
        told = drawn(tree, 1, arguments.threads, folder)
        took, _ = best_s(tree, enough(arguments.size), arguments.threads, arguments.repeats)
        print(
            f"| {count} | {told['s']:.2f} | {told['mb']:.0f} | {took * 1e9 / (arguments.size**2 * enough(arguments.size)):.0f} |",
            flush=True,
        )


def memory(arguments: argparse.Namespace, folder: Path) -> None:
    points, faces = bumpy_sphere(SIDES)
    write_ply(folder / "bumpy.ply", points, faces)
    glow = drawn(scene({"sphere": {"radius": 1.0}}, VIEWS["coherent"], 256), 1, arguments.threads, folder)
    print("\n| scene | s to the first sample | peak MB | bytes a triangle |\n|---|---|---|---|")
    print(f"| one sphere | {glow['s']:.2f} | {glow['mb']:.0f} | |")
    for name, surface in {
        "emitter": {"emitter": {"illuminant": "E", "radiance": 1.0}},
        "matt": {"diffuse": {}},
        "film": {"film": {"thickness_nm": 300.0}},
    }.items():
        tree = scene({"mesh": {"file": "bumpy.ply"}}, VIEWS["coherent"], 256)
        tree["object"][0]["surface"] = surface
        told = drawn(tree, 1, arguments.threads, folder)
        each = (told["mb"] - glow["mb"]) * 2**20 / len(faces)
        print(f"| {len(faces)} triangles, {name} | {told['s']:.2f} | {told['mb']:.0f} | {each:.0f} |", flush=True)


def glasses(arguments: argparse.Namespace, folder: Path) -> None:
    import iridesce as ir

    balls = [("outer", 1.0, 1.5), ("middle", 0.7, 1.33), ("inner", 0.4, 1.7)]
    side, samples, loaded = 96, 16, []  # rays that total reflection keeps in make three of them slow
    for count in (1, 3):
        tree = scene({"sphere": {"radius": 1.0}}, VIEWS["coherent"], side)
        tree["object"] = [
            {"name": name, "shape": {"sphere": {"radius": radius}}, "surface": {"dielectric": {"medium": index}}}
            for name, radius, index in balls[:count]
        ]
        tree["light"] = [{"environment": {"builtin": "studio"}}]
        loaded.append(ir.Scene.load(tree, progress=False))
    # In turn, and medians: the least difference of short times is that of the worst luck with the other one.
    rounds = 5 * arguments.repeats
    took = np.array([[sample_s(each, samples, arguments.threads)[0] for each in loaded] for _ in range(rounds)])
    ns = took * arguments.threads * 1e9 / (side**2 * samples)
    times = np.median(ns[:, 1] / ns[:, 0])
    print(f"\n| balls | ns a camera sample, median of {rounds} in turn | times one |\n|---|---|---|")
    print(f"| 1 | {np.median(ns[:, 0]):.0f} | 1 |\n| 3 | {np.median(ns[:, 1]):.0f} | {times:.2f} |", flush=True)


# Seconds, processor seconds and peak MB of a command, by a process of little memory of its own: that of whoever starts a
# process counts as the new one's peak until it is larger.
WATCH = """
import os, sys, time
begin = time.perf_counter()
_, status, told = os.wait4(os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ), 0)
print(time.perf_counter() - begin, told.ru_utime + told.ru_stime, told.ru_maxrss / 1024)
sys.exit(os.waitstatus_to_exitcode(status))
"""


def start(arguments: argparse.Namespace, folder: Path) -> None:
    from run import BUBBLE
    from studio import write_studio

    write_studio(folder)
    (folder / "bubble.toml").write_text(BUBBLE)
    trivial = scene({"sphere": {"radius": 1.0}}, VIEWS["coherent"], 16)
    (folder / "trivial.json").write_text(json.dumps(trivial))
    print("\n| picture | wall s, median | processor s | peak MB |\n|---|---|---|---|")
    for name, samples, repeats in (("trivial.json", 1, 5), ("bubble.toml", 64, 1)):
        command = [sys.executable, "-m", "iridesce", "render", name, "-o", "out.exr", "--samples", str(samples)]
        command = [sys.executable, "-S", "-c", WATCH, *command, "--threads", str(arguments.threads)]
        runs = [subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True) for _ in range(repeats)]
        wall, used, peak = zip(*(map(float, run.stdout.split()[-3:]) for run in runs), strict=True)
        print(f"| {name} | {sorted(wall)[repeats // 2]:.2f} | {min(used):.2f} | {max(peak):.0f} |", flush=True)


PARTS = {"mesh": mesh, "spheres": spheres, "instances": instances, "memory": memory, "glasses": glasses, "start": start}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], default=[])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--size", type=int, default=512)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.chdir(folder)
        for part in arguments.parts or PARTS:
            PARTS[part](arguments, folder)
        os.chdir("/")
    return 0


if __name__ == "__main__":
    sys.exit(main())
