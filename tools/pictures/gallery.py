"""Draw the pictures of docs/guide/gallery.md: every built-in scene at its own settings, timed, and a small copy of it.

python tools/pictures/gallery.py               # all of them
python tools/pictures/gallery.py wafer         # those whose name begins so
python tools/pictures/gallery.py --time        # only the times, best of three
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import iridesce as ir
from iridesce.scene import scene_names

IMAGES = Path(__file__).resolve().parents[2] / "docs" / "images"
WIDTH = 400  # pixels of the small copy; four times the samples keep its edges as clean


def main() -> int:
    wanted = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    warnings.simplefilter("ignore")  # media continued past their data say so on the page
    for name in scene_names():
        if wanted and not any(name.startswith(prefix) for prefix in wanted):
            continue
        scene = ir.Scene.load(name)
        runs = [ir.render(scene) for _ in range(3 if "--time" in sys.argv else 1)]
        best = min(image.metadata["seconds"] for image in runs)
        print(f"{name:24} {runs[0].width} x {runs[0].height}, {runs[0].metadata['samples']} samples: {best:.1f} s")
        if "--time" in sys.argv:
            continue
        height = round(WIDTH * runs[0].height / runs[0].width)
        small = ir.render(scene, size=(WIDTH, height), samples=4 * runs[0].metadata["samples"])
        small.save(IMAGES / f"gallery-{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
