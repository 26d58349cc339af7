"""From spectra to colour: illuminants, observers, tristimulus sums, colour spaces, differences, gamuts (``ir.color``).

Tristimulus values are relative: the perfect white reflector has Y = 1. Wavelengths are vacuum wavelengths in nm. A
colour is three values on the last axis; everything before it broadcasts. Results are float64.

Spaces: ``xyz xyy lab lch oklab``; ``srgb display-p3 rec2020`` (encoded); ``linear-srgb acescg ntsc1953`` (linear). RGB
matrices are derived from primaries and whites: D65 (0.3127, 0.3290), C (0.31006, 0.31616), ACES (0.32168, 0.33767).
Values out of range are kept, negative ones on the curve of their absolute value, until a gamut mapping is asked for.
"""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from iridesce import _core
from iridesce.arguments.operands import Floats, Operand, broadcast_shape, new_array, place, real_operand

if TYPE_CHECKING:
    from iridesce.stack import Stack

__all__ = [
    "Illuminant",
    "color_matching",
    "convert",
    "delta_e",
    "dias1991",
    "illuminant",
    "illuminants",
    "map_gamut",
    "purity_eps",
    "rgb_matrix",
    "spectrum_to_xyz",
    "stack_color",
]

SPACES = (
    *("xyz", "xyy", "lab", "lch", "oklab", "srgb", "display-p3", "rec2020"),
    *("linear-srgb", "acescg", "ntsc1953"),
)

# Chromaticities by which colour-space standards define these whites; the tables of the illuminants round differently.
_WHITES = {
    "D65": (0.3127, 0.3290),
    "C": (0.31006, 0.31616),
    "D50": (0.34567, 0.35850),
    "ACES": (0.32168, 0.33767),
}
_CSV_SUFFIXES = {".csv", ".txt", ".tsv"}
_CSV_LIMIT_BYTES = 16 * 2**20


def __dir__() -> list[str]:
    return __all__


# ---------------------------------------------------------------------------------------------------------------------
# Light


class Illuminant:
    """A light source: relative spectral power, a continuous part and true lines. Made by :func:`illuminant`.

    >>> import iridesce as ir
    >>> lamp = ir.color.illuminant("lines:589.158*2,589.756")
    >>> lamp
    Illuminant('lines:589.158*2,589.756')
    >>> lamp.lines
    ((589.158, 2.0), (589.756, 1.0))
    """

    __slots__ = ("_core", "_origin")

    _core: Any
    _origin: tuple[str, ...]

    def __init__(self, name: str | os.PathLike[str] | Illuminant) -> None:
        made = illuminant(name)
        self._core, self._origin = made._core, made._origin

    @classmethod
    def _wrap(cls, core: Any, *origin: str) -> Illuminant:
        made = object.__new__(cls)
        made._core, made._origin = core, origin
        return made

    @classmethod
    def from_csv(cls, text: str, label: str = "csv") -> Illuminant:
        """A light source from CSV text: lines ``wavelength_nm,power``, header and ``#`` comments optional.

        text      wavelengths in vacuum nm, ascending; power >= 0; linear between the rows, zero outside
        label     its name, also in errors
        Returns   Illuminant
        Raises    ValueError naming the line

        >>> Illuminant.from_csv("nm,power\\n400,1\\n700,4", "lamp").power(500.0)
        2.0
        """
        return cls._wrap(_core.Illuminant.from_csv(text, label), text, label)

    @property
    def name(self) -> str:
        """Its name: the CIE's spelling, the text of a formula, or the label of a CSV text."""
        return str(self._core.name)

    @property
    def lines(self) -> tuple[tuple[float, float], ...]:
        """The lines: (vacuum wavelength in nm, relative power); empty for a continuous source."""
        return tuple(self._core.lines)

    def power(self, wavelength_nm: ArrayLike) -> Any:
        """Relative power of the continuous part per nm; zero outside its table, linear within.

        wavelength_nm   vacuum wavelength, finite           (...,)
        Returns         float64                             (...,); a float for a scalar
        Raises          ValueError

        >>> import iridesce as ir
        >>> ir.color.illuminant("D65").power([380.0, 560.0, 790.0]).tolist()
        [49.9755, 100.0, 0.0]
        """
        nm = _reals("wavelength_nm", wavelength_nm)
        return _scalar(self._core.power(np.ascontiguousarray(nm.reshape(-1))).reshape(nm.shape))

    def white(self, observer: str = "cie1931") -> Floats:
        """XYZ of the light itself with Y = 1: plain sum over 360..830 nm at 1 nm, lines as lines.

        observer    "cie1931" | "cie1964"
        Returns     float64 (3,)
        Raises      ValueError

        >>> import iridesce as ir
        >>> ir.color.illuminant("D65").white().round(5).tolist()
        [0.95047, 1.0, 1.08883]
        """
        return np.array(self._core.white(_name("observer", observer)))

    @property
    def xy(self) -> tuple[float, float]:
        """Chromaticity for the CIE 1931 observer.

        >>> import iridesce as ir
        >>> tuple(round(v, 4) for v in ir.color.illuminant("A").xy)
        (0.4476, 0.4074)
        """
        white = self.white()
        x, y, _ = white / white.sum()
        return float(x), float(y)

    def __repr__(self) -> str:
        return f"Illuminant({self.name!r})"

    def _repr_html_(self) -> str:
        """What a notebook shows: the light's colour, name and chromaticity."""
        from iridesce import _notebook

        return _notebook.illuminant_html(self)

    def __eq__(self, other: object) -> bool:
        return self._origin == other._origin if isinstance(other, Illuminant) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._origin)

    def __reduce__(self) -> tuple[Any, tuple[str, ...]]:
        return (Illuminant.from_csv if len(self._origin) == 2 else illuminant), self._origin


