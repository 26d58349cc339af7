"""A short run of the fuzzer over every reader, and what it does with readers that misbehave."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools" / "fuzz"))

from mutate import mutated
from seeds import READERS

FUZZ = [sys.executable, str(ROOT / "tools" / "fuzz")]


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_no_reader_does_what_it_must_not(name: str, tmp_path: Path) -> None:
    command = [*FUZZ, name, "-n", "120", "--json", "--findings", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    (row,) = json.loads(done.stdout)
    assert row["findings"] == {}, row["examples"]
    assert row["read"] + row["refused"] == 120
    assert done.returncode == 0


def test_the_same_number_is_the_same_input() -> None:
    seeds = [b"nm,n\n400,1.5\n500,1.6\n", b"x" * 100]
    inputs = [mutated(seeds, f"index:{number}", True) for number in range(200)]
    assert inputs == [mutated(seeds, f"index:{number}", True) for number in range(200)]
    assert len(set(inputs)) > 150


@pytest.mark.parametrize(
    ("body", "kind"),
    [
        ("raise TypeError('x')", "TypeError"),
        ("raise ValueError('')", "unclear"),
        ("raise ValueError('\\x1b[31m')", "unclear"),
        ("raise ValueError('x' * 5000)", "unclear"),
        ("os.abort()", "exit code -6"),
        ("end = time.process_time() + 1.5\n    while time.process_time() < end: pass", "slow"),
        ("held.append(b'x' * (600 << 20)); time.sleep(0)", "memory"),
    ],
)
def test_misbehaviour_is_seen(body: str, kind: str, tmp_path: Path) -> None:
    """The same fuzzer, with one reader that does what it must not."""
    tool = tmp_path / "tool"
    tool.mkdir()
    for name in ("__main__.py", "mutate.py"):
        (tool / name).write_bytes((ROOT / "tools" / "fuzz" / name).read_bytes())
    (tool / "seeds.py").write_text(
        "import os, time\n"
        "from typing import NamedTuple, Any\n"
        "class Reader(NamedTuple):\n    name: str\n    seeds: Any\n    read: Any\n    is_text: bool = False\n"
        "held = []\n"
        f"def read(content, folder):\n    if content == b'seed' * 20: return\n    {body}\n"
        "READERS = {'bad': Reader('bad', lambda _: [b'seed' * 20], read)}\n"
    )
    command = [sys.executable, str(tool), "bad", "-n", "2", "--json", "--findings", str(tmp_path / "found")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    (row,) = json.loads(done.stdout)
    assert done.returncode == 1
    assert kind in row["findings"], row
    assert any((tmp_path / "found").iterdir())
