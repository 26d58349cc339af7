"""What real spectra have and models have not: how `ir.fit_thickness` at its defaults stands each of these faults.

    python bench/fit_trials.py [--each 20] [--seed 1] [--fault NAME]... [--system NAME]... [--joint KIND] [--workers 1]
                               [--verbose]

Each spectrum is made by a stack of random thickness with one fault that `fit_thickness` is not told of; the last column of
faults has several at once. For each fault: the share whose best thickness is of the right order (within a quarter of a fringe
and 4 %), the share whose truth is among the solutions (same measure), the share answered by an error in words, the median and
the worst error of the right ones in per cent, the share of their 95 % intervals that hold the truth, which are those of the
accuracy (1 % of index, 0.3 nm of the wavelengths), and the share of answers that come with a note.

``--joint``: two spectra of the film fitted together, in the window from 60 to 160 % of its thickness; the last columns are the
shares of verdicts, and of answers that are clear and wrong. "angles": R at 0 and 45 degrees, both with the fault; "one": only
the first of them has it; "powers": R and T, both with it (films on a clear base, or on none).
"""

from __future__ import annotations

import argparse
import multiprocessing
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import iridesce as ir

Floats = npt.NDArray[np.float64]
Random = np.random.Generator

# Name: text of the stack, wavelengths (first, last, step), thicknesses (low, high).
SYSTEMS: dict[str, tuple[str, tuple[float, float, float], tuple[float, float]]] = {
    "soap": ("air / soap ? / air", (420.0, 780.0, 0.7), (150.0, 5000.0)),
    "oxide": ("air / SiO2 ? / Si", (400.0, 950.0, 0.6), (120.0, 5000.0)),
    "nitride": ("air / Si3N4 ? / Si", (400.0, 900.0, 0.6), (60.0, 3000.0)),
    "polymer": ("air / PMMA ? / N-BK7", (470.0, 1000.0, 0.8), (250.0, 5000.0)),
    "resist": ("air / polystyrene ? / Si", (470.0, 1000.0, 0.8), (120.0, 20000.0)),
    "titania": ("air / TiO2 ? / Ti", (400.0, 700.0, 1.0), (50.0, 400.0)),
    "thick": ("air / PMMA ? / Si", (600.0, 1000.0, 0.3), (5000.0, 45000.0)),
}


class Bench:
    """One spectrum being made: what a fault may change."""

    def __init__(self, system: str, random: Random, quantity: str = "reflectance", angle_deg: float = 0.0) -> None:
        self.text, (first, last, step), (low, high) = SYSTEMS[system]
        self.random, self.quantity, self.angle_deg = random, quantity, angle_deg
        self.wavelength_nm = np.arange(first, last, step)
        self.thickness_nm = float(np.exp(random.uniform(np.log(low), np.log(high))))
        self.noise = 10.0 ** (-35.0 / 20.0)
        self.x = np.linspace(-1.0, 1.0, self.wavelength_nm.size)

    def stack(self, thickness_nm: float | None = None) -> ir.Stack:
        return ir.Stack.parse(self.text.replace("?", repr(float(thickness_nm or self.thickness_nm))))

    def clean(self, shift_nm: float = 0.0, line_nm: float = 1.2, spread: float = 0.0) -> Floats:
        """The stack through a spectrometer of a narrow line; over a spread of thicknesses (sd, relative)."""
        if spread == 0.0:
            return self._one(self.stack(), shift_nm, line_nm)
        # Even steps: a Gauss-Hermite rule of 41 nodes gives fringes of more than 9 radians of spread back as others of less,
        # which no uneven film shows (the third harmonic of 13 um, the second of 26 um).
        nodes = np.linspace(-6.0, 6.0, 241)
        weights = np.exp(-0.5 * nodes**2)
        parts = np.zeros_like(self.wavelength_nm)
        for node, weight in zip(nodes, weights / weights.sum(), strict=True):
            parts += weight * self._one(self.stack(self.thickness_nm * (1.0 + spread * node)), shift_nm, line_nm)
        return parts

    def _one(self, stack: ir.Stack, shift_nm: float, line_nm: float) -> Floats:
        nodes, weights = np.polynomial.hermite_e.hermegauss(15)
        nm = self.wavelength_nm[:, None] + shift_nm + line_nm / 2.3548 * nodes
        return np.asarray(self.seen(stack, nm) @ (weights / weights.sum()))

    def seen(self, stack: ir.Stack, nm: Floats) -> Floats:
        """What a stack shows at many wavelengths."""
        found = getattr(stack, self.quantity)(nm.reshape(-1), self.angle_deg)
        return np.asarray(found).reshape(nm.shape)

    def noisy(self, clean: Floats) -> Floats:
        return np.asarray(clean + np.std(clean) * self.noise * self.random.standard_normal(clean.size))