def illuminant(name: str | os.PathLike[str] | Illuminant) -> Illuminant:
    """A light source by name.

    ================================  ==================================================================================
    ``A C D50 D55 D65 D75 E`` ...     CIE tables at 5 nm, linear between, zero outside: :func:`illuminants` lists them;
                                      ``F2`` is ``FL2``, letter case does not matter
    ``blackbody:2856``                Planck's radiator, temperature in K; 100 at 560 nm
    ``daylight:6504``                 CIE daylight of that correlated colour temperature, 4000..25000 K
    ``lines:589.158*2,589.756``       true lines: vacuum nm within 360..830, ``*`` relative power (1 unless given)
    ``laser:632.99``                  one line
    a path                            CSV ``wavelength_nm,power``: see :meth:`Illuminant.from_csv`
    ================================  ==================================================================================

    Returns    Illuminant
    Raises     ValueError: unknown name, number out of range, file missing or not such a table
    Source     CIE 15:2004 and CIE 015:2018, as listed beside the tables

    >>> import iridesce as ir
    >>> ir.color.illuminant("f2")
    Illuminant('FL2')
    >>> [round(ir.color.illuminant(name).power(450.0), 2) for name in ("A", "blackbody:2856")]
    [33.09, 33.1]
    """
    if isinstance(name, Illuminant):
        return name
    if not isinstance(name, (str, os.PathLike)):
        raise ValueError(f"illuminant must be a name, a path or an Illuminant, got {name!r}")
    text = os.fspath(name)
    if isinstance(name, str):
        try:
            core = _core.Illuminant.named(text)
            return Illuminant._wrap(core, core.name)
        except ValueError:
            if not _is_file_name(text):
                raise
    return Illuminant.from_csv(_read_csv(Path(text)), text)


def _is_file_name(text: str) -> bool:
    try:
        return Path(text).suffix.lower() in _CSV_SUFFIXES or Path(text).is_file()
    except (OSError, ValueError):  # a name no file system takes
        return False


def _read_csv(path: Path) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(_CSV_LIMIT_BYTES + 1)
    except (OSError, ValueError) as error:
        raise ValueError(f"illuminant file {str(path)!r} cannot be read: {error}") from None
    if len(data) > _CSV_LIMIT_BYTES:
        raise ValueError(f"illuminant file {str(path)!r} is larger than 16 MiB: not a table of a lamp")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"illuminant file {str(path)!r} is not text (UTF-8)") from None


def illuminants() -> list[str]:
    """Names of the tabulated illuminants.

    Returns    list of str
    Raises     nothing

    >>> import iridesce as ir
    >>> ir.color.illuminants()[:4]
    ['A', 'B', 'C', 'D50']
    """
    return list(_core.illuminant_names())


