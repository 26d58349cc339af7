"""Target ``gltf``: KHR_materials_iridescence, transmission, ior; whole scenes with geometry and camera."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from iridesce import _core, color
from iridesce.arguments.operands import Floats
from iridesce.exchange.appearance import lamp_rgb, reflectance_of
from iridesce.exchange.films import Film
from iridesce.exchange.geometry import Mesh, Surface
from iridesce.exchange.knobs import Knobs, differences, fitted, knobs_of
from iridesce.exchange.laying import MM, folder_of
from iridesce.exchange.package import Package, Request
from iridesce.exchange.pieces import Piece, turned
from iridesce.exchange.surfaces import (
    normal_png,
    picture_file,
    roughness_png,
    told_camera,
    told_piece,
    told_spectrum,
)
from iridesce.exchange.textures import laid_out, thickness_png
from iridesce.exchange.twins import gltf as twin

_TAKES = ("film_ior", "base_ior", "f0")
_HELD = (False, False)

MOST_NODES = 10_000
"""Instances of one object beyond which a file of plain nodes is too large; then EXT_mesh_gpu_instancing."""


def export_gltf(request: Request) -> Package:
    """``scene.gltf`` (or ``film.gltf``), its ``.bin`` and the maps of thickness."""
    package = Package()
    name = "film" if request.scene is None else "scene"
    document = _Document(f"{name}.bin")
    if request.scene is None:
        film = request.films[0]
        mesh = Surface("sphere", {"center": [0.0, 0.0, 0.0], "radius": 1.0}).mesh()
        material = document.material(_material(film, request, package, document, _HELD))
        document.node({"name": film.name, "mesh": document.mesh(film.name, mesh, material)})
        package.note("the material is on a sphere of radius 1 m; take it from there")
    else:
        _scene(request, request.scene.to_dict(), folder_of(request.scene), document, package)
    package.files[f"{name}.gltf"] = document.text()
    package.files[f"{name}.bin"] = document.buffer()
    package.note("iridescenceThickness in nm; in the map of thickness channel G counts, linear, first row on top")
    package.note(f"errors are told by a twin of {twin.VERSION}; the formula knows no k, no polarisation and two orders")
    return package


def show(knobs: Knobs, thickness_nm: Floats, cosine: Floats) -> Floats:
    """The twin with these knobs."""
    f0 = knobs.f0 if knobs.base_ior is None else twin.normal_reflectance(knobs.base_ior, 1.0)
    return twin.rgb(thickness_nm, cosine, knobs.film_ior, f0)


def show_three(knobs: Knobs, thickness_nm: Floats, cosine: Floats) -> Floats:
    """The same as three.js evaluates it."""
    f0 = knobs.f0 if knobs.base_ior is None else twin.normal_reflectance(knobs.base_ior, 1.0)
    return twin.rgb(thickness_nm, cosine, knobs.film_ior, f0, fifth=twin.fifth_power_of_three)


def _material(
    film: Film, request: Request, package: Package, document: _Document, repeats: tuple[bool, bool]
) -> dict[str, Any]:
    knobs = knobs_of(film, package, "gltf")
    if request.fit and film.layer is not None:
        knobs = fitted(show, knobs, film, package, _TAKES)
    package.differences[film.name] = differences(show, knobs, film)
    if film.layer is not None:
        mean = float(differences(show_three, knobs, film).mean())
        package.note(
            f"{film.name}: CIEDE2000 {mean:.2f} in the mean in three.js 0.187, which approximates Schlick's fifth power"
        )
    material: dict[str, Any] = {"name": film.name, "extensions": {}}
    surface = {"metallicFactor": 0.0, "roughnessFactor": 0.0, "baseColorFactor": [1.0, 1.0, 1.0, 1.0]}
    if knobs.base_ior is None:
        surface["metallicFactor"] = 1.0
        surface["baseColorFactor"] = [*(round(float(x), 9) for x in knobs.f0), 1.0]
        package.drop(f"{film.name}: k of {knobs.base_name}: the target has no k, and takes the phase of a clear base")
    else:
        material["extensions"]["KHR_materials_ior"] = {"ior": knobs.base_ior}
        material["extensions"]["KHR_materials_transmission"] = {"transmissionFactor": 1.0}
        if film.free:
            material["doubleSided"] = True
    material["pbrMetallicRoughness"] = surface
    _rough(film, material, document, package, repeats)
    if film.layer is not None:
        low, high = film.range_nm
        iridescence: dict[str, Any] = {"iridescenceFactor": 1.0, "iridescenceIor": knobs.film_ior}
        if film.varies:
            film = laid_out(film, package)
            file = f"{film.name}_thickness.png"
            thickness_png(film, package, file)
            iridescence["iridescenceThicknessTexture"] = {"index": document.texture(file, repeats)}
            iridescence["iridescenceThicknessMinimum"], iridescence["iridescenceThicknessMaximum"] = low, high
        else:
            # Without a texture the maximum alone counts.
            iridescence["iridescenceThicknessMaximum"] = high
            iridescence["iridescenceThicknessMinimum"] = high
        material["extensions"]["KHR_materials_iridescence"] = iridescence
    return material


def _rough(
    film: Film, material: dict[str, Any], document: _Document, package: Package, repeats: tuple[bool, bool]
) -> None:
    rough, surface = film.roughness, material["pbrMetallicRoughness"]
    if rough is None:
        return
    if film.free:
        package.drop(
            f"{film.name}: what a rough film passes goes straight on; glTF spreads it as it spreads what is mirrored"
        )
    surface["roughnessFactor"], strength, turn = rough.gltf()
    if rough.grey is not None:
        surface["roughnessFactor"] = 1.0
        texture = document.texture(roughness_png(film.name, rough, package), repeats)
        surface["metallicRoughnessTexture"] = {"index": texture}
    if strength > 0.0:
        direction = {"anisotropyStrength": strength, "anisotropyRotation": turn}
        material["extensions"]["KHR_materials_anisotropy"] = direction


def _scene(request: Request, tree: Mapping[str, Any], folder: Path, document: _Document, package: Package) -> None:
    metres = MM[tree["unit"]] / 1000.0
    camera = tree["camera"]
    eye, target, up = (np.asarray(camera[key], dtype=np.float64) for key in ("position", "target", "up"))
    distance = float(np.linalg.norm(eye - target))
    extent = 20.0 * distance
    for piece in request.pieces:
        if piece.surface is not None and piece.surface.kind == "plane":
            package.note(f"{piece.name}: the plane is cut at {extent:g} {tree['unit']}")
        told_piece(piece, package)
        if piece.film is not None:
            made = _material(piece.film, request, package, document, piece.repeats)
        else:
            made = _plain_material(piece, folder, document, package)
        normals = normal_png(piece, folder, package, extent)
        if normals is not None:
            made["normalTexture"] = {"index": document.texture(normals, piece.repeats)}
        mesh = document.mesh(piece.name, piece.mesh(extent).scaled(metres), document.material(made))
        _put(piece, mesh, metres, document, package)
    document.node({"name": "camera", "camera": 0, "matrix": _look(eye * metres, target * metres, up)})
    told_camera(camera, package, lens=False)
    document.root["cameras"] = [_camera(camera, metres, distance)]
    for number, light in enumerate(tree["light"]):
        ((kind, keys),) = light.items()
        document.light(kind, keys, metres, number, package)


def _put(piece: Piece, mesh: int, metres: float, document: _Document, package: Package) -> None:
    """The nodes that put a mesh where its object stands, once for each instance."""
    placements = piece.placements.copy()
    placements[:, :, 3] *= metres
    if not piece.is_placed:
        document.node({"name": piece.name, "mesh": mesh})
        return
    if len(placements) == 1:
        document.node({"name": piece.name, "mesh": mesh, "matrix": _columns(placements[0])})
        return
    if len(placements) > MOST_NODES:
        parts = turned(placements)
        if parts is not None:
            package.note(
                f"{piece.name}: its {len(placements)} instances as EXT_mesh_gpu_instancing; a viewer without it shows one"
            )
            document.node({"name": piece.name, "mesh": mesh, "extensions": document.instances(*parts)})
            return
        package.note(f"{piece.name}: {len(placements)} nodes: some of its instances are sheared or mirrored")
    children = [
        document.child({"name": f"{piece.name}-{number + 1}", "mesh": mesh, "matrix": _columns(placement)})
        for number, placement in enumerate(placements)
    ]
    document.node({"name": piece.name, "children": children})


def _columns(placement: Floats) -> list[float]:
    """The matrix of a node, column after column."""
    whole = np.concatenate([placement, [[0.0, 0.0, 0.0, 1.0]]])
    return [float(x) for x in whole.T.reshape(-1)]


def _plain_material(piece: Piece, folder: Path, document: _Document, package: Package) -> dict[str, Any]:
    name, repeats = piece.name, piece.repeats
    ((kind, keys),) = piece.item["surface"].items()
    if kind == "diffuse":
        found = reflectance_of(keys["reflectance"], folder)
        factors: dict[str, Any] = {
            "baseColorFactor": [*found.rgb, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        }
        if found.spectrum is not None:
            told_spectrum(name, package)
        if found.picture is not None:
            file = picture_file(name, found, package, (".png", ".jpg", ".jpeg"), "gltf")
            if file is not None:
                factors["baseColorFactor"] = [1.0] * 4
                factors["baseColorTexture"] = {"index": document.texture(file, repeats, data=False)}
        # No gloss: ior 1 takes the dielectric's own mirror away.
        return {"name": name, "pbrMetallicRoughness": factors, "extensions": {"KHR_materials_ior": {"ior": 1.0}}}
    white = color.illuminant(keys["illuminant"]).white() * float(keys["radiance"])
    glow = np.maximum(color.rgb_matrix("linear-srgb") @ white, 0.0)
    strength = max(float(glow.max()), 1e-9)
    package.note(f"{name}: radiance in units of the scene's white, as emissiveStrength")
    return {
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.0, 0.0, 0.0, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        },
        "emissiveFactor": [float(x) for x in np.minimum(glow / strength, 1.0)],
        "doubleSided": True,
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}},
    }


def _camera(camera: Mapping[str, Any], metres: float, distance: float) -> dict[str, Any]:
    width, height = camera["resolution"]
    near, far = 0.001 * distance * metres, 100.0 * distance * metres
    if "orthographic_height" in camera:
        half = 0.5 * float(camera["orthographic_height"]) * metres
        view = {"xmag": half * width / height, "ymag": half, "znear": near, "zfar": far}
        return {"type": "orthographic", "orthographic": view}
    view = {"yfov": float(np.radians(camera["fov_deg"])), "aspectRatio": width / height, "znear": near, "zfar": far}
    return {"type": "perspective", "perspective": view}


def _look(eye: Floats, target: Floats, up: Floats) -> list[float]:
    """Column-major matrix of a camera at ``eye`` that looks along its own -z."""
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross(up, back)
    right = right / np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = right, np.cross(back, right), back, eye
    return [float(x) for x in matrix.T.reshape(-1)]


class _Document:
    """A glTF 2.0 document that grows."""

    def __init__(self, buffer_name: str) -> None:
        self._binary = bytearray()
        self._name = buffer_name
        self._extensions: set[str] = set()
        generator = f"iridesce {_core.__version__}"
        self.root: dict[str, Any] = {"asset": {"version": "2.0", "generator": generator}, "scene": 0}
        self._nodes: list[dict[str, Any]] = []
        self._roots: list[int] = []
        self._known: dict[tuple[bytes, str, int | None], int] = {}
        self._lists: dict[str, list[Any]] = {
            key: [] for key in ("materials", "meshes", "accessors", "bufferViews", "textures", "images", "samplers")
        }
        self._lights: list[dict[str, Any]] = []

    def node(self, node: dict[str, Any]) -> None:
        """A node of the scene."""
        self._roots.append(self.child(node))

    def child(self, node: dict[str, Any]) -> int:
        """A node that another names."""
        self._nodes.append(node)
        return len(self._nodes) - 1

    def instances(self, moves: Floats, turns: Floats, scales: Floats) -> dict[str, Any]:
        """EXT_mesh_gpu_instancing: translations, quaternions x y z w, scales."""
        self._extensions.add("EXT_mesh_gpu_instancing")
        attributes = {
            "TRANSLATION": self._accessor(moves, "VEC3", target=None),
            "ROTATION": self._accessor(turns, "VEC4", target=None),
            "SCALE": self._accessor(scales, "VEC3", target=None),
        }
        return {"EXT_mesh_gpu_instancing": {"attributes": attributes}}

    def material(self, material: dict[str, Any]) -> int:
        self._extensions |= set(material.get("extensions", {}))
        return self._add("materials", {key: value for key, value in material.items() if value != {}})

    def texture(self, file: str, repeats: tuple[bool, bool] = (True, True), data: bool = True) -> int:
        # Linear without mip-maps: a mean of thicknesses has not the mean of their colours. Pictures have them.
        wrap = {key: 10497 if again else 33071 for key, again in zip(("wrapS", "wrapT"), repeats, strict=True)}
        sampler = {"magFilter": 9729, "minFilter": 9729 if data else 9987, **wrap}
        known = self._lists["samplers"]
        number = known.index(sampler) if sampler in known else self._add("samplers", sampler)
        image = self._add("images", {"uri": file})
        return self._add("textures", {"sampler": number, "source": image})

    def mesh(self, name: str, mesh: Mesh, material: int) -> int:
        attributes = {"POSITION": self._accessor(mesh.positions, "VEC3", bounds=True)}
        if mesh.normals is not None:  # without them viewers draw every face flat, as a scene does
            attributes["NORMAL"] = self._accessor(_units(mesh.normals), "VEC3")
        if mesh.uv is not None:  # glTF counts v from the top
            attributes["TEXCOORD_0"] = self._accessor(np.stack([mesh.uv[:, 0], 1.0 - mesh.uv[:, 1]], axis=1), "VEC2")
        indices = self._accessor(mesh.triangles.reshape(-1), "SCALAR")
        primitive = {"attributes": attributes, "indices": indices, "material": material}
        return self._add("meshes", {"name": name, "primitives": [primitive]})

    def light(self, kind: str, keys: Mapping[str, Any], metres: float, number: int, package: Package) -> None:
        if kind not in ("sun", "directional", "point", "spot"):
            what = keys.get("map") or keys.get("builtin") or keys.get("illuminant")
            package.drop(f"light {number}: the environment {what!r}; glTF has none, set it in the viewer")
            return
        rgb = lamp_rgb(keys["illuminant"])
        if keys["illuminant"] != "D65":
            package.drop(f"light {number}: the spectrum of {keys['illuminant']}: three numbers hold its colour alone")
        power = float(keys.get("irradiance", keys.get("intensity", 1.0))) * float(rgb.max())
        light: dict[str, Any] = {"color": [float(x) for x in rgb / rgb.max()], "name": f"light_{number}"}
        node: dict[str, Any] = {"name": f"light_{number}"}
        if kind in ("sun", "directional"):
            way = np.asarray(keys["direction"], dtype=np.float64)
            light |= {"type": "directional", "intensity": power}
            node["matrix"] = _look(way, np.zeros(3), _any_up(way))
            if kind == "sun":
                package.drop(f"light {number}: the disc of the sun; glTF's has no size")
        else:
            place = np.asarray(keys["position"], dtype=np.float64) * metres
            light |= {"type": kind, "intensity": power * metres**2}
            aim = np.asarray(keys.get("target", place - [0, 1, 0]), dtype=np.float64) * (
                metres if kind == "spot" else 1.0
            )
            node["matrix"] = _look(place, aim, _any_up(place - aim))
            if kind == "spot":
                inner = 0.5 * np.radians(float(keys["cone_deg"]))
                outer = inner + np.radians(float(keys.get("soft_deg", 0.0)))
                outer = min(max(outer, inner + 1e-4), 0.5 * np.pi)
                light["spot"] = {"innerConeAngle": float(min(inner, outer - 1e-5)), "outerConeAngle": float(outer)}
        if keys.get("polarized_deg") is not None:
            package.drop(f"light {number}: its polarisation")
        node["extensions"] = {"KHR_lights_punctual": {"light": len(self._lights)}}
        self._lights.append(light)
        self._extensions.add("KHR_lights_punctual")
        self.node(node)

    def text(self) -> bytes:
        root = {**self.root, "scenes": [{"nodes": self._roots}], "nodes": self._nodes}
        root |= {key: value for key, value in self._lists.items() if value}
        root["buffers"] = [{"uri": self._name, "byteLength": len(self._binary)}]
        if self._lights:
            root["extensions"] = {"KHR_lights_punctual": {"lights": self._lights}}
        if self._extensions:
            root["extensionsUsed"] = sorted(self._extensions)
        return (json.dumps(root, indent=1, allow_nan=False) + "\n").encode("ascii")

    def buffer(self) -> bytes:
        return bytes(self._binary)

    def _accessor(
        self, values: np.ndarray[Any, Any], kind: str, bounds: bool = False, target: int | None = 34962
    ) -> int:
        whole = kind == "SCALAR"
        # Corners in 16 bits where they fit; the last value is kept for other uses.
        kind_of_corners, component = ("<u2", 5123) if whole and int(values.max()) < 65535 else ("<u4", 5125)
        array = np.ascontiguousarray(values, dtype=kind_of_corners if whole else "<f4")
        content = array.tobytes()
        known = self._known.get((content, kind, target))
        if known is not None:  # shapes of one kind share their corners, and u and v
            return known
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self._binary), "byteLength": array.nbytes}
        if target is not None:
            view["target"] = 34963 if whole else target
        self._binary += content + bytes(-array.nbytes % 4)
        accessor: dict[str, Any] = {
            "bufferView": self._add("bufferViews", view),
            "componentType": component if whole else 5126,
        }
        accessor |= {"count": len(array), "type": kind}
        if bounds:
            accessor |= {"min": [float(x) for x in array.min(axis=0)], "max": [float(x) for x in array.max(axis=0)]}
        self._known[content, kind, target] = self._add("accessors", accessor)
        return self._known[content, kind, target]

    def _add(self, key: str, value: Any) -> int:
        self._lists[key].append(value)
        return len(self._lists[key]) - 1


def _any_up(way: Floats) -> Floats:
    return np.array([0.0, 0.0, -1.0] if np.hypot(way[0], way[2]) < 1e-6 * np.linalg.norm(way) else [0.0, 1.0, 0.0])


def _units(normals: Floats) -> Floats:
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))
