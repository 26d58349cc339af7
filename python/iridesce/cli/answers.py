"""Answers of the verbs: values to stdout, notes to stderr, errors as one line and an exit code."""

from __future__ import annotations

import codecs
import contextlib
import functools
import io
import json
import os
import sys
from collections.abc import Callable
from typing import Any, ParamSpec

from iridesce._interrupts import kept_interrupts
from iridesce.cli.exit_codes import DONE, FAILED, INTERRUPTED, exit_code, message

# Letters of a message: a list of all known names fits, a file quoted by the kilobyte does not.
_LONGEST = 2000

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
            with kept_interrupts(answered=True):
                verb(*args, **kwargs)
            sys.stdout.flush()
        except BrokenPipeError as error:
            sys.exit(lost(error))
        except KeyboardInterrupt:
            sys.exit(say("interrupted; files that were there before are as they were", INTERRUPTED, label="note"))
        except Exception as error:
            code = exit_code(error)
            if code is None:
                raise
            sys.exit(say(_words(verb, error), code))
        except BaseException as error:
            # A panic of the core derives from BaseException; it is our fault, yet no reason to show a stack of frames.
            if type(error).__name__ != "PanicException" or os.environ.get("IRIDESCE_DEBUG"):
                raise
            sys.exit(say(message(error), FAILED))

    return run


def _words(verb: Callable[..., None], error: Exception) -> str:
    from iridesce.errors import ArgumentError

    if not isinstance(error, ArgumentError):
        return message(error)
    from iridesce.cli.option_words import in_option_words

    return in_option_words(verb, error)


def _show_warning(message: Warning | str, *_args: object, **_kwargs: object) -> None:
    say(str(message), DONE, label="note")


def say(line: str, code: int, label: str = "error") -> int:
    """Write a one-line note or error to stderr and hand the exit code through."""
    color = {"error": "31", "note": "33"}[label]
    if sys.stderr.isatty() and not os.environ.get("NO_COLOR"):
        label = f"\x1b[{color}m{label}\x1b[0m"
    # Where nobody can read it (stderr is full, or closed), the code says it all.
    with contextlib.suppress(OSError, ValueError):
        print(f"{label}: {_harmless(line)}", file=sys.stderr, flush=True)
    return code


def note(text: str) -> None:
    """What is told beside the answer; that nobody can read it is no reason to fail."""
    with contextlib.suppress(OSError, ValueError):
        print(_harmless(text), file=sys.stderr)


def tell(text: str) -> None:
    """An answer for people. On a terminal that is narrower than a line, the line breaks between words."""
    print(fitted(text, terminal_columns()))


def terminal_columns() -> int | None:
    """How wide the terminal is that shows the answer; None where files and programs read it, which want whole lines."""
    import shutil

    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def fitted(text: str, columns: int | None) -> str:
    """Lines of at most so many letters where words allow it: a path stays in one piece. What goes on is indented."""
    if columns is None or max(map(len, text.splitlines()), default=0) <= columns:
        return text
    import textwrap

    lines: list[str] = []
    for line in text.splitlines():
        indent = " " * (len(line) - len(line.lstrip()) + 2)
        parts = textwrap.wrap(
            line, max(columns, 10), subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
        )
        lines += parts or [""]
    return "\n".join(lines)


def _harmless(line: str) -> str:
    """A line as a terminal may show it: no control characters but line ends, and none of a file's words by the kilobyte."""
    clean = "".join(
        letter if letter.isprintable() or letter == "\n" else letter.encode("unicode_escape").decode("ascii")
        for letter in line[:_LONGEST]
    )
    return clean if len(line) <= _LONGEST else f"{clean}..."


def open_streams() -> None:
    """A stream that the caller closed (``>&-``) becomes one to nowhere: nobody reads it, and no file that is opened later may
    get its number.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is not None:
            continue
        nowhere = os.open(os.devnull, os.O_RDWR)
        if nowhere != number:
            os.dup2(nowhere, number)
            os.close(nowhere)
        setattr(sys, name, os.fdopen(number, "r" if number == 0 else "w"))
    codecs.register_error("iridesce", _as_far_as_possible)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="iridesce")


def _as_far_as_possible(error: UnicodeError) -> tuple[str | bytes, int]:
    """Letters that a terminal's encoding has none for: bytes of a file's name as they are, others as ``\\u2026``."""
    try:
        return codecs.lookup_error("surrogateescape")(error)
    except UnicodeError:
        return codecs.lookup_error("backslashreplace")(error)


def lost(error: OSError) -> int:
    """The exit code where the answer could not be written, said in words but for a pipe whose reader has gone (`| head`).

    What is left of the answer is dropped: Python would complain of it at exit.
    """
    with contextlib.suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, BrokenPipeError):
        return FAILED
    return say(f"the answer could not be written: {error.strerror or error}", FAILED)


def quiet_dask() -> None:
    """What Dask logs of workers and schedulers that die is left out: a verb says it in a sentence."""
    import logging

    with contextlib.suppress(ImportError):
        import distributed  # noqa: F401  (it sets the levels of its loggers when it is imported)
    for name in ["distributed", *logging.root.manager.loggerDict]:
        if name.split(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def print_json(value: Any) -> None:
    """The answer as JSON, for programs."""
    print(json.dumps(value, indent=2, ensure_ascii=False, default=_plain))


def _plain(value: Any) -> Any:
    """numpy's scalars and arrays as plain numbers and lists."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
