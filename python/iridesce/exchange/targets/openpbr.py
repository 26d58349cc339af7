"""Target ``openpbr``: an OpenPBR surface with its thin film in MaterialX, and a conductor with n and k beside it."""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

from iridesce import _core
from iridesce.arguments.operands import Floats
from iridesce.exchange.films import Film
from iridesce.exchange.knobs import Knobs, differences, fitted, knobs_of
from iridesce.exchange.package import Package, Request
from iridesce.exchange.surfaces import roughness_png
from iridesce.exchange.textures import laid_out, thickness_png
from iridesce.exchange.twins import materialx as twin

_NM = 1000.0
# The twin's conductor is nearest to the truth with n and k from here.
CONDUCTOR_NM = (600.0, 550.0, 450.0)


def export_openpbr(request: Request) -> Package:
    """``NAME.mtlx`` and the map of thickness of each film."""
    package = Package()
    for film in request.films:
        package.files[f"{film.name}.mtlx"] = _document(film, request, package)
    if request.scene is not None:
        package.drop("geometry, camera and lights: the target holds materials; gltf, usd and mitsuba hold scenes")
    package.note("thin_film_thickness in um (thinfilm_thickness of the conductor node in nm)")
    package.note(
        f"errors are told by a twin of {twin.VERSION}; other renderers of OpenPBR may use another film formula"
    )
    return package


def show(knobs: Knobs, thickness_nm: Floats, cosine: Floats) -> Floats:
    """The twin with these knobs: the dielectric lobe, or the metal one with its Schlick base."""
    if knobs.base_ior is None:
        return twin.rgb(thickness_nm, cosine, knobs.film_ior, f0=knobs.f0)
    return twin.rgb(thickness_nm, cosine, knobs.film_ior, knobs.base_ior)


def show_conductor(knobs: Knobs, thickness_nm: Floats, cosine: Floats) -> Floats:
    """The twin's conductor node."""
    assert knobs.index is not None
    return twin.rgb(thickness_nm, cosine, knobs.film_ior, knobs.index)


def openpbr_inputs(
    film: Film, request: Request, package: Package, target: str = "openpbr"
) -> tuple[Knobs, list[tuple[str, str, str]]]:
    """The inputs of the surface that are not its defaults: (name, type, value); thickness left out."""
    knobs = knobs_of(film, package, target, CONDUCTOR_NM)
    if request.fit and film.layer is not None:
        knobs = fitted(show, knobs, film, package, ("film_ior", "base_ior", "f0"))
    package.differences[film.name] = differences(show, knobs, film)
    inputs = [] if film.roughness is not None and film.roughness.grey is not None else _rough(film, package)
    if knobs.base_ior is None:
        inputs += [
            ("base_metalness", "float", "1"),
            ("base_weight", "float", "1"),
            ("base_color", "color3", ", ".join(f"{x:.9g}" for x in knobs.f0)),
        ]
    else:
        inputs += [("transmission_weight", "float", "1"), ("specular_ior", "float", f"{knobs.base_ior:.9g}")]
        if film.free:
            inputs.append(("geometry_thin_walled", "boolean", "true"))
        package.drop(
            f"{film.name}: fringes in what the film passes: the transmission lobe of MaterialX has no film"
            " (AcademySoftwareFoundation/MaterialX#3026)"
        )
    if film.layer is not None:
        inputs += [("thin_film_weight", "float", "1"), ("thin_film_ior", "float", f"{knobs.film_ior:.9g}")]
    return knobs, inputs


def _rough(film: Film, package: Package) -> list[tuple[str, str, str]]:
    rough = film.roughness
    if rough is None:
        return [("specular_roughness", "float", "0")]
    value, anisotropy = rough.openpbr()
    made = [("specular_roughness", "float", f"{value:.9g}")]
    if anisotropy > 0.0:
        made.append(("specular_roughness_anisotropy", "float", f"{anisotropy:.9g}"))
        if rough.along_v > rough.along_u:
            package.drop(f"{film.name}: rougher along v than along u: turn geometry_tangent by 90 degrees")
    return made


def _rough_map(film: Film, package: Package) -> tuple[list[str], list[str]]:
    """The graph that reads a map of roughness, and the input that takes it."""
    if film.roughness is None or film.roughness.grey is None:
        return [], []
    file, graph = roughness_png(film.name, film.roughness, package), f"{film.name}_roughness"
    lines = [
        f'  <nodegraph name="{graph}">',
        '    <image name="map" type="vector3">',
        f'      <input name="file" type="filename" value={quoteattr(file)} colorspace="none"/>',
        "    </image>",
        '    <extract name="rough" type="float">',
        '      <input name="in" type="vector3" nodename="map"/>',
        '      <input name="index" type="integer" value="1"/>',
        "    </extract>",
        '    <output name="out" type="float" nodename="rough"/>',
        "  </nodegraph>",
    ]
    return lines, [f'    <input name="specular_roughness" type="float" nodegraph="{graph}" output="out"/>']


