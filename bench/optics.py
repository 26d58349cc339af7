"""The speed of the optics beside other ways to the same numbers, in one run and in turn.

usage: optics.py [--repeats N] [--rust] [--out FILE]

film 471 x 90 x 200    unpolarised R of one film, float64, into a given array; million values a second
ten layers             unpolarised R of a mirror, 471 wavelengths x 90 angles x 10 thicknesses
thickness -> sRGB      full sums over 471 wavelengths under D65; million colours a second
table                  thickness and angle -> XYZ from `ir.ColorTable`, CIEDE2000 <= 0.1, at random points

Others: `tmm` (Byrnes), point by point as it is made; numpy in blocks that stay in the second cache, closed form for the film,
transfer matrices written out for the layers; `colour-science` for the colours, given numpy's spectra. Every other way is
first checked to give the same numbers. Each repeat visits every way once; shown are the median and the fastest, since other
work on a machine can only make a run longer, and the ratio of medians. ``--rust`` adds `cargo bench -p iridesce-optics`.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

import iridesce as ir

ROOT = Path(__file__).resolve().parent.parent
NM = np.linspace(360.0, 830.0, 471)
ANGLES = np.linspace(0.0, 89.0, 90)
FILM_NM = np.linspace(1.0, 2000.0, 200)
N_FILM = 1.33
LAYERS_NM = np.linspace(1.0, 100.0, 10)
MIRROR = [2.35 if j % 2 == 0 else 1.46 for j in range(10)]
GLASS = 1.52
COLOR_NM = np.linspace(0.0, 2000.0, 16_384)
TABLE_POINTS = 1 << 20

Way = tuple[Callable[[], object], float]  # what to time, and how many values it gives


# --- the film


def film_out() -> tuple[ir.Stack, np.ndarray]:
    """The film over all thicknesses, and an array for (wavelength, angle, thickness)."""
    out = np.zeros((NM.size, ANGLES.size, FILM_NM.size))
    return ir.Stack([1.0, ir.Layer(N_FILM, FILM_NM), 1.0]), out


def film_ours(threads: int) -> Way:
    """Reflectance into a given array."""
    stack, out = film_out()
    nm, angle = NM[:, None, None], ANGLES[:, None]
    return lambda: stack.reflectance(nm, angle, out=out, threads=threads), out.size


def film_numpy() -> Way:
    """R = F sin^2(d/2) / (1 + F sin^2(d/2)) of each polarisation; blocks of one wavelength, a buffer used again."""
    out = np.empty((NM.size, ANGLES.size, FILM_NM.size))
    cos = np.cos(np.radians(ANGLES))
    inside = np.sqrt(1.0 - (np.sin(np.radians(ANGLES)) / N_FILM) ** 2)
    squares = [((cos - N_FILM * inside) / (cos + N_FILM * inside)) ** 2]
    squares.append(((N_FILM * cos - inside) / (N_FILM * cos + inside)) ** 2)
    finesse = [(4.0 * r / (1.0 - r) ** 2)[:, None] for r in squares]
    path = 2.0 * np.pi * N_FILM * inside[:, None] * FILM_NM
    phase, other = np.empty(path.shape), np.empty(path.shape)

    def run() -> np.ndarray:
        for i, nm in enumerate(NM):
            np.multiply(path, 1.0 / nm, out=phase)
            np.sin(phase, out=phase)
            np.multiply(phase, phase, out=phase)
            for place, factor in enumerate(finesse):
                target = out[i] if place == 0 else other
                np.multiply(phase, factor, out=target)
                # x / (1 + x) = 1 - 1 / (1 + x) would lose digits where x is small
                np.divide(target, target + 1.0, out=target)
            out[i] += other
            out[i] *= 0.5
        return out

    return run, out.size


def film_tmm() -> Way:
    """One call a point and polarisation, on a few of the points."""
    import tmm

    points = [(nm, angle, t) for nm in NM[::157] for angle in ANGLES[::30] for t in FILM_NM[::20]]

    def run() -> list[float]:
        answer = []
        for nm, angle, t in points:
            both = [tmm.coh_tmm(p, [1.0, N_FILM, 1.0], [np.inf, t, np.inf], np.radians(angle), nm)["R"] for p in "sp"]
            answer.append(0.5 * sum(both))
        return answer

    return run, len(points)


# --- ten layers


def layers_ours(threads: int) -> Way:
    """All layers as thick as each other."""
    out = np.zeros((NM.size, ANGLES.size, LAYERS_NM.size))
    stack = ir.Stack([1.0, *(ir.Layer(n, LAYERS_NM) for n in MIRROR), GLASS])
    nm, angle = NM[:, None, None], ANGLES[:, None]
    return lambda: stack.reflectance(nm, angle, out=out, threads=threads), out.size


def layers_numpy() -> Way:
    """Real fields marched through the layers, (e, i h) -> (c e + s h / y, c h - y s e), in blocks of one wavelength."""
    out = np.empty((NM.size, ANGLES.size, LAYERS_NM.size))
    cos = np.cos(np.radians(ANGLES))[:, None]
    sine2 = np.sin(np.radians(ANGLES))[:, None] ** 2
    kz = {n: np.sqrt(n * n - sine2) for n in {*MIRROR, GLASS}}

    def run() -> np.ndarray:
        for i, nm in enumerate(NM):
            turned = {n: 2.0 * np.pi / nm * kz[n] * LAYERS_NM for n in set(MIRROR)}
            waves = {n: (np.cos(phase), np.sin(phase)) for n, phase in turned.items()}
            total: np.ndarray | None = None
            for is_p in (False, True):
                y = {n: (n * n / k if is_p else k) for n, k in kz.items()}
                first = 1.0 / cos if is_p else cos
                # Fields at the last interface are 1 and y: real and imaginary parts stay apart in clear layers.
                er, ei = np.ones((ANGLES.size, LAYERS_NM.size)), np.zeros((ANGLES.size, LAYERS_NM.size))
                hr, hi = np.broadcast_to(y[GLASS], er.shape).copy(), np.zeros(er.shape)
                for n in reversed(MIRROR):
                    c, s = waves[n]
                    up, down = s / y[n], s * y[n]
                    er, hi, ei, hr = c * er + up * hi, c * hi - down * er, c * ei - up * hr, c * hr + down * ei
                numerator = (first * er - hr) ** 2 + (first * ei - hi) ** 2
                reflectance = numerator / ((first * er + hr) ** 2 + (first * ei + hi) ** 2)
                total = reflectance if total is None else 0.5 * (total + reflectance)
            out[i] = total
        return out

    return run, out.size


def layers_tmm() -> Way:
    """One call a point and polarisation, on a few of the points."""
    import tmm

    points = [(nm, angle, t) for nm in NM[::157] for angle in ANGLES[::30] for t in LAYERS_NM[::3]]

    def run() -> list[float]:
        answer = []
        for nm, angle, t in points:
            n, d = [1.0, *MIRROR, GLASS], [np.inf, *([t] * 10), np.inf]
            both = [tmm.coh_tmm(p, n, d, np.radians(angle), nm)["R"] for p in "sp"]
            answer.append(0.5 * sum(both))
        return answer

    return run, len(points)


# --- colours


def color_ours(threads: int) -> Way:
    """Full sums to sRGB; the colour stage takes its threads from RAYON_NUM_THREADS, read at its first use."""
    stack = ir.Stack([1.0, ir.Layer(N_FILM, COLOR_NM), 1.0])
    if threads != int(os.environ.get("RAYON_NUM_THREADS", "0")):
        return lambda: None, 0.0
    return lambda: stack.color(space="srgb"), COLOR_NM.size


def spectra(thickness_nm: np.ndarray) -> np.ndarray:
    """R at normal incidence, (thickness, wavelength), in numpy."""
    r2 = ((1.0 - N_FILM) / (1.0 + N_FILM)) ** 2
    x = np.sin((2.0 * np.pi * N_FILM / NM) * thickness_nm[:, None])
    x *= x
    x *= 4.0 * r2 / (1.0 - r2) ** 2
    x /= x + 1.0
    return x


def srgb(linear: np.ndarray) -> np.ndarray:
    """The encoding of IEC 61966-2-1, negative values on the mirrored curve."""
    size = np.abs(linear)
    return np.sign(linear) * np.where(size <= 0.0031308, 12.92 * size, 1.055 * size ** (1.0 / 2.4) - 0.055)


def color_numpy() -> Way:
    """Blocks of 128 thicknesses, one matrix product with the weights, the same encoding."""
    power = ir.color.illuminant("D65").power(NM)
    cmf = ir.color.color_matching(NM)
    weights = power[:, None] * cmf / (power @ cmf[:, 1])
    to_rgb = np.asarray(ir.color.rgb_matrix("srgb"))
    weights = weights @ to_rgb.T
    out = np.empty((COLOR_NM.size, 3))

    def run() -> np.ndarray:
        for start in range(0, COLOR_NM.size, 128):
            block = slice(start, start + 128)
            out[block] = srgb(spectra(COLOR_NM[block]) @ weights)
        return out

    return run, COLOR_NM.size


def color_science() -> Way:
    """`colour.msds_to_XYZ` by plain sums on numpy's spectra, then `colour.XYZ_to_sRGB`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
    thickness = COLOR_NM[::16]
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    light = colour.SDS_ILLUMINANTS["D65"]

    def run() -> np.ndarray:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            values = colour.MultiSpectralDistributions(spectra(thickness).T, NM)
            xyz = colour.msds_to_XYZ(values, cmfs, light, method="Integration") / 100.0
            return np.asarray(colour.XYZ_to_sRGB(xyz))

    return run, thickness.size


