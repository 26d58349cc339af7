"""The objects of a scene as other programs take them: triangles, where they are put, the film on them. Internal.

Films whose thickness goes by place (gradient, wedge, lens_gap) or by the vertices of a mesh are laid out as maps: over the u
and v of simple shapes; on meshes and walls of bubbles u and v are given up, v counts the thickness along a ramp instead.
An object is several pieces where its film differs from instance to instance, and where walls have another film.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from iridesce import color, thickness
from iridesce.arguments.operands import Floats
from iridesce.arguments.refusals import Words, complaint
from iridesce.exchange.drawn import by_render, is_builtin
from iridesce.exchange.films import Film
from iridesce.exchange.geometry import Mesh, Surface, globe, surface_of
from iridesce.exchange.laying import GRID, MM, RAMP, THICKEST_NM, film_base, plain_name
from iridesce.exchange.walls import walls
from iridesce.scene import Scene
from iridesce.thickness import ThicknessMap

MOST_FILMS = 16
"""Films of one object that differ from instance to instance; of more the first stands for the rest."""

_LEAST_PATCH = 4.0
_IDENTITY = np.eye(4)[:3]


@dataclass(frozen=True, eq=False)
class Piece:
    """What is written as one mesh with one material, once or several times."""

    name: str
    item: Mapping[str, Any]
    """The object's tree."""
    surface: Surface | None
    """A shape with u and v of its own; else a mesh."""
    triangles: Mesh | None
    placements: Floats
    """(n, 3, 4), each from the space of the shape to the world, in scene units."""
    film: Film | None
    uv_scale: tuple[float, float] = (1.0, 1.0)
    uv_offset: tuple[float, float] = (0.0, 0.0)
    carries: Floats | None = None
    """u and v of the vertices that count the thickness, instead of the mesh's own."""
    repeats: tuple[bool, bool] = (False, False)
    """Whether maps go on beyond 0..1 along u and v."""

    def mesh(self, extent: float, fine: bool = False) -> Mesh:
        """Triangles with the u and v of its maps, in the space of the shape, scene units; ``extent``: where a plane ends."""
        mesh = self.triangles if self.surface is None else self.surface.mesh(extent=extent, fine=fine)
        assert mesh is not None
        if self.carries is not None:
            return mesh.with_uv(self.carries)
        if mesh.uv is None or (self.uv_scale == (1.0, 1.0) and self.uv_offset == (0.0, 0.0)):
            return mesh
        return mesh.with_uv(mesh.uv * np.array(self.uv_scale) + np.array(self.uv_offset))

    @property
    def is_placed(self) -> bool:
        """Whether it stands elsewhere than where its shape says."""
        return len(self.placements) != 1 or not np.array_equal(self.placements[0], _IDENTITY)

    @property
    def lost_maps(self) -> list[str]:
        """Maps of the object that cannot lie on it, since u and v count the thickness."""
        if self.carries is None:
            return []
        ((_, keys),) = self.item["surface"].items()
        named = [name for name in ("roughness", "reflectance") if "map" in (keys.get(name) or ()) and keys[name]]
        return [*named, *(["bump"] if self.item.get("bump") else [])]


@dataclass(frozen=True, eq=False)
class _Part:
    """What of an object has one film: all of it, or the outsides or the inner walls of bubbles."""

    name: str
    surface: Surface | None
    triangles: Mesh | None
    vertex_nm: Floats | None
    recipe: Any
    middle: Floats
    axis: Floats | None
    ball_heights: tuple[Floats, Floats] | None
    """Of bubbles: centres and radii, whose box a gradient goes by."""

    def span(self, along: Floats) -> tuple[float, float]:
        if self.ball_heights is not None:
            centers, radii = self.ball_heights
            at, half = centers @ along, radii * np.linalg.norm(along)
            return float((at - half).min()), float((at + half).max())
        if self.surface is not None:
            return self.surface.span(along)
        assert self.triangles is not None
        far = self.triangles.positions @ along
        return float(far.min()), float(far.max())


