"""What the endoscope sees of a picture: the field of view inside a dark surround.

It is convex, round, octagonal, or either of these cropped by the picture; or several such parts, as of two
eyes side by side, whether a surround divides them or not. `field_search` finds it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Annotated, Final, Self

import cv2
import numpy as np
from annotated_types import Interval, Len
from numba import njit
from numpy.typing import NDArray
from pydantic import ConfigDict, model_validator
from pydantic.dataclasses import dataclass

from enhance.image import AnyImage, BoolImage

MOST_COMPARED: Final = 32
"""Fields of one clip."""
LEAST_CONVEX: Final = 0.98
"""Area of an outline by that of its convex hull: rounding may dent it."""
MOST_PARTS: Final = 4
MOST_CORNERS: Final = 240
"""Of an outline; as many as the rays that its rim is measured along."""

Spans = NDArray[np.int32]
EVERYWHERE: Final = np.empty((0, 2), np.int32)
"""The spans of a picture that is all field."""
Side = Annotated[int, Interval(ge=1, le=2**31 - 1)]
Coordinate = Annotated[float, Interval(ge=-1e6, le=1e6)]
Radius = Annotated[float, Interval(ge=0, le=1e6)]
Corner = tuple[Coordinate, Coordinate]


@dataclass(frozen=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
class FieldOfView:
    """A convex part of a picture, or several, in pixels from its upper left corner; pixel centres at +0.5.

    Raises:
        pydantic.ValidationError: (a ValueError) a value out of its range, more than one of a circle, a
            polygon and parts, a polygon that is not convex, or parts of another picture or in parts.

    Example:
        >>> from enhance.field import FieldOfView
        >>> field = FieldOfView(width=8, height=4, circle=(4.0, 2.0, 2.0))
        >>> field.spans().tolist()
        [[3, 5], [2, 6], [2, 6], [3, 5]]
    """

    width: Side
    """Of the picture."""
    height: Side
    circle: tuple[Coordinate, Coordinate, Radius] | None = None
    """Middle, x and y, and radius; it may reach beyond the picture."""
    polygon: Annotated[tuple[Corner, ...], Len(3, MOST_CORNERS)] | None = None
    """Corners of a convex outline, in order."""
    parts: Annotated[tuple[FieldOfView, ...], Len(2, MOST_PARTS)] | None = None
    """A circle or a polygon each; they may share pixels. None of all three: the whole picture."""

    @model_validator(mode="after")
    def _has_one_outline(self) -> Self:
        if sum(one is not None for one in (self.circle, self.polygon, self.parts)) > 1:
            raise ValueError("expected a circle, a polygon or parts, got more than one")
        return self

    @model_validator(mode="after")
    def _is_of_convex_parts(self) -> Self:
        for one in self.parts or ():
            if one.parts is not None or one.is_whole or (one.width, one.height) != (self.width, self.height):
                raise ValueError("expected parts that are a circle or a polygon each, of the same image")
        return self

    @model_validator(mode="after")
    def _is_convex(self) -> Self:
        if self.polygon is not None:
            corners = np.array(self.polygon, np.float32)
            whole = cv2.contourArea(cv2.convexHull(corners))
            if cv2.contourArea(corners) < LEAST_CONVEX * whole:
                raise ValueError("expected a convex polygon, got one with dents or crossing sides")
        return self

    @property
    def is_whole(self) -> bool:
        """There is no surround."""
        return self.circle is None and self.polygon is None and self.parts is None

    def fits(self, image: AnyImage) -> bool:
        """It is of images of this size."""
        return image.shape[:2] == (self.height, self.width)

    def spans(self) -> Spans:
        """(H, 2) first column of each row that belongs to the field and the first after the last one; empty:
        all do. Of several parts, what lies between them is in."""
        if self.is_whole:
            return EVERYWHERE
        if self.parts is not None:
            bounds = np.array([one.spans() for one in self.parts])
            some = bounds[..., 0] < bounds[..., 1]
            first = np.where(some, bounds[..., 0], self.width).min(axis=0)
            end = np.where(some, bounds[..., 1], 0).max(axis=0)
            return np.stack((np.minimum(first, end), end), axis=1).astype(np.int32)
        spans = np.empty((self.height, 2), np.int32)
        if self.circle is not None:
            _fill_circle(np.array(self.circle, np.float64), self.width, spans)
        else:
            _fill_polygon(np.array(self.polygon, np.float64), self.width, spans)
        return spans

    def mask(self) -> BoolImage:
        """(H, W), True = field."""
        if self.is_whole:
            return np.ones((self.height, self.width), bool)
        if self.parts is not None:
            return np.asarray(np.any([one.mask() for one in self.parts], axis=0))
        columns, spans = np.arange(self.width), self.spans()
        return np.asarray((columns >= spans[:, :1]) & (columns < spans[:, 1:]))

    def inset(self, by: float) -> FieldOfView:
        """Narrower by so many px, but not along the picture's own border, as the field goes on there; the
        same where nothing would be left."""
        if self.parts is not None:
            return replace(self, parts=tuple(one.inset(by) for one in self.parts))
        if self.circle is not None and self.circle[2] > by:
            return replace(self, circle=(*self.circle[:2], self.circle[2] - by))
        if self.polygon is None:
            return self
        corners = np.array(self.polygon, np.float64)
        ahead = np.roll(corners, -1, axis=0) - corners
        clockwise = np.sign((corners[:, 0] * ahead[:, 1] - corners[:, 1] * ahead[:, 0]).sum())
        left = corners
        for corner, side in zip(corners, ahead, strict=True):
            length = float(np.hypot(*side))
            if length and not self._along_border(corner, corner + side, by):
                inward = clockwise * np.array([-side[1], side[0]]) / length
                left = beyond(left, inward, float(inward @ corner) + by)
        if len(left) < 3:
            return self
        # No more corners than before: what is left has one at most for each side, moved or kept.
        return replace(self, polygon=tuple((float(x), float(y)) for x, y in left))

    def _along_border(self, one: NDArray[np.float64], other: NDArray[np.float64], by: float) -> bool:
        ends, far = np.stack([one, other]), np.array([self.width - by, self.height - by])
        return bool((ends < by).all(axis=0).any() or (ends > far).all(axis=0).any())


@lru_cache(maxsize=16)
def whole_field(width: int, height: int) -> FieldOfView:
    """All of a picture of this size, checked once: every search begins with it."""
    return FieldOfView(width, height)


def beyond(corners: NDArray[np.float64], inward: NDArray[np.float64], least: float) -> NDArray[np.float64]:
    """The part of a convex outline of (N, 2) corners that lies beyond `least` along the normal."""
    inside, kept = corners @ inward - least, list[NDArray[np.float64]]()
    for place, here in enumerate(inside):
        before = inside[place - 1]
        if (here > 0) != (before > 0):
            share = before / (before - here)
            kept.append(corners[place - 1] + share * (corners[place] - corners[place - 1]))
        if here > 0:
            kept.append(corners[place])
    return np.array(kept).reshape(-1, 2)


@njit(cache=True, error_model="numpy")
def _fill_circle(circle: NDArray[np.float64], width: int, spans: Spans) -> None:
    """The columns of each row whose middles lie between the ends of the circle's chord."""
    x, y, radius = circle[0], circle[1], circle[2]
    for row in range(len(spans)):
        square = radius**2 - (row + 0.5 - y) ** 2
        half = np.sqrt(square) if square > 0 else -1.0
        _fill_row(x - half, x + half, width, spans[row])


