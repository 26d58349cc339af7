"""Draws the chart of an exported film with Mitsuba and the plugin, under D65. Prints X, Y, Z, white = 1, as JSON.

arguments: folder of the export, its table, thinnest and thickest (nm)
A parallel view of a strip whose thickness goes up from left to right in 24 steps, tilted by each of the seven angles.
"""

import json
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_spectral")
folder, table, low, high = sys.argv[1], sys.argv[2], float(sys.argv[3]), float(sys.argv[4])
sys.path.insert(0, folder)
import iridesce_film  # noqa: E402, F401

ANGLES = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0]
STEPS = np.linspace(low, high, 24, dtype=np.float32)
T = mi.ScalarTransform4f


def render(angle: float | None) -> np.ndarray:
    """A row of 24 pixels: of the strip seen at that angle, or of the light alone."""
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 3},
        "light": {"type": "constant", "radiance": {"type": "d65"}},
        "sensor": {
            "type": "orthographic",
            "to_world": T().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]) @ T().scale([1.0, 1.0 / 24.0, 1.0]),
            "film": {"type": "hdrfilm", "width": 24, "height": 1, "pixel_format": "xyz", "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": 1 << 17},
        },
    }
    if angle is not None:
        picture = mi.Bitmap(np.repeat(STEPS[None, :, None], 2, axis=0))
        thickness = {"type": "bitmap", "bitmap": picture, "raw": True, "filter_type": "nearest", "wrap_mode": "clamp"}
        scene["strip"] = {
            "type": "rectangle",
            # Tilted about the x axis and long enough to fill the view at 85 degrees.
            "to_world": T().rotate([1, 0, 0], angle) @ T().scale([1, 40, 1]),
            "film": {"type": "iridesce_film", "table": table, "thickness_nm": thickness},
        }
        # Behind the strip it is dark: what it passes is not counted.
        scene["dark"] = {
            "type": "rectangle",
            "to_world": T().rotate([1, 0, 0], angle) @ T().translate([0, 0, -0.01]) @ T().scale([50, 50, 1]),
            "bsdf": {"type": "diffuse", "reflectance": 0.0},
        }
    return np.array(mi.render(mi.load_dict(scene), seed=1))[0]


white = render(None).mean(axis=0)
d65 = np.array([0.950469, 1.0, 1.088830])
rows = [(render(angle) / white * d65).tolist() for angle in ANGLES]
print(json.dumps({"version": mi.__version__, "xyz": rows}))