def pieces_of(scene: Scene, light: color.Illuminant, folder: Path) -> list[Piece]:
    """All objects; `ValueError` where none of them has a film or an optical surface."""
    tree = scene.to_dict()
    names: set[str] = set()
    found: list[Piece] = []
    for number, item in _with_films_on_faces(scene, tree["object"]):
        for piece in _pieces(scene, number, item, tree["unit"], folder, light):
            name, count = piece.name, 1
            while name in names:
                count += 1
                name = f"{piece.name}-{count}"
            names.add(name)
            film = None if piece.film is None else replace(piece.film, name=name)
            found.append(replace(piece, name=name, film=film))
    if not any(piece.film is not None for piece in found):
        raise complaint(
            "the scene has no surface that interferes: no film, coating, dielectric or metal",
            "scene",
            "a scene with a film, a coating, a dielectric or a metal",
            Words("one without"),
        )
    return found


def _with_films_on_faces(scene: Scene, items: Sequence[Mapping[str, Any]]) -> Iterator[tuple[int, Mapping[str, Any]]]:
    """Objects with their numbers; a film on the very face of a body is a layer of that body's coating, as it is drawn."""
    film_of = {body: film for film, body in scene._core.films_on_faces()}
    films = set(film_of.values())
    for number, item in enumerate(items):
        if number in films:
            continue
        if number not in film_of:
            yield number, item
            continue
        film = items[film_of[number]]["surface"]["film"]
        ((kind, keys),) = item["surface"].items()
        layers = [{key: film[key] for key in ("medium", "thickness_nm")}, *keys.get("layers", ())]
        coating = {"layers": layers, "substrate": keys["substrate" if kind == "coating" else "medium"]}
        rough = {"roughness": keys["roughness"]} if "roughness" in keys else {}
        yield number, {**item, "surface": {"coating": {**coating, **rough}}}


def _pieces(
    scene: Scene, number: int, item: Mapping[str, Any], unit: str, folder: Path, light: color.Illuminant
) -> list[Piece]:
    stored, placements = scene._core.body(number)
    name = plain_name(item["name"])
    uv = item.get("uv") or {}
    scale, offset = (tuple(float(x) for x in uv.get(key, default)) for key, default in _UV)
    plain: dict[str, Any] = {"uv_scale": scale, "uv_offset": offset}
    made: list[Piece] = []
    for part in _parts(name, item, stored):
        plain["repeats"] = _repeats(item["shape"], uv != {})
        base = film_base(item, part.recipe, light, part.name, folder)
        whole = Piece(part.name, item, part.surface, part.triangles, placements, base.film, **plain)
        if base.film is None or base.recipe is None:
            made.append(whole)
            continue
        for held in base.others:  # further layers that vary
            base.hold(held, _mean(part, base.others[held], placements[0], unit, folder))
        groups = _groups(part, base.recipe, placements)
        film = base.film
        if len(groups) > MOST_FILMS:
            film.notes.append(
                f"{part.name}: its thickness differs between {len(groups)} of its instances; the first stands for all"
            )
            groups = [np.arange(len(placements))]
        for group in groups:
            laid = _laid(part, base.recipe, placements[group[0]], unit, folder)
            made.append(_piece(whole, film, laid, placements[group], scale != (1.0, 1.0) or offset != (0.0, 0.0)))
    return made


_UV: tuple[tuple[str, tuple[float, float]], ...] = (("scale", (1.0, 1.0)), ("offset", (0.0, 0.0)))


def _repeats(shape: Mapping[str, Any], mapped: bool) -> tuple[bool, bool]:
    if mapped or "mesh" in shape or "plane" in shape:
        return True, True
    return any(kind in shape for kind in ("sphere", "cylinder", "bubbles")), False


