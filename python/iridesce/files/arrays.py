"""NumPy's NPY files: what a header declares is held against the bytes that are there before memory is taken. Internal."""

from __future__ import annotations

import io
import math
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt


def head_of(file: BinaryIO) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type that an NPY file declares; the file then stands at its numbers. ``ValueError`` as of `array_of`."""
    from iridesce import _core

    try:
        major, _ = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0 if major == 1 else np.lib.format.read_array_header_2_0
        shape, _, kind = read(file)
    except (ValueError, EOFError) as error:
        raise ValueError(f"no NPY file that can be read: {_core.harmless(str(error))}") from None
    return shape, kind


def array_of(content: bytes) -> npt.NDArray[Any]:
    """The array in the content of an NPY file. ``ValueError`` with words that go on after the file's name.

    >>> import io
    >>> import numpy as np
    >>> file = io.BytesIO()
    >>> np.save(file, [1.0, 2.0])
    >>> array_of(file.getvalue())
    array([1., 2.])
    >>> array_of(file.getvalue()[:-1])
    Traceback (most recent call last):
    ValueError: damaged NPY: numbers of the shape (2,) take 16 bytes, 15 follow the header
    """
    from iridesce import _core

    file = io.BytesIO(content)
    shape, kind = head_of(file)
    there = len(content) - file.tell()
    if kind.hasobject:
        raise ValueError("its elements are Python objects, which are not read")
    if any(length < 0 for length in shape) or math.prod(shape) * kind.itemsize != there:
        needed = math.prod(shape) * kind.itemsize
        raise ValueError(
            f"damaged NPY: numbers of the shape {_core.harmless(str(shape))} take {needed} bytes, {there} follow the header"
        )
    file.seek(0)
    found: npt.NDArray[Any] = np.load(file, allow_pickle=False)
    return found
