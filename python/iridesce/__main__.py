"""``python -m iridesce`` is the command line."""

from __future__ import annotations

from iridesce.cli import main

if __name__ == "__main__":
    main()