@njit(cache=True, error_model="numpy")
def _fill_polygon(corners: NDArray[np.float64], width: int, spans: Spans) -> None:
    """The same of a convex outline of (N, 2) corners: each side bounds the rows that it crosses."""
    rows, count = len(spans), len(corners)
    left, right = np.full(rows, np.inf), np.full(rows, -np.inf)
    for corner in range(count):
        after = corner + 1 if corner + 1 < count else 0
        x, y, to_x, to_y = corners[corner, 0], corners[corner, 1], corners[after, 0], corners[after, 1]
        if y == to_y:
            continue
        slope = (to_x - x) / (to_y - y)
        first, last = np.ceil(min(y, to_y) - 0.5), np.floor(max(y, to_y) - 0.5)
        for row in range(max(int(first), 0), min(int(last), rows - 1) + 1):
            at = x + (row + 0.5 - y) * slope
            left[row], right[row] = min(left[row], at), max(right[row], at)
    for row in range(rows):
        if left[row] > right[row]:
            left[row] = right[row] = 0.0
        _fill_row(left[row], right[row], width, spans[row])


@njit(forceinline=True, error_model="numpy")
def _fill_row(left: float, right: float, width: int, span: NDArray[np.int32]) -> None:
    """Columns whose middles lie between these ends; none where they lie the other way round."""
    first = min(max(np.ceil(left - 0.5), 0.0), width)
    span[0], span[1] = first, min(max(np.ceil(right - 0.5), first), width)


def overlap(one: FieldOfView, other: FieldOfView) -> float:
    """Intersection over union of two fields of one picture size, in [0, 1]."""
    ones, others = _bounds(one), _bounds(other)
    together = _count(np.concatenate((ones, others)))
    return (_count(ones) + _count(others) - together) / together if together else 1.0


def uncovered(one: FieldOfView, other: FieldOfView) -> float:
    """Share of a field, in [0, 1], that another of the same picture size does not cover."""
    ones, others = _bounds(one), _bounds(other)
    area = _count(ones)
    return (_count(np.concatenate((ones, others))) - _count(others)) / area if area else 0.0


def _bounds(field: FieldOfView) -> NDArray[np.int32]:
    """(n, H, 2) spans of each of its parts."""
    if field.is_whole:
        spans = np.zeros((1, field.height, 2), np.int32)
        spans[..., 1] = field.width
        return spans
    return np.array([one.spans() for one in field.parts or (field,)])


@njit(cache=True, error_model="numpy")
def _count(bounds: NDArray[np.int32]) -> int:
    """Pixels in any of these: of each row, from left to right, what the spans before have not reached."""
    total = 0
    for row in range(bounds.shape[1]):
        reached, goes_on = 0, True
        while goes_on:
            begin, end, goes_on = reached, reached, False
            for span in range(len(bounds)):
                first = max(bounds[span, row, 0], reached)
                if first < bounds[span, row, 1] and (first < begin or not goes_on):
                    begin, end, goes_on = first, bounds[span, row, 1], True
            total += end - begin if goes_on else 0
            reached = end
    return total


def typical(fields: Sequence[FieldOfView]) -> FieldOfView:
    """The field of the most frequent size that overlaps most with the others, of up to MOST_COMPARED that are
    evenly spread: a flash or a dark moment does not move it."""
    size, _ = Counter((one.width, one.height) for one in fields).most_common(1)[0]
    alike = [one for one in fields if (one.width, one.height) == size]
    places: list[int] = np.linspace(0, len(alike) - 1, min(len(alike), MOST_COMPARED)).astype(int).tolist()
    counts = Counter(alike[place] for place in places)

    def agreement(one: FieldOfView) -> float:
        return sum(overlap(one, other) * count for other, count in counts.items())

    return max(counts, key=agreement)
