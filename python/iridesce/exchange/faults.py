"""What a renderer with one fault would show of a chart: the signatures by which `validate` names a cause. Internal.

Each is the exact chart with that fault made in it, so that a cause is named by what it explains, not by a look.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from iridesce import color
from iridesce.arguments.operands import Floats
from iridesce.exchange.films import ANGLES_DEG, Film, extended_index
from iridesce.exchange.suite import RANGE_NM, THICKNESS_NM, Chart
from iridesce.exchange.twins import gltf
from iridesce.optics.wavelengths import SPECTRUM_NM, in_steps
from iridesce.stack import Layer, Stack

# CIE 1931 RGB: primaries at 700, 546.1 and 435.8 nm, white E (CIE 15:2004, 7.1). XYZ -> RGB.
_CIE_RGB = np.array(
    [[2.3706743, -0.9000405, -0.4706338], [-0.5138850, 1.4253036, 0.0885814], [0.0052982, -0.0146949, 1.0093968]]
)

_WAVELENGTH_NM = in_steps(SPECTRUM_NM, 5.0)

Angles = Floats


def hypotheses(chart: Chart, thickness_nm: Floats, angle_deg: Floats) -> Iterator[tuple[str, Floats]]:
    """(cause, what would be seen) at thicknesses and angles that broadcast; several readings of a fault bear one name."""
    film = chart.film()

    def seen(thickness: Floats) -> Floats:
        return chart.xyz(thickness, angle_deg)

    true = seen(thickness_nm)
    yield from _units(chart, thickness_nm, angle_deg)
    yield from _whites(chart, thickness_nm, angle_deg)
    yield "half period", seen(2.0 * thickness_nm)
    for low, high in ((RANGE_NM[0], RANGE_NM[1]), (0.0, RANGE_NM[1]), (0.0, 1000.0), (0.0, 2000.0)):
        share = np.clip((thickness_nm - low) / (high - low), 0.0, 1.0)
        yield "8-bit thickness", seen(low + np.rint(share * 255.0) / 255.0 * (high - low))
        yield "8-bit thickness", seen(low + np.floor(share * 255.0) / 255.0 * (high - low))
    yield from _matrices(true)
    if chart.illuminant == "D65":
        flat = Chart(chart.name, chart.title, chart.stack, chart.quantity, "E", chart.moved).xyz(
            thickness_nm, angle_deg
        )
        yield next(_matrices(flat))  # CIE RGB with its own white, as MaterialX has it
    if chart.quantity != "reflectance":
        return
    for schlick in _schlick(chart, film, thickness_nm, angle_deg):
        yield "schlick", schlick
    if chart.is_metal:
        for lossless in _without_k(film, thickness_nm, angle_deg):
            yield "k missing", lossless


def _units(chart: Chart, thickness_nm: Floats, angle_deg: Floats) -> Iterator[tuple[str, Floats]]:
    """A thousand times too thin (no film), too thick (fringes that no eye resolves: their mean)."""
    yield "unit", chart.xyz(thickness_nm / 1000.0, angle_deg)
    film = chart.film()
    assert film.layer is not None
    layer = film.stack.layers[film.layer]
    thick = Stack([film.stack.first, Layer(layer.medium, thickness_nm * 1000.0, coherent=False), film.stack.last])
    with film.hushed():
        grey = [
            thick.color(angle_deg=angle_deg, illuminant=film.illuminant, quantity=quantity)
            for quantity in (("reflectance", "transmittance") if chart.quantity == "furnace" else (chart.quantity,))
        ]
    yield "unit", sum(grey[1:], start=grey[0])


def _whites(chart: Chart, thickness_nm: Floats, angle_deg: Floats) -> Iterator[tuple[str, Floats]]:
    """Sums under equal energy instead of the lamp: as they are, or scaled to the working white."""
    if chart.illuminant != "D65":
        return
    flat = Chart(chart.name, chart.title, chart.stack, chart.quantity, "E", chart.moved).xyz(thickness_nm, angle_deg)
    white, working = color.illuminant("E").white(), color.illuminant("D65").white()
    yield "illuminant E", flat
    yield "illuminant E", flat * (working / white)
    to_rgb = color.rgb_matrix("linear-srgb")
    scaled = (flat @ to_rgb.T) / (to_rgb @ white)
    yield "illuminant E", scaled @ np.linalg.inv(to_rgb).T


def _matrices(true: Floats) -> Iterator[tuple[str, Floats]]:
    """RGB made with another matrix and shown as Rec.709."""
    to_rgb = color.rgb_matrix("linear-srgb")
    back = np.linalg.inv(to_rgb)
    yield "cie rgb matrix", true @ _CIE_RGB.T @ back.T
    yield "transposed matrix", true @ to_rgb @ back.T
    rgb = true @ to_rgb.T
    if rgb.min() < -1e-3 * rgb.max():
        yield "rec709 clip", np.maximum(rgb, 0.0) @ back.T


def _schlick(chart: Chart, film: Film, thickness_nm: Floats, angle_deg: Floats) -> Iterator[Floats]:
    """Schlick at both faces, phases 0 or pi, no polarisation: summed over the spectrum, and as glTF ships it."""
    cosine = np.cos(np.radians(angle_deg))
    n = [extended_index(medium, _WAVELENGTH_NM).real for medium in film.stack.media]
    base = film.stack.last
    bare = Stack([film.stack.first, base]).reflectance(_in_data(base, _WAVELENGTH_NM)) if chart.is_metal else None
    if bare is not None:
        root = np.sqrt(np.clip(bare, 0.0, 0.9999))
        n[2] = (1.0 + root) / (1.0 - root)
    squared = np.maximum(1.0 - (n[0] / n[1]) ** 2 * (1.0 - cosine[..., None] ** 2), 0.0)
    inside = np.sqrt(squared)
    first = gltf.schlick(gltf.normal_reflectance(n[1], n[0]), cosine[..., None])
    second = gltf.schlick(gltf.normal_reflectance(n[2], n[1]), inside)
    phase = np.where(n[1] < n[0], 0.0, np.pi) + np.where(n[2] < n[1], np.pi, 0.0)
    turn = 4.0 * np.pi * n[1] * inside * thickness_nm[..., None] / _WAVELENGTH_NM + phase
    amplitude = np.sqrt(first * second)
    # Airy's sum with amplitudes of those reflectances: r12 = -sqrt(R12) where the phase is pi.
    total = 1.0 - (1.0 - first) * (1.0 - second) / (1.0 + first * second - 2.0 * amplitude * np.cos(turn))
    yield color.spectrum_to_xyz(_WAVELENGTH_NM, total, illuminant=film.illuminant)
    n_film = float(extended_index(film.stack.media[1], [550.0])[0].real)
    f0 = np.asarray(base_f0(film))
    to_xyz = np.linalg.inv(color.rgb_matrix("linear-srgb"))
    yield gltf.rgb(thickness_nm, cosine, n_film, f0) @ to_xyz.T


def _without_k(film: Film, thickness_nm: Floats, angle_deg: Floats) -> Iterator[Floats]:
    """The substrate without its k: n kept, or an index that gives the metal's own reflectance at 0 degrees."""
    assert film.layer is not None
    medium = film.stack.layers[film.layer].medium
    index = extended_index(film.stack.last, _WAVELENGTH_NM)
    outside = extended_index(film.stack.first, _WAVELENGTH_NM).real
    root = np.sqrt(np.clip(np.abs((index - outside) / (index + outside)) ** 2, 0.0, 0.9999))
    for lossless in (index.real, outside * (1.0 + root) / (1.0 - root)):
        spectrum = np.stack(
            [
                Stack([film.stack.first, Layer(complex(n1), thickness_nm), float(n2)]).reflectance(float(w), angle_deg)
                for w, n1, n2 in zip(_WAVELENGTH_NM, extended_index(medium, _WAVELENGTH_NM), lossless, strict=True)
            ],
            axis=-1,
        )
        yield color.spectrum_to_xyz(_WAVELENGTH_NM, spectrum, illuminant=film.illuminant)


def base_f0(film: Film) -> Floats:
    """Reflectance of what carries the film, at normal incidence, in linear Rec.709 under D65."""
    with film.hushed():
        return np.asarray(Stack([film.stack.first, film.stack.last]).color(space="linear-srgb"))


def _in_data(medium: object, wavelength_nm: Floats) -> Floats:
    low, high = getattr(medium, "range_nm", None) or (wavelength_nm[0], wavelength_nm[-1])
    return np.clip(wavelength_nm, low, high)


def grids() -> tuple[Floats, Floats]:
    """Thicknesses across and angles down of a chart."""
    return np.array(THICKNESS_NM)[None, :], np.array(ANGLES_DEG)[:, None]
