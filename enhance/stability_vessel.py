"""Stiff and extreme cases of the preset `vessel`: what it could make too much of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from enhance.pipeline import measure
from enhance.stability_row import Row
from enhance.vessel import VESSEL, enhance_vessels

MOST: Final = replace(VESSEL, strength=4.0, contrast=1.0, shading=0.0, radius=64)
"""What darkens most, beside a background in wide blocks."""
BESIDE: Final = 6
"""Pixels beside an edge that blocks of 2 x 2 pixels and the smoothing of colour reach."""


def extremes(image: NDArray[np.uint8]) -> Iterator[Row]:
    """Of colour, of metal, then of contrast; `image` (H, W, 3) is red tissue."""
    yield from _hues(image)
    yield from _metals()
    yield from _contrasts(image)


def _hues(image: NDArray[np.uint8]) -> Iterator[Row]:
    """Grey with noise of colour, of good exposure and hardly lit, gets no hue; red tissue is as it was."""
    hazard, grain = "hues of vessel", np.random.default_rng(12).normal(0, 2, image.shape)
    for light in (1.0, 0.15):
        grey = np.clip(light * image[..., 1:2] + grain, 0, 255).astype(np.float32) / 255
        for tint in ((1.0, 1.0, 1.0), (0.97, 1.0, 0.98), (0.6, 1.0, 0.9)):
            yield Row(hazard, f"grey, lit {light:g}, tint {tint}, apart", _apart(grey * tint), 1e-3, "of 1")
    own, reddened = (enhance_vessels(image, one).image for one in (VESSEL, replace(VESSEL, least_redness=0)))
    yield Row(hazard, "red tissue, bytes that differ", float(np.mean(own != reddened)), 0, "share")
    known, pixels = measure([image]), (image / 255).astype(np.float32)
    steps = [
        enhance_vessels(pixels, statistics=replace(known, redness=share * VESSEL.least_redness)).image
        for share in np.linspace(0.45, 1.05, 61).tolist()
    ]
    jump = 255 * float(np.abs(np.diff(np.stack(steps), axis=0)).max())
    yield Row(hazard, "redness that falls, largest step in 60", jump, 4)


def _metals() -> Iterator[Row]:
    """A line of metal in red tissue, faintly red by it, is left as it is, and one of blood is not; as images
    grow pale, it is darkened without a jump."""
    hazard, image = "metal of vessel", np.broadcast_to(np.array((0.9, 0.6, 0.5), np.float32), (64, 160, 3))
    image = image * np.linspace(0.9, 1.05, 64, dtype=np.float32)[:, None, None]
    image[:, 40:50] *= np.array((0.78, 0.53, 0.6), np.float32)
    image[:, 110:120] = np.array((0.36, 0.32, 0.31), np.float32)
    plain, own = (enhance_vessels(image, replace(VESSEL, strength=k)).image for k in (0.0, VESSEL.strength))
    taken = 1 - (own[:, :, 1] / plain[:, :, 1]).mean(axis=0, dtype=np.float64)
    yield Row(hazard, "metal, taken", float(taken[112:118].max()), 0.01, "of 1")
    yield Row(hazard, "blood, left", float(1 - taken[42:48].min()), 0.7, "of 1")
    known = measure([image])
    steps = [
        enhance_vessels(image, statistics=replace(known, redness=redness)).image
        for redness in np.linspace(0.17, 0.27, 41).tolist()
    ]
    jump = 255 * float(np.abs(np.diff(np.stack(steps), axis=0)).max())
    yield Row(hazard, "redness that falls, largest step in 40", jump, 4)


def _contrasts(image: NDArray[np.uint8]) -> Iterator[Row]:
    """Contrast in full: it darkens alone, of what stands by itself, and adds neither noise nor edges."""
    hazard, without = "contrast of vessel", replace(MOST, contrast=0.0)
    own, plain = (enhance_vessels(image, one).image.astype(float) for one in (MOST, without))
    yield Row(hazard, "brighter by contrast, most", float((own - plain).max()), 0)
    flat = np.broadcast_to(np.array((0.6, 0.35, 0.3), np.float32), (64, 320, 3))
    yield Row(hazard, "tissue of one colour, taken", float(np.abs(_taken(flat)).max()), 0, "of 1")
    uneven = flat.copy()
    uneven[:, :20] *= np.array((1.1, 1.4, 1.4), np.float32)
    uneven[:, 180:] *= np.array((0.8, 0.5, 0.5), np.float32)
    bright, _, dark = np.split(_taken(uneven), (20, 180), axis=1)
    beside = max(np.ptp(dark[:, BESIDE:], axis=(0, 1)).max(), np.abs(bright[:, :-BESIDE]).max())
    yield Row(hazard, "beside an edge, apart from what is far", float(beside), 1e-4, "of 1")
    grain = flat + np.random.default_rng(4).normal(0, 1 / 255, flat.shape).astype(np.float32)
    yield Row(hazard, "grain of one level about the median", float(_taken(grain).std()), 1e-3, "of 1")


def _taken(image: NDArray[np.float32]) -> NDArray[np.float64]:
    """Share of the light that contrast takes, which is 0 where it does nothing."""
    own, plain = (enhance_vessels(image, replace(MOST, contrast=k)).image for k in (1.0, 0.0))
    return 1 - own.astype(np.float64) / plain


def _apart(image: NDArray[np.float64]) -> float:
    """How differently the channels of a pixel are darkened, at most."""
    pixels = image.astype(np.float32)
    whole, left = (enhance_vessels(pixels, replace(VESSEL, strength=k)).image for k in (0.0, VESSEL.strength))
    shares = (left / np.maximum(whole, np.float32(1e-6)))[(whole > 0.02).all(axis=2)]
    return float(np.ptp(shares, axis=1).max())
