"""Spectra of films, with noise and under lamps, for the tests of fits."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import iridesce as ir

Floats = npt.NDArray[np.float64]

NM = np.arange(420.0, 760.0, 1.0)
# Films of the very index and spectrometers of the very wavelengths that were said.
EXACT: dict[str, Any] = {"index_tolerance": 0.0, "wavelength_tolerance_nm": 0.0}


def clean(text: str, *thickness_nm: float, nm: Floats = NM, quantity: str = "reflectance", **how: Any) -> Floats:
    for value in thickness_nm:
        text = text.replace("?", repr(value), 1)
    return np.asarray(getattr(ir.Stack.parse(text), quantity)(nm, **how))


def noisy(values: Floats, db: float = 40.0, seed: int = 1) -> Floats:
    random = np.random.default_rng(seed)
    return np.asarray(values + np.std(values) * 10.0 ** (-db / 20.0) * random.standard_normal(values.size))


def bumps(seed: int, nm: Floats = NM) -> Floats:
    """A lamp with a bump of 40 % and 25 nm that nobody divided out."""
    random = np.random.default_rng(seed)
    where = random.uniform(nm[0], nm[-1])
    return np.asarray(1.0 + 0.4 * np.exp(-0.5 * ((nm - where) / 25.0) ** 2) - 0.3 * ((nm - 600.0) / 200.0) ** 2)
