"""Ten scenes beside Mitsuba 3: signed differences, their noise, and pictures; writes docs/evidence/validation.md.

usage: validation.py [--samples N] [--write] [SCENE]...

Each scene is drawn by iridesce and by the path tracer of Mitsuba 3.9 in its polarised spectral LLVM variant, which is given
the exact film as a BSDF, smooth or rough (below): it has none of its own. Differences are (ours - theirs) / theirs over the
pixels where the object in question is seen, each with one standard error from runs of other seeds; t is the largest of the
blocks of 6 x 6 pixels and of X, Y, Z, beside what chance makes of so many. Then what closed forms say where the peer, or a
renderer without polarisation, is wrong. `--write` puts all of it into the page.

It needs `mitsuba` and a system libLLVM of version 17 or newer, as bench/peer_mitsuba.py does.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from peer_film import alpha_of, exact_film, table_of  # noqa: E402  found through the line above

PAGE = HERE.parent / "docs" / "evidence" / "validation.md"
IMAGE = HERE.parent / "docs" / "images" / "validation.png"
MARKS = ("<!-- tables: from bench/validation.py -->", "<!-- tables end -->")
SIDE, BLOCK, RUNS = 48, 6, 8
VARIANT = "llvm_ad_spectral_polarized"
GREY = {"illuminant": "E", "radiance": 0.4}


def sphere(name: str, center: list[float], radius: float, surface: dict[str, Any]) -> dict[str, Any]:
    return {"name": name, "shape": {"sphere": {"center": center, "radius": radius}}, "surface": surface}


FLOOR = {
    "name": "floor",
    "shape": {"rectangle": {"center": [0.0, -1.0, 0.0], "u": [4.0, 0.0, 0.0], "v": [0.0, 0.0, -4.0]}},
    "surface": {"diffuse": {"reflectance": 0.5}},
}
LAMP = sphere("lamp", [2.6, 3.4, 2.0], 1.3, {"emitter": {"illuminant": "E", "radiance": 2.0}})


def lit(surface: dict[str, Any], *more: dict[str, Any], lamp: bool = True) -> dict[str, Any]:
    """A ball of a surface on a matt floor, under a lamp and an even sky."""
    objects = [sphere("thing", [0.0, 0.0, 0.0], 1.0, surface), FLOOR, *([LAMP] if lamp else []), *more]
    return {
        "version": 1,
        "camera": {"position": [0.0, 1.2, 6.0], "target": [0.0, 0.0, 0.0], "fov_deg": 24.0, "resolution": [SIDE, SIDE]},
        "render": {"max_depth": 64},
        "object": objects,
        "light": [{"environment": GREY}],
    }


def flat(surface: dict[str, Any]) -> dict[str, Any]:
    """A tilted plate over the floor, backed by black: its own back would be a mirror here and black there."""
    tree = lit(surface)
    plate = {"u": [1.1, 0.0, 0.0], "v": [0.0, 0.7, -0.8]}
    front = {"name": "thing", "shape": {"rectangle": {"center": [0.0, -0.1, 0.0], **plate}}, "surface": surface}
    back = {"rectangle": {"center": [0.0, -0.1075, -0.0066], **plate}}  # 0.01 behind
    tree["object"][0] = front
    tree["object"].append({"name": "back", "shape": back, "surface": {"diffuse": {"reflectance": 0.0}}})
    return tree


def coated(layers: list[tuple[Any, float]], substrate: Any, roughness: Any = 0.0) -> dict[str, Any]:
    rows = [{"medium": medium, "thickness_nm": nm} for medium, nm in layers]
    return {"coating": {"layers": rows, "substrate": substrate, "roughness": roughness}}


GRADED = {"film": {"medium": 1.33, "thickness_nm": {"gradient": {"top": 0.0, "bottom": 700.0}}}}
#: Name: scene, and what is compared.
SCENES: dict[str, tuple[dict[str, Any], str]] = {
    "matt": (lit({"diffuse": {"reflectance": 0.7}}), "a matt ball, no film"),
    "glass": (lit({"dielectric": {"medium": 1.5}}), "a glass ball, no film; Mitsuba's own material"),
    "metal": (lit({"metal": {"medium": [0.5, 3.0]}}), "a metal ball, no film; Mitsuba's own material"),
    "rough-metal": (
        lit({"metal": {"medium": [0.5, 3.0], "roughness": 0.15}}),
        "alpha 0.0225, no film; Mitsuba's own material",
    ),
    "bubble": (lit(GRADED), "a free film, graded from 0 to 700 nm"),
    "oil": (lit(coated([(1.47, 420.0)], 1.333)), "a film on a drop of water"),
    "coated-glass": (lit(coated([(1.38, 100.0), (2.1, 130.0), (1.65, 80.0)], 1.5)), "three layers on a glass ball"),
    "titanium": (lit(coated([("TiO2", 60.0)], "Ti")), "an oxide on a metal ball"),
    "rough-titanium": (lit(coated([("TiO2", 60.0)], "Ti", 0.15)), "the same, alpha 0.0225"),
    "brushed-steel": (
        flat(coated([("Fe3O4", 50.0)], "steel", [0.1, 0.2])),
        "an oxide on a brushed plate, alpha 0.01 and 0.04",
    ),
}


def ours(tree: dict[str, Any], samples: int) -> tuple[Floats, NDArray[np.bool_]]:
    """XYZ of some runs, and where the thing is seen by every sample."""
    import iridesce as ir

    runs = []
    for seed in range(1, RUNS + 1):
        image = ir.render(tree, samples=samples, seed=seed)
        runs.append(np.asarray(image.xyz, dtype=np.float64))
    seen = np.asarray(image.channels["object"]) == 0
    inner = seen.copy()
    for axis in (0, 1):
        for step in (1, -1):
            inner &= np.roll(seen, step, axis)
    return np.array(runs), inner


def theirs(tree: dict[str, Any], samples: int) -> Floats:
    """XYZ of as many runs of Mitsuba's path tracer, polarised, with the exact film as a BSDF."""
    from peer_mitsuba import newest_llvm

    os.environ.setdefault("DRJIT_LIBLLVM_PATH", newest_llvm())
    import mitsuba as mi

    mi.set_variant(VARIANT)
    thing = tree["object"][0]
    ((kind, keys),) = thing["surface"].items()
    bsdf: dict[str, Any]
    if kind == "diffuse":
        bsdf = {"type": "diffuse", "reflectance": {"type": "spectrum", "value": keys["reflectance"]}}
    elif kind == "dielectric":
        bsdf = {"type": "dielectric", "int_ior": keys["medium"], "ext_ior": 1.0}
    elif kind == "metal":
        eta, k = ({"type": "spectrum", "value": value} for value in keys["medium"])
        bsdf = {"type": "conductor", "eta": eta, "k": k}
        if keys.get("roughness"):
            bsdf |= {"type": "roughconductor", "distribution": "ggx", "alpha": keys["roughness"] ** 2}
    else:
        film = exact_film(mi)
        film.tell(table_of(thing["surface"]), alpha_of(tree))
        mi.register_bsdf("exact_film", lambda props: film)
        bsdf = {"type": "exact_film"}
    camera = tree["camera"]
    look = mi.ScalarTransform4f().look_at(origin=camera["position"], target=camera["target"], up=[0.0, 1.0, 0.0])
    world: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 64, "rr_depth": 24},
        "sensor": {
            "type": "perspective",
            "fov": camera["fov_deg"],
            "fov_axis": "y",
            "to_world": look,
            "film": {
                "type": "hdrfilm",
                "pixel_format": "xyz",
                "rfilter": {"type": "box"},
                "width": SIDE,
                "height": SIDE,
            },
            "sampler": {"type": "independent", "sample_count": samples},
        },
        "sky": {"type": "constant", "radiance": {"type": "spectrum", "value": GREY["radiance"]}},
    }
    for item in tree["object"]:
        world[item["name"]] = _shape(mi, item, bsdf)
    scene = mi.load_dict(world)
    return np.array(
        [np.array(mi.render(scene, spp=samples, seed=seed))[..., :3] for seed in range(RUNS)], dtype=np.float64
    )


