"""Spectra as laboratories have them: how far the verdicts and the intervals of `ir.fit_thickness` can be believed.

    python bench/fit_hard.py [--each 20] [--seed 1] [--workers 2] [--family NAME]... [--rows rows.jsonl] [--verbose]

Every family has films of three stacks, 1.5 to 12 fringes over the spectrum unless it says otherwise, under noise of 1 % of the
brightest light; odd seeds a lamp that was never divided out (a bell with one or two bumps), even ones an even light, and one
fault:

lamp           nothing but the lamp, on every seed
spikes         3 to 8 channels that are 0.2 to 3 times the signal's range too high
drift          stray light of up to 0.4 of the mean, sloping and bowed
index          the film's index off by a random 1 % (sd), of which the fit is told nothing
one per cent   the film's index off by 1 %, up or down, of which it is told nothing
wavelengths    all wavelengths off by a random 0.3 nm (sd), of which it is told nothing
uneven         a thickness that varies over the spot by up to 1.5 % (sd), even or in a wedge
all            every one of these at once, lamp on every seed
thin           below one fringe, with stray light
empty          no film: a lamp's light, the bare base, a dark file with an offset
known drift    "drift", by a dark and a reference spectrum that has changed by 2 % since
known          "all", by a dark and a reference spectrum that has changed by 2 % since
known thin     from 15 nm to 0.8 fringes, so
known empty    no film, so

A fit is told what is known: `index_tolerance=0` where the film's index is that of the table, `wavelength_tolerance_nm=0` where
the wavelengths are right: its `interval_nm` is asked. Where they are not it is told nothing, and its `accuracy_interval_nm` is
asked, which holds 1 % of index and 0.3 nm of the wavelengths.

For each: how many spectra, the shares of verdicts, the share whose best film is right (within a quarter of a fringe and 4 %, or
3 nm), how many "clear" ones are right, and the shares of intervals of 68 % and of 95 % that hold the truth where the order is
right, each with the standard error of its share; last the median precision, which is that of noise and response
alone, in per cent of the thickness. Truths are made by the formula of a single layer, not by the core.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import iridesce as ir

Floats = npt.NDArray[np.float64]

# Text of the stack, wavelengths (first, last, step).
STACKS = {
    "soap": ("air / soap ? / air", (450.0, 850.0, 1.3)),
    "oxide": ("air / SiO2 ? / Si", (430.0, 900.0, 1.5)),
    "polymer": ("air / PMMA ? / Si", (470.0, 950.0, 1.6)),
}
FAMILIES = (
    *("lamp", "spikes", "drift", "index", "one per cent", "wavelengths", "uneven", "all"),
    *("thin", "empty", "known drift", "known", "known thin", "known empty"),
)
PROBABILITIES = (0.95, 0.68)


@dataclass
class Spectrum:
    """What is measured of one film, and the film."""

    wavelength_nm: Floats
    counts: Floats
    text: str
    truth_nm: float
    index: float
    options: dict[str, Any] = field(default_factory=dict)


@dataclass
class Row:
    """What a fit said of one spectrum."""

    family: str
    stack: str
    seed: int
    probability: float
    truth_nm: float
    found_nm: float
    sd_nm: float
    precision_nm: float
    verdict: str
    right: bool
    held: bool
    words: str


def bell(nm: Floats, random: np.random.Generator, bumps: int) -> Floats:
    """A lamp and a detector: a wide bell, and bumps of 18 to 35 nm sd and 20 to 60 %."""
    out = np.exp(-(((nm - random.uniform(600.0, 720.0)) / random.uniform(200.0, 400.0)) ** 2))
    for _ in range(bumps):
        size, where = random.uniform(0.2, 0.6), random.uniform(nm[0], nm[-1])
        out = out * (1.0 + size * np.exp(-0.5 * ((nm - where) / random.uniform(18.0, 35.0)) ** 2))
    return np.asarray(out)


def film(stack: ir.Stack, nm: Floats, thickness_nm: Floats, weights: Floats, off: float) -> Floats:
    """Reflectance of a single layer at normal incidence, a mean over thicknesses, its index ``1 + off`` times the table's."""
    above, inside, below = (np.broadcast_to(np.asarray(medium.index(nm)), nm.shape) for medium in stack.media)
    inside = inside * (1.0 + off)
    first, second = (above - inside) / (above + inside), (inside - below) / (inside + below)
    turn = np.exp(4j * np.pi * inside * thickness_nm[:, None] / nm)
    return np.asarray(weights @ np.abs((first + second * turn) / (1.0 + first * second * turn)) ** 2)