# --- the table


def table_points() -> tuple[np.ndarray, np.ndarray]:
    """Random points: neighbours in the list are no neighbours in the table."""
    random = np.random.default_rng(1)
    return random.uniform(0.0, 2000.0, TABLE_POINTS), random.uniform(0.0, 80.0, TABLE_POINTS)


def table_ours(table: ir.ColorTable, threads: int) -> Way:
    """XYZ into a given array."""
    t, angle = table_points()
    out = np.zeros((TABLE_POINTS, 3))
    return lambda: table.color(t, angle, out=out, threads=threads), TABLE_POINTS


def table_numpy(table: ir.ColorTable) -> Way:
    """Bilinear in a table of 4096 thicknesses x 512 angles, 48 MiB: cruder, and larger than the caches."""
    grid = table.color(np.linspace(0.0, 2000.0, 4096), np.linspace(0.0, 80.0, 512)[:, None])
    t, angle = table_points()
    out = np.empty((TABLE_POINTS, 3))

    def run() -> np.ndarray:
        for start in range(0, TABLE_POINTS, 16_384):
            block = slice(start, start + 16_384)
            x, y = t[block] * (4095.0 / 2000.0), angle[block] * (511.0 / 80.0)
            i, j = np.minimum(x.astype(np.int64), 4094), np.minimum(y.astype(np.int64), 510)
            x, y = (x - i)[:, None], (y - j)[:, None]
            low, high = grid[j, i] * (1.0 - x) + grid[j, i + 1] * x, grid[j + 1, i] * (1.0 - x) + grid[j + 1, i + 1] * x
            out[block] = low * (1.0 - y) + high * y
        return out

    return run, TABLE_POINTS


