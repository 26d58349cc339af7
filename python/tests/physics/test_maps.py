"""Maps on a sheet that faces the camera: what a pixel shows is what the map says there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import iridesce as ir
from physics.scenes import build

#: Grey levels of the quarters of a picture: upper left and right, lower left and right.
QUARTERS = np.array([[255, 188], [120, 40]], dtype=np.uint8)
CAMERA = {"position": [0.0, 0.0, 9.0], "target": [0.0, 0.0, 0.0], "orthographic_height": 8.0, "resolution": [8, 8]}


def sheet(surface: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"name": "sheet", "shape": {"rectangle": {}}, "surface": surface, **more}


def seen(thing: dict[str, Any], light: dict[str, Any], samples: int = 4) -> Any:
    """Y of every pixel, the top row first."""
    return np.asarray(ir.render(build([thing], CAMERA, [light]), samples=samples).xyz[..., 1], dtype=np.float64)


def from_direction(*direction: float) -> dict[str, Any]:
    """A light under which a white matt surface that faces it shows Y = 1."""
    return {"directional": {"direction": list(direction), "irradiance": np.pi}}


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene from a dict may name the files of the folder that the program is in."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def quarters(here: None) -> str:
    Image.fromarray(np.kron(QUARTERS, np.ones((32, 32), np.uint8))).save("quarters.png")
    return "quarters.png"


def test_a_reflectance_map_lies_upright_and_is_decoded(quarters: str) -> None:
    level = QUARTERS / 255.0
    wanted = np.where(level <= 0.04045, level / 12.92, ((level + 0.055) / 1.055) ** 2.4)
    y = seen(sheet({"diffuse": {"reflectance": {"map": quarters}}}), from_direction(0.0, 0.0, 1.0))
    assert np.allclose(y[1:8:5, 1:8:5], wanted, rtol=1e-4)
    # Twice as often along u, and moved by half of itself along v.
    uv = {"scale": [2.0, 1.0], "offset": [0.0, 0.5]}
    y = seen(sheet({"diffuse": {"reflectance": {"map": quarters}}}, uv=uv), from_direction(0.0, 0.0, 1.0), 256)
    columns = y[1:8:5].reshape(2, 4, 2).mean(axis=2)
    # Between the middles of texels the map is linear: at both of its seams a column of 32 texels has 1/8 of one from beside it.
    left, right = wanted[::-1, :1], wanted[::-1, 1:]
    assert np.allclose(columns[:, [0, 2]], left + (right - left) / 128, rtol=3e-3)
    assert np.allclose(columns[:, [1, 3]], right + (left - right) / 128, rtol=3e-3)


def test_a_roughness_map_is_that_roughness_where_it_lies(quarters: str) -> None:
    lamp = {"environment": {"builtin": "studio"}}

    def metal(roughness: Any) -> Any:
        return seen(sheet({"metal": {"medium": "Al", "roughness": roughness}}), lamp, 256)

    mapped = metal({"map": quarters, "min": 0.1, "max": 0.7})
    for (row, column), level in np.ndenumerate(QUARTERS):
        even = metal(0.1 + 0.6 * level / 255.0)
        place = (slice(4 * row + 1, 4 * row + 3), slice(4 * column + 1, 4 * column + 3))
        assert np.allclose(mapped[place], even[place], rtol=0.02), (row, column)
        other = metal(0.1 + 0.6 * float(QUARTERS[1 - row, 1 - column]) / 255.0)
        assert not np.allclose(mapped[place], other[place], rtol=0.02), "another roughness looks another way"


def test_a_bump_map_turns_normals_by_its_slope() -> None:
    """Heights that rise evenly by 4 over the 8 units of the sheet, along u or along v."""
    ramp = np.tile((np.arange(64) + 0.5) / 64, (64, 1)).astype(np.float32)
    # (Rows of a map run downwards, v upwards.)
    for heights, tilt in ((ramp, (-0.5, 0.0, 1.0)), (ramp.T[::-1], (0.0, -0.5, 1.0))):
        np.save("ramp.npy", np.ascontiguousarray(heights))
        bump = {"map": "ramp.npy", "height": 4.0}
        normal = np.array(tilt) / np.linalg.norm(tilt)
        for light in ((0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (-1.0, 0.5, 1.0), (0.0, -1.0, 1.0)):
            y = seen(sheet({"diffuse": {"reflectance": 1.0}}, bump=bump), from_direction(*light))
            wanted = max(float(normal @ light) / np.linalg.norm(light), 0.0)
            assert np.allclose(y[2:6, 2:6], wanted, rtol=1e-3), (tilt, light)


# ---- what bumps lose ---------------------------------------------------------------------------------------------------

REFERENCE = Path(__file__).resolve().parents[3] / "docs" / "reference" / "scenes.md"
BUMPED: dict[str, dict[str, Any]] = {
    "film": {"film": {"medium": 1.33, "thickness_nm": 430.0}},
    "metal": {"metal": {"medium": [2e-6, 1.0]}},
    "dielectric": {"dielectric": {"medium": 1.5}},
    "film, roughness 0.3": {"film": {"medium": 1.33, "thickness_nm": 430.0, "roughness": 0.3}},
    "metal, roughness 0.3": {"metal": {"medium": [2e-6, 1.0], "roughness": 0.3}},
    "dielectric, roughness 0.3": {"dielectric": {"medium": 1.5, "roughness": 0.3}},
    "diffuse": {"diffuse": {"reflectance": 1.0}},
}


def lost_to_bumps(surface: dict[str, Any], slope: float) -> float:
    """Per cent of a white furnace's light that is missing over the disc of a ball whose heights are waves along u and v.

    Four of them a map, sixteen around the equator of a ball of radius 1 and eight from pole to pole: at the equator the root of
    the mean square of the slope is 4 heights.
    """
    wave = np.sin(2 * np.pi * 4 * (np.arange(256) + 0.5) / 256)
    np.save("waves.npy", (0.5 + 0.25 * (wave[None, :] + wave[:, None])).astype(np.float32))
    ball = {
        "shape": {"sphere": {"radius": 1.0}},
        "surface": surface,
        "uv": {"scale": [4.0, 2.0]},
        "bump": {"map": "waves.npy", "height": slope / 4.0},
    }
    camera = {"position": [0.0, 0.0, 6.0], "orthographic_height": 1.96, "resolution": [48, 48]}
    image = ir.render(build([ball], camera, [{"environment": {"illuminant": "D65"}}]), samples=32)
    return 100.0 * (1.0 - float(image.xyz[..., 1][image.channels["object"] == 0].mean(dtype=np.float64)))


def test_bumps_lose_what_the_reference_says() -> None:
    """White surfaces in a white furnace, as the table there has them: within a twentieth, or 0.1 % (rounding and noise)."""
    text = REFERENCE.read_text(encoding="utf-8").split("| white surface | 0.1 |")[1].split("\n\n")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()[2:]]
    names = {row[0] for row in rows}
    assert names == set(BUMPED)
    for name, *cells in rows:
        for slope, cell in zip((0.1, 0.2, 0.5, 1.0), cells, strict=True):
            stated = float(cell.removesuffix(" %"))
            assert lost_to_bumps(BUMPED[name], slope) == pytest.approx(stated, rel=0.05, abs=0.1), (name, slope)
