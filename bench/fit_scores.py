"""How well `ir.fit_thickness` finds thicknesses: synthetic spectra with noise, blur, unknown gain and baseline.

    python bench/fit_scores.py [--each 1000] [--seed 1] [--snr 40] [--low 50] [--high 5000] [--workers 2]

For each system: the share of spectra whose best solution is of the right order (within a quarter of the wavelength in the
film), the share whose true thickness is among the plausible solutions, the median and the worst error of the right ones, the
share of 95 % and of 68 % intervals that hold the truth (asked of every other spectrum), and the time a fit. Noise of
``--snr`` dB is 10^(-snr/20) times the standard deviation of the spectrum along the wavelengths (that is its fringes, not its
mean, which is the harder reading).
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from typing import Any

import numpy as np

import iridesce as ir

# Name: text of the stack, first and last wavelength, step, full width of the instrument's line, and the thickest film (nm).
SYSTEMS: dict[str, tuple[str, float, float, float, float, float]] = {
    "soap film": ("air / soap ? / air", 420.0, 760.0, 1.0, 0.0, 5000.0),
    "soap film, 2 nm line": ("air / soap ? / air", 420.0, 760.0, 1.0, 2.0, 5000.0),
    "oxide on silicon, 2 nm line": ("air / SiO2 ? / Si", 400.0, 900.0, 0.8, 2.0, 5000.0),
    "resist on silicon, 5 nm line": ("air / 1.62 ? / Si", 450.0, 850.0, 1.0, 5.0, 5000.0),
    "PMMA on N-SF11, 1 nm line": ("air / PMMA ? / N-SF11", 460.0, 1000.0, 1.0, 1.0, 5000.0),
    "PMMA on N-BK7, 1 nm line": ("air / PMMA ? / N-BK7", 460.0, 1000.0, 1.0, 1.0, 5000.0),
    "oxide on titanium": ("air / TiO2 ? / Ti", 400.0, 700.0, 1.0, 0.0, 400.0),
}


PROBABILITIES = (0.95, 0.68)


def one(task: tuple[str, int, float, float, float]) -> tuple[float, float, bool, bool, bool, float]:
    """One spectrum: error, true thickness, right order, truth among the solutions, truth in the best interval, seconds."""
    name, seed, snr, low, high = task
    text, first, last, step, line_nm, thickest = SYSTEMS[name]
    random = np.random.default_rng([seed, *name.encode()])
    wavelength_nm = np.arange(first, last, step)
    thickness_nm = float(random.uniform(low, min(high, thickest)))
    stack = ir.Stack.parse(text.replace("?", repr(thickness_nm)))
    if line_nm > 0.0:
        clean = stack.reflectance_averaged(wavelength_nm, resolution_nm=line_nm, tolerance=1e-7).value
    else:
        clean = stack.reflectance(wavelength_nm)
    noise = np.std(clean) * 10.0 ** (-snr / 20.0) * random.standard_normal(wavelength_nm.size)
    gain = float(np.exp(random.uniform(-2.0, 3.0)))
    measured = gain * (clean + noise + random.uniform(0.0, 0.02))
    started = time.perf_counter()
    probability = PROBABILITIES[seed % 2]
    # The film's index and the wavelengths are the ones that the fit is told.
    exact = {"index_tolerance": 0.0, "wavelength_tolerance_nm": 0.0}
    result: Any = ir.fit_thickness(wavelength_nm, measured, text, probability=probability, **exact)
    seconds = time.perf_counter() - started
    n = float(np.real(stack.layers[0].medium.index(0.5 * (first + last))))
    error = abs(result.best.thickness_nm - thickness_nm)
    right = error < 0.5 * (first + last) / (4.0 * n)
    among = any(abs(solution.thickness_nm - thickness_nm) < 0.5 * (first + last) / (4.0 * n) for solution in result)
    held = result.best.interval_nm[0] <= thickness_nm <= result.best.interval_nm[1]
    return error, thickness_nm, bool(right), bool(among), bool(held), seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--snr", type=float, default=40.0)
    parser.add_argument("--low", type=float, default=50.0)
    parser.add_argument("--high", type=float, default=5000.0)
    parser.add_argument("--workers", type=int, default=1)
    chosen = parser.parse_args()
    print(
        f"{'system':<30} {'right':>8} {'among':>8} {'median nm':>10} {'worst nm':>9} {'in 95 %':>8} {'in 68 %':>8} {'s':>6}"
    )
    with multiprocessing.get_context("spawn").Pool(chosen.workers) as pool:
        for name in SYSTEMS:
            tasks = [(name, chosen.seed + 7919 * i, chosen.snr, chosen.low, chosen.high) for i in range(chosen.each)]
            found = pool.map(one, tasks, chunksize=8)
            even = np.array([task[1] % 2 == 0 for task in tasks])
            errors, thickness, right, among, held, seconds = (np.array(column) for column in zip(*found, strict=True))
            print(
                f"{name:<30} {right.mean():8.2%} {among.mean():8.2%} {np.median(errors):10.3f} {errors[right].max():9.2f} "
                f"{held[even].mean():8.2%} {held[~even].mean():8.2%} {seconds.mean():6.2f}",
                flush=True,
            )
            for place in np.flatnonzero(~right):
                print(f"    wrong: {thickness[place]:.2f} nm, off by {errors[place]:.2f} (seed {tasks[place][1]})")


if __name__ == "__main__":
    main()
