"""Exchange: the look of a film in other programs, charts that tell which program is right, and the way in.

Names load on first use, as those of the package itself.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from iridesce.exchange.exporting import export as export
    from iridesce.exchange.importing import import_scene as import_scene
    from iridesce.exchange.report import ExportReport as ExportReport
    from iridesce.exchange.validating import ValidationReport as ValidationReport
    from iridesce.exchange.validating import validate as validate

# No module bears the name of a function: importing it would put the module in the function's place.
_HOME = {
    "export": "exporting",
    "import_scene": "importing",
    "ExportReport": "report",
    "ValidationReport": "validating",
    "validate": "validating",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'iridesce.exchange' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"iridesce.exchange.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
