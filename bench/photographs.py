"""How good `ir.map_thickness` is: scenes x cameras x lamps x (linear, JPEG), and what wrong assumptions do to it.

    python bench/photographs.py                 # the table of docs/guide/photographs.md, some minutes
    python bench/photographs.py --quick         # two scenes, one camera, one lamp
    python bench/photographs.py --only known --scene "oxide steps"
    python bench/photographs.py --speed         # one megapixel

Pictures are computed from exact spectra at 1 nm with haze of a fifth of the light, shading of 2 % and noise as photons make it;
the tables that answer have 5 nm. A pixel's order is right within a quarter of 550 nm / n. Columns, in per cent: order right,
within 10 nm, held by the 95 % interval, called sure (confidence > 0.95), right among the sure; then the median error in nm.
"""

from __future__ import annotations

import argparse
import io
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image as Pictures

import iridesce as ir
from iridesce.color.light import color_matching

Floats = npt.NDArray[np.float64]
NM = np.arange(380.0, 781.0, 1.0)
HEIGHT, WIDTH = 150, 200
FILM = "air / 1.33 ? / air"
OXIDE = "air / SiO2 ? / Si"
KEPT = 4  # of all cameras and lamps, after a choice by 512 pixels


def scenes() -> Iterator[tuple[str, str, Floats]]:
    """Name, stack, thickness."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    yield "draining film", FILM, 25.0 + 950.0 * (y / HEIGHT) ** 1.6 + 15.0 * np.sin(x / 25.0)
    yield "swirls", FILM, 430.0 + 210.0 * np.sin(x / 23.0 + y / 40.0) * np.cos(y / 31.0 - x / 57.0)
    square = (x - 0.5 * WIDTH) ** 2 + (y - 0.5 * HEIGHT) ** 2
    yield "rings", FILM, 40.0 + 1200.0 * square / square.max()
    yield "oxide steps", OXIDE, 90.0 + 55.0 * np.floor(x / 20.0)
    yield "oxide wedge", OXIDE, 20.0 + 3.3 * x + 0.4 * y


def response(camera: str, lamp: str) -> Floats:
    """What each channel weighs each wavelength with, its white being 1."""
    if camera == "srgb":
        seen = np.asarray(ir.color.convert(np.asarray(color_matching(NM)), "xyz", "linear-srgb"))
    else:
        seen = np.asarray(ir.color.camera(camera).at(NM))
    weights = seen * np.asarray(ir.color.illuminant(lamp).power(NM))[:, None]
    return np.asarray(weights / weights.sum(axis=0))


def photograph(
    stack: str,
    nm: Floats,
    camera: str,
    lamp: str,
    *,
    seed: int,
    angle_deg: Any = 0.0,
    noise: float = 0.01,
    index: float = 1.0,
) -> Floats:
    """Linear light, its brightest channel near 0.8."""
    random = np.random.default_rng(seed)
    grid = np.linspace(nm.min(), nm.max() + 1.0, 2500)
    if stack == FILM:
        films = ir.Stack(["air", ir.Layer(1.33 * index, grid[:, None]), "air"])
    else:
        films = ir.Stack(["air", ir.Layer("SiO2", grid[:, None]), "Si"])
    curves = films.reflectance(NM, angle_deg) @ response(camera, lamp)
    seen = np.stack([np.interp(nm, grid, curve) for curve in curves.T], axis=-1)
    shade = 1.0 + 0.02 * np.sin(np.linspace(0.0, 3.0, nm.shape[1]))[None, :, None]
    light = seen * shade + 0.2 * seen.mean() * np.array([0.9, 1.0, 1.2])
    light *= 0.8 / light.max()
    return np.asarray(light + noise * np.sqrt(np.maximum(light, 0.0) * light.mean()) * random.normal(size=light.shape))


def jpeg(light: Floats, path: Path, quality: int = 92) -> Path:
    """Through the sRGB curve into a JPEG with colour at half the resolution."""
    cut = np.clip(light, 0.0, 1.0)
    coded = np.where(cut <= 0.0031308, 12.92 * cut, 1.055 * cut ** (1.0 / 2.4) - 0.055)
    buffer = io.BytesIO()
    Pictures.fromarray((255.0 * coded + 0.5).astype(np.uint8)).save(buffer, "JPEG", quality=quality, subsampling=2)
    path.write_bytes(buffer.getvalue())
    return path


def score(found: Any, nm: Floats, index: float) -> tuple[float, ...]:
    """Order, within 10 nm, held, sure, right among sure (per cent), median error (nm)."""
    error = np.abs(found.thickness_nm - nm)
    right = error <= 550.0 / (4.0 * index)
    held = (found.low_nm <= nm) & (nm <= found.high_nm)
    sure = found.confidence > 0.95

    def share(of: Any) -> float:
        return 100.0 * float(np.mean(of)) if np.size(of) else float("nan")

    median = float(np.nanmedian(error)) if np.isfinite(error).any() else float("nan")
    return share(right), share(error < 10.0), share(held[right]), share(sure), share(right[sure]), median


def told(name: str, found: Any, nm: Floats, index: float, extra: str = "") -> None:
    """One row."""
    numbers = score(found, nm, index)
    words = " ".join(f"{value:6.1f}" for value in numbers)
    own = found.calibration
    doubt = "doubt" if any("no order is sure" in note for note in found.notes) else ""
    facts = f"misfit {own.get('misfit', 0.0):.2f} bias {own.get('bias', 0.0):.2f} temper {own.get('temper', 0.0):.1f}"
    print(f"{name:44s} {words}  {found.anchor:10s} {facts} {doubt} {extra}", flush=True)


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--speed", action="store_true")
    parser.add_argument("--only", default="known,wrong,blind")
    parser.add_argument("--scene", action="append", choices=[name for name, _, _ in scenes()], help="of named cameras")
    given = parser.parse_args()
    if given.speed:
        speed()
        return
    print(f"{'':44s}  order  10 nm   held   sure  right median")
    chosen = list(scenes())[: 2 if given.quick else None]
    lamps = ("D65",) if given.quick else ("D65", "A", "LED-B3")
    names = ("nikon-d5100",) if given.quick else ("nikon-d5100", "sigma-sd-merrill", "srgb")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "photo.jpg")
        if "known" in given.only:
            known(chosen, given.scene or [name for name, _, _ in chosen], names, lamps, path)
        if "wrong" in given.only:
            wrong(chosen)
        if "blind" in given.only:
            blind(chosen, names, lamps)


def known(
    chosen: list[tuple[str, str, Floats]], asked: list[str], names: tuple[str, ...], lamps: tuple[str, ...], path: Path
) -> None:
    """Camera and lamp named; of all scenes those that are asked for."""
    for number, (name, stack, nm) in enumerate(chosen):
        if name not in asked:
            continue
        index = 1.33 if stack == FILM else 1.46
        for camera in names:
            for lamp in lamps:
                light = photograph(stack, nm, camera, lamp, seed=number)
                for kind, image in (("linear", light), ("JPEG", jpeg(light, path))):
                    found = ir.map_thickness(
                        image, stack, camera=camera, illuminant=lamp, thickness_range_nm=(0.0, 1600.0)
                    )
                    told(f"{name}, {camera}, {lamp}, {kind}", found, nm, index)


def wrong(chosen: list[tuple[str, str, Floats]]) -> None:
    """What is assumed is not so."""
    options: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
        ("index 1 % high", {"index": 1.01}, {}),
        ("the same, index_tolerance 0.01", {"index": 1.01}, {"index_tolerance": 0.01}),
        ("10 degrees for 0", {"angle_deg": 10.0}, {}),
        ("the same, angle_tolerance_deg 10", {"angle_deg": 10.0}, {"angle_tolerance_deg": 10.0}),
        ("lamp A for D65", {"lamp": "A"}, {}),
        ("lamp D50 for D65", {"lamp": "D50"}, {}),
        ("camera sigma for nikon", {"camera": "sigma-sd-merrill"}, {}),
    ]
    for number, (name, stack, nm) in enumerate(one for one in chosen if one[1] == FILM):
        for words, taken, asked in options:
            made = {"camera": "nikon-d5100", "lamp": "D65", **taken}
            light = photograph(stack, nm, made.pop("camera"), made.pop("lamp"), seed=100 + number, **made)
            found = ir.map_thickness(
                light, stack, camera="nikon-d5100", illuminant="D65", thickness_range_nm=(0.0, 1600.0), **asked
            )
            told(f"{name}: {words}", found, nm, 1.33)
    # Another stack than the one that was photographed.
    _, _, nm = next(one for one in scenes() if one[0] == "oxide wedge")
    light = photograph(OXIDE, nm, "nikon-d5100", "D65", seed=7)
    found = ir.map_thickness(light, FILM, camera="nikon-d5100", illuminant="D65", thickness_range_nm=(0.0, 1600.0))
    told("oxide wedge, taken for a free film", found, nm, 1.33)


def blind(chosen: list[tuple[str, str, Floats]], names: tuple[str, ...], lamps: tuple[str, ...]) -> None:
    """Neither is named."""
    for number, (name, stack, nm) in enumerate(chosen):
        index = 1.33 if stack == FILM else 1.46
        for camera in names[:2]:
            for lamp in lamps[:2]:
                light = photograph(stack, nm, camera, lamp, seed=200 + number)
                found = ir.map_thickness(light, stack, thickness_range_nm=(0.0, 1600.0))
                own = found.calibration
                told(f"{name}, {camera}, {lamp}: blind", found, nm, index, f"{own['camera']} {own['illuminant']}")


def speed() -> None:
    """One megapixel, camera and lamp known, then neither, 500 thicknesses."""
    y, x = np.mgrid[0:1000, 0:1000] / 1000.0
    nm = 300.0 + 500.0 * y + 150.0 * np.sin(9.0 * x) * np.cos(7.0 * y)
    light = photograph(FILM, nm, "nikon-d5100", "D65", seed=1).astype(np.float32)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    def timed(threads: int, **known: str) -> tuple[Any, float, float]:
        times, busy = [], []
        for _ in range(3):
            began, processor = time.perf_counter(), time.process_time()
            found = ir.map_thickness(light, FILM, threads=threads, **known)
            times.append(time.perf_counter() - began)
            busy.append(time.process_time() - processor)
        print(
            f"{threads} threads, {', '.join(known) or 'nothing'} known: {min(times):.2f} s a megapixel, "
            f"{min(busy):.2f} s of processor time"
        )
        return found, min(times), min(busy)

    timed(1, camera="nikon-d5100", illuminant="D65")
    found, *known = timed(2, camera="nikon-d5100", illuminant="D65")
    timed(2, illuminant="D65")
    _, *blind = timed(2)
    clock, busy = ((after - before) / KEPT for before, after in zip(known, blind, strict=True))
    print(f"for each of the {KEPT} cameras and lamps kept {clock:.2f} s more, {busy:.2f} s of processor time")
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"memory: {(after - memory) / 1024.0:.0f} MiB more than before")
    told("speed", found, nm, 1.33)


if __name__ == "__main__":
    main()
