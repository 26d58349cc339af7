"""The command line: exit codes, errors and Ctrl-C. What the verbs do is in ``commands``.

Only the standard library is imported here at first, so that Ctrl-C is answered from the first moment on.
"""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable
from typing import ParamSpec

DONE = 0
FAILED = 1
WRONG_USAGE = 2
BAD_INPUT = 3
RESOURCE_LIMIT = 4
INTERRUPTED = 130

P = ParamSpec("P")


def main() -> None:
    """Run the command line and leave with its exit code.

    Returns
        Nothing: the process ends.

    Raises
        SystemExit: always; 0 done, 1 failed, 2 wrong usage, 3 bad input, 4 resource limit, 130 interrupted.
    """
    try:
        from iridesce.cli.commands import app
        from iridesce.cli.verbs import animate, chart, exchange, fit, flow, media  # noqa: F401  (they add verbs)

        app(prog_name="iridesce")
    except KeyboardInterrupt:
        sys.exit(_say("interrupted", INTERRUPTED, label="note"))


def answers_errors(verb: Callable[P, None]) -> Callable[P, None]:
    """Make a verb leave with the exit code and the one-line message that its error calls for.

    Returns
        The same verb; instead of an error it raises ``SystemExit``.

    Raises
        Nothing.
    """

    @functools.wraps(verb)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        import warnings

        warnings.showwarning = _show_warning
        try:
            verb(*args, **kwargs)
            sys.stdout.flush()
        except BrokenPipeError:
            # The reader of our output (`| head`) has gone: stop quietly, and keep Python from complaining at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            sys.exit(FAILED)
        except KeyboardInterrupt:
            sys.exit(_say("interrupted; files that were there before are as they were", INTERRUPTED, label="note"))
        except Exception as error:
            code = _exit_code(error)
            if code is None:
                raise
            sys.exit(_say(_message(error), code))
        except BaseException as error:
            # A panic of the core derives from BaseException; it is our fault, yet no reason to show a stack of frames.
            if type(error).__name__ != "PanicException" or os.environ.get("IRIDESCE_DEBUG"):
                raise
            sys.exit(_say(_message(error), FAILED))

    return run


def _exit_code(error: Exception) -> int | None:
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


def _message(error: BaseException) -> str:
    if isinstance(error, MemoryError) and not str(error):
        return "out of memory"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    if isinstance(error, ValueError | OSError | MemoryError | OverflowError):
        return str(error)
    name = type(error).__name__
    return f"{name}: {error} (this is a fault of iridesce; IRIDESCE_DEBUG=1 shows where, please report it)"


def _show_warning(message: Warning | str, *_args: object, **_kwargs: object) -> None:
    _say(str(message), DONE, label="note")


def _say(message: str, code: int, label: str = "error") -> int:
    """Write a one-line note or error to stderr and hand the exit code through."""
    color = {"error": "31", "note": "33"}[label]
    if sys.stderr.isatty() and not os.environ.get("NO_COLOR"):
        label = f"\x1b[{color}m{label}\x1b[0m"
    print(f"{label}: {message}", file=sys.stderr, flush=True)
    return code
