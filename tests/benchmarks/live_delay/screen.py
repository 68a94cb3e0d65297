"""The screen of a virtual display, read as it is, beside the programs that draw on it."""

from __future__ import annotations

import struct
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import numpy as np

from renderer.clip import ByteImage

PATIENCE: Final = 10.0
"""Seconds for the display to begin."""
COLORS = 19
COLOR_BYTES = 12
"""Which number of the header counts the colours, and what each takes (X11's XWDFile.h)."""
PIXELS: Final = (4, 5, 12)
"""Those of width, height and bytes a row."""


class Screen:
    """The frame buffer file of an Xvfb with 24 bits of colour, mapped."""

    def __init__(self, file: Path) -> None:
        header = struct.unpack(">25I", file.read_bytes()[:100])
        width, height, stride = (header[place] for place in PIXELS)
        start = header[0] + header[COLORS] * COLOR_BYTES
        self._pixels = np.asarray(np.memmap(file, np.uint8, "r", start, (height, stride)))
        self._width = width

    def row(self, y: int, left: int, right: int) -> ByteImage:
        """(W,) green levels of a part of a row: what is there whenever it is read."""
        return self._pixels[y, 4 * left + 1 : 4 * right : 4]


@contextmanager
def display(folder: Path, size: tuple[int, int]) -> Iterator[tuple[str, Screen]]:
    """An Xvfb of its own: its name for DISPLAY, and its screen."""
    width, height = size
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", f"{width}x{height}x24", "-fbdir", str(folder)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        assert server.stdout is not None
        name = f":{server.stdout.readline().strip()}"
        yield name, Screen(_found(folder))
    finally:
        server.terminate()
        server.wait()


def _found(folder: Path) -> Path:
    end = time.monotonic() + PATIENCE
    file = folder / "Xvfb_screen0"
    while not file.is_file() or file.stat().st_size < 100:
        if time.monotonic() > end:
            raise TimeoutError(f"no screen in {folder}")
        time.sleep(0.05)
    return file
