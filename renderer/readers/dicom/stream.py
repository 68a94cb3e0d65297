"""The video in a DICOM object as a file to read from, where it lies: nothing is copied."""

from __future__ import annotations

import io
import struct
from bisect import bisect_right
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path
from typing import Final

from renderer.readers.dicom.header import DicomHeader, read_header
from renderer.regular_files import require_regular

ITEM: Final = b"\xfe\xff\x00\xe0"
EXPLICIT: Final = 12
"""Bytes before the value of an element, with an explicit type and a long length."""


def fragments(path: Path, header: DicomHeader) -> Iterator[tuple[int, int]]:
    """Where each fragment of the pixels begins and how many bytes it has, as far as the file goes.

    Raises OSError.
    """
    length = require_regular(path)
    return ((start, min(size, length - start)) for start, size in _announced(path, header) if start < length)


def ends_early(path: Path) -> bool:
    """Whether a fragment reaches past the end of the file. Raises as `read_header`, and OSError."""
    length = require_regular(path)
    return any(start + size > length for start, size in _announced(path, read_header(path)))


def _announced(path: Path, header: DicomHeader) -> Iterator[tuple[int, int]]:
    """Where each fragment begins and how many bytes it should have.

    The first item of all is no fragment: it lists where frames begin.
    """
    length = require_regular(path)
    with path.open("rb") as file:
        at, is_first = header.pixels_at + EXPLICIT, True
        while at + 8 <= length:
            file.seek(at)
            tag, size = struct.unpack("<4sI", file.read(8))
            if tag != ITEM:
                return
            if not is_first:
                yield at + 8, size
            at, is_first = at + 8 + size, False


class StreamFile(io.RawIOBase):
    """Its fragments one behind the other.

    Raises:
        ClipError, OSError: see `read_header`; or the file is gone.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        header = read_header(path)
        self._parts = tuple(fragments(path, header))
        rate = header.frames_per_second
        self.rate: dict[str, str] = {} if rate is None else {"framerate": f"{rate:.6g}"}
        """Of a stream that does not tell times itself, as FFmpeg takes it."""
        self._starts = tuple(accumulate((size for _, size in self._parts), initial=0))
        self._file = path.open("rb")
        self._at = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._at

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        origin = {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._starts[-1]}[whence]
        self._at = max(origin + offset, 0)
        return self._at

    def read(self, size: int = -1) -> bytes:
        """Up to the end of the fragment at most."""
        number = bisect_right(self._starts, self._at) - 1
        if number >= len(self._parts):
            return b""
        start, length = self._parts[number]
        within = self._at - self._starts[number]
        left = length - within
        self._file.seek(start + within)
        found = self._file.read(left if size < 0 else min(size, left))
        self._at += len(found)
        return found

    def close(self) -> None:
        if not self.closed and hasattr(self, "_file"):
            self._file.close()
        super().close()
