"""What a decoder leaves to its user: which way is up, the shape of pixels, and colours that no tag tells."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from av import VideoFrame
    from av.video.stream import VideoStream

UNSPECIFIED = 2
"""Of a colour tag, in ITU-T H.273."""
HD = 720
"""Rows from which on players take the matrix of BT.709 where the file names none."""


def usual_matrix(height: int) -> str:
    """Of a picture that names none, as swscale calls it."""
    return "ITU709" if height >= HD else "ITU601"


def quarter_turns(frame: VideoFrame) -> int:
    """Counterclockwise, 0 to 3, that make the frame upright."""
    return round(frame.rotation / 90) % 4


def pixel_aspect(stream: VideoStream, frame: VideoFrame) -> Fraction:
    """Width of a pixel by its height, in the upright picture; 1 where all of them together differ by less
    than one pixel, as is left of rounding when a video is made smaller."""
    aspect = Fraction(stream.sample_aspect_ratio or 1)
    if abs(aspect - 1) * max(frame.width, frame.height) < 1:
        return Fraction(1)
    return 1 / aspect if quarter_turns(frame) % 2 else aspect


def bits_of(frame: VideoFrame) -> int:
    """Of a colour, as they are stored."""
    return max(component.bits for component in frame.format.components)
