"""Levels of 16 bits as bytes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ByteImage


def in_bytes(levels: NDArray[Any]) -> ByteImage:
    """0 to 65535 as the nearest of 0 to 255, in any shape."""
    return ((levels.astype(np.uint32) + 128) // 257).astype(np.uint8)
