"""Visibility in numbers and what it costs: saturation, flicker. Neither detection nor diagnosis.

Pixels whose alpha is 0 count in no measure.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.brightness import BLACK, value
from enhance.image import AnyImage, BoolImage, Float32Image, ImageError, check_shape
from enhance.measured_pixels import check_sizes, green, kept, seen, unit
from enhance.strips import strips

RING_GAP: Final = 2
RING_WIDTH: Final = 5
FULL_SIDE: Final = 640
"""Pixels of an image's longer side from which on lengths in pixels stand as they are."""
LEAST_SCALE: Final = 1 / 3
"""Vessels of 1 to 4 pixels: of narrower ones nothing is left."""
SATURATED: Final = 250 / 255
ROUNDING: Final = 1e-8
"""Grey levels squared: variances below are what rounding leaves of none; one step of 16 bits makes 6e-7."""


@dataclass(frozen=True)
class DvBv:
    """Detail variance, background variance (grey levels squared) and their ratio; NaN where undefined.

    Example:
        >>> import numpy as np
        >>> from enhance import dvbv_otsu
        >>> found = dvbv_otsu(np.full((16, 16), 80, np.uint8))  # nothing above its threshold: no ratio
        >>> type(found).__name__, found.ratio
        ('DvBv', nan)
    """

    dv: float
    bv: float
    ratio: float


