"""How long work is told about: bars on a terminal, a caller's own function. Internal."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Callable, Iterator
from typing import Any

# What a caller may give as `progress`: a function of (done, total), or of (done, total, stage=...).
Told = Callable[..., object] | bool | None
# What `_core` calls: done, total, stage.
Tell = Callable[[int, int, str], object]

# Stages of the core, in words for a bar.
_WORDS = {"reading": "reading maps", "flowing": "the film flows"}


def check_progress(progress: object) -> None:
    """``ValueError`` for what cannot be told anything."""
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise ValueError(
            f"progress must be a function of (done, total) or (done, total, stage), True, False or None, got {progress!r}"
        )


@contextlib.contextmanager
def watched(progress: Told, stage: str, words: str | None = None) -> Iterator[Tell | None]:
    """What `_core` is to call while it works: a bar, the caller's function, or nothing.

    stage  the main stage of the work. A function that takes no ``stage`` hears of this one alone, so that what it is told
           counts one thing; one that does hears of all
    words  what a bar calls that stage
    """
    check_progress(progress)
    if progress is None or progress is False:
        yield None
    elif progress is True:
        with progress_bar(words or stage) as advance:
            yield lambda done, total, now: advance(
                done, total, words or stage if now == stage else _WORDS.get(now, now)
            )
    else:
        yield _told(progress, stage)


def _told(progress: Callable[..., object], stage: str) -> Tell:
    if _takes_stage(progress):
        return lambda done, total, now: progress(done, total, stage=now)
    return lambda done, total, now: progress(done, total) if now == stage else None


def _takes_stage(function: Callable[..., object]) -> bool:
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return False
    return any(p.kind is p.VAR_KEYWORD or (p.name == "stage" and p.kind is not p.POSITIONAL_ONLY) for p in parameters)


@contextlib.contextmanager
def progress_bar(what: str, counted: bool = False) -> Iterator[Callable[..., None]]:
    """A bar with the time left, on stderr, from the first news on; rich draws none where that is no terminal.

    counted  tell how many of how many, not the share
    Yields   a function of done, total and, where there are several stages, words for the one at hand
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
    columns: tuple[Any, ...] = (
        TextColumn("{task.description}"),
        BarColumn(),
        share,
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        tasks: dict[str, TaskID] = {}

        def advance(done: float, total: float, words: str = what) -> None:
            if words not in tasks:
                # A stage ends where the next one begins.
                while tasks:
                    bar.remove_task(tasks.popitem()[1])
                tasks[words] = bar.add_task(words, total=total)
            bar.update(tasks[words], completed=done, total=total)

        yield advance
