"""Draw the pictures of docs/guide/gallery.md: every built-in scene at its own settings, timed, and a small copy of it.

python tools/pictures/gallery.py               # all of them
python tools/pictures/gallery.py wafer         # those whose name begins so
python tools/pictures/gallery.py --time        # only the times, best of three: of a clock, and of all processors together
python tools/pictures/gallery.py --time=1      # the same of one run
"""

from __future__ import annotations

import sys
import time
import warnings
from pathlib import Path

import iridesce as ir
from iridesce.scene import scene_names

IMAGES = Path(__file__).resolve().parents[2] / "docs" / "images"
WIDTH = 400  # pixels of the small copy; four times the samples keep its edges as clean


def main() -> int:
    wanted = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    timed = next((argument for argument in sys.argv if argument.startswith("--time")), None)
    repeats = int((timed or "--time=1").partition("=")[2] or 3)
    warnings.simplefilter("ignore")  # media continued past their data say so on the page
    for name in scene_names():
        if wanted and not any(name.startswith(prefix) for prefix in wanted):
            continue
        scene = ir.Scene.load(name)
        runs = [drawn(scene) for _ in range(repeats)]
        image = runs[0][0]
        best, busy = min(image.metadata["seconds"] for image, _ in runs), min(busy for _, busy in runs)
        size = f"{image.width} x {image.height}, {image.metadata['samples']} samples"
        print(f"{name:24} {size}: {best:.1f} s, {busy:.1f} processor seconds", flush=True)
        if timed:
            continue
        height = round(WIDTH * image.height / image.width)
        small = ir.render(scene, size=(WIDTH, height), samples=4 * image.metadata["samples"])
        small.save(IMAGES / f"gallery-{name}.png")
    return 0


def drawn(scene: ir.Scene) -> tuple[ir.Image, float]:
    """A picture, and the processor seconds of all threads that it took."""
    before = time.process_time()
    return ir.render(scene), time.process_time() - before


if __name__ == "__main__":
    sys.exit(main())
