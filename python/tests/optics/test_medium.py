"""Media: published values, ranges and sources, files in every state, hostile arguments."""

from __future__ import annotations

import copy
import hashlib
import json
import pickle
import re
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import iridesce as ir
from conftest import ROOT
from iridesce import _core
from iridesce.optics.medium import MediumName

OPTICS = ROOT / "crates" / "optics"
COLOUR_REFERENCE = json.loads((OPTICS / "tests" / "reference" / "colour_reference.json").read_text())
CHECK_VALUES = COLOUR_REFERENCE["materials"]["check_values"]
OUR_NAME = {"Si_Green2008": "Si", "SiO2_Malitson": "SiO2", "Ti_Johnson": "Ti", "TiO2_Siefke": "TiO2-siefke"}

FOUNDATION = [
    "vacuum",
    "air",
    "air-ciddor",
    "water",
    "soap",
    "N-BK7",
    "SiO2",
    "MgF2",
    "TiO2",
    "TiO2-siefke",
    "rutile-o",
    "rutile-e",
    "Si",
    "Ti",
    "Al",
    "Ag",
    "Au",
    "Fe",
    "Fe3O4",
]

CLEAR = [*FOUNDATION[:8], "F2", "soda-lime", "sapphire-o", "soap-glycerol-20"]

GLASS = "nm,n,k\n400,1.5,0\n500,1.4,0.1\n600,1.3,0.3\n"


