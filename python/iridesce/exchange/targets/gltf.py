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
from iridesce.exchange.geometry import Mesh, Surface, surface_of
from iridesce.exchange.knobs import Knobs, differences, fitted, knobs_of
from iridesce.exchange.package import Package, Request
from iridesce.exchange.scenes import MM, folder_of, plain_name
from iridesce.exchange.surfaces import picture_file, roughness_png, told_camera, told_item, told_spectrum
from iridesce.exchange.textures import laid_out, thickness_png
from iridesce.exchange.twins import gltf as twin

_TAKES = ("film_ior", "base_ior", "f0")


def export_gltf(request: Request) -> Package:
    """``scene.gltf`` (or ``film.gltf``), its ``.bin`` and the maps of thickness."""
    package = Package()
    name = "film" if request.scene is None else "scene"
    document = _Document(f"{name}.bin")
    materials = {film.name: document.material(_material(film, request, package, document)) for film in request.films}
    if request.scene is None:
        film = request.films[0]
        mesh = Surface("sphere", {"center": [0.0, 0.0, 0.0], "radius": 1.0}).mesh()
        document.node({"name": film.name, "mesh": document.mesh(film.name, mesh, materials[film.name])})
        package.note("the material is on a sphere of radius 1 m; take it from there")
    else:
        _scene(request.scene.to_dict(), folder_of(request.scene), materials, document, package)
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


def _material(film: Film, request: Request, package: Package, document: _Document) -> dict[str, Any]:
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
        package.drop(
            f"{film.name}: k of {film.stack.last.name}: the target has no k, and takes the phase of a clear base"
        )
    else:
        material["extensions"]["KHR_materials_ior"] = {"ior": knobs.base_ior}
        material["extensions"]["KHR_materials_transmission"] = {"transmissionFactor": 1.0}
        if film.free:
            material["doubleSided"] = True
    material["pbrMetallicRoughness"] = surface
    _rough(film, material, document, package)
    if film.layer is not None:
        low, high = film.range_nm
        iridescence: dict[str, Any] = {"iridescenceFactor": 1.0, "iridescenceIor": knobs.film_ior}
        if film.varies:
            film = laid_out(film, package)
            file = f"{film.name}_thickness.png"
            thickness_png(film, package, file)
            iridescence["iridescenceThicknessTexture"] = {"index": document.texture(file)}
            iridescence["iridescenceThicknessMinimum"], iridescence["iridescenceThicknessMaximum"] = low, high
        else:
            # Without a texture the maximum alone counts.
            iridescence["iridescenceThicknessMaximum"] = high
            iridescence["iridescenceThicknessMinimum"] = high
        material["extensions"]["KHR_materials_iridescence"] = iridescence
    return material


def _rough(film: Film, material: dict[str, Any], document: _Document, package: Package) -> None:
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
        texture = document.texture(roughness_png(film.name, rough, package))
        surface["metallicRoughnessTexture"] = {"index": texture}
    if strength > 0.0:
        direction = {"anisotropyStrength": strength, "anisotropyRotation": turn}
        material["extensions"]["KHR_materials_anisotropy"] = direction


def _scene(
    tree: Mapping[str, Any], folder: Path, materials: Mapping[str, int], document: _Document, package: Package
) -> None:
    metres = MM[tree["unit"]] / 1000.0
    camera = tree["camera"]
    eye, target, up = (np.asarray(camera[key], dtype=np.float64) for key in ("position", "target", "up"))
    distance = float(np.linalg.norm(eye - target))
    for item in tree["object"]:
        surface = surface_of(item["shape"])
        if surface is None:
            package.drop(f"{item['name']}: the shape {next(iter(item['shape']))} is not written")
            continue
        mesh = surface.mesh(extent=20.0 * distance)
        if surface.kind == "plane":
            package.note(f"{item['name']}: the plane is cut at {20.0 * distance:g} {tree['unit']}")
        told_item(item, package)
        name = plain_name(item["name"])
        material = materials.get(name)
        if material is None:
            material = document.material(_plain_material(name, item["surface"], folder, document, package))
        document.node({"name": name, "mesh": document.mesh(name, _scaled(mesh, metres), material)})
    document.node({"name": "camera", "camera": 0, "matrix": _look(eye * metres, target * metres, up)})
    told_camera(camera, package, lens=False)
    document.root["cameras"] = [_camera(camera, metres, distance)]
    for number, light in enumerate(tree["light"]):
        ((kind, keys),) = light.items()
        document.light(kind, keys, metres, number, package)


