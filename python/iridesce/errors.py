"""The errors a user can meet; all are ``ValueError`` so that one ``except`` catches them."""

from __future__ import annotations


class SceneError(ValueError):
    """A scene that cannot be used; ``file``, ``line`` and ``key`` tell where (``None`` where unknown)."""

    def __init__(self, message: str, file: str | None = None, line: int | None = None, key: str | None = None):
        super().__init__(message)
        self.file = file
        self.line = line
        self.key = key


class ResourceError(ValueError):
    """Something that cannot fit: an image, a grid or a scene larger than the machine can hold."""
