"""The colour of stacks: exact, and on the road of 1991."""

from __future__ import annotations

import os
import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import _core
from iridesce.arguments.operands import Floats, broadcast_shape, new_array, real_operand, reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import optional_text, text
from iridesce.color.light import Illuminant, as_illuminant
from iridesce.optics.multilayer import Multilayer

GREY_NM = 1e5
"""Films a tenth of a millimetre thick are grey to every eye: charts and tables of colours hold no thicker ones."""


def stack_color(
    stack: Multilayer,
    angle_deg: ArrayLike = 0.0,
    polarization: str = "unpolarized",
    illuminant: str | os.PathLike[str] | Illuminant = "D65",
    observer: str = "cie1931",
    space: str = "xyz",
    quantity: str = "reflectance",
    model: str = "exact",
    wavelength_nm: ArrayLike | None = None,
    adaptation: str | None = None,
    gamut: str | None = None,
) -> Floats:
    """Colour of a stack under a light: what ``Stack.color`` calls.

    XYZ = k sum S(lambda) R(lambda) cmf(lambda) over 360..830 nm at 1 nm, k such that the perfect reflector has Y = 1.
    Where fringes are finer than 2 n t cos(theta) step / lambda^2 = 1/4 (summed over coherent layers) the steps are
    halved until they are not; and above 1/16 (1/64 under lamps whose spectra have spikes, and beyond 75
    degrees) until half the steps change the colour by no more than CIEDE2000 0.01, since strong reflections give fringes
    overtones. Lines of a lamp are exact at any thickness. Lab, LCh and ``adaptation`` take the light's own white.

    stack           thicknesses of its layers broadcast                            (...,)
    angle_deg       incidence in the first medium, [0, 90)                         (...,) broadcasts
    polarization    "s" | "p" | "unpolarized"
    illuminant      name, path or Illuminant: see :func:`illuminant`
    observer        "cie1931" | "cie1964"
    space           see :func:`convert`
    quantity        "reflectance" | "transmittance" | "absorptance"
    model           "exact" | "two-beam": the form of 1991 (one layer, real indices, unpolarised reflectance)
    wavelength_nm   another uniform ascending grid, taken as it is                 (n,)
    adaptation      None | "bradford": from the light's white to that of the space
    gamut           None (values out of range are kept) | "hue" | "clip": see :func:`map_gamut`
    Returns         float64                                                        broadcast shape + (3,)
    Raises          ValueError naming the argument, the value and what is allowed
    Warns           UserWarning when a built-in medium is used beyond its data (by its stated extension), or when
                    ``wavelength_nm`` is too coarse for the fringes: it tells up to which thickness the grid holds

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=305.0), "air"])
    >>> ir.color.stack_color(film, illuminant="C").round(5).tolist()
    [0.05432, 0.06839, 0.03743]
    """
    media, layers = _parts(stack)
    shape, thickness, angles = _points(angle_deg, layers)
    grid = None
    if wavelength_nm is not None:
        grid = reals("wavelength_nm", wavelength_nm)
        if grid.ndim != 1:
            raise refusal("wavelength_nm", "one axis", Words(f"shape {grid.shape}"), must="have")
        grid = np.ascontiguousarray(grid)
    colors: Floats = new_array("the colours", (*shape, 3))
    extended, fringe, thickest = _core.stack_color(
        [medium._core for medium in media],
        [bool(layer.coherent) for layer in layers],
        thickness,
        angles,
        text("polarization", polarization),
        as_illuminant(illuminant)._core,
        text("observer", observer),
        text("space", space),
        text("quantity", quantity),
        text("model", model),
        grid,
        optional_text("adaptation", adaptation),
        optional_text("gamut", gamut),
        colors.reshape(-1, 3),
    )
    if extended:
        names = ", ".join(extended)
        warnings.warn(
            f"{names}: beyond the measured data inside 360..830 nm the stated extension was used", stacklevel=3
        )
    if fringe > 0.25 and grid is not None:
        step = (grid[-1] - grid[0]) / (grid.size - 1)
        what = "a film" if len(layers) == 1 else "coherent layers of together"
        warnings.warn(
            f"wavelength_nm in steps of {step:.4g} nm holds for {what} up to {0.25 * thickest / fringe:.6g} nm here, and"
            f" {thickest:.6g} nm were given: colours beyond that are wrong, as steps must satisfy"
            " 2 n t cos(theta) step / lambda^2 <= 1/4. Leave wavelength_nm out and the sum refines itself",
            stacklevel=3,
        )
    return colors


