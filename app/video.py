"""Video files: H.264 with the input's colour tags where PyAV is installed, else MPEG-4 part 2 by OpenCV."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass
from fractions import Fraction
from importlib import import_module
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np

from app.atomic import replaced
from app.color_tag import tag_colors
from app.errors import UserError
from app.in_steps import in_one_go
from app.pictures import ArrayImage
from app.utf8 import require_utf8

BT709, UNSPECIFIED, BT601 = 1, 2, 6
"""Codes of ITU-T H.273."""


@dataclass(frozen=True)
class Written:
    """What became of the frames."""

    encoding: str
    """Codec and colour, for the record."""
    notices: tuple[str, ...]
    """One sentence for each loss."""


class Writer(Protocol):
    encoding: str

    def write(self, frame: ArrayImage) -> None:
        """Append one (H, W, 3) RGB uint8 frame."""

    def finish(self) -> None:
        """All frames are there: complete the file."""

    def close(self) -> None:
        """Let go of the file, finished or not."""


def write_video(
    path: Path, frames: Iterator[ArrayImage], frames_per_second: float, *, like: Path | None = None
) -> Written:
    """`write_frames` in one go. Raises UserError as that does."""
    return in_one_go(write_frames(path, frames, frames_per_second, like=like))


def write_frames(
    path: Path, frames: Iterator[ArrayImage], frames_per_second: float, *, like: Path | None = None
) -> Generator[int, None, Written]:
    """Write at least one uint8 frame, (H, W) grey, (H, W, 3) RGB or (H, W, 4) RGBA, whose alpha is lost.

    Yields the number of frames written so far. The file appears whole or not at all, also when the generator
    is closed before its end. Frame rate and size stay, but for the last column or row of an odd
    size, which the codecs cannot hold. Sound is not written, and the rate is constant.

    Args:
        like: the video that the frames come from, whose colour tags are kept where PyAV is installed. Without
            PyAV the file is in BT.601 and says so, so that colours look the same.

    Raises:
        UserError: frames of another type, of different sizes or smaller than 2x2 pixels, a path that is not
            UTF-8, or no encoder on this machine.
    """
    require_utf8(path)
    stored = (_stored(frame, path) for frame in frames)
    with replaced(path) as temporary:
        first = next(stored)
        if min(first.shape[:2]) < 2:
            got = f"{first.shape[1]}x{first.shape[0]}"
            raise UserError(
                f"a video holds frames of 2x2 pixels or more, got {got}; give a folder for {path}"
            )
        size = (first.shape[1] // 2 * 2, first.shape[0] // 2 * 2)
        writer = _writer(path, temporary, size, frames_per_second, like)
        try:
            for done, frame in enumerate(chain((first,), stored), start=1):
                if frame.shape != first.shape:
                    given, come = first.shape[1::-1], frame.shape[1::-1]
                    raise UserError(
                        f"expected frames of {given[0]}x{given[1]}, got {come[0]}x{come[1]}: {path}"
                    )
                writer.write(np.ascontiguousarray(frame[: size[1], : size[0]]))
                yield done
            writer.finish()
        finally:
            writer.close()
    cut = f"the codec holds even sizes: {first.shape[1]}x{first.shape[0]} was cut to {size[0]}x{size[1]}"
    return Written(writer.encoding, (cut,) if size != first.shape[1::-1] else ())


def _stored(frame: ArrayImage, path: Path) -> ArrayImage:
    if frame.dtype != np.uint8:
        raise UserError(f"a video holds 8-bit frames, got {frame.dtype}; give a folder in place of {path}")
    return np.repeat(frame[..., None], 3, axis=2) if frame.ndim == 2 else frame[..., :3]


def _writer(path: Path, place: Path, size: tuple[int, int], rate: float, like: Path | None) -> Writer:
    """Raises UserError, naming `path`, when nothing on this machine can write a video."""
    if find_spec("av") is not None and "libx264" in import_module("av").codecs_available:
        return _AvWriter(place, size, rate, like)
    writer = cv2.VideoWriter(str(place), cv2.VideoWriter.fourcc(*"mp4v"), rate, size)
    if not writer.isOpened():
        raise UserError(f"cannot write video on this machine; give a folder in place of {path}")
    return _OpenCvWriter(place, writer)


class _OpenCvWriter:
    encoding = "MPEG-4 part 2, BT.601 matrix, tagged so"

    def __init__(self, path: Path, writer: cv2.VideoWriter) -> None:
        self._path, self._writer = path, writer

    def write(self, frame: ArrayImage) -> None:
        self._writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))

    def finish(self) -> None:
        self._writer.release()
        # OpenCV converts with the matrix of BT.601 and does not say so; its RGB is that of screens, BT.709.
        tag_colors(self._path, primaries=BT709, transfer=BT709, matrix=BT601)

    def close(self) -> None:
        self._writer.release()


class _AvWriter:
    def __init__(self, path: Path, size: tuple[int, int], rate: float, like: Path | None) -> None:
        self._av: Any = import_module("av")
        self._container = self._av.open(str(path), "w")
        speed = {"crf": "16", "preset": "veryfast"}
        stream = self._container.add_stream(
            "libx264", rate=Fraction(rate).limit_denominator(1001), options=speed
        )
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        codec = stream.codec_context
        tags = self._tags(like) if like is not None else (BT709, BT709, BT709)
        codec.color_primaries, codec.color_trc, codec.colorspace = tags
        codec.color_range = 1
        self._stream = stream
        # OpenCV decodes what is not tagged by BT.601: written back by the same matrix, colours do not move.
        self._matrix = BT601 if tags[2] == UNSPECIFIED else tags[2]
        self.encoding = f"H.264, colour tags {tags[0]}/{tags[1]}/{tags[2]}"

    def _tags(self, like: Path) -> tuple[int, int, int]:
        """Primaries, transfer and matrix of a video."""
        with self._av.open(str(like)) as container:
            codec = container.streams.video[0].codec_context
            return int(codec.color_primaries), int(codec.color_trc), int(codec.colorspace)

    def write(self, frame: ArrayImage) -> None:
        # Of the codes of H.273, swscale calls 6 by its own name, 5.
        matrix = 5 if self._matrix == BT601 else self._matrix
        picture = self._av.VideoFrame.from_ndarray(frame, "rgb24").reformat(
            format="yuv420p", dst_colorspace=matrix, dst_color_range=1
        )
        self._container.mux(self._stream.encode(picture))

    def finish(self) -> None:
        self._container.mux(self._stream.encode())

    def close(self) -> None:
        self._container.close()
