"""Charts against pictures of them: the truth is right, each fault is named when it is made, two alike are not guessed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from conftest import Run
from iridesce.exchange import exr, faults, png, suite

T = np.linspace(50.0, 1200.0, 24)[None, :]
ANGLE = np.array([0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0])[:, None]
TO_RGB = ir.color.rgb_matrix("linear-srgb")
STACKS = {
    "C1": ("air", "soap", "air"),
    "C3": ("air", 1.47, "water"),
    "C4": ("air", "MgF2", "N-BK7"),
    "C5": ("air", "SiO2", "Si"),
    "C6": ("air", "TiO2", "Ti"),
}


def chart(name: str, t: np.ndarray = T, angle: np.ndarray = ANGLE, **options: object) -> np.ndarray:
    first, film, last = STACKS[name]
    return ir.Stack([first, ir.Layer(film, t), last]).color(angle_deg=angle, **options)


# --- the truth


@pytest.mark.parametrize("name", STACKS)
def test_the_truth_is_right(name: str) -> None:
    report = ir.validate(chart(name), name)
    assert report.delta_e["max"] < 1e-6 and report.cause is None and "right" in report.text


def test_the_other_charts() -> None:
    soap = ir.Stack(["air", ir.Layer("soap", T), "air"])
    passed = soap.color(angle_deg=ANGLE, quantity="transmittance")
    assert ir.validate(passed, "C2").delta_e["max"] < 1e-6
    assert ir.validate(passed + chart("C1"), "C7").delta_e["max"] < 1e-6
    assert ir.validate(np.broadcast_to(ir.color.illuminant("D65").white(), (7, 24, 3)), "C7").delta_e["max"] < 0.01
    for lamp in ("A", "FL2", "FL11", "LED-B1"):
        seen = chart("C1", illuminant=lamp)
        assert ir.validate(seen, f"C8-{lamp}").delta_e["max"] < 1e-6
        assert ir.validate(seen, "C8").chart == f"C8-{lamp}", "the nearest of the group"
    for nm in (1.0, 2.0, 5.0):
        assert ir.validate(chart("C1", T + nm), "C9").chart == f"C9-{nm:g}nm"
    assert ir.validate(chart("C1"), "c1").chart == "C1"


def test_errors_of_thickness_cost_in_proportion() -> None:
    one, two = (ir.validate(chart("C1", T + nm), "C1").delta_e["mean"] for nm in (1.0, 2.0))
    assert 0.3 < one < 0.7 and two == pytest.approx(2.0 * one, rel=0.1)


# --- each fault, made here from the film's own physics


def airy_schlick(name: str) -> np.ndarray:
    """Schlick's reflectance at both faces, spectra summed: written out for this test."""
    first, film, last = STACKS[name]
    wavelength = np.arange(380.0, 781.0, 2.0)
    n0, n1, n2 = (np.real(ir.Medium(medium).index(wavelength)) for medium in (first, film, last))
    cosine = np.cos(np.radians(ANGLE))[..., None]
    inside = np.sqrt(1.0 - (n0 / n1) ** 2 * (1.0 - cosine**2))
    f1, f2 = ((n1 - n0) / (n1 + n0)) ** 2, ((n2 - n1) / (n2 + n1)) ** 2
    r1 = np.sqrt(f1 + (1 - f1) * (1 - cosine) ** 5) * np.sign(n0 - n1)
    r2 = np.sqrt(f2 + (1 - f2) * (1 - inside) ** 5) * np.sign(n1 - n2)
    phase = np.exp(4j * np.pi * n1 * inside * T[..., None] / wavelength)
    spectrum = np.abs((r1 + r2 * phase) / (1.0 + r1 * r2 * phase)) ** 2
    return ir.color.spectrum_to_xyz(wavelength, spectrum)


def without_k(name: str) -> np.ndarray:
    first, film, last = STACKS[name]
    wavelength = np.arange(380.0, 781.0, 10.0)
    spectrum = [
        ir.Stack([first, ir.Layer(film, T), float(np.real(ir.Medium(last).index(w)))]).reflectance(w, ANGLE)
        for w in wavelength
    ]
    return ir.color.spectrum_to_xyz(wavelength, np.stack(spectrum, axis=-1))


