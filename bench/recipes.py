"""How well `ir.recipes` finds films, how true its yields are, how long it takes.

    python bench/recipes.py [--planted 1000] [--yields 40] [--times 10] [--seed 1]

Planted: films of one or two of ten media, of random thickness, on silicon, glass or titanium; their colour is the target. Found:
a recipe of the same media in the same order within CIEDE2000 0.05 whose layers are within 2 nm, or, where a layer hardly
shows (less than CIEDE2000 0.02 a nm), of any thickness. Yields: against the share of 100 000 pseudo-random normal draws of
exact colours. Times: a target for ten media, one and two layers, after the tables are built; wall and processor time.
"""

from __future__ import annotations

import argparse
import time
import warnings

import numpy as np

import iridesce as ir

MEDIA = ("SiO2", "TiO2", "MgF2", "Si3N4", "Al2O3", "Ta2O5", "HfO2", "PMMA", "ZnS", "polystyrene")
SUBSTRATES = ("Si", "N-BK7", "Ti")


def planted(count: int, random: np.random.Generator) -> None:
    found, lost = 0, []
    for _ in range(count):
        layers = int(random.integers(1, 3))
        media = [str(one) for one in random.choice(MEDIA, layers, replace=False)]
        substrate = str(random.choice(SUBSTRATES))
        h = random.uniform(5.0, 400.0, layers)
        stack = ir.Stack(["air", *(ir.Layer(m, float(t)) for m, t in zip(media, h, strict=True)), substrate])
        target = stack.color(space="lab")
        answers = ir.recipes(target, media=media, substrate=substrate, max_delta_e=0.5, count=None)
        for one in answers:
            same = [layer.medium.name for layer in one.stack.layers] == media
            near = zip(one.thickness_nm, h, one.delta_e_per_nm, strict=False)
            if same and one.delta_e < 0.05 and all(abs(a - b) < 2.0 or shows < 0.02 for a, b, shows in near):
                found += 1
                break
        else:
            lost.append(stack)
    print(f"planted: {found} of {count} found ({found / count:.1%})")
    for stack in lost:
        print(f"    lost: {stack}")


def yields(count: int, random: np.random.Generator) -> None:
    """Of random targets, recipes whose yields are between 3 and 97 %: against 100 000 draws."""
    errors, done = [], 0
    while done < count:
        media = [str(one) for one in random.choice(MEDIA, 2, replace=False)]
        substrate = str(random.choice(SUBSTRATES))
        h = random.uniform(30.0, 400.0, 2)
        stack = ir.Stack(["air", *(ir.Layer(m, float(t)) for m, t in zip(media, h, strict=True)), substrate])
        target, sigma = stack.color(space="lab"), float(random.choice([0.005, 0.01, 0.03]))
        for one in ir.recipes(target, media=media, substrate=substrate, sigma=sigma, count=4):
            if not 0.03 < one.yield_ < 0.97 or done >= count:
                continue
            drawn = [
                np.maximum(t * (1.0 + sigma * random.standard_normal(100_000)), 0.0).reshape(-1)
                for t in one.thickness_nm
            ]
            layers = [ir.Layer(layer.medium, t) for layer, t in zip(one.stack.layers, drawn, strict=True)]
            lab = ir.Stack([one.stack.first, *layers, one.stack.last]).color(space="lab")
            share = float((ir.color.delta_e(lab, target) <= 2.0).mean())
            errors.append(one.yield_ - share)
            done += 1
    size = 100.0 * np.abs(errors)
    # A share of 100 000 draws has a standard deviation of 0.16 points at most.
    print(f"yields: {count} recipes, off by {size.mean():.2f} points on average, {size.max():.2f} at most")


def times(count: int, random: np.random.Generator) -> None:
    started, busy = time.perf_counter(), time.process_time()
    ir.recipes([50.0, 0.0, 0.0], media=list(MEDIA), substrate="Si")
    print(f"tables: {time.perf_counter() - started:.1f} s, {time.process_time() - busy:.1f} s of processor time, once")
    wall, cpu, films = [], [], []
    for _ in range(count):
        target = [random.uniform(20.0, 80.0), *random.uniform(-35.0, 35.0, 2)]
        started, busy = time.perf_counter(), time.process_time()
        films.append(len(ir.recipes(target, media=list(MEDIA), substrate="Si")))
        wall.append(time.perf_counter() - started)
        cpu.append(time.process_time() - busy)
    print(
        f"a target: median {np.median(wall):.2f} s (processor {np.median(cpu):.2f} s), longest {max(wall):.2f} s "
        f"(processor {max(cpu):.2f} s)"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--planted", type=int, default=1000)
    parser.add_argument("--yields", type=int, default=40)
    parser.add_argument("--times", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)
    random = np.random.default_rng(chosen.seed)
    if chosen.times:
        times(chosen.times, random)
    if chosen.yields:
        yields(chosen.yields, random)
    if chosen.planted:
        planted(chosen.planted, random)


if __name__ == "__main__":
    main()
