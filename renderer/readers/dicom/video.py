"""Frames of a DICOM object that holds them one by one, as a video has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from renderer.clip import ByteImage, ClipError
from renderer.readers.byte_levels import in_bytes
from renderer.readers.cut_off import cut_off
from renderer.readers.dicom.header import read_header
from renderer.readers.dicom.pixels import read_pixels, whole_frames


class DicomVideo:
    """Frames by number, in any order and from any thread: each is read from the file when asked for.

    Raises:
        ClipError: as `read_header`; or none of its frames is whole.
    """

    stereo = None
    """DICOM does not say whether frames hold both eyes."""

    def __init__(self, path: Path) -> None:
        self._path, self.header = path, read_header(path)
        self._count = whole_frames(path, self.header)
        if not self._count:
            raise ClipError(f"expected a DICOM file with frames, got none that is whole: {path}")
        self.pixel_aspect = self.header.pixel_aspect
        times = self.header.frame_times
        self.frame_times = None if times is None or len(times) < self._count else times[: self._count]
        self.notices = tuple(self._oddities())

    def __len__(self) -> int:
        return self._count

    @property
    def frames_per_second(self) -> float | None:
        if self.frame_times is None or self._count < 2:
            return self.header.frames_per_second
        return (self._count - 1) / self.frame_times[-1]

    def read(self, index: int) -> ByteImage:
        """(H, W, 3) RGB. Raises ClipError when the frame is damaged."""
        stored = read_pixels(self._path, self.header, index)
        byte = in_bytes(stored) if stored.dtype.itemsize > 1 else stored.astype(np.uint8)
        return np.repeat(byte[:, :, None], 3, axis=2) if byte.ndim == 2 else byte

    def _oddities(self) -> list[str]:
        announced = self.header.frames
        return [cut_off(self._count, announced)] if self._count < announced else []
