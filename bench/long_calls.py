"""Calls that take long, and the large files that they read."""

from __future__ import annotations

from pathlib import Path

# What is prepared before the call, and the call; each runs for some seconds at least.
CALLS = {
    "render": ("", 'ir.render("soap-bubble", samples=4096, size=(512, 512))'),
    "render, one thread": ("", 'ir.render("soap-bubble", samples=4096, size=(512, 512), threads=1)'),
    "render of a film that flows": (
        'f = {"flow": {"preset": "bubble-on-bath", "time_s": 60.0, "seed": 9}}',
        'ir.render(ir.Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", f), size=(8, 8))',
    ),
    "simulate": ("s = ir.thickness.simulate('bubble-on-bath', time_s=100.0, frames_per_second=0.02)", "list(s)"),
    "Stack.color": (
        "s = ir.Stack(['air', ir.Layer('soap', thickness_nm=np.linspace(0, 9e4, 3_000_000)), 'air'])",
        "s.color(angle_deg=np.linspace(0, 80, 3_000_000))",
    ),
    "Stack.reflectance": (
        "s = ir.Stack(['air', *[ir.Layer(1.3 + i % 2 / 2, 100.0) for i in range(400)], 'air'])\n"
        "nm = np.linspace(400, 800, 2_000_000)",
        "s.reflectance(nm, 30.0)",
    ),
    "Stack.reflectance, slabs": (
        "s = ir.Stack(['air', ir.Layer('SiO2', np.linspace(0, 900, 3_000_000)), ir.Layer(1.5, 1e6, coherent=False), 'air'])",
        "s.reflectance(550.0, [[0.0], [30.0], [60.0]])",
    ),
    "Stack.derivatives": (
        "s = ir.Stack(['air', *[ir.Layer(1.3 + i % 2 / 2, 100.0) for i in range(40)], 'air'])\n"
        "nm = np.linspace(400, 800, 200_000)",
        "s.derivatives('reflectance', nm)",
    ),
    "ColorTable": (
        "s = ir.Stack(['air', ir.Layer('soap', thickness_nm=0.0), 'air'])",
        "ir.ColorTable(s, (0.0, 30_000.0), (0.0, 85.0), max_delta_e=0.005)",
    ),
    "ColorTable.color": (
        "t = ir.ColorTable(ir.Stack(['air', ir.Layer('soap', thickness_nm=0.0), 'air']), (0.0, 400.0))\n"
        "nm = np.full(40_000_000, 300.0)",
        "t.color(nm, 30.0, space='lab')",
    ),
    "fit_thickness": (
        "nm = np.linspace(400, 900, 2000); s = ir.Stack(['air', ir.Layer('SiO2', 20_000.0), 'Si']); m = s.reflectance(nm)",
        "[ir.fit_thickness(nm, m, s) for _ in range(50)]",
    ),
    "Medium.index": ("m = ir.Medium('Si'); nm = np.linspace(400, 800, 60_000_000)", "m.index(nm)"),
    "Image.rgb": (
        "i = ir.Image(np.full((6000, 6000, 3), 0.5, np.float32))",
        "[i.rgb(exposure='auto') for _ in range(50)]",
    ),
    "Image.save png": (
        "i = ir.Image(np.random.default_rng(1).random((6000, 6000, 3), np.float32))",
        "[i.save(folder + '/x.png') for _ in range(50)]",
    ),
    "Image.save exr": (
        "i = ir.Image(np.random.default_rng(1).random((6000, 6000, 3), np.float32))",
        "[i.save(folder + '/x.exr') for _ in range(50)]",
    ),
    "ThicknessMap.load png": ("", "ir.thickness.ThicknessMap.load(folder + '/map.png', 0.0, 900.0)"),
    "ThicknessMap.load exr": ("", "ir.thickness.ThicknessMap.load(folder + '/map.exr')"),
    "environment hdr": (
        "scene = ir.Scene.load('soap-bubble').to_dict(); scene['light'] = [{'environment': {'map': folder + '/sky.hdr'}}]\n"
        "scene = ir.Scene.load(scene, allow_outside=True)",
        "scene.resolve()",
    ),
}
# Last words of the calls that read large files.
READ = ("png", "exr", "hdr", "progressive", "ply", "obj", "mesh")
MEDIA = (
    'media=["SiO2", "TiO2", "MgF2", "Si3N4", "Al2O3", "Ta2O5", "HfO2", "PMMA", "ZnS"], substrate="Si", layers=(1, 2, 3)'
)
SHEET = (
    "shape = {'mesh': {'file': folder + '/sheet.' + ending}}\n"
    "film = {'film': {'medium': 'soap', 'thickness_nm': 300.0}}\n"
    "light = [{'environment': {'illuminant': 'D65'}}]\n"
    "scene = {'version': 1, 'camera': {'resolution': [8, 8]}, 'object': [{'shape': shape, 'surface': film}], 'light': light}\n"
    "scene = ir.Scene.load(scene, allow_outside=True)"
)
CALLS |= {
    "photograph jpeg, progressive": (
        "camera = dict(camera='srgb', illuminant='D65')",
        "ir.map_thickness(folder + '/photo.jpg', 'air / soap ? / air', **camera)",
    ),
    "mesh ply": ("ending = 'ply'\n" + SHEET, "scene.resolve()"),
    "mesh obj": ("ending = 'obj'\n" + SHEET, "scene.resolve()"),
    "render of a mesh": (
        "ending = 'ply'\n" + SHEET + "\nscene.resolve()",
        "ir.render(scene, samples=4096, size=(512, 512))",
    ),
    "map_thickness": (
        "nm = np.linspace(150, 900, 1600) + 100 * np.sin(np.arange(1200)[:, None] / 99)\n"
        "photo = ir.Stack(['air', ir.Layer('soap', nm), 'air']).color(space='linear-srgb')\n"
        "camera = dict(camera='srgb', illuminant='D65')",
        "[ir.map_thickness(photo, 'air / soap ? / air', **camera) for _ in range(9)]",
    ),
    "map_thickness_video": (
        "nm = np.linspace(150, 900, 640) + 100 * np.sin(np.arange(480)[:, None] / 99)\n"
        "photo = ir.Stack(['air', ir.Layer('soap', nm), 'air']).color(space='linear-srgb')\n"
        "camera = dict(camera='srgb', illuminant='D65')",
        "list(ir.map_thickness_video([photo] * 40, 'air / soap ? / air', **camera))",
    ),
    "fit_series": (
        "nm = np.arange(450.0, 800.0, 1.0)\n"
        "film = ir.Stack(['air', ir.Layer('soap', thickness_nm=np.linspace(2400.0, 900.0, 400)[:, None]), 'air'])\n"
        "r = film.reflectance(nm)",
        "[ir.fit_series(nm, r, 'air / soap ? / air') for _ in range(9)]",
    ),
    "recipes": ("", f"[ir.recipes([40.0, 10.0, -40.0], {MEDIA}) for _ in range(9)]"),
    "sweep of colours": (
        "",
        "ir.sweep('air / soap 320 / air', {'layers.0.thickness_nm': np.linspace(0, 999, 50_000)})",
    ),
    "sweep of pictures": (
        "",
        "ir.sweep('soap-bubble', {'render.seed': range(1, 1000)}, store=folder + f'/{os.getpid()}')",
    ),
    "export": ("", "[ir.export('soap-bubble', 'usd', folder + f'/e{os.getpid()}.{i}') for i in range(999)]"),
    "merge": (
        "image = ir.render('wafer', samples=1, size=(1024, 1024))\n"
        "parts = [folder + f'/{os.getpid()}-{i}.exr' for i in (1, 2)]\n"
        "for i, part in enumerate(parts): ir.render('wafer', samples=1, size=(1024, 1024), shard=(i + 1, 2)).save(part)",
        "[ir.merge(parts) for _ in range(999)]",
    ),
}
COMMANDS = {
    "iridesce render": "render soap-bubble --samples 4096 -o x.png",
    "iridesce animate": "animate soap-bubble --seconds 10 --fps 30 --samples 64 -o x.mp4 --size 256x256",
    "iridesce flow": "flow bubble-on-bath --time 100 -o run",
}


