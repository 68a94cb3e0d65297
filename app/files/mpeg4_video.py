"""MPEG-4 part 2 by OpenCV: what can be written where PyAV is not installed, as in the bundle."""

from __future__ import annotations

from pathlib import Path

import cv2

from app.files.image_files import ArrayImage
from app.files.mp4_color_tag import tag_colors
from app.files.timing import Timing

BT709, BT601 = 1, 6
"""Codes of ITU-T H.273."""


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
        lost = [] if timing.like is None else ["sound is"]
        lost += [] if timing.frame_times is None else ["uneven frame times are"]
        missing = "not kept: this needs PyAV, which is not installed"
        self.notices = tuple(f"{what} {missing}" for what in lost)

    def write(self, frame: ArrayImage, seconds: float | None) -> None:
        self._writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))

    def finish(self) -> None:
        self._writer.release()
        # OpenCV converts with the matrix of BT.601 and does not say so; its RGB is that of screens, BT.709.
        tag_colors(self._path, primaries=BT709, transfer=BT709, matrix=BT601)

    def close(self) -> None:
        self._writer.release()
