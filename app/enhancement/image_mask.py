"""Pixels that a user leaves out of the statistics: burned-in text, and what lies around a round view."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Final

import cv2
import numpy as np
from annotated_types import Interval
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from renderer.clip import BoolImage

FARTHEST: Final = 1e9
"""Pixels from the picture's corner: a hand may draw far beyond the picture."""
Edge = Annotated[float, Interval(ge=-FARTHEST, le=FARTHEST)]
Box = tuple[Edge, Edge, Edge, Edge]
Radius = Annotated[float, Interval(ge=0, le=2 * FARTHEST)]
Circle = tuple[Edge, Edge, Radius]
Round = tuple[Edge, Edge, Radius, Annotated[float, Interval(gt=0)]]
"""A circle on screen, of pixels that are not square: with the width of one by its height."""


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
class PictureMask:
    """A box to leave out and a circle to keep, each where it is needed; in pixels of the picture."""

    text: Box | None = None
    """Left, top, right and bottom edge."""
    view: Circle | Round | None = None
    """Middle, x and y, and radius, which is counted down the picture."""

    def kept(self, shape: tuple[int, int]) -> BoolImage:
        """(H, W), True = counts, judged at the middle of each pixel."""
        y, x = (np.ogrid[: shape[0], : shape[1]][axis] + 0.5 for axis in (0, 1))
        keep = np.ones(shape, dtype=bool)
        if self.text is not None:
            left, top, right, bottom = self.text
            keep &= ~((x >= left) & (x < right) & (y >= top) & (y < bottom))
        if self.view is not None:
            middle_x, middle_y, radius, *aspect = self.view
            across = (x - middle_x) * (aspect[0] if aspect else 1.0)
            keep &= across**2 + (y - middle_y) ** 2 <= radius**2
        return keep

    def drawn(
        self, shape: str, start: tuple[float, float], end: tuple[float, float], pixel_aspect: float = 1.0
    ) -> PictureMask:
        """With a box between two corners ("text"), or a circle from its middle to its rim ("view"), round
        where pixels are shown so much wider than high."""
        (x, y), (to_x, to_y) = start, end
        if shape == "text":
            return replace(self, text=(min(x, to_x), min(y, to_y), max(x, to_x), max(y, to_y)))
        radius = min(float(np.hypot((to_x - x) * pixel_aspect, to_y - y)), 2 * FARTHEST)
        return replace(self, view=round_on_screen((x, y, radius), pixel_aspect))


NO_MASK: Final = PictureMask()


def round_on_screen(circle: Circle, pixel_aspect: float) -> Circle | Round:
    """The circle where pixels are shown so much wider than high; its radius is counted down the picture."""
    return circle if pixel_aspect == 1 else (*circle, pixel_aspect)


def enclosing(keep: BoolImage, pixel_aspect: float = 1.0) -> Circle | Round | None:
    """The smallest circle around the kept pixels, which straight sides may cut; None where all are kept."""
    if keep.all() or not keep.any():
        return None
    rims, _ = cv2.findContours(keep.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    middles = np.concatenate(rims)[:, 0] + 0.5
    (x, y), radius = cv2.minEnclosingCircle((middles * (pixel_aspect, 1)).astype(np.float32))
    return round_on_screen((x / pixel_aspect, y, radius + 0.5), pixel_aspect)
