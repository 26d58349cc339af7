"""Modules by the names they once had, so that programs and pickles of before go on working.

A finder at the end of ``sys.meta_path``, asked only for what no file answers, gives the module at its new place: the
same object, so that its classes are the same classes.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType

MOVED = {
    "iridesce.color_table": "iridesce.color.color_table",
    "iridesce.fit": "iridesce.inverse.fit",
    "iridesce.medium": "iridesce.optics.medium",
    # Private, but named in pickles of their values.
    "iridesce._averages": "iridesce.optics.averages",
    "iridesce._database": "iridesce.optics.database",
    "iridesce._derivatives": "iridesce.color.derivatives",
    "iridesce._fields": "iridesce.optics.fields",
    "iridesce._fit_solve": "iridesce.inverse.solve",
    "iridesce._flow": "iridesce.thickness.simulation",
    "iridesce._spectrum_file": "iridesce.files.spectra",
    "iridesce._thickness_map": "iridesce.thickness.thickness_map",
}


class _Finder:
    """Finds a moved module and loads what stands at its new place."""

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(name, self, origin=MOVED[name]) if name in MOVED else None  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = importlib.import_module(MOVED[spec.name])
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        # The import system has just put the old name's spec in; the module has run already, under its own.
        assert module.__spec__ is not None
        module.__spec__ = module.__spec__.loader_state


def keep_old_names() -> None:
    """Let the old names be imported; once a process."""
    sys.meta_path.append(_Finder())