def scaled(stack: ir.Stack, nm: Floats, film: float, base: float) -> Floats:
    """The spectrum with the film's n and the substrate's n scaled."""
    thickness = float(np.ravel(stack.layers[0].thickness_nm)[0])
    out = np.empty(nm.size)
    for place, one in enumerate(nm):
        n1, n2 = complex(stack.layers[0].medium.index(one)), complex(stack.last.index(one))
        moved = ir.Stack([1.0, ir.Layer(complex(n1.real * film, n1.imag), thickness), complex(n2.real * base, n2.imag)])
        out[place] = moved.reflectance(one)
    return out


def none(bench: Bench) -> Floats:
    return bench.noisy(bench.clean())


def lamp_drift(bench: Bench) -> Floats:
    """The lamp has changed its colour since the reference: a curved gain of +-5 %."""
    a, b = bench.random.uniform(-0.05, 0.05, 2)
    return bench.noisy(bench.clean() * (1.0 + a * bench.x + b * bench.x**2))


def saturated(bench: Bench) -> Floats:
    """The top tenth of the range is clipped."""
    values = bench.noisy(bench.clean())
    return np.minimum(values, values.min() + 0.9 * np.ptp(values))


def spikes(bench: Bench) -> Floats:
    values = bench.noisy(bench.clean())
    where = bench.random.choice(values.size, 6, replace=False)
    values[where] += np.ptp(values) * bench.random.uniform(0.3, 5.0, 6)
    return values


def stray_light(bench: Bench) -> Floats:
    """Light past the sample: up to half the mean, sloping by a fifth of that."""
    clean = bench.clean()
    size = clean.mean() * bench.random.uniform(0.0, 0.5)
    return bench.noisy(clean + size * (1.0 + 0.2 * bench.x))


def second_order(bench: Bench) -> Floats:
    """Above 1.8 times the first wavelength, a tenth of the light is the grating's second order."""
    clean = bench.clean()
    half = bench.seen(bench.stack(), np.maximum(0.5 * bench.wavelength_nm, 440.0))
    mixed = np.where(bench.wavelength_nm > 1.8 * bench.wavelength_nm[0], 0.9 * clean + 0.1 * half, clean)
    return bench.noisy(mixed)


def spliced(bench: Bench) -> Floats:
    """Two detectors that do not meet: beyond one wavelength in the middle six tenths, 6 % more or less."""
    where = bench.wavelength_nm > bench.wavelength_nm[int(bench.random.uniform(0.2, 0.8) * bench.wavelength_nm.size)]
    return bench.noisy(bench.clean() * (1.0 + bench.random.choice([-0.06, 0.06]) * where))


def noisy_ends(bench: Bench) -> Floats:
    """The lamp is dim at the ends: noise grows to the size of the signal."""
    clean = bench.clean()
    size = 1.0 + 80.0 * np.abs(bench.x) ** 12
    return np.asarray(clean + np.std(clean) * bench.noise * size * bench.random.standard_normal(clean.size))


