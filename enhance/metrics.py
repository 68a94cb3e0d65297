"""Visibility in numbers: DV/BV, vessel contrast, saturated share. None of them is detection or diagnosis."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.brightness import value
from enhance.image import AnyImage, BoolImage, ImageError, read_picture

RING_GAP = 2
RING_WIDTH = 5
SATURATED = 250 / 255


@dataclass(frozen=True)
class DvBv:
    """Detail variance, background variance (grey levels squared) and their ratio; NaN where undefined."""

    dv: float
    bv: float
    ratio: float


def dvbv_otsu(image: AnyImage) -> DvBv:
    """DV and BV as the paper's tables have them: an inferred definition, the paper prints none.

    Variance of the grey levels (BT.601, 8 bit) above, and at or below, the image's own Otsu threshold. It
    answers to brightness more than to vessels: darkening an image raises the ratio. Over several images, the
    tables' ratio is the mean of the ratios. NaN: an empty class, and the ratio where bv = 0.
    """
    grey = np.rint(_grey(image)).astype(np.uint8)
    threshold, _ = cv2.threshold(grey, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    above = grey > threshold
    return _ratio(_variance(grey[above]), _variance(grey[~above]))


def dvbv_local(image: AnyImage, original: AnyImage, *, threshold: float | None = None) -> DvBv:
    """DV and BV of the literature: mean 5x5 variance of grey over detail, and over background.

    Ramponi et al., Journal of Electronic Imaging 5(3), 1996. Detail is where the variance of `original`
    exceeds `threshold` (grey levels squared; None: its mean), so all methods share one mask. The border is
    reflected. NaN: an empty class, and the ratio where bv = 0.

    Raises:
        ImageError: images of different sizes.
    """
    before, after = _local_variance(_grey(original)), _local_variance(_grey(image))
    if before.shape != after.shape:
        raise ImageError(f"expected image and original of one size, got {after.shape} and {before.shape}")
    detail = before > (before.mean() if threshold is None else threshold)
    return _ratio(_mean(after[detail]), _mean(after[~detail]))


def vessel_contrast(image: AnyImage, vessel_mask: BoolImage) -> float:
    """Weber contrast (ring - vessel) / ring of mean green; positive where vessels are darker than around.

    The ring is what lies 3 to 7 pixels from the mask; the two pixels beside it, blurred edges, are left out.
    RGB images only by that order of colours: green is the middle channel; a grey image is its own green.
    NaN: no vessel, no ring or a black ring.

    Raises:
        ImageError: a mask of another size.
    """
    colors = read_picture(image).colors
    green = colors if colors.ndim == 2 else colors[..., 1]
    if vessel_mask.shape != green.shape:
        raise ImageError(f"expected a vessel_mask of shape {green.shape}, got {vessel_mask.shape}")
    vessel = vessel_mask != 0
    ring = _dilated(vessel, RING_GAP + RING_WIDTH) & ~_dilated(vessel, RING_GAP)
    around = _mean(green[ring])
    return (around - _mean(green[vessel])) / around if around > 0 else math.nan


def saturated_share(image: AnyImage) -> float:
    """Share of pixels, 0 to 1, whose largest channel is at 250 of 255 or above."""
    return float(np.mean(value(read_picture(image).colors) >= np.float32(SATURATED)))


def _grey(image: AnyImage) -> NDArray[np.float64]:
    colors = read_picture(image).colors.astype(np.float64) * 255
    return colors if colors.ndim == 2 else np.asarray(colors @ np.array([0.299, 0.587, 0.114]))


def _local_variance(grey: NDArray[np.float64]) -> NDArray[np.float64]:
    mean, square = (cv2.blur(x, (5, 5), borderType=cv2.BORDER_REFLECT) for x in (grey, grey * grey))
    return np.asarray(np.maximum(np.asarray(square) - np.asarray(mean) ** 2, 0.0))


def _dilated(mask: BoolImage, radius: int) -> BoolImage:
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    return np.asarray(cv2.dilate(mask.astype(np.uint8), disc)) > 0


def _ratio(dv: float, bv: float) -> DvBv:
    return DvBv(dv, bv, dv / bv if bv > 0 else math.nan)


def _variance(values: NDArray[np.uint8]) -> float:
    return float(values.var(dtype=np.float64)) if values.size else math.nan


def _mean(values: NDArray[np.floating]) -> float:
    return float(values.mean(dtype=np.float64)) if values.size else math.nan
