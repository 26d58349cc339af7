"""Exit codes, in one table: which error gives which, and the line that tells of it."""

from __future__ import annotations

import os

DONE = 0
FAILED = 1
WRONG_USAGE = 2
BAD_INPUT = 3
RESOURCE_LIMIT = 4
INTERRUPTED = 130

MEANING = {
    DONE: "done",
    FAILED: "failed",
    WRONG_USAGE: "wrong usage",
    BAD_INPUT: "bad input",
    RESOURCE_LIMIT: "resource limit",
    INTERRUPTED: "interrupted",
}


def exit_code(error: Exception) -> int | None:
    """The exit code for an error, ``None`` for one that is the command-line library's own business."""
    from iridesce.errors import ResourceError

    if isinstance(error, ResourceError | MemoryError):
        return RESOURCE_LIMIT
    if isinstance(error, ValueError | OverflowError):
        return BAD_INPUT
    if isinstance(error, OSError):
        return FAILED
    if type(error).__module__.split(".")[0] in {"typer", "click"}:
        return None
    return None if os.environ.get("IRIDESCE_DEBUG") else FAILED


def message(error: BaseException) -> str:
    """One line for an error."""
    if isinstance(error, MemoryError) and not str(error):
        return "out of memory"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    if isinstance(error, ValueError | OSError | MemoryError | OverflowError):
        return str(error)
    name = type(error).__name__
    return f"{name}: {error} (this is a fault of iridesce; IRIDESCE_DEBUG=1 shows where, please report it)"
