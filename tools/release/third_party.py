"""Write THIRD-PARTY-LICENSES.txt: what is compiled into a wheel, by whom, and under which licence.

    python tools/release/third_party.py            # needs cargo, and `pip install colour-science`
    python tools/release/third_party.py --check    # exit code 1 if the list lacks a package, or holds one that is gone

Walks the normal dependencies of the extension module on the platforms that wheels are built for; procedural macros and
build scripts run at build time and leave nothing behind. The texts are the licence files that each package ships, except
that the Apache licence, which stands in LICENSE-APACHE already, is only named.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
OUTPUT = ROOT / "THIRD-PARTY-LICENSES.txt"
RULE = "=" * 100
PLATFORMS = (
    "x86_64-unknown-linux-gnu",
    "aarch64-unknown-linux-gnu",
    "x86_64-apple-darwin",
    "aarch64-apple-darwin",
    "x86_64-pc-windows-msvc",
)

OPENING = """\
Third-party software and data in iridesce
=========================================

The compiled module of iridesce contains the Rust packages listed here and the Rust standard library (Copyright (c) The
Rust Project Contributors, MIT OR Apache-2.0). iridesce takes a package that offers a choice under MIT where that is one.
The Apache License 2.0 stands whole in LICENSE-APACHE. Written by tools/release/third_party.py.
"""

DATA = """\
Data: the optical constants are pages of the refractiveindex.info database (CC0 1.0), which asks for no notice and is named
with gratitude. The CIE tables were taken from colour-science, whose notice follows at the end."""


def metadata(platform: str) -> dict[str, Any]:
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", platform]
    data: dict[str, Any] = json.loads(
        subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    )
    return data


def host() -> str:
    text = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout
    return next(line.removeprefix("host: ") for line in text.splitlines() if line.startswith("host: "))


def compiled_in(data: dict[str, Any]) -> list[dict[str, Any]]:
    """Packages whose code ends up in the extension module, ours left out, by name and version."""
    packages = {package["id"]: package for package in data["packages"]}
    nodes = {node["id"]: node for node in data["resolve"]["nodes"]}
    root = next(key for key, package in packages.items() if package["name"] == "iridesce-python")
    found: set[str] = set()
    queue = [root]
    while queue:
        current = queue.pop()
        package = packages[current]
        is_macro = any("proc-macro" in target["kind"] for target in package["targets"])
        if current in found or is_macro:
            continue
        found.add(current)
        for dependency in nodes[current]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                queue.append(dependency["pkg"])
    third_party = [packages[key] for key in found if packages[key]["source"] is not None]
    return sorted(third_party, key=lambda package: (package["name"], package["version"]))


def line(package: dict[str, Any]) -> str:
    return f"{package['name']} {package['version']}: {package['license']}"


def notices(package: dict[str, Any]) -> list[str]:
    """The licence files that a package ships, without the Apache licence where there is another."""
    folder = Path(package["manifest_path"]).parent
    names = re.compile(r"(?i)^(licen[cs]e|copying|notice|unlicense)")
    texts = [path.read_text(errors="replace").strip() for path in sorted(folder.iterdir()) if names.match(path.name)]
    texts = [text for text in texts if not re.search(r"Apache License\s+Version 2\.0", text[:400])]
    authors = ", ".join(package["authors"]) or "not named"
    return texts or [f"No licence file is shipped. Licence: {package['license']}. Authors: {authors}."]


def write() -> str:
    everything = {line(package): package for platform in PLATFORMS for package in compiled_in(metadata(platform))}
    packages = [everything[name] for name in sorted(everything)]
    parts = [OPENING, *(f"- {line(package)}" for package in packages), "", DATA]
    by_text: dict[str, list[str]] = {}
    for package in packages:
        for text in notices(package):
            lines = "\n".join(part.rstrip() for part in text.splitlines())
            by_text.setdefault(lines, []).append(f"{package['name']} {package['version']}")
    colour = distribution("colour-science")
    licence = next(file for file in colour.files or [] if file.name.startswith("LICENSE"))
    by_text.setdefault(str(licence.read_text()).strip(), []).append(f"colour-science {colour.version} (data)")
    for text, names in by_text.items():
        parts += ["", RULE, ", ".join(names), RULE, "", text]
    return "\n".join(parts) + "\n"


def differences(text: str) -> list[str]:
    """What the list lacks of the packages compiled in on this platform, and what it holds that Cargo.lock does not."""
    listed = set(re.findall(r"^- (.+)$", text.split(RULE)[0], flags=re.M))
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]
    locked = {f"{package['name']} {package['version']}" for package in lock}
    missing = {line(package) for package in compiled_in(metadata(host()))} - listed
    gone = {text for text in listed if text.split(":")[0] not in locked}
    return [*(f"missing: {name}" for name in sorted(missing)), *(f"gone: {name}" for name in sorted(gone))]


def main() -> int:
    if "--check" in sys.argv:
        wrong = differences(OUTPUT.read_text())
        print(*wrong, sep="\n")
        return int(bool(wrong))
    OUTPUT.write_text(write())
    return 0


if __name__ == "__main__":
    sys.exit(main())
