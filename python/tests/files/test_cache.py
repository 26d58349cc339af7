"""Where the user's cache is: the place that `platformdirs` knows for each system."""

from __future__ import annotations

from pathlib import Path

import platformdirs
import pytest

from iridesce.files import cache


@pytest.mark.parametrize("base", [None, "an absolute folder"])
def test_the_folder_is_the_system_s_own(base: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(cache.VARIABLE, raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    if base is not None and platformdirs.PlatformDirs.__name__ == "Unix":
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / base))
    assert cache.folder() == Path(platformdirs.user_cache_dir("iridesce", appauthor=False))


def test_the_variable_goes_first_and_a_relative_base_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "here")  # to be ignored, says the XDG base directory specification
    monkeypatch.delenv(cache.VARIABLE, raising=False)
    assert cache.folder().is_absolute()
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    assert cache.folder() == tmp_path
