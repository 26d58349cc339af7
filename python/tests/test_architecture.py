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

# Our crates and which of our crates each may use, in any way (normal, build or dev dependency).
MAY_USE = {
    "iridesce-numerics": set(),
    "iridesce-optics": {"iridesce-numerics"},
    "iridesce-thickness": {"iridesce-numerics"},
    "iridesce-flow": {"iridesce-numerics", "iridesce-thickness"},
    "iridesce-files": {"iridesce-numerics", "iridesce-optics", "iridesce-thickness"},
    "iridesce-scene": {
        "iridesce-numerics",
        "iridesce-optics",
        "iridesce-thickness",
        "iridesce-flow",
        "iridesce-files",
    },
    "iridesce-render": {"iridesce-numerics", "iridesce-scene", "iridesce-optics", "iridesce-files"},
    "iridesce": {
        "iridesce-numerics",
        "iridesce-optics",
        "iridesce-thickness",
        "iridesce-flow",
        "iridesce-files",
        "iridesce-scene",
        "iridesce-render",
    },
    "iridesce-python": {"iridesce"},
}

# Inside optics a module may use the ones before it.
OPTICS_ORDER = ["error", "spectrum", "medium", "incidence", "fresnel", "film", "stack", "color"]

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


# --- order of the modules of optics


def without_tests(text: str) -> str:
    """Rust source up to its unit tests, without comments."""
    text = text.split("#[cfg(test)]\nmod ")[0]
    return re.sub(r"//[^\n]*", "", text)


def split_top_level(group: str) -> list[str]:
    """The members of a `{a::{b, c}, d}` group (given without its outer braces)."""
    members, depth, current = [], 0, ""
    for letter in group:
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            members.append(current.strip())
            current = ""
        else:
            current += letter
    return [member for member in [*members, current.strip()] if member]


def crate_names(text: str) -> set[str]:
    """The first name after every `crate::` of a Rust source."""
    names = set(re.findall(r"\bcrate::(\w+)", text))
    for opening in re.finditer(r"\bcrate::\{", text):
        depth, end = 1, opening.end()
        while depth:
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            end += 1
        names |= {re.split(r"\W", member)[0] for member in split_top_level(text[opening.end() : end - 1])}
    return names


def reexports(lib: str) -> dict[str, str]:
    """Names that the crate root offers, with their home module."""
    home = {}
    for module, names in re.findall(r"pub use (\w+)::(\w+|\{[^}]*\});", lib):
        for name in re.findall(r"\w+", names):
            home[name] = module
    return home


def backward_uses(sources: dict[str, str], lib: str) -> list[str]:
    """Uses of a later module, as `file -> module`; `sources` maps a path below `src` to its text."""
    home = reexports(lib)
    wrong = []
    for path, text in sources.items():
        own = stage(path)
        assert own is not None, f"{path} belongs to no module of OPTICS_ORDER"
        for name in crate_names(without_tests(text)):
            used = home.get(name, name)
            if used in OPTICS_ORDER and OPTICS_ORDER.index(used) > OPTICS_ORDER.index(own):
                wrong.append(f"{path} -> {used}")
    return wrong


def stage(path: str) -> str | None:
    """The module that a file below `src` belongs to: `stack/march.rs`, `stack_color.rs` and `stack.rs` are `stack`."""
    first = path.split("/")[0].removesuffix(".rs")
    return next((module for module in OPTICS_ORDER if first == module or first.startswith(f"{module}_")), None)


def test_optics_modules_are_in_order() -> None:
    source = ROOT / "crates" / "optics" / "src"
    files = [path for path in source.rglob("*.rs") if path.stem != "tests"]
    sources = {path.relative_to(source).as_posix(): path.read_text() for path in files}
    lib = sources.pop("lib.rs")
    assert set(re.findall(r"^(?:pub )?mod (\w+);", lib, flags=re.M)) >= set(OPTICS_ORDER)
    assert backward_uses(sources, lib) == []


def test_a_backward_use_is_seen() -> None:
    lib = "pub use stack::{Layer, Stack};\npub use medium::Medium;"
    sources = {
        "film.rs": "use crate::{Medium, spectrum::{Table, x}, Stack};\n",
        "medium/yaml.rs": "// crate::color is not used\nlet x = crate::film::reflectance();",
        "color.rs": "use crate::stack::solve;",
        "fresnel.rs": "fn f() {}\n#[cfg(test)]\nmod tests { use crate::stack; }",
    }
    assert backward_uses(sources, lib) == ["film.rs -> stack", "medium/yaml.rs -> film"]


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