def dark_ends(bench: Bench) -> Floats:
    """No light at one or both ends, up to a tenth of the channels each: ratios of noise, to thirty times the film's range."""
    values = bench.noisy(bench.clean())
    count = int(bench.random.uniform(2.0, 0.1 * values.size))
    size = np.ptp(values) * 10.0 ** bench.random.uniform(-0.5, 1.5)
    ends = bench.random.integers(3)
    noise = size * bench.random.standard_normal(values.size)
    values[:count] += noise[:count] * (ends != 1)
    values[-count:] += noise[-count:] * (ends != 0)
    return values


def substrate_index(bench: Bench) -> Floats:
    return bench.noisy(scaled(bench.stack(), bench.wavelength_nm, 1.0, 1.01))


def film_index(bench: Bench) -> Floats:
    return bench.noisy(scaled(bench.stack(), bench.wavelength_nm, 1.01, 1.0))


def film_index_less(bench: Bench) -> Floats:
    return bench.noisy(scaled(bench.stack(), bench.wavelength_nm, 0.97, 1.0))


def slit(bench: Bench) -> Floats:
    return bench.noisy(bench.clean(line_nm=6.0))


def uneven_film(bench: Bench) -> Floats:
    return bench.noisy(bench.clean(spread=0.012))


def wavelength_offset(bench: Bench) -> Floats:
    return bench.noisy(bench.clean(shift_nm=bench.random.choice([-1.0, 1.0])))


def wavelength_scale(bench: Bench) -> Floats:
    """A calibration that stretches by 0.3 %."""
    return bench.noisy(bench._one(bench.stack(), 0.003 * bench.wavelength_nm[:, None], 1.2))


def lamp_lines(bench: Bench) -> Floats:
    """A few emission lines of the lamp do not cancel: peaks and dips 3 nm wide."""
    values = bench.noisy(bench.clean())
    for place in bench.random.uniform(bench.wavelength_nm[0], bench.wavelength_nm[-1], 4):
        values += (
            np.ptp(values) * bench.random.uniform(-0.3, 0.5) * np.exp(-(((bench.wavelength_nm - place) / 1.5) ** 2))
        )
    return values


def dead_pixels(bench: Bench) -> Floats:
    values = bench.noisy(bench.clean())
    values[bench.random.choice(values.size, 5, replace=False)] = 0.0
    return values


