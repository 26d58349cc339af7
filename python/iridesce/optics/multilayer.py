"""Media and layers in the order light meets them, and what they do to light: R, T, A, amplitudes, ellipsometry."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce.arguments.operands import Floats, Operand, broadcast_shape, checked_out, new_array, real_operand
from iridesce.arguments.refusals import Words, complaint, refusal, short, within
from iridesce.arguments.scalars import one_of
from iridesce.optics.evaluation import check_ends, evaluate, index_at, medium_repr
from iridesce.optics.layer import Fixed, Layer
from iridesce.optics.medium import Medium, MediumLike, as_medium
from iridesce.optics.stack_text import EXAMPLE, parse_items

_POLARIZATIONS = ("s", "p", "unpolarized")
# Numbers of a block of elements, laid out for the core.
_BLOCK = 1 << 20


class Multilayer(Fixed):
    """A first medium, layers in the order light meets them, and a last medium: a `Stack` before it has colours.

    What users hold, `iridesce.Stack`, documents both.
    """

    __slots__ = ("first", "last", "layers")

    first: Medium
    layers: tuple[Layer, ...]
    last: Medium

    def __init__(self, items: Iterable[MediumLike | Layer]) -> None:
        if isinstance(items, str | bytes):
            raise complaint(
                f"a Stack takes a list, got {short(items)}; Stack.parse reads text like {EXAMPLE}",
                "stack",
                "a list of media and layers",
                items,
            )
        try:
            listed = list(items)
        except TypeError:
            raise complaint(
                f"a Stack takes a list of media and layers, got {short(items)}",
                "stack",
                "a list of media and layers",
                items,
            ) from None
        if len(listed) < 2:
            raise complaint(
                f"a Stack needs a first and a last medium, got {short(items)}",
                "stack",
                "a list with a first and a last medium",
                items,
            )
        for position, item in enumerate(listed):
            is_end = position in (0, len(listed) - 1)
            if is_end and isinstance(item, Layer):
                raise refusal(f"item {position} of a Stack", "a medium without thickness", item)
            if not is_end and not isinstance(item, Layer):
                raise refusal(f"item {position} of a Stack", "a Layer(medium, thickness_nm=...)", item)
        object.__setattr__(self, "first", as_medium(listed[0]))
        object.__setattr__(self, "layers", tuple(listed[1:-1]))
        object.__setattr__(self, "last", as_medium(listed[-1]))
        check_ends(self.first, self.last)

    @classmethod
    def parse(cls, text: str) -> Self:
        """A stack from one line of text: items separated by `` / ``, layers with their nm.

        text       such as "air / soap 320 / air"; an item is a name, a number or n+kj, layers add their thickness
                   in nm and, for a slab, the word incoherent: "air / MgF2 100 / N-BK7 1e6 incoherent / air"
        Returns    Stack
        Raises     ValueError naming the item that cannot be read

        >>> import iridesce as ir
        >>> ir.Stack.parse("air / 1.38 100 / 1.5")
        Stack(['air', Layer(1.38, thickness_nm=100.0), 1.5])
        """
        first, *layers, last = parse_items(text)
        items: list[MediumLike | Layer] = [first.medium]
        for item in layers:
            try:
                items.append(Layer(item.medium, item.thickness_nm, item.coherent))
            except ValueError as error:
                raise within(item.where, error) from None
        return cls([*items, last.medium])

    @property
    def media(self) -> tuple[Medium, ...]:
        """All media, from the first to the last."""
        return (self.first, *(layer.medium for layer in self.layers), self.last)

    def reversed(self) -> Self:
        """The same stack with the light coming from the other side.

        Returns    Stack
        Raises     ValueError where the last medium absorbs: the incident power is defined in a clear medium only

        >>> import iridesce as ir
        >>> coat = ir.Stack(["air", ir.Layer(1.38, thickness_nm=100.0), 1.52])
        >>> coat.reversed()
        Stack([1.52, Layer(1.38, thickness_nm=100.0), 'air'])
        >>> abs(coat.transmittance(550.0) - coat.reversed().transmittance(550.0)) < 1e-15
        True
        """
        return type(self)([self.last, *self.layers[::-1], self.first])

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

        >>> import iridesce as ir
        >>> round(ir.Stack(["air", 1.5]).reflectance(550.0), 4)
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

        >>> import iridesce as ir
        >>> round(ir.Stack(["air", 1.5]).transmittance(550.0), 4)
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

        >>> import iridesce as ir
        >>> silver = ir.Stack(["air", ir.Layer(0.06 + 3.6j, thickness_nm=20.0), 1.5])
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

        >>> import iridesce as ir
        >>> film = ir.Stack(["air", ir.Layer(1.38, 100.0), ir.Layer(0.06 + 3.6j, 20.0), 1.5])
        >>> film.layer_absorptance(550.0).shape
        (2,)
        """
        shape, arguments = self._arguments(wavelength_nm, angle_deg)
        polarization = _checked_polarization(polarization)
        full = (*shape, len(self.layers))
        result: Floats = new_array("layer_absorptance", full) if out is None else checked_out(out, full)
        self._ask("layer_absorptance", polarization, shape, arguments, result.reshape(-1), None, threads)
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

        >>> import iridesce as ir
        >>> r, t = ir.Stack(["air", 1.5]).amplitudes(550.0, 0.0, "s")
        >>> round(r.real, 12), round(t.real, 12)
        (-0.2, 0.8)
        """
        if _checked_polarization(polarization) == "unpolarized":
            raise complaint(
                'amplitudes exist for polarization "s" or "p" only, got "unpolarized"',
                "polarization",
                '"s" or "p"',
                "unpolarized",
            )
        self._must_be_coherent("amplitudes")
        shape, arguments = self._arguments(wavelength_nm, angle_deg)
        r = new_array("amplitudes", shape, np.complex128)
        t = new_array("amplitudes", shape, np.complex128)
        flat = [array.reshape(-1).view(np.float64) for array in (r, t)]
        self._ask("amplitudes", polarization, shape, arguments, flat[0], flat[1], threads)
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

        >>> import iridesce as ir
        >>> psi, delta = ir.Stack(["air", 1.5]).ellipsometry(550.0, 0.0)
        >>> round(psi, 9), round(delta, 9)
        (45.0, 180.0)
        """
        self._must_be_coherent("ellipsometry")
        shape, arguments = self._arguments(wavelength_nm, angle_deg)
        psi, delta = new_array("psi_deg", shape), new_array("delta_deg", shape)
        self._ask("ellipsometry", "s", shape, arguments, psi.reshape(-1), delta.reshape(-1), threads)
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

        >>> import iridesce as ir
        >>> film = ir.Stack(["air", ir.Layer(1.333, thickness_nm=103.15), "air"])
        >>> round(film.two_beam_reflectance(550.0), 4), round(film.reflectance(550.0), 4)
        (0.0815, 0.0783)
        """
        self._must_be_one_film()
        shape, arguments = self._arguments(wavelength_nm, angle_deg)
        result = new_array("two_beam_reflectance", shape)
        self._ask("two_beam", "unpolarized", shape, arguments, result.reshape(-1), None, threads)
        return result if shape else float(result)

    def two_beam_purity(self, wavelength_nm: npt.ArrayLike) -> Any:
        """Colour purity of the two-beam form, eps = (r12 - r23)^2/(4 r12 r23): purest at 0 or -1, paler as |eps| grows.

        wavelength_nm  vacuum wavelength, > 0                          (...,)
        Returns        float64 of the same shape (a float for a scalar)
        Raises         ValueError also for stacks other than one coherent film, indices that are not real, and where an
                       interface does not reflect

        >>> import iridesce as ir
        >>> ir.Stack(["air", ir.Layer(1.33, thickness_nm=100.0), "air"]).two_beam_purity(550.0)
        -1.0
        """
        self._must_be_one_film()
        wavelength = real_operand("wavelength_nm", wavelength_nm, low=0.0, includes_low=False)
        indices = [index_at(medium, wavelength.values) for medium in self.media]
        if any(np.any(index.imag != 0.0) for index in indices):
            raise complaint(
                "the two-beam form takes real indices: every medium must have k = 0",
                "stack",
                "one of media with k = 0 for the two-beam form",
                Words("an absorbing one"),
            )
        full = [np.broadcast_to(index.real, wavelength.values.shape).reshape(-1) for index in indices]
        own = wavelength.values.shape if wavelength.shape else ()
        eps = _core.two_beam_purity(np.ascontiguousarray(np.stack(full, axis=-1)), list(own))
        return np.broadcast_to(eps.reshape(wavelength.values.shape), wavelength.shape).copy() if own else float(eps[0])

    def __repr__(self) -> str:
        items = [medium_repr(self.first), *map(repr, self.layers), medium_repr(self.last)]
        return f"{type(self).__name__}([{', '.join(items)}])"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Multilayer):
            return NotImplemented
        return (self.first, self.layers, self.last) == (other.first, other.layers, other.last)

    def __hash__(self) -> int:
        return hash((self.first, self.layers, self.last))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), ([self.first, *self.layers, self.last],)

    # --- the way to the core

    def _thicknesses(self) -> list[Operand]:
        """The layers' thicknesses, with names that tell them apart in errors."""
        only = len(self.layers) == 1
        return [
            Operand(
                "thickness_nm" if only else f"thickness_nm of layer {number}", layer.operand.values, layer.operand.shape
            )
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
        self._ask(quantity, polarization, shape, arguments, result.reshape(-1), None, threads)
        return float(result) if shape == () and out is None else result

    def _ask(
        self,
        quantity: str,
        polarization: str,
        shape: tuple[int, ...],
        arguments: list[Operand],
        out: Floats,
        second: Floats | None,
        threads: int | None,
    ) -> None:
        coherent = [layer.coherent for layer in self.layers]
        evaluate(quantity, polarization, self.media, coherent, shape, arguments, out, second, threads)

    def _elements(
        self, shape: tuple[int, ...], arguments: list[Operand], extended: bool = False, hold: bool = False
    ) -> Iterator[tuple[slice, tuple[npt.NDArray[np.complex128], Floats, Floats, Floats]]]:
        """Every argument in full size, one row an element, in blocks of some megabytes: (which rows, (indices,
        thicknesses, wavelength, angle)). Laid out at once they could fit nowhere, and nobody hears Ctrl-C meanwhile.

        ``extended``: built-in media continue beyond their data as they state, as in colour sums; ``hold``: all media
        keep the ends of their data.
        """
        wavelength_nm, angle_deg, *thickness_nm = (_flat(argument.full(), shape) for argument in arguments)
        columns = []
        for medium in self.media:
            if extended and medium.kind != "constant":
                flat, _ = medium._core.index_extended(np.ascontiguousarray(arguments[0].values.reshape(-1)))
                values = flat.reshape(arguments[0].values.shape)
            elif hold:
                values = np.asarray(medium.index(arguments[0].values, extrapolate="hold"))
            else:
                values = index_at(medium, arguments[0].values)
            columns.append(_flat(values, shape))
        rows, layers = math.prod(shape), len(self.layers)
        step = max(1, _BLOCK // (3 * layers + 6))
        for start in range(0, rows, step):
            which = slice(start, min(start + step, rows))
            indices = np.empty((which.stop - start, layers + 2), np.complex128)
            for column, index in enumerate(columns):
                indices[:, column] = index[which]
            thickness = np.empty((which.stop - start, layers))
            for column, values_nm in enumerate(thickness_nm):
                thickness[:, column] = values_nm[which]
            nm, deg = (np.ascontiguousarray(argument[which]) for argument in (wavelength_nm, angle_deg))
            yield which, (indices, thickness, nm, deg)

    def _must_be_coherent(self, what: str) -> None:
        for number, layer in enumerate(self.layers, start=1):
            if not layer.coherent:
                raise complaint(
                    f"{what} of a stack need coherent layers; layer {number}, {layer!r}, is incoherent",
                    "stack",
                    "one of coherent layers",
                    layer,
                    f"for layer {number}",
                )

    def _must_be_one_film(self) -> None:
        if len(self.layers) != 1 or not self.layers[0].coherent:
            raise complaint(
                f"the two-beam form takes exactly one layer, a coherent one, got {short(self)}",
                "stack",
                "one of exactly one layer, a coherent one, for the two-beam form",
                self,
            )


def _flat(values: npt.NDArray[Any], shape: tuple[int, ...]) -> Any:
    """What gives any part of the values in their full shape, flat, without laying all of them out."""
    full = np.broadcast_to(values, shape)
    return full.reshape(-1) if full.flags.c_contiguous else full.flat


def _checked_polarization(value: object) -> str:
    return one_of("polarization", value, _POLARIZATIONS)
