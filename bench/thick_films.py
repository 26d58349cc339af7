"""How right the colours of thick films are: random stacks against sums in steps of 0.02 nm.

usage: thick_films.py [--stacks N] [--points N] [--seed N]

Each stack has one to three layers of built-in media (dispersive, some absorbing) on a medium of another kind; the
thicknesses are drawn evenly in their logarithm from 10 nm to 100 um, or evenly up to 100 um, the angles evenly below 85
degrees; lamps are continuous, have lines on a continuum, or lines alone. Shown is the greatest CIEDE2000 between
`Stack.color`, which refines its sum by itself, and the same sum forced to 0.02 nm, for each kind of lamp and number of
layers, and the stack that had it. Where they differ by more than 0.02, steps of 0.0025 nm decide, since three layers of
100 um at grazing light are finer than 0.02 nm too; the last line tells how far the 0.02 nm sums are from those. The fixed
1 nm sum stands beside it to show what the refinement is worth.
"""

from __future__ import annotations

import argparse
import warnings

import numpy as np

import iridesce as ir

MEDIA = ["soap", "SiO2", "MgF2", "TiO2", "Si3N4", "PMMA", "N-BK7", "sapphire-o", "ZnS", 1.38, 1.6 + 0.0005j, 2.1]
ENDS = ["air", "water", "N-BK7", "Si", "Al", 1.5, "air"]
LAMPS = {
    "continuous": ["D65", "A", "E", "C", "blackbody:3500", "LED-B3"],
    "lines on a continuum": ["FL2", "FL7", "FL11", "FL12"],
    "lines alone": ["lines:589.158*2,589.756", "laser:632.99", "lines:435.833,546.074*2,578.0"],
}
FINE_NM = np.linspace(360.0, 830.0, 23_501)
FINEST_NM = np.linspace(360.0, 830.0, 188_001)
DOUBTFUL = 0.02
COARSE_NM = np.linspace(360.0, 830.0, 471)


def one_stack(random: np.random.Generator, points: int) -> tuple[ir.Stack, np.ndarray, int]:
    """Layers with arrays of thicknesses, an angle for each point, the number of layers."""
    layers = int(random.integers(1, 4))
    media = [MEDIA[random.integers(len(MEDIA))] for _ in range(layers)]
    thickness = [
        10.0 ** random.uniform(1.0, 5.0, points) if random.random() < 0.3 else random.uniform(0.0, 1e5, points)
        for _ in range(layers)
    ]
    first = ["air", "air", "water"][random.integers(3)]
    last = ENDS[random.integers(len(ENDS))]
    stack = ir.Stack([first, *(ir.Layer(m, t) for m, t in zip(media, thickness, strict=True)), last])
    return stack, random.uniform(0.0, 85.0, points), layers


def main() -> None:
    """Draw, compare, print the worst."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stacks", type=int, default=300)
    parser.add_argument("--points", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random = np.random.default_rng(options.seed)
    warnings.simplefilter("ignore")
    worst: dict[tuple[str, int], tuple[float, str]] = {}
    fixed: dict[tuple[str, int], float] = {}
    count, reference = 0, 0.0
    for _ in range(options.stacks):
        stack, angle, layers = one_stack(random, options.points)
        polarization = ["unpolarized", "s", "p"][random.integers(3)]
        for kind, lamps in LAMPS.items():
            lamp = lamps[random.integers(len(lamps))]
            how = {"polarization": polarization, "illuminant": lamp, "space": "lab"}
            exact = stack.color(angle, **how, wavelength_nm=FINE_NM)
            own = stack.color(angle, **how)
            doubtful = np.flatnonzero(ir.color.delta_e(own, exact) > DOUBTFUL)
            for at in doubtful:
                layers_at = [ir.Layer(layer.medium, layer.thickness_nm[at]) for layer in stack.layers]
                one = ir.Stack([stack.first, *layers_at, stack.last])
                finest = one.color(angle[at], **how, wavelength_nm=FINEST_NM)
                reference = max(reference, float(ir.color.delta_e(exact[at], finest)))
                exact[at] = finest
            error = ir.color.delta_e(own, exact)
            key, at = (kind, layers), int(np.argmax(error))
            count += error.size
            text = " / ".join(
                f"{layer.medium.name} {np.atleast_1d(layer.thickness_nm)[at]:.1f}" for layer in stack.layers
            )
            where = f"{stack.first.name} / {text} / {stack.last.name}, {angle[at]:.2f} deg, {polarization}, {lamp}"
            worst[key] = max(worst.get(key, (0.0, "")), (float(error[at]), where))
            coarse = ir.color.delta_e(stack.color(angle, **how, wavelength_nm=COARSE_NM), exact)
            fixed[key] = max(fixed.get(key, 0.0), float(coarse.max()))
    print(f"{options.stacks} stacks, {count} colours, seed {options.seed}\n")
    print("| lamp | layers | CIEDE2000 | with fixed steps of 1 nm | where |\n|---|---|---|---|---|")
    for (kind, layers), (error, where) in sorted(worst.items()):
        print(f"| {kind} | {layers} | {error:.2g} | {fixed[kind, layers]:.2g} | {where} |")
    print(f"\nthe sums in steps of 0.02 nm are themselves off by up to {reference:.2g}")


if __name__ == "__main__":
    main()
