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
    indices: list[_C128],
    media: list[int],
    coherent: list[bool],
    arguments: list[tuple[_F64, list[int]]],
    shape: list[int],
    out: _F64,
    second: _F64 | None,
    threads: int | None,
) -> None: ...

# --- color

class Illuminant:
    @staticmethod
    def named(name: str) -> Illuminant: ...
    @staticmethod
    def from_csv(text: str, label: str) -> Illuminant: ...
    @property
    def name(self) -> str: ...
    @property
    def lines(self) -> list[tuple[float, float]]: ...
    def power(self, wavelength_nm: _F64) -> _F64: ...
    def white(self, observer: str) -> list[float]: ...

def illuminant_names() -> list[str]: ...
def color_matching(wavelength_nm: _F64, observer: str) -> _F64: ...
def spectrum_to_xyz(wavelength_nm: _F64, values: _F64, illuminant: Illuminant, observer: str) -> _F64: ...
def convert_color(
    values: _F64, from_space: str, to_space: str, white: list[float], adaptation: str | None
) -> _F64: ...
def rgb_matrix(space: str) -> list[list[float]] | None: ...
def delta_e(lab_a: _F64, lab_b: _F64) -> _F64: ...
def map_gamut(values: _F64, space: str, gamut: str) -> tuple[_F64, int]: ...
def stack_color(
    media: list[Medium],
    coherent: list[bool],
    thickness_nm: _F64,
    angle_deg: _F64,
    polarization: str,
    illuminant: Illuminant,
    observer: str,
    space: str,
    quantity: str,
    model: str,
    wavelength_nm: _F64 | None,
    adaptation: str | None,
    gamut: str | None,
    out: _F64,
) -> tuple[list[str], float]: ...
def dias1991_wavelengths() -> _F64: ...
def dias1991(
    indices: _C128,
    thickness_nm: _F64,
    angle_deg: _F64,
    table: str,
    matrix: str | list[list[float]],
) -> tuple[_F64, _F64]: ...
