"""Photographs: planted films come back, clipped and coded ones too; wrong assumptions and pictures of nothing are never sure."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import tifffile
from PIL import Image as Pictures

import iridesce as ir
from iridesce.color.light import color_matching
from iridesce.inverse.photograph import _narrow

Floats = npt.NDArray[np.float64]
NM = np.arange(380.0, 781.0, 2.0)
FILM = "air / 1.33 ? / air"
QUARTER_NM = 550.0 / (4.0 * 1.33)


def response(camera: str, lamp: str) -> Floats:
    if camera == "srgb":
        seen = np.asarray(ir.color.convert(np.asarray(color_matching(NM)), "xyz", "linear-srgb"))
    else:
        seen = np.asarray(ir.color.camera(camera).at(NM))
    weights = seen * np.asarray(ir.color.illuminant(lamp).power(NM))[:, None]
    return np.asarray(weights / weights.sum(axis=0))


def photograph(
    nm: Floats, camera: str = "nikon-d5100", lamp: str = "D65", noise: float = 0.01, seed: int = 1, angle: float = 0.0
) -> Floats:
    """A free film with haze of a fifth of its light, its brightest pixel near 0.8; by spectra finer than the program's tables."""
    grid = np.linspace(nm.min(), nm.max() + 1.0, 1500)
    curves = ir.Stack(["air", ir.Layer(1.33, grid[:, None]), "air"]).reflectance(NM, angle) @ response(camera, lamp)
    light = np.stack([np.interp(nm, grid, curve) for curve in curves.T], axis=-1)
    light = light + 0.2 * light.mean() * np.array([0.9, 1.0, 1.2])
    light *= 0.8 / light.max()
    random = np.random.default_rng(seed)
    return np.asarray(light + noise * np.sqrt(np.maximum(light, 0.0) * light.mean()) * random.normal(size=light.shape))


def draining(height: int = 72, width: int = 96) -> Floats:
    y, x = np.mgrid[0:height, 0:width].astype(float)
    return np.asarray(20.0 + 800.0 * (y / height) ** 1.4 + 12.0 * np.sin(x / 20.0))


def swirls(height: int = 72, width: int = 96) -> Floats:
    y, x = np.mgrid[0:height, 0:width].astype(float)
    return np.asarray(430.0 + 160.0 * np.sin(x / 23.0 + y / 40.0) * np.cos(y / 31.0 - x / 57.0))


def mapped(image: Any, stack: Any = FILM, **options: Any) -> Any:
    options = {"camera": "nikon-d5100", "illuminant": "D65", "thickness_range_nm": (0.0, 1200.0), **options}
    return ir.map_thickness(image, stack, **options)


def right(found: Any, nm: Floats) -> npt.NDArray[np.bool_]:
    return np.asarray(np.abs(found.thickness_nm - nm) <= QUARTER_NM)


def is_honest(found: Any, nm: Floats) -> None:
    """What is called sure is right, and intervals hold."""
    good = right(found, nm)
    sure = found.confidence > 0.95
    assert not sure.any() or good[sure].mean() > 0.98
    held = (found.low_nm <= nm) & (nm <= found.high_nm)
    assert not good.any() or held[good].mean() > 0.93


# --- planted films


@pytest.mark.parametrize("camera", ["nikon-d5100", "sigma-sd-merrill", "srgb"])
@pytest.mark.parametrize("lamp", ["D65", "A"])
def test_a_draining_film_comes_back(camera: str, lamp: str) -> None:
    nm = draining()
    found = mapped(photograph(nm, camera, lamp), camera=camera, illuminant=lamp)
    assert right(found, nm).mean() > 0.98
    assert np.mean(np.abs(found.thickness_nm - nm) < 10.0) > 0.97
    assert np.median(np.abs(found.thickness_nm - nm)) < 1.5
    assert found.sure > 0.97
    assert found.anchor == "black film"
    is_honest(found, nm)


