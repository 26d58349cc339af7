"""Pictures: developed, saved, read back by other programs; and renders that can be watched and stopped."""

from __future__ import annotations

import errno
import io
import json
import os
import struct
import subprocess
import sys
import threading
import zlib
from pathlib import Path

import numpy as np
import OpenEXR
import PIL.Image
import pytest

import iridesce as ir
from iridesce import color
from iridesce.image import check_output

SMALL = {"samples": 2, "size": (40, 30)}
WHITE = np.array([0.3127 / 0.3290, 1.0, 0.3583 / 0.3290])

# IEC 61966-2-1, ITU-R BT.709 luminances to four digits.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@pytest.fixture(scope="module")
def image() -> ir.Image:
    """A small bubble, with colours outside sRGB and pixels off the film."""
    return ir.render("soap-bubble", **SMALL)


def picture(linear, space: str = "linear-srgb", **planes) -> ir.Image:
    """An image of linear RGB."""
    return ir.Image(color.convert(np.asarray(linear, float), space, "xyz"), **planes)


def chunks(file: bytes) -> dict[str, bytes]:
    """The chunks of a PNG, read by hand; checks every CRC."""
    assert file[:8] == b"\x89PNG\r\n\x1a\n"
    found, at = {}, 8
    while at < len(file):
        (length,) = struct.unpack(">I", file[at : at + 4])
        kind, data = file[at + 4 : at + 8], file[at + 8 : at + 8 + length]
        assert struct.unpack(">I", file[at + 8 + length : at + 12 + length])[0] == zlib.crc32(kind + data)
        found.setdefault(kind.decode(), data)
        at += 12 + length
    assert "IEND" in found
    return found


