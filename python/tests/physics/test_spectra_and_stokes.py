"""What a picture knows beside its colours: radiance at single wavelengths, and Stokes vectors."""

from __future__ import annotations

import numpy as np
import OpenEXR
import pytest

import command_line
import iridesce as ir
from oracles import environment, spectra
from oracles.camera import camera_rays
from physics.scenes import film, plane, scene
from physics.test_polarisation import CHAINS, build

from oracles.polarised_trace import Tracer  # isort: skip

WAVELENGTHS = np.array([380.0, 412.5, 450.0, 500.0, 550.0, 560.0, 632.8, 700.0, 780.0])
BLACK = {"diffuse": {"reflectance": 0.0}}
ANGLE_DEG = 45.0


def tilted(light: dict, up=(0.0, 1.0, 0.0), medium="soap", thickness_nm=420.0, **render) -> ir.Image:
    """A film before black, seen at 45 degrees by parallel rays: every pixel shows R(45) times the lamp."""
    return ir.render(
        {
            "version": 1,
            "camera": {
                "position": [0.0, 9.0, 9.0],
                "target": [0.0, 0.0, 0.0],
                "up": list(up),
                "orthographic_height": 1.0,
                "resolution": [3, 2],
            },
            "object": [
                {"name": "film", **plane([0, 0, 0], [0, 0, 1], film(medium, thickness_nm))},
                {"name": "black", **plane([0, 0, -5], [0, 0, 1], BLACK)},
            ],
            "light": [{"environment": light}],
        },
        **{"samples": 2, **render},
    )


def relative(name: str, wavelength_nm: np.ndarray) -> np.ndarray:
    """An illuminant of Y = 1 on the scale where D65 of Y = 1 has 1 at 560 nm."""
    import colour

    def values(name: str, at: np.ndarray) -> np.ndarray:
        table = colour.SDS_ILLUMINANTS[name]
        return np.interp(at, table.wavelengths, table.values)

    y_bar = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].values[:, 1]
    total = {key: float(values(key, spectra.WAVELENGTH_NM) @ y_bar) for key in {name, "D65"}}
    d65_at_560 = float(values("D65", np.array([560.0]))[0])
    return values(name, wavelength_nm) / total[name] * total["D65"] / d65_at_560


@pytest.mark.parametrize("lamp", ["D65", "A"])
def test_a_films_spectrum_is_its_reflectance_times_the_lamp(lamp):
    image = tilted({"illuminant": lamp, "radiance": 0.7}, spectral_nm=WAVELENGTHS)
    stack = ir.Stack(["air", ir.Layer("soap", thickness_nm=420.0), "air"])
    expected = 0.7 * stack.reflectance(WAVELENGTHS, ANGLE_DEG) * relative(lamp, WAVELENGTHS)
    assert image.spectra.shape == (2, 3, 9)
    assert image.spectra.dtype == np.float32
    # f32 reflectance: 3e-6 absolute (film.rs).
    np.testing.assert_allclose(image.spectra, np.broadcast_to(expected, (2, 3, 9)), rtol=2e-4, atol=5e-6)
    assert np.array_equal(image.spectral_nm, WAVELENGTHS)
    assert image.stokes is None
    plain = tilted({"illuminant": lamp, "radiance": 0.7})
    np.testing.assert_allclose(image.xyz, plain.xyz, rtol=1e-6)
    assert plain.spectra is None


