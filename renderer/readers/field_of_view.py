"""The part of the picture that an endoscope sees, from its lit pixels: what a mask is checked against."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from renderer.clip import BoolImage, ByteImage

LIT = 30
"""Of 255: the surround stays below, compression noise included."""
DISPLACED = 0.05
"""Share of the lit field beyond a mask, and of the mask on the black surround, from which it is misplaced."""
_RIM = 1 / 200
"""Of the picture's width: the bright ring at the edge of the lens, which is no tissue."""


def lit_field(images: Sequence[ByteImage]) -> BoolImage:
    """(H, W), the largest area that is lit in any of the (H, W, 3) images, without holes and its rim; all
    False where nothing is lit."""
    brightest = np.max([image.max(axis=2) for image in images], axis=0)
    lit = (brightest > LIT).astype(np.uint8)
    field = np.zeros_like(lit)
    outlines, _ = cv2.findContours(lit, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if outlines:
        cv2.drawContours(field, [max(outlines, key=cv2.contourArea)], -1, (1,), cv2.FILLED)
    side = 2 * round(lit.shape[1] * _RIM) + 1
    # Beyond the picture the field goes on: it has no rim there.
    return np.asarray(cv2.erode(field, np.ones((side, side), np.uint8)) > 0)


def is_displaced(mask: BoolImage, field: BoolImage) -> bool:
    """Whether the mask both leaves out lit tissue and takes in black surround: it is of other pictures.

    A mask that is only narrower, or only wider, says something that the light does not.
    """
    if not mask.any() or not field.any():
        return False
    left_out, taken_in = np.mean(~mask[field]), np.mean(~field[mask])
    return bool(min(left_out, taken_in) > DISPLACED)
