"""What an export tells: files, colour error, what was left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from iridesce.exchange.charts import Summary


@dataclass(frozen=True)
class ExportReport:
    """What `iridesce.export` wrote, how far the target is from the truth, and what it cannot hold.

    >>> import tempfile, iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=0.0), "air"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     report = ir.export(film, "cube", folder, vary=(50.0, 1200.0))
    >>> [path.name for path in report.files], report.delta_e["mean"] < 0.02
    (['film.cube'], True)
    """

    to: str
    """The target."""
    files: tuple[Path, ...]
    """What was written; all of it whole."""
    delta_e: Summary
    """CIEDE2000 against the truth: ``mean``, ``p95``, ``max`` and ``by_angle`` {degrees: mean}, over 24 thicknesses of the
    range x 0, 15, 30, 45, 60, 75, 85 degrees, both sides times 1 / (largest Y of the chart)."""
    dropped: tuple[str, ...] = ()
    """What the target cannot hold, a sentence each."""
    notes: tuple[str, ...] = ()
    """Units, conventions, how the error was told, what a user should know."""
    films: dict[str, Summary] | None = None
    """The error of each film of a scene, by the name of its object."""

    @property
    def text(self) -> str:
        """The report in words."""
        return "\n".join(self._lines())

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON.

        Returns  a new dict: to, files, delta_e, dropped, notes, films
        Raises   nothing

        >>> from iridesce.exchange.report import ExportReport
        >>> ExportReport("cube", (), {"mean": 0.0, "by_angle": {15.0: 0.0}}).to_dict()["delta_e"]
        {'mean': 0.0, 'by_angle': {'15': 0.0}}
        """
        return {
            "to": self.to,
            "files": [str(path) for path in self.files],
            "delta_e": _plain(self.delta_e),
            "dropped": list(self.dropped),
            "notes": list(self.notes),
            "films": {name: _plain(one) for name, one in (self.films or {}).items()},
        }

    def _lines(self) -> Sequence[str]:
        angles = self.delta_e["by_angle"]
        assert isinstance(angles, dict)
        lines = [
            f"{self.to}: {len(self.files)} file{'s' if len(self.files) != 1 else ''}",
            f"CIEDE2000 against the truth: {words(self.delta_e)}",
            "by angle: " + ", ".join(f"{angle:g} deg {value:.3g}" for angle, value in angles.items()),
        ]
        lines += [f"left out: {sentence}" for sentence in self.dropped]
        lines += [f"note: {sentence}" for sentence in self.notes]
        return lines

    def __str__(self) -> str:
        return self.text


def words(summary: Summary) -> str:
    """``mean 1, p95 2, max 3``."""
    return ", ".join(f"{key} {value:.3g}" for key, value in summary.items() if not isinstance(value, dict))


def _plain(summary: Summary) -> dict[str, Any]:
    return {
        key: {f"{angle:g}": number for angle, number in value.items()} if isinstance(value, dict) else value
        for key, value in summary.items()
    }