@pytest.fixture
def write(tmp_path: Path) -> Any:
    def write(content: str | bytes, name: str = "m.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


# --- numbers


@pytest.mark.parametrize("page", CHECK_VALUES)
def test_check_values_of_the_colour_reference(page: str) -> None:
    medium = ir.Medium(OUR_NAME[page])
    wavelengths = [float(nm) for nm in CHECK_VALUES[page]]
    wanted = np.array([complex(n, k) for n, k in CHECK_VALUES[page].values()])
    got = medium.index(wavelengths)
    # Interpolating in nm instead of um moves the last bits only.
    np.testing.assert_allclose(got.real, wanted.real, rtol=5e-16)
    np.testing.assert_allclose(got.imag, wanted.imag, rtol=5e-15)


def test_check_values_name_media_that_exist() -> None:
    assert set(CHECK_VALUES) == set(OUR_NAME)


@pytest.mark.parametrize(
    ("name", "wavelength_nm", "index", "digit"),
    [
        # n_d of the SCHOTT data sheet; water of the paper's table at 20 C; quartz glass of Malitson's table;
        # D line of Dodge; printed rows of Johnson & Christy.
        ("N-BK7", 587.5618, 1.51680, 1e-5),
        ("water", 589.3, 1.33335, 1e-5),
        ("SiO2", 587.561798, 1.458464, 1e-6),
        ("MgF2", 589.3, 1.37771, 1e-5),
        ("air-ciddor", 589.3, 1.00027715, 1e-8),
        ("rutile-o", 589.3, 2.61291, 1e-5),
        ("rutile-e", 589.3, 2.90865, 1e-5),
        ("Ag", 659.5, 0.05 + 4.483j, 1e-12),
        ("Au", 520.9, 0.62 + 2.081j, 1e-12),
        ("Ti", 582.0, 2.6 + 3.58j, 1e-12),
        ("Fe", 582.0, 2.94 + 2.99j, 1e-12),
        ("Fe3O4", 580.0, 2.342 + 0.125j, 1e-12),
        ("Al", 563.57, 1.073 + 6.784j, 1e-3),
        ("TiO2", 553.5, 2.447, 1e-3),
        ("Si", 620.0, 3.898 + 0.01737j, 1e-5),
        ("Cu", 582.1, 0.70 + 2.704j, 1e-12),
        ("glycerol", 589.3, 1.47220, 1e-5),
        ("sapphire-o", 589.3, 1.76808, 1e-5),
        ("ZnS", 589.3, 2.36694, 1e-5),
        ("soap-glycerol-40", 589.3, 1.3845, 1e-3),
    ],
)
def test_published_values(name: str, wavelength_nm: float, index: complex, digit: float) -> None:
    got = ir.Medium(name).index(wavelength_nm)
    assert abs(got.real - complex(index).real) <= digit / 2 * 1.01
    assert abs(got.imag - complex(index).imag) <= digit / 2 * 1.01


# Apparent specific gravity 20/20 C of glycerol in water by per cent by mass: Lange's Handbook of Chemistry, 15th edition,
# table 5.13.
GLYCEROL_SPECIFIC_GRAVITY = {10: 1.02395, 20: 1.04880, 30: 1.07470, 40: 1.10135, 50: 1.12845, 60: 1.15605}
WATER_20C, AIR = 0.99821, 0.0012  # g/cm^3


def glycerol_density_model(mass_fraction: float, celsius: float = 20.0) -> float:
    """Density in g/cm^3: Volk & Kaehler, Experiments in Fluids 59, 75 (2018)."""
    glycerol = 1273.3 - 0.6121 * celsius
    water = 1000.0 * (1.0 - (abs(celsius - 3.98) / 615.0) ** 1.71)
    depth = 1.78e-6 * celsius**2 - 1.82e-4 * celsius + 1.41e-2
    contraction = 1.0 + (depth * np.sin(mass_fraction**1.31 * np.pi) ** 0.81)
    return contraction / (mass_fraction / glycerol + (1.0 - mass_fraction) / water) / 1000.0


@pytest.mark.parametrize("percent", GLYCEROL_SPECIFIC_GRAVITY)
def test_glycerol_solutions_have_the_published_density(percent: int) -> None:
    """The density that the index of a solution implies, against a table and a model."""
    nm, w = 600.0, percent / 100.0

    def refraction(name: str) -> float:
        square = ir.Medium(name).index(nm).real ** 2
        return (square - 1.0) / (square + 2.0)

    per_gram = w * refraction("glycerol") / 1.2580 + (1.0 - w) * refraction("water") / 0.9982
    density = refraction(f"soap-glycerol-{percent}") / per_gram
    # In air a weighing finds less by the air that the body displaces.
    table = GLYCEROL_SPECIFIC_GRAVITY[percent] * (WATER_20C - AIR) + AIR
    assert density == pytest.approx(table, abs=6e-5)  # four decimals, and the last digit of the table
    assert density == pytest.approx(glycerol_density_model(w), abs=3.5e-4)
    assert glycerol_density_model(1.0, 25.0) == pytest.approx(1.2580, abs=5e-5)


def test_soap_is_water_and_air_is_one() -> None:
    nm = np.linspace(360.0, 830.0, 95)
    np.testing.assert_array_equal(ir.Medium("soap").index(nm), ir.Medium("water").index(nm))
    for name in ("air", "vacuum"):
        np.testing.assert_array_equal(ir.Medium(name).index([1.0, 550.0, 1e9]), 1.0)


def test_glass_is_window_glass_in_python_and_in_stack_texts() -> None:
    slab = ir.Layer("glass", thickness_nm=1e6, coherent=False)
    assert ir.Medium("glass") == ir.Medium("soda-lime") == slab.medium
    assert ir.Stack.parse("air / glass 1e6 incoherent / air") == ir.Stack(["air", slab, "air"])


def test_clear_media_are_clear() -> None:
    """Light may enter from these, so k must be exactly 0."""
    for name in CLEAR:
        indices, _ = ir.Medium(name)._core.index_extended(np.arange(360.0, 831.0))
        assert np.all(indices.imag == 0.0), name


# --- the list of media


def test_media_know_source_range_and_kind() -> None:
    names = ir.media()
    assert set(FOUNDATION) <= set(names)
    assert len(names) == len(set(names))
    for name in names:
        assert isinstance(name, str)
        medium = ir.Medium(name)
        assert (name.source, name.kind, name.range_nm) == (medium.source, medium.kind, medium.range_nm)
        assert (name.note, name.extension, medium.name) == (medium.note, medium.extension, name)
        if name.range_nm is not None:
            low, high = name.range_nm
            assert np.all(np.isfinite(medium.index([low, high])))
            assert re.search(r"\(\d{4}\)|SCHOTT", name.source), name.source
    assert {name for name in names if name.range_nm is None} == {"vacuum", "air"}
    assert pickle.loads(pickle.dumps(names)) == names
    assert type(pickle.loads(pickle.dumps(names))[0]) is MediumName


def test_extensions_are_stated_where_data_stop_inside_the_visible() -> None:
    stated = {str(name): name.extension for name in ir.media() if name.extension}
    assert stated["rutile-o"] == stated["rutile-e"] == "360-430 nm: the dispersion formula is continued"
    assert stated["TiO2"] == "827-830 nm: the end value of the table is held"
    for name in ir.media():
        low, high = name.range_nm or (0.0, np.inf)
        assert (name.extension is not None) == (low > 360.0 or high < 830.0), name
        indices, extended = ir.Medium(name)._core.index_extended(np.arange(360.0, 831.0))
        assert extended == (name.extension is not None), name
        assert np.all(indices.real > 0.0), name


def test_extension_of_user_media_is_refused(write: Any) -> None:
    medium = ir.Medium.from_file(write(GLASS))
    assert medium.extension is None
    with pytest.raises(ValueError, match=r"360\.0 nm was asked\. Colour sums and renders continue only built-in media"):
        medium._core.index_extended(np.array([500.0, 360.0]))


def test_sources_list_every_file_with_its_checksum() -> None:
    folder = OPTICS / "data" / "media"
    listed = dict(
        re.findall(r"^\| `([^`]+)` \| `[^`]+` \| `([0-9a-f]{64})` \|$", (folder / "SOURCES.md").read_text(), re.M)
    )
    files = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.glob("*.yml")}
    assert listed == files
    assert "CC0" in (folder / "SOURCES.md").read_text()


