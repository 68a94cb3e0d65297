"""How many bits the values of 16-bit images use: of cameras of 10 or 12, files often hold them as they come,
nearly black.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.evenly import evenly
from renderer.file_signatures import PNG_SIGNATURE
from renderer.readers.image_files.tiff_layouts import BLACK_IS_ZERO, RGB, UNSIGNED, tiff_layout
from renderer.regular_files import require_regular

ALL: Final = 16
FEWER: Final = (10, 12)
"""Of cameras."""
LOOKED_AT: Final = 9
"""Evenly spread images of a folder."""
PNG_BITS: Final = 24
"""Where a PNG says how many bits a value has."""
DARKEST: Final = 255
"""No more, and an image is black, whatever it uses."""


def used_bits(paths: Sequence[Path]) -> int:
    """10 or 12, where no value of these images together needs more and one needs more than 8; else 16.

    One answer for all images of a folder, so that none of them flickers: a few of them tell, evenly spread.
    Of PNG and TIFF with whole numbers of 16 bits; other files, and what cannot be read, tell nothing.
    """
    most = 0
    for path in evenly(paths, LOOKED_AT):
        most = max(most, _most(path))
        if most >= 1 << FEWER[-1]:
            return ALL
    return next(bits for bits in FEWER if most < 1 << bits) if most > DARKEST else ALL


def stretched(levels: NDArray[np.uint16], bits: int) -> NDArray[np.uint16]:
    """What uses so many bits over the whole range of 16, in any shape; values beyond become the highest."""
    if bits >= ALL:
        return levels
    most = (1 << bits) - 1
    return ((np.minimum(levels, most).astype(np.uint32) * 65535 + most // 2) // most).astype(np.uint16)


def said_of_bits(count: int, bits: int) -> tuple[str, ...]:
    """To a person, of so many files; nothing where they use all bits."""
    if bits >= ALL:
        return ()
    return (
        f"{_files(count, bits)}: shown {1 << (ALL - bits)} times brighter (--bits 16 shows what is stored)",
    )


def said_of_unread_bits(count: int, bits: int) -> tuple[str, ...]:
    """The same where so many files that use `bits` are shown as stored."""
    if bits >= ALL:
        return ()
    way = f"--bits {bits} shows them {1 << (ALL - bits)} times brighter"
    return (f"{_files(count, bits)}: shown as stored ({way})",)


def _files(count: int, bits: int) -> str:
    return f"16-bit file that uses {bits} bits" if count == 1 else f"16-bit files that use {bits} bits"


def holds_deep(path: Path) -> bool:
    """Whether a file is a PNG or TIFF with whole numbers of 16 bits, by its header. Raises OSError."""
    require_regular(path)
    with path.open("rb") as file:
        head = file.read(PNG_BITS + 1)
    if head.startswith(PNG_SIGNATURE):
        return head[PNG_BITS:] == bytes((ALL,))
    layout = tiff_layout(path)
    if layout is None or layout.misread or layout.photometric not in (BLACK_IS_ZERO, RGB):
        return False
    return layout.bits == ALL and layout.format in (0, UNSIGNED)


def deep_levels(path: Path) -> NDArray[np.uint16] | None:
    """(H, W) grey or (H, W, 3) RGB of a file that `holds_deep`, as it lies, without alpha; None: damaged.

    Pillow keeps 8 bits of three colours.
    """
    try:
        stored = cv2.imdecode(np.frombuffer(path.read_bytes(), np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return None
    if stored is None or stored.dtype != np.uint16:
        return None
    layout = tiff_layout(path)
    meant = layout.meant(stored) if layout else stored
    return np.asarray(meant if meant.ndim == 2 else np.ascontiguousarray(meant[..., 2::-1]), np.uint16)


def _most(path: Path) -> int:
    """The highest value; 0 where it does not tell."""
    try:
        levels = deep_levels(path) if holds_deep(path) else None
    except OSError:
        return 0
    return 0 if levels is None else int(levels.max())
