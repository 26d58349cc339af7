"""Rough films at equal error beside the path tracer of Mitsuba 3: a mesh of a million triangles, and a room with bubbles.

usage: rough.py --peer PYTHON [--repeats N] [--size N] [--reference N] [--samples OURS PEER] [mesh | room]...

mesh  a bumpy sphere of 1.0 million triangles with a rough oxide on titanium, under the studio map
room  matt walls, a rough metal block and a rough coated ball, a lamp of radius 0.05 and three bubbles

Either side draws the same scene as a whole process, in turn; `efficiency = 1 / (relMSE x wall seconds)`, relMSE = mean of
(x - reference)^2 / (reference^2 + 0.01) over the pixels of the objects in linear sRGB, and each side is held against a picture of
its own of another seed with many more samples, so that what the two models differ by counts for neither. The peer is given the
same exact film as a BSDF (bench/peer_film.py), without polarisation, which is its faster variant, and the faster of its samplers
and integrators (`path`; `volpath` where shadows of bubbles ask for it); PYTHON is one that has `mitsuba`.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from peer_film import exact_film  # noqa: E402  found through the line above

Floats = NDArray[np.float64]

FLOOR = 0.01  # keeps dark pixels from ruling the mean; linear sRGB squared
ROUGHNESS = 0.3
OXIDE: dict[str, Any] = {"coating": {"layers": [{"medium": "TiO2", "thickness_nm": 60.0}], "substrate": "Ti"}}
OXIDE["coating"]["roughness"] = ROUGHNESS
STEEL: dict[str, Any] = {"metal": {"medium": [2.5, 3.4], "roughness": 0.4}}
SAMPLES = {"mesh": {"ours": 64, "peer": 256}, "room": {"ours": 16, "peer": 256}}
BATCH = 64  # samples of a pixel that the peer follows at once


def mesh_scene(size: int) -> dict[str, Any]:
    return {
        "version": 1,
        "camera": {"position": [0.0, 0.0, 4.0], "target": [0.0, 0.0, 0.0], "fov_deg": 33.0, "resolution": [size, size]},
        "render": {"max_depth": 16},
        "object": [{"name": "thing", "shape": {"mesh": {"file": "bumpy.ply"}}, "surface": OXIDE}],
        "light": [{"environment": {"map": "studio.exr"}}],
    }


def rectangle(
    name: str, center: list[float], u: list[float], v: list[float], surface: dict[str, Any]
) -> dict[str, Any]:
    return {"name": name, "shape": {"rectangle": {"center": center, "u": u, "v": v}}, "surface": surface}


def sphere(name: str, center: list[float], radius: float, surface: dict[str, Any]) -> dict[str, Any]:
    return {"name": name, "shape": {"sphere": {"center": center, "radius": radius}}, "surface": surface}


def room_scene(size: int) -> dict[str, Any]:
    def matt(value: float) -> dict[str, Any]:
        return {"diffuse": {"reflectance": value}}

    def bubble(nm: float) -> dict[str, Any]:
        return {"film": {"medium": 1.33, "thickness_nm": nm}}

    walls = [
        rectangle("floor", [0, -1, 0], [1, 0, 0], [0, 0, -1], matt(0.6)),
        rectangle("ceiling", [0, 1, 0], [1, 0, 0], [0, 0, 1], matt(0.7)),
        rectangle("back", [0, 0, -1], [1, 0, 0], [0, 1, 0], matt(0.7)),
        rectangle("left", [-1, 0, 0], [0, 0, -1], [0, 1, 0], matt(0.4)),
        rectangle("right", [1, 0, 0], [0, 0, 1], [0, 1, 0], matt(0.5)),
        rectangle("plate", [0.15, -0.55, -0.7], [0.6, 0, 0], [0, 0.4, -0.1], STEEL),
    ]
    things = [
        sphere("ball", [-0.45, -0.65, 0.1], 0.35, OXIDE),
        sphere("bubble", [0.45, -0.4, 0.1], 0.3, bubble(320.0)),
        sphere("second", [-0.2, 0.25, -0.2], 0.25, bubble(480.0)),
        sphere("third", [0.6, 0.4, -0.4], 0.2, bubble(210.0)),
        sphere("lamp", [0.0, 0.85, 0.0], 0.05, {"emitter": {"illuminant": "E", "radiance": 100.0}}),
    ]
    return {
        "version": 1,
        "camera": {"position": [0.0, 0.0, 3.6], "target": [0.0, 0.0, 0.0], "fov_deg": 40.0, "resolution": [size, size]},
        "render": {"max_depth": 16},
        "object": [*walls, *things],
        "light": [{"environment": {"illuminant": "E", "radiance": 0.0}}],
    }


SCENES = {"mesh": mesh_scene, "room": room_scene}


def prepare(folder: Path, name: str, size: int) -> None:
    """The scene as a file, with what it needs, and the tables of its films for the peer."""
    from geometry import SIDES, bumpy_sphere, write_ply
    from peer_film import table_of
    from studio import write_studio

    if name == "mesh":
        write_studio(folder)
        write_ply(folder / "bumpy.ply", *bumpy_sphere(SIDES))
    tree = SCENES[name](size)
    (folder / f"{name}.json").write_text(json.dumps(tree))
    for item in tree["object"]:
        if {"film", "coating"} & item["surface"].keys():
            table = {key: value for key, value in table_of(item["surface"]).items() if value is not None}
            np.savez(folder / f"{name}-{item['name']}.npz", **table)


def theirs(name: str, how: tuple[str, str], samples: int, seed: int, out: str) -> None:
    """The peer, in the folder of the scene and in a process of its own."""
    from peer_mitsuba import newest_llvm

    os.environ.setdefault("DRJIT_LIBLLVM_PATH", newest_llvm())
    import drjit as dr
    import mitsuba as mi

    dr.set_thread_count(2)
    mi.set_variant("llvm_ad_spectral")
    sampler, integrator = how
    tree = json.loads(Path(f"{name}.json").read_text())
    camera = tree["camera"]
    look = mi.ScalarTransform4f().look_at(origin=camera["position"], target=camera["target"], up=[0.0, 1.0, 0.0])
    side = camera["resolution"][0]
    picture = {"type": "hdrfilm", "width": side, "height": side, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    world: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": integrator, "max_depth": 17, "rr_depth": 16},
        "camera": {
            "type": "perspective",
            "fov": camera["fov_deg"],
            "to_world": look,
            "film": picture | {"component_format": "float32"},
            "sampler": {"type": sampler, "sample_count": min(samples, BATCH)},
        },
    }
    if name == "mesh":
        turn = mi.ScalarTransform4f([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
        back = mi.ScalarTransform4f([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
        world["sky"] = {"type": "envmap", "filename": "studio_zup.exr", "to_world": back @ turn}
    for item in tree["object"]:
        world[item["name"]] = their_shape(mi, name, item)
    scene = mi.load_dict(world)
    total, done = np.zeros((side, side, 3)), 0
    while done < samples:
        count = min(BATCH, samples - done)
        total += np.array(mi.render(scene, spp=count, seed=1000 * seed + done), dtype=np.float64)[..., :3] * count
        done += count
    np.save(out, total / samples)


def their_shape(mi: Any, name: str, item: dict[str, Any]) -> dict[str, Any]:
    ((kind, keys),) = item["shape"].items()
    told: dict[str, Any]
    if kind == "mesh":
        told = {"type": "ply", "filename": keys["file"], "face_normals": True}
    elif kind == "sphere":
        told = {"type": "sphere", "center": keys["center"], "radius": keys["radius"]}
    else:
        u, v = np.array(keys["u"], dtype=float), np.array(keys["v"], dtype=float)
        normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
        columns = np.stack([u, v, normal, np.array(keys["center"], dtype=float)], axis=1)
        told = {"type": "rectangle", "to_world": mi.ScalarTransform4f(np.vstack([columns, [0.0, 0.0, 0.0, 1.0]]))}
    ((kind, keys),) = item["surface"].items()
    if kind == "emitter":
        told["emitter"] = {"type": "area", "radiance": {"type": "spectrum", "value": keys["radiance"]}}
    elif kind == "diffuse":
        value = {"type": "spectrum", "value": keys["reflectance"]}
        told["bsdf"] = {"type": "diffuse", "reflectance": value}
    elif kind == "metal":
        eta, k = ({"type": "spectrum", "value": value} for value in keys["medium"])
        alpha = keys["roughness"] ** 2
        rough = {"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "eta": eta, "k": k}
        told["bsdf"] = {"type": "twosided", "bsdf": rough}
    else:
        film = exact_film(mi)
        with np.load(f"{name}-{item['name']}.npz") as table:
            rows = {key: table[key] if table[key].ndim else float(table[key]) for key in table.files}
        alpha = keys.get("roughness", 0.0) ** 2
        film.tell({"inside": None, **rows}, (alpha, alpha) if alpha else None)
        mi.register_bsdf(f"exact_film_{item['name']}", lambda _: film)
        told["bsdf"] = {"type": f"exact_film_{item['name']}"}
    return told


def ours(folder: Path, name: str, samples: int, seed: int, out: str) -> tuple[float, Floats, Any]:
    """Seconds of `iridesce render`, its picture in linear sRGB, and where objects are seen."""
    import iridesce as ir

    command = [sys.executable, "-m", "iridesce", "render", f"{name}.json", "-o", out, "--threads", "2"]
    seconds = timed([*command, "--samples", str(samples), "--seed", str(seed)], folder)
    image = ir.Image.load(folder / out)
    return seconds, np.asarray(ir.color.convert(image.xyz, "xyz", "linear-srgb")), image.channels["object"] >= 0


def timed(command: list[str], folder: Path) -> float:
    """Wall seconds of a whole process."""
    start = time.perf_counter()
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} left with {done.returncode}:\n{done.stderr}")
    return time.perf_counter() - start


def relative_mse(picture: Floats, reference: Floats, seen: NDArray[np.bool_]) -> float:
    return float(np.mean((picture[seen] - reference[seen]) ** 2 / (reference[seen] ** 2 + FLOOR)))


def measure(folder: Path, name: str, arguments: argparse.Namespace) -> None:
    prepare(folder, name, arguments.size)
    ways = [("independent", "path"), ("multijitter", "path")]
    if name == "room":
        ways += [("independent", "volpath")]

    def peer(way: tuple[str, str], samples: int, seed: int, out: str) -> float:
        command = [str(arguments.peer), str(HERE / "rough.py"), "--alone", name, *way, str(samples), str(seed), out]
        return timed(command, folder)

    count = dict(zip(("ours", "peer"), arguments.samples, strict=True)) if arguments.samples else SAMPLES[name]
    took: dict[Any, list[float]] = {}
    for _ in range(arguments.repeats):
        took.setdefault("iridesce", []).append(ours(folder, name, count["ours"], 1, "ours.exr")[0])
        for way in ways:
            took.setdefault(way, []).append(peer(way, count["peer"], 1, f"{'-'.join(way)}.npy"))
    _, picture, _ = ours(folder, name, count["ours"], 1, "ours.exr")
    _, other, _ = ours(folder, name, count["ours"], 2, "other.exr")
    _, wanted, seen = ours(folder, name, arguments.reference * count["ours"], 1001, "reference.exr")
    peer(ways[0], arguments.reference * count["peer"], 1001, "reference.npy")
    peer_wanted = np.load(folder / "reference.npy")
    means = [float(each[seen][:, 1].mean()) for each in (wanted, peer_wanted)]
    between = 0.5 * float(np.mean((picture[seen] - other[seen]) ** 2 / (wanted[seen] ** 2 + FLOOR)))
    print(f"\n{name}: mean of G here {means[0]:.4f}, there {means[1]:.4f}; relMSE here from two seeds {between:.3e}\n")
    print("| | samples a pixel | wall s | relMSE | efficiency |\n|---|---|---|---|---|")
    best: dict[str, float] = {}
    for way, seconds in took.items():
        side, title = ("ours", way) if way == "iridesce" else ("peer", " ".join(way))
        drawn = picture if side == "ours" else np.load(folder / f"{'-'.join(way)}.npy")
        error, wall = relative_mse(drawn, wanted if side == "ours" else peer_wanted, seen), statistics.median(seconds)
        best[side] = max(best.get(side, 0.0), 1.0 / (error * wall))
        print(f"| {title} | {count[side]} | {wall:.2f} | {error:.3e} | {1.0 / (error * wall):.3g} |", flush=True)
    print(f"\ntimes the peer: {best['ours'] / best['peer']:.1f}", flush=True)


def main() -> int:
    if "--alone" in sys.argv:
        name, sampler, integrator, samples, seed, out = sys.argv[2:]
        theirs(name, (sampler, integrator), int(samples), int(seed), out)
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", choices=[*SCENES, []], default=[])
    parser.add_argument("--peer", type=Path, required=True, help="a Python that has mitsuba")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument(
        "--reference", type=int, default=32, help="samples of the references over those of the pictures"
    )
    parser.add_argument("--samples", type=int, nargs=2, metavar=("OURS", "PEER"), help="samples a pixel of either side")
    parser.add_argument("--keep", type=Path, help="a folder for scenes and pictures")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as name:
        folder = (arguments.keep or Path(name)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        for scene in arguments.scenes or SCENES:
            measure(folder, scene, arguments)
    return 0


if __name__ == "__main__":
    sys.exit(main())
