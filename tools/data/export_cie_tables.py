"""Write the CIE tables of ``crates/optics/data`` from the package ``colour-science`` (0.4.7, BSD-3-Clause).

    pip install colour-science==0.4.7
    python tools/data/export_cie_tables.py

Only figures published by the CIE are taken; every number is written as the shortest text that reads back as the same
double. Sources of the figures are named in the SOURCES.md beside each table.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

import colour

DATA = Path(__file__).resolve().parents[2] / "crates" / "optics" / "data"

OBSERVERS = {
    "cie1931": "CIE 1931 2 Degree Standard Observer",
    "cie1964": "CIE 1964 10 Degree Standard Observer",
}
ILLUMINANTS = (
    ["A", "B", "C", "D50", "D55", "D60", "D65", "D75", "E"]
    + [f"FL{i}" for i in range(1, 13)]
    + [f"FL3.{i}" for i in range(1, 16)]
    + [f"HP{i}" for i in range(1, 6)]
    + [f"LED-B{i}" for i in range(1, 6)]
    + ["LED-BH1", "LED-RGB1", "LED-V1", "LED-V2"]
)


def write(path: Path, comment: str, header: list[str], columns: list[dict[float, float]]) -> None:
    wavelengths = sorted(set().union(*columns))
    lines = [f"# {comment}", ",".join(header)]
    for nm in wavelengths:
        lines.append(",".join([repr(int(nm))] + [repr(float(c[nm])) if nm in c else "" for c in columns]))
    text = "\n".join(lines) + "\n"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    print(f"{path.relative_to(DATA)}  sha256 {hashlib.sha256(text.encode()).hexdigest()}")


def column(spectrum: colour.SpectralDistribution) -> dict[float, float]:
    return {float(nm): float(value) for nm, value in zip(spectrum.wavelengths, spectrum.values, strict=True)}


def main() -> None:
    for name, title in OBSERVERS.items():
        table = colour.MSDS_CMFS[title]
        columns = [dict(zip(map(float, table.wavelengths), table.values[:, i], strict=True)) for i in range(3)]
        write(DATA / "observers" / f"{name}.csv", title, ["wavelength_nm", "xbar", "ybar", "zbar"], columns)
    write(
        DATA / "illuminants" / "cie_illuminants.csv",
        "Relative spectral power of the CIE illuminants, 5 nm; an empty field lies outside the published table",
        ["wavelength_nm", *ILLUMINANTS],
        [column(colour.SDS_ILLUMINANTS[name]) for name in ILLUMINANTS],
    )
    basis = colour.colorimetry.SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES
    write(
        DATA / "illuminants" / "daylight_basis.csv",
        "Components S0, S1, S2 of CIE daylight, 5 nm",
        ["wavelength_nm", "S0", "S1", "S2"],
        [column(basis[name]) for name in ("S0", "S1", "S2")],
    )


if __name__ == "__main__":
    main()
