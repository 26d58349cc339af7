"""Answers of the command line as files: CSV and JSON, written whole. Internal."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from iridesce.arguments.refusals import complaint
from iridesce.files.whole import check_place, write_whole

FORMATS = (".csv", ".json")


def check(path: Path, formats: Sequence[str] = FORMATS) -> None:
    """Find out before the work that a file has a known ending and somewhere to go."""
    if path.suffix.lower() not in formats:
        raise complaint(
            f"the name of an output must end in {', '.join(formats)}, got {str(path)!r}",
            "output",
            f"a name that ends in {', '.join(formats)}",
            str(path),
        )
    check_place(path)


def csv_text(columns: Mapping[str, Sequence[Any]]) -> str:
    """A header and a row for each entry, numbers to ten digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow([f"{value:.10g}" if isinstance(value, float) else value for value in row])
    return text.getvalue()


def write(path: Path, columns: Mapping[str, Sequence[Any]], facts: Mapping[str, Any]) -> None:
    """The columns as .csv; facts and columns as .json."""
    lists = {name: _plain(values) for name, values in columns.items()}
    if path.suffix.lower() == ".csv":
        text = csv_text(lists)
    else:
        text = json.dumps({**facts, **lists}, indent=2, ensure_ascii=False) + "\n"
    write_whole(path, text.encode("utf-8"))


def _plain(values: Any) -> list[Any]:
    return list(values.tolist() if hasattr(values, "tolist") else values)
