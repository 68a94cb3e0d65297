"""Video files: as .mp4 H.264 by PyAV or FFmpeg, as all players show, or else MPEG-4 part 2 by OpenCV; other
codecs by PyAV alone."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain, repeat
from pathlib import Path
from typing import Protocol

import numpy as np

from app.errors import UserError
from app.files.atomic import replaced, require_there
from app.files.image_files import ArrayImage
from app.files.legible import require_utf8
from app.files.stepping import run_to_end
from app.files.timing import Timing
from app.files.video_encoder import codec_for, video_encoder


@dataclass(frozen=True)
class Written:
    """What became of the frames."""

    encoding: str
    """Codec and colour, for the record."""
    notices: tuple[str, ...]
    """One sentence for each loss."""


class Writer(Protocol):
    encoding: str
    notices: tuple[str, ...]

    def write(self, frame: ArrayImage, seconds: float | None) -> None:
        """Append one (H, W, 3) RGB uint8 frame, shown from `seconds` on; None: after the last, evenly."""

    def finish(self) -> None:
        """All frames are there: complete the file."""

    def close(self) -> None:
        """Let go of the file, finished or not."""


def write_video(path: Path, frames: Iterator[ArrayImage], timing: Timing) -> Written:
    """`write_frames` in one go. Raises UserError as that does."""
    return run_to_end(write_frames(path, frames, timing))


def write_frames(path: Path, frames: Iterator[ArrayImage], timing: Timing) -> Generator[int, None, Written]:
    """Write at least one uint8 frame, (H, W) grey, (H, W, 3) RGB or (H, W, 4) RGBA, whose alpha is lost.

    Yields the number of frames written so far. The file appears whole or not at all, also when the generator
    is closed before its end. Size stays, but for the last column or row of an odd size, which the codecs
    cannot hold.

    Raises:
        UserError: frames of another type, of different sizes, smaller than 2x2 pixels or of a size that the
            codec cannot hold, a path that is not UTF-8, or no encoder of its ending on this machine.
    """
    require_utf8(path)
    stored = (_stored(frame, path) for frame in frames)
    with replaced(path) as temporary:
        first = next(stored)
        if min(first.shape[:2]) < 2:
            got = f"{first.shape[1]}x{first.shape[0]}"
            raise UserError(
                f"expected video frames of at least 2x2 pixels, got {got} (write to a folder instead): {path}"
            )
        size = (first.shape[1] // 2 * 2, first.shape[0] // 2 * 2)
        writer = _writer(path, temporary, size, timing)
        times = iter(timing.frame_times) if timing.frame_times else repeat(None)
        try:
            for done, (frame, seconds) in enumerate(
                zip(chain((first,), stored), times, strict=False), start=1
            ):
                if frame.shape != first.shape:
                    given, come = first.shape[1::-1], frame.shape[1::-1]
                    raise UserError(
                        f"expected frames of {given[0]}x{given[1]}, got {come[0]}x{come[1]}: {path}"
                    )
                require_there(temporary.parent)
                writer.write(np.ascontiguousarray(frame[: size[1], : size[0]]), seconds)
                yield done
            writer.finish()
        except BaseException:
            with suppress(OSError):  # It follows from what is told.
                writer.close()
            raise
        writer.close()
    cut = f"the codec needs even sizes: {first.shape[1]}x{first.shape[0]} was cut to {size[0]}x{size[1]}"
    return Written(writer.encoding, (*((cut,) if size != first.shape[1::-1] else ()), *writer.notices))


def _stored(frame: ArrayImage, path: Path) -> ArrayImage:
    if frame.dtype != np.uint8:
        raise UserError(
            f"expected 8-bit frames for a video, got {frame.dtype} (write to a folder instead): {path}"
        )
    return np.repeat(frame[..., None], 3, axis=2) if frame.ndim == 2 else frame[..., :3]


def _writer(path: Path, place: Path, size: tuple[int, int], timing: Timing) -> Writer:
    """Raises UserError, naming `path`, when nothing on this machine can write a video."""
    codec, encoder = codec_for(path), video_encoder()
    if encoder.program == "PyAV":
        from app.files.pyav_writing import PyavWriter

        return PyavWriter(place, size, timing, codec)
    if encoder.program == "ffmpeg":
        from app.files.ffmpeg_video import FfmpegWriter

        return FfmpegWriter(place, size, timing, encoder.name)
    from app.files.mpeg4_video import Mpeg4Writer

    try:
        return Mpeg4Writer(place, size, timing)
    except OSError as error:
        raise UserError(f"cannot write video on this machine (write to a folder instead): {path}") from error