def lens(bench: Bench) -> Floats:
    """A microscope lens of NA 0.25: angles from 0 to 14.5 degrees, evenly over the pupil."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    sine = 0.25 * np.sqrt(0.5 * (nodes + 1.0))
    stack = bench.stack()
    parts = [np.asarray(stack.reflectance(bench.wavelength_nm, float(np.degrees(np.arcsin(s))))) for s in sine]
    return bench.noisy(np.tensordot(weights / weights.sum(), np.array(parts), axes=1))


def noise_20_db(bench: Bench) -> Floats:
    bench.noise = 0.1
    return bench.noisy(bench.clean())


def smoothed(bench: Bench) -> Floats:
    """The spectrometer's boxcar of nine pixels: neighbours' noise hangs together."""
    bench.noise = 0.05
    return np.convolve(np.pad(bench.noisy(bench.clean()), 4, mode="edge"), np.full(9, 1.0 / 9.0), mode="valid")


def coarse(bench: Bench) -> Floats:
    """Every 5 nm only, as colour instruments write."""
    step = 5.0
    bench.wavelength_nm = np.arange(bench.wavelength_nm[0], bench.wavelength_nm[-1], step)
    bench.x = np.linspace(-1.0, 1.0, bench.wavelength_nm.size)
    n = float(np.real(bench.stack().layers[0].medium.index(550.0)))
    bench.thickness_nm = min(bench.thickness_nm, bench.wavelength_nm[0] ** 2 / (2.0 * n * step) / 3.0)
    return bench.noisy(bench.clean())


def native_oxide(bench: Bench) -> Floats:
    """A film on the film: 15 nm of water."""
    stack = bench.stack()
    stack = ir.Stack([stack.first, ir.Layer("water", 15.0), *stack.layers, stack.last])
    return bench.noisy(bench.seen(stack, bench.wavelength_nm))


def lamp_not_divided(bench: Bench) -> Floats:
    """The reference was taken on another mirror: an even bow of 30 % in the gain."""
    return bench.noisy(bench.clean() * (1.0 + 0.15 * bench.x - 0.25 * bench.x**2))


def all_at_once(bench: Bench) -> Floats:
    a, b = bench.random.uniform(-0.03, 0.03, 2)
    values = bench.clean(shift_nm=0.4, line_nm=2.5, spread=0.003) * (1.0 + a * bench.x + b * bench.x**2)
    values = values + 0.1 * values.mean() * (1.0 + 0.2 * bench.x)
    bench.noise = 0.02
    values = bench.noisy(values)
    values[bench.random.choice(values.size, 2, replace=False)] *= 1.5
    return values


FAULTS: dict[str, Callable[[Bench], Floats]] = {
    function.__name__: function
    for function in (
        none, noise_20_db, lamp_drift, lamp_not_divided, saturated, spikes, dead_pixels, lamp_lines, stray_light,
        second_order, spliced, noisy_ends, dark_ends, substrate_index, film_index, film_index_less, slit, uneven_film,
        wavelength_offset, wavelength_scale, lens, smoothed, coarse, native_oxide, all_at_once,
    )
}  # fmt: skip


def one(task: tuple[str, str, int]) -> tuple[str, float, float, bool, bool, bool, int, str]:
    """Outcome of one spectrum: system, thickness, error, right, among, held, notes, words."""
    fault, system, seed = task
    bench = Bench(system, np.random.default_rng([seed, *fault.encode(), *system.encode()]))
    measured = FAULTS[fault](bench)
    measured = measured * float(np.exp(bench.random.uniform(-1.0, 8.0)))
    truth = bench.thickness_nm
    try:
        result: Any = ir.fit_thickness(bench.wavelength_nm, measured, bench.text)
    except ValueError as error:
        return system, truth, np.nan, False, False, False, 0, str(error)
    if result.best is None:
        return system, truth, np.inf, False, False, False, 1, "; ".join(result.notes)
    return (system, truth, *outcome(bench, result))


def outcome(bench: Bench, result: Any) -> tuple[float, bool, bool, bool, int, str]:
    """Error, right, among, held, notes, words of an answer."""
    truth = bench.thickness_nm
    n = float(np.real(bench.stack().layers[0].medium.index(bench.wavelength_nm.mean())))
    near = min(bench.wavelength_nm.mean() / (8.0 * n) + 0.01 * truth, 0.04 * truth + 3.0)
    errors = [solution.thickness_nm - truth for solution in result]
    low, high = result.best.accuracy_interval_nm
    return (
        errors[0], abs(errors[0]) < near, min(map(abs, errors)) < near, low <= truth <= high,
        sum("said of the film's index" not in note for note in result.notes),
        "; ".join(result.notes),
    )  # fmt: skip


# Two measurements each: quantity, angle in degrees, and whether it has the fault.
JOINT: dict[str, tuple[tuple[str, float, bool], ...]] = {
    "angles": (("reflectance", 0.0, True), ("reflectance", 45.0, True)),
    "one": (("reflectance", 0.0, True), ("reflectance", 45.0, False)),
    "powers": (("reflectance", 0.0, True), ("transmittance", 0.0, True)),
}
VERDICTS = ("clear", "ambiguous", "doubtful", "none")


def together(kind: str, task: tuple[str, str, int]) -> tuple[Any, ...]:
    """Outcome of one joint fit: as of `one`, and the verdict."""
    fault, system, seed = task
    random = np.random.default_rng([seed, *fault.encode(), *system.encode(), *kind.encode()])
    of = Bench(system, random)
    # Films that both spectra show: a joint fit takes the instrument's line as a point, and looks up to 10 000 nm.
    of.thickness_nm = min(of.thickness_nm, 8000.0)
    parts = []
    for quantity, angle_deg, faulty in JOINT[kind]:
        bench = Bench(system, random, quantity, angle_deg)
        bench.thickness_nm = of.thickness_nm
        values = (FAULTS[fault] if faulty else none)(bench) * float(np.exp(random.uniform(-1.0, 8.0)))
        parts.append(ir.Measurement(quantity, bench.wavelength_nm, values, angle_deg))
    truth = of.thickness_nm
    try:
        result: Any = ir.fit_thickness(measurements=parts, stack=of.text, thickness_range_nm=(0.6 * truth, 1.6 * truth))
    except ValueError as error:
        return system, truth, np.nan, False, False, False, 0, str(error), "refused"
    if result.best is None:
        return system, truth, np.nan, False, False, False, 0, "; ".join(result.notes), result.verdict
    return (system, truth, *outcome(of, result), result.verdict)


def told(found: list[tuple[Any, ...]]) -> str:
    """Shares of verdicts, and of the clear ones that are wrong, of joint fits."""
    shares = [sum(row[8] == word for row in found) / len(found) for word in VERDICTS]
    wrong = sum(row[8] == "clear" and not row[3] for row in found) / len(found)
    return "  " + " ".join(f"{share:6.0%}" for share in shares) + f" {wrong:15.0%}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=20, help="spectra for each fault and system")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--fault", action="append", choices=list(FAULTS))
    parser.add_argument("--system", action="append", choices=list(SYSTEMS))
    parser.add_argument("--joint", choices=list(JOINT), help="two spectra together")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--verbose", action="store_true", help="tell every wrong answer")
    chosen = parser.parse_args()
    print(
        f"{'fault':<18} {'right':>7} {'among':>7} {'refused':>8} {'median %':>9} {'worst %':>8} {'held':>6} {'noted':>6}"
        + (f"  {'clear':>6} {'ambig':>6} {'doubt':>6} {'none':>6} {'clear and wrong':>15}" if chosen.joint else "")
    )
    with multiprocessing.get_context("spawn").Pool(chosen.workers) as pool:
        for fault in chosen.fault or FAULTS:
            clear_base = ["soap", "polymer"] if chosen.joint == "powers" else list(SYSTEMS)
            systems = chosen.system or clear_base
            tasks = [(fault, system, chosen.seed + i) for system in systems for i in range(chosen.each)]
            found = pool.map(partial(together, chosen.joint) if chosen.joint else one, tasks, chunksize=4)
            right = np.array([row[3] for row in found])
            among = np.array([row[4] for row in found])
            refused = np.array([np.isnan(row[2]) for row in found])
            held = np.array([row[5] for row in found])[right]
            noted = np.array([row[6] > 0 for row in found])
            share = np.array([abs(row[2]) / row[1] * 100.0 for row in found])[right]
            middle, worst = (np.median(share), share.max()) if share.size else (np.nan, np.nan)
            print(
                f"{fault:<18} {right.mean():7.1%} {among.mean():7.1%} {refused.mean():8.1%} {middle:9.3f} {worst:8.2f} "
                f"{held.mean() if held.size else np.nan:6.0%} {noted.mean():6.0%}"
                + (told(found) if chosen.joint else ""),
                flush=True,
            )
            if chosen.verbose:
                for row in found:
                    if not row[3]:
                        how = ("among" if row[4] else "WRONG") + (f" and {row[8]}" if chosen.joint else "")
                        print(f"    {how} {row[0]} {row[1]:.1f} nm off by {row[2]:.1f}: {row[7]}")


if __name__ == "__main__":
    main()
