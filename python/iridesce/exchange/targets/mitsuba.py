"""Target ``mitsuba``: a BSDF plugin in Python with spectra over thickness, wavelength and angle; whole scenes as XML."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from iridesce import _core, color
from iridesce.arguments.operands import Floats
from iridesce.exchange import charts, exr
from iridesce.exchange.appearance import Roughness, reflectance_of
from iridesce.exchange.films import ANGLES_DEG, DISPERSES, Film, extended_index, grazing_deg
from iridesce.exchange.geometry import Mesh
from iridesce.exchange.laying import folder_of
from iridesce.exchange.package import Package, Request
from iridesce.exchange.pieces import Piece
from iridesce.exchange.surfaces import environment_file, heights_of, picture_file, told_camera, told_piece
from iridesce.exchange.targets.shaders import decimal, filled
from iridesce.exchange.targets.tables import without_film
from iridesce.exchange.textures import laid_out
from iridesce.optics.wavelengths import VISIBLE_NM, in_steps

WAVELENGTH_NM = in_steps(VISIBLE_NM, 5.0)
COSINES = (64, 128)
"""Rows of a table over many thicknesses, and over one."""

_LEAST_STEPS, _MOST_STEPS = 2, 512
# A fringe of the shortest wavelength in the densest film used here is some 70 nm; so many steps to it.
_STEP_NM = 4.0


def export_mitsuba(request: Request) -> Package:
    """``iridesce_film.py``, the table of each film, and of a scene ``scene.xml`` with its meshes and maps."""
    package = Package()
    kept = [film for film in request.films if film.layer is not None]
    for film in kept:
        package.files[f"{film.name}_film.npz"] = _table(film, package)
    for film in request.films:
        if film.layer is None:
            package.differences[film.name] = _bare(film)
    if kept:
        first = kept[0]
        words = {
            "VERSION": _core.__version__,
            "STACK": first.text_for_table.encode("ascii", "replace").decode("ascii"),
            "TABLE": f"{first.name}_film.npz",
            "START": decimal(first.range_nm[1] if not first.varies else 0.5 * sum(first.range_nm)),
        }
        package.files["iridesce_film.py"] = filled("iridesce_film.py.txt", words)
    if request.scene is not None:
        _scene(request, request.scene.to_dict(), folder_of(request.scene), package)
    elif not kept:
        raise without_film("mitsuba")
    package.drop("polarisation: the table is of unpolarised light")
    package.note(
        "thickness in nm; any lamp, in spectral variants of llvm or cuda (Mitsuba 3.9); import iridesce_film first"
    )
    return package


def _table(film: Film, package: Package) -> bytes:
    low, high = film.range_nm
    steps = int(np.clip(np.ceil((high - low) / _STEP_NM) + 1, _LEAST_STEPS, _MOST_STEPS)) if film.varies else 1
    thickness = np.linspace(low, high, steps)[:, None, None]
    wavelength = WAVELENGTH_NM[None, :, None]
    angle = grazing_deg(np.linspace(0.0, 1.0, COSINES[0] if film.varies else COSINES[1]))[None, None, :]
    stack = film.at(thickness)
    held = _held(stack)
    arrays: dict[str, Any] = {
        "thickness_nm": np.array([low, high]),
        "wavelength_nm": WAVELENGTH_NM[[0, -1]],
        "reflectance": held.reflectance(wavelength, angle).astype(np.float16),
        "base_ior": np.array(1.0 if film.free else float(extended_index(film.stack.last, [550.0])[0].real)),
    }
    if film.transmits:
        arrays["transmittance"] = held.transmittance(wavelength, angle).astype(np.float16)
        if not film.free and np.ptp(extended_index(film.stack.last, [450.0, 650.0]).real) > DISPERSES:
            package.drop(f"{film.name}: dispersion of {film.stack.last.name} where it refracts; the film's own is kept")
    package.differences[film.name] = _chart(film, arrays["reflectance"].astype(np.float64))
    return npz_bytes(arrays)


def _held(stack: Any) -> Any:
    """The same stack with media that answer over the whole of 360..830 nm, as colour sums take them."""
    from iridesce.stack import Layer, Stack

    if all(_covers(medium) for medium in stack.media):
        return stack
    items = [_Extended(medium) for medium in stack.media]
    layers = [
        Layer(item.medium, layer.thickness_nm, layer.coherent)
        for item, layer in zip(items[1:-1], stack.layers, strict=True)
    ]
    return Stack([items[0].medium, *layers, items[-1].medium])


def _covers(medium: Any) -> bool:
    ends = medium.range_nm
    return ends is None or (ends[0] <= WAVELENGTH_NM[0] and ends[1] >= WAVELENGTH_NM[-1])


class _Extended:
    """A medium as a table at the wavelengths of the export, its stated extension included."""

    def __init__(self, medium: Any) -> None:
        from iridesce.optics.medium import Medium

        if _covers(medium):
            self.medium = medium
            return
        rows = [
            f"{w:g},{float(v.real)!r},{float(v.imag)!r}"
            for w, v in zip(WAVELENGTH_NM, extended_index(medium, WAVELENGTH_NM), strict=True)
        ]
        self.medium = Medium._from_text("\n".join(["nm,n,k", *rows]), f"{medium.name}.csv")


def _chart(film: Film, table: Floats) -> Floats:
    """What a renderer sums from the table on the chart of the film, against the truth."""
    steps, _, rows = table.shape
    low, high = film.range_nm
    share = (film.thicknesses() - low) / (high - low) if film.varies else np.zeros(1)
    place, row = share * (steps - 1), np.cos(np.radians(ANGLES_DEG)) * (rows - 1)
    t0, c0 = np.minimum(place.astype(int), max(steps - 2, 0)), np.minimum(row.astype(int), rows - 2)
    t1 = np.minimum(t0 + 1, steps - 1)
    dt, dc = (place - t0)[None, :, None], (row - c0)[:, None, None]

    def at(t: Any, c: Any) -> Floats:
        return np.asarray(table[t[None, :], :, c[:, None]])

    spectra = (at(t0, c0) * (1 - dc) + at(t0, c0 + 1) * dc) * (1 - dt) + (
        at(t1, c0) * (1 - dc) + at(t1, c0 + 1) * dc
    ) * dt
    return _summed(film, spectra)


def _bare(film: Film) -> Floats:
    """A bare surface as Mitsuba sums it: n and k at steps of 5 nm, of a clear medium n at 550 nm."""
    from iridesce.stack import Stack

    angle = np.array(ANGLES_DEG)[:, None, None]
    if film.transmits:
        index = float(extended_index(film.stack.last, [550.0])[0].real)
        spectra = Stack([film.stack.first, index]).reflectance(WAVELENGTH_NM, angle)
    else:
        spectra = _held(film.stack).reflectance(WAVELENGTH_NM, angle)
    return _summed(film, np.asarray(spectra, dtype=np.float64))


def _summed(film: Film, spectra: Floats) -> Floats:
    """Spectra (angles, thicknesses, wavelengths) as colours, against the truth."""
    fine = in_steps(VISIBLE_NM, 1.0)
    full = np.apply_along_axis(lambda values: np.interp(fine, WAVELENGTH_NM, values), -1, spectra)
    seen = color.spectrum_to_xyz(fine, full, illuminant=film.illuminant)
    return charts.differences(np.asarray(seen), charts.truth(film), film.illuminant)


def npz_bytes(arrays: Mapping[str, Any]) -> bytes:
    """An .npz of which the same arrays give the same bytes: no times in it."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as file:
        for name, values in sorted(arrays.items()):
            part = io.BytesIO()
            np.save(part, np.ascontiguousarray(values))
            info = zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(info, part.getvalue())
    return content.getvalue()


