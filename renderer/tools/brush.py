"""A mask mended by hand: a line drawn with a brush, and an area grown from it up to edges in the image."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal

import cv2
import numpy as np

from renderer.clip import BoolImage, ByteImage

Stroke = Literal["paint", "erase", "grow"]
Point = tuple[float, float]
"""Column and row of the image."""

REACH: Final = 6.0
"""Radii of the brush that an area grows to at most, from the line."""
_SIDE = 400
"""Pixels of the longer side of what is grown in: GrabCut's time goes with their number."""
_ROUNDS = 3
_SUBPIXEL = 4
"""Bits of a pixel's fraction that OpenCV draws with."""


def drawn(mask: BoolImage, line: Sequence[Point], radius: float, *, value: bool) -> BoolImage:
    """The mask (H, W) with a round brush drawn along a line; a single point is a dot."""
    canvas = mask.astype(np.uint8)
    points = np.round(np.asarray(line, dtype=np.float64) * 2**_SUBPIXEL).astype(np.int32)
    for start, end in zip(points, points[1:] if len(points) > 1 else points, strict=False):
        cv2.line(
            canvas, tuple(map(int, start)), tuple(map(int, end)), int(value),
            max(1, round(2 * radius)), cv2.LINE_8, _SUBPIXEL,
        )  # fmt: skip
    return canvas > 0


def grown(image: ByteImage, mask: BoolImage, line: Sequence[Point], radius: float) -> BoolImage:
    """The mask with what belongs to the line added: GrabCut from the line as tool, within `REACH`.

    What lies at the end of the reach and is not masked counts as tissue. Rother et al., GrabCut, 2004.
    """
    line_mask = drawn(np.zeros_like(mask), line, radius, value=True)
    (left, top), (right, bottom) = _box(line_mask.shape, line, (REACH + 2) * radius)
    if right - left < 2 or bottom - top < 2:
        return mask | line_mask
    part = np.s_[top:bottom, left:right]
    area = _cut(image[part], mask[part], line_mask[part], radius)
    out = mask | line_mask
    out[part] |= area
    return out


def _box(shape: tuple[int, ...], line: Sequence[Point], margin: float) -> tuple[tuple[int, int], ...]:
    """Left and top, right and bottom, within the image."""
    points = np.asarray(line, dtype=np.float64)
    most = np.array((shape[1], shape[0]))
    low = np.clip(np.floor(points.min(axis=0) - margin), 0, most).astype(int)
    high = np.clip(np.ceil(points.max(axis=0) + margin), 0, most).astype(int)
    return (int(low[0]), int(low[1])), (int(high[0]), int(high[1]))


def _cut(image: ByteImage, mask: BoolImage, line: BoolImage, radius: float) -> BoolImage:
    """(h, w) of a part of the image: what GrabCut joins to the line, where it touches it."""
    height, width = line.shape
    scale = min(1.0, _SIDE / max(height, width))
    size = max(1, round(width * scale)), max(1, round(height * scale))
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    sure, known = (
        cv2.resize(each.astype(np.uint8), size, interpolation=cv2.INTER_AREA) for each in (line, mask)
    )
    far = cv2.distanceTransform(1 - sure, cv2.DIST_L2, 5) > REACH * radius * scale
    labels = np.full(sure.shape, cv2.GC_PR_BGD, np.uint8)
    labels[far & (known == 0)] = cv2.GC_BGD
    labels[(far & (known > 0)) | (sure > 0)] = cv2.GC_FGD
    near = cv2.dilate(sure, np.ones((3, 3), np.uint8), iterations=max(1, round(radius * scale)))
    labels[(labels == cv2.GC_PR_BGD) & ((near > 0) | (known > 0))] = cv2.GC_PR_FGD
    if not (labels == cv2.GC_FGD).any() or not (labels == cv2.GC_BGD).any():
        return line
    cv2.setRNGSeed(0)  # GrabCut begins with k-means.
    models = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(small, labels, (0, 0, 1, 1), *models, _ROUNDS, cv2.GC_INIT_WITH_MASK)
    found = ((labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD)).astype(np.uint8)
    _, areas = cv2.connectedComponents(found, connectivity=4)
    touched = np.unique(areas[(sure > 0) & (found > 0)])
    joined = np.isin(areas, touched[touched > 0]).astype(np.float32)
    return np.asarray(cv2.resize(joined, (width, height), interpolation=cv2.INTER_LINEAR) > 0.5)
