"""The direction of dependencies, and what the dependencies' licences allow."""

from __future__ import annotations

import importlib.metadata
import json
import re
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from conftest import ROOT
from house import (
    MAY_USE,
    MODULE_ORDER,
    PACKAGE_ORDER,
    circles,
    code_of,
    floors,
    python_arrows,
    python_modules,
    python_room,
    ranges_spelled_out,
    rust_arrows,
    rust_modules,
    typescript_arrows,
    typescript_modules,
    upstream_arrows,
)

# Licences that ask for nothing but to be named: fit for a package under MIT OR Apache-2.0.
PERMISSIVE = {
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0",
    "ISC", "MIT", "MIT-0", "Unicode-3.0", "Unlicense", "Zlib",
}  # fmt: skip


@cache
def cargo_metadata(*arguments: str) -> dict[str, Any]:
    command = ["cargo", "metadata", "--format-version", "1", "--locked", *arguments]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)


@cache
def host() -> str:
    text = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout
    return next(line.removeprefix("host: ") for line in text.splitlines() if line.startswith("host: "))


def forbidden_edges(packages: list[dict[str, Any]]) -> list[str]:
    """Every dependency between our crates that `MAY_USE` does not hold, as `a -> b`."""
    ours = {package["name"] for package in packages}
    return [
        f"{package['name']} -> {dependency['name']}"
        for package in packages
        for dependency in package["dependencies"]
        if dependency["name"] in ours and dependency["name"] not in MAY_USE.get(package["name"], set())
    ]


def test_crates_depend_in_one_direction() -> None:
    packages = cargo_metadata("--no-deps")["packages"]
    assert {package["name"] for package in packages} == set(MAY_USE), "a new crate needs its row in MAY_USE"
    assert forbidden_edges(packages) == []
    # The facade offers every stage.
    facade = next(package for package in packages if package["name"] == "iridesce")
    assert MAY_USE["iridesce"] <= {dependency["name"] for dependency in facade["dependencies"]}


def test_a_forbidden_edge_is_seen() -> None:
    packages = [
        {"name": "iridesce-optics", "dependencies": [{"name": "iridesce-scene"}, {"name": "rayon"}]},
        {"name": "iridesce-scene", "dependencies": [{"name": "iridesce-optics"}]},
    ]
    assert forbidden_edges(packages) == ["iridesce-optics -> iridesce-scene"]


# --- order and circles of Rust modules

CRATES = sorted(path.name for path in (ROOT / "crates").iterdir() if (path / "src").is_dir())


@cache
def arrows_of(crate: str) -> dict[str, set[str]]:
    return rust_arrows(rust_modules(ROOT / "crates" / crate / "src"))


def top_level(module: str, order: list[str]) -> str:
    """The row of a module: `stack::march`, and `stack_color` too, are `stack`."""
    first = module.split("::")[0]
    found = next((name for name in order if first == name or first.startswith(f"{name}_")), None)
    assert found is not None, f"{module} belongs to no row of MODULE_ORDER"
    return found


@pytest.mark.parametrize("crate", sorted(MODULE_ORDER))
def test_modules_of_a_crate_are_in_order(crate: str) -> None:
    order, arrows = MODULE_ORDER[crate], arrows_of(crate)
    assert upstream_arrows(arrows, order, {name: top_level(name, order) for name in arrows}) == []


def test_no_circles_among_rust_modules() -> None:
    assert {(crate, *circle) for crate in CRATES for circle in circles(arrows_of(crate))} == set(), "what is upstream?"


def test_every_module_of_every_crate_is_read() -> None:
    for crate in CRATES:
        folder = ROOT / "crates" / crate / "src"
        left_out = {path.stem for path in folder.rglob("*.rs")} - {
            name.rpartition("::")[2] or "lib" for name in rust_modules(folder)
        }
        tests = re.findall(r"#\[cfg\(test\)\]\s*mod (\w+);", "".join(path.read_text() for path in folder.rglob("*.rs")))
        assert left_out <= {"mod", *tests, *(path.stem for name in tests for path in folder.rglob(f"{name}/*.rs"))}
    assert sum(map(len, arrows_of("optics").values())) > 50, "the arrows are not found any more"