def color_matching(wavelength_nm: ArrayLike, observer: str = "cie1931") -> Floats:
    """Colour-matching functions of a CIE standard observer: the 1 nm table, linear between, zero outside 360..830 nm.

    wavelength_nm   vacuum wavelength, finite                (...,)
    observer        "cie1931" (2 degrees) | "cie1964" (10 degrees)
    Returns         xbar, ybar, zbar, float64                (..., 3)
    Raises          ValueError

    >>> import iridesce as ir
    >>> ir.color.color_matching(560.0).tolist()
    [0.5945, 0.995, 0.0039]
    """
    nm = _reals("wavelength_nm", wavelength_nm)
    rows = _core.color_matching(np.ascontiguousarray(nm.reshape(-1)), _name("observer", observer))
    return np.asarray(rows).reshape(*nm.shape, 3)


# ---------------------------------------------------------------------------------------------------------------------
# Sums, spaces, differences


def spectrum_to_xyz(
    wavelength_nm: ArrayLike,
    values: ArrayLike,
    illuminant: str | os.PathLike[str] | Illuminant = "D65",
    observer: str = "cie1931",
) -> Floats:
    """Tristimulus values of reflectances (or other power ratios) under a light.

    XYZ = k (sum step S value cmf + sum over lines P value cmf), with k such that value = 1 gives Y = 1: a plain sum
    over the wavelengths given, tables interpolated linearly there. At lines the value is interpolated linearly.

    wavelength_nm   a uniform ascending grid of vacuum wavelengths, > 0           (n,), n >= 2
    values          the spectrum on that grid                                     (..., n)
    illuminant      name, path or Illuminant
    observer        "cie1931" | "cie1964"
    Returns         float64                                                       (..., 3)
    Raises          ValueError: grid not uniform or not ascending, shapes, a line outside the grid, no light on the grid
    Source          CIE 15:2004

    >>> import numpy as np
    >>> import iridesce as ir
    >>> nm = np.arange(360.0, 831.0)
    >>> ir.color.spectrum_to_xyz(nm, np.full(471, 0.5), "E").round(4).tolist()
    [0.5, 0.5, 0.5002]
    """
    nm = _reals("wavelength_nm", wavelength_nm)
    if nm.ndim != 1:
        raise ValueError(f"wavelength_nm must have one axis, got shape {nm.shape}")
    spectra = _reals("values", values)
    if spectra.ndim < 1 or spectra.shape[-1] != nm.size:
        raise ValueError(f"the last axis of values must match wavelength_nm: shapes {spectra.shape} and {nm.shape}")
    light = _light(illuminant)
    flat = np.ascontiguousarray(spectra.reshape(-1, nm.size))
    rows = _core.spectrum_to_xyz(np.ascontiguousarray(nm), flat, light._core, _name("observer", observer))
    return np.asarray(rows).reshape(*spectra.shape[:-1], 3)


def convert(
    values: ArrayLike,
    from_space: str,
    to_space: str,
    white: str | ArrayLike | Illuminant = "D65",
    adaptation: str | None = None,
) -> Floats:
    """Colours of one space in another.

    XYZ, xyY, Lab and LCh are under the light ``white``; Lab and LCh are relative to it. RGB spaces and Oklab have
    whites of their own: without adaptation XYZ passes as it is; with ``"bradford"`` the one white becomes the other.
    Encoded spaces extend oddly: a negative value takes the curve of its absolute value. xyY of black has the
    chromaticity of ``white``.

    values       colours, finite                                             (..., 3)
    from_space   xyz xyy lab lch oklab srgb display-p3 rec2020 linear-srgb acescg ntsc1953
    to_space     the same
    white        "D65" "C" "D50" "ACES": the chromaticities of the standards; any other name of
                 :func:`illuminant`, or an Illuminant: its own white (CIE 1931, 1 nm); an array: (x, y) or (X, Y, Z)
    adaptation   None | "bradford" (linear Bradford)
    Returns      float64                                                     (..., 3)
    Raises       ValueError: unknown space, not finite, or a colour that has no XYZ (xyY with y = 0)
    Source       IEC 61966-2-1, SMPTE EG 432-1, ITU-R BT.2020, S-2014-004 (AP1), FCC 1953; CIE 15:2004 (Lab);
                 B. Ottosson, "A perceptual color space for image processing", 2020 (Oklab)

    >>> import iridesce as ir
    >>> ir.color.convert([0.5, 0.5, 0.5], "srgb", "lab").round(3).tolist()
    [53.389, 0.0, 0.0]
    """
    colors = _colors("values", values)
    rows = _core.convert_color(
        _rows(colors),
        _name("from_space", from_space),
        _name("to_space", to_space),
        _white(white),
        _optional_name("adaptation", adaptation),
    )
    return _checked(np.asarray(rows).reshape(colors.shape), colors, f"has no finite colour in {to_space!r}")


