"""MaterialX: the film of an OpenPBR or Standard Surface, on a ball. Thicknesses: um in OpenPBR, nm in Standard Surface."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

from iridesce.exchange.importers.common import MOST_BYTES, Import, checked_nm, film_surface, index_of_f0, roughened
from iridesce.files.whole import read_whole

_BALL = {"sphere": {"center": [0.0, 0.0, 0.0], "radius": 4.0}}

# Names of the same thing in the two models, the unit of thickness in nm, and defaults.
_MODELS: dict[str, dict[str, Any]] = {
    "open_pbr_surface": {
        "unit": ("um", 1000.0),
        "thickness": ("thin_film_thickness", 0.5),
        "film_ior": ("thin_film_ior", 1.4),
        "weight": ("thin_film_weight", 0.0),
        "metal": ("base_metalness", 0.0),
        "ior": ("specular_ior", 1.5),
        "clear": ("transmission_weight", 0.0),
        "rough": ("specular_roughness", 0.3),
        "thin": "geometry_thin_walled",
    },
    "standard_surface": {
        "unit": ("nm", 1.0),
        "thickness": ("thin_film_thickness", 0.0),
        "film_ior": ("thin_film_IOR", 1.5),
        "weight": None,
        "metal": ("metalness", 0.0),
        "ior": ("specular_IOR", 1.5),
        "clear": ("transmission", 0.0),
        "rough": ("specular_roughness", 0.2),
        "thin": "thin_walled",
    },
}


def read_materialx(label: str) -> Import:
    """One ball for each surface."""
    content = read_whole(label, MOST_BYTES, "no material has")
    root = parsed(content, label)
    if root.tag != "materialx":
        raise ValueError(f"{label}: no MaterialX document, its root is <{root.tag}>")
    found = Import(unit="cm")
    for number, element in enumerate(root.iter()):
        if element.tag in _MODELS:
            _surface(element, root, label, found, number)
        elif element.tag in ("conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf"):
            found.leave_out(f"{element.get('name')}: the node {element.tag}; OpenPBR and Standard Surface are read")
    return found


def parsed(content: bytes, label: str) -> ET.Element:
    """An XML tree without entities of its own: they can grow without end."""
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise ValueError(f"{label}: document types and entities are not read")
    try:
        return ET.fromstring(content)
    except ET.ParseError as error:
        raise ValueError(f"{label}: no XML ({error})") from None


def _surface(element: ET.Element, root: ET.Element, label: str, found: Import, number: int) -> None:
    model = _MODELS[element.tag]
    name = element.get("name") or f"surface-{number}"
    inputs = {child.get("name"): child for child in element.findall("input")}

    def number_of(key: tuple[str, float]) -> float:
        child = inputs.get(key[0])
        if child is None:
            return key[1]
        if child.get("value") is None:
            found.leave_out(f"{name}: the graph behind {key[0]}; its default, {key[1]:g}, stands for it")
            return key[1]
        return _float(child.get("value", ""), label, f"{name}: {key[0]}")

    unit, factor = model["unit"]
    thickness: Any = (
        number_of(model["thickness"])
        if inputs.get(model["thickness"][0]) is None or inputs[model["thickness"][0]].get("value")
        else _graph(inputs[model["thickness"][0]], root, label, name, found)
    )
    weight = number_of(model["weight"]) if model["weight"] else float(bool(thickness))
    metal, ior, clear = (number_of(model[key]) for key in ("metal", "ior", "clear"))
    rough = number_of(model["rough"])
    thin = inputs.get(model["thin"])
    free = (thin is not None and thin.get("value") == "true") or abs(ior - 1.0) < 1e-3
    color = inputs.get("base_color")
    mean = 0.8
    if color is not None and color.get("value"):
        values = [_float(word, label, f"{name}: base_color") for word in color.get("value", "").split(",")]
        mean = sum(values) / max(len(values), 1)
    base: Any = max(ior, 1.0)
    if metal > 0.5:
        found.leave_out(f"{name}: the metal's k: the file has none; a clear base of the same reflectance stands for it")
        base, free = index_of_f0(mean), False
    if weight > 0.0:
        if weight < 1.0:
            found.leave_out(f"{name}: a film that is there in part")
        nm = thickness
        if isinstance(nm, float):
            nm = checked_nm(found, label, name, nm * factor, unit)
        else:
            ends = [checked_nm(found, label, name, end * factor, unit) for end in nm]
            nm = {"gradient": {"top": ends[0], "bottom": ends[1]}}
            found.leave_out(f"{name}: the map of thickness; a gradient over its range stands for it")
        film_ior = number_of(model["film_ior"])
        if not 1.0 <= film_ior < 10.0:
            raise ValueError(f"{label}: {name}: the film's index must be 1 or more, got {film_ior:g}")
        surface = film_surface(film_ior, nm, base, free and clear > 0.5)
    elif metal > 0.5:
        surface = {"coating": {"layers": [], "substrate": base}}
    elif clear > 0.5:
        surface = {"dielectric": {"medium": max(ior, 1.0 + 1e-6)}}
    else:
        surface = {"diffuse": {"reflectance": min(max(mean, 0.0), 1.0)}}
    if "diffuse" not in surface:
        surface = roughened(surface, min(max(rough, 0.0), 1.0))
        if "specular_roughness_anisotropy" in inputs or "specular_anisotropy" in inputs:
            found.leave_out(f"{name}: the anisotropy of its roughness")
    place = 10.0 * len(found.objects)
    shape = {"sphere": {"center": [place, 0.0, 0.0], "radius": _BALL["sphere"]["radius"]}}
    found.objects.append({"name": name, "shape": shape, "surface": surface})


def _graph(child: ET.Element, root: ET.Element, label: str, name: str, found: Import) -> Any:
    """The ends of a remapped map; the middle of nothing is not guessed."""
    graph = child.get("nodegraph")
    for one in root.findall("nodegraph"):
        if one.get("name") == graph:
            for remap in one.iter("remap"):
                ends = {item.get("name"): item.get("value") for item in remap.findall("input")}
                if ends.get("outlow") and ends.get("outhigh"):
                    return tuple(_float(str(ends[key]), label, f"{name}: {key}") for key in ("outlow", "outhigh"))
    raise ValueError(f"{label}: {name}: the graph {graph!r} behind the film's thickness cannot be read")


def _float(text: str, label: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{label}: {where} must be a number, got {text!r:.40}") from None