def has_example(text: str) -> bool:
    """Whether the documentation holds a block that a test of documentation would compile."""
    fences = re.findall(r"^\s*//[/!]\s*```(.*)$", text, re.MULTILINE)
    return any(opening.strip() != "text" for opening in fences[::2])


def left_out(target: Any, source: Path) -> list[str]:
    """Files of a library with tests or examples that its manifest says not to run."""
    out = []
    for file in sorted(source.rglob("*.rs")):
        text = file.read_text()
        if (not target["test"] and "#[test]" in text) or (not target["doctest"] and has_example(text)):
            out.append(file.name)
    return out


def test_what_a_library_does_not_run_is_not_there() -> None:
    for package in cargo_metadata("--no-deps")["packages"]:
        for target in package["targets"]:
            if {"lib", "cdylib"} & set(target["kind"]):
                assert left_out(target, Path(target["src_path"]).parent) == [], package["name"]


@pytest.mark.parametrize("flag", ["test", "doctest"])
def test_a_test_that_would_not_run_is_seen(flag: str, tmp_path: Path) -> None:
    (tmp_path / "quiet.rs").write_text("//! ```text\n//! a drawing\n//! ```\nfn one() {}\n")
    loud = {"test": "#[test]\nfn one() {}\n", "doctest": "/// ```\n/// one();\n/// ```\npub fn one() {}\n"}[flag]
    (tmp_path / "loud.rs").write_text(loud)
    runs = {"test": True, "doctest": True}
    assert left_out(runs, tmp_path) == []
    assert left_out(runs | {flag: False}, tmp_path) == ["loud.rs"]


def planted_crate(tmp_path: Path, **files: str) -> dict[str, set[str]]:
    for name, text in {"lib": "mod film; mod stack; mod color;", **files}.items():
        path = tmp_path / f"{name.replace('__', '/')}.rs"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return rust_arrows(rust_modules(tmp_path))


@pytest.mark.parametrize(
    "text",
    [
        "use crate::stack::solve;",
        "use crate::{medium::Medium, stack::{march::Wave, x}};",
        "pub(crate) fn f() -> f64 { crate::stack::solve() }",
        "use super::super::stack;",
        "use crate::Stack;",  # which the root only hands on
        "use crate::film::Stack as Same;",  # which a module hands on
    ],
)
def test_a_use_of_a_later_module_is_seen(text: str, tmp_path: Path) -> None:
    arrows = planted_crate(
        tmp_path,
        lib="mod film; mod stack; mod color;\npub use stack::{Layer, Stack};",
        film="mod thin;\npub use crate::stack::Stack;",
        film__thin=text,
        stack="mod march;\npub struct Stack;",
        stack__march="",
        color="use crate::film::thin::f;",
    )
    order = ["film", "stack", "color"]
    seen = upstream_arrows(arrows, order, {name: top_level(name, order) for name in arrows})
    assert seen
    assert all(arrow.startswith("film::thin -> stack") for arrow in seen)


def test_what_is_no_use_of_a_later_module(tmp_path: Path) -> None:
    arrows = planted_crate(
        tmp_path,
        film='// crate::stack is not used\nfn f() { say("crate::stack"); other::stack::f(); }\n'
        "#[cfg(test)]\nmod tests { use crate::stack; }",
        stack="#[cfg(test)]\nmod proofs;\nuse crate::film::f;",
        stack__proofs="use crate::color;",
        color="",
    )
    assert arrows == {"film": set(), "stack": {"film"}, "color": set()}


def test_a_circle_of_rust_modules_is_seen(tmp_path: Path) -> None:
    arrows = planted_crate(
        tmp_path, film="use crate::color::c;", stack="use crate::film::f;", color="use super::stack;"
    )
    assert circles(arrows) == [("color", "film", "stack")]


# --- order and circles of Python modules


def test_python_modules_are_in_order_and_without_circles() -> None:
    modules = python_modules(ROOT / "python" / "iridesce")
    rooms = {name: python_room(name) for name in modules}
    assert set(rooms.values()) == set(PACKAGE_ORDER), "a new package needs its row in PACKAGE_ORDER, a lost one none"
    arrows = python_arrows(modules)
    assert sum(map(len, arrows.values())) > 200, "the arrows are not found any more"
    assert upstream_arrows(arrows, PACKAGE_ORDER, rooms) == []
    assert circles(arrows) == []


