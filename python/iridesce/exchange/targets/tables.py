"""Targets ``lut`` and ``cube``: exact colours as files that any program with textures reads."""

from __future__ import annotations

import numpy as np

from iridesce.arguments.refusals import Words, complaint
from iridesce.errors import ArgumentError
from iridesce.exchange import charts, lut
from iridesce.exchange.films import Film
from iridesce.exchange.package import Package, Request


def export_lut(request: Request) -> Package:
    """``NAME_reflectance.exr`` and, where light comes out behind, ``NAME_transmittance.exr``: half XYZ."""
    package = Package()
    for film in with_layer(request, package, "lut"):
        for quantity in quantities(film, package):
            table = lut.stored(lut.table(film, quantity))
            stated = lut.error(table, film)
            package.files[f"{film.name}_{quantity}.exr"] = lut.exr_file(table, stated)
            package.note(
                f"{film.name}, {quantity}: read linearly at 20 000 places CIEDE2000 mean {stated['mean']:.3f},"
                f" p99 {stated['p99']:.3f}, max {stated['max']:.2f} above 20 nm"
            )
            if quantity == "reflectance":
                package.differences[film.name] = lut.chart_differences(table, film)
    package.note(
        "columns: thickness A..B nm, rows from the top: cos(theta) 0..1, both at texel centres; XYZ, white Y = 1"
    )
    package.note("read with a linear filter, clamped edges, no mip-maps, as raw data (no colour management)")
    return package


def export_cube(request: Request) -> Package:
    """``NAME.cube``: 1 024 entries at 0 degrees, linear XYZ over thickness."""
    package = Package()
    for film in with_layer(request, package, "cube"):
        stated = lut.cube_error(film, "reflectance")
        package.files[f"{film.name}.cube"] = lut.cube_file(film, "reflectance", stated)
        (low, high), xyz = lut.ramp(film, "reflectance")
        rounded = np.array([[float(f"{value:.7g}") for value in row] for row in xyz])
        places = (film.thicknesses() - low) / (high - low) * (len(xyz) - 1)
        seen = lut.bilinear(rounded[None], places, np.zeros_like(places))
        package.differences[film.name] = charts.differences(seen[None], charts.truth(film), film.illuminant)
    package.claims_deg = (0.0,)
    package.drop("every angle but 0 degrees: a .cube has one dimension; the target lut holds them")
    package.drop("transmitted light: the .cube holds the reflectance")
    package.note(
        "input in nm, output linear XYZ with the perfect white Y = 1; mean, p95 and max are those at 0 degrees, which is what a"
        " .cube holds; by_angle tells what its colours are worth at the other angles"
    )
    return package


def with_layer(request: Request, package: Package, target: str) -> list[Film]:
    """The films that have a layer; bare surfaces are left out, and told."""
    kept = [film for film in request.films if film.layer is not None]
    for film in request.films:
        if film.layer is None:
            package.drop(f"{film.name}: a bare surface has no film")
    if not kept:
        raise without_film(target)
    if request.scene is not None:
        package.drop(f"geometry, camera and lights: {target} holds films; gltf, usd and mitsuba hold scenes")
    tell_kind(kept, package)
    return kept


def without_film(target: str) -> ArgumentError:
    """Of bare surfaces there is nothing to write; who takes them is named."""
    return complaint(
        f'"{target}" writes films; there is none here (gltf, openpbr, usd and cycles take bare surfaces)',
        "stack_or_scene",
        "a stack with a layer or a scene with a film",
        Words("one without"),
    )


def tell_kind(films: list[Film], package: Package) -> None:
    """What a table of colours cannot know, whatever it holds."""
    for film in films:
        if not film.varies:
            low, high = film.table_range()
            package.note(f"{film.name}: one thickness, {film.range_nm[0]:g} nm; its table spans {low:g} to {high:g} nm")
        if film.thickness_nm is not None:
            package.note(f"{film.name}: its thickness differs from place to place; hand the map over beside the table")
    package.drop("polarisation: the tables are of unpolarised light")
    package.drop("other lamps: colours are those under the lamp of the table; make one for each")


def quantities(film: Film, package: Package) -> tuple[str, ...]:
    """Reflectance, and transmittance where light comes out."""
    if film.transmits:
        return lut.QUANTITIES
    package.note(f"{film.name}: no light comes out behind {film.stack.last.name}: no table of transmittance")
    return lut.QUANTITIES[:1]
