"""The house as tables, and checkers that read the code beside them: which crate, module and package may use which.

A new crate, package or top-level module needs one row here. The checkers take plain dicts of names and texts, so that
`test_architecture` can show each of them a planted fault.
"""

from __future__ import annotations

import ast
import io
import posixpath
import re
import tokenize
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath

# --- tables ----------------------------------------------------------------------------------------------------------

# Our crates and which of our crates each may use, in any way (normal, build or dev dependency).
MAY_USE: dict[str, set[str]] = {
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
    "iridesce-inverse": {"iridesce-numerics"},
    "iridesce": {
        "iridesce-inverse",
        "iridesce-numerics",
        "iridesce-optics",
        "iridesce-thickness",
        "iridesce-flow",
        "iridesce-files",
        "iridesce-scene",
        "iridesce-render",
    },
    "iridesce-python": {"iridesce"},
    "iridesce-web": {"iridesce-numerics", "iridesce-optics", "iridesce-thickness", "iridesce-flow"},
}

# Inside a crate that has a row, a top-level module may use the ones before it.
MODULE_ORDER: dict[str, list[str]] = {
    "optics": ["error", "spectrum", "medium", "incidence", "fresnel", "mueller", "film", "stack", "coherence", "color"],
    "inverse": [
        *("error", "cholesky", "tridiagonal", "response", "evidence"),
        *("pixels", "blocks", "lines", "exposure", "neighbours", "regions", "photograph"),
    ],
}

# What stands at the top of `python/iridesce`, from the ground up: each may use the ones before it. "iridesce" is the
# face: the names that `import iridesce` offers.
PACKAGE_ORDER = [
    *("_core", "_interrupts", "_moved", "errors", "arguments", "_progress", "_notebook", "files"),
    *("optics", "_picture_files", "image", "color", "stack", "thickness", "scene", "rendering"),
    *("plot", "inverse", "exchange", "sweeping"),
    *("page", "notebooks"),
    *("iridesce", "cli", "__main__"),
]

# --- graphs ----------------------------------------------------------------------------------------------------------

Graph = Mapping[str, Iterable[str]]


