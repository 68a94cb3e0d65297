"""Structural dissimilarity over the tissue alone: windows weigh only supervised pixels (masked SSIM)."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

SIGMA, WINDOW = 1.5, 11
C1, C2 = np.float32(0.01**2), np.float32(0.03**2)
ZERO, ONE, TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)
FAINT = np.float32(1e-3)
"""Of a window, the least share that must be supervised."""
# Planes of the slopes of the loss by the window's mean, mean square and mean product.
BY_MEAN, BY_SQUARE, BY_PRODUCT = range(3)


def add_dissimilarity(
    picture: NDArray[np.float32],
    image: NDArray[np.float32],
    mask: NDArray[np.float32],
    weight: float,
    extra: NDArray[np.float32],
) -> float:
    """`weight` times the mean of 1 - SSIM over supervised pixels and channels; the gradient goes to `extra`.

    SSIM is that of Wang et al. 2004 (Eq 13), Gaussian windows of sigma 1.5; a window's means are taken
    over its supervised pixels alone, so that nothing outside the mask counts.

    Args:
        picture: (3, H, W) rendered.
        image: (3, H, W) in [0, 1].
        mask: (H, W) 1 = supervised.
        extra: (3 or more, H, W), gradient by the picture, added to its first three.
    """
    count = float(mask.sum())
    if count == 0:
        return 0.0
    share = _window(mask)
    scale = np.float32(weight / (3 * count))
    total = 0.0
    for channel in range(3):
        x, y = picture[channel] * mask, image[channel] * mask
        windows = np.stack([_window(plane) for plane in (x, y, x * x, y * y, x * y)])
        slopes = np.empty((3, *mask.shape), np.float32)
        sums = np.empty(len(mask))
        _slopes(windows, share, mask, scale, slopes, sums)
        total += float(sums.sum())
        by_mean, by_square, by_product = (_window(plane) for plane in slopes)
        extra[channel] += mask * (by_mean + TWO * x * by_square + y * by_product)
    return weight * (1.0 - total / (3 * count))


def _window(plane: NDArray[np.float32]) -> NDArray[np.float32]:
    """Gaussian window sums; nothing lies beyond the border. Symmetric, so it is its own adjoint."""
    blurred = cv2.GaussianBlur(plane, (WINDOW, WINDOW), SIGMA, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(blurred, dtype=np.float32)


@njit(parallel=True, cache=True, error_model="numpy")
def _slopes(
    windows: NDArray[np.float32],  # (5, H, W) sums of x, y, x^2, y^2 and x y
    share: NDArray[np.float32],
    mask: NDArray[np.float32],
    scale: np.float32,
    slopes: NDArray[np.float32],  # (3, H, W), out: of the loss, by the window sums
    sums: NDArray[np.float64],  # (H,), out: SSIM over the supervised pixels
) -> None:
    for row in prange(mask.shape[0]):
        total = 0.0
        for column in range(mask.shape[1]):
            part = share[row, column]
            counts = mask[row, column] > ZERO and part > FAINT
            unit = ONE / part if counts else ZERO
            x, y = windows[0, row, column] * unit, windows[1, row, column] * unit
            variance_x = windows[2, row, column] * unit - x * x
            variance_y = windows[3, row, column] * unit - y * y
            covariance = windows[4, row, column] * unit - x * y
            a1, a2 = TWO * x * y + C1, TWO * covariance + C2
            b1, b2 = x * x + y * y + C1, variance_x + variance_y + C2
            similarity = a1 * a2 / (b1 * b2)
            by_x = TWO * y * (a2 - a1) / (b1 * b2) - TWO * x * similarity * (ONE / b1 - ONE / b2)
            gain = -scale * unit
            slopes[BY_MEAN, row, column] = gain * by_x
            slopes[BY_SQUARE, row, column] = -gain * similarity / b2
            slopes[BY_PRODUCT, row, column] = gain * TWO * a1 / (b1 * b2)
            total += np.float64(similarity) if counts else (1.0 if mask[row, column] > ZERO else 0.0)
        sums[row] = total
