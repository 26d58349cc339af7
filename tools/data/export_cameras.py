"""Write the camera sensitivities of ``python/iridesce/color/camera_data`` from the package ``colour-science``
(0.4.7, BSD-3-Clause).

    pip install colour-science==0.4.7
    python tools/data/export_cameras.py

Every number is written as the shortest text that reads back as the same double; the SOURCES.md beside the tables names
their paper.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

import colour
import numpy as np

DATA = Path(__file__).resolve().parents[2] / "python" / "iridesce" / "color" / "camera_data"
CAMERAS = {"nikon-d5100": "Nikon 5100 (NPL)", "sigma-sd-merrill": "Sigma SDMerill (NPL)"}


def main() -> None:
    for name, origin in CAMERAS.items():
        table = colour.MSDS_CAMERA_SENSITIVITIES[origin]
        lines = [f"# relative spectral sensitivities of {origin}: SOURCES.md", "nm,r,g,b"]
        for nm, row in zip(table.wavelengths, table.values, strict=True):
            lines.append(",".join([repr(int(nm)), *(repr(float(value)) for value in row)]))
        text = "\n".join(lines) + "\n"
        (DATA / f"{name}.csv").write_text(text)
        print(name, hashlib.sha256(text.encode()).hexdigest())
    write_basis()


def write_basis() -> None:
    """The first two eigenvectors of each channel, the first one's sign made positive."""
    shape = colour.recovery.SPECTRAL_SHAPE_BASIS_FUNCTIONS_DYER2017
    basis = np.asarray(colour.recovery.BASIS_FUNCTIONS_DYER2017)[:2]
    basis[0] *= np.sign(basis[0].sum(axis=0))
    lines = ["# first two eigenvectors of measured camera sensitivities: SOURCES.md", "nm,r1,g1,b1,r2,g2,b2"]
    for i, nm in enumerate(shape.wavelengths):
        lines.append(",".join([repr(int(nm)), *(repr(float(value)) for value in basis[:, i].reshape(-1))]))
    text = "\n".join(lines) + "\n"
    (DATA / "basis.csv").write_text(text)
    print("basis", hashlib.sha256(text.encode()).hexdigest())


if __name__ == "__main__":
    main()
