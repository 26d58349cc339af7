"""glTF 2.0 with KHR_materials_iridescence. Meshes that are spheres or flat become shapes; others stay in the file."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.exchange.importers.common import (
    MOST_BYTES,
    Import,
    checked_nm,
    film_surface,
    index_of_f0,
    luminance,
    placed,
    plain,
    roughened,
    spot_angles,
)
from iridesce.exchange.importers.shapes import on_chart, shape_of
from iridesce.files.whole import read_whole

_KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_DEEPEST = 64


def read_gltf(label: str) -> Import:
    """Objects, camera and what was left out."""
    content = read_whole(label, MOST_BYTES, "no glTF here has")
    binary: bytes | None = None
    if content[:4] == b"glTF":
        content, binary = _chunks(content, label)
    try:
        root = json.loads(content)
        if not isinstance(root, dict) or not isinstance(root.get("asset"), dict):
            raise ValueError("no asset")
    except ValueError as error:
        raise ValueError(f"{label}: no glTF ({error})") from None
    try:
        return _Reader(root, label, binary).read()
    except (KeyError, IndexError, TypeError, AttributeError, struct.error, np.exceptions.AxisError) as error:
        raise ValueError(f"{label}: damaged glTF ({type(error).__name__}: {error})") from None


def _chunks(content: bytes, label: str) -> tuple[bytes, bytes | None]:
    try:
        _, version, length = struct.unpack_from("<4sII", content)
        size, kind = struct.unpack_from("<I4s", content, 12)
        if version != 2 or kind != b"JSON" or length > len(content):
            raise ValueError(f"{label}: no GLB of version 2, or cut short")
        text, place = content[20 : 20 + size], 20 + size
        if place + 8 <= length:
            size, kind = struct.unpack_from("<I4s", content, place)
            if kind == b"BIN\0":
                return text, content[place + 8 : place + 8 + size]
        return text, None
    except struct.error:
        raise ValueError(f"{label}: no GLB of version 2, or cut short") from None


class _Reader:
    def __init__(self, root: dict[str, Any], label: str, binary: bytes | None) -> None:
        self.root, self.label, self.binary = root, label, binary
        self.found = Import(unit="m")
        # Where each primitive of a mesh is put, and under which name first.
        self.uses: dict[tuple[int, int], tuple[str, list[Floats]]] = {}
        self.met: set[int] = set()

    def read(self) -> Import:
        root = self.root
        for name in root.get("extensionsRequired", []):
            if name not in _KNOWN:
                self.found.leave_out(f"the required extension {name}")
        if root.get("scenes"):
            roots = root["scenes"][root.get("scene", 0)].get("nodes", [])
        else:
            below = {child for node in root["nodes"] for child in node.get("children", [])}
            roots = [number for number in range(len(root["nodes"])) if number not in below] or (root["nodes"] and [0])
        for number in roots:
            self._node(number, np.eye(4), 0)
        for (mesh, index), (name, matrices) in self.uses.items():
            if len(matrices) > 1:  # the first of many nodes does not name them all
                name = plain(root["meshes"][mesh].get("name"), name) + (f"-{index}" if index else "")
            self._primitive(name, mesh, index, np.stack(matrices)[:, :3])
        if root.get("animations"):
            self.found.leave_out("animations")
        return self.found

    def _node(self, number: int, above: Floats, depth: int) -> None:
        if depth > _DEEPEST:
            raise ValueError(f"{self.label}: nodes are nested more than {_DEEPEST} deep, or in a circle")
        if number in self.met:
            raise ValueError(f"{self.label}: node {number} hangs below two others, or in a circle")
        self.met.add(number)
        node = self.root["nodes"][number]
        matrix = above @ _matrix(node)
        name = plain(node.get("name"), f"node-{number}")
        if "mesh" in node:
            for index in range(len(self.root["meshes"][node["mesh"]]["primitives"])):
                own = name if index == 0 else f"{name}-{index}"
                uses = self.uses.setdefault((node["mesh"], index), (own, []))[1]
                uses += [matrix @ each for each in self._instances(node)]
        if "camera" in node and not self.found.camera:
            self._camera(self.root["cameras"][node["camera"]], matrix)
        if "KHR_lights_punctual" in node.get("extensions", {}):
            number = node["extensions"]["KHR_lights_punctual"]["light"]
            self._light(name, self.root["extensions"]["KHR_lights_punctual"]["lights"][number], matrix)
        for child in node.get("children", []):
            self._node(child, matrix, depth + 1)

    def _instances(self, node: dict[str, Any]) -> list[Floats]:
        """What EXT_mesh_gpu_instancing says; once without it."""
        extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
        if extension is None:
            return [np.eye(4)]
        parts = {key: self._accessor(number) for key, number in extension["attributes"].items()}
        count = max((len(values) for values in parts.values()), default=0)
        moves = parts.get("TRANSLATION", np.zeros((count, 3)))
        turns = parts.get("ROTATION", np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)))
        scales = parts.get("SCALE", np.ones((count, 3)))
        if not len(moves) == len(turns) == len(scales):
            raise ValueError(f"{self.label}: EXT_mesh_gpu_instancing with lists of different lengths")
        return [
            _matrix({"translation": move, "rotation": turn, "scale": scale})
            for move, turn, scale in zip(moves, turns, scales, strict=True)
        ]

    def _primitive(self, name: str, mesh: int, index: int, placements: Floats) -> None:
        """A shape where it is one, else that part of the file as a mesh; once, or as instances."""
        primitive = self.root["meshes"][mesh]["primitives"][index]
        if primitive.get("mode", 4) not in (4, 5, 6):
            self.found.leave_out(f"{name}: points and lines")
            return
        if primitive.get("targets"):
            self.found.leave_out(f"{name}: its morph targets")
        points = self._accessor(primitive["attributes"]["POSITION"])
        uv = None
        if "TEXCOORD_0" in primitive["attributes"]:
            uv = self._accessor(primitive["attributes"]["TEXCOORD_0"])
            uv = np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=1)
        material = self.root["materials"][primitive["material"]] if "material" in primitive else {}
        mapped = _is_mapped(material)
        shape, where = None, placements
        if len(placements) == 1:
            there = points @ placements[0, :, :3].T + placements[0, :, 3]
            shape, where = self._shape(there, uv, mapped), np.eye(4)[None, :3]
        if shape is None:
            shape, where = self._shape(points, uv, mapped), placements
        if shape is None:
            shape = {"mesh": {"file": Path(self.label).name, "part": f"/meshes/{mesh}/primitives/{index}"}}
        surface = self._surface(name, material, uv is not None)
        item = placed({"name": name, "shape": shape, "surface": surface}, where, self.found)
        if item is not None:
            self.found.objects.append(item)

    def _shape(self, points: Floats, uv: Floats | None, mapped: bool) -> dict[str, Any] | None:
        """The shape that points lie on; with maps on it only if they lie there as they do on a shape of ours."""
        shape = shape_of(points)
        if shape is None or uv is None:
            return None if mapped else shape
        own = on_chart(shape, points, uv)
        return own if own is not None or mapped else shape

    def _surface(self, name: str, material: dict[str, Any], has_uv: bool) -> dict[str, Any]:
        extensions = material.get("extensions", {})
        surface = material.get("pbrMetallicRoughness", {})
        color = [float(x) for x in surface.get("baseColorFactor", [1, 1, 1, 1])][:3]
        metal, rough = float(surface.get("metallicFactor", 1.0)), float(surface.get("roughnessFactor", 1.0))
        ior = float(extensions.get("KHR_materials_ior", {}).get("ior", 1.5))
        clear = float(extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0))
        film = extensions.get("KHR_materials_iridescence")
        for key in ("normalTexture", "occlusionTexture", "emissiveTexture"):
            if key in material:
                self.found.leave_out(f"{name}: {key}")
        for key in sorted(set(extensions) - _KNOWN):
            self.found.leave_out(f"{name}: the extension {key}")
        roughness = self._roughness(name, surface, extensions, rough)
        emitted = [float(x) for x in material.get("emissiveFactor", [0, 0, 0])]
        strength = float(extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0))
        if max(emitted) > 0.0:
            if max(emitted) - min(emitted) > 0.05 * max(emitted):
                self.found.leave_out(f"{name}: the colour of its glow; it is that of D65")
            return {"emitter": {"illuminant": "D65", "radiance": strength * luminance(emitted)}}
        if film is not None and float(film.get("iridescenceFactor", 0.0)) > 0.0:
            self._no_picture(name, surface)
            return roughened(self._film(name, film, color, metal, ior, clear, has_uv), roughness)
        if metal > 0.5:
            self.found.leave_out(f"{name}: a metal by its colour; a clear medium of the same reflectance stands for it")
            self._no_picture(name, surface)
            return roughened({"coating": {"layers": [], "substrate": index_of_f0(sum(color) / 3.0)}}, roughness)
        if clear > 0.5:
            self._no_picture(name, surface)
            return roughened({"dielectric": {"medium": max(ior, 1.0 + 1e-6)}}, roughness)
        picture = self._picture(name, surface, color) if has_uv else None
        if picture is not None:
            return {"diffuse": {"reflectance": {"map": picture}}}
        return {"diffuse": {"reflectance": [min(max(x, 0.0), 1.0) for x in color]}}

    def _no_picture(self, name: str, surface: dict[str, Any]) -> None:
        if "baseColorTexture" in surface:
            self.found.leave_out(f"{name}: baseColorTexture")

    def _picture(self, name: str, surface: dict[str, Any], color: list[float]) -> str | None:
        """The file of a matt surface's colours."""
        if "baseColorTexture" not in surface:
            return None
        path = self._image(surface["baseColorTexture"])
        if path is None or path.suffix.lower() not in (".png", ".jpg", ".jpeg"):
            self.found.leave_out(f"{name}: baseColorTexture inside the file, or no PNG or JPEG beside it")
            return None
        if min(color) < 1.0:
            self.found.leave_out(f"{name}: the factor {color} on its baseColorTexture")
        return path.relative_to(Path(self.label).parent.resolve()).as_posix()

    def _roughness(self, name: str, surface: dict[str, Any], extensions: dict[str, Any], rough: float) -> Any:
        """A number, or two along u and v; 0 for a mirror."""
        rough = min(max(rough, 0.0), 1.0)
        if "metallicRoughnessTexture" in surface and rough > 0.0:
            rough = self._mean_roughness(name, surface["metallicRoughnessTexture"], rough)
        brushed = extensions.get("KHR_materials_anisotropy")
        if brushed is None:
            return rough
        strength = min(max(float(brushed.get("anisotropyStrength", 0.0)), 0.0), 1.0)
        turn = float(brushed.get("anisotropyRotation", 0.0)) % np.pi
        along = float(np.sqrt(rough**2 + (1.0 - rough**2) * strength**2))
        if "anisotropyTexture" in brushed:
            self.found.leave_out(f"{name}: anisotropyTexture")
        upright = abs(turn - 0.5 * np.pi) < 0.25 * np.pi
        if min(abs(turn - at) for at in (0.0, 0.5 * np.pi, np.pi)) > 1e-3:
            self.found.leave_out(f"{name}: anisotropyRotation {turn:g}; it is brushed along {'v' if upright else 'u'}")
        return [rough, along] if upright else [along, rough]

    def _mean_roughness(self, name: str, texture: dict[str, Any], factor: float) -> float:
        """A scene's map is grey, glTF's has metalness beside: its mean is taken."""
        from iridesce.exchange import png

        path = self._image(texture)
        try:
            if path is None:
                raise ValueError("it is not beside the file")
            values = png.read_png(read_whole(str(path), MOST_BYTES, "no map has"), path.name)
        except ValueError as error:
            self.found.leave_out(f"{name}: the map of its roughness ({error}); its factor, {factor:g}, is taken")
            return factor
        mean = factor * float((values.values[..., min(1, values.values.shape[2] - 1)] / values.peak).mean())
        self.found.leave_out(f"{name}: the map of its roughness; its mean, {mean:.3g}, stands for it")
        return mean

    def _image(self, texture: dict[str, Any]) -> Path | None:
        """The file of a texture, where it lies beside this one."""
        image = self.root["images"][self.root["textures"][texture["index"]]["source"]]
        uri = image.get("uri", "")
        folder = Path(self.label).parent.resolve()
        if not uri or uri.startswith("data:"):
            return None
        path = _beside(folder, uri)
        return path if path.is_relative_to(folder) and path.is_file() else None

    def _light(self, name: str, light: dict[str, Any], matrix: Floats) -> None:
        kind, strength = light["type"], float(light.get("intensity", 1.0))
        colors = [float(x) for x in light.get("color", [1.0, 1.0, 1.0])]
        if max(colors) - min(colors) > 0.01:
            self.found.leave_out(f"{name}: the colour of its light; it is that of D65")
        strength *= luminance(colors)
        back = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
        place = matrix[:3, 3]
        if "range" in light:
            self.found.leave_out(f"{name}: the range of its light; it reaches everywhere")
        if kind == "directional":
            keys: dict[str, Any] = {"direction": back.tolist(), "irradiance": strength}
        elif kind == "point":
            keys = {"position": place.tolist(), "intensity": strength}
        elif kind == "spot":
            cone = light.get("spot", {})
            inner = np.degrees(float(cone.get("innerConeAngle", 0.0)))
            outer = np.degrees(float(cone.get("outerConeAngle", 0.25 * np.pi)))
            keys = {"position": place.tolist(), "target": (place - back).tolist(), "intensity": strength}
            keys |= spot_angles(inner, outer)
        else:
            self.found.leave_out(f"{name}: the light {kind!r}")
            return
        if not 0.0 < strength < np.inf:
            self.found.leave_out(f"{name}: a light of strength {strength:g}")
            return
        self.found.lights.append({kind: {**keys, "illuminant": "D65"}})

    def _film(
        self,
        name: str,
        film: dict[str, Any],
        color: list[float],
        metal: float,
        ior: float,
        clear: float,
        has_uv: bool,
    ) -> dict[str, Any]:
        if float(film["iridescenceFactor"]) < 1.0 or "iridescenceTexture" in film:
            self.found.leave_out(f"{name}: a film that is there in part")
        low = float(film.get("iridescenceThicknessMinimum", 100.0))
        high = float(film.get("iridescenceThicknessMaximum", 400.0))
        index = float(film.get("iridescenceIor", 1.3))
        if not 1.0 <= index < 10.0:
            raise ValueError(f"{self.label}: {name}: iridescenceIor must be 1 or more, got {index:g}")
        nm: Any = checked_nm(self.found, self.label, name, high, "nm")
        texture = film.get("iridescenceThicknessTexture")
        if texture is not None:
            if max(low, high) > 0.0:
                checked_nm(self.found, self.label, name, max(low, high), "nm")
            if low > high:
                self.found.leave_out(f"{name}: its least thickness is above its greatest, {low:g} > {high:g} nm")
            nm = self._map(name, texture, low, high, has_uv)
        free = clear > 0.5 and abs(ior - 1.0) < 1e-3 and metal < 0.5
        base: Any = max(ior, 1.0)
        if metal > 0.5:
            base = index_of_f0(sum(color) / 3.0)
            self.found.leave_out(
                f"{name}: the metal's k: the file has none; a clear base of the same reflectance stands for it"
            )
        return film_surface(index, nm, base, free)

    def _map(self, name: str, texture: dict[str, Any], low: float, high: float, has_uv: bool) -> Any:
        mean = 0.5 * (low + high)
        path = self._image(texture)
        if path is None or low > high:
            self.found.leave_out(f"{name}: the map of thickness inside the file; {mean:g} nm stands for it")
            return mean
        from iridesce.exchange import png

        try:
            values = png.read_png(read_whole(str(path), MOST_BYTES, "no map has"), str(path))
        except ValueError as error:
            self.found.leave_out(f"{name}: the map of thickness ({error}); {mean:g} nm stands for it")
            return mean
        if low == high:
            return low
        channels = values.values.shape[2]
        if has_uv and texture.get("texCoord", 0) == 0 and "extensions" not in texture and channels != 2:
            file = path.relative_to(Path(self.label).parent.resolve()).as_posix()
            channel = {} if channels == 1 else {"channel": "G"}
            return {"map": file, "min_nm": low, "max_nm": high, **channel}
        value = low + (high - low) * float((values.values[..., min(1, channels - 1)] / values.peak).mean())
        self.found.leave_out(f"{name}: the map of thickness; its mean, {value:g} nm, stands for it")
        return value

    def _camera(self, camera: dict[str, Any], matrix: Floats) -> None:
        eye, back, up = matrix[:3, 3], matrix[:3, 2], matrix[:3, 1]
        view: dict[str, Any] = {
            "position": eye.tolist(),
            "target": (eye - back / np.linalg.norm(back) * max(1.0, float(np.linalg.norm(eye)))).tolist(),
            "up": (up / np.linalg.norm(up)).tolist(),
        }
        if camera["type"] == "perspective":
            view["fov_deg"] = float(np.degrees(camera["perspective"]["yfov"]))
            aspect = float(camera["perspective"].get("aspectRatio", 1.0))
        else:
            view["orthographic_height"] = 2.0 * float(camera["orthographic"]["ymag"])
            aspect = float(camera["orthographic"]["xmag"]) / float(camera["orthographic"]["ymag"])
        view["resolution"] = [max(1, round(512 * aspect)), 512]
        self.found.camera = view

    def _accessor(self, number: int) -> Floats:
        accessor = self.root["accessors"][number]
        if "sparse" in accessor or "bufferView" not in accessor:
            raise ValueError(f"{self.label}: accessor {number} is sparse or empty, which is not read here")
        view = self.root["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(_KINDS[accessor["componentType"]]), _COUNTS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        data = self._buffer(view["buffer"])
        count = accessor["count"]
        if count < 1 or start < 0 or start + stride * (count - 1) + kind.itemsize * width > len(data):
            raise ValueError(f"{self.label}: accessor {number} reaches beyond its buffer")
        flat = np.ndarray((count, width), kind, data, start, (stride, kind.itemsize))
        numbers = flat.astype(np.float64)
        if accessor.get("normalized") and kind.kind in "iu":  # shares of the largest: glTF 2.0, section 3.6.2.2
            numbers = np.maximum(numbers / np.iinfo(kind).max, -1.0)
        return numbers

    def _buffer(self, number: int) -> bytes:
        buffer = self.root["buffers"][number]
        uri = buffer.get("uri")
        if uri is None:
            if self.binary is None:
                raise ValueError(f"{self.label}: buffer {number} is nowhere")
            return self.binary
        if uri.startswith("data:"):
            try:
                return base64.b64decode(uri.partition(",")[2], validate=True)
            except ValueError as error:
                raise ValueError(f"{self.label}: buffer {number}: {error}") from None
        path = _beside(Path(self.label).parent, uri)
        if not path.is_relative_to(Path(self.label).parent.resolve()):
            raise ValueError(f"{self.label}: buffer {number} lies outside the file's folder: {uri!r}")
        return read_whole(str(path), MOST_BYTES, "no buffer here has")


def _beside(folder: Path, uri: str) -> Path:
    """A file that a glTF file names: percent-encoded by the format's rule, which some writers forget."""
    path = (folder / unquote(uri)).resolve()
    return path if path.exists() else (folder / uri).resolve()


_KNOWN = {
    "KHR_mesh_quantization",
    "KHR_materials_iridescence",
    "KHR_materials_transmission",
    "KHR_materials_ior",
    "KHR_materials_emissive_strength",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "EXT_mesh_gpu_instancing",
}


def _is_mapped(material: dict[str, Any]) -> bool:
    """Whether something lies on it by u and v that a scene takes."""
    surface, film = (
        material.get("pbrMetallicRoughness", {}),
        material.get("extensions", {}).get("KHR_materials_iridescence", {}),
    )
    return "baseColorTexture" in surface or "iridescenceThicknessTexture" in film


def _matrix(node: dict[str, Any]) -> Floats:
    if "matrix" in node:
        return np.asarray(node["matrix"], dtype=np.float64).reshape(4, 4).T
    made = np.eye(4)
    x, y, z, w = (float(q) for q in node.get("rotation", [0, 0, 0, 1]))
    made[:3, :3] = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    ) * np.asarray(node.get("scale", [1, 1, 1]), dtype=np.float64)
    made[:3, 3] = node.get("translation", [0, 0, 0])
    return made
