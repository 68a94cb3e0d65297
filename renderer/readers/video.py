"""A video file as a clip without depth."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from renderer.clip import ByteImage, Clip
from renderer.pyav_presence import has_pyav, why_not_pyav
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.readers.frames import without_depth


class Video(Protocol):
    """Frames by number, in any order and from any thread."""

    @property
    def frames_per_second(self) -> float | None: ...
    @property
    def frame_times(self) -> tuple[float, ...] | None: ...
    @property
    def pixel_aspect(self) -> float: ...
    @property
    def notices(self) -> tuple[str, ...]: ...

    def __len__(self) -> int: ...
    def read(self, index: int) -> ByteImage: ...


def open_video(path: Path, options: ClipOptions = DEFAULTS) -> Clip:
    """A video file; its frames are those that decode, not those that the header announces.

    Raises:
        ClipError: the file is no video, or OpenCV alone is at hand and cannot read this one.
    """
    video = _opened(path, options)
    image = video.read(0)
    return without_depth(
        path,
        "video",
        labels=tuple(str(index) for index in range(len(video))),
        size=(image.shape[1], image.shape[0]),
        read=video.read,
        field_of_view=options.field_of_view,
        frames_per_second=video.frames_per_second,
        frame_times=video.frame_times,
        pixel_aspect=video.pixel_aspect,
        notices=(*video.notices, *filter(None, (why_not_pyav(),))),
    )


def _opened(path: Path, options: ClipOptions) -> Video:
    if has_pyav():
        from renderer.readers.pyav_video import PyAvVideo

        return PyAvVideo(path, options.deinterlacing)
    from renderer.readers.opencv_video import OpenCvVideo

    return OpenCvVideo(path)
