"""The few numbers by which targets with a film model of their own hold a film: its index, its base, its thickness. Internal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.exchange import charts
from iridesce.exchange.films import ANGLES_DEG, DISPERSES, Film, extended_index
from iridesce.exchange.package import Package
from iridesce.stack import Stack

DESIGN_NM = 550.0
"""Where one index stands for a dispersive one: near the peak of the eye."""

RGB_NM = (650.0, 550.0, 450.0)
"""Where n and k are taken for R, G and B."""

_ABSORBS = 1e-4

_BOUNDS = {"film_ior": (1.0, 3.5), "base_ior": (1.0, 5.0), "f0": (0.0, 0.999), "n": (0.05, 8.0), "k": (0.0, 12.0)}

Twin = Callable[["Knobs", Floats, Floats], Floats]


@dataclass(frozen=True, eq=False)
class Knobs:
    """What is set in the target."""

    film_ior: float
    base_ior: float | None
    """Of a clear base."""
    f0: Floats
    """Reflectance of the base at normal incidence, linear Rec.709."""
    index: Floats | None = None
    """n + ik of an absorbing base at R, G and B."""
    base_name: str = ""

    @property
    def is_metal(self) -> bool:
        """Whether the base absorbs."""
        return self.index is not None


def knobs_of(film: Film, package: Package, target: str, rgb_nm: tuple[float, float, float] = RGB_NM) -> Knobs:
    """The physical values; what they cannot say is told."""
    name, stack = film.name, film.stack
    outside = float(extended_index(stack.first, [DESIGN_NM])[0].real)
    if abs(outside - 1.0) > 1e-3:
        package.drop(f"{name}: the medium outside, {stack.first.name}; {target} counts indices against air")
    below = stack.layers if film.layer is None else stack.layers[film.layer + 1 :]
    above = () if film.layer is None else stack.layers[: film.layer]
    for layer in above:
        package.drop(
            f"{name}: the layer {layer.medium.name} above the film; {target} holds one film, use lut, osl or mitsuba"
        )
    base = stack.last
    slab = next((number for number, layer in enumerate(below) if not layer.coherent), None)
    if slab is not None:  # what the film lies on; its back is a face of its own
        base, below = below[slab].medium, below[:slab]
        package.drop(
            f"{name}: what comes back from behind the slab {base.name}, which is incoherent: {target} ends at its front;"
            " lut, osl and mitsuba hold it whole"
        )
    clear = bool(np.all(extended_index(base, rgb_nm).imag == 0.0))
    for layer in below:
        counts = "it is left out" if clear else "it counts with the base at 0 degrees only"
        package.drop(
            f"{name}: the layer {layer.medium.name} under the film as a film of its own: {target} holds one film; {counts};"
            " lut, osl and mitsuba hold it whole"
        )
    film_ior = 1.0
    if film.layer is not None:
        medium = stack.layers[film.layer].medium
        index = extended_index(medium, [450.0, DESIGN_NM, 650.0])
        film_ior = float(index[1].real) / outside
        if not stack.layers[film.layer].coherent:
            package.drop(f"{name}: the slab {medium.name} is incoherent; {target} draws its fringes")
        if np.max(np.abs(index.imag)) > _ABSORBS:
            package.drop(f"{name}: absorption of the film {medium.name}; {target} knows clear films only, use lut")
        if np.ptp(index.real) > DISPERSES:
            package.drop(
                f"{name}: dispersion of {medium.name}, n = {index[0].real:.3f} at 450 nm to {index[2].real:.3f} at 650 nm;"
                f" {target} takes n = {film_ior:.4f}"
            )
        if film_ior < 1.0:
            package.drop(
                f"{name}: a film of lower index than the medium outside; {target} takes 1 at least, use lut or osl"
            )
            film_ior = 1.0
    with film.hushed():
        f0 = np.clip(np.asarray(Stack([stack.first, *below, base]).color(space="linear-srgb")), 0.0, 1.0)
    index = extended_index(base, rgb_nm)
    if clear:
        base_ior = max(float(extended_index(base, [DESIGN_NM])[0].real) / outside, 1.0)
        return Knobs(film_ior, base_ior, f0, None, base.name)
    return Knobs(film_ior, None, f0, index / outside, base.name)


def shown(twin: Twin, knobs: Knobs, film: Film) -> Floats:
    """The chart as the target shows it: its linear Rec.709 as XYZ, under the film's own lamp."""
    cosine = np.cos(np.radians(ANGLES_DEG))[:, None]
    rgb = twin(knobs, film.thicknesses()[None, :], cosine)
    to_rgb = color.rgb_matrix("linear-srgb")
    # RGB has no spectra: a lamp is a factor on each channel.
    lamp = to_rgb @ film.illuminant.white() if film.illuminant.name != "D65" else np.ones(3)
    return np.asarray((rgb * lamp) @ np.linalg.inv(to_rgb).T)


def differences(twin: Twin, knobs: Knobs, film: Film) -> Floats:
    """CIEDE2000 of the target's chart against the truth."""
    return charts.differences(shown(twin, knobs, film), charts.truth(film), film.illuminant)


