"""Every reader of the package: seeds, and how it is asked."""

from __future__ import annotations

import functools
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pictures

ROOT = Path(__file__).parents[2]


class Reader(NamedTuple):
    """Seeds are made anew by each process, and are the same each time."""

    name: str
    seeds: Callable[[Path], list[bytes]]
    read: Callable[[bytes, Path], Any]
    is_text: bool = False


def _file(name: str, ask: Callable[[Path], Any]) -> Callable[[bytes, Path], Any]:
    def read(content: bytes, folder: Path) -> Any:
        path = folder / name
        path.write_bytes(content)
        return ask(path)

    return read


# --- seeds


def _scenes(_: Path) -> list[bytes]:
    return [path.read_bytes() for path in sorted((ROOT / "scenes").glob("*.toml"))]


def _scenes_json(_: Path) -> list[bytes]:
    import json

    import iridesce as ir

    return [json.dumps(ir.Scene.load(name).to_dict()).encode() for name in ("soap-bubble", "newtons-rings", "wafer")]


def _indices(_: Path) -> list[bytes]:
    data = ROOT / "crates" / "optics" / "data" / "media"
    pages = [path.read_bytes() for path in sorted(data.rglob("*.y*ml")) if path.stat().st_size < 5000][:6]
    tables = [
        b"nm,n,k\n400,1.5,0.1\n500,1.6,0.2\n600,1.7,0.3\n",
        b"wavelength (um);e1;e2\n0,4;2,25;0\n0,5;2,3;0,01\n",
        b"wl,n\n0.4,1.5\n0.5,1.6\n\nwl,k\n0.4,0.1\n0.5,0.2\n",
        b"# Smith 2020\n400 1.5\n500 1.6\n",
    ]
    return pages + tables


def _lamps(_: Path) -> list[bytes]:
    return [
        b"nm,power\n360,10\n400,20\n500,90.5\n600,100\n700,80\n830,20\n",
        "um;Leistung\n0,83;20\n0,6;100\n0,5;90,5\n0,4;-0,1\n".encode("utf-16"),
        b"# lamp\n400\t1\n500\t2\n600\t3 # peak\n",
    ]


def _spectra(_: Path) -> list[bytes]:
    rows = [(400.1 + 0.6 * i, 4.2 + (i * 37 % 11) / 10) for i in range(40)]
    comma = "\n".join(f"{x:.2f};1200;48000,5;{y * 100:.1f};{y:.3f}".replace(".", ",") for x, y in rows)
    jcamp = "##TITLE= x\n##XUNITS= NANOMETERS\n##YUNITS= REFLECTANCE\n##NPOINTS= 4\n##XYPOINTS= (XY..XY)\n"
    return [
        "\n".join(f"{x:.2f}\t{y}" for x, y in rows).encode(),
        ("Probe 7; 25 ms\nWave;Dark;Ref;Sample;Reflectance\n[nm];[counts];[counts];[counts];[%]\n" + comma).encode(),
        (jcamp + "400.1, 0.042; 400.6, 0.044\n401.1, 0.041; 402, 0.04\n##END=\n").encode(),
        b"##TITLE= x\n##FIRSTX= 400\n##LASTX= 402\n##NPOINTS= 3\n##YFACTOR= 0.001\n"
        b"##XYDATA= (X++(Y..Y))\n400 +42+44\n402 +41\n##END=\n",
        b'"Wavelength (nm)","Measured Reflectance","Calculated Reflectance"\n400.1,0.042,0.0421\n400.6,0.044,0.0440\n',
        "Wellenl\u00e4nge [\u00b5m];R [%]\n0,500;4,2\n0,510;4,4\n0,520;4,1\n".encode("utf-16"),
    ]


def _pixels() -> Any:
    import numpy as np

    return (np.arange(48, dtype=np.float64).reshape(6, 8) * 7.0) % 255.0


def _tiffs(_: Path) -> list[bytes]:
    import tifffile

    made = []
    for values, options in (
        (
            _pixels().astype("float32"),
            {"imagej": True, "metadata": {"unit": "mm", "vunit": "nm", "c0": 0.0, "c1": 1.0}},
        ),
        (_pixels().astype("uint16"), {"extratags": [(274, 3, 1, 6, True)]}),
        (_pixels().astype("uint8"), {"compression": "zlib"}),
    ):
        buffer = io.BytesIO()
        tifffile.imwrite(buffer, values, **options)  # type: ignore[arg-type]
        made.append(buffer.getvalue())
    buffer = io.BytesIO()
    with tifffile.TiffWriter(buffer) as writer:
        writer.write(_pixels().astype("uint16"))
        writer.write(_pixels().astype("uint16"))
    return [*made, buffer.getvalue()]