def _document(film: Film, request: Request, package: Package) -> bytes:
    name = film.name
    knobs, inputs = openpbr_inputs(film, request, package)
    lines = [
        '<?xml version="1.0"?>',
        f"<!-- {film.text_for_table if film.layer is not None else film.text}; iridesce {_core.__version__} -->".replace(
            "--h", "-h"
        ),
        '<materialx version="1.39" colorspace="lin_rec709">',
    ]
    thickness = ""
    if film.layer is not None:
        graph, thickness = _thickness(film, package)
        lines += graph
    graph, rough = _rough_map(film, package)
    lines += graph
    lines.append(f'  <open_pbr_surface name={quoteattr(name + "_surface")} type="surfaceshader">')
    lines += [f'    <input name="{key}" type="{kind}" value="{value}"/>' for key, kind, value in inputs]
    lines += rough
    if thickness:
        lines.append(f'    <input name="thin_film_thickness" type="float" {thickness}/>')
    lines += ["  </open_pbr_surface>", *_material(name, f"{name}_surface")]
    if knobs.index is not None:
        lines += _conductor(film, knobs, package)
    return ("\n".join([*lines, "</materialx>"]) + "\n").encode("utf-8")


def _thickness(film: Film, package: Package) -> tuple[list[str], str]:
    """The graph that reads the map, and what the thickness is connected to; um."""
    low, high = film.range_nm
    if not film.varies:
        return [], f'value="{high / _NM!r}"'
    film = laid_out(film, package)
    file = f"{film.name}_thickness.png"
    thickness_png(film, package, file)
    graph = f"{film.name}_thickness"
    lines = [
        f'  <nodegraph name="{graph}">',
        '    <image name="map" type="vector3">',
        f'      <input name="file" type="filename" value={quoteattr(file)} colorspace="none"/>',
        '      <input name="uaddressmode" type="string" value="clamp"/>',
        '      <input name="vaddressmode" type="string" value="clamp"/>',
        '      <input name="filtertype" type="string" value="linear"/>',
        "    </image>",
        '    <extract name="share" type="float">',
        '      <input name="in" type="vector3" nodename="map"/>',
        '      <input name="index" type="integer" value="1"/>',
        "    </extract>",
        '    <remap name="um" type="float">',
        '      <input name="in" type="float" nodename="share"/>',
        f'      <input name="outlow" type="float" value="{low / _NM!r}"/>',
        f'      <input name="outhigh" type="float" value="{high / _NM!r}"/>',
        "    </remap>",
        '    <output name="out" type="float" nodename="um"/>',
        "  </nodegraph>",
    ]
    return lines, f'nodegraph="{graph}" output="out"'


def _conductor(film: Film, knobs: Knobs, package: Package) -> list[str]:
    """The same film on a conductor with n and k: nearer to the truth where the renderer has the node."""
    assert knobs.index is not None
    name = f"{film.name}_conductor"
    mean = float(differences(show_conductor, knobs, film).mean())
    package.note(
        f"{film.name}: the material {name} holds {knobs.base_name} by n and k: CIEDE2000 {mean:.2f} in the mean by the twin"
    )
    alpha = (0.0, 0.0) if film.roughness is None else film.roughness.alpha
    value = film.range_nm[1] if not film.varies else 0.5 * sum(film.range_nm)
    lines = [
        f'  <conductor_bsdf name="{name}_bsdf" type="BSDF">',
        f'    <input name="ior" type="color3" value="{", ".join(f"{x:.6g}" for x in knobs.index.real)}"/>',
        f'    <input name="extinction" type="color3" value="{", ".join(f"{x:.6g}" for x in knobs.index.imag)}"/>',
        f'    <input name="roughness" type="vector2" value="{", ".join(f"{x:.6g}" for x in alpha)}"/>',
    ]
    if film.layer is not None:
        lines += [
            f'    <input name="thinfilm_thickness" type="float" value="{value!r}"/>',
            f'    <input name="thinfilm_ior" type="float" value="{knobs.film_ior:.9g}"/>',
        ]
    return [
        *lines,
        "  </conductor_bsdf>",
        f'  <surface name="{name}_surface" type="surfaceshader">',
        f'    <input name="bsdf" type="BSDF" nodename="{name}_bsdf"/>',
        "  </surface>",
        *_material(name, f"{name}_surface"),
    ]


def _material(name: str, surface: str) -> list[str]:
    return [
        f'  <surfacematerial name={quoteattr(name)} type="material">',
        f'    <input name="surfaceshader" type="surfaceshader" nodename="{surface}"/>',
        "  </surfacematerial>",
    ]
