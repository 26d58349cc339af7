"""Small OpenEXR files, written the same byte for byte and read back: scan lines, one part. Internal.

Written: half or float channels, ZIP. Read: half, float and uint channels; no compression, RLE, ZIPS, ZIP.
Layout: "The OpenEXR File Layout", openexr.com.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Attribute = str | int | float | tuple[float, ...]

_MAGIC = 20000630
_KINDS: dict[int, np.dtype[Any]] = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
_LINES = {0: 1, 1: 1, 2: 1, 3: 16}
_NAMES = {4: "PIZ", 5: "PXR24", 6: "B44", 7: "B44A", 8: "DWAA", 9: "DWAB"}
_MOST_PIXELS = 2**26
_FLAGS = {0x200: "tiles", 0x800: "deep data", 0x1000: "several parts"}


class ExrFile(NamedTuple):
    """What a file holds."""

    channels: dict[str, NDArray[np.float32]]
    attributes: dict[str, Attribute]


def exr_bytes(channels: Mapping[str, NDArray[np.floating]], attributes: Mapping[str, Attribute]) -> bytes:
    """A file of channels of one shape, float16 or float32; texts, whole numbers, numbers and tuples as attributes."""
    names = sorted(channels)
    height, width = channels[names[0]].shape
    half = {name: channels[name].dtype == np.float16 for name in names}
    head = struct.pack("<II", _MAGIC, 2 | (0x400 if any(len(name) > 31 for name in attributes) else 0))
    listed = b"".join(
        name.encode("ascii") + b"\0" + struct.pack("<IB3xII", 1 if half[name] else 2, 0, 1, 1) for name in names
    )
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    required = [
        ("channels", "chlist", listed + b"\0"),
        ("compression", "compression", b"\3"),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    ]
    own = [(name, *_packed(value)) for name, value in sorted(attributes.items())]
    for name, kind, content in required + own:
        head += name.encode("ascii") + b"\0" + kind.encode("ascii") + b"\0" + struct.pack("<I", len(content)) + content
    head += b"\0"
    chunks = []
    for top in range(0, height, 16):
        rows = range(top, min(top + 16, height))
        raw = b"".join(
            np.ascontiguousarray(channels[name][row], dtype="<f2" if half[name] else "<f4").tobytes()
            for row in rows
            for name in names
        )
        packed = zlib.compress(_predicted(raw), 6)
        content = packed if len(packed) < len(raw) else raw
        chunks.append(struct.pack("<iI", top, len(content)) + content)
    place = len(head) + 8 * len(chunks)
    offsets = []
    for chunk in chunks:
        offsets.append(place)
        place += len(chunk)
    return head + struct.pack(f"<{len(offsets)}Q", *offsets) + b"".join(chunks)


def read_exr(content: bytes, label: str) -> ExrFile:
    """The channels (float32) and attributes of a file; `ValueError` naming ``label`` and what cannot be read."""
    try:
        return _read(content, label)
    except (struct.error, zlib.error, IndexError, UnicodeError, OverflowError, TypeError) as error:
        raise ValueError(f"{label}: damaged OpenEXR file ({error})") from None


def _read(content: bytes, label: str) -> ExrFile:
    magic, version = struct.unpack_from("<II", content)
    if magic != _MAGIC:
        raise ValueError(f"{label}: no OpenEXR file")
    for flag, what in _FLAGS.items():
        if version & flag:
            raise ValueError(f"{label}: OpenEXR with {what} is not read here; write scan lines in one part")
    place, found = 8, {}
    while content[place]:
        name, place = _text(content, place)
        kind, place = _text(content, place)
        (size,) = struct.unpack_from("<I", content, place)
        found[name] = (kind, content[place + 4 : place + 4 + size])
        place += 4 + size
    place += 1
    missing = [name for name in ("channels", "compression", "dataWindow") if name not in found]
    if missing:
        raise ValueError(f"{label}: damaged OpenEXR file (no attribute {missing[0]!r})")
    compression = found["compression"][1][0]
    if compression not in _LINES:
        known = _NAMES.get(compression, str(compression))
        raise ValueError(f"{label}: OpenEXR compression {known} is not read here; write it as ZIP, ZIPS, RLE or none")
    left, top, right, bottom = struct.unpack("<4i", found["dataWindow"][1])
    width, height = right - left + 1, bottom - top + 1
    if width < 1 or height < 1 or width * height > _MOST_PIXELS:
        raise ValueError(f"{label}: {width} x {height} pixels, at most {_MOST_PIXELS} are read")
    layout = _channel_list(found["channels"][1], label)
    planes = {name: np.zeros((height, width), np.float32) for name, _ in layout}
    lines = _LINES[compression]
    count = -(-height // lines)
    seen = 0
    for offset in struct.unpack_from(f"<{count}Q", content, place):
        row, size = struct.unpack_from("<iI", content, offset)
        packed = content[offset + 8 : offset + 8 + size]
        rows = range(row - top, min(row - top + lines, height))
        wanted = sum(dtype.itemsize for _, dtype in layout) * width * len(rows)
        raw = packed if size == wanted or compression == 0 else _unpacked(packed, compression, wanted)
        if len(raw) != wanted or row < top:
            raise ValueError(f"{label}: damaged OpenEXR file (line {row} holds {len(raw)} bytes of {wanted})")
        at = 0
        for line in rows:
            for name, dtype in layout:
                planes[name][line] = np.frombuffer(raw, dtype, width, at)
                at += dtype.itemsize * width
        seen += len(rows)
    if seen != height:
        raise ValueError(f"{label}: damaged OpenEXR file ({seen} of {height} lines)")
    attributes = {name: value for name, pair in found.items() if (value := _unpacked_attribute(*pair)) is not None}
    return ExrFile(planes, attributes)


def _channel_list(content: bytes, label: str) -> list[tuple[str, np.dtype[Any]]]:
    layout: list[tuple[str, np.dtype[Any]]] = []
    place = 0
    while content[place]:
        name, place = _text(content, place)
        kind, _, across, down = struct.unpack_from("<IB3xII", content, place)
        place += 16
        if kind not in _KINDS or (across, down) != (1, 1):
            raise ValueError(f"{label}: channel {name!r} is subsampled or of an unknown kind")
        layout.append((name, _KINDS[kind]))
    return layout


def _text(content: bytes, place: int) -> tuple[str, int]:
    end = content.find(b"\0", place, place + 256)
    if end < 0:
        raise IndexError("a name has no end")
    return content[place:end].decode("ascii"), end + 1


def _packed(value: Attribute) -> tuple[str, bytes]:
    if isinstance(value, str):
        return "string", value.encode("unicode_escape")
    if isinstance(value, int):
        return "int", struct.pack("<i", value)
    if isinstance(value, float):
        return "double", struct.pack("<d", value)
    kinds = {2: "v2d", 3: "v3d", 8: "chromaticities"}
    single = len(value) == 8
    return kinds[len(value)], struct.pack(f"<{len(value)}{'f' if single else 'd'}", *value)


def _unpacked_attribute(kind: str, content: bytes) -> Attribute | None:
    if kind == "string":
        return content.decode("ascii", "replace").encode("ascii", "replace").decode("unicode_escape")
    formats = {"int": "<i", "double": "<d", "float": "<f", "v2d": "<2d", "v3d": "<3d", "v2f": "<2f", "v3f": "<3f"}
    if kind not in formats:
        return None
    values = struct.unpack(formats[kind], content)
    return values[0] if len(values) == 1 else values


def _predicted(raw: bytes) -> bytes:
    """Even bytes before odd ones, then differences: what ZIP of OpenEXR packs."""
    flat = np.frombuffer(raw, np.uint8)
    apart = np.concatenate([flat[0::2], flat[1::2]])
    steps = apart.copy()
    steps[1:] = apart[1:] - apart[:-1] + np.uint8(128)
    return steps.tobytes()


def _unpacked(packed: bytes, compression: int, wanted: int) -> bytes:
    if compression == 1:
        steps = _run_lengths(packed)
    else:
        worker = zlib.decompressobj()
        steps = worker.decompress(packed, wanted + 1)  # never more than a byte beyond what the header says
    flat = np.frombuffer(steps, np.uint8).astype(np.int64)
    flat[1:] -= 128
    apart = (np.cumsum(flat) & 255).astype(np.uint8)
    raw = np.empty_like(apart)
    half = (len(apart) + 1) // 2
    raw[0::2], raw[1::2] = apart[:half], apart[half:]
    return raw.tobytes()


def _run_lengths(packed: bytes) -> bytes:
    parts, place = [], 0
    while place < len(packed):
        count = packed[place] - 256 if packed[place] > 127 else packed[place]
        if count < 0:
            parts.append(packed[place + 1 : place + 1 - count])
            place += 1 - count
        else:
            parts.append(packed[place + 1 : place + 2] * (count + 1))
            place += 2
    return b"".join(parts)
