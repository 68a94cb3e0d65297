"""What a decoder leaves to its user: which way is up, the shape of pixels, and colours that no tag tells."""

from __future__ import annotations

from contextlib import suppress
from fractions import Fraction
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ByteImage

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from av import VideoFrame
    from av.buffer import Buffer
    from av.video.stream import VideoStream

UNSPECIFIED = 2
"""Of a colour tag, in ITU-T H.273."""
HD = 720
"""Rows from which on players take the matrix of BT.709 where the file names none."""


def usual_matrix(height: int) -> str:
    """Of a picture that names none, as swscale calls it."""
    return "ITU709" if height >= HD else "ITU601"


def said_with(frame: VideoFrame, kind: str) -> bytes | None:
    """What a video says with a frame, by FFmpeg's name of it.

    `VideoFrame.side_data` would be kept by the frame, which it keeps: its megabytes, and the threads of its
    conversion, would wait for a collection of cycles, and that counts objects alone.
    """
    from av.sidedata.sidedata import SideDataContainer

    said = SideDataContainer.__new__(SideDataContainer)
    # It stops at the first kind that PyAV has no name for, such as EXIF, before which FFmpeg puts the others.
    with suppress(ValueError):
        cast("Callable[[object, VideoFrame], None]", SideDataContainer.__init__)(said, frame)
    found = cast("Mapping[str, Buffer]", said).get(kind)
    return None if found is None else bytes(found)


def lies_down(frame: VideoFrame) -> bool:
    """Whether rows of the stored frame are columns of the upright one."""
    right, down = _display_matrix(frame)[0]
    return bool(abs(down) > abs(right))


def upright(frame: VideoFrame, stored: ByteImage) -> ByteImage:
    """The (H, W, 3) pixels of a frame, turned and mirrored as players show it: a view of the same memory."""
    across, down = _display_matrix(frame)
    if lies_down(frame):
        stored, across, down = stored.transpose(1, 0, 2), down, across
    return stored[:: -1 if down[1] < 0 else 1, :: -1 if across[0] < 0 else 1]


def _display_matrix(frame: VideoFrame) -> NDArray[np.int64]:
    """(2, 2): the directions, right and down, in which a step across and a step down the stored frame go.

    Source: ISO/IEC 14496-12, 8.3.2 (matrix of a track), as FFmpeg hands it on.
    """
    told = said_with(frame, "DISPLAYMATRIX")
    if told is None:
        return np.eye(2, dtype=np.int64)
    return np.frombuffer(told, np.int32).astype(np.int64).reshape(3, 3)[:2, :2]


def pixel_aspect(stream: VideoStream, frame: VideoFrame) -> Fraction:
    """Width of a pixel by its height, in the upright picture; 1 where all of them together differ by less
    than one pixel, as is left of rounding when a video is made smaller."""
    aspect = Fraction(stream.sample_aspect_ratio or 1)
    if abs(aspect - 1) * max(frame.width, frame.height) < 1:
        return Fraction(1)
    return 1 / aspect if lies_down(frame) else aspect


def bits_of(frame: VideoFrame) -> int:
    """Of a colour, as they are stored."""
    return max(component.bits for component in frame.format.components)
