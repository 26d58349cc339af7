"""Media: complex refractive index n + ik against vacuum wavelength, with source and range.

``k > 0`` absorbs. Tables are read by linear interpolation in wavelength.

>>> import iridesce as ir
>>> complex(ir.Medium("Si").index(550.0))
(4.077+0.027968j)
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal, SupportsComplex, SupportsFloat, TypeAlias

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce._notebook import facts_html
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.errors import ArgumentError
from iridesce.files.report import ReadReport, of_core
from iridesce.files.whole import read_whole

MediumLike: TypeAlias = "str | complex | Medium"
"""What may stand for a medium: a built-in name, a number, or a `Medium`."""

_FILE_SUFFIXES = {".csv", ".txt", ".tsv", ".yml", ".yaml"}

__all__ = ["Medium", "MediumLike", "MediumName", "media"]


class Medium:
    """A medium: its complex refractive index n + ik against vacuum wavelength.

    medium    a built-in name (`iridesce.media` lists them; "glass" is soda-lime, window glass), a real or complex index that
              holds at every wavelength (n >= 0; k > 0 absorbs, k < 0 amplifies), another `Medium`, or, with
              ``pip install "iridesce[materials]"``, a page of refractiveindex.info: ``"main/SiO2/Malitson"``
              (shelf/book/page) or ``"SiO2/Malitson"``; built-in names come first
    Raises    ValueError: an unknown name (the nearest known one is suggested), an index that is not finite, has n < 0
              or is 0; a page where the extra is not installed

    Media are immutable; equal ones compare equal and hash alike, and they can be pickled.

    >>> Medium("N-BK7").source[:24]
    'SCHOTT Zemax catalog 201'
    >>> Medium(1.33).index([400.0, 700.0])
    array([1.33+0.j, 1.33+0.j])
    >>> Medium("sopa")
    Traceback (most recent call last):
    ValueError: unknown medium "sopa"; did you mean "soap"?...
    """

    __slots__ = ("_core", "_origin", "_read")

    _core: _core.Medium
    # What it was made from, which also says when two are equal: (kind, content[, label]).
    _origin: tuple[Any, ...]
    _read: ReadReport | None

    def __init__(self, medium: MediumLike) -> None:
        if isinstance(medium, Medium):
            self._core, self._origin = medium._core, medium._origin
        elif isinstance(medium, str):
            self._core, name = _by_name(medium)
            self._origin = ("name", name)
        else:
            index = _index(medium)
            self._core, self._origin = _core.Medium.constant(index.real, index.imag), ("index", index)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Medium:
        """Read a medium from a file: a page of refractiveindex.info (YAML), or CSV.

        YAML: dispersion formulas 1 to 9, ``tabulated n``, ``tabulated k``, ``tabulated nk``; wavelengths in um, as
        downloaded. Recognised by a line ``DATA:`` or the suffix ``.yml`` or ``.yaml``.
        Text: rows ``nm, n`` or ``nm, n, k``; a header is optional; separators comma, semicolon, tab or spaces, decimal
        point or comma; ``#`` starts a comment. Names of columns count: ``um``, ``eV`` and their like, ``k`` before ``n``,
        ``e1`` and ``e2`` of a permittivity (n + ik = sqrt(e1 + i e2)); others are refused. The blocks ``wl,n`` and ``wl,k``
        of refractiveindex.info are in um. In all, rows may stand in any order. Between rows the index is linear in
        wavelength.
        The file is read whole, at once, and may be 16 MiB long.

        path      the file
        Returns   Medium, named by its path
        Raises    ValueError naming the file, the line and what is wrong: missing, a folder, unreadable, no ordinary file,
                  of another kind, not finite, n < 0, a wavelength <= 0, a CSV wavelength given twice with other values

        >>> import pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder, "glass.csv")
        ...     _ = file.write_text("nm,n\\n400,1.54\\n700,1.51")
        ...     glass = Medium.from_file(file)
        >>> round(float(glass.index(550.0).real), 6)
        1.525
        """
        return cls._from_bytes(*_read(path))

    @classmethod
    def _from_bytes(cls, label: str, content: bytes) -> Medium:
        medium = cls.__new__(cls)
        medium._core, text, plain = _core.Medium.from_bytes(content, label)
        medium._origin = ("text", text, label)
        medium._read = of_core(plain)
        return medium

    @classmethod
    def _from_text(cls, text: str, label: str) -> Medium:
        return cls._from_bytes(label, text.encode())

    @property
    def read(self) -> ReadReport | None:
        """How its file was understood: columns, units and why (`ReadReport`); None for a medium that is no file's."""
        return getattr(self, "_read", None)

    @classmethod
    def mixture(
        cls,
        first: MediumLike,
        second: MediumLike,
        fraction: float,
        rule: str = "bruggeman",
        *,
        weight_density: tuple[float, ...] | None = None,
    ) -> Medium:
        """Two media mixed more finely than the wavelength, by an effective-medium rule; e stands for the square of n + ik.

        "bruggeman"        (1 - f)(a - e)/(a + 2e) + f (b - e)/(b + 2e) = 0: grains of both on the same footing; for
                           rough faces (f = 1/2), porous and granular films
        "maxwell-garnett"  (e - a)/(e + 2a) = f (b - a)/(b + 2a): separate spheres of b in a host a
        "lorentz-lorenz"   (e - 1)/(e + 2) = (1 - f)(a - 1)/(a + 2) + f (b - 1)/(b + 2): refractions of molecules add;
                           for solutions and liquids

        first          medium a: a name, an index, a `Medium`
        second         medium b
        fraction       f, the share of b by volume, 0 to 1; by weight where ``weight_density`` is given
        rule           one of the three
        weight_density  None, or the densities of a and b in one unit, and that of the mixture where it is known: liquids
                       shrink when they mix, and v_i = w_i density / density_i is the volume that a part had before.
                       Without it volumes add. A third density is for "lorentz-lorenz" only
        Returns        Medium of the kind "mixture", known where both parts are
        Raises         ValueError naming the argument, the value and what is allowed; parts with gain (k < 0), or known
                       at no common wavelength
        Source         D. A. G. Bruggeman, Ann. Phys. 416, 636 (1935); J. C. Maxwell Garnett, Phil. Trans. R. Soc. A 203,
                       385 (1904); Born & Wolf, Principles of Optics, sec. 2.3.3 (Lorentz-Lorenz)

        >>> porous = Medium.mixture("SiO2", "air", 0.25)
        >>> round(float(porous.index(550.0).real), 4)
        1.3414
        >>> syrup = Medium.mixture("water", "glycerol", 0.5, "lorentz-lorenz", weight_density=(0.998, 1.261, 1.126))
        >>> round(float(syrup.index(589.3).real), 3)
        1.398
        """
        parts = cls(first), cls(second)
        share = _share("fraction", fraction)
        volumes = (1.0 - share, share)
        if not isinstance(rule, str):
            raise refusal("rule", "a string", Words(_shown(rule)))
        if weight_density is not None:
            volumes = _volumes(share, weight_density, rule)
        medium = cls.__new__(cls)
        name = f"{parts[0].name} + {parts[1].name} {volumes[1]:.6g} {rule}"
        medium._core = _core.Medium.mixture(parts[0]._core, parts[1]._core, *volumes, rule, name)
        densities = None if weight_density is None else tuple(float(value) for value in weight_density)
        medium._origin = ("mixture", parts[0], parts[1], share, rule, densities)
        return medium

    @classmethod
    def _from_mixture(cls, first: Medium, second: Medium, share: float, rule: str, densities: Any) -> Medium:
        return cls.mixture(first, second, share, rule, weight_density=densities)

    @property
    def name(self) -> str:
        """The name it was asked for by: a built-in name, a number such as ``1.33`` or ``2+3j``, or a path."""
        return self._core.name

    @property
    def source(self) -> str:
        """Where the numbers come from: authors, title, journal."""
        return self._core.source

    @property
    def kind(self) -> str:
        """``"constant"``, ``"formula"``, ``"table"``, ``"formula and table"`` or ``"mixture"``."""
        return self._core.kind

    @property
    def range_nm(self) -> tuple[float, float] | None:
        """First and last vacuum wavelength (nm) of its data; `None` for a constant, which holds everywhere."""
        return self._core.range_nm

    @property
    def note(self) -> str:
        """What a user should know about the data; may be empty."""
        return self._core.note

    @property
    def extension(self) -> str | None:
        """How colour sums and renders continue its data up to 360..830 nm; `None` where they do not.

        >>> Medium("rutile-o").extension
        '360-430 nm: the dispersion formula is continued'
        """
        return self._core.extension

    def index(
        self, wavelength_nm: npt.ArrayLike, extrapolate: Literal["hold"] | None = None
    ) -> np.complex128 | npt.NDArray[np.complex128]:
        """Complex refractive index n + ik.

        wavelength_nm  vacuum wavelength, > 0                                            (...,)
        extrapolate    outside the data: `None` refuses, ``"hold"`` takes n and k at the end of their data
        Returns        index, complex128                                                 shape of wavelength_nm
        Raises         ValueError naming the wavelength, its place in the array and the range of the data; also where a
                       dispersion formula has no real value

        >>> index = Medium("water").index(589.3)
        >>> round(float(index.real), 5)
        1.33335
        >>> Medium("Ag").index(2000.0)
        Traceback (most recent call last):
        ValueError: medium "Ag" has data for 188-1937 nm; 2000.0 nm was asked. Pass extrapolate="hold" to accept ...
        >>> complex(Medium("Ag").index(2000.0, extrapolate="hold"))
        (0.24+14.08j)
        """
        if extrapolate not in (None, "hold"):
            raise refusal("extrapolate", 'None or "hold"', extrapolate)
        wavelengths = _real_array(wavelength_nm, "wavelength_nm")
        flat = self._core.index(wavelengths.ravel(), extrapolate == "hold", wavelengths.shape)
        indices: npt.NDArray[np.complex128] = flat.reshape(wavelengths.shape)
        return np.complex128(indices[()]) if wavelengths.ndim == 0 else indices

    def __repr__(self) -> str:
        kind, content, *label = self._origin
        if kind == "mixture":
            second, share, rule, densities = label
            dense = "" if densities is None else f", weight_density={densities}"
            return f"Medium.mixture({_bare(content)}, {_bare(second)}, {share!r}, {rule!r}{dense})"
        if kind == "text":
            return f"Medium.from_file({label[0]!r})"
        if kind == "index" and content.imag == 0.0:
            content = content.real
        return f"Medium({content!r})"

    def _repr_html_(self) -> str:
        """What a notebook shows: source, range, and the index at three wavelengths."""
        span = self.range_nm
        facts = [
            ("data", "any wavelength" if span is None else f"{span[0]:g} to {span[1]:g} nm"),
            ("source", self.source),
            ("extended", self.extension or ""),
            ("note", self.note),
        ]
        facts += [(f"n at {nm:g} nm", index_in_words(self, nm)) for nm in (450.0, 550.0, 650.0)]
        return facts_html(self.name, facts)

    def __eq__(self, other: object) -> bool:
        return self._origin == other._origin if isinstance(other, Medium) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._origin)

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        kind, *content = self._origin
        makers: dict[str, Any] = {"text": Medium._from_text, "mixture": Medium._from_mixture}
        return makers.get(kind, Medium), tuple(content)


