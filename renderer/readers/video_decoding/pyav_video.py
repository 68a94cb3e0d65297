"""Frames of a video file by number, decoded by FFmpeg through PyAV."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from renderer.clip import ByteImage, ClipError
from renderer.readers.clip_options import Deinterlacing
from renderer.readers.cut_off import cut_off
from renderer.readers.video_decoding.decoders import DECODERS
from renderer.readers.video_decoding.deinterlacing import deinterlaced
from renderer.readers.video_decoding.stereo_layout import told_layout
from renderer.readers.video_decoding.video_index import (
    Threads,
    decoded,
    index_of,
    open_container,
    video_stream,
)
from renderer.readers.video_decoding.video_shape import (
    UNSPECIFIED,
    bits_of,
    pixel_aspect,
    upright,
    usual_matrix,
)

if TYPE_CHECKING:
    from av import VideoFrame
    from av.container import InputContainer
    from av.video.stream import VideoStream

STEP_LIMIT = 32
"""Frames that are cheaper to decode in passing than to seek over."""
RECENT = 4
"""Decoded frames that are kept, since deinterlacing looks at the neighbours."""
UNSEEN = 0.005
"""Share by which pixels are wider than high, or higher than wide, without a word."""
HDR = {16: "PQ", 18: "HLG"}
"""Transfer characteristics of ITU-T H.273 that call for tone mapping."""
INTERLACED = {
    "frame": "interlaced video: deinterlaced, one image per frame",
    "field": "interlaced video: deinterlaced, one image per field",
    "off": "interlaced video: not deinterlaced, as requested; moving edges show combing",
}


class PyAvVideo:
    """Frames by number, in any order and from any thread, from one decoder that is used under a lock, and
    given up when other videos are read.

    Time stamps, sorted, tell which frame is which: a frame is returned only when its own stamp is the wanted
    one, so seeking that lands elsewhere is noticed and mended.

    Raises:
        ClipError: the file is no video, or none of its frames decodes.
    """

    def __init__(self, path: Path, deinterlacing: Deinterlacing = "frame") -> None:
        self._path, self._deinterlacing = path, deinterlacing
        self._lock = threading.Lock()
        self._index = index_of(path)
        self._place = {stamp: number for number, stamp in enumerate(self._index.stamps)}
        by_field = deinterlacing == "field" and self._index.is_interlaced
        self._per_frame = 2 if by_field else 1
        self._decoder: tuple[InputContainer, VideoStream] | None = None
        self._frames: Iterator[VideoFrame] = iter(())
        self._recent: dict[int, VideoFrame] = {}
        self._close: weakref.finalize[..., PyAvVideo] | None = None
        first = self._frame(0)
        self._size = first.width, first.height
        # Of the decoder that gave it: one before it, which did not, is closed.
        assert self._decoder is not None
        self.pixel_aspect: float = float(pixel_aspect(self._decoder[1], first))
        self.stereo = told_layout(first)
        self.notices = tuple(self._oddities(first))
        DECODERS.use(self)

    def __len__(self) -> int:
        return len(self._index.stamps) * self._per_frame

    @property
    def frames_per_second(self) -> float:
        return float(self._index.frames_per_second * self._per_frame)

    @property
    def frame_times(self) -> tuple[float, ...]:
        """Seconds from the first frame, rising."""
        times = self._index.times
        if self._per_frame == 1:
            return times
        lasting = [later - one for one, later in pairwise(times)]
        lasting.append(lasting[-1] if lasting else float(1 / self._index.nominal_rate))
        return tuple(
            time + half * last / 2 for time, last in zip(times, lasting, strict=True) for half in (0, 1)
        )

    def read(self, index: int) -> ByteImage:
        """(H, W, 3) RGB, upright. Raises ClipError when the frame is damaged."""
        number, field = divmod(index, self._per_frame)
        DECODERS.use(self)
        with self._lock:
            before = self._neighbour(number - 1)
            frame = self._frame(number)
            if (frame.width, frame.height) != self._size:
                (width, height), got = self._size, f"{frame.width}x{frame.height}"
                wanted = f"expected frames of {width}x{height}, as the first one"
                raise ClipError(f"{wanted}, got {got} in frame {index + 1} of {len(self)}: {self._path}")
            if frame.interlaced_frame and self._deinterlacing != "off":
                after = self._neighbour(number + 1)
                frame = deinterlaced(before, frame, after, field=field if self._per_frame == 2 else None)
            return self._rgb(frame)

    def rest(self) -> bool:
        """See Rests."""
        if not self._lock.acquire(blocking=False):
            return False
        try:
            self._give_up()
        finally:
            self._lock.release()
        return True

    def _neighbour(self, number: int) -> VideoFrame | None:
        """Of an interlaced frame; None where there is none, or none is needed."""
        needed = self._index.is_interlaced and self._deinterlacing != "off"
        if not needed or not 0 <= number < len(self._index.stamps):
            return None
        try:
            return self._frame(number)
        except ClipError:
            return None

    def _rgb(self, frame: VideoFrame) -> ByteImage:
        """Upright. Raises ClipError: swscale does not convert its colours."""
        from av.error import FFmpegError
        from av.video.reformatter import Colorspace
        from av.video.reformatter import Interpolation as Flags

        # Without these, swscale rounds down: whole pictures become darker by a grey level. It is quickest
        # with a plane a colour.
        exact = Flags.BILINEAR | Flags.ACCURATE_RND | Flags.FULL_CHR_H_INT
        unsaid = frame.colorspace == UNSPECIFIED
        matrix = int(Colorspace[usual_matrix(frame.height)]) if unsaid else None
        wanted: dict[str, Any] = {"format": "gbrp", "src_colorspace": matrix, "interpolation": exact}
        try:
            planar = self._reformatter.reformat(frame, **wanted)
        except FFmpegError as error:
            got = f"those of {frame.format.name} with matrix {frame.colorspace} of H.273"
            raise ClipError(f"expected colours that FFmpeg converts, got {got}: {self._path}") from error
        green, blue, red = (
            np.frombuffer(memoryview(plane), np.uint8).reshape(-1, plane.line_size)[:, : plane.width]
            for plane in planar.planes
        )
        stored = np.asarray(cv2.merge((red, green, blue)), np.uint8)
        return np.ascontiguousarray(upright(frame, stored))

    def _frame(self, number: int) -> VideoFrame:
        if number in self._recent:
            return self._recent[number]
        if self._decoder is None:
            self._start(self._index.threads)
        for approach in (self._step, self._seek, self._seek_one_by_one, self._restart):
            if approach(number) and (frame := self._decode_until(number)) is not None:
                return frame
        place = f"frame {number * self._per_frame + 1} of {len(self)}"
        raise ClipError(f"{place} cannot be decoded: {self._path}")

    def _step(self, number: int) -> bool:
        return 0 < number - self._at <= STEP_LIMIT

    def _seek(self, number: int) -> bool:
        import av

        if self._index.is_counted or self._decoder is None:
            return False
        container, stream = self._decoder
        try:
            container.seek(self._index.stamps[number], stream=stream)
        except (av.error.FFmpegError, OSError):
            return False
        self._frames = decoded(container, stream)
        self._recent = {}
        return True

    def _give_up(self) -> None:
        from av.video.reformatter import VideoReformatter

        if self._close is not None:
            self._close()
        # The stream alone keeps the decoder's threads and frames; the reformatter has threads of its own.
        self._decoder, self._frames, self._recent = None, iter(()), {}
        self._reformatter = VideoReformatter()

    def _seek_one_by_one(self, number: int) -> bool:
        """Near damage a decoder of several threads loses frames that one of a single thread shows."""
        if self._index.is_counted:
            return False
        self._start("SLICE")
        return self._seek(number)

    def _restart(self, number: int) -> bool:
        self._start(self._index.threads)
        return True

    def _start(self, threads: Threads) -> None:
        self._give_up()
        container = open_container(self._path)
        # Containers and their streams hold each other, and a decoder its threads and pictures: whoever drops
        # a video gives all of it back at once, and not when garbage is next searched for, which may be never.
        self._close = weakref.finalize(self, container.close)
        self._close.atexit = False
        stream = video_stream(container, self._path, threads)
        self._decoder, self._frames, self._at = (container, stream), decoded(container, stream), -1

    def _decode_until(self, number: int) -> VideoFrame | None:
        """The wanted frame; None where it is not among those that come."""
        for frame in self._frames:
            at = self._at + 1 if self._index.is_counted else self._place.get(frame.pts or 0)
            if at is None:
                continue
            self._at = at
            self._recent[at] = frame
            if len(self._recent) > RECENT:
                del self._recent[next(iter(self._recent))]
            if at >= number:
                return frame if at == number else None
        return None

    def _oddities(self, first: VideoFrame) -> Iterator[str]:
        """One sentence for each property that a person might not expect."""
        if self._index.is_cut:
            yield cut_off(len(self._index.stamps), self._index.announced)
        if (last := self._index.last_size) and last != self._size:
            (width, height), others = self._size, f"{last[0]}x{last[1]}"
            yield f"frames at the end are {others}, not {width}x{height} as the first one, and cannot be read"
        if not self._index.is_steady:
            rate = f"{self.frames_per_second:.3g}"
            yield f"the frame rate varies, {rate} frames per second on average; frame times are kept"
        if self._index.is_interlaced:
            yield INTERLACED[self._deinterlacing]
        if abs(self.pixel_aspect - 1) > UNSEEN:
            ratio = f"{self.pixel_aspect:.3g}"
            yield f"pixels are {ratio} times as wide as high; exported images keep the stored pixels"
        if (bits := bits_of(first)) > 8:
            yield f"the video has {bits} bits a colour; it is read with 8"
        if transfer := HDR.get(first.color_trc):
            yield f"the video is HDR ({transfer}); it is read without tone mapping and looks flat"
