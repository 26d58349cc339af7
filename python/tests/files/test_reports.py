"""Readers that say what they did: lamps, index files, maps; what two readings leave open is asked."""

from __future__ import annotations

import os
import pickle
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from iridesce.files.report import ReadReport, Taken


def test_spectrum_lamp_index_and_map_share_one_report(tmp_path: Path) -> None:
    spectrum = tmp_path / "film.csv"
    spectrum.write_text("nm,Dark,Ref,Sample,Reflectance [%]\n400,1,9,4,4.2\n401,1,9,4,4.3\n")
    lamp = tmp_path / "lamp.csv"
    lamp.write_bytes("\u00b5m;Leistung\n0,7;1\n0,5;3\n0,4;1\n".encode("utf-16"))
    index = tmp_path / "glass.csv"
    index.write_text("nm;e1;e2\n400;2,25;0\n700;2,25;0\n")
    grid = tmp_path / "film.npy"
    np.save(grid, np.full((2, 3), 320.0))
    made = [
        ir.fit.read_spectrum(spectrum).read,
        ir.color.illuminant(lamp).read,
        ir.Medium.from_file(index).read,
        ir.thickness.ThicknessMap.load(grid).read,
    ]
    for report, words in zip(
        made, ("Reflectance [%]", "Leistung", "computed from the permittivity", "the only one"), strict=True
    ):
        assert isinstance(report, ReadReport)
        assert words in str(report), str(report)
        assert set(report.to_dict()) == {"format", "taken", "dropped", "notes"}
        assert pickle.loads(pickle.dumps(report)) == report
    assert made[0].taken[1] == Taken("reflectance", "Reflectance [%]", "percent", "its own name")
    assert made[0].dropped == ('the columns "Dark", "Ref", "Sample"',)
    assert ir.color.illuminant(lamp).power(450.0) == pytest.approx(2.0)
    assert complex(ir.Medium.from_file(index).index(550.0)) == pytest.approx(1.5)
    # What is no file's has none.
    for nothing in (ir.Medium("soap"), ir.color.illuminant("D65"), ir.thickness.ThicknessMap([[1.0]])):
        assert nothing.read is None


def test_lamps_and_media_of_files_are_pickled_in_any_encoding(tmp_path: Path) -> None:
    for encoding in ("utf-8", "utf-16", "cp1252"):
        file = tmp_path / "table.csv"
        file.write_bytes("# Gr\u00f6\u00dfe\nnm,power\n400,1\n700,2\n".encode(encoding))
        lamp = ir.color.illuminant(file)
        again = pickle.loads(pickle.dumps(lamp))
        assert again.power(550.0) == lamp.power(550.0) == 1.5
        file.write_bytes("# Gr\u00f6\u00dfe\nnm,n\n400,1.5\n700,1.6\n".encode(encoding))
        medium = ir.Medium.from_file(file)
        assert pickle.loads(pickle.dumps(medium)).index(550.0) == medium.index(550.0)
        assert medium.note == "Gr\u00f6\u00dfe"


def test_one_enormous_power_leaves_a_white(tmp_path: Path) -> None:
    lamp = tmp_path / "lamp.csv"
    lamp.write_text("400,1\n500,1e308\n600,1\n700,1\n")
    white = ir.color.illuminant(lamp).white()
    assert np.isfinite(white).all()
    assert white[1] == pytest.approx(1.0)


@pytest.mark.parametrize("kind", ["pipe", "endless"])
def test_what_is_no_ordinary_file_is_refused_before_it_is_opened(tmp_path: Path, kind: str) -> None:
    """Each of these waited for ever, or filled the memory."""
    place = tmp_path / "x.csv"
    if kind == "pipe":
        os.mkfifo(place)
    else:
        place.symlink_to("/dev/zero")
    from iridesce.rendering.animation import camera_path

    camera = {"position": [0.0, 0.0, 16.0], "target": [0.0] * 3, "up": [0.0, 1.0, 0.0], "fov_deg": 35.0}
    for read in (
        ir.Medium.from_file,
        ir.color.illuminant,
        ir.fit.read_spectrum,
        ir.thickness.ThicknessMap.load,
        lambda path: camera_path(camera, 1.0, 0.0, path),
    ):
        with pytest.raises(ValueError, match="no ordinary file"):
            read(place)
    table = tmp_path / "x.exr"
    place.rename(table)
    with pytest.raises(ValueError, match="no ordinary file"):
        ir.ColorTable.load(table)


