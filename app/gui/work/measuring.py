"""Visibility of what is on screen in numbers, and how its grey levels are spread: off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.enhancement.frame_enhancer import Pictures
from app.enhancement.measures import Measures, Original, VesselsSeen
from app.enhancement.methods import EnhancementSettings
from enhance import EnhanceParams, Statistics
from enhance.brightness import brighten, z_from_level
from enhance.exposure import exposed, exposure
from enhance.saturation import Saturation, stretch
from renderer.clip import ByteImage

BINS = 64
POINTS = 65
"""Of a transfer curve."""
Shares = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Spread:
    """How V and S of a picture are spread: (BINS,) shares of its pixels, relative to the fullest bin."""

    value: Shares
    saturation: Shares


@dataclass(frozen=True, eq=False)
class Measured:
    """Of the frame and of the enhanced picture on screen."""

    pictures: Pictures
    before: Measures
    after: Measures
    original: Spread
    enhanced: Spread
    vessels: VesselsSeen | None = None


class Measurer:
    """Measures pictures; remembers what follows from the frame alone."""

    def __init__(self) -> None:
        self._known: tuple[Original, Spread] | None = None

    def measure(self, pictures: Pictures) -> Iterator[Measured]:
        """Raises ImageError."""
        enhanced = pictures.enhanced
        if enhanced is None:
            return
        if self._known is None or self._known[0].image is not pictures.original:
            self._known = Original.of(pictures.original), spread(pictures.original)
        frame, spread_before = self._known
        after = frame.measures(enhanced, pictures.milliseconds)
        vessels = frame.vessels_in(enhanced, after)
        yield Measured(pictures, frame.own, after, spread_before, spread(enhanced), vessels)


def spread(image: ByteImage) -> Spread:
    """Of an (H, W, 3) picture."""
    hsv = np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2HSV))
    return Spread(*(_shares(hsv[..., channel]) for channel in (2, 1)))


def _shares(levels: NDArray[Any]) -> Shares:
    counts = np.bincount(levels.ravel() // (256 // BINS), minlength=BINS).astype(np.float64)
    return np.asarray(counts / max(counts.max(), 1.0))


@dataclass(frozen=True, eq=False)
class Curves:
    """(POINTS,) V and S after the global stages, for V and S from 0 to 1."""

    given: NDArray[np.float64]
    value: NDArray[np.float64]
    saturation: NDArray[np.float64]


@lru_cache(maxsize=16)
def curves(look: EnhancementSettings, used: Statistics) -> Curves:
    """Eq 1 and Eqs 11-12 with the statistics in use; of `vessel` with its own part of them.

    Local detail, which depends on the neighbourhood, is no part of them.
    """
    given = np.linspace(0, 1, POINTS)
    if isinstance(look, EnhanceParams):
        stretched = _stretched(given, used.saturation_mean, look.k)
        return Curves(given, brighten(given, used.z), given + used.color * (stretched - given))
    stretched = _stretched(given, used.saturation_mean, look.d_factor)
    longer = exposed(given, exposure(used.bright_level, look.most_exposure))
    value = brighten(longer, 1 - (1 - z_from_level(used.level)) * look.lift) ** look.gamma
    return Curves(given, value, np.clip(stretched, given, np.minimum(look.most_color * given, 1)))


def _stretched(given: NDArray[np.float64], mean: float, d_factor: float) -> NDArray[np.float64]:
    single = given.astype(np.float32)[None]
    return np.asarray(stretch(Saturation(single, 1 - single), mean, d_factor)[0], dtype=np.float64)
