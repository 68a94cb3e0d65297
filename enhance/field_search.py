"""The search of the field of view: in a small copy of the picture, and then along its rim at full size."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np

from enhance.field import MOST_PARTS, FieldOfView, overlap, whole_field
from enhance.field_circle import Points
from enhance.field_copy import low_of, small_copy
from enhance.field_even import apart_from, box_of, is_box, moved
from enhance.field_look import Look, look_at
from enhance.field_outline import (
    LEAST_SURROUND,
    SQUARE,
    Lit,
    Outline,
    around,
    filled,
    lit_above,
    spans_in,
)
from enhance.field_parts import apart, insets, nearest_of, touching
from enhance.field_regions import Levels
from enhance.field_rim import Rim, are_free, cropped_by, dim_beside, left_along_rays
from enhance.field_shape import LEAST_ON_CIRCLE, are_circles, fitted, share_on_circle
from enhance.field_tones import DEVIATIONS, LEAST_SHADED, Tones
from enhance.image import WHOLE, AnyImage, Picture, read_picture

READ: Final = *WHOLE, np.dtype(np.float32), np.dtype(np.float64)
LOW_SIDE: Final = 160
"""Longer side of the small copy, in pixels."""
FAINT, MOST_FAINT = 0.4, 0.25
"""The way from the surround's V to what no noise reaches, and how many pixels beside a sharp end may be
brighter than that."""
FAINT_STEP: Final = 4.0
"""Grey levels, as STEP, of a field whose rim is nearly as dark as the surround."""
LEAST_SIDE: Final = 16
"""Pixels: smaller pictures are too small for a surround with a rim. No narrower, in pixels of the small copy,
is what a page shows."""
RINGED, LEAST_RINGED = 0.5, 0.9
"""Brighter than `Tones.most` by this share of its own height is so much of the rim within a dim ring; and so
much of that rim is on a circle."""
BESIDE: Final = 3
"""Small pixels from a rim to where it is looked at whether a ring lies there."""
EDGE: Final = 2
"""Pixels along the sides of an image on a page."""
MOSTLY, ALL_BUT, SURELY, NEVER = 0.5, 0.7, 0.8, 2.0
"""How much of a polygon's rim runs as circles and frames do: of parts, as no tool runs so; where the rim is
faint, as shade does not; beyond another rim, as stray light does not, wherever it lies; more than any."""


def find_field(image: AnyImage | Picture) -> FieldOfView | None:
    """The field of view of a picture; the whole picture where there is no surround, None where it is too dark
    to tell.

    A surround is dark, or of one colour in three of the four corners at least, even but for noise and text,
    reaches a corner of the picture, and the convex rest of the picture rises sharply from it.

    Raises:
        ImageError: an image that cannot be used.

    Example:
        >>> import numpy as np
        >>> from enhance import find_field
        >>> y, x = np.mgrid[:240, :320] + 0.5
        >>> image = np.where(np.hypot(x - 160, y - 120) < 100, 180, 5).astype(np.uint8)
        >>> [round(value) for value in find_field(image).circle]
        [160, 120, 98]
    """
    picture = image if isinstance(image, Picture) else read_picture(image)
    pixels = picture.pixels
    height, width = pixels.shape[:2]
    whole = whole_field(width, height)
    if min(height, width) < LEAST_SIDE:
        return whole
    if pixels.dtype not in READ:
        # OpenCV reads no other floats.
        pixels = pixels.astype(np.float32)
    factor = _factor_of(height, width)
    small, low = small_copy(pixels, factor)
    look = look_at(low, small)
    surround = look.surround
    if surround is None:
        return _found(pixels, low, look, small, whole, factor)
    low = low_of(apart_from(small, surround))
    field = _found(apart_from(pixels, surround), low, look_at(low), small, whole, factor)
    if field is None or field.is_whole:
        return whole
    left, top, right, bottom = box_of(field)
    # A line across an even image is narrow.
    return whole if min(right - left, bottom - top) < LEAST_SIDE * factor else _shown_on(pixels, field)


def _shown_on(page: AnyImage, field: FieldOfView) -> FieldOfView:
    """A field on a page, without the dark surround that an image on it may have itself."""
    whole, parts = whole_field(field.width, field.height), list[FieldOfView]()
    for part in field.parts or (field,):
        # Without what is half page along its sides.
        left, top, right, bottom = box = tuple(np.add(box_of(part), (EDGE, EDGE, -EDGE, -EDGE)).tolist())
        shown = _in_the_dark(np.ascontiguousarray(page[top:bottom, left:right])) if is_box(part) else None
        if shown is None or shown.is_whole:
            parts.append(part)
        else:
            parts += [moved(one, box, whole) for one in shown.parts or (shown,)]
    if len(parts) > MOST_PARTS:
        return field
    return parts[0] if len(parts) == 1 else replace(whole, parts=tuple(parts))


def _in_the_dark(pixels: AnyImage) -> FieldOfView | None:
    """In a surround that is dark, if any."""
    height, width = pixels.shape[:2]
    factor = _factor_of(height, width)
    small, low = small_copy(pixels, factor)
    return _found(pixels, low, look_at(low), small, whole_field(width, height), factor)


def _factor_of(height: int, width: int) -> int:
    """Of the small copy of such a picture, along each side."""
    return -(-max(height, width) // LOW_SIDE)


def _found(
    pixels: AnyImage, low: Levels, look: Look, colors: Levels, whole: FieldOfView, factor: int
) -> FieldOfView | None:
    """low: `low_of` a small copy of the pixels, by this factor; colors: as they are shown there."""
    tones, lit, outline = look.tones, look.lit, look.outline
    if tones is None or lit is None:
        return whole
    search = _Search(pixels, whole, factor, low, tones)
    if outline is None:
        faint = search.faint(ALL_BUT)
        return None if faint.is_whole else faint
    field = search.without_ring(search.field(lit, outline))
    return search.with_insets(field, colors, lit, outline)


@dataclass(frozen=True, eq=False)
class _Search:
    """In one picture."""

    pixels: AnyImage
    whole: FieldOfView
    factor: int
    low: Levels
    tones: Tones

    def field(self, lit: Lit, outline: Outline) -> FieldOfView:
        """Without insets."""
        threshold = self.tones.threshold
        outlines = apart(self.low, lit)
        parts = self._together([self._rim(one, threshold) for one in outlines]) if outlines else self.whole
        if len(outline.corners) == 0:
            return self.faint(ALL_BUT) if parts.is_whole else parts
        if parts.is_whole and outline.is_dented:
            touch = self._touching(lit)
            if not touch.is_whole:
                return touch
        shaded = _shaded(self.low, self.tones, outline.corners)
        if shaded is not None:
            outline, threshold = shaded, self.tones.least
        rim = self._rim(outline.corners, threshold)
        if not parts.is_whole:
            field = fitted(rim, self.whole, NEVER)
            return parts if field.is_whole else field
        field = fitted(rim, self.whole, 0.0 if outline.is_convex else NEVER)
        if field.is_whole or rim.is_dark:
            faint = self.faint(ALL_BUT)
        elif rim.is_noisy:
            faint = self._beyond_stray_light(field, rim)
        else:
            return field
        return field if faint.is_whole else faint

    def without_ring(self, field: FieldOfView) -> FieldOfView:
        """A round field without the dim ring that is the inside of a sheath or speculum: within it all is
        bright up to another circle, where tissue that darkens towards the rim has none."""
        if field.circle is None or not self._is_dim_within(field.circle):
            return field
        bright, outline = lit_above(self.low, self.tones.most)
        if outline is None or len(outline.corners) == 0 or not outline.is_convex:
            return field
        within = spans_in(filled(self.low, outline.corners.astype(np.int32)))
        middle = self.tones.most + RINGED * (self.tones.most - self.tones.level)
        _, _, rim, sharp = around(self.low, bright.pixels, within, middle)
        if sharp < LEAST_RINGED * rim:
            return field
        found = self._rim(outline.corners, self.tones.most)
        inner = fitted(found, self.whole, NEVER, LEAST_RINGED)
        is_other = inner.circle is not None and are_free(found.cropped)
        return inner if is_other and overlap(inner, field) * (1 + LEAST_SHADED) < 1 else field

    def _is_dim_within(self, circle: tuple[float, float, float]) -> bool:
        """What lies beside its rim, all around."""
        x, y, radius = circle
        beside = x, y, radius - BESIDE * self.factor
        seen, dim = dim_beside(self.low, self.factor, beside, self.tones.most)
        return dim >= LEAST_RINGED * seen

    def _beyond_stray_light(self, field: FieldOfView, rim: Rim) -> FieldOfView:
        """A field beyond a rim that is all lit; all of the picture where a soft rim lies there, which is
        narrow, or stray light, which takes the field its shape."""
        round_at = LEAST_ON_CIRCLE if field.circle is None else share_on_circle(rim, self.whole)
        faint = self.faint(SURELY, round_at)
        is_other = field.circle is not None and faint.circle is None
        is_narrow = overlap(field, faint) * (1 + LEAST_SHADED) > 1
        return self.whole if is_other or is_narrow else faint

    def faint(self, least: float, round_at: float = LEAST_ON_CIRCLE) -> FieldOfView:
        """A field whose rim is hardly brighter than the surround, as lenses that darken towards it have; all
        of the picture where less than `least` of it runs as circles and frames do.

        round_at: share of the rim on a circle from which on it is one.
        """
        step = max(FAINT_STEP, DEVIATIONS * self.tones.noise)
        if np.count_nonzero(self.low <= self.tones.level + step) < LEAST_SURROUND * self.low.size:
            return self.whole
        _, outline = lit_above(self.low, self.tones.level + step, step)
        if outline is None or len(outline.corners) == 0 or not outline.is_convex:
            return self.whole
        rim = self._rim(outline.corners, self.tones.level + step, is_faint=True)
        return fitted(rim, self.whole, least, round_at)

    def _touching(self, lit: Lit) -> FieldOfView:
        """Round fields; all of the picture where there are none that touch."""
        hulls, circles = touching(self.low, lit)
        if not hulls:
            return self.whole
        circles[:, :2] = (circles[:, :2] + 0.5) * self._scale
        circles[:, 2] *= self._scale.mean()
        rims = list[Rim]()
        for place, hull in enumerate(hulls):
            rim = self._rim(hull, self.tones.threshold)
            nearest = nearest_of(rim.points[:, 0], rim.points[:, 1], circles)
            rims.append(cropped_by(rim, nearest != place))
        return self._together(rims) if are_circles(rims, self.whole) else self.whole

    def with_insets(self, field: FieldOfView, small: AnyImage, lit: Lit, outline: Outline) -> FieldOfView:
        """A field, and what looks like a small one beside it."""
        if field.is_whole or len(outline.corners) == 0 or small.ndim == 2:
            return field
        found = insets(self.low, small, lit, outline.corners)
        parts = list(field.parts or (field,))
        for one in found[: MOST_PARTS - len(parts)]:
            inset = fitted(self._rim(one, self.tones.threshold), self.whole, MOSTLY)
            parts += [] if inset.is_whole else [inset]
        return replace(self.whole, parts=tuple(parts)) if len(parts) > len(field.parts or (field,)) else field

    def _rim(self, corners: Points, threshold: float, *, is_faint: bool = False) -> Rim:
        size, most = self.low.shape, self.tones.most
        return left_along_rays(self.pixels, corners, size, threshold, most, self.factor, is_faint=is_faint)

    @property
    def _scale(self) -> Points:
        """Of a pixel of the small copy."""
        return np.array([self.whole.width / self.low.shape[1], self.whole.height / self.low.shape[0]])

    def _together(self, rims: list[Rim]) -> FieldOfView:
        """All of the picture where one of them is no field."""
        parts = tuple(fitted(rim, self.whole, MOSTLY) for rim in rims)
        if any(one.is_whole for one in parts):
            return self.whole
        return replace(self.whole, parts=parts)


def _shaded(low: Levels, tones: Tones, lit: Points) -> Outline | None:
    """The outline with tissue in the shade; None: there is none beyond the outline of what is lit."""
    if not tones.may_be_shaded:
        return None
    _, outline = lit_above(low, tones.least)
    if outline is None or len(outline.corners) == 0 or not outline.is_convex:
        return None
    field, before = (filled(low, corners.astype(np.int32)) for corners in (outline.corners, lit))
    if field.sum() < (1 + LEAST_SHADED) * before.sum():
        return None
    # Two pixels outside, where the outline has moved.
    near = cv2.dilate(field, SQUARE)
    beside = low[(cv2.dilate(near, SQUARE) > near) & (cv2.dilate(before, SQUARE, iterations=4) == 0)]
    faint = beside > tones.level + FAINT * (tones.least - tones.level)
    return outline if len(beside) > 0 and faint.mean() <= MOST_FAINT else None
