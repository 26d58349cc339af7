"""Target ``usd``: a stage in text, with OpenPBR shaders as UsdShade (nothing is referenced from a .mtlx), whole scenes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from iridesce import _core, color
from iridesce.arguments.operands import Floats
from iridesce.exchange.appearance import lamp_rgb, reflectance_of
from iridesce.exchange.films import Film
from iridesce.exchange.geometry import Mesh, Surface
from iridesce.exchange.laying import MM, folder_of, plain_name
from iridesce.exchange.package import Package, Request
from iridesce.exchange.pieces import Piece, turned
from iridesce.exchange.surfaces import (
    environment_file,
    normal_png,
    picture_file,
    roughness_png,
    told_camera,
    told_piece,
    told_spectrum,
)
from iridesce.exchange.targets.openpbr import openpbr_inputs
from iridesce.exchange.textures import laid_out, thickness_png
from iridesce.exchange.twins import materialx as twin

_NM = 1000.0

MOST_PRIMS = 1_000
"""Instances of one object beyond which a PointInstancer stands for prims of their own."""


def export_usd(request: Request) -> Package:
    """``scene.usda`` (or ``film.usda``) and the maps of thickness."""
    package = Package()
    name = "film" if request.scene is None else "scene"
    unit = "m" if request.scene is None else request.scene.to_dict()["unit"]
    lines = [
        "#usda 1.0",
        "(",
        f'    doc = "iridesce {_core.__version__}: films as OpenPBR, thin_film_thickness in um"',
        '    defaultPrim = "World"',
        f"    metersPerUnit = {MM[unit] / 1000.0:g}",
        '    upAxis = "Y"',
        ")",
        "",
        'def Xform "World"',
        "{",
    ]
    if request.scene is None:
        film = request.films[0]
        prim = prim_name(film.name)
        lines += _indented(_material(film, prim, request, package, (False, False), None))
        mesh = Surface("sphere", {"center": [0.0, 0.0, 0.0], "radius": 1.0}).mesh()
        lines += _indented(_mesh(f"{prim}_ball", mesh, prim))
        package.note("the material is on a sphere of radius 1; take it from there")
    else:
        lines += _indented(_scene(request, request.scene.to_dict(), folder_of(request.scene), package))
    package.files[f"{name}.usda"] = ("\n".join([*lines, "}"]) + "\n").encode("utf-8")
    package.note("thin_film_thickness in um; the same numbers in nm stand in customData of each material")
    package.note(
        f"errors are told by a twin of {twin.VERSION}; other renderers of OpenPBR may use another film formula"
    )
    return package


def prim_name(name: str) -> str:
    """A name as a prim may bear it."""
    return plain_name(name).replace("-", "_")


def _material(
    film: Film,
    prim: str,
    request: Request,
    package: Package,
    repeats: tuple[bool, bool],
    normals: str | None,
) -> list[str]:
    knobs, inputs = openpbr_inputs(film, request, package, "usd")
    facts: dict[str, Any] = {"stack": film.text_for_table if film.layer is not None else film.text}
    kinds = {"float": "float", "color3": "color3f", "boolean": "bool"}
    shader = ['uniform token info:id = "ND_open_pbr_surface_surfaceshader"']
    for key, kind, value in inputs:
        shown = f"({value})" if kind == "color3" else {"true": "1", "false": "0"}.get(value, value)
        shader.append(f"{kinds[kind]} inputs:{key} = {shown}")
    extra: list[str] = []
    path = f"/World/{prim}"
    if film.layer is not None:
        low, high = film.range_nm
        facts |= {"thickness_min_nm": low, "thickness_max_nm": high}
        if film.varies:
            file = f"{film.name}_thickness.png"
            thickness_png(laid_out(film, package), package, file)
            extra = _map_shaders(path, file, low, high, repeats)
            shader.append(f"float inputs:thin_film_thickness.connect = <{path}/um.outputs:out>")
        else:
            shader.append(f"float inputs:thin_film_thickness = {high / _NM!r}")
    if film.roughness is not None and film.roughness.grey is not None:
        file = roughness_png(film.name, film.roughness, package)
        extra += _rough_shaders(path, file, repeats)
        shader.append(f"float inputs:specular_roughness.connect = <{path}/rough.outputs:out>")
    if normals is not None:
        extra += _normal_shaders(path, normals, repeats)
        shader.append(f"float3 inputs:geometry_normal.connect = <{path}/normal.outputs:out>")
    if knobs.index is not None:
        facts |= {"base_n_rgb": knobs.index.real.tolist(), "base_k_rgb": knobs.index.imag.tolist()}
    shader.append("token outputs:out")
    metadata = [f"{_usd_type(value)} {key} = {_usd_value(value)}" for key, value in facts.items()]
    return [
        f'def Material "{prim}" (',
        "    customData = {",
        "        dictionary iridesce = {",
        *(f"            {line}" for line in metadata),
        "        }",
        "    }",
        ")",
        "{",
        f"    token outputs:mtlx:surface.connect = <{path}/surface.outputs:out>",
        "",
        '    def Shader "surface"',
        "    {",
        *(f"        {line}" for line in shader),
        "    }",
        *_indented(extra),
        "}",
    ]


def _address(repeats: tuple[bool, bool]) -> list[str]:
    modes = ["periodic" if again else "clamp" for again in repeats]
    return [f'    string inputs:{letter}addressmode = "{mode}"' for letter, mode in zip("uv", modes, strict=True)]


def _map_shaders(path: str, file: str, low: float, high: float, repeats: tuple[bool, bool]) -> list[str]:
    return [
        'def Shader "map"',
        "{",
        '    uniform token info:id = "ND_image_vector3"',
        f"    asset inputs:file = @{file}@ (",
        '        colorSpace = "raw"',
        "    )",
        *_address(repeats),
        '    string inputs:filtertype = "linear"',
        "    float3 outputs:out",
        "}",
        'def Shader "share"',
        "{",
        '    uniform token info:id = "ND_extract_vector3"',
        f"    float3 inputs:in.connect = <{path}/map.outputs:out>",
        "    int inputs:index = 1",
        "    float outputs:out",
        "}",
        'def Shader "um"',
        "{",
        '    uniform token info:id = "ND_remap_float"',
        f"    float inputs:in.connect = <{path}/share.outputs:out>",
        f"    float inputs:outlow = {low / _NM!r}",
        f"    float inputs:outhigh = {high / _NM!r}",
        "    float outputs:out",
        "}",
    ]


def _normal_shaders(path: str, file: str, repeats: tuple[bool, bool]) -> list[str]:
    return [
        'def Shader "normal_map"',
        "{",
        '    uniform token info:id = "ND_image_vector3"',
        f"    asset inputs:file = @{file}@ (",
        '        colorSpace = "raw"',
        "    )",
        *_address(repeats),
        "    float3 outputs:out",
        "}",
        'def Shader "normal"',
        "{",
        '    uniform token info:id = "ND_normalmap_float"',
        f"    float3 inputs:in.connect = <{path}/normal_map.outputs:out>",
        "    float3 outputs:out",
        "}",
    ]


def _rough_shaders(path: str, file: str, repeats: tuple[bool, bool]) -> list[str]:
    return [
        'def Shader "rough_map"',
        "{",
        '    uniform token info:id = "ND_image_vector3"',
        f"    asset inputs:file = @{file}@ (",
        '        colorSpace = "raw"',
        "    )",
        *_address(repeats),
        "    float3 outputs:out",
        "}",
        'def Shader "rough"',
        "{",
        '    uniform token info:id = "ND_extract_vector3"',
        f"    float3 inputs:in.connect = <{path}/rough_map.outputs:out>",
        "    int inputs:index = 1",
        "    float outputs:out",
        "}",
    ]


def _scene(request: Request, tree: Mapping[str, Any], folder: Path, package: Package) -> list[str]:
    camera = tree["camera"]
    eye, target = (np.asarray(camera[key], dtype=np.float64) for key in ("position", "target"))
    distance = float(np.linalg.norm(eye - target))
    extent = 20.0 * distance
    lines: list[str] = []
    prims: set[str] = set()
    for piece in request.pieces:
        told_piece(piece, package)
        prim, count = prim_name(piece.name), 1
        while prim in prims:  # - and _ are the same here
            count += 1
            prim = f"{prim_name(piece.name)}_{count}"
        prims.add(prim)
        normals = normal_png(piece, folder, package, extent)
        if piece.film is not None:
            material = prim
            lines += _material(piece.film, prim, request, package, piece.repeats, normals)
        else:
            material = f"{prim}_plain"
            lines += _plain_material(material, piece, folder, package, normals)
        lines += _placed(f"{prim}_shape", piece, piece.mesh(extent), material, package)
    told_camera(camera, package, lens=True)
    lines += _camera(camera, eye, target, distance)
    for number, light in enumerate(tree["light"]):
        lines += _light(light, number, folder, package)
    return lines


def _placed(prim: str, piece: Piece, mesh: Mesh, material: str, package: Package) -> list[str]:
    """A mesh where its object stands: once, or as a class of its own that instances name."""
    placements = piece.placements
    if not piece.is_placed:
        return _mesh(prim, mesh, material)
    if len(placements) == 1:
        return _mesh(prim, mesh, material, _rows(placements[0]))
    parts = turned(placements) if len(placements) > MOST_PRIMS else None
    if parts is not None:
        moves, turns, scales = parts
        # A quaternion is written with its real part first.
        turns = np.concatenate([turns[:, 3:], turns[:, :3]], axis=1)
        return [
            f'def PointInstancer "{prim}"',
            "{",
            f"    quath[] orientations = [{', '.join(map(_tuple, turns))}]",
            f"    point3f[] positions = [{', '.join(map(_tuple, moves))}]",
            f"    int[] protoIndices = [{', '.join(['0'] * len(moves))}]",
            f"    rel prototypes = </World/{prim}/one>",
            f"    float3[] scales = [{', '.join(map(_tuple, scales))}]",
            "",
            *_indented(_mesh("one", mesh, material)),
            "}",
        ]
    lines = [
        f'class Xform "{prim}_one"',
        "{",
        *_indented(_mesh("mesh", mesh, material)),
        "}",
        f'def Xform "{prim}"',
        "{",
    ]
    for number, placement in enumerate(placements):
        lines += [
            f'    def Xform "at_{number + 1}" (',
            "        instanceable = true",
            f"        prepend references = </World/{prim}_one>",
            "    )",
            "    {",
            *(f"        {line}" for line in _rows(placement)),
            "    }",
        ]
    return [*lines, "}"]


def _rows(placement: Floats) -> list[str]:
    """A transform; USD's vectors are rows."""
    whole = np.concatenate([placement, [[0.0, 0.0, 0.0, 1.0]]]).T
    return [
        f"matrix4d xformOp:transform = ( {', '.join(_exact(row) for row in whole)} )",
        'uniform token[] xformOpOrder = ["xformOp:transform"]',
    ]


