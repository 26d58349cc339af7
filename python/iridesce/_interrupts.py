"""Ctrl-C while packages are imported for the first time.

C code that runs during an import may lose a ``KeyboardInterrupt``: numpy's does, where Ctrl-C comes while it looks for
``datetime``, and its import then fails with an ``ImportError`` that names neither. Whether the key was pressed is known
only to whoever hears the signal.
"""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator

__all__ = ["kept_interrupts"]


@contextlib.contextmanager
def kept_interrupts(answered: bool = False) -> Iterator[None]:
    """Ctrl-C within is a ``KeyboardInterrupt``, whatever error the code that it hits makes of it, or none.

    Only Python's own handling of the signal is listened to, and only in the main thread, as no other hears signals.

    Parameters
        answered  whether the code within may answer a ``KeyboardInterrupt`` itself: then only an ``ImportError`` is one

    Returns
        A context.

    Raises
        KeyboardInterrupt: on Ctrl-C, in place of what came of it, which is its cause; what is raised within, otherwise.
    """
    heard = False

    def hear(number: int, frame: object) -> None:
        nonlocal heard
        heard = True
        signal.default_int_handler(number, frame)  # type: ignore[arg-type]

    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    try:
        signal.signal(signal.SIGINT, hear)
    except ValueError:  # not the main thread of the main interpreter
        yield
        return
    try:
        yield
    except Exception as error:
        if heard and (isinstance(error, ImportError) or not answered):
            raise KeyboardInterrupt from error
        raise
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if heard and not answered:
        raise KeyboardInterrupt