def _plain_material(
    name: str, surface: Mapping[str, Any], folder: Path, document: _Document, package: Package
) -> dict[str, Any]:
    ((kind, keys),) = surface.items()
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
                factors["baseColorTexture"] = {"index": document.texture(file, data=False)}
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


def _scaled(mesh: Mesh, factor: float) -> Mesh:
    return Mesh(mesh.positions * factor, mesh.normals, mesh.uv, mesh.triangles)


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
        self._lists: dict[str, list[Any]] = {
            key: [] for key in ("materials", "meshes", "accessors", "bufferViews", "textures", "images", "samplers")
        }
        self._lights: list[dict[str, Any]] = []

    def node(self, node: dict[str, Any]) -> None:
        self._nodes.append(node)

    def material(self, material: dict[str, Any]) -> int:
        self._extensions |= set(material.get("extensions", {}))
        return self._add("materials", {key: value for key, value in material.items() if value != {}})

    def texture(self, file: str, data: bool = True) -> int:
        # Linear without mip-maps: a mean of thicknesses has not the mean of their colours. Clamped. Pictures have both.
        wrap = {"wrapS": 33071, "wrapT": 33071} if data else {"wrapS": 10497, "wrapT": 10497}
        sampler = {"magFilter": 9729, "minFilter": 9729 if data else 9987, **wrap}
        known = self._lists["samplers"]
        number = known.index(sampler) if sampler in known else self._add("samplers", sampler)
        image = self._add("images", {"uri": file})
        return self._add("textures", {"sampler": number, "source": image})

    def mesh(self, name: str, mesh: Mesh, material: int) -> int:
        # glTF counts v from the top.
        uv = np.stack([mesh.uv[:, 0], 1.0 - mesh.uv[:, 1]], axis=1)
        attributes = {
            "POSITION": self._accessor(mesh.positions, "VEC3", bounds=True),
            "NORMAL": self._accessor(mesh.normals, "VEC3"),
            "TEXCOORD_0": self._accessor(uv, "VEC2"),
        }
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
        root = {**self.root, "scenes": [{"nodes": list(range(len(self._nodes)))}], "nodes": self._nodes}
        root |= {key: value for key, value in self._lists.items() if value}
        root["buffers"] = [{"uri": self._name, "byteLength": len(self._binary)}]
        if self._lights:
            root["extensions"] = {"KHR_lights_punctual": {"lights": self._lights}}
        if self._extensions:
            root["extensionsUsed"] = sorted(self._extensions)
        return (json.dumps(root, indent=1, allow_nan=False) + "\n").encode("ascii")

    def buffer(self) -> bytes:
        return bytes(self._binary)

    def _accessor(self, values: np.ndarray[Any, Any], kind: str, bounds: bool = False) -> int:
        whole = kind == "SCALAR"
        array = np.ascontiguousarray(values, dtype="<u4" if whole else "<f4")
        view = {
            "buffer": 0,
            "byteOffset": len(self._binary),
            "byteLength": array.nbytes,
            "target": 34963 if whole else 34962,
        }
        self._binary += array.tobytes()
        accessor: dict[str, Any] = {
            "bufferView": self._add("bufferViews", view),
            "componentType": 5125 if whole else 5126,
        }
        accessor |= {"count": len(array), "type": kind}
        if bounds:
            accessor |= {"min": [float(x) for x in array.min(axis=0)], "max": [float(x) for x in array.max(axis=0)]}
        return self._add("accessors", accessor)

    def _add(self, key: str, value: Any) -> int:
        self._lists[key].append(value)
        return len(self._lists[key]) - 1


def _any_up(way: Floats) -> Floats:
    return np.array([0.0, 0.0, -1.0] if np.hypot(way[0], way[2]) < 1e-6 * np.linalg.norm(way) else [0.0, 1.0, 0.0])
