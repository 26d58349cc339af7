"""The cluster of twenty bubbles of `crates/scene/scenes/bubble-cluster.toml`: python tools/data/bubble_cluster.py > FILE.

Two bubbles of radii a and b that share a wall are in balance at d^2 = a^2 + b^2 - a b. Each new bubble is put onto one, two or
three that are there, at exactly these distances, and stays clear of all others, so that every touching pair is in balance
and every wall meets its neighbours at 120 degrees.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

RADII = [3.0, 2.5, 2.1, 1.1, 0.9, 1.3, 1.2, 1.0, 1.4, 0.95, 1.15, 0.8, 0.9, 0.75, 0.7, 0.62, 0.56, 0.5, 0.44, 0.4]
ON = [0, 1, 2, 3, 3, 2, 2, 2, 1, 2, 1, 2, 1, 1, 1, 1, 1, 1, 1, 1]
CLEAR = 0.06


def balanced(a: float, b: float) -> float:
    """Distance of centres in balance."""
    return float(np.sqrt(a * a + b * b - a * b))


def places(centers: np.ndarray, distances: list[float], noise: np.random.Generator) -> list[np.ndarray]:
    """Points at given distances from one, two or three centres; what is free is drawn."""
    first, d0 = centers[0], distances[0]
    if len(distances) == 1:
        way = noise.normal(size=3)
        return [first + d0 * way / np.linalg.norm(way)]
    x = centers[1] - first
    apart = float(np.linalg.norm(x))
    x /= apart
    along = (apart**2 + d0**2 - distances[1] ** 2) / (2 * apart)
    ring2 = d0**2 - along**2
    if ring2 <= 0:
        return []
    if len(distances) == 2:
        way = np.cross(x, noise.normal(size=3))
        return [first + along * x + np.sqrt(ring2) * way / np.linalg.norm(way)]
    third = centers[2] - first
    i = float(third @ x)
    y = third - i * x
    j = float(np.linalg.norm(y))
    y /= j
    across = (d0**2 - distances[2] ** 2 + i * i + j * j - 2 * i * along) / (2 * j)
    rest2 = ring2 - across**2
    if rest2 <= 0:
        return []
    up = np.sqrt(rest2) * np.cross(x, y)
    return [first + along * x + across * y + sign * up for sign in (1.0, -1.0)]


def put(
    radius: float,
    wanted: int,
    balls: list[tuple[np.ndarray, float]],
    touching: set[tuple[int, int]],
    noise: np.random.Generator,
) -> tuple[np.ndarray, tuple[int, ...]] | None:
    """A place on so many bubbles, which share walls with each other, clear of all others."""
    groups = [
        group
        for group in combinations(range(len(balls)), wanted)
        if all(pair in touching for pair in combinations(group, 2))
    ]
    for _ in range(300 if groups else 0):
        chosen = groups[noise.integers(len(groups))]
        centers = np.array([balls[k][0] for k in chosen])
        for place in places(centers, [balanced(radius, balls[k][1]) for k in chosen], noise):
            others = [(c, r) for k, (c, r) in enumerate(balls) if k not in chosen]
            if all(np.linalg.norm(place - c) > (radius + r) * (1 + CLEAR) for c, r in others):
                return place, chosen
    return None


def cluster(seed: int) -> list[tuple[np.ndarray, float]] | None:
    """Twenty balls, or None where one finds no place."""
    noise = np.random.default_rng(seed)
    balls: list[tuple[np.ndarray, float]] = []
    touching: set[tuple[int, int]] = set()
    for radius, on in zip(RADII, ON, strict=True):
        if not balls:
            balls.append((np.zeros(3), radius))
            continue
        place = next(
            (found for wanted in range(on, 0, -1) if (found := put(radius, wanted, balls, touching, noise))), None
        )
        if place is None:
            return None
        touching |= {(k, len(balls)) for k in place[1]}
        balls.append((place[0], radius))
    return balls


def main() -> None:
    """Prints the first cluster that closes, its middle at the origin."""
    balls = next(found for seed in range(1000) if (found := cluster(seed)) is not None)
    weights = np.array([r**3 for _, r in balls])
    middle = sum(w * c for w, (c, _) in zip(weights, balls, strict=True)) / weights.sum()
    for center, radius in balls:
        x, y, z = (float(v) for v in center - middle)
        print(f"    {{ center = [{x!r}, {y!r}, {z!r}], radius = {radius} }},")


if __name__ == "__main__":
    main()
