"""Targets ``shader`` and ``osl``: one function from thickness and cosine to XYZ, and the table it reads."""

from __future__ import annotations

import json
from importlib import resources

import numpy as np

from iridesce import _core
from iridesce.exchange import lut
from iridesce.exchange.films import Film
from iridesce.exchange.package import Package, Request
from iridesce.exchange.targets.tables import quantities, with_layer

LANGUAGES = ("glsl", "wgsl", "hlsl", "osl")


def export_shader(request: Request) -> Package:
    """``NAME.glsl``, ``.wgsl``, ``.hlsl``, ``.osl`` and the tables, as raw RGBA16F for an upload and as EXR."""
    package = Package()
    for film in with_layer(request, package, "shader"):
        for quantity in quantities(film, package):
            table, stated = _tables(film, quantity, package)
            package.files[f"{film.name}_{quantity}.rgba16f"] = raw_half(table)
        words = _words(film, table, stated, f"{film.name}_reflectance.rgba16f")
        for language in LANGUAGES:
            texture = {"TABLE": f"{film.name}_reflectance.exr"} if language == "osl" else {}
            package.files[f"{film.name}.{language}"] = filled(f"film.{language}", {**words, **texture})
        facts = {
            "width": table.xyz.shape[1],
            "height": table.xyz.shape[0],
            "format": "rgba16float, little-endian, first row (cos 0) first; X, Y, Z, 1",
            "thickness_nm": list(table.range_nm),
            "illuminant": table.illuminant,
            "stack": table.stack,
        }
        package.files[f"{film.name}.json"] = (json.dumps(facts, indent=2) + "\n").encode("ascii")
    package.note("film_xyz(thickness_nm, cos_theta) -> XYZ; one texture film_lut, uploaded as stored, no flip")
    package.note("the tables of transmittance have the same layout: bind them to the same function")
    return package


def export_osl(request: Request) -> Package:
    """``iridesce_film.osl`` (parameters ``lut_file``, ``thickness_nm``, output ``xyz``) and the table of each film."""
    package = Package()
    films = with_layer(request, package, "osl")
    for film in films:
        for quantity in reversed(quantities(film, package)):
            table, stated = _tables(film, quantity, package)
        name = "iridesce_film.osl" if len(films) == 1 else f"iridesce_film_{film.name}.osl"
        words = {**_words(film, table, stated, f"{film.name}_reflectance.exr")}
        package.files[name] = filled("film.osl", words)
    package.note("thickness in nm; xyz is the reflectance; give lut_file the other table for what the film passes")
    package.note(
        "CPU (and OptiX) renderers only; the path of the table must be constant; compile with the renderer's own oslc"
    )
    return package


def _tables(film: Film, quantity: str, package: Package) -> tuple[lut.Lut, dict[str, float]]:
    table = lut.stored(lut.table(film, quantity))
    stated = lut.error(table, film)
    package.files[f"{film.name}_{quantity}.exr"] = lut.exr_file(table, stated)
    if quantity == "reflectance":
        package.differences[film.name] = lut.chart_differences(table, film)
    return table, stated


def raw_half(table: lut.Lut) -> bytes:
    """RGBA16F, row 0 first: what texImage2D, writeTexture and CreateTexture2D take as it is."""
    height, width = table.xyz.shape[:2]
    texels = np.ones((height, width, 4), dtype="<f2")
    texels[..., :3] = table.xyz
    return texels.tobytes()


def filled(template: str, words: dict[str, str]) -> bytes:
    """A template of this package with its words put in; a word without a value is a fault of ours."""
    text = resources.files("iridesce.exchange").joinpath("templates", template).read_text(encoding="utf-8")
    for name, value in words.items():
        text = text.replace(f"@{name}@", value)
    return text.encode("ascii")


def decimal(value: float) -> str:
    """A number as every shading language reads a float: with a point."""
    text = f"{value:.9g}"
    return text if any(mark in text for mark in ".e") else text + ".0"


def _words(film: Film, table: lut.Lut, stated: dict[str, float], file: str) -> dict[str, str]:
    height, width = table.xyz.shape[:2]
    low, high = table.range_nm
    start = film.range_nm[0] if not film.varies else 0.5 * (low + high)
    return {
        "VERSION": _core.__version__,
        "STACK": table.stack.encode("ascii", "replace").decode("ascii"),
        "ILLUMINANT": table.illuminant.encode("ascii", "replace").decode("ascii"),
        "MEAN": f"{stated['mean']:.3f}",
        "P99": f"{stated['p99']:.3f}",
        "MAX": f"{stated['max']:.2f}",
        "WIDTH": str(width),
        "HEIGHT": str(height),
        "TABLE": file,
        "CHANNELS": "X, Y, Z",
        "LOW": decimal(low),
        "HIGH": decimal(high),
        "LAST_COLUMN": decimal(width - 1),
        "LAST_ROW": decimal(height - 1),
        "START": decimal(start),
    }
