"""Borders of the picture that are no view of the scene: bars and marks that stay while all else moves."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from renderer.camera import FloatArray
from renderer.clip import ByteImage

_DEEPEST: Final = 0.1
"""Of the height or width: farther in, an edge is no border."""
_REACH = 2
"""px to either side of an edge; as many are added, for its blur."""
_CONTRAST = 0.4
"""Of the brighter side."""
_LONG = 0.1
"""Share of the rows or columns that show the edge at least."""


def burned_in_borders(images: Iterable[ByteImage]) -> tuple[int, int, int, int]:
    """Widths in px at the left, top, right and bottom, of images (H, W, 3) of a camera that moves; 0 = none.

    In the mean of frames of a moving camera the edges of the scene are blurred, and those are sharp that
    the picture itself has.
    """
    total, count = np.zeros(()), 0
    for image in images:
        total, count = total + image.max(axis=2).astype(np.float64), count + 1
    mean = np.asarray(total / max(count, 1))
    if count < 2 or min(mean.shape) < 4 * _REACH + 4:
        return 0, 0, 0, 0
    return _depth(mean.T), _depth(mean), _depth(mean.T[::-1]), _depth(mean[::-1])


def _depth(mean: FloatArray) -> int:
    """Rows at the top of (H, W) that belong to the border."""
    deepest = max(round(_DEEPEST * len(mean)), _REACH + 1)
    outer, inner = mean[: deepest - _REACH], mean[2 * _REACH : deepest + _REACH]
    sharp = np.abs(inner - outer) > _CONTRAST * np.maximum(inner, outer)
    edges = np.flatnonzero(sharp.mean(axis=1) > _LONG)
    return int(edges[-1]) + 2 * _REACH + 1 if len(edges) else 0
