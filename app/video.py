"""Video files, written by OpenCV: MPEG-4 part 2 in .mp4."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import cv2
import numpy as np

from app.atomic import replaced
from app.errors import UserError
from app.pictures import ArrayImage


def write_video(path: Path, frames: Iterator[ArrayImage], frames_per_second: float) -> None:
    """Write at least one uint8 frame, (H, W) grey, (H, W, 3) RGB or (H, W, 4) RGBA, whose alpha is lost.

    The file appears whole or not at all.

    Raises:
        UserError: frames of another type or of different sizes, or no encoder on this machine.
    """
    stored = (_stored(frame, path) for frame in frames)
    with replaced(path) as temporary:
        first = next(stored)
        size = (first.shape[1], first.shape[0])
        writer = cv2.VideoWriter(str(temporary), cv2.VideoWriter.fourcc(*"mp4v"), frames_per_second, size)
        try:
            if not writer.isOpened():
                raise UserError(f"cannot write video on this machine; give a folder in place of {path}")
            for frame in chain((first,), stored):
                if frame.shape != first.shape:
                    raise UserError(
                        f"expected frames of {size[0]}x{size[1]}, got {frame.shape[1::-1]}: {path}"
                    )
                writer.write(frame)
        finally:
            writer.release()


def _stored(frame: ArrayImage, path: Path) -> ArrayImage:
    if frame.dtype != np.uint8:
        raise UserError(f"a video holds 8-bit frames, got {frame.dtype}; give a folder in place of {path}")
    if frame.ndim == 2:
        return cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR)
    return cv2.cvtColor(np.ascontiguousarray(frame[..., :3]), cv2.COLOR_RGB2BGR)
