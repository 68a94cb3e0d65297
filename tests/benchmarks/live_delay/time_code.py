"""A time painted into a picture, as a row of black and white blocks that enhancement leaves readable."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ByteImage

TICK: Final = 1e-4
"""Seconds that one counts for."""
BITS = 24
CHECK = 6
BLOCKS: Final = 2 + BITS + CHECK
"""Black and white for comparison, the count of ticks, its check."""
FACTOR: Final = 37
"""Odd, so that a wrong bit changes the check."""
HIGH: Final = 1 / 20
"""Of the picture's height."""
LIFE: Final = TICK * (1 << BITS)
"""Seconds after which the count begins anew."""
CONTRAST: Final = 40
"""Grey levels between black and white below which nothing is read."""


def paint(image: ByteImage, seconds: float) -> None:
    """Write the time, on `time.perf_counter`, over the middle rows of an (H, W, 3) image."""
    height, width = image.shape[:2]
    edges = np.linspace(0, width, BLOCKS + 1).astype(int)
    high = max(1, round(HIGH * height))
    top = (height - high) // 2
    for bit, left, right in zip(_bits(int(seconds / TICK)), edges[:-1], edges[1:], strict=True):
        image[top : top + high, left:right] = 255 * bit


def middles(width: int) -> NDArray[np.intp]:
    """(BLOCKS,) of a row of so many pixels, where `read` looks."""
    return ((np.arange(BLOCKS) + 0.5) * width / BLOCKS).astype(np.intp)


def read(levels: ByteImage) -> float | None:
    """The time that the (BLOCKS,) grey levels at `middles` show, modulo LIFE; None where they show none."""
    seen = levels.astype(int)
    if seen[1] - seen[0] < CONTRAST:
        return None
    bits = seen[2:] > (seen[0] + seen[1]) / 2
    value = int("".join("1" if bit else "0" for bit in bits), 2)
    count, check = value >> CHECK, value & ((1 << CHECK) - 1)
    return count * TICK if check == _check(count) else None


def age(shown: float, now: float) -> float:
    """Seconds since the painted time."""
    return float((now - shown) % LIFE)


def _bits(count: int) -> list[int]:
    count %= 1 << BITS
    value = count << CHECK | _check(count)
    return [0, 1, *(value >> place & 1 for place in reversed(range(BITS + CHECK)))]


def _check(count: int) -> int:
    return (count * FACTOR >> 2) % (1 << CHECK) ^ (count >> 13) % (1 << CHECK)
