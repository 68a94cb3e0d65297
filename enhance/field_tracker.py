"""The field of view of a live stream: looked for now and then, and kept while single images disagree."""

from __future__ import annotations

from typing import Final

from enhance.field import FieldOfView, overlap, uncovered, whole_field
from enhance.field_search import find_field
from enhance.image import Picture

EVERY: Final = 8
"""Images from one look to the next."""
SAME: Final = 0.98
"""Overlap from which on two fields are one."""
NEAR: Final = 0.5
"""Overlap of two looks at a field that moves."""


class FieldTracker:
    """Follows one stream.

    A flash, a dark moment or an instrument at the rim moves a field that is found in one image; a field takes
    the place of another once two looks in a row agree on it, or on where it moves. What is too dark to tell
    says nothing.
    """

    def __init__(self) -> None:
        self._field: FieldOfView | None = None
        self._other: FieldOfView | None = None
        self._until_next = 0

    def follow(self, picture: Picture) -> FieldOfView:
        """The field of the next image; all of it until one has been found."""
        height, width = picture.pixels.shape[:2]
        if self._field is None or not self._field.fits(picture.pixels):
            self._field = self._other = find_field(picture)
            self._until_next = EVERY
            return self._field or whole_field(width, height)
        self._until_next -= 1
        if self._until_next <= 0:
            self._until_next = EVERY
            self._weigh(find_field(picture))
        return self._field

    def _weigh(self, found: FieldOfView | None) -> None:
        if found is None or self._field is None:
            return
        if self._other is not None and _follows(found, self._other, self._field):
            self._field = found
        self._other = found


def _follows(found: FieldOfView, other: FieldOfView, kept: FieldOfView) -> bool:
    """Whether the field is no longer where it was: it is at another place in two looks, or on its way there.

    What moves reaches beyond where it was, from one look to the next; what grows dark in the field does not.
    """
    step, way = overlap(found, other), overlap(found, kept)
    if way > SAME or step > SAME:
        return way <= SAME
    moves_on = step > max(way, NEAR)
    return moves_on and min(uncovered(other, kept), uncovered(found, kept)) > 1 - SAME