def dvbv_otsu(image: AnyImage, *, tissue_mask: BoolImage | None = None) -> DvBv:
    """DV and BV as in the paper's tables: an inferred definition, the paper gives none.

    Variance of the grey levels (BT.601, 8 bit) above, and at or below, the image's own Otsu threshold. It
    responds to brightness more than to vessels: darkening an image raises the ratio. Over several images, the
    tables' ratio is the mean of the ratios. NaN: an empty class, and the ratio where bv = 0.

    Args:
        image: as `enhance` takes it.
        tissue_mask: (H, W), True = keep: threshold and variances are of these pixels. Without it, a black
            surround is the class below.

    Raises:
        ImageError: an image that cannot be used, or a mask of another size.

    Example:
        >>> import numpy as np
        >>> from enhance import dvbv_otsu
        >>> dvbv_otsu(np.uint8([[10, 20, 200, 240]]))  # variances of 200, 240 and of 10, 20
        DvBv(dv=400.0, bv=25.0, ratio=16.0)
    """
    grey = _bytes(seen(image))[kept(image, tissue_mask)]
    if not grey.size:
        return DvBv(math.nan, math.nan, math.nan)
    threshold, _ = cv2.threshold(grey, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    above = grey > threshold
    return _ratio(_variance(grey[above]), _variance(grey[~above]))


def dvbv_local(
    image: AnyImage,
    original: AnyImage,
    *,
    threshold: float | None = None,
    tissue_mask: BoolImage | None = None,
) -> DvBv:
    """DV and BV of the literature: mean 5x5 variance of grey over detail, and over background.

    Ramponi et al., Journal of Electronic Imaging 5(3), 1996. Detail is where the variance of `original`
    exceeds `threshold` (grey levels squared; None: its mean), so all methods share one mask. The border is
    reflected. NaN: an empty class, and the ratio where bv = 0.

    Args:
        tissue_mask: (H, W), True = keep; only windows that lie within count, also for the mean.

    Raises:
        ImageError: images of different sizes, or a threshold that is negative or no number.

    Example:
        >>> import numpy as np
        >>> from enhance import dvbv_local, unsharp
        >>> image = np.random.default_rng(0).normal(120, 2, (64, 64, 3)).astype(np.uint8)
        >>> image[:, 30:34] = 80
        >>> bool(dvbv_local(unsharp(image), image).dv > dvbv_local(image, image).dv)
        True
    """
    if threshold is not None and not 0 <= threshold < math.inf:
        raise ImageError(f"expected a threshold of 0 or more, got {threshold}")
    before, after = _local_variance(seen(original)), _local_variance(seen(image))
    check_sizes(after, before)
    counted = _whole_windows(kept(original, tissue_mask) & kept(image))
    detail = before > (_mean(before[counted]) if threshold is None else threshold)
    return _ratio(_mean(after[detail & counted]), _mean(after[~detail & counted]))


def _whole_windows(mask: BoolImage) -> BoolImage:
    """Pixels whose 5x5 window lies within the mask; what is beyond the border counts as within."""
    inside = cv2.erode(mask.astype(np.uint8), np.ones((5, 5), np.uint8), borderValue=1)
    return np.asarray(inside > 0)


def line_scale(image: AnyImage) -> float:
    """What lengths in pixels are multiplied by to measure vessels of a small image as those of a larger one
    of the same scene: its longer side by 640, between a third and 1.

    Raises:
        ImageError: no image by its shape.

    Example:
        >>> import numpy as np
        >>> from enhance import line_scale
        >>> line_scale(np.zeros((240, 320, 3), np.uint8)), line_scale(np.zeros((1080, 1920), np.uint8))
        (0.5, 1.0)
    """
    check_shape(array := np.asarray(image))
    return float(min(1.0, max(LEAST_SCALE, max(array.shape[:2]) / FULL_SIDE)))


def scaled(length: float, scale: float, least: int = 1) -> int:
    """Whole pixels. Raises ImageError: such a scale makes no length."""
    if not 0 < scale < math.inf:
        raise ImageError(f"expected a scale above 0, got {scale}")
    return max(least, round(length * scale))


def vessel_contrast(
    image: AnyImage, vessel_mask: BoolImage, *, tissue_mask: BoolImage | None = None, scale: float = 1.0
) -> float:
    """Weber contrast (ring - vessel) / ring of mean green; positive where vessels are darker than around.

    The ring is what lies 3 to 7 pixels from the mask; the two pixels beside it, blurred edges, are left out.
    RGB images only by that order of colours: green is the middle channel; a grey image is its own green.
    To compare methods, keep one mask: a given truth, or `vessel_mask` of the original.
    NaN: no vessel, no ring or a black ring.

    Args:
        tissue_mask: (H, W), True = keep; the ring lies within.
        scale: of the ring's gap and width, as of `line_scale`.

    Raises:
        ImageError: a mask of another size.

    Example:
        >>> import numpy as np
        >>> from enhance import vessel_contrast
        >>> image = np.full((64, 64, 3), 200, np.uint8)
        >>> vessel = np.zeros((64, 64), bool)
        >>> vessel[:, 30:34] = True
        >>> image[vessel] = 150
        >>> round(vessel_contrast(image, vessel), 3)  # (200 - 150) / 200
        0.25
    """
    vessel, ring = _greens(image, vessel_mask, tissue_mask, scale)
    around = _mean(ring)
    return (around - _mean(vessel)) / around if around > 0 else math.nan


def vessel_cnr(
    image: AnyImage, vessel_mask: BoolImage, *, tissue_mask: BoolImage | None = None, scale: float = 1.0
) -> float:
    """Contrast to noise ratio (ring - vessel) / std(ring) of green, with the ring of `vessel_contrast`.

    The ring's deviation holds texture and uneven light besides noise. NaN: also where it is 0.

    Raises:
        ImageError: a mask of another size.

    Example:
        >>> import numpy as np
        >>> from enhance import vessel_cnr
        >>> image = np.full((64, 64, 3), 200, np.uint8)
        >>> vessel = np.zeros((64, 64), bool)
        >>> vessel[:, 30:34] = True
        >>> image[vessel] = 150
        >>> image[::2] += 10
        >>> round(vessel_cnr(image, vessel), 2)  # 50 by a deviation of 5
        10.0
    """
    vessel, ring = _greens(image, vessel_mask, tissue_mask, scale)
    spread = math.sqrt(_variance(ring))
    return (_mean(ring) - _mean(vessel)) / spread if spread > 0 else math.nan


def blackened_share(image: AnyImage, original: AnyImage, vessel_mask: BoolImage) -> float:
    """Share of vessel pixels, 0 to 1, that are near-black (V below 48 of 255) and were not. NaN: no vessel.

    Raises:
        ImageError: images or a mask of different sizes.

    Example:
        >>> import numpy as np
        >>> from enhance import blackened_share
        >>> original = np.full((8, 8, 3), 100, np.uint8)
        >>> image = original.copy()
        >>> image[:4] = 20
        >>> blackened_share(image, original, np.ones((8, 8), bool))
        0.5
    """
    before, after = seen(original), seen(image)
    check_sizes(after, before)
    vessel = _vessel(original, vessel_mask) & kept(image)
    dark, was_dark = (unit(value(pixels)[vessel]) < np.float32(2 * BLACK) for pixels in (after, before))
    return _mean(dark & ~was_dark)


def flicker(images: Iterable[AnyImage], originals: Iterable[AnyImage]) -> float:
    """Mean step of the mean luma between neighbouring frames, less that of the originals, in grey levels.

    0 or less: as steady as the original clip. NaN: fewer than two frames.

    Raises:
        ImageError: not as many images as originals.

    Example:
        >>> import numpy as np
        >>> from enhance import flicker
        >>> originals = [np.full((8, 8), level, np.uint8) for level in (100, 101, 100)]
        >>> images = [np.full((8, 8), level, np.uint8) for level in (150, 154, 150)]
        >>> round(flicker(images, originals), 3)  # steps of 4 in place of 1
        3.0
    """
    after, before = (
        [_mean(grey_levels(image)[kept(image)]) for image in clip] for clip in (images, originals)
    )
    if len(after) != len(before):
        raise ImageError(f"expected as many images as originals, got {len(after)} and {len(before)}")
    return _mean_step(after) - _mean_step(before)


def saturated_share(image: AnyImage, *, tissue_mask: BoolImage | None = None) -> float:
    """Share of pixels, 0 to 1, whose largest channel is at 250 of 255 or above. NaN: no pixel counts.

    Args:
        tissue_mask: (H, W), True = keep: the share is of these pixels.

    Raises:
        ImageError: an image that cannot be used, or a mask of another size.

    Example:
        >>> import numpy as np
        >>> from enhance import saturated_share
        >>> saturated_share(np.uint8([[0, 100, 250, 255]]))
        0.5
    """
    return _mean(unit(value(seen(image))[kept(image, tissue_mask)]) >= np.float32(SATURATED))


def _greens(
    image: AnyImage, vessel_mask: BoolImage, tissue_mask: BoolImage | None, scale: float
) -> tuple[Float32Image, Float32Image]:
    """Of the vessel's pixels, and of those around it."""
    pixels, vessel, ring = vessel_and_ring(image, vessel_mask, tissue_mask, scale)
    return unit(green(pixels)[vessel]), unit(green(pixels)[ring])


def vessel_and_ring(
    image: AnyImage, vessel_mask: BoolImage, tissue_mask: BoolImage | None, scale: float
) -> tuple[AnyImage, BoolImage, BoolImage]:
    """What is `seen`; and (H, W) the vessel and what lies around it, for comparing the two.

    Raises:
        ImageError: an image that cannot be used, or a mask of another size.
    """
    pixels, vessel = seen(image), _vessel(image, vessel_mask)
    gap, width = scaled(RING_GAP, scale), scaled(RING_WIDTH, scale, 2)
    ring = _dilated(vessel, gap + width) & ~_dilated(vessel, gap)
    return pixels, vessel, ring & kept(image, tissue_mask)


def _vessel(image: AnyImage, vessel_mask: BoolImage | None) -> BoolImage:
    """Without a mask, as OpenCV reads a file that is not there, all would be vessel. Raises ImageError."""
    if vessel_mask is None:
        raise ImageError("expected a vessel_mask of shape (H, W), got None")
    return kept(image, vessel_mask)


def _mean_step(means: list[float]) -> float:
    steps = [abs(after - before) for before, after in pairwise(means)]
    return float(np.mean(steps)) if steps else math.nan


def grey_levels(image: AnyImage) -> NDArray[np.float64]:
    """Grey by BT.601, (H, W), 0 to 255, not rounded; 0 where nothing is visible."""
    return _grey(seen(image))


def _grey(pixels: AnyImage) -> NDArray[np.float64]:
    colors = unit(pixels).astype(np.float64) * 255
    return colors if colors.ndim == 2 else np.asarray(colors @ np.array([0.299, 0.587, 0.114]))


def _bytes(pixels: AnyImage) -> NDArray[np.uint8]:
    """(H, W) grey, rounded."""
    whole = np.empty(pixels.shape[:2], np.uint8)
    for strip in strips(whole.shape):
        whole[strip.own] = np.rint(_grey(pixels[strip.own]))
    return whole


def _local_variance(pixels: AnyImage) -> NDArray[np.float64]:
    """(H, W) of grey in 5x5 windows."""
    whole = np.empty(pixels.shape[:2])
    for strip in strips(whole.shape, beside=2):
        grey = _grey(pixels[strip.rows])
        mean, square = (cv2.blur(x, (5, 5), borderType=cv2.BORDER_REFLECT) for x in (grey, grey * grey))
        variance = (np.asarray(square) - np.asarray(mean) ** 2)[strip.inner]
        whole[strip.own] = np.where(variance < ROUNDING, 0.0, variance)
    return whole


def _dilated(mask: BoolImage, radius: int) -> BoolImage:
    return np.asarray(cv2.dilate(mask.astype(np.uint8), disc(radius))) > 0


def disc(radius: int) -> NDArray[np.uint8]:
    """For morphology, (2 radius + 1, 2 radius + 1)."""
    shape = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    return np.asarray(shape, np.uint8)


def _ratio(dv: float, bv: float) -> DvBv:
    return DvBv(dv, bv, dv / bv if bv > 0 else math.nan)


def _variance(values: NDArray[Any]) -> float:
    return float(values.var(dtype=np.float64)) if values.size else math.nan


def _mean(values: NDArray[Any]) -> float:
    return float(values.mean(dtype=np.float64)) if values.size else math.nan
