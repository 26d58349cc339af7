"""The structure of the code in numbers: modules, floors, circles, arrows upstream, long files and functions, copies.

`python bench/structure.py [FOLDER ...]` counts in this repository, or in others: that of an older commit is made by
`git worktree add FOLDER COMMIT`. Needs Python alone. What the tests hold to is counted by their own means
(`python/tests/house.py`); tests are not counted.
"""

from __future__ import annotations

import ast
import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(HERE / "python" / "tests"))

import house  # noqa: E402  (its folder is no package)

LONG_FILE, LONG_FUNCTION = 500, 60
# Lines of code, blank ones and brackets aside, that two places share word for word to count as a pair.
COPY = 8

SOURCES = {
    "Rust": ("crates/*/src/**/*.rs",),
    "Python": ("python/iridesce/**/*.py",),
    "TypeScript": ("web/src/**/*.ts",),
}


def sources(root: Path, language: str) -> dict[str, str]:
    """File to source, without files of tests and, in Rust, without the tests at a file's end."""
    files = {}
    for place in SOURCES[language]:
        for path in sorted(root.glob(place)):
            name = path.relative_to(root).as_posix()
            if path.stem != "tests" and "/laws/" not in name:
                text = path.read_text(encoding="utf-8")
                files[name] = re.split(r"#\[cfg\(test\)\]\s*mod \w+ \{", text)[0] if language == "Rust" else text
    return files


def graphs(root: Path) -> dict[str, dict[str, set[str]]]:
    """By language: which module uses which. Modules of Rust are named after their crate."""
    rust: dict[str, set[str]] = {}
    for crate in sorted(path for path in (root / "crates").iterdir() if (path / "src").is_dir()):
        arrows = house.rust_arrows(house.rust_modules(crate / "src"))
        rust |= {f"{crate.name}::{name}": {f"{crate.name}::{one}" for one in used} for name, used in arrows.items()}
    found = {"Rust": rust}
    found["Python"] = house.python_arrows(house.python_modules(root / "python" / "iridesce"))
    if (root / "web" / "src").is_dir():
        found["TypeScript"] = house.typescript_arrows(house.typescript_modules(root / "web" / "src"))
    return found


def floors(graph: Mapping[str, Iterable[str]]) -> int:
    """Storeys, modules of a circle on one."""
    home = {node: node for node in graph} | {node: ring[0] for ring in house.circles(graph) for node in ring}
    merged: dict[str, set[str]] = defaultdict(set)
    for node, used in graph.items():
        merged[home[node]] |= {home[one] for one in used if one in home} - {home[node]}
    return house.floors(merged)


def upstream(root: Path, language: str, graph: Mapping[str, set[str]]) -> str:
    """Arrows against the order of `house.py`; "-" for a tree that it does not describe."""
    if language == "Python":
        rooms = {name: house.python_room(name) for name in graph}
        if not set(rooms.values()) <= set(house.PACKAGE_ORDER):
            return "-"
        return str(len(house.upstream_arrows(graph, house.PACKAGE_ORDER, rooms)))
    if language == "Rust":
        against = 0
        for crate, order in house.MODULE_ORDER.items():
            arrows = house.rust_arrows(house.rust_modules(root / "crates" / crate / "src"))
            rooms = {name: row for name in arrows for row in order if re.match(rf"{row}(_|::|$)", name)}
            if set(rooms) != set(arrows):
                return "-"
            against += len(house.upstream_arrows(arrows, order, rooms))
        return f"{against} (in {', '.join(house.MODULE_ORDER)}, which have an order beside that of the crates)"
    return "-"