def test_gain_and_haze_are_told_apart() -> None:
    found = mapped(photograph(swirls()))
    own = found.calibration
    light = photograph(swirls(), noise=0.0)
    grid = np.linspace(swirls().min(), swirls().max(), 1500)
    film = ir.Stack(["air", ir.Layer(1.33, grid[:, None]), "air"]).reflectance(NM) @ response("nikon-d5100", "D65")
    gain = np.ptp(light[..., 1]) / np.ptp(film[:, 1])
    assert own["gain"] == pytest.approx(gain, rel=0.02)
    haze = light.min(axis=(0, 1)) - gain * film.min(axis=0)
    np.testing.assert_allclose(own["haze"], haze, rtol=0.06)
    assert found.anchor == "color"


def test_clipped_channels_say_only_that_they_are_full(tmp_path: Path) -> None:
    nm = swirls()
    light = 1.7 * photograph(nm)
    assert 0.1 < np.mean(light > 1.0) < 0.4
    found = mapped(np.minimum(light, 1.0))
    assert right(found, nm).mean() > 0.97
    is_honest(found, nm)
    assert any("is full at 1" in note for note in found.notes)
    # The same in whole numbers of 16 bits, where the file itself says so.
    path = tmp_path / "photo.tif"
    tifffile.imwrite(path, (65535.0 * np.clip(light, 0.0, 1.0) + 0.5).astype(np.uint16), photometric="rgb")
    of_file = mapped(path)
    assert np.mean(np.abs(of_file.thickness_nm - found.thickness_nm) < 2.0) > 0.97


def test_a_jpeg_is_read_by_its_curve(tmp_path: Path) -> None:
    nm = draining(120, 160)
    light = np.clip(photograph(nm), 0.0, 1.0)
    coded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
    buffer = io.BytesIO()
    Pictures.fromarray((255.0 * coded + 0.5).astype(np.uint8)).save(buffer, "JPEG", quality=92, subsampling=2)
    path = tmp_path / "photo.jpg"
    path.write_bytes(buffer.getvalue())
    found = mapped(path)
    assert right(found, nm).mean() > 0.93
    assert found.calibration["temper"] > 2.0  # errors of neighbours hang together, and are measured to
    is_honest(found, nm)


