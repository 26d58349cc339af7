"""A rig's own eye: what each channel of a camera sees under its lamp, learnt from a film whose thickness is known."""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from iridesce._notebook import facts_html
from iridesce.arguments.operands import Floats, plain_reals
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.arguments.scalars import file_name, number
from iridesce.files.whole import read_whole, write_whole
from iridesce.inverse.calibration_fit import KNOTS, ResponseFit, contact_gap, fit, not_negative, of_any_sign
from iridesce.inverse.model import Problem, describe, read_problem
from iridesce.inverse.pictures import Picture, clip_levels, corrected, read_mask, read_picture
from iridesce.inverse.views import View, of_response, reflectances, wavelengths

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_FORMAT = "iridesce camera calibration"
_MOST_BYTES = 1 << 22
# Relative uncertainty of the scale that a lens leaves (two pictures of one rig), when its radius is exact.
_SCALE_SD = 0.004


@dataclass(frozen=True, eq=False)
class CameraCalibration:
    """What each channel of a rig sees, lamp included: effective spectra, relative to their common sum.

    wavelength_nm  of the response, nm                                                (n,)
    response       weight of each wavelength in red, green and blue; negative in part where a colour matrix mixed the
                   channels (sRGB)                                                    (n, 3)
    haze           light of each channel that is no film's, in units of a white surface
    misfit         root mean square of what the known film leaves, of its contrast
    gap_nm         what had to be added to the thickness that was given
    center         (x, y) of the model, pixels; None where a map was given
    stack          of the known film
    made           when

    A film of known shape is a spectrometer: as its thickness grows each channel runs through its interferogram. A lens of known
    radius on a plate is the best of them.

    >>> import numpy as np
    >>> import iridesce as ir
    >>> y, x = np.mgrid[0:80, 0:80]
    >>> gap = 0.6 * ((x - 40.0) ** 2 + (y - 40.0) ** 2)
    >>> seen = ir.Stack(["N-BK7", ir.Layer("air", gap), "N-BK7"]).color(space="linear-srgb")
    >>> rig = ir.CameraCalibration.from_known(seen, "N-BK7 / air ? / N-BK7", gap)
    >>> [int(nm) for nm in rig.wavelength_nm[rig.response.argmax(axis=0)]][1:]
    [540, 450]
    """

    wavelength_nm: Floats = field(repr=False)
    response: Floats = field(repr=False)
    haze: tuple[float, float, float]
    misfit: float
    gap_nm: float
    center: tuple[float, float] | None
    stack: str
    made: str

    @classmethod
    def from_known(
        cls,
        image: Any,
        stack: Any,
        thickness_nm: Any,
        *,
        pixel_um: float | None = None,
        center: tuple[float, float] | None = None,
        dark: Any = None,
        flat: Any = None,
        mask: npt.ArrayLike | None = None,
    ) -> CameraCalibration:
        """Learns the response from a picture of a film of known thickness.

        y_c(h) = sum q_c(l) R(l, h) + o_c with q_c >= 0 and smooth, as smooth as the noise allows (discrepancy principle).
        Channels that a colour matrix has mixed (sRGB of a developed or rendered picture) see some wavelengths with a negative
        weight: where no q_c >= 0 explains what a signed one does, q_c is signed. Bias of the gap is fitted with it and is then
        not independent; slope, order and radius are.

        image        as for `map_thickness`
        stack        with one unknown layer: "N-BK7 / air ? / N-BK7"
        thickness_nm  nm of every pixel (h, w), NaN where unknown; or `iridesce.thickness.lens_gap` or `wedge`, laid out by
                     pixel_um around center (x to the right, y up, millimetres)
        pixel_um     side of a pixel in the film's plane; needed for a model
        center       (x, y) of the model's origin, pixels; None: found (the point about which the picture is symmetric)
        dark, flat, mask  as for `map_thickness`
        Returns      CameraCalibration
        Raises       ValueError: shapes, no model without pixel_um, too few thicknesses, a picture that does not show this film
        Source       docs/guide/photographs.md

        >>> import numpy as np
        >>> import iridesce as ir
        >>> gap = np.linspace(0.0, 2500.0, 200) + np.zeros((20, 1))
        >>> seen = ir.Stack(["N-BK7", ir.Layer("air", gap), "N-BK7"]).color(space="linear-srgb")
        >>> ir.CameraCalibration.from_known(seen, "N-BK7 / air ? / N-BK7", gap).misfit < 0.02
        True
        """
        problem = read_problem(stack, None, None, "reflectance", 0.0, "unpolarized")
        if len(problem.unknown) != 1:
            raise refusal("stack", "one unknown thickness", Words(len(problem.unknown)), must="have")
        picture = corrected(read_picture(image), flat, dark)
        usable = np.isfinite(picture.pixels).all(axis=2) & ~read_mask(mask, picture.shape)
        usable &= (picture.pixels < clip_levels(picture, usable, None, [])).all(axis=2)
        if not usable.any():
            raise complaint(
                "mask, NaN or full channels leave no pixel of the picture",
                "mask",
                "one that leaves pixels whose channels are finite and not full",
                Words("none of them"),
            )
        known, place = _known(thickness_nm, pixel_um, center, picture, usable)
        usable &= np.isfinite(known)
        if not usable.any() or (known[usable] < 0.0).any():
            raise complaint(
                "thickness_nm must be >= 0, and known somewhere that is not masked",
                "thickness_nm",
                ">= 0, and known somewhere that is not masked",
                Words("values below 0, or none"),
            )
        best, gap = _learnt(problem, picture, known, usable, has_contact=place is not None)
        scale = best.response.sum(axis=0).mean()
        red, green, blue = (best.haze / scale).tolist()
        return cls(
            KNOTS.copy(),
            best.response / scale,
            (red, green, blue),
            best.misfit,
            gap,
            place,
            describe(problem),
            datetime.now(UTC).isoformat(timespec="seconds"),
        )

    @property
    def scale_sd(self) -> float:
        """Relative standard deviation of thicknesses found with it, its own film being exact."""
        return math.hypot(_SCALE_SD, 0.05 * self.misfit)

    def _facts(self) -> list[tuple[str, str]]:
        peaks = ", ".join(f"{nm:.0f}" for nm in self.wavelength_nm[self.response.argmax(axis=0)])
        middle = "" if self.center is None else f"{self.center[0]:.1f}, {self.center[1]:.1f}"
        return [
            ("channels largest at", f"{peaks} nm"),
            ("contrast left over", f"{100.0 * self.misfit:.1f} %"),
            ("gap", f"{self.gap_nm:.1f} nm"),
            ("middle of the rings at", middle),
        ]

    def __str__(self) -> str:
        return f"{self.stack}: " + ", ".join(f"{name} {value}" for name, value in self._facts() if value)

    def _repr_html_(self) -> str:
        return facts_html(self.stack, self._facts())

    def plot(self, ax: Axes | None = None, *, title: str | None = None, theme: str | None = None) -> Axes:
        """What red, green and blue see, over wavelength.

        ax, title, theme  as in `iridesce.plot`
        Returns    the Axes
        Raises     ValueError as there

        >>> import numpy as np
        >>> import iridesce as ir
        >>> gap = np.linspace(0.0, 2500.0, 200) + np.zeros((20, 1))
        >>> seen = ir.Stack(["N-BK7", ir.Layer("air", gap), "N-BK7"]).color(space="linear-srgb")
        >>> ax = ir.CameraCalibration.from_known(seen, "N-BK7 / air ? / N-BK7", gap).plot()
        >>> [line.get_label() for line in ax.get_lines()][:3]
        ['red', 'green', 'blue']
        """
        from iridesce.plot import _calibration

        return _calibration.plot(self, ax, title, theme)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it as JSON.

        path       ends in .json
        Raises     ValueError: another ending; OSError where it cannot be written

        >>> import pathlib, tempfile
        >>> import numpy as np
        >>> import iridesce as ir
        >>> gap = np.linspace(0.0, 2500.0, 200) + np.zeros((20, 1))
        >>> seen = ir.Stack(["N-BK7", ir.Layer("air", gap), "N-BK7"]).color(space="linear-srgb")
        >>> rig = ir.CameraCalibration.from_known(seen, "N-BK7 / air ? / N-BK7", gap)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     rig.save(pathlib.Path(folder, "rig.json"))
        ...     bool((ir.CameraCalibration.load(pathlib.Path(folder, "rig.json")).response == rig.response).all())
        True
        """
        name = file_name(path, (".json",))
        tree = {
            "format": _FORMAT,
            "version": 1,
            "stack": self.stack,
            "made": self.made,
            "misfit": self.misfit,
            "gap_nm": self.gap_nm,
            "center": None if self.center is None else list(self.center),
            "haze": list(self.haze),
            "wavelength_nm": self.wavelength_nm.tolist(),
            "response": self.response.tolist(),
        }
        write_whole(Path(name), (json.dumps(tree, indent=1) + "\n").encode())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> CameraCalibration:
        """Reads what `save` wrote.

        path       the file
        Returns    CameraCalibration
        Raises     ValueError naming the file: missing, no calibration, numbers that cannot be

        >>> import iridesce as ir
        >>> ir.CameraCalibration.load("none.json")
        Traceback (most recent call last):
        ValueError: none.json: no such file
        """
        label = file_name(path)
        content = read_whole(label, _MOST_BYTES, "no calibration is")
        try:
            tree = json.loads(content)
            if tree["format"] != _FORMAT:
                raise KeyError("format")
            nm = np.array(tree["wavelength_nm"], dtype=np.float64)
            response = np.array(tree["response"], dtype=np.float64)
            red, green, blue = (float(value) for value in tree["haze"])
            misfit, gap = float(tree["misfit"]), float(tree["gap_nm"])
            center = None if tree["center"] is None else (float(tree["center"][0]), float(tree["center"][1]))
            stack, made = str(tree["stack"]), str(tree["made"])
        except (ValueError, KeyError, TypeError, IndexError, RecursionError, OverflowError):
            raise ValueError(f"{label}: is not the JSON of a camera calibration (CameraCalibration.save)") from None
        is_good = nm.ndim == 1 and nm.size >= 8 and response.shape == (nm.size, 3)
        if not (is_good and np.isfinite(response).all() and (response.sum(axis=0) > 0.0).all()):
            raise ValueError(
                f"{label}: wavelength_nm and response must be n and n x 3 numbers, the sum of each channel > 0"
            )
        if not ((np.diff(nm) > 0.0).all() and nm[0] >= 100.0 and nm[-1] <= 3000.0 and math.isfinite(misfit)):
            raise ValueError(f"{label}: wavelength_nm must ascend within 100 to 3000, and misfit be finite")
        return cls(nm, response, (red, green, blue), misfit, gap, center, stack, made)

    def _views(self, problem: Problem, grid: Floats, angles: Floats) -> list[View]:
        """The tables of films as this rig sees them."""
        nm = wavelengths(float(grid[-1]), 1.5)
        columns = [np.interp(nm, self.wavelength_nm, one, left=0.0, right=0.0) for one in self.response.T]
        spectra = reflectances(problem, grid, angles, nm).astype(np.float32)
        found = of_response("calibration", "calibration", np.stack(columns, axis=1), spectra)
        # The balance of the channels was measured: it is as it is.
        return found[-1:]


def _known(
    thickness_nm: Any,
    pixel_um: float | None,
    center: tuple[float, float] | None,
    picture: Picture,
    usable: npt.NDArray[np.bool_],
) -> tuple[Floats, tuple[float, float] | None]:
    """The thickness of every pixel, nm; and the middle of the model that was laid out, None for a map."""
    if not callable(getattr(thickness_nm, "at_point", None)):
        known = plain_reals("thickness_nm", thickness_nm, "numbers, one for each pixel, or a model")
        if known.shape != picture.shape:
            raise refusal("thickness_nm", f"a value for each pixel {picture.shape}", Words(known.shape), must="hold")
        return known, None
    if pixel_um is None:
        raise complaint(
            "pixel_um is needed to lay out a thickness model",
            "pixel_um",
            "a number > 0 with a thickness model",
            None,
        )
    pixel_mm = 1e-3 * number("pixel_um", pixel_um, low=0.0, high=1e6, includes_low=False)
    place = _center(center, picture, usable)
    return _laid_out(thickness_nm, picture.shape, pixel_mm, place), place


def _learnt(
    problem: Problem, picture: Picture, known: Floats, usable: npt.NDArray[np.bool_], has_contact: bool
) -> tuple[ResponseFit, float]:
    """What the channels see, and what had to be added to the gap of a model whose glasses touch, nm."""
    seen = picture.pixels[usable]
    if (np.ptp(seen, axis=0) <= 1e-6 * np.abs(seen).max(axis=0, initial=0.0)).any():
        raise complaint(
            "a channel of the picture has one value throughout: it shows no film",
            "image",
            "a picture whose channels vary",
            Words("one with a constant channel"),
        )
    gap = contact_gap(problem, picture, known, usable, not_negative) if has_contact else 0.0
    best = fit(problem, picture, known + gap, usable)
    if best.is_signed and has_contact:
        gap = contact_gap(problem, picture, known, usable, of_any_sign)
        best = fit(problem, picture, known + gap, usable)
    if best.misfit > 0.25:
        raise complaint(
            f"the picture does not show this film: {100.0 * best.misfit:.0f} % of its contrast is left over "
            "(center, pixel_um, stack, or a curve that is not linear)",
            "image",
            "a picture of this film",
            Words(f"one with {100.0 * best.misfit:.0f} % of its contrast left over"),
        )
    return best, gap


def _laid_out(model: Any, shape: tuple[int, int], pixel_mm: float, center: tuple[float, float]) -> Floats:
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]]
    across, up = (x - center[0]) * pixel_mm, (center[1] - y) * pixel_mm
    if callable(getattr(model, "at_radius", None)) and "lens_gap" in model.to_scene():
        return np.asarray(model.at_radius(np.hypot(across, up)), dtype=np.float64)
    points = np.stack([across, up, np.zeros_like(across)], axis=-1)
    return np.asarray(model.at_point(points), dtype=np.float64)


def _center(given: Any, picture: Picture, usable: npt.NDArray[np.bool_]) -> tuple[float, float]:
    height, width = picture.shape
    if given is not None:
        try:
            x, y = (float(value) for value in given)
        except (TypeError, ValueError):
            raise refusal("center", "(x, y) in pixels", given) from None
        if not (math.isfinite(x) and math.isfinite(y)):
            raise refusal("center", "finite", Words(f"({x}, {y})"))
        return x, y
    # The picture turned by half a turn about its centre of symmetry is itself: the peak of its correlation with itself turned.
    light = np.where(usable[..., None], picture.pixels, np.nan).astype(np.float64)
    light = np.nan_to_num(light - np.nanmean(light, axis=(0, 1)), nan=0.0)
    total = np.zeros((2 * height, 2 * width))
    for c in range(3):
        spectrum = np.fft.rfft2(light[..., c], total.shape)
        total += np.fft.irfft2(spectrum * spectrum, total.shape)
    row, column = np.unravel_index(int(total.argmax()), total.shape)

    def between(values: Floats, at: int) -> float:
        low, mid, high = values[at - 1], values[at], values[(at + 1) % values.size]
        bend = low - 2.0 * mid + high
        return at + (0.5 * (low - high) / bend if bend < 0.0 else 0.0)

    return 0.5 * between(total[row], int(column)), 0.5 * between(total[:, column], int(row))
