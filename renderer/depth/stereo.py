"""Disparity of a rectified pair of pictures: semi-global matching, checked both ways, refined."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, ByteImage
from renderer.depth.averaging import Float32Image
from renderer.depth.exposure import well_exposed

GreyImage = NDArray[np.uint8]

_BLOCK = 7  # px
_SMALL, _LARGE = 8 * _BLOCK**2, 32 * _BLOCK**2
"""Penalties for a disparity that changes by one pixel, and by more."""
_UNIQUENESS = 5
"""Percent by which the best match must beat every other."""
_GRADIENT_CAP = 31
_STEPS = 16
"""Fractions of a pixel in OpenCV's result; its range is a multiple of as many pixels."""
FARTHEST = 2**15 // _STEPS - 1 - _STEPS
"""px of disparity that its 16-bit numbers hold, with a step of the range to spare."""
_AGREEMENT = 1.0
"""Largest difference in px between the disparities found from the left and from the right."""
_SPECKLE_SHARE = 5e-4
"""Of the picture: a smaller patch at a disparity of its own is a failed match."""

FEWEST_FEATURES = 20
"""Recognised in both images of a pair that shows one scene."""
_COARSE_WIDTH = 320
_WIDEST = 0.5
"""Largest disparity looked for, as a share of the width."""
_RANGE_PERCENTILES = (0.5, 99.5)
_MARGIN_PIXELS, _MARGIN_SHARE = 4.0, 0.15
_FEWEST = 0.3
"""Share of pixels that must match in the coarse pictures: chance matches a quarter of smooth ones."""

_WINDOW = 6.0
"""Standard deviation in px of the window of the last refinement and of the local mean."""
_LARGEST_STEP = 0.5  # px
_FLAT = 1e-3
"""Squared gradient of normalised grey below which a window tells nothing."""

_FEATURE_WIDTH = 640
_FEATURES = 2000
_RATIO = 0.7
"""Lowe's ratio test: the best match is nearer than this share of the second best."""


def disparity(left: ByteImage, right: ByteImage) -> Float32Image:
    """How far each pixel of `left` lies to the right of its match in `right`, in px; 0 = no match.

    Both are RGB (H, W, 3), rows matching rows. Semi-global matching (Hirschmüller, PAMI 2008, in
    OpenCV) over the range that coarse pictures show, from the left and from the right, where both
    must agree within a pixel; patches on their own, reflections and black are left out, and holes
    stay holes. Beyond FARTHEST they are looked for in smaller pictures. One Gauss-Newton step (Lucas & Kanade
    1981) on the locally normalised pictures then halves the median error, whose fractions the matcher
    interpolates towards whole pixels.

    Constants were chosen on phantoms with seeds 11 to 13 and 21 to 23.

    Raises:
        ValueError: two sizes.
    """
    if left.shape != right.shape:
        raise ValueError(f"expected two images of one size, got {left.shape} and {right.shape}")
    first, second = _grey(left), _grey(right)
    limits = disparity_limits(first, second)
    if limits is None:
        return np.zeros(first.shape, dtype=np.float32)
    found, agreed = _searched(first, second, *limits)
    known = agreed & well_exposed(left)
    return np.where(known, _refined(first, second, found, agreed), np.float32(0))


def disparity_limits(left: GreyImage, right: GreyImage) -> tuple[int, int] | None:
    """Lowest and highest disparity in px that a coarse matching of two grey pictures (H, W) shows.

    The span is a multiple of 16, as the matcher wants it. None when little matches, or the pictures
    are no wider than the matcher's window.
    """
    if left.shape[1] <= _BLOCK:
        return None
    shrink = max(1.0, left.shape[1] / _COARSE_WIDTH)
    size = (max(round(left.shape[1] / shrink), 1), max(round(left.shape[0] / shrink), 1))
    small = [
        np.asarray(cv2.resize(eye, size, interpolation=cv2.INTER_AREA), np.uint8) for eye in (left, right)
    ]
    found, agreed = _matched_both_ways(small[0], small[1], 0, _whole_steps(_WIDEST * size[0]))
    if agreed.mean() < _FEWEST:
        return None
    low, high = np.percentile(found[agreed] * shrink, _RANGE_PERCENTILES)
    margin = max(_MARGIN_PIXELS, _MARGIN_SHARE * (high - low))
    lowest = max(math.floor(low - margin), 0)
    return lowest, lowest + _whole_steps(high + margin - lowest)


def feature_shifts(left: ByteImage, right: ByteImage) -> NDArray[np.float64]:
    """Shifts (M, 2) in px, left minus right, of what can be recognised in both RGB pictures; the second
    column is 0 in a rectified pair."""
    here, there = feature_matches(left, right)
    return np.asarray(here - there)


