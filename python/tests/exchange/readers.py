"""The programs that read what we export: found where `make readers` put them, and named where they are absent.

With IRIDESCE_REQUIRE_READERS=1 an absent reader is a failure, not a skip.
"""

from __future__ import annotations

import importlib
import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from conftest import ROOT

FOLDER = Path(os.environ.get("IRIDESCE_READERS", ROOT / ".readers"))
NODE_SCRIPTS = Path(__file__).parent / "node"


def absent(what: str) -> None:
    message = f"reader absent: {what} (make readers)"
    if os.environ.get("IRIDESCE_REQUIRE_READERS") == "1":
        pytest.fail(message)
    pytest.skip(message)


def module(name: str) -> Any:
    """An importable reader, such as OpenImageIO."""
    try:
        return importlib.import_module(name)
    except ImportError:
        absent(name)


def program(name: str, *places: Path) -> str:
    """A program on the path or at one of the places."""
    found = shutil.which(name) or next((str(place) for place in places if place.is_file()), None)
    if found is None:
        absent(name)
    return str(found)


def blender() -> str:
    """The Python that holds the module bpy; it pins an old numpy, so it lives apart."""
    return program(".", FOLDER / "bpy" / "bin" / "python") if (FOLDER / "bpy").exists() else str(absent("bpy"))


def run_lux(script: Path, *arguments: object, timeout: float = 600.0) -> Any:
    """Run a script in the Python that holds pyluxcore; its last line is its answer in JSON."""
    command = [program(".", FOLDER / "lux" / "bin" / "python"), str(script), *map(str, arguments)]
    finished = subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)
    assert finished.returncode == 0, finished.stdout[-3000:] + finished.stderr[-3000:]
    return json.loads(finished.stdout.strip().splitlines()[-1])


def run_blender(script: Path, *arguments: object, timeout: float = 600.0) -> Any:
    """Run a script in Blender's Python; its last line is its answer in JSON."""
    command = [blender(), str(script), *map(str, arguments)]
    finished = subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)
    assert finished.returncode == 0, finished.stdout[-3000:] + finished.stderr[-3000:]
    return json.loads(finished.stdout.strip().splitlines()[-1])


def node(script: str, question: Any, timeout: float = 600.0) -> Any:
    """Run a script of ``node/`` with a question in JSON on its standard input; its answer, from JSON."""
    modules = FOLDER / "node_modules"
    if not modules.is_dir():
        absent("node modules")
    finished = subprocess.run(
        [program("node"), str(NODE_SCRIPTS / script), str(modules)],
        input=json.dumps(question),
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )
    assert finished.returncode == 0, finished.stdout[-3000:] + finished.stderr[-3000:]
    return json.loads(finished.stdout)


def chromium() -> str:
    return next(
        (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), ""
    ) or str(absent("chromium"))


def llvm() -> str:
    """The newest LLVM library; below 17 the compiler of Mitsuba's variants aborts."""
    import re

    found = {}
    for path in Path("/usr/lib").glob("*/libLLVM*.so*"):
        version = re.match(r"libLLVM(?:-|\.so\.)(\d+)", path.name)
        if version and int(version[1]) >= 17:
            found[int(version[1])] = str(path)
    given = os.environ.get("DRJIT_LIBLLVM_PATH")
    return given or (found[max(found)] if found else str(absent("libLLVM 17 or newer")))
