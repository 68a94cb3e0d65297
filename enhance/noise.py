"""Noise in numbers: how many times larger it is than in the original, where that is flat.

Pixels whose alpha is 0 count in no measure.
"""

from __future__ import annotations

import math
from typing import Final, Literal, get_args

import cv2
import numpy as np

from enhance.brightness import BLACK, value
from enhance.image import AnyImage, BoolImage, Float32Image, ImageError
from enhance.metrics import SATURATED, check_sizes, colors_of, green, kept

FLAT_SIGMA: Final = 2.0
NOISE_KERNEL: Final = np.outer((1, -2, 1), (1, -2, 1)).astype(np.float32)
NOISELESS: Final = 1e-6
"""Of full scale: mean responses below are what the rounding of floats leaves of none; that of 16 bits makes
1e-5."""
NoiseCut = Literal["by rank", "by level"]
"""How noise leaves out its largest quarter: as many values, whatever ties there are; or what is above their
third quartile, where rounding decides between ties, as before 0.4.0."""


def noise_gain(
    image: AnyImage,
    original: AnyImage,
    *,
    tissue_mask: BoolImage | None = None,
    cut: NoiseCut = "by rank",
) -> float:
    """How many times larger the noise of `image` is where `original` is flat; 1 = the same.

    Noise is the mean size of the response to the kernel that is blind to planes (Immerkaer, Computer Vision
    and Image Understanding 64(2), 1996), over all channels, without the largest quarter, which edges make:
    of n values the largest n // 4, by rank. (Their median would step by whole grey levels.) Flat is the half
    of the tissue with the smallest gradient of the blurred green of `original`, without black and highlights.
    NaN: nothing flat, or an original without noise.

    Args:
        tissue_mask: (H, W), True = keep.
        cut: "by level" reproduces values of before 0.4.0.

    Raises:
        ImageError: images or a mask of different sizes, or a cut that there is none of.

    Example:
        >>> import numpy as np
        >>> from enhance import noise_gain
        >>> noise = np.random.default_rng(0).normal(0, 0.01, (64, 64))
        >>> round(noise_gain(0.5 + 2 * noise, 0.5 + noise), 2)
        2.0
    """
    before, after = colors_of(original), colors_of(image)
    check_sizes(after, before)
    return _gain(before, after, _flat(before, kept(original, tissue_mask) & kept(image)), cut)


def chroma_noise_gain(
    image: AnyImage,
    original: AnyImage,
    *,
    tissue_mask: BoolImage | None = None,
    cut: NoiseCut = "by rank",
) -> float:
    """How many times larger the noise of the colours of `image` is where `original` is flat; 1 = the same.

    As `noise_gain`, of R - G and B - G in place of the channels. NaN: also of grey images.

    Raises:
        ImageError: images or a mask of different sizes, or a cut that there is none of.

    Example:
        >>> import numpy as np
        >>> from enhance import chroma_noise_gain
        >>> noise = np.random.default_rng(0).normal(0, 0.01, (64, 64, 3))
        >>> round(chroma_noise_gain(0.5 + 2 * noise, 0.5 + noise), 2)
        2.0
    """
    before, after = colors_of(original), colors_of(image)
    check_sizes(after, before)
    if before.ndim == 2:
        return math.nan
    flat = _flat(before, kept(original, tissue_mask) & kept(image))
    was, is_now = (colors[..., ::2] - colors[..., 1:2] for colors in (before, after))
    return _gain(was, is_now, flat, cut)


def _flat(colors: Float32Image, counted: BoolImage) -> BoolImage:
    """(H, W) of what counts, the half with the smallest gradient."""
    keep = counted & (value(colors) > np.float32(2 * BLACK)) & (green(colors) < np.float32(SATURATED))
    smooth = cv2.GaussianBlur(green(colors), (0, 0), FLAT_SIGMA)
    slope = np.hypot(cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1))
    return np.asarray(keep & (slope <= np.median(slope[keep]))) if keep.any() else keep


def _gain(before: Float32Image, after: Float32Image, where: BoolImage, cut: NoiseCut) -> float:
    if cut not in get_args(NoiseCut):
        raise ImageError(f"expected cut to be 'by rank' or 'by level', got {cut!r}")
    was, is_now = (_noise(colors, where, cut) for colors in (before, after))
    return is_now / was if was > (NOISELESS if cut == "by rank" else 0) else math.nan


def _noise(colors: Float32Image, where: BoolImage, cut: NoiseCut) -> float:
    filtered = cv2.filter2D(colors, cv2.CV_32F, NOISE_KERNEL, borderType=cv2.BORDER_REFLECT)
    response = np.abs(filtered)[where].ravel()
    if not response.size:
        return math.nan
    if cut == "by level":
        return float(response[response <= np.quantile(response, 0.75)].mean(dtype=np.float64))
    count = response.size - response.size // 4
    return float(np.partition(response, count - 1)[:count].mean(dtype=np.float64))