# --- shapes and types of the wavelength


def test_shapes_and_types() -> None:
    glass = ir.Medium("N-BK7")
    scalar = glass.index(550.0)
    assert isinstance(scalar, np.complex128)
    assert isinstance(scalar, complex)
    for value in (550, np.float32(550.0), np.int16(550), np.array(550.0), np.longdouble(550)):
        got = glass.index(value)
        assert isinstance(got, np.complex128)
        assert got == scalar
    grid = np.linspace(400.0, 700.0, 12).reshape(3, 4)
    got = glass.index(grid)
    assert got.dtype == np.complex128
    assert got.shape == (3, 4)
    assert got.flags.writeable
    np.testing.assert_array_equal(got, [[glass.index(nm) for nm in row] for row in grid])
    # Views: transposed, strided, reversed, broadcast, other byte order.
    np.testing.assert_array_equal(glass.index(grid.T), got.T)
    np.testing.assert_array_equal(glass.index(grid[::2, ::-1]), got[::2, ::-1])
    np.testing.assert_array_equal(glass.index(np.broadcast_to(grid[0], (5, 4))), np.broadcast_to(got[0], (5, 4)))
    np.testing.assert_array_equal(glass.index(grid.astype(">f8")), got)
    np.testing.assert_array_equal(glass.index(grid.tolist()), got)
    for empty in ([], np.empty((0, 3)), np.empty((2, 0, 4))):
        got = glass.index(empty)
        assert got.shape == np.shape(empty)
        assert got.dtype == np.complex128


def test_input_is_not_modified() -> None:
    nm = np.array([[500.0, 600.0]])
    nm.flags.writeable = False
    ir.Medium("Ag").index(nm)
    np.testing.assert_array_equal(nm, [[500.0, 600.0]])


@pytest.mark.parametrize(
    "wrong",
    [
        None,
        "550",
        ["a"],
        [None, 550.0],
        550.0 + 0j,
        [550.0 + 1j],
        True,
        [True, False],
        [[1.0, 2.0], [3.0]],
        {"nm": 550},
        object(),
        np.array(["2020-01-01"], dtype="datetime64[D]"),
        [10**400],
        b"550",
    ],
)
def test_wavelengths_that_are_no_real_numbers(wrong: Any) -> None:
    with pytest.raises(ValueError, match="wavelength_nm must be"):
        ir.Medium("Ag").index(wrong)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 0.0, -1.0])
