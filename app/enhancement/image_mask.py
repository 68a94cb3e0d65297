"""Pixels that a user leaves out of the statistics: burned-in text, and what lies around a round view."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Final

import numpy as np
from annotated_types import Interval
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from renderer.clip import BoolImage

FARTHEST: Final = 1e9
"""Pixels from the picture's corner: a hand may draw far beyond the picture."""
Edge = Annotated[float, Interval(ge=-FARTHEST, le=FARTHEST)]
Box = tuple[Edge, Edge, Edge, Edge]
Circle = tuple[Edge, Edge, Annotated[float, Interval(ge=0, le=2 * FARTHEST)]]


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
class PictureMask:
    """A box to leave out and a circle to keep, each where it is needed; in pixels of the picture."""

    text: Box | None = None
    """Left, top, right and bottom edge."""
    view: Circle | None = None
    """Middle, x and y, and radius."""

    def kept(self, shape: tuple[int, int]) -> BoolImage:
        """(H, W), True = counts, judged at the middle of each pixel."""
        y, x = (np.ogrid[: shape[0], : shape[1]][axis] + 0.5 for axis in (0, 1))
        keep = np.ones(shape, dtype=bool)
        if self.text is not None:
            left, top, right, bottom = self.text
            keep &= ~((x >= left) & (x < right) & (y >= top) & (y < bottom))
        if self.view is not None:
            middle_x, middle_y, radius = self.view
            keep &= (x - middle_x) ** 2 + (y - middle_y) ** 2 <= radius**2
        return keep

    def drawn(self, shape: str, start: tuple[float, float], end: tuple[float, float]) -> PictureMask:
        """With a box between two corners ("text"), or a circle from its middle to its rim ("view")."""
        (x, y), (to_x, to_y) = start, end
        if shape == "text":
            return replace(self, text=(min(x, to_x), min(y, to_y), max(x, to_x), max(y, to_y)))
        return replace(self, view=(x, y, float(np.hypot(to_x - x, to_y - y))))


NO_MASK: Final = PictureMask()


def enclosing(keep: BoolImage) -> Circle | None:
    """The circle of the same middle and width or height as the kept pixels; None where all are kept."""
    if keep.all() or not keep.any():
        return None
    rows, columns = np.flatnonzero(keep.any(axis=1)), np.flatnonzero(keep.any(axis=0))
    sides = [(float(line[0]), float(line[-1] + 1)) for line in (columns, rows)]
    (left, right), (top, bottom) = sides
    return (left + right) / 2, (top + bottom) / 2, max(right - left, bottom - top) / 2
