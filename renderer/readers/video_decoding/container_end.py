"""Whether a video file ends before its own parts do, from the lengths that its container writes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

EBML = bytes.fromhex("1a45dfa3")
"""With which Matroska and WebM begin."""


def ends_early(path: Path) -> bool:
    """Whether the last part of an MP4, MOV, AVI, Matroska or WebM file reaches past the file's end.

    False for other kinds, and for files that state no length, as recorders write them that cannot go back.
    Sources: ISO/IEC 14496-12 (boxes), RIFF, RFC 8794 (EBML).
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        begin = file.read(8)
        if begin[:4] == EBML:
            parts = _elements(file)
        elif begin[:4] == b"RIFF":
            parts = _chunks(file, size)
        elif begin[4:] in (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip"):
            parts = _boxes(file, size)
        else:
            return False
        return max(parts, default=0) > size


def _boxes(file: BinaryIO, size: int) -> Iterator[int]:
    """Where each part of the first level ends, in bytes."""
    at = 0
    while size - at >= 16:
        file.seek(at)
        begin = file.read(16)
        length = int.from_bytes(begin[:4])
        if length == 1:
            length = int.from_bytes(begin[8:])
        if length < 8:
            return
        at += length
        yield at


def _chunks(file: BinaryIO, size: int) -> Iterator[int]:
    """The same: large AVI files are several of them."""
    at = 0
    while size - at >= 8:
        file.seek(at)
        begin = file.read(8)
        if begin[:4] != b"RIFF":
            return
        at += 8 + int.from_bytes(begin[4:], "little")
        yield at


def _elements(file: BinaryIO) -> Iterator[int]:
    """The same of the header and the segment that follows it, whose names take four bytes each."""
    at = 0
    for _ in range(2):
        file.seek(at + 4)
        begin = file.read(8)
        if not begin or not begin[0]:
            return
        width = 9 - begin[0].bit_length()
        bits = 7 * width
        length = int.from_bytes(begin[:width]) & ((1 << bits) - 1)
        if length == (1 << bits) - 1:
            return
        at += 4 + width + length
        yield at
