"""Depth that is guessed instead of measured: one free scale for the whole clip, whose median is 1."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import BoolImage, Clip, ClipError, Frame
from renderer.depth.averaging import Float32Image, averaged
from renderer.depth.exposure import well_exposed
from renderer.readers.masks.lit_part import beyond_surround

Guess = Callable[[Frame], Float32Image]
"""Depth (H, W) of a frame up to one factor for the clip, 0 = none."""

_SAMPLES = 8  # Training frames that decide the scale, the range and what the endoscope sees.
_PERCENTILES = (1.0, 99.0)
_SMOOTHING = 0.1
"""Of the width: standard deviation of the window that averages albedo out."""
_SUPPORT = 0.02
"""Share of the window that must be well exposed tissue."""


@dataclass(frozen=True)
class Compression:
    """Makes the median of guessed depth 1 and cuts its tails."""

    median: float
    nearest: float
    farthest: float

    @classmethod
    def of(cls, guesses: Iterable[NDArray[np.float32]]) -> Compression | None:
        """From pooled positive values; None when there are none."""
        pooled = np.concatenate([guess[guess > 0] for guess in guesses])
        if not pooled.size:
            return None
        median = float(np.median(pooled))
        nearest, farthest = (float(value) for value in np.percentile(pooled, _PERCENTILES))
        return cls(median, nearest, farthest)

    def __call__(self, guess: Float32Image) -> Float32Image:
        cut = np.clip(guess, self.nearest, self.farthest) / self.median
        return np.where(guess > 0, cut, 0).astype(np.float32)


def with_guessed_depth(clip: Clip, guess: Guess, notice: str) -> Clip:
    """The clip with depth by `guess` in place of any it has, in "scene units" with median 1.

    One factor and one range, the 1st to 99th percentile over a few training frames, hold for all
    frames, so that the scene does not breathe.

    Raises:
        ClipError: a camera that moves by known lengths, which a free scale would contradict; or no
            tissue to guess from.
    """
    if not clip.camera_is_fixed:
        raise ClipError(
            "expected a fixed camera for estimated depth, which has no scale, got one that "
            f"moves: {clip.path}"
        )
    frames = (clip.read_frame(index) for index in _sample(clip))
    compression = Compression.of(np.where(frame.tissue_mask, guess(frame), 0) for frame in frames)
    if compression is None:
        raise ClipError(f"expected lit tissue to estimate depth from, got none: {clip.path}")

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        return replace(frame, depth=compression(guess(frame)), depth_is_guess=True)

    return replace(
        clip, read_frame=read_frame, has_depth=True, unit="scene units", notices=(*clip.notices, notice)
    )


def _sample(clip: Clip) -> list[int]:
    """Training frames, evenly spread."""
    indices = clip.train_indices
    places = np.linspace(0, len(indices) - 1, min(_SAMPLES, len(indices)))
    return [indices[round(place)] for place in places]


def brightness_guess(clip: Clip) -> Guess:
    """Depth by `depth_from_brightness`, none in the dark surround, whose noise tells no distance."""

    @lru_cache(1)
    def seen() -> BoolImage:
        return beyond_surround([clip.read_image(index) for index in _sample(clip)])

    def guess(frame: Frame) -> Float32Image:
        return depth_from_brightness(replace(frame, tissue_mask=frame.tissue_mask & seen()))

    return guess


def depth_from_brightness(frame: Frame) -> Float32Image:
    """Depth (H, W) along +z up to a factor, from how dark the tissue is; 0 off the tissue and in the black.

    An endoscope carries its lamp, so what it sees falls off with the square of the distance r (Wu,
    Narasimhan & Jaramaz, IJCV 2010); lamp and lens lose about cos^2 off the axis besides. From
    luminance = cos^2 / r^2 follows z = r cos = cos^2 / sqrt(luminance). Luminance is linear (sRGB
    decoded), averaged over a window of well exposed tissue that spans many vessels; reflections
    take the depth of what surrounds them. Slope and albedo are not told from distance, so the
    shape is coarse.

    The window and the power of the cosine were chosen on phantoms with seeds 21 to 32, where the mean
    rank correlation with the truth is 0.73, and on training frames of the pulling clip, 0.78.
    """
    lit = (well_exposed(frame.image, frame.tissue_mask) & frame.tissue_mask).astype(np.float32)
    share = averaged(lit, _SMOOTHING)
    light = averaged(lit * _linear_luminance(frame.image), _SMOOTHING)
    seen = frame.tissue_mask & (share > _SUPPORT) & (light > 0) & (frame.image.max(axis=2) > 0)
    distance = np.sqrt(share / np.where(seen, light, 1))
    return np.where(seen, distance * _cosine(frame.camera) ** 2, 0).astype(np.float32)


def _linear_luminance(image: NDArray[np.uint8]) -> Float32Image:
    """(H, W) in [0, 1] by IEC 61966-2-1 and the weights of ITU-R BT.709."""
    level = np.arange(256) / 255
    linear = np.where(level <= 0.04045, level / 12.92, ((level + 0.055) / 1.055) ** 2.4).astype(np.float32)
    return np.asarray(linear[image] @ np.array([0.2126, 0.7152, 0.0722], np.float32))


def _cosine(camera: Camera) -> NDArray[np.float64]:
    """(H, W) of the angle between the ray through each pixel and the axis."""
    rays = camera.moved(np.eye(4)).unproject(np.ones((camera.height, camera.width)))
    return np.asarray(1 / np.linalg.norm(rays, axis=2))