def as_medium(value: Any) -> Medium:
    """A medium as it is; a name or an index as a medium."""
    return value if isinstance(value, Medium) else Medium(value)


def index_in_words(medium: Medium, wavelength_nm: float) -> str:
    """The index to four digits, for tables; nothing where the medium has no data."""
    try:
        index = complex(medium.index(wavelength_nm))
    except ValueError:  # no data there
        return ""
    return f"{index.real:.4g}" if index.imag == 0.0 else f"{index.real:.4g} {index.imag:+.3g}i"


class MediumName(str):
    """The name of a built-in medium, which knows its `source`, `range_nm`, `kind`, `note` and `extension`.

    >>> silver = next(name for name in media() if name == "Ag")
    >>> silver.range_nm, silver.kind
    ((187.9, 1937.0), 'table')
    """

    __slots__ = ()

    @property
    def source(self) -> str:
        """Where the numbers come from: authors, title, journal."""
        return _named(self).source

    @property
    def kind(self) -> str:
        """``"constant"``, ``"formula"``, ``"table"``, ``"formula and table"`` or ``"mixture"``."""
        return _named(self).kind

    @property
    def range_nm(self) -> tuple[float, float] | None:
        """First and last vacuum wavelength (nm) of its data; `None` for a constant, which holds everywhere."""
        return _named(self).range_nm

    @property
    def note(self) -> str:
        """What a user should know about the data; may be empty."""
        return _named(self).note

    @property
    def extension(self) -> str | None:
        """How colour sums and renders continue its data up to 360..830 nm; `None` where they do not."""
        return _named(self).extension


