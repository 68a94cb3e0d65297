"""How far tissue moves in a clip, and how much its colour changes, measured on pairs of frames.

A frame is warped onto another by depth and cameras, as if the tissue were at rest; what displacement is left
is estimated window by window (Lucas & Kanade 1981). It is estimated on the logarithm of red minus green in
linear light: a white highlight cancels in the difference, and in the logarithm smooth shading, which both
follow the lamp rather than the tissue, is a constant that the window's mean takes away.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import Frame

Plane = NDArray[np.float32]
BoolArray = NDArray[np.bool_]

WINDOW = 15
"""Side in pixels."""
FILLED = 0.7
"""Share of a window that must be seen in both frames."""
EXPECTED_ERROR = 0.1
"""Windows whose displacement noise blurs by more pixels than this have too little texture."""
BLOCKS = 4
"""The picture is judged in so many blocks each way."""
LEAST_WINDOWS = 5
"""That a block is judged by."""
GAPS = (4, 5, 6, 7, 8, 9, 10, 11)
"""Pairs are these fractions of the clip apart: no period of the tissue is a multiple of all of them."""
BRIGHTEST = 250
"""Channels at or above this may be cut off."""
HIDDEN = 1.05
"""A point this much farther than the depth measured there is behind something."""
DARK = np.float32(0.02)
"""Added to red minus green, in linear light, before the logarithm."""
BLUR = 0.7  # px


@dataclass(frozen=True)
class Stillness:
    """The greatest changes between any two of the frames compared."""

    displacement: float
    """Pixels: the second greatest median of a block. Infinite where there is too little to measure."""
    recoloring: float
    """Grey levels: the root mean square over the blocks' mean colours."""


def stillness(frames: Sequence[Frame]) -> Stillness:
    """Of frames in the order of time. A single frame is still."""
    if len(frames) == 1:
        return Stillness(0.0, 0.0)
    compared = [_compared(first, second) for first, second in _pairs(frames)]
    measured = [each for each in compared if each is not None]
    if not measured:
        return Stillness(np.inf, np.inf)
    displacements, recolorings = zip(*measured, strict=True)
    return Stillness(max(displacements), max(recolorings))