@pytest.mark.parametrize(
    "text",
    [
        "import iridesce.stack",
        "from iridesce.stack import Stack",
        "from iridesce import stack",
        "def f():\n    from iridesce import stack as later",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from iridesce.stack import Stack",
    ],
)
def test_an_import_of_a_later_module_is_seen(text: str) -> None:
    modules = {"iridesce": "", "iridesce.optics": "", "iridesce.optics.medium": text, "iridesce.stack": ""}
    modules["iridesce.stack"] = "from iridesce.optics import medium"
    arrows = python_arrows(modules)
    rooms = {name: python_room(name) for name in modules}
    assert upstream_arrows(arrows, ["optics", "stack", "iridesce"], rooms) == [
        "iridesce.optics.medium -> iridesce.stack"
    ]
    assert circles(arrows) == [("iridesce.optics.medium", "iridesce.stack")]


def test_relative_imports_are_refused() -> None:
    with pytest.raises(AssertionError, match="the whole path"):
        python_arrows({"iridesce.optics.medium": "from . import stack"})


def test_floors_are_counted() -> None:
    assert floors({"a": set(), "b": {"a"}, "c": {"a", "b"}, "d": set()}) == 3


def test_no_module_bears_the_name_of_a_public_function() -> None:
    """Importing such a submodule would put it in the function's place: `ir.render` would be a module."""
    taken = {"render", "sweep", "merge", "export", "validate", "widget", "media", "fit_thickness", "map_thickness"}
    modules = python_modules(ROOT / "python" / "iridesce")
    assert {f"iridesce.{name}" for name in taken} & set(modules) == set()
    for package, text in modules.items():
        inside = {name.removeprefix(f"{package}.") for name in modules if name.startswith(f"{package}.")}
        listed = re.search(r"^__all__ = \[(.*?)\]", text, flags=re.M | re.S)
        offered = set() if package == "iridesce" or listed is None else set(re.findall(r'"(\w+)"', listed[1]))
        assert inside & offered == set(), package


# --- circles of the page's modules


def test_no_circles_among_modules_of_the_page() -> None:
    arrows = typescript_arrows(typescript_modules(ROOT / "web" / "src"))
    assert sum(map(len, arrows.values())) > 80, "the arrows are not found any more"
    assert circles(arrows) == [], "types that both need have a file of their own, as page.ts"


@pytest.mark.parametrize(
    "text",
    [
        'import { draw } from "../app";',
        'import type { App } from "../app";',
        'import {\n  type App,\n  draw,\n} from "../app.ts";',
        'export { App } from "../app";',
        'import "../app";',
        'const later = () => import("../app");',
    ],
)
def test_a_circle_of_the_page_is_seen(text: str) -> None:
    modules = {"app": 'import { page } from "./parts/page";', "parts/page": text, "main": 'import "./app";'}
    assert circles(typescript_arrows(modules)) == [("app", "parts/page")]


def test_what_leads_out_of_the_page_is_no_arrow() -> None:
    modules = {"app": 'import { html } from "lit";\nimport style from "./style.css";\n// import { a } from "./app";'}
    assert typescript_arrows(modules) == {"app": set()}
    with pytest.raises(AssertionError, match=r"app: no module \['lost'\]"):
        typescript_arrows({"app": 'import { html } from "./lost";'})


# --- licences


def is_permissive(expression: str) -> bool:
    """Whether an SPDX expression can be met with licences of `PERMISSIVE` alone."""
    tokens = re.findall(r"\(|\)|[^\s()]+", expression.replace("/", " OR "))

    def any_of(position: int) -> tuple[bool, int]:
        value, position = all_of(position)
        while position < len(tokens) and tokens[position] == "OR":
            other, position = all_of(position + 1)
            value = value or other
        return value, position

    def all_of(position: int) -> tuple[bool, int]:
        value, position = one(position)
        while position < len(tokens) and tokens[position] == "AND":
            other, position = one(position + 1)
            value = value and other
        return value, position

    def one(position: int) -> tuple[bool, int]:
        if tokens[position] == "(":
            value, position = any_of(position + 1)
            return value, position + 1
        name, position = tokens[position], position + 1
        if position < len(tokens) and tokens[position] == "WITH":
            name, position = f"{name} WITH {tokens[position + 1]}", position + 2
        return name in PERMISSIVE, position

    value, position = any_of(0)
    assert position == len(tokens), expression
    return value


