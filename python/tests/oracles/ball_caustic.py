"""Light of a small lamp that a glass ball throws onto a floor, by rays from the lamp: lamp, ball and floor are round together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BallCaustic:
    """A ball of ``index`` with its centre ``height`` above a floor, a lamp ``lamp_height`` above it on the same axis."""

    index: float = 1.5
    height: float = 1.2
    radius: float = 0.5
    lamp_height: float = 4.0

    def irradiance(self, edges: Array, intensity: float = 1.0, rays: int = 100_000) -> Array:
        """Mean irradiance of the floor between circles of these radii, all ways through and off the ball included.

        Rays are as many as there is solid angle; at each face they part by Fresnel's powers of s and p light, whose planes of
        incidence all hold the axis.
        """
        half = np.arcsin(self.radius / (self.lamp_height - self.height))
        angle = np.arccos(1.0 - (1.0 - np.cos(half)) * (np.arange(rays) + 0.5) / rays)
        power = np.full((2, rays), np.pi * intensity * (1.0 - np.cos(half)) / rays)
        place = np.stack([np.zeros(rays), np.full(rays, self.lamp_height - self.height)])
        direction = np.stack([np.sin(angle), -np.cos(angle)])
        along = (place * direction).sum(0)
        place = place - direction * (along + np.sqrt(np.maximum(along**2 - (place**2).sum(0) + self.radius**2, 0.0)))
        normal = place / self.radius
        cos = -(direction * normal).sum(0)
        mirrored, beyond = _fresnel(cos, self.index)
        found = self._land(place, direction + 2.0 * cos * normal, (power * mirrored).sum(0), edges)
        power = power * (1.0 - mirrored)
        direction = direction / self.index + normal * (cos / self.index - beyond)
        for _ in range(8):
            place = place - 2.0 * (place * direction).sum(0) * direction
            normal = place / self.radius
            cos = (direction * normal).sum(0)
            mirrored, beyond = _fresnel(cos, 1.0 / self.index)
            out = direction * self.index + normal * (beyond - cos * self.index)
            found += self._land(place, out, (power * (1.0 - mirrored)).sum(0), edges)
            power = power * mirrored
            direction = direction - 2.0 * cos * normal
        return found / (np.pi * np.diff(edges**2))

    def _land(self, place: Array, direction: Array, power: Array, edges: Array) -> Array:
        down = direction[1] < 0.0
        far = place[0] - direction[0] * (place[1] + self.height) / np.where(down, direction[1], -1.0)
        return np.histogram(np.abs(far[down]), edges, weights=power[down])[0]


def _fresnel(cos: Array, index: float) -> tuple[Array, Array]:
    """Reflectances of s and p light that comes to a medium of ``index`` times the index before it; the cosine beyond."""
    cosine2 = 1.0 - (1.0 - cos**2) / index**2
    beyond = np.sqrt(np.maximum(cosine2, 0.0))
    s = ((cos - index * beyond) / (cos + index * beyond)) ** 2
    p = ((index * cos - beyond) / (index * cos + beyond)) ** 2
    return np.where(cosine2 > 0.0, [s, p], 1.0), beyond
