"""Target ``cycles``: a script that makes one material in Blender: its own film where that suffices, the table where not."""

from __future__ import annotations

import numpy as np

from iridesce import _core, color
from iridesce.arguments.operands import Floats
from iridesce.exchange import exr, lut
from iridesce.exchange.films import Film
from iridesce.exchange.knobs import Knobs, differences, fitted, knobs_of
from iridesce.exchange.package import Package, Request
from iridesce.exchange.targets.shaders import decimal, filled
from iridesce.exchange.textures import laid_out, thickness_png
from iridesce.exchange.twins import cycles as twin

SUFFICES = 2.0
"""CIEDE2000 in the mean up to which the physical knobs are taken: two of these are told apart with care only."""

# The path in the film beyond which Cycles' own table of sensitivities has ended, nm.
_TABLE_END_NM = twin.TABLE_END_NM


def export_cycles(request: Request) -> Package:
    """``NAME_cycles.py`` for each film, and the textures it reads."""
    package = Package()
    for film in request.films:
        _film(film, request, package)
    if request.scene is not None:
        package.drop("geometry, camera and lights: the script makes materials; gltf and usd hold scenes")
    package.note(
        "run the script in Blender (Text editor, or blender --python); thickness in nm; textures lie beside it"
    )
    return package


def show(knobs: Knobs, thickness_nm: Floats, cosine: Floats) -> Floats:
    """The twin with these knobs: Principled for a clear base, Metallic with n and k for a metal."""
    base = knobs.index if knobs.base_ior is None else knobs.base_ior
    assert base is not None
    return twin.rgb(thickness_nm, cosine, knobs.film_ior, base)


def _film(film: Film, request: Request, package: Package) -> None:
    trial = Package()
    knobs = knobs_of(film, trial, "cycles")
    if request.fit and film.layer is not None:
        knobs = fitted(show, knobs, film, trial, ("film_ior", "base_ior", "nk"))
    physical = differences(show, knobs, film)
    mean = float(physical.mean())
    # Two of the twin's losses are no matter of error: another layer, an absorbing film. The error tells of them.
    if film.layer is None or mean <= SUFFICES:
        package.note(
            f"{film.name}: physical material: its knobs suffice, CIEDE2000 {mean:.2f} in the mean (twin of {twin.VERSION})"
        )
        for sentence in trial.dropped:
            package.drop(sentence)
        for sentence in trial.notes:
            package.note(sentence)
        package.differences[film.name] = physical
        if 2.0 * knobs.film_ior * film.range_nm[1] > _TABLE_END_NM:
            package.drop(
                f"{film.name}: fringes of more than {_TABLE_END_NM:.0f} nm of path: Cycles' own table ends there"
            )
        _write(film, package, knobs, None)
        return
    package.note(
        f"{film.name}: table: the physical knobs would be off by CIEDE2000 {mean:.2f} in the mean (twin of {twin.VERSION})"
    )
    _write(film, package, knobs, _tables(film, package))


def _tables(film: Film, package: Package) -> dict[str, str]:
    """The tables in linear Rec.709, half floats, for an image node of Non-Color data."""
    files = {}
    to_rgb = color.rgb_matrix("linear-srgb")
    for quantity in lut.QUANTITIES if film.transmits else lut.QUANTITIES[:1]:
        table = lut.table(film, quantity)
        rgb = (table.xyz @ to_rgb.T).astype(np.float16)
        name = f"{film.name}_{quantity}_rec709.exr"
        facts = {**table.attributes(), "iridesce:space": "linear Rec.709"}
        package.files[name] = exr.exr_bytes({letter: rgb[..., axis] for axis, letter in enumerate("RGB")}, facts)
        files[quantity] = name
        share = float((rgb.min(axis=-1) < 0.0).mean())
        if share > 0.0:
            package.drop(
                f"{film.name}, {quantity}: {100.0 * share:.0f} % of the table lies outside Rec.709; Cycles cuts closure"
                " colours there"
            )
        if quantity == "reflectance":
            cut = lut.Lut(
                np.maximum(rgb.astype(np.float64), 0.0) @ np.linalg.inv(to_rgb).T, table.range_nm, quantity, "", ""
            )
            package.differences[film.name] = lut.chart_differences(cut, film)
    package.drop(f"{film.name}: other lamps: the table holds colours under {film.illuminant.name}; polarisation")
    return files


def _write(film: Film, package: Package, knobs: Knobs, tables: dict[str, str] | None) -> None:
    rough = film.roughness
    if rough is not None and rough.grey is not None:
        package.drop(f"{film.name}: the map of its roughness; its mean, {rough.mean:.3g}, is written")
    elif rough is not None and rough.is_brushed:
        package.drop(
            f"{film.name}: its brushing, {rough.along_u:g} along u, {rough.along_v:g} along v; {rough.mean:.3g} is written"
        )
    if rough is not None and tables:
        package.drop(f"{film.name}: the table is read at the angle of the surface, not of its facets")
    low, high = film.table_range() if tables else film.range_nm
    texture = ""
    if film.layer is not None and film.varies:
        texture = f"{film.name}_thickness.png"
        thickness_png(laid_out(film, package), package, texture)
    index = np.zeros(3, complex) if knobs.index is None else knobs.index
    kind = "table" if tables else "metallic" if knobs.base_ior is None else "principled"
    width, height = lut.SIZE
    if tables:
        width = exr.read_exr(package.files[tables["reflectance"]], "table").channels["R"].shape[1]
    words = {
        "VERSION": _core.__version__,
        "STACK": (film.text_for_table if film.layer is not None else film.text)
        .encode("ascii", "replace")
        .decode("ascii"),
        "NAME": film.name,
        "KIND": kind,
        "FILM": str(film.layer is not None),
        "THICKNESS": decimal(film.range_nm[1]),
        "LOW": decimal(low),
        "HIGH": decimal(high),
        "MAP": texture,
        "MAP_LOW": decimal(film.range_nm[0]),
        "MAP_HIGH": decimal(film.range_nm[1]),
        "FILM_IOR": decimal(knobs.film_ior),
        "ROUGHNESS": decimal(0.0 if film.roughness is None else film.roughness.mean),
        "BASE_IOR": decimal(knobs.base_ior or 1.0),
        "BASE_N": ", ".join(decimal(float(x)) for x in index.real),
        "BASE_K": ", ".join(decimal(float(x)) for x in index.imag),
        "REFLECTANCE": (tables or {}).get("reflectance", ""),
        "TRANSMITTANCE": (tables or {}).get("transmittance", ""),
        "WIDTH": str(width),
        "HEIGHT": str(height),
    }
    package.files[f"{film.name}_cycles.py"] = filled("cycles.py.txt", words)
