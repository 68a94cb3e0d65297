"""Self-guided fast guided filter (Eqs 3-6; He and Sun, "Fast Guided Filter", arXiv 1505.00996, 2015)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from enhance.image import Float32Image


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Window means of the linear model's a and b (Eq 6), on the subsampled grid."""

    a: Float32Image
    """In [0, 1]: near 1 at edges, which stay; near 0 on flat parts, which are smoothed."""
    b: Float32Image
    """In [0, 1]."""


def shrink(value: Float32Image, subsample: int) -> Float32Image:
    """Means of `subsample` x `subsample` blocks, (ceil(H/s), ceil(W/s)); the last row and column repeat."""
    if subsample == 1:
        return value
    rows, columns = value.shape
    padded = np.pad(value, ((0, -rows % subsample), (0, -columns % subsample)), mode="edge")
    blocks = padded.reshape(padded.shape[0] // subsample, subsample, -1, subsample)
    return np.asarray(blocks.mean(axis=(1, 3), dtype=np.float32))


def shrunk_radius(radius: int, subsample: int) -> int:
    """r / s as a whole number of low-resolution pixels, halves up, at least 1."""
    return max(1, (2 * radius + subsample) // (2 * subsample))


def coefficients(low: Float32Image, radius: int, eps: float) -> Coefficients:
    """Mean a and b of every window (Eqs 4 and 5, averaged for Eq 6); guide and input are the same.

    Args:
        low: subsampled V, (h, w) in [0, 1].
        radius: window radius in pixels of `low`; it may exceed the image.
        eps: regularisation, a variance on [0, 1].
    """
    mean = window_mean(low, radius)
    # Rounding can leave a flat window's variance slightly negative.
    variance: Float32Image = np.maximum(window_mean(low * low, radius) - mean * mean, 0)
    a = variance / (variance + np.float32(eps))
    b = (np.float32(1) - a) * mean
    return Coefficients(a=window_mean(a, radius), b=window_mean(b, radius))


def apply(value: Float32Image, coefficients: Coefficients, subsample: int) -> Float32Image:
    """Q of Eq 6 at full resolution, (H, W) in [0, 1]; a and b come up bilinearly."""
    return _enlarge(coefficients.a, value, subsample) * value + _enlarge(coefficients.b, value, subsample)


def window_mean(image: Float32Image, radius: int) -> Float32Image:
    """Mean over the part of each (2 r + 1)^2 window that lies inside the image."""
    rows, columns = (_window_sizes(size, radius) for size in image.shape)
    # A radius of size - 1 sees all of a side, and box sums are accumulated in double precision.
    across, down = (2 * min(radius, size - 1) + 1 for size in reversed(image.shape))
    total = cv2.boxFilter(image, cv2.CV_32F, (across, down), normalize=False, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(total, dtype=np.float32) / np.outer(rows, columns)


def _window_sizes(size: int, radius: int) -> Float32Image:
    """(size,) how many pixels of a side each window covers."""
    index = np.arange(size)
    inside = np.minimum(index + radius, size - 1) - np.maximum(index - radius, 0) + 1
    return inside.astype(np.float32)


def _enlarge(low: Float32Image, value: Float32Image, subsample: int) -> Float32Image:
    if subsample == 1:
        return low
    size = low.shape[1] * subsample, low.shape[0] * subsample
    large = cv2.resize(low, size, interpolation=cv2.INTER_LINEAR)
    rows, columns = value.shape
    return np.asarray(large[:rows, :columns], dtype=np.float32)
