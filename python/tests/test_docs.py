"""Every code block of the documentation runs, and every link of it leads somewhere.

Languages: `python` blocks are doctests (or plain code), one namespace a file; `console` blocks are `$ command` with
its output; `bash` blocks are run line by line; `toml` blocks are scenes, saved under the name that the text before them
gives; `text` is not run. All blocks of a file share one temporary folder.
"""

from __future__ import annotations

import doctest
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

import command_line
import iridesce as ir
from conftest import ROOT

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
OPTIONS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
LANGUAGES = {"python", "console", "bash", "toml", "text"}

# What a shell block may say besides `iridesce`: not run here, because the tests run inside their result.
INSTALLERS = ("pip install ", "maturin develop")


@dataclass(frozen=True)
class Block:
    language: str
    text: str
    line: int
    before: str


def blocks(page: str) -> Iterator[Block]:
    """The fenced blocks of a Markdown text."""
    start, language, inside, previous = 0, "", False, 0
    lines = page.splitlines()
    for number, line in enumerate(lines, start=1):
        if not line.startswith("```"):
            continue
        if inside:
            before = "\n".join(lines[previous : start - 1])
            yield Block(language, "\n".join(lines[start : number - 1]) + "\n", start + 1, before)
            previous = number
        else:
            start, language = number, line[3:].strip()
        inside = not inside
    assert not inside, "a block is not closed"


def run_command(command: str, folder: Path) -> str:
    """Run `iridesce ...` in a folder; what it prints."""
    words = shlex.split(command, comments=True)
    assert words[0] == "iridesce", f"not run in the documentation: {command}"
    if words[1:2] == ["render"] and "--samples" not in words:
        # Nobody looks at the picture here; a reader's machine takes seconds for its noise.
        words += ["--samples", "1"]
    finished = command_line.run(words[1:], folder)
    assert finished.returncode == 0, f"{command}: exit {finished.returncode}\n{finished.stderr}"
    return finished.stdout


def run_shell_line(line: str, folder: Path) -> None:
    for part in line.split("&&"):
        command = part.partition(" #")[0].strip()
        if not command or command.startswith("#") or command.startswith(INSTALLERS):
            continue
        if command.startswith("make "):
            targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), flags=re.M))
            assert set(command.split()[1:]) <= targets, f"no such target: {command}"
            continue
        run_command(command, folder)


def run_console(text: str, folder: Path) -> None:
    checker = doctest.OutputChecker()
    for example in re.split(r"^\$ ", text, flags=re.M)[1:]:
        command, _, wanted = example.partition("\n")
        got = run_command(command, folder)
        assert checker.check_output(wanted, got, OPTIONS), f"$ {command}\nwanted:\n{wanted}\ngot:\n{got}"


def run_python(block: Block, names: dict[str, object], page: str) -> None:
    if ">>>" not in block.text:
        exec(compile(block.text, f"{page}:{block.line}", "exec"), names)
        return
    test = doctest.DocTestParser().get_doctest(block.text, names, page, page, block.line - 1)
    report: list[str] = []
    result = doctest.DocTestRunner(optionflags=OPTIONS).run(test, out=report.append, clear_globs=False)
    names.update(test.globs)
    assert result.failed == 0, "".join(report)


def run_page(text: str, page: str, folder: Path) -> int:
    """Run every block of a page in a folder; how many there were to run."""
    names: dict[str, object] = {"__name__": "documentation"}
    count = 0
    for block in blocks(text):
        assert block.language in LANGUAGES, f"{page}:{block.line}: language {block.language!r} is not among {LANGUAGES}"
        count += block.language != "text"
        if block.language == "python":
            run_python(block, names, page)
        elif block.language == "console":
            run_console(block.text, folder)
        elif block.language == "bash":
            for line in block.text.splitlines():
                run_shell_line(line, folder)
        elif block.language == "toml":
            named = re.findall(r"`([\w.-]+\.toml)`", block.before)
            path = folder / (named[-1] if named else "scene.toml")
            path.write_text(block.text)
            ir.Scene.load(path)
    return count


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_page_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run_page(path.read_text(), path.relative_to(ROOT).as_posix(), tmp_path)


def test_the_pages_that_must_show_something_do(tmp_path: Path) -> None:
    for name in ("README.md", "docs/reference/conventions.md", "docs/reference/theory.md"):
        shown = [block for block in blocks((ROOT / name).read_text()) if block.language == "python"]
        assert len(shown) >= 2, name


