"""Maps of thickness as the textures that targets read. Internal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from iridesce.exchange import exr, png
from iridesce.exchange.films import Film
from iridesce.exchange.knobs import coded_cost
from iridesce.exchange.laying import RAMP
from iridesce.exchange.package import Package


def laid_out(film: Film, package: Package) -> Film:
    """A film whose thickness varies has a map: its own, or its range laid over v, thinnest on top."""
    if not film.varies or film.thickness_nm is not None:
        return film
    low, high = film.range_nm
    columns, rows = RAMP
    package.note(f"{film.name}: no map was given: {low:g} to {high:g} nm is laid over v, thinnest on top")
    ramp = np.repeat(np.linspace(low, high, rows)[:, None], columns, axis=1)
    return replace(film, thickness_nm=ramp)


def thickness_png(film: Film, package: Package, name: str) -> tuple[float, float]:
    """A 16-bit PNG of the film's map, least to greatest thickness as 0 to 65535 in every channel; its ends, nm.

    The first row is the top. Viewers that keep 8 bits of it lose what the report says.
    """
    assert film.thickness_nm is not None
    low, high = film.range_nm
    share = (np.clip(film.thickness_nm, low, high) - low) / (high - low)
    steps = np.rint(share * 65535.0).astype(np.uint16)
    texts = {"iridesce:thickness_nm": f"{low!r} {high!r}"}
    package.files[name] = png.png_bytes(np.repeat(steps[..., None], 3, axis=2), texts)
    package.note(
        f"{film.name}: map of thickness {name}, 16 bits over {low:.6g} to {high:.6g} nm; a reader that keeps 8 bits of it"
        f" adds CIEDE2000 {coded_cost(film, 256):.2f} in the mean"
    )
    return low, high


def thickness_exr(film: Film, package: Package, name: str) -> None:
    """The map as an EXR in nm, float32; the first row is the top."""
    assert film.thickness_nm is not None
    values = film.thickness_nm.astype(np.float32)
    package.files[name] = exr.exr_bytes(dict.fromkeys("RGB", values), {"iridesce:unit": "nm"})
    package.note(f"{film.name}: map of thickness {name}, nm as floats")
