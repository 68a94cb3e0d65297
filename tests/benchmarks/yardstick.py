"""The yardstick of the speed benchmark and a second oracle: Eqs 1-12 in plain float32 numpy and OpenCV.

One stage after another over whole images, as one writes it at first.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from enhance import brightness, saturation
from enhance.brightness import BLACK
from enhance.detail import FLOOR, exponent
from enhance.guided_filter import shrunk_radius
from enhance.image import AnyImage, Float32Image, read_picture
from enhance.params import DEFAULTS, EnhanceParams


def enhance_plainly(image: AnyImage, params: EnhanceParams = DEFAULTS) -> AnyImage:
    """What `enhance` does to an RGB image with its own statistics."""
    picture = read_picture(image)
    colors = picture.colors
    value = brightness.value(colors)
    color = saturation.saturation(colors, value)
    low = shrink(value, params.subsample)
    keep = np.ones(value.shape, dtype=bool)
    level = brightness.level(brightness.value_histogram(value, keep))
    z = brightness.z_from_level(level) if params.z is None else params.z
    brightened = brightness.brighten(value, z)
    details = []
    for radius in params.radii:
        model = coefficients(low, shrunk_radius(radius, params.subsample), params.eps)
        filtered = apply(value, model, params.subsample)
        sigma = 255 * float(filtered.std(dtype=np.float64))
        p = params.p if isinstance(params.p, float) else exponent(sigma, params.p_form)
        details.append(detailed(brightened, surround_ratio(value, filtered, p)))
    enhanced = mean_over_scales(details)
    mean = float(color.chroma.mean(dtype=np.float64))
    enhanced_colors = saturation.recolor(
        colors, value, color, enhanced, saturation.stretch(color, mean, params.d_factor)
    )
    if params.keep_black:
        enhanced_colors = fade_black(colors, enhanced_colors, value)
    return picture.with_colors(enhanced_colors)


def surround_ratio(value: Float32Image, filtered: Float32Image, p: float) -> Float32Image:
    """E of Eq 7, ((Q + e) / (V + e))^P with e = 1/255; below 1 where a pixel is brighter than around it.

    The ratio is within [1/256, 256], so E is finite for all P.
    """
    e = np.float32(FLOOR)
    ratio = (filtered + e) / (value + e)
    return np.sqrt(ratio) if p == 0.5 else ratio ** np.float32(p)


def detailed(brightened: Float32Image, ratio: Float32Image) -> Float32Image:
    """v of Eq 8, Vn^E, in [0, 1]; 0 where it underflows."""
    return np.asarray(brightened**ratio, dtype=np.float32)


def mean_over_scales(details: Iterable[Float32Image]) -> Float32Image:
    """V* of Eq 10, scales weighted equally."""
    scales = list(details)
    return np.asarray(sum(scales[1:], scales[0]) / np.float32(len(scales)), dtype=np.float32)


def fade_black(colors: Float32Image, enhanced: Float32Image, value: Float32Image) -> Float32Image:
    """`keep_black`: below V = 24/255 the enhanced colours fade back to the original ones, `colors`.

    The weight is a smoothstep of the original V, 0 at V = 0: exact black stays exact black, there is no kink,
    and Eq 1, which never darkens, still rises with V. At z = 0 the steepest step of two neighbouring 8-bit
    levels shrinks from 32 levels to 7, so that noise in the dark is not blown up. Where enhancement changes
    nothing, neither does the fade.
    """
    t = np.minimum(value * np.float32(1 / BLACK), np.float32(1))
    weight = np.asarray(t * t * (3 - 2 * t), dtype=np.float32)
    if colors.ndim == 3:
        weight = weight[..., None]
    return np.asarray(weight * enhanced + (1 - weight) * colors, dtype=np.float32)


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
