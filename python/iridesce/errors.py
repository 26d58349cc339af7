"""The errors a user can meet; all are ``ValueError`` so that one ``except`` catches them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class ArgumentError(ValueError):
    """An argument outside what is allowed; its message is made of the parts, or a sentence of its own beside them.

    argument   its name
    allowed    what is allowed, to be read after "must be", or after "must" where a verb begins it ("have one axis")
    given      what was given, in words
    place      where in it: "at index (3, 7)", "in layer 2"; empty where there is only one place

    >>> import iridesce as ir
    >>> film = ir.Stack(["air", ir.Layer("soap", thickness_nm=320.0), "air"])
    >>> try:
    ...     film.reflectance([550.0, -1.0])
    ... except ir.ArgumentError as error:
    ...     print(error, [error.argument, error.allowed, error.given, error.place], sep="\\n")
    wavelength_nm must be > 0 and finite, got -1.0 at index (1,)
    ['wavelength_nm', '> 0 and finite', '-1.0', 'at index (1,)']
    """

    def __init__(self, message: str, argument: str = "", allowed: str = "", given: str = "", place: str = ""):
        super().__init__(message)
        self.argument = argument
        self.allowed = allowed
        self.given = given
        self.place = place


class SceneError(ValueError):
    """A scene that cannot be used; ``file``, ``line`` and ``key`` tell where (``None`` where unknown).

    ``errors`` holds all that is wrong with the scene, a SceneError for each; the first of them lends the whole its place.

    >>> import iridesce as ir
    >>> try:
    ...     ir.Scene.load("soap-bubble").with_value("camera.fov_deg", -3)
    ... except ir.SceneError as error:
    ...     print(error.key)
    camera.fov_deg
    >>> try:
    ...     ir.Scene.load({"version": 1, "camera": {"fov": 30.0}})
    ... except ir.SceneError as error:
    ...     print([one.key for one in error.errors])
    ['object', 'light', 'camera.fov']
    """

    def __init__(
        self,
        message: str,
        file: str | None = None,
        line: int | None = None,
        key: str | None = None,
        others: Sequence[tuple[str, str | None, int | None, str | None]] = (),
    ):
        super().__init__(message)
        self.file = file
        self.line = line
        self.key = key
        self._others = tuple(others)

    @property
    def errors(self) -> list[SceneError]:
        """Every complaint about the scene by itself, in the order of reading; this one alone where it is the only one."""
        if not self._others:
            return [self]
        own = SceneError(str(self).split("\n", 1)[0], self.file, self.line, self.key)
        return [own, *(SceneError(*other) for other in self._others)]

    def __reduce__(self) -> tuple[Any, ...]:
        return (SceneError, (str(self), self.file, self.line, self.key, self._others))


class ResourceError(ValueError):
    """Something that cannot fit: an image, a grid or a scene larger than the machine can hold.

    >>> import iridesce as ir
    >>> ir.thickness.uniform(320.0).map(10**6, 10**6)
    Traceback (most recent call last):
    iridesce.errors.ResourceError: a map has at most 1073741824 cells, got 1000000 x 1000000
    """
