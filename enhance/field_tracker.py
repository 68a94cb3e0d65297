"""The field of view of a live stream: looked for now and then, and kept while single images disagree."""

from __future__ import annotations

from typing import Final

from enhance.field import FieldOfView, overlap, whole_field
from enhance.field_search import find_field
from enhance.image import Picture

EVERY: Final = 8
"""Images from one look to the next."""
SAME: Final = 0.98
"""Overlap from which on two fields are one."""


class FieldTracker:
    """Follows one stream.

    A flash, a dark moment or an instrument at the rim moves a field that is found in one image; a field takes
    the place of another once two looks in a row agree on it. What is too dark to tell says nothing.
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
        if self._other is not None and overlap(found, self._other) > SAME >= overlap(found, self._field):
            self._field = found
        self._other = found