def _pngs(folder: Path) -> list[bytes]:
    import matplotlib.image
    import numpy as np

    import iridesce as ir

    made = []
    image = ir.Image(np.repeat(_pixels()[..., None] / 255.0, 3, axis=2), metadata={"note": "x" * 200})
    for space, bits in (("srgb", 8), ("display-p3", 16)):
        path = folder / "seed.png"
        image.save(path, exposure=0.0, space=space, bits=bits)
        made.append(path.read_bytes())
    buffer = io.BytesIO()
    matplotlib.image.imsave(buffer, _pixels().astype("uint8"), format="png", cmap="gray")
    return [*made, buffer.getvalue()]


def _npys(_: Path) -> list[bytes]:
    import numpy as np

    made = []
    for values in (_pixels(), _pixels().astype("<f2"), np.asfortranarray(_pixels().astype(">u2"))):
        buffer = io.BytesIO()
        np.save(buffer, values)
        made.append(buffer.getvalue())
    return made


def _exrs(folder: Path) -> list[bytes]:
    import numpy as np

    import iridesce as ir

    path = folder / "seed.exr"
    ir.thickness.ThicknessMap(_pixels()).save(path)
    made = [path.read_bytes()]
    ir.Image(np.repeat(_pixels()[..., None] / 255.0, 3, axis=2), thickness_nm=_pixels()).save(path)
    return [*made, path.read_bytes()]


def _skies(folder: Path) -> list[bytes]:
    """Twice as wide as high: other shapes are refused as cube maps."""
    import numpy as np

    import iridesce as ir

    path = folder / "sky.exr"
    ir.Image(np.repeat(_pixels()[:4, :, None] / 255.0, 3, axis=2)).save(path)
    return [path.read_bytes(), (ROOT / "scenes" / "maps" / "two-windows.exr").read_bytes()]


def _hdrs(_: Path) -> list[bytes]:
    flat = bytes(value for pixel in range(8 * 4) for value in (pixel * 7 % 256, pixel, 200, 120 + pixel % 16))
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n"
    runs = b"".join(b"\x02\x02\x00\x10" + 4 * (b"\x88\x40\x08" + bytes(range(8))) for _ in range(8))
    return [
        head + b"EXPOSURE=2\nCOLORCORR=1 1 1\n\n-Y 4 +X 8\n" + flat,
        head + b"PRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329\n\n-Y 8 +X 16\n" + runs,
        head + b"\n+X 4 -Y 8\n" + flat,
    ]


def _jpegs(_: Path) -> list[bytes]:
    import numpy as np
    from PIL import Image, ImageCms

    made = []
    pixels = np.repeat(_pixels()[..., None].astype("uint8"), 3, axis=2)
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    exif = Image.Exif()
    exif[274] = 6
    for options in ({}, {"progressive": True, "icc_profile": profile}, {"exif": exif.tobytes(), "quality": 95}):
        buffer = io.BytesIO()
        Image.fromarray(pixels).save(buffer, "JPEG", **options)
        made.append(buffer.getvalue())
    return made


def _tables(folder: Path) -> list[bytes]:
    import iridesce as ir

    film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=0.0), "air"])
    path = folder / "seed.exr"
    ir.ColorTable(film, (0.0, 300.0), angle_deg=(0.0, 30.0), max_delta_e=1.0).save(path)
    return [path.read_bytes()]


@functools.cache
def _film() -> Any:
    import iridesce as ir

    film = ir.thickness.simulate("late", 0.1, 30.0, columns=64, regeneration=0.0)
    next(film)
    return film.checkpoint()


def _checkpoints(_: Path) -> list[bytes]:
    return [_film()]


def _paths(_: Path) -> list[bytes]:
    return [
        b"[[key]]\ntime_s = 0.0\nposition = [0.0, 0.0, 16.0]\n\n[[key]]\ntime_s = 2.0\nfov_deg = 20.0\ntarget = [0, 1, 0]\n",
        b"key = [{ time_s = 0.0, fov_deg = 35.0 }, { time_s = 1.5 }]\n",
    ]