def media() -> list[MediumName]:
    """The names of the built-in media; each is a `str` that knows its source, range and kind.

    Returns   list of `MediumName`
    Raises    nothing

    >>> media()[:5]
    ['vacuum', 'air', 'air-ciddor', 'water', 'soap']
    >>> [name for name in media() if name.kind == "table"][:3]
    ['TiO2', 'TiO2-siefke', 'Si']
    """
    return [MediumName(name) for name in _core.media_names()]


def _by_name(name: str) -> tuple[_core.Medium, str]:
    """The medium of a built-in name or else of a page of refractiveindex.info, and that name in full."""
    try:
        core = _named(name)
        return core, core.name
    except ValueError as error:
        from iridesce.optics import database

        if not database.is_page_name(name):
            raise
        try:
            page = database.find(name)
        except database.MissingDatabase as missing:
            raise complaint(
                f"{error}; {missing}", "medium", "a built-in name, or one of the extra materials", name
            ) from None
        except ValueError as unknown:
            if Path(name).suffix.lower() in _FILE_SUFFIXES:
                raise error from None
            raise unknown from None
    return _core.Medium.from_bytes(_read(page.file)[1], page.name)[0], page.name


def _named(name: str) -> _core.Medium:
    try:
        return _core.Medium.named(name)
    except UnicodeEncodeError:  # a lone surrogate, which no text outside Python can hold
        raise complaint(f"unknown medium {name!r}", "medium", "a built-in name", name) from None
    except ValueError as error:
        if Path(name).suffix or os.sep in name:
            raise complaint(
                f"{error}. A file is read by Medium.from_file(path)", "medium", "a built-in name", name
            ) from None
        raise


