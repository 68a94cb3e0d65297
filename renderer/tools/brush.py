"""A mask mended by hand: a line drawn with a brush, and an area grown from it up to edges in the image."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal

import cv2
import numpy as np
from numpy.typing import ArrayLike

from renderer.clip import BoolImage, ByteImage

Stroke = Literal["paint", "erase", "grow"]
Point = tuple[float, float]
"""Column and row of the image, the middle of its first pixel at 0.5."""

REACH: Final = 6.0
"""Radii of the brush that an area grows to at most, from the line."""
_SIDE = 400
"""Pixels of the longer side of what is grown in: GrabCut's time goes with their number."""
_THICK = 6.0
"""Pixels of a radius at least, where there is room: GrabCut tells little from few pixels."""
_ROUNDS = 3
_THINNEST = 0.75
"""px: a thinner line would miss pixels that it crosses."""


def drawn(mask: BoolImage, line: Sequence[Point], radius: float, *, value: bool) -> BoolImage:
    """The mask (H, W) with a round brush drawn along a line: pixels whose middle is within `radius` of it,
    and those that it crosses. A single point is a dot."""
    out = mask.copy()
    points = np.asarray(line, dtype=np.float64)
    reach = max(radius, _THINNEST)
    for start, end in zip(points, points[1:] if len(points) > 1 else points, strict=False):
        (left, top), (right, bottom) = _box(mask.shape, (start, end), reach)
        rows, columns = np.mgrid[top:bottom, left:right] + 0.5
        x, y = columns - start[0], rows - start[1]
        along, across = end - start
        share = np.clip((x * along + y * across) / max(along**2 + across**2, 1e-12), 0, 1)
        near = (x - share * along) ** 2 + (y - share * across) ** 2 <= reach**2
        out[top:bottom, left:right][near] = value
    return out


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


def _box(shape: tuple[int, ...], line: ArrayLike, margin: float) -> tuple[tuple[int, int], ...]:
    """Left and top, right and bottom, within the image."""
    points = np.asarray(line, dtype=np.float64)
    most = np.array((shape[1], shape[0]))
    low = np.clip(np.floor(points.min(axis=0) - margin), 0, most).astype(int)
    high = np.clip(np.ceil(points.max(axis=0) + margin), 0, most).astype(int)
    return (int(low[0]), int(low[1])), (int(high[0]), int(high[1]))


def _cut(image: ByteImage, mask: BoolImage, line: BoolImage, radius: float) -> BoolImage:
    """(h, w) of a part of the image: what GrabCut joins to the line, where it touches it."""
    height, width = line.shape
    scale = min(max(1.0, _THICK / radius), _SIDE / max(height, width))
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    size = max(1, round(width * scale)), max(1, round(height * scale))
    small = cv2.resize(image, size, interpolation=how)
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