# --- scenes


def _scene(request: Request, tree: Mapping[str, Any], folder: Path, package: Package) -> None:
    camera = tree["camera"]
    distance = float(np.linalg.norm(np.subtract(camera["position"], camera["target"])))
    depth = tree["render"]["max_depth"] + 1
    lines = [
        '<scene version="3.0.0">',
        f'  <integrator type="path"><integer name="max_depth" value="{depth}"/></integrator>',
    ]
    told_camera(camera, package, lens=True)
    lines += _sensor(camera, tree["render"])
    for piece in request.pieces:
        told_piece(piece, package)
        body = _material(piece, folder, package)
        lines += [f"  {line}" for line in _shapes(piece, body, 20.0 * distance, package)]
    for number, light in enumerate(tree["light"]):
        lines += [f"  {line}" for line in _light(light, number, folder, package)]
    package.files["scene.xml"] = ("\n".join([*lines, "</scene>"]) + "\n").encode("utf-8")
    package.note("scene.xml: import iridesce_film, then mitsuba.load_file; lengths in scene units")


def _shapes(piece: Piece, body: list[str], extent: float, package: Package) -> list[str]:
    """An object where it stands: a sphere, a mesh, or a group of which there are instances."""
    varies = piece.film is not None and piece.film.varies
    name, surface = piece.name, piece.surface
    if surface is not None and surface.kind == "sphere" and not varies and not piece.is_placed:
        center, radius = surface.keys["center"], surface.keys["radius"]
        return [
            f'<shape type="sphere" id="{name}"><point name="center" value="{_list(center)}"/>'
            f'<float name="radius" value="{float(radius)!r}"/>',
            *(f"  {line}" for line in body),
            "</shape>",
        ]
    mesh = piece.mesh(extent, fine=surface is not None and surface.kind == "sphere")
    lines: list[str] = []
    # In a mirror the front stays the front, which Mitsuba's meshes do not know: they get a mirrored mesh.
    mirrored = np.linalg.det(piece.placements[:, :, :3]) < 0.0
    for is_mirrored in (False, True):
        own = piece.placements[mirrored == is_mirrored].copy()
        if not len(own):
            continue
        file = f"{name}_mirrored.ply" if is_mirrored else f"{name}.ply"
        if is_mirrored:
            own[:, :, 0] *= -1.0
        package.files[file] = ply_bytes(mesh.mirrored() if is_mirrored else mesh)
        shape = [f'  <string name="filename" value={quoteattr(file)}/>']
        if mesh.normals is None:
            shape.append('  <boolean name="face_normals" value="true"/>')
        shape += [f"  {line}" for line in body]
        ident = file.removesuffix(".ply")
        # A group holds no lamps.
        if len(own) == 1 or any("<emitter" in line for line in body):
            for number, placement in enumerate(own):
                mark = ident if number == 0 else f"{ident}-{number + 1}"
                lines += [f'<shape type="ply" id="{mark}">', *_to_world(placement), *shape, "</shape>"]
            continue
        lines += [
            f'<shape type="shapegroup" id="{ident}-group"><shape type="ply" id="{ident}">',
            *shape,
            "</shape></shape>",
        ]
        for placement in own:
            lines += [f'<shape type="instance"><ref id="{ident}-group"/>', *_to_world(placement), "</shape>"]
    return lines


