"""Pictures that hold both eyes: how they lie in them, and what a video says of it."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, cast

from renderer.clip import ByteImage, ClipError
from renderer.readers.clip_options import Stereo, StereoLayout

if TYPE_CHECKING:
    from av import VideoFrame
    from av.buffer import Buffer

TOLD: Final[Mapping[int, StereoLayout]] = {1: "side-by-side", 2: "top-bottom"}
"""As FFmpeg numbers them."""
RIGHT_FIRST: Final = 1
"""FFmpeg's flag of eyes that have changed places."""
NARROWEST: Final = 1.0
WIDEST: Final = 2.4
"""Width by height of an eye's picture: beyond, it is squeezed to half its width or height, as for cables and
screens made for one picture. Squeezed ones of 5:4 to 16:9 have 0.63 to 0.89, or 2.5 to 3.6."""


def chosen_layout(stereo: Stereo, told: StereoLayout | None) -> StereoLayout | None:
    """What is asked for, else what the file says; None: its frames are of one eye."""
    if stereo == "auto":
        return told
    return None if stereo == "off" else stereo


def told_layout(first: VideoFrame) -> StereoLayout | None:
    """What a video says with its first frame; None: nothing, or a layout that is not read."""
    found = cast("Buffer | None", first.side_data.get("STEREO3D"))
    if found is None:
        return None
    tag = bytes(found)
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
