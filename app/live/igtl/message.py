"""A live picture as an OpenIGTLink IMAGE message, version 1.

3D Slicer puts the first axis of the message (columns, rightwards) towards the patient's left and the second
(rows, downwards) towards posterior, a pixel's height to 1 mm, the first pixel at the origin: the axial
slice, which Slicer looks at from the feet, then shows the picture upright and not mirrored.
"""

from __future__ import annotations

import time
from struct import Struct
from typing import Final

import numpy as np

from app.live.picture import LivePicture

DEVICE: Final = b"VesselSplat"
"""Name of the node in Slicer."""
HEADER: Final = Struct(">H12s20sQQQ")
"""Version, type, device, time, bytes of the body and their checksum."""
IMAGE: Final = Struct(">HBBBB3H12f6H")
"""Version, components, type and order of bytes, axes; size, matrix, first pixel and size of the part."""
UINT8, LITTLE, RAS = 3, 2, 1
"""Codes of the protocol; the axes are right, anterior and superior."""


def message_of(picture: LivePicture) -> memoryview:
    """The frame as shown, RGB, 8 bit, with the time at which it arrived."""
    # Its kernel is compiled when the first frame is sent, and is no part of the window's start.
    from app.live.igtl.checksum import crc64

    image = picture.original if picture.enhanced is None else picture.enhanced
    message = np.empty(HEADER.size + IMAGE.size + image.nbytes, np.uint8)
    body = message[HEADER.size :]
    IMAGE.pack_into(body.data, 0, *_about(image.shape[1], image.shape[0], picture.pixel_aspect))
    body[IMAGE.size :].reshape(image.shape)[:] = image
    arrived = time.time() - (time.perf_counter() - picture.arrived)
    HEADER.pack_into(message.data, 0, 1, b"IMAGE", DEVICE, _stamp(arrived), body.size, crc64(body))
    return message.data


def _about(width: int, height: int, aspect: float) -> tuple[float, ...]:
    """What an IMAGE says before its pixels; its place is that of its centre."""
    columns, rows, slices = (-aspect, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)
    center = (-aspect * (width - 1) / 2, -(height - 1) / 2, 0.0)
    size = (width, height, 1)
    return (1, 3, UINT8, LITTLE, RAS, *size, *columns, *rows, *slices, *center, 0, 0, 0, *size)


def _stamp(seconds: float) -> int:
    """Seconds since 1970, in units of 2^-32."""
    return int(seconds * 2**32)
