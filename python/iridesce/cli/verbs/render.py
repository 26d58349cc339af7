"""The verb ``render``: a scene to its picture."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from iridesce.cli.answers import note, print_json, quiet_dask
from iridesce.cli.options import DaskOption, JsonOption, OutsideOption, SceneArgument, SetOption, ThreadsOption
from iridesce.cli.reading import (
    assignment,
    changed_scene,
    check_picture,
    crop_in_pixels,
    exposure_in_stops,
    load_scene,
    plain_name,
    shard_of,
    size_in_pixels,
    wavelengths_of,
)

if TYPE_CHECKING:
    from iridesce.image import Image

# Shorter renders leave no journal behind when they are killed, unless --resume asks for one: they are sooner made again.
_JOURNAL_AFTER_S = 10.0


def verb(
    scene: SceneArgument,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--output",
            help="Picture to write, .png or .exr; may be given twice. Without it both are written here.",
        ),
    ] = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Width and height in pixels, as in 640x480.")] = None,
    samples: Annotated[int | None, typer.Option(help="Camera rays per pixel.")] = None,
    seed: Annotated[int | None, typer.Option(help="Another seed gives other, independent noise.")] = None,
    threads: ThreadsOption = None,
    exposure: Annotated[str, typer.Option(metavar="E", help='Stops for the .png, or "auto".')] = "auto",
    until: Annotated[
        float | None, typer.Option(metavar="E", help="Go on until the median relative error of Y is below E.")
    ] = None,
    time_: Annotated[float | None, typer.Option("--time", metavar="S", help="Go on for S seconds.")] = None,
    crop: Annotated[str | None, typer.Option(metavar="X,Y,W,H", help="Only this part of the picture, pixels.")] = None,
    spectral: Annotated[
        str | None, typer.Option(metavar="FROM:TO:STEP", help="Radiance at these wavelengths, nm, in the .exr.")
    ] = None,
    stokes: Annotated[bool, typer.Option("--stokes", help="Stokes vectors in the .exr.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with FILE.journal of a render that was killed.")
    ] = False,
    shard: Annotated[
        str | None, typer.Option(metavar="I/N", help="Only the I-th of N shares, from 1; `merge` joins them.")
    ] = None,
    space: Annotated[str, typer.Option(help="Of the .png: srgb, display-p3 or rec2020.")] = "srgb",
    gamut: Annotated[str, typer.Option(help="Colours outside it: hue (kept) or clip.")] = "hue",
    bits: Annotated[int, typer.Option(help="Of a channel of the .png: 8 or 16.")] = 8,
    half: Annotated[bool, typer.Option("--half", help="Half floats in the .exr.")] = False,
    dask: DaskOption = None,
    set_: SetOption = None,
    allow_outside: OutsideOption = False,
    as_json: JsonOption = False,
) -> None:
    """Draw a scene: writes its picture as .png (to look at) and .exr (all the numbers)."""
    width_height = None if size is None else size_in_pixels(size)
    stops = exposure_in_stops(exposure)
    changes = [assignment(text) for text in set_ or []]
    loaded = changed_scene(load_scene(scene, allow_outside), changes)
    paths = output or [Path(plain_name(scene) + suffix) for suffix in (".png", ".exr")]
    for path in paths:
        check_picture(path)
    if dask is not None and (until is not None or time_ is not None or resume or shard is not None):
        raise typer.BadParameter("goes without --until, --time, --resume and --shard", param_hint="--dask")
    part = None if crop is None else crop_in_pixels(crop)
    share = shard_of(shard)
    # A slip is told before a long render, not after it.
    for name, value, allowed in (
        ("space", space, ("srgb", "display-p3", "rec2020")),
        ("gamut", gamut, ("hue", "clip")),
        ("bits", bits, (8, 16)),
    ):
        if value not in allowed:
            wanted = ", ".join(str(word) for word in allowed)
            raise typer.BadParameter(f"wanted one of {wanted}, got {value!r:.60}", param_hint=f"--{name}")

    from iridesce.rendering.journal import Keep
    from iridesce.rendering.pictures import draw

    started = time.perf_counter()
    journal = paths[0].with_name(f"{paths[0].name}.journal")
    if journal.exists() and not resume:
        note(f"note: {journal} of a render that was killed is there; --resume would go on with it")
    asked: dict[str, Any] = {"samples": samples, "seed": seed, "size": width_height, "threads": threads}
    asked |= {"until": until, "time_s": time_, "crop": part, "shard": share}
    asked |= {"spectral_nm": None if spectral is None else wavelengths_of(spectral), "stokes": stokes}
    keep = Keep(journal, 0.0 if resume else _JOURNAL_AFTER_S, resume)
    if dask is None:
        image = draw(loaded, asked, keep, progress=True)
    else:
        from iridesce.sweeping.frames import draw_in_shards

        quiet_dask()
        shared = {"samples": samples, "seed": seed, "size": width_height, "crop": part, "threads": threads}
        shared |= {"spectral_nm": asked["spectral_nm"], "stokes": stokes}
        image = draw_in_shards(dask, loaded, shared)
    for path in paths:
        image.save(path, exposure=stops, space=space, gamut=gamut, bits=bits, half=half)
    if keep.is_ours():
        journal.unlink(missing_ok=True)
    seconds = time.perf_counter() - started
    if as_json:
        facts = {key: value for key, value in image.metadata.items() if key != "scene"}
        print_json({"files": [str(path) for path in paths], **facts})
    else:
        for path in paths:
            print(path)
    note(_summary(image, seconds))


def _summary(image: Image, seconds: float) -> str:
    height, width = image.xyz.shape[:2]
    metadata = image.metadata
    text = f"{width} x {height} pixels, {metadata['samples']} samples, seed {metadata['seed']}, {seconds:.2f} s"
    share = metadata.get("out_of_gamut")
    if isinstance(share, float) and share > 0.0:
        pixels = "all pixels" if share == 1.0 else f"{100.0 * share:.1f} % of the pixels"
        always = ", as monochromatic light always does," if _is_monochromatic(metadata.get("scene")) else ""
        # (An .exr holds colours as they are; the share is that of a .png in sRGB.)
        space = {"display-p3": "Display P3", "rec2020": "Rec.2020"}.get(str(metadata.get("space", "srgb")), "sRGB")
        told = {"hue": " (hue kept in the .png)", "clip": " (cut off in the .png)"}[str(metadata.get("gamut", "hue"))]
        text += f"; {pixels} lie outside {space}{always}{told}"
    return text


def _is_monochromatic(tree: Any) -> bool:
    """Whether all light of a scene is of one narrow line or one close group of lines, as that of sodium."""
    names = [
        value
        for light in (tree or {}).get("light", [])
        for kind in light.values()
        if isinstance(kind, dict)
        for key, value in kind.items()
        if key in ("illuminant", "map", "builtin") and isinstance(value, str)
    ]
    wavelengths: list[float] = []
    for name in names:
        kind, colon, lines = name.partition(":")
        if not colon or kind not in ("lines", "laser"):
            return False
        try:
            wavelengths += [float(line.split("*")[0]) for line in lines.split(",")]
        except ValueError:
            return False
    return bool(wavelengths) and max(wavelengths) - min(wavelengths) <= 5.0
