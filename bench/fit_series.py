"""How well and how fast `ir.fit_series` follows a film in time.

    python bench/fit_series.py [--spectra 2500] [--films 1] [--seed 1]

A soap film that thins from 1 800 nm to some tens of nm, with thick patches that pass the spot, and bursts at the end; counts
under a lamp with two bumps that drifts by 2 %, its size changing by 10 % from one spectrum to the next, stray light, noise
1 % of the largest count. Right: within a quarter of a fringe and 4 %, or 3 nm. For each range of thickness: shares of
verdicts, right, right among clear, intervals of 95 % that hold the truth (all that were given), median error of the right ones.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import iridesce as ir

BANDS = ((20.0, 150.0), (150.0, 400.0), (400.0, 2500.0))


def series(count: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    nm = np.arange(450.0, 850.0, 1.3)
    t = np.linspace(0.0, 1.0, count)
    h = 1800.0 * np.exp(-random.uniform(3.2, 4.4) * t) + 20.0
    for _ in range(8):
        start, length = int(random.uniform(0.0, 0.9) * count), int(random.uniform(0.002, 0.02) * count) + 1
        h[start : start + length] *= random.uniform(1.1, 1.6)
    burst = int(0.97 * count)
    h[burst:] = 0.0
    lamp = 2e4 * np.exp(-(((nm - random.uniform(620.0, 700.0)) / random.uniform(180.0, 300.0)) ** 2))
    for _ in range(2):
        where, width = random.uniform(470.0, 830.0), random.uniform(18.0, 35.0)
        lamp = lamp * (1.0 + random.uniform(0.2, 0.6) * np.exp(-0.5 * ((nm - where) / width) ** 2))
    drift = 1.0 + 0.02 * np.sin(6.0 * t)[:, None] * np.sin(2.0 * np.pi * (nm - 450.0) / 500.0)
    film = ir.Stack(["air", ir.Layer("soap", h[:, None]), "air"]).reflectance(nm)
    size = np.exp(0.1 * random.standard_normal(count))[:, None]
    clean = size * lamp * drift * (film + random.uniform(0.0, 0.02))
    noise = 0.01 * float(clean.max())
    return nm, clean + noise * random.standard_normal(clean.shape), h


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spectra", type=int, default=2500)
    parser.add_argument("--films", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    wall, busy = [], []
    found, truth, held, verdict = [], [], [], []
    for film in range(chosen.films):
        nm, counts, h = series(chosen.spectra, np.random.default_rng([chosen.seed, film]))
        started, processor = time.perf_counter(), time.process_time()
        # The film's index and the wavelengths are the ones that the fit is told.
        exact = {"index_tolerance": 0.0, "wavelength_tolerance_nm": 0.0}
        result = ir.fit_series(nm, counts, "air / soap ? / air", **exact)
        wall.append(time.perf_counter() - started)
        busy.append(time.process_time() - processor)
        found.append(result.thickness_nm)
        truth.append(h)
        verdict.append(result.verdict)
        held.append((result.interval_nm[:, 0] <= h) & (h <= result.interval_nm[:, 1]))
    h, got, words, inside = (np.concatenate(one) for one in (truth, found, verdict, held))
    error = np.abs(got - h)
    right = error < np.minimum(600.0 / (8.0 * 1.33) + 0.01 * h, 0.04 * h + 3.0)
    print(f"{chosen.spectra} spectra: {np.mean(wall):.1f} s, {np.mean(busy):.1f} s of processor time")
    print("film, nm        clear  ambig  doubt   none  right  of clear  in 95 %  median %")
    for low, high in BANDS:
        part = (h >= low) & (h < high)
        if part.any():
            shares = [(words[part] == word).mean() for word in ("clear", "ambiguous", "doubtful", "none")]
            clear = part & (words == "clear")
            good = part & right
            middle = 100.0 * np.median(error[good] / h[good]) if good.any() else np.nan
            print(
                f"{low:5.0f} to {high:5.0f}  "
                + " ".join(f"{share:6.1%}" for share in shares)
                + f" {right[part].mean():6.1%} {right[clear].mean() if clear.any() else np.nan:8.1%}"
                + f" {inside[part & np.isfinite(got)].mean():8.1%} {middle:8.3f}"
            )
    burst = h == 0.0
    print(f"burst: none {np.mean(words[burst] == 'none'):.1%}, clear {np.mean(words[burst] == 'clear'):.1%}")


if __name__ == "__main__":
    main()
