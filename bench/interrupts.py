"""How long Ctrl-C takes: for each long call the worst of some tries, in a script and in the command line.

    python bench/interrupts.py                 # all calls, 20 tries each
    python bench/interrupts.py --tries 5 render

A try starts a process, waits until the call runs, sends SIGINT after a random while and measures until the process has said
KeyboardInterrupt (a script) or has left with exit code 130 (the command line, with Python's own way out, some 50 ms).
Promised: 0.3 s.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
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
        "scene = ir.Scene.load('soap-bubble').to_dict(); scene['light'] = [{'environment': {'map': folder + '/sky.hdr'}}]",
        "ir.Scene.load(scene, allow_outside=True)",
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

SCRIPT = """
import os, sys, time
folder = os.environ["FOLDER"]
import numpy as np
import iridesce as ir
{prepare}
{warm}
print("ready", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("heard", time.monotonic(), flush=True)
    os._exit(0)
print("over", flush=True)
os._exit(0)
"""


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


def one_script(name: str, folder: Path, delay: float, first: bool) -> float | None:
    """Seconds from the signal to KeyboardInterrupt; None where the call was over before."""
    prepare, call = CALLS[name]
    warm = (
        "" if first else "ir.Stack(['air', ir.Layer('soap', thickness_nm=np.linspace(0, 900, 20_000)), 'air']).color()"
    )
    script = SCRIPT.format(prepare=prepare, call=call, warm=warm)
    env = {**os.environ, "FOLDER": str(folder)}
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=env, text=True
    )
    assert process.stdout is not None and process.stderr is not None
    line = process.stdout.readline()
    if line != "ready\n":
        raise RuntimeError(f"{name}: {process.stderr.read()}")
    time.sleep(delay)
    sent = time.monotonic()
    process.send_signal(signal.SIGINT)
    words = process.stdout.readline().split()
    process.wait()
    if words[:1] == ["over"]:
        return None
    if words[:1] != ["heard"]:
        raise RuntimeError(f"{name}: {words} {process.stderr.read()}")
    return float(words[1]) - sent


def one_command(name: str, folder: Path, delay: float) -> float:
    """Seconds from the signal to the end of the process."""
    command = [sys.executable, "-m", "iridesce", *COMMANDS[name].split()]
    with tempfile.TemporaryDirectory(dir=folder) as place:
        process = subprocess.Popen(command, cwd=place, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(1.5 + delay)
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, told = process.communicate()
        seconds = time.monotonic() - sent
    if process.returncode != 130:
        raise RuntimeError(f"{name}: exit {process.returncode}, {told}")
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tries", type=int, default=20)
    parser.add_argument("names", nargs="*", help="only calls whose name holds one of these")
    arguments = parser.parse_args()
    chance = random.Random(1)

    def wanted(name: str) -> bool:
        return not arguments.names or any(part in name for part in arguments.names)

    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        if any(wanted(name) and name.split()[-1] in READ for name in CALLS):
            large_files(folder)
        print(f"{'call':<32} {'worst, ms':>10} {'median':>8} {'first call':>11}")
        for name in filter(wanted, CALLS):
            columns = []
            for first in (False, True):
                tries = [one_script(name, folder, chance.uniform(0.02, 0.5), first) for _ in range(arguments.tries)]
                columns.append(sorted(1e3 * seconds for seconds in tries if seconds is not None))
            warm, cold = columns
            if not warm or not cold:
                print(f"{name:<32} over before it was interrupted")
                continue
            print(f"{name:<32} {warm[-1]:10.0f} {warm[len(warm) // 2]:8.0f} {cold[-1]:11.0f}", flush=True)
        for name in filter(wanted, COMMANDS):
            tries = sorted(1e3 * one_command(name, folder, chance.uniform(0.0, 0.5)) for _ in range(arguments.tries))
            print(f"{name:<32} {tries[-1]:10.0f} {tries[len(tries) // 2]:8.0f}", flush=True)


if __name__ == "__main__":
    main()
