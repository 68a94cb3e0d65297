"""Which pixels show the light that tissue scatters: not the lamp's reflections, nor the black surround."""

from __future__ import annotations

import cv2
import numpy as np

from renderer.clip import BoolImage, ByteImage
from renderer.depth.averaging import averaged

_BLACK = 10
"""Largest channel of the surround of an endoscopic picture, in grey levels."""
_SATURATED = 235
"""Smallest channel of a reflection that is as large as its surroundings."""
_REACH = 0.03
"""Of the width: standard deviation of the surroundings that a reflection stands out of."""
_CONTRAST, _STEP = 1.2, 0.2
"""A reflection's smallest channel is above this multiple of its surroundings plus this share of the
level that one pixel in ten exceeds: whatever the exposure, the same pixels."""
_LEAST = 1e-3
"""Share of seen surroundings below which there are none."""
_MARGIN = 1 / 90
"""Of the width: what the blur of the lens and the window of a matcher still feel of a reflection."""


def well_exposed(image: ByteImage, seen: BoolImage | None = None) -> BoolImage:
    """(H, W), True where an RGB picture (H, W, 3) is neither black nor a reflection of the lamp.

    What is not `seen`, the surround of a round view, counts for no surroundings; None: all is seen.

    Reflections are white, so they stand out most in the smallest channel. They move with lamp and
    eye, not with the tissue: two views of one lie at the depth of the mirrored lamp. The constants
    were chosen on phantoms with seeds 11 to 13, where leaving these pixels out halves the number of
    matches that are off by more than a pixel.
    """
    width = image.shape[1]
    whiteness, level = image.min(axis=2), image.max(axis=2)
    within = np.ones_like(whiteness, bool) if seen is None or not seen.any() else seen
    share = averaged(within.astype(np.float32), _REACH)
    around = averaged((within * whiteness).astype(np.float32), _REACH) / np.maximum(share, _LEAST)
    step = _STEP * float(np.percentile(level[within], 90))
    bright = (whiteness > _CONTRAST * around + step) | (whiteness > _SATURATED)
    across = max(round(_MARGIN * width), 1)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (across, across))
    reflection = cv2.dilate(bright.astype(np.uint8), disc) > 0
    return np.asarray(~reflection & (level > _BLACK))