def _pairs(frames: Sequence[Frame]) -> Iterator[tuple[Frame, Frame]]:
    for place, gap in enumerate(GAPS):
        apart = max(1, len(frames) // gap)
        start = round(place / (len(GAPS) - 1) * (len(frames) - 1 - apart))
        yield frames[start], frames[start + apart]


def _compared(first: Frame, second: Frame) -> tuple[float, float] | None:
    """Displacement and change of colour between two frames; None where there is too little to measure."""
    if first.camera != second.camera and (first.depth is None or second.depth is None):
        return None
    columns, rows, seen = _correspondence(first, second)
    there = np.asarray(cv2.remap(second.image, columns, rows, cv2.INTER_LINEAR))
    for image in (first.image, there):
        seen &= image.max(axis=2) < BRIGHTEST
    seen = cv2.erode(seen.astype(np.uint8), np.ones((7, 7)), borderValue=0) > 0
    here = _texture(first.image)
    lengths = _displacements(
        here, np.asarray(cv2.remap(_texture(second.image), columns, rows, cv2.INTER_CUBIC)), seen
    )
    medians = sorted(np.median(block) for block in _blocks(lengths, np.isfinite(lengths), LEAST_WINDOWS))
    if len(medians) < 2:
        return None
    change = there.astype(np.float32) - first.image
    means = [block.mean(axis=0) for block in _blocks(change, seen, WINDOW**2)]
    if not means:
        return None
    return float(medians[-2]), float(np.sqrt(np.mean(np.square(means))))


def _correspondence(first: Frame, second: Frame) -> tuple[Plane, Plane, BoolArray]:
    """Where `second` shows what each pixel of `first` shows, if it rests, and whether both see it.

    Columns and rows (H, W) count from the centre of the first pixel, as OpenCV does.
    """
    height, width = first.tissue_mask.shape
    seen = first.tissue_mask.copy()
    if first.camera == second.camera:
        columns, rows = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    else:
        assert first.depth is not None
        assert second.depth is not None
        points = first.camera.unproject(first.depth).reshape(-1, 3)
        pixels, depth = second.camera.project(points)
        columns, rows = (pixels - 0.5).astype(np.float32).T.reshape(2, height, width)
        measured = cv2.remap(second.depth, columns, rows, cv2.INTER_NEAREST)
        depth = depth.reshape(height, width)
        seen &= first.depth_mask & (depth > 0) & (depth < HIDDEN * measured)
    tissue = cv2.erode(second.tissue_mask.astype(np.uint8), np.ones((3, 3)))
    seen &= cv2.remap(tissue, columns, rows, cv2.INTER_NEAREST) > 0
    return columns, rows, seen


def _texture(image: NDArray[np.uint8]) -> Plane:
    """(H, W) log of red minus green in linear light."""
    linear = ((np.arange(256) / 255) ** 2.2).astype(np.float32)
    red, green = (cv2.GaussianBlur(linear[image[:, :, channel]], (0, 0), BLUR) for channel in (0, 1))
    return np.asarray(np.log(np.maximum(red - green, 0) + DARK))


def _displacements(here: Plane, there: Plane, seen: BoolArray) -> Plane:
    """Lengths in pixels, of windows half a window apart; NaN where there is too little to measure.

    In each window the displacement d minimises the sum of (there - here + gradient . d - mean)^2.
    """
    middle, change = (here + there) / 2, there - here
    right = np.asarray(cv2.Sobel(middle, cv2.CV_32F, 1, 0, ksize=3, scale=1 / 8), np.float32)
    down = np.asarray(cv2.Sobel(middle, cv2.CV_32F, 0, 1, ksize=3, scale=1 / 8), np.float32)
    weight = seen.astype(np.float32)
    step = WINDOW // 2

    def sums(values: Plane) -> NDArray[np.float64]:
        whole = cv2.boxFilter(values * weight, cv2.CV_32F, (WINDOW, WINDOW), normalize=False)
        return np.asarray(whole[step::step, step::step], np.float64)

    count = np.maximum(sums(weight), 1.0)

    def covariance(one: Plane, other: Plane) -> NDArray[np.float64]:
        return np.asarray(sums(one * other) / count - sums(one) * sums(other) / count**2)

    rr, rd, dd = covariance(right, right), covariance(right, down), covariance(down, down)
    rc, dc = covariance(right, change), covariance(down, change)
    determinant = np.maximum(rr * dd - rd * rd, 1e-20)
    lengths = np.hypot(dd * rc - rd * dc, rr * dc - rd * rc) / determinant
    spread = 2 * _noise(here) ** 2 * (rr + dd) / (determinant * count)
    good = (count > FILLED * WINDOW**2) & (spread < EXPECTED_ERROR**2)
    return np.where(good, lengths, np.nan).astype(np.float32)


def _noise(plane: Plane) -> float:
    """Standard deviation, from second differences both ways, which smooth pictures have little of."""
    kernel = np.outer([1, -2, 1], [1, -2, 1]).astype(np.float32)
    differences = cv2.filter2D(plane, cv2.CV_32F, kernel)[1:-1, 1:-1]
    return float(np.median(np.abs(differences))) / (0.6745 * 6)


def _blocks(values: Plane, chosen: BoolArray, least: int) -> Iterator[Plane]:
    """The chosen values of each block that has at least so many."""
    parts = [np.array_split(np.arange(length), BLOCKS) for length in chosen.shape]
    for rows, columns in product(*parts):
        place = np.ix_(rows, columns)
        if np.count_nonzero(chosen[place]) >= least:
            yield values[place][chosen[place]]