def _plain_material(prim: str, piece: Piece, folder: Path, package: Package, normals: str | None) -> list[str]:
    ((kind, keys),) = piece.item["surface"].items()
    shader = ['uniform token info:id = "ND_open_pbr_surface_surfaceshader"', "float inputs:specular_weight = 0"]
    extra: list[str] = []
    if kind == "diffuse":
        found = reflectance_of(keys["reflectance"], folder)
        file = None
        if found.spectrum is not None:
            told_spectrum(prim, package)
        if found.picture is not None:
            file = picture_file(prim, found, package, (".png", ".jpg", ".jpeg", ".exr", ".hdr"), "usd")
        if file is None:
            shader.append(f"color3f inputs:base_color = {_tuple(found.rgb)}")
        else:
            space = "lin_rec709" if file.endswith((".exr", ".hdr")) else "srgb_texture"
            shader.append(f"color3f inputs:base_color.connect = </World/{prim}/picture.outputs:out>")
            extra = [
                'def Shader "picture"',
                "{",
                '    uniform token info:id = "ND_image_color3"',
                f"    asset inputs:file = @{file}@ (",
                f'        colorSpace = "{space}"',
                "    )",
                *_address(piece.repeats),
                "    color3f outputs:out",
                "}",
            ]
    else:
        white = color.illuminant(keys["illuminant"]).white() * float(keys["radiance"])
        rgb = np.maximum(color.rgb_matrix("linear-srgb") @ white, 0.0).tolist()
        shader += ["float inputs:base_weight = 0", "float inputs:emission_luminance = 1"]
        shader.append(f"color3f inputs:emission_color = {_tuple(rgb)}")
        package.note(f"{prim}: radiance in units of the scene's white, as emission_luminance 1 x emission_color")
    if normals is not None:
        extra += _normal_shaders(f"/World/{prim}", normals, piece.repeats)
        shader.append(f"float3 inputs:geometry_normal.connect = </World/{prim}/normal.outputs:out>")
    return [
        f'def Material "{prim}"',
        "{",
        f"    token outputs:mtlx:surface.connect = </World/{prim}/surface.outputs:out>",
        '    def Shader "surface"',
        "    {",
        *(f"        {line}" for line in [*shader, "token outputs:out"]),
        "    }",
        *_indented(extra),
        "}",
    ]


