"""A folder that holds a run: what was asked of it, so that ``--resume`` goes on with the same and with nothing else."""

from __future__ import annotations

import contextlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from iridesce.files.trees import NotATree, from_json
from iridesce.files.whole import check_place, read_whole, write_whole

_NAME = "run.json"
# A scene of ten thousand objects, and then some.
_MOST_BYTES = 64 << 20


@dataclass(frozen=True)
class RunFolder:
    """A folder, what its run is called in messages, and the question as plain values."""

    folder: Path
    what: str
    asked: dict[str, Any]

    @classmethod
    def of(cls, folder: Path, what: str, **asked: Any) -> RunFolder:
        """The question as JSON gives it back: tuples as lists, numpy's numbers as plain ones."""
        return cls(folder, what, json.loads(json.dumps(asked)))

    def check_new(self, may_hold_other_files: bool = False) -> None:
        """Refuse a folder that is in use; nothing is written yet."""
        if (self.folder / _NAME).exists():
            raise ValueError(f"{self.folder} holds {self.what}; --resume goes on with it, another name starts afresh")
        if self.folder.is_dir():
            if not may_hold_other_files and any(self.folder.iterdir()):
                raise ValueError(f"{self.folder} is not empty; name a new folder")
            check_place(self.folder / _NAME)

    def start(self, **learnt: Any) -> None:
        """Make the folder, and write down what was asked and what has been learnt since."""
        self.folder.mkdir(parents=True, exist_ok=True)
        write_whole(self.folder / _NAME, (json.dumps({**self.asked, **learnt}, indent=1) + "\n").encode())

    def taken_up(self) -> dict[str, Any]:
        """What the folder's run has learnt; ``ValueError`` where it is not the same run."""
        description = self.folder / _NAME
        if not description.exists():
            raise ValueError(f"{self.folder} holds no {self.what.removeprefix('a ')} to resume: no {_NAME}")
        try:
            before = from_json(read_whole(str(description), _MOST_BYTES), str(description))
            differing = [key for key, value in self.asked.items() if before[key] != value]
        except (NotATree, KeyError, TypeError, AttributeError):
            raise ValueError(f"{description} is not the description of {self.what}") from None
        if differing:
            key = differing[0]
            was, now = json.dumps(before[key]), json.dumps(self.asked[key])
            raise ValueError(
                f"{self.folder} holds {self.what} with another {key}: {was:.80}, not {now:.80}; --resume takes the same"
            )
        return {key: value for key, value in before.items() if key not in self.asked}

    def remove(self) -> None:
        """Take the description away, and the folder if nothing else is in it."""
        (self.folder / _NAME).unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            self.folder.rmdir()
