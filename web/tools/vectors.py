"""Makes web/tests/vectors.json and rings.json: what the native core answers, for the tests of the page (`make test-web`).

Reflectances carry their conditioning: how much they change where wavelength and angle move by one unit in the last place,
which is what rounding alone may do.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import iridesce as ir

OUT = Path(__file__).resolve().parents[1] / "tests" / "vectors.json"
RINGS = OUT.with_name("rings.json")
SOLIDS = ["soap", "water", "SiO2", "TiO2", "MgF2", "N-BK7", "Si", "Ti", "Al", "Ag", "Au", "1.47", "2.2+0.05j", "1.8"]
FIRST = ["air", "1.33", "N-BK7"]


def stack(rng: np.random.Generator, thickest_nm: float) -> str:
    """A random stack of one to four layers, as text."""
    layers = [
        f"{rng.choice(SOLIDS)} {float(rng.uniform(0.0, thickest_nm)):.3f}"
        + (" incoherent" if rng.random() < 0.05 else "")
        for _ in range(rng.integers(1, 5))
    ]
    return " / ".join([str(rng.choice(FIRST)), *layers, str(rng.choice(["air", *SOLIDS]))])


def powers(rng: np.random.Generator) -> list[list[object]]:
    """2 000 of: stack, wavelength, angle, polarization, reflectance, conditioning."""
    found: list[list[object]] = []
    while len(found) < 2000:
        # Half are films as colours know them, half are thick: 300 um have thousands of fringes.
        text = stack(rng, 3000.0 if len(found) % 2 == 0 else 3e5)
        wavelength_nm, angle_deg = float(rng.uniform(400.0, 780.0)), float(rng.uniform(0.0, 89.9))
        polarization = str(rng.choice(["s", "p", "unpolarized"]))
        made = ir.Stack.parse(text)
        nm = np.array([wavelength_nm, *np.nextafter(wavelength_nm, [0.0, 1e9]), wavelength_nm, wavelength_nm])
        deg = np.array([angle_deg, angle_deg, angle_deg, *np.nextafter(angle_deg, [0.0, 90.0])])
        values = made.reflectance(nm, deg, polarization)
        conditioning = float(np.abs(values - values[0]).max())
        found.append([text, wavelength_nm, angle_deg, polarization, float(values[0]), conditioning])
    return found


def colors(rng: np.random.Generator) -> list[list[object]]:
    """200 of: stack, layer, thickness, angle, illuminant, model, X, Y, Z."""
    found: list[list[object]] = []
    for text, model in [
        ("air / soap ? / air", "exact"),
        ("air / soap ? / air", "two-beam"),
        ("air / TiO2 ? / Ti", "exact"),
        ("air / 1.47 ? / water", "exact"),
        ("N-BK7 / air ? / N-BK7", "exact"),
    ]:
        for illuminant in ["D65", "A", "FL2", "lines:589.158*2,589.756"]:
            for _ in range(10):
                thickness_nm, angle_deg = float(rng.uniform(0.0, 1500.0)), float(rng.uniform(0.0, 40.0))
                filled = ir.Stack.parse(text.replace("?", repr(thickness_nm)))
                xyz = filled.color(angle_deg, illuminant=illuminant, model=model)
                found.append([text, 0, thickness_nm, angle_deg, illuminant, model, *xyz.tolist()])
    return found


def flows() -> list[list[object]]:
    """Of: preset, seed, time, mean thickness, its standard deviation, thickness of the first and the last cell."""
    found: list[list[object]] = []
    for preset in ["late", "free-bubble"]:
        *_, (time_s, nm) = ir.thickness.simulate(preset, time_s=0.3, frames_per_second=10, seed=3)
        found.append([preset, 3, float(time_s), 10, *map(float, [nm.mean(), nm.std(), nm[0, 0], nm[-1, -1]])])
    return found


def rings() -> list[list[float]]:
    """X, Y, Z along a diameter of the scene `newtons-rings`, 4.8 mm in 256 pixels: its camera, a row one pixel high."""
    changes = {"camera.orthographic_height": 4.8 / 256, "camera.resolution": [256, 1], "render.samples": 256}
    scene = ir.Scene.load("newtons-rings")
    for key, value in changes.items():
        scene = scene.with_value(key, value)
    return [[round(float(v), 6) for v in xyz] for xyz in ir.render(scene).xyz[0]]


if __name__ == "__main__":
    RINGS.write_text("[\n" + ",\n".join(map(json.dumps, rings())) + "\n]\n")
    rng = np.random.default_rng(20261128)
    OUT.parent.mkdir(parents=True, exist_ok=True)
    vectors = {"powers": powers(rng), "colors": colors(rng), "flows": flows()}
    parts = [f'"{name}": [\n' + ",\n".join(map(json.dumps, rows)) + "\n]" for name, rows in vectors.items()]
    OUT.write_text("{\n" + ",\n".join(parts) + "\n}\n")
    print(f"{OUT}: {', '.join(f'{len(rows)} {name}' for name, rows in vectors.items())}")
