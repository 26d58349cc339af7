"""Bars for long work, in a terminal and in a notebook."""

from __future__ import annotations

import io
import os
import re
import subprocess
import sys
import types
from typing import Any

import pytest

import iridesce as ir
from iridesce._progress import progress_bar

FILM = ir.Stack(["air", ir.Layer("soap", thickness_nm=0.0), "air"])
CALLS = {
    "rendering": lambda progress: ir.render("soap-bubble", size=(64, 48), samples=16, progress=progress),
    "building": lambda progress: ir.ColorTable(FILM, (0.0, 2000.0), progress=progress),
}


class Shown:
    """What a notebook was shown, in the place of IPython's display."""

    def __init__(self) -> None:
        self.html: list[str] = []

    def display(self, thing: Any, display_id: bool) -> Shown:
        assert display_id
        self.html.append(thing._repr_html_())
        return self

    def update(self, thing: Any) -> None:
        self.html.append(thing._repr_html_())


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> Shown:
    shown = Shown()
    shell = types.SimpleNamespace(kernel=object())
    ipython = types.ModuleType("IPython")
    ipython.get_ipython = lambda: shell  # type: ignore[attr-defined]
    module = types.ModuleType("IPython.display")
    module.display = shown.display  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    return shown


@pytest.mark.parametrize("name", CALLS)
def test_a_notebook_shows_a_bar_below_its_cell(notebook: Shown, name: str, capfd: pytest.CaptureFixture[str]) -> None:
    CALLS[name](True)
    *bars, last = notebook.html
    assert bars and last == ""
    words = {"building": "color table"}.get(name, name)
    assert all(f"<div>{words} <progress" in bar for bar in bars)
    shares = [float(found) for bar in bars for found in re.findall(r'value="([\d.]+)"', bar)]
    assert shares[-1] == 1.0
    assert shares == sorted(shares) or name == "building"  # a grid that must be refined has more to do
    assert capfd.readouterr().err == ""


def test_a_bar_tells_how_many_and_how_long(notebook: Shown) -> None:
    with progress_bar("<frames>", counted=True) as advance:
        advance(3, 12)
    assert "&lt;frames&gt;" in notebook.html[0] and "3 of 12" in notebook.html[0]
    assert notebook.html[-1] == ""


@pytest.mark.parametrize("name", CALLS)
def test_neither_terminal_nor_notebook_no_bar(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    CALLS[name](True)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("name", CALLS)
def test_functions_are_told_done_and_total(name: str) -> None:
    seen: list[tuple[int, int]] = []
    CALLS[name](lambda done, total: seen.append((done, total)))
    assert seen and seen[-1][0] == seen[-1][1]
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


@pytest.mark.parametrize("name", CALLS)
def test_an_exception_of_the_function_is_passed_on(name: str) -> None:
    def refuse(done: int, total: int) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        CALLS[name](refuse)


@pytest.mark.skipif(sys.platform == "win32", reason="terminals of POSIX")
def test_a_terminal_shows_a_bar() -> None:
    import pty

    master, slave = pty.openpty()
    program = "import iridesce as ir; ir.render('soap-bubble', size=(128, 96), samples=64, progress=True)"
    env = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    process = subprocess.Popen([sys.executable, "-c", program], stderr=slave, env=env)
    os.close(slave)
    written = b""
    while True:
        try:
            part = os.read(master, 4096)
        except OSError:
            break
        if not part:
            break
        written += part
    assert process.wait(timeout=60) == 0
    os.close(master)
    assert b"rendering" in written and b"left" in written


def test_work_that_is_over_at_its_first_news_has_no_bar_where_nobody_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    """What draws bars takes longer to import than a small picture to render."""

    def none(*_: object) -> None:
        raise AssertionError("a bar for work that is over")

    monkeypatch.setattr("iridesce._progress._Bar", none)
    with progress_bar("rendering") as advance:
        advance(256, 256)
        with pytest.raises(AssertionError, match="over"):
            advance(1, 256)


class Mute:
    """A stream that knows how to write, and nothing else."""

    def write(self, text: str) -> int:
        return len(text)


def closed() -> io.StringIO:
    stream = io.StringIO()
    stream.close()
    return stream


@pytest.mark.parametrize("stream", [None, closed(), Mute()], ids=["none", "closed", "mute"])
def test_without_a_stderr_there_is_no_bar_and_no_error(stream: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs without a console (pythonw) have None."""
    monkeypatch.setattr(sys, "stderr", stream)
    CALLS["rendering"](True)
    for first in (1, 12):
        with progress_bar("frames", counted=True) as advance:
            advance(first, 12)
            advance(12, 12)