def _parts(name: str, item: Mapping[str, Any], stored: Any) -> list[_Part]:
    ((kind, keys),) = item["shape"].items()
    ((_, skin),) = item["surface"].items()
    recipe = skin.get("thickness_nm")
    surface = surface_of(item["shape"])
    if surface is not None:
        axis = surface.frame()[2] if kind == "cap" else None
        middle = np.asarray(keys.get("center", keys.get("point")), dtype=np.float64)
        return [_Part(name, surface, None, None, recipe, middle, axis, None)]
    if kind == "mesh":
        positions, normals, uv, vertex_nm, triangles, _ = stored
        mesh = _facing(
            Mesh(positions, _floats(normals), _floats(uv), np.asarray(triangles, dtype=np.int64)),
        )
        low, high = positions.min(axis=0), positions.max(axis=0)
        return [_Part(name, None, mesh, _floats(vertex_nm), recipe, 0.5 * (low + high), None, None)]
    spheres = keys["spheres"]
    centers = np.array([ball["center"] for ball in spheres], dtype=np.float64)
    balls = (centers, np.array([ball["radius"] for ball in spheres], dtype=np.float64))
    outer, inner = walls(spheres)
    if inner is None:
        return [_Part(name, None, outer, None, recipe, centers.mean(axis=0), None, balls)]
    own = skin.get("inner_thickness_nm", recipe)
    return [
        _Part(part, None, mesh, None, what, centers.mean(axis=0), None, balls)
        for part, mesh, what in ((name, outer, recipe), (f"{name}-walls", inner, own))
    ]


def _floats(values: Any) -> Floats | None:
    return None if values is None else np.asarray(values, dtype=np.float64)


def _facing(mesh: Mesh) -> Mesh:
    """Normals on the side that corners run around, as a scene takes them."""
    if mesh.normals is None:
        return mesh
    corners = mesh.positions[mesh.triangles]
    front = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front /= np.linalg.norm(front, axis=1, keepdims=True)
    along = np.zeros(len(mesh.positions))
    for corner in range(3):
        at = mesh.triangles[:, corner]
        np.add.at(along, at, (mesh.normals[at] * front).sum(axis=1))
    return Mesh(mesh.positions, np.where(along < 0.0, -1.0, 1.0)[:, None] * mesh.normals, mesh.uv, mesh.triangles)


# --- thickness


def _groups(part: _Part, recipe: Any, placements: Floats) -> list[Any]:
    """Instances of the same thickness everywhere."""
    if len(placements) == 1 or not isinstance(recipe, Mapping):
        return [np.arange(len(placements))]
    ((kind, _), *_) = recipe.items()
    linear = placements[:, :, :3]
    if kind == "gradient":  # by height: which way is up, in the space of the shape
        marks = linear[:, 1] / np.linalg.norm(linear[:, 1], axis=1, keepdims=True)
    elif kind == "lens_gap":  # by distance
        marks = (np.swapaxes(linear, 1, 2) @ linear).reshape(len(placements), -1)
    elif kind == "wedge":
        marks = placements.reshape(len(placements), -1)
    else:
        return [np.arange(len(placements))]
    size = max(float(np.abs(marks).max()), 1e-300)
    _, first, which = np.unique(np.round(marks / size, 9), axis=0, return_index=True, return_inverse=True)
    return [np.flatnonzero(which.reshape(-1) == number) for number in np.argsort(first)]


@dataclass(frozen=True, eq=False)
class _Laid:
    """Thickness in nm: over u and v (row 0 on top), or of the vertices."""

    grid: Floats | None
    vertex_nm: Floats | None = None
    chart: float | None = None
    """Of a plane: the side of the square that the grid covers."""
    by_place: bool = False
    error_nm: float = 0.0
    """Of vertices: how far the middles of edges are from the law."""