def names_in(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


# --- what an image is


def test_an_image_has_its_planes(image):
    assert image.xyz.shape == image.shape == (30, 40, 3)
    assert (image.width, image.height) == (40, 30)
    assert image.xyz.dtype == np.float32
    depth, thickness_nm, normal = (image.channels[k] for k in ("depth", "thickness_nm", "normal"))
    assert depth.shape == thickness_nm.shape == (30, 40)
    assert normal.shape == (30, 40, 3)
    whole = {"object", "samples"}
    for name, plane in image.channels.items():
        assert plane.dtype == (np.int32 if name in whole else np.float32), name
    film = np.isfinite(depth)
    assert film[15, 20]
    assert not film[0, 0]
    assert np.isposinf(depth[~film]).all()
    assert np.array_equal(np.isnan(thickness_nm), ~film)
    assert (normal[~film] == 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(normal[film], axis=-1), 1.0, atol=1e-6)
    # Row 0 on top, and the first film is met from in front: normals look up above and towards the camera (+z).
    assert normal[6, 20, 1] > 0.0 > normal[24, 20, 1]
    assert (normal[film][:, 2] > 0.0).all()


def test_a_picture_is_read_only_and_its_own(image):
    with pytest.raises(ValueError, match="read-only"):
        image.xyz[0, 0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        image.channels["depth"][0, 0] = 0.0
    mine = np.ones((2, 2, 3))
    held = ir.Image(mine)
    mine[:] = 7.0
    assert (held.xyz == 1.0).all()
    metadata = held.metadata
    metadata["exposure"] = "mine"
    assert held.metadata["exposure"] != "mine"


def test_arrays_of_any_layout_become_images():
    xyz = np.arange(2 * 3 * 3, dtype=float).reshape(2, 3, 3)
    for layout in (xyz[:, ::-1], np.asfortranarray(xyz), xyz.astype(">f8"), xyz.astype(int), xyz.tolist()):
        held = ir.Image(layout)
        assert held.xyz.flags.c_contiguous
        np.testing.assert_array_equal(held.xyz, np.asarray(layout))
        assert held.rgb().shape == (2, 3, 3)


@pytest.mark.parametrize(
    ("planes", "said"),
    [
        ({"xyz": np.ones((2, 3))}, r"shape \(height, width, 3\).*got shape \(2, 3\)"),
        ({"xyz": np.ones((2, 3, 4))}, r"got shape \(2, 3, 4\)"),
        ({"xyz": np.ones((0, 3, 3))}, r"at least one pixel, got shape \(0, 3, 3\)"),
        ({"xyz": 1.0}, r"got shape \(\)"),
        ({"xyz": "red"}, "xyz must be an array of real numbers"),
        ({"xyz": None}, "xyz"),
        ({"xyz": np.array([[[1.0, np.nan, 0.0]]])}, r"xyz must be finite, got nan at index \(0, 0, 1\)"),
        ({"xyz": np.full((1, 2, 3), np.inf)}, r"got inf at index \(0, 0, 0\)"),
        (
            {"xyz": np.ones((2, 3, 3)), "depth": np.ones((3, 2))},
            r"depth must be of shape \(2, 3\) like xyz, got shape \(3, 2\)",
        ),
        ({"xyz": np.ones((2, 3, 3)), "normal": np.ones((2, 3))}, r"normal must be of shape \(2, 3, 3\)"),
        ({"xyz": np.ones((2, 3, 3)), "thickness_nm": [1.0, 2.0]}, "thickness_nm must be of shape"),
    ],
)
def test_what_is_no_image_is_said(planes, said):
    with pytest.raises(ValueError, match=said):
        ir.Image(**planes)


def test_metadata_repeats_the_render(image):
    metadata = image.metadata
    assert {"samples", "seed", "seconds", "backend", "simd", "version", "exposure", "out_of_gamut", "scene"} <= set(
        metadata
    )
    assert metadata["samples"] == 2
    assert metadata["seed"] == 1
    assert metadata["backend"] == "cpu"
    assert metadata["version"] == ir.__version__
    assert metadata["seconds"] > 0.0
    assert metadata["scene"]["camera"]["resolution"] == [40, 30]
    assert np.array_equal(ir.render(metadata["scene"]).xyz, image.xyz)
    other = ir.render("soap-bubble", seed=2**64 - 1, **SMALL)
    assert other.metadata["seed"] == 2**64 - 1
    assert not np.array_equal(other.xyz, image.xyz)
    assert np.array_equal(ir.render(other.metadata["scene"]).xyz, other.xyz)


def test_metadata_tells_of_the_latest_development(tmp_path):
    held = picture([[[0.5, 0.25, 0.0], [0.2, 0.2, 0.2], [-0.1, 0.5, 0.2], [0.1, 0.5, 0.2]]])
    # Before any: what save("x.png") would do. The 95th percentile of four is the third, 0.5: log2(0.9 / 0.5) = 0.848.
    assert held.metadata["exposure"] == 0.85
    assert held.metadata["out_of_gamut"] == 0.25
    held.rgb(exposure=2.0)
    assert (held.metadata["exposure"], held.metadata["out_of_gamut"]) == (2.0, 0.75)
    held.save(tmp_path / "x.png", exposure=0.0, space="rec2020")
    assert (held.metadata["exposure"], held.metadata["out_of_gamut"]) == (0.0, 0.0)
    assert held.metadata["space"] == "rec2020"
    assert held._repr_png_()
    assert held.metadata["space"] == "rec2020"


# --- development


@pytest.mark.parametrize("space", ["srgb", "display-p3", "rec2020"])
@pytest.mark.parametrize("gamut", ["hue", "clip"])
def test_colours_inside_come_out_exactly(space, gamut):
    encoded = np.random.default_rng(5).uniform(0.0, 1.0, (16, 16, 3))
    for exposure in (-1.5, 0.0, 3.0):
        held = ir.Image(color.convert(encoded, space, "xyz") / 2.0**exposure)
        rgb = held.rgb(space, exposure, gamut)
        assert rgb.dtype == np.float32
        # f32 XYZ, 6e-8 relative, times 12.92 where the curve is steep
        np.testing.assert_allclose(rgb, encoded, atol=4e-6)


def oklch(encoded, space):
    lightness, a, b = np.moveaxis(color.convert(encoded, space, "oklab"), -1, 0)
    return lightness, np.hypot(a, b), np.arctan2(b, a)


@pytest.mark.parametrize("space", ["srgb", "display-p3", "rec2020"])
def test_hue_is_kept_where_the_space_ends(space):
    linear = np.random.default_rng(6).uniform(-0.1, 3.0, (32, 32, 3))
    held = ir.Image(color.convert(linear, "linear-srgb", "xyz"))
    rgb = held.rgb(space).astype(float)
    assert rgb.min() >= 0.0
    assert rgb.max() <= 1.0
    _, chroma, hue = oklch(rgb, space)
    _, _, wanted = oklch(linear, "linear-srgb")
    turn = np.abs(np.angle(np.exp(1j * (hue - wanted))))
    # Hue times chroma is how far the colour is off; 1e-4 of Oklab is far below a just noticeable difference (0.02).
    assert (turn * chroma).max() < 2e-4
    clipped = held.rgb(space, gamut="clip").astype(float)
    _, chroma, hue = oklch(clipped, space)
    assert (np.abs(np.angle(np.exp(1j * (hue - wanted)))) * chroma).max() > 0.05, (
        "clipping turns hues: the check can fail"
    )


def test_clip_is_numpys_clip():
    linear = np.random.default_rng(7).uniform(-0.5, 2.0, (8, 8, 3))
    expected = color.convert(np.clip(linear, 0.0, 1.0), "linear-srgb", "srgb")
    np.testing.assert_allclose(picture(linear).rgb(gamut="clip"), expected, atol=4e-6)


def test_highlights_whiten_step_by_step():
    steps = np.exp2(np.linspace(-1.0, 8.0, 400))
    rgb = picture(steps[None, :, None] * np.array([1.0, 0.3, 0.05])).rgb()[0].astype(float)
    lightness, chroma, _ = oklch(rgb, "srgb")
    assert (np.diff(lightness) > -1e-5).all(), "brighter light never looks darker"
    assert np.abs(np.diff(rgb, axis=0)).max() < 0.03, "no jumps"
    assert (rgb[-1] > 0.98).all()
    assert chroma[steps > 2.0][0] > 0.05, "a stop over is still a colour"


def test_auto_exposure_meters_what_is_there():
    grey = np.full((10, 10, 1), 0.5) * np.ones(3)
    # log2(0.9 / 0.5) = 0.848
    held = picture(grey)
    np.testing.assert_allclose(held.rgb(exposure="auto"), held.rgb(exposure=0.85), atol=0.0)
    assert held.metadata["exposure"] == 0.85
    # A lamp in the background does not matter, once there is a surface to look at.
    depth = np.full((10, 10), np.inf)
    depth[5:] = 3.0
    lamp = grey.copy()
    lamp[:5] = 1000.0
    held = picture(lamp, depth=depth)
    assert held.metadata["exposure"] == 0.85
    assert picture(lamp).metadata["exposure"] == pytest.approx(np.log2(0.9 / 1000.0), abs=0.006)
    assert ir.Image(np.zeros((4, 4, 3))).metadata["exposure"] == 0.0
    assert ir.Image(np.full((4, 4, 3), -1.0)).metadata["exposure"] == 0.0
    tiny = ir.Image(np.full((4, 4, 3), 1e-38))
    assert tiny.metadata["exposure"] == 64.0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"space": "sRGB"}, r"space must be \"srgb\", \"display-p3\" or \"rec2020\", got 'sRGB'"),
        ({"space": None}, "space must be .* got None"),
        ({"gamut": "wide"}, r"gamut must be \"hue\" or \"clip\", got 'wide'"),
        ({"gamut": 1}, "gamut"),
        ({"exposure": "bright"}, r"exposure must be a number of stops from -64 to 64 or \"auto\", got 'bright'"),
        ({"exposure": float("nan")}, 'exposure must be a number of stops from -64 to 64 or "auto", got nan'),
        ({"exposure": 65}, "exposure must be .* got 65"),
        ({"exposure": True}, "exposure must be .* got True"),
        ({"exposure": 1j}, "exposure"),
        ({"exposure": None}, "exposure"),
        ({"exposure": [1.0]}, "exposure"),
    ],
)
def test_wrong_arguments_are_named(image, tmp_path, arguments, said):
    with pytest.raises(ValueError, match=said):
        image.rgb(**arguments)
    for name in ("x.png", "x.exr"):
        with pytest.raises(ValueError, match=said):
            image.save(tmp_path / name, **arguments)
    assert not list(tmp_path.iterdir())