def grey(name: str) -> np.ndarray:
    """nm taken for um: so many fringes that a lamp of any breadth averages them."""
    first, film, last = STACKS[name]
    return ir.Stack([first, ir.Layer(film, T * 1000.0), last]).color(angle_deg=ANGLE)


FAULTS: list[tuple[str, str, Callable[[], np.ndarray]]] = [
    ("unit", "C1", lambda: chart("C1", T / 1000.0)),
    ("unit", "C1", lambda: grey("C1")),
    ("unit", "C5", lambda: chart("C5", T / 1000.0)),
    ("unit", "C6", lambda: grey("C6")),
    ("illuminant E", "C1", lambda: chart("C1", illuminant="E")),
    ("illuminant E", "C4", lambda: chart("C4", illuminant="E") * ir.color.illuminant("D65").white()),
    ("k missing", "C6", lambda: without_k("C6")),
    ("schlick", "C1", lambda: airy_schlick("C1")),
    ("schlick", "C3", lambda: airy_schlick("C3")),
    ("v flipped", "C1", lambda: chart("C1")[::-1]),
    ("v flipped", "C6", lambda: chart("C6")[::-1]),
    ("8-bit thickness", "C1", lambda: chart("C1", np.rint(T / 1200.0 * 255.0) / 255.0 * 1200.0)),
    ("8-bit thickness", "C5", lambda: chart("C5", 50.0 + np.rint((T - 50.0) / 1150.0 * 255.0) / 255.0 * 1150.0)),
    ("transposed matrix", "C1", lambda: chart("C1") @ TO_RGB @ np.linalg.inv(TO_RGB).T),
    ("cie rgb matrix", "C4", lambda: chart("C4", illuminant="E") @ faults._CIE_RGB.T @ np.linalg.inv(TO_RGB).T),
    ("rec709 clip", "C1", lambda: np.maximum(chart("C1") @ TO_RGB.T, 0.0) @ np.linalg.inv(TO_RGB).T),
    ("half period", "C3", lambda: chart("C3", 2.0 * T)),
]


@pytest.mark.parametrize(("cause", "name", "make"), FAULTS, ids=[f"{cause} {name}" for cause, name, _ in FAULTS])
def test_a_fault_is_named(cause: str, name: str, make: Callable[[], np.ndarray]) -> None:
    report = ir.validate(make(), name)
    assert report.delta_e["mean"] > 0.3 and report.cause == cause, report.text
    assert f"likely cause: {cause}" in report.text


@pytest.mark.parametrize(
    ("cause", "name", "make"), FAULTS[:13], ids=[f"{cause} {name}" for cause, name, _ in FAULTS[:13]]
)
def test_a_fault_is_named_under_noise(cause: str, name: str, make: Callable[[], np.ndarray]) -> None:
    """A path tracer's noise, 0.3 % of each colour: CIEDE2000 0.4 in the mean. More would hide faults that are as small."""
    seen = make()
    noise = np.random.default_rng(4).normal(0.0, 0.003, seen.shape)
    report = ir.validate(seen * (1.0 + noise), name)
    assert report.cause == cause, report.text


def test_what_nobody_knows_is_not_guessed() -> None:
    strange = chart("C1")[..., [1, 2, 0]]
    report = ir.validate(strange, "C1")
    assert report.cause is None and "no single known fault" in report.text
    # Two faults at once, each of which explains half.
    both = chart("C1", illuminant="E")[::-1] * 0.7
    assert ir.validate(both, "C1").cause in (None, "v flipped")


def test_a_wrong_scale_is_told() -> None:
    assert "exposure and scale" in ir.validate(2.0 * chart("C1"), "C1").text


# --- files and layouts


@pytest.fixture
def picture() -> np.ndarray:
    """Patches of 8 pixels."""
    return np.kron(chart("C4"), np.ones((8, 8, 1)))