def rgb_matrix(space: str) -> Floats:
    """The matrix from XYZ to the linear RGB of a space, derived from its primaries and white.

    space      srgb display-p3 rec2020 linear-srgb acescg ntsc1953
    Returns    float64 (3, 3)
    Raises     ValueError for a space without primaries

    >>> import iridesce as ir
    >>> ir.color.rgb_matrix("linear-srgb")[0].round(6).tolist()
    [3.24097, -1.537383, -0.498611]
    """
    matrix = _core.rgb_matrix(_name("space", space))
    if matrix is None:
        raise ValueError(f"space {space!r} has no primaries; RGB spaces: {' '.join(SPACES[5:])}")
    return np.array(matrix)


def delta_e(lab_a: ArrayLike, lab_b: ArrayLike) -> Any:
    """Colour difference CIEDE2000 of CIELAB colours, with k_L = k_C = k_H = 1.

    lab_a, lab_b   L*, a*, b*, finite           (..., 3), broadcast
    Returns        float64                      broadcast shape without the last axis; a float for two colours
    Raises         ValueError
    Source         CIE 142-2001; Sharma, Wu & Dalal, Color Research & Application 30, 21 (2005)

    >>> import iridesce as ir
    >>> round(ir.color.delta_e([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485]), 4)
    2.0425
    """
    a, b = _colors("lab_a", lab_a), _colors("lab_b", lab_b)
    shape = broadcast_shape([Operand("lab_a", a, a.shape), Operand("lab_b", b, b.shape)])
    a, b = np.broadcast_to(a, shape), np.broadcast_to(b, shape)
    difference = np.asarray(_core.delta_e(_rows(a), _rows(b))).reshape(a.shape[:-1])
    return _scalar(_checked(difference, a, "of lab_a has no finite difference from that of lab_b"))


def map_gamut(values: ArrayLike, space: str = "srgb", gamut: str = "hue") -> tuple[Floats, float]:
    """Colours of an RGB space brought into [0, 1], and the share that was outside.

    ``"hue"`` keeps lightness and hue of Oklab and takes away just enough chroma; what is brighter than white becomes
    white. ``"clip"`` clips each linear channel. Colours inside stay as they are, bit for bit. A colour counts as
    outside when a linear channel is below -1e-6 or above 1.0005 (an eighth of an 8-bit step); smaller excursions are
    clipped.

    values     colours of ``space``, encoded where it is, finite        (..., 3)
    space      srgb display-p3 rec2020 linear-srgb acescg ntsc1953
    gamut      "hue" | "clip"
    Returns    (float64 (..., 3), share of the colours outside in [0, 1])
    Raises     ValueError

    >>> import iridesce as ir
    >>> mapped, share = ir.color.map_gamut([[0.2, 0.5, 0.3], [-0.1, 0.6, 0.2]], "linear-srgb")
    >>> mapped.round(4).tolist(), share
    ([[0.2, 0.5, 0.3], [0.0, 0.5543, 0.2374]], 0.5)
    """
    colors = _colors("values", values)
    rows, outside = _core.map_gamut(_rows(colors), _name("space", space), _name("gamut", gamut))
    return np.asarray(rows).reshape(colors.shape), 3 * outside / colors.size


# ---------------------------------------------------------------------------------------------------------------------
# Films


