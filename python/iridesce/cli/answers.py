"""Answers of the verbs: values to stdout, notes to stderr, errors as one line and an exit code."""

from __future__ import annotations

import functools
import json
import os
import sys
from collections.abc import Callable
from typing import Any, ParamSpec

from iridesce.cli.exit_codes import DONE, FAILED, INTERRUPTED, exit_code, message

P = ParamSpec("P")


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
            sys.exit(say("interrupted; files that were there before are as they were", INTERRUPTED, label="note"))
        except Exception as error:
            code = exit_code(error)
            if code is None:
                raise
            sys.exit(say(message(error), code))
        except BaseException as error:
            # A panic of the core derives from BaseException; it is our fault, yet no reason to show a stack of frames.
            if type(error).__name__ != "PanicException" or os.environ.get("IRIDESCE_DEBUG"):
                raise
            sys.exit(say(message(error), FAILED))

    return run


def _show_warning(message: Warning | str, *_args: object, **_kwargs: object) -> None:
    say(str(message), DONE, label="note")


def say(line: str, code: int, label: str = "error") -> int:
    """Write a one-line note or error to stderr and hand the exit code through."""
    color = {"error": "31", "note": "33"}[label]
    if sys.stderr.isatty() and not os.environ.get("NO_COLOR"):
        label = f"\x1b[{color}m{label}\x1b[0m"
    print(f"{label}: {line}", file=sys.stderr, flush=True)
    return code


def note(text: str) -> None:
    """What is told beside the answer."""
    print(text, file=sys.stderr)


def print_json(value: Any) -> None:
    """The answer as JSON, for programs."""
    print(json.dumps(value, indent=2, ensure_ascii=False, default=_plain))


def _plain(value: Any) -> Any:
    """numpy's scalars and arrays as plain numbers and lists."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
