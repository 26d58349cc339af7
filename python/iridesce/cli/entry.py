"""The command line from outside: the verbs' table, and Ctrl-C from the first moment on.

Only the standard library is imported here at first. Everything heavy is imported inside the verbs, so that
`iridesce --help` does not pay for it.
"""

from __future__ import annotations

import contextlib
import os
import sys
from typing import TYPE_CHECKING

from iridesce.cli.answers import answers_errors, lost, open_streams, say
from iridesce.cli.exit_codes import DONE, INTERRUPTED, MEANING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from typer import Typer

# In the order of `iridesce --help`. Each is a file in `verbs` (a keyword of Python's has a _ behind it there) with a
# function `verb`, or with a Typer `group` of verbs of its own.
VERBS = (
    *("render", "merge", "scenes", "check", "color", "spectrum", "info"),
    *(
        "sweep",
        "animate",
        "lut",
        "export",
        "validate",
        "import",
        "fit",
        "thickness",
        "calibrate",
        "recipes",
        "flow",
        "media",
        "chart",
        "page",
    ),
)


def main() -> None:
    """Run the command line and leave with its exit code.

    Returns
        Nothing: the process ends.

    Raises
        SystemExit: always; 0 done, 1 failed, 2 wrong usage, 3 bad input, 4 resource limit, 130 interrupted.
    """
    open_streams()
    code: object = DONE
    try:
        application(verbs_asked(sys.argv[1:]))(prog_name="iridesce")
    except SystemExit as leaving:
        code = leaving.code
    except KeyboardInterrupt:
        code = say("interrupted", INTERRUPTED, label="note")
    except OSError as error:
        # (Those of verbs are answered there: this is help, or a list, that could not be written.)
        code = lost(error)
    try:
        sys.stdout.flush()
    except OSError as error:
        code = lost(error)
    with contextlib.suppress(OSError):
        sys.stderr.flush()
    if code == INTERRUPTED:
        # Python remembers that Ctrl-C ended code given as a string (named tuples and data classes are made of such), and
        # `python -m` then dies of the signal, whatever code it is asked for. It forgets when it runs the next string.
        exec("")
    sys.exit(code)  # type: ignore[arg-type]


def verbs_asked(words: Sequence[str]) -> tuple[str, ...]:
    """The verbs that a command line needs: its own, where its first word is one; else all, to list them or to guess.

    Parameters
        words  what stands behind ``iridesce``

    Returns
        Names out of ``VERBS``.

    Raises
        Nothing.

    >>> verbs_asked(["color", "air / soap 320 / air"])
    ('color',)
    """
    # (A shell that completes words asks by the environment, and for any of them.)
    is_completing = "_IRIDESCE_COMPLETE" in os.environ
    return (words[0],) if words and words[0] in VERBS and not is_completing else VERBS


def application(verbs: Sequence[str] = VERBS) -> Typer:
    """Verbs, ready to be called.

    Reading all of them takes 0.15 s of processor time, a third of what a short command takes.

    Parameters
        verbs  which; all of them without it

    Returns
        A Typer application.

    Raises
        Nothing.
    """
    import importlib
    import keyword

    import typer

    app = typer.Typer(
        help="Interference colour: from a film to its spectrum, its colour and its picture.",
        no_args_is_help=True,
        add_completion=True,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
        epilog="Exit codes: " + ", ".join(f"{code} {meaning}" for code, meaning in MEANING.items()) + ".",
    )

    @app.callback(invoke_without_command=True)
    def root(version: bool = typer.Option(False, "--version", help="Print the version and leave.")) -> None:
        """Interference colour: from a film to its spectrum, its colour and its picture."""
        if version:
            from iridesce import __version__

            print(f"iridesce {__version__}")
            raise typer.Exit

    for name in verbs:
        module = importlib.import_module(f"iridesce.cli.verbs.{name}{'_' if keyword.iskeyword(name) else ''}")
        if hasattr(module, "group"):
            app.add_typer(module.group, name=name)
        else:
            app.command(name)(answers_errors(module.verb))
    return app
