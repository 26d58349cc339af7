"""PNG files of 8 or 16 bits with text, written the same byte for byte and read back with all their bits. Internal.

PNG, W3C Recommendation (third edition); no interlacing.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_KINDS = {1: 0, 2: 4, 3: 2, 4: 6}
_SAMPLES = {kind: count for count, kind in _KINDS.items()}
_MOST_PIXELS = 2**26


class PngFile(NamedTuple):
    """What a file holds: whole numbers (height, width, channels), the greatest of the format, texts by keyword."""

    values: NDArray[np.uint16]
    peak: int
    texts: dict[str, str]


def png_bytes(values: NDArray[np.integer], texts: Mapping[str, str], bits: int = 16) -> bytes:
    """A picture (height, width) or (height, width, 1 to 4) of whole numbers of 8 or 16 bits, with its texts."""
    array = np.atleast_3d(values)
    height, width, samples = array.shape
    rows = np.ascontiguousarray(array, dtype=">u2" if bits == 16 else np.uint8).reshape(height, -1).view(np.uint8)
    # Filter 2, differences to the row above: charts change slowly downwards.
    steps = rows.copy()
    steps[1:] = rows[1:] - rows[:-1]
    lines = np.concatenate([np.full((height, 1), 2, np.uint8), steps], axis=1).tobytes()
    head = struct.pack(">IIBBBBB", width, height, bits, _KINDS[samples], 0, 0, 0)
    content = _SIGNATURE + _chunk(b"IHDR", head)
    for key, text in texts.items():
        content += _chunk(b"tEXt", key.encode("latin-1") + b"\0" + text.encode("latin-1", "replace"))
    return content + _chunk(b"IDAT", zlib.compress(lines, 9)) + _chunk(b"IEND", b"")


def read_png(content: bytes, label: str) -> PngFile:
    """All bits of a PNG of 8 or 16 bits; `ValueError` naming ``label`` and what cannot be read."""
    if content[:8] != _SIGNATURE:
        raise ValueError(f"{label}: no PNG file")
    try:
        return _read(content, label)
    except (struct.error, zlib.error, IndexError) as error:
        raise ValueError(f"{label}: damaged PNG file ({error})") from None


def _read(content: bytes, label: str) -> PngFile:
    place, packed, texts, head = 8, b"", {}, None
    while place < len(content):
        (size,) = struct.unpack_from(">I", content, place)
        kind, body = content[place + 4 : place + 8], content[place + 8 : place + 8 + size]
        (check,) = struct.unpack_from(">I", content, place + 8 + size)
        if zlib.crc32(kind + body) != check:
            raise ValueError(f"{label}: damaged PNG file (checksum of {kind.decode('latin-1')})")
        if kind == b"IHDR":
            head = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        elif kind == b"tEXt" and b"\0" in body:
            key, _, text = body.partition(b"\0")
            texts[key.decode("latin-1")] = text.decode("latin-1")
        place += 12 + size
        if kind == b"IEND":
            break
    if head is None:
        raise ValueError(f"{label}: damaged PNG file (no header)")
    width, height, bits, kind_of, _, _, interlace = head
    if bits not in (8, 16) or kind_of not in _SAMPLES or interlace:
        raise ValueError(f"{label}: only PNG of 8 or 16 bits without palette and interlacing is read here")
    if width * height > _MOST_PIXELS or not width * height:
        raise ValueError(f"{label}: {width} x {height} pixels, 1 to {_MOST_PIXELS} are read")
    samples, deep = _SAMPLES[kind_of], bits // 8
    stride = width * samples * deep
    worker = zlib.decompressobj()
    raw = worker.decompress(packed, height * (stride + 1) + 1)
    if len(raw) != height * (stride + 1):
        raise ValueError(f"{label}: damaged PNG file ({len(raw)} bytes of pixels, {height * (stride + 1)} wanted)")
    lines = np.frombuffer(raw, np.uint8).reshape(height, stride + 1)
    rows = _unfiltered(lines, samples * deep, label)
    array = rows.view(">u2" if deep == 2 else np.uint8).reshape(height, width, samples).astype(np.uint16)
    return PngFile(array, 2**bits - 1, texts)


def _unfiltered(lines: NDArray[np.uint8], step: int, label: str) -> NDArray[np.uint8]:
    height, stride = lines.shape[0], lines.shape[1] - 1
    rows = np.zeros((height + 1, stride), np.uint8)  # a row of zeros above the first
    for number, line in enumerate(lines):
        above, row = rows[number], rows[number + 1]
        kind, body = int(line[0]), line[1:]
        if kind == 0:
            row[:] = body
        elif kind == 2:
            row[:] = body + above
        elif kind == 1:
            sums = np.cumsum(body.reshape(-1, step).astype(np.uint64), axis=0)
            row[:] = (sums & 255).astype(np.uint8).reshape(-1)
        elif kind in (3, 4):
            _walk(row, body, above, step, kind)
        else:
            raise ValueError(f"{label}: damaged PNG file (filter {kind} of row {number})")
    return rows[1:]


def _walk(row: NDArray[np.uint8], body: NDArray[np.uint8], above: NDArray[np.uint8], step: int, kind: int) -> None:
    """The two filters in which a byte depends on its left neighbour in a way that no sum expresses."""
    done, up, left_up = [0] * step, [0] * step + above.tolist(), 0
    for at, byte in enumerate(body.tolist()):
        a, b = done[at], up[at + step]
        if kind == 3:
            guess = (a + b) >> 1
        else:
            left_up = up[at]
            whole = a + b - left_up
            gaps = abs(whole - a), abs(whole - b), abs(whole - left_up)
            guess = a if gaps[0] <= gaps[1] and gaps[0] <= gaps[2] else b if gaps[1] <= gaps[2] else left_up
        done.append((byte + guess) & 255)
    row[:] = done[step:]


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
