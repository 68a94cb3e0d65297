"""Memory of results, which is used again once nobody holds the last one."""

from __future__ import annotations

import sys
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from enhance.image import AnyImage


def _holders(one: list[AnyImage]) -> int:
    """References to the array in a list, with those of the count itself."""
    return sys.getrefcount(one[0])


NOBODY_ELSE: Final = _holders([np.empty(0, np.uint8)])


class ResultMemory:
    """Gives out arrays, in the memory of the last one if nobody holds that any more: what is new costs, page
    by page, up to a quarter of the time of an image.

    What is given out is a view of an array that stays here. A view of it, however cut, is one of that array,
    too, so that its memory counts as held as long as anything reads it.
    """

    def __init__(self) -> None:
        self._last: list[AnyImage] = [np.empty(0, np.uint8)]

    @property
    def size(self) -> int:
        """Bytes that stay."""
        return self._last[0].nbytes

    def like(self, pixels: AnyImage) -> NDArray[Any]:
        """Empty, of this shape and type, C-contiguous; the caller's own."""
        last = self._last
        fits = (last[0].shape, last[0].dtype) == (pixels.shape, pixels.dtype)
        if not fits or _holders(last) > NOBODY_ELSE:
            last[0] = np.empty(pixels.shape, pixels.dtype)
        return last[0].view()
