"""Stacks of films: reflectance, transmittance, absorptance, amplitudes, ellipsometry, colour."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import (
    Floats,
    Operand,
    broadcast_shape,
    checked_out,
    checked_threads,
    new_array,
    one_of,
    place,
    real_operand,
)
from iridesce.optics import averages, fields, labelled
from iridesce.optics import derivatives as _derivatives
from iridesce.optics.medium import Medium, MediumLike
from iridesce.optics.stack_text import EXAMPLE, parse_items

__all__ = ["Layer", "Stack"]

_POLARIZATIONS = ("s", "p", "unpolarized")


class _Fixed:
    """An object that stays as it was made, so that results cannot change behind a stack that is in use."""

    __slots__ = ()

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a {type(self).__name__} cannot be changed; make a new one")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a {type(self).__name__} cannot be changed; make a new one")


class Layer(_Fixed):
    """One finite layer of a stack.

    medium         name of a built-in medium, refractive index (complex n + ik), or `Medium`
    thickness_nm   thickness, >= 0 and finite; an array broadcasts like any other argument      (...,)
    coherent       ``False``: a slab so thick or uneven that its fringes average out; its faces add powers
    Raises         ValueError naming the argument, the value, its place and what is allowed

    >>> Layer("soap", thickness_nm=320.0)
    Layer('soap', thickness_nm=320.0)
    """

    __slots__ = ("_thickness", "coherent", "medium")

    medium: Medium
    coherent: bool
    _thickness: Operand

    def __init__(self, medium: MediumLike, thickness_nm: npt.ArrayLike, coherent: bool = True) -> None:
        if not isinstance(coherent, bool | np.bool_):
            raise ValueError(f"coherent must be True or False, got {coherent!r}")
        object.__setattr__(self, "medium", _as_medium(medium))
        object.__setattr__(self, "_thickness", real_operand("thickness_nm", thickness_nm, low=0.0))
        object.__setattr__(self, "coherent", bool(coherent))

    @classmethod
    def graded(
        cls,
        thickness_nm: npt.ArrayLike,
        first: MediumLike | Callable[[float], Any],
        second: MediumLike | None = None,
        profile: Callable[[float], float] | None = None,
        rule: str = "bruggeman",
        *,
        wavelength_nm: npt.ArrayLike = (400.0, 550.0, 700.0),
        tolerance: float = 1e-5,
    ) -> list[Layer]:
        """A layer whose index changes with depth, as slices; put them into a `Stack` with a star.

        Equal slices, each of the index in its middle, twice as many until R and T change by less than three times the
        tolerance, as the error falls with the square of their number. That is looked at between air and n = 4, and
        between the layer's own ends where these are clear, at 0 and 60 degrees.

        thickness_nm   of the whole                                                 (...,) broadcasts as for a `Layer`
        first          the medium at the top; or a function of the depth in nm that gives n + ik, and no ``second``
        second         the medium at the bottom
        profile        share of the second by volume against depth, both from 0 to 1; None: it grows in proportion
        rule           of the mixture: "bruggeman", "maxwell-garnett", "lorentz-lorenz"
        wavelength_nm  where the error is looked at: the ends and the middle of what you need
        tolerance      the error of R and T that is allowed
        Returns        list of `Layer`
        Raises         ValueError naming the argument; a tolerance that 1 024 slices do not reach
        Source         Born & Wolf, Principles of Optics, 7th ed., sec. 1.6 (stratified media as a limit of homogeneous layers)

        >>> import iridesce as ir
        >>> moth_eye = ir.Stack(["air", *ir.Layer.graded(400.0, "air", "SiO2"), "SiO2"])
        >>> round(moth_eye.reflectance(550.0), 5), round(ir.Stack(["air", "SiO2"]).reflectance(550.0), 5)
        (0.00056, 0.03495)
        """
        from iridesce.optics import graded

        if callable(first):
            if second is not None or profile is not None:
                raise ValueError("first is a function of the depth: second and profile must be None")
            return graded.graded(thickness_nm, graded.of_index(first, thickness_nm), wavelength_nm, tolerance)
        if second is None:
            raise ValueError("second must be a medium, unless first is a function of the depth in nm")
        return graded.graded(thickness_nm, graded.between(first, second, profile, rule), wavelength_nm, tolerance)

    @classmethod
    def rough(cls, rms_nm: npt.ArrayLike, above: MediumLike, below: MediumLike) -> Layer:
        """A rough face, as a layer of both media in equal shares by Bruggeman's rule, 2 rms thick.

        A face that is as often rms above its mean as below it has this layer's thickness and share exactly. It holds
        for roughness much finer and shallower than the wavelength; light that rougher faces scatter is not told.

        rms_nm         root mean square of the height, nm, >= 0                     (...,) broadcasts as for a `Layer`
        above, below   the media on its sides
        Returns        `Layer`
        Raises         ValueError naming the argument
        Source         D. A. G. Bruggeman, Ann. Phys. 416, 636 (1935), for the mixture

        >>> import iridesce as ir
        >>> rough = ir.Stack(["air", ir.Layer.rough(3.0, "air", "Si"), "Si"])
        >>> round(rough.reflectance(400.0) / ir.Stack(["air", "Si"]).reflectance(400.0), 3)
        0.958
        """
        height = real_operand("rms_nm", rms_nm, low=0.0)
        return cls(Medium.mixture(above, below, 0.5), 2.0 * height.values.reshape(height.shape))

    @property
    def thickness_nm(self) -> Any:
        """Thickness in nm: a float, or a read-only float64 array."""
        return float(self._thickness.values) if self._thickness.shape == () else self._thickness.full()

    def __repr__(self) -> str:
        if self._thickness.shape == ():
            thickness = repr(self.thickness_nm)
        else:
            values = self._thickness.values
            thickness = f"<{self._thickness.shape}, {values.min():g} to {values.max():g}>"
        coherent = "" if self.coherent else ", coherent=False"
        return f"Layer({_medium_repr(self.medium)}, thickness_nm={thickness}{coherent})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Layer):
            return NotImplemented
        return (
            self.medium == other.medium
            and self.coherent == other.coherent
            and self._thickness.shape == other._thickness.shape
            and np.array_equal(self._thickness.full(), other._thickness.full())
        )

    def __hash__(self) -> int:
        values = self._thickness.values
        return hash((self.medium, self.coherent, self._thickness.shape, values.flat[0], values.flat[-1]))

    def __reduce__(self) -> tuple[Any, ...]:
        return Layer, (self.medium, self.thickness_nm, self.coherent)


class Stack(_Fixed):
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

    __slots__ = ("first", "last", "layers")

    first: Medium
    layers: tuple[Layer, ...]
    last: Medium

    def __init__(self, items: Iterable[MediumLike | Layer]) -> None:
        if isinstance(items, str | bytes):
            raise ValueError(f"a Stack takes a list, got {items!r}; Stack.parse reads text like {EXAMPLE}")
        try:
            listed = list(items)
        except TypeError:
            raise ValueError(f"a Stack takes a list of media and layers, got {items!r}") from None
        if len(listed) < 2:
            raise ValueError(f"a Stack needs a first and a last medium, got {items!r}")
        for position, item in enumerate(listed):
            is_end = position in (0, len(listed) - 1)
            if is_end and isinstance(item, Layer):
                raise ValueError(f"item {position} of a Stack must be a medium without thickness, got {item!r}")
            if not is_end and not isinstance(item, Layer):
                raise ValueError(f"item {position} of a Stack must be a Layer(medium, thickness_nm=...), got {item!r}")
        object.__setattr__(self, "first", _as_medium(listed[0]))
        object.__setattr__(self, "layers", tuple(listed[1:-1]))
        object.__setattr__(self, "last", _as_medium(listed[-1]))
        _check_ends(self.first, self.last)

    @classmethod
    def parse(cls, text: str) -> Stack:
        """A stack from one line of text: items separated by `` / ``, layers with their nm.

        text       such as "air / soap 320 / air"; an item is a name, a number or n+kj, layers add their thickness
                   in nm and, for a slab, the word incoherent: "air / MgF2 100 / N-BK7 1e6 incoherent / air"
        Returns    Stack
        Raises     ValueError naming the item that cannot be read

        >>> Stack.parse("air / 1.38 100 / 1.5")
        Stack(['air', Layer(1.38, thickness_nm=100.0), 1.5])
        """
        first, *layers, last = parse_items(text)
        items: list[MediumLike | Layer] = [first.medium]
        for item in layers:
            try:
                items.append(Layer(item.medium, item.thickness_nm, item.coherent))
            except ValueError as error:
                raise ValueError(f"{item.where}: {error}") from None
        return cls([*items, last.medium])

    @property
    def media(self) -> tuple[Medium, ...]:
        """All media, from the first to the last."""
        return (self.first, *(layer.medium for layer in self.layers), self.last)

    def reversed(self) -> Stack:
        """The same stack with the light coming from the other side.

        Returns    Stack
        Raises     ValueError where the last medium absorbs: the incident power is defined in a clear medium only

        >>> coat = Stack(["air", Layer(1.38, thickness_nm=100.0), 1.52])
        >>> coat.reversed()
        Stack([1.52, Layer(1.38, thickness_nm=100.0), 'air'])
        >>> abs(coat.transmittance(550.0) - coat.reversed().transmittance(550.0)) < 1e-15
        True
        """
        return Stack([self.last, *self.layers[::-1], self.first])

    def reflectance(
        self,
        wavelength_nm: npt.ArrayLike,
        angle_deg: npt.ArrayLike = 0.0,
        polarization: str = "unpolarized",
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Any:
        """Reflected share of the incident power.

        R = |r|^2 per polarisation; "unpolarized" is the mean of s and p.

        wavelength_nm  vacuum wavelength, > 0                          (...,)
        angle_deg      incidence in the first medium, [0, 90)          (...,) broadcasts
        polarization   "s", "p" or "unpolarized"
        out            array to write into: writable, float64, C order, of the result's shape
        threads        None: all cores, or RAYON_NUM_THREADS; the result does not depend on it
        Returns        float64 of the broadcast shape (a float for scalars); `out` where it was given
        Raises         ValueError naming the argument, the value and the allowed range; ResourceError for a result that
                       cannot fit
        Source         F. Abeles, Ann. Phys. (Paris) 5, 596 (1950), scaled against overflow

        >>> round(Stack(["air", 1.5]).reflectance(550.0), 4)
        0.04
        """
        return self._power("reflectance", wavelength_nm, angle_deg, polarization, out, threads)

    def transmittance(
        self,
        wavelength_nm: npt.ArrayLike,
        angle_deg: npt.ArrayLike = 0.0,
        polarization: str = "unpolarized",
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Any:
        """Transmitted share: power flux along the normal in the last medium over that in the first.

        T_s = Re(kz_last)/kz_first |t|^2, T_p = Re(kz_last/n_last^2)/(kz_first/n_first^2) |t_H|^2; 0 beyond the critical
        angle of a clear last medium.

        wavelength_nm, angle_deg, polarization, out, threads  as for `reflectance`
        Returns        float64 of the broadcast shape (a float for scalars); `out` where it was given
        Raises         ValueError, ResourceError as for `reflectance`

        >>> round(Stack(["air", 1.5]).transmittance(550.0), 4)
        0.96
        """
        return self._power("transmittance", wavelength_nm, angle_deg, polarization, out, threads)

    def absorptance(
        self,
        wavelength_nm: npt.ArrayLike,
        angle_deg: npt.ArrayLike = 0.0,
        polarization: str = "unpolarized",
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Any:
        """Share of the incident power absorbed in the layers, A = 1 - R - T; negative where they amplify.

        What an absorbing last medium takes in is transmittance.

        wavelength_nm, angle_deg, polarization, out, threads  as for `reflectance`
        Returns        float64 of the broadcast shape (a float for scalars); `out` where it was given
        Raises         ValueError, ResourceError as for `reflectance`

        >>> silver = Stack(["air", Layer(0.06 + 3.6j, thickness_nm=20.0), 1.5])
        >>> round(silver.absorptance(550.0), 6)
        0.024862
        """
        return self._power("absorptance", wavelength_nm, angle_deg, polarization, out, threads)

    def layer_absorptance(
        self,
        wavelength_nm: npt.ArrayLike,
        angle_deg: npt.ArrayLike = 0.0,
        polarization: str = "unpolarized",
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Floats:
        """Share of the incident power absorbed in each layer; negative for gain. With R and T it makes 1.

        wavelength_nm, angle_deg, polarization, out, threads  as for `reflectance`
        Returns        float64 of the broadcast shape and a last axis with one entry per layer
        Raises         ValueError, ResourceError as for `reflectance`

        >>> film = Stack(["air", Layer(1.38, 100.0), Layer(0.06 + 3.6j, 20.0), 1.5])
        >>> film.layer_absorptance(550.0).shape
        (2,)
        """
        shape, arguments = self._arguments(wavelength_nm, angle_deg)
        polarization = _checked_polarization(polarization)
        full = (*shape, len(self.layers))
        result: Floats = new_array("layer_absorptance", full) if out is None else checked_out(out, full)
        self._evaluate("layer_absorptance", polarization, shape, arguments, result.reshape(-1), None, threads)
        return result

    def amplitudes(
        self,
        wavelength_nm: npt.ArrayLike,
        angle_deg: npt.ArrayLike,
        polarization: str,
        threads: int | None = None,
    ) -> tuple[Any, Any]:
        """Amplitudes of the reflected and transmitted electric field over the incident one.

        Phase of r at the first interface, of t at the last one; r_p = -r_s at normal incidence.

        wavelength_nm, angle_deg, threads  as for `reflectance`
        polarization   "s" or "p"
        Returns        (r, t), complex128 of the broadcast shape (complex numbers for scalars)
        Raises         ValueError also for "unpolarized" and for stacks with incoherent slabs; ResourceError

        >>> r, t = Stack(["air", 1.5]).amplitudes(550.0, 0.0, "s")
        >>> round(r.real, 12), round(t.real, 12)
        (-0.2, 0.8)
        """
        if _checked_polarization(polarization) == "unpolarized":
            raise ValueError('amplitudes exist for polarization "s" or "p" only, got "unpolarized"')
        self._must_be_coherent("amplitudes")
        shape, arguments = self._arguments(wavelength_nm, angle_deg)
        r = new_array("amplitudes", shape, np.complex128)
        t = new_array("amplitudes", shape, np.complex128)
        flat = [array.reshape(-1).view(np.float64) for array in (r, t)]
        self._evaluate("amplitudes", polarization, shape, arguments, flat[0], flat[1], threads)
        return (r, t) if shape else (complex(r), complex(t))

    def ellipsometry(
        self,
        wavelength_nm: npt.ArrayLike,
        angle_deg: npt.ArrayLike,
        threads: int | None = None,
    ) -> tuple[Any, Any]:
        """Ellipsometric angles: tan(psi) = |r_p / r_s|, delta = arg(r_p / r_s) in [0, 360).

        delta is 180 for a bare clear surface near the normal. Instruments that write n - ik report 360 - delta.

        wavelength_nm, angle_deg, threads  as for `reflectance`
        Returns        (psi_deg, delta_deg), float64 of the broadcast shape (floats for scalars)
        Raises         ValueError also for stacks with incoherent slabs, and where nothing is reflected; ResourceError

        >>> psi, delta = Stack(["air", 1.5]).ellipsometry(550.0, 0.0)
        >>> round(psi, 9), round(delta, 9)
        (45.0, 180.0)
        """
        self._must_be_coherent("ellipsometry")
        shape, arguments = self._arguments(wavelength_nm, angle_deg)
        psi, delta = new_array("psi_deg", shape), new_array("delta_deg", shape)
        self._evaluate("ellipsometry", "s", shape, arguments, psi.reshape(-1), delta.reshape(-1), threads)
        return (psi, delta) if shape else (float(psi), float(delta))

    def two_beam_reflectance(
        self, wavelength_nm: npt.ArrayLike, angle_deg: npt.ArrayLike = 0.0, threads: int | None = None
    ) -> Any:
        """Reflectance in the two-beam form of 1991, for weak contrast: R = 4 r12 r23 (eps + cos^2(delta/2)).

        delta = 4 pi n2 t cos(theta2)/lambda; r12 and r23 are those of normal incidence at every angle, without
        polarisation. For one coherent layer with real indices.

        wavelength_nm, angle_deg, threads  as for `reflectance`
        Returns        float64 of the broadcast shape (a float for scalars)
        Raises         ValueError also for other stacks and beyond the film's critical angle; ResourceError
        Source         M. L. Dias, IEEE Computer Graphics and Applications 11(2), 1991, corrected in 14(3), 1994

        >>> film = Stack(["air", Layer(1.333, thickness_nm=103.15), "air"])
        >>> round(film.two_beam_reflectance(550.0), 4), round(film.reflectance(550.0), 4)
        (0.0815, 0.0783)
        """
        self._must_be_one_film()
        shape, arguments = self._arguments(wavelength_nm, angle_deg)
        result = new_array("two_beam_reflectance", shape)
        self._evaluate("two_beam", "unpolarized", shape, arguments, result.reshape(-1), None, threads)
        return result if shape else float(result)

    def two_beam_purity(self, wavelength_nm: npt.ArrayLike) -> Any:
        """Colour purity of the two-beam form, eps = (r12 - r23)^2/(4 r12 r23): purest at 0 or -1, paler as |eps| grows.

        wavelength_nm  vacuum wavelength, > 0                          (...,)
        Returns        float64 of the same shape (a float for a scalar)
        Raises         ValueError also for stacks other than one coherent film, indices that are not real, and where an
                       interface does not reflect

        >>> Stack(["air", Layer(1.33, thickness_nm=100.0), "air"]).two_beam_purity(550.0)
        -1.0
        """
        self._must_be_one_film()
        wavelength = real_operand("wavelength_nm", wavelength_nm, low=0.0, includes_low=False)
        indices = [_indices(medium, wavelength.values) for medium in self.media]
        if any(np.any(index.imag != 0.0) for index in indices):
            raise ValueError("the two-beam form takes real indices: every medium must have k = 0")
        n = [np.broadcast_to(index.real, wavelength.values.shape) for index in indices]
        r12, r23 = (n[0] - n[1]) / (n[0] + n[1]), (n[1] - n[2]) / (n[1] + n[2])
        dark = r12 * r23 == 0.0
        if np.any(dark):
            where = place(np.unravel_index(int(np.argmax(dark)), dark.shape))
            raise ValueError(f"the purity eps has no value where an interface does not reflect{where}")
        eps = np.broadcast_to((r12 - r23) ** 2 / (4.0 * r12 * r23), wavelength.shape)
        return eps.copy() if wavelength.shape else float(eps)

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

        >>> film = Stack(["air", Layer("soap", thickness_nm=320.0), "air"])
        >>> film.color(space="srgb").shape
        (3,)
        """
        polarization = _checked_polarization(polarization)
        quantity = one_of("quantity", quantity, ("reflectance", "transmittance", "absorptance"))
        if one_of("model", model, ("exact", "two-beam")) == "two-beam":
            self._must_be_one_film()
            if polarization != "unpolarized":
                raise ValueError(f'model="two-beam" knows no polarisation, got polarization={polarization!r}')
            if quantity != "reflectance":
                raise ValueError(f'model="two-beam" gives the reflectance only, got quantity={quantity!r}')
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
    derivatives = _derivatives.derivatives
    color_derivatives = _derivatives.color_derivatives
    color_uncertainty = _derivatives.color_uncertainty
    reflectance_averaged = averages.reflectance_averaged
    transmittance_averaged = averages.transmittance_averaged
    jones = fields.jones
    mueller = fields.mueller
    field_profile = fields.field_profile
    to_xarray = labelled.to_xarray

    def __repr__(self) -> str:
        items = [_medium_repr(self.first), *map(repr, self.layers), _medium_repr(self.last)]
        return f"Stack([{', '.join(items)}])"

    def _repr_html_(self) -> str:
        """What a notebook shows: a table of the layers and the colour."""
        from iridesce import _notebook  # uses colour, a later stage

        return _notebook.stack_html(self)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Stack):
            return NotImplemented
        return (self.first, self.layers, self.last) == (other.first, other.layers, other.last)

    def __hash__(self) -> int:
        return hash((self.first, self.layers, self.last))

    def __reduce__(self) -> tuple[Any, ...]:
        return Stack, ([self.first, *self.layers, self.last],)

    # --- the way to the core

    def _thicknesses(self) -> list[Operand]:
        """The layers' thicknesses, with names that tell them apart in errors."""
        only = len(self.layers) == 1
        return [
            Operand("thickness_nm" if only else f"thickness_nm of layer {number}", *_parts(layer))
            for number, layer in enumerate(self.layers, start=1)
        ]

    def _arguments(
        self, wavelength_nm: npt.ArrayLike, angle_deg: npt.ArrayLike
    ) -> tuple[tuple[int, ...], list[Operand]]:
        """The shape of the result, and wavelength, angle and thicknesses, checked."""
        arguments = [
            real_operand("wavelength_nm", wavelength_nm, low=0.0, includes_low=False),
            real_operand("angle_deg", angle_deg, low=0.0, high=90.0),
            *self._thicknesses(),
        ]
        return broadcast_shape(arguments), arguments

    def _power(
        self,
        quantity: str,
        wavelength_nm: npt.ArrayLike,
        angle_deg: npt.ArrayLike,
        polarization: str,
        out: Floats | None,
        threads: int | None,
    ) -> Any:
        """One number an element: reflectance, transmittance or absorptance."""
        shape, arguments = self._arguments(wavelength_nm, angle_deg)
        polarization = _checked_polarization(polarization)
        result: Floats = new_array(quantity, shape) if out is None else checked_out(out, shape)
        self._evaluate(quantity, polarization, shape, arguments, result.reshape(-1), None, threads)
        return float(result) if shape == () and out is None else result

    def _evaluate(
        self,
        quantity: str,
        polarization: str,
        shape: tuple[int, ...],
        arguments: list[Operand],
        out: Floats,
        second: Floats | None,
        threads: int | None,
    ) -> None:
        """Indices once per wavelength and different medium, then one call into the core."""
        count = checked_threads(threads)
        rows: dict[Medium, int] = {}
        media = [rows.setdefault(medium, len(rows)) for medium in self.media]
        indices = [_indices(medium, arguments[0].values).reshape(-1) for medium in rows]
        _core.stack_evaluate(
            quantity,
            polarization,
            indices,
            media,
            [layer.coherent for layer in self.layers],
            [(argument.values.reshape(-1), argument.strides(shape)) for argument in arguments],
            list(shape),
            out,
            second,
            count,
        )

    def _elements(
        self, shape: tuple[int, ...], arguments: list[Operand], extended: bool = False, hold: bool = False
    ) -> tuple[npt.NDArray[np.complex128], Floats, Floats, Floats]:
        """Every argument in full size, one row an element: indices, thicknesses, wavelength, angle.

        ``extended``: built-in media continue beyond their data as they state, as in colour sums; ``hold``: all media
        keep the ends of their data.
        """
        wavelength_nm, angle_deg, *thickness_nm = (np.broadcast_to(argument.full(), shape) for argument in arguments)
        columns = []
        for medium in self.media:
            if extended and medium.kind != "constant":
                flat, _ = medium._core.index_extended(np.ascontiguousarray(arguments[0].values.reshape(-1)))
                values = flat.reshape(arguments[0].values.shape)
            elif hold:
                values = np.asarray(medium.index(arguments[0].values, extrapolate="hold"))
            else:
                values = _indices(medium, arguments[0].values)
            columns.append(np.broadcast_to(values, shape).reshape(-1))
        rows = wavelength_nm.size
        thickness = np.empty((rows, len(self.layers)))
        for column, values_nm in enumerate(thickness_nm):
            thickness[:, column] = values_nm.reshape(-1)
        return (
            np.ascontiguousarray(np.stack(columns, axis=-1)),
            thickness,
            np.ascontiguousarray(wavelength_nm.reshape(-1)),
            np.ascontiguousarray(angle_deg.reshape(-1)),
        )

    def _must_be_coherent(self, what: str) -> None:
        for number, layer in enumerate(self.layers, start=1):
            if not layer.coherent:
                raise ValueError(f"{what} of a stack need coherent layers; layer {number}, {layer!r}, is incoherent")

    def _must_be_one_film(self) -> None:
        if len(self.layers) != 1 or not self.layers[0].coherent:
            raise ValueError(f"the two-beam form takes exactly one layer, a coherent one, got {self!r}")


