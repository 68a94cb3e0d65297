"""H.264 in .mp4 by the system's FFmpeg, a program of its own that is given the frames one by one."""

from __future__ import annotations

import subprocess
from contextlib import suppress
from pathlib import Path
from shutil import which
from tempfile import TemporaryFile
from typing import IO, Any

from app.files.codecs import CODECS, MP4
from app.files.image_files import ArrayImage
from app.files.timing import Timing, losses

PATIENCE = 10
"""Seconds in which it ends after it has stopped reading."""
BITS_PER_PIXEL = 0.25
"""Of encoders that are told a rate in place of a quality: much, as vessels are fine."""
EXACT = "scale=out_color_matrix=bt709:out_range=tv:flags=bicubic+accurate_rnd+full_chroma_int+full_chroma_inp"
"""Without these flags whole pictures become darker by a grey level."""
TAGS = ("-color_primaries", "bt709", "-color_trc", "bt709", "-colorspace", "bt709", "-color_range", "tv")


class FfmpegWriter:
    """Frames come evenly, without sound.

    Raises:
        OSError: FFmpeg is gone, or cannot write this.
    """

    def __init__(self, path: Path, size: tuple[int, int], timing: Timing, encoder: str) -> None:
        self.encoding = f"H.264 by ffmpeg's {encoder}, colour tags 1/1/1"
        self.notices = losses(timing)
        self._said = TemporaryFile()  # noqa: SIM115 - it is closed with the writer.
        program, (width, height) = which("ffmpeg") or "ffmpeg", size
        rate = f"{timing.frames_per_second:.6f}"
        bits = round(BITS_PER_PIXEL * width * height * timing.frames_per_second)
        told = CODECS[MP4].options if encoder == CODECS[MP4].encoder else {"b:v": str(bits)}
        quality = [word for name, value in told.items() for word in (f"-{name}", value)]
        command = (
            program, "-hide_banner", "-loglevel", "error", "-nostdin", "-y",
            "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", rate, "-i", "pipe:0",
            "-vf", EXACT, "-pix_fmt", "yuv420p", *TAGS,
            "-c:v", encoder, *quality,
            "-movflags", "+faststart", "-f", "mp4", f"file:{path.absolute()}",
        )  # fmt: skip
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=self._said, stderr=self._said)

    @property
    def _frames(self) -> IO[Any]:
        assert self._process.stdin is not None
        return self._process.stdin

    def write(self, frame: ArrayImage, seconds: float | None) -> None:
        # Of a pipe whose reader has ended systems say different things.
        try:
            self._frames.write(frame.tobytes())
        except OSError as error:
            raise self._failed() from error

    def finish(self) -> None:
        try:
            self._frames.close()
        except OSError as error:
            raise self._failed() from error
        if self._process.wait() != 0:
            raise self._failed()

    def _failed(self) -> OSError:
        """Why ffmpeg has failed, as its last line says it, once it has ended."""
        with suppress(OSError):
            self._frames.close()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(PATIENCE)
        self._said.seek(0)
        lines = self._said.read().decode(errors="replace").strip().splitlines()
        return OSError(f"ffmpeg cannot write the video: {lines[-1] if lines else 'it ended early'}")

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        with suppress(OSError):  # What it had not read is of no use any more.
            self._frames.close()
        self._said.close()
