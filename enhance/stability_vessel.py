"""Stiff and extreme cases of the preset `vessel`: colours of which it could make too much."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from enhance.pipeline import measure
from enhance.stability_row import Row
from enhance.vessel import VESSEL, enhance_vessels


def hues(image: NDArray[np.uint8]) -> Iterator[Row]:
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


def _apart(image: NDArray[np.float64]) -> float:
    """How differently the channels of a pixel are darkened, at most."""
    pixels = image.astype(np.float32)
    whole, left = (enhance_vessels(pixels, replace(VESSEL, strength=k)).image for k in (0.0, VESSEL.strength))
    shares = (left / np.maximum(whole, np.float32(1e-6)))[(whole > 0.02).all(axis=2)]
    return float(np.ptp(shares, axis=1).max())
