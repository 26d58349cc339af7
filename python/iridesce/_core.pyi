"""Types of the compiled core. Private: the public modules check and document, then call these."""

import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

_F64 = npt.NDArray[np.float64]
_Progress = Callable[[int, int, str], object]
_C128 = npt.NDArray[np.complex128]
_F32 = npt.NDArray[np.float32]
_Path = str | os.PathLike[str]
_Facts = list[tuple[str, str | int | float]]
_Report = tuple[str, list[tuple[str, str, str, str]], list[str], list[str]]

__version__: str

# --- medium

MEDIUM_TEXT_BYTES: int

def argument_words(argument: str, allowed: str, given: str, place: str) -> str: ...
def range_words(low: float, includes_low: bool, high: float) -> str: ...

class Medium:
    @staticmethod
    def constant(n: float, k: float) -> Medium: ...
    @staticmethod
    def named(name: str) -> Medium: ...
    @staticmethod
    def from_bytes(bytes: bytes, label: str) -> tuple[Medium, str, _Report]: ...
    @staticmethod
    def mixture(
        first: Medium, second: Medium, first_volume: float, second_volume: float, rule: str, name: str
    ) -> Medium: ...
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
    def from_bytes(bytes: bytes, label: str) -> tuple[Illuminant, _Report]: ...
    @property
    def name(self) -> str: ...
    @property
    def lines(self) -> list[tuple[float, float]]: ...
    def power(self, wavelength_nm: _F64) -> _F64: ...
    def white(self, observer: str) -> list[float]: ...

def illuminant_names() -> list[str]: ...
def color_matching(wavelength_nm: _F64, observer: str) -> _F64: ...
def spectrum_to_xyz(wavelength_nm: _F64, values: _F64, illuminant: Illuminant, observer: str) -> _F64: ...
def convert_color(values: _F64, from_space: str, to_space: str, white: list[float], adaptation: str | None) -> _F64: ...
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
) -> tuple[list[str], float, float]: ...
def dias1991_wavelengths() -> _F64: ...
def dias1991(
    indices: _C128,
    thickness_nm: _F64,
    angle_deg: _F64,
    table: str,
    matrix: str | list[list[float]],
) -> tuple[_F64, _F64]: ...

# --- detail

def stack_derivatives(
    quantity: str,
    polarization: str,
    indices: _C128,
    thickness_nm: _F64,
    coherent: list[bool],
    wavelength_nm: _F64,
    angle_deg: _F64,
    values: _F64,
    rows: _F64,
) -> None: ...
def stack_layer_airy(
    polarization: str,
    indices: _C128,
    thickness_nm: _F64,
    wavelength_nm: _F64,
    angle_deg: _F64,
    layer: int,
    out: _C128,
) -> None: ...
def stack_averaged(
    quantity: str,
    polarization: str,
    media: list[Medium],
    coherent: list[bool],
    lines: list[tuple[str, float]],
    thickness_sd_nm: list[float],
    tolerance: float,
    wavelength_nm: _F64,
    angle_deg: _F64,
    thickness_nm: _F64,
) -> tuple[_F64, _F64]: ...
def stack_mueller(
    direction: str,
    indices: _C128,
    thickness_nm: _F64,
    coherent: list[bool],
    wavelength_nm: _F64,
    angle_deg: _F64,
    out: _F64,
) -> None: ...
def two_beam_purity(n: _F64, shape: list[int]) -> _F64: ...
def graded_slices(
    index_at: Callable[[float], _C128], wavelength_nm: _F64, thickness_nm: float, tolerance: float
) -> int: ...
def color_parts(media: list[Medium], coherent: list[bool], thickness_nm: _F64, angle_deg: _F64) -> list[int]: ...
def stack_fields(
    polarization: str,
    indices: _C128,
    thickness_nm: _F64,
    wavelength_nm: _F64,
    angle_deg: _F64,
    depth_nm: _F64,
    fields: _C128,
    power: _F64,
) -> None: ...
def color_weights(
    illuminant: Illuminant, observer: str, wavelength_nm: _F64 | None, parts: int
) -> tuple[_F64, _F64, tuple[float, float, float], int]: ...
def color_jacobian(xyz: _F64, space: str, white: tuple[float, float, float], adaptation: str | None) -> _F64: ...

