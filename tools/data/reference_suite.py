"""Makes `reference/`: charts with spectral truth, scenes with their pictures, and the index. `make reference` runs it.

The charts are the same bytes each time; the pictures of the scenes are, on machines of one SIMD level (it is in the index).
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import sys
import tempfile
from pathlib import Path

import numpy as np

import iridesce as ir
from iridesce import _core
from iridesce.exchange import exr, lut
from iridesce.exchange.films import ANGLES_DEG, extended_index, grazing_deg
from iridesce.exchange.suite import CHARTS, RANGE_NM, THICKNESS_NM, Chart

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "reference"
WAVELENGTH_NM = np.arange(400.0, 701.0, 10.0)
SEEDS = (1, 2, 3, 4)
MOST_BYTES = 8 * 2**20
CONVENTIONS = {
    "observer": "CIE 1931 2 degrees, 360 to 830 nm in steps of 1 nm or finer",
    "white": "perfect reflector Y = 1 under the chart's own illuminant",
    "polarization": "mean of s and p",
    "angle": "degrees from the normal in the first medium (air)",
    "chart": f"{len(THICKNESS_NM)} thicknesses, 50 to 1200 nm in steps of 50 nm, across; {len(ANGLES_DEG)} angles down,"
    " 0 15 30 45 60 75 85; one pixel a patch",
    "table": "512 x 64: columns 50 to 1200 nm, rows cos(theta) 0 (top) to 1, both at texel centres; half floats",
    "scale": "none: compare with both sides times 1 / (largest Y of the chart)",
}


def main() -> None:
    """Charts, then scenes, or those named; what is written is whole at every step."""
    only = sys.argv[1:]
    files: dict[str, bytes] = {}
    index: dict[str, object] = {"version": 1, "made_by": f"iridesce {_core.__version__}", "licence": "CC0-1.0"}
    old = json.loads((FOLDER / "index.json").read_text()) if (FOLDER / "index.json").exists() else {}
    charts, scenes = dict(old.get("charts", {})), dict(old.get("scenes", {}))
    index |= {"conventions": CONVENTIONS, "simd_of_scenes": _core.SIMD_LEVEL, "charts": charts, "scenes": scenes}
    for name, chart in CHARTS.items():
        if not only or name in only:
            charts[name] = chart_entry(name, chart, files)
    write(files, index)
    for name, (title, scene) in scenes_of().items():
        if not only or name in only:
            print(f"{name}: {title}", file=sys.stderr, flush=True)
            kept = {key: value for key, value in scenes.get(name, {}).items() if key in ("geometry", "gltf")}
            scenes[name] = kept | scene_entry(name, title, scene, files)
            write(files, index)
    if not only or "geometry" in only:
        for name, (_, scene) in scenes_of().items():
            content = geometry(ir.Scene.load(scene).to_dict())
            # Scenes of the same shapes share a file.
            same = next((file for file, other in files.items() if other == content), f"scenes/{name}.obj")
            files[same] = content
            files |= gltf_files(name, scene, files)
            scenes[name] |= {"geometry": same, "gltf": f"scenes/{name}.gltf"}
        write(files, index)
    if not only or "studio" in only:
        files["scenes/studio.exr"] = studio_map()
        write(files, index)


def write(files: dict[str, bytes], index: dict[str, object]) -> None:
    """Everything made so far, and the index of everything that is there."""
    for file, content in files.items():
        path = FOLDER / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    there = sorted(path for path in FOLDER.rglob("*") if path.is_file() and path.parent != FOLDER)
    index["sha256"] = {
        path.relative_to(FOLDER).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in there
    }
    (FOLDER / "index.json").write_text(json.dumps(index, indent=1) + "\n")
    total = sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file())
    print(f"{len(there)} files, {total / 2**20:.2f} MiB", flush=True)
    if total > MOST_BYTES:
        raise SystemExit("the suite is larger than 8 MiB")


def chart_entry(name: str, chart: Chart, files: dict[str, bytes]) -> dict[str, object]:
    """The files of one chart, and its row of the index."""
    xyz = chart.truth()
    spectra = reflectance(chart) if chart.illuminant == "D65" else None
    files[f"charts/{name}.csv"] = chart_csv(xyz, spectra)
    facts: dict[str, exr.Attribute] = {
        "iridesce:chart": name,
        "iridesce:stack": chart.stack,
        "iridesce:quantity": chart.quantity,
        "iridesce:illuminant": chart.illuminant,
    }
    planes = {letter: xyz[..., axis].astype(np.float32) for axis, letter in enumerate("XYZ")}
    files[f"charts/{name}.exr"] = exr.exr_bytes(planes, facts)
    entry: dict[str, object] = {
        "title": chart.title,
        "stack": chart.stack,
        "quantity": chart.quantity,
        "illuminant": chart.illuminant,
        "illuminant_white_xyz": ir.color.illuminant(chart.illuminant).white().tolist(),
        "grid": "24 x 7",
        "files": [f"charts/{name}.csv", f"charts/{name}.exr"],
    }
    if name[1:].isdigit() and int(name[1:]) <= 6:
        thickness = np.linspace(*RANGE_NM, lut.SIZE[0])[None, :]
        cosine = np.linspace(0.0, 1.0, lut.SIZE[1])[:, None]
        table = lut.Lut(
            chart.xyz(thickness, grazing_deg(cosine)), RANGE_NM, chart.quantity, chart.illuminant, chart.stack
        )
        stated = lut.error(lut.stored(table), chart.film())
        files[f"charts/{name}_table.exr"] = lut.exr_file(table, stated)
        entry["table"] = f"charts/{name}_table.exr"
        entry["table_delta_e"] = {key: round(value, 4) for key, value in stated.items()}
    return entry


def reflectance(chart: Chart) -> np.ndarray:
    """The spectra, (7, 24, 31), of the chart's quantity; media beyond their data by their stated extension."""
    film = chart.film()
    t = np.array(THICKNESS_NM)[None, :]
    t = t if chart.moved is None else chart.moved(t)
    angle = np.array(ANGLES_DEG)[:, None]
    rows = []
    for wavelength in WAVELENGTH_NM:
        first, layer, last = (complex(extended_index(medium, [wavelength])[0]) for medium in film.stack.media)
        stack = ir.Stack([first.real, ir.Layer(layer, t), last])
        r, through = stack.reflectance(wavelength, angle), stack.transmittance(wavelength, angle)
        rows.append({"reflectance": r, "transmittance": through, "furnace": r + through}[chart.quantity])
    return np.stack(rows, axis=-1)