def _to_world(placement: Floats) -> list[str]:
    if np.array_equal(placement, np.eye(4)[:3]):
        return []
    whole = np.concatenate([placement, [[0.0, 0.0, 0.0, 1.0]]])
    values = " ".join(repr(float(x)) for x in whole.reshape(-1))
    return [f'  <transform name="to_world"><matrix value="{values}"/></transform>']


def _sensor(camera: Mapping[str, Any], settings: Mapping[str, Any]) -> list[str]:
    width, height = camera["resolution"]
    look = (
        f'<lookat origin="{_list(camera["position"])}" target="{_list(camera["target"])}" up="{_list(camera["up"])}"/>'
    )
    if "orthographic_height" in camera:
        half = 0.5 * float(camera["orthographic_height"])
        kind, optics = "orthographic", ""
        look = f'<scale x="{half * width / height!r}" y="{half!r}" z="1"/>{look}'
    else:
        kind = "perspective"
        optics = f'<float name="fov" value="{camera["fov_deg"]!r}"/><string name="fov_axis" value="y"/>'
        if camera.get("aperture_radius"):
            kind = "thinlens"
            away = float(np.linalg.norm(np.subtract(camera["position"], camera["target"])))
            optics += f'<float name="aperture_radius" value="{camera["aperture_radius"]!r}"/>'
            optics += f'<float name="focus_distance" value="{camera.get("focus_distance", away)!r}"/>'
    return [
        f'  <sensor type="{kind}">{optics}',
        f'    <transform name="to_world">{look}</transform>',
        '    <film type="hdrfilm"><string name="pixel_format" value="xyz"/><rfilter type="box"/>',
        f'      <integer name="width" value="{width}"/><integer name="height" value="{height}"/></film>',
        f'    <sampler type="independent"><integer name="sample_count" value="{settings["samples"]}"/></sampler>',
        "  </sensor>",
    ]


