"""How a picture was exposed: the gain, haze, camera and lamp that suit it, what else suits it, and whether any does. Internal."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce._progress import Tell
from iridesce.inverse.shots import Setup, Shot
from iridesce.inverse.views import View

# Pixels by which the exposure is found, where all cameras and lamps are tried and where one is left.
_COARSE, _SAMPLED = 512, 2048
# A tie point is worth so many pixels where exposures are compared.
_TIED = 30.0
# Other exposures, cameras and lamps that are held against the best one.
_RIVALS = 8
# Residuals of a model that is off by this many of the standard deviations that it is allowed (`Shot.unknown`) are doubted.
_OFF = 2.0
# What is left of an error that is the same for all pixels of one thickness, where gain and thickness have taken two of three
# channels up: a third of its variance.
_LEFT = 1.0 / 3.0
# Of pictures in which more than this share of all channels is full the exposure may be any: of 28 films behind a detector that
# was cut lower and lower those with up to 78 % were right wherever they were sure, of those with 80 % and more half.
_MOST_FULL = 0.7
# And what a mean over `_SAMPLED` pixels in 24 parts of the range has by chance, of the noise's variance: three sd of chi square.
_CHANCE = 0.006


@dataclass(frozen=True)
class Exposed:
    """A view with the gain and haze that suit a picture."""

    view: View
    gain: float
    haze: tuple[float, float, float]
    cost: float
    misfit: float
    """Infinite where no pixel tells: some channel of each is full, or cut."""
    bias: float

    @property
    def kappa(self) -> float:
        """By how much noise and model are taken to be larger than they should be."""
        return max(self.misfit, 1.0) if math.isfinite(self.misfit) else 1.0


def exposures(setup: Setup, shot: Shot, tables: list[View], tell: Tell | None) -> list[Exposed]:
    """The exposures that suit the picture, best first: of all views by few pixels, of those that are left by more."""
    left = list(tables)
    if len(left) > 4:
        order = np.argsort([one[0].cost for one in _expose(setup, shot, left, _COARSE, tell)], kind="stable")
        left = [left[i] for i in order[:4]]
    found = [one for starts in _expose(setup, shot, left, _SAMPLED, None) for one in starts]
    if shot.ties:
        # An exposure in which a pixel cannot be what it is known to be is none.
        found = [replace(one, cost=one.cost + _untied(setup, shot, one)) for one in found]
    return sorted(found, key=lambda one: one.cost)


def _untied(setup: Setup, shot: Shot, one: Exposed) -> float:
    """What it costs that the pixels of tie points are of other orders."""
    places = np.array([place for place, _ in shot.ties])
    nm = np.array([nm for _, nm in shot.ties], dtype=np.float32)
    of = None if shot.angles.table_of is None else np.ascontiguousarray(shot.angles.table_of[places])
    first, step = setup.steps
    row = shot.row(one.gain, one.haze, one.kappa)
    pixels = np.ascontiguousarray(shot.flat[places])
    mass = _core.picture_agreement(pixels, of, one.view.channels, first, step, row, nm, setup.quarter_nm)
    return float(-_TIED * np.log(np.maximum(np.nan_to_num(mass), 1e-6)).sum())


def _expose(setup: Setup, shot: Shot, tables: list[View], most: int, tell: Tell | None) -> list[list[Exposed]]:
    _, pixels, of = shot.sample(most)
    channels = np.stack([view.channels for view in tables])
    first, step = setup.steps
    base = shot.row(1.0, (0.0, 0.0, 0.0))
    rows = _core.picture_exposures(pixels, of, channels, first, step, base, setup.threads, tell)
    return [
        [Exposed(view, g, (r, gr, b), cost, misfit, bias) for g, r, gr, b, cost, misfit, bias in starts.tolist()]
        for view, starts in zip(tables, rows, strict=True)
    ]


def agreed(
    setup: Setup, shot: Shot, rivals: list[Exposed], nm: npt.NDArray[np.float32], temper: float, notes: list[str]
) -> Any:
    """By thickness, with which probability other exposures, cameras and lamps that suit the picture give the same order."""
    best = rivals[0]
    # Costs count in units of the misfit that even the best one leaves.
    weight = [math.exp(-(one.cost - best.cost) / best.kappa**2) for one in rivals]
    chosen: list[tuple[Exposed, float]] = []
    for one, share in zip(rivals, weight, strict=True):
        close = any(
            one.view is other.view
            and abs(one.gain / other.gain - 1.0) < 0.02
            and max(abs(a - b) for a, b in zip(one.haze, other.haze, strict=True))
            < 0.02 * max(other.haze[0], other.gain * 0.05)
            for other, _ in chosen
        )
        if share > 1e-3 and not close and len(chosen) < _RIVALS:
            chosen.append((one, share))
    if len(chosen) == 1:
        return np.float32(1.0)
    places, pixels, of = shot.sample(_SAMPLED)
    first, step = setup.steps
    near = np.nan_to_num(nm[places], nan=first).astype(np.float32)
    masses = []
    for one, _ in chosen:
        row = shot.row(one.gain, one.haze, best.kappa, temper)
        masses.append(_core.picture_agreement(pixels, of, one.view.channels, first, step, row, near, setup.quarter_nm))
    shares = np.array([share for _, share in chosen])
    shares /= shares.sum()
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.minimum(np.stack(masses) / np.maximum(masses[0], 1e-6), 1.0)
    agreed = np.tensordot(shares, np.nan_to_num(ratio, nan=0.0), axes=1)
    bins = np.clip(((near - first) / setup.quarter_nm).astype(int), 0, 200)
    count = np.bincount(bins, minlength=201)
    mean = np.bincount(bins, agreed, minlength=201) / np.maximum(count, 1)
    mean[count == 0] = float(agreed.mean())
    others = {f"{one.view.camera} under {one.view.illuminant}" for one, _ in chosen[1:]} - {
        f"{best.view.camera} under {best.view.illuminant}"
    }
    if others:
        notes.append("not excluded: " + ", ".join(sorted(others)))
    if mean.min() < 0.9:
        notes.append("other exposures suit the picture as well, and give other orders in part of it")
    of_pixel = np.clip(((np.nan_to_num(nm, nan=first) - first) / setup.quarter_nm).astype(int), 0, 200)
    return mean.astype(np.float32)[of_pixel]


def doubts(shot: Shot, best: Exposed, grows: bool) -> list[str]:
    """Why no order of the picture is sure.

    Residuals are told in units of what noise n and the unknown u of the model come to, sqrt(n^2 + u^2) = 1. Noise alone leaves n;
    a model that is off by `_OFF` of its sd leaves n^2 + (`_OFF` u)^2, squared; and pixels of one thickness have u^2 / 3 in
    common where it is off by one.
    """
    _, pixels, _ = shot.sample(_SAMPLED)
    values = np.maximum(np.where(np.isfinite(pixels), pixels, 0.0), 0.0).astype(np.float64)
    noise = shot.noise[:, 0] + shot.noise[:, 1] * values
    of_noise = float(np.mean(noise / (noise + (shot.unknown * values) ** 2)))
    most = math.sqrt(of_noise + _OFF**2 * (1.0 - of_noise))
    alike = math.sqrt(_LEFT * (1.0 - of_noise) + _CHANCE)
    cut = float(np.mean(pixels >= shot.levels))
    if cut > _MOST_FULL:
        return [
            f"{100.0 * cut:.0f} % of the picture is full: too little is left to tell its exposure by; no order is sure"
        ]
    if not math.isfinite(best.misfit):
        return [
            "no pixel has three channels between dark and full: whether the model holds is unknown; no order is sure"
        ]
    found = []
    if best.misfit > most:
        found.append(
            f"the best camera and lamp leave {best.misfit:.2g} of what noise and model may, at most {most:.2g}"
        )
    if best.bias > alike:
        found.append(f"pixels of one thickness miss the model by {best.bias:.2g} of it, all alike, at most {alike:.2g}")
    if grows:
        found.append("errors of neighbours hang together over the whole picture")
    words = "; ".join(found)
    return (
        [f"{words}: another lamp, camera or stack, a tone curve or local tone mapping; no order is sure"]
        if found
        else []
    )
