"""MPEG-4 part 2 by OpenCV: what can be written where PyAV is not installed, as in the bundle."""

from __future__ import annotations

import errno
import struct
from pathlib import Path

import cv2

from app.files.codecs import BT601, BT709
from app.files.image_files import ArrayImage
from app.files.timing import Timing, losses

ENTRY = (b"trak", b"mdia", b"minf", b"stbl", b"stsd", b"mp4v")
"""Where moov holds the description of an MPEG-4 part 2 stream."""
CHILDREN = {b"stsd": 16}
"""Bytes before the first child, where they are not 8."""


class Mpeg4Writer:
    """Frames come evenly, without sound; players know the codec, browsers do not.

    Raises:
        OSError: OpenCV cannot write video on this machine.
    """

    encoding = "MPEG-4 part 2, BT.601 matrix, tagged so"

    def __init__(self, path: Path, size: tuple[int, int], timing: Timing) -> None:
        self._path = path
        # A path of its own, since a name with a colon would be taken for an address.
        place = str(path.absolute())
        codec = cv2.VideoWriter.fourcc(*"mp4v")
        self._writer = cv2.VideoWriter(place, codec, timing.frames_per_second, size)
        if not self._writer.isOpened():
            raise OSError(f"no encoder for {path}")
        self.notices = losses(timing)

    def write(self, frame: ArrayImage, seconds: float | None) -> None:
        self._writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))

    def finish(self) -> None:
        self._writer.release()
        # OpenCV converts with the matrix of BT.601 and does not say so; its RGB is that of screens, BT.709.
        try:
            tag_colors(self._path, primaries=BT709, transfer=BT709, matrix=BT601)
        except (ValueError, struct.error) as error:
            # OpenCV does not say that it could not write.
            raise OSError(errno.EIO, "the video is not whole, as of a full disk", str(self._path)) from error

    def close(self) -> None:
        self._writer.release()


def tag_colors(path: Path, primaries: int, transfer: int, matrix: int) -> None:
    """Without a colour tag, players guess the matrix by the size and shift the reds.

    Add a `colr` box of limited range, with codes of ITU-T H.273, to the video that OpenCV wrote at `path`.

    The box (ISO/IEC 14496-12, 12.1.5) goes into `moov`, which must be the file's last, as OpenCV writes it:
    what lies before stays where it is.

    Raises:
        ValueError: a file of another structure.
    """
    color = struct.pack(">I4s4sHHHB", 19, b"colr", b"nclx", primaries, transfer, matrix, 0)
    with path.open("r+b") as file:
        size = path.stat().st_size
        offset, kind, length = 0, b"", 0
        while offset + length < size:
            offset += length
            file.seek(offset)
            length, kind = _header(file.read(16))
            if length < 8:
                break
        if kind != b"moov" or offset + length != size:
            raise ValueError(f"expected moov as the last box of {path.name}, got {kind!r}")
        file.seek(offset)
        moov = file.read(length)
        file.seek(offset)
        file.write(_extended(moov, ENTRY, color))


def _header(start: bytes) -> tuple[int, bytes]:
    """Length and kind of the box that begins with these 16 bytes."""
    length, kind = struct.unpack_from(">I4s", start)
    return (struct.unpack_from(">Q", start, 8)[0] if length == 1 else length), kind


def _extended(box: bytes, below: tuple[bytes, ...], extra: bytes) -> bytes:
    """`box` with `extra` at the end of its descendant along `below`, and all sizes made to fit."""
    if not below:
        return _sized(box + extra)
    offset = CHILDREN.get(box[4:8], 8)
    while offset + 8 <= len(box):
        length, kind = struct.unpack_from(">I4s", box, offset)
        if kind == below[0]:
            child = _extended(box[offset : offset + length], below[1:], extra)
            return _sized(box[:offset] + child + box[offset + length :])
        if length < 8:
            break
        offset += length
    raise ValueError(f"expected a box {below[0]!r} in {box[4:8]!r}")


def _sized(box: bytes) -> bytes:
    return struct.pack(">I", len(box)) + box[4:]