def _material(piece: Piece, folder: Path, package: Package) -> list[str]:
    """The material, with its bump around it, and the lamp of a surface that glows."""
    lines = _skin(piece, folder, package)
    found = heights_of(piece, folder)
    if found is None:
        return lines
    shares, height = found
    file = f"{piece.name}_bump.exr"
    package.files[file] = exr.exr_bytes({"Y": shares.astype(np.float32)}, {"iridesce:is": "height, shares of 1"})
    end = next((number for number, line in enumerate(lines) if line.startswith("<emitter")), len(lines))
    wrapped = [
        f'<bsdf type="bumpmap"><float name="scale" value="{height!r}"/>',
        '  <texture type="bitmap"><boolean name="raw" value="true"/>',
        f'    <string name="filename" value={quoteattr(file)}/>{_wrap(piece)}</texture>',
        *(f"  {line}" for line in lines[:end]),
        "</bsdf>",
    ]
    return [*wrapped, *lines[end:]]


def _wrap(piece: Piece) -> str:
    """Mitsuba knows one rule for both directions: where u goes round, the poles meet too."""
    return f'<string name="wrap_mode" value="{"repeat" if any(piece.repeats) else "clamp"}"/>'


def _skin(piece: Piece, folder: Path, package: Package) -> list[str]:
    name, film = piece.name, piece.film
    ((kind, keys),) = piece.item["surface"].items()
    if film is not None and film.layer is not None:
        rough: list[str] = []
        if film.roughness is not None and "roughness" not in piece.lost_maps:
            rough = _facets(name, film.roughness, package)
            if film.transmits and not film.free:
                package.drop(f"{name}: what its rough film passes: it goes on as through a smooth one")
        lines = [
            '<bsdf type="iridesce_film">',
            f'  <string name="table" value={quoteattr(name + "_film.npz")}/>',
            f'  <string name="stack" value={quoteattr(film.text_for_table)}/>',
        ]
        if film.varies:
            laid = laid_out(film, package)
            assert laid.thickness_nm is not None
            package.files[f"{name}_thickness.exr"] = exr.exr_bytes(
                {"Y": laid.thickness_nm.astype(np.float32)}, {"iridesce:unit": "nm"}
            )
            lines += [
                '  <texture type="bitmap" name="thickness_nm"><boolean name="raw" value="true"/>',
                f'    <string name="filename" value={quoteattr(name + "_thickness.exr")}/>',
                f"    {_wrap(piece)}</texture>",
            ]
        else:
            lines.append(f'  <float name="thickness_nm" value="{film.range_nm[1]!r}"/>')
        return [*lines, *rough, "</bsdf>"]
    if film is not None:  # a bare surface
        index = extended_index(film.stack.last, WAVELENGTH_NM)
        if film.transmits:
            package.drop(f"{name}: dispersion of {film.stack.last.name}; n at 550 nm is written")
            ior = float(extended_index(film.stack.last, [550.0])[0].real)
            kind, rough = _rough(name, "dielectric", film.roughness, package)
            indices = f'<float name="int_ior" value="{ior!r}"/><float name="ext_ior" value="1.0"/>'
            return [f'<bsdf type="{kind}">{indices}', *rough, "</bsdf>"]
        parts = [
            f'<spectrum name="{letter}" value="{_spectrum(values)}"/>'
            for letter, values in (("eta", index.real), ("k", index.imag))
        ]
        kind, rough = _rough(name, "conductor", film.roughness, package)
        return [f'<bsdf type="{kind}">', *[f"  {part}" for part in parts], *rough, "</bsdf>"]
    if kind == "diffuse":
        return [
            '<bsdf type="twosided"><bsdf type="diffuse">',
            *_reflectance(piece, keys, folder, package),
            "</bsdf></bsdf>",
        ]
    radiance = _lamp(keys["illuminant"], float(keys["radiance"]), package)
    package.drop(f"{name}: a lamp that glows on both sides; Mitsuba's shines from its front")
    return [
        '<bsdf type="diffuse"><spectrum name="reflectance" value="0"/></bsdf>',
        f'<emitter type="area"><spectrum name="radiance" value="{radiance}"/></emitter>',
    ]


