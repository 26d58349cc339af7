"""Draws an exported scene with Mitsuba and the plugin: `mitsuba_scene.py FOLDER SAMPLES OUT.npy`. X, Y, Z, rows from the top."""

import json
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_spectral")
folder, samples, out = Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
if (folder / "iridesce_film.py").exists():
    sys.path.insert(0, str(folder))
    import iridesce_film  # noqa: F401
scene = mi.load_file(str(folder / "scene.xml"))
# In parts: each holds one wavefront in memory.
parts = [np.array(mi.render(scene, spp=16, seed=seed)) for seed in range(max(1, samples // 16))]
np.save(out, np.mean(parts, axis=0))
print(json.dumps({"version": mi.__version__}))