@pytest.mark.parametrize(
    "page",
    [
        "```python\n>>> 1 + 1\n3\n```",
        "```python\nassert False\n```",
        "```console\n$ iridesce --version\niridesce 99\n```",
        "```bash\niridesce no-such-verb\n```",
        "```bash\nmake no-such-target\n```",
        "```bash\nrm -r somewhere\n```",
        "```toml\nversion = 1\n```",
        "```perl\n1\n```",
        "```python\n",
    ],
)
def test_a_wrong_page_is_refused(page: str, tmp_path: Path) -> None:
    with pytest.raises((AssertionError, ValueError)):
        run_page(page, "page.md", tmp_path)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(path: Path) -> None:
    prose = re.sub(r"```.*?```", "", path.read_text(), flags=re.S)
    for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", prose):
        if not target.startswith(("http://", "https://")):
            assert (path.parent / target).exists(), f"{path.name}: {target}"
    # Paths in backquotes that point into the repository.
    for target in re.findall(r"`((?:crates|python|docs|scenes)/[\w./-]+)`", prose):
        assert (ROOT / target).exists(), f"{path.name}: {target}"


def test_readme_opens_with_a_picture_and_its_command() -> None:
    opening = (ROOT / "README.md").read_text().splitlines()[:10]
    picture = re.search(r"!\[[^]]+\]\((docs/images/[\w-]+\.png)\)", "\n".join(opening))
    assert picture is not None
    assert (ROOT / picture[1]).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert any("iridesce render soap-bubble" in line for line in opening)


def test_the_readme_names_every_verb_and_scene() -> None:
    from iridesce.cli.entry import VERBS
    from iridesce.scene import scene_names

    text = (ROOT / "README.md").read_text()
    listed = text[text.index("The command line answers `--help`") :].split("\n\n")[0]
    assert set(re.findall(r"`(\w+)`", listed)) >= set(VERBS), "a verb is missing from the README's list"
    assert set(re.findall(r"`(\w+)`", listed)) <= set(VERBS) | {"iridesce"}
    gallery = text + (ROOT / "docs" / "guide" / "gallery.md").read_text()
    assert [name for name in scene_names() if name not in gallery] == []


def test_the_tasks_teach_what_newcomers_did_not_find() -> None:
    text = (ROOT / "docs" / "guide" / "tasks.md").read_text()
    run = "\n".join(block.text for block in blocks(text) if block.language in ("python", "bash", "console"))
    for call in ("ir.ColorTable(", ".to_xarray(", ".jones(", ".mueller(", ".derivatives(", "--set object."):
        assert call in run, call


def test_every_test_that_the_page_of_faults_names_is_there() -> None:
    # (What follows them are figures.)
    text = (ROOT / "docs" / "evidence" / "faults.md").read_text().partition("## Ctrl-C")[0]
    rows = [
        line for line in text.splitlines() if line.startswith("| ") and not line.startswith(("| input", "| what |"))
    ]
    for row in rows:
        named = re.findall(r"`([\w/]+\.(?:py|rs))::(\w+)`", row)
        assert named, f"no test: {row}"
        for file, test in named:
            source = ROOT / ("crates" if file.endswith(".rs") else "python/tests") / file
            assert re.search(rf"\b(def|fn) {test}\(", source.read_text()), f"{file} has no {test}"


def test_references_are_whole() -> None:
    text = (ROOT / "docs" / "reference" / "references.bib").read_text()
    keys = re.findall(r"^@\w+\{(\w+),", text, flags=re.M)
    assert len(keys) == len(set(keys)) >= 10
    assert text.count("{") == text.count("}")
    for entry in re.split(r"^@", text, flags=re.M)[1:]:
        assert {"author", "title", "year"} <= set(re.findall(r"\b(\w+) = \{", entry)), entry.split(",")[0]


def test_every_computed_picture_is_shown_and_has_its_function() -> None:
    """The pictures that tools/pictures/doc_images.py draws, the ones in docs/images, the ones that a page shows: the same."""
    source = (ROOT / "tools" / "pictures" / "doc_images.py").read_text()
    drawn = {name.replace("_", "-") for name in re.findall(r"^@picture\ndef (\w+)\(", source, flags=re.M)}
    kinds = tuple({name.split("-")[0] for name in drawn})
    present = {path.stem for path in (ROOT / "docs" / "images").glob("*.png") if path.stem.startswith(kinds)}
    text = "".join(path.read_text() for path in PAGES)
    shown = {name for name in re.findall(r"images/([\w-]+)\.png", text) if name.startswith(kinds)}
    assert drawn == present == shown
