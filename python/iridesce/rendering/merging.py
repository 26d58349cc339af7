"""Several renders of one scene put together: shards, and runs with other seeds."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.refusals import Words, refusal
from iridesce.image import Image

__all__ = ["merge"]

_Array = npt.NDArray[Any]


@dataclass(frozen=True)
class _Run:
    """One render, or one shard of it, that is in a picture."""

    seed: int
    samples: int
    number: int
    of: int
    where: str

    def has(self, tile: int) -> bool:
        return tile % self.of == self.number - 1

    def plain(self) -> dict[str, Any]:
        return {"seed": self.seed, "samples": self.samples, "shard": f"{self.number}/{self.of}"}


def merge(images: Iterable[Image | str | os.PathLike[str]]) -> Image:
    """Puts shards of a render together, and renders of the same scene with other seeds; each pixel's mean is weighted by samples.

    images     Images or paths of EXR files: two at least
    Returns    Image. All shards of a render give the bytes of the unbroken one. ``variance`` is that of the joined mean,
               ``samples`` their sum; ``metadata["merged"]`` lists what is in it, unless that is one whole render
    Raises     ValueError naming the difference where two are not of the same scene, size, crop, version, SIMD level or
               planes; and where two hold the same tile of the same seed

    Of an incomplete set of shards a warning says which are missing; the picture has samples 0 and colour 0 there, and can be
    merged again.

    >>> import iridesce as ir
    >>> halves = [ir.render("soap-bubble", samples=1, size=(40, 40), shard=(i, 2)) for i in (1, 2)]
    >>> whole = ir.render("soap-bubble", samples=1, size=(40, 40))
    >>> bool((ir.merge(halves).xyz == whole.xyz).all())
    True
    """
    if isinstance(images, (str, os.PathLike, Image)):
        raise refusal("images", "a list of two images or paths at least", images)
    given = list(images)
    if len(given) < 2:
        raise refusal("images", "two at least", Words(len(given)))
    named = [_named(image, place) for place, image in enumerate(given)]
    for name, image in named[1:]:
        _check_same(named[0], (name, image))
    tiles = _core.render_tiles((named[0][1].width, named[0][1].height))
    runs = [run for name, image in named for run in _runs(name, image)]
    _check_disjoint(runs, tiles)
    facts = _facts(named[0][1], runs, tiles)
    return _joined([image for _, image in named], facts)


def _named(image: object, place: int) -> tuple[str, Image]:
    if isinstance(image, Image):
        return f"images[{place}]", image
    if isinstance(image, (str, os.PathLike)):
        return os.fspath(image), Image.load(image)
    raise refusal("images", "images and paths", image, f"at index {place}", must="hold")


def _check_same(first: tuple[str, Image], second: tuple[str, Image]) -> None:
    a, b = _described(*first), _described(*second)
    for key, value in a.items():
        if b[key] != value:
            # Sizes and crops are told whole: "24 and 10" says nothing.
            is_whole = key in ("size", "crop")
            was, other = (str(value), str(b[key])) if is_whole else _difference(value, b[key])
            word = {"simd": "SIMD level"}.get(key, key)
            raise ValueError(f"{first[0]} and {second[0]} cannot be merged: {word} {was} and {other}")


def _described(name: str, image: Image) -> dict[str, Any]:
    """What must be the same."""
    facts = image.metadata
    missing = [key for key in ("samples", "scene", "simd", "version") if key not in facts]
    if missing or "samples" not in image.channels or not ("seed" in facts or "merged" in facts):
        raise ValueError(f"{name} does not tell how it was rendered ({', '.join(missing) or 'samples of each pixel'})")
    scene = {key: value for key, value in facts["scene"].items() if key != "render"}
    scene["render"] = {
        key: value for key, value in facts["scene"].get("render", {}).items() if key not in ("samples", "seed")
    }
    return {
        "size": [image.width, image.height],
        "crop": facts.get("crop"),
        "scene": json.loads(json.dumps(scene, default=str)),
        "version": facts["version"],
        "simd": facts["simd"],
        "planes": sorted([*image.channels, *image._spectral]),
        "wavelengths": None if image.spectral_nm is None else image.spectral_nm.tolist(),
    }


def _difference(a: Any, b: Any) -> tuple[str, str]:
    """The first place where two values differ, with both."""
    place = ""
    while isinstance(a, (dict, list)) and type(a) is type(b):
        keys: Sequence[Any] = list(a) if isinstance(a, dict) else range(len(a))
        if (set(a) != set(b)) if isinstance(a, dict) else len(a) != len(b):
            break
        key = next(key for key in keys if a[key] != b[key])
        place += f".{key}" if place else f"{key}"
        a, b = a[key], b[key]
    lead = f"{place} = " if place else ""
    return f"{lead}{json.dumps(a):.80}", f"{json.dumps(b):.80}"


def _runs(name: str, image: Image) -> Iterator[_Run]:
    facts = image.metadata
    alone = {"seed": facts.get("seed"), "samples": facts["samples"], "shard": facts.get("shard", "1/1")}
    try:
        for run in facts.get("merged", [alone]):
            number, _, of = run["shard"].partition("/")
            yield _Run(int(run["seed"]), int(run["samples"]), int(number), int(of), name)
    except (KeyError, TypeError, ValueError, AttributeError):
        raise ValueError(f"{name}: what it says of its shards is damaged") from None


def _check_disjoint(runs: list[_Run], tiles: list[tuple[int, int, int, int]]) -> None:
    for place, run in enumerate(runs):
        for other in runs[:place]:
            if run.seed != other.seed:
                continue
            shared = next((tile for tile in range(len(tiles)) if run.has(tile) and other.has(tile)), None)
            if shared is not None:
                x, y, width, height = tiles[shared]
                raise ValueError(
                    f"{other.where} and {run.where} both hold tile {shared} of seed {run.seed} (x {x}, y {y}, "
                    f"{width} x {height} pixels); the same samples twice are no more than once"
                )
    for run in runs:
        of_seed = [other for other in runs if other.seed == run.seed]
        if len({other.samples for other in of_seed}) > 1:
            numbers = " and ".join(str(other.samples) for other in of_seed)
            raise ValueError(f"the shards of seed {run.seed} cannot be merged: samples {numbers}")


def _facts(first: Image, runs: list[_Run], tiles: list[tuple[int, int, int, int]]) -> dict[str, Any]:
    """How the joined picture came about; a warning tells what is missing."""
    seeds = list(dict.fromkeys(run.seed for run in runs))
    complete = True
    for seed in seeds:
        of_seed = [run for run in runs if run.seed == seed]
        missing = [tile for tile in range(len(tiles)) if not any(run.has(tile) for run in of_seed)]
        if missing:
            complete = False
            counts = sorted({run.of for run in of_seed})
            shards = [f"{i}/{counts[0]}" for i in range(1, counts[0] + 1) if all(run.number != i for run in of_seed)]
            which = (
                f"shard{'s' if len(shards) > 1 else ''} {', '.join(shards):.80}" if len(counts) == 1 else "some shards"
            )
            warnings.warn(
                f"incomplete: {which} of seed {seed} missing ({len(missing)} of {len(tiles)} tiles); "
                "these have samples 0 and colour 0",
                stacklevel=3,
            )
    facts = {key: value for key, value in first.metadata.items() if key in _KEPT}
    tree = dict(facts["scene"])
    samples = sum(next(run.samples for run in runs if run.seed == seed) for seed in seeds)
    facts["samples"] = samples
    facts["seed"] = seeds[0]
    tree["render"] = {**tree.get("render", {}), "samples": samples, "seed": seeds[0]}
    facts["scene"] = tree
    if not complete or len(seeds) > 1:
        facts["merged"] = [run.plain() for run in runs]
    return facts


_KEPT = ("backend", "simd", "version", "crop", "scene")


def _joined(images: list[Image], facts: dict[str, Any]) -> Image:
    samples = np.stack([image.channels["samples"] for image in images]).astype(np.float64)
    total = samples.sum(axis=0)
    # Exactly 1 where one picture alone has samples: its bytes stay.
    shares = samples / np.where(total > 0.0, total, 1.0)

    def mean(planes: list[_Array]) -> _Array:
        sum_ = np.zeros(planes[0].shape)
        for share, plane in zip(shares, planes, strict=True):
            sum_ += share.reshape(share.shape + (1,) * (plane.ndim - 2)) * plane
        return sum_.astype(np.float32)

    first = np.argmax(samples > 0.0, axis=0)

    def pick(planes: list[_Array]) -> _Array:
        chosen = planes[0].copy()
        for number in range(1, len(planes)):
            chosen[first == number] = planes[number][first == number]
        return chosen

    planes: dict[str, _Array] = {}
    for name in images[0].channels:
        own = [image.channels[name] for image in images]
        if name == "samples":
            planes[name] = total.astype(np.int32)
        elif name == "variance":
            weighted = [np.where(share > 0.0, share**2 * plane, 0.0) for share, plane in zip(shares, own, strict=True)]
            planes[name] = np.sum(weighted, axis=0).astype(np.float32)
        elif name == "alpha":
            planes[name] = mean(own)
        else:
            planes[name] = pick(own)
    spectral = {
        name: images[0]._spectral[name].copy()
        if name == "spectral_nm"
        else mean([image._spectral[name] for image in images])
        for name in images[0]._spectral
    }
    return Image._of_render(mean([image.xyz for image in images]), planes, spectral, facts)