# --- everything


def check() -> dict[str, float]:
    """The largest difference of each other way from ours: nobody is timed on another task."""
    film, layers = np.asarray(film_ours(2)[0]()), np.asarray(layers_ours(2)[0]())
    colors = ir.Stack([1.0, ir.Layer(N_FILM, COLOR_NM), 1.0]).color(space="srgb")
    few = {
        "film": film[::157, ::30, ::20].reshape(-1),
        "layers": layers[::157, ::30, ::3].reshape(-1),
    }
    found = {
        "film, numpy": np.abs(np.asarray(film_numpy()[0]()) - film).max(),
        "film, tmm": np.abs(np.asarray(film_tmm()[0]()) - few["film"]).max(),
        "ten layers, numpy": np.abs(np.asarray(layers_numpy()[0]()) - layers).max(),
        "ten layers, tmm": np.abs(np.asarray(layers_tmm()[0]()) - few["layers"]).max(),
        "sRGB, numpy": np.abs(np.asarray(color_numpy()[0]()) - colors).max(),
        # (It draws negative values out straight, we mirror the curve.)
        "sRGB, colour-science": np.abs(np.asarray(color_science()[0]()) - colors[::16])[colors[::16] >= 0.0].max(),
    }
    limits = {"sRGB, numpy": 1e-9, "sRGB, colour-science": 2e-3}  # colour-science has a matrix of four digits
    for name, difference in found.items():
        if not difference < limits.get(name, 1e-11):
            raise SystemExit(f"{name} differs by {difference}")
    return {name: float(difference) for name, difference in found.items()}