TETRAHEDRON = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def _objs(_: Path) -> list[bytes]:
    points = "".join(f"v {x} {y} {z}\nvt {x} {y}\nvn {x} {y} 1\n" for x, y, z in TETRAHEDRON)
    plain = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES)
    full = "".join("f " + " ".join(f"{k + 1}/{k + 1}/{k + 1}" for k in face) + "\n" for face in FACES)
    return [f"mtllib a.mtl\no thing\n{points}{plain}".encode(), f"{points}usemtl x\n{full}".encode()]


def _plys(_: Path) -> list[bytes]:
    import struct

    head = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float thickness_nm\n"
    head += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    text = "".join(f"{x} {y} {z} 300\n" for x, y, z in TETRAHEDRON)
    text += "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    seeds = [f"ply\nformat ascii 1.0\n{head}{text}".encode()]
    for order, sign in (("little", "<"), ("big", ">")):
        data = b"".join(struct.pack(f"{sign}4f", *point, 300.0) for point in TETRAHEDRON)
        data += b"".join(struct.pack(f"{sign}B3i", 3, *face) for face in FACES)
        seeds.append(f"ply\nformat binary_{order}_endian 1.0\n{head}".encode() + data)
    return seeds


def _gltfs(_: Path) -> list[bytes]:
    import base64
    import json
    import struct

    data = b"".join(struct.pack("<3f", *point) for point in TETRAHEDRON)
    data += b"".join(struct.pack("<3H", *face) for face in FACES)
    tree: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [1, 2, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
    }
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    inside = json.dumps({**tree, "buffers": [{"byteLength": len(data), "uri": uri}]}).encode()
    chunk = json.dumps({**tree, "buffers": [{"byteLength": len(data)}]}).encode()
    chunk += b" " * (-len(chunk) % 4)
    body = struct.pack("<I4s", len(chunk), b"JSON") + chunk + struct.pack("<I4s", len(data), b"BIN\0") + data
    return [inside, b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body]


def _pictures(folder: Path) -> list[bytes]:
    """Bytes of which `pictures` makes a scene; the mesh that it may name stands in the folder."""
    (folder / "thing.ply").write_bytes(_plys(folder)[0])
    return [bytes(range(start, start + 16)) for start in range(0, 160, 16)]


def _stacks(_: Path) -> list[bytes]:
    return [
        b"air / soap 320 / air",
        b"air / TiO2 60 / 2.0+3.0j 10 / Ti",
        b"air / MgF2 100 / N-BK7 1e6 incoherent / air",
        b"1.5 / SiO2 ? / Si",
    ]


def _settings(_: Path) -> list[bytes]:
    return [
        b"object.bubble.surface.film.thickness_nm=400",
        b"camera.position=[0.0, 1.0, 16.0]",
        b"render.samples=16",
        b"object.bubble.surface.film.thickness_nm={ gradient = { top = 0.0, bottom = 800.0 } }",
        b"light.0.environment.radiance=2",
    ]


# --- asking


def _scene(path: Path) -> Any:
    import iridesce as ir

    return ir.Scene.load(path)


def _index(path: Path) -> Any:
    import iridesce as ir

    return ir.Medium.from_file(path).index(550.0, extrapolate="hold")


def _lamp(path: Path) -> Any:
    import iridesce as ir

    white = ir.color.spectrum_to_xyz([400.0, 700.0], [1.0, 1.0], illuminant=ir.color.illuminant(path))
    if not all(abs(value) < 1e300 for value in white):
        raise AssertionError(f"white is {white}")
    return white


def _spectrum(path: Path) -> Any:
    import iridesce as ir

    spectrum = ir.fit.read_spectrum(path)
    if not (spectrum.wavelength_nm > 0.0).all() or len(spectrum.wavelength_nm) != len(spectrum.measured):
        raise AssertionError("a spectrum that is none was read")
    return spectrum


def _map(path: Path) -> Any:
    import iridesce as ir

    try:
        return ir.thickness.ThicknessMap.load(path)
    except ValueError as error:
        if not str(error).startswith("min_nm"):
            raise
        return ir.thickness.ThicknessMap.load(path, min_nm=0.0, max_nm=1000.0)


def _environment(path: Path) -> Any:
    from iridesce import _core

    return _core.read_environment(path, None)


def _photograph(path: Path) -> Any:
    from iridesce import _core

    return _core.read_photograph(path, None, None)