def _parts(layer: Layer) -> tuple[Floats, tuple[int, ...]]:
    return layer._thickness.values, layer._thickness.shape


def _as_medium(value: Any) -> Medium:
    return value if isinstance(value, Medium) else Medium(value)


def _constant_index(medium: Medium) -> complex | None:
    """The index of a medium that has the same one at every wavelength, else ``None``."""
    return complex(medium.index(550.0)) if medium.kind == "constant" else None


def _indices(medium: Medium, wavelength_nm: Floats) -> npt.NDArray[np.complex128]:
    """The medium's index at each wavelength, or a single one where it is constant; `ValueError` outside its data."""
    if medium.kind == "constant":
        return np.array(_constant_index(medium))
    if medium.range_nm is not None:
        low, high = medium.range_nm
        outside = (wavelength_nm < low) | (wavelength_nm > high)
        if outside.any():
            index = np.unravel_index(int(np.argmax(outside)), outside.shape)
            raise ValueError(
                f'medium "{medium.name}" has data for {low:g}-{high:g} nm; wavelength_nm must be within them, '
                f"got {wavelength_nm[index]}{place(index)}"
            )
    return np.asarray(medium.index(wavelength_nm))


def _medium_repr(medium: Medium) -> str:
    """As short as `Layer` and `Stack` take it: 'soap', 1.5, or the whole of ``Medium.from_file(...)``."""
    text = repr(medium)
    return text.removeprefix("Medium(").removesuffix(")") if text.startswith("Medium(") else text


def _check_ends(first: Medium, last: Medium) -> None:
    """What can be told without a wavelength; the core checks the rest at each one."""
    index = _constant_index(first)
    if index is not None and (index.imag != 0.0 or index.real <= 0.0):
        raise ValueError(f"the first medium must have real n > 0 and k = 0, got {_medium_repr(first)}")
    index = _constant_index(last)
    if index is not None and index.imag < 0.0:
        raise ValueError(f"the last medium must have k >= 0 (gain only in finite layers), got {_medium_repr(last)}")


def _checked_polarization(value: object) -> str:
    return one_of("polarization", value, _POLARIZATIONS)
