"""Cameras: the built-in ones are the measured ones, files of two formats are read, anything else is refused in words."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

import colour
import numpy as np
import pytest

import iridesce as ir
from iridesce.color.camera_tables import typical_cameras

DATA = Path(ir.color.__file__).parent / "camera_data"
ORIGIN = {"nikon-d5100": "Nikon 5100 (NPL)", "sigma-sd-merrill": "Sigma SDMerill (NPL)"}


def test_built_in_cameras_are_those_of_their_source() -> None:
    assert ir.color.cameras() == sorted(ORIGIN)
    for name, origin in ORIGIN.items():
        made, wanted = ir.color.camera(name), colour.MSDS_CAMERA_SENSITIVITIES[origin]
        assert made.wavelength_nm[[0, -1]].tolist() == [380.0, 780.0]
        assert made.sensitivity.shape == (81, 3)
        np.testing.assert_allclose(made.at(wanted.wavelengths), wanted.values, rtol=1e-15, atol=1e-16)


def test_every_table_is_the_one_its_source_names() -> None:
    text = (DATA / "SOURCES.md").read_text()
    named = dict(re.findall(r"`([\w-]+\.csv)`.*`([0-9a-f]{64})`", text))
    assert set(named) == {path.name for path in DATA.glob("*.csv")}
    for name, digest in named.items():
        assert hashlib.sha256((DATA / name).read_bytes()).hexdigest() == digest, name


def test_typical_cameras_see_red_green_and_blue() -> None:
    for one in typical_cameras():
        red, green, blue = one.wavelength_nm[one.sensitivity.argmax(axis=0)]
        assert blue < green < red
        assert (one.sensitivity >= 0.0).all()


def test_csv_and_json_hold_the_same_camera(tmp_path: Path) -> None:
    nikon = ir.color.camera("nikon-d5100")
    rows = np.column_stack([nikon.wavelength_nm, nikon.sensitivity])
    csv, tree = tmp_path / "own.csv", tmp_path / "own.json"
    csv.write_text("# mine\nnm,r,g,b\n" + "".join(",".join(map(repr, map(float, row))) + "\n" for row in rows[::-1]))
    main = {f"{row[0]:g}": row[1:].tolist() for row in rows}
    header = {"manufacturer": "Nikon", "model": "D5100"}
    tree.write_text(json.dumps({"header": header, "spectral_data": {"units": "relative", "data": {"main": main}}}))
    for path in (csv, str(tree)):
        read = ir.color.camera(path)
        np.testing.assert_array_equal(read.wavelength_nm, nikon.wavelength_nm)
        np.testing.assert_array_equal(read.sensitivity, nikon.sensitivity)
    assert ir.color.camera(tree).name == "Nikon D5100"
    assert ir.color.camera(nikon) is nikon


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", "nm,r,g,b\n400,1,2\n", "wanted four numbers nm,r,g,b"),
        ("a.csv", "nm,r,g,b\n400,1,2,3\nred,1,2,3\n", "a.csv:3: wanted four numbers"),
        ("a.csv", "nm,r,g,b\n400,1,2,3\n", "holds 1 rows of nm,r,g,b; at least 8"),
        ("a.csv", "".join(f"{nm},1,nan,0\n" for nm in range(400, 700, 10)), "must be finite"),
        ("a.csv", "".join(f"{nm},1,1,0\n" for nm in range(400, 700, 10)), "a channel sees nothing"),
        ("a.csv", "".join(f"{nm},1,1,1\n" for nm in [400] * 9), "wavelengths must be different"),
        ("a.json", "{}", "is not the JSON of camera sensitivities"),
        ("a.json", "{" * 5000, "is not the JSON of camera sensitivities"),
    ],
)
def test_what_is_no_camera_is_refused(tmp_path: Path, name: str, text: str, words: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ValueError, match=re.escape(words)):
        ir.color.camera(path)


def test_an_unknown_name_lists_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="one of nikon-d5100, sigma-sd-merrill, or a file"):
        ir.color.camera("box")
    with pytest.raises(ValueError, match="no such file"):
        ir.color.camera(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="must be a name or a path"):
        ir.color.camera(3)  # type: ignore[arg-type]
