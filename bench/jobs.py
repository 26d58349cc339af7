"""Four jobs as users would say them, in one process: cold (first call) and warm (median of the rest).

usage: jobs.py [--repeats N]

spectrum_1_layer     reflectance of one soap film, 200 wavelengths x 500 thicknesses x 20 angles; spectra a second
stack_20_layers      reflectance of a 20-layer mirror, 2000 wavelengths x 50 angles; spectra of 200 wavelengths a second
chart_1024x1024      colours of 1024 thicknesses x 1024 angles of a soap film, exact sums; colours per second
bubble_512_64spp     the built-in bubble, 512 x 512 at 64 samples; camera rays per second
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Callable

import numpy as np

import iridesce as ir


def spectrum_1_layer(threads: int | None) -> float:
    """Spectra of 200 wavelengths."""
    thickness_nm = np.linspace(0.0, 2000.0, 500)[:, None, None]
    angle_deg = np.linspace(0.0, 85.0, 20)[None, :, None]
    film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=thickness_nm), "air"])
    return film.reflectance(np.linspace(380.0, 780.0, 200), angle_deg=angle_deg, threads=threads).size / 200


def stack_20_layers(threads: int | None) -> float:
    """Spectra of 200 wavelengths."""
    layers = [ir.Layer(2.35 if i % 2 == 0 else 1.46, thickness_nm=58.5 if i % 2 == 0 else 94.2) for i in range(20)]
    mirror = ir.Stack(["air", *layers, 1.52])
    angle_deg = np.linspace(0.0, 85.0, 50)[:, None]
    return mirror.reflectance(np.linspace(380.0, 780.0, 2000), angle_deg=angle_deg, threads=threads).size / 200


def chart_1024x1024(threads: int | None) -> float:
    """Colours."""
    thickness_nm = np.linspace(0.0, 2000.0, 1024)[:, None]
    film = ir.Stack(["air", ir.Layer("soap", thickness_nm=thickness_nm), "air"])
    return film.color(angle_deg=np.linspace(0.0, 89.0, 1024)[None, :]).size / 3


def bubble_512_64spp(threads: int | None) -> float:
    """Camera rays."""
    return ir.render("soap-bubble", samples=64, size=(512, 512), threads=threads).xyz.size / 3 * 64


JOBS: dict[str, tuple[Callable[[int | None], float], str]] = {
    "spectrum_1_layer": (spectrum_1_layer, "spectra/s"),
    "stack_20_layers": (stack_20_layers, "spectra/s"),
    "chart_1024x1024": (chart_1024x1024, "colours/s"),
    "bubble_512_64spp": (bubble_512_64spp, "camera rays/s"),
}


def measure(repeats: int) -> dict[str, dict[str, float | str]]:
    """Cold seconds, warm median and spread, and the rate of the warm median, of every job on all threads."""
    results: dict[str, dict[str, float | str]] = {}
    for name, (job, unit) in JOBS.items():
        seconds = []
        for _ in range(repeats + 1):
            start = time.perf_counter()
            amount = job(None)
            seconds.append(time.perf_counter() - start)
        warm = seconds[1:]
        results[name] = {
            "cold_s": seconds[0],
            "warm_s": statistics.median(warm),
            "spread_s": max(warm) - min(warm),
            "rate": amount / statistics.median(warm),
            "unit": unit,
        }
    return results


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=3)
    print(json.dumps(measure(parser.parse_args().repeats), indent=2))
