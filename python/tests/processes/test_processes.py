"""Fork, spawn, threads, asyncio and interpreters that end: every call that uses threads answers alike in each."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import iridesce as ir
from processes.entries import ENTRIES, WITHOUT

HERE = Path(__file__).parent

# Runs entries in the way that `how` names and prints a digest of each. An entry that hangs is ended by an alarm, whose default
# action ends the process, so that the test sees which one it was.
PROGRAM = """
import asyncio, concurrent.futures, hashlib, json, os, signal, sys
from processes.entries import ENTRIES
how, names = sys.argv[1], sys.argv[2:]

def one(name):
    return hashlib.sha256(ENTRIES[name]()).hexdigest()

def told(name, digest):
    print(json.dumps([name, digest]), flush=True)

def all_here():
    for name in names:
        signal.alarm(60)
        told(name, one(name))
    signal.alarm(0)

async def gathered():
    loop = asyncio.get_running_loop()
    ticks = 0
    async def tick():
        nonlocal ticks
        while True:
            await asyncio.sleep(0.001)
            ticks += 1
    ticking = asyncio.create_task(tick())
    for name in names:
        told(name, await asyncio.to_thread(one, name))
    ticking.cancel()
    assert ticks > len(names), ticks

if __name__ == "__main__":
    if how == "here":
        all_here()
    elif how == "fork":
        for name in names:
            one(name)  # so that the parent has its threads
        child = os.fork()
        if child == 0:
            all_here()
            sys.stdout.flush()
            os._exit(0)
        _, status = os.waitpid(child, 0)
        sys.exit(os.waitstatus_to_exitcode(status))
    elif how in ("fork pool", "spawn pool"):
        import multiprocessing
        if how == "fork pool":
            for name in names:
                one(name)
        with multiprocessing.get_context(how.split()[0]).Pool(2) as pool:
            for name, digest in zip(names, pool.map_async(one, names).get(timeout=240)):
                told(name, digest)
    elif how == "threads":
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            for name, digest in zip(names, pool.map(one, names)):
                told(name, digest)
    elif how == "asyncio":
        asyncio.run(gathered())
"""


def environment(**more: str) -> dict[str, str]:
    paths = [str(HERE.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "PYTHONWARNINGS": "ignore", **more}


def digests(how: str, script: Path, **more: str) -> dict[str, str]:
    """What each entry answers, run in that way."""
    script.write_text(PROGRAM)
    command = [sys.executable, str(script), how, *ENTRIES]
    finished = subprocess.run(
        command, env=environment(**more), capture_output=True, text=True, timeout=600, check=False
    )
    found = dict(json.loads(line) for line in finished.stdout.splitlines())
    missing = [name for name in ENTRIES if name not in found]
    assert not missing and finished.returncode == 0, (how, missing, finished.returncode, finished.stderr[-2000:])
    return found


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return digests("here", tmp_path_factory.mktemp("here") / "program.py")


def test_every_public_name_is_an_entry_or_uses_no_threads() -> None:
    entries = {name.replace(",", " ").replace(".", " ").split()[0] for name in ENTRIES}
    assert entries | set(WITHOUT) == set(ir.__all__) and not entries & set(WITHOUT)


@pytest.mark.parametrize("how", ["fork", "fork pool", "spawn pool", "threads", "asyncio"])
def test_every_entry_answers_alike(here: dict[str, str], how: str, tmp_path: Path) -> None:
    assert digests(how, tmp_path / "program.py") == here


def test_one_thread_answers_alike_and_is_honoured(here: dict[str, str], tmp_path: Path) -> None:
    assert digests("here", tmp_path / "program.py", RAYON_NUM_THREADS="1") == here
    for count in ("1", "3"):
        question = "from iridesce import _core; print(_core.threads())"
        command = [sys.executable, "-c", question]
        env = environment(RAYON_NUM_THREADS=count)
        assert subprocess.run(command, env=env, capture_output=True, text=True, check=True).stdout.strip() == count


def test_a_call_does_not_wait_for_that_of_another_thread() -> None:
    program = """
import threading, time
import iridesce as ir
film = ir.Stack(["air", ir.Layer("soap", thickness_nm=[300.0 + i / 100 for i in range(20_000)]), "air"])
film.color()
start = time.perf_counter()
film.color()
alone = time.perf_counter() - start
stop = threading.Event()
def tell(done, total):
    if stop.is_set():
        raise InterruptedError
