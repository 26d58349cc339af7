"""Mutates seeds of every reader, in processes with limits on memory and time, and tells what went wrong.

    python tools/fuzz                        every reader, 10 000 inputs each
    python tools/fuzz spectrum -n 100000     one of them, as long as you like
    python tools/fuzz --list

Input number N of a reader is always the same: a finding is repeated by ``python tools/fuzz READER --first N -n 1``.
A reader may answer, or refuse in words (`ValueError`, `OSError`); anything else is a finding: another exception, a panic, a
signal, more than a second, more than 512 MiB, words that are empty, raw or longer than a screen. Findings are kept as files.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from mutate import mutated
from seeds import READERS, Reader

SLOW_S = 1.0
KILL_S = 20.0
MOST_MEMORY_MIB = 512
# What a worker may have in all: a refusal of memory must be an answer, not an abort.
ADDRESS_SPACE = 6 << 30
LONGEST_MESSAGE = 2000


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reader", nargs="*", help="readers to fuzz; all if none is named")
    parser.add_argument("-n", type=int, default=10_000, metavar="N", help="inputs for each reader")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first input")
    parser.add_argument("--findings", type=Path, default=Path("fuzz-findings"), help="folder for what is found")
    parser.add_argument("--json", action="store_true", help="the table as JSON")
    parser.add_argument("--list", action="store_true", help="name the readers")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.list:
        print("\n".join(READERS))
        return 0
    names = arguments.reader or list(READERS)
    unknown = [name for name in names if name not in READERS]
    if unknown:
        parser.error(f"no reader is called {unknown[0]!r}; there are {', '.join(READERS)}")
    if arguments.worker:
        work(READERS[names[0]], arguments.first, arguments.n)
        return 0
    rows = [fuzz(name, arguments.first, arguments.n, arguments.findings) for name in names]
    if arguments.json:
        print(json.dumps(rows, indent=1))
    else:
        print(table(rows))
    return 1 if any(row["findings"] for row in rows) else 0


def work(reader: Reader, first: int, count: int) -> None:
    """In a process of its own: one line of JSON for each input, begun before it is read and ended after."""
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    with tempfile.TemporaryDirectory() as folder:
        seeds = reader.seeds(Path(folder))
        # The first call loads modules; its memory is not the input's.
        for seed in seeds:
            answer(reader, seed, Path(folder))
        for number in range(first, first + count):
            content = mutated(seeds, f"{reader.name}:{number}", reader.is_text)
            print(json.dumps({"begin": number}), flush=True)
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            began, worked = time.perf_counter(), time.process_time()
            kind, words = answer(reader, content, Path(folder))
            # Other work on the machine stretches the one, several threads the other. (What waits for ever is killed.)
            took = min(time.perf_counter() - began, time.process_time() - worked)
            grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
            print(json.dumps({"end": number, "kind": kind, "words": words, "s": took, "mib": grown}), flush=True)


def answer(reader: Reader, content: bytes, folder: Path) -> tuple[str, str]:
    """Whether the reader took the input, refused it in words, or did what it must not do."""
    try:
        reader.read(content, folder)
    except (ValueError, OSError) as error:
        words = str(error)
        # (Python's own words, and those of its JSON and TOML readers, are none for a stranger.)
        if not words:
            return "unclear", f"{type(error).__name__} without words"
        # A scene tells all its errors, a line each.
        longest = max(words.splitlines(), key=len)
        if len(longest) > LONGEST_MESSAGE:
            return "unclear", f"{len(longest)} letters in a line: {longest[:200]}"
        if any(not letter.isprintable() and letter != "\n" for letter in words):
            return "unclear", f"raw: {words[:200]!r}"
        if isinstance(error, UnicodeError) or "fault of iridesce" in words or "Traceback" in words:
            return "unclear", f"{type(error).__name__}: {words[:200]}"
        return "refused", ""
    except MemoryError as error:
        return "refused" if str(error) else "MemoryError", str(error)[:200]
    except BaseException as error:
        return type(error).__name__, str(error)[:200]
    return "read", ""


def fuzz(name: str, first: int, count: int, folder: Path) -> dict[str, object]:
    """Workers, one after another, until all inputs are through."""
    tally: Counter[str] = Counter()
    findings: list[dict[str, object]] = []
    slowest, largest, panics = 0.0, 0.0, 0
    number, last = first, first + count
    began = time.perf_counter()

    def found(number: int, kind: str, words: str) -> None:
        findings.append({"input": number, "kind": kind, "words": words})
        folder.mkdir(parents=True, exist_ok=True)
        reader = READERS[name]
        with tempfile.TemporaryDirectory() as place:
            content = mutated(reader.seeds(Path(place)), f"{name}:{number}", reader.is_text)
        (folder / f"{name}-{number}.bin").write_bytes(content)

    while number < last:
        for event in worker(name, number, last - number):
            if "begin" in event:
                number = int(event["begin"])  # type: ignore[call-overload]
                continue
            if "end" in event:
                tally[str(event["kind"])] += 1
                slowest, largest = max(slowest, float(event["s"])), max(largest, float(event["mib"]))  # type: ignore[arg-type]
                if event["kind"] not in ("read", "refused"):
                    found(number, str(event["kind"]), str(event["words"]))
                elif float(event["s"]) > SLOW_S:  # type: ignore[arg-type]
                    found(number, "slow", f"{event['s']:.2f} s")
                elif float(event["mib"]) > MOST_MEMORY_MIB:  # type: ignore[arg-type]
                    found(number, "memory", f"{event['mib']:.0f} MiB")
                number += 1
                continue
            panics += str(event["stderr"]).count("panicked at")
            if event["died"]:
                tally["died"] += 1
                found(number, str(event["died"]), str(event["stderr"])[-200:])
                number += 1
    seconds = time.perf_counter() - began
    kinds = Counter(str(one["kind"]) for one in findings)
    return {
        "reader": name,
        "inputs": count,
        "read": tally["read"],
        "refused": tally["refused"],
        "findings": dict(kinds),
        "caught_panics": panics,
        "slowest_s": round(slowest, 3),
        "largest_mib": round(largest, 1),
        "seconds": round(seconds, 1),
        "examples": findings[:5],
    }


def worker(name: str, first: int, count: int) -> Iterator[dict[str, object]]:
    """What a worker tells; at the end its stderr, and how it died if it did."""
    command = [sys.executable, str(Path(__file__).parent), name, "--worker", "--first", str(first), "-n", str(count)]
    with tempfile.TemporaryFile("w+", errors="replace") as errors:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True)
        assert process.stdout is not None
        hung, waited, spent = False, 0, 0.0

        def too_long(*_: object) -> None:
            # A machine with other work, or one that slept, is no hang: time counts that the worker has used; who waits for
            # something that never comes uses none, and is given five times as long.
            nonlocal hung, waited
            waited += 1
            if waited < 5 and processor_s(process.pid) - spent < KILL_S / 2:
                signal.setitimer(signal.ITIMER_REAL, KILL_S)
                return
            hung = True
            process.kill()

        old = signal.signal(signal.SIGALRM, too_long)
        done = 0
        try:
            # (The first input waits for the modules to be loaded.)
            signal.setitimer(signal.ITIMER_REAL, KILL_S + 60.0)
            for line in process.stdout:
                signal.setitimer(signal.ITIMER_REAL, KILL_S)
                waited, spent = 0, processor_s(process.pid)
                event = json.loads(line)
                done += "end" in event
                yield event
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, old)
            if process.poll() is None and done < count and not hung:
                process.wait()
            process.wait()
        errors.seek(0)
        died = "" if done == count else "hang" if hung else f"exit code {process.returncode}"
        yield {"stderr": errors.read()[-100_000:], "died": died}


def processor_s(pid: int) -> float:
    """Processor time that a process has used; infinite where the system does not tell."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return math.inf
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def table(rows: list[dict[str, object]]) -> str:
    heads = ("reader", "inputs", "read", "refused", "caught_panics", "slowest_s", "largest_mib", "seconds", "findings")
    lines = ["  ".join(heads)]
    for row in rows:
        lines.append("  ".join(str(row[head] or 0) for head in heads))
        lines += [f"    {example}" for example in row["examples"]]  # type: ignore[attr-defined]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
