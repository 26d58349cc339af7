"""What all Python tests share."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

import command_line

ROOT = Path(__file__).resolve().parents[2]

# Where a shell has put them into the background (`make test &`) Ctrl-C is ignored, and so it would be by all that they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Modules beside the tests are tools of theirs: looked into for doctests, scripts of other programs would be run."""
    is_module = collection_path.suffix == ".py" and ROOT / "python" / "tests" in collection_path.parents
    return True if is_module and not collection_path.name.startswith(("test_", "conftest")) else None


Run = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository's root."""
    return ROOT


@pytest.fixture
def iridesce(tmp_path: Path) -> Run:
    """Run the command line in a temporary folder: ``iridesce("color", "air / soap 320 / air").stdout``.

    It is a process of its own, as for a user, so exit codes, both streams and the absence of a traceback are the real ones.
    With an environment it is a new interpreter too.
    """

    def run(*arguments: str, cwd: Path = tmp_path, env: dict[str, str] | None = None, timeout: float = 120.0):
        finished = command_line.run(arguments, cwd, env, timeout)
        assert "Traceback" not in finished.stderr, finished.stderr
        return finished

    return run


def pytest_collection_finish() -> None:
    """What was imported until here stays: collectors of garbage need not walk it, 0.25 s of processor time each."""
    gc.collect()
    gc.freeze()


def pytest_configure(config: pytest.Config) -> None:
    """colour-science switches numpy to its printing of 2017 when it is imported; the examples show today's."""
    # Tests leave the user's cache folder alone, and share one of their own.
    os.environ.setdefault("IRIDESCE_CACHE", str(Path(tempfile.gettempdir()) / "iridesce-tests-cache"))
    if config.getoption("numprocesses", None) and not hasattr(config, "workerinput"):
        return  # this process runs no tests, and those that do wait for it to begin
    import colour  # noqa: F401
    import numpy as np

    np.set_printoptions(legacy=False)
