"""The verb ``info``: versions, threads, SIMD level, where the data come from."""

from __future__ import annotations

from typing import Any

from iridesce.cli.answers import print_json
from iridesce.cli.options import JsonOption


def verb(as_json: JsonOption = False) -> None:
    """Versions, threads, SIMD level, data sources."""
    import importlib.metadata
    import platform

    from iridesce import _core

    libraries = ("numpy", "matplotlib", "typer", "rich", "tifffile")
    facts: dict[str, Any] = {
        "iridesce": _core.__version__,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "threads": _threads(),
        "simd": _core.SIMD_LEVEL,
        "libraries": {library: importlib.metadata.version(library) for library in libraries},
        "data": _data_sources(),
    }
    if as_json:
        print_json(facts)
        return
    for key in ("iridesce", "python", "platform", "threads", "simd"):
        print(f"{key:<10} {facts[key]}")
    print(f"{'libraries':<10} " + ", ".join(f"{name} {version}" for name, version in facts["libraries"].items()))
    print("data")
    for name, source in facts["data"].items():
        print(f"  {name:<16} {source}")


def _threads() -> int:
    """How many threads work when nobody says otherwise."""
    import os

    wish = os.environ.get("RAYON_NUM_THREADS", "")
    if wish.isdecimal() and int(wish) > 0:
        return int(wish)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _data_sources() -> dict[str, str]:
    import iridesce as ir

    sources = {
        "observers": "CIE 1931 2 degrees and CIE 1964 10 degrees, 1 nm",
        "illuminants": "CIE 5 nm tables; CIE daylight components; Planck's law",
    }
    return {**sources, **{name: str(ir.Medium(name).source) for name in map(str, ir.media())}}
