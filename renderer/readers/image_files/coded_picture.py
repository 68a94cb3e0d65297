"""HEIC, AVIF and JPEG 2000 as Pillow's readers see a picture: FFmpeg decodes them, through PyAV."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from PIL import Image, ImageFile

from renderer.clip import ClipError
from renderer.pyav_presence import has_pyav
from renderer.readers.misnamed import BRANDS
from renderer.regular_files import require_regular

if TYPE_CHECKING:
    from PIL._imaging import PixelAccess

CODED: Final = frozenset({".avif", ".heic", ".heif", ".jp2"})
"""Suffixes of such files; of those with several images the first counts among the images of a folder."""
JPEG_2000: Final = b"\x00\x00\x00\x0cjP  "
BOXES: Final = b"ftyp"
GROUPS, STEREO = b"grpl", b"ster"
COLORS: Final = b"colrprof"
"""Before the ICC profile of an image in HEIC and AVIF. Source: ISO/IEC 14496-12, 12.1.5."""
BEFORE_PIXELS: Final = 1 << 16
"""Bytes of a file within which it tells how its image is turned, its colours, and which images belong
together."""
QUARTERS: Final = re.compile(rb"\x00\x00\x00\x09irot(.)", re.DOTALL)
"""The turn of an image in HEIC and AVIF, in quarters. Source: ISO/IEC 23008-12, 6.5.10."""


def is_coded(path: Path) -> bool:
    """Whether a file of such a name is one by its first bytes, and PyAV is there: others are misnamed."""
    head = _head(path, 12) if path.suffix.lower() in CODED else b""
    return (head.startswith(JPEG_2000) or head[4:8] == BOXES) and has_pyav()


def is_coded_still(path: Path) -> bool:
    """Whether a file of any name holds one such image, by its first bytes: sequences have other ones."""
    head = _head(path, 12)
    return head.startswith(JPEG_2000) or (head[4:8] == BOXES and head[8:12] in BRANDS)


def is_stereo_pair(path: Path) -> bool:
    """Whether such a file says that two of its images are those of the left and of the right eye, as spatial
    photos do. Source: ISO/IEC 23008-12, entity group 'ster'."""
    head = _head(path, BEFORE_PIXELS) if path.suffix.lower() in CODED else b""
    return STEREO in _box(head, GROUPS)


def _box(head: bytes, name: bytes) -> bytes:
    """What follows the name in the first box that begins so; empty where that does not end within."""
    at = head.find(name)
    end = at - 4 + int.from_bytes(head[max(at - 4, 0) : max(at, 0)])
    return head[at + len(name) : end] if at >= 4 and end <= len(head) else b""


def _head(path: Path, count: int) -> bytes:
    """Empty of what cannot be read."""
    try:
        require_regular(path)
        with path.open("rb") as file:
            return file.read(count)
    except OSError:
        return b""


class CodedPicture(ImageFile.ImageFile):
    """Of several images the first; upright.

    Raises:
        ClipError: it is damaged, or has too many pixels; when its pixels are asked for, as PyAvVideo.
    """

    format = "HEIF"
    format_description = "HEIC, AVIF or JPEG 2000"

    def __init__(self, path: Path) -> None:
        self._path, self._is_loaded = path, False
        super().__init__(path)

    def _open(self) -> None:
        from renderer.readers.video_decoding.video_index import decoded, open_container, video_stream
        from renderer.readers.video_decoding.video_shape import lies_down

        head = _head(self._path, BEFORE_PIXELS)
        with open_container(self._path) as container:
            stream = video_stream(container, self._path)
            self._size = stream.codec_context.width, stream.codec_context.height
            self.n_frames = max(stream.frames, 1)
            if _may_lie_down(head):
                first = next(decoded(container, stream), None)
                if first is None:
                    raise ClipError(f"expected an intact image, got one that does not decode: {self._path}")
                self._size = self._size[::-1] if lies_down(first) else self._size
        self._mode = "RGB"
        if profile := _box(head, COLORS):
            self.info["icc_profile"] = profile

    def load(self) -> PixelAccess | None:
        if not self._is_loaded:
            from renderer.readers.video_decoding.pyav_video import PyAvVideo

            self.im = Image.fromarray(PyAvVideo(self._path).read(0)).im
            self._is_loaded = True
        access: PixelAccess = self.im.pixel_access(self.readonly)
        return access


def _may_lie_down(head: bytes) -> bool:
    """Decoding tells whether it does; of most files that is spared."""
    return any(turn[0] & 1 for turn in QUARTERS.findall(head))