def fitted(twin: Twin, knobs: Knobs, film: Film, package: Package, takes: tuple[str, ...]) -> Knobs:
    """The knobs that bring the chart nearest to the truth, in the mean; the report says what was won."""
    start, bounds = _vector(knobs, takes)
    low, high = np.array(bounds).T

    def cost(values: Floats) -> float:
        held = np.clip(values, low, high)
        outside = float(np.abs(values - held).sum())
        return float(differences(twin, _knobs(knobs, takes, held), film).mean()) + 10.0 * outside

    # A simplex that has collapsed in a valley is opened again from where it lies.
    best = start
    for reach in (0.3, 0.1):
        best = nelder_mead(cost, best, reach * np.maximum(np.abs(best), 0.1))
    made = _knobs(knobs, takes, np.clip(best, low, high))
    before, after = (float(differences(twin, one, film).mean()) for one in (knobs, made))
    if after >= before:
        package.note(f"{film.name}: fit: nothing won, CIEDE2000 stays {before:.2f} in the mean")
        return knobs
    package.note(
        f"{film.name}: fit: CIEDE2000 {before:.2f} with the physical values, {after:.2f} with those written ("
        + ", ".join(f"{key} {value:.4g}" for key, value in _named(made, takes))
        + ")"
    )
    return made


def coded_cost(film: Film, levels: int) -> float:
    """CIEDE2000 in the mean that a map of so many levels over the film's range costs, at 0 degrees."""
    low, high = film.range_nm
    draws = low + (high - low) * np.random.Generator(np.random.PCG64(2)).random(512)
    steps = low + np.rint((draws - low) / (high - low) * (levels - 1)) * (high - low) / (levels - 1)
    return float(charts.differences(film.xyz(steps, 0.0), film.xyz(draws, 0.0), film.illuminant).mean())


def nelder_mead(cost: Callable[[Floats], float], start: Floats, step: Floats, rounds: int = 120) -> Floats:
    """The simplex method of J. A. Nelder and R. Mead, Comput. J. 7, 308 (1965); always the same number of rounds at most."""
    points = [start, *[start + step[i] * np.eye(len(start))[i] for i in range(len(start))]]
    values = [cost(point) for point in points]
    for _ in range(rounds):
        order = np.argsort(values, kind="stable")
        points, values = [points[i] for i in order], [values[i] for i in order]
        if values[-1] - values[0] < 1e-4:
            break
        middle = np.mean(points[:-1], axis=0)
        mirrored = middle + (middle - points[-1])
        value = cost(mirrored)
        if value < values[0]:
            further = middle + 2.0 * (middle - points[-1])
            beyond = cost(further)
            mirrored, value = (further, beyond) if beyond < value else (mirrored, value)
        elif value >= values[-2]:
            nearer = middle + 0.5 * ((mirrored if value < values[-1] else points[-1]) - middle)
            inside = cost(nearer)
            if inside >= min(value, values[-1]):
                points = [points[0], *[points[0] + 0.5 * (point - points[0]) for point in points[1:]]]
                values = [values[0], *[cost(point) for point in points[1:]]]
                continue
            mirrored, value = nearer, inside
        points[-1], values[-1] = mirrored, value
    best: Floats = points[int(np.argmin(values))]
    return best


def _vector(knobs: Knobs, takes: tuple[str, ...]) -> tuple[Floats, list[tuple[float, float]]]:
    values, bounds = [], []
    for key, value in _named(knobs, takes):
        values.append(value)
        bounds.append(_BOUNDS[key.split("_")[0] if key[0] in "nk" or key.startswith("f0") else key])
    return np.array(values), bounds


def _named(knobs: Knobs, takes: tuple[str, ...]) -> list[tuple[str, float]]:
    named: list[tuple[str, float]] = []
    for key in takes:
        if key == "film_ior":
            named.append((key, knobs.film_ior))
        elif key == "base_ior" and knobs.base_ior is not None:
            named.append((key, knobs.base_ior))
        elif key == "f0" and knobs.base_ior is None:
            named += [(f"f0_{letter}", float(value)) for letter, value in zip("rgb", knobs.f0, strict=True)]
        elif key == "nk" and knobs.index is not None:
            for part, values in (("n", knobs.index.real), ("k", knobs.index.imag)):
                named += [(f"{part}_{letter}", float(value)) for letter, value in zip("rgb", values, strict=True)]
    return named


def _knobs(knobs: Knobs, takes: tuple[str, ...], values: Floats) -> Knobs:
    given = dict(zip([key for key, _ in _named(knobs, takes)], values.tolist(), strict=True))
    made = replace(knobs, film_ior=given.get("film_ior", knobs.film_ior))
    if "base_ior" in given:
        made = replace(made, base_ior=given["base_ior"])
    if "f0_r" in given:
        made = replace(made, f0=np.array([given[f"f0_{letter}"] for letter in "rgb"]))
    if "n_r" in given:
        made = replace(made, index=np.array([complex(given[f"n_{x}"], given[f"k_{x}"]) for x in "rgb"]))
    return made
