"""What every importer gathers, and the rules that all share: units, names, what is left out. Internal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from iridesce import _core
from iridesce.arguments.operands import Floats

MOST_BYTES = 2**28

_MOST_INSTANCES = 100_000

_LEAST_NM, _MOST_NM = 5.0, 5e4
# A film of light's own size lies between these; a thousandth or a thousand times of it lies outside.
_SURELY_UM_NM, _SURELY_M_NM = 2.0, 1e5


@dataclass
class Import:
    """Objects, lights and a camera as a scene's tree has them, and what was left out."""

    objects: list[dict[str, Any]] = field(default_factory=list)
    lights: list[dict[str, Any]] = field(default_factory=list)
    camera: dict[str, Any] = field(default_factory=dict)
    unit: str = "m"
    left_out: list[str] = field(default_factory=list)

    def leave_out(self, sentence: str) -> None:
        """Something that a scene cannot hold; said once."""
        if sentence not in self.left_out:
            self.left_out.append(sentence)

    def tree(self, label: str) -> dict[str, Any]:
        """The whole tree; `ValueError` where nothing was found."""
        if not self.objects:
            raise ValueError(f"{label}: nothing that a scene can hold was found" + _because(self.left_out))
        if not self.lights:
            self.leave_out("no light was found: a uniform one of D65 shines")
            self.lights.append({"environment": {"illuminant": "D65", "radiance": 1.0}})
        names: dict[str, int] = {}
        for item in self.objects:
            count = names[item["name"]] = names.get(item["name"], 0) + 1
            if count > 1:
                item["name"] = f"{item['name']}-{count}"
        return {"version": 1, "unit": self.unit, "camera": self.camera, "object": self.objects, "light": self.lights}


def placed(item: dict[str, Any], placements: Floats, found: Import) -> dict[str, Any] | None:
    """An object where matrices (n, 3, 4) put it: as it stands, moved, or as instances; ``None`` where none has a volume."""
    size = np.linalg.norm(placements[:, :, :3], axis=1).prod(axis=1)
    kept = np.asarray(np.isfinite(placements).all(axis=(1, 2)))
    kept &= np.abs(np.linalg.det(np.where(kept[:, None, None], placements[:, :, :3], 0.0))) > 1e-12 * size
    if not kept.all():
        found.leave_out(f"{item['name']}: {(~kept).sum()} placements that squeeze it flat")
        placements = placements[kept]
    if len(placements) > _MOST_INSTANCES:
        found.leave_out(f"{item['name']}: all but {_MOST_INSTANCES} of its {len(placements)} instances")
        placements = placements[:_MOST_INSTANCES]
    if not len(placements):
        return None
    if len(placements) > 1:
        return {**item, "instances": [{"matrix": rows} for rows in placements.tolist()]}
    if np.array_equal(placements[0], np.eye(4)[:3]):
        return item
    return {**item, "transform": {"matrix": placements[0].tolist()}}


def checked_nm(found: Import, label: str, where: str, nm: float, unit: str) -> float:
    """A thickness read from a file; a fault of a thousand is refused, an odd one told."""
    if not math.isfinite(nm) or nm < 0.0:
        raise ValueError(f"{label}: {where}: the thickness must be finite and >= 0, got {nm:g} nm")
    if 0.0 < nm < _SURELY_UM_NM:
        raise ValueError(
            f"{label}: {where}: a film of {nm:g} nm; the file's unit is {unit}: is it a thousand times too small?"
        )
    if nm > _SURELY_M_NM:
        raise ValueError(
            f"{label}: {where}: a film of {nm:g} nm; the file's unit is {unit}: is it a thousand times too large?"
        )
    if nm and not _LEAST_NM <= nm <= _MOST_NM:
        found.leave_out(f"{where}: a film of {nm:g} nm is unusual (5 nm to 50 um show colours)")
    return nm


def luminance(rgb: Sequence[float]) -> float:
    """Of linear Rec.709 red, green and blue (ITU-R BT.709-6)."""
    red, green, blue = _core.REC709_LUMINANCE
    return red * rgb[0] + green * rgb[1] + blue * rgb[2]


def index_of_f0(f0: float) -> float:
    """The index against air of a clear base with that reflectance at normal incidence."""
    root = math.sqrt(min(max(f0, 0.0), 0.998))
    return (1.0 + root) / (1.0 - root)


def roughened(surface: dict[str, Any], roughness: Any) -> dict[str, Any]:
    """The same surface with facets; a mirror stays as it is."""
    ((kind, keys),) = surface.items()
    return {kind: {**keys, "roughness": roughness}} if roughness else surface


def spot_angles(inner_deg: float, outer_deg: float) -> dict[str, float]:
    """A cone that shines fully within half an angle and not beyond another, as a scene counts it."""
    inner = min(max(inner_deg, 1e-3), 89.0)
    return {"cone_deg": 2.0 * inner, "soft_deg": max(min(outer_deg, 90.0) - inner, 0.0)}


def film_surface(film_ior: float, nm: Any, base: Any, free: bool) -> dict[str, Any]:
    """The surface of one film: free, or on a base (an index, or [n, k])."""
    if free:
        return {"film": {"medium": film_ior, "thickness_nm": nm}}
    return {"coating": {"layers": [{"medium": film_ior, "thickness_nm": nm}], "substrate": base}}


def plain(name: Any, otherwise: str) -> str:
    """A name for an object: letters, digits, - and _."""
    if not isinstance(name, str) or not name.strip():
        return otherwise
    return "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in name.strip())[:90]


def _because(left_out: list[str]) -> str:
    return "" if not left_out else f" ({'; '.join(left_out[:3])})"