def _laid(part: _Part, recipe: Any, placement: Floats, unit: str, folder: Path) -> _Laid:
    columns, rows = GRID
    u = (np.arange(columns) + 0.5)[None, :] / columns
    v = 1.0 - (np.arange(rows) + 0.5)[:, None] / rows
    if recipe == "vertex":
        assert part.vertex_nm is not None
        return _Laid(None, part.vertex_nm)
    surface = part.surface
    if is_builtin(recipe.get("map")):
        return _Laid(by_render(recipe))
    if "map" in recipe:
        path = Path(recipe["map"])
        chosen = {key: recipe[key] for key in ("min_nm", "max_nm", "channel", "page") if key in recipe}
        return _Laid(
            np.asarray(ThicknessMap.load(path if path.is_absolute() else folder / path, **chosen).thickness_nm)
        )
    if "flow" in recipe:
        grid = thickness.flow(**recipe["flow"]).map(columns, rows)
        if surface is not None and surface.kind == "cap":
            across, up = globe(surface.points(u, v), surface.middle_of_sphere())
            return _Laid(np.asarray(grid.sample(across, up)))
        return _Laid(np.asarray(grid.thickness_nm))
    if "swirls" in recipe:
        return _Laid(by_render(recipe))
    if surface is None:
        assert part.triangles is not None
        mesh = part.triangles
        own = _at(recipe, part, mesh.positions, placement, unit)
        ends = np.concatenate([mesh.triangles[:, [0, 1]], mesh.triangles[:, [1, 2]], mesh.triangles[:, [2, 0]]])
        middles = 0.5 * (mesh.positions[ends[:, 0]] + mesh.positions[ends[:, 1]])
        law = _at(recipe, part, middles, placement, unit)
        error = float(np.abs(law - 0.5 * (own[ends[:, 0]] + own[ends[:, 1]])).max())
        return _Laid(None, own, by_place=True, error_nm=error)
    points, side = surface.points(u, v), None
    if surface.kind == "plane":  # the patch that the map of a plane covers
        far = (
            [np.asarray(recipe["wedge"][key], dtype=np.float64) for key in ("from", "to")] if "wedge" in recipe else []
        )
        middle = _moved(part.middle, placement)
        side = max([_LEAST_PATCH, *(2.2 * float(np.linalg.norm(end - middle)) for end in far)])
        points = surface.points(0.5 + side * (u - 0.5), 0.5 + side * (v - 0.5))
    if surface.kind in ("disk", "cap"):  # the corners of the square lie beyond the rim: they go on as the rim is
        beyond = np.maximum(np.hypot(2 * u - 1, 2 * v - 1), 1.0)
        points = surface.points(0.5 + (u - 0.5) / beyond, 0.5 + (v - 0.5) / beyond)
    return _Laid(_at(recipe, part, points, placement, unit), chart=side, by_place=True)


def _moved(points: Floats, placement: Floats) -> Floats:
    return np.asarray(points @ placement[:, :3].T + placement[:, 3])


def _at(recipe: Mapping[str, Any], part: _Part, own: Floats, placement: Floats, unit: str) -> Floats:
    """A law of place at points of the shape, where the object is put."""
    ((kind, keys),) = recipe.items()
    points = _moved(own, placement)
    if kind == "gradient":
        low, high = (end + placement[1, 3] for end in part.span(placement[1, :3]))
        height = np.clip((points[..., 1] - low) / (high - low), 0.0, 1.0)
        return np.asarray(thickness.gradient(**keys).at_height(height), dtype=np.float64)
    if kind == "wedge":
        named = {f"{key}_point" if key in ("from", "to") else key: value for key, value in keys.items()}
        return np.asarray(np.maximum(thickness.wedge(**named).at_point(points), 0.0), dtype=np.float64)
    middle = part.middle
    if part.surface is None and part.ball_heights is None:  # a mesh: the middle of its box in the world
        assert part.triangles is not None
        corners = _moved(part.triangles.positions, placement)
        middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    else:
        middle = _moved(middle, placement)
    way = points - middle
    if part.axis is not None:
        axis = part.axis @ np.linalg.inv(placement[:, :3])
        axis = axis / np.linalg.norm(axis)
        way = way - (way @ axis)[..., None] * axis
    radius_mm = np.linalg.norm(way, axis=-1) * MM[unit]
    return np.asarray(thickness.lens_gap(**keys).at_radius(np.minimum(radius_mm, 0.999 * float(keys["radius_mm"]))))