def spread(kind: str, random: np.random.Generator) -> tuple[Floats, Floats]:
    """Thicknesses over the spot, in units of their standard deviation, and their weights."""
    if random.random() < 0.5:
        nodes, weights = np.polynomial.hermite_e.hermegauss(21)
    else:
        nodes, weights = np.polynomial.legendre.leggauss(21)
        nodes = nodes * math.sqrt(3.0)
    return np.asarray(nodes) * (kind in ("uneven", "all", "known")), np.asarray(weights / weights.sum())


def thickness(kind: str, random: np.random.Generator, nm: Floats, n: float) -> float:
    """By the number of fringes over the spectrum, evenly in the logarithm."""
    fringe = 1.0 / (2.0 * n * (1.0 / nm[0] - 1.0 / nm[-1]))  # nm of film for one fringe
    low, high = {"thin": (0.1 * fringe, 0.8 * fringe), "known thin": (15.0, 0.8 * fringe)}.get(
        kind, (1.5 * fringe, 12.0 * fringe)
    )
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def spectrum(family: str, name: str, seed: int) -> Spectrum:
    """One of a family."""
    random = np.random.default_rng([seed, *family.encode(), *name.encode()])
    text, (first, last, step) = STACKS[name]
    nm = np.arange(first, last, step)
    stack = ir.Stack.parse(text.replace("?", "1"))
    n = float(np.real(stack.layers[0].medium.index(600.0)))
    every = family in ("all", "known", "known thin")
    truth = thickness(family, random, nm, n)
    off = 0.01 * random.standard_normal() * (family == "index" or every)
    if family == "one per cent":
        off = 0.01 * random.choice([-1.0, 1.0])
    shift = 0.3 * random.standard_normal() * (family == "wavelengths")
    nodes, weights = spread(family, random)
    uneven = random.uniform(0.0, 0.015 if family == "uneven" else 0.006)
    clean = film(stack, nm + shift, truth * (1.0 + uneven * nodes), weights, off)
    if "empty" in family:
        bare = film(stack, nm, np.zeros(1), np.ones(1), 0.0)
        clean = bare if bare.max() > 1e-3 else np.full(nm.size, 0.01)
    lamp = seed % 2 == 1 or family in ("lamp", "all", "thin", "empty") or family.startswith("known")
    light = bell(nm, random, int(random.integers(1, 3))) if lamp else np.ones(nm.size)
    x = np.linspace(-1.0, 1.0, nm.size)
    drift = 1.0 + random.uniform(-0.7, 0.7) * x + random.uniform(-0.3, 0.3) * (x * x - 0.3)
    drifts = family in ("drift", "known drift")
    amount = {"drift": 0.4, "known drift": 0.4, "all": 0.3, "thin": 0.3, "empty": 0.3}.get(family, 0.0)
    stray = random.uniform(0.0, amount) * float(clean.mean()) * (drift if drifts or family == "all" else 1.0)
    seen = light * clean + (1.0 if drifts else light) * stray
    if family == "empty" and seed % 3 == 0:
        seen = np.full(nm.size, float(clean.mean()))  # a dark file
    noise = 0.01 * float(np.max(light) * clean.mean()) * (0.3 + np.sqrt(light / light.max()))
    scale = float(np.exp(random.uniform(4.0, 10.0)))
    counts = scale * (seen + noise * random.standard_normal(nm.size))
    options: dict[str, Any] = {"probability": PROBABILITIES[seed // 2 % 2]}
    if off == 0.0:
        options["index_tolerance"] = 0.0
    if shift == 0.0:
        options["wavelength_tolerance_nm"] = 0.0
    if family.startswith("known"):
        # The reference was taken on the same lamp; since then it has changed by 2 %, smoothly.
        change = 1.0 + 0.02 * np.sin(2.0 * np.pi * (nm - random.uniform(400.0, 900.0)) / random.uniform(300.0, 900.0))
        options["dark"] = 200.0 + 2.0 * random.standard_normal(nm.size)
        options["reference"] = scale * light * change + 200.0 + scale * noise * random.standard_normal(nm.size)
        counts = counts + 200.0
    if family in ("spikes", "all", "known"):
        where = random.choice(nm.size, int(random.integers(3, 9)), replace=False)
        counts[where] += scale * float(np.ptp(seen) + 1e-3) * random.uniform(0.2, 3.0, where.size)
    return Spectrum(nm, counts, text, truth, n, options)


def one(task: tuple[str, str, int]) -> Row:
    """The fit of one spectrum."""
    family, name, seed = task
    of = spectrum(family, name, seed)
    row = Row(
        family,
        name,
        seed,
        of.options["probability"],
        of.truth_nm,
        math.nan,
        math.nan,
        math.nan,
        "error",
        False,
        False,
        "",
    )
    try:
        result: Any = ir.fit_thickness(of.wavelength_nm, of.counts, of.text, **of.options)
    except ValueError as error:
        row.words = str(error)
        return row
    row.verdict, row.words = (
        result.verdict,
        f"none {result.no_film:.3f} other {result.other:.3f} " + "; ".join(result.notes),
    )
    if result.best is None:
        return row
    best = result.best
    row.found_nm, row.sd_nm, row.precision_nm = best.thickness_nm, best.sd_nm, best.precision_nm
    near = min(600.0 / (8.0 * of.index) + 0.01 * of.truth_nm, 0.04 * of.truth_nm + 3.0)
    row.right = abs(best.thickness_nm - of.truth_nm) < near and "empty" not in family
    told = {"index_tolerance", "wavelength_tolerance_nm"} <= of.options.keys()
    low, high = best.interval_nm if told else best.accuracy_interval_nm
    row.held = low <= of.truth_nm <= high
    row.words = f"weight {best.weight:.3f} kappa {best.kappa:g} line {best.resolution_nm:.2f} " + row.words
    return row


def share(hits: int, of: int) -> str:
    """A share and its standard error (of one more hit and one more miss, so that neither end is without error)."""
    if of == 0:
        return "-"
    p = (hits + 1) / (of + 2)
    return f"{hits}/{of} {hits / of:.1%} ±{math.sqrt(p * (1.0 - p) / (of + 3)):.1%}"


def line(name: str, rows: list[Row]) -> str:
    """One line of the table."""
    clear = [row for row in rows if row.verdict == "clear"]
    words = [
        f"{sum(row.verdict == word for row in rows) / len(rows):5.0%}"
        for word in ("clear", "ambiguous", "doubtful", "none")
    ]
    held = []
    for level in (0.68, 0.95):
        of = [row for row in rows if row.right and row.probability == level]
        held.append(share(sum(row.held for row in of), len(of)))
    right = sum(row.right for row in rows) / len(rows)
    told = share(sum(row.right for row in clear), len(clear))
    precise = [100.0 * row.precision_nm / row.truth_nm for row in rows if row.right]
    middle = f"{np.median(precise):.3f}" if precise else "-"
    return f"{name:<13}{len(rows):5} {' '.join(words)} {right:6.0%}  {told:<22}{held[0]:<22}{held[1]:<22}{middle}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=20, help="spectra of each family and stack")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=1, help="processes, at the lowest priority but nine")
    parser.add_argument("--family", action="append", choices=FAMILIES)
    parser.add_argument("--rows", type=Path, help="append what every fit said to this file, a line of JSON each")
    parser.add_argument("--table", action="store_true", help="only the table of what stands in --rows")
    parser.add_argument("--verbose", action="store_true")
    chosen = parser.parse_args()
    rows: list[Row] = []
    if chosen.table:
        rows = [Row(**json.loads(text)) for text in chosen.rows.read_text().splitlines()]
    else:
        families = chosen.family or FAMILIES
        # One of each family in turn: a run that is cut short has seen all of them.
        tasks = [(family, name, chosen.seed + i) for i in range(chosen.each) for name in STACKS for family in families]
        started = time.perf_counter()
        with multiprocessing.get_context("spawn").Pool(chosen.workers, os.nice, (10,)) as pool:
            for row in pool.imap(one, tasks):
                rows.append(row)
                if chosen.rows is not None:
                    with chosen.rows.open("a") as file:
                        file.write(json.dumps(asdict(row)) + "\n")
        print(f"{len(rows)} spectra in {time.perf_counter() - started:.0f} s")
    words = "family       count clear ambig doubt  none  right"
    print(f"{words}  {'right of clear':<22}{'in 68 %':<22}{'in 95 %':<22}precision %")
    for family in FAMILIES:
        of = [row for row in rows if row.family == family]
        if not of:
            continue
        print(line(family, of))
        if chosen.verbose:
            for row in of:
                if (row.verdict == "clear" and not row.right) or (
                    not row.right and "thin" not in family and "empty" not in family
                ):
                    print(
                        f"    {row.stack} {row.seed} {row.verdict}: {row.truth_nm:.1f} nm, found {row.found_nm:.1f} "
                        f"+- {row.sd_nm:.2f}: {row.words[:150]}"
                    )
    wide = [row for row in rows if not any(word in row.family for word in ("empty", "thin"))]
    for name, of in (
        ("> 1.5 fringes", wide),
        *(
            (
                f"  {light}",
                [
                    row
                    for row in wide
                    if (row.seed % 2 == 1 or row.family in ("lamp", "all")) == (light == "lamp")
                    and "known" not in row.family
                ],
            )
            for light in ("lamp", "even")
        ),
        ("all", rows),
    ):
        if of:
            print(line(name, of))


if __name__ == "__main__":
    main()
