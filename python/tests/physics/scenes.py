"""The scene's words for shapes, surfaces, lights and cameras; scenes of film spheres from what the oracles are given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from oracles.film_sphere import FilmSphere

Thing = dict[str, Any]
WHITE: Thing = {"environment": {"illuminant": "D65", "radiance": 1.0}}
DARK: Thing = {"environment": {"illuminant": "D65", "radiance": 0.0}}


def sphere(center: Sequence[float], radius: float, surface: Thing) -> Thing:
    """A whole sphere."""
    return {"shape": {"sphere": {"center": list(center), "radius": radius}}, "surface": surface}


def rectangle(center: Sequence[float], u: Sequence[float], v: Sequence[float], surface: Thing) -> Thing:
    """Half edges ``u`` and ``v``; the front is where u x v points."""
    return {"shape": {"rectangle": {"center": list(center), "u": list(u), "v": list(v)}}, "surface": surface}


def disk(center: Sequence[float], normal: Sequence[float], radius: float, surface: Thing) -> Thing:
    """A flat disk."""
    return {"shape": {"disk": {"center": list(center), "normal": list(normal), "radius": radius}}, "surface": surface}


def plane(point: Sequence[float], normal: Sequence[float], surface: Thing) -> Thing:
    """A half space behind its normal."""
    return {"shape": {"plane": {"point": list(point), "normal": list(normal)}}, "surface": surface}


def cap(vertex: Sequence[float], axis: Sequence[float], radius: float, rim: float, surface: Thing) -> Thing:
    """Part of a sphere of ``radius`` (negative: hollow) around its vertex, ``rim`` wide."""
    table = {"center": list(vertex), "axis": list(axis), "radius_of_curvature": radius, "aperture_radius": rim}
    return {"shape": {"cap": table}, "surface": surface}


def coating(layers: Sequence[tuple[Any, Any]], substrate: Any) -> Thing:
    """Layers (medium, nm) from outside inwards."""
    return {"coating": {"layers": [{"medium": m, "thickness_nm": d} for m, d in layers], "substrate": substrate}}


def dielectric(medium: Any) -> Thing:
    """The bare surface of a medium."""
    return {"dielectric": {"medium": medium}}


def metal(medium: Any) -> Thing:
    """The bare surface of a medium that light does not get through."""
    return {"metal": {"medium": medium}}


def film(medium: Any, thickness_nm: Any, outside: Any = "air") -> Thing:
    """A free film."""
    return {"film": {"medium": medium, "thickness_nm": thickness_nm, "outside": outside}}


def diffuse(reflectance: float | Sequence[float]) -> Thing:
    """A matt surface."""
    return {"diffuse": {"reflectance": reflectance}}


def emitter(radiance: float, illuminant: str = "D65") -> Thing:
    """A glowing surface."""
    return {"emitter": {"illuminant": illuminant, "radiance": radiance}}


def lit(illuminant: str, radiance: float = 1.0) -> Thing:
    """A uniform light all around."""
    return {"environment": {"illuminant": illuminant, "radiance": radiance}}


def view(
    position: Sequence[float], target: Sequence[float], resolution: tuple[int, int] = (1, 1), **lens: Any
) -> Thing:
    """A camera; ``fov_deg`` or ``orthographic_height`` and the rest by name."""
    return {"position": list(position), "target": list(target), "resolution": list(resolution), **lens}


def slanted(
    angle_deg: float, resolution: tuple[int, int] = (4, 4), height: float = 1.0, distance: float = 100.0
) -> Thing:
    """A parallel view of the origin, ``angle_deg`` from +y, in the x-y plane; every ray meets y = 0 at that angle."""
    from math import cos, radians, sin

    a = radians(angle_deg)
    position = [distance * sin(a), distance * cos(a), 0.0]
    return view(position, [0.0] * 3, resolution, orthographic_height=height, up=[0.0, 0.0, 1.0])


def build(objects: Sequence[Thing], camera: Thing, lights: Sequence[Thing] = (WHITE,), **render: Any) -> Thing:
    """A whole scene; ``unit`` may stand among the render settings."""
    unit = {"unit": render.pop("unit")} if "unit" in render else {}
    named = [{"name": f"object-{i}", **thing} for i, thing in enumerate(objects)]
    return {"version": 1, **unit, "camera": camera, "render": render, "object": named, "light": list(lights)}


def film_sphere_object(sphere: FilmSphere, medium: Any, name: str = "sphere") -> Thing:
    """A scene's object table for ``sphere``; ``medium`` is the scene's own word for its index."""
    gradient = {"top": sphere.top_nm, "bottom": sphere.bottom_nm, "exponent": sphere.exponent}
    thickness = sphere.top_nm if sphere.top_nm == sphere.bottom_nm else {"gradient": gradient}
    return {
        "name": name,
        "shape": {"sphere": {"center": list(sphere.center), "radius": sphere.radius}},
        "surface": {"film": {"medium": medium, "thickness_nm": thickness}},
    }


def medium_of(sphere: FilmSphere) -> Any:
    """ "water" for a function of wavelength, a number or [n, k] otherwise."""
    if callable(sphere.index):
        return "water"
    index = complex(sphere.index)
    return [index.real, index.imag] if index.imag else index.real


def scene(spheres: Sequence[FilmSphere], camera: Thing, environment: Thing, **render: int) -> Thing:
    """A whole scene; ``environment`` is the light's table, ``render`` holds samples, seed, max_depth."""
    return {
        "version": 1,
        "camera": camera,
        "render": render,
        "object": [film_sphere_object(s, medium_of(s), f"sphere-{i}") for i, s in enumerate(spheres)],
        "light": [{"environment": environment}],
    }
