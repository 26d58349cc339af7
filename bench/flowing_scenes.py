"""What scenes with flowing films cost, in processor time of one thread.

usage: flowing_scenes.py

check      `Scene.load` of a film that is to flow for 600 s: nothing flows
nine       nine films flow and are drawn; then the camera is changed and they are drawn again, beside nine films that do not flow
animation  five films, frames 0.04 s apart: each goes on from where it stood, so that a frame costs the same all along
"""

from __future__ import annotations

import os

os.environ.setdefault("RAYON_NUM_THREADS", "1")

import statistics
import time
from collections.abc import Callable
from typing import Any

import iridesce as ir

PRESET = "free-bubble-small-preview"


def scene(thicknesses: list[Any]) -> ir.Scene:
    """Rectangles side by side, one for each thickness."""
    objects = [
        {
            "name": f"f{i}",
            "shape": {
                "rectangle": {"center": [2.2 * (i - len(thicknesses) / 2), 0, 0], "u": [1, 0, 0], "v": [0, 1, 0]}
            },
            "surface": {"film": {"medium": "water", "thickness_nm": thickness}},
        }
        for i, thickness in enumerate(thicknesses)
    ]
    camera = {"position": [0, 0, 30], "target": [0, 0, 0], "up": [0, 1, 0], "fov_deg": 40, "resolution": [48, 32]}
    light = [{"environment": {"builtin": "sky"}}]
    whole = {"version": 1, "unit": "cm", "camera": camera, "render": {"samples": 1}, "object": objects, "light": light}
    return ir.Scene.load(whole)


def flowing(count: int, time_s: float) -> list[Any]:
    return [{"flow": {"preset": PRESET, "time_s": time_s, "seed": i}} for i in range(count)]


def ms(work: Callable[[], object]) -> float:
    begun = time.process_time()
    work()
    return 1e3 * (time.process_time() - begun)


def main() -> None:
    print(f"load {os.getloadavg()[0]:.1f}")
    checks = [ms(lambda: scene(flowing(1, 600.0))) for _ in range(20)]
    print(f"check of a film of 600 s: {statistics.median(checks):.2f} ms")

    nine = scene(flowing(9, 1.0))
    print(f"nine films flow for 1 s and are drawn: {ms(lambda: ir.render(nine)):.0f} ms")
    changed = nine.with_value("camera.fov_deg", 41.0)
    print(f"the camera changed, drawn again: {ms(lambda: ir.render(changed)):.1f} ms")
    still = scene([300.0] * 9)
    ir.render(still)
    print(f"nine films that do not flow: {ms(lambda: ir.render(still)):.1f} ms")

    five = scene(flowing(5, 1.0))
    ir.render(five)
    frames = []
    for frame in range(24):
        for film in range(5):
            five = five.with_value(f"object.f{film}.surface.film.thickness_nm.flow.time_s", 1.0 + 0.04 * (frame + 1))
        now = five
        frames.append(ms(lambda now=now: ir.render(now)))
    first, last = statistics.median(frames[:12]), statistics.median(frames[12:])
    print(f"five films, frames 0.04 s apart: {first:.0f} ms a frame of the first twelve, {last:.0f} of the next")


if __name__ == "__main__":
    main()
