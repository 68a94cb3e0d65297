"""One image in a file that a decoder of videos reads: HEIC, AVIF and JPEG 2000."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

from renderer.clip import Clip
from renderer.readers.clip_options import FIELD_OF_VIEW, ClipOptions
from renderer.readers.misnamed import BRANDS
from renderer.readers.video import open_video
from renderer.regular_files import require_regular

JPEG_2000: Final = b"\x00\x00\x00\x0cjP  "


def is_coded_still(path: Path) -> bool:
    """Whether it is such a file, by its first bytes: sequences of such images have other ones."""
    try:
        require_regular(path)
        with path.open("rb") as file:
            head = file.read(12)
    except OSError:
        return False
    return head.startswith(JPEG_2000) or (head[4:8] == b"ftyp" and head[8:12] in BRANDS)


def open_coded_still(path: Path, field_of_view: float = FIELD_OF_VIEW) -> Clip:
    """A clip of one frame. Raises ClipError: it cannot be decoded."""
    video = open_video(path, ClipOptions(field_of_view=field_of_view, stereo="off"))
    first = video.every(len(video))
    return replace(first, format="image", labels=(path.name,), frames_per_second=None, frame_times=None)
