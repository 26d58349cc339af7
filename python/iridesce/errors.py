"""The errors a user can meet; all are ``ValueError`` so that one ``except`` catches them."""

from __future__ import annotations


class SceneError(ValueError):
    """A scene that cannot be used; ``file``, ``line`` and ``key`` tell where (``None`` where unknown).

    >>> import iridesce as ir
    >>> try:
    ...     ir.Scene.load("soap-bubble").with_value("camera.fov_deg", -3)
    ... except ir.SceneError as error:
    ...     print(error.key)
    camera.fov_deg
    """

    def __init__(self, message: str, file: str | None = None, line: int | None = None, key: str | None = None):
        super().__init__(message)
        self.file = file
        self.line = line
        self.key = key


class ResourceError(ValueError):
    """Something that cannot fit: an image, a grid or a scene larger than the machine can hold.

    >>> import iridesce as ir
    >>> ir.thickness.uniform(320.0).map(10**6, 10**6)
    Traceback (most recent call last):
    iridesce.errors.ResourceError: a map has at most 1073741824 cells, got 1000000 x 1000000
    """
