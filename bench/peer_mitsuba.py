"""The peer: the bench bubble in Mitsuba 3 with a user-written interference film; prints one JSON line.

usage: peer_mitsuba.py SAMPLES OUT.npy --environment studio_zup.exr
                       [--sampler multijitter|independent] [--seed N] [--size N] [--threads N]

Mitsuba 3.9 has no interference material, so this holds the one a determined user would add: the exact single film per
sampled wavelength, s and p averaged, mirror reflection or straight passage chosen by the mean reflectance. Everything
else is stock: path integrator, environment map with importance sampling, box filter, LLVM spectral variant. Run it
with the Python of an environment that has `mitsuba` and `numpy`, and with a system libLLVM.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import time
from pathlib import Path

START = time.perf_counter()


def newest_llvm() -> str:
    """DRJIT_LIBLLVM_PATH, or the newest system libLLVM; before 17 it cannot lower `fminimum` of Dr.Jit 1.5, and aborts."""
    if told := os.environ.get("DRJIT_LIBLLVM_PATH"):
        return told
    found = {}
    for path in Path("/usr/lib").glob("*/libLLVM*.so*"):
        version = re.match(r"libLLVM(?:-|\.so\.)(\d+)", path.name)
        if version:
            found[int(version[1])] = str(path)
    if not found or max(found) < 17:
        raise SystemExit("the peer needs libLLVM 17 or newer (Debian: libllvm19), or DRJIT_LIBLLVM_PATH set to one")
    return found[max(found)]


if "DRJIT_LIBLLVM_PATH" not in os.environ:
    os.environ["DRJIT_LIBLLVM_PATH"] = newest_llvm()

import drjit as dr  # noqa: E402  the library path above must be set first
import mitsuba as mi  # noqa: E402
import numpy as np  # noqa: E402

mi.set_variant("llvm_ad_spectral")

BATCH = 256  # camera rays per pixel and pass; a whole wavefront must fit in memory


class InterferenceFilm(mi.BSDF):
    """A free film in air; its thickness goes linearly from ``bottom_nm`` at z = -1 to ``top_nm`` at z = 1."""

    def __init__(self, properties: mi.Properties) -> None:
        mi.BSDF.__init__(self, properties)
        self.index = properties.get("index", 1.33)
        self.top_nm = properties.get("top_nm", 0.0)
        self.bottom_nm = properties.get("bottom_nm", 800.0)
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [mi.BSDFFlags.DeltaReflection | sides, mi.BSDFFlags.Null | sides]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def reflectance(self, hit: mi.SurfaceInteraction3f) -> mi.Spectrum:
        """Unpolarised reflectance at the hit's own wavelengths, angle and height.

        R = F sin^2(d / 2) / (1 + F sin^2(d / 2)), F = 4 r^2 / (1 - r^2)^2, d = 4 pi n t cos(theta_film) / lambda,
        per polarisation, r the amplitude of one face.
        """
        n = self.index
        outer = dr.abs(mi.Frame3f.cos_theta(hit.wi))
        inner = dr.sqrt(1.0 - (1.0 - outer * outer) / (n * n))
        thickness_nm = dr.lerp(self.bottom_nm, self.top_nm, 0.5 * hit.p.z + 0.5)
        wave = dr.square(dr.sin(2.0 * dr.pi * n * thickness_nm * inner / hit.wavelengths))

        def film(face: mi.Float) -> mi.Spectrum:
            finesse = 4.0 * dr.square(face) / dr.square(1.0 - dr.square(face))
            return finesse * wave / (1.0 + finesse * wave)

        s = film((outer - n * inner) / (outer + n * inner))
        p = film((n * outer - inner) / (n * outer + inner))
        return 0.5 * (s + p)

    def sample(self, context, hit, sample1, sample2, active=True):
        reflectance = self.reflectance(hit)
        chance = dr.mean(reflectance)
        reflected = sample1 < chance
        result = mi.BSDFSample3f()
        result.wo = dr.select(reflected, mi.reflect(hit.wi), -hit.wi)
        result.pdf = dr.select(reflected, chance, 1.0 - chance)
        result.eta = 1.0
        result.sampled_component = dr.select(reflected, mi.UInt32(0), mi.UInt32(1))
        result.sampled_type = dr.select(
            reflected, mi.UInt32(+mi.BSDFFlags.DeltaReflection), mi.UInt32(+mi.BSDFFlags.Null)
        )
        weight = dr.select(reflected, reflectance / chance, (1.0 - reflectance) / (1.0 - chance))
        return result, weight & (active & (result.pdf > 0))

    def eval(self, context, hit, direction, active=True):
        return mi.Spectrum(0.0)

    def pdf(self, context, hit, direction, active=True):
        return mi.Float(0.0)

    def eval_pdf(self, context, hit, direction, active=True):
        return mi.Spectrum(0.0), mi.Float(0.0)

    def to_string(self) -> str:
        return f"InterferenceFilm[index={self.index}, top_nm={self.top_nm}, bottom_nm={self.bottom_nm}]"


def bench_scene(environment: str, sampler: str, samples: int, size: int) -> dict:
    """The scene of README.md in Mitsuba's z-up world."""
    transform = mi.ScalarTransform4f
    y_up_to_z_up = transform([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    picture = {
        "type": "hdrfilm",
        "width": size,
        "height": size,
        "rfilter": {"type": "box"},
        "pixel_format": "rgb",
        "component_format": "float32",
    }
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 17, "rr_depth": 1000},  # 16 hits, then the environment; no roulette
        "environment": {"type": "envmap", "filename": environment, "to_world": y_up_to_z_up},
        "bubble": {"type": "sphere", "bsdf": {"type": "interference_film"}},
        "camera": {
            "type": "perspective",
            "fov": 35,
            "to_world": transform().look_at(origin=[0, -4, 0], target=[0, 0, 0], up=[0, 0, 1]),
            "film": picture,
            "sampler": {"type": sampler, "sample_count": min(samples, BATCH)},
        },
    }


def main() -> None:
    """Render and write linear sRGB, float32."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("samples", type=int)
    parser.add_argument("out")
    parser.add_argument("--environment", required=True)
    parser.add_argument("--sampler", default="multijitter", choices=["multijitter", "independent"])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()

    dr.set_thread_count(options.threads)
    mi.register_bsdf("interference_film", InterferenceFilm)
    scene = mi.load_dict(bench_scene(options.environment, options.sampler, options.samples, options.size))
    total = np.zeros((options.size, options.size, 3))
    done, seed = 0, options.seed * 1000
    while done < options.samples:
        samples = min(BATCH, options.samples - done)
        total += np.array(mi.render(scene, spp=samples, seed=seed), dtype=np.float64)[..., :3] * samples
        done, seed = done + samples, seed + 1
    np.save(options.out, (total / options.samples).astype(np.float32))
    seconds = time.perf_counter() - START
    print(json.dumps({"seconds": seconds, "rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))


if __name__ == "__main__":
    main()