def _mesh(prim: str, mesh: Mesh, material: str, transform: Iterable[str] = ()) -> list[str]:
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    normals = (
        []
        if mesh.normals is None
        else [
            f"    normal3f[] normals = [{', '.join(map(_tuple, mesh.normals))}] (",
            '        interpolation = "vertex"',
            "    )",
        ]
    )
    st = (
        []
        if mesh.uv is None
        else [
            f"    texCoord2f[] primvars:st = [{', '.join(map(_tuple, mesh.uv))}] (",
            '        interpolation = "vertex"',
            "    )",
        ]
    )
    return [
        f'def Mesh "{prim}" (',
        '    prepend apiSchemas = ["MaterialBindingAPI"]',
        ")",
        "{",
        "    uniform bool doubleSided = 1",
        f"    float3[] extent = [{_tuple(low)}, {_tuple(high)}]",
        f"    int[] faceVertexCounts = [{', '.join(['3'] * len(mesh.triangles))}]",
        f"    int[] faceVertexIndices = [{', '.join(map(str, mesh.triangles.reshape(-1).tolist()))}]",
        *normals,
        f"    point3f[] points = [{', '.join(map(_tuple, mesh.positions))}]",
        *st,
        '    uniform token subdivisionScheme = "none"',
        f"    rel material:binding = </World/{material}>",
        *(f"    {line}" for line in transform),
        "}",
    ]


