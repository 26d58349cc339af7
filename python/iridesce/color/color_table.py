"""Tables of a stack's colours over thickness and angle: measured error, millions of colours a second."""

from __future__ import annotations

import base64
import errno
import os
import warnings
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import _core
from iridesce._progress import Tell, Told, check_progress, watched
from iridesce.arguments.operands import Floats, Operand, broadcast_shape, checked_out, new_array, place, real_operand
from iridesce.arguments.refusals import Words, complaint, refusal, short
from iridesce.arguments.scalars import checked_threads, file_name, one_of
from iridesce.color.light import Illuminant
from iridesce.color.light import illuminant as named_illuminant
from iridesce.color.spaces import SPACES
from iridesce.files.whole import read_whole
from iridesce.image import Image
from iridesce.optics.multilayer import Multilayer

__all__ = ["ColorTable"]

Light = str | os.PathLike[str] | Illuminant

_QUANTITIES = ("reflectance", "transmittance", "absorptance")
_POLARIZATIONS = ("s", "p", "unpolarized")
_DEFAULT_NM = (0.0, 2000.0)
_MOST_BYTES = 2**31
_MOST_PIXELS = 2**26
_SHOWN = (360, 120)


class ColorTable:
    """Colours of a stack with one varying layer, over thickness and angle, for one or several lights.

    XYZ(t, theta) of `Stack.color` at the nodes of a grid over the angle and the reduced thickness
    v = t sqrt(1 - sin^2(theta) / m^2), along which the phase stands still; between them cubic Hermite in v and the cubic
    through four rows in angle. The grid is refined until the colour error is small enough, and the error that was
    measured stays with the table and with its file.

    stack          a `Stack`; all layers but one have a single thickness
    thickness_nm   (least, greatest) thickness of the varying layer, or any array: its extent. Without it that of the
                   array in the layer, else 0 to 2000 nm
    angle_deg      (least, greatest) incidence, [0, 90), or a single angle
    illuminant     a light as `iridesce.color.illuminant` takes it, or a list of them
    observer       "cie1931" or "cie1964"
    polarization   "s", "p" or "unpolarized"
    quantity       "reflectance", "transmittance" or "absorptance", or a list of them
    layer          which layer varies, its place in ``stack.layers``; needed where that is not plain
    max_delta_e    the greatest colour error to allow, CIEDE2000
    progress       called as ``progress(done, total)`` in colours, the total growing where the grid must be refined (with
                   ``stage="building"`` if it takes that); an exception from it stops the work. True draws a bar on
                   stderr
    Raises         ValueError naming the argument, the value and what is allowed, also where no grid of four million
                   nodes keeps to ``max_delta_e``; KeyboardInterrupt on Ctrl-C
    Warns          UserWarning when a built-in medium is used beyond its data (by its stated extension)

    The error that is stated is 1.25 times the worst that was found by probing between the nodes and climbing from the
    worst probes.

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=0.0), "air"])
    >>> table = ir.ColorTable(film, thickness_nm=(0.0, 1000.0), angle_deg=(0.0, 60.0))
    >>> table.max_delta_e <= 0.1
    True
    >>> table.color(320.0, 30.0, space="srgb").round(3).tolist()
    [0.224, 0.32, 0.216]
    """

    __slots__ = ("_facts", "_parts")

    _parts: dict[tuple[str, str], Any]
    _facts: dict[str, str]

    def __init__(
        self,
        stack: Multilayer,
        thickness_nm: ArrayLike | None = None,
        angle_deg: ArrayLike = (0.0, 80.0),
        illuminant: Light | list[Light] | tuple[Light, ...] = "D65",
        observer: str = "cie1931",
        polarization: str = "unpolarized",
        quantity: str | list[str] | tuple[str, ...] = "reflectance",
        layer: int | None = None,
        max_delta_e: float = 0.1,
        progress: Told = None,
    ) -> None:
        if not isinstance(stack, Multilayer):
            raise refusal("stack", "an iridesce.Stack", stack)
        varying = _varying_layer(stack, layer)
        range_nm = _range_nm(stack, varying, thickness_nm)
        range_deg = _extent(real_operand("angle_deg", angle_deg, low=0.0, high=90.0))
        lights = [named_illuminant(light) for light in _listed("illuminant", illuminant)]
        quantities = [one_of("quantity", name, _QUANTITIES) for name in _listed("quantity", quantity)]
        _check_distinct("illuminant", [light.name for light in lights])
        _check_distinct("quantity", quantities)
        observer = one_of("observer", observer, ("cie1931", "cie1964"))
        polarization = one_of("polarization", polarization, _POLARIZATIONS)
        tolerance = real_operand("max_delta_e", max_delta_e, low=0.0, includes_low=False)
        if tolerance.shape:
            raise refusal("max_delta_e", "a single number", Words(f"shape {tolerance.shape}"))
        check_progress(progress)

        parts, extended = _built(
            stack,
            varying,
            (range_nm, range_deg),
            lights,
            observer,
            polarization,
            quantities,
            float(tolerance.values),
            progress,
        )
        if extended:
            names = ", ".join(sorted(extended))
            warnings.warn(
                f"{names}: beyond the measured data inside 360..830 nm the stated extension was used", stacklevel=2
            )
        self._parts = parts
        self._facts = {
            "stack": _described(stack, varying, range_nm),
            "layer": str(varying),
            "observer": observer,
            "polarization": polarization,
        }

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> ColorTable:
        """A table from the file that `save` wrote.

        path       an .exr file of a colour table
        Returns    ColorTable
        Raises     ValueError where the file is no colour table or is damaged; OSError where it cannot be read

        >>> import pathlib, tempfile, iridesce as ir
        >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=0.0), "air"])
        >>> table = ir.ColorTable(film, (100.0, 400.0), angle_deg=0.0)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     table.save(pathlib.Path(folder, "film.exr"))
        ...     again = ir.ColorTable.load(pathlib.Path(folder, "film.exr"))
        >>> bool((again.color(250.0) == table.color(250.0)).all())
        True
        """
        name = file_name(path, (".exr",))
        if not Path(name).exists():
            raise FileNotFoundError(errno.ENOENT, "no such file", name)
        content = read_whole(name, _MOST_BYTES, "no colour table is")
        try:
            return cls._of_parts(_core.color_tables_read(content))
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None

    @classmethod
    def _of_parts(cls, read: list[tuple[Any, list[tuple[str, str]]]]) -> ColorTable:
        parts: dict[tuple[str, str], Any] = {}
        common: dict[str, str] | None = None
        for table, words in read:
            facts = dict(words)
            missing = [key for key in (*_FACTS, "illuminant", "quantity") if key not in facts]
            if missing:
                raise ValueError(f"the colour table lacks the attribute {missing[0]!r}")
            one_of("quantity", facts["quantity"], _QUANTITIES)
            key = (_unescaped(facts["illuminant"]), facts["quantity"])
            shared = {fact: _unescaped(facts[fact]) for fact in _FACTS}
            first = next(iter(parts.values()), table)
            if (common or shared) != shared or (first.range_nm, first.range_deg) != (table.range_nm, table.range_deg):
                raise ValueError("its parts belong to different tables")
            if key in parts:
                raise ValueError(f"it holds {key[1]} under {key[0]} twice")
            parts[key], common = table, shared
        made = cls.__new__(cls)
        made._parts, made._facts = parts, common or {}
        lights, quantities = made.illuminants, made.quantities
        if len(parts) != len(lights) * len(quantities):
            raise ValueError(f"it lacks parts: {len(parts)} for {len(lights)} lights and {len(quantities)} quantities")
        return made

    def color(
        self,
        thickness_nm: ArrayLike,
        angle_deg: ArrayLike | None = None,
        space: str = "xyz",
        illuminant: Light | None = None,
        quantity: str | None = None,
        adaptation: str | None = None,
        gamut: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Floats:
        """Colours at many thicknesses and angles, relative to the perfect white (Y = 1).

        thickness_nm   of the varying layer, within the table's               (...,)
        angle_deg      incidence, within the table's; None: its least         (...,) broadcasts
        space          as in `Stack.color`
        illuminant     one of the table's lights; None: its first
        quantity       one of the table's quantities; None: its first
        adaptation     None, or "bradford": from the illuminant's white to that of the space
        gamut          None keeps what is out of range of an RGB space; "clip" or "hue" (hue kept) brings it in
        out            where to put the result: float64, C order
        threads        1 to 1024; None uses all cores, or RAYON_NUM_THREADS
        Returns        float64 of the broadcast shape and a last axis of 3; ``out`` where it was given
        Raises         ValueError naming the argument, the value and its place; ResourceError

        A table may be called like a function: ``table(320.0, 30.0)``.

        >>> import iridesce as ir
        >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=0.0), "air"])
        >>> table = ir.ColorTable(film, (0.0, 600.0), angle_deg=(0.0, 45.0), illuminant=["D65", "A"])
        >>> table.color([[100.0], [200.0]], [0.0, 20.0, 40.0], illuminant="A").shape
        (2, 3, 3)
        """
        table = self._part(illuminant, quantity)
        space = one_of("space", space, SPACES)
        thickness = _within("thickness_nm", thickness_nm, table.range_nm)
        angle = _within("angle_deg", table.range_deg[0] if angle_deg is None else angle_deg, table.range_deg)
        shape = broadcast_shape(
            [Operand("thickness_nm", thickness, thickness.shape), Operand("angle_deg", angle, angle.shape)]
        )
        result: Floats = new_array("the colours", (*shape, 3)) if out is None else checked_out(out, (*shape, 3))
        one_angle = angle.size == 1
        table.evaluate(
            np.ascontiguousarray(np.broadcast_to(thickness, shape)).reshape(-1),
            np.ascontiguousarray(angle if one_angle else np.broadcast_to(angle, shape)).reshape(-1),
            space,
            adaptation if adaptation is None else one_of("adaptation", adaptation, ("bradford",)),
            gamut if gamut is None else one_of("gamut", gamut, ("clip", "hue")),
            result.reshape(-1, 3),
            checked_threads(threads),
        )
        return result

    __call__ = color

    def error(self, illuminant: Light | None = None, quantity: str | None = None) -> tuple[float, float]:
        """The colour error of one light and quantity, CIEDE2000: (greatest, mean), as measured when it was built.

        illuminant     one of the table's lights; None: its first
        quantity       one of the table's quantities; None: its first
        Returns        two floats
        Raises         ValueError naming the argument and what the table holds

        >>> import iridesce as ir
        >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=0.0), "air"])
        >>> greatest, mean = ir.ColorTable(film, (0.0, 400.0), angle_deg=20.0).error("D65")
        >>> mean < greatest <= 0.1
        True
        """
        greatest, mean, _ = self._part(illuminant, quantity).delta_e
        return float(greatest), float(mean)

    def ramp(
        self, size: tuple[int, int] = (1024, 256), illuminant: Light | None = None, quantity: str | None = None
    ) -> Image:
        """The table as a picture: thickness grows to the right, the angle downwards; the ends are pixel centres.

        size           (width, height) in pixels
        illuminant     one of the table's lights; None: its first
        quantity       one of the table's quantities; None: its first
        Returns        `Image`, whose channel ``thickness_nm`` tells the thickness of each pixel
        Raises         ValueError naming the argument, the value and what is allowed

        >>> import iridesce as ir
        >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=0.0), "air"])
        >>> table = ir.ColorTable(film, (0.0, 600.0), angle_deg=(0.0, 45.0))
        >>> table.ramp((300, 60)).shape
        (60, 300, 3)
        """
        try:
            width, height = (int(side) for side in size)
            if (width, height) != tuple(size) or min(width, height) < 1 or width * height > _MOST_PIXELS:
                raise ValueError
        except (TypeError, ValueError):
            raise refusal("size", f"(width, height), each >= 1, {_MOST_PIXELS} pixels at most", size) from None
        thickness = np.linspace(*self.thickness_nm, width)
        xyz = self.color(
            thickness, np.linspace(*self.angle_deg, height)[:, None], illuminant=illuminant, quantity=quantity
        )
        return Image(xyz, thickness_nm=np.broadcast_to(thickness, (height, width)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the table (.exr), or a picture of its first part (.png): a whole file or none.

        path       ``.exr``: a part for each light and quantity, in float32: channels ``XYZ.X XYZ.Y XYZ.Z``, their slopes
                   ``slope.X ..`` per step, and ``R G B`` (linear Rec.709) for viewers; ranges, light and error as attributes.
                   ``.png``: ``ramp()``, developed at automatic exposure
        Raises     ValueError for other endings; OSError naming the file where it cannot be written

        The same table gives the same bytes, also after `load`.

        >>> import pathlib, tempfile, iridesce as ir
        >>> film = ir.Stack(["air", ir.Layer(1.33, thickness_nm=0.0), "air"])
        >>> table = ir.ColorTable(film, (0.0, 600.0), angle_deg=(0.0, 45.0))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     table.save(pathlib.Path(folder, "film.png"))
        ...     pathlib.Path(folder, "film.png").read_bytes()[1:4]
        b'PNG'
        """
        name = file_name(path, (".exr", ".png"))
        if name.lower().endswith(".png"):
            self.ramp().save(name)
            return
        _core.color_tables_save(name, self._saved())

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        return _of_bytes, (_core.color_tables_bytes(self._saved()),)

    def __deepcopy__(self, memo: dict[int, Any]) -> ColorTable:
        return self  # immutable

    def _saved(self) -> list[tuple[Any, str, list[tuple[str, str | int | float]]]]:
        """The parts with their names and facts, as the core writes them."""
        common = [(key, _escaped(value)) for key, value in self._facts.items()]
        software = ("Software", f"iridesce {_core.__version__}")
        parts: list[tuple[Any, str, list[tuple[str, str | int | float]]]] = []
        for (light, what), table in self._parts.items():
            own = [("illuminant", _escaped(light)), ("quantity", what)]
            parts.append((table, _escaped(f"{light} {what}"), [software, *common, *own]))
        return parts

    @property
    def max_delta_e(self) -> float:
        """Colour error against exact sums, CIEDE2000: 1.25 times the worst that was found, over all parts."""
        return max(float(table.delta_e[0]) for table in self._parts.values())

    @property
    def mean_delta_e(self) -> float:
        """Mean colour error, CIEDE2000, of the worst part."""
        return max(float(table.delta_e[1]) for table in self._parts.values())

    @property
    def thickness_nm(self) -> tuple[float, float]:
        """Least and greatest thickness of the varying layer, nm."""
        low, high = next(iter(self._parts.values())).range_nm
        return float(low), float(high)

    @property
    def angle_deg(self) -> tuple[float, float]:
        """Least and greatest angle of incidence, degrees."""
        low, high = next(iter(self._parts.values())).range_deg
        return float(low), float(high)

    @property
    def illuminants(self) -> tuple[str, ...]:
        """Names of the lights."""
        return tuple(dict.fromkeys(light for light, _ in self._parts))

    @property
    def quantities(self) -> tuple[str, ...]:
        """What the colours are of: "reflectance", "transmittance", "absorptance"."""
        return tuple(dict.fromkeys(quantity for _, quantity in self._parts))

    @property
    def observer(self) -> str:
        """The observer, "cie1931" or "cie1964"."""
        return self._facts["observer"]

    @property
    def polarization(self) -> str:
        """The polarisation, "s", "p" or "unpolarized"."""
        return self._facts["polarization"]

    @property
    def layer(self) -> int:
        """Which layer varies: its place in ``stack.layers``."""
        return int(self._facts["layer"])

    @property
    def stack(self) -> str:
        """The stack in words, such as "air / soap 0..1000 / air"."""
        return self._facts["stack"]

    @property
    def nodes(self) -> int:
        """Nodes of the grids of all parts together; each takes 32 bytes."""
        return sum(int(rows * columns) for rows, columns in (table.shape for table in self._parts.values()))

    def __repr__(self) -> str:
        low, high = self.angle_deg
        return (
            f"<iridesce.ColorTable {self.stack}, {low:g} to {high:g} deg, {', '.join(self.illuminants)},"
            f" {', '.join(self.quantities)}, CIEDE2000 <= {self.max_delta_e:.2g}>"
        )

    def _repr_html_(self) -> str:
        """What a notebook shows: the ramp, and what the table holds."""
        picture = base64.b64encode(self.ramp(_SHOWN)._repr_png_()).decode("ascii")
        (thin, thick), (low, high) = self.thickness_nm, self.angle_deg
        facts = [
            ("stack", self.stack),
            ("thickness", f"{thin:g} to {thick:g} nm, to the right"),
            ("angle", f"{low:g} to {high:g}\u00b0, downwards"),
            ("light", ", ".join(self.illuminants)),
            ("quantity", ", ".join(self.quantities)),
            ("error", f"CIEDE2000 at most {self.max_delta_e:.2g}, {self.mean_delta_e:.2g} in the mean"),
            ("size", f"{self.nodes} nodes, {self.nodes * 32 / 1024:.0f} KiB"),
        ]
        cell = "text-align:left;padding:1px 12px 1px 0"
        rows = "".join(
            f'<tr><th style="{cell}">{label}</th><td style="{cell}">{escape(value)}</td></tr>' for label, value in facts
        )
        return f'<img alt="colours" src="data:image/png;base64,{picture}"/><table><tbody>{rows}</tbody></table>'

    def _part(self, illuminant: Light | None, quantity: str | None) -> Any:
        light = self.illuminants[0] if illuminant is None else _light_name(illuminant, self.illuminants)
        what = self.quantities[0] if quantity is None else quantity
        if what not in self.quantities:
            raise refusal("quantity", f"one of the table's, {', '.join(self.quantities)}", quantity)
        return self._parts[light, what]


_FACTS = ("stack", "layer", "observer", "polarization")


def _built(
    stack: Multilayer,
    varying: int,
    ranges: tuple[tuple[float, float], tuple[float, float]],
    lights: list[Illuminant],
    observer: str,
    polarization: str,
    quantities: list[str],
    tolerance: float,
    progress: Told,
) -> tuple[dict[tuple[str, str], Any], set[str]]:
    """The core's table of every light and quantity, and the media whose stated extension was used."""
    parts: dict[tuple[str, str], Any] = {}
    extended: set[str] = set()
    with watched(progress, "building", "color table") as tell:
        counter = None if tell is None else _Counter(tell)
        for light in lights:
            for name in quantities:
                table, used = _core.ColorTable.build(
                    [medium._core for medium in stack.media],
                    [one.coherent for one in stack.layers],
                    [float(one._thickness.values.flat[0]) for one in stack.layers],
                    varying,
                    list(ranges[0]),
                    list(ranges[1]),
                    polarization,
                    light._core,
                    observer,
                    name,
                    tolerance,
                    counter,
                )
                if counter is not None:
                    counter.next()
                parts[light.name, name] = table
                extended.update(used)
    return parts, extended


class _Counter:
    """Adds up the progress of several tables."""

    def __init__(self, tell: Tell) -> None:
        self.tell, self.before, self.latest = tell, 0, 0

    def __call__(self, done: int, total: int, stage: str) -> None:
        self.latest = done
        self.tell(self.before + done, self.before + total, stage)

    def next(self) -> None:
        self.before, self.latest = self.before + self.latest, 0


def _varying_layer(stack: Multilayer, layer: object) -> int:
    count = len(stack.layers)
    if count == 0:
        raise complaint(
            f"a colour table needs a stack with a layer, got {short(stack)}", "stack", "a stack with a layer", stack
        )
    many = [number for number, one in enumerate(stack.layers) if one._thickness.values.size > 1]
    if layer is None:
        if len(many) > 1 or (not many and count > 1):
            raise complaint(
                f"layer must say which of the {count} layers varies, 0 to {count - 1}"
                f" ({'several hold' if many else 'none holds'} an array of thicknesses)",
                "layer",
                f"a whole number from 0 to {count - 1}",
                None,
            )
        return many[0] if many else 0
    if isinstance(layer, bool) or not isinstance(layer, int | np.integer) or not 0 <= layer < count:
        raise refusal("layer", f"a whole number from 0 to {count - 1}", layer)
    others = [number for number in many if number != layer]
    if others:
        raise complaint(
            f"all layers but the varying one must have one thickness; layer {others[0]} has an array",
            "layer",
            "the one whose thickness is an array",
            layer,
        )
    return int(layer)


def _range_nm(stack: Multilayer, layer: int, thickness_nm: ArrayLike | None) -> tuple[float, float]:
    if thickness_nm is not None:
        return _extent(real_operand("thickness_nm", thickness_nm, low=0.0))
    values = stack.layers[layer]._thickness.values
    return (float(values.min()), float(values.max())) if values.size > 1 else _DEFAULT_NM


def _extent(operand: Operand) -> tuple[float, float]:
    return float(operand.values.min()), float(operand.values.max())


def _listed(argument: str, value: Any) -> list[Any]:
    listed = list(value) if isinstance(value, list | tuple) else [value]
    if not listed:
        raise complaint(f"{argument} must not be empty", argument, "not empty", value)
    return listed


def _check_distinct(argument: str, names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise complaint(f"{argument} must not name {name!r} twice", argument, "different names", names)


def _within(name: str, value: ArrayLike, allowed: tuple[float, float]) -> Floats:
    """``value`` as float64, all of it within the table's range."""
    low, high = allowed
    plain = type(value) is np.ndarray and value.dtype == np.float64 and value.dtype.isnative and value.size > 0
    values: Floats = value if plain else real_operand(name, value).full()  # type: ignore[assignment]
    if not (values.min() >= low and values.max() <= high):  # so written that a NaN fails
        index = np.unravel_index(int(np.argmin((values >= low) & (values <= high))), values.shape)
        raise refusal(name, f"within the table's {low:g} to {high:g}", float(values[index]), place(index))
    return values


def _light_name(illuminant: Light, names: tuple[str, ...]) -> str:
    name = illuminant if isinstance(illuminant, str) and illuminant in names else named_illuminant(illuminant).name
    if name not in names:
        raise refusal("illuminant", f"one of the table's, {', '.join(names)}", illuminant)
    return name


def _described(stack: Multilayer, varying: int, range_nm: tuple[float, float]) -> str:
    words = [stack.first.name]
    for number, layer in enumerate(stack.layers):
        nm = f"{range_nm[0]:g}..{range_nm[1]:g}" if number == varying else f"{layer._thickness.values.flat[0]:g}"
        words.append(f"{layer.medium.name} {nm}{'' if layer.coherent else ' incoherent'}")
    return " / ".join([*words, stack.last.name])


def _escaped(text: str) -> str:
    """ASCII, which is what every reader of EXR attributes takes."""
    return text.encode("unicode_escape").decode("ascii")


def _unescaped(text: str) -> str:
    try:
        return text.encode("ascii").decode("unicode_escape")
    except UnicodeError:
        raise ValueError(f"the attribute {text!r} is no text of a colour table") from None


def _of_bytes(content: bytes) -> ColorTable:
    return ColorTable._of_parts(_core.color_tables_read(content))
