"""Noise in numbers: how many times larger it is than in the original, where that is flat.

Pixels whose alpha is 0 count in no measure.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
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
SCALES: Final = (1, 2, 4, 8, 16)
"""Pixels of the sides of blocks whose mean colours are compared."""
BLOCKS: Final = 16
"""Along either side of an image, at least, where they are of more than one pixel."""
BEYOND_ROUNDING: Final = 0.02
"""Of full scale: from here on, the mean response times the scale is four times that of R - G to rounding to
8 bits, and gains of 1/2 to 3 are within some tenth."""
NoiseCut = Literal["unclipped", "by rank", "by level"]
"""What noise is without: what has clipped, and the largest quarter of the responses, as many values whatever
ties there are; as before 0.6.0, that quarter alone, and colours pixel by pixel; or, as before 0.4.0, what is
above the third quartile, where rounding decides between ties."""


def noise_gain(
    image: AnyImage,
    original: AnyImage,
    *,
    tissue_mask: BoolImage | None = None,
    cut: NoiseCut = "unclipped",
) -> float:
    """How many times larger the noise of `image` is where `original` is flat; 1 = the same.

    Noise is the mean size of the response to the kernel that is blind to planes (Immerkaer, Computer Vision
    and Image Understanding 64(2), 1996), over all channels, without the largest quarter, which edges make:
    of n values the largest n // 4, by rank. (Their median would step by whole grey levels.) Flat is the half
    of the tissue with the smallest gradient of the blurred green of `original`, without black and highlights.
    Responses to values that are clipped, 0 or full scale, in either image are left out of both, so that a
    method that clips is not the quieter for it. NaN: nothing flat, all clipped, or an original without noise.

    Args:
        tissue_mask: (H, W), True = keep.
        cut: "by rank" and "by level" reproduce values of before 0.6.0 and 0.4.0.

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
    keep = kept(original, tissue_mask) & kept(image)
    return _gain(before, after, _flat(before, keep), _whole(before, after, keep, cut), cut)


def chroma_noise_gain(
    image: AnyImage,
    original: AnyImage,
    *,
    tissue_mask: BoolImage | None = None,
    cut: NoiseCut = "unclipped",
) -> float:
    """How many times larger the noise of the colours of `image` is where `original` is flat; 1 = the same.

    As `noise_gain`, of R - G and B - G in place of the channels, and of their means over blocks of 1, 2, 4, 8
    or 16 pixels a side: the smallest at which the noise of `original` is well beyond the rounding to 8 bits,
    else where it is most so. Codecs leave little of it at finer scales. Colours that a method makes out of
    noise of brightness count, too. NaN: also of grey images.

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
    keep = kept(original, tissue_mask) & kept(image)
    whole = _whole(before, after, keep, cut)
    was, is_now = (colors[..., ::2] - colors[..., 1:2] for colors in (before, after))
    scales = SCALES if cut == "unclipped" else SCALES[:1]
    return _gain(was, is_now, _flat(before, keep), whole[..., ::2] & whole[..., 1:2], cut, scales)


def _flat(colors: Float32Image, counted: BoolImage) -> BoolImage:
    """(H, W) of what counts, the half with the smallest gradient."""
    keep = counted & (value(colors) > np.float32(2 * BLACK)) & (green(colors) < np.float32(SATURATED))
    smooth = cv2.GaussianBlur(green(colors), (0, 0), FLAT_SIGMA)
    slope = np.hypot(cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1))
    return np.asarray(keep & (slope <= np.median(slope[keep]))) if keep.any() else keep


def _whole(before: Float32Image, after: Float32Image, keep: BoolImage, cut: NoiseCut) -> BoolImage:
    """Of the shape of either, True where values count and neither is clipped; all, of cuts of before."""
    if cut not in get_args(NoiseCut):
        raise ImageError(f"expected cut to be {' or '.join(map(repr, get_args(NoiseCut)))}, got {cut!r}")
    if cut != "unclipped":
        return np.ones(before.shape, bool)
    unclipped = (before > 0) & (before < 1) & (after > 0) & (after < 1)
    return np.asarray(unclipped & (keep if before.ndim == 2 else keep[..., None]))


def _gain(
    was: Float32Image,
    is_now: Float32Image,
    flat: BoolImage,
    whole: BoolImage,
    cut: NoiseCut,
    scales: Sequence[int] = SCALES[:1],
) -> float:
    """At the smallest of these scales at which what was is beyond rounding, else where it is most so."""
    found: dict[int, tuple[float, float]] = {}
    for scale in scales:
        if scale == 1 or BLOCKS * scale <= min(flat.shape):
            where = _counted(flat, whole, scale)
            before, after = (_noise(_responses(colors, scale)[where], cut) for colors in (was, is_now))
            if math.isfinite(before):
                found[scale] = before, after
    beside = {scale: scale * before for scale, (before, _) in found.items()}
    best = max(beside, key=lambda scale: min(beside[scale], BEYOND_ROUNDING), default=None)
    if best is None:
        return math.nan
    before, after = found[best]
    return after / before if before > (0 if cut == "by level" else NOISELESS) else math.nan


def _counted(flat: BoolImage, whole: BoolImage, scale: int) -> BoolImage:
    """Of the responses of blocks, those in flat tissue to whole ones."""
    beside = cv2.erode((_blocks(whole, scale) == 1).astype(np.uint8), np.ones(NOISE_KERNEL.shape)) > 0
    counts = _blocks(flat, scale) >= 0.5
    return np.asarray(beside & (counts if whole.ndim == 2 else counts[..., None]))


def _responses(colors: Float32Image, scale: int) -> Float32Image:
    """Their sizes, of blocks' means."""
    blocks = _blocks(colors, scale)
    return np.abs(cv2.filter2D(blocks, cv2.CV_32F, NOISE_KERNEL, borderType=cv2.BORDER_REFLECT))


def _blocks(values: Float32Image | BoolImage, scale: int) -> Float32Image:
    """Means over blocks of `scale` pixels a side; what is left at the right and the bottom is dropped."""
    height, width = (side // scale for side in values.shape[:2])
    cut = values[: height * scale, : width * scale].astype(np.float32)
    return cut if scale == 1 else np.asarray(cv2.resize(cut, (width, height), interpolation=cv2.INTER_AREA))


def _noise(responses: Float32Image, cut: NoiseCut) -> float:
    if not responses.size:
        return math.nan
    if cut == "by level":
        return float(responses[responses <= np.quantile(responses, 0.75)].mean(dtype=np.float64))
    count = responses.size - responses.size // 4
    return float(np.partition(responses, count - 1)[:count].mean(dtype=np.float64))
