"""Spectra as spectrometers write them, and files that are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import iridesce as ir

read = ir.fit.read_spectrum

OCEAN = """SpectraSuite Data File
++++++++++++++++++++++++++++++++++++
Date: Tue Mar 03 14:22:10 CET 2009
User: lab
Dark Spectrum Present: Yes
Integration Time (usec): 100000 (USB4C01234)
Spectra Averaged: 10
Number of Pixels in Processed Spectrum: 3
>>>>>Begin Processed Spectral Data<<<<<
400.10\t4.20
400.60\t4.40
401.10\t4.10
>>>>>End Processed Spectral Data<<<<<
"""
AVANTES = """Integration time [ms]:  25.000
Averaging Nr. [scans]:  10
Spectrometer ID 1204001U1

Wave   ;Sample   ;Dark     ;Reference;Reflectance
[nm]   ;[counts] ;[counts] ;[counts] ;[%]

400,100;  1310,1;   700,00; 15000,00;   4,2000
400,600;  1330,2;   700,00; 15100,00;   4,4000
401,100;  1290,9;   700,00; 15200,00;   4,1000
"""
PERKIN = """PE UV       SUBTECH     SPECTRUM    ASCII       PEDS        4.00
film7.asc
2019/03/07 11:12:13.00
#HDR
-1
-1
#GR
nm
%R
1.000000
0.000000
#DATA
401.100000\t4.100000
400.600000\t4.400000
400.100000\t4.200000
"""
FILMETRICS = """"Wavelength(nm)","Measured Reflectance","Calculated Reflectance"
400.1,0.042,0.0421
400.6,0.044,0.0440
401.1,0.041,0.0413
"""
QUOTED = '"Wellenlänge nm.","R%"\n"400,10","4,200"\n"400,60","4,400"\n"401,10","4,100"\n'
WAVENUMBER = "wavenumber [1/cm];reflectance\n{};0.041\n{};0.044\n{};0.042\n".format(
    *(f"{1e7 / nm:.9f}" for nm in (401.1, 400.6, 400.1))
)
MICRONS = "# wavelength (um)  R\n0.40010 0.042\n0.40060 0.044\n0.40110 0.041\n"
ELECTRONVOLTS = "Photon energy (eV),R\n" + "".join(
    f"{1239.841984 / nm:.12f},{value}\n" for nm, value in ((400.1, 0.042), (400.6, 0.044), (401.1, 0.041))
)
ANGSTROM = "lambda (Angstrom)\tR\n4001\t0.042\n4006\t0.044\n4011\t0.041\n"
JCAMP_PAIRS = """##TITLE= film 7
##JCAMP-DX= 4.24
##XUNITS= NANOMETERS
##YUNITS= REFLECTANCE
##NPOINTS= 3
##XYPOINTS= (XY..XY)
400.1, 0.042; 400.6, 0.044
401.1, 0.041 $$ the last
##END=
"""
JCAMP_LINES = """##TITLE= film 7
##JCAMP-DX= 4.24
##DATA TYPE= UV/VIS SPECTRUM
##XUNITS= NANOMETERS
##YUNITS= REFLECTANCE
##FIRSTX= 400.1
##LASTX= 401.1
##XFACTOR= 1.0
##YFACTOR= 0.001
##NPOINTS= 3
##XYDATA= (X++(Y..Y))
400.1 +42+44
401.1 +41
##END=
"""
FILES = {
    "ocean optics": OCEAN,
    "ocean optics, comma": OCEAN.replace(".10\t", ",10\t").replace(".60\t", ",60\t").replace("\t4.", "\t4,"),
    "avantes": AVANTES,
    "perkin elmer": PERKIN,
    "filmetrics": FILMETRICS,
    "quoted decimal commas": QUOTED,
    "wavenumbers": WAVENUMBER,
    "micrometres": MICRONS,
    "electronvolts": ELECTRONVOLTS,
    "angstrom": ANGSTROM,
    "bare": "400.1,0.042\n400.6,0.044\n401.1,0.041\n",
    "bare, old line ends": "400.1 0.042\r400.6 0.044\r401.1 0.041\r",
    "jcamp pairs": JCAMP_PAIRS,
    "jcamp lines": JCAMP_LINES,
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("name", FILES)
def test_spectrometers(tmp_path: Path, name: str, encoding: str) -> None:
    """All of them hold the same three points."""
    file = tmp_path / "film.csv"
    file.write_bytes(FILES[name].encode(encoding))
    spectrum = read(file)
    order = np.argsort(spectrum.wavelength_nm)
    np.testing.assert_allclose(spectrum.wavelength_nm[order], [400.1, 400.6, 401.1], rtol=1e-9)
    np.testing.assert_allclose(spectrum.measured[order], [0.042, 0.044, 0.041], rtol=1e-12)


def test_column_by_name_and_number(tmp_path: Path) -> None:
    file = tmp_path / "film.txt"
    file.write_text(AVANTES)
    assert "Reflectance" in read(file).column
    assert read(file, "sample").measured.tolist() == [1310.1, 1330.2, 1290.9]
    assert read(file, 4).measured.tolist() == [15000.0, 15100.0, 15200.0]
    with pytest.raises(ValueError, match=r'0 columns are named "blue".*Sample'):
        read(file, "blue")
    with pytest.raises(ValueError, match=r"2 to 5, got 1"):
        read(file, 1)
    with pytest.raises(ValueError, match=r"column must be None, a name or a number"):
        read(file, 2.5)  # type: ignore[arg-type]


def test_transmittance_has_its_own_column(tmp_path: Path) -> None:
    file = tmp_path / "film.csv"
    file.write_text("nm,%R,%T\n500,4.2,90\n501,4.3,91\n502,4.4,92\n")
    assert read(file).measured.tolist() == pytest.approx([0.042, 0.043, 0.044], rel=1e-14)
    assert read(file, quantity="transmittance").measured.tolist() == pytest.approx([0.90, 0.91, 0.92], rel=1e-14)


def test_what_is_missing_is_nan_and_what_was_guessed_is_said(tmp_path: Path) -> None:
    file = tmp_path / "film.csv"
    file.write_text("0.50;4.2\n0.51;--\n0.52;NaN\n0.53;4.4\n0.54;OVER\n")
    spectrum = read(file)
    np.testing.assert_array_equal(np.isnan(spectrum.measured), [False, True, True, False, True])
    assert any("percent" in note for note in spectrum.notes) and any("um" in note for note in spectrum.notes)
    assert read(file, unit="um").wavelength_nm[0] == pytest.approx(500.0, rel=1e-14)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "no table"),
        (b"hello\n", "no table"),
        (b"500,0.04\n", "no table"),
        (b"\x00\x01\x02\xff" * 1000, "no table of numbers: it is a binary file"),
        (b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 20, "no table"),
        (b"500\n501\n502\n", "no table"),
        (b"50000,0.1\n50001,0.1\n", "without a unit: 1/cm or nm.*say the unit"),
        (b"nan,0.1\nnan,0.2\n", "no table"),
        (b"##TITLE= x\n##XYDATA= (X++(Y..Y))\n400.1@VKT%TLkj%J\n##END=\n", "compressed"),
        (b"##TITLE= x\n##FIRSTX= x\n##XYDATA= (X++(Y..Y))\n400 1 2 3\n##END=\n", "FIRSTX"),
        (b"##TITLE= x\n##NPOINTS= 9\n##FIRSTX=400\n##LASTX=402\n##XYDATA= (X++(Y..Y))\n400 1 2 3\n", "NPOINTS"),
        (b"##TITLE= x\n##NPOINTS= nan\n##FIRSTX=400\n##LASTX=402\n##XYDATA= (X++(Y..Y))\n400 1 2 3\n", "NPOINTS"),
        (b"##TITLE= x\n##XYPOINTS= (XY..XY)\n400, 1, 401\n", "not complete"),
        (b"##TITLE= x\n##END=\n", "no XYDATA"),
    ],
)
def test_files_that_are_no_spectra(tmp_path: Path, content: bytes, words: str) -> None:
    file = tmp_path / "film.csv"
    file.write_bytes(content)
    with pytest.raises(ValueError, match=words) as caught:
        read(file)
    assert "film.csv" in str(caught.value)


def test_places_that_are_no_files(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no such file"):
        read(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="is a folder"):
        read(tmp_path)
    with pytest.raises(ValueError, match="path"):
        read("a\0b.csv")
    (tmp_path / "a.csv").write_text("500,1\n501,2\n")
    with pytest.raises(ValueError, match='unit must be "nm"'):
        read(tmp_path / "a.csv", unit="inch")
