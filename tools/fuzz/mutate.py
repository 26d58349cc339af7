"""Mutations of seeds: the same for the same name, whatever ran before."""

from __future__ import annotations

import random
import re
import struct
import zlib

_NUMBERS = (
    b"0", b"-1", b"1e308", b"-1e308", b"1e-320", b"nan", b"inf", b"-inf", b"99999999999999999999", b"1e400", b"0x10",
    b"1,5", b"1.234,5", b"1" * 5000, b"true", b"\"x\"", b"[]", b"{}", b"2147483648", b"-2147483649", b"65536", b"1_0",
)  # fmt: skip
_WORDS = (
    b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\x1b[31m", b"\xe2\x80\xae", b"\xc3", b"\"", b"'", b"\\", b"=", b"..", b"../",
    b"/dev/zero", b"[" * 3000, b"{" * 3000, b"a." * 2000, b"\r", b"\n\n", b";", b",", b"\t", b"#", b"%", b"um", b"nm",
    b"eV", b"Ref", b"R", b"NaN",
)  # fmt: skip
_INTEGERS = (0, 1, 2, 127, 128, 255, 256, 32767, 32768, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1)


def mutated(seeds: list[bytes], name: str, is_text: bool) -> bytes:
    """Some changes of one of the seeds."""
    dice = random.Random(name)
    content = bytearray(dice.choice(seeds))
    is_png = content[:4] == b"\x89PNG"
    for _ in range(dice.choice((1, 1, 1, 2, 3, 5, 12))):
        change = dice.choice(_TEXT if is_text and dice.random() < 0.8 else _BINARY)
        content = bytearray(change(content, dice, seeds))
        if len(content) > 1 << 20:
            del content[1 << 20 :]
    # A wrong check sum hides every other change of a PNG.
    return _with_sums(bytes(content)) if is_png and dice.random() < 0.8 else bytes(content)


def _place(content: bytearray, dice: random.Random) -> int:
    # Headers decide: half of the changes fall into the first kilobyte.
    end = min(len(content), 1024) if dice.random() < 0.5 else len(content)
    return dice.randrange(end) if end else 0


def _flip(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    if content:
        content[_place(content, dice)] ^= 1 << dice.randrange(8)
    return content


def _byte(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    if content:
        content[_place(content, dice)] = dice.choice((0, 1, 0x7F, 0x80, 0xFF, dice.randrange(256)))
    return content


def _integer(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    kind = dice.choice(("<H", ">H", "<I", ">I", "<Q", ">Q"))
    size = struct.calcsize(kind)
    if len(content) >= size:
        at = min(_place(content, dice), len(content) - size)
        content[at : at + size] = struct.pack(kind, dice.choice(_INTEGERS) % 2 ** (8 * size))
    return content


def _float(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    kind = dice.choice(("<f", "<d"))
    size = struct.calcsize(kind)
    if len(content) >= size:
        at = min(_place(content, dice), len(content) - size) // 4 * 4
        value = dice.choice((float("nan"), float("inf"), -float("inf"), -1.0, 0.0, 3e38, -3e38, 1e-45))
        content[at : at + size] = struct.pack(kind, value)
    return content


def _cut(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    return content[: dice.randrange(len(content) + 1)]


def _delete(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    at = _place(content, dice)
    del content[at : at + dice.choice((1, 2, 4, 8, 64, 512))]
    return content


def _repeat(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    at = _place(content, dice)
    piece = content[at : at + dice.choice((1, 4, 16, 128, 1024))]
    return content[:at] + piece * dice.choice((2, 3, 30, 300)) + content[at:]


def _splice(content: bytearray, dice: random.Random, seeds: list[bytes]) -> bytes:
    other = dice.choice(seeds)
    return content[: dice.randrange(len(content) + 1)] + other[dice.randrange(len(other) + 1) :]


def _number(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    found = list(re.finditer(rb"[-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?", content))
    if found:
        one = dice.choice(found)
        content[one.start() : one.end()] = dice.choice(_NUMBERS)
    return content


def _word(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    at = _place(content, dice)
    return content[:at] + dice.choice(_WORDS) + content[at:]


def _swap(content: bytearray, dice: random.Random, seeds: list[bytes]) -> bytes:
    found = list(re.finditer(rb"[A-Za-z_]+", content))
    words = re.findall(rb"[A-Za-z_]+", dice.choice(seeds))
    if found and words:
        one = dice.choice(found)
        content[one.start() : one.end()] = dice.choice(words)
    return content


def _lines(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    lines = content.split(b"\n")
    a, b = dice.randrange(len(lines)), dice.randrange(len(lines))
    what = dice.randrange(4)
    if what == 0:
        lines[a], lines[b] = lines[b], lines[a]
    elif what == 1:
        del lines[a]
    elif what == 2:
        lines.insert(a, lines[b])
    else:
        lines[a:a] = [lines[b]] * dice.choice((3, 100))
    return b"\n".join(lines)


def _encoding(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    text = content.decode("utf-8", "replace")
    return text.encode(dice.choice(("utf-16", "utf-16-le", "utf-16-be", "utf-8-sig", "latin-1")), "replace")


def _sign(content: bytearray, dice: random.Random, _: list[bytes]) -> bytes:
    old, new = dice.choice(((b",", b";"), (b".", b","), (b",", b"\t"), (b"\n", b"\r"), (b" ", b""), (b"=", b" = ")))
    return content.replace(old, new)


_BINARY = (_flip, _byte, _byte, _integer, _integer, _float, _cut, _delete, _repeat, _splice)
_TEXT = (_number, _number, _number, _word, _word, _swap, _swap, _lines, _lines, _encoding, _sign, _delete, _splice)


def _with_sums(content: bytes) -> bytes:
    """A PNG with the check sums of its chunks as they should be."""
    made, at = bytearray(content[:8]), 8
    while at + 12 <= len(content):
        length = int.from_bytes(content[at : at + 4], "big")
        if at + 12 + length > len(content):
            break
        body = content[at + 4 : at + 8 + length]
        made += content[at : at + 4] + body + zlib.crc32(body).to_bytes(4, "big")
        at += 12 + length
    return bytes(made + content[at:])