def stack_color(
    stack: Stack,
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
        grid = _reals("wavelength_nm", wavelength_nm)
        if grid.ndim != 1:
            raise ValueError(f"wavelength_nm must have one axis, got shape {grid.shape}")
        grid = np.ascontiguousarray(grid)
    colors: Floats = new_array("the colours", (*shape, 3))
    extended, fringe, thickest = _core.stack_color(
        [medium._core for medium in media],
        [bool(layer.coherent) for layer in layers],
        thickness,
        angles,
        _name("polarization", polarization),
        _light(illuminant)._core,
        _name("observer", observer),
        _name("space", space),
        _name("quantity", quantity),
        _name("model", model),
        grid,
        _optional_name("adaptation", adaptation),
        _optional_name("gamut", gamut),
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


def purity_eps(stack: Stack, wavelength_nm: ArrayLike = 555.0) -> Any:
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
    stack: Stack,
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
        raise ValueError(f"dias1991 needs exactly one coherent layer, got {len(layers)} layers")
    chosen: str | list[list[float]]
    if isinstance(matrix, str):
        chosen = matrix
    else:
        given = _reals("matrix", matrix)
        if given.shape != (3, 3):
            raise ValueError(f'matrix must be "printed", "full" or an array of shape (3, 3), got shape {given.shape}')
        chosen = given.tolist()
    shape, thickness, angles = _points(angle_deg, layers)
    nm = np.asarray(_core.dias1991_wavelengths())
    indices = np.stack([np.asarray(medium.index(nm), dtype=np.complex128) for medium in media], axis=-1)
    xyz, rgb = _core.dias1991(
        np.ascontiguousarray(indices), np.ascontiguousarray(thickness[:, 0]), angles, _name("table", table), chosen
    )
    return np.asarray(xyz).reshape(*shape, 3), np.asarray(rgb).reshape(*shape, 3)


# ---------------------------------------------------------------------------------------------------------------------
# Arguments


def _name(argument: str, value: object) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{argument} must be a string, got {value!r}")
    return value


def _optional_name(argument: str, value: object) -> str | None:
    return None if value is None else _name(argument, value)


def _light(light: str | os.PathLike[str] | Illuminant) -> Illuminant:
    return light if isinstance(light, Illuminant) else illuminant(light)


def _reals(argument: str, value: ArrayLike) -> Floats:
    return real_operand(argument, value).full()


def _scalar(array: Any) -> Any:
    return float(array) if array.ndim == 0 else array


def _colors(argument: str, values: ArrayLike) -> Floats:
    array = _reals(argument, values)
    if array.ndim < 1 or array.shape[-1] != 3:
        raise ValueError(f"{argument} must have a last axis of 3, got shape {array.shape}")
    return array


def _rows(colors: Floats) -> Floats:
    return np.ascontiguousarray(colors.reshape(-1, 3))


def _checked(result: Floats, given: Floats, problem: str) -> Floats:
    """``result``, or an error that names the first of the ``given`` colours that did not give a finite one."""
    bad = np.argwhere(~np.isfinite(result))
    if bad.size:
        row = tuple(bad[0][: given.ndim - 1])
        raise ValueError(f"the colour {given[row].tolist()}{place(row)} {problem}")
    return result


def _white(white: str | ArrayLike | Illuminant) -> list[float]:
    """XYZ with Y = 1."""
    if isinstance(white, str) and white.strip().upper() in _WHITES:
        x, y = _WHITES[white.strip().upper()]
        return [x / y, 1.0, (1.0 - x - y) / y]
    if isinstance(white, (str, os.PathLike, Illuminant)):
        return [float(v) for v in _light(white).white()]
    array = _reals("white", white)
    if array.shape == (2,) and array.min() > 0.0 and array.sum() < 1.0:
        x, y = (float(v) for v in array)
        return [x / y, 1.0, (1.0 - x - y) / y]
    if array.shape == (3,) and array.min() > 0.0:
        return [float(v / array[1]) for v in array]
    raise ValueError(f"white must be a name, an Illuminant, (x, y) or (X, Y, Z), all > 0, got {white!r}")


def _parts(stack: Stack) -> tuple[list[Any], list[Any]]:
    try:
        return [stack.first, *(layer.medium for layer in stack.layers), stack.last], list(stack.layers)
    except AttributeError:
        raise ValueError(f"stack must be an iridesce.Stack, got {stack!r}") from None


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
