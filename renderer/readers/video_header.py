"""What the header of a video file says, without decoding it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2

from renderer.clip import ClipError


@dataclass(frozen=True)
class VideoHeader:
    """As announced: what decodes may be less."""

    size: tuple[int, int]
    """Width and height in pixels."""
    frames: int | None
    frames_per_second: float | None


def read_video_header(path: Path) -> VideoHeader:
    """Raises ClipError: the file is no video, or its path is not UTF-8, which the decoder cannot take."""
    try:
        str(path).encode()
    except UnicodeEncodeError as error:
        shown = str(path).encode(errors="backslashreplace").decode()
        raise ClipError(f"expected a path in UTF-8, rename or move it: {shown}") from error
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    if not capture.isOpened():
        raise ClipError(f"expected a picture or a video, got a file that is neither, or damaged: {path}")
    try:
        names = cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FRAME_COUNT
        width, height, frames = (int(capture.get(name)) for name in names)
        rate = float(capture.get(cv2.CAP_PROP_FPS))
    finally:
        capture.release()
    return VideoHeader((width, height), frames if frames > 0 else None, rate if 0 < rate < 1000 else None)
