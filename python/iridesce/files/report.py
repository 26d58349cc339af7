"""What a reader did with a file: for spectra, lamps, index files, maps alike. Offered as `iridesce.ReadReport`."""

from __future__ import annotations

from typing import Any, NamedTuple


class Taken(NamedTuple):
    """One thing that was taken from a file.

    role   what it is used as: "wavelength", "reflectance", "n", "thickness", "radiance"
    name   the column, channel or page, as the file calls it
    unit   the unit its numbers were read in
    why    why it was taken so: "its own name", "unit=", "a guess by the size of the numbers"

    >>> Taken("wavelength", "Wave [nm]", "nm", "its own name").unit
    'nm'
    """

    role: str
    name: str
    unit: str
    why: str


class ReadReport(NamedTuple):
    """How a file was understood. Nothing is decided in silence: what was chosen, why, and what was left out.

    format    the format, with encoding and dialect where it is a text
    taken     columns, channels or pages that were taken: `Taken`
    dropped   what was left out, in words
    notes     what else to know: guesses, conversions

    >>> report = ReadReport("CSV", (Taken("wavelength", "Wave [nm]", "nm", "its own name"),), ("a second table",), ())
    >>> print(report)
    CSV; wavelength: "Wave [nm]" in nm (its own name); left out: a second table
    """

    format: str
    taken: tuple[Taken, ...] = ()
    dropped: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def sentences(self) -> tuple[str, ...]:
        """Guesses, conversions and losses, one sentence each."""
        return (*self.notes, *(f"left out: {what}" for what in self.dropped))

    def to_dict(self) -> dict[str, Any]:
        """As plain values, for JSON.

        Returns    dict of format, taken (a list of dicts), dropped and notes
        Raises     nothing

        >>> ReadReport("NPY", notes=("half of the values are 0",)).to_dict()["notes"]
        ['half of the values are 0']
        """
        taken = [one._asdict() for one in self.taken]
        return {"format": self.format, "taken": taken, "dropped": list(self.dropped), "notes": list(self.notes)}

    def __str__(self) -> str:
        parts = [self.format]
        for role, name, unit, why in self.taken:
            parts.append(f'{role}: "{name}"' + (f" in {unit}" if unit else "") + (f" ({why})" if why else ""))
        return "; ".join([*parts, *self.sentences])


def of_core(plain: tuple[str, list[tuple[str, str, str, str]], list[str], list[str]]) -> ReadReport:
    """A report from the core's plain values."""
    kind, taken, dropped, notes = plain
    return ReadReport(kind, tuple(Taken(*one) for one in taken), tuple(dropped), tuple(notes))