def test_channel_and_page_of_a_map(tmp_path: Path) -> None:
    import tifffile

    path = tmp_path / "stack.tif"
    with tifffile.TiffWriter(path) as writer:
        for page in range(3):
            writer.write(np.full((2, 2), 100.0 * (page + 1), dtype=np.float32))
    with pytest.raises(ValueError, match=r"it holds 3 pages; say which: page = 1 to 3"):
        ir.thickness.ThicknessMap.load(path)
    second = ir.thickness.ThicknessMap.load(path, page=2)
    assert second.thickness_nm[0, 0] == 200.0
    assert second.read is not None
    assert "2 other pages" in str(second.read)
    for wrong, words in ((4, "page must be 1 to 3, got 4"), (0, "whole number >= 1"), (1.5, "whole number >= 1")):
        with pytest.raises(ValueError, match=words):
            ir.thickness.ThicknessMap.load(path, page=wrong)  # type: ignore[arg-type]
    picture = tmp_path / "picture.exr"
    ir.Image(np.ones((2, 2, 3)), thickness_nm=np.full((2, 2), 320.0), depth=np.ones((2, 2))).save(picture)
    assert ir.thickness.ThicknessMap.load(picture).thickness_nm[0, 0] == 320.0
    assert ir.thickness.ThicknessMap.load(picture, channel="depth.Z").thickness_nm[0, 0] == 1.0
    with pytest.raises(ValueError, match=r'it has no channel "film"; there are'):
        ir.thickness.ThicknessMap.load(picture, channel="film")


def test_imagej_calibration_and_orientation_written_by_others(tmp_path: Path) -> None:
    import tifffile

    path = tmp_path / "map.tif"
    values = np.arange(6, dtype=np.uint16).reshape(2, 3)
    metadata = {"axes": "YX", "c0": 10.0, "c1": 0.5, "cf": 0, "vunit": "nm"}
    tifffile.imwrite(path, values, imagej=True, metadata=metadata)
    np.testing.assert_allclose(ir.thickness.ThicknessMap.load(path).thickness_nm, 10.0 + 0.5 * values)
    tifffile.imwrite(path, values, extratags=[(274, 3, 1, 4, True)])
    np.testing.assert_allclose(
        ir.thickness.ThicknessMap.load(path, min_nm=0.0, max_nm=65535.0).thickness_nm, values[::-1], atol=1e-9
    )


def test_declared_sizes_take_no_memory(tmp_path: Path) -> None:
    from iridesce import _core

    file = tmp_path / "sky.hdr"
    file.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8192 +X 16384\n")
    with pytest.raises(ValueError, match=r"need 98304 bytes at least, 0 follow the header"):
        _core.read_environment(file, None)
    # 7 TiB in 80 bytes, to each reader of NumPy's arrays; and what else bears their ending.
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000, 1000000), }\n"
    npy = tmp_path / "film.npy"
    for content, words in (
        (b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header, r"1000000"),
        (b"PK\x03\x04" + bytes(40), "NPY"),
        (b"", "NPY|empty"),
    ):
        npy.write_bytes(content)
        for read in (
            lambda: ir.validate(npy, "C1"),
            lambda: ir.map_thickness(npy, "air / soap ? / air", camera="srgb", illuminant="D65"),
            lambda: ir.thickness.ThicknessMap.load(npy),
        ):
            with pytest.raises(ValueError, match=words) as caught:
                read()
            assert "film.npy" in str(caught.value)


def test_words_of_files_reach_no_terminal_raw(tmp_path: Path) -> None:
    from iridesce import _core

    hdr = tmp_path / "sky.hdr"
    hdr.write_bytes(b"#?RADIANCE\nFORMAT=\x1b[31mred\x07\n\n-Y 1 +X 2\n" + bytes(8))
    npy = tmp_path / "map.npy"
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (\x1b[2J, 3), }\n"
    npy.write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    csv = tmp_path / "film.csv"
    csv.write_text("nm,\x1b]0;title\x07 refl,b refl\n400,1,2\n401,1,2\n")
    for read in (
        lambda: _core.read_environment(hdr, None),
        lambda: ir.thickness.ThicknessMap.load(npy),
        lambda: ir.fit.read_spectrum(csv),
    ):
        with pytest.raises(ValueError, match=r".") as caught:
            read()
        assert str(caught.value).isprintable(), repr(str(caught.value))
        assert len(str(caught.value)) < 600
