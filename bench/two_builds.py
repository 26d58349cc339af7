"""The jobs of `optics.py` in two builds of iridesce, in turn, by processor time.

usage: two_builds.py PYTHON PYTHON [--rounds N] [--jobs NAME,..]

Each PYTHON is an interpreter of an environment with a build installed: the first is the one before. Both run side by side on
one thread each, and every round asks one after the other, in changing order. Processor time does not count what other programs
take; of all rounds the fastest, the quarter and the median are compared, since another job on the same core can only make a
round longer. Shown are milliseconds of the first and ratios of the second to the first: above 1 it is slower.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

FIRST_ROUNDS = 2  # warm caches, and are not counted


def answer() -> None:
    """One build: names its jobs, then does each job that is asked for."""
    import iridesce as ir
    import optics

    film = ir.Stack([1.0, ir.Layer(optics.N_FILM, [0.0, 2000.0]), 1.0])

    def build() -> ir.ColorTable:
        return ir.ColorTable(film, (0.0, 2000.0), (0.0, 80.0))

    jobs = {
        "film": optics.film_ours(1)[0],
        "layers": optics.layers_ours(1)[0],
        "colors": optics.color_ours(1)[0],
        "table": optics.table_ours(build(), 1)[0],
        "table-built": build,
    }
    print(json.dumps(list(jobs)), flush=True)
    for line in sys.stdin:
        begun = time.process_time()
        jobs[line.strip()]()
        print(time.process_time() - begun, flush=True)


class Build:
    def __init__(self, python: str) -> None:
        self.process = subprocess.Popen(
            [python, __file__, "--answer"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"RAYON_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
        self.jobs: list[str] = json.loads(self._line())

    def _line(self) -> str:
        line = self.process.stdout.readline() if self.process.stdout else ""
        if not line:
            raise SystemExit("two_builds.py: a build ended early; its words are above")
        return line

    def ask(self, job: str) -> float:
        if self.process.stdin is not None:
            self.process.stdin.write(job + "\n")
            self.process.stdin.flush()
        return float(self._line())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pythons", nargs="*")
    parser.add_argument("--rounds", type=int, default=80)
    parser.add_argument("--jobs")
    parser.add_argument("--answer", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.answer:
        answer()
        return
    if len(options.pythons) != 2 or options.rounds <= FIRST_ROUNDS:
        parser.error(f"two interpreters are compared, in more than {FIRST_ROUNDS} rounds")
    builds = [Build(str(Path(python).absolute())) for python in options.pythons]
    jobs = options.jobs.split(",") if options.jobs else builds[0].jobs
    seconds: dict[str, list[list[float]]] = {job: [[], []] for job in jobs}
    for number in range(options.rounds):
        for job in jobs:
            for which in (0, 1) if number % 2 == 0 else (1, 0):
                seconds[job][which].append(builds[which].ask(job))
    print(f"load {os.getloadavg()[0]:.1f}, {options.rounds} rounds\n")
    print("| job | before, ms | fastest | quarter | median |\n|---|---|---|---|---|")
    for job in jobs:
        before, after = (sorted(times[FIRST_ROUNDS:]) for times in seconds[job])
        quarter = len(before) // 4
        middle = statistics.median(before)
        ratios = (after[0] / before[0], after[quarter] / before[quarter], statistics.median(after) / middle)
        print(f"| {job} | {1e3 * middle:.2f} | " + " | ".join(f"{ratio:.3f}" for ratio in ratios) + " |")


if __name__ == "__main__":
    main()
