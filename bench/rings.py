"""Measure Newton's rings in pictures: radii of ten dark rings, and the contrast of two sodium lines far out.

    python bench/rings.py

Expected (Born & Wolf, Principles of Optics, 7th ed., sec. 7.5): dark rings at sqrt(m lambda R) in air; two equal lines
of 589.158 and 589.756 nm lose their contrast at order lambda / (2 dlambda) = 493 and have it back at 986.
"""

import numpy as np

import iridesce as ir

RADIUS_MM = 1000.0
SIDE = 512


def radii(wavelength_nm: float = 589.3, height_mm: float = 6.0) -> list[tuple[float, float]]:
    """Expected and measured radii of ten dark rings, pixels: a parabola in r^2 through the quarter order around each."""
    scene = ir.Scene.load("newtons-rings").with_value("light.0.environment.illuminant", f"lines:{wavelength_nm}")
    image = ir.render(scene.with_value("camera.orthographic_height", height_mm), samples=64, size=(SIDE, SIDE))
    luminance = image.xyz[..., 1].astype(float)
    rows, columns = np.mgrid[0:SIDE, 0:SIDE] - (SIDE - 1) / 2
    square = rows**2 + columns**2
    found = []
    for order in range(1, 11):
        expected = np.sqrt(order * wavelength_nm * 1e-6 * RADIUS_MM) / (height_mm / SIDE)
        near = abs(square / expected**2 - 1.0) * order < 0.25
        curve = np.polyfit(square[near], luminance[near], 2)
        found.append((float(expected), float(np.sqrt(-curve[1] / (2.0 * curve[0])))))
    return found


def contrast(order: int, lines: str) -> float:
    """(max - min) / (max + min) over some six rings around an order."""
    radius = np.sqrt(order * 589.457e-6 * RADIUS_MM)
    scene = ir.Scene.load("newtons-rings-sodium").with_value("light.0.environment.illuminant", lines)
    scene = scene.with_value("camera.orthographic_height", 3.0 * 589.457e-6 * RADIUS_MM / radius)
    for key, height in (("position", 100.0), ("target", 0.0)):
        scene = scene.with_value(f"camera.{key}", [radius, height, 0.0])
    luminance = ir.render(scene, samples=16, size=(256, 256)).xyz[118:138, :, 1].mean(axis=0)
    return float((luminance.max() - luminance.min()) / (luminance.max() + luminance.min()))


if __name__ == "__main__":
    print("order  sqrt(m lambda R)  measured  error, pixels")
    for order, (expected, measured) in enumerate(radii(), start=1):
        print(f"{order:5} {expected:17.3f} {measured:9.3f} {measured - expected:9.4f}")
    for lines in ("lines:589.158,589.756", "lines:589.158*2,589.756"):
        values = ", ".join(f"{order}: {contrast(order, lines):.3f}" for order in (10, 100, 246, 493, 740, 986))
        print(f"contrast by order, {lines}: {values}")