@pytest.mark.parametrize("name", ["Ag", "N-BK7", "air"])
@pytest.mark.parametrize("extrapolate", [None, "hold"])
def test_wavelengths_that_are_no_lengths(bad: float, name: str, extrapolate: Any) -> None:
    nm = np.full((4, 8), 550.0)
    nm[3, 7] = bad
    shown = {np.inf: "inf", -np.inf: "-inf"}.get(bad, "NaN" if np.isnan(bad) else repr(float(bad)))
    message = re.escape(f"wavelength_nm must be > 0 and finite, got {shown} at index (3, 7)")
    with pytest.raises(ValueError, match=message):
        ir.Medium(name).index(nm, extrapolate=extrapolate)
    with pytest.raises(ValueError, match=re.escape(f"got {shown}") + "$"):
        ir.Medium(name).index(bad, extrapolate=extrapolate)


def test_place_of_a_wrong_wavelength_in_a_long_array() -> None:
    nm = np.full(100_000, 550.0)
    nm[70_001] = -1.0
    with pytest.raises(ValueError, match=r"got -1.0 at index \(70001,\)$"):
        ir.Medium("Ag").index(nm)
    with pytest.raises(ValueError, match=r"got -1.0 at index \(1, 0, 20001\)$"):
        ir.Medium("Ag").index(nm.reshape(2, 1, 50_000))


def test_outside_the_data() -> None:
    silver = ir.Medium("Ag")
    message = (
        'medium "Ag" has data for 188-1937 nm; 2000.0 nm was asked. Pass extrapolate="hold" to accept the end value'
    )
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        silver.index(2000.0)
    with pytest.raises(ValueError, match=re.escape("2000.0 nm was asked at index (0, 1). Pass")):
        silver.index([[500.0, 2000.0]])
    low, high = silver.range_nm or (0.0, 0.0)
    held = silver.index([1.0, 1e7], extrapolate="hold")
    np.testing.assert_array_equal(held, silver.index([low, high]))
    for wrong in ("linear", "", True, 0, "HOLD"):
        with pytest.raises(ValueError, match='extrapolate must be None or "hold"'):
            silver.index(500.0, extrapolate=wrong)  # type: ignore[arg-type]


# --- making a medium


def test_constants() -> None:
    for value in (1.5, np.float32(1.5), np.float64(1.5), Fraction(3, 2), Decimal("1.5"), np.array(1.5), 1.5 - 0j):
        assert ir.Medium(value) == ir.Medium(1.5)  # type: ignore[arg-type]
    metal = ir.Medium(2.0 + 3.0j)
    assert metal.index(np.ones((2, 3)) * 550.0).tolist() == [[2 + 3j] * 3] * 2
    assert (metal.kind, metal.range_nm, metal.extension) == ("constant", None, None)
    assert ir.Medium(1).index(5.0) == 1.0
    assert ir.Medium(1.5 - 0.1j).index(5.0) == 1.5 - 0.1j
    assert ir.Medium(0 + 2j).index(5.0) == 2j


@pytest.mark.parametrize(
    "wrong", [np.nan, np.inf, -np.inf, 0, 0.0, -1.5, -1.5 + 2j, complex(1, np.nan), complex(1, -np.inf), 1e300, 1e-300]
)
def test_indices_out_of_range(wrong: Any) -> None:
    with pytest.raises(ValueError, match="the index of a medium must have n >= 0"):
        ir.Medium(wrong)


@pytest.mark.parametrize(
    "wrong",
    [None, True, np.True_, b"air", [1.5], (1.5, 0.1), {}, np.array([1.5]), np.array("air"), object(), Path("x.yml"),
     10**400, float, Decimal("sNaN")],
)  # fmt: skip
def test_what_is_no_medium(wrong: Any) -> None:
    with pytest.raises(ValueError, match="a medium is a built-in name, a real or complex number or a Medium, got"):
        ir.Medium(wrong)


def test_unknown_names() -> None:
    for wrong, hint in [
        ("sopa", "soap"),
        ("n-bk7", "N-BK7"),
        ("siO2", "SiO2"),
        ("rutile", "rutile-"),
        ("Water", "water"),
    ]:
        with pytest.raises(ValueError, match=f'unknown medium "{wrong}"; did you mean "{hint}'):
            ir.Medium(wrong)
    with pytest.raises(ValueError, match=r"Known: vacuum, air, .*\. A file is read by Medium.from_file\(path\)"):
        ir.Medium("glass.yml")
    for wrong in ("", " ", "\0", "\ud800", "x" * 100_000):
        with pytest.raises(ValueError, match="unknown medium") as info:
            ir.Medium(wrong)
        assert wrong[:1] != "x" or len(str(info.value)) < 2000


