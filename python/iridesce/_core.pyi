"""Types of the compiled core. Private: the public modules check and document, then call these."""

import numpy as np
import numpy.typing as npt

__version__: str


# --- stack

def stack_evaluate(
    quantity: str,
    polarization: str,
    indices: npt.NDArray[np.complex128],
    media: list[int],
    coherent: list[bool],
    arguments: list[tuple[npt.NDArray[np.float64], list[int]]],
    shape: list[int],
    out: npt.NDArray[np.float64],
    second: npt.NDArray[np.float64] | None,
    threads: int | None,
) -> None: ...
