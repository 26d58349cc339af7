"""The grid of thicknesses, its files, and the checks that it shares with the models."""

from __future__ import annotations

import io
import operator
import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from iridesce import _core
from iridesce.arguments.operands import place, refuse_masks
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import file_name, number
from iridesce.errors import ArgumentError
from iridesce.files.report import ReadReport, of_core

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TIFF = (".tif", ".tiff")
_ENDINGS = (*_TIFF, ".exr", ".npy")
_MAX_FLOAT32 = float(np.finfo(np.float32).max)


class ThicknessMap:
    """A grid of thicknesses; row 0 on top, values at the middles of the cells. Immutable.

    thickness_nm  nm, finite, >= 0                                                     (height, width)
    Raises        ValueError naming the value and its place: another shape, no cells, not finite, negative

    It stands for its array wherever numpy or `iridesce.Layer` wants one.

    >>> grid = ThicknessMap([[100.0, 200.0], [300.0, 400.0]])
    >>> grid, grid.width, grid.height
    (<iridesce.thickness.ThicknessMap 2 x 2, 100 to 400 nm>, 2, 2)
    """

    __slots__ = ("_core", "_read", "_thickness_nm")

    def __init__(self, thickness_nm: ArrayLike) -> None:
        values = array("thickness_nm", thickness_nm)
        if values.ndim != 2 or 0 in values.shape:
            raise refusal("thickness_nm", "the shape (height, width), both >= 1", Words(values.shape), must="have")
        self._core = _core.ThicknessMap(np.ascontiguousarray(values))
        self._read: ReadReport | None = None
        self._thickness_nm: NDArray[np.float64] = values.copy()
        self._thickness_nm.flags.writeable = False

    @property
    def thickness_nm(self) -> NDArray[np.float64]:
        """The values, nm, float64, read-only, (height, width)."""
        return self._thickness_nm

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self._thickness_nm.shape[1])

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self._thickness_nm.shape[0])

    def sample(self, u: ArrayLike, v: ArrayLike) -> NDArray[np.float64] | float:
        """Thickness between the cells: bilinear between their middles, the outermost values beyond them.

        u        0 at the left edge, 1 at the right; finite                                (...,)
        v        0 at the bottom edge, 1 on top; finite                                    (...,) broadcasts
        Returns  nm, float64; a float for scalars                                          broadcast shape
        Raises   ValueError where a coordinate is not finite, or shapes do not broadcast

        >>> ThicknessMap([[100.0, 200.0], [300.0, 400.0]]).sample(0.5, [0.25, 0.5, 1.0])
        array([350., 250., 150.])
        """
        across, up = array("u", u), array("v", v)
        for name, values in (("u", across), ("v", up)):
            refuse_where(~np.isfinite(values), values, name, "finite")
        try:
            across, up = np.broadcast_arrays(across, up)
        except ValueError:
            raise complaint(
                f"u and v must broadcast: shapes {across.shape} and {up.shape}",
                "u and v",
                "of shapes that broadcast",
                Words(f"{across.shape} and {up.shape}"),
            ) from None
        flat = self._core.sample(np.ascontiguousarray(across).reshape(-1), np.ascontiguousarray(up).reshape(-1))
        return float(flat[0]) if across.ndim == 0 else flat.reshape(across.shape)

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        min_nm: float | None = None,
        max_nm: float | None = None,
        *,
        channel: str | None = None,
        page: int | None = None,
    ) -> ThicknessMap:
        """Read a map from a file; its content tells the format, not its name.

        path            OpenEXR, TIFF (its orientation and ImageJ's calibration in nm or um applied), PNG, or NPY of two
                        dimensions; one number a pixel, row 0 on top
        min_nm, max_nm  nm that 0 and the largest number of the format stand for, 0 <= min_nm <= max_nm: both are
                        needed where the file holds whole numbers of 8 or 16 bits, and refused where it holds floats,
                        which are nm already
        channel         which channel: ``"part:layer.channel"`` of an OpenEXR, or as much of its end as tells it from
                        the others; ``"R"``, ``"G"``, ``"B"``, ``"A"`` of a picture in colour (glTF: G). None: the only
                        one, or the only ``thickness_nm``, ``thickness`` or ``Z``
        page            which page of a TIFF, 1 is the first; None: the only one
        Returns         ThicknessMap; how the file was understood is in its ``read``
        Raises          ValueError naming the file and what is wrong: missing, a folder, empty, damaged, of another
                        kind, several channels or pages and none named, more than 2**27 cells, a value that is
                        not finite or negative with its place; or naming ``min_nm`` or ``max_nm``

        >>> import pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder, "film.npy")
        ...     np.save(file, np.array([[0, 51], [102, 255]], dtype=np.uint8))
        ...     grid = ThicknessMap.load(file, min_nm=100.0, max_nm=600.0)
        >>> grid.thickness_nm.round(6).tolist()
        [[100.0, 200.0], [300.0, 600.0]]
        """
        name = file_name(path)
        ends = {"min_nm": min_nm, "max_nm": max_nm}
        given = {key: None if value is None else number(key, value) for key, value in ends.items()}
        if not (channel is None or isinstance(channel, str)):
            raise refusal("channel", "a string or None", channel)
        if page is not None:
            try:
                page = operator.index(page)
            except TypeError:
                raise refusal("page", "a whole number >= 1 or None", page) from None
            if not 1 <= page <= 2**31:
                raise refusal("page", "a whole number >= 1 or None", page)
        values, plain = _core.load_thickness_map(name, given["min_nm"], given["max_nm"], channel, page)
        made = cls(values)
        made._read = of_core(plain)
        return made

    @property
    def read(self) -> ReadReport | None:
        """How its file was understood: channel, page, unit and why (`ReadReport`); None for a map that is no file's."""
        return self._read

    def save(
        self,
        path: str | os.PathLike[str],
        pixel_size: float | tuple[float, float] | None = None,
        unit: str = "mm",
    ) -> None:
        """Write the map: a whole file or none. What was at ``path`` stays until the new file is complete.

        path        ``.tif`` or ``.tiff``: float32, nm, as ImageJ writes it: it shows nm as the unit of the values
                    (``vunit``). ``.exr``: one float32 channel ``thickness_nm``. ``.npy``: float64
        pixel_size  width, or (width, height), of a cell in ``unit``, > 0; only for TIFF
        unit        of ``pixel_size``, as ImageJ names it: ``"mm"``, ``"um"``, ...
        Raises      ValueError for a wrong argument, another extension, or a thickness beyond single precision;
                    OSError (FileNotFoundError, PermissionError, ...) naming the file where it cannot be written

        `load` reads it back.

        >>> import pathlib, tempfile
        >>> grid = ThicknessMap([[0.0, 100.0], [200.0, 300.5]])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder, "film.tif")
        ...     grid.save(file, pixel_size=0.5)
        ...     ThicknessMap.load(file) == grid
        True
        """
        name = file_name(path)
        ending = os.path.splitext(name)[1].lower()
        if ending not in _ENDINGS:
            raise refusal("path", f"in {', '.join(_ENDINGS)}", name, must="end")
        if pixel_size is not None and ending not in _TIFF:
            raise complaint(
                f"pixel_size goes with a TIFF file, got {name!r:.200}",
                "pixel_size",
                "left out unless the file is a TIFF",
                pixel_size,
            )
        if ending != ".npy" and float(self._thickness_nm.max()) > _MAX_FLOAT32:
            raise complaint(
                f"a map with {float(self._thickness_nm.max())!r} nm does not fit single precision",
                "thickness_nm",
                "within single precision",
                Words(float(self._thickness_nm.max())),
            )
        _core.check_output(name)
        if ending == ".npy":
            buffer = io.BytesIO()
            np.save(buffer, self._thickness_nm)
            content = buffer.getvalue()
        elif ending == ".exr":
            content = self._core.exr_bytes()
        else:
            content = self._tiff_bytes(pixel_size, unit)
        _core.write_file(name, content)

    def color(
        self, medium: Any = "soap", substrate: Any = "air", *, space: str = "srgb", **how: Any
    ) -> NDArray[np.float64]:
        """Colour of a film as thick as this in air, cell by cell: a picture of it.

        medium, substrate  of the film and below it, as a `Stack` takes them
        space, **how       as in `Stack.color`: ``angle_deg``, ``illuminant``, ``observer``, ``gamut``, ...
        Returns            float64                                                          (height, width, 3)
        Raises             ValueError as there

        >>> ThicknessMap([[0.0, 100.0], [200.0, 300.0]]).color()[:, :, 1].round(2).tolist()
        [[0.0, 0.31], [-0.02, 0.31]]
        """
        from iridesce.optics.layer import Layer
        from iridesce.stack import Stack

        return Stack(["air", Layer(medium, thickness_nm=self._thickness_nm), substrate]).color(space=space, **how)

    def plot(self, ax: Axes | None = None, *, title: str | None = None) -> Axes:
        """The map in false colours with its scale in nm.

        ax       matplotlib Axes; None makes a figure
        title    None: the range in words; ``""``: none
        Returns  the Axes
        Raises   ImportError naming the extra where matplotlib is missing

        >>> ThicknessMap([[100.0, 200.0], [300.0, 400.0]]).plot().get_title()
        '100 to 400 nm'
        """
        import matplotlib.pyplot as plt

        if ax is None:
            _, ax = plt.subplots(layout="constrained")
        shown = ax.imshow(self._thickness_nm, cmap="viridis", interpolation="nearest")
        ax.figure.colorbar(shown, ax=ax, label="thickness (nm)", shrink=0.85)
        if title is None:
            title = f"{float(self._thickness_nm.min()):.4g} to {float(self._thickness_nm.max()):.4g} nm"
        ax.set_title(title)
        ax.set(xlabel="column", ylabel="row")
        return ax

    def _tiff_bytes(self, pixel_size: float | tuple[float, float] | None, unit: str) -> bytes:
        import tifffile

        # ImageJ takes "vunit" alone for floats; older versions want the calibration function with it, here the
        # straight line 0 + 1 x.
        metadata: dict[str, Any] = {"axes": "YX", "hyperstack": False, "cf": 0, "c0": 0.0, "c1": 1.0, "vunit": "nm"}
        metadata |= {"min": float(self._thickness_nm.min()), "max": float(self._thickness_nm.max())}
        resolution: tuple[float, float] | None = None
        if pixel_size is not None:
            if not (isinstance(unit, str) and unit.isascii() and unit.isprintable() and 0 < len(unit) <= 20):
                raise refusal("unit", 'a short ASCII text such as "mm"', unit)
            both = pixel_size if isinstance(pixel_size, (tuple, list)) else (pixel_size, pixel_size)
            sides = [number("pixel_size", side) for side in both]
            # TIFF holds ratios of 32-bit numbers.
            if len(sides) != 2 or not all(1e-6 <= side <= 1e6 for side in sides):
                raise refusal("pixel_size", "one or two lengths from 1e-6 to 1e6", pixel_size)
            metadata["unit"] = unit
            resolution = (1.0 / sides[0], 1.0 / sides[1])
        buffer = io.BytesIO()
        tifffile.imwrite(
            buffer,
            self._thickness_nm.astype(np.float32),
            imagej=True,
            metadata=metadata,
            resolution=resolution,
            resolutionunit="NONE" if resolution else None,
        )
        return buffer.getvalue()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy:
            return np.array(self._thickness_nm, dtype=dtype)
        return np.asarray(self._thickness_nm, dtype=dtype)

    def _repr_png_(self) -> bytes:
        """What a notebook shows: false colours from the least thickness (dark) to the greatest."""
        return _false_colors(self._thickness_nm)

    def __repr__(self) -> str:
        least, most = float(self._thickness_nm.min()), float(self._thickness_nm.max())
        return f"<iridesce.thickness.ThicknessMap {self.width} x {self.height}, {least:g} to {most:g} nm>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ThicknessMap) and np.array_equal(self._thickness_nm, other._thickness_nm)

    def __hash__(self) -> int:
        return hash((self._thickness_nm.shape, self._thickness_nm.tobytes()))

    def __reduce__(self) -> tuple[Any, ...]:
        return (ThicknessMap, (self._thickness_nm,))


