"""``ir.import_scene``: films, geometry, cameras and lights that others wrote, as a scene; what is left out is told."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from iridesce import _core
from iridesce.exchange.importers.common import Import
from iridesce.scene import Scene

_READERS = {
    ".gltf": ("gltf", "read_gltf"),
    ".glb": ("gltf", "read_gltf"),
    ".mtlx": ("materialx", "read_materialx"),
    ".xml": ("mitsuba", "read_mitsuba"),
}
ENDINGS = tuple(_READERS)


def import_scene(path: str | os.PathLike[str]) -> tuple[Scene, list[str]]:
    """Read a scene or material of another program.

    path       ``.gltf``, ``.glb``: KHR_materials_iridescence, transmission, ior, emissive strength, anisotropy, roughness,
               pictures of matt surfaces; spheres and flat pieces of meshes, cameras, lights. ``.mtlx``: the film of OpenPBR
               or Standard Surface, on a ball. ``.xml``: the subset of Mitsuba 3 that a scene holds. Pictures are named
               relative to the file's folder
    Returns    (Scene, what was left out: a list of sentences)
    Raises     ValueError naming the file and what cannot be read; a film whose thickness is a thousand times off (nm
               taken for um, or the other way) is refused

    Thicknesses outside 5 nm to 50 um are told in the list.

    >>> import tempfile, pathlib, iridesce as ir
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     report = ir.export("air / soap 320 / air", "openpbr", folder)
    ...     scene, left_out = import_scene(pathlib.Path(folder, "film.mtlx"))
    >>> scene.to_dict()["object"][0]["surface"]["film"]["thickness_nm"]
    320.0
    """
    if not isinstance(path, str | os.PathLike):
        raise ValueError(f"path must be a file ending in {', '.join(ENDINGS)}, got {path!r:.60}")
    name = os.fspath(path)
    ending = Path(name).suffix.lower() if isinstance(name, str) else ""
    if ending not in _READERS:
        raise ValueError(f"path must be a file ending in {', '.join(ENDINGS)}, got {name!r:.200}")
    import importlib

    module, function = _READERS[ending]
    read: Callable[[str], Import] = getattr(importlib.import_module(f"iridesce.exchange.importers.{module}"), function)
    found = read(name)
    # Files that it names lie beside it.
    folder = Path(name).parent.resolve()
    return Scene(_core.Scene.from_dict(found.tree(name), folder, None, False)), found.left_out
