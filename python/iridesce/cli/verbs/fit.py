"""The verb ``fit``: film thickness from a spectrum."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from iridesce.cli.answers import note, print_json, quiet_dask, say, tell
from iridesce.cli.chart_file import FORMATS, write_chart
from iridesce.cli.exit_codes import BAD_INPUT, message
from iridesce.cli.options import AngleOption, DaskOption, JsonOption, PolarizationOption, SizeOption, ThemeOption
from iridesce.cli.reading import pair


def verb(
    spectrum: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="Text files of a spectrometer: wavelength and measurement; each is fitted by itself.",
            show_default=False,
        ),
    ],
    stack: Annotated[
        str, typer.Option("--stack", help='Media and layers, ? for what is unknown: "air / SiO2 ? / Si".')
    ],
    angle: AngleOption = 0.0,
    polarization: PolarizationOption = "unpolarized",
    quantity: Annotated[str, typer.Option(help="reflectance or transmittance.")] = "reflectance",
    range_: Annotated[
        list[str] | None,
        typer.Option("--range", metavar="A:B", help="Thicknesses to look among, nm; once, or once for each ?."),
    ] = None,
    gain: Annotated[
        str | None,
        typer.Option(
            help='measured = gain x model; unknown if not given. 1 for a calibrated ratio; "linear", "quadratic": drifting.'
        ),
    ] = None,
    baseline: Annotated[str, typer.Option(help="Stray light: auto, none, constant, linear or quadratic.")] = "auto",
    resolution: Annotated[
        float | None, typer.Option(help="Full width of the instrument's line, nm; found if not given.")
    ] = None,
    index: Annotated[
        str | None, typer.Option(help="Fit the index of the unknown layers too: constant or cauchy.")
    ] = None,
    index_tolerance: Annotated[
        float | None,
        typer.Option(
            "--index-tolerance",
            help="Standard deviation of the film's index, relative; if not given, only the accuracy holds 0.01.",
            show_default=False,
        ),
    ] = None,
    wavelength_tolerance: Annotated[
        float | None,
        typer.Option(
            "--wavelength-tolerance",
            help="Standard deviation of the spectrometer's wavelengths, nm; if not given, only the accuracy holds 0.3.",
            show_default=False,
        ),
    ] = None,
    dark: Annotated[Path | None, typer.Option(help="File of counts without light.", show_default=False)] = None,
    reference: Annotated[
        Path | None, typer.Option(help="File of counts of the reference, see --reference-stack.", show_default=False)
    ] = None,
    reference_stack: Annotated[
        str | None,
        typer.Option("--reference-stack", help='What the reference is: "air / Si"; a perfect mirror if not given.'),
    ] = None,
    column: Annotated[str | None, typer.Option(help="Name or number of the measurement's column.")] = None,
    wavelength_column: Annotated[
        str | None, typer.Option("--wavelength-column", help="Name or number of the axis's column.")
    ] = None,
    unit: Annotated[str | None, typer.Option(help="Of the wavelengths: nm, um, angstrom, cm-1, ev.")] = None,
    unit_y: Annotated[
        str | None, typer.Option("--unit-y", help="Of the measurement: ratio, percent, counts, absorbance.")
    ] = None,
    from_: Annotated[float, typer.Option("--from", help="Leave out wavelengths below, nm.")] = 0.0,
    to: Annotated[float, typer.Option("--to", help="Leave out wavelengths above, nm.")] = float("inf"),
    probability: Annotated[float, typer.Option(help="Of the intervals.")] = 0.95,
    series: Annotated[
        bool,
        typer.Option("--series", help="The files are one film in time, in this order: the lamp is learnt from all."),
    ] = False,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--output",
            help="Plot (.png, .pdf, .svg) or curves (.csv, .json) of one file to write; may be given twice.",
        ),
    ] = None,
    theme: ThemeOption = "light",
    size: SizeOption = None,
    dask: DaskOption = None,
    verbose: Annotated[bool, typer.Option("--verbose", help="Say all of how the file was read.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Film thickness from a reflectance or transmittance spectrum: every plausible solution, and a verdict."""
    from iridesce.files import rows

    files = output or []
    for file in files:
        rows.check(file, (*FORMATS, *rows.FORMATS))
    if files and len(spectrum) > 1 and not series:
        raise typer.BadParameter(f"curves of {len(spectrum)} spectra do not go into one file", param_hint="--output")
    if series and (
        index is not None
        or len(range_ or []) > 1
        or gain in ("linear", "quadratic")
        or baseline not in ("auto", "none")
    ):
        raise typer.BadParameter(
            "a series takes no --index, one --range, a number for --gain, auto or none for --baseline",
            param_hint="--series",
        )
    if series and dask is not None:
        raise typer.BadParameter("a series is one fit; it takes no --dask", param_hint="--dask")
    files_read = _Reading(
        column,
        wavelength_column,
        unit,
        # Counts are no percent, however large they are: they are divided by those of the reference.
        "counts" if unit_y is None and reference is not None else unit_y,
        quantity,
        (from_, to),
        dark,
        reference,
    )
    said: dict[str, Any] = {
        "stack": stack,
        "quantity": quantity,
        "angle_deg": angle,
        "polarization": polarization,
        "baseline": baseline,
        "probability": probability,
        "reference_stack": reference_stack,
        "index_tolerance": index_tolerance,
        "wavelength_tolerance_nm": wavelength_tolerance,
    }
    pairs = [pair(text, "--range", "nm") for text in range_ or []]
    if series:
        said["thickness_range_nm"] = pairs[0] if pairs else None
        said["gain"] = None if gain is None else float(_gain(gain) or 0.0)
        said["resolution_nm"] = 0.0 if resolution is None else resolution
        _tell_series(_fit_series(spectrum, files_read, said), spectrum, files, size, theme, as_json)
        return
    said["thickness_range_nm"] = None if not pairs else pairs[0] if len(pairs) == 1 else pairs
    said |= {"gain": _gain(gain), "resolution_nm": resolution, "index": index}
    answers = _fit_each(spectrum, files_read, said, dask)
    for file in files:
        _write(file, answers[0], size, theme)
    _tell(answers, files, verbose, as_json)
    failed = [one for one in answers if one.error is not None]
    for one in failed:
        say(one.words, BAD_INPUT)
    if failed:
        raise typer.Exit(BAD_INPUT)


