"""How far vessels stand out by colour: CIEDE2000 between them and what lies beside them."""

from __future__ import annotations

import math
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.image import AnyImage, BoolImage
from enhance.measured_pixels import unit
from enhance.metrics import scaled, vessel_and_ring

BLOCK: Final = 64
"""Pixels of a block's side."""
LEAST_BLOCK: Final = 16
LEAST: Final = 12
"""Pixels of either kind; blocks with fewer say nothing."""
Lab = NDArray[np.float64]


def vessel_color_difference(
    image: AnyImage, vessel_mask: BoolImage, *, tissue_mask: BoolImage | None = None, scale: float = 1.0
) -> float:
    """Colour difference (CIEDE2000) between vessels and their surroundings: 1 is just noticeable.

    In each block of 64 x 64 pixels, of the mean colour of the vessel and that of the ring of
    `vessel_contrast`; the mean over blocks that hold both. Vessels lighter than their surroundings count as
    well. To compare methods, keep one mask. NaN: no block holds enough of both.

    Args:
        tissue_mask: (H, W), True = keep; the ring lies within.
        scale: of the blocks and of the ring, as of `line_scale`.

    Raises:
        ImageError: a mask of another size.

    Example:
        >>> import numpy as np
        >>> from enhance import vessel_color_difference
        >>> image = np.full((64, 64, 3), (200, 120, 110), np.uint8)
        >>> vessel = np.zeros((64, 64), bool)
        >>> vessel[:, 30:34] = True
        >>> image[vessel] = 170, 80, 75
        >>> round(vessel_color_difference(image, vessel), 1)
        13.5
    """
    pixels, vessel, ring = vessel_and_ring(image, vessel_mask, tissue_mask, scale)
    (first, of_vessel), (second, of_ring) = (
        _by_block(pixels, where, scaled(BLOCK, scale, LEAST_BLOCK)) for where in (vessel, ring)
    )
    both = (of_vessel >= LEAST) & (of_ring >= LEAST)
    return float(ciede2000(first[both], second[both]).mean()) if both.any() else math.nan


def _by_block(pixels: AnyImage, where: BoolImage, side: int) -> tuple[Lab, NDArray[np.int64]]:
    """Mean colour of the chosen pixels of each block, (blocks, 3), and their number."""
    y, x = np.nonzero(where)
    across, down = (-(-size // side) for size in (pixels.shape[1], pixels.shape[0]))
    block = (y // side) * across + x // side
    count = np.bincount(block, minlength=across * down)
    chosen = unit(pixels[y, x])
    chosen = chosen if chosen.ndim == 2 else np.repeat(chosen[:, None], 3, axis=1)
    if not len(chosen):
        return np.zeros((across * down, 3)), count
    lab = np.asarray(cv2.cvtColor(np.ascontiguousarray(chosen[None], np.float32), cv2.COLOR_RGB2Lab))[0]
    sums = [np.bincount(block, lab[:, axis], across * down) for axis in range(3)]
    return np.stack(sums, axis=1) / np.maximum(count, 1)[:, None], count


def ciede2000(one: Lab, other: Lab) -> NDArray[np.float64]:
    """Difference of colours in CIELAB, (..., 3) to (...): ISO/CIE 11664-6 with all weights 1; steps and signs
    as in Sharma, Wu and Dalal, Color Research and Application 30(1), 2005."""
    (l1, a1, b1), (l2, a2, b2) = (np.moveaxis(np.asarray(lab, np.float64), -1, 0) for lab in (one, other))
    mean = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2
    stretch = 1.5 - 0.5 * np.sqrt(mean**7 / (mean**7 + 25.0**7))
    c1, c2 = np.hypot(stretch * a1, b1), np.hypot(stretch * a2, b2)
    h1, h2 = (np.degrees(np.arctan2(b, stretch * a)) % 360 for a, b in ((a1, b1), (a2, b2)))
    colored = c1 * c2 > 0
    apart = np.where(colored, (h2 - h1 + 180) % 360 - 180, 0.0)
    apart = np.where(colored & (h2 - h1 == 180), 180.0, apart)
    middle = (h1 + h2) / 2 + np.where(np.abs(h1 - h2) > 180, np.where(h1 + h2 < 360, 180.0, -180.0), 0.0)
    hue = np.radians(np.where(colored, middle, h1 + h2))
    light, chroma = (l1 + l2) / 2, (c1 + c2) / 2
    t = 1 - 0.17 * np.cos(hue - np.radians(30)) + 0.24 * np.cos(2 * hue)
    t += 0.32 * np.cos(3 * hue + np.radians(6)) - 0.20 * np.cos(4 * hue - np.radians(63))
    turn = np.radians(30 * np.exp(-(((np.degrees(hue) - 275) / 25) ** 2)))
    rotation = -np.sin(2 * turn) * 2 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    of_light = (l2 - l1) / (1 + 0.015 * (light - 50) ** 2 / np.sqrt(20 + (light - 50) ** 2))
    of_chroma = (c2 - c1) / (1 + 0.045 * chroma)
    of_hue = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(apart) / 2) / (1 + 0.015 * chroma * t)
    square = of_light**2 + of_chroma**2 + of_hue**2 + rotation * of_chroma * of_hue
    return np.asarray(np.sqrt(np.maximum(square, 0)))