def test_equal_hash_copy_pickle_repr(write: Any) -> None:
    path = write(GLASS)
    file = ir.Medium.from_file(path)
    media = [ir.Medium("soap"), ir.Medium("water"), ir.Medium(1.33), ir.Medium(2 + 3j), ir.Medium("Ag"), file]
    assert len(set(media)) == len(media)
    for medium in media:
        for twin in (pickle.loads(pickle.dumps(medium)), copy.copy(medium), copy.deepcopy(medium), ir.Medium(medium)):
            assert twin == medium
            assert hash(twin) == hash(medium)
            assert (twin.name, twin.source, twin.kind) == (medium.name, medium.source, medium.kind)
            assert twin.index(450.0) == medium.index(450.0)
    assert ir.Medium("soap") != "soap"
    assert ir.Medium(1.33) != 1.33
    assert [repr(medium) for medium in media[1:4]] == ["Medium('water')", "Medium(1.33)", "Medium((2+3j))"]
    assert repr(file) == f"Medium.from_file({str(path)!r})"
    with pytest.raises(AttributeError):
        file.name = "other"  # type: ignore[misc]
    # Once read, the file is not needed.
    path.unlink()
    assert pickle.loads(pickle.dumps(file)).index(450.0) == file.index(450.0)


# --- files


def test_csv_file(write: Any) -> None:
    path = write(GLASS)
    for argument in (path, str(path)):
        medium = ir.Medium.from_file(argument)
        assert (medium.name, medium.range_nm, medium.kind) == (str(path), (400.0, 600.0), "table")
        np.testing.assert_allclose(medium.index([400.0, 450.0, 575.0]), [1.5, 1.45 + 0.05j, 1.325 + 0.25j], rtol=1e-15)
    for text in (
        "600;1.3\r\n400;1.5\r\n",
        "\ufeff400\t1.5\n600\t1.3",
        "# made up\n\nwavelength n\n400 1.5\n 600  1.3 # x\n",
    ):
        assert ir.Medium.from_file(write(text, "m.txt")).index(500.0) == pytest.approx(1.4)


def test_yaml_file_is_recognised_by_content_or_suffix(write: Any) -> None:
    page = (OPTICS / "data" / "media" / "SiO2.yml").read_bytes()
    wanted = ir.Medium("SiO2").index(np.arange(360.0, 831.0))
    for name in ("silica.yml", "silica.YAML", "silica", "silica.csv"):
        medium = ir.Medium.from_file(write(page, name))
        np.testing.assert_array_equal(medium.index(np.arange(360.0, 831.0)), wanted)
        assert medium.source == ir.Medium("SiO2").source
        assert "Malitson" in medium.source
        assert "<" not in medium.source


