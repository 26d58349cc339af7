"""How long `iridesce render soap-bubble` takes at 1920 x 1080, and how far its PNG is from one of 4 096 samples.

    python bench/full_hd.py [--samples 2 3 4] [--reference 4096] [--repeats 3]

Whole processes of the command, the median of three. The reference is made of 96 parts of 16 x 16 pixels that lie evenly over the
picture, backdrop included, under the exposure of the picture and rounded to bytes as a PNG has them; shown are the 95th
percentile and the median of CIEDE2000 over all their pixels, and the 95th percentile of those on the bubble.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image as Pictures

import iridesce as ir

SIZE = (1920, 1080)
# Sides of a part, and how many there are across and down.
PART = 16
PARTS = (12, 8)
CORNERS = [
    tuple(int((i + 0.5) * size / count) - PART // 2 for i, size, count in zip(place, SIZE, PARTS, strict=True))
    for place in np.ndindex(PARTS)
]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, nargs="*", default=[2, 3, 4])
    parser.add_argument("--reference", type=int, default=4096)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    parts = [ir.render("soap-bubble", options.reference, 2, SIZE, crop=(*corner, PART, PART)) for corner in CORNERS]
    for samples in options.samples:
        stops = ir.render("soap-bubble", samples, 1, SIZE).exposure_stops()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "picture.png")
            seconds = []
            for _ in range(options.repeats):
                began = time.perf_counter()
                size = "x".join(map(str, SIZE))
                command = [
                    "render",
                    "soap-bubble",
                    "--size",
                    size,
                    "--samples",
                    str(samples),
                    "--seed",
                    "1",
                    "-o",
                    str(path),
                ]
                subprocess.run([sys.executable, "-m", "iridesce", *command], check=True, capture_output=True)
                seconds.append(time.perf_counter() - began)
            with Pictures.open(path) as opened:
                picture = np.asarray(opened.convert("RGB"), dtype=float) / 255.0
        errors = [
            ir.color.delta_e(
                ir.color.convert(picture[y : y + PART, x : x + PART], "srgb", "lab"),
                ir.color.convert(np.round(255.0 * part.rgb(exposure=stops)) / 255.0, "srgb", "lab"),
            )
            for (x, y), part in zip(CORNERS, parts, strict=True)
        ]
        bubble = np.concatenate(
            [error[np.isfinite(part.channels["thickness_nm"])] for error, part in zip(errors, parts, strict=True)]
        )
        print(
            f"{samples} samples: {statistics.median(seconds):.2f} s ({min(seconds):.2f} to {max(seconds):.2f}), "
            f"CIEDE2000 {np.percentile(errors, 95):.2f} (95 %), {np.median(errors):.2f} (median), "
            f"on the bubble {np.percentile(bubble, 95):.2f} (95 %)",
            flush=True,
        )


if __name__ == "__main__":
    main()
