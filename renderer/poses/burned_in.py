"""Borders of the picture that are no view of the scene: bars and marks that stay while all else moves, and
thin bars that are dark beside tissue that is lit."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.camera import FloatArray
from renderer.clip import BoolImage, ByteImage, Frame
from renderer.readers.masks.lit_part import LIT

_DEEPEST: Final = 0.1
"""Of the height or width: farther in, an edge is no border."""
_REACH = 2
"""px to either side of an edge; as many are added, for its blur."""
_CONTRAST = 0.4
"""Of the brighter side."""
_LONG = 0.1
"""Share of the rows or columns that show the edge at least."""
_THIN: Final = 0.02, 3
"""Of the height or width, or px where that is more: wider bars are a surround."""
_DARK: Final = 0.5
"""Of the brightness of the tissue beside it, what a bar has at most."""
_OFTEN: Final = 0.5
"""Share of the frames that tell a bar from tissue beside it at least; the others show no light there."""


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


def dark_bars(frames: Iterable[Frame]) -> tuple[int, int, int, int]:
    """Widths in px at the left, top, right and bottom of bars, as rectified video has them; 0 = none, as of
    frames of several sizes.

    Edges of the scene stay, too, where the camera is at rest. So a bar is thin, up to the border dark by the
    tissue beside it, in all of the frames, and ends along one row or column for _LONG of a side. Where a mask
    or darkness hides the tissue, a frame tells nothing.
    """
    found, sizes = list[list[BoolImage]](), set[tuple[int, ...]]()
    for frame in frames:
        sides = zip(_sides(frame.image.max(axis=2)), _sides(frame.tissue_mask), strict=True)
        found.append([_told_and_dark(*side) for side in sides])
        sizes.add(frame.tissue_mask.shape)
    if len(found) < 2 or len(sizes) > 1:
        return 0, 0, 0, 0
    left, top, right, bottom = (_thickness(np.array(side)) for side in zip(*found, strict=True))
    return left, top, right, bottom


def _sides(image: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    """Of (H, W), each with the left, top, right and bottom border as its first row."""
    return image.T, image, image.T[::-1], image[::-1]


def _told_and_dark(level: ByteImage, tissue: BoolImage) -> BoolImage:
    """(2, D, W) for each row from the border on: whether it tells anything, and whether all up to the border
    is dark by the tissue _REACH farther in."""
    inner = level[_REACH + 1 :][: max(round(_THIN[0] * len(level)), _THIN[1])]
    outer = np.maximum.accumulate(level[: len(inner)])
    told = tissue[_REACH + 1 :][: len(inner)] & (np.maximum(outer, inner) > LIT)
    return np.stack((told, told & (outer < _DARK * inner)))


def _thickness(frames: BoolImage) -> int:
    """Rows of a bar that (F, 2, D, W) frames show, and one for its blur."""
    told, dark = frames.sum(axis=0)
    bar = (dark == told) & (dark > _OFTEN * len(frames))
    edges = np.flatnonzero(bar.mean(axis=1) > _LONG)
    return int(edges[-1]) + 2 if len(edges) else 0
