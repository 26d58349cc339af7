"""The stack as users know it: what it does to light, its colours, their derivatives, its table in a notebook.

Each method is one call into `iridesce.optics` or `iridesce.color`, which know nothing of this class.
"""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from iridesce.arguments.operands import Floats, broadcast_shape, real_operand
from iridesce.arguments.refusals import complaint
from iridesce.arguments.scalars import one_of
from iridesce.color import derivatives as color_slopes
from iridesce.color.stack_html import stack_html
from iridesce.optics import averages, derivatives, fields, labelled
from iridesce.optics.layer import Layer
from iridesce.optics.multilayer import Multilayer

__all__ = ["Layer", "Stack"]


class Stack(Multilayer):
    """A first medium, layers in the order light meets them, and a last medium.

    items     first medium, any number of `Layer`, last medium; a medium is a name, an index (complex n + ik) or
              a `Medium`
    Raises    ValueError naming the item that is wrong

    The first medium must have real n > 0 and k = 0; the last k >= 0; gain (k < 0) is allowed in coherent layers only.
    Time factor exp(-i omega t). All questions take `wavelength_nm` (vacuum, > 0) and `angle_deg` (in the first medium,
    0 <= angle < 90), which broadcast with each other and with the layers' thicknesses; scalars give a scalar.
    A wavelength outside the data of a medium is an error.

    Method: tangential fields marched from the last medium up, good to 1e-12 in R and to 1e-9 of itself in T, at grazing
    incidence, beyond critical angles and behind opaque metals alike.

    >>> film = Stack(["air", Layer(1.333, thickness_nm=100.0), "air"])
    >>> round(film.reflectance(550.0), 10)
    0.0781050139
    """

    __slots__ = ()

    def color(
        self,
        angle_deg: npt.ArrayLike = 0.0,
        polarization: str = "unpolarized",
        illuminant: Any = "D65",
        observer: str = "cie1931",
        space: str = "xyz",
        quantity: str = "reflectance",
        model: str = "exact",
        wavelength_nm: npt.ArrayLike | None = None,
        adaptation: str | None = None,
        *,
        gamut: str | None = None,
    ) -> Floats:
        """Colour of the stack under an illuminant, relative to the perfect white reflector (Y = 1).

        X = sum(S R xbar) / sum(S ybar), Y and Z alike, over 360..830 nm at 1 nm, refined where fringes are finer.

        angle_deg      incidence in the first medium, [0, 90)          (...,) broadcasts with the thicknesses
        polarization   "s", "p" or "unpolarized"
        illuminant     a name or object of `iridesce.color.illuminant`
        observer       "cie1931" or "cie1964"
        space          "xyz", "xyy", "lab", "lch", "oklab"; "srgb", "display-p3", "rec2020" (encoded);
                       "linear-srgb", "acescg", "ntsc1953" (linear)
        quantity       "reflectance", "transmittance" or "absorptance"
        model          "exact", or "two-beam": the form of 1991 (one coherent layer, real indices, no polarisation)
        wavelength_nm  a uniform grid to sum over instead
        adaptation     None, or "bradford": from the illuminant's white to that of the space
        gamut          None keeps what is out of range of an RGB space; "clip" or "hue" (hue kept) brings it in
        Returns        float64 of the broadcast shape and a last axis of 3
        Raises         ValueError naming the argument, the value and what is allowed; ResourceError

        >>> import iridesce as ir
        >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=320.0), "air"])
        >>> film.color(space="srgb").shape
        (3,)
        """
        polarization = one_of("polarization", polarization, ("s", "p", "unpolarized"))
        quantity = one_of("quantity", quantity, ("reflectance", "transmittance", "absorptance"))
        if one_of("model", model, ("exact", "two-beam")) == "two-beam":
            self._must_be_one_film()
            if polarization != "unpolarized":
                raise complaint(
                    f'model="two-beam" knows no polarisation, got polarization={polarization!r}',
                    "polarization",
                    "unpolarized for the two-beam model",
                    polarization,
                )
            if quantity != "reflectance":
                raise complaint(
                    f'model="two-beam" gives the reflectance only, got quantity={quantity!r}',
                    "quantity",
                    "reflectance for the two-beam model",
                    quantity,
                )
        angle = real_operand("angle_deg", angle_deg, low=0.0, high=90.0)
        broadcast_shape([angle, *self._thicknesses()])
        # Here, not above: the colour stage comes after this one and is not needed for spectra.
        from iridesce import color

        result: Floats = color.stack_color(
            self,
            angle.full(),
            polarization,
            illuminant,
            observer,
            space,
            quantity,
            model,
            wavelength_nm,
            adaptation,
            gamut,
        )
        return result

    # Questions that live in modules of their own; each is an ordinary method.
    derivatives = derivatives.derivatives
    color_derivatives = color_slopes.color_derivatives
    color_uncertainty = color_slopes.color_uncertainty
    reflectance_averaged = averages.reflectance_averaged
    transmittance_averaged = averages.transmittance_averaged
    jones = fields.jones
    mueller = fields.mueller
    field_profile = fields.field_profile
    to_xarray = labelled.to_xarray

    def _repr_html_(self) -> str:
        """What a notebook shows: a table of the layers and the colour."""
        return stack_html(self)
