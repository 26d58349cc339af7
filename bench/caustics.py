"""A small lamp through a glass ball onto a floor: the picture against a light-traced reference, and its noise.

    python bench/caustics.py [--radius 0.001] [--samples 4096] [--seeds 8]

The reference follows rays from the lamp through the ball (both polarisations by Fresnel, inner mirrors included) and
counts what reaches the part of the floor that the picture shows; the renderer finds the same light only where a branch
from the floor happens to meet the lamp.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import iridesce as ir

INDEX, BALL_Y, BALL_RADIUS, LAMP_Y = 1.5, 1.2, 0.5, 4.0
SIDES = (0.06 * np.sqrt(10.0) / 2.0, 0.09)  # of the floor in the picture, half, along x and z
REFLECTANCE = 0.5


def fresnel(cos, index):
    """Power reflectances of s and p light that comes from a medium of relative index 1 into ``index``, and the cosine beyond."""
    inner2 = 1.0 - (1.0 - cos**2) / index**2
    inner = np.sqrt(np.maximum(inner2, 0.0))
    s = ((cos - index * inner) / (cos + index * inner)) ** 2
    p = ((index * cos - inner) / (index * cos + inner)) ** 2
    return np.where(inner2 > 0, s, 1.0), np.where(inner2 > 0, p, 1.0), inner


def reference(radiance, lamp_radius, rings=40_000):
    """Mean irradiance of the floor in the picture, by angle from the axis: lamp and ball are round."""
    half = np.arcsin(BALL_RADIUS / (LAMP_Y - BALL_Y))
    low = 1.0 - np.cos(half)
    less = low * (np.arange(rings) + 0.5) / rings
    angle = np.arccos(1.0 - less)
    intensity = radiance * np.pi * lamp_radius**2
    power = np.full((2, rings), 0.5 * intensity * 2.0 * np.pi * low / rings)
    position = np.stack([np.zeros(rings), np.full(rings, LAMP_Y - BALL_Y)])
    direction = np.stack([np.sin(angle), -np.cos(angle)])

    def onto_ball(position, direction, inside):
        along = (position * direction).sum(0)
        reach = np.sqrt(np.maximum(along**2 - (position**2).sum(0) + BALL_RADIUS**2, 0.0))
        return position + direction * (-2.0 * along if inside else -along - reach)

    position = onto_ball(position, direction, False)
    total = 0.0
    azimuth = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
    cos = -(direction * position).sum(0) / BALL_RADIUS
    r_s, r_p, inner = fresnel(cos, INDEX)
    power = power * np.stack([1.0 - r_s, 1.0 - r_p])
    normal = position / BALL_RADIUS
    direction = direction / INDEX + normal * (cos / INDEX - inner)
    for _ in range(6):
        position = onto_ball(position, direction, True)
        normal = position / BALL_RADIUS
        cos = (direction * normal).sum(0)
        r_s, r_p, outer = fresnel(cos, 1.0 / INDEX)
        passed = power * np.stack([1.0 - r_s, 1.0 - r_p])
        out = direction * INDEX + normal * (outer - cos * INDEX)
        place = position[0] - out[0] * (position[1] + BALL_Y) / np.minimum(out[1], -1e-9)
        near = (out[1] < 0) & (np.abs(place) < np.hypot(*SIDES))
        across, along = np.abs(place[near, None] * np.cos(azimuth)), np.abs(place[near, None] * np.sin(azimuth))
        share = ((across < SIDES[0]) & (along < SIDES[1])).mean(axis=1)
        total += (passed[:, near] * share).sum()
        power = power - passed
        direction = direction - 2.0 * cos * normal
    return total / (4.0 * SIDES[0] * SIDES[1])


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--radius", type=float, default=0.001)
    parser.add_argument("--samples", type=int, default=4096)
    parser.add_argument("--seeds", type=int, default=8)
    asked = parser.parse_args()
    radiance = 1.0 / (np.pi * asked.radius**2)
    scene = ir.Scene.load(
        {
            "version": 1,
            "camera": {
                "position": [3.0, 1.0, 0.0],
                "target": [0, 0, 0],
                "orthographic_height": 0.06,
                "resolution": [24, 8],
            },
            "render": {"samples": asked.samples},
            "object": [
                {"name": "floor", "shape": {"plane": {}}, "surface": {"diffuse": {"reflectance": REFLECTANCE}}},
                {
                    "name": "ball",
                    "shape": {"sphere": {"center": [0, BALL_Y, 0], "radius": BALL_RADIUS}},
                    "surface": {"dielectric": {"medium": INDEX}},
                },
                {
                    "name": "lamp",
                    "shape": {"sphere": {"center": [0, LAMP_Y, 0], "radius": asked.radius}},
                    "surface": {"emitter": {"radiance": radiance}},
                },
            ],
            "light": [{"environment": {"illuminant": "D65", "radiance": 0.0}}],
        }
    )
    wanted = REFLECTANCE * reference(radiance, asked.radius) / np.pi
    start = time.perf_counter()
    means = np.array([ir.render(scene, seed=seed).xyz[..., 1].mean(dtype=np.float64) for seed in range(asked.seeds)])
    seconds = time.perf_counter() - start
    print(f"light-traced mean: Y = {wanted:.5f}")
    print(
        f"rendered: {means.mean():.5f} +- {means.std(ddof=1) / np.sqrt(len(means)):.5f} of {asked.seeds} seeds, {seconds:.1f} s"
    )
    print(f"relative MSE of one picture's mean: {((means / wanted - 1.0) ** 2).mean():.3g}")


if __name__ == "__main__":
    main()
