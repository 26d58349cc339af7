"""``ir.import_scene``: films, geometry, cameras and lights that others wrote, as a scene; what is left out is told."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from iridesce import _core
from iridesce.arguments.refusals import refusal
from iridesce.errors import SceneError
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
               pictures of matt surfaces; meshes where they lie (spheres, rectangles and disks as such), instances, cameras,
               lights. ``.mtlx``: the film of OpenPBR
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
        raise refusal("path", f"a file ending in {', '.join(ENDINGS)}", path)
    name = os.fspath(path)
    ending = Path(name).suffix.lower() if isinstance(name, str) else ""
    if ending not in _READERS:
        raise refusal("path", f"a file ending in {', '.join(ENDINGS)}", name)
    import importlib

    module, function = _READERS[ending]
    read: Callable[[str], Import] = getattr(importlib.import_module(f"iridesce.exchange.importers.{module}"), function)
    found = read(name)
    # Files that it names lie beside it.
    folder = Path(name).parent.resolve()
    tree = found.tree(name)
    scene = Scene(_core.Scene.from_dict(tree, folder, None, False))
    if _without_open_bodies(tree, scene, found):
        scene = Scene(_core.Scene.from_dict(tree, folder, None, False))
    return scene, found.left_out


def _without_open_bodies(tree: dict[str, Any], scene: Scene, found: Import) -> bool:
    """A medium cannot fill a mesh that is open: matt grey stands for its surface, and it is told."""
    changed = False
    for number, item in enumerate(tree["object"]):
        if "mesh" not in item["shape"] or not ({"dielectric", "coating"} & set(item["surface"])):
            continue
        try:
            scene._core.body(number)
        except SceneError as error:
            if "must be closed" not in str(error):
                raise
            ((kind, _),) = item["surface"].items()
            item["surface"] = {"diffuse": {"reflectance": 0.5}}
            found.leave_out(f"{item['name']}: its {kind}: a medium fills closed meshes alone, and this one is open")
            changed = True
    return changed
