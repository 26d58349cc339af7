"""The verb ``info``: versions, threads, SIMD level, where the data come from."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from iridesce.cli.answers import print_json, tell
from iridesce.cli.options import JsonOption


def verb(
    full: Annotated[bool, typer.Option("--full", help="Tell the source of every medium, too.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Versions, threads, SIMD level, data sources."""
    import importlib.metadata
    import platform

    from iridesce import _core
    from iridesce.files import cache

    libraries = ("numpy", "matplotlib", "typer", "rich", "tifffile")
    facts: dict[str, Any] = {
        "iridesce": _core.__version__,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "threads": _core.threads(),
        "simd": _core.SIMD_LEVEL,
        "cache": str(cache.folder()),
        "cache_bytes": cache.used_bytes(),
        "libraries": {library: importlib.metadata.version(library) for library in libraries},
        "data": _data_sources(),
    }
    if as_json:
        print_json(facts)
        return
    for key in ("iridesce", "python", "platform", "threads", "simd"):
        tell(f"{key:<10} {facts[key]}")
    tell(f"{'libraries':<10} " + ", ".join(f"{name} {version}" for name, version in facts["libraries"].items()))
    mib = facts["cache_bytes"] / 2**20
    tell(
        f"{'cache':<10} {facts['cache']} ({mib:.1f} of at most {cache.LIMIT_BYTES >> 20} MiB; ${cache.VARIABLE} says where)"
    )
    data = facts["data"]
    if not full:
        tell(f"{'data':<10} {len(data) - 2} media; observers and illuminants of the CIE (sources: --full)")
        return
    print("data")
    for name, source in data.items():
        tell(f"  {name:<16} {source}")


def _data_sources() -> dict[str, str]:
    import iridesce as ir

    sources = {
        "observers": "CIE 1931 2 degrees and CIE 1964 10 degrees, 1 nm",
        "illuminants": "CIE 5 nm tables; CIE daylight components; Planck's law",
    }
    return {**sources, **{name: str(ir.Medium(name).source) for name in map(str, ir.media())}}
