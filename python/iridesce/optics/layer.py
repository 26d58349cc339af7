"""One finite layer: a medium and a thickness; graded layers as slices, rough faces as a mixture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from iridesce.arguments.operands import Operand, real_operand
from iridesce.arguments.refusals import Words, complaint, refusal, short
from iridesce.optics.evaluation import medium_repr
from iridesce.optics.graded import between, of_index, slices
from iridesce.optics.medium import Medium, MediumLike, as_medium

__all__ = ["Layer"]


class Fixed:
    """An object that stays as it was made, so that results cannot change behind a stack that is in use."""

    __slots__ = ()

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a {type(self).__name__} cannot be changed; make a new one")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a {type(self).__name__} cannot be changed; make a new one")


class Layer(Fixed):
    """One finite layer of a stack.

    medium         name of a built-in medium, refractive index (complex n + ik), or `Medium`
    thickness_nm   thickness, >= 0 and finite; an array broadcasts like any other argument      (...,)
    coherent       ``False``: a slab so thick or uneven that its fringes average out; its faces add powers
    Raises         ValueError naming the argument, the value, its place and what is allowed

    >>> import iridesce as ir
    >>> ir.Layer("soap", thickness_nm=320.0)
    Layer('soap', thickness_nm=320.0)
    """

    __slots__ = ("_thickness", "coherent", "medium")

    medium: Medium
    coherent: bool
    _thickness: Operand

    def __init__(self, medium: MediumLike, thickness_nm: npt.ArrayLike, coherent: bool = True) -> None:
        if not isinstance(coherent, bool | np.bool_):
            raise refusal("coherent", "True or False", coherent)
        object.__setattr__(self, "medium", as_medium(medium))
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
        if callable(first):
            if second is not None or profile is not None:
                raise complaint(
                    "first is a function of the depth: second and profile must be None, got "
                    + " and ".join(map(short, (second, profile))),
                    "second" if second is not None else "profile",
                    "None where first is a function of the depth",
                    second if second is not None else profile,
                )
            made = slices(thickness_nm, of_index(first, thickness_nm), wavelength_nm, tolerance)
            return [cls(medium, nm) for medium, nm in made]
        if second is None:
            raise complaint(
                "second must be a medium, unless first is a function of the depth in nm, got None",
                "second",
                "a medium, unless first is a function of the depth in nm",
                second,
            )
        made = slices(thickness_nm, between(first, second, profile, rule), wavelength_nm, tolerance)
        return [cls(medium, nm) for medium, nm in made]

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
    def operand(self) -> Operand:
        """The thickness as an argument that broadcasts."""
        return self._thickness

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
        return f"Layer({medium_repr(self.medium)}, thickness_nm={thickness}{coherent})"

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


def check_one_thickness(layers: Sequence[Layer], what: str) -> None:
    """Refuse layers with several thicknesses, where ``what`` ("a fit") takes one of each.

    >>> check_one_thickness([Layer("soap", [1.0, 2.0])], "a fit")
    Traceback (most recent call last):
    iridesce.errors.ArgumentError: a fit needs one thickness a layer, got 2 for layer 1
    """
    for number, layer in enumerate(layers, start=1):
        if (count := np.size(layer.thickness_nm)) != 1:
            words = f"{what} needs one thickness a layer, got {count} for layer {number}"
            raise complaint(words, "thickness_nm", "one number a layer", Words(count), f"for layer {number}")
