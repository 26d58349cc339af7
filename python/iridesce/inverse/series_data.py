"""The spectra of a series before any film is looked for: read, checked, referenced, put right. Internal."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.files.spectra import read_spectrum
from iridesce.inverse.data import inside_media, local_noise, referenced
from iridesce.inverse.model import Problem

_THINNEST_NM, _THICKEST_NM = 1.0, 10_000.0
_MOST_VALUES = 200_000_000
_FEWEST_POINTS = 24


def read(wavelength_nm: npt.ArrayLike | None, spectra: Any) -> tuple[Floats, Floats]:
    if wavelength_nm is None:
        if isinstance(spectra, str | os.PathLike) or not hasattr(spectra, "__iter__"):
            raise refusal("spectra", "a list of paths where wavelength_nm is None", spectra)
        paths = list(spectra)
        if not all(isinstance(one, str | os.PathLike) for one in paths) or not paths:
            raise complaint(
                "spectra must be a list of paths where wavelength_nm is None",
                "spectra",
                "a list of paths where wavelength_nm is None",
                spectra,
            )
        read = [read_spectrum(one) for one in paths]
        for path, one in zip(paths, read, strict=True):
            if one.wavelength_nm.size != read[0].wavelength_nm.size or not np.allclose(
                one.wavelength_nm, read[0].wavelength_nm, rtol=0.0, atol=1e-6
            ):
                raise ValueError(f"{os.fspath(path)}: its wavelengths are not those of {os.fspath(paths[0])}")
        nm, values = np.asarray(read[0].wavelength_nm), np.array([one.measured for one in read])
    else:
        nm = plain_reals("wavelength_nm", wavelength_nm, "numbers, (wavelengths,)")
        _of_one_length(spectra, nm.size)
        values = plain_reals("spectra", spectra, "numbers of one length each, (n, wavelengths)")
    if nm.ndim != 1 or values.ndim != 2 or values.shape[1] != nm.size or not len(values):
        raise refusal(
            "spectra", f"the shape (n, {nm.size}) for {nm.size} wavelengths", Words(values.shape), must="have"
        )
    if not (np.isfinite(nm).all() and (nm > 0.0).all()):
        raise complaint("wavelength_nm must be > 0 and finite", "wavelength_nm", "> 0 and finite", Words("others"))
    if values.size > _MOST_VALUES:
        raise complaint(
            f"spectra hold {values.size} values, at most {_MOST_VALUES} are taken: fit the series in parts",
            "spectra",
            f"{_MOST_VALUES} values at most",
            Words(values.size),
        )
    # Whatever is no number is none in the same way: differences of two infinities are words of numpy's.
    return nm, values if np.isfinite(values).all() else np.where(np.isfinite(values), values, np.nan)


def _of_one_length(spectra: Any, count: int) -> None:
    """Names the first of a list of spectra that has another length than there are wavelengths."""
    if isinstance(spectra, np.ndarray) or not isinstance(spectra, Sequence):
        return
    for place, one in enumerate(spectra):
        if isinstance(one, np.ndarray | Sequence) and not isinstance(one, str) and len(one) != count:
            raise complaint(
                f"spectra must be of one length, a value at each of {count} wavelengths, got {len(one)} in spectrum {place}",
                "spectra",
                f"{count} values each",
                Words(f"{len(one)} values"),
                f"in spectrum {place}",
            )


def times_of(given: npt.ArrayLike | None, count: int) -> Floats:
    if given is None:
        return np.arange(count, dtype=np.float64)
    times = plain_reals("time_s", given, "numbers")
    if times.shape != (count,):
        raise refusal("time_s", f"one time a spectrum ({count})", Words(f"shape {times.shape}"), must="have")
    if not np.isfinite(times).all() or np.any(np.diff(times) <= 0.0):
        raise complaint("time_s must be finite and ascending", "time_s", "finite and ascending", Words("others"))
    return times


def by_reference(
    problem: Problem,
    nm: Floats,
    values: Floats,
    dark: Any,
    reference: Any,
    reference_stack: Any,
    notes: list[str],
) -> tuple[Floats, Floats, Floats]:
    """Reflectances of all spectra: the mean's tells which channels have light, and the noise."""
    # Of a spectrum that is none, or of a channel that has no number in some, the others tell.
    finite = np.isfinite(values)
    mean = np.where(finite, values, 0.0).sum(axis=0) / np.maximum(finite.sum(axis=0), 1)
    lit, _, sd, *_ = referenced(problem, nm, mean, dark, reference, reference_stack, None, notes)
    part = np.isin(nm, lit)
    # Linear in the counts: two of them give the line of each channel.
    d = np.zeros_like(nm) if dark is None else np.asarray(dark, dtype=np.float64)
    light = np.asarray(reference, dtype=np.float64) - d
    _, of, *_ = referenced(
        problem, nm, np.asarray(reference, dtype=np.float64), dark, reference, reference_stack, None, []
    )
    found = (values[:, part] - d[part]) / light[part] * of
    # The noise of the mean is that of one spectrum over the root of their number.
    right, whole = (found, finite.all(axis=1)) if finite.all() else put_right(found, [])
    own = local_noise(right[whole]) if whole.any() else sd
    return lit, found, np.maximum(own, np.minimum(sd, 10.0 * own))