def _shape(mi: Any, item: dict[str, Any], bsdf: dict[str, Any]) -> dict[str, Any]:
    ((kind, keys),) = item["shape"].items()
    if kind == "sphere":
        told: dict[str, Any] = {"type": "sphere", "center": keys["center"], "radius": keys["radius"]}
    else:
        u, v = np.array(keys["u"]), np.array(keys["v"])
        normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
        rows = np.vstack([np.stack([u, v, normal, keys["center"]], axis=1), [0.0, 0.0, 0.0, 1.0]])
        told = {"type": "rectangle", "to_world": mi.ScalarTransform4f(rows)}
    surface = item["surface"]
    if item["name"] == "thing":
        told["bsdf"] = bsdf
    elif "emitter" in surface:
        told["emitter"] = {"type": "area", "radiance": {"type": "spectrum", "value": surface["emitter"]["radiance"]}}
    else:
        value = {"type": "spectrum", "value": surface["diffuse"]["reflectance"]}
        told["bsdf"] = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": value}}
    return told


def compare(name: str, samples: int, folder: Path) -> dict[str, Any]:
    """One scene, both renderers."""
    warnings.simplefilter("ignore")
    tree, _ = SCENES[name]
    mine, seen = ours(tree, max(samples // 8, 4))
    peer = theirs(tree, samples)
    # Mitsuba sums its spectra a little otherwise: an even sky of 0.4 is 0.4 there but for some 1e-3. Each counts by its own.
    sky = GREY["radiance"] * np.ones(3)
    mine, peer = mine * (sky / mine[:, :4].mean(axis=(0, 1, 2))), peer * (sky / peer[:, :4].mean(axis=(0, 1, 2)))
    np.savez(folder / f"{name}.npz", mine=mine.mean(0), peer=peer.mean(0), seen=seen)
    sums = [runs[:, seen].mean(axis=1) for runs in (mine, peer)]
    total = sums[1].mean(axis=0)
    difference = (sums[0].mean(axis=0) - total) / total
    error = np.sqrt(sum(each.var(axis=0, ddof=1) / RUNS for each in sums)) / total
    blocks = [
        runs.reshape(RUNS, SIDE // BLOCK, BLOCK, SIDE // BLOCK, BLOCK, 3).mean(axis=(2, 4)) for runs in (mine, peer)
    ]
    spread = np.sqrt(sum(each.var(axis=0, ddof=1) / RUNS for each in blocks))
    gap = blocks[0].mean(axis=0) - blocks[1].mean(axis=0)
    return {
        "difference": difference.tolist(),
        "error": error.tolist(),
        "t": float(np.abs(gap / np.maximum(spread, 1e-12)).max()),
        "worst": float(np.abs(gap / blocks[1].mean(axis=0)).max()),
        "y": float(total[1]),
    }


def polarisation() -> list[tuple[float, float, float, float]]:
    """Two walls of a film of 300 nm before a lamp, at one angle: the angle, Y in closed form, ours, and the product of mean T.

    Light through both walls of a bubble has (T_s^2 + T_p^2) / 2 of its radiance: the first wall polarises what the second gets.
    """
    import iridesce as ir

    film = {"film": {"medium": 1.33, "thickness_nm": 300.0}}
    stack = ir.Stack(["air", ir.Layer(1.33, 300.0), "air"])
    nm = np.arange(360.0, 831.0)
    rows = []
    for angle in (30.0, 60.0, 75.0, 83.0):
        height = float(np.sin(np.radians(angle)))
        lamp = {
            "shape": {"disk": {"center": [0.0, height, -3.0], "radius": 0.02}},
            "surface": {"emitter": {"illuminant": "E"}},
        }
        tree = {
            "version": 1,
            "camera": {
                "position": [0.0, height, 3.0],
                "target": [0.0, height, 0.0],
                "orthographic_height": 1e-4,
                "resolution": [8, 8],
            },
            "object": [sphere("thing", [0.0, 0.0, 0.0], 1.0, film), {"name": "lamp", **lamp}],
            "light": [{"environment": {"illuminant": "E", "radiance": 0.0}}],
        }
        seen = float(ir.render(tree, samples=4).xyz[..., 1].mean())
        s, p = (stack.transmittance(nm, angle, of) for of in "sp")
        exact, mean = (
            float(ir.color.spectrum_to_xyz(nm, t, illuminant="E")[1])
            for t in (0.5 * (s * s + p * p), (0.5 * (s + p)) ** 2)
        )
        rows.append((angle, exact, seen, mean))
    return rows


def single_albedo(alpha: float, height_correlated: bool, count: int = 300) -> float:
    """What white facets (GGX) mirror at once and unhindered, of an even sky, over the disc of a ball."""
    t, turn = np.meshgrid((np.arange(count) + 0.5) / count, (np.arange(count) + 0.5) / count * 2 * np.pi)
    slope = alpha * np.sqrt(1 / t.ravel() ** 2 - 1)
    h = np.stack([slope * np.cos(turn.ravel()), slope * np.sin(turn.ravel()), np.ones(count * count)], axis=1)
    cos_h = 1 / np.linalg.norm(h, axis=1)
    h *= cos_h[:, None]

    def behind(cosine: Any) -> Any:
        return 0.5 * (np.sqrt(1 + alpha**2 * (1 / cosine**2 - 1)) - 1)

    total = 0.0
    mus = np.sqrt((np.arange(60) + 0.5) / 60)  # even over the disc
    for mu in mus:
        towards = np.array([np.sqrt(1 - mu * mu), 0.0, mu])
        weight = t.ravel() * np.maximum(h @ towards, 0.0) / cos_h
        out = 2 * (h @ towards) * h[:, 2] - mu
        there, back = behind(np.maximum(out, 1e-6)), behind(mu)
        open_ = (1 + back) / (1 + back + there) if height_correlated else 1 / (1 + there)
        total += float((weight * np.where(out > 0, open_, 0.0)).sum() / weight.sum()) / len(mus)
    return total


def furnace(roughness: float) -> dict[str, float]:
    """White rough balls in an even sky of 1, over their discs: ours, Mitsuba's own, and what one bounce alone gives."""
    import mitsuba as mi

    import iridesce as ir

    surface = {"metal": {"medium": [2e-6, 1.0], "roughness": roughness}}
    tree = {
        "version": 1,
        "camera": {"position": [0.0, 0.0, 4.0], "orthographic_height": 2.0, "resolution": [32, 32]},
        "object": [sphere("thing", [0.0, 0.0, 0.0], 1.0, surface)],
        "light": [{"environment": {"illuminant": "E", "radiance": 1.0}}],
    }
    runs = np.array([ir.render(tree, samples=16, seed=seed).xyz[..., 1] for seed in (1, 2, 3, 4)])
    mi.set_variant("llvm_ad_rgb")
    look = mi.ScalarTransform4f().look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0])
    white = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": roughness**2}
    flat_film = {"type": "hdrfilm", "pixel_format": "luminance", "rfilter": {"type": "box"}, "width": 32, "height": 32}
    world = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 3},
        "sensor": {"type": "orthographic", "to_world": look, "film": flat_film},
        "sky": {"type": "constant", "radiance": 1.0},
        "ball": {"type": "sphere", "bsdf": white},
    }
    disc = np.pi / 4  # of the picture; around it the sky is 1 in both
    told = np.array(mi.render(mi.load_dict(world), spp=1024)).mean()
    return {
        "ours": 1 - float(1 - runs.mean()) / disc,
        "theirs": 1 - float(1 - told) / disc,
        "one_bounce": single_albedo(roughness**2, False),
    }