def _table(path: Path) -> Any:
    import iridesce as ir

    return ir.ColorTable.load(path).color(100.0)


def _checkpoint(content: bytes, _: Path) -> Any:
    import iridesce as ir

    # Its check sum (FNV-1a) hides every other change: most inputs have a right one.
    if len(content) > 8 and content[-1] % 8:
        check = 0xCBF29CE484222325
        for byte in content[:-8]:
            check = (check ^ byte) * 0x100000001B3 % 2**64
        content = content[:-8] + check.to_bytes(8, "little")
    return ir.thickness.simulate("late", 0.1, 30.0, columns=64, regeneration=0.0, checkpoint=content)


def _path(path: Path) -> Any:
    from iridesce.rendering.animation import camera_path

    camera = {"position": [0.0, 0.0, 16.0], "target": [0.0, 0.0, 0.0], "up": [0.0, 1.0, 0.0], "fov_deg": 35.0}
    return camera_path(camera, 2.0, 0.0, path).at(1.0)


def _mesh(path: Path) -> Any:
    import json

    import iridesce as ir

    scene = {
        "version": 1,
        "camera": {"resolution": [4, 4]},
        "object": [{"name": "thing", "shape": {"mesh": {"file": path.name}}, "surface": {"dielectric": {}}}],
        "light": [{"environment": {"illuminant": "D65"}}],
    }
    beside = path.with_name("mesh.json")
    beside.write_text(json.dumps(scene))
    return ir.Scene.load(beside).resolve()


def _stack(content: bytes, _: Path) -> Any:
    import iridesce as ir
    from iridesce.optics.stack_text import parse_items

    items = parse_items(content.decode("utf-8", "replace"), open_layers=True)
    middle = [ir.Layer(item.medium, thickness_nm=item.thickness_nm, coherent=item.coherent) for item in items[1:-1]]
    return ir.Stack([items[0].medium, *middle, items[-1].medium])


@functools.cache
def _bubble() -> Any:
    import iridesce as ir

    return ir.Scene.load("soap-bubble")


def _set(content: bytes, _: Path) -> Any:
    from iridesce.cli.reading import assignment

    try:
        key, value = assignment(content.decode("utf-8", "replace"))
    except Exception as error:
        # Wrong usage, which the command line words by itself.
        if type(error).__name__ == "BadParameter":
            return None
        raise
    return _bubble().with_value(key, value)


READERS = {
    reader.name: reader
    for reader in (
        Reader("scene", _scenes, _file("scene.toml", _scene), True),
        Reader("scene-json", _scenes_json, _file("scene.json", _scene), True),
        Reader("index", _indices, _file("index.csv", _index), True),
        Reader("lamp", _lamps, _file("lamp.csv", _lamp), True),
        Reader("spectrum", _spectra, _file("spectrum.txt", _spectrum), True),
        Reader("map-exr", _exrs, _file("map.exr", _map)),
        Reader("map-tiff", _tiffs, _file("map.tif", _map)),
        Reader("map-png", _pngs, _file("map.png", _map)),
        Reader("map-npy", _npys, _file("map.npy", _map)),
        Reader("environment-exr", _skies, _file("map.exr", _environment)),
        Reader("environment-hdr", _hdrs, _file("map.hdr", _environment)),
        Reader("photograph-jpeg", _jpegs, _file("photo.jpg", _photograph)),
        Reader("photograph-png", _pngs, _file("photo.png", _photograph)),
        Reader("photograph-tiff", _tiffs, _file("photo.tif", _photograph)),
        Reader("table", _tables, _file("table.exr", _table)),
        Reader("checkpoint", _checkpoints, _checkpoint),
        Reader("camera-path", _paths, _file("path.toml", _path), True),
        Reader("mesh-obj", _objs, _file("thing.obj", _mesh), True),
        Reader("mesh-ply", _plys, _file("thing.ply", _mesh)),
        Reader("mesh-gltf", _gltfs, _file("thing.gltf", _mesh)),
        Reader("picture", _pictures, pictures.draw),
        Reader("picture-obj", _objs, functools.partial(pictures.draw_mesh, "thing.obj"), True),
        Reader("picture-ply", _plys, functools.partial(pictures.draw_mesh, "thing.ply")),
        Reader("picture-gltf", _gltfs, functools.partial(pictures.draw_mesh, "thing.gltf")),
        Reader("stack-text", _stacks, _stack, True),
        Reader("set", _settings, _set, True),
    )
}
