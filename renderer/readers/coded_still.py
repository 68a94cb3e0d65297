"""One image in a file that a decoder of videos reads: HEIC, AVIF and JPEG 2000."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from renderer.clip import Clip
from renderer.readers.clip_options import FIELD_OF_VIEW, ClipOptions
from renderer.readers.image_folders.pages import left_pages
from renderer.readers.video import open_video


def open_coded_still(path: Path, field_of_view: float = FIELD_OF_VIEW) -> Clip:
    """A clip of one frame. Raises ClipError: it cannot be decoded."""
    video = open_video(path, ClipOptions(field_of_view=field_of_view, stereo="off"))
    first = video.between(0, 0)
    said = (*first.notices, *left_pages((path,)))
    alone = replace(first, frames_per_second=None, frame_times=None)
    return replace(alone, format="image", labels=(path.name,), notices=said)
