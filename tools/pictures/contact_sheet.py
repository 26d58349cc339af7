"""Frames of a film's life on one sheet, to be looked at: python tools/pictures/contact_sheet.py bubble.frames sheet.png

Twelve frames, evenly over all of the folder that `iridesce animate --keep-frames` leaves, read as lines of text are.
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

COLUMNS, ROWS, WIDTH = 4, 3, 400


def main() -> int:
    if len(sys.argv) != 3:
        print("usage: python tools/pictures/contact_sheet.py FOLDER SHEET.png", file=sys.stderr)
        return 2
    frames = sorted(Path(sys.argv[1]).glob("frame_*.png"))
    if not frames:
        print(f"error: {sys.argv[1]} holds no frame_*.png", file=sys.stderr)
        return 3
    count = COLUMNS * ROWS
    chosen = [frames[round(i * (len(frames) - 1) / (count - 1))] for i in range(count)]
    sheet: Image.Image | None = None
    for i, frame in enumerate(chosen):
        with Image.open(frame) as picture:
            height = round(WIDTH * picture.height / picture.width)
            small = picture.convert("RGB").resize((WIDTH, height))
        if sheet is None:
            sheet = Image.new("RGB", (COLUMNS * WIDTH, ROWS * height))
        sheet.paste(small, ((i % COLUMNS) * WIDTH, (i // COLUMNS) * height))
    assert sheet is not None
    sheet.save(sys.argv[2])
    return 0


if __name__ == "__main__":
    sys.exit(main())
