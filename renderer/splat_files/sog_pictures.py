"""The pictures of a SOG: how many pixels they may have, and what their rows are."""

from __future__ import annotations

import io
import struct
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from renderer.splat_files.sog_members import Read
from renderer.splat_files.splat_file import SplatFileError

SIDE_BY_SIDE: Final = 64
"""Rows of a palette in a line of its picture."""
MOST_ROWS: Final = 1 << 16
"""Of a palette, whose places have 16 bits."""
SPARE: Final = 1 << 16
"""Pixels of a picture, and bytes of its file, beyond four for each splat."""
BROKEN: Final = (
    OSError, SyntaxError, ValueError, EOFError, TypeError, KeyError, IndexError, AttributeError,
    OverflowError, struct.error, Image.DecompressionBombError,
)  # fmt: skip
"""What Pillow raises for a damaged picture."""

Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class Pictures:
    """Pixels by the name of their file."""

    read: Read
    count: int

    def splats(self, name: str) -> Bytes:
        """(N, 4), the first of a picture of at least as many pixels."""
        most = 4 * self.count + SPARE
        pixels = self._pixels(name, (self.count, most), most)
        return pixels.reshape(-1, 4)[: self.count]

    def palette(self, name: str, rows: int, bands: int) -> Bytes:
        """(rows, bands, 3)."""
        width, height = SIDE_BY_SIDE * bands, -(-rows // SIDE_BY_SIDE)
        most = width * MOST_ROWS // SIDE_BY_SIDE
        pixels = self._pixels(name, (width * height, most), 4 * most)
        if pixels.shape[1] != width:
            raise SplatFileError(f"expected {name} to be {width} pixels wide, got {pixels.shape[1]}")
        return pixels[..., :3].reshape(-1, bands, 3)[:rows]

    def _pixels(self, name: str, ends: tuple[int, int], most: int) -> Bytes:
        """(H, W, 4) of a picture that holds from one to the other number of pixels."""
        content = self.read(name, most)
        try:
            with Image.open(io.BytesIO(content), formats=("WEBP", "PNG")) as picture:
                size = picture.width * picture.height
                if not ends[0] <= size <= ends[1] or picture.mode not in ("RGB", "RGBA"):
                    raise SplatFileError(
                        f"expected {name} of {ends[0]} to {ends[1]} pixels of RGB or RGBA, got {size} of "
                        f"{picture.mode}"
                    )
                return np.asarray(picture.convert("RGBA"))
        except SplatFileError:
            raise
        except BROKEN as error:
            raise SplatFileError(f"expected a WebP image in {name}, got a damaged file") from error
