"""What Ctrl-C waits for: no call of the core holds Python's lock for long, and nothing of any size is laid out at once."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import iridesce as ir
from iridesce import _core
from iridesce._interrupts import heard
from iridesce.optics import multilayer

ROWS = np.random.default_rng(1).random((300_000, 3))
FLAT = np.tile(ROWS[:, 0], 8)
WHITE = [0.95, 1.0, 1.09]
CALLS: dict[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
    "delta_e": (_core.delta_e, (100.0 * ROWS, 100.0 * ROWS[::-1].copy())),
    "convert_color": (_core.convert_color, (ROWS, "xyz", "lch", WHITE, None)),
    "map_gamut": (_core.map_gamut, (2.0 * ROWS, "srgb", "hue")),
    "color_matching": (_core.color_matching, (400.0 + 300.0 * FLAT, "cie1931")),
    "spectrum_to_xyz": (
        _core.spectrum_to_xyz,
        (np.arange(360.0, 831.0), np.ones((40_000, 471)), ir.color.illuminant("D65")._core, "cie1931"),
    ),
    "color_jacobian": (_core.color_jacobian, (np.tile(ROWS, (4, 1)), "lab", WHITE, None)),
    "two_beam_purity": (_core.two_beam_purity, (1.0 + ROWS, [len(ROWS)])),
    "Illuminant.power": (ir.color.illuminant("D65")._core.power, (400.0 + 300.0 * FLAT,)),
    "Medium.index": (_core.Medium.named("soap").index, (400.0 + 300.0 * FLAT, False, [FLAT.size])),
    "Thickness.at_height": (_core.Thickness.gradient(0.0, 900.0, 1.7).at_height, (FLAT,)),
    "ThicknessMap.sample": (_core.ThicknessMap(np.ones((64, 64))).sample, (FLAT, FLAT)),
}


@pytest.mark.parametrize("name", CALLS)
def test_python_goes_on_while_the_core_computes(name: str) -> None:
    # (A busy machine may keep the other thread waiting for a whole call; one that holds the lock keeps it in each.)
    assert any(ticks_during(*CALLS[name]) > 3 for _ in range(5)), "the lock was held"


def ticks_during(function: Callable[..., Any], arguments: tuple[Any, ...]) -> int:
    """How often another thread of Python has its turn in a call."""
    ticks = 0
    done = threading.Event()

    def tick() -> None:
        nonlocal ticks
        while not done.is_set():
            ticks += 1
            time.sleep(0.0005)

    ticking = threading.Thread(target=tick, daemon=True)
    ticking.start()
    try:
        began = ticks
        function(*arguments)
        return ticks - began
    finally:
        done.set()
        ticking.join()


def test_elements_are_laid_out_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    nm = np.linspace(400.0, 800.0, 7)
    stack = ir.Stack(["air", ir.Layer("SiO2", np.linspace(10.0, 500.0, 6)[:, None, None]), ir.Layer(1.5, 100.0), "Si"])
    asked: dict[str, Callable[[], Any]] = {
        "derivatives": lambda: stack.derivatives("reflectance", nm, [[0.0], [30.0], [60.0]]),
        "psi": lambda: stack.derivatives("psi", nm, [[0.0], [30.0], [60.0]]),
        "field_profile": lambda: stack.field_profile([0.0, 5.0, 400.0], nm, [[0.0], [30.0], [60.0]]),
        "mueller": lambda: (stack.mueller(nm, [[0.0], [30.0], [60.0]]),),
        "color_derivatives": lambda: stack.color_derivatives([[0.0]], wavelength_nm=np.arange(400.0, 701.0, 10.0)),
    }
    whole = {name: call() for name, call in asked.items()}
    monkeypatch.setattr(multilayer, "_BLOCK", 60)
    for name, call in asked.items():
        for one, other in zip(call(), whole[name], strict=True):
            np.testing.assert_array_equal(one, other, err_msg=name)
    _, arguments = stack._arguments(nm, [[0.0], [30.0], [60.0]])
    sizes = [which.stop - which.start for which, _ in stack._elements((6, 3, 7), arguments)]
    assert sum(sizes) == 126 and max(sizes) == 5


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_among_the_depths_of_one_field() -> None:
    film = ir.Stack(["air", ir.Layer("soap", 500.0), "air"])
    depth = np.linspace(0.0, 500.0, 600_000)
    for _ in range(2):
        began = time.perf_counter()
        film.field_profile(depth, 550.0)
        whole = time.perf_counter() - began
    main = threading.main_thread().ident
    assert main is not None
    timer = threading.Timer(whole / 20.0, signal.pthread_kill, (main, signal.SIGINT))
    began = time.perf_counter()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        film.field_profile(depth, 550.0)
    assert time.perf_counter() - began < 0.6 * whole + 0.03


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_while_another_package_works() -> None:
    assert heard(divmod, 7, 2) == (3, 1)
    with pytest.raises(ZeroDivisionError):
        heard(divmod, 7, 0)
    main = threading.main_thread().ident
    assert main is not None
    began = time.perf_counter()
    threading.Timer(0.1, signal.pthread_kill, (main, signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        heard(time.sleep, 5.0)
    assert time.perf_counter() - began < 3.0


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_in_code_that_is_made_of_a_string_leaves_with_the_code_of_all_others(tmp_path: Path) -> None:
    # (What makes named tuples and data classes; a program that is run by its path never dies of the signal.)
    (tmp_path / "interrupted.py").write_text(
        "import iridesce as ir\nfrom iridesce.cli import main\n\n"
        "def media(*arguments):\n    exec('raise KeyboardInterrupt')\n\nir.Medium = media\nmain()\n"
    )
    words = [sys.executable, "-m", "interrupted", "media", "soap"]
    left = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert left.returncode == 130, left.stderr
    assert left.stderr == "note: interrupted; files that were there before are as they were\n"