def _rough(name: str, kind: str, rough: Roughness | None, package: Package) -> tuple[str, list[str]]:
    """The rough kin of a material, and its facets."""
    if rough is None:
        return kind, []
    return f"rough{kind}", ['  <string name="distribution" value="ggx"/>', *_facets(name, rough, package)]


def _facets(name: str, rough: Roughness, package: Package) -> list[str]:
    """The alphas of facets."""
    package.drop(f"{name}: light that goes from facet to facet: Mitsuba's rough surfaces lose it")
    facets: list[str] = []
    if rough.grey is not None:
        file = f"{name}_alpha.exr"
        package.files[file] = exr.exr_bytes({"Y": (rough.grey**2).astype(np.float32)}, {"iridesce:is": "GGX alpha"})
        facets += [
            '  <texture type="bitmap" name="alpha"><boolean name="raw" value="true"/>',
            f'    <string name="filename" value={quoteattr(file)}/></texture>',
        ]
    else:
        along_u, along_v = rough.alpha
        facets += [f'  <float name="alpha_u" value="{along_u!r}"/>', f'  <float name="alpha_v" value="{along_v!r}"/>']
    return facets


def _reflectance(piece: Piece, keys: Mapping[str, Any], folder: Path, package: Package) -> list[str]:
    found = reflectance_of(keys["reflectance"], folder)
    if found.spectrum is not None:
        # Beyond its ends Mitsuba's spectrum is zero, a scene's holds.
        values = np.interp(WAVELENGTH_NM, *found.spectrum)
        return [f'  <spectrum name="reflectance" value="{_spectrum(values)}"/>']
    if found.picture is not None:
        file = picture_file(piece.name, found, package, (".png", ".jpg", ".jpeg", ".exr", ".hdr"), "mitsuba")
        if file is not None:
            path = f'<string name="filename" value={quoteattr(file)}/>'
            return [f'  <texture type="bitmap" name="reflectance">{path}{_wrap(piece)}</texture>']
    if found.rgb[0] == found.rgb[1] == found.rgb[2]:
        return [f'  <spectrum name="reflectance" value="{found.rgb[0]!r}"/>']
    return [f'  <rgb name="reflectance" value="{_list(found.rgb)}"/>']


def _lamp_without_size(kind: str, keys: Mapping[str, Any], number: int, package: Package) -> list[str]:
    value = float(keys["irradiance"] if kind in ("sun", "directional") else keys["intensity"])
    spectrum = _lamp(keys["illuminant"], value, package)
    if keys.get("polarized_deg") is not None:
        package.drop(f"light {number}: its polarisation")
    if kind in ("sun", "directional"):
        if kind == "sun":
            package.drop(f"light {number}: the disc of the sun; Mitsuba's directional light has no size")
        way = _list([-float(x) for x in keys["direction"]])
        return [
            f'<emitter type="directional"><vector name="direction" value="{way}"/>',
            f'  <spectrum name="irradiance" value="{spectrum}"/></emitter>',
        ]
    lines = [f'  <spectrum name="intensity" value="{spectrum}"/>']
    place = _list(keys["position"])
    if kind == "point":
        return [f'<emitter type="point"><point name="position" value="{place}"/>', *lines, "</emitter>"]
    inner = 0.5 * float(keys["cone_deg"])
    outer = inner + float(keys["soft_deg"])
    if outer > inner:
        package.drop(
            f"light {number}: its edge falls straight from {inner:g} to {outer:g} degrees, not by 3 s^2 - 2 s^3"
        )
    back = np.subtract(keys["position"], keys["target"])
    up = "0, 0, -1" if np.hypot(back[0], back[2]) < 1e-6 * np.linalg.norm(back) else "0, 1, 0"
    look = f'<lookat origin="{place}" target="{_list(keys["target"])}" up="{up}"/>'
    return [
        f'<emitter type="spot"><transform name="to_world">{look}</transform>',
        *lines,
        f'  <float name="cutoff_angle" value="{max(outer, inner * 1.0001)!r}"/><float name="beam_width" value="{inner!r}"/>',
        "</emitter>",
    ]