@pytest.mark.parametrize(
    ("surface", "layers"),
    [
        (film("SiO2", 1700.0), ["air", ir.Layer("SiO2", 1700.0), "air"]),
        (film([1.9, 0.02], 250.0), ["air", ir.Layer(1.9 + 0.02j, 250.0), "air"]),
        (
            {"coating": {"layers": [{"medium": "MgF2", "thickness_nm": 110.0}], "substrate": "N-BK7"}},
            ["air", ir.Layer("MgF2", 110.0), "N-BK7"],
        ),
        (
            {"coating": {"layers": [{"medium": "TiO2", "thickness_nm": 60.0}], "substrate": "Ti"}},
            ["air", ir.Layer("TiO2", 60.0), "Ti"],
        ),
    ],
    ids=["thick film", "absorbing film", "coated glass", "oxide on metal"],
)
@pytest.mark.filterwarnings("ignore:the data of medium")
def test_the_spectrum_of_any_layers_is_the_reflectance_of_the_stack(surface, layers):
    """At 45 degrees, before black; what enters the glass comes to black at its other side."""
    nm = np.linspace(400.0, 780.0, 39)
    camera = {"position": [0.0, 9.0, 9.0], "orthographic_height": 1.0, "resolution": [2, 2]}
    black = {"name": "black", **plane([0, 0, -5], [0, 0, 1], BLACK)}
    objects = [{"name": "layers", **plane([0, 0, 0], [0, 0, 1], surface)}, black]
    light = [{"environment": {"illuminant": "D65"}}]
    image = ir.render({"version": 1, "camera": camera, "object": objects, "light": light}, samples=2, spectral_nm=nm)
    expected = ir.Stack(layers).reflectance(nm, ANGLE_DEG) * relative("D65", nm)
    np.testing.assert_allclose(image.spectra, np.broadcast_to(expected, (2, 2, 39)), rtol=2e-4, atol=5e-6)


def test_lines_are_the_mean_over_their_band():
    wavelengths = [530.0, 540.0, 550.0, 590.0]
    image = tilted({"illuminant": "lines:546.07*2,589.0"}, spectral_nm=wavelengths)
    stack = ir.Stack(["air", ir.Layer("soap", thickness_nm=420.0), "air"])
    lines, power = np.array([546.07, 589.0]), np.array([2.0, 1.0])
    import colour

    y_bar = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].values[:, 1]
    d65 = relative("D65", spectra.WAVELENGTH_NM)
    scale = float(d65 @ y_bar) / float(power @ np.interp(lines, spectra.WAVELENGTH_NM, y_bar))
    radiance = scale * power * stack.reflectance(lines, ANGLE_DEG)
    # Bands: 525..535, 535..545, 545..570, 570..610.
    expected = [0.0, 0.0, radiance[0] / 25.0, radiance[1] / 40.0]
    np.testing.assert_allclose(image.spectra[1, 1], expected, rtol=2e-4)


def test_the_spectrum_of_a_bubble_sums_to_its_colour():
    """Under the studio map, refraction or none: the 1 nm sum of the spectrum is the XYZ of the same samples."""
    every = np.arange(360.0, 831.0)
    image = ir.render("soap-bubble", samples=4, size=(6, 6), spectral_nm=every)
    import colour

    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].values
    total = float(relative("D65", every) @ observer[:, 1])
    xyz = image.spectra.astype(float) @ observer / total
    # The colours interpolate what is between their nodes: 1e-3 of the brightest.
    np.testing.assert_allclose(xyz, image.xyz, atol=2e-3 * image.xyz.max())
    np.testing.assert_allclose(image.xyz, ir.render("soap-bubble", samples=4, size=(6, 6)).xyz, rtol=2e-6, atol=1e-6)


def crowded(*, glass: bool = False, has_sky: bool = True, **camera) -> dict:
    """Every way in which light gets into a picture: rough and smooth surfaces, lamps of every kind, lines, polarised ones."""
    objects = [
        {"name": "floor", **plane([0, -2, 0], [0, 1, 0], {"diffuse": {"reflectance": [0.7, 0.5, 0.3]}})},
        {"name": "gold", "shape": _ball(-2.2, 0.0), "surface": {"metal": {"medium": "Au", "roughness": 0.5}}},
        {
            "name": "sheet",
            "shape": _ball(0.2, 1.6, 0.7),
            "surface": {"film": {**film("soap", 380.0)["film"], "roughness": 0.4}},
        },
        {"name": "bubble", "shape": _ball(0.2, -0.4, 0.9), "surface": film("soap", 420.0)},
        {"name": "oxide", "shape": _ball(2.4, 0.0), "surface": _coated("TiO2", 60.0, "Ti", [0.3, 0.6])},
        {"name": "lamp", "shape": _ball(-1.0, 3.5, 0.3), "surface": {"emitter": {"illuminant": "A", "radiance": 8.0}}},
    ]
    if glass:
        objects[3] = {"name": "glass", "shape": _ball(0.2, -0.4, 0.9), "surface": {"dielectric": {"medium": "N-SF11"}}}
    lines = {"illuminant": "lines:546*2,589", "polarized_deg": 30.0}
    return {
        "version": 1,
        "camera": {"position": [0.0, 2.0, 10.0], "target": [0.0, 0.0, 0.0], "resolution": [8, 6], **camera},
        "render": {"samples": 16},
        "object": objects,
        "light": [
            *([{"environment": {"builtin": "sky", "radiance": 0.3}}] if has_sky else []),
            {"environment": {"illuminant": "FL2", "radiance": 0.1}},
            {"point": {"position": [3.0, 4.0, 3.0], "intensity": 20.0, **lines}},
            {
                "sun": {
                    "direction": [-1.0, 2.0, 2.0],
                    "angular_diameter_deg": 8.0,
                    "irradiance": 1.0,
                    "polarized_deg": 70.0,
                }
            },
        ],
    }