def _mean(part: _Part, recipe: Any, placement: Floats, unit: str, folder: Path) -> float:
    laid = _laid(part, recipe, placement, unit, folder)
    values = laid.grid if laid.grid is not None else laid.vertex_nm
    assert values is not None
    return float(values.mean())


def _piece(whole: Piece, film: Film, laid: _Laid, placements: Floats, mapped: bool) -> Piece:
    """A piece whose film is laid out."""
    notes = list(film.notes)
    values = laid.grid if laid.grid is not None else laid.vertex_nm
    assert values is not None
    if values.max() > THICKEST_NM:
        notes.append(
            f"{whole.name}: thicker than {THICKEST_NM:g} nm, up to {values.max():.6g}, is held at {THICKEST_NM:g} nm"
        )
        values = np.minimum(values, THICKEST_NM)
    low, high = float(values.min()), float(values.max())
    if low == high:
        return replace(
            whole, film=replace(film, range_nm=(low, high), thickness_nm=None, notes=notes), placements=placements
        )
    if laid.vertex_nm is not None:
        if laid.error_nm > 0.05:
            notes.append(
                f"{whole.name}: its thickness is linear between its vertices: up to {laid.error_nm:.2g} nm off on their edges"
            )
        columns, rows = RAMP
        ramp = np.repeat(np.linspace(high, low, rows)[:, None], columns, axis=1)
        share = (values - low) / (high - low)
        carries = np.stack([np.full(len(share), 0.5), (0.5 + (rows - 1) * share) / rows], axis=1)
        film = replace(film, range_nm=(low, high), thickness_nm=ramp, notes=notes)
        return replace(whole, film=film, placements=placements, carries=carries, repeats=(False, False))
    film = replace(film, range_nm=(low, high), thickness_nm=values, notes=notes)
    piece = replace(whole, film=film, placements=placements)
    if not laid.by_place:
        return piece
    # A law of place lies on the shape's own u and v.
    scale = 1.0 if laid.chart is None else 1.0 / laid.chart
    offset = 0.5 - 0.5 * scale
    if mapped:
        film.notes.append(f"{whole.name}: uv is left out, for its thickness is laid over the shape's own u and v")
    return replace(
        piece,
        uv_scale=(scale, scale),
        uv_offset=(offset, offset),
        repeats=_repeats(whole.item["shape"], False) if laid.chart is None else (False, False),
    )


def turned(placements: Floats) -> tuple[Floats, Floats, Floats] | None:
    """Translations, rotations as quaternions x y z w, scales along the axes; ``None`` where one is sheared or mirrored."""
    linear = placements[:, :, :3]
    scales = np.linalg.norm(linear, axis=1)
    turns = linear / scales[:, None, :]
    square = np.swapaxes(turns, 1, 2) @ turns
    if np.abs(square - np.eye(3)).max() > 1e-9 or np.linalg.det(turns).min() < 0.0:
        return None
    # The largest of the four (Shepperd 1978): no cancellation.
    m = turns
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    four = np.stack([m[:, 0, 0], m[:, 1, 1], m[:, 2, 2], trace], axis=1)
    quaternions = np.empty((len(m), 4))
    for number, most in enumerate(np.argmax(four, axis=1)):
        own = m[number]
        if most == 3:
            w = own[2, 1] - own[1, 2], own[0, 2] - own[2, 0], own[1, 0] - own[0, 1], 1.0 + trace[number]
        else:
            j, k = (most + 1) % 3, (most + 2) % 3
            w4 = [0.0] * 4
            w4[most] = 1.0 + 2.0 * own[most, most] - trace[number]
            w4[j], w4[k] = own[j, most] + own[most, j], own[k, most] + own[most, k]
            w4[3] = own[k, j] - own[j, k]
            w = (w4[0], w4[1], w4[2], w4[3])
        quaternions[number] = np.array(w) / np.linalg.norm(w)
    return placements[:, :, 3], quaternions, scales
