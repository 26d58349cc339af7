"""One question to a pile of media and thicknesses, answered by one call into the core.

Plain values only: `Layer` and everything after it stands on this.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, Operand, place
from iridesce.arguments.refusals import Words, complaint
from iridesce.arguments.scalars import checked_threads
from iridesce.optics.medium import Medium


def evaluate(
    quantity: str,
    polarization: str,
    media: Sequence[Medium],
    coherent: Sequence[bool],
    shape: tuple[int, ...],
    arguments: Sequence[Operand],
    out: Floats,
    second: Floats | None = None,
    threads: int | None = None,
) -> None:
    """Write a quantity into ``out``: indices once per wavelength and different medium, then one call into the core.

    ``arguments`` are wavelength, angle and the thickness of each layer, which broadcast to ``shape``.
    """
    count = checked_threads(threads)
    rows: dict[Medium, int] = {}
    numbers = [rows.setdefault(medium, len(rows)) for medium in media]
    _core.stack_evaluate(
        quantity,
        polarization,
        [index_at(medium, arguments[0].values).reshape(-1) for medium in rows],
        numbers,
        list(coherent),
        [(argument.values.reshape(-1), argument.strides(shape)) for argument in arguments],
        list(shape),
        out,
        second,
        count,
    )


def index_at(medium: Medium, wavelength_nm: Floats) -> npt.NDArray[np.complex128]:
    """The medium's index at each wavelength, or a single one where it is constant; `ValueError` outside its data."""
    if medium.kind == "constant":
        return np.array(constant_index(medium))
    if medium.range_nm is not None:
        low, high = medium.range_nm
        outside = (wavelength_nm < low) | (wavelength_nm > high)
        if outside.any():
            index = np.unravel_index(int(np.argmax(outside)), outside.shape)
            raise complaint(
                f'medium "{medium.name}" has data for {low:g}-{high:g} nm; wavelength_nm must be within them, '
                f"got {wavelength_nm[index]}{place(index)}",
                "wavelength_nm",
                f"within {low:g}-{high:g}",
                Words(wavelength_nm[index]),
                place(index),
            )
    return np.asarray(medium.index(wavelength_nm))


def constant_index(medium: Medium) -> complex | None:
    """The index of a medium that has the same one at every wavelength, else ``None``."""
    return complex(medium.index(550.0)) if medium.kind == "constant" else None


def check_ends(first: Medium, last: Medium) -> None:
    """What can be told without a wavelength; the core checks the rest at each one."""
    index = constant_index(first)
    if index is not None and (index.imag != 0.0 or index.real <= 0.0):
        raise complaint(
            f"the first medium must have real n > 0 and k = 0, got {medium_repr(first)}",
            "first",
            "a medium with real n > 0 and k = 0",
            Words(medium_repr(first)),
        )
    index = constant_index(last)
    if index is not None and index.imag < 0.0:
        raise complaint(
            f"the last medium must have k >= 0 (gain only in finite layers), got {medium_repr(last)}",
            "last",
            "a medium with k >= 0",
            Words(medium_repr(last)),
        )


def medium_repr(medium: Medium) -> str:
    """As short as `Layer` and `Stack` take it: 'soap', 1.5, or the whole of ``Medium.from_file(...)``."""
    text = repr(medium)
    return text.removeprefix("Medium(").removesuffix(")") if text.startswith("Medium(") else text
