"""`.spz` (Niantic, versions 1 to 3): a zipped plane of each value of all splats.

Axes are right, up, back: y and z change sign, and with them what is odd in either.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.budget import budget
from renderer.harmonics import BANDS
from renderer.raw_gaussians import RawGaussians, logits
from renderer.splat_files.other_kinds import CONVERT
from renderer.splat_files.packed_ply import smallest_three
from renderer.splat_files.splat_file import PER_COLOR, SplatFile, SplatFileError, repaired
from renderer.splat_files.y_up import y_up

GZIP: Final = b"\x1f\x8b"
MAGIC: Final = 0x5053474E
MAGIC_BYTES: Final = MAGIC.to_bytes(4, "little")
"""Of files from version 4 on, which are zipped plane by plane, the first bytes: see spz_streams.py."""
ZIPPED_PLY: Final = b"ply"
HEAD: Final = struct.Struct("<IIIBBBB")
MOST: Final = 10_000_000
"""Splats of a file, as the format has it."""
MOST_BITS: Final = 24
"""After the point of a position."""
ANTIALIASED: Final = 1
COLOR_SCALE: Final = 0.15


@dataclass(frozen=True)
class Head:
    """Of any version."""

    version: int
    count: int
    bands: int
    fraction_bits: int
    flags: int

    @property
    def widths(self) -> tuple[int, ...]:
        """Bytes a splat of each plane."""
        return (6 if self.version == 1 else 9, 1, 3, 3, 4 if self.version >= 3 else 3, 3 * self.bands)


def read_spz(content: bytes) -> SplatFile:
    """The Gaussians. No more is unzipped than the header asks for.

    Raises:
        SplatFileError: another version, too many splats, or a damaged file.
    """
    unzip = zlib.decompressobj(16 + zlib.MAX_WBITS)
    try:
        head = _head(unzip.decompress(content, HEAD.size))
        size = head.count * sum(head.widths)
        body = unzip.decompress(unzip.unconsumed_tail, size) if size else b""
    except zlib.error as error:
        raise SplatFileError("expected zipped splats, got a damaged file") from error
    if len(body) < size:
        raise SplatFileError(f"expected {head.count} splats of {size} bytes, got {len(body)}: cut off")
    return repaired(unpacked(head, body), "mip" if head.flags & ANTIALIASED else "default")


def _head(content: bytes) -> Head:
    if content.startswith(ZIPPED_PLY):
        raise SplatFileError("expected an uncompressed PLY file, got a gzip file: unzip it first")
    if len(content) < HEAD.size:
        raise SplatFileError("expected a header of splats, got a file that is cut off")
    magic, version, count, degree, bits, flags, _ = HEAD.unpack(content)
    if magic != MAGIC:
        raise SplatFileError("expected an SPZ file, got another gzip file: unzip it first")
    if version not in (1, 2, 3):
        said = f"expected a zipped SPZ file of version 1 to 3, got version {version}: {CONVERT}"
        raise SplatFileError(said)
    if count > MOST or degree >= len(BANDS) or bits > MOST_BITS:
        raise SplatFileError(
            f"expected up to {MOST} splats of degree 0 to 3 with up to {MOST_BITS} bits after the point, "
            f"got {count} of {degree} with {bits}"
        )
    budget().require(splats=count)
    return Head(version, count, BANDS[degree], bits, flags)


def unpacked(head: Head, body: bytes) -> RawGaussians:
    """The Gaussians of all planes, which lie one after the other; in the axes of this program."""
    planes, start = [], 0
    for width in head.widths:
        plane = np.frombuffer(body, np.uint8, head.count * width, start)
        planes.append(plane.reshape(head.count, width))
        start += plane.size
    positions, alphas, colors, scales, rotations, harmonics = planes
    quats = _rotations_3(rotations) if head.version >= 3 else _rotations_2(rotations)
    raw = RawGaussians(
        means=_positions(head, positions),
        quats=quats,
        log_scales=(scales / 16 - 10).astype(np.float32),
        opacity_logits=logits(alphas[:, 0] / 255),
        colors=(0.5 + PER_COLOR * (colors / 255 - 0.5) / COLOR_SCALE).astype(np.float32),
        harmonics=(harmonics.reshape(head.count, head.bands, 3) / 128 - 1).astype(np.float32),
    )
    return y_up(raw)


def _positions(head: Head, plane: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Half floats in version 1, else 24-bit numbers with a fixed point."""
    if head.version == 1:
        return plane.copy().view("<f2").astype(np.float32)
    low, middle, high = plane.reshape(-1, 3, 3).astype(np.int32).transpose(2, 0, 1)
    whole = low | middle << 8 | high << 16
    return ((whole - (whole >> 23 << 24)) / (1 << head.fraction_bits)).astype(np.float32)


def _rotations_2(plane: NDArray[np.uint8]) -> NDArray[np.float32]:
    """x, y, z as bytes about 0; w is what is left."""
    return smallest_three(plane / 127.5 - 1, np.zeros(len(plane), np.int64))


def _rotations_3(plane: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Of x, y, z, w the largest is left out; of the others the last is lowest: 9 bits and a sign each."""
    words = plane.copy().view("<u4")[:, 0]
    largest = (words >> 30).astype(np.int64)
    parts = np.stack([(words >> shift) & 0x3FF for shift in (20, 10, 0)], axis=1)
    given = (parts & 0x1FF) / 511 * np.sqrt(0.5) * np.where(parts & 0x200, -1, 1)
    return np.ascontiguousarray(smallest_three(given, largest)[:, [3, 0, 1, 2]])
