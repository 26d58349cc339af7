"""Ctrl-C while packages are imported for the first time, and while others work.

C code that runs during an import may lose a ``KeyboardInterrupt``: numpy's does, where Ctrl-C comes while it looks for
``datetime``, and its import then fails with an ``ImportError`` that names neither. Whether the key was pressed is known
only to whoever hears the signal.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from importlib.machinery import ModuleSpec, SourceFileLoader
from types import ModuleType
from typing import Any, TypeVar

__all__ = ["heard", "keep_in_submodules", "kept_interrupts"]

T = TypeVar("T")


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


class _Loader(SourceFileLoader):
    def exec_module(self, module: ModuleType) -> None:
        with kept_interrupts():
            super().exec_module(module)


class _Finder:
    """Finds modules of a package as all others do, and has them loaded within `kept_interrupts`."""

    def __init__(self, package: str) -> None:
        self._inside = f"{package}."

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if not name.startswith(self._inside):
            return None
        for finder in sys.meta_path:
            find = getattr(finder, "find_spec", None)
            spec: ModuleSpec | None = None if find is None or finder is self else find(name, path, target)
            if spec is not None:
                if type(spec.loader) is SourceFileLoader:
                    spec.loader = _Loader(spec.loader.name, spec.loader.path)
                return spec
        return None


def keep_in_submodules(package: str) -> None:
    """Any module of a package may be the first that a program imports, and so the one that imports numpy."""
    sys.meta_path.insert(0, _Finder(package))


def heard(function: Callable[..., T], *arguments: Any) -> T:
    """What a function of another package answers that may work for seconds without Python's lock, such as a decomposition: Ctrl-C
    is heard meanwhile. The work itself cannot be stopped; it ends in its own time, and nobody waits for it.
    """
    answers: list[T] = []
    errors: list[BaseException] = []

    def work() -> None:
        try:
            answers.append(function(*arguments))
        except BaseException as error:
            errors.append(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(0.03)
    if errors:
        raise errors[0]
    return answers[0]
