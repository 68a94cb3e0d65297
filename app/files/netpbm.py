"""PGM and PPM, whose header says which number is white."""

from __future__ import annotations

import re
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

HEADER: Final = re.compile(rb"P([2356])" + 3 * rb"(?:\s|#[^\r\n]*[\r\n])+(\d+)")
"""Kind, width, height and the number of white, with comments between them."""
PLAIN: Final = (b"2", b"3")
"""Kinds whose numbers are text."""


def full_scale(content: bytes, stored: NDArray[Any]) -> NDArray[Any]:
    """The numbers that OpenCV makes of `content`, of the same type, white being its highest; other kinds of
    files are left as they are."""
    header = HEADER.match(content)
    if header is None:
        return stored
    kind, white, highest = header[1], int(header[4]), np.iinfo(stored.dtype).max
    # Of text with 8 bits, OpenCV scales the numbers itself.
    if white in (0, highest) or (kind in PLAIN and stored.dtype == np.uint8):
        return stored
    shares = np.arange(highest + 1).clip(max=white) / white
    return np.asarray(np.rint(shares * highest).astype(stored.dtype)[stored])