def _camera(camera: Mapping[str, Any], eye: Floats, target: Floats, distance: float) -> list[str]:
    width, height = camera["resolution"]
    back = (eye - target) / distance
    right = np.cross(np.asarray(camera["up"], dtype=np.float64), back)
    right = right / np.linalg.norm(right)
    rows = np.eye(4)
    rows[0, :3], rows[1, :3], rows[2, :3], rows[3, :3] = right, np.cross(back, right), back, eye
    # Apertures are in tenths of a unit, as focal length; only their ratio counts for a perspective.
    if "orthographic_height" in camera:
        tall = 10.0 * float(camera["orthographic_height"])
        optics = ['token projection = "orthographic"', "float focalLength = 50"]
    else:
        tall = 24.0
        focal = 0.5 * tall / np.tan(0.5 * np.radians(float(camera["fov_deg"])))
        optics = ['token projection = "perspective"', f"float focalLength = {focal:.9g}"]
        radius = float(camera.get("aperture_radius") or 0.0)
        if radius > 0.0:  # focalLength counts in tenths of a unit
            optics.append(f"float fStop = {0.1 * focal / (2.0 * radius):.9g}")
            optics.append(f"float focusDistance = {float(camera.get('focus_distance', distance)):.9g}")
    return [
        'def Camera "camera"',
        "{",
        *(f"    {line}" for line in optics),
        f"    float horizontalAperture = {tall * width / height:.9g}",
        f"    float verticalAperture = {tall:.9g}",
        f"    float2 clippingRange = ({0.001 * distance:.9g}, {100.0 * distance:.9g})",
        f"    matrix4d xformOp:transform = ( {', '.join(_tuple(row) for row in rows)} )",
        '    uniform token[] xformOpOrder = ["xformOp:transform"]',
        "}",
    ]


