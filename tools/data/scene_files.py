"""Make the files of the built-in scenes anew: python tools/data/scene_files.py [NAME...]

They stand in crates/scene/files, go into the program and are named `builtin:NAME` in scenes (crates/scene/src/builtin.rs).
All of them are made up from a few formulas here; noise comes from seeds, so that the same files come out every time.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Floats = NDArray[np.float64]

FOLDER = Path(__file__).resolve().parents[2] / "crates" / "scene" / "files"


def smooth_noise(rows: int, columns: int, waves: float, seed: int, slope: float = 2.0) -> Floats:
    """Noise of mean 0 and deviation 1 that fits to itself: amplitudes fall as frequency^-slope above `waves` a side."""
    rng = np.random.default_rng(seed)
    spectrum = np.fft.rfft2(rng.standard_normal((rows, columns)))
    frequency = np.hypot(np.fft.fftfreq(rows, 1 / rows)[:, None], np.fft.rfftfreq(columns, 1 / columns)[None, :])
    spectrum *= np.where(frequency > 0, 1.0, 0.0) / (1.0 + (frequency / waves) ** 2) ** (slope / 2)
    field = np.fft.irfft2(spectrum, (rows, columns))
    return np.asarray(field / field.std())


def write_grey(name: str, values: Floats, most: float, bits: int = 16) -> None:
    """A grey picture, row 0 on top (v = 1), of which the largest whole number means `most`."""
    top = (1 << bits) - 1
    steps = np.round(np.clip(values / most, 0.0, 1.0) * top).astype(np.uint16 if bits == 16 else np.uint8)
    Image.fromarray(steps).save(FOLDER / name, optimize=True)


def temper() -> None:
    """Magnetite on steel beside a weld, nm over u (around the pipe, 0 to 1) and v (along it, the weld at 1/2).

    The peak temperature at the distance d from the weld falls as 1/d (Rosenthal's moving source in a plate); oxide grows by
    diffusion, so its thickness goes as exp(-Q / 2 R T) of the peak temperature T.
    """
    rows, columns = 384, 192
    activation_j_mol, gas_j_mol_k = 6.0e4, 8.314  # of iron through magnetite at these temperatures, about
    v = (np.arange(rows) + 0.5)[:, None] / rows
    around = (np.arange(columns) + 0.5)[None, :] / columns
    # The torch is moved by hand: heat runs ahead and is late, more on one side; each pulse leaves a scallop.
    stops = smooth_noise(1, columns, 3.0, 11, 3.0)
    reach = 1.0 + 0.10 * stops + 0.012 * np.cos(2 * np.pi * 72 * around)
    reach = reach * (1.0 + 0.05 * np.sign(v - 0.5) * smooth_noise(1, columns, 2.0, 12, 3.0))
    distance = np.abs(v - 0.5) / (0.26 * reach)
    peak_k = 293.0 + 420.0 / (distance + 0.45)
    law = np.exp(-activation_j_mol / (2 * gas_j_mol_k) * (1.0 / peak_k - 1.0 / 1226.0))
    thickness_nm = 2.0 + 112.0 * law
    thickness_nm = thickness_nm * (1.0 + 0.02 * smooth_noise(rows, columns, 10.0, 13))
    write_grey("temper.png", np.round(thickness_nm / 0.1) * 0.1, 6553.5)


def scratches() -> None:
    """Heights of a brushed surface: lines along u, one column, rows along v."""
    rows = 1024
    rng = np.random.default_rng(21)
    height = 0.5 * smooth_noise(rows, 1, 200.0, 22, 1.0)[:, 0]
    deep = rng.integers(0, rows, 60)
    height[deep] -= rng.exponential(1.5, deep.size)
    height = (height - height.min()) / np.ptp(height)
    write_grey("scratches.png", np.repeat(height[:, None], 4, axis=1), 1.0, bits=8)


def write_ply(name: str, points: Floats, normals: Floats, uv: Floats, faces: NDArray[np.int64]) -> None:
    """A mesh with normals, u and v: floats and corners of 16 bits."""
    assert len(points) < 1 << 16
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    lines += [f"property float {key}" for key in ("x", "y", "z", "nx", "ny", "nz", "u", "v")]
    lines += [f"element face {len(faces)}", "property list uchar ushort vertex_indices", "end_header"]
    rows = np.hstack([points, normals, uv]).astype("<f4")
    corners = np.zeros(len(faces), dtype=[("count", "u1"), ("corner", "<u2", (3,))])
    corners["count"], corners["corner"] = 3, faces
    (FOLDER / name).write_bytes("\n".join([*lines, ""]).encode() + rows.tobytes() + corners.tobytes())


Part = tuple[Floats, Floats, Floats, NDArray[np.int64]]


def loft(rings: Floats, u: Floats, v: Floats, is_ring: bool = False) -> Part:
    """A closed surface through rings (n, m, 3) of which the first and the last are points, or the same (a ring of rings).

    Normals are smooth, and point outside whichever way the rings run. Its seams have their vertices twice.
    """
    rings = np.concatenate([rings, rings[:, :1]], axis=1)
    n, m, _ = rings.shape
    along = np.gradient(rings, axis=0)
    around = np.empty_like(rings)
    around[:, 1:-1] = rings[:, 2:] - rings[:, :-2]
    around[:, 0] = around[:, -1] = rings[:, 1] - rings[:, -2]
    normal = np.cross(around, along)
    if is_ring:
        rings[-1] = rings[0]
        normal[0] = normal[-1] = np.cross(around[0], rings[1] - rings[-2])
    else:
        normal[0], normal[-1] = (
            np.cross(around[k], rings[end] - rings[k].mean(axis=0)) * sign for k, end, sign in ((1, 0, -1), (-2, -1, 1))
        )
        normal[0], normal[-1] = normal[0].sum(axis=0), normal[-1].sum(axis=0)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    index = np.arange(n * m).reshape(n, m)
    a, b, c, d = (x.ravel() for x in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]))
    lower, upper = np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)
    rows = np.repeat(np.arange(n - 1), m - 1)
    kept = (rows >= 0, rows >= 0) if is_ring else (rows > 0, rows < n - 2)  # at a point one of the two is a line
    faces = np.concatenate([lower[kept[0]], upper[kept[1]]])
    corners = rings.reshape(-1, 3)[faces]
    if np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) < 0.0:  # six times the volume
        faces, normal = faces[:, ::-1], -normal
    uv = np.stack(np.broadcast_arrays(u[None, :], v[:, None]), axis=-1)
    return rings.reshape(-1, 3), normal.reshape(-1, 3), uv.reshape(-1, 2), faces


def joined(parts: list[Part]) -> Part:
    """Several surfaces as one mesh."""
    first = np.cumsum([0, *(len(part[0]) for part in parts)])
    points, normals, uv = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return points, normals, uv, np.concatenate([part[3] + start for part, start in zip(parts, first, strict=False)])


def elytron() -> None:
    """The right wing case of a jewel beetle, cm: from its base at z = 0 to its tip at z = -2.5; x from the suture outwards.

    u runs from the suture (0) over the back to the edge (1) and beneath, v from the base to the tip.
    """
    s = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, 45))
    tip = np.clip((s - 0.42) / 0.58, 0.0, 1.0)
    taper = np.maximum(1.0 - tip**2.1, 0.0) ** 0.72
    shoulder = np.sqrt(np.maximum(1.0 - np.clip(1.0 - s / 0.10, 0.0, 1.0) ** 2, 0.0))
    width = (
        0.80
        * taper
        * (0.55 * shoulder + 0.45 * np.sqrt(np.clip(s / 0.03, 0, 1)))
        * (1.0 + 0.05 * np.sin(2.2 * np.pi * s))
    )
    height = (
        0.50 * taper**0.85 * np.sqrt(np.clip(s / 0.16, 0.0, 1.0)) * (1.0 + 0.10 * np.exp(-(((s - 0.22) / 0.15) ** 2)))
    )
    top = np.array([0.0, 0.012, 0.03, 0.06, *np.linspace(0.1, 1.0, 16)])
    angle = 0.5 * np.pi * top
    over = np.stack([np.sin(angle) ** 0.92, np.cos(angle) ** 0.80], axis=1)
    beneath = np.array([[0.97, -0.10], [0.80, -0.16], [0.40, -0.18], [0.05, -0.16], [0.0, 0.3]])
    outline = np.concatenate([over, beneath])
    u = np.concatenate([top, [1.03, 1.1, 1.25, 1.4, 1.5], [1.6]])
    z = np.broadcast_to(-2.5 * s[:, None], (len(s), len(outline)))
    drop = -0.10 * np.clip((s - 0.5) / 0.5, 0.0, 1.0) ** 2  # the tip hangs
    rings = np.stack([width[:, None] * outline[:, 0], height[:, None] * outline[:, 1] + drop[:, None], z], axis=-1)
    rings[0], rings[-1] = [0.25, 0.05, 0.0], [0.02, drop[-1], -2.5]
    write_ply("elytron.ply", *loft(rings, u, s))


def body(z: Floats, half_width: Floats, top: Floats, bottom: Floats, middle: Floats, count: int, square: float) -> Part:
    """A closed body along z: an upper and a lower half ellipse about a middle line, its corners fuller for square < 1."""
    angle = 2 * np.pi * np.arange(count) / count
    cos, sin = np.cos(angle), np.sin(angle)
    across = np.sign(cos) * np.abs(cos) ** square
    up = np.where(sin > 0, top[:, None], bottom[:, None]) * np.sign(sin) * np.abs(sin) ** square
    x = half_width[:, None] * across
    rings = np.stack([x, middle[:, None] + up, np.broadcast_to(z[:, None], x.shape)], axis=-1)
    return loft(rings[::-1], np.linspace(0.0, 1.0, count + 1), np.linspace(1.0, 0.0, len(z)))


def thorax() -> None:
    """Pronotum, scutellum and head of the beetle, cm; the head towards +z."""
    s = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, 25))
    round_ends = np.sqrt(np.maximum(1.0 - np.abs(2.0 * s - 1.0) ** 6, 0.0))
    pronotum = body(
        0.07 + 0.78 * s,
        (0.80 - 0.30 * s**1.5) * round_ends,
        (0.46 - 0.14 * s**1.6) * round_ends,
        0.26 * round_ends,
        0.0 * s,
        36,
        0.86,
    )
    ends = np.sqrt(np.maximum(1.0 - (2.0 * s - 1.0) ** 2, 0.0))
    head = body(0.66 + 0.56 * s, 0.47 * ends**0.9, 0.28 * ends, 0.26 * ends, -0.03 - 0.09 * s, 28, 0.9)
    scutellum = body(-0.10 + 0.26 * s, 0.09 * ends, 0.05 * ends, 0.05 * ends, 0.455 + 0.0 * s, 12, 1.0)
    write_ply("thorax.ply", *joined([pronotum, head, scutellum]))


def tube(line: Floats, radius: Floats, sides: int) -> Part:
    """A closed tube along a line, of one radius for each of its points; its ends are drawn to points."""
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along, [0.31, 0.17, 0.94])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other = np.cross(along, across)
    angle = -2 * np.pi * np.arange(sides)[None, :, None] / sides
    rings = line[:, None] + radius[:, None, None] * (np.cos(angle) * across[:, None] + np.sin(angle) * other[:, None])
    rings = np.concatenate([line[None, :1].repeat(sides, axis=1), rings, line[None, -1:].repeat(sides, axis=1)])
    return loft(rings[::-1], np.linspace(0.0, 1.0, sides + 1), np.linspace(1.0, 0.0, len(rings)))


def limbs() -> None:
    """Legs and feelers of the beetle, cm; its feet stand on y = -0.55."""
    parts = []
    legs = [  # hip, knee, ankle, claw of the right side
        ([0.35, -0.12, 0.50], [0.98, 0.10, 0.95], [1.22, -0.48, 1.32], [1.30, -0.54, 1.62]),
        ([0.45, -0.12, -0.25], [1.20, 0.14, -0.20], [1.58, -0.48, -0.32], [1.86, -0.54, -0.42]),
        ([0.45, -0.12, -0.85], [1.12, 0.12, -1.25], [1.42, -0.48, -1.85], [1.52, -0.54, -2.20]),
    ]
    for side in (1.0, -1.0):
        flip = np.array([side, 1.0, 1.0])
        for which, leg in enumerate(legs):
            hip, knee, ankle, claw = (np.asarray(point) * flip for point in leg)
            if side < 0:  # no beetle stands quite symmetrically
                knee, ankle, claw = (
                    knee + np.array([0, 0, 0.10]),
                    ankle + np.array([0, 0, 0.16 - 0.1 * which]),
                    claw + np.array([0, 0, 0.2 - 0.14 * which]),
                )
            share = np.linspace(0.0, 1.0, 7)[:, None]
            swell = np.sin(np.pi * np.linspace(0.06, 0.94, 7)) ** 0.6
            parts.append(tube(hip + share * (knee - hip), 0.105 * swell, 8))
            parts.append(tube(knee + share * (ankle - knee), 0.025 + 0.040 * swell, 8))
            beads = np.linspace(0.0, 1.0, 11)
            bulge = 0.022 + 0.020 * np.abs(np.sin(5 * np.pi * beads))
            parts.append(tube(ankle + beads[:, None] * (claw - ankle), bulge, 6))
        share = np.linspace(0.0, 1.0, 23)
        feeler = np.stack(
            [0.14 + 0.75 * share**1.2, -0.02 + 0.22 * np.sin(2.2 * share), 1.12 + 0.62 * np.sin(1.9 * share)], axis=1
        )
        parts.append(tube(feeler * flip, 0.016 + 0.016 * np.abs(np.sin(11 * np.pi * share)), 6))
    write_ply("limbs.ply", *joined(parts))


def punctures() -> None:
    """Heights of a wing case over u (ten ribs) and v: rows of pits between the ribs, and fine wrinkles."""
    rows, columns = 512, 320
    u, v = np.meshgrid((np.arange(columns) + 0.5) / columns, (np.arange(rows) + 0.5) / rows)
    wander = 0.012 * smooth_noise(rows, columns, 3.0, 31, 3.0)
    ribs = 0.5 + 0.5 * np.cos(2 * np.pi * 10 * (u + 0.3 * wander))
    rng = np.random.default_rng(32)
    pits = np.zeros((rows, columns))
    for rib in range(10):
        for place in np.arange(0.0, 1.0, 1 / 46):
            at_u, at_v = (rib + 0.5 + 0.16 * rng.standard_normal()) / 10, place + 0.004 * rng.standard_normal()
            du, dv = (u - at_u + 0.5) % 1 - 0.5, (v - at_v + 0.5) % 1 - 0.5
            pits = np.maximum(pits, (0.7 + 0.3 * rng.random()) * np.exp(-((du / 0.016) ** 2) - (dv / 0.0066) ** 2))
    height = 0.55 * ribs - 0.55 * pits + 0.035 * smooth_noise(rows, columns, 30.0, 33, 3.0)
    write_grey("punctures.png", height - height.min(), float(np.ptp(height)), bits=8)


def chitin() -> None:
    """Thickness of the layers of a wing case, a share of 1 over u: two stripes of copper red on green, and a redder edge."""
    columns, rows = 160, 64
    u, v = np.meshgrid((np.arange(columns) + 0.5) / columns, 1.0 - (np.arange(rows) + 0.5) / rows)
    middle = 0.44 + 0.05 * np.sin(2.5 * (v - 0.2)) + 0.012 * smooth_noise(rows, 1, 4.0, 41, 3.0)
    stripe = np.exp(-(((u - middle) / (0.105 + 0.02 * np.cos(5 * v))) ** 4))
    edge = np.exp(-(((u - 1.0) / 0.07) ** 2))
    share = (
        1.0
        + 0.20 * stripe
        + 0.06 * edge
        - 0.03 * np.exp(-((u / 0.12) ** 2))
        + 0.006 * smooth_noise(rows, columns, 6.0, 42)
    )
    write_grey("chitin.png", share, 2.0)


def asphalt_stones(side: int, count: int, seed: int) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Nearest of some stones at each cell, the share of the way to its rim, and their random numbers; fits to itself."""
    rng = np.random.default_rng(seed)
    place, size = rng.random((count, 2)), rng.lognormal(0.0, 0.28, count)
    u, v = np.meshgrid((np.arange(side) + 0.5) / side, (np.arange(side) + 0.5) / side)
    u = u + 0.004 * smooth_noise(side, side, 40.0, seed + 1, 3.0)
    v = v + 0.004 * smooth_noise(side, side, 40.0, seed + 2, 3.0)
    first, second = np.full((side, side), 9.0), np.full((side, side), 9.0)
    which = np.zeros((side, side), dtype=np.int64)
    for number, ((x, y), scale) in enumerate(zip(place, size, strict=True)):
        reach = round(4.2 * side / np.sqrt(count))
        i, j = round(y * side), round(x * side)
        rows, columns = np.arange(i - reach, i + reach) % side, np.arange(j - reach, j + reach) % side
        at = np.ix_(rows, columns)
        way = np.hypot((u[at] - x + 0.5) % 1 - 0.5, (v[at] - y + 0.5) % 1 - 0.5) * np.sqrt(count) / scale
        nearer = way < first[at]
        second[at] = np.where(nearer, first[at], np.minimum(second[at], way))
        which[at] = np.where(nearer, number, which[at])
        first[at] = np.minimum(first[at], way)
    return np.clip((second - first) / (second + first), 0.0, 1.0), which, rng.random(count)


def asphalt() -> None:
    """Heights of wet asphalt: stones rounded by traffic, some proud of the rest; water stands in between."""
    side, water = 640, 0.16
    inside, which, chance = asphalt_stones(side, 11000, 51)
    # Worn rims are round: a cliff there would be a dark stroke in the picture, and read as a scratch.
    rise = np.clip(inside / 0.80, 0.0, 1.0)
    dome = rise**2 * (3.0 - 2.0 * rise) * (0.25 + 0.85 * chance[which])
    dome += 0.035 * smooth_noise(side, side, 160.0, 52, 1.6)
    dome += 0.10 * smooth_noise(side, side, 5.0, 53, 3.0)
    height = np.maximum(dome, water + 0.25 * (dome - water))
    for _ in range(3):
        height = (height + sum(np.roll(height, way, (0, 1)) for way in ((1, 0), (-1, 0), (0, 1), (0, -1)))) / 5
    write_grey("asphalt.png", height - height.min(), float(np.ptp(height)), bits=8)


def oil() -> None:
    """A drop of oil that has spread over wet ground, nm: thick where it fell, thinner in folded rings outwards; none beyond."""
    side = 448
    u, v = np.meshgrid((np.arange(side) + 0.5) / side, (np.arange(side) + 0.5) / side)
    push = [smooth_noise(side, side, 3.0, seed, 3.2) for seed in (61, 62)]
    fine = [smooth_noise(side, side, 12.0, seed, 3.2) for seed in (63, 64)]
    x = u - 0.47 + 0.045 * push[0] + 0.010 * fine[0]
    y = v - 0.52 + 0.045 * push[1] + 0.010 * fine[1]
    away = np.hypot(x * 0.92, y * 1.12) / 0.36
    streak = np.exp(-(((x + 0.6 * y - 0.06) / 0.10) ** 2)) * np.clip(1.2 - away, 0.0, 1.0)
    thickness = (
        700.0 * np.exp(-1.8 * away**1.35) * (1.0 + 0.10 * smooth_noise(side, side, 7.0, 65, 2.6)) + 160.0 * streak
    )
    thickness *= 1.0 / (1.0 + np.exp((away - 1.28) / 0.05))
    write_grey("oil.png", np.round(thickness), 6553.5)


def overcast() -> None:
    """The CIE standard overcast sky, (1 + 2 sin h) / 3 of its zenith at the height h, over houses and trees; mean 1 above.

    Radiance HDR, 128 x 64, of whole pixels without runs.
    """
    columns, rows = 128, 64
    height = np.pi * (0.5 - (np.arange(rows) + 0.5)[:, None] / rows)
    sky = (1.0 + 2.0 * np.sin(np.maximum(height, 0.0))) / 3.0 * (9.0 / 7.0)
    clouds = 1.0 + 0.16 * smooth_noise(rows, columns, 5.0, 71, 2.4)
    roofs = np.deg2rad(
        14.0 + 7.0 * np.round(smooth_noise(1, columns, 6.0, 72, 2.0)) + 3.0 * smooth_noise(1, columns, 30.0, 73, 1.5)
    )
    value = np.where(height > np.maximum(roofs, 0.02), sky * clouds, 0.2)
    value = np.where(height < 0.0, 0.10, value)
    rgb = value[..., None] * np.array([1.0, 1.0, 1.0])
    exponent = np.ceil(np.log2(rgb.max(axis=-1) + 1e-9))
    bytes_ = np.empty((rows, columns, 4), dtype=np.uint8)
    bytes_[..., :3] = np.clip(np.floor(rgb / 2.0 ** exponent[..., None] * 256), 0, 255)
    bytes_[..., 3] = exponent + 128
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {rows} +X {columns}\n".encode()
    (FOLDER / "overcast.hdr").write_bytes(head + bytes_.tobytes())


def iris() -> None:
    """Nine blades of a stop, cm, around the z axis: flat sheets from a hole with nine corners to a round rim."""
    parts = []
    for blade in range(9):
        angle = 2 * np.pi / 9 * (blade + np.linspace(0.0, 1.6, 9))
        middle = 2 * np.pi / 9 * (blade + 0.5)
        edge = 0.95 / np.cos(np.clip(angle - middle, -0.36, 0.9))
        height = 0.02 * np.linspace(0.0, 1.0, len(angle)) * 1.6
        rings = [
            np.stack([r * np.cos(angle), r * np.sin(angle), height], axis=1) for r in (edge, np.full_like(edge, 2.3))
        ]
        points, n = np.concatenate(rings), len(angle)
        a = np.arange(n - 1)
        faces = np.concatenate([np.stack([a, a + n, a + n + 1], axis=1), np.stack([a, a + n + 1, a + 1], axis=1)])
        normals = np.broadcast_to(np.array([0.0, 0.0, 1.0]), points.shape)
        parts.append((points, np.asarray(normals), points[:, :2] / 4.6 + 0.5, faces))
    write_ply("iris.ply", *joined(parts))


def barrel() -> None:
    """The barrel of a lens, cm, turned about the z axis: a grooved ring outside, a lip in front, smooth within."""
    grooves = [(2.95 + 0.06 * (k % 2), -0.86 - 0.3 * (k // 2 - 1) - 0.06 * (k % 2)) for k in range(2, 10)]
    profile = [  # radius, z: down the outside, up the inside
        (2.62, 0.32),
        (2.70, 0.34),
        (2.78, 0.32),
        (2.86, 0.22),
        (2.88, 0.10),
        (2.88, -0.70),
        (2.95, -0.80),
        *grooves,
        (2.95, -2.20),
        (2.88, -2.30),
        (2.88, -4.90),
        (2.80, -5.00),
        (2.44, -5.00),
        (2.44, -0.44),
        (2.50, -0.30),
        (2.52, -0.10),
        (2.58, 0.10),
        (2.60, 0.26),
    ]
    radius, z = np.array(profile).T
    angle = 2 * np.pi * np.arange(57)[:, None] / 56
    rings = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.broadcast_to(z, (57, len(z)))], axis=-1)
    write_ply("barrel.ply", *loft(rings, np.linspace(0.0, 1.0, len(z) + 1), np.linspace(0.0, 1.0, 57), is_ring=True))


FILES = {
    one.__name__: one
    for one in (temper, scratches, elytron, thorax, limbs, punctures, chitin, asphalt, oil, overcast, iris, barrel)
}


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    for name in sys.argv[1:] or FILES:
        FILES[name]()
    for path in sorted(FOLDER.iterdir()):
        print(f"{path.name}: {path.stat().st_size} bytes", file=sys.stderr)


if __name__ == "__main__":
    main()