def test_extreme_values_stay_in_range():
    held = ir.Image([[[3e38, 3e38, 3e38], [-3e38, 3e38, 0.0], [0.0, -3e38, 0.0], [1e-45, 0.0, 3e38]]])
    for space in ("srgb", "display-p3", "rec2020"):
        for exposure in (-64, 0.0, np.float32(64.0), "auto"):
            for gamut in ("hue", "clip"):
                rgb = held.rgb(space, exposure, gamut)
                assert ((rgb >= 0.0) & (rgb <= 1.0)).all()


# --- PNG


@pytest.mark.parametrize(("bits", "steps"), [(8, 255), (16, 65535)])
def test_a_png_holds_the_nearest_steps(tmp_path, bits, steps):
    encoded = np.random.default_rng(8).uniform(0.0, 1.0, (9, 13, 3))
    if bits == 8:
        encoded = np.round(encoded * 255.0) / 255.0  # between steps there is dither
    held = ir.Image(color.convert(encoded, "srgb", "xyz"))
    path = tmp_path / "x.PNG"
    held.save(path, exposure=0.0, bits=bits)
    file = path.read_bytes()
    header = struct.unpack(">IIBBBBB", chunks(file)["IHDR"])
    assert header == (13, 9, bits, 2, 0, 0, 0)
    expected = np.round(held.rgb().astype(float) * steps)
    # Pillow, and matplotlib through it, read 16-bit colour as 8 bits: undo the filters by hand.
    read = np.asarray(PIL.Image.open(path), dtype=float) if bits == 8 else sixteen_bits(file, 13, 9)
    np.testing.assert_array_equal(read, expected)


