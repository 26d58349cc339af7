"""The command line (``iridesce.cli:main``)."""

from __future__ import annotations

from iridesce.cli.entry import main

__all__ = ["main"]
