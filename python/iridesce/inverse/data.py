"""What is done to a measured spectrum before and around a fit: order, outliers, weights, the size of its noise. Internal."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.inverse.full import full
from iridesce.inverse.model import Problem
from iridesce.inverse.posterior import temper
from iridesce.inverse.solve import Data
from iridesce.stack import Stack

# Values so many times the median are damaged digits: no detector has such a range.
_FAR_OUT = 1e9


def cleaned(
    wavelength_nm: npt.ArrayLike, measured: npt.ArrayLike, noise: npt.ArrayLike | None, notes: list[str]
) -> tuple[Floats, Floats, Floats | None]:
    """Ascending, finite, one value a wavelength; what was changed goes into the notes."""
    nm, values = _column("wavelength_nm", wavelength_nm), _column("measured", measured)
    if nm.shape != values.shape:
        raise complaint(
            f"wavelength_nm and measured must be of one length, got {nm.size} and {values.size}",
            "measured",
            f"as long as wavelength_nm ({nm.size})",
            Words(values.size),
        )
    sd: Floats | None = None
    if noise is not None:
        given = _column("noise", np.atleast_1d(np.asarray(noise)))
        if given.size not in (1, nm.size):
            raise refusal("noise", f"one number or one a point ({nm.size})", Words(given.size))
        sd = np.broadcast_to(given, nm.shape).copy()
    good = np.isfinite(nm) & np.isfinite(values) & (nm > 0.0)
    if sd is not None:
        good &= np.isfinite(sd) & (sd > 0.0)
    # One damaged digit, 1e154 among reflectances, would take every sum of squares with it.
    typical = float(np.median(np.abs(values[good]))) if good.any() else 0.0
    if typical > 0.0:
        good &= np.abs(values) <= _FAR_OUT * typical
    dropped = int(nm.size - good.sum())
    if dropped:
        notes.append(
            f"{dropped} of {nm.size} points dropped: not finite, beyond {_FAR_OUT:g} times the others, or a wavelength or "
            "noise that is not > 0"
        )
    nm, values = nm[good], values[good]
    sd = None if sd is None else sd[good]
    if nm.size == 0:
        raise complaint(
            "wavelength_nm and measured hold no usable point",
            "measured",
            "finite at some wavelength > 0",
            Words("nothing usable"),
        )
    order = np.argsort(nm, kind="stable")
    if np.any(np.diff(nm) < 0.0) and not np.all(np.diff(nm) <= 0.0):
        notes.append("the wavelengths were not in order; they have been sorted")
    nm, values = nm[order], values[order]
    sd = None if sd is None else sd[order]
    unique, inverse, counts = np.unique(nm, return_inverse=True, return_counts=True)
    if unique.size < nm.size:
        notes.append(f"{nm.size - unique.size} repeated wavelengths: their values have been averaged")
        values = np.bincount(inverse, values) / counts
        sd = None if sd is None else np.sqrt(np.bincount(inverse, sd**2)) / counts
        nm = unique
    return nm, values, sd


# Where the reference has so few standard deviations of light, a ratio to it says nothing.
_LEAST_LIGHT = 3.0


class Seen(Protocol):
    """What of a film was measured: a `Problem`, or a `Measurement`."""

    @property
    def quantity(self) -> str: ...
    @property
    def angle_deg(self) -> float: ...
    @property
    def polarization(self) -> str: ...


def check_reference(dark: object, reference: object, reference_stack: object) -> None:
    """What goes with a reference is not given without one."""
    if reference is None and (dark is not None or reference_stack is not None):
        raise complaint(
            "dark and reference_stack go with a reference: give reference=, too",
            "dark" if dark is not None else "reference_stack",
            "given with a reference",
            Words("no reference"),
        )


def referenced(
    of_film: Seen,
    wavelength_nm: npt.ArrayLike,
    measured: npt.ArrayLike,
    dark: npt.ArrayLike | None,
    reference: npt.ArrayLike,
    reference_stack: Any,
    noise: npt.ArrayLike | None,
    notes: list[str],
) -> tuple[Floats, Floats, Floats, Floats, tuple[Floats, Floats]]:
    """Reflectance or transmittance from counts, and the standard deviation of each point.

    Besides, wavelengths of channels that are full; and the light of the reference, by wavelength in ascending order.

    q = (m - d) / (r - d), R = q R0, s^2 = R0^2 (v(m) + q^2 v(r) + (1 - q)^2 v(d)) / (r - d)^2, v the variance of each count,
    from the scatter of neighbours unless `noise`, in counts, is given.
    """
    nm, m, r = _column("wavelength_nm", wavelength_nm), _column("measured", measured), _column("reference", reference)
    d = np.zeros_like(m) if dark is None else _column("dark", dark)
    if not nm.size == m.size == r.size == d.size:
        raise complaint(
            f"wavelength_nm, measured, reference and dark must be of one length, got {nm.size}, {m.size}, {r.size}, {d.size}",
            "measured",
            "as long as wavelength_nm, reference and dark",
            Words(f"{nm.size}, {m.size}, {r.size}, {d.size}"),
        )
    if nm.size < 12:
        raise complaint(
            f"{nm.size} points are too few for counts; at least 12", "measured", "12 points or more", Words(nm.size)
        )
    if noise is None:
        variance = [_variance(nm, one) for one in (m, r, d)]
    else:
        size = np.broadcast_to(_column("noise", np.atleast_1d(np.asarray(noise))), m.shape) ** 2
        variance = [size, size, np.zeros_like(size) if dark is None else size]
    light = r - d
    lit = np.isfinite(light) & (light > _LEAST_LIGHT * np.sqrt(variance[1] + variance[2])) & (light > 0.0)
    if lit.sum() < 12:
        raise complaint(
            f"the reference is above the dark by {_LEAST_LIGHT:g} standard deviations at {int(lit.sum())} of {lit.size} points, "
            "at least 12 are needed: check dark and reference",
            "reference",
            f"above the dark by {_LEAST_LIGHT:g} standard deviations at 12 points or more",
            Words(f"{int(lit.sum())} of {lit.size} points"),
        )
    if not lit.all():
        notes.append(f"{int((~lit).sum())} of {lit.size} points dropped: no light in the reference")
    # Of a reference that is full nothing is known; of a film that fills a channel, a limit.
    over = np.zeros(lit.size, dtype=bool)
    over[lit] = full(r[lit])
    if over.any():
        notes.append(f"{int(over.sum())} of {over.size} points dropped: the reference is full, at its largest value")
    lit &= ~over
    filled = np.sort(nm[full(m) & lit])
    nm, m, light, d = nm[lit], m[lit], light[lit], d[lit]
    if reference_stack is None:
        of = np.ones_like(nm)
    else:
        stack = Stack.parse(reference_stack) if isinstance(reference_stack, str) else reference_stack
        if not isinstance(stack, Stack):
            raise refusal("reference_stack", "a Stack or text like 'air / Si'", reference_stack)
        of = np.asarray(getattr(stack, of_film.quantity)(nm, of_film.angle_deg, of_film.polarization))
    q = (m - d) / light
    v = [one[lit] for one in variance]
    sd = of * np.sqrt(v[0] + q * q * v[1] + (1.0 - q) ** 2 * v[2]) / light
    # Of a film without any light in it, the reference's own reflectance is what is small or large.
    largest = float(np.nanmax(np.abs(q * of), initial=0.0)) or float(np.abs(of).max())
    sd = np.maximum(sd, 1e-6 * max(largest, 1e-300))
    return nm, q * of, sd, filled, _course(nm, light / of, np.sqrt(v[1] + v[2]) / light)


# The course of a reference's light is wanted as well as this: a mean over as many channels as that takes, at most a twelfth.
_COURSE = 0.01


def _course(nm: Floats, light: Floats, relative_sd: Floats) -> tuple[Floats, Floats]:
    """Light by wavelength, without its noise.

    One dark is taken from both counts: in the noise of a ratio and of its light it is the same, and a stray light that is one of
    counts would, over a noisy light, explain noise.
    """
    order = np.argsort(nm, kind="stable")
    width = int(np.clip((float(np.median(relative_sd)) / _COURSE) ** 2, 1, max(nm.size // 12, 1))) | 1
    padded = np.pad(light[order], width // 2, mode="reflect", reflect_type="odd")
    sums = np.cumsum(np.r_[0.0, padded])
    smooth = (sums[width:] - sums[:-width]) / width
    return nm[order], np.maximum(smooth, 0.1 * np.median(smooth))


def _variance(nm: Floats, counts: Floats) -> Floats:
    """Variance of each count: from second differences, averaged over a twelfth of the spectrum."""
    order = np.argsort(nm, kind="stable")
    values = np.where(np.isfinite(counts), counts, 0.0)[order]
    second = (values[2:] - 2.0 * values[1:-1] + values[:-2]) / math.sqrt(6.0)
    local = _local_scatter(np.abs(np.r_[second[0], second, second[-1]]), values.size // 12)
    out = np.empty_like(values)
    out[order] = np.maximum(local[: values.size], 1e-12 * float(np.abs(values).max(initial=0.0))) ** 2
    return out


def inside_media(problem: Problem, nm: Floats, notes: list[str]) -> npt.NDArray[np.bool_]:
    """Which wavelengths all media have data for; the others are dropped, as spectrometers write more than films are known for."""
    inside = np.ones(nm.size, dtype=bool)
    for medium in problem.stack.media:
        if medium.range_nm is None or medium.kind == "constant":
            continue
        low, high = medium.range_nm
        outside = (nm < low) | (nm > high)
        if outside.any() and not outside.all():
            word = f'{int(outside.sum())} points outside {low:g}-{high:g} nm dropped: "{medium.name}" has no data there'
            if word not in notes:
                notes.append(word)
            inside &= ~outside
    return inside


def _column(name: str, values: npt.ArrayLike) -> Floats:
    numbers = plain_reals(name, values, "real numbers along one axis")
    if numbers.ndim != 1:
        raise refusal(name, "real numbers along one axis", Words(f"shape {numbers.shape}"))
    return numbers


def unit(weight: Floats) -> Floats:
    """Weights whose squares have the mean 1."""
    return np.asarray(weight / np.sqrt(np.mean(weight**2)))


# Marked places up to so many points apart are of one stretch: of noise that is too large, most places are marked.
_STRETCH_GAP = 6
# So many spikes in a stretch at an end are no spikes but noise.
_CROWD = 3


def without_spikes(values: Floats, notes: list[str]) -> npt.NDArray[np.bool_]:
    """Which points are no spikes: those that jump from the median of their four neighbours far more than others do."""
    if values.size < 30:
        return np.ones(values.size, dtype=bool)
    padded = np.pad(values, 2, mode="reflect")
    neighbours = np.stack([padded[shift : shift + values.size] for shift in (0, 1, 3, 4)])
    jump = np.abs(values - np.median(neighbours, axis=0))
    # The local scale, so that the noisy edges of a spectrometer are not taken for spikes.
    width = max(values.size // 12, 15)
    blocks = np.array([np.median(block) for block in np.array_split(jump, max(values.size // width, 1))])
    scale = np.interp(np.linspace(0.0, 1.0, values.size), np.linspace(0.0, 1.0, blocks.size), blocks)
    steady = jump <= 15.0 * np.maximum(scale, np.median(jump))
    # With neighbours on one side only, a slope looks like a jump: there a spike is what leaves the middle half of all values.
    small = jump <= float(np.subtract(*np.percentile(values, [75.0, 25.0])))
    steady[:2] |= small[:2]
    steady[-2:] |= small[-2:]
    # Where spikes crowd at an end, what is left between them is of the same noise.
    for there in (steady, steady[::-1]):
        crowd = _stretch_at_start(~there)
        if crowd.size >= _CROWD:
            there[: crowd[-1] + 1] = False
    spikes = int(values.size - steady.sum())
    if spikes == 0 or spikes > values.size // 20 or not np.median(jump) > 0.0:
        return np.ones(values.size, dtype=bool)
    notes.append(f"{spikes} of {values.size} points dropped: spikes that no neighbour shares")
    return np.asarray(steady)


# A place is wild where neighbours differ by more than this many times the middle half of the whole spectrum: a film's fringes,
# of even height and two points each at least, reach 1.2 (second differences of a sine, over its interquartile range).
_WILD = 1.5
# More than this share is no dark end; nor is any where so many places between the ends are wild, too: sharp lines of a mirror's
# cavity, whose spectrum is wild all along. Six spikes in five hundred points, of three places each, are 4 %.
_MOST_DARK = 1.0 / 3.0
_MARGIN = 3
_MOST_WILD_BETWEEN = 0.1


def within_light(values: Floats, notes: list[str]) -> npt.NDArray[np.bool_]:
    """Which points lie between ends whose noise is larger than the signal: no light of the lamp, and ratios of noise.

    Of such points not even the scatter is of use, and least squares over them see nothing else.
    """
    kept = np.ones(values.size, dtype=bool)
    if values.size < 60:
        return kept
    spread = float(np.subtract(*np.percentile(values, [75.0, 25.0])))
    second = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2]) / math.sqrt(6.0)
    # Ends have one neighbour only; a step to it counts as much.
    rough = np.r_[abs(values[1] - values[0]) / math.sqrt(6.0), second, abs(values[-1] - values[-2]) / math.sqrt(6.0)]
    wild = rough > _WILD * spread
    if not spread > 0.0 or not wild.any():
        return kept
    first, last = _end_of_stretch(wild), values.size - _end_of_stretch(wild[::-1])
    if values.size - (last - first) > _MOST_DARK * values.size or wild[first:last].mean() > _MOST_WILD_BETWEEN:
        return kept
    kept[:first] = kept[last:] = False
    if not kept.all():
        notes.append(
            f"{int((~kept).sum())} of {kept.size} points dropped: at the ends the noise is larger than the signal"
        )
    return kept


def _end_of_stretch(wild: npt.NDArray[np.bool_]) -> int:
    """How many points from the first on belong to a wild stretch that begins there."""
    stretch = _stretch_at_start(wild)
    # A single spike is wild at three places, and no end. Beyond the last wild place the same noise may be small by chance.
    return 0 if stretch.size == 0 or (stretch.size <= 3 and stretch[0] > 2) else int(stretch[-1]) + 1 + _MARGIN


def _stretch_at_start(marked: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """The marked places of a stretch that begins near the first point; none where the first one is far from it."""
    places = np.flatnonzero(marked)
    if places.size == 0 or places[0] > _STRETCH_GAP:
        return places[:0]
    gaps = np.flatnonzero(np.diff(places) > _STRETCH_GAP)
    return places if gaps.size == 0 else places[: gaps[0] + 1]


def heteroscedastic_weights(values: Floats, notes: list[str]) -> Floats:
    """Weights from the scatter between neighbours, where that is far from even: the dark edges of a spectrometer."""
    if values.size < 60:
        return np.ones_like(values)
    second = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2]) / math.sqrt(6.0)
    local = _local_scatter(np.r_[second[0], second, second[-1]], values.size // 12)
    typical = float(np.median(local))
    if typical <= 0.0 or local.max() < 6.0 * typical:
        return np.ones_like(values)
    notes.append("the noise is uneven along the spectrum: noisy parts count less")
    return unit(1.0 / np.maximum(local, 0.5 * typical))


# Noise that differs along the spectrum by more than this is weighted by where it is.
_UNEVEN = 2.5
# The scatter of so many points is known to 15 %: of a dozen, chance alone made noise look uneven, and a film of it.
_FEWEST_OF_A_SCATTER = 36


def weights_of(curve: Floats, data: Data, notes: list[str]) -> Floats | None:
    """Weights from what a fit has left, or None where it is even within chance.

    By second differences: what a fit under an even gain has left of a lamp is smooth, and is no noise.
    """
    residual = data.measured - curve
    if residual.size < 60:
        return None
    second = np.abs(residual[2:] - 2.0 * residual[1:-1] + residual[:-2]) / math.sqrt(6.0)
    local = _local_scatter(np.r_[second[0], second, second[-1]], max(residual.size // 8, _FEWEST_OF_A_SCATTER))
    typical = float(np.median(local))
    if typical <= 0.0 or local.max() < _UNEVEN * local.min():
        return None
    note = "the noise is uneven along the spectrum: noisy parts count less"
    if note not in notes:
        notes.append(note)
    return unit(1.0 / np.maximum(local, 0.2 * typical))


# Degree of the course of a lamp, and the share of its peak below which nothing is worth dividing.
_LAMP_DEGREE = 7
_DARK = 0.05


def without_lamp(nm: Floats, values: Floats, mean: Floats) -> tuple[Floats, Floats, Floats] | None:
    """Wavelengths, values and weights of a spectrum over its own smooth course, times the mean that the stack has there."""
    x = (2.0 * nm - nm[0] - nm[-1]) / (nm[-1] - nm[0])
    basis = np.polynomial.chebyshev.chebvander(x, _LAMP_DEGREE)
    course = basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
    lit = course > _DARK * course.max()
    if course.max() <= 0.0 or lit.sum() < 100:
        return None
    lamp = course[lit] / mean[lit]
    return nm[lit], values[lit] / lamp, unit(lamp)


# The narrow window of a local scatter, and how many times what the wide one sees it has to see to be believed.
_NARROW = 11
_ABRUPT = 3.0


def _local_scatter(size: Floats, width: int) -> Floats:
    """Root mean square within a window, outliers cut at eight times the median of all.

    Where most of eleven neighbours are far above that, the noise itself is larger there: it is what their median says.
    """
    width = max(width | 1, _NARROW)
    clipped = np.minimum(size, 8.0 * np.median(size)) ** 2
    padded = np.pad(clipped, width // 2, mode="reflect")
    sums = np.cumsum(np.r_[0.0, padded])
    wide = np.sqrt((sums[width:] - sums[:-width]) / width)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(size, _NARROW // 2, mode="reflect"), _NARROW)
    # The median of a normal error's size is 0.6745 standard deviations.
    narrow = np.median(around, axis=1) / 0.6745
    return np.where(narrow > _ABRUPT * wide, narrow, wide)


def local_noise(spectra: Floats) -> Floats:
    """Noise at each wavelength of many spectra alike: from second differences, over a sixteenth of the spectrum."""
    second = (spectra[:, 2:] - 2.0 * spectra[:, 1:-1] + spectra[:, :-2]) / math.sqrt(6.0)
    # The median of a square is 0.455 of its mean: outliers do not count.
    size = (
        np.sqrt(np.median(second * second, axis=0) / 0.4549) if len(spectra) > 8 else np.sqrt((second**2).mean(axis=0))
    )
    local = _local_scatter(np.r_[size[0], size, size[-1]], spectra.shape[1] // 16)
    return np.maximum(local[: spectra.shape[1]], 1e-150)


def scatter(residual: Floats) -> float:
    """Noise from second differences of what is left, in which what the model misses smoothly does not show."""
    size = math.sqrt(float(np.mean((residual[2:] - 2.0 * residual[1:-1] + residual[:-2]) ** 2)) / 6.0)
    return max(size, 1e-150)


# Residuals above this many times the noise, squared, say that something smooth is left.
_SMOOTH_LEFT = 1.5
# Unless they hang together over less than this, nm: an instrument's smoothing does so, and no lamp.
_SHORTEST_LAMP_NM = 10.0
# Correlations of so many standard deviations are none of chance, of the few dozen that are apart.
_CHANCE = 3.0


def explained(residual: Floats, wavelength_nm: Floats) -> tuple[bool, tuple[float, float] | None]:
    """Whether nothing smooth is left; and of noise that neighbours share its size, and how many share it."""
    size = math.sqrt(float(residual @ residual) / residual.size)
    if size < math.sqrt(_SMOOTH_LEFT) * scatter(residual):
        return True, None
    step = float(np.median(np.diff(wavelength_nm)))
    if not _is_short(residual, min(int(_SHORTEST_LAMP_NM / step), residual.size // 30)):
        return False, None
    return True, (size, temper(residual / size))


def _is_short(residual: Floats, reach: int) -> bool:
    """Whether residuals hang together over fewer than ``reach`` channels alone, and farther away by chance."""
    left = residual - residual.mean()
    size, count = float(left @ left), left.size
    if reach < 2 or size <= 0.0:
        return False
    shared = temper(left / math.sqrt(size / count))
    chance = _CHANCE * math.sqrt(shared / count)
    if shared > reach:
        return False
    return all(abs(float(left[lag:] @ left[:-lag])) < chance * size for lag in range(reach, count // 3))


def too_much(freedom: int) -> float:
    """A chi2 a degree of freedom above which the noise given, or the model, is wrong: five standard deviations."""
    return 1.0 + 5.0 * math.sqrt(2.0 / freedom)
