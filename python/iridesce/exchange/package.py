"""What is asked of a target, and what it makes. Internal."""

from __future__ import annotations

from dataclasses import dataclass, field

from iridesce.arguments.operands import Floats
from iridesce.color import Illuminant
from iridesce.exchange.films import ANGLES_DEG, Film
from iridesce.exchange.pieces import Piece
from iridesce.scene import Scene


@dataclass(frozen=True)
class Request:
    """Films to hand over: those of a scene, or the one of a stack."""

    films: list[Film]
    illuminant: Illuminant
    scene: Scene | None = None
    fit: bool = False
    pieces: list[Piece] = field(default_factory=list)
    """The objects of a scene."""


@dataclass
class Package:
    """Files by name, differences of each film on its chart, and what to tell."""

    files: dict[str, bytes] = field(default_factory=dict)
    differences: dict[str, Floats] = field(default_factory=dict)
    dropped: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    claims_deg: tuple[float, ...] = ANGLES_DEG
    """The angles that the target claims to hold: mean, p95 and max are told over these."""

    def drop(self, sentence: str) -> None:
        """Something that the target cannot hold; said once."""
        if sentence not in self.dropped:
            self.dropped.append(sentence)

    def note(self, sentence: str) -> None:
        """Something a user should know; said once."""
        if sentence not in self.notes:
            self.notes.append(sentence)