def circles(graph: Graph) -> list[tuple[str, ...]]:
    """Sets of nodes that lead to each other, each sorted (Tarjan, SIAM J. Comput. 1, 146 (1972), without recursion)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []
    for root in sorted(graph):
        if root in index:
            continue
        index[root] = low[root] = len(index)
        stack.append(root)
        work = [(root, iter(sorted(set(graph[root]))))]
        while work:
            node, following = work[-1]
            for other in following:
                if other not in graph:
                    continue
                if other not in index:
                    index[other] = low[other] = len(index)
                    stack.append(other)
                    work.append((other, iter(sorted(set(graph[other])))))
                    break
                if other in stack:
                    low[node] = min(low[node], index[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    members = stack[stack.index(node) :]
                    del stack[stack.index(node) :]
                    if len(members) > 1:
                        found.append(tuple(sorted(members)))
    return sorted(found)


def floors(graph: Graph) -> int:
    """How many storeys a graph without circles has."""
    height: dict[str, int] = {}

    def of(node: str) -> int:
        if node not in height:
            height[node] = 1 + max((of(other) for other in graph[node] if other in graph and other != node), default=0)
        return height[node]

    return max((of(node) for node in graph), default=0)


def upstream_arrows(graph: Graph, order: list[str], room: Mapping[str, str]) -> list[str]:
    """Arrows to a later room, as ``a -> b``; ``room`` says in which room of ``order`` a node stands."""
    place = {name: number for number, name in enumerate(order)}
    return [
        f"{node} -> {other}"
        for node in sorted(graph)
        for other in sorted(set(graph[node]))
        if other in room and place[room[other]] > place[room[node]]
    ]


# --- Python ----------------------------------------------------------------------------------------------------------


def python_modules(folder: Path) -> dict[str, str]:
    """Module name to source for a package on disk, stubs of compiled modules included."""
    modules = {}
    for path in [*folder.rglob("*.py"), *folder.rglob("*.pyi")]:
        parts = (folder.name, *path.relative_to(folder).with_suffix("").parts)
        modules[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path.read_text(encoding="utf-8")
    return modules


def python_arrows(modules: Mapping[str, str]) -> dict[str, set[str]]:
    """Which modules each imports, anywhere in it: at the top, in functions, for type checkers only."""
    return {name: _imports(name, text, modules) - {name} for name, text in modules.items()}


def _imports(name: str, text: str, modules: Mapping[str, str]) -> set[str]:
    used: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            used |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name}: imports name the whole path"
            for alias in node.names:
                inside = f"{node.module}.{alias.name}"
                used.add(inside if inside in modules else node.module or "")
    return used & set(modules)


def python_room(module: str) -> str:
    """What of `PACKAGE_ORDER` a module belongs to."""
    return module.split(".")[1] if "." in module else module


# --- Rust ------------------------------------------------------------------------------------------------------------


def rust_modules(source: Path) -> dict[str, str]:
    """Module path (``stack::march``; "" is the crate's root) to source, without tests."""
    files = {}
    for path in source.rglob("*.rs"):
        parts = path.relative_to(source).with_suffix("").parts
        if parts in (("lib",), ("main",)):
            parts = ()
        elif parts[-1] == "mod":
            parts = parts[:-1]
        files["::".join(parts)] = path.read_text(encoding="utf-8")
    tests = {
        "::".join(filter(None, (parent, child)))
        for parent, text in files.items()
        for child in re.findall(r"#\[cfg\(test\)\]\s*(?:pub(?:\([\w ]+\))? )?mod (\w+);", text)
    }
    return {
        name: without_tests(text)
        for name, text in files.items()
        if not any(name == test or name.startswith(f"{test}::") for test in tests)
    }


def without_tests(text: str) -> str:
    """Rust source up to its unit tests, without comments and texts."""
    text = re.split(r"#\[cfg\(test\)\]\s*mod \w+ \{", text)[0]
    text = re.sub(r"//[^\n]*", "", text)
    return re.sub(r'"(?:[^"\\]|\\.)*"', '""', text)


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


def spread(tree: str) -> list[str]:
    """``a::{b, c::{d, e as f}}`` as ``a::b``, ``a::c::d``, ``a::c::e``."""
    head, brace, rest = tree.partition("{")
    if not brace:
        return [tree.split(" as ")[0].strip()]
    return [head + path for member in split_top_level(rest.rsplit("}", 1)[0]) for path in spread(member)]


def rust_arrows(modules: Mapping[str, str]) -> dict[str, set[str]]:
    """Which modules of the same crate each uses. A name that a module only hands on leads to the module it comes from."""
    handed_on = {name: _handed_on(name, text, modules) for name, text in modules.items()}
    arrows: dict[str, set[str]] = {}
    for name, text in modules.items():
        body = re.sub(r"\bpub(?:\([\w ]+\))? use [^;]+;", "", text)
        paths = [path for tree in re.findall(r"\buse ([^;]+);", body) for path in spread(tree)]
        body = re.sub(r"\buse [^;]+;", "", body)
        paths += re.findall(r"(?<![\w:])(?:\w+::)+\w+", body)
        found = {_home(_absolute(path, name, modules), modules, handed_on) for path in paths}
        arrows[name] = {home for home in found if home is not None} - {name}
    arrows.pop("", None)  # the root only lists and hands on
    return {name: used - {""} for name, used in arrows.items()}


def _absolute(path: str, own: str, modules: Mapping[str, str]) -> list[str] | None:
    """The path from the crate's root, or ``None`` for one that leads out of the crate."""
    parts = re.sub(r"\s+", "", path).split("::")
    here = own.split("::") if own else []
    if parts[0] == "crate":
        return parts[1:]
    if parts[0] == "self":
        return here + parts[1:]
    if parts[0] == "super":
        while parts and parts[0] == "super":
            here, parts = here[:-1], parts[1:]
        return here + parts
    return here + parts if "::".join([*here, parts[0]]) in modules else None


def _handed_on(own: str, text: str, modules: Mapping[str, str]) -> dict[str, list[str]]:
    """Names that a module offers and another one defines: ``pub use stack::{Layer, Stack};``."""
    home = {}
    for tree in re.findall(r"\bpub(?:\([\w ]+\))? use ([^;]+);", text):
        for path in spread(tree):
            absolute = _absolute(path, own, modules)
            if absolute:
                home[absolute[-1]] = absolute
    return home


def _home(
    path: list[str] | None, modules: Mapping[str, str], handed_on: Mapping[str, dict[str, list[str]]]
) -> str | None:
    """The module in which a name is defined, through those that hand it on."""
    seen = []
    while path is not None and path not in seen:
        seen.append(path)
        deepest = max((n for n in range(len(path) + 1) if "::".join(path[:n]) in modules), default=0)
        module, rest = "::".join(path[:deepest]), path[deepest:]
        onward = handed_on.get(module, {}).get(rest[0]) if rest else None
        if onward is None:
            return module
        path = [*onward, *rest[1:]]
    return None


# --- TypeScript ------------------------------------------------------------------------------------------------------


def typescript_modules(source: Path) -> dict[str, str]:
    """Module path (``parts/charts``) to source."""
    return {
        path.relative_to(source).with_suffix("").as_posix(): path.read_text(encoding="utf-8")
        for path in source.rglob("*.ts")
    }


def typescript_arrows(modules: Mapping[str, str]) -> dict[str, set[str]]:
    """Which modules of the page each imports or hands on, types alone too; what leads out of the page is left out."""
    named = re.compile(r"""^(?:import|export)\b[^"';]*?\bfrom\s*["'](\.[^"']+)["']""", re.MULTILINE)
    bare = re.compile(r"""^import\s*["'](\.[^"']+)["']|\bimport\(\s*["'](\.[^"']+)["']""", re.MULTILINE)
    arrows = {}
    for name, text in modules.items():
        paths = named.findall(text) + [one or other for one, other in bare.findall(text)]
        folder = PurePosixPath(name).parent.as_posix()
        found = {posixpath.normpath(posixpath.join(folder, path)).removesuffix(".ts") for path in paths}
        lost = {path for path in found if path not in modules and not PurePosixPath(path).suffix}
        assert not lost, f"{name}: no module {sorted(lost)}"
        arrows[name] = found & set(modules) - {name}
    return arrows


# --- numbers that have one home --------------------------------------------------------------------------------------


def code_of(path: Path) -> str:
    """A source's code, line by line: without comments, texts and, in Rust, the tests at its end."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return _python_code(text)
    return without_tests(re.sub(r"/\*.*?\*/", lambda found: "\n" * found[0].count("\n"), text, flags=re.S))


def _python_code(text: str) -> str:
    lines: dict[int, list[str]] = {}
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in (tokenize.NUMBER, tokenize.NAME, tokenize.OP):
            lines.setdefault(token.start[0], []).append(token.string)
    return "\n".join(" ".join(lines.get(number, [])) for number in range(1, max(lines, default=0) + 1))


def ranges_spelled_out(code: str) -> list[str]:
    """Lines with an end of the visible range (360 or 380 to 780 or 830 nm). 360 alone is an angle, but right behind nm."""
    end = re.compile(r"(?<![\w.])(380|78[01]|83[01])(\.[05])?(?![\w.]*\d)")
    start = re.compile(r"(nm|wavelength)\W{1,6}360(\.0)?(?![\w.]*\d)", re.IGNORECASE)
    return [line for line in code.splitlines() if end.search(line) or start.search(line)]
