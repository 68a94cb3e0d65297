"""A DICOM still as Pillow's readers see a picture: size and mode by the header, pixels when asked for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image, ImageFile

from renderer.clip import ClipError
from renderer.readers.byte_levels import in_bytes
from renderer.readers.dicom.header import read_header
from renderer.readers.dicom.pixels import read_pixels

if TYPE_CHECKING:
    from PIL._imaging import PixelAccess


class DicomStill(ImageFile.ImageFile):
    """Of several frames the first; `n_frames` tells how many there are.

    Raises:
        ClipError: as `read_header`; or it is a video. When its pixels are asked for, as `read_pixels`.
    """

    format = "DICOM"
    format_description = "DICOM"

    def __init__(self, path: Path) -> None:
        self._path, self._is_loaded = path, False
        super().__init__(path)

    def _open(self) -> None:
        self._header = read_header(self._path)
        if self._header.is_stream:
            raise ClipError(f"expected an image, got a DICOM video (open it on its own): {self._path}")
        self.n_frames = self._header.frames
        self._size = self._header.size
        colored = self._header.samples == 3 or self._header.photometric == "PALETTE COLOR"
        self._mode = "RGB" if colored else "I;16" if self._header.bits_stored > 8 else "L"

    def load(self) -> PixelAccess | None:
        """Colours of more than 8 bits become 8, as Pillow has them of PNG."""
        if not self._is_loaded:
            stored = read_pixels(self._path, self._header, 0)
            if stored.ndim == 3 and stored.dtype.itemsize > 1:
                stored = in_bytes(stored)
            picture = Image.fromarray(stored)
            self._mode, self.im = picture.mode, picture.im
            self._is_loaded = True
        access: PixelAccess = self.im.pixel_access(self.readonly)
        return access