def _ball(x: float, y: float, radius: float = 1.2) -> dict:
    return {"sphere": {"center": [x, y, 0.0], "radius": radius}}


def _coated(layer: str, thickness_nm: float, substrate: str, roughness: list[float]) -> dict:
    layers = [{"medium": layer, "thickness_nm": thickness_nm}]
    return {"coating": {"layers": layers, "substrate": substrate, "roughness": roughness}}


def test_all_light_of_a_picture_is_in_its_spectra():
    """Rough surfaces, small and polarised lamps, lines: the 1 nm sum of the spectrum is XYZ of the same samples; S0, too."""
    import colour

    every = np.arange(360.0, 831.0)
    recipe = crowded()
    image = ir.render(recipe, spectral_nm=every)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].values
    total = float(relative("D65", every) @ observer[:, 1])
    np.testing.assert_allclose(image.spectra.astype(float) @ observer / total, image.xyz, atol=3e-3 * image.xyz.max())
    plain = ir.render(recipe)
    assert np.array_equal(image.xyz, plain.xyz)
    stokes = ir.render(recipe, stokes=True)
    # Rounding in another frame turns a choice over now and then: in few pixels, and by the noise of one branch.
    apart = np.abs(stokes.xyz - plain.xyz).max(axis=-1) / plain.xyz.max()
    assert (apart > 1e-5).mean() < 0.15
    assert apart.max() < 0.01
    assert np.array_equal(stokes.stokes[..., 0], stokes.xyz)


def test_prisms_part_the_spectra_as_they_part_the_colours():
    import colour

    every = np.arange(360.0, 831.0, 5.0)
    image = ir.render(crowded(glass=True), spectral_nm=every, samples=32)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].values[::5]
    total = float(relative("D65", every) @ observer[:, 1])
    summed = (image.spectra.astype(float) @ observer / total).mean(axis=(0, 1))
    # Light at a place between nodes is told at those beside it: alike on average only.
    np.testing.assert_allclose(summed, image.xyz.mean(axis=(0, 1)), rtol=0.03)


@pytest.mark.parametrize("degrees", [45.0, 110.0])
def test_a_polariser_passes_what_the_stokes_vectors_say(degrees):
    """By the rows of the adjoint, against renders that know of none."""
    nm = [450.0, 546.0, 650.0]
    open_ = ir.render(crowded(has_sky=False), stokes=True, samples=128)
    closed = ir.render(crowded(has_sky=False, polarizer_deg=degrees), spectral_nm=nm, samples=128)
    both = ir.render(crowded(has_sky=False, polarizer_deg=degrees), spectral_nm=nm, stokes=True, samples=128)
    twice = np.radians(2.0 * degrees)
    passes = 0.5 * np.array([1.0, np.cos(twice), np.sin(twice), 0.0])
    mean = lambda values: values.astype(float).mean(axis=(0, 1))  # noqa: E731
    expected = mean(open_.stokes) @ passes
    assert np.abs(mean(open_.stokes)[1, 1:3]).max() > 0.02 * mean(open_.stokes)[1, 0], "there is something to see"
    for image in (closed, both):
        np.testing.assert_allclose(mean(image.xyz), expected, rtol=0.01)
    np.testing.assert_allclose(mean(both.stokes)[:, :3], mean(open_.stokes)[:, :3], atol=0.01 * expected[1])
    np.testing.assert_allclose(both.stokes.astype(float) @ passes, both.xyz, atol=1e-4 * both.xyz.max())
    np.testing.assert_allclose(mean(both.spectra), mean(closed.spectra), rtol=0.02)
    np.testing.assert_allclose(both.spectral_stokes.astype(float) @ passes, both.spectra, atol=1e-5)