@pytest.mark.parametrize(
    ("expression", "fits"),
    [
        ("MIT OR Apache-2.0", True),
        ("MIT/Apache-2.0", True),
        ("(MIT OR Apache-2.0) AND Unicode-3.0", True),
        ("Apache-2.0 WITH LLVM-exception OR MIT", True),
        ("GPL-3.0-only", False),
        ("MIT AND GPL-2.0-or-later", False),
        ("MIT OR GPL-2.0-or-later", True),
        ("LGPL-2.1 OR MPL-2.0", False),
    ],
)
def test_licence_expressions_are_read(expression: str, fits: bool) -> None:
    assert is_permissive(expression) is fits


def test_rust_dependencies_are_permissive() -> None:
    packages = cargo_metadata("--filter-platform", host())["packages"]
    assert len(packages) > len(MAY_USE)
    wrong = [
        f"{package['name']} {package['version']}: {package['license'] or package['license_file']}"
        for package in packages
        if not is_permissive(package["license"] or "none")
    ]
    assert wrong == []


def run_time_distributions() -> set[str]:
    """Everything that `pip install iridesce` brings, without extras."""
    from packaging.requirements import Requirement

    found: set[str] = set()
    queue = ["iridesce"]
    while queue:
        name = queue.pop()
        if name in found:
            continue
        found.add(name)
        for text in importlib.metadata.requires(name) or []:
            requirement = Requirement(text)
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                queue.append(requirement.name.lower())
    return found


def test_python_dependencies_are_not_gpl() -> None:
    names = run_time_distributions()
    assert {"iridesce", "numpy", "matplotlib", "typer", "rich", "tifffile"} <= names
    for name in names:
        metadata = importlib.metadata.metadata(name)
        stated = [metadata.get("License-Expression") or ""]
        stated += [value for key, value in metadata.items() if key == "Classifier" and value.startswith("License")]
        assert not any("GPL" in text or "GNU" in text for text in stated), f"{name}: {stated}"


def test_our_licences_are_stated_and_present() -> None:
    for package in cargo_metadata("--no-deps")["packages"]:
        assert package["license"] == "MIT OR Apache-2.0", package["name"]
    for name, opening in {"LICENSE-MIT": "MIT License", "LICENSE-APACHE": "Apache License"}.items():
        assert opening in (ROOT / name).read_text()[:100]


# --- what must not be in the repository


def test_no_file_names_the_machine_it_was_written_on() -> None:
    """Absolute home paths in tracked files are of use to nobody else."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("not a git checkout")
    pattern = re.compile(rb"(?<![\w.])/(?:root|home/\w+|Users/\w+)/")
    wrong = []
    for name in filter(None, listed.stdout.split("\0")):
        path = ROOT / name
        if path.is_file() and path != Path(__file__) and pattern.search(path.read_bytes()):
            wrong.append(name)
    assert wrong == []


def test_examples_of_docstrings_leave_no_file_behind() -> None:
    """They run in the folder of whoever runs the tests."""
    leaving = re.compile(r'(>>>|\.\.\.) .*\.save\("')
    sources = {file: file.read_text(encoding="utf-8") for file in (ROOT / "python" / "iridesce").rglob("*.py")}
    assert [file.name for file, text in sources.items() if leaving.search(text)] == []
    assert leaving.search('>>> result.save("series.csv")') and not leaving.search('... result.save(f"{folder}/x")')


# --- length of files

MOST_LINES = 500


def lines_of(file: Path) -> int:
    """Lines without a Rust file's own tests, which are a list of cases at its end."""
    return len(file.read_text(encoding="utf-8").split("#[cfg(test)]\nmod tests {")[0].splitlines())