def _light(light: Mapping[str, Any], number: int, folder: Path, package: Package) -> list[str]:
    ((kind, keys),) = light.items()
    if kind != "environment":
        return _lamp_without_size(kind, keys, number, package)
    radiance = float(keys.get("radiance", 1.0))
    if "illuminant" in keys:
        spectrum = _lamp(keys["illuminant"], radiance, package)
        return [f'<emitter type="constant"><spectrum name="radiance" value="{spectrum}"/></emitter>']
    if "map" in keys:
        file = environment_file(keys["map"], number, folder, package)
        if file is None:
            even = _lamp("D65", radiance, package)
            return [f'<emitter type="constant"><spectrum name="radiance" value="{even}"/></emitter>']
        turn = 180.0 + float(keys.get("rotation_deg", 0.0))
        return [
            f'<emitter type="envmap"><string name="filename" value={quoteattr(file)}/>',
            f'  <float name="scale" value="{radiance!r}"/>',
            f'  <transform name="to_world"><rotate y="1" angle="{turn!r}"/></transform></emitter>',
        ]
    package.drop(f"light {number}: the built-in {keys.get('builtin')}; a uniform one of D65 is written")
    return [f'<emitter type="constant"><spectrum name="radiance" value="{_lamp("D65", radiance, package)}"/></emitter>']


def _lamp(name: str, radiance: float, package: Package) -> str:
    """The spectrum of a lamp at 5 nm, scaled so that Y of the perfect white is the radiance."""
    light = color.illuminant(name)
    if light.lines:
        package.drop(f"the lines of {name}: they are written as bands of 5 nm")
    power = np.asarray(light.power(WAVELENGTH_NM), dtype=np.float64)
    for nm, strength in light.lines:
        power[int(np.argmin(np.abs(WAVELENGTH_NM - nm)))] += strength / 5.0
    fine = in_steps(VISIBLE_NM, 1.0)
    # Mitsuba's film divides by the integral of the observer's y; so does this.
    ybar = color.color_matching(fine)[:, 1]
    total = float((np.interp(fine, WAVELENGTH_NM, power) * ybar).sum() / ybar.sum())
    return _spectrum(power * radiance / total)


def _spectrum(values: Floats) -> str:
    return ", ".join(f"{nm:g}:{value:.6g}" for nm, value in zip(WAVELENGTH_NM, values, strict=True))


def _list(values: Any) -> str:
    return ", ".join(repr(float(x)) for x in values)


def ply_bytes(mesh: Mesh) -> bytes:
    """A binary PLY with normals and u, v where the mesh has them; Mitsuba's textures count v from the top."""
    columns, names = [mesh.positions], ["x", "y", "z"]
    uv = None if mesh.uv is None else np.stack([mesh.uv[:, 0], 1.0 - mesh.uv[:, 1]], axis=1)
    for values, own in ((mesh.normals, ("nx", "ny", "nz")), (uv, ("u", "v"))):
        if values is not None:
            columns.append(values)
            names += own
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.positions)}"]
    head += [f"property float {name}" for name in names]
    head += [f"element face {len(mesh.triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    vertices = np.concatenate(columns, axis=1).astype("<f4")
    faces = np.zeros(len(mesh.triangles), dtype=[("count", "u1"), ("index", "<i4", 3)])
    faces["count"], faces["index"] = 3, mesh.triangles
    return "\n".join(head).encode("ascii") + vertices.tobytes() + faces.tobytes()