def test_eight_bits_are_dithered_below_one_step(tmp_path):
    """A slow gradient: no pixel is a step off, the mean of any 8 x 8 patch is right, and grey stays grey."""
    ramp = np.linspace(0.30, 0.34, 256)[None, :, None] * np.ones((64, 1, 3))
    held = ir.Image(color.convert(ramp, "srgb", "xyz"))
    held.save(tmp_path / "x.png", exposure=0.0)
    read = np.asarray(PIL.Image.open(tmp_path / "x.png"), dtype=float)
    wanted = held.rgb().astype(float) * 255.0
    assert np.abs(read - wanted).max() < 1.0
    # (Three channels of a grey differ by the rounding of XYZ; the threshold is the same for all of them.)
    assert (np.ptp(read, axis=-1) == 0.0).mean() > 0.999
    patches = (read - wanted)[..., 0].reshape(8, 8, 32, 8).mean(axis=(1, 3))
    assert np.abs(patches).max() < 0.06
    assert np.abs((np.round(wanted) - wanted)[..., 0].reshape(8, 8, 32, 8).mean(axis=(1, 3))).max() > 0.3, "can fail"
    held.save(tmp_path / "again.png", exposure=0.0)
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "x.png").read_bytes()


def test_a_png_of_premultiplied_colour_divides_by_alpha(tmp_path):
    alpha = np.array([[0.25, 0.5, 1.0, 0.0]], np.float32)
    straight = color.convert(np.full((1, 4, 3), 0.5), "linear-srgb", "xyz")
    held = ir.Image._of_render(
        (straight * alpha[..., None]).astype(np.float32), {**ir.Image(straight).channels, "alpha": alpha}, {}, {}
    )
    held.save(tmp_path / "x.png", exposure=0.0, bits=8)
    read = np.asarray(PIL.Image.open(tmp_path / "x.png"), dtype=float)
    assert read.shape == (1, 4, 4)
    np.testing.assert_allclose(read[0, :3, :3], 188.0, atol=1.0)
    np.testing.assert_array_equal(read[0, :, 3], [64, 128, 255, 0])
    held.save(tmp_path / "x.exr")
    with OpenEXR.File(str(tmp_path / "x.exr"), separate_channels=True) as file:
        np.testing.assert_array_equal(file.channels()["A"].pixels, alpha)
    assert np.array_equal(ir.Image.load(tmp_path / "x.exr").channels["alpha"], alpha)
    bright = ir.Image._of_render(held.xyz.copy() * 3.0, {**held.channels}, {}, {})
    bright.save(tmp_path / "bright.png", exposure=0.0)
    assert bright.metadata["out_of_gamut"] == 0.75, "the share of pixels that clip is told"