def test_signs_of_linear_polarisation():
    """A film mirrors more s than p: light swings across the plane of incidence, which here holds the camera's upright."""
    stack = ir.Stack(["air", ir.Layer("soap", thickness_nm=420.0), "air"])
    r_s, r_p = (stack.color(ANGLE_DEG, polarization) for polarization in "sp")
    upright = tilted({"illuminant": "D65"}, stokes=True)
    assert upright.stokes.shape == (2, 3, 3, 4)
    np.testing.assert_allclose(upright.stokes[1, 1, :, 0], 0.5 * (r_s + r_p), rtol=1e-3)
    np.testing.assert_allclose(upright.stokes[1, 1, :, 1], 0.5 * (r_p - r_s), rtol=1e-3)
    np.testing.assert_allclose(upright.stokes[1, 1, :, 2:], 0.0, atol=1e-6)
    assert np.array_equal(upright.stokes[..., 0], upright.xyz)
    # The camera turned so that the field (along x) is 45 degrees clockwise from its upright.
    across = tilted({"illuminant": "D65"}, up=(np.sqrt(2.0), 1.0, -1.0), stokes=True)
    np.testing.assert_allclose(across.stokes[1, 1, :, 2], 0.5 * (r_s - r_p), rtol=1e-3)
    np.testing.assert_allclose(across.stokes[1, 1, :, [1, 3]], 0.0, atol=1e-6)


