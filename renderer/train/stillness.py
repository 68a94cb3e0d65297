"""How far tissue moves in a clip, and how much its colour changes, measured on pairs of frames.

Every frame is compared with another, at a low resolution: tissue that is moved aside in a few frames counts
by the pairs that show it, a place that beats by the quarter of the pairs in which it moves farthest. In a
place no larger than a window, noise and the blocks of JPEG displace as far as a vessel that beats, but
another way in every frame: there only what the next two frames repeat counts.

A frame is warped onto another by depth and cameras, as if the tissue were at rest; what displacement is left
is estimated window by window (Lucas & Kanade 1981). It is estimated on the logarithm of red minus green in
linear light: a white highlight cancels in the difference, and in the logarithm smooth shading, which both
follow the lamp rather than the tissue, is a constant that the window's mean takes away.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, product

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from renderer.camera import BoolArray
from renderer.clip import Frame

Plane = NDArray[np.float32]

LONGEST_SIDE = 320
"""Pixels of the frames that are compared: larger ones are halved, thirded, ... until they fit."""
WINDOW = 15
"""Side in pixels."""
FILLED = 0.7
"""Share of a window that must be seen in both frames."""
EXPECTED_ERROR = 0.1
"""Windows whose displacement noise blurs by more pixels than this have too little texture."""
LEAST_TEXTURE = 1e-20
"""Of the determinant of a window's gradients. A grey one, or one with no more red than green, has none, nor
has it noise that would tell so: it is not at rest for that."""
BLOCKS = 4
"""The picture is judged in so many blocks each way."""
LEAST_WINDOWS = 5
"""That a block is judged by."""
REACH = 2
"""A place is this many windows to each side of one: 5 x 5, as wide as 43 pixels."""
LEAST_OF_PLACE = 13
"""Windows that a place is judged by: more than half."""
BEATING = 0.75
"""Quantile over the pairs by which a place is judged: what beats is elsewhere in a quarter of them."""
GAPS = (8, 4, 9, 5, 10, 6, 11, 7)
"""Pairs are these fractions of the clip apart, two of each in turn: no period of the tissue is a multiple of
all."""
LEAST_REPEATED = 6
"""Twos of pairs that a window is judged by."""
CERTAIN = 3.0
"""Standard errors by which the displacements of two such pairs agree. On two phantoms places some 20 px wide
that beat by 2 to 3 px are 0.7 to 1.8 px (one of six 0.3: it has little texture), tissue at rest at most 0.4,
also real frames: noise of up to 5 grey levels, JPEG quality 80 and 60; of 2 errors, 1.2. But the noise of
MPEG-4 at 0.1 bits per pixel goes on from frame to frame: up to 1.7 px at rest. H.264: at most 0.3."""
FROM_MEAN_SQUARE = 1.3
"""Of a sine: what it exceeds a quarter of the time, by which places are judged, to its root mean square."""
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
    """Pixels: the second greatest of a pair's blocks, of the places or of the windows that repeat it.
    Infinite where there is too little to measure."""
    recoloring: float
    """Grey levels: the root mean square over the blocks' mean colours."""
    compared: tuple[int, int, int] = (0, 0, 0)
    """Number of frames, and the columns and rows at which each was compared with another."""


@dataclass(frozen=True, eq=False)
class _Pair:
    """What differs between two frames."""

    displacements: Plane
    """(rows, columns, 2) of windows half a window apart; NaN where there is too little to measure."""
    recoloring: float


