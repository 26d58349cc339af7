"""How long Ctrl-C takes: for each long call the worst of some tries, in a script and in the command line.

    python bench/interrupts.py                 # all calls, 20 tries each: some ten minutes
    python bench/interrupts.py --tries 5 render
    python bench/interrupts.py --part 2/5      # every fifth call, from the second on

For each call a process imports the package and prepares what the call needs. Every try of the column `first` is a child of its
own, forked before anything was called: modules, tables and threads are the child's to load and to start. The tries of `again`
follow each other in one child, each after a call that was interrupted. SIGINT comes a random while after the call began; the
time is that until `KeyboardInterrupt` has reached the caller (a script), or until the process has left with exit code 130 (the
command line, with Python's own way out, some 50 ms). Promised: 0.3 s.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from long_calls import CALLS, COMMANDS, READ, large_files

PREPARED = """
import os, signal, sys, time
folder = os.environ["FOLDER"]
import numpy as np
import iridesce as ir
{prepare}

def interrupted():
    try:
        print("began", os.getpid(), flush=True)
        {call}
    except KeyboardInterrupt:
        print("heard", time.monotonic(), flush=True)
        return True
    # (The signal of this try is still to come.)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    print("over", flush=True)
    return False

print("ready", flush=True)
for line in sys.stdin:
    count = int(line)
    if os.fork() == 0:
        try:
            while count and interrupted():
                count -= 1
        finally:
            # (A signal between the end of a call and the line that ignores it.)
            os._exit(0)
    os.wait()
    print("done", flush=True)
"""


class Caller:
    """A process that has prepared a call, and makes it in children."""

    def __init__(self, name: str, folder: Path) -> None:
        prepare, call = CALLS[name]
        self.name = name
        self._process = subprocess.Popen(
            [sys.executable, "-c", PREPARED.format(prepare=prepare, call=call)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**os.environ, "FOLDER": str(folder)},
            text=True,
        )
        self._line("ready")

    def _line(self, *wanted: str) -> list[str]:
        assert self._process.stdout is not None and self._process.stderr is not None
        words = self._process.stdout.readline().split()
        if not words or words[0] not in wanted:
            self._process.kill()
            raise RuntimeError(f"{self.name}: {words} {self._process.stderr.read()}")
        return words

    def tries(self, count: int, chance: random.Random) -> list[float]:
        """Seconds from the signal to KeyboardInterrupt, for each of some tries in one child."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{count}\n")
        self._process.stdin.flush()
        seconds = []
        while (words := self._line("began", "done"))[0] == "began":
            time.sleep(chance.uniform(0.02, 0.5))
            sent = time.monotonic()
            with contextlib.suppress(ProcessLookupError):  # the call, and its process, were over before
                os.kill(int(words[1]), signal.SIGINT)
            heard = self._line("heard", "over", "done")
            if heard[0] == "heard":
                seconds.append(float(heard[1]) - sent)
            elif heard[0] == "done":
                break
        return seconds

    def close(self) -> None:
        self._process.kill()
        self._process.communicate()


def one_command(name: str, folder: Path, delay: float) -> float:
    """Seconds from the signal to the end of the process."""
    command = [sys.executable, "-m", "iridesce", *COMMANDS[name].split()]
    with tempfile.TemporaryDirectory(dir=folder) as place:
        process = subprocess.Popen(command, cwd=place, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(1.0 + delay)
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, told = process.communicate()
        seconds = time.monotonic() - sent
    if process.returncode != 130:
        raise RuntimeError(f"{name}: exit {process.returncode}, {told}")
    return seconds


def column(seconds: list[float]) -> str:
    if not seconds:
        return f"{'over before':>18}"
    return f"{1e3 * max(seconds):7.0f} ({1e3 * statistics.median(seconds):4.0f}) {len(seconds):3}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tries", type=int, default=20)
    parser.add_argument("--part", default="1/1", help="I/N: every N-th call, from the I-th on")
    parser.add_argument("--folder", type=Path, help="where the large files are kept for the next run")
    parser.add_argument("names", nargs="*", help="only calls whose name holds one of these")
    arguments = parser.parse_args()
    chance = random.Random(1)
    first, step = (int(number) for number in arguments.part.split("/"))
    names = [name for name in [*CALLS, *COMMANDS] if any(part in name for part in arguments.names or [""])][
        first - 1 :: step
    ]
    with tempfile.TemporaryDirectory() as place:
        folder = arguments.folder or Path(place)
        folder.mkdir(parents=True, exist_ok=True)
        if any(name.split()[-1] in READ for name in names) and not (folder / "sheet.obj").exists():
            large_files(folder)
        print("worst (median) of tries, in ms")
        print(f"{'call':<32} {'first':>18} {'again':>18}")
        for name in names:
            began = time.monotonic()
            if name in COMMANDS:
                columns = [[one_command(name, folder, chance.uniform(0.0, 0.5)) for _ in range(arguments.tries)]]
            else:
                caller = Caller(name, folder)
                try:
                    columns = [[one for _ in range(arguments.tries) for one in caller.tries(1, chance)]]
                    columns.append(caller.tries(arguments.tries, chance))
                finally:
                    caller.close()
            print(f"{name:<32} {' '.join(map(column, columns))}  [{time.monotonic() - began:.0f} s]", flush=True)


if __name__ == "__main__":
    main()
