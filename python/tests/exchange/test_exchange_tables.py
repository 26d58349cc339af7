"""Tables of exact colours: what a texel means, that other programs read it, and that the error stated is the error."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import readers

import iridesce as ir
from iridesce.exchange import exr, lut, png
from iridesce.exchange.films import film_of
from iridesce.exchange.lut import single_file

SOAP = "air / soap ? / air"
TITANIUM = "air / TiO2 ? / Ti"


@pytest.fixture(scope="module")
def soap(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ir.exchange.ExportReport]:
    folder = tmp_path_factory.mktemp("soap")
    return folder, ir.export(SOAP, "lut", folder, vary=(0.0, 1200.0))


def stack(medium: object = "soap", last: object = "air") -> ir.Stack:
    return ir.Stack(["air", ir.Layer(medium, thickness_nm=0.0), last])


# --- what a texel is


def test_a_texel_is_its_thickness_and_cosine(soap: tuple[Path, ir.exchange.ExportReport]) -> None:
    read = lut.read((soap[0] / "film_reflectance.exr").read_bytes(), "x.exr")
    assert read is not None and read.xyz.shape == (64, 512, 3)
    for column, row in ((0, 63), (511, 63), (100, 40), (400, 1), (7, 20)):
        t, cosine = 1200.0 * column / 511, row / 63
        film = ir.Stack(["air", ir.Layer("soap", thickness_nm=t), "air"])
        true = film.color(angle_deg=np.degrees(np.arccos(cosine)))
        assert np.allclose(read.xyz[row, column], true, rtol=1e-3, atol=1e-6)  # half floats: 2**-11


def test_the_first_row_is_the_limit_of_grazing_light(soap: tuple[Path, ir.exchange.ExportReport]) -> None:
    white = ir.color.illuminant("D65").white()
    for quantity, limit in (("reflectance", white), ("transmittance", 0.0 * white)):
        read = lut.read((soap[0] / f"film_{quantity}.exr").read_bytes(), "x.exr")
        assert read is not None
        assert np.allclose(read.xyz[0, 1:], limit, atol=1e-3)
        assert not np.allclose(read.xyz[1, 1:], limit, atol=1e-2), "row 1 would do for row 0"
    # No film, no interface: nothing is reflected at any angle.
    reflectance = lut.read((soap[0] / "film_reflectance.exr").read_bytes(), "x.exr")
    assert reflectance is not None and float(np.abs(reflectance.xyz[:, 0]).max()) == 0.0


def test_reflectance_and_transmittance_make_white(soap: tuple[Path, ir.exchange.ExportReport]) -> None:
    parts = [lut.read((soap[0] / f"film_{name}.exr").read_bytes(), "x.exr") for name in lut.QUANTITIES]
    assert all(part is not None for part in parts)
    total = parts[0].xyz + parts[1].xyz  # type: ignore[union-attr]
    assert np.allclose(total, ir.color.illuminant("D65").white(), atol=1.5e-3)


def test_sampling_follows_the_stated_coordinates(soap: tuple[Path, ir.exchange.ExportReport]) -> None:
    """u = (0.5 + (W - 1) share) / W and v alike, through a reader that knows texels only."""
    read = lut.read((soap[0] / "film_reflectance.exr").read_bytes(), "x.exr")
    assert read is not None
    height, width = read.xyz.shape[:2]
    for t, cosine in ((333.3, 0.77), (0.0, 1.0), (1200.0, 0.0), (871.0, 0.123)):
        u = (0.5 + (width - 1) * t / 1200.0) / width
        v = (0.5 + (height - 1) * cosine) / height
        by_texture = lut.bilinear(read.xyz, np.asarray(u * width - 0.5), np.asarray(v * height - 0.5))
        assert np.allclose(by_texture, read.sample(t, cosine), atol=1e-12)


# --- the error


@pytest.mark.parametrize(
    ("medium", "last", "most"), [("soap", "air", 0.05), (1.47, "water", 0.05), ("TiO2", "Ti", 0.05)]
)
def test_the_error_is_small_and_is_the_one_stated(medium: object, last: object, most: float) -> None:
    content, stated, film = single_file(
        stack(medium, last), ".exr", vary=(0.0, 1200.0), illuminant="D65", size=None, quantity="reflectance"
    )
    assert 0.0 < stated["mean"] <= most and stated["p99"] < 0.3
    read = lut.read(content, "x.exr")
    assert read is not None
    # Measured anew from the file, at places of our own.
    draws = np.random.default_rng(7).random((2, 3000))
    t, cosine = 1200.0 * draws[0], draws[1]
    angle = np.degrees(np.arccos(cosine))
    true = ir.Stack(["air", ir.Layer(medium, thickness_nm=t), last]).color(angle_deg=angle)
    peak = film.xyz(np.linspace(0.0, 1200.0, 24)[None], np.array([0, 15, 30, 45, 60, 75, 85.0])[:, None])[..., 1].max()
    lab = [ir.color.convert(side / peak, "xyz", "lab") for side in (read.sample(t, cosine), true)]
    measured = float(np.mean(ir.color.delta_e(*lab)))
    assert measured == pytest.approx(stated["mean"], rel=0.25)


def test_half_the_texels_err_more() -> None:
    errors = []
    for size in ((512, 64), (128, 32)):
        _, stated, _ = single_file(
            stack(), ".exr", vary=(0.0, 1200.0), illuminant="D65", size=size, quantity="reflectance"
        )
        errors.append(stated["mean"])
    assert errors[1] > 3.0 * errors[0]


def test_the_report_tells_the_chart_of_what_a_reader_gets(soap: tuple[Path, ir.exchange.ExportReport]) -> None:
    folder, report = soap
    assert set(report.delta_e) == {"mean", "p95", "max", "by_angle"}
    assert list(report.delta_e["by_angle"]) == [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0]  # type: ignore[arg-type]
    read = lut.read((folder / "film_reflectance.exr").read_bytes(), "x.exr")
    assert read is not None
    t, angle = np.linspace(0.0, 1200.0, 24)[None], np.array([0, 15, 30, 45, 60, 75, 85.0])[:, None]
    true = ir.Stack(["air", ir.Layer("soap", thickness_nm=t), "air"]).color(angle_deg=angle)
    seen = read.sample(t, np.cos(np.radians(angle)))
    white = ir.color.illuminant("D65")
    lab = [ir.color.convert(side / true[..., 1].max(), "xyz", "lab", white=white) for side in (seen, true)]
    values = ir.color.delta_e(*lab)
    assert report.delta_e["mean"] == pytest.approx(values.mean(), abs=1e-9)
    assert report.delta_e["max"] == pytest.approx(values.max(), abs=1e-9)


# --- files that others read


def test_openimageio_reads_the_exr(soap: tuple[Path, ir.exchange.ExportReport]) -> None:
    oiio = readers.module("OpenImageIO")
    buffer = oiio.ImageBuf(str(soap[0] / "film_reflectance.exr"))
    spec = buffer.spec()
    assert (spec.width, spec.height, tuple(spec.channelnames)) == (512, 64, ("X", "Y", "Z"))
    assert str(spec.format) == "half"
    ours = lut.read((soap[0] / "film_reflectance.exr").read_bytes(), "x.exr")
    assert ours is not None and np.array_equal(buffer.get_pixels(oiio.FLOAT), ours.xyz.astype(np.float32))
    assert spec.getattribute("iridesce:illuminant") == "D65"
    assert tuple(spec.getattribute("iridesce:thickness_nm")) == (0.0, 1200.0)


def test_openimageio_reads_the_png(tmp_path: Path) -> None:
    oiio = readers.module("OpenImageIO")
    content, _, film = single_file(
        stack(), ".png", vary=(0.0, 1200.0), illuminant="D65", size=None, quantity="reflectance"
    )
    (tmp_path / "x.png").write_bytes(content)
    buffer = oiio.ImageBuf(str(tmp_path / "x.png"))
    scale = float(buffer.spec().getattribute("iridesce:scale"))
    xyz = buffer.get_pixels(oiio.FLOAT)[..., :3].astype(np.float64) * scale
    true = film.xyz(np.linspace(0.0, 1200.0, 512)[None], 0.0)[0]
    assert np.abs(xyz[-1] - true).max() <= 0.51 * scale / 65535.0
    read = lut.read(content, "x.png")
    assert read is not None and np.abs(read.xyz - xyz).max() < 1e-6 and read.range_nm == (0.0, 1200.0)


def test_opencolorio_reads_the_cube(tmp_path: Path) -> None:
    ocio = readers.module("PyOpenColorIO")
    ir.export(SOAP, "cube", tmp_path, vary=(50.0, 1200.0))
    transform = ocio.FileTransform(str(tmp_path / "film.cube"), interpolation=ocio.INTERP_LINEAR)
    processor = ocio.Config.CreateRaw().getProcessor(transform).getDefaultCPUProcessor()
    thickness = np.linspace(50.0, 1200.0, 301)
    seen = np.array([processor.applyRGB([float(t)] * 3) for t in thickness])
    true = ir.Stack(["air", ir.Layer("soap", thickness_nm=thickness), "air"]).color()
    lab = [ir.color.convert(side / true[..., 1].max(), "xyz", "lab") for side in (seen, true)]
    values = ir.color.delta_e(*lab)
    assert float(values.mean()) < 0.01 and float(values.max()) < 0.1


def test_a_cube_claims_normal_light_alone(tmp_path: Path) -> None:
    report = ir.export(SOAP, "cube", tmp_path, vary=(50.0, 1200.0))
    angles = report.delta_e["by_angle"]
    assert report.delta_e["mean"] == angles[0.0] < 0.01 < 1.0 < angles[60.0]  # type: ignore[index]
    assert any("0 degrees" in sentence for sentence in report.dropped)
    text = (tmp_path / "film.cube").read_text()
    assert "LUT_1D_SIZE 1024" in text and "DOMAIN_MAX 1200 1200 1200" in text and "nm" in text


@pytest.mark.parametrize("compression", ["NO_COMPRESSION", "RLE_COMPRESSION", "ZIPS_COMPRESSION", "ZIP_COMPRESSION"])
@pytest.mark.parametrize("kind", [np.float16, np.float32, np.uint32])
def test_our_reader_takes_what_openexr_writes(tmp_path: Path, compression: str, kind: type) -> None:
    OpenEXR = readers.module("OpenEXR")
    values = (np.random.default_rng(1).random((37, 53, 2)) * 100).astype(kind)
    values[5:30] = values[5]  # something to compress
    header = {"compression": getattr(OpenEXR, compression), "type": OpenEXR.scanlineimage, "who": "me"}
    channels = {name: np.ascontiguousarray(values[..., axis]) for axis, name in enumerate("AB")}
    OpenEXR.File(header, channels).write(str(tmp_path / "x.exr"))
    read = exr.read_exr((tmp_path / "x.exr").read_bytes(), "x.exr")
    assert read.attributes["who"] == "me"
    for axis, name in enumerate("AB"):
        assert np.array_equal(read.channels[name], values[..., axis].astype(np.float32))


def test_piz_is_refused_with_a_way_out(tmp_path: Path) -> None:
    OpenEXR = readers.module("OpenEXR")
    header = {"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"Y": np.ones((8, 8), np.float32)}).write(str(tmp_path / "x.exr"))
    with pytest.raises(ValueError, match=r"x\.exr: .*PIZ.*ZIP"):
        exr.read_exr((tmp_path / "x.exr").read_bytes(), "x.exr")


def test_our_png_reader_takes_every_filter(tmp_path: Path) -> None:
    """libpng, through Pillow, chooses the filters by itself; a photograph-like picture brings all of them."""
    from PIL import Image

    y, x = np.mgrid[0:64, 0:80]
    smooth = 128 + 60 * np.sin(x / 9.0) * np.cos(y / 7.0)
    noisy = smooth[..., None] + np.random.default_rng(2).normal(0, 6, (64, 80, 3))
    values = np.clip(noisy, 0, 255).astype(np.uint8)
    Image.fromarray(values).save(tmp_path / "x.png")
    read = png.read_png((tmp_path / "x.png").read_bytes(), "x.png")
    assert read.peak == 255 and np.array_equal(read.values, values)


@pytest.mark.parametrize("ending", [".exr", ".png"])
def test_damaged_files_are_refused_in_words(ending: str) -> None:
    content, _, _ = single_file(
        stack(), ending, vary=(0.0, 900.0), illuminant="D65", size=(32, 8), quantity="reflectance"
    )
    generator = np.random.default_rng(3)
    for number in range(300):
        broken = bytearray(content)
        if number % 2:
            broken = broken[: int(generator.integers(0, len(content)))]
        else:
            for place in generator.integers(0, len(content), 3):
                broken[place] ^= 1 << int(generator.integers(0, 8))
        try:
            lut.read(bytes(broken), f"x{ending}")
        except ValueError as error:
            wrong = None if f"x{ending}" in str(error) else error
        else:
            wrong = None
        assert wrong is None, "an error that does not name the file"


def test_the_same_bytes_each_time(tmp_path: Path) -> None:
    for target in ("lut", "cube", "shader", "osl"):
        first = ir.export(TITANIUM, target, tmp_path / "a", vary=(0.0, 300.0))
        second = ir.export(TITANIUM, target, tmp_path / "b", vary=(0.0, 300.0))
        for a, b in zip(first.files, second.files, strict=True):
            assert a.read_bytes() == b.read_bytes()
            assert str(tmp_path).encode() not in a.read_bytes()


# --- what is asked


def test_a_metal_has_no_table_of_transmittance(tmp_path: Path) -> None:
    report = ir.export(TITANIUM, "lut", tmp_path, vary=(0.0, 300.0))
    assert [path.name for path in report.files] == ["film_reflectance.exr"]
    assert any("Ti" in note for note in report.notes)


def test_the_layer_with_a_question_mark_varies(tmp_path: Path) -> None:
    ir.export("air / SiO2 ? / Si3N4 80 / Si", "lut", tmp_path, vary=(0.0, 500.0))
    read = lut.read((tmp_path / "film_reflectance.exr").read_bytes(), "x.exr")
    true = ir.Stack(["air", ir.Layer("SiO2", 500.0), ir.Layer("Si3N4", 80.0), "Si"]).color()
    assert read is not None and np.allclose(read.xyz[-1, -1], true, rtol=1e-3)


def test_another_lamp_is_in_the_table_and_in_its_head(tmp_path: Path) -> None:
    ir.export(SOAP, "lut", tmp_path, vary=(0.0, 1000.0), illuminant="FL2")
    read = lut.read((tmp_path / "film_reflectance.exr").read_bytes(), "x.exr")
    true = ir.Stack(["air", ir.Layer("soap", 1000.0), "air"]).color(illuminant="FL2")
    assert read is not None and read.illuminant == "FL2" and np.allclose(read.xyz[-1, -1], true, rtol=1e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"to": "unreal"}, "to must be one of lut, cube"),
        ({"to": 3}, "to must be one of"),
        ({"vary": (300.0, 100.0)}, "thinner to a thicker"),
        ({"vary": (-1.0, 100.0)}, "vary must be >= 0"),
        ({"vary": (0.0, float("nan"))}, "vary must be"),
        ({"vary": (0.0, 1e9)}, "100000 nm or below"),
        ({"vary": 300.0}, "two thicknesses"),
        ({"illuminant": "D66"}, "D66"),
        ({"fit": "yes"}, "fit must be"),
        ({"stack_or_scene": "air / soap ? / SiO2 ? / air"}, "only one layer"),
        ({"stack_or_scene": "air / soap 3 / SiO2 4 / air"}, "which of the 2 layers varies"),
        ({"stack_or_scene": "air / glas"}, "glas"),
        ({"stack_or_scene": ir.Stack(["air", 1.5]), "vary": None}, "there is none here"),
        ({"stack_or_scene": ir.Stack(["air", 1.5])}, "needs a stack with a layer"),
        ({"stack_or_scene": "soap-bubble"}, "vary and thickness go with a stack"),
        ({"thickness": np.full((2, 2), 2000.0)}, "beyond vary"),
        ({"thickness": "missing.tif"}, "missing.tif"),
    ],
)
def test_wrong_questions_are_refused_in_words(tmp_path: Path, arguments: dict[str, object], message: str) -> None:
    question = {"stack_or_scene": SOAP, "to": "lut", "path": tmp_path / "out", "vary": (0.0, 1000.0), **arguments}
    with pytest.raises(ValueError, match=message):
        ir.export(question.pop("stack_or_scene"), question.pop("to"), question.pop("path"), **question)  # type: ignore[arg-type]
    assert not (tmp_path / "out").exists(), "something was written"


def test_places_that_take_no_files(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(NotADirectoryError):
        ir.export(SOAP, "cube", tmp_path / "file", vary=(0.0, 100.0))
    with pytest.raises(FileNotFoundError):
        ir.export(SOAP, "cube", tmp_path / "no" / "such", vary=(0.0, 100.0))
    (tmp_path / "film.cube").mkdir()
    with pytest.raises(IsADirectoryError):
        ir.export(SOAP, "cube", tmp_path, vary=(0.0, 100.0))


def test_a_failure_half_way_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "film_transmittance.exr").mkdir()  # the second file cannot be written
    with pytest.raises(IsADirectoryError):
        ir.export(SOAP, "lut", tmp_path, vary=(0.0, 100.0))
    assert [path.name for path in tmp_path.iterdir()] == ["film_transmittance.exr"]


def test_long_attribute_names_are_declared() -> None:
    """Names beyond 31 letters need a flag in the version field of OpenEXR."""
    plane = {"Y": np.zeros((2, 2), np.float32)}
    assert struct.unpack_from("<I", exr.exr_bytes(plane, {"a" * 20: 1}), 4)[0] == 2
    assert struct.unpack_from("<I", exr.exr_bytes(plane, {"a" * 40: 1}), 4)[0] == 0x402


def test_the_film_of_a_stack_knows_its_range() -> None:
    light = ir.color.illuminant("D65")
    assert film_of(ir.Stack(["air", ir.Layer("soap", [100.0, 300.0]), "air"]), None, None, None, light).range_nm == (
        100,
        300,
    )
    fixed = film_of(ir.Stack(["air", ir.Layer("soap", 320.0), "air"]), None, None, None, light)
    assert not fixed.varies and fixed.table_range() == (0.0, 2000.0) and fixed.free
