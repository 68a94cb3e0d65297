"""A video file as a clip without depth: its frames, or the left eye's pictures in them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import numpy as np

from renderer.clip import ByteImage, Clip, ClipError, numbered
from renderer.pyav_presence import has_pyav, why_not_pyav
from renderer.readers.clip_options import DEFAULTS, ClipOptions, StereoLayout
from renderer.readers.dicom.header import holds_stream
from renderer.readers.image_files.file_kinds import require_moving
from renderer.readers.image_folders.frames import assumed_camera
from renderer.readers.new_clip import new_clip
from renderer.readers.video_decoding.stereo_layout import (
    HALVES,
    chosen_layout,
    eye_aspect,
    eye_size,
    eyes,
    likely_layout,
    squeezed,
)


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
    @property
    def stereo(self) -> StereoLayout | None: ...

    def __len__(self) -> int: ...
    def read(self, index: int) -> ByteImage: ...


def open_video(path: Path, options: ClipOptions = DEFAULTS) -> Clip:
    """A video file; its frames are those that decode, not those that the header announces.

    Of frames that hold both eyes, the left ones are the clip's, and `Clip.read_right` gives the others.

    Raises:
        ClipError: the file is no video, but perhaps an image; or OpenCV alone is there and cannot read this
            one; or its frames cannot be split into eyes as `options.stereo` asks.
    """
    video = _opened(path, options)
    require_moving(path, len(video))
    layout, first = chosen_layout(options.stereo, video.stereo), video.read(0)
    size = first.shape[1], first.shape[0]
    if layout is None:
        clip = _clip(path, options, video, video.read, size, video.pixel_aspect)
        hint = eyes_hint(first) if options.stereo == "auto" else ""
        return replace(clip, notices=(*clip.notices, hint)) if hint else clip
    try:
        size = eye_size(size, layout)
    except ClipError as error:
        raise ClipError(f"{error}: {path}") from error
    aspect = eye_aspect(size, layout, video.pixel_aspect)
    left = _clip(path, options, video, lambda index: _eye(video.read(index), layout, 0), size, aspect)
    said = f"stereo, {layout}: the frames are those of the left eye"
    said += squeezed(size, layout, video.pixel_aspect)
    return replace(
        left,
        read_right=lambda index: _eye(video.read(numbered(index, len(video))), layout, 1),
        notices=(*left.notices, said),
    )


def eyes_hint(first: ByteImage) -> str:
    """What a person should decide whose frames look like those of two eyes; else nothing."""
    layout = likely_layout(first)
    if layout is None:
        return ""
    way = f"set Eyes (--stereo {layout})"
    return f"the {HALVES[layout]} of a frame look alike; if they are the two eyes, {way}"


def _eye(image: ByteImage, layout: StereoLayout, number: int) -> ByteImage:
    return np.ascontiguousarray(eyes(image, layout)[number])


def _clip(
    path: Path,
    options: ClipOptions,
    video: Video,
    read: Callable[[int], ByteImage],
    size: tuple[int, int],
    aspect: float,
) -> Clip:
    clip = new_clip(
        path,
        "video",
        cameras=(assumed_camera(options.view_angle, size, aspect),) * len(video),
        labels=tuple(str(index) for index in range(len(video))),
        read_image=read,
        notices=(*video.notices, *filter(None, (why_not_pyav(),))),
    )
    rate, times = video.frames_per_second, video.frame_times
    return replace(clip, frames_per_second=rate, frame_times=times, pixel_aspect=aspect)


def _opened(path: Path, options: ClipOptions) -> Video:
    if not holds_stream(path):
        from renderer.readers.dicom.video import DicomVideo

        return DicomVideo(path)
    if has_pyav():
        from renderer.readers.video_decoding.pyav_video import PyAvVideo

        return PyAvVideo(path, options.deinterlacing)
    from renderer.readers.video_decoding.opencv_video import OpenCvVideo

    return OpenCvVideo(path)