def _false_colors(thickness_nm: NDArray[np.float64]) -> bytes:
    """A map in false colours from its least value (dark) to its greatest, small ones enlarged."""
    import matplotlib

    step = max(1, -(-max(thickness_nm.shape) // 1024))
    values = thickness_nm[::step, ::step]
    low, high = float(values.min()), float(values.max())
    share = (values - low) / (high - low) if high > low else np.zeros_like(values)
    rgb = matplotlib.colormaps["viridis"](share)[..., :3].astype(np.float32)
    times = max(1, 192 // max(values.shape))
    return bytes(_core.png_bytes(np.ascontiguousarray(rgb.repeat(times, axis=0).repeat(times, axis=1)), "srgb"))


def array(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Real numbers as float64, or ValueError naming them."""
    try:
        refuse_masks(name, values)
        found = np.asarray(values)
        if found.dtype.kind not in "fiu":
            raise TypeError
        return found.astype(np.float64, copy=False)
    except ArgumentError:
        raise
    except (TypeError, ValueError):
        raise refusal(name, "real numbers", values) from None


def refuse_where(wrong: NDArray[np.bool_], values: NDArray[np.float64], name: str, allowed: str) -> None:
    """Names the first value that breaks a rule, and its place."""
    if wrong.any():
        at = tuple(int(i) for i in np.argwhere(wrong)[0])
        raise refusal(name, allowed, values[at].item(), place(at))