def test_colours_that_an_edge_mixes_are_not_sure(tmp_path: Path) -> None:
    """Steps of oxide in a JPEG: along an edge all pixels have the colour of a third film, and were sure of its order."""
    x = np.broadcast_to(np.arange(100), (48, 100))
    truth = 200.0 + 55.0 * (x // 20)
    film = ir.Stack(["air", ir.Layer("SiO2", truth[:1]), "Si"]).color(space="linear-srgb")
    light = np.broadcast_to(film / film.max() * 0.7, (48, 100, 3)) + np.array([0.09, 0.1, 0.12])
    light = light + 0.004 * np.random.default_rng(5).standard_normal(light.shape)
    coded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
    path = tmp_path / "steps.jpg"
    Pictures.fromarray((255.0 * coded + 0.5).astype(np.uint8)).save(path, quality=92, subsampling=2)
    found = ir.map_thickness(
        path, "air / SiO2 ? / Si", camera="srgb", illuminant="D65", thickness_range_nm=(0.0, 1200.0)
    )
    wrong = np.abs(found.thickness_nm - truth) > 550.0 / 4.0 / 1.46
    edges = (x % 20 == 0) | (x % 20 == 19)
    assert wrong.any() and not wrong[~edges].any()
    assert not (found.confidence[wrong] > 0.95).any() and (found.confidence[~edges] > 0.95).mean() > 0.9


def test_narrow_stripes_are_those_between_two_edges() -> None:
    row = np.array([1.0, 1, 9, 1, 1, 9, 9, 1, 9, 9, 9, 1, 5, 9], dtype=np.float32) * 100.0
    found = _narrow(np.tile(row, (4, 1)), 300.0)
    assert (found == found[0]).all()
    assert found[0].nonzero()[0].tolist() == [2, 3, 4, 5, 6, 7, 11, 12]


def test_flat_dark_and_mask() -> None:
    nm = swirls()
    light = photograph(nm)
    flat = np.linspace(0.5, 1.0, nm.shape[1])[None, :, None] * np.ones((*nm.shape, 3))
    dark = np.full((*nm.shape, 3), 0.03)
    mask = np.zeros(nm.shape, dtype=bool)
    mask[:9] = True
    found = mapped(light * flat + dark, flat=flat + dark, dark=dark, mask=mask)
    assert right(found, nm)[~mask].mean() > 0.99
    for plane in (found.thickness_nm, found.confidence, found.low_nm, found.high_nm, found.candidates_nm[..., 0]):
        assert np.isnan(plane[mask]).all()
    np.testing.assert_array_equal(found.best.thickness_nm[mask], 0.0)


def test_tie_points_give_a_region_its_order() -> None:
    """Thick, narrow in range, under little colour: an order is a guess until a pixel is known."""
    y, x = np.mgrid[0:64, 0:80].astype(float)
    nm = 1500.0 + 1.2 * x + 0.8 * y
    light = photograph(nm, noise=0.02)
    options: dict[str, Any] = {"thickness_range_nm": (0.0, 2500.0)}
    alone = mapped(light, **options)
    is_honest(alone, nm)
    tied = mapped(light, tie_points=[(40, 30, 1500.0 + 48.0 + 24.0)], **options)
    assert right(tied, nm).mean() > max(0.8, right(alone, nm).mean() - 0.01)
    assert tied.anchor == "tie point"
    lost = mapped(photograph(swirls()), tie_points=[(3, 3, 1150.0)], thickness_range_nm=(0.0, 1200.0))
    assert any("suits the pixel of its tie point" in note for note in lost.notes)


def test_a_rendered_bubble_with_an_angle_for_each_pixel() -> None:
    """A bubble around a black ball in even light: angles from 0 to 64 degrees, thickness from 150 to 550 nm."""
    film = {"medium": 1.33, "thickness_nm": {"gradient": {"top": 150.0, "bottom": 550.0}}}
    scene = {
        "version": 1,
        "camera": {"orthographic_height": 6.2, "resolution": [96, 96]},
        "object": [
            {"shape": {"sphere": {"radius": 3.0}}, "surface": {"film": film}},
            {"shape": {"sphere": {"radius": 2.8}}, "surface": {"diffuse": {"reflectance": 0.0}}},
        ],
        "light": [{"environment": {"illuminant": "D65"}}],
    }
    image = ir.render(ir.Scene.load(scene), samples=16)
    normal, depth = image.channels["normal"], image.channels["depth"]
    # A parallel view along -z.
    angle = np.degrees(np.arccos(np.clip(normal[..., 2], 0.0, 1.0)))
    outside = ~np.isfinite(depth) | (angle > 64.0)  # beyond, light passes beside the ball
    truth = image.channels["thickness_nm"].astype(float)
    options: dict[str, Any] = {"camera": "srgb", "mask": outside, "thickness_range_nm": (0.0, 900.0)}
    found = mapped(image, angle_deg=np.where(outside, 0.0, angle), **options)
    assert right(found, truth)[~outside].mean() > 0.98
    error = np.abs(found.thickness_nm - truth)[~outside]
    assert np.median(error) < 2.0
    assert np.mean(error < 10.0) > 0.97
    held = (found.low_nm <= truth) & (truth <= found.high_nm)
    assert held[~outside].mean() > 0.93
    # One angle for all is another picture: the rim is up to a third off.
    flat = mapped(image, angle_deg=0.0, **options)
    assert np.mean(np.abs(flat.thickness_nm - truth)[~outside] < 10.0) < 0.8


# --- honest where it does not know


def test_blind_finds_the_order_and_says_that_its_scale_is_uncertain() -> None:
    nm = draining()
    found = ir.map_thickness(photograph(nm), FILM, thickness_range_nm=(0.0, 1200.0))
    assert right(found, nm).mean() > 0.98
    is_honest(found, nm)
    low, high = found.scale_interval
    assert high - low > 0.1
    assert mapped(photograph(nm)).scale_interval[1] - 1.0 < 0.015


@pytest.mark.parametrize(("lamp", "noise"), [("A", 0.01), ("A", 0.05), ("FL11", 0.01)])
def test_a_wrong_lamp_is_told(lamp: str, noise: float) -> None:
    """In noise, too, where what the lamp leaves is less than half of it; the right lamp is sure there."""
    nm = draining()
    found = mapped(photograph(nm, lamp=lamp, noise=noise))
    assert mapped(photograph(nm, noise=noise)).sure > 0.95
    assert found.sure == 0.0
    assert any("no order is sure" in note for note in found.notes)


def test_another_stack_is_told() -> None:
    grid = draining()
    oxide = ir.Stack(["air", ir.Layer("SiO2", grid[..., None]), "Si"]).reflectance(NM) @ response("nikon-d5100", "D65")
    found = mapped(oxide + np.random.default_rng(1).normal(0.0, 0.003, oxide.shape))
    assert found.sure == 0.0


def test_tolerances_enter_the_intervals() -> None:
    nm = swirls()
    tilted = photograph(nm, angle=10.0)
    wide = mapped(tilted, angle_tolerance_deg=10.0, index_tolerance=0.01)
    held = (wide.low_nm <= nm) & (nm <= wide.high_nm)
    assert held.mean() > 0.95
    narrow = mapped(tilted)
    assert np.mean(wide.high_nm - wide.low_nm) > 1.5 * np.mean(narrow.high_nm - narrow.low_nm)


def test_noise_and_gradients_are_no_films() -> None:
    random = np.random.default_rng(5)
    ramp = np.linspace(0.1, 0.9, 64)[None, :, None] * np.ones((48, 64, 3))
    pictures = [
        random.uniform(0.0, 1.0, (48, 64, 3)),
        ramp + random.normal(0.0, 0.004, ramp.shape),
        np.clip(ramp * [1.0, 0.6, 0.3] + random.normal(0.0, 0.004, ramp.shape), 0.0, None),
    ]
    for picture in pictures:
        assert mapped(picture).sure == 0.0


@pytest.mark.parametrize(
    ("picture", "words"),
    [
        (np.zeros((16, 20, 3)), "dark"),
        (np.random.default_rng(1).normal(0.0, 1e-3, (16, 20, 3)), "dark"),
        (np.full((16, 20, 3), 0.3), "one colour"),
        (
            np.full((16, 20, 3), 0.3) * [1.0, 0.6, 0.8] + np.random.default_rng(1).normal(0.0, 1e-3, (16, 20, 3)),
            "one colour",
        ),
    ],
)
def test_pictures_that_say_nothing_get_a_verdict_and_no_number(picture: Floats, words: str) -> None:
    found = mapped(picture)
    assert words in found.notes[0]
    assert np.isnan(found.thickness_nm).all()
    assert (found.confidence == 0.0).all()
    assert (found.anchor, found.sure) == ("none", 0.0)
    assert "no nm" in str(found)


def test_a_full_picture_gets_a_verdict_and_no_number(tmp_path: Path) -> None:
    Pictures.fromarray(np.full((16, 16, 3), 255, dtype=np.uint8)).save(tmp_path / "full.png")
    for picture, options in ((tmp_path / "full.png", {}), (np.full((16, 16, 3), 2.0), {"clip": 1.0})):
        found = mapped(picture, **options)
        assert "full" in found.notes[0]
        assert found.to_dict()["mapped"] == 0


# --- what is refused


@pytest.mark.parametrize(
    ("image", "options", "words"),
    [
        (np.zeros((1, 1, 3)), {}, "at least 8 x 8 pixels, got 1 x 1"),
        (np.full((16, 16, 3), np.nan), {}, "holds no number at all"),
        (np.zeros((16, 16)), {}, "of the shape .height, width, 3."),
        ("none.png", {}, "none.png: "),
        ("photo.heic", {}, "HEIC or AVIF; convert it"),
        ("photo.NEF", {}, "RAW file; convert it to a linear 16-bit TIFF"),
        (np.zeros((16, 16, 3)), {"stack": "air / air"}, "no layer"),
        (np.zeros((16, 16, 3)), {"stack": "air / SiO2 ? / TiO2 ? / SiO2 ? / Si"}, "one unknown thickness .* got 3"),
        (np.zeros((16, 16, 3)), {"camera": "box"}, "nikon-d5100, sigma-sd-merrill"),
        (np.zeros((16, 16, 3)), {"illuminant": "candle"}, "candle"),
        (np.zeros((16, 16, 3)), {"illuminant": "laser:1064"}, "laser:1064|360..830"),
        (np.zeros((16, 16, 3)), {"angle_deg": 90.0}, "angle_deg must be >= 0 and < 90, got 90"),
        (np.zeros((16, 16, 3)), {"angle_deg": np.zeros((3, 3))}, "one a pixel .16, 16., got shape .3, 3."),
        (np.zeros((16, 16, 3)), {"thickness_range_nm": (500.0, 100.0)}, "thickness_range_nm must be 0 <= low < high"),
        (np.zeros((16, 16, 3)), {"mask": np.ones((16, 16), dtype=bool)}, "leaves no pixel"),
        (np.zeros((16, 16, 3)), {"mask": np.zeros((4, 4), dtype=bool)}, "mask must hold true or false"),
        (np.zeros((16, 16, 3)), {"noise": -1.0}, "noise must be one number or three"),
        (np.zeros((16, 16, 3)), {"clip": "high"}, "clip must be one level or three"),
        (np.zeros((16, 16, 3)), {"flat": np.ones((9, 9, 3))}, "flat must have the size"),
        (np.zeros((16, 16, 3)), {"tie_points": [(50, 2, 100.0)]}, "must lie in the picture of 16 x 16"),
        (np.zeros((16, 16, 3)), {"tie_points": [3]}, "list of .x, y, nm."),
        (np.zeros((16, 16, 3)), {"index_tolerance": -1}, "index_tolerance must be"),
        (np.zeros((16, 16, 3)), {"threads": 0}, "threads must be"),
        (np.zeros((16, 16, 3)), {"progress": 3}, "progress must be"),
        (np.zeros((16, 16, 3)), {"calibration": 3}, "path must be a file name|calibration"),
    ],
)
def test_bad_input_is_refused_in_words(image: Any, options: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        mapped(image, **options)


def test_16k_by_16k_is_refused_before_memory_is_taken() -> None:
    with pytest.raises(ir.ResourceError, match="16384 x 16384 pixels"):
        mapped(np.broadcast_to(np.float32(0.1), (16384, 16384, 3)))


def heads() -> dict[str, bytes]:
    """The first bytes of pictures of 16384 x 16384 pixels, of which there is no more."""
    side = 16384
    entries = [(256, 4, 1, side), (257, 4, 1, side), (258, 3, 1, 16), (259, 3, 1, 1), (262, 3, 1, 1)]
    entries += [(273, 4, 1, 8), (277, 3, 1, 1), (278, 4, 1, side), (279, 4, 1, 2 * side * side)]
    directory = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *one) for one in entries) + bytes(4)
    npy = io.BytesIO()
    np.lib.format.write_array_header_1_0(npy, {"descr": "<f4", "fortran_order": False, "shape": (side, side, 3)})
    window = struct.pack("<4i", 0, 0, side - 1, side - 1)
    return {
        "x.tif": b"II*\0" + struct.pack("<I", 8) + directory,
        "x.png": b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sII", 13, b"IHDR", side, side),
        "x.jpg": b"\xff\xd8\xff\xe0\0\x04ab\xff\xff\xc2\0\x11\x08" + struct.pack(">HH", side, side) + b"\x03",
        "x.exr": b"\x76\x2f\x31\x01\x02\0\0\0compression\0compression\0\x01\0\0\0\x03"
        + b"dataWindow\0box2i\0\x10\0\0\0"
        + window,
        "x.npy": npy.getvalue(),
    }