def test_formula_and_table_of_another_range(write: Any) -> None:
    text = (
        "DATA:\n  - type: formula 5\n    wavelength_range: 0.3 2.5\n    coefficients: 1.5 0.01 -2\n"
        "  - type: tabulated k\n    data: |\n        0.4 0.2\n        0.6 0.4\n"
    )
    medium = ir.Medium.from_file(write(text, "m.yml"))
    assert (medium.kind, medium.range_nm) == ("formula and table", (400.0, 600.0))
    assert medium.index(500.0) == pytest.approx(1.54 + 0.3j, rel=1e-15)
    with pytest.raises(ValueError, match=r"has data for 400-600 nm; 350\.0 nm was asked"):
        medium.index(350.0)
    # Held: each at the end of its own data.
    assert medium.index(1000.0, extrapolate="hold") == pytest.approx(1.51 + 0.4j, rel=1e-15)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("m.csv", b"", ": holds no rows of nm, n"),
        ("m.csv", b"nm,n\n400,1.5\n500,abc\n", ':3: "abc" is not a finite number'),
        ("m.csv", b"400,1.5\n500,nan\n", ':2: "nan" is not a finite number'),
        ("m.csv", b"400,1.5\n500,-1\n", ":2: n must be >= 0"),
        ("m.csv", b"400,1.5\n500\n", ":2: a row holds nm, n and perhaps k"),
        ("m.csv", b"400,1.5\n400,1.6\n", ":2: the wavelength 400 nm stands on line 1 too"),
        ("m.csv", b"THz (THz),n\n0.4,1.5\n", ':1: the axis "THz (THz)" is in "thz"'),
        ("m.csv", b"nm,R\n400,1.5\n", ':1: the column "R" is neither n nor k'),
        ("m.csv", b"400,1.5\n\xff\xfe,1.5", ':2: "\xff\xfe" is not a finite number'),
        ("m.csv", b"400,1.5\n500,1.5\x00\n", ": holds no table of numbers: it is a binary file"),
        ("m.yml", b"", ":"),
        ("m.yml", b"400,1.5\n", ": is no page of the refractiveindex.info database"),
        ("m.yml", b"DATA:\n  - type: 'tabulated", ":2: not YAML"),
        ("m.yml", b"DATA:\n  - type: tabulated nk\n    data: |\n        0.4 1.5\n", ":4: a row holds wavelength"),
        ("m.yml", b"DATA:\n  - type: tabulated k\n    data: |\n        0.4 1.5\n", ": holds no refractive index n"),
        ("m.yml", b"a: &a [1]\nDATA: *a\n", ":2: aliases"),
        ("m.yml", b"\x89PNG\r\n\x1a\n\0\0", ": holds no table of numbers: it is a PNG picture"),
        ("m.yml", b"[" * 1_000_000, ":1: "),
    ],
)  # fmt: skip
def test_broken_files(write: Any, name: str, content: bytes, message: str) -> None:
    path = write(content, name)
    with pytest.raises(ValueError, match=re.escape(str(path) + message)):
        ir.Medium.from_file(path)


def test_truncated_page(write: Any) -> None:
    """A page cut short is refused or holds what is left; it never gives a number that the whole page does not."""
    page = (OPTICS / "data" / "media" / "Ti.yml").read_bytes()
    whole = ir.Medium("Ti")
    refused = 0
    for end in range(0, len(page), 7):
        path = write(page[:end], "cut.yml")
        try:
            cut = ir.Medium.from_file(path)
        except ValueError as error:
            assert str(error).startswith(str(path))  # noqa: PT017
            refused += 1
            continue
        assert cut.range_nm is not None
        low, high = cut.range_nm
        inside = np.linspace(low, whole.range_nm[1] if high > 1937.0 else high, 5)[:-1]  # type: ignore[index]
        np.testing.assert_allclose(cut.index(inside), whole.index(inside), rtol=0.35)
    assert refused > 50


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"nothing\.yml: no such file"):
        ir.Medium.from_file(tmp_path / "nothing.yml")
    with pytest.raises(ValueError, match="is a folder, not a file"):
        ir.Medium.from_file(tmp_path)
    with pytest.raises(ValueError, match="cannot be read"):
        ir.Medium.from_file(tmp_path / ("x" * 5000))
    with pytest.raises(ValueError, match="null byte"):
        ir.Medium.from_file("a\0b")
    for wrong in (None, 5, ["x"], 1.5):
        with pytest.raises(ValueError, match="path must be a path, got"):
            ir.Medium.from_file(wrong)  # type: ignore[arg-type]


def test_huge_file(tmp_path: Path) -> None:
    path = tmp_path / "huge.csv"
    with path.open("wb") as file:
        file.truncate(1 << 40)  # a hole: a terabyte that takes no room
    with pytest.raises(ValueError, match="longer than 16 MiB"):
        ir.Medium.from_file(path)
    # Cut within a letter, it is still too long rather than no text.
    path.write_text("é" * (9 << 20), encoding="utf-8")
    with pytest.raises(ValueError, match="longer than 16 MiB"):
        ir.Medium.from_file(path)
    assert _core.MEDIUM_TEXT_BYTES == 16 << 20


def test_dispersion_formula_without_an_index(write: Any) -> None:
    text = "DATA:\n  - type: formula 1\n    wavelength_range: 0.3 0.9\n    coefficients: 0 1 0.6\n"
    medium = ir.Medium.from_file(write(text, "m.yml"))
    with pytest.raises(
        ValueError, match=r"gives no refractive index at 500.0 nm at index \(1,\): its dispersion formula has"
    ):
        medium.index([700.0, 500.0])
