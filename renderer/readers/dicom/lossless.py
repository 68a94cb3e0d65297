"""Lossless JPEG and JPEG-LS, which archives like and pydicom has no free decoder for: FFmpeg decodes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from renderer.pyav_presence import has_pyav
from renderer.readers.dicom.header import DicomHeader

if TYPE_CHECKING:
    from av import VideoCodecContext

CODECS: Final = {
    "1.2.840.10008.1.2.4.57": "mjpeg",
    "1.2.840.10008.1.2.4.70": "mjpeg",
    "1.2.840.10008.1.2.4.80": "jpegls",
    "1.2.840.10008.1.2.4.81": "jpegls",
}
"""By transfer syntax, as FFmpeg calls them."""
FRAMES: Final = (0xC3, 0xF7)
"""Second bytes of the markers that begin the header of a frame of JPEG Lossless and of JPEG-LS."""
SCAN: Final = 0xDA
"""That of the marker that begins its data."""
FORMS: Final = {1: ("gray", "gray16le"), 3: ("rgb24", "bgr24", "rgb48le", "bgr48le")}
"""By values of a pixel: those of which nothing is changed."""


def is_lossless(header: DicomHeader) -> bool:
    """Whether FFmpeg decodes such frames here; colours are those of RGB alone."""
    known = header.samples == 1 or header.photometric == "RGB"
    return known and header.transfer_syntax in CODECS and has_pyav()


def decoded_frame(content: bytes, header: DicomHeader) -> NDArray[Any]:
    """(H, W) or (H, W, 3) of one compressed frame, as stored. Raises ValueError or FFmpegError: damaged."""
    import av

    codec = cast("VideoCodecContext", av.CodecContext.create(CODECS[header.transfer_syntax], "r"))
    # One that unpacks to more than is announced is not decoded.
    codec.options = {"max_pixels": str(header.size[0] * header.size[1])}
    frames = [*codec.decode(av.Packet(content)), *codec.decode(None)]
    if len(frames) != 1 or (frames[0].width, frames[0].height) != header.size:
        raise ValueError("the frame is not of the size announced")
    frame = frames[0]
    if frame.is_corrupt or frame.format.name not in FORMS[header.samples]:
        raise ValueError(f"its pixels are {frame.format.name}")
    pixels: NDArray[Any] = frame.to_ndarray()
    most = 8 * pixels.dtype.itemsize
    # FFmpeg brings what is stored in fewer bits up to the whole range of its type.
    pixels = pixels >> (most - _precision(content, most))
    return np.asarray(pixels[..., ::-1] if frame.format.name.startswith("bgr") else pixels)


def _precision(content: bytes, most: int) -> int:
    """Bits of a value, as the frame's header says; `most` where it says nothing that can be."""
    at = 2
    while at + 5 <= len(content) and content[at] == 0xFF and content[at + 1] != SCAN:
        if content[at + 1] in FRAMES:
            return content[at + 4] if 1 < content[at + 4] <= most else most
        at += 2 + int.from_bytes(content[at + 2 : at + 4])
    return most