class ColorTable:
    @staticmethod
    def build(
        media: list[Medium],
        coherent: list[bool],
        thickness_nm: list[float],
        layer: int,
        range_nm: list[float],
        range_deg: list[float],
        polarization: str,
        illuminant: Illuminant,
        observer: str,
        quantity: str,
        max_delta_e: float,
        progress: _Progress | None,
    ) -> tuple[ColorTable, list[str]]: ...
    def evaluate(
        self,
        thickness_nm: _F64,
        angle_deg: _F64,
        space: str,
        adaptation: str | None,
        gamut: str | None,
        out: _F64,
        threads: int | None,
    ) -> None: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def range_nm(self) -> tuple[float, float]: ...
    @property
    def range_deg(self) -> tuple[float, float]: ...
    @property
    def delta_e(self) -> tuple[float, float, int]: ...

def color_tables_read(bytes: bytes) -> list[tuple[ColorTable, list[tuple[str, str]]]]: ...
def color_tables_bytes(tables: list[tuple[ColorTable, str, _Facts]]) -> bytes: ...
def color_tables_save(path: _Path, tables: list[tuple[ColorTable, str, _Facts]]) -> None: ...

# --- films that flow

class Flow:
    def __new__(
        cls,
        preset: str,
        columns: int | None,
        seed: int,
        changes: list[tuple[str, float]],
        checkpoint: bytes | None,
        initial: ThicknessMap | None,
        sides: str | None,
    ) -> Flow: ...
    def advance_to(self, time_s: float, progress: _Progress | None) -> None: ...
    def thickness_nm(self) -> _F64: ...
    def map(self, columns: int | None) -> _F64: ...
    def black_share(self) -> _F64 | None: ...
    def facts(self) -> dict[str, float | None]: ...
    def summary(self) -> list[float]: ...
    def profile(self) -> _F64: ...
    def checkpoint(self) -> bytes: ...
    def sides(self) -> str | None: ...
    def parameters(self) -> list[tuple[str, float]]: ...

class FlowContext:
    def __new__(cls) -> FlowContext: ...

def flow_map(
    context: FlowContext,
    preset: str,
    time_s: float,
    seed: int,
    columns: int | None,
    width: int,
    height: int,
    progress: _Progress | None,
) -> _F64: ...
def flow_presets() -> list[str]: ...

# --- thickness

class Thickness:
    @staticmethod
    def uniform(thickness_nm: float) -> Thickness: ...
    @staticmethod
    def gradient(top: float, bottom: float, exponent: float) -> Thickness: ...
    @staticmethod
    def wedge(
        from_point: tuple[float, float, float], to_point: tuple[float, float, float], start_nm: float, end_nm: float
    ) -> Thickness: ...
    @staticmethod
    def lens_gap(radius_mm: float, contact_gap_nm: float) -> Thickness: ...
    def at_height(self, s: _F64) -> _F64: ...
    def at_point(self, points: _F64) -> _F64: ...
    def at_radius(self, distance_mm: _F64) -> _F64: ...
    def map(self, width: int, height: int, extent: tuple[float, float, float, float] | None) -> _F64: ...

class ThicknessMap:
    def __new__(cls, thickness_nm: _F64) -> ThicknessMap: ...
    def sample(self, u: _F64, v: _F64) -> _F64: ...
    def exr_bytes(self) -> bytes: ...

def load_thickness_map(
    path: _Path, min_nm: float | None, max_nm: float | None, channel: str | None, page: int | None
) -> tuple[_F64, _Report]: ...

# --- inverse

def inverse_evidence(
    wavelength_nm: _F64,
    values: _F64,
    sd: _F64,
    spectra: _F64,
    smooth: list[tuple[float, float, float]],
    nuisance: _F64,
) -> _F64: ...
def inverse_explain(
    wavelength_nm: _F64,
    values: _F64,
    sd: _F64,
    spectrum: _F64,
    smooth: list[tuple[float, float, float]],
    nuisance: _F64,
) -> tuple[_F64, _F64]: ...
def picture_noise(pixels: _F32, width: int, mask: npt.NDArray[np.bool_] | None) -> _F64: ...
def picture_exposures(
    pixels: _F32,
    table_of: npt.NDArray[np.uint8] | None,
    channels: _F32,
    first_nm: float,
    step_nm: float,
    exposed: list[float],
    threads: int | None,
    progress: Callable[..., object] | None,
) -> list[_F64]: ...
def picture_agreement(
    pixels: _F32,
    table_of: npt.NDArray[np.uint8] | None,
    channels: _F32,
    first_nm: float,
    step_nm: float,
    exposed: list[float],
    thickness_nm: _F32,
    reach_nm: float,
) -> _F32: ...
def picture_neighbourhood(
    pixels: _F32,
    width: int,
    table_of: npt.NDArray[np.uint8] | None,
    mask: npt.NDArray[np.bool_] | None,
    channels: _F32,
    first_nm: float,
    step_nm: float,
    exposed: list[float],
    quarter_nm: float,
    threads: int | None,
) -> tuple[float, float, float, bool]: ...
def picture_thickness(
    pixels: _F32,
    width: int,
    table_of: npt.NDArray[np.uint8] | None,
    mask: npt.NDArray[np.bool_] | None,
    channels: _F32,
    first_nm: float,
    step_nm: float,
    exposed: list[float],
    neighbours: tuple[float, float, float],
    quarter_nm: float,
    ties: list[tuple[int, float]],
    prior: tuple[_F32, _F32, float] | None,
    threads: int | None,
    progress: Callable[..., object] | None,
) -> tuple[_F32, _F32, _F32, _F32, _F32, npt.NDArray[np.uint8], list[bool]]: ...