def sixteen_bits(file: bytes, width: int, height: int) -> np.ndarray:
    """Pixels of an RGB16 PNG (W3C PNG specification, section 9: filters)."""
    data, at = b"", 8
    while at < len(file):
        (length,) = struct.unpack(">I", file[at : at + 4])
        if file[at + 4 : at + 8] == b"IDAT":
            data += file[at + 8 : at + 8 + length]
        at += 12 + length
    raw, stride, bpp = zlib.decompress(data), 6 * width, 6
    rows, above = [], [0] * stride
    for y in range(height):
        kind, line = raw[y * (stride + 1)], list(raw[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
        for i in range(stride):
            left = line[i - bpp] if i >= bpp else 0
            corner = above[i - bpp] if i >= bpp else 0
            p = left + above[i] - corner
            near = min((left, above[i], corner), key=lambda v: abs(p - v))
            line[i] = (line[i] + [0, left, above[i], (left + above[i]) // 2, near][kind]) % 256
        rows.append(line)
        above = line
    return np.frombuffer(bytes(byte for line in rows for byte in line), ">u2").reshape(height, width, 3).astype(float)


def test_a_png_is_tagged_with_its_space(tmp_path, image):
    image.save(tmp_path / "srgb.png")
    tags = chunks((tmp_path / "srgb.png").read_bytes())
    assert tags["sRGB"] == b"\x01"
    assert struct.unpack(">I", tags["gAMA"]) == (45455,)
    assert struct.unpack(">8I", tags["cHRM"]) == (31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
    for space, code_points in (("display-p3", b"\x0c\x0d\x00\x01"), ("rec2020", b"\x09\x0e\x00\x01")):
        image.save(tmp_path / "wide.png", space=space)
        tags = chunks((tmp_path / "wide.png").read_bytes())
        assert tags["cICP"] == code_points
        assert "sRGB" not in tags
        assert "iCCP" in tags


@pytest.mark.parametrize("space", ["display-p3", "rec2020"])
def test_colour_management_reads_the_profile_as_we_do(tmp_path, space):
    """LittleCMS (through Pillow) converts our tagged file to sRGB; the colours must be those of our own sRGB."""
    from PIL import ImageCms

    linear = np.random.default_rng(9).uniform(0.05, 0.95, (8, 8, 3))
    held = picture(linear)
    held.save(tmp_path / "wide.png", exposure=0.0, space=space)
    wide = PIL.Image.open(tmp_path / "wide.png")
    profile = ImageCms.ImageCmsProfile(io.BytesIO(wide.info["icc_profile"]))
    read = ImageCms.profileToProfile(wide, profile, ImageCms.createProfile("sRGB"), renderingIntent=1)
    # Both are rounded to 8 bits; near black a step of one is up to three of the other.
    np.testing.assert_allclose(np.asarray(read, float), held.rgb() * 255.0, atol=2.5)
    # Without the profile the numbers differ: the check can fail.
    assert np.abs(np.asarray(wide, float) - held.rgb() * 255.0).max() > 8.0


def test_a_png_says_how_it_was_made(tmp_path, image):
    image.save(tmp_path / "x.png", exposure=-0.5)
    text = PIL.Image.open(tmp_path / "x.png").text
    assert text["Software"] == f"iridesce {ir.__version__}"
    assert (text["samples"], text["seed"], text["backend"]) == ("2", "1", "cpu")
    assert text["simd"] == image.metadata["simd"]
    assert float(text["exposure"]) == -0.5
    assert float(text["out_of_gamut"]) == image.metadata["out_of_gamut"]
    assert np.array_equal(ir.render(json.loads(text["scene"])).xyz, image.xyz)


def test_a_notebook_shows_the_picture(image):
    shown = PIL.Image.open(io.BytesIO(image._repr_png_()))
    assert shown.size == (40, 30)
    # (Dithered: within a step.)
    assert np.abs(np.asarray(shown, float) - image.rgb(exposure="auto") * 255.0).max() < 1.0


# --- EXR


def test_an_exr_holds_everything(tmp_path, image):
    image.save(tmp_path / "x.exr", exposure=3.0)
    with OpenEXR.File(str(tmp_path / "x.exr"), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
        header = dict(file.header())
    assert {name for name, plane in channels.items() if plane.dtype != np.float32} == {"samples"}
    assert channels["samples"].dtype == np.uint32
    xyz = np.stack([channels[f"XYZ.{axis}"] for axis in "XYZ"], -1)
    np.testing.assert_array_equal(xyz, image.xyz)
    np.testing.assert_array_equal(
        np.stack([channels[f"normal.{axis}"] for axis in "XYZ"], -1), image.channels["normal"]
    )
    np.testing.assert_array_equal(channels["depth.Z"], image.channels["depth"])
    np.testing.assert_array_equal(channels["thickness_nm"], image.channels["thickness_nm"])
    rgb = np.stack([channels[c] for c in "RGB"], -1).astype(float)
    np.testing.assert_allclose(rgb, color.convert(image.xyz.astype(float), "xyz", "linear-srgb"), atol=1e-6)
    np.testing.assert_allclose(rgb @ LUMINANCE, image.xyz[..., 1], atol=2e-4)
    assert rgb.min() < 0.0, "colours outside Rec.709 are kept"
    assert set(channels) == {
        *("R", "G", "B", "depth.Z", "thickness_nm", "path_difference_nm", "object", "variance", "samples"),
        *(f"{n}.{a}" for n in ("XYZ", "normal") for a in "XYZ"),
    }

    assert header["software"] == f"iridesce {ir.__version__}"
    assert (header["samples"], header["seed"], header["backend"]) == (2, "1", "cpu")
    assert header["simd"] == image.metadata["simd"]
    np.testing.assert_allclose(header["chromaticities"], (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329), atol=1e-7)
    assert np.array_equal(ir.render(json.loads(header["scene"])).xyz, image.xyz)


def test_an_exr_comes_back_whole(tmp_path, image):
    image.save(tmp_path / "x.exr")
    again = ir.Image.load(tmp_path / "x.exr")
    assert again.xyz.tobytes() == image.xyz.tobytes()
    assert again.channels.keys() == image.channels.keys()
    for name, plane in image.channels.items():
        assert again.channels[name].dtype == plane.dtype, name
        assert again.channels[name].tobytes() == plane.tobytes(), name
    assert again.scene == json.loads(json.dumps(image.scene))
    assert np.array_equal(ir.render(again.scene).xyz, image.xyz)
    for key in ("samples", "seed", "backend", "simd", "version"):
        assert again.metadata[key] == image.metadata[key], key
    again.save(tmp_path / "again.exr")
    assert (tmp_path / "again.exr").read_bytes() == (tmp_path / "x.exr").read_bytes()
    assert ir.Image(np.ones((2, 2, 3))).scene is None


def test_half_floats_hold_three_digits(tmp_path, image):
    image.save(tmp_path / "x.exr", half=True)
    with OpenEXR.File(str(tmp_path / "x.exr"), separate_channels=True) as file:
        types = {name: channel.pixels.dtype for name, channel in file.channels().items()}
    halves = {name for name, kind in types.items() if kind == np.float16}
    assert halves == {"R", "G", "B"} | {f"{n}.{a}" for n in ("XYZ", "normal") for a in "XYZ"}
    again = ir.Image.load(tmp_path / "x.exr")
    np.testing.assert_allclose(again.xyz, image.xyz, rtol=2**-11, atol=1e-7)
    assert again.channels["thickness_nm"].tobytes() == image.channels["thickness_nm"].tobytes()
    ir.Image([[[1e6, 1e6, 1e6]]]).save(tmp_path / "sun.exr", half=True)
    assert (ir.Image.load(tmp_path / "sun.exr").xyz == 65504.0).all()


def test_pictures_of_other_programs_are_read_by_their_primaries(tmp_path):
    rgb = np.random.default_rng(3).uniform(0.0, 1.0, (3, 4, 3)).astype(np.float32)
    wide = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290)  # ITU-R BT.2020-2, table 3
    for corners, space in ((None, "linear-srgb"), (wide, "rec2020")):
        header = {} if corners is None else {"chromaticities": corners}
        channels = {letter: np.ascontiguousarray(rgb[..., i]) for i, letter in enumerate("RGB")}
        OpenEXR.File(header, channels).write(str(tmp_path / "x.exr"))
        linear = rgb if space == "linear-srgb" else color.convert(rgb, "linear-srgb", "srgb")
        read = ir.Image.load(tmp_path / "x.exr").xyz
        if corners is None:
            np.testing.assert_allclose(read, color.convert(linear, "linear-srgb", "xyz"), atol=1e-5)
        else:
            # White is white, and red is where the file says.
            np.testing.assert_allclose(read.sum(axis=-1) > 0.0, True)
            red = ir.Image.load(_only(tmp_path, "R", corners)).xyz[0, 0]
            np.testing.assert_allclose(red[:2] / red.sum(), corners[:2], atol=1e-6)
    OpenEXR.File({}, {"Z": np.ones((2, 2), np.float32)}).write(str(tmp_path / "z.exr"))
    for name, said in (("z.exr", "needs the channels R, G, B"), ("none.exr", "no such file"), ("x.png", r"\.exr")):
        with pytest.raises(ValueError, match=said):
            ir.Image.load(tmp_path / name)
    (tmp_path / "torn.exr").write_bytes((tmp_path / "x.exr").read_bytes()[:300])
    with pytest.raises(ValueError, match=r"torn\.exr"):
        ir.Image.load(tmp_path / "torn.exr")


def _only(folder: Path, letter: str, corners: tuple[float, ...]) -> Path:
    """A picture of one primary."""
    channels = {c: np.full((1, 1), float(c == letter), np.float32) for c in "RGB"}
    OpenEXR.File({"chromaticities": corners}, channels).write(str(folder / "only.exr"))
    return folder / "only.exr"


def test_facts_of_ones_own_are_left_out_of_files(tmp_path):
    held = ir.Image(
        np.ones((2, 2, 3)), metadata={"samples": 9, "mine": "x", "scene": {"name": "泡", "n": np.float64(1.5)}}
    )
    held.save(tmp_path / "x.exr")
    held.save(tmp_path / "x.png")
    with OpenEXR.File(str(tmp_path / "x.exr")) as file:
        assert json.loads(file.header()["scene"]) == {"name": "泡", "n": 1.5}
        assert "mine" not in file.header()
    assert json.loads(PIL.Image.open(tmp_path / "x.png").text["scene"])["name"] == "泡"


# --- files: whole or not at all


@pytest.mark.parametrize("name", ["x.png", "x.exr"])
def test_the_same_render_gives_the_same_file(tmp_path, name):
    """However many threads, and in another process (hash tables are seeded anew there)."""
    code = (
        "import sys, iridesce as ir\n"
        "ir.render('soap-bubble', samples=2, size=(40, 30), threads=int(sys.argv[1])).save(sys.argv[2])\n"
    )
    for threads in ("1", "3"):
        subprocess.run([sys.executable, "-c", code, threads, str(tmp_path / (threads + name))], check=True)
    assert (tmp_path / ("1" + name)).read_bytes() == (tmp_path / ("3" + name)).read_bytes()


def test_a_save_replaces_a_picture_whole(tmp_path, image):
    path = tmp_path / "x.png"
    path.write_bytes(b"old")
    path.chmod(0o640)
    image.save(path)
    assert PIL.Image.open(path).size == (40, 30)
    assert path.stat().st_mode & 0o777 == 0o640
    assert names_in(tmp_path) == ["x.png"]


def test_bad_places_and_names(tmp_path, image, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "file").write_text("precious")
    for save in (image.save, check_output):
        with pytest.raises(FileNotFoundError, match=r"nowhere does not exist: 'nowhere/x\.png'"):
            save("nowhere/x.png")
        with pytest.raises(IsADirectoryError, match=r"it is a folder: 'folder\.png'"):
            save("folder.png")
        with pytest.raises(NotADirectoryError, match=r"file is not a folder: 'file/x\.exr'"):
            save(Path("file/x.exr"))
        for name in ("x.bmp", "x", "", ".png", "png"):
            with pytest.raises(ValueError, match=r"path must end in \.png or \.exr, got"):
                save(name)
        for name in (None, 3, ["x.png"], b"x.png"):
            with pytest.raises(ValueError, match="path must be a file name"):
                save(name)
        with pytest.raises(ValueError, match="zero byte"):
            save("a\0b.png")
    for bits in (7, 32, "8", None, True, 8.5):
        with pytest.raises(ValueError, match="bits must be 8 or 16, got"):
            image.save("x.png", bits=bits)
    assert names_in(tmp_path) == ["file", "folder.png"]
    check_output("x.png")
    check_output(Path("x.exr"))
    assert names_in(tmp_path) == ["file", "folder.png"]
    with pytest.raises(FileNotFoundError) as caught:
        image.save("nowhere/x.exr")
    assert caught.value.filename == "nowhere/x.exr"


# --- render(): arguments


@pytest.mark.parametrize("name", ["samples", "seed", "threads"])
@pytest.mark.parametrize("value", [-1, 1.5, "4", True, 2**64, float("nan"), [4], np.float64(2.0)])
def test_wrong_numbers_are_named(name, value):
    with pytest.raises(ValueError, match=rf"{name} must be a whole number from \d+ to \d+, or None, got"):
        ir.render("soap-bubble", **{name: value})


@pytest.mark.parametrize("size", [(0, 4), (4, -1), (4,), (4, 4, 4), 64, "64x64", "ab", (4.0, 4), (None, 4), [], {}])
def test_wrong_sizes_are_named(size):
    with pytest.raises(ValueError, match=r"size must be \(width, height\), two whole numbers"):
        ir.render("soap-bubble", size=size)


@pytest.mark.parametrize("size", [(2**20, 2**20), (2**32, 1), (2**70, 2**70)])
def test_what_cannot_fit_is_refused_at_once(size):
    with pytest.raises(ir.ResourceError, match=f"{size[0]} x {size[1]}"):
        ir.render("soap-bubble", size=size)


def test_other_back_ends_are_refused():
    with pytest.raises(ValueError, match=r'backend must be "cpu", got \'gpu\' \(this iridesce has no GPU back end'):
        ir.render("soap-bubble", backend="gpu")
    with pytest.raises(ValueError, match=r'backend must be "cpu", got None'):
        ir.render("soap-bubble", backend=None)
    with pytest.raises(ValueError, match="progress must be a function"):
        ir.render("soap-bubble", progress=3)


def test_numpy_integers_are_integers():
    image = ir.render(
        "soap-bubble", samples=np.int16(1), seed=np.uint64(2**64 - 1), size=np.array([5, 4]), threads=np.int8(1)
    )
    assert image.xyz.shape == (4, 5, 3)
    assert image.metadata["seed"] == 2**64 - 1


def test_threads_change_nothing_but_the_time():
    pictures = [ir.render("soap-bubble", threads=threads, **SMALL) for threads in (None, 1, 3)]
    assert [p.metadata["threads"] for p in pictures[1:]] == [1, 3]
    for other in pictures[1:]:
        assert pictures[0].xyz.tobytes() == other.xyz.tobytes()


def test_rayon_num_threads_is_honoured():
    code = "import iridesce as ir; print(ir.render('soap-bubble', samples=1, size=(4, 4)).metadata['threads'])"
    environment = {**os.environ, "RAYON_NUM_THREADS": "3"}
    finished = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert finished.stdout.strip() == "3"


# --- render(): watched and stopped


def test_progress_is_told_in_the_callers_thread():
    calls = []
    ir.render(
        "soap-bubble", samples=8, size=(200, 150), progress=lambda *news: calls.append((threading.get_ident(), news))
    )
    assert {who for who, _ in calls} == {threading.get_ident()}
    news = [n for _, n in calls]
    assert news[-1] == (200 * 150, 200 * 150)
    assert news == sorted(set(news)), "each call has news"
    assert {total for _, total in news} == {200 * 150}


def test_an_exception_of_the_callback_stops_the_render():
    class MineError(Exception):
        pass

    def fail(done, total):
        raise MineError(done)

    # Of a picture that takes minutes; the timeout of the whole test run is the check that it stops.
    with pytest.raises(MineError) as caught:
        ir.render("soap-bubble", samples=4096, size=(512, 512), progress=fail)
    assert caught.value.args[0] < 512 * 512 / 4


def test_a_bar_draws_only_on_a_terminal():
    code = "import iridesce as ir; ir.render('soap-bubble', samples=1, size=(8, 8), progress=True)"
    finished = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert finished.stdout == finished.stderr == ""


def test_a_render_runs_in_any_python_thread():
    results = []

    def work(seed: int) -> None:
        results.append(ir.render("soap-bubble", seed=seed, **SMALL))

    workers = [threading.Thread(target=work, args=(seed,)) for seed in (1, 2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(60.0)
    assert sorted(image.metadata["seed"] for image in results) == [1, 2]


STOPPED = """
import os, signal, threading, time
import numpy as np
import iridesce as ir

large = ir.Image(np.ones((2048, 2048, 3)))
sent = []
def interrupt():
    time.sleep(0.5)
    sent.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)

threading.Thread(target=interrupt, daemon=True).start()
try:
    {work}
except KeyboardInterrupt:
    print(time.perf_counter() - sent[0])
else:
    print("nothing was interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be sent to one process there")
@pytest.mark.parametrize(
    "work",
    [
        "ir.render('soap-bubble', samples=65536)",
        "ir.render('soap-bubble', samples=2**20, size=(2, 2))",
        "ir.render('soap-bubble', samples=65536, threads=1, progress=lambda done, total: None)",
        "while True: large.save('x.exr')",
    ],
    ids=["render", "few pixels of many samples", "one thread, watched", "save"],
)
def test_ctrl_c_stops_within_0_3_s(work, tmp_path):
    finished = subprocess.run(
        [sys.executable, "-c", STOPPED.format(work=work)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        timeout=60,
        check=True,
    )
    assert float(finished.stdout) < 0.3, finished.stdout
    assert set(names_in(tmp_path)) <= {"x.exr"}, "no half-written file"


@pytest.mark.skipif(sys.platform == "win32", reason="no limits on file sizes there")
@pytest.mark.parametrize("name", ["x.png", "x.exr"])
def test_a_disk_that_fills_up_at_the_last_byte(name, image, tmp_path):
    """Writers buffer: an error in the very last piece must be an error all the same."""
    image.save(tmp_path / name)
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(b"precious")
    code = (
        "import resource, signal, sys, iridesce as ir\n"
        f"image = ir.render('soap-bubble', samples={SMALL['samples']}, size={SMALL['size']})\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), -1))\n"
        "try:\n"
        f"    image.save({name!r})\n"
        "except OSError as error:\n"
        "    print(error.errno, error.filename)\n"
    )

    def save_within(limit: int) -> str:
        arguments = [sys.executable, "-c", code, str(limit)]
        return subprocess.run(arguments, cwd=tmp_path, capture_output=True, text=True, check=True).stdout

    for limit in (len(whole) - 1, len(whole) - 20, len(whole) // 2):
        assert save_within(limit) == f"{errno.EFBIG} {name}\n"
        assert (tmp_path / name).read_bytes() == b"precious"
        assert names_in(tmp_path) == [name]
    assert save_within(len(whole)) == ""
    assert (tmp_path / name).read_bytes() == whole


def test_what_is_told_of_a_picture_is_the_callers_and_the_picture_stays(tmp_path: Path) -> None:
    image = ir.render("soap-bubble", samples=1, size=(4, 3))
    image.save(tmp_path / "film.exr")
    given = {"scene": {"camera": {"position": [0.0, 0.0, 16.0]}}, "note": [1, (2, [3]), np.arange(2)]}
    made = ir.Image(np.ones((1, 1, 3)), metadata=given)
    for picture in (image, ir.Image.load(tmp_path / "film.exr"), made):
        before = repr(picture.scene), repr(picture.metadata)
        for scene in (picture.scene, picture.metadata["scene"]):
            assert scene is not None
            scene["camera"]["position"][2] = 99.0
            scene["camera"]["fov_deg"] = 1.0
            scene.clear()
        assert (repr(picture.scene), repr(picture.metadata)) == before
    given["scene"]["camera"]["position"].append(7.0)  # type: ignore[index]
    given["note"][1][1].append(4)  # type: ignore[index]
    given["note"][2][0] = 5  # type: ignore[index]
    made.metadata["note"][2][0] = 6
    assert (repr(made.scene), repr(made.metadata)) == before


def test_a_render_keeps_the_scene_that_it_was_of() -> None:
    tree = ir.Scene.load("soap-bubble").to_dict()
    image = ir.render(tree, samples=1, size=(4, 3))
    before = repr(image.scene)
    tree["camera"]["position"][0] = 50.0
    tree["object"][0]["surface"].clear()
    assert repr(image.scene) == before
