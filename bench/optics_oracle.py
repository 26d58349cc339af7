"""Fresh random reference vectors in arbitrary precision, held against the installed package.

    pip install mpmath
    python bench/optics_oracle.py [--seed N] [--each N]

Two routes that share no formula with each other nor the package's scaling: recursive Airy summation from the exit side
for r and t, and characteristic matrices for the fluxes; they must agree to 1e-25. Inputs are doubles taken as exact.
Prints the worst error of every category over what the pass rule of `optics_reference.json` allows; exit code 1 beyond.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from mpmath import asin, atan2, conj, cos, exp, fabs, log10, mp, mpc, mpf, pi, sin, sqrt

import iridesce as ir

Index = tuple[float, float]
WORKING_DIGITS = 60


@dataclass
class Case:
    """One stack with light: indices (first to last), thicknesses, wavelength, angle."""

    category: str
    n: list[Index]
    d_nm: list[float]
    wavelength_nm: float
    angle_deg: float
    slabs: set[int] = field(default_factory=set)  # incoherent layers, by position in d_nm

    def stack(self) -> ir.Stack:
        media = [complex(*n) if n[1] else n[0] for n in self.n]
        layers = [
            ir.Layer(medium, d, coherent=j not in self.slabs)
            for j, (medium, d) in enumerate(zip(media[1:-1], self.d_nm, strict=True))
        ]
        return ir.Stack([media[0], *layers, media[-1]])


# --- the exact answer


def wavenumbers(case: Case, angle: Any) -> list[Any]:
    """kz of every medium in vacuum wavenumbers, Im >= 0."""
    along = mpf(case.n[0][0]) * sin(angle * pi / 180)
    result = []
    for n in case.n:
        kz = sqrt(mpc(*n) ** 2 - along**2)
        result.append(-kz if kz.imag < 0 or (kz.imag == 0 and kz.real < 0) else kz)
    return result


def airy(n: list[Any], kz: list[Any], phases: list[Any], pol: str) -> tuple[Any, Any]:
    """r and t (electric fields) by recursive summation from the exit side."""

    def interface(a: int, b: int) -> tuple[Any, Any]:
        if pol == "s":
            return (kz[a] - kz[b]) / (kz[a] + kz[b]), 2 * kz[a] / (kz[a] + kz[b])
        p, q = n[b] ** 2 * kz[a], n[a] ** 2 * kz[b]
        return (p - q) / (p + q), 2 * n[a] * n[b] * kz[a] / (p + q)

    last = len(n) - 1
    r, t = interface(last - 1, last)
    for j in range(last - 2, -1, -1):
        r_j, t_j = interface(j, j + 1)
        turn = exp(1j * phases[j])
        bounces = 1 + r_j * r * turn**2
        r, t = (r_j + r * turn**2) / bounces, t_j * t * turn / bounces
    return r, t


def fluxes(n: list[Any], kz: list[Any], phases: list[Any], pol: str) -> tuple[list[Any], Any]:
    """Net flux at the top of each layer and in the exit medium for unit incident power; and R."""
    weight = [x**2 if pol == "p" else mpf(1) for x in n]
    e, h = mpc(1), kz[-1] / weight[-1]
    flux = [(conj(e) * h).real]
    for j in range(len(n) - 2, 0, -1):
        c, s = cos(phases[j - 1]), sin(phases[j - 1])
        q = kz[j] / weight[j]
        e, h = c * e - 1j * s / q * h, c * h - 1j * q * s * e
        flux.append((conj(e) * h).real)
    q = kz[0].real / weight[0].real
    incident = fabs(q * e + h) ** 2 / (4 * q)
    return [f / incident for f in reversed(flux)], fabs((q * e - h) / (q * e + h)) ** 2


def digits_for(case: Case) -> int:
    opacity = sum(n[1] * d / case.wavelength_nm for n, d in zip(case.n[1:-1], case.d_nm, strict=True))
    along = case.n[0][0] * math.sin(math.radians(case.angle_deg))
    for n, d in zip(case.n[1:-1], case.d_nm, strict=True):
        opacity += math.sqrt(max(0.0, along**2 - n[0] ** 2)) * d / case.wavelength_nm
    return WORKING_DIGITS + int(4 * math.pi * opacity / math.log(10) * 2)


def coherent(case: Case, pol: str, nudge: float = 0.0) -> dict[str, Any]:
    """R, T, r, t, layer absorptances; `nudge` moves wavelength and angle by that relative amount."""
    mp.dps = digits_for(case)
    wavelength, angle = mpf(case.wavelength_nm) * (1 + mpf(nudge)), mpf(case.angle_deg) * (1 + mpf(nudge))
    n = [mpc(*x) for x in case.n]
    kz = wavenumbers(case, angle)
    phases = [2 * pi * mpf(d) / wavelength * k for d, k in zip(case.d_nm, kz[1:-1], strict=True)]
    r, t = airy(n, kz, phases, pol)
    flux, reflectance = fluxes(n, kz, phases, pol)
    assert fabs(fabs(r) ** 2 - reflectance) < mpf(10) ** -25, case
    assert fabs(flux[0] - (1 - reflectance)) < mpf(10) ** -25, case
    layers = [flux[j] - flux[j + 1] for j in range(len(case.d_nm))]
    return {"R": reflectance, "T": flux[-1], "r": r, "t": t, "A": layers}


def incoherent(case: Case, pol: str) -> tuple[Any, Any]:
    """R and T of a stack with slabs: powers added from the last run up."""
    mp.dps = digits_for(case)
    n = [mpc(*x) for x in case.n]
    kz = wavenumbers(case, mpf(case.angle_deg))
    phases = [mpc(0)] + [
        2 * pi * mpf(d) / mpf(case.wavelength_nm) * k for d, k in zip(case.d_nm, kz[1:-1], strict=True)
    ]
    ends = [0, *(j + 1 for j in sorted(case.slabs)), len(n) - 1]
    reflected: Any = None
    through: Any = None
    for top, bottom in reversed(list(pairwise(ends))):
        part = slice(top, bottom + 1)
        r, t = airy(n[part], kz[part], phases[top + 1 : bottom], pol)
        back, out = airy(n[part][::-1], kz[part][::-1], phases[top + 1 : bottom][::-1], pol)
        if reflected is None:
            reflected, through = fabs(r) ** 2, fabs(t) ** 2
            continue
        once = exp(-2 * phases[bottom].imag)
        escape = 1 - fabs(back) ** 2 * once**2 * reflected
        through = fabs(t) ** 2 * once * through / escape
        reflected = fabs(r) ** 2 + fabs(t * out) ** 2 * once**2 * reflected / escape
    last = kz[-1] / n[-1] * conj(n[-1]) if pol == "p" else kz[-1]
    return reflected, last.real / kz[0].real * through


# --- fresh numbers of every kind


METALS: list[Index] = [(0.061, 3.77), (0.31, 2.88), (2.54, 3.43), (0.98, 6.55), (3.5, 2.7), (0.04, 4.2)]


def cases(rng: random.Random, each: int) -> Iterator[Case]:
    u = rng.uniform

    def real(low: float = 1.2, high: float = 2.6) -> Index:
        return (round(u(low, high), 4), 0.0)

    def wave() -> float:
        return round(u(380, 780), rng.choice([0, 1, 2, 3]))

    def angle(high: float = 88.0) -> float:
        return rng.choice([0.0, round(u(0, high), 3)])

    def near(low: float, high: float) -> float:
        """Uniform in the logarithm."""
        return math.exp(u(math.log(low), math.log(high)))

    air: Index = (1.0, 0.0)

    def critical(n1: float, n2: float) -> float:
        return float(asin(mpf(n2) / mpf(n1)) * 180 / pi)

    def ranged(low: float, high: float, count: int) -> list[float]:
        return [round(u(low, high), 3) for _ in range(count)]

    def bragg() -> Case:
        pairs, (high, low) = rng.randint(2, 30), (real(2.0, 2.6), real(1.3, 1.5))
        at = wave()
        d = [round(at / 4 / high[0], 6), round(at / 4 / low[0], 6)] * pairs
        return Case("bragg", [air, *([high, low] * pairs), real()], d, round(at * u(0.9, 1.1), 3), angle(80))

    def tir() -> Case:
        n1, n2 = real(1.4, 2.0)[0], real(1.0, 1.35)[0]
        offset = rng.choice([-1, 1]) * near(1e-11, 10)
        return Case("tir", [(n1, 0.0), (n2, 0.0)], [], wave(), min(critical(n1, n2) + offset, 89.0))

    def critical_layer() -> Case:
        n1, n2 = real(1.5, 2.5)[0], real(1.0, 1.4)[0]
        at = critical(n1, n2) + rng.choice([0.0, 1e-13, 1e-9, -1e-9, 1e-5])
        return Case("critical_layer", [(n1, 0.0), (n2, 0.0), real()], ranged(1, 500, 1), wave(), at)

    def random_multilayer() -> Case:
        count = rng.randint(1, 12)
        layers = [rng.choice([real(1.2, 3.5), (round(u(1.3, 4), 4), round(u(0, 1), 4))]) for _ in range(count)]
        last = rng.choice([real(1, 4), METALS[0], (1.4, 3e-8)])
        return Case("random_multilayer", [real(1, 1.8), *layers, last], ranged(0, 300, count), wave(), angle())

    def grazing() -> Case:
        at = 90.0 - near(1e-12, 2.0)
        last = rng.choice([air, rng.choice(METALS), real()])
        return Case("grazing", [air, real(), last], ranged(5, 600, 1), wave(), at)

    def opaque() -> Case:
        metal = rng.choice(METALS)
        d = round(near(100, 1e5), 1)
        if rng.random() < 0.5:
            return Case("opaque_metal", [air, metal, real()], [d], wave(), angle())
        n = [air, real(), metal, real(), rng.choice(METALS), real()]
        return Case(
            "opaque_metal", n, [70.0, round(near(100, 4000), 1), 130.0, round(near(10, 1500), 1)], wave(), angle()
        )

    def leaky() -> Case:
        n1, n2 = real(1.5, 2.0)[0], real(1.0, 1.4)[0]
        at = min(critical(n1, n2) + near(1e-9, 30), 89.9)
        layers = rng.randint(0, 2)
        n = [(n1, 0.0), *[real() for _ in range(layers)], (n2, near(1e-12, 1e-4))]
        return Case("weakly_absorbing_exit", n, ranged(10, 400, layers), wave(), at)

    def brewster() -> Case:
        n = real(1.2, 3.0)
        return Case("brewster", [air, n], [], wave(), math.degrees(math.atan(n[0])))

    makers: list[Callable[[], Case]] = [
        lambda: Case("bare_interface", [real(1, 2), rng.choice([real(1, 3), *METALS])], [], wave(), angle()),
        lambda: Case("single_film", [real(1, 1.6), real(), real(1, 4)], [round(near(1, 2000), 3)], wave(), angle()),
        lambda: Case("soap_film", [air, real(1.3, 1.4), air], [round(near(0.01, 5000), 3)], wave(), angle()),
        lambda: Case(
            "zero_thickness", [air, real(), rng.choice(METALS), real()], [0.0, rng.choice([0.0, 30.0])], wave(), angle()
        ),
        lambda: Case(
            "thick_coherent",
            [air, (real()[0], rng.choice([0.0, 1e-6])), real()],
            [round(near(1e4, 5e5), 0)],
            wave(),
            angle(),
        ),
        opaque,
        grazing,
        lambda: Case("ftir_gap", [real(1.5, 2), air, real(1.5, 2)], [round(near(0.1, 3000), 3)], wave(), u(30, 85)),
        tir,
        critical_layer,
        lambda: Case("tir_multilayer", [real(1.7, 2), real(), real(), air], ranged(10, 400, 2), wave(), u(45, 88)),
        lambda: (lambda n: Case("index_matched", [n, n, n], ranged(0, 2000, 1), wave(), angle()))(real(1, 2)),
        lambda: (lambda n: Case("half_wave", [air, (n, 0.0), real()], [600.0 / (2 * n)], 600.0, 0.0))(real()[0]),
        lambda: (lambda n: Case("quarter_wave", [air, (n, 0.0), (n * n, 0.0)], [600.0 / (4 * n)], 600.0, 0.0))(
            real()[0]
        ),
        lambda: Case(
            "oxide_on_metal",
            [air, (real()[0], rng.choice([0.0, 0.002])), rng.choice(METALS)],
            ranged(1, 300, 1),
            wave(),
            angle(),
        ),
        lambda: Case(
            "oxide_on_silicon",
            [air, (1.456, 0.0), (round(u(3.7, 5.5), 3), round(u(0.005, 0.3), 3))],
            ranged(1, 2000, 1),
            wave(),
            angle(),
        ),
        lambda: Case("metal_film", [air, rng.choice(METALS), real()], ranged(1, 100, 1), wave(), angle()),
        bragg,
        brewster,
        lambda: Case(
            "kretschmann",
            [real(1.5, 1.8), rng.choice(METALS), (1.0, rng.choice([0.0, 3e-8]))],
            ranged(30, 70, 1),
            632.8,
            u(35, 80),
        ),
        lambda: Case("otto", [real(1.5, 1.8), air, rng.choice(METALS)], ranged(100, 1500, 1), 632.8, u(35, 80)),
        lambda: Case("gain_layer", [air, (real()[0], -near(1e-6, 0.01)), real()], ranged(10, 2000, 1), wave(), angle()),
        lambda: Case(
            "enz_layer", [air, (near(0.001, 0.1), near(0.001, 0.1)), real()], ranged(1, 300, 1), wave(), angle()
        ),
        lambda: Case("pure_imag_metal", [air, (0.0, u(0.5, 5)), real()], ranged(1, 200, 1), wave(), angle()),
        lambda: Case("high_index", [air, (u(4, 8), u(0, 3)), real(3, 5)], ranged(1, 100, 1), wave(), angle()),
        random_multilayer,
        leaky,
    ]
    for _ in range(each):
        for make in makers:
            yield make()


def slab_cases(rng: random.Random, count: int) -> Iterator[Case]:
    u = rng.uniform
    for _ in range(count):
        n: list[Index] = [(rng.choice([1.0, 1.33]), 0.0)]
        d: list[float] = []
        slabs: set[int] = set()
        for _ in range(rng.randint(1, 3)):
            for _ in range(rng.randint(0, 2)):
                n.append(rng.choice([(round(u(1.3, 2.5), 3), 0.0), rng.choice(METALS)]))
                d.append(round(u(2, 130) if n[-1][1] == 0 else u(2, 30), 2))
            n.append((round(u(1.2, 1.8), 3), rng.choice([0.0, 0.0, 1e-7, 5e-6])))
            slabs.add(len(d))
            d.append(rng.choice([5e5, 1e6, 2e6]))
        for _ in range(rng.randint(0, 2)):
            n.append((round(u(1.3, 2.5), 3), 0.0))
            d.append(round(u(20, 130), 2))
        n.append(rng.choice([(1.0, 0.0), (1.33, 0.0), (2.54, 3.43)]))
        yield Case("incoherent", n, d, round(u(400, 700), 1), rng.choice([0.0, 20.0, 45.0, 70.0, 85.0]), slabs)


# --- comparison


class Worst:
    """Largest error over what is allowed, by category and quantity."""

    def __init__(self) -> None:
        self.rows: dict[tuple[str, str], tuple[float, str]] = {}

    def add(self, case: Case, quantity: str, error: Any, allowed: Any) -> None:
        ratio = float(error / allowed)
        key = (case.category, quantity)
        if key not in self.rows or not ratio <= self.rows[key][0]:
            self.rows[key] = (ratio, f"error {float(error):.2e}, allowed {float(allowed):.2e}: {case}")

    def report(self, limit: float = 1.0) -> int:
        for (category, quantity), (ratio, text) in sorted(self.rows.items()):
            print(f"{category:<22} {quantity:<8} {ratio:9.1e}{'  ' + text if not ratio <= limit else ''}")
        return sum(not ratio <= limit for ratio, _ in self.rows.values())


def compare(case: Case, worst: Worst) -> None:
    stack = case.stack()
    at = (case.wavelength_nm, case.angle_deg)
    bare_critical = not case.d_nm and case.n[-1][1] == 0 and case.n[-1][0] < case.n[0][0]
    if bare_critical:
        sine = case.n[-1][0] / case.n[0][0]
        bare_critical = abs(math.degrees(math.asin(sine)) - case.angle_deg) < 1e-6
    ratio_of = {}
    for pol in "sp":
        exact, moved = coherent(case, pol), coherent(case, pol, 2.0**-53)
        slack = 1000 * fabs(moved["R"] - exact["R"])
        worst.add(case, "R", fabs(stack.reflectance(*at, pol) - exact["R"]), mpf(1e-12) + slack)
        got = stack.transmittance(*at, pol)
        worst.add(case, "T", fabs(got - exact["T"]), mpf(1e-12) + 1000 * fabs(moved["T"] - exact["T"]))
        if exact["T"] > mpf("1e-300"):
            worst.add(case, "T/T_ref", fabs(got / exact["T"] - 1), mpf(1e-9))
        r, t = stack.amplitudes(*at, pol)
        if not bare_critical:
            worst.add(case, "r", fabs(r - exact["r"]), mpf(1e-11) + slack)
            if fabs(exact["t"]) > mpf("1e-290"):
                worst.add(case, "t/t_ref", fabs(t / exact["t"] - 1), mpf(1e-9))
        for a, reference in zip(stack.layer_absorptance(*at, pol), exact["A"], strict=True):
            worst.add(case, "A_layer", fabs(a - reference), mpf(1e-11))
        total = stack.reflectance(*at, pol) + got + stack.absorptance(*at, pol)
        worst.add(case, "R+T+A-1", abs(total - 1), mpf(1e-12) * max(1, exact["R"] + exact["T"]))
        ratio_of[pol] = exact["r"]
    if min(fabs(x) for x in ratio_of.values()) > mpf(1e-3):
        rho = ratio_of["p"] / ratio_of["s"]
        psi, delta = stack.ellipsometry(*at)
        exact_delta = (atan2(rho.imag, rho.real) * 180 / pi) % 360
        off = fabs(delta - exact_delta)
        digits_lost = mpf(10) ** max(0, log10(slack * 1e12 + 1))
        worst.add(case, "psi", fabs(psi - atan2(fabs(rho), 1) * 180 / pi), mpf(1e-9) * digits_lost)
        worst.add(case, "delta", min(off, 360 - off), mpf(1e-9) * digits_lost)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--each", type=int, default=10, help="cases of every category")
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    worst = Worst()
    count = 0
    for case in cases(rng, arguments.each):
        compare(case, worst)
        count += 2
    for case in slab_cases(rng, 5 * arguments.each):
        stack = case.stack()
        for pol in "sp":
            reflected, through = incoherent(case, pol)
            at = (case.wavelength_nm, case.angle_deg, pol)
            worst.add(case, "R", fabs(stack.reflectance(*at) - reflected), mpf(1e-11))
            worst.add(case, "T", fabs(stack.transmittance(*at) - through), mpf(1e-11))
            total = stack.reflectance(*at) + stack.transmittance(*at) + stack.layer_absorptance(*at).sum()
            worst.add(case, "R+T+A-1", abs(total - 1), mpf(1e-11))
            count += 1
    failures = worst.report()
    print(f"{count} vectors, {failures} groups beyond the pass rule (numbers above: worst error over what is allowed)")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