@pytest.mark.parametrize("name", CHAINS)
def test_stokes_vectors_of_chains_against_field_matrices(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    spheres, camera, lamp, _ = build(name, resolution=(1, 1))
    environment.write_exr(tmp_path / "lamp.exr", lamp)
    nm = np.array([450.0, 550.0, 620.0])
    image = ir.render(
        scene(spheres, camera, {"map": "lamp.exr"}, samples=1024, seed=2, max_depth=16), stokes=True, spectral_nm=nm
    )
    tracer = Tracer(spheres, lambda d: environment.lookup(lamp, d), depth=12, threshold=1e-5)
    origin, direction = camera_rays(camera, 0.5, 0.5)
    wanted = tracer.spectrum(origin, direction, np.array(camera["up"]))
    got = image.stokes[0, 0].astype(float)
    expected = np.einsum("wc,wj->cj", spectra.xyz_weights(), wanted)
    assert (np.abs(got - expected) <= 0.01 * expected[:, :1]).all(), (got, expected)
    assert np.abs(expected[1, 1:]).max() > 0.05 * expected[1, 0], "there is something to see"
    at = [int(value - 360) for value in nm]
    lamp_at = relative("D65", nm)[:, None]
    np.testing.assert_allclose(
        image.spectral_stokes[0, 0], wanted[at] * lamp_at, atol=0.012 * (wanted[at] * lamp_at)[:, 0].max()
    )
    assert np.array_equal(image.spectra, image.spectral_stokes[..., 0])


def test_elliptic_light_has_the_sign_of_the_theory():
    chain = np.einsum("wc,wj->cj", spectra.xyz_weights(), _elliptic())
    assert abs(chain[1, 3]) > 0.1 * chain[1, 0], "the case above tells signs of S3 apart"


def _elliptic() -> np.ndarray:
    spheres, camera, lamp, _ = build("elliptic light between", resolution=(1, 1))
    origin, direction = camera_rays(camera, 0.5, 0.5)
    tracer = Tracer(spheres, lambda d: environment.lookup(lamp, d), depth=12, threshold=1e-5)
    return tracer.spectrum(origin, direction, np.array(camera["up"]))


def test_spectra_and_stokes_vectors_travel_in_the_published_layout(tmp_path):
    image = ir.render("soap-bubble", samples=2, size=(8, 6), spectral_nm=[450.0, 550.0, 632.8], stokes=True)
    image.save(tmp_path / "x.exr")
    with OpenEXR.File(str(tmp_path / "x.exr"), separate_channels=True) as file:
        names, header = set(file.channels()), dict(file.header())
    assert {f"S{j}.{nm}nm" for j in range(4) for nm in ("450,00", "550,00", "632,80")} <= names
    assert {f"stokes.{axis}.{j}" for axis in "XYZ" for j in range(4)} <= names
    assert header["spectralLayoutVersion"] == "1.0"
    assert header["polarisationHandedness"] == "right"
    assert "D65" in header["emissiveUnits"]
    again = ir.Image.load(tmp_path / "x.exr")
    for name in ("stokes", "spectra", "spectral_stokes", "spectral_nm"):
        assert np.array_equal(getattr(again, name), getattr(image, name)), name
    recipe = ir.Scene.load("soap-bubble").with_value("camera.polarizer_deg", 20.0)
    turned = ir.render(recipe, size=(8, 6), samples=2, spectral_nm=[450.0, 550.0], stokes=True)
    turned.save(tmp_path / "turned.exr")
    again = ir.Image.load(tmp_path / "turned.exr")
    assert np.array_equal(again.spectra, turned.spectra)
    assert np.array_equal(again.spectral_stokes, turned.spectral_stokes)
    image.save(tmp_path / "half.exr", half=True)
    np.testing.assert_allclose(ir.Image.load(tmp_path / "half.exr").spectra, image.spectra, rtol=2**-11, atol=1e-6)
    command = ["render", "soap-bubble", "--samples", "2", "--size", "8x6", "--spectral", "450:550:100", "-o", "c.exr"]
    assert command_line.run(command, tmp_path).returncode == 0
    np.testing.assert_allclose(ir.Image.load(tmp_path / "c.exr").spectra, image.spectra[..., :2], rtol=1e-5)


def test_parts_journals_and_shards_hold_them_too(tmp_path):
    more = {"samples": 2, "size": (40, 20), "spectral_nm": [500.0, 600.0], "stokes": True}
    whole = ir.render("soap-bubble", **more)
    part = ir.render("soap-bubble", **more, crop=(11, 3, 20, 9))
    assert np.array_equal(part.spectral_stokes, whole.spectral_stokes[3:12, 11:31])
    merged = ir.merge([ir.render("soap-bubble", **more, shard=(i, 2)) for i in (1, 2)])
    assert np.array_equal(merged.stokes, whole.stokes)
    assert np.array_equal(merged.spectral_stokes, whole.spectral_stokes)
    ir.render("soap-bubble", **more, resume=tmp_path / "j")
    assert np.array_equal(ir.render("soap-bubble", **more, resume=tmp_path / "j").stokes, whole.stokes)
    with pytest.raises(ValueError, match=r"planes.stokes was true, now it is false"):
        ir.render("soap-bubble", **{**more, "stokes": False}, resume=tmp_path / "j")
    with pytest.raises(ValueError, match="planes"):
        ir.merge([whole, ir.render("soap-bubble", samples=2, size=(40, 20), seed=2)])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"spectral_nm": [500.0, 400.0]}, "spectral_nm must ascend"),
        ({"spectral_nm": [500.0, 500.0]}, "spectral_nm must ascend"),
        ({"spectral_nm": [300.0]}, "spectral_nm must ascend from 360 to 830"),
        ({"spectral_nm": [float("nan")]}, "spectral_nm"),
        ({"spectral_nm": "red"}, "spectral_nm"),
        ({"spectral_nm": np.linspace(400.0, 700.0, 5000)}, "4096 wavelengths at most"),
        ({"stokes": 1}, "stokes must be True or False"),
    ],
)
def test_what_cannot_be_asked_for_is_said(arguments, said):
    with pytest.raises(ValueError, match=said):
        ir.render("soap-bubble", samples=1, size=(2, 2), **arguments)


def test_planes_that_cannot_fit_are_refused_before_any_work():
    with pytest.raises(ir.ResourceError, match="needs"):
        ir.render("soap-bubble", size=(6000, 6000), spectral_nm=np.linspace(400.0, 700.0, 4096), stokes=True)
