"""The peer of caustics.py: the ball's caustic in Mitsuba 3; prints one JSON line a picture.

usage: peer_caustics.py INTEGRATOR SAMPLES OUT.npy [--seeds N] [--threads N] [--radius R]

INTEGRATOR is `path`, or `ptracer` (rays from the lamp), which knows no parallel view: its camera stands 300 units away.
Stock integrators, box filter, grey light in the variant `llvm_ad_rgb`, the cheapest that holds it. The first picture, which
pays for the kernel, is not counted. Run it with the Python of an environment that has `mitsuba` and `numpy`, and with a
system libLLVM.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import time
from pathlib import Path

if "DRJIT_LIBLLVM_PATH" not in os.environ:
    found = {}
    for library in Path("/usr/lib").glob("*/libLLVM*.so*"):
        version = re.match(r"libLLVM(?:-|\.so\.)(\d+)", library.name)
        if version:
            found[int(version[1])] = str(library)
    if not found or max(found) < 17:
        raise SystemExit("the peer needs libLLVM 17 or newer (Debian: libllvm19), or DRJIT_LIBLLVM_PATH set to one")
    os.environ["DRJIT_LIBLLVM_PATH"] = found[max(found)]

import drjit as dr  # the library path above must be set first
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

BATCH = 4096  # samples per pixel and pass; a whole wavefront must fit in memory
AWAY = 100.0


def bench_scene(integrator: str, radius: float) -> dict:
    """The scene of caustics.py."""
    transform = mi.ScalarTransform4f
    grey = {"type": "rgb", "value": 0.5}
    radiance = {"type": "rgb", "value": 1.0 / (np.pi * radius**2)}
    picture = {
        "type": "hdrfilm",
        "width": 24,
        "height": 8,
        "rfilter": {"type": "box"},
        "pixel_format": "luminance",
        "component_format": "float32",
    }
    look = transform().look_at(origin=[3, 1, 0], target=[0, 0, 0], up=[0, 1, 0])
    camera = {"type": "orthographic", "to_world": look.scale([0.09, 0.09, 1.0]), "film": picture}
    if integrator == "ptracer":
        far = AWAY * 10.0**0.5
        look = transform().look_at(origin=[3 * AWAY, AWAY, 0], target=[0, 0, 0], up=[0, 1, 0])
        fov = float(2.0 * np.degrees(np.arctan(0.09 / far)))
        camera = {"type": "perspective", "fov": fov, "fov_axis": "x", "near_clip": 1.0, "far_clip": 1e4}
        camera |= {"to_world": look, "film": picture}
    return {
        "type": "scene",
        "integrator": {"type": integrator, "max_depth": 12},
        "floor": {
            "type": "rectangle",
            "to_world": transform().rotate([1, 0, 0], -90).scale(50),
            "bsdf": {"type": "diffuse", "reflectance": grey},
        },
        "ball": {
            "type": "sphere",
            "center": [0, 1.2, 0],
            "radius": 0.5,
            "bsdf": {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0},
        },
        "lamp": {
            "type": "sphere",
            "center": [0, 4, 0],
            "radius": radius,
            "emitter": {"type": "area", "radiance": radiance},
        },
        "camera": camera,
    }


def main() -> None:
    """Render and write the luminances of all pictures, float32."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("integrator", choices=["path", "ptracer"])
    parser.add_argument("samples", type=int)
    parser.add_argument("out")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--radius", type=float, default=0.001)
    options = parser.parse_args()
    dr.set_thread_count(options.threads)
    scene = mi.load_dict(bench_scene(options.integrator, options.radius))
    pictures = []
    for seed in range(options.seeds + 1):
        start = time.perf_counter()
        total, done = np.zeros((8, 24)), 0
        while done < options.samples:
            samples = min(BATCH, options.samples - done)
            number = 1000 * seed + done // BATCH
            total += np.array(mi.render(scene, spp=samples, seed=number), dtype=np.float64)[..., 0] * samples
            done += samples
        if seed > 0:
            pictures.append(total / options.samples)
            print(json.dumps({"seconds": time.perf_counter() - start}), flush=True)
    np.save(options.out, np.array(pictures, dtype=np.float32))


if __name__ == "__main__":
    main()
