"""`.spz` of version 4 (Niantic): the planes of version 3, each zipped by itself with Zstandard.

Layout: the program of https://github.com/nianticlabs/spz, as github.com/sparkjsdev/spark/pull/332 tells it. A
header of 32 bytes says where the table of streams begins, of two 64-bit sizes each, zipped and whole; the
streams follow it. Before the table, makers may add what they like. Harmonics may be of degree 4.
"""

from __future__ import annotations

import io
import struct
from dataclasses import replace
from typing import Final

import numpy as np

from renderer.budget import budget
from renderer.harmonics import BANDS
from renderer.splat_files.other_kinds import CONVERT
from renderer.splat_files.splat_file import FUNCTIONS, SplatFile, SplatFileError, repaired
from renderer.splat_files.spz import ANTIALIASED, MOST_BITS, Head, unpacked

VERSION: Final = 4
HEAD: Final = struct.Struct("<IIIBBBBI12x")
SIZES: Final = struct.Struct("<QQ")
LEAST_WINDOW: Final = 1 << 23
"""Bytes that every decoder of Zstandard has to grant."""


def read_spz_streams(content: bytes) -> SplatFile:
    """The Gaussians. No more is unzipped than the header asks for.

    Raises:
        SplatFileError: another version, or a damaged file.
        OverBudget: too many splats.
    """
    if len(content) < HEAD.size:
        raise SplatFileError("expected a header of splats, got a file that is cut off")
    _, version, count, degree, bits, flags, streams, table = HEAD.unpack_from(content)
    if version != VERSION:
        raise SplatFileError(
            f"expected an SPZ file of version 1 to {VERSION}, got version {version}: {CONVERT}"
        )
    if degree >= len(FUNCTIONS) or bits > MOST_BITS:
        raise SplatFileError(
            f"expected splats of degree 0 to 4 with up to {MOST_BITS} bits after the point, "
            f"got degree {degree} with {bits}"
        )
    budget().require(splats=count)
    head = Head(VERSION, count, FUNCTIONS[degree], bits, flags)
    wanted = [width * count for width in head.widths if width * count]
    if streams < len(wanted) or table + SIZES.size * streams > len(content):
        raise SplatFileError(
            f"expected {len(wanted)} streams, got {streams} in {len(content)} bytes: cut off"
        )
    start = table + SIZES.size * streams
    planes = []
    for place, size in enumerate(wanted):
        zipped, whole = SIZES.unpack_from(content, table + SIZES.size * place)
        if whole != size or start + zipped > len(content):
            raise SplatFileError(f"expected a stream of {size} bytes, got {whole}: damaged or cut off")
        planes.append(_unzipped(content[start : start + zipped], size))
        start += zipped
    return _file(head, planes)


def _file(head: Head, planes: list[bytes]) -> SplatFile:
    """Without harmonics above degree 3, which nothing here draws."""
    degree = FUNCTIONS.index(head.bands)
    if head.bands > BANDS[-1]:
        if planes:
            rest = np.frombuffer(planes[-1], np.uint8).reshape(head.count, head.bands, 3)
            planes[-1] = rest[:, : BANDS[-1]].tobytes()
        head = replace(head, bands=BANDS[-1])
    return repaired(
        unpacked(head, b"".join(planes)), "mip" if head.flags & ANTIALIASED else "default", degree
    )


def _unzipped(content: bytes, size: int) -> bytes:
    try:
        import zstandard
    except ImportError as error:
        raise SplatFileError(f"SPZ 4 needs the package zstandard: install it, or {CONVERT}") from error
    unzip = zstandard.ZstdDecompressor(max_window_size=max(LEAST_WINDOW, 2 * size))
    try:
        with unzip.stream_reader(io.BytesIO(content)) as stream:
            plane: bytes = stream.read(size)
    except zstandard.ZstdError as error:
        raise SplatFileError("expected zipped splats, got a damaged file") from error
    if len(plane) < size:
        raise SplatFileError(f"expected a stream of {size} bytes, got {len(plane)}: cut off")
    return plane