@dataclass(frozen=True)
class _Reading:
    """How the files are read, and which belong to all of them."""

    column: str | None
    wavelength_column: str | None
    unit: str | None
    unit_y: str | None
    quantity: str
    range_nm: tuple[float, float]
    dark: Path | None
    reference: Path | None

    def read(self, path: Path) -> Any:
        """A spectrum as it stands in its file."""
        import iridesce as ir

        return ir.fit.read_spectrum(
            path,
            self.column,
            self.unit,
            self.quantity,
            wavelength_column=self.wavelength_column,
            unit_y=self.unit_y,
            range_nm=self.range_nm if self.range_nm != (0.0, float("inf")) else None,
        )

    def inside(self, wavelength_nm: Any) -> Any:
        """Which wavelengths are asked for; what is not a number is, so that the fit can name it."""
        low, high = self.range_nm
        return ~((wavelength_nm < low) | (wavelength_nm > high))

    def counts(self, wavelength_nm: Any, first: Path) -> dict[str, Any]:
        """Counts of the dark and of the reference, at the wavelengths of the first spectrum."""
        import numpy as np

        found: dict[str, Any] = {}
        for name, path in (("dark", self.dark), ("reference", self.reference)):
            if path is not None:
                other = self.read(path)
                if not np.array_equal(other.wavelength_nm, wavelength_nm):
                    raise ValueError(f"{path}: its wavelengths are not those of {first}")
                found[name] = other.measured[self.inside(wavelength_nm)]
        return found


def _fit_series(spectrum: list[Path], reading: _Reading, said: dict[str, Any]) -> Any:
    """All files as one film in time."""
    import numpy as np

    import iridesce as ir
    from iridesce._progress import progress_bar

    read = [reading.read(path) for path in spectrum]
    nm = read[0].wavelength_nm
    for path, one in zip(spectrum, read, strict=True):
        if not np.array_equal(one.wavelength_nm, nm):
            raise ValueError(f"{path}: its wavelengths are not those of {spectrum[0]}")
    inside = reading.inside(nm)
    measured = np.array([one.measured[inside] for one in read])
    with progress_bar("fit", counted=True) as advance:
        return ir.fit_series(nm[inside], measured, **reading.counts(nm, spectrum[0]), **said, progress=advance)


@dataclass(frozen=True)
class _Answer:
    """What a file was read as, and its fit; or why there is none."""

    path: Path
    read: Any = None
    result: Any = None
    error: Exception | None = None

    @property
    def words(self) -> str:
        """Why there is no fit, and of which file."""
        words = "" if self.error is None else message(self.error)
        return words if words.startswith(str(self.path)) else f"{self.path}: {words}"

    def to_dict(self) -> dict[str, Any]:
        """For --json."""
        if self.error is not None:
            return {"file": str(self.path), "error": self.words}
        return {
            "file": str(self.path),
            "column": self.read.column,
            "read": self.read.read.to_dict(),
            **self.result.to_dict(),
        }