# --- scene

class Scene:
    @staticmethod
    def builtin(name: str) -> Scene: ...
    @staticmethod
    def load(path: _Path, allow_outside: bool) -> Scene: ...
    @staticmethod
    def from_dict(tree: Mapping[str, Any], folder: _Path, file: _Path | None, allow_outside: bool) -> Scene: ...
    def to_dict(self) -> dict[str, Any]: ...
    def to_json(self) -> str: ...
    def with_value(self, path: str, value: Any) -> Scene: ...
    def resolve(self, progress: _Progress | None) -> None: ...
    def body(
        self, object: int
    ) -> tuple[
        tuple[_F64, _F32 | None, _F32 | None, list[float] | None, npt.NDArray[np.uint32], list[str]] | None, _F64
    ]: ...
    def standing(self, preset: str, seed: int, columns: int | None) -> bytes | None: ...
    def stand(self, preset: str, seed: int, columns: int | None, bytes: bytes) -> None: ...
    def extended_media(self) -> list[str]: ...
    def films_on_faces(self) -> list[tuple[int, int]]: ...
    def notes(self) -> list[str]: ...
    @property
    def file(self) -> os.PathLike[str] | None: ...
    @property
    def folder(self) -> os.PathLike[str] | None: ...
    @property
    def allow_outside(self) -> bool: ...

def scene_schema() -> str: ...
def scene_names() -> list[str]: ...
def scene_text(name: str) -> str: ...

# --- render

SIMD_LEVEL: str
MAX_SAMPLES: int
MOST_SLABS: int
REC709_LUMINANCE: list[float]
VISIBLE_NM: tuple[float, float]

MOST_SHARDS: int
TILE_SIDE: int

def render_scene(
    scene: Scene, asked: Mapping[str, Any], progress: _Progress | None
) -> tuple[
    _F32,
    dict[str, Any],
    dict[str, Any],
    tuple[int, int, float, str, int],
    tuple[int, int, int, int] | None,
    list[str],
]: ...
def journal_head(path: _Path) -> bytes | None: ...
def render_tiles(size: tuple[int, int]) -> list[tuple[int, int, int, int]]: ...
def develop_image(xyz: _F32, space: str, exposure: float, gamut: str) -> tuple[_F32, float, float]: ...
def auto_exposure(xyz: _F32, depth: _F32) -> float: ...
def save_png(path: _Path, rgb: _F32, bits: int, space: str, facts_: _Facts, is_quick: bool) -> None: ...
def png_bytes(rgb: _F32, space: str) -> bytes: ...
def save_exr(
    path: _Path, xyz: _F32, is_half: bool, planes: list[tuple[list[str], Any, bool]], facts_: _Facts
) -> None: ...
def load_exr(bytes: bytes) -> tuple[list[tuple[str, _F32, bool]], dict[str, Any], tuple[float, ...] | None]: ...
def check_output(path: _Path) -> None: ...
def write_file(path: _Path, bytes: bytes) -> None: ...

# --- files

MAX_SPECTRUM_BYTES: int
MAX_LAMP_BYTES: int

def read_file(path: _Path, limit: int) -> bytes: ...
def read_spectrum(
    bytes: bytes,
    column: str | None,
    wavelength_column: str | None,
    unit: str | None,
    unit_y: str | None,
    quantity: str,
    range_nm: tuple[float, float] | None,
) -> tuple[_F64, _F64, str, _Report]: ...
def picture_fault(bytes: bytes, width: int, height: int) -> str | None: ...
def read_photograph(
    path: _Path, channel: str | None, page: int | None
) -> tuple[_F32, npt.NDArray[np.bool_], _Report]: ...
def photograph_size(path: _Path) -> tuple[int, int] | None: ...
def read_environment(path: _Path, layer: str | None) -> tuple[_F32, _Report]: ...
def harmless(message: str) -> str: ...

# --- worker threads

def threads() -> int: ...