def purity_eps(stack: Multilayer, wavelength_nm: ArrayLike = 555.0) -> Any:
    """Colour purity eps = (r12 - r23)^2 / (4 r12 r23) of a film, with amplitudes of normal incidence (Dias 1991).

    Purest at 0 or -1, paler as |eps| grows: R = 4 r12 r23 (eps + cos^2(delta/2)).

    stack           exactly one layer, real indices
    wavelength_nm   where dispersive indices are read                (...,)
    Returns         float64                                          (...,); a float for a scalar
    Raises          ValueError: more layers, absorption, a face that does not reflect
    Source          M. L. Dias, IEEE Computer Graphics and Applications 11(2), 1991 and 14(3), 1994

    >>> import iridesce as ir
    >>> ir.color.purity_eps(ir.Stack(["air", ir.Layer(1.33, thickness_nm=300.0), "air"]))
    -1.0
    """
    return stack.two_beam_purity(wavelength_nm)


def dias1991(
    stack: Multilayer,
    angle_deg: ArrayLike = 0.0,
    table: str = "printed",
    matrix: str | ArrayLike = "printed",
) -> tuple[Floats, Floats]:
    """Colour of a film on the road of 1991: XYZ and linear RGB.

    R = 4 r12 r23 (eps + cos^2(delta/2)), delta = 4 pi n2 t cos(theta2)/lambda, amplitudes of normal incidence at every
    angle; XYZ = k sum S R cmf in 10 nm steps over 380..770 nm, illuminant C, k = 1 / sum(S ybar).
    The reflectance is the paper's; k, the sums and the matrix are those of the report on it. For exact colours
    use ``Stack.color``.

    stack       exactly one coherent layer, real indices; its thickness broadcasts      (...,)
    angle_deg   incidence in the first medium, [0, 90), below total reflection           (...,) broadcasts
    table       "printed": the report's four-digit table (Wyszecki & Stiles, 1982) | "full": the CIE tables at 10 nm
    matrix      "printed": the report's, for XYZ in percent | "full": derived from the NTSC 1953 primaries with
                white C | an array (3, 3) that takes XYZ with Y = 1 to linear RGB
    Returns     (XYZ with Y = 1 for the perfect reflector, linear RGB), float64          broadcast shape + (3,) each
    Raises      ValueError
    Source      M. L. Dias, "Ray Tracing Interference Color", IEEE Computer Graphics and Applications 11(2), 1991, with
                the factor 4 r12 r23 of the correction in 14(3), 1994

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=305.0), "air"])
    >>> xyz, rgb = ir.color.dias1991(film)
    >>> xyz.round(4).tolist(), rgb.round(4).tolist()
    ([0.0556, 0.0706, 0.0375], [0.0579, 0.0856, 0.0286])
    """
    media, layers = _parts(stack)
    if len(layers) != 1 or not layers[0].coherent:
        raise complaint(
            f"dias1991 needs exactly one coherent layer, got {len(layers)} layers",
            "stack",
            "one of exactly one coherent layer",
            Words(f"{len(layers)} layers"),
        )
    chosen: str | list[list[float]]
    if isinstance(matrix, str):
        chosen = matrix
    else:
        given = reals("matrix", matrix)
        if given.shape != (3, 3):
            raise refusal("matrix", '"printed", "full" or an array of shape (3, 3)', Words(f"shape {given.shape}"))
        chosen = given.tolist()
    shape, thickness, angles = _points(angle_deg, layers)
    nm = np.asarray(_core.dias1991_wavelengths())
    indices = np.stack([np.asarray(medium.index(nm), dtype=np.complex128) for medium in media], axis=-1)
    xyz, rgb = _core.dias1991(
        np.ascontiguousarray(indices), np.ascontiguousarray(thickness[:, 0]), angles, text("table", table), chosen
    )
    return np.asarray(xyz).reshape(*shape, 3), np.asarray(rgb).reshape(*shape, 3)


def _parts(stack: Multilayer) -> tuple[list[Any], list[Any]]:
    try:
        return [stack.first, *(layer.medium for layer in stack.layers), stack.last], list(stack.layers)
    except AttributeError:
        raise refusal("stack", "an iridesce.Stack", stack) from None


def _points(angle_deg: ArrayLike, layers: list[Any]) -> tuple[tuple[int, ...], Floats, Floats]:
    """Broadcast shape; thicknesses as (points, layers); angles as (points,)."""
    angle = real_operand("angle_deg", angle_deg, low=0.0, high=90.0)
    names = ["thickness_nm"] if len(layers) == 1 else [f"thickness_nm of layer {i}" for i in range(1, len(layers) + 1)]
    columns = [real_operand(name, layer.thickness_nm, low=0.0) for name, layer in zip(names, layers, strict=True)]
    shape = broadcast_shape([angle, *columns])
    thickness: Floats = new_array("the thicknesses", (*shape, len(columns)))
    for column, operand in enumerate(columns):
        thickness[..., column] = operand.full()
    angles: Floats = new_array("the angles", shape)
    angles[...] = angle.full()
    return shape, thickness.reshape(angles.size, len(columns)), angles.reshape(-1)