def _fit_each(spectrum: list[Path], reading: _Reading, said: dict[str, Any], dask: str | None) -> list[_Answer]:
    """Each file by itself. One that cannot be read or fitted stands with its error, and the others are fitted."""
    reads: list[Any] = []
    questions: dict[int, dict[str, Any]] = {}
    for place, path in enumerate(spectrum):
        try:
            reads.append(read := reading.read(path))
            inside = reading.inside(read.wavelength_nm)
            axes = {"wavelength_nm": read.wavelength_nm[inside], "measured": read.measured[inside]}
            questions[place] = {**axes, **reading.counts(read.wavelength_nm, path), **said}
        except (ValueError, OSError) as error:
            reads[place:] = [error]
    found = dict(zip(questions, _fitted(list(questions.values()), dask), strict=True))
    answers = []
    for place, (path, read) in enumerate(zip(spectrum, reads, strict=True)):
        result = read if isinstance(read, Exception) else found[place]
        failed = isinstance(result, Exception)
        answers.append(_Answer(path, error=result) if failed else _Answer(path, read, result))
    for one in answers:
        # One file is all that was asked for; and what is wrong of an option is wrong of every file.
        if one.error is not None and (len(answers) == 1 or _is_of_options(one.error)):
            raise one.error
    return answers


def _fitted(questions: list[dict[str, Any]], dask: str | None) -> list[Any]:
    """The fit of each, or its error."""
    import iridesce as ir

    if dask is not None:
        from iridesce.sweeping.fits import fit_each

        quiet_dask()
        return fit_each(dask, questions, raises=False)
    results: list[Any] = []
    for question in questions:
        try:
            results.append(ir.fit_thickness(**question))
        except ValueError as error:
            results.append(error)
    return results


def _is_of_options(error: Exception) -> bool:
    """Whether an argument was refused that an option gave, and no file."""
    from iridesce.cli.option_words import option_of, options_of
    from iridesce.errors import ArgumentError

    if not isinstance(error, ArgumentError) or error.argument in ("dark", "reference"):
        return False
    return option_of(options_of(verb), error.argument) is not None


def _write(file: Path, answer: _Answer, size: str | None, theme: str) -> None:
    """Curves or a plot of a fit."""
    from iridesce.files import rows

    path, result = answer.path, answer.result
    if file.suffix.lower() not in rows.FORMATS:
        write_chart(file, size, lambda ax: result.plot(ax, theme=theme))
        return
    columns: dict[str, Any] = {"wavelength_nm": result.wavelength_nm, "measured": result.measured}
    for number, solution in enumerate(result, start=1):
        columns[f"fitted_{number}"] = solution.fitted
    rows.write(file, columns, {"file": str(path), **result.to_dict()})


def _tell(answers: list[_Answer], files: list[Path], verbose: bool, as_json: bool) -> None:
    """What the fits say, and which files were written."""
    if as_json:
        told = [one.to_dict() for one in answers]
        print_json({**told[0], "files": [str(file) for file in files]} if len(told) == 1 else told)
        return
    for one in answers:
        if one.error is not None:
            continue
        for remark in [one.read.read] if verbose else one.read.notes:
            note(f"note: {remark}" if len(answers) == 1 and not verbose else f"{one.path}: {remark}")
        tell(str(one.result) if len(answers) == 1 else f"{one.path}: {one.result}")
    for file in files:
        print(file)


def _tell_series(
    course: Any, spectrum: list[Path], files: list[Path], size: str | None, theme: str, as_json: bool
) -> None:
    """A row a spectrum."""
    from iridesce.files import rows

    for file in files:
        if file.suffix.lower() in rows.FORMATS:
            course.save(file)
        else:
            write_chart(file, size, lambda ax: course.plot(ax, theme=theme))
    columns = {name: values.tolist() for name, values in course.columns().items()}
    told = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    if as_json:
        plain = [{name: None if value != value else value for name, value in row.items()} for row in told]
        print_json(
            {
                "stack": course.stack,
                "learnt": course.learnt,
                "notes": list(course.notes),
                "spectra": [{"file": str(path), **row} for path, row in zip(spectrum, plain, strict=True)],
                "files": [str(file) for file in files],
            }
        )
        return
    for remark in course.notes:
        note(f"note: {remark}")
    for path, row in zip(spectrum, told, strict=True):
        sized = row["verdict"] != "none"
        words = f"{row['thickness_nm']:.2f} nm ({row['low_nm']:.2f} to {row['high_nm']:.2f})" if sized else "no film"
        tell(f"{path}: {row['verdict']}, {words}")
    for file in files:
        print(file)


def _gain(text: str | None) -> float | str | None:
    if text is None or text in ("linear", "quadratic"):
        return text
    try:
        return float(text)
    except ValueError:
        words = f'wanted a number, "linear" or "quadratic", got {text!r}'
        raise typer.BadParameter(words, param_hint="--gain") from None
