"""Mitsuba 3's XML, the subset that a scene holds: spheres, rectangles, disks, cylinders, meshes of OBJ and PLY, groups and
their instances, bumps; diffuse, dielectric, conductor, our own film; constant and map environments, area lights, lights
without size; perspective and orthographic sensors."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np

from iridesce.arguments.operands import Floats
from iridesce.exchange.films import read_stack
from iridesce.exchange.importers.common import (
    MOST_BYTES,
    Import,
    checked_nm,
    luminance,
    placed,
    plain,
    roughened,
    spot_angles,
)
from iridesce.exchange.importers.materialx import _float, parsed
from iridesce.files.whole import read_whole

_IORS = {"vacuum": 1.0, "air": "air", "water": "water", "bk7": "N-BK7", "diamond": "diamond", "acrylic glass": "PMMA"}
_MESHES = ("obj", "ply")  # kinds of shapes that a file holds
_METALS = ("Ag", "Al", "Au", "Cr", "Cu", "W", "V", "Ti", "Ni", "Pt")


def read_mitsuba(label: str) -> Import:
    """Objects, lights and camera of a scene."""
    root = parsed(read_whole(label, MOST_BYTES, "no scene here has"), label)
    if root.tag != "scene":
        raise ValueError(f"{label}: no scene of Mitsuba, its root is <{root.tag}>")
    return _Reader(root, label).read()


class _Reader:
    def __init__(self, root: ET.Element, label: str) -> None:
        self.root, self.label = root, label
        self.found = Import(unit="m")
        self.named = {one.get("id"): one for one in root.iter("bsdf") if one.get("id")}
        self.groups = {one.get("id"): one for one in root.iter("shape") if one.get("type") == "shapegroup"}
        self.instances: dict[str, list[Floats]] = {}
        self.defaults = {one.get("name"): one.get("value") for one in root.findall("default")}

    def read(self) -> Import:
        for number, element in enumerate(self.root):
            kind = element.get("type", "")
            if element.tag == "shape" and kind == "instance":
                self._instance(element, number)
            elif element.tag == "shape" and kind != "shapegroup":
                self._shape(element, kind, number)
            elif element.tag == "emitter":
                self._emitter(element, kind)
            elif element.tag == "sensor":
                self._sensor(element, kind)
            elif element.tag in ("medium", "include", "volume"):
                self.found.leave_out(f"<{element.tag}>")
        for ident, placements in self.instances.items():
            for number, element in enumerate(self.groups[ident].findall("shape")):
                self._shape(element, element.get("type", ""), number, np.stack(placements))
        return self.found

    def _instance(self, element: ET.Element, number: int) -> None:
        inside = element.find("ref")
        ident = (inside.get("id") if inside is not None else None) or ""
        if ident not in self.groups:
            self.found.leave_out(f"instance-{number}: the group {ident!r}, which is not there")
            return
        self.instances.setdefault(ident, []).append(self._transform(element, "to_world"))

    def _shape(self, element: ET.Element, kind: str, number: int, instances: Floats | None = None) -> None:
        name = plain(element.get("id"), f"{kind}-{number}")
        extra: dict[str, Any] = {}
        matrix = self._transform(element, "to_world")
        shape = self._mesh(element, kind, name) if kind in _MESHES else self._solid(element, kind, name, matrix)
        if shape is None:
            return
        placements = np.eye(4)[None] if instances is None else instances
        if kind in _MESHES:
            placements = placements @ matrix
        # Mitsuba's textures count v from the top of a picture; files of OBJ are turned as they are read.
        is_turned = kind in _MESHES and self._flag(element, "flip_tex_coords", kind == "obj")
        if kind in (*_MESHES, "rectangle") and not is_turned:
            extra = {"uv": {"scale": [1.0, -1.0], "offset": [0.0, 1.0]}}
        glow = next((one for one in element.findall("emitter") if one.get("type") == "area"), None)
        surface = {"emitter": self._light(glow)} if glow is not None else self._surface(element, name)
        bump = None if glow is not None else self._bump(element, name)
        item = {"name": name, "shape": shape, "surface": surface, **({} if bump is None else {"bump": bump})}
        if _has_map(item):
            if kind in ("sphere", "cylinder", "disk"):
                self.found.leave_out(f"{name}: how Mitsuba lays maps over a {kind}; they lie as a scene lays them")
            item |= extra
        made = placed(item, placements[:, :3], self.found)
        if made is not None:
            self.found.objects.append(made)

    def _mesh(self, element: ET.Element, kind: str, name: str) -> dict[str, Any] | None:
        file = self._file(element)
        if file is None:
            self.found.leave_out(f"{name}: its {kind} file, which does not lie beside this one")
            return None
        for key in ("flip_normals", "face_normals"):
            # Faces without normals are flat in a scene as they are.
            if self._flag(element, key, False) and not (key == "face_normals" and self._is_flat(file)):
                self.found.leave_out(f"{name}: {key}")
        return {"mesh": {"file": file}}

    def _solid(self, element: ET.Element, kind: str, name: str, matrix: Floats) -> dict[str, Any] | None:
        """A shape that a formula describes, where `matrix` puts it; None, said in the report, for what a scene has none of."""
        turn, middle = matrix[:3, :3], matrix[:3, 3]
        scale = np.linalg.norm(turn, axis=0)
        is_squeezed = np.ptp(scale) > 1e-6 * scale.max()
        if kind == "sphere":
            if is_squeezed:
                self.found.leave_out(f"{name}: a sphere that is squeezed; it is round")
            center = turn @ self._point(element, "center", [0.0, 0.0, 0.0]) + middle
            radius = self._number(element, "radius", 1.0) * float(scale.mean())
            return {"sphere": {"center": center.tolist(), "radius": radius}}
        if kind == "rectangle":
            return {"rectangle": {"center": middle.tolist(), "u": turn[:, 0].tolist(), "v": turn[:, 1].tolist()}}
        if kind == "disk":
            normal = np.cross(turn[:, 0], turn[:, 1])
            return {
                "disk": {
                    "center": middle.tolist(),
                    "normal": normal.tolist(),
                    "radius": float(np.linalg.norm(turn[:, 0])),
                }
            }
        if kind == "cylinder":
            ends = [turn @ self._point(element, key, at) + middle for key, at in _ENDS]
            axis = ends[1] - ends[0]
            if is_squeezed or not np.linalg.norm(axis) > 0.0:
                self.found.leave_out(f"{name}: a cylinder that is squeezed")
                return None
            return {
                "cylinder": {
                    "center": (0.5 * (ends[0] + ends[1])).tolist(),
                    "axis": axis.tolist(),
                    "radius": self._number(element, "radius", 1.0) * float(scale.mean()),
                    "height": float(np.linalg.norm(axis)),
                }
            }
        self.found.leave_out(f"{name}: the shape {kind}")
        return None

    def _file(self, element: ET.Element) -> str | None:
        """The file that a shape or a texture names, where it lies beside this one or below."""
        name = next((one.get("value", "") for one in element.findall("string") if one.get("name") == "filename"), "")
        folder = Path(self.label).parent.resolve()
        path = (folder / name).resolve()
        if not name or not path.is_relative_to(folder) or not path.is_file():
            return None
        return path.relative_to(folder).as_posix()

    def _flag(self, element: ET.Element, name: str, otherwise: bool) -> bool:
        value = next((one.get("value") for one in element.findall("boolean") if one.get("name") == name), None)
        return otherwise if value is None else value == "true"

    def _is_flat(self, file: str) -> bool:
        """Whether a PLY or OBJ file has no normals of its own."""
        content = read_whole(str(Path(self.label).parent / file), 2**31, "no mesh here has")
        if file.lower().endswith(".ply"):
            head = content[: content.find(b"end_header")]
            return not any(line.split()[-1:] == [b"nx"] for line in head.splitlines())
        return not any(line.startswith(b"vn ") for line in content.splitlines())

    def _bump(self, element: ET.Element, name: str) -> dict[str, Any] | None:
        """The bump around a material, where its texture is a file."""
        bsdf = self._outermost(element)
        while bsdf is not None and bsdf.get("type") in ("twosided", "bumpmap"):
            if bsdf.get("type") == "bumpmap":
                texture = bsdf.find("texture")
                file = None if texture is None or texture.get("type") != "bitmap" else self._file(texture)
                if file is None:
                    self.found.leave_out(f"{name}: its bump, whose texture is no file beside this one")
                    return None
                return {"map": file, "height": self._number(bsdf, "scale", 1.0)}
            bsdf = bsdf.find("bsdf")
        return None

    def _outermost(self, element: ET.Element) -> ET.Element | None:
        bsdf, reference = element.find("bsdf"), element.find("ref")
        if bsdf is None and reference is not None:
            return self.named.get(reference.get("id"))
        return bsdf

    def _surface(self, element: ET.Element, name: str) -> dict[str, Any]:
        bsdf = self._outermost(element)
        while bsdf is not None and bsdf.get("type") in ("twosided", "mask", "bumpmap", "normalmap"):
            if bsdf.get("type") not in ("twosided", "bumpmap"):
                self.found.leave_out(f"{name}: the {bsdf.get('type')} around its material")
            bsdf = bsdf.find("bsdf")
        kind = "diffuse" if bsdf is None else bsdf.get("type", "")
        if bsdf is None:
            return {"diffuse": {"reflectance": 0.5}}
        if kind in ("dielectric", "thindielectric", "roughdielectric"):
            if kind == "thindielectric":
                self.found.leave_out(f"{name}: {kind}: it is a smooth face")
            surface = {"dielectric": {"medium": self._ior(bsdf, "int_ior", "bk7", name)}}
            return roughened(surface, self._roughness(bsdf, name) if kind == "roughdielectric" else 0.0)
        if kind in ("conductor", "roughconductor"):
            return roughened(
                self._conductor(bsdf, name), self._roughness(bsdf, name) if kind == "roughconductor" else 0.0
            )
        if kind == "iridesce_film":
            return self._film(bsdf, name)
        if kind != "diffuse":
            self.found.leave_out(f"{name}: the material {kind}; grey of 0.5 stands for it")
            return {"diffuse": {"reflectance": 0.5}}
        return {"diffuse": {"reflectance": self._reflectance(bsdf, name)}}

    def _roughness(self, bsdf: ET.Element, name: str) -> Any:
        """Facets of the same alpha, which a scene counts as roughness^2."""
        kind = next(
            (one.get("value") for one in bsdf.findall("string") if one.get("name") == "distribution"), "beckmann"
        )
        if kind != "ggx":
            self.found.leave_out(f"{name}: facets spread as {kind}; GGX of the same alpha stands for them")
        for one in bsdf.findall("texture"):
            if (one.get("name") or "").startswith("alpha"):
                self.found.leave_out(f"{name}: the map of its roughness; alpha 0.1 stands for it")
        alpha = self._number(bsdf, "alpha", 0.1)
        along = [min(max(self._number(bsdf, key, alpha), 0.0), 1.0) ** 0.5 for key in ("alpha_u", "alpha_v")]
        return along[0] if along[0] == along[1] else along

    def _film(self, bsdf: ET.Element, name: str) -> dict[str, Any]:
        value = next((one.get("value") for one in bsdf.findall("float") if one.get("name") == "thickness_nm"), None)
        texture = next((one for one in bsdf.findall("texture") if one.get("name") == "thickness_nm"), None)
        file = None if texture is None else self._file(texture)
        nm: Any = 320.0
        if value is not None:
            nm = checked_nm(self.found, self.label, name, self._text_number(value), "nm")
        elif file is not None and file.lower().endswith(".exr"):
            nm = {"map": file}
        else:
            self.found.leave_out(f"{name}: the map of its thickness; 320 nm stands for it")
        surface = _film_of(self._string(bsdf, "stack"), nm)
        if surface is None:
            self.found.leave_out(f"{name}: what the film is made of: its table holds spectra; soap stands for it")
            surface = {"film": {"medium": "soap", "thickness_nm": nm}}
        if any(one.get("name") == "alpha" for one in bsdf.findall("texture")):
            self.found.leave_out(f"{name}: the map of its roughness; alpha 0.1 stands for it")
            return roughened(surface, 0.1**0.5)
        along = [min(max(self._number(bsdf, key, 0.0), 0.0), 1.0) ** 0.5 for key in ("alpha_u", "alpha_v")]
        return roughened(surface, (along[0] if along[0] == along[1] else along) if max(along) > 0.0 else 0.0)

    def _string(self, element: ET.Element, name: str) -> str:
        return next((one.get("value", "") for one in element.findall("string") if one.get("name") == name), "")

    def _conductor(self, bsdf: ET.Element, name: str) -> dict[str, Any]:
        material = next((one.get("value") for one in bsdf.findall("string") if one.get("name") == "material"), None)
        if material in _METALS:
            return {"metal": {"medium": material}}
        parts = {
            one.get("name"): one.get("value", "")
            for one in [*bsdf.findall("spectrum"), *bsdf.findall("float"), *bsdf.findall("rgb")]
        }
        if "eta" in parts and "k" in parts:
            index = [self._middle(parts[key], name) for key in ("eta", "k")]
            self.found.leave_out(
                f"{name}: the course of n and k; those nearest 550 nm stand for it, {index[0]:g} + {index[1]:g}i"
            )
            if index[1] > 0.0:
                return {"metal": {"medium": index}}
        self.found.leave_out(f"{name}: the conductor {material!r}; aluminium stands for it")
        return {"metal": {"medium": "Al"}}

    def _middle(self, text: str, name: str) -> float:
        pairs = [word.split(":") for word in text.replace(",", " ").split()]
        if any(len(pair) == 2 for pair in pairs):
            best = min(pairs, key=lambda pair: abs(_float(pair[0], self.label, name) - 550.0))
            return _float(best[-1], self.label, name)
        return self._text_number(pairs[len(pairs) // 2][0] if pairs else "")

    def _ior(self, bsdf: ET.Element, key: str, otherwise: str, name: str) -> Any:
        for one in [*bsdf.findall("float"), *bsdf.findall("string")]:
            if one.get("name") == key:
                value = one.get("value", "")
                if one.tag == "string":
                    if value not in _IORS:
                        self.found.leave_out(f"{name}: the medium {value!r}; N-BK7 stands for it")
                    return _IORS.get(value, "N-BK7")
                return self._text_number(value)
        return _IORS[otherwise]

    def _reflectance(self, bsdf: ET.Element, name: str) -> Any:
        for one in bsdf:
            if one.get("name") == "reflectance":
                words = one.get("value", "").replace(",", " ").split()
                if one.tag in ("spectrum", "float") and len(words) == 1 and ":" not in words[0]:
                    return min(max(self._text_number(words[0]), 0.0), 1.0)
                if one.tag == "rgb" and len(words) == 3:
                    return [min(max(self._text_number(word), 0.0), 1.0) for word in words]
                file = next((s.get("value", "") for s in one.findall("string") if s.get("name") == "filename"), "")
                path = Path(self.label).parent / file
                if one.tag == "texture" and one.get("type") == "bitmap" and file and path.is_file():
                    return {"map": file}
                self.found.leave_out(f"{name}: the map or spectrum of its reflectance; 0.5 stands for it")
        return 0.5

    def _emitter(self, element: ET.Element, kind: str) -> None:
        if kind == "constant":
            self.found.lights.append({"environment": self._light(element)})
        elif kind == "envmap":
            name = next(
                (one.get("value", "") for one in element.findall("string") if one.get("name") == "filename"), ""
            )
            path = Path(self.label).parent / name
            if not name or not path.is_file():
                self.found.leave_out(f"the environment {name!r}, which is not there")
                return
            self.found.lights.append({"environment": {"map": name, "radiance": self._number(element, "scale", 1.0)}})
        elif kind in ("directional", "point", "spot"):
            self._lamp(element, kind)
        else:
            self.found.leave_out(f"the light {kind}")

    def _lamp(self, element: ET.Element, kind: str) -> None:
        """A light without size."""
        key = "irradiance" if kind == "directional" else "intensity"
        light = self._light(element, key)
        matrix = self._transform(element, "to_world")
        keys: dict[str, Any] = {"illuminant": light["illuminant"], key: light["radiance"]}
        if kind == "directional":
            given = next((one for one in element.findall("vector") if one.get("name") == "direction"), None)
            ahead = matrix[:3, 2]
            if given is not None:
                text = given.get("value")
                ahead = np.array(
                    [self._text_number(given.get(axis, "0")) for axis in "xyz"] if text is None else self._three(text)
                )
            keys["direction"] = (0.0 - ahead / np.linalg.norm(ahead)).tolist()
        else:
            place = matrix[:3, 3] + self._point(element, "position", [0.0, 0.0, 0.0])
            keys["position"] = place.tolist()
        if kind == "spot":
            keys["target"] = (place + matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])).tolist()
            outer = self._number(element, "cutoff_angle", 20.0)
            keys |= spot_angles(self._number(element, "beam_width", 0.75 * outer), outer)
        self.found.lights.append({kind: keys})

    def _light(self, element: ET.Element, key: str = "radiance") -> dict[str, Any]:
        for one in element:
            if one.get("name") != key:
                continue
            value = one.get("value", "")
            words = value.replace(",", " ").split()
            if one.tag == "spectrum" and (one.get("type") == "d65" or ":" in value):
                if ":" in value:
                    self.found.leave_out("the course of a lamp's spectrum; D65 of radiance 1 stands for it")
                scale = next((s.get("value", "1") for s in one.findall("float") if s.get("name") == "scale"), "1")
                return {"illuminant": "D65", "radiance": self._text_number(scale)}
            if len(words) == 1:
                return {"illuminant": "D65" if one.tag == "rgb" else "E", "radiance": self._text_number(words[0])}
            if len(words) == 3:
                self.found.leave_out("the colour of a lamp; D65 of the same luminance stands for it")
                return {"illuminant": "D65", "radiance": luminance([self._text_number(word) for word in words])}
        return {"illuminant": "D65", "radiance": 1.0}

    def _sensor(self, element: ET.Element, kind: str) -> None:
        if self.found.camera or kind not in ("perspective", "thinlens", "orthographic"):
            self.found.leave_out(f"the sensor {kind}")
            return
        matrix = self._transform(element, "to_world")
        eye, ahead, up = matrix[:3, 3], matrix[:3, 2], matrix[:3, 1]
        film = element.find("film")
        width, height = 768, 576
        if film is not None:
            width, height = (
                int(self._number(film, key, size, "integer")) for key, size in (("width", 768), ("height", 576))
            )
        distance = max(float(np.linalg.norm(eye)), 1.0)
        camera: dict[str, Any] = {
            "position": eye.tolist(),
            "target": (eye + ahead / np.linalg.norm(ahead) * distance).tolist(),
            "up": (up / np.linalg.norm(up)).tolist(),
            "resolution": [width, height],
        }
        if kind == "orthographic":
            camera["orthographic_height"] = 2.0 * float(np.linalg.norm(up))
        else:
            fov = self._number(element, "fov", 50.0)
            axis = next((one.get("value") for one in element.findall("string") if one.get("name") == "fov_axis"), "x")
            along_y = axis == "y" or (axis == "smaller" and height <= width) or (axis == "larger" and height > width)
            tall = np.tan(0.5 * np.radians(fov)) * (1.0 if along_y else height / width)
            camera["fov_deg"] = float(np.degrees(2.0 * np.arctan(tall)))
        if kind == "thinlens":
            self.found.leave_out("the lens of the camera; it is a pinhole")
        self.found.camera = camera

    def _transform(self, element: ET.Element, name: str) -> Floats:
        made = np.eye(4)
        for one in element.findall("transform"):
            if one.get("name") == name:
                for step in one:
                    made = self._step(step) @ made
        return made

    def _step(self, step: ET.Element) -> Floats:
        made = np.eye(4)
        if step.tag == "matrix":
            values = [self._text_number(word) for word in step.get("value", "").replace(",", " ").split()]
            if len(values) != 16:
                raise ValueError(f"{self.label}: a matrix has 16 numbers, got {len(values)}")
            return np.array(values).reshape(4, 4)
        if step.tag == "lookat":
            eye, target, up = (np.array(self._three(step.get(key, ""))) for key in ("origin", "target", "up"))
            ahead = (target - eye) / np.linalg.norm(target - eye)
            left = np.cross(up, ahead) / np.linalg.norm(np.cross(up, ahead))
            made[:3, 0], made[:3, 1], made[:3, 2], made[:3, 3] = left, np.cross(ahead, left), ahead, eye
            return made
        if step.get("value") is not None:
            vector = self._three(step.get("value", ""))
        else:
            absent = "1" if step.tag == "scale" else "0"
            vector = [self._text_number(step.get(axis, absent)) for axis in "xyz"]
        if step.tag == "translate":
            made[:3, 3] = vector
        elif step.tag == "scale":
            made[:3, :3] = np.diag(vector)
        elif step.tag == "rotate":
            axis = np.array(vector) / np.linalg.norm(vector)
            angle = np.radians(self._text_number(step.get("angle", "0")))
            cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
            made[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
        else:
            self.found.leave_out(f"the transform {step.tag}")
        return made

    def _point(self, element: ET.Element, name: str, otherwise: list[float]) -> Floats:
        for one in element.findall("point"):
            if one.get("name") == name:
                if one.get("value") is not None:
                    return np.array(self._three(one.get("value", "")))
                return np.array([self._text_number(one.get(axis, "0")) for axis in "xyz"])
        return np.array(otherwise)

    def _number(self, element: ET.Element, name: str, otherwise: float, tag: str = "float") -> float:
        value = next((one.get("value") for one in element.findall(tag) if one.get("name") == name), None)
        return otherwise if value is None else self._text_number(value)

    def _three(self, text: str) -> list[float]:
        words = text.replace(",", " ").split()
        values = [self._text_number(word) for word in words]
        if len(values) == 1:
            return values * 3
        if len(values) != 3:
            raise ValueError(f"{self.label}: three numbers were wanted, got {text!r:.60}")
        return values

    def _text_number(self, text: str) -> float:
        if text.startswith("$"):
            text = self.defaults.get(text[1:]) or text
        return _float(text, self.label, "a value")


_ENDS = (("p0", [0.0, 0.0, 0.0]), ("p1", [0.0, 0.0, 1.0]))


def _has_map(item: dict[str, Any]) -> bool:
    ((_, keys),) = item["surface"].items()
    named = (
        keys.get("reflectance"),
        keys.get("thickness_nm"),
        *(one["thickness_nm"] for one in keys.get("layers", ())),
    )
    return "bump" in item or any(isinstance(one, dict) and "map" in one for one in named)


def _film_of(text: str, nm: Any) -> dict[str, Any] | None:
    """The surface of a stack in words, whose open thickness is nm; ``None`` for words that are none."""
    try:
        stack, layer = read_stack(text)
    except ValueError:
        return None
    if layer is None or not all(one.coherent for one in stack.layers):
        return None
    media = [_medium(one) for one in stack.media]
    if stack.first == stack.last and len(stack.layers) == 1:
        return {"film": {"medium": media[1], "thickness_nm": nm, "outside": media[0]}}
    if stack.first.name not in ("air", "vacuum"):
        return None
    thicknesses = [
        nm if number == layer else float(one._thickness.values.flat[0]) for number, one in enumerate(stack.layers)
    ]
    layers = [{"medium": one, "thickness_nm": t} for one, t in zip(media[1:-1], thicknesses, strict=True)]
    return {"coating": {"layers": layers, "substrate": media[-1]}}


def _medium(medium: Any) -> Any:
    index = medium._core.constant_index
    if index is None or medium.name in ("air", "vacuum"):
        return medium.name
    return index[0] if index[1] == 0.0 else list(index)
