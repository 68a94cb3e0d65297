"""What a video file says of itself, with few of its frames decoded."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from renderer.clip import ByteImage, ClipError
from renderer.pyav_presence import has_pyav
from renderer.readers.clip_options import StereoLayout
from renderer.readers.dicom.header import DicomHeader, holds_stream, read_header
from renderer.readers.dicom.opening import is_dicom
from renderer.readers.image_files.file_kinds import require_moving

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.video.stream import VideoStream

QUICKLY_READ: Final = 256_000_000
"""Bytes of a file that is read in a few seconds, wherever it lies."""


@dataclass(frozen=True)
class VideoHeader:
    """As announced: what decodes may be less."""

    size: tuple[int, int]
    """Width and height in pixels of a picture that stands upright."""
    frames: int | None
    frames_per_second: float | None
    """On average where some are left out, as in a video of variable rate."""
    seconds: float | None = None
    codec: str | None = None
    """As FFmpeg calls it, or DICOM; None where PyAV is not installed, which tells it and what follows."""
    bits: int = 8
    """Of a colour, of which 8 are read."""
    sound: str | None = None
    """Codec of the first sound track."""
    is_interlaced: bool = False
    pixel_aspect: float = 1.0
    """Width of a pixel by its height."""
    stereo: StereoLayout | None = None
    """How both eyes lie in its frames, where it says so."""
    is_steady: bool = True
    """Whether frames come evenly, as far as that is known."""
    is_announced: bool = True
    """Whether the number of frames, and with it their rate, is what the file states, and not what decodes."""
    is_cut: bool = False
    """Whether the end of the file is missing or damaged, as far as the frames were counted."""
    announced: int = 0
    """Frames that the file states where they were counted; 0: it does not, or they were not."""


def read_video_header(path: Path) -> VideoHeader:
    """Raises ClipError: the file is no video, or its path is not UTF-8, which the decoder cannot take."""
    if is_dicom(path) and not (told := read_header(path)).is_stream:
        return _of_frames(told, told.frames)
    return _by_pyav(path) if has_pyav() else _by_opencv(path)


def read_counted_header(path: Path) -> VideoHeader:
    """With the frames and their rate as the reader finds them, where the file tells them quickly.

    Raises ClipError as `read_video_header`, for a DICOM object of which no frame is whole, and for an image.
    """
    if not holds_stream(path):
        return _counted(path)
    header = read_video_header(path)
    if not has_pyav() or path.stat().st_size > QUICKLY_READ:
        return header
    from renderer.readers.video_decoding.video_index import told_index

    if (index := told_index(path)) is None:
        return header
    frames, rate = len(index.stamps), float(index.frames_per_second)
    require_moving(path, frames)
    return replace(
        header,
        frames=frames,
        frames_per_second=rate,
        seconds=frames / rate,
        is_steady=index.is_steady,
        is_announced=False,
        is_cut=index.is_cut,
        announced=index.announced,
    )


def first_frame(path: Path) -> ByteImage | None:
    """(H, W, 3) RGB, as stored, of a video of any length at once; None where it does not decode.

    Raises ClipError as `read_video_header`.
    """
    if not holds_stream(path):
        from renderer.readers.dicom.video import DicomVideo

        return DicomVideo(path).read(0)
    if has_pyav():
        from renderer.readers.video_decoding.video_index import decoded, open_container, video_stream

        with open_container(path) as container:
            first = next(decoded(container, video_stream(container, path)), None)
            return None if first is None else np.asarray(first.to_ndarray(format="rgb24"), np.uint8)
    import cv2

    from renderer.readers.video_decoding.opencv_video import open_capture

    there, frame = open_capture(path).read()
    return np.asarray(cv2.cvtColor(frame, cv2.COLOR_BGR2RGB), np.uint8) if there else None


def _counted(path: Path) -> VideoHeader:
    """Of a DICOM object that holds its frames one by one, those that are whole."""
    from renderer.readers.dicom.video import DicomVideo

    video = DicomVideo(path)
    told, found = video.header, len(video)
    is_cut = found < told.frames
    return replace(_of_frames(told, found), is_announced=False, is_cut=is_cut, announced=told.frames)


def _of_frames(told: DicomHeader, frames: int) -> VideoHeader:
    """Of a DICOM object that holds its frames one by one, so many."""
    from pydicom.uid import UID

    rate = told.frames_per_second
    seconds = frames / rate if rate else None
    kind = UID(told.transfer_syntax).name
    return VideoHeader(told.size, frames, rate, seconds, kind, pixel_aspect=told.pixel_aspect)


def _by_pyav(path: Path) -> VideoHeader:
    from renderer.readers.video_decoding.stereo_layout import told_layout
    from renderer.readers.video_decoding.video_index import decoded, open_container, rate_of, video_stream
    from renderer.readers.video_decoding.video_shape import bits_of, lies_down, pixel_aspect

    with open_container(path) as container:
        stream = video_stream(container, path)
        first = next(decoded(container, stream), None)
        if first is None:
            raise ClipError(f"expected a video, got a file without a frame that decodes: {path}")
        lies = lies_down(first)
        rate, seconds = rate_of(stream), _seconds(stream, container)
        sounds = container.streams.audio
        return VideoHeader(
            size=(first.height, first.width) if lies else (first.width, first.height),
            frames=stream.frames or None,
            frames_per_second=None if rate is None else _kept_rate(float(rate), stream.frames, seconds),
            seconds=seconds,
            codec=stream.codec_context.codec.canonical_name,
            bits=bits_of(first),
            sound=sounds[0].codec_context.codec.canonical_name if sounds else None,
            is_interlaced=first.interlaced_frame,
            pixel_aspect=float(pixel_aspect(stream, first)),
            stereo=told_layout(first),
        )


def _seconds(stream: VideoStream, container: InputContainer) -> float | None:
    """Of the pictures where the file says it; sound may last longer."""
    if stream.duration and stream.time_base:
        return float(stream.duration * stream.time_base)
    if not container.duration:
        return None
    # Matroska tells when its last frame ends, however late its first one is.
    before = max(container.start_time or 0, 0) if "matroska" in container.format.name else 0
    return (container.duration - before) / 1e6


def _kept_rate(rate: float, frames: int, seconds: float | None) -> float:
    """The mean where the file holds fewer frames than its rate makes in that time, but for rounding."""
    return frames / seconds if frames and seconds and frames < rate * seconds - 1.5 else rate


def _by_opencv(path: Path) -> VideoHeader:
    import cv2

    from renderer.readers.video_decoding.opencv_video import open_capture, rate_of

    capture = open_capture(path)
    try:
        names = cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FRAME_COUNT
        width, height, frames = (int(capture.get(name)) for name in names)
        rate = rate_of(capture)
    finally:
        capture.release()
    seconds = frames / rate if rate and frames > 0 else None
    return VideoHeader((width, height), frames if frames > 0 else None, rate, seconds)
