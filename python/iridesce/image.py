"""Pictures: linear XYZ inside, display encoding only on the way out."""

from __future__ import annotations

import json
import math
import numbers
import operator
import os
from typing import Any

import numpy as np
import numpy.typing as npt

from iridesce import _core
from iridesce._picture_files import (
    HANDEDNESS_FACTS,
    LAYOUT_FACTS,
    file_planes,
    metadata_of_file,
    planes_of_file,
    seen_spectra,
    xyz_of_file,
)
from iridesce.arguments.refusals import Words, complaint, refusal, short
from iridesce.arguments.scalars import MOST_STOPS, file_name, one_of
from iridesce.errors import ArgumentError
from iridesce.files.whole import read_whole

__all__ = ["Image", "check_output"]

_Floats = npt.NDArray[np.float32]
_Planes = dict[str, npt.NDArray[Any]]

_EXTENSIONS = (".png", ".exr")
_SPACES = ("srgb", "display-p3", "rec2020")
_GAMUTS = ("hue", "clip")
_STOPS = f'a number of stops from -{MOST_STOPS:g} to {MOST_STOPS:g} or "auto"'
# Largest file that is read.
_MOST_BYTES = 16 << 30


class Image:
    """A picture: relative XYZ for every pixel, what was seen there, and how it was made.

    xyz            relative tristimulus values, a white of radiance 1 has Y = 1; row 0 on top    (height, width, 3)
    depth          distance along the ray, scene units, inf where nothing was met                (height, width)
    thickness_nm   of the first film, behind clear faces too, or of a coating's first layer; else NaN  (height, width)
    normal         unit normal of the first surface, world axes, zero where nothing was met      (height, width, 3)
    metadata       what is known of how the picture was made; see the property
    Raises         ValueError where shapes differ or ``xyz`` is not finite, naming the place

    :func:`iridesce.render` makes these; your own arrays make one too (the mean of two renders, a chart):

    >>> import numpy as np, iridesce as ir
    >>> grey = ir.Image(np.full((2, 3, 3), [0.95046, 1.0, 1.08906]) * 0.18)     # 18 % of D65
    >>> grey.shape, grey.width, grey.height
    ((2, 3, 3), 3, 2)
    >>> [round(float(v), 3) for v in grey.rgb()[0, 0]]
    [0.461, 0.461, 0.461]

    Arrays are copied and read-only: a picture does not change after it is made.
    """

    def __init__(
        self,
        xyz: npt.ArrayLike,
        *,
        depth: npt.ArrayLike | None = None,
        thickness_nm: npt.ArrayLike | None = None,
        normal: npt.ArrayLike | None = None,
        metadata: dict[str, Any] | None = None,
    ) -> None:
        xyz_ = _plane("xyz", xyz, None, 3)
        size = (xyz_.shape[0], xyz_.shape[1])
        bad = ~np.isfinite(xyz_)
        if bad.any():
            place = tuple(int(i) for i in np.argwhere(bad)[0])
            raise refusal("xyz", "finite", float(xyz_[place]), f"at index {place}")
        planes = {
            "depth": np.full(size, np.inf, np.float32) if depth is None else _plane("depth", depth, size, None),
            "thickness_nm": np.full(size, np.nan, np.float32)
            if thickness_nm is None
            else _plane("thickness_nm", thickness_nm, size, None),
            "normal": np.zeros((*size, 3), np.float32) if normal is None else _plane("normal", normal, size, 3),
        }
        self._set(xyz_, planes, {}, _copied(dict(metadata or {})))

    @classmethod
    def _of_render(
        cls,
        xyz: _Floats,
        planes: _Planes,
        spectral: _Planes,
        facts: dict[str, Any],
        surfaces: tuple[int, int, int, int] | None = None,
    ) -> Image:
        """Takes over the arrays of a finished render without a copy.

        surfaces   (x, y, width, height) of the tiles outside which no ray from the camera met anything
        """
        image = cls.__new__(cls)
        image._set(xyz, planes, spectral, facts)
        image._surfaces = surfaces
        return image

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Image:
        """Reads a picture from an OpenEXR file: of one that :meth:`save` wrote every plane and what is known of how it was made.

        path       ``.exr``
        Returns    an Image; of files of other programs the colours (R, G, B by the primaries they state, else Rec.709; or Y),
                   and those planes that are called as ours
        Raises     ValueError for another ending, and for what cannot be read as such a picture, naming the file

        ``metadata`` has no ``seconds`` and ``threads`` then: files do not hold them. Half floats come back as float32.

        >>> import pathlib, tempfile, iridesce as ir
        >>> image = ir.render("soap-bubble", samples=1, size=(8, 6))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder, "bubble.exr")
        ...     image.save(file)
        ...     again = ir.Image.load(file)
        >>> bool((again.xyz == image.xyz).all()), again.scene == image.scene, again.metadata["samples"]
        (True, True, 1)
        """
        name = file_name(path, (".exr",))
        content = read_whole(name, _MOST_BYTES, "no picture is")
        try:
            channels, facts, corners = _core.load_exr(content)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
        xyz = xyz_of_file(channels, corners, name)
        planes, spectral = planes_of_file(channels, (xyz.shape[0], xyz.shape[1]))
        first = [planes.pop(key, None) for key in ("depth", "thickness_nm", "normal")]
        whole = cls(xyz, depth=first[0], thickness_nm=first[1], normal=first[2])
        metadata = metadata_of_file(facts, name)
        if "spectral_stokes" in spectral:
            spectral["spectra"] = seen_spectra(spectral["spectral_stokes"], metadata.get("scene"))
        whole._set(whole._xyz, {**whole._planes, **planes}, spectral, metadata)
        return whole

    def _set(self, xyz: _Floats, planes: _Planes, spectral: _Planes, facts: dict[str, Any]) -> None:
        for array in (xyz, *planes.values(), *spectral.values()):
            array.flags.writeable = False
        self._xyz = xyz
        self._planes = planes
        self._spectral = spectral
        self._facts = facts
        self._developed: dict[str, Any] | None = None
        self._surfaces: tuple[int, int, int, int] | None = None

    def __repr__(self) -> str:
        made = f", {self._facts['samples']} samples" if "samples" in self._facts else ""
        return f"<iridesce.Image {self.width} x {self.height}{made}>"

    @property
    def xyz(self) -> _Floats:
        """Relative XYZ, float32, (height, width, 3), row 0 on top; read-only. Nothing is denoised or clamped."""
        return self._xyz

    @property
    def channels(self) -> _Planes:
        """Planes beside the colours, read-only: float32, or int32 where they count.

        Of what the middle of each pixel meets first:

        ``"depth"``               distance along the ray, scene units, inf where there is no surface      (height, width)
        ``"thickness_nm"``        thickness of the first film, behind clear faces too, or of a coating's first layer; NaN off
                                  them                                                                    (height, width)
        ``"path_difference_nm"``  optical path difference 2 n t cos(theta) of the two faces of that film or layer at 560 nm,
                                  theta within it: the number that names a colour's order; NaN off films  (height, width)
        ``"normal"``              unit normal, world axes, zero where there is no surface                 (height, width, 3)
        ``"object"``              place of the object in the scene's list, -1 for none; int32             (height, width)

        Of the samples, in renders:

        ``"variance"``            variance of the pixel's mean Y: what another seed would give is off by about its root, in
                                  smooth pictures by two thirds of it. That samples are spread evenly is counted in. NaN
                                  after a single sample                                                   (height, width)
        ``"samples"``             camera rays of the pixel, 0 outside the tiles of a shard; int32         (height, width)
        ``"alpha"``               of scenes without backdrop: 1 - the mean transmittance along the unbent straight way to the
                                  environment; colours are premultiplied                                  (height, width)
        """
        return dict(self._planes)

    @property
    def stokes(self) -> _Floats | None:
        """Stokes vectors S0..S3 of X, Y and Z, float32, (height, width, 3, 4), before any polariser; None if not asked for.

        S1 > 0 is light that swings along the camera's upright, S2 > 0 at 45 degrees from it, clockwise in the picture; the
        sign of S3 is that of V in docs/reference/theory.md, section 5.
        """
        return self._spectral.get("stokes")

    @property
    def spectra(self) -> _Floats | None:
        """Spectral radiance at :attr:`spectral_nm`, float32, (height, width, wavelengths); None if not asked for.

        On the scale where grey 1.0 is the relative D65 spectrum with 1 at 560 nm. Where lines shine it is the mean over the
        band halfway to the neighbours (their power over its width), else the value at the wavelength.
        """
        return self._spectral.get("spectra")

    @property
    def spectral_nm(self) -> npt.NDArray[np.float64] | None:
        """Vacuum wavelengths of :attr:`spectra`, nm, (wavelengths,); None if not asked for."""
        return self._spectral.get("spectral_nm")

    @property
    def spectral_stokes(self) -> _Floats | None:
        """Stokes vectors S0..S3 at each wavelength, float32, (height, width, wavelengths, 4); None unless both spectra and
        Stokes vectors were asked for. They are those of the light before any polariser: without one, S0 is :attr:`spectra`."""
        return self._spectral.get("spectral_stokes")

    @property
    def scene(self) -> dict[str, Any] | None:
        """The scene that was rendered, as the dict of ``metadata["scene"]``: ``ir.render(image.scene)`` repeats it (a new
        dict at each call, all the way down). None of pictures that know of none."""
        scene = self._facts.get("scene")
        return _copied(scene) if isinstance(scene, dict) else None

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, 3), the shape of :attr:`xyz`."""
        return (self._xyz.shape[0], self._xyz.shape[1], 3)

    @property
    def width(self) -> int:
        """Columns."""
        return int(self._xyz.shape[1])

    @property
    def height(self) -> int:
        """Rows."""
        return int(self._xyz.shape[0])

    @property
    def metadata(self) -> dict[str, Any]:
        """How the picture was made, and how it was last developed (a new dict at each call, all the way down).

        Of a render: ``samples``, ``seed``, ``seconds`` (wall time of the rendering), ``threads``, ``backend``, ``simd``
        (the instruction set: the same bytes are promised for the same one), ``version``, and ``scene``, the whole scene
        as a dict with these samples, seed and size, so that ``ir.render(image.metadata["scene"])`` repeats it (file names
        in it are as the scene had them, relative to its folder); ``crop``, ``shard`` and ``merged`` of parts of a picture and
        of what was put together.

        Of the latest ``rgb()`` or ``save()`` of a PNG, or before the first of them what ``save("x.png")`` would do:
        ``exposure`` (stops), ``space``, ``gamut``, ``out_of_gamut`` (share of pixels, 0 to 1, that the space could not hold
        and that were mapped into it) and ``overexposed`` (the part of them that was too bright).
        """
        if self._developed is None:
            self._develop("srgb", self._stops("auto"), "hue")
        told: dict[str, Any] = _copied({**self._facts, **(self._developed or {})})
        return told

    def rgb(self, space: str = "srgb", exposure: float | str = 0.0, gamut: str = "hue") -> _Floats:
        """The picture for a display: encoded RGB in [0, 1], float32, (height, width, 3).

        space      ``"srgb"``, ``"display-p3"`` or ``"rec2020"``
        exposure   stops, -64 to 64: XYZ are multiplied by 2**exposure first; or ``"auto"``, see below
        gamut      what happens to colours outside the space; those inside are exact either way.
                   ``"hue"``: Oklab hue is kept. A colour with negative components loses chroma at the same lightness until
                   it fits. A colour whose largest component is m > 1 is scaled by 1/m and then goes the share 1 - 1/m of
                   the straight line to white: highlights whiten as on film.
                   ``"clip"``: each component is clipped to [0, 1]; hues shift.
        Returns    a new array, float32
        Raises     ValueError naming the argument, the value and what is allowed

        ``"auto"`` is log2(0.9 / p) rounded to a hundredth, p the 95th percentile of the largest linear Rec.709 component (of
        a grey: of Y) over the pixels that show a surface, or over all pixels where surfaces fill less than a hundredth of
        the picture: the films are shown whole, lamps behind them may be white. 0 for a black picture.

        >>> import iridesce as ir
        >>> picture = ir.Image([[[0.4124, 0.2126, 0.0193]]])        # the red of sRGB
        >>> [round(float(v), 3) for v in picture.rgb(exposure=-1.0)[0, 0]]
        [0.735, 0.0, 0.0]
        """
        one_of("space", space, _SPACES)
        one_of("gamut", gamut, _GAMUTS)
        return self._develop(space, self._stops(exposure), gamut)

    def save(
        self,
        path: str | os.PathLike[str],
        exposure: float | str = "auto",
        *,
        space: str = "srgb",
        gamut: str = "hue",
        bits: int = 8,
        half: bool = False,
    ) -> None:
        """Writes the picture: a whole file or none. What was at ``path`` stays until the new file is complete.

        path       ``.png``: developed as :meth:`rgb` does, tagged with its colour space, the render's facts as text. With a
                   plane ``alpha`` the file has it too, and colours are divided by it, as the format asks.
                   ``.exr``: everything in float32, linear, no exposure and no mapping: ``R G B`` (linear Rec.709),
                   ``XYZ.X XYZ.Y XYZ.Z``, the other planes under their own names (``depth.Z``, ``normal.X normal.Y normal.Z``,
                   ``A`` for alpha, ``stokes.X.0`` .. ``stokes.Z.3``, ``S0.550,00nm`` and so on), and the facts as
                   attributes; ``exposure``, ``space``, ``gamut`` and ``bits`` have no bearing on it
        exposure   as in :meth:`rgb`
        space      as in :meth:`rgb`
        gamut      as in :meth:`rgb`
        bits       of a PNG channel, 8 or 16. 8 bits are dithered by a fixed pattern below one step, so that slow gradients
                   show no bands
        half       colours, spectra, normals and alpha of an EXR in half floats: three digits, at most 65504 (what is brighter
                   is stored as that). Lengths, variances and counts stay as they are
        Raises     ValueError for a wrong argument or an extension other than these;
                   OSError (FileNotFoundError, PermissionError, ...) naming the file where it cannot be written

        Files hold no times or thread counts: the same render gives the same bytes.

        >>> import pathlib, tempfile, iridesce as ir
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder, "red.png")
        ...     ir.Image([[[0.4124, 0.2126, 0.0193]]]).save(file)
        ...     file.read_bytes()[1:4]
        b'PNG'
        """
        name = file_name(path, _EXTENSIONS)
        one_of("space", space, _SPACES)
        one_of("gamut", gamut, _GAMUTS)
        if isinstance(bits, bool) or bits not in (8, 16):
            raise refusal("bits", "8 or 16", bits)
        stops = self._stops(exposure)
        if name.lower().endswith(".exr"):
            facts = self._file_facts()
            if "spectra" in self._spectral:
                facts += list(LAYOUT_FACTS.items())
            if "stokes" in self._spectral or "spectral_stokes" in self._spectral:
                facts += list(HANDEDNESS_FACTS.items())
            _core.save_exr(name, self._xyz, bool(half), file_planes(self._planes, self._spectral, bool(half)), facts)
            return
        self._save_png(name, stops, space, gamut, int(bits), is_quick=False)

    def _save_png(self, name: str, stops: float, space: str, gamut: str, bits: int, is_quick: bool) -> None:
        """``is_quick``: a ninth of the time to make the file, which is larger by a fifth; the same pixels."""
        _core.check_output(name)
        rgb = self._develop(space, stops, gamut, self._undivided())
        if "alpha" in self._planes:
            rgb = np.concatenate([rgb, np.clip(self._planes["alpha"], 0.0, 1.0)[..., None]], axis=-1)
        developed = self._developed or {}
        _core.save_png(name, rgb, bits, space, self._file_facts() + list(developed.items()), is_quick)

    def _repr_png_(self) -> bytes:
        """What a notebook shows: sRGB, automatic exposure."""
        before = self._developed
        try:
            return _core.png_bytes(self._develop("srgb", self._stops("auto"), "hue"), "srgb")
        finally:
            self._developed = before  # showing a picture is no statement about it

    def exposure_stops(self, exposure: float | str = "auto") -> float:
        """The stops that an exposure means for this picture; give them to others that are to match it.

        exposure  "auto", or stops from -64 to 64
        Returns   stops: linear values are multiplied by 2**stops
        Raises    ValueError for anything else

        >>> import iridesce as ir
        >>> image = ir.render("soap-bubble", samples=1, size=(8, 8))
        >>> image.exposure_stops("auto") == image.exposure_stops(), image.exposure_stops(1.5)
        (True, 1.5)
        """
        return self._stops(exposure)

    def _stops(self, exposure: float | str) -> float:
        if isinstance(exposure, str):
            if exposure != "auto":
                raise refusal("exposure", _STOPS, exposure)
            return float(_core.auto_exposure(self._xyz, self._planes["depth"]))
        number = isinstance(exposure, numbers.Real) and not isinstance(exposure, (bool, np.bool_))
        stops = float(exposure) if number else math.nan
        if not -MOST_STOPS <= stops <= MOST_STOPS:
            raise refusal("exposure", _STOPS, exposure)
        return stops

    def _undivided(self) -> _Floats:
        """The colours of what covers the pixels, whatever shines through."""
        alpha = self._planes.get("alpha")
        if alpha is None:
            return self._xyz
        # What hardly covers anything has no colour of its own to speak of: light that it mirrors would be any number.
        return np.divide(self._xyz, alpha[..., None], out=np.zeros_like(self._xyz), where=alpha[..., None] > 1e-6)

    def _develop(self, space: str, stops: float, gamut: str, xyz: _Floats | None = None) -> _Floats:
        xyz = self._xyz if xyz is None else xyz
        rgb, out_of_gamut, overexposed = _core.develop_image(xyz, space, stops, gamut)
        self._developed = {
            "exposure": stops,
            "space": space,
            "gamut": gamut,
            "out_of_gamut": out_of_gamut,
            "overexposed": overexposed,
        }
        return rgb

    def _file_facts(self) -> list[tuple[str, str | int | float]]:
        """What a file says of its picture: enough to repeat it, nothing that varies from run to run."""
        facts: list[tuple[str, str | int | float]] = [("Software", f"iridesce {_core.__version__}")]
        for key in ("backend", "simd", "samples", "seed"):
            if key in self._facts:
                value = self._facts[key]
                # A seed has 64 bits, more than the integers of an EXR attribute.
                facts.append((key, str(value) if key == "seed" else value))
        if "crop" in self._facts:
            facts.append(("crop", " ".join(str(number) for number in self._facts["crop"])))
        if "shard" in self._facts:
            facts.append(("shard", self._facts["shard"]))
        if "merged" in self._facts:
            facts.append(("merged", json.dumps(self._facts["merged"])))
        if "scene" in self._facts:
            # ASCII: EXR attributes hold nothing else.
            facts.append(("scene", json.dumps(self._facts["scene"], allow_nan=False, default=_plain)))
        return facts


def check_output(path: str | os.PathLike[str]) -> None:
    """Raises what ``Image.save(path)`` would raise about the path itself; writes nothing.

    Asked before a long render: an extension other than .png and .exr is a ValueError, a folder that is missing or takes
    no new file an OSError.
    """
    _core.check_output(file_name(path, _EXTENSIONS))


def _plane(name: str, values: npt.ArrayLike, size: tuple[int, int] | None, depth: int | None) -> _Floats:
    """A new contiguous float32 array of the right shape."""
    last = () if depth is None else (depth,)
    if isinstance(values, np.ma.MaskedArray):
        raise refusal(name, "an array without a mask", Words("a masked array"))
    try:
        given = np.asarray(values)
        if given.dtype.kind not in "biuf" and not (given.dtype.kind == "O" and all(map(_is_real, given.flat))):
            kind = Words(f"an array of type {given.dtype}")
            raise refusal(name, "an array of real numbers", kind)
        with np.errstate(over="ignore"):  # what is too large for float32 is told below
            array = np.array(given, dtype=np.float32, order="C", copy=True)
    except ArgumentError:
        raise
    except (TypeError, ValueError, RuntimeError, OverflowError) as error:
        # (numpy has its own words for what has more than 32 or 64 dimensions.)
        words = f"{name} must be an array of numbers, got {short(values)}: {error}"
        raise complaint(words, name, "an array of numbers", values) from None
    if size is None:
        good = array.ndim == 3 and array.shape[2] == depth and array.size > 0
        if not good:
            allowed = "of shape (height, width, 3), with at least one pixel"
            raise refusal(name, allowed, Words(f"shape {array.shape}"))
    elif array.shape != (*size, *last):
        raise refusal(name, f"of shape {(*size, *last)} like xyz", Words(f"shape {array.shape}"))
    return array


def _copied(value: Any) -> Any:
    """The same plain value with dicts, lists, tuples and arrays of its own."""
    if isinstance(value, dict):
        return {key: _copied(part) for key, part in value.items()}
    if type(value) in (list, tuple):
        return type(value)(_copied(part) for part in value)
    return value.copy() if isinstance(value, np.ndarray) else value


def _is_real(value: object) -> bool:
    return isinstance(value, numbers.Real)


def _plain(value: object) -> object:
    """Numpy scalars and arrays, for JSON."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    try:
        return operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return str(value)