def chance_t(tests: int, runs: int) -> float:
    """What the largest |t| of so many blocks stays below in 99 of 100 pages, with the freedom of Welch's test at its least."""
    rng = np.random.default_rng(1)
    a, b = (rng.standard_normal((400, tests, runs)) for _ in range(2))
    t = np.abs((a.mean(-1) - b.mean(-1)) / np.sqrt((a.var(-1, ddof=1) + b.var(-1, ddof=1)) / runs))
    return float(np.quantile(t.max(axis=1), 0.99))


def sheet(names: list[str], folder: Path) -> None:
    """Ours above theirs above ten times the difference about grey, scene by scene."""
    from PIL import Image

    import iridesce as ir

    columns = []
    for name in names:
        with np.load(folder / f"{name}.npz") as file:
            mine, peer = file["mine"], file["peer"]
        rows = [ir.color.convert(np.maximum(each, 0.0) * 0.8, "xyz", "srgb") for each in (mine, peer)]
        off = 0.5 + 10.0 * (mine[..., 1] - peer[..., 1])
        rows.append(np.repeat(off[..., None], 3, axis=-1))
        columns.append(np.concatenate([np.clip(row, 0.0, 1.0) for row in rows]))
    picture = np.round(255 * np.concatenate(columns, axis=1)).astype(np.uint8).repeat(2, axis=0).repeat(2, axis=1)
    Image.fromarray(picture).save(IMAGE, optimize=True)