@pytest.mark.parametrize("name", list(heads()))
def test_a_file_that_is_too_large_is_refused_from_its_head(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(heads()[name])
    if name == "x.npy":  # numpy maps what is there: a file with a hole takes no room
        with path.open("r+b") as file:
            file.truncate(file.seek(0, 2) + 4 * 3 * 16384**2)
    with pytest.raises(ir.ResourceError, match="16384 x 16384 pixels, at most 67108864"):
        mapped(path)


# --- the answer itself


def test_any_number_of_threads_gives_the_same_bytes() -> None:
    light = photograph(draining(), noise=0.02)
    one, three = (mapped(light, threads=threads) for threads in (1, 3))
    for name in ("thickness_nm", "confidence", "low_nm", "high_nm", "candidates_nm", "weights", "anchors"):
        assert getattr(one, name).tobytes() == getattr(three, name).tobytes(), name
    assert one.to_dict() == three.to_dict()


def test_pages_of_the_tiff(tmp_path: Path) -> None:
    mask = np.zeros((72, 96), dtype=bool)
    mask[0] = True
    found = mapped(photograph(draining()), mask=mask)
    found.save(tmp_path / "map.tif")
    with tifffile.TiffFile(tmp_path / "map.tif") as file:
        pages = file.asarray()
        assert file.is_imagej
    second = (found.candidates_nm[..., 1], found.weights[..., 1])
    wanted = (found.thickness_nm, found.low_nm, found.high_nm, found.confidence, *second)
    assert pages.dtype == np.float32
    np.testing.assert_array_equal(pages, np.stack(wanted))
    assert np.isnan(pages[:4, 0]).all()
    # What has no answer is refused as a scene's map, unless a thickness is given for it.
    with pytest.raises(ValueError, match="NaN at row 0"):
        ir.thickness.ThicknessMap.load(tmp_path / "map.tif", page=1)
    found.save(tmp_path / "filled.tif", unknown_nm=120.0)
    grid = ir.thickness.ThicknessMap.load(tmp_path / "filled.tif", page=1).thickness_nm
    assert (grid[0] == 120.0).all() and (grid[1:] == found.thickness_nm[1:]).all()
    with tifffile.TiffFile(tmp_path / "filled.tif") as file:
        assert (file.asarray()[3, 0] == 0.0).all()
    with pytest.raises(ValueError, match="unknown_nm must be"):
        found.save(tmp_path / "map.tif", unknown_nm=-1.0)
    with pytest.raises(ValueError, match=r"must end in \.tif or \.tiff"):
        found.save(tmp_path / "map.png")


def test_candidates_and_weights_are_probabilities() -> None:
    found = mapped(photograph(draining(), noise=0.03))
    sums = np.nansum(found.weights, axis=-1)
    assert (sums <= 1.0 + 1e-5).all()
    assert np.median(sums) > 0.98
    np.testing.assert_array_equal(found.candidates_nm[..., 0], found.thickness_nm)
    nm, weight = found.at(10, 20)[0]
    assert (nm, weight) == (float(found.thickness_nm[20, 10]), float(found.weights[20, 10, 0]))
    with pytest.raises(ValueError, match="x must be"):
        found.at(1000, 2)


def test_progress_is_told_and_can_stop_it() -> None:
    told: list[tuple[int, int, str]] = []
    light = photograph(draining())
    mapped(light, progress=lambda done, total, stage: told.append((done, total, stage)))
    assert (3 * 72 * 96, 3 * 72 * 96, "mapping") in told

    def stop(done: int, total: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        mapped(light, progress=stop)


def test_charts_and_notebooks() -> None:
    found = mapped(photograph(draining()))
    figure = found.plot()
    assert [ax.get_title() for ax in figure.axes[:4]][3] == "second candidate (nm)"
    figure = found.plot(at=(10, 20))
    assert figure.axes[3].get_title() == "candidates of pixel (10, 20)"
    html = found._repr_html_()
    assert html.startswith('<img alt="thickness map" src="data:image/png;base64,')
    assert "sure of the order" in html


def test_memory_that_is_not_there_is_told_beforehand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the head of a file, before its pixels are read: 180 bytes a pixel."""
    from iridesce.arguments import operands

    side = 2048
    path = tmp_path / "large.npy"
    with path.open("wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (side, side, 3)})
    monkeypatch.setattr(operands, "available_bytes", lambda: 180.0 * side * side - 1.0)
    words = r"mapping .*large\.npy of 2048 x 2048 pixels needs 0.703 GiB, and 0.703 GiB of memory is free; crop it"
    with pytest.raises(ir.ResourceError, match=words):
        mapped(path)
    monkeypatch.setattr(operands, "available_bytes", lambda: 180.0 * side * side)
    with pytest.raises(ValueError, match=r"large\.npy") as caught:
        mapped(path)
    assert not isinstance(caught.value, ir.ResourceError)  # it has no pixels: that is told when they are read