def feature_matches(left: ByteImage, right: ByteImage) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places (M, 2) in px of what can be recognised in both RGB pictures, in the left and in the right one.

    SIFT features (Lowe 2004) that pass the ratio test.
    """
    shrink = max(1.0, left.shape[1] / _FEATURE_WIDTH)
    sift = cv2.SIFT.create(_FEATURES)
    points, features = [], []
    for eye in (left, right):
        size = (round(eye.shape[1] / shrink), round(eye.shape[0] / shrink))
        keypoints, described = sift.detectAndCompute(
            np.asarray(cv2.resize(_grey(eye), size, interpolation=cv2.INTER_AREA)), None
        )
        points.append(np.array([keypoint.pt for keypoint in keypoints]).reshape(-1, 2) * shrink)
        features.append(described)
    if min(len(found) for found in points) < 2:
        return np.zeros((0, 2)), np.zeros((0, 2))
    nearest = cv2.BFMatcher(cv2.NORM_L2).knnMatch(features[0], features[1], k=2)
    clear = [best for best, second in nearest if best.distance < _RATIO * second.distance]
    here, there = [match.queryIdx for match in clear], [match.trainIdx for match in clear]
    return points[0][here], points[1][there]


def _grey(image: ByteImage) -> GreyImage:
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), dtype=np.uint8)


def _whole_steps(span: float) -> int:
    return max(math.ceil(span / _STEPS), 1) * _STEPS


def _searched(left: GreyImage, right: GreyImage, lowest: int, highest: int) -> tuple[Float32Image, BoolImage]:
    """Disparity (H, W) in px of the left picture, and where it holds."""
    shrink = math.ceil(highest / FARTHEST)
    if shrink == 1:
        return _without_speckles(*_matched_both_ways(left, right, lowest, highest))
    height, width = left.shape
    size = (math.ceil(width / shrink), max(math.ceil(height / shrink), 1))
    small = [
        np.asarray(cv2.resize(eye, size, interpolation=cv2.INTER_AREA), np.uint8) for eye in (left, right)
    ]
    low = lowest // shrink
    found, agreed = _searched(small[0], small[1], low, low + _whole_steps(highest / shrink - low))
    whole = (width, height)
    return (
        np.asarray(cv2.resize(found, whole, interpolation=cv2.INTER_NEAREST_EXACT) * (width / size[0])),
        cv2.resize(agreed.astype(np.uint8), whole, interpolation=cv2.INTER_NEAREST_EXACT) > 0,
    )


def _matched_both_ways(
    left: GreyImage, right: GreyImage, lowest: int, highest: int
) -> tuple[Float32Image, BoolImage]:
    """Disparity (H, W) in px of the left picture, and where matching from the right agrees."""
    found = _matched(left, right, lowest, highest)
    mirrored = [np.ascontiguousarray(eye[:, ::-1]) for eye in (right, left)]
    back = _matched(mirrored[0], mirrored[1], lowest, highest)[:, ::-1]
    columns = np.rint(np.arange(left.shape[1]) - found).astype(np.int64)
    theirs = np.take_along_axis(back, np.clip(columns, 0, left.shape[1] - 1), axis=1)
    agreed = (np.abs(theirs - found) <= _AGREEMENT) & (found >= max(lowest, 1)) & (columns >= 0)
    return found, np.asarray(agreed)


def _matched(left: GreyImage, right: GreyImage, lowest: int, highest: int) -> Float32Image:
    """OpenCV's disparity (H, W) in px, below `lowest` where there is none.

    The matcher skips the columns that the largest disparity could shift out of the picture, also
    where the true one does not: a border keeps them.
    """
    matcher = cv2.StereoSGBM.create(
        minDisparity=lowest,
        numDisparities=highest - lowest,
        blockSize=_BLOCK,
        P1=_SMALL,
        P2=_LARGE,
        disp12MaxDiff=-1,  # Checked with a matching of its own.
        preFilterCap=_GRADIENT_CAP,
        uniquenessRatio=_UNIQUENESS,
        mode=cv2.StereoSGBM_MODE_HH,
    )
    padded = [cv2.copyMakeBorder(eye, 0, 0, highest, 0, cv2.BORDER_REPLICATE) for eye in (left, right)]
    fixed = np.asarray(matcher.compute(padded[0], padded[1]))
    return fixed[:, highest:].astype(np.float32) / np.float32(_STEPS)


def _without_speckles(found: Float32Image, agreed: BoolImage) -> tuple[Float32Image, BoolImage]:
    fixed = np.where(agreed, np.rint(found * _STEPS), 0).astype(np.int16)
    cv2.filterSpeckles(fixed, 0, round(_SPECKLE_SHARE * fixed.size), _STEPS)
    return found, agreed & (fixed > 0)


def _refined(left: GreyImage, right: GreyImage, found: Float32Image, known: BoolImage) -> Float32Image:
    """One step towards equal windows: d + dd with right(x - d - dd) = right(x - d) - gradient dd."""
    ours, theirs = _locally_normalised(left), _locally_normalised(right)
    grid = np.indices(found.shape).astype(np.float32)
    warped = cv2.remap(theirs, grid[1] - found, grid[0], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    gradient = (cv2.Scharr(warped, cv2.CV_32F, 1, 0) + cv2.Scharr(ours, cv2.CV_32F, 1, 0)) / 64
    difference = ours - warped
    weight = known / (1 + (2 * difference) ** 2)
    against = cv2.GaussianBlur(weight * gradient * difference, (0, 0), _WINDOW)
    stiffness = cv2.GaussianBlur(weight * gradient * gradient, (0, 0), _WINDOW)
    step = np.clip(-against / (stiffness + _FLAT), -_LARGEST_STEP, _LARGEST_STEP)
    return np.asarray(found + step, dtype=np.float32)


def _locally_normalised(grey: GreyImage) -> Float32Image:
    """Grey without its local mean and in local deviations: the eyes differ in light and vignetting."""
    level = grey.astype(np.float32)
    detail = level - cv2.GaussianBlur(level, (0, 0), _WINDOW)
    deviation = np.sqrt(cv2.GaussianBlur(detail * detail, (0, 0), 2 * _WINDOW) + 1)
    return np.asarray(detail / deviation, dtype=np.float32)