def usable(
    problem: Problem, nm: Floats, values: Floats, sd: Floats | None, filled: Floats, notes: list[str]
) -> tuple[Floats, Floats, Floats | None]:
    """In ascending order, where the media have data, without channels that are full; at least so many wavelengths."""
    order = np.argsort(nm, kind="stable")
    nm, values = nm[order], values[:, order]
    if np.any(np.diff(nm) <= 0.0):
        raise complaint("wavelength_nm must not repeat", "wavelength_nm", "different wavelengths", Words("some twice"))
    known = inside_media(problem, nm, notes) & ~np.isin(nm, filled)
    if known.sum() < _FEWEST_POINTS:
        raise complaint(
            f"{int(known.sum())} usable wavelengths are too few for a series; at least {_FEWEST_POINTS}",
            "wavelength_nm",
            f"{_FEWEST_POINTS} usable wavelengths or more",
            Words(int(known.sum())),
        )
    return nm[known], values[:, known], None if sd is None else sd[order][known]


def put_right(values: Floats, notes: list[str]) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Single spikes and gaps filled from their neighbours; which spectra are whole.

    Not by `without_spikes`, the finder of single spectra: that drops what it finds, where a channel too many costs nothing,
    and marks 0.2 to 0.3 channels a spectrum that are none, of films to 9 um. Spectra of a series have the same channels, so
    that values are filled in, and each too many is a false one; this one marks 0.02, finds as many spikes of the size of the
    fringes and more (97 % against 93 %, of a third of that 50 % against 60 %), and takes a tenth of the time (0.04 ms a
    spectrum).
    """
    finite = np.isfinite(values)
    whole = finite.mean(axis=1) > 0.9
    out = np.where(finite, values, 0.0)
    neighbours = np.sort(np.stack([np.roll(out, shift, axis=1) for shift in (-2, -1, 1, 2)]), axis=0)
    middle = 0.5 * (neighbours[1] + neighbours[2])
    away = np.abs(out - middle)
    size = 1.4826 * np.median(away, axis=1)[:, None]
    spikes = finite & (away > 12.0 * np.maximum(size, 1e-12 * np.abs(out).max(axis=1)[:, None]))
    # The top of a fringe lies away from its neighbours, too, by 5/6 of what parts these (a parabola): it is no spike.
    spikes &= away > 2.0 * (neighbours[2] - neighbours[1])
    spikes[:, :2] = spikes[:, -2:] = False
    out = np.where(spikes | ~finite, middle, out)
    if spikes.any():
        notes.append(f"{int(spikes.sum())} spikes that no neighbour shares were filled")
    if not finite.all():
        notes.append(
            f"{int((~finite).sum())} values that are not finite were filled; {int((~whole).sum())} spectra left out"
        )
    return out, whole


def bounds_of(given: Any, problem: Problem, nm: Floats, notes: list[str]) -> tuple[float, float]:
    if given is None:
        low, high = _THINNEST_NM, _THICKEST_NM
    else:
        try:
            low, high = (float(one) for one in given)
        except (TypeError, ValueError):
            raise refusal("thickness_range_nm", "(low, high) in nm", given) from None
    if not 0.0 <= low < high <= 1e5:
        raise refusal("thickness_range_nm", "0 <= low < high <= 100 000", Words((low, high)))
    n = float(np.real(problem.stack.layers[problem.unknown[0]].medium.index(nm[-1], extrapolate="hold")))
    limit = float(nm[-1]) ** 2 / (4.0 * max(n, 1.0) * float(np.median(np.diff(nm))))
    if high > limit > 2.0 * low:
        notes.append(f"films above {limit:.4g} nm have fringes finer than these wavelengths show")
        high = limit
    return low, high