def _light(light: Mapping[str, Any], number: int, folder: Path, package: Package) -> list[str]:
    ((kind, keys),) = light.items()
    if kind != "environment":
        return _lamp(kind, keys, number, package)
    radiance = float(keys.get("radiance", 1.0))
    body = [f"float inputs:intensity = {radiance:.9g}"]
    if "illuminant" in keys:
        rgb = lamp_rgb(keys["illuminant"])
        body.append(f"color3f inputs:color = {_tuple(rgb)}")
        if keys["illuminant"] != "D65":
            package.drop(
                f"light {number}: the spectrum of {keys['illuminant']}: three numbers hold its colour, not its lines"
            )
    elif "map" in keys:
        file = environment_file(keys["map"], number, folder, package)
        if file is not None:
            body += [f"asset inputs:texture:file = @{file}@", 'token inputs:texture:format = "latlong"']
        if keys.get("rotation_deg"):
            package.drop(f"light {number}: the rotation of the map, {keys['rotation_deg']:g} degrees")
    else:
        package.drop(f"light {number}: the built-in {keys.get('builtin')}; a white dome is written")
    return [f'def DomeLight "light_{number}"', "{", *(f"    {line}" for line in body), "}"]


def _lamp(kind: str, keys: Mapping[str, Any], number: int, package: Package) -> list[str]:
    """A light without size, or the sun. UsdLux with ``normalize``: a distant light's intensity is its irradiance at normal
    incidence, a sphere light's is 4 times its intensity towards a side (its luminance over 4 pi r^2, seen as pi r^2)."""
    value = float(keys["irradiance"] if kind in ("sun", "directional") else keys["intensity"])
    if keys["illuminant"] != "D65":
        package.drop(
            f"light {number}: the spectrum of {keys['illuminant']}: three numbers hold its colour, not its lines"
        )
    if keys.get("polarized_deg") is not None:
        package.drop(f"light {number}: its polarisation")
    body = [f"color3f inputs:color = {_tuple(lamp_rgb(keys['illuminant']))}", "bool inputs:normalize = 1"]
    if kind in ("sun", "directional"):
        angle = float(keys["angular_diameter_deg"]) if kind == "sun" else 0.0
        body += [f"float inputs:intensity = {value:.9g}", f"float inputs:angle = {angle:.9g}"]
        back = np.asarray(keys["direction"], dtype=np.float64)
        place, schema = np.zeros(3), "DistantLight"
    else:
        body += [f"float inputs:intensity = {4.0 * value:.9g}", "bool treatAsPoint = 1", "float inputs:radius = 0.001"]
        place, schema = np.asarray(keys["position"], dtype=np.float64), "SphereLight"
        back = place - np.asarray(keys["target"], dtype=np.float64) if kind == "spot" else np.array([0.0, 0.0, 1.0])
    if kind == "spot":
        inner = 0.5 * float(keys["cone_deg"])
        outer = inner + float(keys["soft_deg"])
        body += [f"float inputs:shaping:cone:angle = {outer:.9g}"]
        body += [f"float inputs:shaping:cone:softness = {(outer - inner) / outer:.9g}"]
    back = back / np.linalg.norm(back)
    up = np.array([0.0, 0.0, -1.0] if np.hypot(back[0], back[2]) < 1e-6 else [0.0, 1.0, 0.0])
    right = np.cross(up, back) / np.linalg.norm(np.cross(up, back))
    rows = np.eye(4)
    rows[0, :3], rows[1, :3], rows[2, :3], rows[3, :3] = right, np.cross(back, right), back, place
    body += [
        f"matrix4d xformOp:transform = ( {', '.join(_tuple(row) for row in rows)} )",
        'uniform token[] xformOpOrder = ["xformOp:transform"]',
    ]
    head = [f'def {schema} "light_{number}"']
    if kind == "spot":
        head = [f'def {schema} "light_{number}" (', '    prepend apiSchemas = ["ShapingAPI"]', ")"]
    return [*head, "{", *(f"    {line}" for line in body), "}"]


def _indented(lines: Iterable[str]) -> list[str]:
    return [f"    {line}" if line else line for line in lines]


def _tuple(values: Iterable[float]) -> str:
    return f"({', '.join(f'{float(x):.9g}' for x in values)})"


def _exact(values: Iterable[float]) -> str:
    return f"({', '.join(repr(float(x)) for x in values)})"


def _usd_type(value: Any) -> str:
    return {str: "string", float: "double", list: "double[]"}[type(value)]


def _usd_value(value: Any) -> str:
    return json.dumps(value) if isinstance(value, str) else repr(value)
