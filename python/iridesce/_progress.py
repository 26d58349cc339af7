"""How long work is told about: bars on a terminal or in a notebook, a caller's own function. Internal."""

from __future__ import annotations

import contextlib
import inspect
import sys
import time
from collections.abc import Callable, Iterator
from html import escape
from typing import Any

from iridesce.arguments.refusals import refusal

# What a caller may give as `progress`: a function of (done, total), or of (done, total, stage=...).
Told = Callable[..., object] | bool | None
# What `_core` calls: done, total, stage.
Tell = Callable[[int, int, str], object]

# Stages of the core, in words for a bar.
_WORDS = {"reading": "reading maps", "flowing": "the film flows"}


def check_progress(progress: object) -> None:
    """``ValueError`` for what cannot be told anything."""
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise refusal("progress", "a function of (done, total) or (done, total, stage), True, False or None", progress)


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
    """A bar with the time left, from the first news on: in a notebook below its cell, else on stderr where that is a terminal.

    counted  tell how many of how many, not the share
    Yields   a function of done, total and, where there are several stages, words for the one at hand
    """
    show = _notebook_display()
    with _notebook_bar(what, counted, show) if show is not None else _terminal_bar(what, counted) as advance:
        yield advance


@contextlib.contextmanager
def _terminal_bar(what: str, counted: bool) -> Iterator[Callable[..., None]]:
    # Where nobody looks, work that is over at its first news needs no bar: importing `rich.progress` takes longer than a small
    # picture.
    with contextlib.ExitStack() as shown:
        bars: list[_Bar] = []

        def advance(done: float, total: float, words: str = what) -> None:
            if not bars:
                if not _can_be_written(sys.stderr) or (done >= total and not _is_terminal(sys.stderr)):
                    return
                bars.append(_Bar(shown, counted))
            bars[0].advance(done, total, words)

        yield advance


def _can_be_written(stream: Any) -> bool:
    """A program without a console (pythonw) has no stderr, and some close theirs: who does wants no bar, and no error."""
    return stream is not None and not getattr(stream, "closed", False)


def _is_terminal(stream: Any) -> bool:
    """Streams that take the place of stderr need not know the question."""
    return bool(getattr(stream, "isatty", bool)())


class _Bar:
    """One bar of `rich` on stderr, until the stack that it is put on ends."""

    def __init__(self, shown: contextlib.ExitStack, counted: bool) -> None:
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
        bar = Progress(*columns, console=console, transient=True, disable=not console.is_terminal)
        self._bar = shown.enter_context(bar)
        self._tasks: dict[str, TaskID] = {}

    def advance(self, done: float, total: float, words: str) -> None:
        if words not in self._tasks:
            # A stage ends where the next one begins.
            while self._tasks:
                self._bar.remove_task(self._tasks.popitem()[1])
            self._tasks[words] = self._bar.add_task(words, total=total)
        self._bar.update(self._tasks[words], completed=done, total=total)


def _notebook_display() -> Callable[..., Any] | None:
    """What shows things below the cell of a notebook that runs this; None elsewhere."""
    shell = sys.modules.get("IPython")
    running = shell.get_ipython() if shell is not None else None
    if running is None or not hasattr(running, "kernel"):
        return None
    from IPython.display import display

    return display


@contextlib.contextmanager
def _notebook_bar(what: str, counted: bool, display: Callable[..., Any]) -> Iterator[Callable[..., None]]:
    start = time.monotonic()
    handles: list[Any] = []

    def advance(done: float, total: float, words: str = what) -> None:
        bar = _Html(_bar_html(words, done, total, counted, time.monotonic() - start))
        if handles:
            handles[0].update(bar)
        else:
            handles.append(display(bar, display_id=True))

    try:
        yield advance
    finally:
        for handle in handles:
            handle.update(_Html(""))


class _Html:
    def __init__(self, html: str) -> None:
        self._html = html

    def _repr_html_(self) -> str:
        return self._html

    def __repr__(self) -> str:
        return ""


def _bar_html(what: str, done: float, total: float, counted: bool, seconds: float) -> str:
    share = min(done / total, 1.0) if total > 0 else 0.0
    told = f"{done:g} of {total:g}" if counted else f"{share:.0%}"
    left = ""
    if share > 0.0 and seconds > 1.0:
        remaining = round(seconds * (1.0 - share) / share)
        left = f", {remaining // 60}:{remaining % 60:02d} left"
    return (
        f'<div>{escape(what)} <progress value="{share:.4f}" max="1" style="width:40%;vertical-align:middle"></progress>'
        f" {told}{left}</div>"
    )
