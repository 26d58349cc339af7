"""`IRIDESCE_SIMD` caps the vector instructions of a whole process; what the machine lacks is refused, by whatever it meets."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import numpy as np
import pytest

CALLS = {
    "reflectance": "ir.Stack(['air', ir.Layer(1.33, 300.0), 'air']).reflectance(550.0)",
    "color": "ir.Stack(['air', ir.Layer(1.33, 300.0), 'air']).color()",
    "render": "ir.render('soap-bubble', size=(8, 6), samples=1)",
    "simulate": "ir.thickness.simulate(ir.thickness.presets()[0], time_s=0.0)",
}


def asked(level: str, code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", f"import iridesce as ir\n{code}"],
        env={**os.environ, "IRIDESCE_SIMD": level},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("call", CALLS)
def test_a_level_that_is_none_is_refused(call: str) -> None:
    done = asked("avx1024", CALLS[call])
    assert done.returncode == 1
    last = done.stderr.strip().splitlines()[-1]
    assert (
        last.startswith("ValueError: ")
        and "IRIDESCE_SIMD must be one of sse2" in last
        and "'avx1024'" in last.replace('"', "'")
    )


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="sse2 is a level of x86")
def test_a_level_is_used_and_recorded() -> None:
    code = "print(ir.render('soap-bubble', size=(8, 6), samples=1).metadata['simd'])"
    assert asked("sse2", code).stdout.strip() == "sse2"
    best = asked("", code).stdout.strip()
    assert asked(best, code).stdout.strip() == best


LEVELS = {"x86_64": ("sse2", "sse4.2", "avx2", "avx512"), "AMD64": ("sse2", "sse4.2", "avx2", "avx512")}


def test_every_level_that_the_machine_has_draws_the_same_picture() -> None:
    """Paths of light are compiled once a level: where one level rounds otherwise a path may turn, no more."""
    code = (
        "import sys; picture = ir.render('double-bubble', size=(24, 16), samples=8, seed=3)\n"
        "print(picture.metadata['simd'], *map(float.hex, map(float, picture.xyz[..., 1].ravel())))"
    )
    best = asked("", code).stdout.split()
    wanted = np.array([float.fromhex(word) for word in best[1:]])
    for level in LEVELS.get(platform.machine(), ()):
        done = asked(level, code)
        if done.returncode:
            assert "this machine has" in done.stderr
            continue
        name, *words = done.stdout.split()
        assert name == level
        drawn = np.array([float.fromhex(word) for word in words])
        assert np.median(np.abs(drawn - wanted) / wanted.mean()) < 1e-6, level
        assert drawn.mean() == pytest.approx(wanted.mean(), rel=1e-3), level
