"""What a series of spectra says: thickness, interval and verdict in time, and the lamp that was learnt. Internal."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from iridesce._notebook import facts_html
from iridesce.arguments.operands import Floats
from iridesce.arguments.scalars import file_name
from iridesce.files import rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class SeriesResult:
    """A film's thickness in time.

    time_s        of each spectrum; their numbers where no times were given                      (n,)
    thickness_nm  the likeliest thickness, NaN where no film can be told                         (n,)
    interval_nm   (low, high) of the asked probability if the order is right, stated tolerances included (n, 2)
    precision_nm  standard deviation without them: of noise and lamp, by which spectra can be compared    (n,)
    accuracy_nm   standard deviation with 1 % of index and 0.3 nm of wavelengths where nothing was said of them   (n,)
    probability_of_order  that the order is right, "no film" among the explanations               (n,)
    no_film       probability that there is no film                                              (n,)
    verdict       "clear", "ambiguous", "doubtful", "none", as of `ir.fit_thickness`             (n,)
    kappa         by how much what is left is larger than the noise                              (n,)
    wavelength_nm, response  the lamp's course learnt over the series, mean 1                    (wavelengths,)
    learnt        whether it was: else it is a smooth guess, and every spectrum stands for itself
    stack, probability, notes

    >>> import numpy as np
    >>> import iridesce as ir
    >>> nm = np.arange(450.0, 800.0, 4.0)
    >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(1000.0, 900.0, 8)[:, None]), "air"])
    >>> series = ir.fit_series(nm, film.reflectance(nm), "air / soap ? / air", gain=1.0)
    >>> series.thickness_nm.shape, series.interval_nm.shape
    ((8,), (8, 2))
    """

    time_s: Floats
    thickness_nm: Floats
    interval_nm: Floats
    probability_of_order: Floats
    no_film: Floats
    verdict: npt.NDArray[np.str_]
    kappa: Floats
    wavelength_nm: Floats = field(repr=False)
    response: Floats = field(repr=False)
    learnt: bool
    stack: str
    probability: float
    notes: tuple[str, ...]
    precision_nm: Floats = field(default_factory=lambda: np.empty(0))
    accuracy_nm: Floats = field(default_factory=lambda: np.empty(0))

    def __len__(self) -> int:
        return int(self.thickness_nm.size)

    def __str__(self) -> str:
        words = ", ".join(f"{count} {word}" for word, count in self.counts().items() if count)
        lines = [f"{self.stack}: {len(self)} spectra, {words}; lamp {'learnt' if self.learnt else 'not learnt'}"]
        seen = np.isfinite(self.thickness_nm)
        if seen.any():
            lines.append(f"  {np.nanmin(self.thickness_nm):.1f} to {np.nanmax(self.thickness_nm):.1f} nm")
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def counts(self) -> dict[str, int]:
        """How many spectra have each verdict.

        Returns    dict

        >>> import numpy as np
        >>> import iridesce as ir
        >>> nm = np.arange(450.0, 800.0, 4.0)
        >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(1000.0, 900.0, 8)[:, None]), "air"])
        >>> ir.fit_series(nm, film.reflectance(nm), "air / soap ? / air", gain=1.0).counts()["clear"]
        8
        """
        return {word: int((self.verdict == word).sum()) for word in ("clear", "ambiguous", "doubtful", "none")}

    def columns(self) -> dict[str, Any]:
        """What `save` writes, by name.

        Returns    dict of arrays

        >>> import numpy as np
        >>> import iridesce as ir
        >>> nm = np.arange(450.0, 800.0, 4.0)
        >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(1000.0, 900.0, 8)[:, None]), "air"])
        >>> list(ir.fit_series(nm, film.reflectance(nm), "air / soap ? / air", gain=1.0).columns())[:3]
        ['time_s', 'thickness_nm', 'low_nm']
        """
        return {
            "time_s": self.time_s,
            "thickness_nm": self.thickness_nm,
            "low_nm": self.interval_nm[:, 0],
            "high_nm": self.interval_nm[:, 1],
            "verdict": self.verdict,
            "probability_of_order": self.probability_of_order,
            "no_film": self.no_film,
            "kappa": self.kappa,
            "precision_nm": self.precision_nm,
            "accuracy_nm": self.accuracy_nm,
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a row a spectrum: .csv, or .json with lamp and notes.

        path       file name; written whole or not at all
        Returns    None
        Raises     ValueError for another ending; OSError

        >>> import tempfile
        >>> import numpy as np
        >>> import iridesce as ir
        >>> nm = np.arange(450.0, 800.0, 4.0)
        >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(1000.0, 900.0, 8)[:, None]), "air"])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     ir.fit_series(nm, film.reflectance(nm), "air / soap ? / air", gain=1.0).save(f"{folder}/series.csv")
        ...     print(Path(folder, "series.csv").read_text().splitlines()[0])
        time_s,thickness_nm,low_nm,high_nm,verdict,probability_of_order,no_film,kappa,precision_nm,accuracy_nm
        """
        place = Path(file_name(path, rows.FORMATS))
        facts = {
            "stack": self.stack,
            "probability": self.probability,
            "learnt": self.learnt,
            "notes": list(self.notes),
            "wavelength_nm": self.wavelength_nm.tolist(),
            "response": self.response.tolist(),
        }
        told = {
            name: [None if one != one else one for one in values.tolist()] for name, values in self.columns().items()
        }
        rows.write(place, told if place.suffix.lower() == ".json" else self.columns(), facts)

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` over ``time_s``, with the lamp over ``wavelength_nm``; needs the extra ``xarray``.

        Returns    xarray.Dataset
        Raises     ImportError without xarray

        >>> import numpy as np
        >>> import iridesce as ir
        >>> nm = np.arange(450.0, 800.0, 4.0)
        >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(1000.0, 900.0, 8)[:, None]), "air"])
        >>> ir.fit_series(nm, film.reflectance(nm), "air / soap ? / air", gain=1.0).to_xarray().thickness_nm.dims
        ('time_s',)
        """
        try:
            import xarray
        except ImportError:
            raise ImportError('to_xarray needs xarray: pip install "iridesce[xarray]"') from None
        columns = self.columns()
        data = {name: ("time_s", values) for name, values in columns.items() if name != "time_s"}
        return xarray.Dataset(
            {**data, "response": ("wavelength_nm", self.response)},
            coords={"time_s": self.time_s, "wavelength_nm": self.wavelength_nm},
            attrs={"stack": self.stack, "probability": self.probability, "notes": list(self.notes)},
        )

    def _repr_html_(self) -> str:
        counts = ", ".join(f"{count} {word}" for word, count in self.counts().items() if count)
        facts = [("spectra", str(len(self))), ("verdicts", counts), ("lamp", "learnt" if self.learnt else "not learnt")]
        return facts_html(self.stack, [*facts, *(("note", note) for note in self.notes)])

    def plot(self, ax: Axes | None = None, *, title: str | None = None, theme: str | None = None) -> Axes:
        """Thickness against time, with intervals; hollow where the verdict is not "clear".

        ax, title, theme  as in `iridesce.plot`
        Returns    the Axes
        Raises     ValueError as there

        >>> import numpy as np
        >>> import iridesce as ir
        >>> nm = np.arange(450.0, 800.0, 4.0)
        >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=np.linspace(1000.0, 900.0, 8)[:, None]), "air"])
        >>> ir.fit_series(nm, film.reflectance(nm), "air / soap ? / air", gain=1.0).plot().get_ylabel()
        'thickness (nm)'
        """
        from iridesce.plot import _series

        return _series.plot(self, ax, title, theme)


def no_film(times: Floats, nm: Floats, stack: str, probability: float, notes: list[str]) -> SeriesResult:
    """No spectrum shows a film."""
    count = times.size
    empty = np.full(count, np.nan)
    none = np.full(count, "none", dtype="<U9")
    return SeriesResult(
        times, empty, np.full((count, 2), np.nan), np.zeros(count), np.ones(count), none, np.ones(count), nm,
        np.ones_like(nm), False, stack, probability, tuple(notes), empty, empty,
    )  # fmt: skip