def test_pictures_of_patches(tmp_path: Path, picture: np.ndarray) -> None:
    rgb = picture @ TO_RGB.T
    planes = {name: np.ascontiguousarray(rgb[..., i], dtype=np.float32) for i, name in enumerate("RGB")}
    (tmp_path / "x.exr").write_bytes(exr.exr_bytes(planes, {}))
    encoded = np.rint(np.clip(ir.color.convert(picture, "xyz", "srgb"), 0.0, 1.0) * 65535.0)
    (tmp_path / "x.png").write_bytes(png.png_bytes(encoded.astype(np.uint16), {}))
    np.save(tmp_path / "x.npy", picture)
    for name, most in (("x.exr", 1e-3), ("x.npy", 1e-6), ("x.png", 0.2)):
        report = ir.validate(tmp_path / name, "C4")
        assert report.delta_e["mean"] < most and "24 x 7 patches" in report.text, name
    image = ir.Image(picture)
    assert ir.validate(image, "C4").delta_e["mean"] < 1e-3
    image.save(tmp_path / "y.exr")
    assert ir.validate(tmp_path / "y.exr", "C4").delta_e["mean"] < 1e-3
    (tmp_path / "z.exr").write_bytes(exr.exr_bytes(planes, {}))
    for name, plane in planes.items():
        planes[name] = plane[::-1]
    (tmp_path / "z.exr").write_bytes(exr.exr_bytes(planes, {}))
    assert ir.validate(tmp_path / "z.exr", "C4").cause == "v flipped"


def test_tables(tmp_path: Path) -> None:
    ir.export("air / soap ? / air", "lut", tmp_path, vary=(0.0, 1200.0))
    report = ir.validate(tmp_path / "film_reflectance.exr", "C1")
    assert report.delta_e["mean"] < 0.06 and report.cause is None
    assert ir.validate(tmp_path / "film_transmittance.exr", "C2").delta_e["mean"] < 0.06
    cosine = np.linspace(0.0, 1.0, 64)[:, None]
    angle = np.degrees(np.arccos(np.clip(cosine, 1e-6, 1.0)))
    table = chart("C1", np.linspace(50.0, 1200.0, 512)[None], angle)
    assert ir.validate(table, "C1").delta_e["mean"] < 0.06
    assert ir.validate(table[::-1], "C1").cause == "v flipped"


@pytest.mark.parametrize(
    ("seen", "name", "message"),
    [
        (np.zeros((7, 24, 3)), "C10", "chart must be one of C1, C2"),
        (np.zeros((7, 24, 3)), 1, "chart must be one of"),
        (np.zeros((7, 24)), "C1", "shape"),
        (np.zeros((9, 9, 3)), "C1", "24k x 7k"),
        (np.full((7, 24, 3), np.nan), "C1", "finite"),
        ("missing.exr", "C1", "missing.exr"),
        ("x.jpg", "C1", ".exr"),
        ("text", "C1", ".exr"),
        ([["a"]], "C1", "array of XYZ"),
        (None, "C1", "array of XYZ|shape"),
    ],
)
def test_wrong_questions(seen: object, name: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ir.validate(seen, name)  # type: ignore[arg-type]


def test_the_verb(iridesce: Run, tmp_path: Path) -> None:
    np.save(tmp_path / "x.npy", chart("C1")[::-1])
    finished = iridesce("validate", "x.npy", "--chart", "C1")
    assert finished.returncode == 0 and "likely cause: v flipped" in finished.stdout
    answer = json.loads(iridesce("validate", "x.npy", "--chart", "C1", "--json").stdout)
    assert answer["cause"] == "v flipped" and set(answer["delta_e"]) == {"mean", "p95", "max"}
    assert iridesce("validate", "x.npy", "--chart", "C0").returncode == 3
    (tmp_path / "bad.exr").write_bytes(b"v/1\x01 no")
    assert iridesce("validate", "bad.exr", "--chart", "C1").returncode == 3


def test_every_chart_has_its_stack() -> None:
    assert [name for name in suite.CHARTS if "-" not in name] == ["C1", "C2", "C3", "C4", "C5", "C6", "C7"]
    assert [one.name for one in suite.GROUPS["C9"]] == ["C9-0nm", "C9-1nm", "C9-2nm", "C9-5nm", "C9-8bit"]
