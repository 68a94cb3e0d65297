"""What stands behind the Gaussians, where nothing was observed: it must not look like tissue."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

import cv2
import numpy as np

from renderer.splats import Float32Array
from renderer.unobserved import BLACK, GREY, LINES, PERIOD, Rgb, line_mask

Background = Rgb | Literal["hatched", "smooth"]
BackgroundName = Literal["grey", "hatched", "smooth", "black"]
BACKGROUNDS: Final[Mapping[BackgroundName, Background]] = {
    "grey": GREY,
    "hatched": "hatched",
    "smooth": "smooth",
    "black": BLACK,
}
EXPLAINED: Final[Mapping[BackgroundName, str]] = {
    "grey": "Plain grey where nothing was observed.",
    "hatched": "Diagonal lines where nothing was observed.",
    "smooth": "The colours of the surroundings, hatched, where nothing was observed.",
    "black": "Black where nothing was observed.",
}
_LINE_SHARE = np.float32(0.5)
"""Of the colour of the lines in a smooth background."""


def laid_over(image: Float32Array, alpha: Float32Array, background: Background) -> Float32Array:
    """(H, W, 3) of a premultiplied `image` (H, W, 3) with `alpha` (H, W) in [0, 1], not clipped."""
    return laid(image, alpha, ground(image, alpha, background))


def laid(image: Float32Array, alpha: Float32Array, behind: Float32Array) -> Float32Array:
    """The same over what is `behind` it (H, W, 3)."""
    left = np.repeat(1 - alpha, 3, axis=1).reshape(image.shape)
    over: Float32Array = image + left * behind
    return over


def ground(image: Float32Array, alpha: Float32Array, background: Background) -> Float32Array:
    """(H, W, 3), what is behind such an image; not to be written to."""
    height, width = alpha.shape
    if not isinstance(background, str):
        return np.broadcast_to(np.tile(np.array(background, np.float32), (width, 1)), (height, width, 3))
    color = np.array(LINES, np.float32)
    if background == "hatched":
        once = np.where(line_mask(PERIOD, width)[..., None], color, np.array(GREY, np.float32))
        return once[np.arange(height) % PERIOD]
    smooth, lines = _smooth(image, alpha), line_mask(height, width)[..., None]
    return np.where(lines, smooth + _LINE_SHARE * (color - smooth), smooth)


def _smooth(image: Float32Array, alpha: Float32Array) -> Float32Array:
    """(H, W, 3) of what surrounds each pixel: every level of a pyramid is laid over the next coarser one."""
    height, width = alpha.shape
    half = (width + 1) // 2, (height + 1) // 2
    if half == (width, height):
        return np.divide(image, alpha[..., None], out=np.zeros_like(image), where=alpha[..., None] > 0)
    fewer = _resized(image, half, cv2.INTER_AREA)
    share = _resized(alpha, half, cv2.INTER_AREA)
    coarse: Float32Array = fewer + (1 - share[..., None]) * _smooth(fewer, share)
    return _resized(coarse, (width, height), cv2.INTER_LINEAR)


def _resized(values: Float32Array, size: tuple[int, int], interpolation: int) -> Float32Array:
    """To (width, height); OpenCV leaves out an axis of length 1 at the end."""
    resized = cv2.resize(values, size, interpolation=interpolation).astype(np.float32, copy=False)
    return resized.reshape(*size[::-1], *values.shape[2:])
