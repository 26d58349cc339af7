"""Draws films with LuxCore's own film, in its own environment: `lux_chart.py FILM_IOR BASE SAMPLES`.

BASE: an index, of its glass; thin:INDEX, of its thin-walled archglass; or three numbers with commas between: the colour of a
metal of its Disney material.

A parallel view of 24 squares of 50 to 1200 nm, tilted by each of the seven angles, lit all round by white, in front of
black. Prints {"version", "rgb": 7 x 24 x 3} as JSON, white = 1.
"""

import array
import json
import math
import os
import sys
import time

import pyluxcore

FILM, SAMPLES = float(sys.argv[1]), int(sys.argv[3])
GLASS = "archglass" if sys.argv[2].startswith("thin:") else "glass"
BASE = [float(word) for word in sys.argv[2].removeprefix("thin:").split(",")]
ANGLES = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0]
STEPS, SIDE = 24, 4


def square(name, scene, x0, x1, tilt, depth):
    """A strip from x0 to x1, turned about x, facing the camera at +z."""
    s, c = math.sin(tilt), math.cos(tilt)
    corners = [(x, y * c - depth * -s, y * s - depth * c) for x, y in ((x0, -40), (x1, -40), (x1, 40), (x0, 40))]
    scene.DefineMesh(name, corners, [(0, 1, 2), (0, 2, 3)], None, None, None, None)


def render(angle):
    scene = pyluxcore.Scene()
    tilt = math.radians(angle)
    text = {
        "scene.camera.type": ["orthographic"],
        "scene.camera.lookat.orig": [0.0, 0.0, 100.0],
        "scene.camera.lookat.target": [0.0, 0.0, 0.0],
        "scene.camera.up": [0.0, 1.0, 0.0],
        "scene.camera.screenwindow": [-1.0, 1.0, -1.0 / STEPS, 1.0 / STEPS],
        "scene.camera.autovolume.enable": [False],
        "scene.lights.sky.type": ["constantinfinite"],
        "scene.lights.sky.color": [1.0, 1.0, 1.0],
        "scene.materials.black.type": ["matte"],
        "scene.materials.black.kd": [0.0, 0.0, 0.0],
    }
    for step in range(STEPS):
        nm = 50.0 + 1150.0 * step / (STEPS - 1)
        key = f"scene.materials.film{step}"
        if len(BASE) == 3:
            text |= {f"{key}.type": ["disney"], f"{key}.basecolor": BASE, f"{key}.metallic": [1.0]}
            text |= {f"{key}.roughness": [0.0], f"{key}.filmamount": [1.0]}
        else:
            text |= {f"{key}.type": [GLASS], f"{key}.interiorior": BASE, f"{key}.exteriorior": [1.0]}
            text |= {f"{key}.kr": [1.0, 1.0, 1.0], f"{key}.kt": [1.0, 1.0, 1.0]}
        text |= {f"{key}.filmthickness": [nm], f"{key}.filmior": [FILM]}
    square("behind", scene, -2.0, 2.0, tilt, 0.5)
    text |= {"scene.objects.behind.shape": ["behind"], "scene.objects.behind.material": ["black"]}
    for step in range(STEPS):
        square(f"strip{step}", scene, -1.0 + 2.0 * step / STEPS, -1.0 + 2.0 * (step + 1) / STEPS, tilt, 0.0)
        text |= {f"scene.objects.o{step}.shape": [f"strip{step}"], f"scene.objects.o{step}.material": [f"film{step}"]}
    properties = pyluxcore.Properties()
    for key, values in text.items():
        properties.Set(pyluxcore.Property(key, values))
    scene.Parse(properties)
    settings = pyluxcore.Properties()
    for key, value in {
        "renderengine.type": "PATHCPU",
        "sampler.type": "SOBOL",
        "path.pathdepth.total": 4,
        "path.clamping.variance.maxvalue": 0.0,
        "film.width": STEPS * SIDE,
        "film.height": SIDE,
        "film.filter.type": "NONE",
        "film.imagepipelines.0.0.type": "NOP",
        "batch.haltspp": SAMPLES,
        "native.threads.count": 2,
    }.items():
        settings.Set(pyluxcore.Property(key, [value]))
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(settings, scene))
    session.Start()
    while not session.HasDone():
        time.sleep(0.05)
        session.UpdateStats()
    session.Stop()
    film = session.GetFilm()
    values = array.array("f", [0.0] * (3 * STEPS * SIDE * SIDE))
    film.GetOutputFloat(pyluxcore.FilmOutputType.RGB, values)
    row = []
    for step in range(STEPS):
        pixels = [(y * STEPS * SIDE + x) * 3 for y in range(SIDE) for x in range(step * SIDE, (step + 1) * SIDE)]
        row.append([sum(values[p + c] for p in pixels) / len(pixels) for c in range(3)])
    return row


pyluxcore.Init(lambda message: None)
print(json.dumps({"version": pyluxcore.Version(), "rgb": [render(angle) for angle in ANGLES]}), flush=True)
# Its threads hold the interpreter at exit (pyluxcore 2.11.2) and end it with an error.
os._exit(0)