def large_files(folder: Path) -> None:
    """Maps of 8192 x 8192 (a thickness, twice) and 8192 x 4096 (a sky), so that reading them takes seconds."""
    import numpy as np

    import iridesce as ir

    side = 8192
    values = np.random.default_rng(2).integers(0, 65535, (side, side), np.uint16)
    png = [b"\x89PNG\r\n\x1a\n"]
    import struct
    import zlib

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = np.zeros((side, 2 * side + 1), np.uint8)
    rows[:, 1:] = values.astype(">u2").view(np.uint8).reshape(side, 2 * side)
    png += [
        chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 16, 0, 0, 0, 0)),
        chunk(b"IDAT", zlib.compress(rows.tobytes(), 1)),
    ]
    (folder / "map.png").write_bytes(b"".join([*png, chunk(b"IEND", b"")]))
    ir.thickness.ThicknessMap(values.astype(np.float64)).save(folder / "map.exr")
    pixels = np.random.default_rng(3).integers(1, 255, (side // 2, side, 4), np.uint8)
    from PIL import Image

    grey = Image.fromarray((values >> 8).astype(np.uint8))
    Image.merge("RGB", [grey] * 3).save(folder / "photo.jpg", progressive=True, quality=60)
    sheet(folder)
    (folder / "sky.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4096 +X 8192\n" + pixels.tobytes())


def sheet(folder: Path) -> None:
    """A wavy sheet of 2 million triangles, as PLY and OBJ."""
    import numpy as np

    side = 1000
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side)))
    places = np.column_stack([i, j, 9.0 * np.sin(i * 0.05) * np.cos(j * 0.03)]).astype("<f4")
    at = (np.arange(side - 1) + side * np.arange(side - 1)[:, None]).ravel()
    corners = np.concatenate([at[:, None] + [0, 1, side], at[:, None] + [1, side + 1, side]]).astype("<i4")
    faces = np.zeros(len(corners), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, corners
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(places)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    (folder / "sheet.ply").write_bytes(head.encode() + places.tobytes() + faces.tobytes())
    with (folder / "sheet.obj").open("w") as file:
        np.savetxt(file, places, "v %g %g %g")
        np.savetxt(file, corners + 1, "f %d %d %d")
