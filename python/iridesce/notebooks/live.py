"""The widget itself: traits that both sides see. Imported only where anywidget is. Internal."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import anywidget
import numpy as np
import traitlets

from iridesce import color
from iridesce.color.color_table import ColorTable
from iridesce.optics.wavelengths import SPECTRUM_NM, in_steps
from iridesce.stack import Layer, Stack

_HERE = Path(__file__).parent
# Angles of the page's chart, and nodes of the table that the browser interpolates: 2.5 degrees, 2.5 nm.
_LAST_DEG = 80.0
_ROWS = 33
_STEP_NM = 2.5
_SPECTRUM_NM = in_steps(SPECTRUM_NM, 2.0)


class FilmWidget(anywidget.AnyWidget):  # type: ignore[misc]  # anywidget has no types
    """What `iridesce.widget` returns."""

    _esm = _HERE / "widget.js"
    _css = _HERE / "widget.css"

    kind = traitlets.Unicode("film").tag(sync=True)
    thickness_nm = traitlets.Float(320.0).tag(sync=True)
    angle_deg = traitlets.Float(0.0).tag(sync=True)
    illuminant = traitlets.Unicode("D65").tag(sync=True)

    _shape = traitlets.List(traitlets.Float()).tag(sync=True)
    _matrix = traitlets.List(traitlets.Float()).tag(sync=True)
    _nodes = traitlets.Bytes().tag(sync=True)
    _field = traitlets.Bytes().tag(sync=True)
    _field_size = traitlets.List(traitlets.Int()).tag(sync=True)
    _spectrum = traitlets.Bytes().tag(sync=True)
    _srgb = traitlets.Unicode("#000").tag(sync=True)
    _words = traitlets.Unicode("").tag(sync=True)

    def __init__(
        self, kind: str, stack: Stack, thickness_nm: float, thickest_nm: float, shares: Any, *, illuminant: str
    ) -> None:
        self._stack = stack
        self._thickest_nm = thickest_nm
        light = color.illuminant(illuminant)  # its error before anything is shown
        super().__init__(kind=kind, thickness_nm=thickness_nm, illuminant=light.name)
        primaries = color.convert(np.eye(3), "xyz", "linear-srgb")
        self._matrix = [float(value) for value in np.asarray(primaries).T.ravel()]
        if shares is not None:
            rows, columns = shares.shape
            self._field_size = [columns, rows]
            self._field = np.ascontiguousarray(shares, dtype=np.float32).tobytes()
        self._table()
        self._film()

    @property
    def description(self) -> str:
        """The film in words and numbers."""
        return self._words

    @traitlets.validate("thickness_nm")  # type: ignore[untyped-decorator]
    def _valid_thickness(self, proposal: Any) -> float:
        return self._within("thickness_nm", proposal["value"], self._thickest_nm)

    @traitlets.validate("angle_deg")  # type: ignore[untyped-decorator]
    def _valid_angle(self, proposal: Any) -> float:
        return self._within("angle_deg", proposal["value"], _LAST_DEG)

    @traitlets.validate("illuminant")  # type: ignore[untyped-decorator]
    def _valid_illuminant(self, proposal: Any) -> str:
        try:
            color.illuminant(proposal["value"])
        except ValueError as error:
            raise traitlets.TraitError(str(error)) from None
        return str(proposal["value"])

    @staticmethod
    def _within(name: str, value: float, most: float) -> float:
        if not 0.0 <= value <= most:
            raise traitlets.TraitError(f"{name} must be from 0 to {most:g}, got {value!r}")
        return float(value)

    @traitlets.observe("thickness_nm", "angle_deg")  # type: ignore[untyped-decorator]
    def _moved(self, _: Any) -> None:
        if self._nodes:
            self._film()

    @traitlets.observe("illuminant")  # type: ignore[untyped-decorator]
    def _relit(self, _: Any) -> None:
        if self._nodes:
            self._table()
            self._film()

    def _varied(self, thickness_nm: Any) -> Stack:
        first, *rest = self._stack.layers
        layer = Layer(first.medium, thickness_nm=thickness_nm, coherent=first.coherent)
        return Stack([self._stack.first, layer, *rest, self._stack.last])

    def _table(self) -> None:
        """Colours and their slopes a step, as the page's tables hold them, over thickness and angle themselves."""
        columns = int(np.ceil(self._thickest_nm / _STEP_NM)) + 1
        nm = np.linspace(0.0, self._thickest_nm, columns)
        deg = np.linspace(0.0, _LAST_DEG, _ROWS)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # told once, by the stack's own colours
            table = ColorTable(
                self._varied(0.0),
                thickness_nm=(0.0, self._thickest_nm),
                angle_deg=(0.0, _LAST_DEG),
                illuminant=self.illuminant,
                layer=0,
            )
        xyz = np.asarray(table.color(nm[None, :], deg[:, None]))
        slopes = np.gradient(xyz, axis=1, edge_order=2)
        white = color.illuminant(self.illuminant).white()
        self._shape = [
            float(_ROWS),
            float(columns),
            self._thickest_nm,
            _LAST_DEG,
            *map(float, white),
            table.max_delta_e,
            0.0,
            0.0,
        ]
        self._nodes = np.concatenate([xyz, slopes], axis=-1).astype(np.float32).tobytes()

    def _film(self) -> None:
        film = self._varied(self.thickness_nm)
        xyz = film.color(self.angle_deg, illuminant=self.illuminant)
        peak = max(float(xyz[1]), 1e-9)
        linear = color.convert(xyz * min(5.0, max(1.0, 0.5 / peak)), "xyz", "linear-srgb")
        shown = color.convert(color.map_gamut(linear, "linear-srgb", "hue")[0], "linear-srgb", "srgb")
        self._srgb = "rgb({} {} {})".format(*(round(255 * float(np.clip(value, 0.0, 1.0))) for value in shown))
        self._spectrum = film.reflectance(_SPECTRUM_NM, self.angle_deg).astype(np.float32).tobytes()
        numbers = " ".join(f"{float(value):.4f}" for value in xyz)
        self._words = f"film {self.thickness_nm:g} nm at {self.angle_deg:g} degrees: XYZ {numbers}"

    def _repr_png_(self) -> bytes:
        """The picture where no kernel runs: the chart of the film's colours over thickness and angle."""
        import io

        from matplotlib.figure import Figure

        nm, deg = np.linspace(0.0, self._thickest_nm, 240), np.linspace(0.0, _LAST_DEG, 120)
        chart = self._varied(nm[None, :]).color(deg[:, None], illuminant=self.illuminant, space="srgb", gamut="hue")
        figure = Figure(figsize=(4.8, 3.0))
        axes = figure.subplots()
        axes.imshow(np.clip(chart, 0.0, 1.0), extent=(0.0, self._thickest_nm, _LAST_DEG, 0.0), aspect="auto")
        axes.plot([self.thickness_nm], [self.angle_deg], "o", color="white", markeredgecolor="black")
        axes.set_xlabel("thickness, nm")
        axes.set_ylabel("angle, degrees")
        file = io.BytesIO()
        figure.savefig(file, format="png", dpi=100, bbox_inches="tight")
        return file.getvalue()
