"""The jobs of `optics.py`, pictures, films and fits in two builds of iridesce, in turn, by processor time.

usage: two_builds.py PYTHON PYTHON [--rounds N] [--jobs NAME,..] [--bytes]

Each PYTHON is an interpreter of an environment with a build installed: the first is the one before. Both run side by side on
one thread each, and every round asks one after the other, in changing order. Processor time does not count what other programs
take; of all rounds the fastest, the quarter and the median are compared, since another job on the same core can only make a
round longer. Shown are milliseconds of the first and ratios of the second to the first: above 1 it is slower.

``--bytes`` asks instead whether every built-in scene, every film that flows, colours and spectra are the same to the last bit.
"""

from __future__ import annotations

import argparse
import functools
import hashlib
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

DIGESTS = "digests"  # is asked of a build in place of a job
FIRST_ROUNDS = 2  # warm caches, and are not counted
# What a picture of each asks for: one film, flat films of a plate, walls that meet, facets, layers, lenses, bumps.
SCENES = ("soap-bubble", "titanium", "bubble-cluster", "burnt-steel", "beetle", "coated-lens", "wet-asphalt")


def answer() -> None:
    """One build: names its jobs, then does each job that is asked for."""
    import numpy as np

    import iridesce as ir
    import optics

    film = ir.Stack([1.0, ir.Layer(optics.N_FILM, [0.0, 2000.0]), 1.0])

    nm = np.arange(420.0, 760.0, 1.0)
    spectrum = ir.Stack.parse("air / soap 1234 / air").reflectance(nm) + np.random.default_rng(1).normal(
        0.0, 1e-3, nm.size
    )

    def build() -> ir.ColorTable:
        return ir.ColorTable(film, (0.0, 2000.0), (0.0, 80.0))

    jobs = {
        "film": optics.film_ours(1)[0],
        "layers": optics.layers_ours(1)[0],
        "colors": optics.color_ours(1)[0],
        "table": optics.table_ours(build(), 1)[0],
        "table-built": build,
        **{name: functools.partial(ir.render, ir.Scene.load(name), 4, 1, (96, 64), 1) for name in SCENES},
        "flow": lambda: list(ir.thickness.simulate("bubble-on-bath", time_s=0.1, frames_per_second=10)),
        "fit": functools.partial(ir.fit_thickness, nm, spectrum, "air / soap ? / air"),
    }
    print(json.dumps(list(jobs)), flush=True)
    for line in sys.stdin:
        if line.strip() == DIGESTS:
            print_digests()
            continue
        begun = time.process_time()
        jobs[line.strip()]()
        print(time.process_time() - begun, flush=True)


def print_digests() -> None:
    """A digest of all numbers of each small picture, film, chart and spectrum, as one line of JSON."""
    import numpy as np

    import iridesce as ir
    from iridesce.scene import scene_names

    def digest(*arrays: object) -> str:
        return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()

    found = {}
    for name in scene_names():
        image = ir.render(name, samples=2, seed=1, size=(48, 36))
        found[f"scene {name}"] = digest(image.xyz, *(image.channels[plane] for plane in sorted(image.channels)))
    for name in ir.thickness.presets():
        frames = list(ir.thickness.simulate(name, time_s=0.1, frames_per_second=10))
        found[f"film {name}"] = digest(*(frame.thickness_nm for frame in frames))
    nm = np.arange(380.0, 781.0)
    for text in ("air / soap 320 / air", "air / SiO2 100 / TiO2 60 / Si", "air / TiO2 60 / Ti"):
        stack = ir.Stack.parse(text)
        found[f"spectrum {text}"] = digest(stack.reflectance(nm, 30.0), stack.transmittance(nm, 30.0))
        found[f"colour {text}"] = digest(stack.color(angle_deg=np.arange(0.0, 90.0, 5.0)))
    print(json.dumps(found), flush=True)


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
        self._send(job)
        return float(self._line())

    def digests(self) -> dict[str, str]:
        self._send(DIGESTS)
        found: dict[str, str] = json.loads(self._line())
        return found

    def _send(self, job: str) -> None:
        if self.process.stdin is not None:
            self.process.stdin.write(job + "\n")
            self.process.stdin.flush()


def compare_digests(before: dict[str, str], after: dict[str, str]) -> None:
    same = [name for name in before if before[name] == after.get(name)]
    print(f"{len(same)} of {len(before)} the same to the last bit")
    for name in sorted(before.keys() | after.keys()):
        if name not in same:
            print(f"{name}: {'differs' if name in before and name in after else 'in one alone'}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pythons", nargs="*")
    parser.add_argument("--rounds", type=int, default=80)
    parser.add_argument("--jobs")
    parser.add_argument("--bytes", action="store_true")
    parser.add_argument("--answer", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.answer:
        answer()
        return
    if len(options.pythons) != 2 or options.rounds <= FIRST_ROUNDS:
        parser.error(f"two interpreters are compared, in more than {FIRST_ROUNDS} rounds")
    builds = [Build(str(Path(python).absolute())) for python in options.pythons]
    if options.bytes:
        compare_digests(*(build.digests() for build in builds))
        return
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
