"""An image a few rows at a time, so that what is computed on the way stays in the cache."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

PIXELS: Final = 1 << 16
"""Of a strip, some: a float32 of each colour is 3/4 MB."""


@dataclass(frozen=True)
class Strip:
    """Some rows of an image."""

    own: slice
    rows: slice
    """Its own, and those beside that they depend on, as far as there are any."""

    @property
    def inner(self) -> slice:
        """Its own, counted from the first of `rows`."""
        return slice(self.own.start - self.rows.start, self.own.stop - self.rows.start)


def strips(shape: tuple[int, ...], beside: int = 0) -> Iterator[Strip]:
    """All rows of an image of this height and width, from the top; each depends on `beside` more on either
    side."""
    height, width = shape
    each = max(PIXELS // max(width, 1), 2 * beside, 1)
    for top in range(0, height, each):
        bottom = min(top + each, height)
        yield Strip(slice(top, bottom), slice(max(top - beside, 0), min(bottom + beside, height)))
