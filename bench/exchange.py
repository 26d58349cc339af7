"""How long `ir.export` takes for each target, and how much it writes: a table in Markdown.

usage: exchange.py [TARGET ...] [--only SUBJECT] [--repeats N]

Wall and processor seconds, imports done, tables made anew each time; medians of N repeats (default 3). A film
is a stack of one layer over 0 to 1200 nm, a slab the same on 1 mm of glass whose back reflects without fringes, a scene
the built-in soap film in its frame, whose film flows.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import iridesce as ir
from iridesce.exchange import lut
from iridesce.exchange.exporting import TARGETS

RANGE_NM = (0.0, 1200.0)
SUBJECTS = {
    "soap film": "air / soap ? / air",
    "TiO2 on Ti": "air / TiO2 ? / Ti",
    "three layers": "air / soap ? / TiO2 100 / SiO2 120 / N-BK7",
    "film on a slab": "air / soap ? / N-BK7 1e6 incoherent / air",
    "scene": "soap-film-frame",
}


def measured(subject: str, target: str, repeats: int) -> tuple[float, float, int, int]:
    """Seconds, processor seconds, bytes and files of one export."""
    vary = RANGE_NM if "/" in subject else None
    walls, works, size, count = [], [], 0, 0
    for _ in range(repeats):
        lut._computed.cache_clear()
        with tempfile.TemporaryDirectory() as folder:
            wall, work = time.perf_counter(), time.process_time()
            report = ir.export(subject, target, Path(folder) / "out", vary=vary)
            walls.append(time.perf_counter() - wall)
            works.append(time.process_time() - work)
            size, count = sum(path.stat().st_size for path in report.files), len(report.files)
    return statistics.median(walls), statistics.median(works), size, count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument("--only", choices=list(SUBJECTS), metavar="SUBJECT", help="; ".join(SUBJECTS))
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    subjects = {name: subject for name, subject in SUBJECTS.items() if options.only in (None, name)}
    for subject in subjects.values():  # whatever is imported late, and the film of the scene
        with tempfile.TemporaryDirectory() as folder:
            ir.export(subject, "gltf", folder, vary=RANGE_NM if "/" in subject else None)
    print("| target |" + "".join(f" {name} |" for name in subjects))
    print("|---|" + "---|" * len(subjects))
    for target in options.targets or TARGETS:
        cells = []
        for subject in subjects.values():
            wall, work, size, count = measured(subject, target, options.repeats)
            cells.append(f" {wall:.2f} s ({work:.2f}), {size / 1000.0:.0f} kB in {count} |")
        print(f"| `{target}` |" + "".join(cells), flush=True)


if __name__ == "__main__":
    main()
