"""Types of the compiled core. Private: the public modules check and document, then call these."""

import numpy as np
import numpy.typing as npt

_F64 = npt.NDArray[np.float64]
_C128 = npt.NDArray[np.complex128]

__version__: str

# --- medium

MEDIUM_TEXT_BYTES: int

class Medium:
    @staticmethod
    def constant(n: float, k: float) -> Medium: ...
    @staticmethod
    def named(name: str) -> Medium: ...
    @staticmethod
    def from_text(text: str, label: str) -> Medium: ...
    @property
    def name(self) -> str: ...
    @property
    def source(self) -> str: ...
    @property
    def note(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def range_nm(self) -> tuple[float, float] | None: ...
    @property
    def extension(self) -> str | None: ...
    @property
    def constant_index(self) -> tuple[float, float] | None: ...
    def index(self, wavelength_nm: _F64, hold: bool, shape: tuple[int, ...]) -> _C128: ...
    def index_extended(self, wavelength_nm: _F64) -> tuple[_C128, bool]: ...

def media_names() -> list[str]: ...

# --- stack

def stack_evaluate(
    quantity: str,
    polarization: str,
    indices: _C128,
    media: list[int],
    coherent: list[bool],
    arguments: list[tuple[_F64, list[int]]],
    shape: list[int],
    out: _F64,
    second: _F64 | None,
    threads: int | None,
) -> None: ...
