"""The folder that `--resume` goes by."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from iridesce.cli.run_folder import RunFolder


def asked(folder: Path, **changes: object) -> RunFolder:
    return RunFolder.of(folder, "a run", **{"preset": "late", "size": (3, 4), "fps": 30.0, **changes})


def test_the_same_run_is_taken_up_with_what_it_has_learnt(tmp_path: Path) -> None:
    run = asked(tmp_path / "run")
    run.check_new()
    assert not (tmp_path / "run").exists(), "nothing is written before the start"
    run.start()
    assert asked(tmp_path / "run").taken_up() == {}
    run.start(stops=1.5)
    assert asked(tmp_path / "run").taken_up() == {"stops": 1.5}
    run.remove()
    assert not (tmp_path / "run").exists()


def test_another_run_is_refused_and_the_difference_named(tmp_path: Path) -> None:
    asked(tmp_path / "run").start()
    for change, words in {"fps": "another fps: 30.0, not 25.0", "size": r"another size: \[3, 4\], not \[9\]"}.items():
        with pytest.raises(ValueError, match=f"holds a run with {words}; --resume takes the same"):
            asked(tmp_path / "run", **{change: {"fps": 25.0, "size": [9]}[change]}).taken_up()


@pytest.mark.parametrize("text", ["", "[]", "3", '{"preset": "late"}', "\ufffd{", "null"])
def test_what_is_no_description(text: str, tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text(text)
    with pytest.raises(ValueError, match="not the description of a run"):
        asked(tmp_path).taken_up()


def test_a_folder_in_use_is_no_place_to_start(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"holds no run to resume: no run\.json"):
        asked(tmp_path).taken_up()
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(ValueError, match="is not empty"):
        asked(tmp_path).check_new()
    asked(tmp_path).check_new(may_hold_other_files=True)
    asked(tmp_path).start()
    with pytest.raises(ValueError, match="holds a run; --resume goes on with it"):
        asked(tmp_path).check_new(may_hold_other_files=True)
    asked(tmp_path).remove()
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]
    assert json.dumps(asked(tmp_path).asked["size"]) == "[3, 4]"
