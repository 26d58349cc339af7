"""Every call that uses worker threads, each large enough to use them: name -> what it answers, as bytes."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import iridesce as ir

NM = np.linspace(400.0, 800.0, 201)
FILM = ir.Stack(["air", ir.Layer("soap", thickness_nm=320.0), "air"])
MANY = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(0.0, 2000.0, 20_000)), "air"])
OXIDE = ir.Stack(["air", ir.Layer("SiO2", thickness_nm=1000.0), "Si"])
SLAB = ir.Stack(
    [
        "air",
        ir.Layer("SiO2", thickness_nm=np.linspace(0.0, 900.0, 9_000)),
        ir.Layer("N-BK7", 1e6, coherent=False),
        "air",
    ]
)
TRIPLES = np.random.default_rng(5).random((5_000, 3))


def _picture() -> ir.Image:
    return ir.render("soap-bubble", size=(64, 48), samples=2)


def _saved(name: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        _picture().save(path)
        return path.read_bytes()


def _fields() -> bytes:
    found = FILM.field_profile(np.linspace(0.0, 320.0, 9), np.linspace(400.0, 800.0, 3_000))
    return b"".join(_floats(value) for value in found if isinstance(value, np.ndarray))


def _derivatives() -> bytes:
    found = MANY.derivatives("reflectance", 550.0)
    return np.ascontiguousarray(found.thickness_nm).tobytes()


def _exr_map() -> bytes:
    thickness = ir.thickness.gradient(top=0.0, bottom=900.0).map(64, 48)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.exr"
        thickness.save(path)
        return ir.thickness.ThicknessMap.load(path).thickness_nm.tobytes()


def _table() -> ir.ColorTable:
    return ir.ColorTable(FILM, thickness_nm=(0.0, 400.0), angle_deg=(0.0, 30.0), max_delta_e=1.0)


def _table_file() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.exr"
        _table().save(path)
        return ir.ColorTable.load(path).color(np.linspace(0.0, 400.0, 5_000)).tobytes()


def _fit() -> bytes:
    result = ir.fit_thickness(NM, OXIDE.reflectance(NM), OXIDE)
    return f"{result.best.thickness_nm:.6f}".encode()


def _floats(value: Any) -> bytes:
    return np.ascontiguousarray(value).tobytes()


def _series() -> bytes:
    nm = np.arange(450.0, 800.0, 8.0)
    film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(1000.0, 900.0, 4)[:, None]), "air"])
    return _floats(ir.fit_series(nm, film.reflectance(nm), "air / soap ? / air", gain=1.0).thickness_nm)


def _photograph() -> bytes:
    nm = np.linspace(150.0, 400.0, 24) + np.zeros((16, 1))
    photo = ir.Stack(["air", ir.Layer("soap", nm), "air"]).color(space="linear-srgb")
    found = ir.map_thickness(photo, "air / soap ? / air", camera="srgb", illuminant="D65")
    return _floats(found.thickness_nm)


def _recipes() -> bytes:
    found = ir.recipes([40.0, 10.0, -40.0], media=["SiO2"], substrate="Si", layers=(1,), max_delta_e=20.0)
    return repr([one.thickness_nm for one in found]).encode()


def _sweep() -> bytes:
    return _floats(ir.sweep("air / soap 320 / air", {"layers.0.thickness_nm": [100.0, 200.0, 300.0]}).values)


def _merged() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        parts = [Path(folder) / f"{part}.exr" for part in (1, 2)]
        for number, part in enumerate(parts, start=1):
            ir.render("wafer", size=(64, 48), samples=1, shard=(number, 2)).save(part)
        return _floats(ir.merge(parts).xyz)


def _mesh() -> bytes:
    points, faces = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4)]
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in points) + "".join(f"f {a} {b} {c}\n" for a, b, c in faces)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "thing.obj"
        file.write_text(text)
        scene = {
            "version": 1,
            "camera": {"position": [0.0, 0.0, 5.0], "resolution": [32, 24]},
            "object": [{"shape": {"mesh": {"file": str(file)}}, "surface": {"dielectric": {"medium": 1.5}}}],
            "light": [{"environment": {"builtin": "studio"}}],
        }
        return _floats(ir.render(ir.Scene.load(scene, allow_outside=True), samples=2).xyz)


ENTRIES: dict[str, Callable[[], bytes]] = {
    "render": lambda: _floats(_picture().xyz),
    "render, threads=2": lambda: _floats(ir.render("soap-bubble", size=(64, 48), samples=2, threads=2).xyz),
    "render of a film that flows": lambda: _floats(ir.render(_flowing(), size=(16, 12), samples=1).xyz),
    "Image.rgb": lambda: _floats(_picture().rgb(exposure="auto")),
    "Image.save png": lambda: _saved("x.png"),
    "Image.save exr": lambda: _saved("x.exr"),
    "Stack.color": lambda: _floats(MANY.color()),
    "Stack.reflectance": lambda: _floats(MANY.reflectance(550.0, angle_deg=[[0.0], [45.0]])),
    "Stack.reflectance, threads=2": lambda: _floats(MANY.reflectance(550.0, angle_deg=[[0.0], [45.0]], threads=2)),
    "Stack.transmittance of a slab": lambda: _floats(SLAB.transmittance(550.0)),
    "Stack.amplitudes": lambda: _floats(MANY.amplitudes(550.0, 30.0, "s")),
    "Stack.derivatives": _derivatives,
    "Stack.field_profile": _fields,
    "Medium.index": lambda: _floats(ir.Medium("Si").index(np.linspace(400.0, 800.0, 100_000))),
    "thickness.simulate": lambda: b"".join(
        _floats(frame.thickness_nm) for frame in ir.thickness.simulate("late", time_s=0.02)
    ),
    "thickness.ThicknessMap.save, load": _exr_map,
    "ColorTable": lambda: _floats(_table().color(np.linspace(0.0, 400.0, 5_000))),
    "ColorTable.save, load": _table_file,
    "fit_thickness": _fit,
    "fit_series": _series,
    "map_thickness": _photograph,
    "recipes": _recipes,
    "sweep": _sweep,
    "render of a mesh": _mesh,
    "merge": _merged,
    "Stack.mueller": lambda: _floats(MANY.mueller(550.0, 30.0)),
    "color.delta_e": lambda: _floats(ir.color.delta_e(100.0 * TRIPLES, 100.0 * TRIPLES[::-1])),
    "color.convert": lambda: _floats(ir.color.convert(TRIPLES, "xyz", "lab")),
    "color.map_gamut": lambda: _floats(ir.color.map_gamut(2.0 * TRIPLES, "srgb")[0]),
    "thickness.gradient": lambda: _floats(ir.thickness.gradient(0.0, 900.0).at_height(TRIPLES[:, 0])),
}


def _flowing() -> ir.Scene:
    flow = {"flow": {"preset": "late", "time_s": 0.02, "seed": 3}}
    return ir.Scene.load("soap-bubble").with_value("object.bubble.surface.film.thickness_nm", flow)


# Public names that use no worker threads of their own, and why.
WITHOUT: dict[str, str] = {
    "ArgumentError": "an error",
    "ResourceError": "an error",
    "SceneError": "an error",
    "Layer": "a value",
    "Measurement": "a value; its fit is fit_thickness",
    "ReadReport": "a value",
    "SweepResult": "a value",
    "CameraCalibration": "a value; its calibration is numpy on one thread",
    "Scene": "a recipe; resolve() is what render does first",
    "media": "a list",
    "fit": "the module of fit_thickness",
    "plot": "pictures by matplotlib, of what Stack and color answer",
    "exchange": "the module of export, validate and import_scene",
    "export": "files of what ColorTable, render and Stack answer",
    "import_scene": "reads texts",
    "validate": "compares pictures by numpy",
    "widget": "a page in a notebook: a table of ColorTable's",
    "map_thickness_video": "map_thickness, frame by frame",
}