def colors_with(threads: int, repeats: int) -> list[float]:
    """Seconds of `color_ours` in a process of its own with that many threads."""
    command = [sys.executable, __file__, "--colors", str(repeats)]
    environment = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
    text = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    return [float(value) for value in json.loads(text)]


def timed(way: Callable[[], object]) -> float:
    """Wall seconds of one run."""
    start = time.perf_counter()
    way()
    return time.perf_counter() - start


def measure(repeats: int) -> dict[str, dict[str, float]]:
    """Median and fastest rate of every way, in millions a second."""
    start = time.perf_counter()
    table = ir.ColorTable(ir.Stack([1.0, ir.Layer(N_FILM, 0.0), 1.0]), (0.0, 2000.0), (0.0, 80.0))
    built = time.perf_counter() - start
    ways: dict[str, Way] = {
        "film 471 x 90 x 200: iridesce, 1 thread": film_ours(1),
        "film 471 x 90 x 200: iridesce, 2 threads": film_ours(2),
        "film 471 x 90 x 200: numpy in blocks": film_numpy(),
        "film 471 x 90 x 200: tmm": film_tmm(),
        "ten layers 471 x 90 x 10: iridesce, 1 thread": layers_ours(1),
        "ten layers 471 x 90 x 10: iridesce, 2 threads": layers_ours(2),
        "ten layers 471 x 90 x 10: numpy in blocks": layers_numpy(),
        "ten layers 471 x 90 x 10: tmm": layers_tmm(),
        "thickness -> sRGB: numpy in blocks": color_numpy(),
        "thickness -> sRGB: colour-science": color_science(),
        "table: iridesce, 1 thread": table_ours(table, 1),
        "table: iridesce, 2 threads": table_ours(table, 2),
        "table: numpy, bilinear": table_numpy(table),
    }
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    for way, _ in ways.values():
        way()  # warm
    for _ in range(repeats):
        for name, (way, _) in ways.items():
            seconds[name].append(timed(way))
    counts = {name: count for name, (_, count) in ways.items()}
    for threads in (1, 2):
        name = f"thickness -> sRGB: iridesce, {threads} thread{'s' if threads > 1 else ''}"
        seconds[name], counts[name] = colors_with(threads, 3 * repeats), COLOR_NM.size
    result = {
        name: {
            "median": counts[name] / statistics.median(times) / 1e6,
            "best": counts[name] / min(times) / 1e6,
        }
        for name, times in sorted(seconds.items())
    }
    result["table: built, seconds"] = {"median": built, "best": built}
    return result


def show(result: dict[str, dict[str, float]]) -> None:
    """A table, and how many times the others ours is."""
    print("| job | median, M/s | best, M/s | ours, one thread, is |\n|---|---|---|---|")
    for name, rates in result.items():
        job = name.split(":")[0]
        ours = result.get(f"{job}: iridesce, 1 thread")
        ratio = f"{ours['median'] / rates['median']:.3g} times as fast" if ours and "iridesce" not in name else ""
        print(f"| {name} | {rates['median']:.4g} | {rates['best']:.4g} | {ratio} |")


def main() -> None:
    """Check, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--rust", action="store_true", help="the Rust rows too (needs cargo and the sources)")
    parser.add_argument("--out", type=Path, default=ROOT / "target" / "bench" / "optics.json")
    parser.add_argument("--colors", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.colors:
        way, _ = color_ours(int(os.environ["RAYON_NUM_THREADS"]))
        way()
        print(json.dumps([timed(way) for _ in range(options.colors)]))
        return
    load = os.getloadavg()[0]
    differences = check()
    result = measure(options.repeats)
    print(f"load when begun {load:.2f}, when done {os.getloadavg()[0]:.2f}, medians of {options.repeats}\n")
    show(result)
    print("\nlargest differences: " + ", ".join(f"{name} {value:.1e}" for name, value in differences.items()))
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps({"rates": result, "differences": differences}, indent=2))
    if options.rust:
        subprocess.run(["cargo", "bench", "-p", "iridesce-optics", "--bench", "optics"], cwd=ROOT, check=True)


if __name__ == "__main__":
    main()
