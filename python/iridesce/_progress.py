"""A bar for long work. Internal."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator


@contextlib.contextmanager
def progress_bar(what: str, counted: bool = False) -> Iterator[Callable[[float, float], None]]:
    """A bar with the time left, on stderr, from the first news on; rich draws none where that is no terminal.

    counted  tell how many of how many, not the share
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TaskID,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    share = MofNCompleteColumn() if counted else TaskProgressColumn()
    columns = (TextColumn(what), BarColumn(), share, TextColumn("left"), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        tasks: list[TaskID] = []

        def advance(done: float, total: float) -> None:
            if not tasks:
                tasks.append(bar.add_task(what, total=total))
            bar.update(tasks[0], completed=done, total=total)

        yield advance