def chart_csv(xyz: np.ndarray, spectra: np.ndarray | None) -> bytes:
    """A row a patch: thickness, angle, XYZ, sRGB (hue kept), and the power ratio at 31 wavelengths."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    head = ["thickness_nm", "angle_deg", "X", "Y", "Z", "sR", "sG", "sB"]
    if spectra is not None:
        head += [f"{wavelength:g}nm" for wavelength in WAVELENGTH_NM]
    writer.writerow(head)
    srgb, _ = ir.color.map_gamut(ir.color.convert(xyz, "xyz", "srgb"), "srgb", "hue")
    for row, angle in enumerate(ANGLES_DEG):
        for column, thickness in enumerate(THICKNESS_NM):
            values = [f"{x:.6g}" for x in (thickness, angle, *xyz[row, column], *srgb[row, column])]
            if spectra is not None:
                values += [f"{x:.5g}" for x in spectra[row, column]]
            writer.writerow(values)
    return text.getvalue().encode("ascii")


def scenes_of() -> dict[str, tuple[str, dict]]:
    """The scenes: small trees, so that another renderer can build them by hand."""
    black = {"diffuse": {"reflectance": 0.0}}
    soap = {"film": {"medium": "soap", "thickness_nm": {"gradient": {"top": 100.0, "bottom": 900.0}}}}
    uniform = [{"environment": {"illuminant": "D65", "radiance": 1.0}}]
    fan, camera = [], {"position": [0.0, 0.0, 400.0], "orthographic_height": 14.0, "resolution": [512, 512]}
    for number, angle in enumerate(ANGLES_DEG):
        # Each quad is seen 1.8 wide and leans to the right; each stands 40 nearer than the one on its left, so that
        # none sees another in its mirror. A black one right behind each takes what it passes.
        x, tilt = 2.0 * (number - 3), np.radians(angle)
        half, normal = 0.9 / np.cos(tilt), np.array([np.sin(tilt), 0.0, np.cos(tilt)])
        u, v = [half * np.cos(tilt), 0.0, -half * np.sin(tilt)], [0.0, 6.5, 0.0]
        center = np.array([x, 0.0, 40.0 * number])
        film = {"from": [0.0, -6.5, 0.0], "to": [0.0, 6.5, 0.0], "start_nm": 50.0, "end_nm": 1200.0}
        surface = {"film": {"medium": "soap", "thickness_nm": {"wedge": film}}}
        for name, place, skin in (("quad", center, surface), ("behind", center - 0.01 * normal, black)):
            shape = {"rectangle": {"center": place.tolist(), "u": u, "v": v}}
            fan.append({"name": f"{name}-{angle:g}", "shape": shape, "surface": skin})
    ball = {"sphere": {"center": [0.0, 0.0, 0.0], "radius": 4.0}}
    inner = {"sphere": {"center": [0.0, 0.0, 0.0], "radius": 3.99}}
    seen = {"position": [0.0, 0.0, 16.0], "fov_deg": 35.0, "resolution": [512, 512]}
    bubble = {"name": "bubble", "shape": ball, "surface": soap}
    rings = {name: ir.Scene.load(name).to_dict() for name in ("newtons-rings", "newtons-rings-sodium")}
    ball_inside = {"name": "ball", "shape": inner, "surface": black}
    studio = [{"environment": {"builtin": "studio"}}]
    made = {
        "S1": ("seven flat quads of soap, 0 to 85 degrees, 50 to 1200 nm upwards, uniform D65", fan, camera, uniform),
        "S2": ("a sphere of soap around a black ball: mirrored alone", [bubble, ball_inside], seen, studio),
        "S3": ("a sphere of soap: mirrored and passed", [bubble], seen, studio),
    }
    trees = {name: (title, tree(objects, view, light)) for name, (title, objects, view, light) in made.items()}
    trees["S4-daylight"] = ("Newton's rings, D65", rings["newtons-rings"])
    trees["S4-sodium"] = ("Newton's rings, sodium", rings["newtons-rings-sodium"])
    trees["S5"] = ("an anodised titanium coin, domed and rough, under the studio", tree([coin()], seen, studio))
    trees["S6"] = ("the bubble of the built-in scene under the studio", ir.Scene.load("soap-bubble").to_dict())
    return trees


def coin() -> dict:
    """20 nm of oxide on the left rim to 220 nm on the right one; facets of GGX with alpha = 0.35^2."""
    oxide = {"from": [-4.0, 0.0, 0.0], "to": [4.0, 0.0, 0.0], "start_nm": 20.0, "end_nm": 220.0}
    layer = {"medium": "TiO2", "thickness_nm": {"wedge": oxide}}
    face = {"center": [0.0, 0.0, 0.0], "axis": [0.0, 0.35, 1.0], "radius_of_curvature": 12.0, "aperture_radius": 4.0}
    return {
        "name": "coin",
        "shape": {"cap": face},
        "surface": {"coating": {"layers": [layer], "substrate": "Ti", "roughness": 0.35}},
    }


def studio_map() -> bytes:
    """The built-in studio as a map, latitude-longitude as in `docs/reference/conventions.md`: seen through six windows
    of 90 degrees, four times as fine as the map, and read at the middles of its texels."""
    height, width, fine = 512, 1024, 2048
    polar = np.pi * (np.arange(height) + 0.5)[:, None] / height
    turn = 2.0 * np.pi * ((np.arange(width) + 0.5)[None, :] / width - 0.5)
    way = np.stack(
        np.broadcast_arrays(np.sin(polar) * np.sin(turn), np.cos(polar), -np.sin(polar) * np.cos(turn)), axis=-1
    )
    radiance = np.zeros((height, width))
    # Far from the windows, black and too small to be seen: a scene has at least one object.
    speck = {"shape": {"sphere": {"center": [0, 0, 9e5], "radius": 1e-3}}, "surface": {"diffuse": {"reflectance": 0}}}
    for axis in range(3):
        for sign in (-1.0, 1.0):
            ahead, up = sign * np.eye(3)[axis], np.eye(3)[(axis + 1) % 3]
            right = np.cross(ahead, up)
            view = {"position": [0, 0, 0], "target": ahead.tolist(), "up": up.tolist(), "fov_deg": 90.0}
            scene = tree([speck], view, [{"environment": {"builtin": "studio"}}])
            seen = ir.render(ir.Scene.load(scene), samples=1, size=(fine, fine)).xyz[..., 1]
            front = np.argmax(np.abs(way), axis=-1) == axis
            front &= way @ ahead > 0.0
            towards = way[front] / (way[front] @ ahead)[:, None]
            column = np.clip((0.5 + 0.5 * (towards @ right)) * fine, 0, fine - 1).astype(int)
            row = np.clip((0.5 - 0.5 * (towards @ up)) * fine, 0, fine - 1).astype(int)
            radiance[front] = seen[row, column]
    grey = coarse(radiance, 8).astype(np.float16)
    return exr.exr_bytes(dict.fromkeys("RGB", grey), {"iridesce:light": "studio; grey: radiance times D65"})


def tree(objects: list, camera: dict, light: list) -> dict:
    return {"version": 1, "unit": "cm", "camera": camera, "render": {"samples": 16}, "object": objects, "light": light}


def scene_entry(name: str, title: str, tree: dict, files: dict[str, bytes]) -> dict[str, object]:
    """The picture with its uncertainty, the scene as text, its geometry; and its row of the index."""
    scene = ir.Scene.load(tree)
    # Facets scatter: the coin's noise is that of the light, not of fringes within a pixel.
    samples = {"S4": 2, "S5": 16}.get(name[:2], 4)
    pictures = np.stack([ir.render(scene, samples=samples, seed=seed, size=(512, 512)).xyz for seed in SEEDS]).astype(
        np.float64
    )
    mean = pictures.mean(axis=0)
    sigma = pictures[..., 1].std(axis=0, ddof=1) / np.sqrt(len(SEEDS))
    planes = {letter: mean[..., axis].astype(np.float16) for axis, letter in enumerate("XYZ")}
    # Three bits of sigma are enough, and pack well.
    planes["sigma_Y"] = coarse(sigma).astype(np.float16)
    facts: dict[str, exr.Attribute] = {
        "iridesce:scene": name,
        "iridesce:samples": samples * len(SEEDS),
        "iridesce:simd": _core.SIMD_LEVEL,
    }
    files[f"scenes/{name}.exr"] = exr.exr_bytes(planes, facts)
    files[f"scenes/{name}.toml"] = scene.check().encode("utf-8")
    return {
        "title": title,
        "picture": f"scenes/{name}.exr",
        "channels": "X, Y, Z, sigma_Y (standard error of Y); half floats, 512 x 512",
        "samples": samples * len(SEEDS),
        "scene": f"scenes/{name}.toml",
        "camera": scene.to_dict()["camera"],
    }


def gltf_files(name: str, tree: dict, before: dict[str, bytes]) -> dict[str, bytes]:
    """Geometry, camera, films and their maps as `ir.export` writes them, every file under the name of the first scene that
    has it."""
    with tempfile.TemporaryDirectory() as folder:
        report = ir.export(tree, "gltf", folder)
        contents = {path.name: path.read_bytes() for path in report.files}
    root = json.loads(contents.pop("scene.gltf"))
    known = {content: file.removeprefix("scenes/") for file, content in before.items() if file.startswith("scenes/")}
    made = {}
    for part in (*root["buffers"], *root.get("images", ())):
        content = contents[part["uri"]]
        own = f"{name}.bin" if part["uri"] == "scene.bin" else f"{name}_{part['uri']}"
        part["uri"] = known.setdefault(content, own)
        made[f"scenes/{part['uri']}"] = content
    return {f"scenes/{name}.gltf": (json.dumps(root, separators=(",", ":")) + "\n").encode("ascii"), **made}


def coarse(values: np.ndarray, bits: int = 3) -> np.ndarray:
    mantissa, exponent = np.frexp(values)
    return np.ldexp(np.round(mantissa * 2.0**bits) / 2.0**bits, exponent)


def geometry(tree: dict) -> bytes:
    """Wavefront OBJ of all objects, v upwards; spheres and caps in few triangles, as a guide: the truth is the .toml."""
    from iridesce.exchange.geometry import surface_of

    lines, start = ["# lengths in scene units; one group an object"], 1
    for item in tree["object"]:
        surface = surface_of(item["shape"])
        assert surface is not None
        if surface.kind == "sphere":
            mesh = surface._grid(32, 16)
        else:
            mesh = surface._rings(48, 8) if surface.kind == "cap" else surface.mesh(extent=100.0)
        assert mesh.uv is not None and mesh.normals is not None
        lines.append(f"g {item['name']}")
        lines += ["v " + " ".join(f"{x:.6g}" for x in p) for p in mesh.positions]
        lines += ["vt " + " ".join(f"{x:.5g}" for x in p) for p in mesh.uv]
        lines += ["vn " + " ".join(f"{x:.5g}" for x in p) for p in mesh.normals]
        lines += [
            "f " + " ".join(f"{i + start}/{i + start}/{i + start}" for i in triangle) for triangle in mesh.triangles
        ]
        start += len(mesh.positions)
    return ("\n".join(lines) + "\n").encode("ascii")


if __name__ == "__main__":
    main()