def _index(value: Any) -> complex:
    """A number as a complex index; anything else is refused in words."""
    allowed = "a built-in name, a real or complex number or a Medium"
    wanted = f"a medium is {allowed}"
    if isinstance(value, os.PathLike):
        raise complaint(
            f"{wanted}, got the path {os.fspath(value)!r}; a file is read by Medium.from_file(path)",
            "medium",
            allowed,
            value,
        )
    if isinstance(value, bool | np.bool_ | bytes) or not isinstance(value, SupportsComplex | SupportsFloat):
        raise complaint(f"{wanted}, got {_shown(value)}", "medium", allowed, value)
    if getattr(value, "ndim", 0) != 0:
        shape = f"an array of shape {getattr(value, 'shape', None)}"
        raise complaint(f"{wanted}, got {shape}", "medium", allowed, Words(shape))
    try:
        return complex(value)
    except (TypeError, ValueError, OverflowError):
        raise complaint(f"{wanted}, got {_shown(value)}", "medium", allowed, value) from None


def _bare(medium: Medium) -> str:
    """A medium as `Medium.mixture` takes it: without the ``Medium( )`` around a name or a number."""
    text = repr(medium)
    return text.removeprefix("Medium(").removesuffix(")") if text.startswith("Medium(") else text


def _share(name: str, value: object) -> float:
    """A number from 0 to 1."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise refusal(name, "a number from 0 to 1", Words(_shown(value))) from None
    if isinstance(value, bool | str) or not 0.0 <= number <= 1.0:
        raise refusal(name, "a number from 0 to 1", Words(_shown(value)))
    return number


def _volumes(share: float, densities: object, rule: str) -> tuple[float, float]:
    """Volumes before mixing per volume of the mixture, from a share by weight."""
    wanted = "two or three densities > 0: of the first, of the second, of the mixture"
    try:
        known = [float(value) for value in densities]  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        raise refusal("weight_density", wanted, Words(_shown(densities))) from None
    if len(known) not in (2, 3) or not all(0.0 < value < float("inf") for value in known):
        raise refusal("weight_density", wanted, Words(_shown(densities)))
    if len(known) == 3 and rule != "lorentz-lorenz":
        raise complaint(
            f'a density of the mixture is for rule="lorentz-lorenz" only, got {_shown(densities)} for {rule!r}',
            "weight_density",
            'two densities unless rule is "lorentz-lorenz"',
            densities,
        )
    volumes = (1.0 - share) / known[0], share / known[1]
    density = known[2] if len(known) == 3 else 1.0 / sum(volumes)
    first, second = (volume * density for volume in volumes)
    return (first, second) if len(known) == 3 else (1.0 - second, second)


def _shown(value: object) -> str:
    text = repr(value)
    return f"{type(value).__name__} {text if len(text) <= 60 else text[:60] + '...'}"


def _real_array(values: npt.ArrayLike, name: str) -> npt.NDArray[np.float64]:
    """`values` as contiguous float64; not copied where they are that already."""
    try:
        if isinstance(values, np.ma.MaskedArray):
            raise refusal(name, "an array without a mask", Words("a masked array"))
        array = np.asarray(values)
    except ArgumentError:
        raise
    except ValueError:
        raise refusal(name, "numbers in an array or a scalar", Words("rows of different lengths")) from None
    if array.dtype.kind not in "fiu" and array.size != 0:
        raise refusal(name, "real numbers", Words(_shown(values)))
    # `order="C"` keeps a 0-d array 0-d, which `ascontiguousarray` would not.
    return np.asarray(array, dtype=np.float64, order="C")


def _read(path: str | os.PathLike[str]) -> tuple[str, bytes]:
    """Name and bytes of a file; every way in which it cannot be read is a `ValueError` naming it."""
    if not isinstance(path, str | os.PathLike):
        raise refusal("path", "a path", Words(_shown(path)))
    label = os.fspath(path)
    if not isinstance(label, str):
        label = os.fsdecode(label)
    return label, read_whole(label, _core.MEDIUM_TEXT_BYTES, "no table of an index needs")
