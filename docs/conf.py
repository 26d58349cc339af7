"""The documentation site (`make docs`): the pages of this folder, the names of the package, and the live page.

Sphinx with MyST, the choice of numpy, scipy and matplotlib's own projects; furo for its looks. Warnings are errors.
"""

from __future__ import annotations

import re
from typing import Any

import iridesce

project = "iridesce"
author = "the iridesce authors"
release = iridesce.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary"]
exclude_patterns = ["_build"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = "iridesce"
# The page in one file lies beside the site's own pages.
html_extra_path = ["../python/iridesce/page/iridesce.html"]
autosummary_generate = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"
# Addresses of others are looked at by `make docs-links`, not on every build.
linkcheck_timeout = 20
nitpicky = False


def leave_code_alone(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Docstrings are plain text in columns: the first paragraph is prose, the rest is shown as it stands."""
    end = next((i for i, line in enumerate(lines) if not line.strip()), len(lines))
    head, rest = lines[:end], lines[end:]
    lines[:] = [re.sub(r"(?<!`)`([^`]+)`(?!`)", r"``\1``", line).replace("*", r"\*") for line in head]
    if any(line.strip() for line in rest):
        lines += ["", ".. code-block:: none", "", *("   " + line for line in rest), ""]


def stay_inside(app: Any, docname: str, source: list[str]) -> None:
    """Links to files of the repository outside this folder become their names."""
    source[0] = re.sub(r"\[([^\]]+)\]\((?:\.\./)+(?:scenes|python|bench|tools)/[^)]*\)", r"\1", source[0])


def setup(app: Any) -> None:
    app.connect("autodoc-process-docstring", leave_code_alone)
    app.connect("source-read", stay_inside)
