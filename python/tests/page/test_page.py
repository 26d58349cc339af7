"""The verb ``page`` and the file it opens. What the page does is tested in a browser: ``make test-web``."""

from __future__ import annotations

import hashlib
import re
import webbrowser
from base64 import b64encode
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from iridesce.cli.entry import application
from iridesce.page import SCENES, page_link, page_path


def text() -> str:
    return page_path().read_text(encoding="utf-8")


def test_the_page_is_one_small_file() -> None:
    assert page_path().stat().st_size <= 1_500_000
    # Nothing is fetched: no address with a host, but for names of namespaces.
    hosts = set(
        re.findall(r"https?://([\w.-]+)", re.sub(r"<script type=\"application.*?</script>", "", text(), flags=re.S))
    )
    assert hosts <= {"www.w3.org", "localhost"}, hosts
    assert not re.search(r"<(link|img|script|iframe)[^>]+(src|href)=\"(?!data:)", text())


def test_its_policy_names_its_own_scripts_and_nothing_else() -> None:
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]+)"', text())
    assert policy is not None
    rules = dict(rule.strip().split(" ", 1) for rule in policy[1].split(";"))
    assert rules["default-src"] == "'none'"
    assert "unsafe-inline" not in policy[1] and "http" not in policy[1] and "unsafe-eval'" in rules["script-src"]
    scripts = re.findall(r"<script>(.*?)</script>", text(), flags=re.S)
    assert len(scripts) == 1
    digest = b64encode(hashlib.sha256(scripts[0].encode()).digest()).decode()
    assert rules["script-src"] == f"'sha256-{digest}' 'wasm-unsafe-eval'"
    assert rules["worker-src"] == "blob:"


def test_it_names_no_machine() -> None:
    import gzip
    from base64 import b64decode

    core = re.search(r'id="iridesce-core">([^<]+)<', text())
    assert core is not None
    wasm = gzip.decompress(b64decode(core[1]))
    assert wasm[:4] == b"\0asm"
    assert not re.search(rb"/(?:root|home|Users)/", wasm)


def test_the_verb_opens_a_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []

    def browser(link: str) -> bool:
        opened.append(link)
        return True

    monkeypatch.setattr(webbrowser, "open", browser)
    result = CliRunner().invoke(application(), ["page", "rings"])
    assert result.exit_code == 0, result.output
    assert opened == [page_link("rings")] and opened[0].endswith("#v=1&scene=rings")


def test_the_verb_writes_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> bool:
        raise AssertionError("nothing is to be opened")

    monkeypatch.setattr(webbrowser, "open", refuse)
    result = CliRunner().invoke(application(), ["page", "-o", str(tmp_path / "page.html")])
    assert result.exit_code == 0 and (tmp_path / "page.html").read_bytes() == page_path().read_bytes()


def test_what_it_cannot_open(monkeypatch: pytest.MonkeyPatch) -> None:
    assert CliRunner().invoke(application(), ["page", "pond"]).exit_code == 3
    with pytest.raises(ValueError, match="bubble, rings"):
        page_link("pond")
    assert len(SCENES) == 6
    monkeypatch.setattr(webbrowser, "open", lambda link: False)
    assert CliRunner().invoke(application(), ["page"]).exit_code == 1
