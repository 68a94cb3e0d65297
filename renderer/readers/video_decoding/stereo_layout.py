"""Pictures that hold both eyes: how they lie in them, and what a video says of it."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import ByteImage, ClipError
from renderer.readers.clip_options import Stereo, StereoLayout
from renderer.readers.video_decoding.video_shape import said_with

if TYPE_CHECKING:
    from av import VideoFrame

TOLD: Final[Mapping[int, StereoLayout]] = {1: "side-by-side", 2: "top-bottom"}
"""As FFmpeg numbers them."""
RIGHT_FIRST: Final = 1
"""FFmpeg's flag of eyes that have changed places."""
NARROWEST: Final = 1.0
WIDEST: Final = 2.4
"""Width by height of an eye's picture: beyond, it is squeezed to half its width or height, as for cables and
screens made for one picture. Squeezed ones of 5:4 to 16:9 have 0.63 to 0.89, or 2.5 to 3.6."""
SLENDEREST: Final = 0.5
"""Width by height, below which a half is no eye's picture, squeezed or not: of an upright frame."""

SMALL: Final = 96
"""Columns at which halves of a frame are compared."""
TALLEST: Final = 192
COARSE: Final = 6.0
"""Pixels, standard deviation of the blur that is taken away: what light and a round view have in common."""
ALIKE: Final = 0.45
"""Correlation from which on halves look alike. Frames of one eye have at most 0.29 (seven clips, a phantom,
42 retinas), pairs of eyes at least 0.61, squeezed ones 0.45 (two clips)."""
FLAT: Final = 0.5
"""Grey levels, standard deviation: too little to compare."""
HALVES: Final[Mapping[StereoLayout, str]] = {
    "side-by-side": "left and right halves",
    "top-bottom": "upper and lower halves",
}


def chosen_layout(stereo: Stereo, told: StereoLayout | None) -> StereoLayout | None:
    """What is asked for, else what the file says; None: its frames are of one eye."""
    if stereo == "auto":
        return told
    return None if stereo == "off" else stereo


def told_layout(first: VideoFrame) -> StereoLayout | None:
    """What a video says with its first frame; None: nothing, or a layout that is not read."""
    tag = said_with(first, "STEREO3D")
    if tag is None:
        return None
    kind, flags = (int.from_bytes(tag[at : at + 4], sys.byteorder) for at in (0, 4))
    return None if flags & RIGHT_FIRST else TOLD.get(kind)


def eye_size(size: tuple[int, int], layout: StereoLayout) -> tuple[int, int]:
    """Width and height of one eye's picture. Raises ClipError: they cannot be of one size."""
    width, height = size
    beside = layout == "side-by-side"
    if (width if beside else height) % 2:
        side = "width" if beside else "height"
        raise ClipError(f"expected an even {side} of {layout} stereo, got {width}x{height}")
    return (width // 2, height) if beside else (width, height // 2)


def eyes(image: ByteImage, layout: StereoLayout) -> tuple[ByteImage, ByteImage]:
    """Left and right picture, views of `image` (H, W, 3). Raises ClipError as `eye_size`."""
    width, height = eye_size((image.shape[1], image.shape[0]), layout)
    if layout == "side-by-side":
        return image[:, :width], image[:, width:]
    return image[:height], image[height:]


def eye_aspect(size: tuple[int, int], layout: StereoLayout, pixel_aspect: float = 1.0) -> float:
    """Width of a pixel by its height in an eye's picture of that size, where that of the video is
    `pixel_aspect`: nothing says whether an eye is squeezed but its shape."""
    shape = pixel_aspect * size[0] / size[1]
    if layout == "side-by-side" and shape < NARROWEST:
        return 2 * pixel_aspect
    return pixel_aspect / 2 if layout == "top-bottom" and shape > WIDEST else pixel_aspect


def squeezed(size: tuple[int, int], layout: StereoLayout, pixel_aspect: float = 1.0) -> str:
    """What is said of an eye's picture that is, behind other words; nothing of one that is not."""
    if eye_aspect(size, layout, pixel_aspect) == pixel_aspect:
        return ""
    return f", squeezed to half its {'width' if layout == 'side-by-side' else 'height'}"


def likely_layout(image: ByteImage) -> StereoLayout | None:
    """That in which the halves of a frame look alike, as pictures of two eyes do, if there is one."""
    grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.uint8)
    height, width = grey.shape[0] // 2, grey.shape[1] // 2
    if min(height, width) < SMALL // 2:
        return None
    likeness: dict[StereoLayout, float] = {
        "side-by-side": _likeness(grey[:, :width], grey[:, width : 2 * width]),
        "top-bottom": _likeness(grey[:height], grey[height : 2 * height]),
    }
    best = max(likeness, key=lambda layout: likeness[layout])
    return best if likeness[best] >= ALIKE else None


def _likeness(one: NDArray[np.uint8], other: NDArray[np.uint8]) -> float:
    """Highest correlation of the middle of one half with the other, a fifth of the width aside at most; 0 of
    halves that show too little, or have no shape of a picture."""
    if one.shape[1] < SLENDEREST * one.shape[0]:
        return 0.0
    size = SMALL, int(np.clip(SMALL * one.shape[0] // one.shape[1], SMALL // 4, TALLEST))
    small = (cv2.resize(half, size, interpolation=cv2.INTER_AREA).astype(np.float32) for half in (one, other))
    first, second = (half - cv2.GaussianBlur(half, (0, 0), COARSE) for half in small)
    aside, above = size[0] // 5, max(2, size[1] // 16)
    middle = first[above:-above, aside:-aside]
    if min(middle.std(), second.std()) < FLAT:
        return 0.0
    return float(cv2.matchTemplate(second, middle, cv2.TM_CCOEFF_NORMED).max())
