"""What a wheel needs: the notices of what is compiled in, the questions it is asked, the workflow that publishes it."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from types import ModuleType

import pytest

from conftest import ROOT

NOTICES = ROOT / "THIRD-PARTY-LICENSES.txt"
WORKFLOW = ROOT / ".github" / "workflows" / "release.yml"


def tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / "release" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


third_party = tool("third_party")
check_wheel = tool("check_wheel")


def test_every_package_compiled_in_is_named() -> None:
    assert third_party.differences(NOTICES.read_text()) == [], "run: python tools/release/third_party.py"


def test_a_package_that_is_not_named_or_gone_is_seen() -> None:
    text = NOTICES.read_text()
    line = next(line for line in text.splitlines() if line.startswith("- rayon "))
    assert third_party.differences(text.replace(f"{line}\n", "")) == [f"missing: {line[2:]}"]
    assert third_party.differences(text.replace(line, f"{line}\n- phlogiston 1.0.0: MIT")) == [
        "gone: phlogiston 1.0.0: MIT"
    ]


def test_the_notices_hold_the_texts_they_owe() -> None:
    text = NOTICES.read_text()
    for name, phrase in {
        "exr": "Redistribution and use in source and binary forms",
        "numpy": "Redistribution and use in source and binary forms",
        "rayon": "Permission is hereby granted, free of charge",
        "colour-science": "Redistribution and use in source and binary forms",
    }.items():
        heading = re.search(
            rf"^={{100}}\n[^\n]*\b{name} \d[^\n]*\n={{100}}\n(.*?)(?=\n={{100}}\n|\Z)", text, re.M | re.S
        )
        assert heading is not None, name
        assert phrase in heading[1], name


def test_the_wheel_carries_all_licences() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert set(project["license-files"]) == {"LICENSE-MIT", "LICENSE-APACHE", NOTICES.name}
    assert all((ROOT / name).is_file() for name in project["license-files"])


# --- the questions


def ask(folder: Path, questions: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PATH": check_wheel.without_rust(os.environ["PATH"])}
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", questions], cwd=folder, env=environment, capture_output=True, text=True
    )


def test_the_questions_are_answered(tmp_path: Path) -> None:
    answered = ask(tmp_path, check_wheel.QUESTIONS)
    assert answered.returncode == 0, answered.stderr
    assert "glass 0.040000000000" in answered.stdout


def test_a_wrong_answer_is_not_taken(tmp_path: Path) -> None:
    wrong = check_wheel.QUESTIONS.replace('"thickness_nm": 0.0', '"thickness_nm": -1.0')
    assert wrong != check_wheel.QUESTIONS
    assert ask(tmp_path, wrong).returncode != 0
    wrong = check_wheel.QUESTIONS.replace("glass - 0.04", "glass - 0.05")
    assert wrong != check_wheel.QUESTIONS
    assert ask(tmp_path, wrong).returncode != 0


def wheel(folder: Path, name: str, *left_out: str, library: str = "") -> Path:
    licences = [f"iridesce-1.0.dist-info/licenses/{text}" for text in ("LICENSE-MIT", "LICENSE-APACHE", NOTICES.name)]
    path = folder / name
    with zipfile.ZipFile(path, "w") as archive:
        for member in ("iridesce/_core.abi3.so", "iridesce/_core.pyi", "iridesce/py.typed", *licences):
            if not any(part in member for part in left_out):
                archive.writestr(member, library if "_core.abi3" in member else "")
    return path


def test_a_wheel_is_looked_into(tmp_path: Path) -> None:
    check_wheel.check_contents(wheel(tmp_path, "iridesce-1.0-cp311-abi3-any.whl"))
    with pytest.raises(AssertionError, match="no abi3 wheel"):
        check_wheel.check_contents(wheel(tmp_path, "iridesce-1.0-cp313-cp313-any.whl"))
    for part in ("_core.abi3.so", "py.typed", "LICENSE-MIT", NOTICES.name):
        with pytest.raises(AssertionError):
            check_wheel.check_contents(wheel(tmp_path, "iridesce-1.0-cp311-abi3-any.whl", part))


@pytest.mark.parametrize("separator", ["/", "\\"])
def test_a_library_says_nothing_of_its_builder(tmp_path: Path, separator: str) -> None:
    # The path is put together here: a test of the sources refuses files that spell one.
    root = "C:\\Users" if separator == "\\" else "/home"
    home = separator.join([root, "me", ".cargo", "registry", "src", "exr"])
    check_wheel.check_contents(wheel(tmp_path, "iridesce-1.0-cp311-abi3-any.whl", library="cargo/registry/src/exr"))
    with pytest.raises(AssertionError, match="names the home of its builder"):
        check_wheel.check_contents(wheel(tmp_path, "iridesce-1.0-cp311-abi3-any.whl", library=home))


def test_a_path_without_rust_keeps_the_rest(tmp_path: Path) -> None:
    with_rust, without = tmp_path / "rust", tmp_path / "other"
    for folder in (with_rust, without):
        folder.mkdir()
    program = with_rust / ("cargo.exe" if os.name == "nt" else "cargo")
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    assert check_wheel.without_rust(os.pathsep.join([str(with_rust), str(without)])) == str(without)


# --- the workflow


def test_the_workflow_publishes_without_secrets_and_asks_before() -> None:
    text = WORKFLOW.read_text()
    assert "secrets." not in text
    assert not re.search(r"(?i)\b(password|token)\s*:(?! write)", text)
    publish = text[text.index("\n  publish:") :]
    assert "id-token: write" in publish
    assert "startsWith(github.ref, 'refs/tags/')" in publish
    assert "needs: [ask, sdist]" in publish
    assert text.count("id-token: write") == 1
    for script in set(re.findall(r"python (tools/\S+\.py)", text)):
        assert (ROOT / script).is_file(), script
    built = set(re.findall(r"name: ([\w-]+), runner: \S+, target:", text))
    asked = set(re.findall(r"name: ([\w-]+), runner: \S+, python:", text))
    assert built == asked == {"linux-x86_64", "linux-aarch64", "macos-universal2", "windows-x86_64"}
