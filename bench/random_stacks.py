"""Random stacks against the laws that hold for all: energy, reciprocity, a layer split in two; no NaN.

    pip install mpmath
    python bench/random_stacks.py [--count 1000000] [--seed 1]

1 to 12 layers, each with n from 0.05 to 5, k = 0 for half of the media and 1e-8 to 8 for the others, 0.1 nm to 100 um; first
medium n from 1 to 2.5, last one clear or absorbing; 0 to 89.9 degrees (total reflection included); s, p and unpolarised light;
a third of the stacks with incoherent slabs. Three evaluations of the same reflectance are compared as well: the kernels for
many wavelengths, the solver of one, and the solver with derivatives.

A deviation above 1e-12 is put beside what one unit in the last place of every input does to the value (first order, from the
analytic derivatives): the last column is the largest such ratio. Where it is some units, the inputs themselves are not known
better; the worst of each kind are computed again with 50 digits, unchanged and with one input moved by its last place.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from typing import Any

import mpmath
import numpy as np
import numpy.typing as npt

from iridesce import _core

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]
LIMIT = 1e-12
MOST_LAYERS = 12


@dataclass
class Stacks:
    """Many stacks of one number of layers."""

    n: Complexes
    """(stacks, layers + 2)"""
    d_nm: Floats
    """(stacks, layers)"""
    wavelength_nm: Floats
    angle_deg: Floats
    coherent: list[bool]
    polarization: str

    @property
    def layers(self) -> int:
        return self.d_nm.shape[1]

    def evaluate(self, quantity: str, width: int = 1) -> Any:
        """Through the kernels, all stacks in one call."""
        count = self.wavelength_nm.size
        out = np.empty(count * width)
        shape = [count]
        arguments = [self.wavelength_nm, self.angle_deg, *(np.ascontiguousarray(column) for column in self.d_nm.T)]
        _core.stack_evaluate(
            quantity,
            self.polarization,
            [np.ascontiguousarray(column) for column in self.n.T],
            list(range(self.layers + 2)),
            self.coherent,
            [(argument, [1]) for argument in arguments],
            shape,
            out,
            None,
            None,
        )
        return out.reshape(count, width) if width > 1 else out

    def derivatives(self, quantity: str) -> tuple[Floats, Floats]:
        """Values through the other solver, and what one unit in the last place of every input changes, summed."""
        count = self.wavelength_nm.size
        values, rows = np.empty((count, 1)), np.empty((count, 3 * self.layers + 3))
        _core.stack_derivatives(
            quantity, self.polarization, np.ascontiguousarray(self.n), np.ascontiguousarray(self.d_nm), self.coherent,
            self.wavelength_nm, self.angle_deg, values, rows,
        )  # fmt: skip
        steps = np.concatenate([np.spacing(self.d_nm), np.spacing(self.n.real), np.spacing(self.n.imag[:, 1:])], axis=1)
        # The wavelength acts as all thicknesses together.
        along = np.abs((rows[:, : self.layers] * self.d_nm).sum(axis=1)) / self.wavelength_nm
        return values[:, 0], np.abs(rows * steps).sum(axis=1) + along * np.spacing(self.wavelength_nm)

    def reversed(self) -> Stacks:
        """Seen from the other side, at the angle of the light there; only where that is real."""
        sine = self.n[:, 0].real * np.sin(np.radians(self.angle_deg)) / self.n[:, -1].real
        angle = np.degrees(np.arcsin(np.minimum(sine, 1.0)))
        return Stacks(
            np.ascontiguousarray(self.n[:, ::-1]), np.ascontiguousarray(self.d_nm[:, ::-1]), self.wavelength_nm, angle,
            self.coherent[::-1], self.polarization,
        )  # fmt: skip

    def split(self, which: int, share: float) -> Stacks:
        """One layer as two of the same medium; ``share`` times its thickness is exact."""
        first = share * self.d_nm[:, which]
        parts = np.stack([first, self.d_nm[:, which] - first], axis=1)
        return Stacks(
            np.insert(self.n, which + 1, self.n[:, which + 1], axis=1),
            np.concatenate([self.d_nm[:, :which], parts, self.d_nm[:, which + 1 :]], axis=1),
            self.wavelength_nm,
            self.angle_deg,
            [*self.coherent[: which + 1], *self.coherent[which:]],
            self.polarization,
        )

    def part(self, chosen: npt.NDArray[Any]) -> Stacks:
        return Stacks(
            self.n[chosen], self.d_nm[chosen], self.wavelength_nm[chosen], self.angle_deg[chosen], self.coherent,
            self.polarization,
        )  # fmt: skip


def random_stacks(random: np.random.Generator, count: int, layers: int) -> Stacks:
    shape = (count, layers + 2)
    n = np.exp(random.uniform(np.log(0.05), np.log(5.0), shape))
    k = np.where(random.random(shape) < 0.5, 0.0, np.exp(random.uniform(np.log(1e-8), np.log(8.0), shape)))
    n[:, 0], k[:, 0] = random.uniform(1.0, 2.5, count), 0.0
    d_nm = np.exp(random.uniform(np.log(0.1), np.log(1e5), (count, layers)))
    # Multiples of 2^-22 nm: halves and quarters and their sums are exact.
    d_nm = np.round(d_nm * 2.0**22) / 2.0**22
    slabs = random.random() < 1.0 / 3.0
    coherent = [not (slabs and random.random() < 0.4) for _ in range(layers)]
    return Stacks(
        n + 1j * k,
        d_nm,
        random.uniform(200.0, 2000.0, count),
        np.where(random.random(count) < 0.1, 0.0, random.uniform(0.0, 89.9, count)),
        coherent,
        str(random.choice(["s", "p", "unpolarized"])),
    )


@dataclass
class Law:
    """Deviations from one law."""

    name: str
    tested: int = 0
    worst: float = 0.0
    above: int = 0
    places: float = 0.0
    bad: int = 0
    case: tuple[Stacks, float] | None = field(default=None, repr=False)

    def add(self, deviation: Floats, allowed: Floats, stacks: Stacks) -> None:
        self.tested += deviation.size
        wrong = ~np.isfinite(deviation)
        self.bad += int(wrong.sum())
        size = np.where(wrong, 0.0, np.abs(deviation))
        above = size > LIMIT
        self.above += int(above.sum())
        if above.any():
            self.places = max(self.places, float((size[above] / np.maximum(allowed[above], 1e-300)).max()))
        if size.size and size.max() > self.worst:
            place = int(size.argmax())
            self.worst, self.case = float(size.max()), (stacks.part(np.array([place])), float(allowed[place]))


def exact_reflectance(stacks: Stacks, moved: int | None = None) -> mpmath.mpf:
    """R of the only stack in s or p light by recursive Airy summation, 50 digits; one thickness moved by its last place."""
    with mpmath.workdps(50):
        n = [mpmath.mpc(value.real, value.imag) for value in stacks.n[0]]
        d = [mpmath.mpf(float(value)) for value in stacks.d_nm[0]]
        if moved is not None:
            d[moved] += mpmath.mpf(float(np.spacing(stacks.d_nm[0, moved])))
        along = n[0] * mpmath.sin(mpmath.radians(mpmath.mpf(float(stacks.angle_deg[0]))))
        kz = [mpmath.sqrt(one * one - along * along) for one in n]
        kz = [-one if one.imag < 0 else one for one in kz]
        results = []
        for p in (False, True) if stacks.polarization == "unpolarized" else (stacks.polarization == "p",):
            q = [k / (one * one) if p else k for k, one in zip(kz, n, strict=True)]
            r = (q[-2] - q[-1]) / (q[-2] + q[-1])
            for j in range(len(n) - 3, -1, -1):
                turn = mpmath.exp(4j * kz[j + 1] * mpmath.pi * d[j] / float(stacks.wavelength_nm[0]))
                face = (q[j] - q[j + 1]) / (q[j] + q[j + 1])
                r = (face + r * turn) / (1 + face * r * turn)
            results.append(abs(r) ** 2)
        return sum(results) / len(results)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    random = np.random.default_rng(chosen.seed)
    energy, clear = Law("R + T + layers = 1"), Law("R + T = 1 without absorption")
    reciprocity, split_r, split_t = Law("T from both sides"), Law("R, a layer split"), Law("T, a layer split")
    roads_r, roads_t, bounds = Law("R, two solvers"), Law("T, two solvers"), Law("0 <= R, T <= 1")
    done, block = 0, 5000
    while done < chosen.count:
        count = min(block, chosen.count - done)
        layers = int(random.integers(1, MOST_LAYERS + 1))
        stacks = random_stacks(random, count, layers)
        if random.random() < 0.3:
            stacks.n = np.ascontiguousarray(stacks.n.real + 0j)
        r, t = stacks.evaluate("reflectance"), stacks.evaluate("transmittance")
        a = np.asarray(stacks.evaluate("layer_absorptance", layers)).reshape(count, layers)
        (r2, ulp_r), (t2, ulp_t) = stacks.derivatives("reflectance"), stacks.derivatives("transmittance")
        energy.add(r + t + a.sum(axis=1) - 1.0, ulp_r + ulp_t, stacks)
        bounds.add(np.maximum(np.maximum(-np.minimum(r, t), np.maximum(r, t) - 1.0), 0.0), ulp_r + ulp_t, stacks)
        lossless = (stacks.n.imag == 0.0).all(axis=1)
        clear.add((r + t - 1.0)[lossless], (ulp_r + ulp_t)[lossless], stacks.part(lossless))
        roads_r.add(r - r2, ulp_r, stacks)
        roads_t.add(t - t2, ulp_t, stacks)
        which, share = int(random.integers(layers)), float(random.choice([0.25, 0.5, 0.75]))
        halves = stacks.split(which, share)
        if stacks.coherent[which]:
            split_r.add(halves.evaluate("reflectance") - r, ulp_r, stacks)
            split_t.add(halves.evaluate("transmittance") - t, ulp_t, stacks)
        sine = stacks.n[:, 0].real * np.sin(np.radians(stacks.angle_deg))
        passes = (stacks.n[:, -1].imag == 0.0) & (sine < 0.999 * stacks.n[:, -1].real)
        if passes.any():
            there = stacks.part(passes)
            back = there.reversed()
            # The angle beyond is rounded: its last place counts as well, by a difference.
            moved = Stacks(
                back.n,
                back.d_nm,
                back.wavelength_nm,
                np.nextafter(back.angle_deg, 90.0),
                back.coherent,
                back.polarization,
            )
            t_back = back.evaluate("transmittance")
            wobble = np.abs(moved.evaluate("transmittance") - t_back)
            reciprocity.add(t_back - t[passes], ulp_t[passes] + 2.0 * wobble, there)
        done += count
    print(f"{done} stacks of 1 to {MOST_LAYERS} layers, seed {chosen.seed}")
    print(f"{'law':<30} {'tested':>9} {'NaN':>4} {'worst':>9} {'> 1e-12':>8} {'in last places':>15}")
    laws = [energy, clear, bounds, reciprocity, split_r, split_t, roads_r, roads_t]
    for law in laws:
        print(f"{law.name:<30} {law.tested:>9} {law.bad:>4} {law.worst:9.1e} {law.above:>8} {law.places:>15.1f}")
    for law in laws:
        if law.case is None or law.worst <= LIMIT:
            continue
        stacks, allowed = law.case
        print(f"worst of {law.name}: {law.worst:.1e}, all last places together {allowed:.1e}")
        if all(stacks.coherent):
            exact = exact_reflectance(stacks)
            moves = [float(abs(exact_reflectance(stacks, place) - exact)) for place in range(stacks.layers)]
            print(
                f"    50 digits: R = {mpmath.nstr(exact, 17)}, this program {float(stacks.evaluate('reflectance')[0]):.17g}; "
                f"one last place of one thickness moves it by up to {max(moves):.1e}"
            )
        print(f"    {stacks.polarization}, {stacks.angle_deg[0]:.17g} deg, {stacks.wavelength_nm[0]:.17g} nm")
        print(f"    coherent {stacks.coherent}")
        print(f"    n {stacks.n[0].tolist()}")
        print(f"    d_nm {stacks.d_nm[0].tolist()}")


if __name__ == "__main__":
    main()
