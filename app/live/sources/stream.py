"""A stream from an address, by FFmpeg in PyAV: frames as they come, with as little held back as it allows."""

from __future__ import annotations

import time
from collections.abc import Generator
from typing import TYPE_CHECKING

import numpy as np

from app.errors import UserError
from app.live.sources.source import Arrived, SourceLost
from renderer.clip import ByteImage
from renderer.pyav_presence import has_pyav, why_not_pyav
from renderer.readers.video_decoding.video_shape import (
    UNSPECIFIED,
    lies_down,
    pixel_aspect,
    upright,
    usual_matrix,
)

if TYPE_CHECKING:
    from av import Packet, VideoFrame
    from av.container import InputContainer
    from av.video.stream import VideoStream

PATIENCE = 5.0
"""Seconds that opening may take."""
SILENCE = 2.0
"""Seconds without a packet after which a stream is lost."""
QUICK = {
    # Nothing is gathered before the first frame is given out, and no late packet is waited for.
    "fflags": "nobuffer",
    "flags": "low_delay",
    "max_delay": "0",
    "reorder_queue_size": "0",
    "probesize": "500000",
    "analyzeduration": "500000",
    "rtsp_transport": "tcp",
    "fifo_size": "1000000",
    "overrun_nonfatal": "1",
}


class StreamSource:
    """Decodes every frame, as later ones build on it; only those that are looked at become RGB."""

    def __init__(self, address: str, name: str) -> None:
        """Raises SourceLost: nothing answers there; UserError: it is of no kind that FFmpeg knows."""
        if not has_pyav():
            raise UserError(f"expected PyAV for a stream: {why_not_pyav() or 'it is not installed'}")
        self._name = name
        self._container = _opened(address, name)
        self._stream = self._video()
        rate = self._stream.average_rate or self._stream.guessed_rate
        self.frames_per_second = float(rate) if rate and 0 < rate < 1000 else None
        self._lies_down = False  # Frames tell.
        self._frames = self._decoded()

    @property
    def told(self) -> str:
        codec = self._stream.codec_context
        rate = "" if self.frames_per_second is None else f", {self.frames_per_second:.3g} frames/s"
        width, height = (codec.height, codec.width) if self._lies_down else (codec.width, codec.height)
        return f"{width} × {height}{rate}, {codec.name}"

    def read(self) -> Arrived | None:
        try:
            return next(self._frames)
        except StopIteration:
            raise SourceLost("the stream has ended") from None

    def close(self) -> None:
        self._frames.close()
        self._container.close()

    def _video(self) -> VideoStream:
        found = self._container.streams.video
        if not found:
            self._container.close()
            raise UserError(f"expected a stream of video, got one without: {self._name}")
        # Threads by frame hold back as many frames as there are threads.
        found[0].thread_type = "SLICE"
        return found[0]

    def _decoded(self) -> Generator[Arrived, None, None]:
        import av

        try:
            for packet in self._container.demux(self._stream):
                at = time.perf_counter()
                yield from (self._arrived(frame, at) for frame in _frames(packet))
        except (av.error.FFmpegError, OSError) as error:
            raise SourceLost(_reason(error)) from error

    def _arrived(self, frame: VideoFrame, at: float) -> Arrived:
        seconds = at if frame.pts is None else frame.time
        self._lies_down = lies_down(frame)
        aspect = float(pixel_aspect(self._stream, frame))
        return Arrived(lambda: rgb(frame), at, seconds, pixel_aspect=aspect)


def _frames(packet: Packet[VideoStream]) -> list[VideoFrame]:
    """Damaged packets, as after a lost one, give none."""
    import av

    try:
        return [frame for frame in packet.decode() if not frame.is_corrupt]
    except av.error.FFmpegError:
        return []


def rgb(frame: VideoFrame) -> ByteImage:
    """(H, W, 3) of a frame, upright, quickly: within a grey level of the exact conversion that files get."""
    matrix = usual_matrix(frame.height) if frame.colorspace == UNSPECIFIED else None
    stored = np.asarray(frame.reformat(format="rgb24", src_colorspace=matrix).to_ndarray(), np.uint8)
    return np.ascontiguousarray(upright(frame, stored))


def _opened(address: str, name: str) -> InputContainer:
    import av

    try:
        return av.open(address, options=QUICK, timeout=(PATIENCE, SILENCE), metadata_errors="replace")
    except av.error.ProtocolNotFoundError as error:
        scheme = address.partition("://")[0]
        raise UserError(f"expected a stream that PyAV's FFmpeg can receive, which {scheme} is not") from error
    except (av.error.FFmpegError, OSError, ValueError) as error:
        raise SourceLost(f"nothing can be received from {name} ({_reason(error)})") from error


def _reason(error: Exception) -> str:
    """What FFmpeg says, without the address, which may hold a password."""
    import av

    if isinstance(error, av.error.ExitError):
        return "no data in time"
    return str(getattr(error, "strerror", None) or type(error).__name__).lower()