def long_files(root: Path) -> set[str]:
    """Sources past 500 lines; files of tests are lists of cases and are not asked."""
    places = ("crates/*/src/**/*.rs", "python/iridesce/**/*.py", "tools/**/*.py", "bench/**/*.py", "web/src/**/*.ts")
    files = (file for place in places for file in root.glob(place) if file.stem != "tests")
    return {file.relative_to(root).as_posix() for file in files if lines_of(file) > MOST_LINES}


def test_a_file_past_500_lines_has_its_reason_in_architecture() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8").split("## Long files")[1].split("\n## ")[0]
    reasons = dict(re.findall(r"^\| `([^`]+)` \| (.{20,}) \|$", text, re.MULTILINE))
    assert long_files(ROOT) - set(reasons) == set(), "does it hold two ideas? part it, or say why not"
    assert [name for name in reasons if not (ROOT / name).is_file()] == []


def test_a_long_file_is_seen(tmp_path: Path) -> None:
    for name, text in {
        "crates/a/src/b/long.rs": "x\n" * 501,
        "crates/a/src/tested.rs": "x\n" * 500 + "#[cfg(test)]\nmod tests {\n" + "y\n" * 9,
        "crates/a/src/b/tests.rs": "x\n" * 900,
        "python/iridesce/p/q.py": "x\n" * 502,
        "python/tests/test_q.py": "x\n" * 900,
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    assert long_files(tmp_path) == {"crates/a/src/b/long.rs", "python/iridesce/p/q.py"}


# --- limits that have one home in each language

HOMES = {
    "crates/optics/src/medium/value.rs",
    "python/iridesce/optics/wavelengths.py",
    "web/src/core/wavelengths.ts",
}


def test_the_visible_range_stands_in_one_place() -> None:
    places = ("crates/*/src/**/*.rs", "python/iridesce/**/*.py", "web/src/**/*.ts")
    files = [file for place in places for file in ROOT.glob(place) if file.stem != "tests"]
    spelled = {file.relative_to(ROOT).as_posix(): ranges_spelled_out(code_of(file)) for file in files}
    assert set(spelled) >= HOMES, "a home has moved"
    assert {name: lines for name, lines in spelled.items() if lines and name not in HOMES} == {}, (
        "take it from its home"
    )
    assert all(spelled[name] for name in HOMES - {"python/iridesce/optics/wavelengths.py"}), "the ends are not found"


def test_the_page_has_the_ranges_of_the_core() -> None:
    from iridesce.optics import wavelengths

    text = (ROOT / "web/src/core/wavelengths.ts").read_text(encoding="utf-8")
    found = dict(re.findall(r"export const (\w+) = \[(\d+, \d+)\] as const;", text))
    ranges = {name: tuple(map(float, ends.split(", "))) for name, ends in found.items()}
    assert ranges == {"VISIBLE_NM": wavelengths.VISIBLE_NM, "SPECTRUM_NM": wavelengths.SPECTRUM_NM}


@pytest.mark.parametrize(
    ("name", "text", "is_seen"),
    [
        ("a.py", "nm = np.arange(360.0, 831.0)", True),
        ("a.py", "x = range(380,\n 781)", True),
        ("a.py", "first_nm = 360.0", True),
        ("a.py", "turn = (delta + 360.0) % 360.0  # 380 nm", False),
        ("a.py", "all = nm.size * log(90.0 if psi else 360.0)", False),
        ("a.py", 'def f():\n    """360 to 830 nm."""\n    return "380..780 nm", 0.830, 1380, 3.8e2', False),
        ("a.rs", "let visible = (360..=830).map(f64::from);", True),
        ("a.rs", 'let x = 360.0; // nm\nsay("360..830 nm"); let y = [0.165, 0.830];', False),
        ("a.rs", "let x = 1;\n#[cfg(test)]\nmod tests {\n let nm = 380.0;\n}", False),
        ("a.ts", "const all = Float64Array.from({ length: 401 }, (_, i) => 380 + i);", True),
        ("a.ts", "const at = 3 * (nm - 360);", True),
        ("a.ts", "/* 380\n nm */ const BOX = { width: 360 };", False),
    ],
)
def test_a_range_that_is_spelled_out_is_seen(name: str, text: str, is_seen: bool, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    assert bool(ranges_spelled_out(code_of(tmp_path / name))) is is_seen