def long():
    try:
        ir.render("soap-bubble", samples=4096, size=(512, 512), progress=tell)
    except InterruptedError:
        pass
other = threading.Thread(target=long)
other.start()
time.sleep(0.5)
start = time.perf_counter()
film.color()
beside = time.perf_counter() - start
stop.set()
other.join()
print(alone, beside)
assert beside < 20 * alone + 2, (alone, beside)
"""
    finished = subprocess.run(
        [sys.executable, "-c", program], env=environment(), capture_output=True, text=True, timeout=120, check=False
    )
    assert finished.returncode == 0, finished.stderr


@pytest.mark.parametrize("ending", ["returns", "raises", "exits"])
def test_an_interpreter_may_end_while_work_runs(ending: str) -> None:
    how = {"returns": "", "raises": "raise LookupError('on purpose')", "exits": "raise SystemExit(7)"}[ending]
    program = f"""
import threading, time
import iridesce as ir
told = threading.Event()
def work():
    ir.render("soap-bubble", samples=4096, size=(512, 512), progress=lambda *_: told.set())
for _ in range(2):
    threading.Thread(target=work, daemon=True).start()
told.wait()
{how}
"""
    finished = subprocess.run(
        [sys.executable, "-c", program], env=environment(), capture_output=True, text=True, timeout=60, check=False
    )
    assert finished.returncode == {"returns": 0, "raises": 1, "exits": 7}[ending], (
        finished.returncode,
        finished.stderr,
    )
    assert "panicked" not in finished.stderr
    assert ("LookupError" in finished.stderr) == (ending == "raises")


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_during_the_first_call_of_a_process_is_a_keyboard_interrupt() -> None:
    # The import of numpy inside the first import of the core is hit, too: the signal comes at many moments.
    program = """
import os, signal, sys, threading, time
delay = float(sys.argv[1])
threading.Thread(target=lambda: (time.sleep(delay), os.kill(os.getpid(), signal.SIGINT)), daemon=True).start()
import iridesce as ir
ir.Stack(["air", ir.Layer("soap", thickness_nm=[float(i) for i in range(20_000)]), "air"]).color()
while True:
    time.sleep(1)
"""
    for step in range(8):
        command = [sys.executable, "-c", program, str(0.02 + 0.06 * step)]
        finished = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=60, check=False)
        assert finished.returncode in (1, -signal.SIGINT), (step, finished.returncode, finished.stderr)
        assert "KeyboardInterrupt" in finished.stderr and "Panic" not in finished.stderr, (step, finished.stderr)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(
    "start",
    [
        ["-c", "import iridesce as ir; ir.Stack"],
        ["-c", "from iridesce import color"],
        ["-c", "import iridesce.image"],
        ["-c", "from iridesce.optics.medium import Medium"],
        ["-c", "import pickle; pickle.loads(b'ciridesce.medium\\nMedium\\n.')"],
        ["-c", "from iridesce.cli.entry import main; main()", "color", "air / soap 320 / air"],
    ],
    ids=["name", "module", "file", "file of a package", "old name", "verb"],
)
@pytest.mark.parametrize("pressed", [True, False])
def test_ctrl_c_that_an_import_makes_an_error_of_is_a_keyboard_interrupt(
    start: list[str], pressed: bool, tmp_path: Path
) -> None:
    # As numpy does where Ctrl-C comes during its look-up of `datetime`: whoever looks at the error alone cannot know.
    raised = "signal.raise_signal(signal.SIGINT)" if pressed else "raise KeyError"
    lines = f"""
import signal
try:
    {raised}
except (KeyboardInterrupt, KeyError):
    raise ImportError("PyCapsule_Import could not import module 'datetime'") from None
"""
    (tmp_path / "numpy.py").write_text(lines)
    paths = environment(PYTHONPATH=os.pathsep.join([str(tmp_path), environment()["PYTHONPATH"]]))
    finished = subprocess.run(
        [sys.executable, *start], env=paths, capture_output=True, text=True, timeout=60, check=False
    )
    last = finished.stderr.strip().splitlines()[-1]
    if not pressed:
        assert finished.returncode in (1, 3) and "could not import module 'datetime'" in last, finished.stderr
    elif start[-1].startswith("air"):
        assert finished.returncode == 130 and last.startswith("note: interrupted"), finished.stderr
    else:
        assert finished.returncode in (1, -signal.SIGINT) and last == "KeyboardInterrupt", finished.stderr