def report(names: list[str], samples: int, folder: Path) -> list[str]:
    limit = chance_t(3 * (SIDE // BLOCK) ** 2, RUNS)
    lines = ["| scene | | X, % | Y, % | Z, % | t |", "|---|---|---|---|---|---|"]
    print("\n".join(lines), flush=True)
    for name in names:
        command = [sys.executable, __file__, "--alone", "--samples", str(samples), "--folder", str(folder), name]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{name}: {done.stderr}")
        told = json.loads(done.stdout.strip().splitlines()[-1])
        cells = [f"{100 * d:+.2f} ± {100 * e:.2f}" for d, e in zip(told["difference"], told["error"], strict=True)]
        lines.append(f"| `{name}` | {SCENES[name][1]} | {' | '.join(cells)} | {told['t']:.1f} |")
        print(lines[-1], flush=True)
    lines += ["", f"Chance alone makes a largest t above {limit:.1f} on one page in a hundred, a scene.", ""]
    lines += ["| angle | closed form | iridesce | product of the unpolarised means |", "|---|---|---|---|"]
    lines += [
        f"| {angle:g} | {exact:.5f} | {seen:.5f} | {mean:.5f} ({100 * (mean / exact - 1):+.2f} %) |"
        for angle, exact, seen, mean in polarisation()
    ]
    lines += ["", "| alpha | iridesce | Mitsuba's `roughconductor` | one bounce in closed form |", "|---|---|---|---|"]
    for roughness in (0.15, 0.3, 0.5):
        command = [sys.executable, __file__, "--furnace", str(roughness)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        told = json.loads(done.stdout.strip().splitlines()[-1])
        lines.append(f"| {roughness**2:.4f} | {told['ours']:.4f} | {told['theirs']:.4f} | {told['one_bounce']:.4f} |")
    print("\n".join(lines[len(names) + 2 :]), flush=True)
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", choices=[*SCENES, []], default=[], help="default: all")
    parser.add_argument("--samples", type=int, default=256, help="of the peer, a pixel and run; ours takes an eighth")
    parser.add_argument("--write", action="store_true", help="put all of it into docs/evidence/validation.md")
    parser.add_argument("--alone", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--furnace", type=float, help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.write and arguments.scenes:
        parser.error("--write puts the tables of all scenes into the page: name none")
    if arguments.furnace:
        from peer_mitsuba import newest_llvm

        os.environ.setdefault("DRJIT_LIBLLVM_PATH", newest_llvm())
        print(json.dumps(furnace(arguments.furnace)))
        return 0
    if arguments.alone:
        print(json.dumps(compare(arguments.scenes[0], arguments.samples, arguments.folder)))
        return 0
    names = arguments.scenes or list(SCENES)
    with tempfile.TemporaryDirectory() as name:
        lines = report(names, arguments.samples, Path(name))
        if arguments.write:
            sheet(names, Path(name))
            text = PAGE.read_text(encoding="utf-8")
            first, last = text.index(MARKS[0]) + len(MARKS[0]), text.index(MARKS[1])
            PAGE.write_text(text[:first] + "\n\n" + "\n".join(lines) + "\n\n" + text[last:], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