def stillness(frames: Sequence[Frame]) -> Stillness:
    """Of frames in the order of time, of equal size. A single frame is still."""
    if len(frames) == 1:
        return Stillness(0.0, 0.0)
    height, width = frames[0].tissue_mask.shape
    factor = -(-max(height, width) // LONGEST_SIDE)
    compared = (len(frames), width // factor, height // factor)
    every = [_compared(*(_reduced(frame, factor) for frame in pair)) for pair in _pairs(frames)]
    pairs = [pair for pair in every if pair is not None]
    lengths = [_of_blocks(pair.displacements) for pair in pairs]
    lengths.append(_of_places([pair.displacements for pair in pairs]))
    lengths.append(_of_windows(every))
    known = [length for length in lengths if length is not None]
    if not known:
        return Stillness(np.inf, np.inf, compared)
    return Stillness(factor * max(known), max(pair.recoloring for pair in pairs), compared)


def _pairs(frames: Sequence[Frame]) -> Iterator[tuple[Frame, Frame]]:
    """Each frame with a later one, the last ones with the first ones; two in turn are as far apart."""
    for index, gap in zip(range(len(frames)), cycle(np.repeat(GAPS, 2).tolist()), strict=False):
        yield frames[index], frames[(index + max(1, len(frames) // gap)) % len(frames)]


def _reduced(frame: Frame, factor: int) -> Frame:
    """The frame at a whole fraction of its size; a rest at the right and lower edges is left out."""
    if factor == 1:
        return frame
    height, width = (length // factor for length in frame.tissue_mask.shape)
    kept = np.s_[: height * factor, : width * factor]
    tissue = np.asarray(frame.tissue_mask[kept].reshape(height, factor, width, factor).all(axis=(1, 3)))
    middles = np.s_[factor // 2 : height * factor : factor, factor // 2 : width * factor : factor]
    lens = frame.camera
    return replace(
        frame,
        image=np.asarray(cv2.resize(frame.image[kept], (width, height), interpolation=cv2.INTER_AREA)),
        camera=replace(
            lens, fx=lens.fx / factor, fy=lens.fy / factor, cx=lens.cx / factor, cy=lens.cy / factor,
            width=width, height=height,
        ),
        tissue_mask=tissue,
        evaluation_mask=tissue,
        depth=None if frame.depth is None else frame.depth[middles],
    )  # fmt: skip


def _compared(first: Frame, second: Frame) -> _Pair | None:
    """What differs between two frames; None where there is too little to measure."""
    if first.camera != second.camera and (first.depth is None or second.depth is None):
        return None
    columns, rows, seen = _correspondence(first, second)
    there = np.asarray(cv2.remap(second.image, columns, rows, cv2.INTER_LINEAR))
    for image in (first.image, there):
        seen &= image.max(axis=2) < BRIGHTEST
    seen = cv2.erode(seen.astype(np.uint8), np.ones((7, 7)), borderValue=0) > 0
    change = there.astype(np.float32) - first.image
    means = [block.mean(axis=0) for block in _blocks(change, seen, WINDOW**2)]
    if not means:
        return None
    texture = np.asarray(cv2.remap(_texture(second.image), columns, rows, cv2.INTER_CUBIC), np.float32)
    displacements = _displacements(_texture(first.image), texture, seen)
    return _Pair(displacements, float(np.sqrt(np.mean(np.square(means)))))


def _of_blocks(displacements: Plane) -> float | None:
    """The second greatest length of the blocks' medians."""
    known = np.isfinite(displacements[..., 0])
    medians = [np.median(block, axis=0) for block in _blocks(displacements, known, LEAST_WINDOWS)]
    return _second_greatest(np.hypot(*median) for median in medians)


def _of_places(displacements: Sequence[Plane]) -> float | None:
    """The second greatest length of the places' medians, in the quarter of the pairs that move farthest.

    A place is judged where at least half of the pairs can be.
    """
    if not displacements or min(displacements[0].shape[:2]) <= 2 * REACH:
        return None
    lengths = np.stack([_lengths_of_places(each) for each in displacements])
    judged = 2 * np.isfinite(lengths).sum(axis=0) >= len(lengths)
    return _second_greatest(np.nanquantile(lengths[:, judged], BEATING, axis=0)) if judged.any() else None


def _of_windows(every: Sequence[_Pair | None]) -> float | None:
    """The second greatest length on which windows agree in two pairs, one frame apart, over all such twos.

    The product of both is on average what they share, squared: noise, which one frame does not share with the
    next, adds nothing. A window is judged where at least half of the twos can be.
    """
    twos = zip(every[::2], every[1::2], strict=False)
    products = [
        (one.displacements * next_one.displacements).sum(axis=2, dtype=np.float64)
        for one, next_one in twos
        if one is not None and next_one is not None
    ]
    if len(products) < LEAST_REPEATED:
        return None
    shared = np.stack(products)
    counts = np.isfinite(shared).sum(axis=0)
    judged = counts >= max(LEAST_REPEATED, len(shared) / 2)
    shared = shared[:, judged]
    error = np.nanstd(shared, axis=0, ddof=1) / np.sqrt(counts[judged])
    squares = np.maximum(np.nanmean(shared, axis=0) - CERTAIN * error, 0)
    return _second_greatest(FROM_MEAN_SQUARE * np.sqrt(squares))


def _lengths_of_places(displacements: Plane) -> Plane:
    """(rows, columns) of the median displacement of the windows about each; NaN for fewer than enough."""
    side = 2 * REACH + 1
    about = sliding_window_view(displacements, (side, side), axis=(0, 1)).reshape(-1, 2, side**2)
    enough = np.isfinite(about[:, 0]).sum(axis=1) >= LEAST_OF_PLACE
    lengths = np.full(len(about), np.nan, np.float32)
    lengths[enough] = np.hypot(*np.nanmedian(about[enough], axis=2).T)
    rows, columns = displacements.shape[:2]
    return lengths.reshape(rows - 2 * REACH, columns - 2 * REACH)


def _second_greatest(lengths: Iterable[float]) -> float | None:
    """A single one may be a highlight."""
    greatest = sorted(lengths)[-2:]
    return float(greatest[0]) if len(greatest) == 2 else None


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
    """(rows, columns, 2) in pixels, of windows half a window apart; NaN where there is too little to measure.

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
    determinant = np.maximum(rr * dd - rd * rd, LEAST_TEXTURE)
    across, along = (rd * dc - dd * rc) / determinant, (rd * rc - rr * dc) / determinant
    spread = 2 * _noise(here) ** 2 * (rr + dd) / (determinant * count)
    good = (count > FILLED * WINDOW**2) & (spread < EXPECTED_ERROR**2) & (determinant > LEAST_TEXTURE)
    return np.where(good[..., None], np.stack([across, along], axis=-1), np.nan).astype(np.float32)


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