def functions(language: str, text: str) -> list[tuple[str, int]]:
    """Name and lines of each function: from its first line to its last, without its documentation."""
    if language == "Python":
        return [
            (node.name, (node.end_lineno or node.lineno) - node.lineno + 1 - _docstring(node))
            for node in ast.walk(ast.parse(text))
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        ]
    lines = text.splitlines()
    start = re.compile(
        r"^(\s*)(?:pub(?:\([\w ]+\))? )?(?:const |async |unsafe )*fn (\w+)"
        if language == "Rust"
        else r"^(\s*)(?:export |private |protected |static |readonly )*(?:async )?(?:function )?(\w+)[^=;]*\{$"
    )
    found = []
    for number, line in enumerate(lines):
        begun = start.match(line)
        if begun is None or begun[2] in {"if", "for", "while", "switch", "else", "try", "class", "interface", "return"}:
            continue
        # Formatted code: the bracket that ends a function stands under its first letter.
        for last in range(number, len(lines)):
            if lines[last].startswith(f"{begun[1]}}}") or (last == number and re.search(r"\{.*\}$|;$", line)):
                found.append((begun[2], last - number + 1))
                break
    return found


def _docstring(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    if ast.get_docstring(node) is None:
        return 0
    first = node.body[0]
    return (first.end_lineno or first.lineno) - first.lineno + 1


def copies(files: Mapping[str, str]) -> list[tuple[str, str, int]]:
    """Pairs of places with the same `COPY` lines of code or more: where, where else, how many lines."""
    places: dict[tuple[str, ...], list[tuple[str, int]]] = defaultdict(list)
    code: dict[str, list[tuple[int, str]]] = {}
    for name, text in files.items():
        kept = [(number, line.strip()) for number, line in enumerate(text.splitlines(), 1)]
        code[name] = [(number, line) for number, line in kept if _tells(line)]
        for at in range(len(code[name]) - COPY + 1):
            places[tuple(line for _, line in code[name][at : at + COPY])].append((name, at))
    pairs = {(one, other) for found in places.values() for i, one in enumerate(found) for other in found[i + 1 :]}
    result = []
    for (file, at), (other, there) in sorted(pairs):
        if ((file, at - 1), (other, there - 1)) in pairs or (file == other and there - at < COPY):
            continue
        length = COPY
        while ((file, at + length - COPY + 1), (other, there + length - COPY + 1)) in pairs:
            length += 1
        result.append((f"{file}:{code[file][at][0]}", f"{other}:{code[other][there][0]}", length))
    return result


def _tells(line: str) -> bool:
    return len(line) > 3 and not line.startswith(("//", "#", "use ", "import ", "from ", "*", '"""'))


def report(root: Path) -> None:
    print(root.name)
    by_language = graphs(root)
    every: dict[str, str] = {}
    for language, graph in by_language.items():
        files = sources(root, language)
        every |= files
        rings = house.circles(graph)
        lengths = {name: len(text.splitlines()) for name, text in files.items()}
        long = sorted(
            ((lines, one, name) for name, text in files.items() for one, lines in functions(language, text)),
            reverse=True,
        )
        too_long = [one for one in long if one[0] > LONG_FUNCTION]
        print(f"\n  {language}: {len(files)} files, {sum(lengths.values())} lines")
        print(f"    modules {len(graph)}, arrows {sum(map(len, graph.values()))}, floors {floors(graph)}")
        print(f"    circles {len(rings)} ({', '.join(str(len(ring)) for ring in rings) or 'none'} modules)")
        print(f"    arrows upstream {upstream(root, language, graph)}")
        largest = sorted(((lines, name) for name, lines in lengths.items()), reverse=True)
        print(f"    files past {LONG_FILE} lines {sum(lines > LONG_FILE for lines, _ in largest)}; largest:")
        for lines, name in largest[:5]:
            print(f"      {lines:5} {name}")
        print(f"    functions {len(long)}, past {LONG_FUNCTION} lines {len(too_long)}; longest:")
        for lines, one, name in long[:5]:
            print(f"      {lines:5} {one} in {name}")
    found = copies(every)
    print(f"\n  pairs of places with the same {COPY} lines or more: {len(found)}")
    for one, other, length in sorted(found, key=lambda pair: -pair[2])[:12]:
        print(f"      {length:4} {one} = {other}")


if __name__ == "__main__":
    for folder in sys.argv[1:] or [str(HERE)]:
        report(Path(folder).resolve())
