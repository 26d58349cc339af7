"""Install a wheel into a clean environment, with no Rust toolchain in reach, and ask it for numbers.

    python tools/release/check_wheel.py dist                      # the wheel of that folder that fits this Python and platform
    python tools/release/check_wheel.py dist/iridesce-0.1.0-cp311-abi3-win_amd64.whl

Exit code 0 when the installed package answers right. Needs a package index for numpy and the other dependencies.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

# Asked in the clean environment. Numbers with a closed form: glass of n = 1.5 reflects ((1.5 - 1) / (1.5 + 1))^2 = 0.04;
# a quarter wave of sqrt(1.5) on it reflects nothing; the sum of a perfect white gives the lamp's white; a film of no
# thickness in an even environment is invisible.
QUESTIONS = """
import math, shutil, sys
assert "numpy" not in sys.modules
import iridesce as ir
assert "numpy" not in sys.modules, "importing iridesce must not import numpy"
assert shutil.which("cargo") is None and shutil.which("rustc") is None, "Rust is in reach"

glass = float(ir.Stack(["air", 1.5]).reflectance(550.0))
assert abs(glass - 0.04) < 1e-15, glass
coated = ir.Stack(["air", ir.Layer(math.sqrt(1.5), 550.0 / 4 / math.sqrt(1.5)), 1.5])
assert 0.0 <= float(coated.reflectance(550.0)) < 1e-17  # what 0.01 loses by rounding where two waves cancel
white = ir.Stack(["vacuum", 1.0]).color(quantity="transmittance")
assert abs(white - ir.color.illuminant("D65").white()).max() < 1e-12, white
medium = ir.Medium("SiO2").index(589.3).real
assert abs(medium - 1.45840) < 1e-5, medium

scene = {
    "version": 1,
    "camera": {"position": [0.0, 0.0, 16.0], "target": [0.0, 0.0, 0.0], "resolution": [16, 16]},
    "object": [{
        "name": "bubble",
        "shape": {"sphere": {"center": [0.0, 0.0, 0.0], "radius": 4.0}},
        "surface": {"film": {"medium": "soap", "thickness_nm": 0.0}},
    }],
    "light": [{"environment": {"illuminant": "D65", "radiance": 1.0}}],
}
luminance = ir.render(scene, samples=4, seed=1).xyz[..., 1]
assert abs(luminance - 1.0).max() < 1e-4, (luminance.min(), luminance.max())
picture = ir.render("soap-bubble", size=(32, 32), samples=4)
picture.save("bubble.png")
print(f"glass {glass:.12f}, SiO2 {medium:.5f}, invisible film {luminance.mean():.6f}, studio {picture.xyz[..., 1].mean():.4f}")
"""


def without_rust(path: str) -> str:
    """A search path with no folder that holds cargo or rustc."""
    folders = path.split(os.pathsep)
    return os.pathsep.join(f for f in folders if not (shutil.which("cargo", path=f) or shutil.which("rustc", path=f)))


def check_contents(wheel: Path) -> None:
    """One extension module for every Python from 3.11 on, without the paths of whoever built it; the licences, the types."""
    assert "-cp311-abi3-" in wheel.name, f"{wheel.name} is no abi3 wheel"
    archive = zipfile.ZipFile(wheel)
    names = archive.namelist()
    modules = [name for name in names if name.startswith("iridesce/_core.") and name.endswith((".so", ".pyd"))]
    assert len(modules) == 1, modules
    library = archive.read(modules[0])
    for home in (b"/.cargo/registry/", b"\\.cargo\\registry\\", b"/.rustup/"):
        assert home not in library, (
            f"{modules[0]} names the home of its builder: build it with RUSTFLAGS as `make wheel` does"
        )
    for wanted in ("iridesce/py.typed", "iridesce/_core.pyi"):
        assert wanted in names, f"{wanted} is missing"
    for wanted in ("LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY-LICENSES.txt"):
        assert any(name.endswith(f"licenses/{wanted}") for name in names), f"{wanted} is missing"


def main() -> int:
    if len(sys.argv) != 2 or not Path(sys.argv[1]).exists():
        print(__doc__, file=sys.stderr)
        return 2
    given = Path(sys.argv[1]).resolve()
    wheels = [given] if given.is_file() else sorted(given.glob("*.whl"))
    for wheel in wheels:
        check_contents(wheel)
        print(f"{wheel.name}: {wheel.stat().st_size / 2**20:.2f} MiB")
    assert wheels, f"no wheel in {given}"
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        scripts = Path(folder) / ("Scripts" if os.name == "nt" else "bin")
        environment = {
            key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "CARGO", "RUST"))
        }
        environment["PATH"] = without_rust(os.pathsep.join([str(scripts), os.environ["PATH"]]))

        def run(*command: str) -> None:
            subprocess.run([str(scripts / command[0]), *command[1:]], check=True, cwd=folder, env=environment)

        quiet = ("--quiet", "--disable-pip-version-check")
        # First the wheel itself, from nowhere else; of several pip takes the one that fits.
        source = [str(given)] if given.is_file() else ["--find-links", str(given), "iridesce"]
        run("python", "-m", "pip", "install", *quiet, "--no-index", "--no-deps", *source)
        # Then its dependencies, as wheels only: nothing may ask for a compiler.
        run("python", "-m", "pip", "install", *quiet, "--only-binary", ":all:", "iridesce")
        (Path(folder) / "questions.py").write_text(QUESTIONS)
        run("python", "-c", "import iridesce; assert 'site-packages' in iridesce.__file__")
        run("python", "-W", "error", "questions.py")
        run("iridesce", "--version")
        run("iridesce", "render", "soap-bubble", "--size", "16x16", "--samples", "2", "-o", "tiny.png")
        assert (Path(folder) / "tiny.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    print("the wheel answers")
    return 0


if __name__ == "__main__":
    sys.exit(main())
