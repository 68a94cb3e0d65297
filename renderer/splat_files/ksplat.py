"""`.ksplat` (Mark Kellogg's GaussianSplats3D, version 0.1): sections of splats, one record after the other.

Layout: `SplatBuffer.js` of https://github.com/mkkellogg/GaussianSplats3D. A header of 4096 bytes, one of 1024
for each section, then the sections: lengths of buckets that are not full, centres of buckets, records. At
compression level 0 numbers are floats; at levels 1 and 2 positions are 16 bits about the centre of their
bucket, sizes and rotations (w first) half floats; harmonics are half floats at level 1, bytes at level 2.
Colour and opacity are bytes; harmonics stand by degree, all of red before green and blue. Values are those of
a PLY file.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.budget import budget
from renderer.harmonics import BANDS
from renderer.raw_gaussians import RawGaussians, joined, logits
from renderer.splat_files.other_kinds import CONVERT
from renderer.splat_files.splat_file import SplatFile, SplatFileError, repaired

HEAD: Final = struct.Struct("<BBxxIIIIHxx12xff")
HEAD_SIZE: Final = 4096
SECTION: Final = struct.Struct("<IIIIfHxxIIIIH")
SECTION_SIZE: Final = 1024
BUCKET_SIZE: Final = 12
WHOLE_RANGE: Final = 32767
"""Of 16-bit positions on either side of a centre, where a section says nothing else."""
REST_RANGE: Final = 1.5
"""Of harmonics as bytes, likewise."""
FORMS: Final = (("<f4", "<f4", "<f4"), ("<u2", "<f2", "<f2"), ("<u2", "<f2", "u1"))
"""By level: of positions, of sizes and rotations, and of harmonics."""


@dataclass(frozen=True)
class _Head:
    sections: int
    count: int
    level: int
    rest: tuple[float, float]
    """Harmonics that the bytes 0 and 255 stand for."""


@dataclass(frozen=True)
class _Section:
    """In the order of its header."""

    count: int
    most: int
    """Records that there is room for."""
    in_bucket: int
    buckets: int
    block: float
    """Side of the cube about a centre."""
    bucket_size: int
    whole: int
    size: int
    full: int
    partial: int
    degree: int

    def record(self, level: int) -> np.dtype[Any]:
        place, plain, rest = FORMS[level]
        return np.dtype([
            ("mean", place, 3), ("scale", plain, 3), ("quat", plain, 4), ("color", "u1", 4),
            ("rest", rest, (3 * BANDS[self.degree],)),
        ])  # fmt: skip

    @property
    def before(self) -> int:
        """Bytes before its records."""
        return 4 * self.partial + self.bucket_size * self.buckets


def read_ksplat(content: bytes) -> SplatFile:
    """The Gaussians. No more is set aside than the file has bytes for.

    Raises:
        SplatFileError: another version, or a damaged file.
        OverBudget: too many splats.
    """
    head = _head(content)
    sections = list(_sections(content, head))
    count = sum(section.count for section in sections)
    if count != head.count:
        raise SplatFileError(f"expected {head.count} splats, got {count} in the sections: damaged")
    if not sections:
        raise SplatFileError("expected sections, got none")
    at = HEAD_SIZE + SECTION_SIZE * head.sections
    parts = []
    for section in sections:
        parts.append(_unpacked(content, at, section, head))
        at += section.before + section.record(head.level).itemsize * section.most
    return repaired(joined(parts))


def _head(content: bytes) -> _Head:
    if len(content) < HEAD_SIZE:
        raise SplatFileError(f"expected a header of {HEAD_SIZE} bytes, got {len(content)}: cut off")
    major, minor, sections, _, _, count, level, low, high = HEAD.unpack_from(content)
    if major != 0 or minor < 1 or level >= len(FORMS):
        raise SplatFileError(
            f"expected a .ksplat file of version 0.1 and compression level 0 to {len(FORMS) - 1}, "
            f"got version {major}.{minor} and level {level}: {CONVERT}"
        )
    if HEAD_SIZE + SECTION_SIZE * sections > len(content):
        raise SplatFileError(f"expected headers of {sections} sections, got {len(content)} bytes: cut off")
    budget().require(splats=count)
    return _Head(sections, count, level, (low or -REST_RANGE, high or REST_RANGE))


def _sections(content: bytes, head: _Head) -> Iterator[_Section]:
    """The sections of a file; raises SplatFileError where one does not fit into it."""
    end = HEAD_SIZE + SECTION_SIZE * head.sections
    for place in range(head.sections):
        section = _Section(*SECTION.unpack_from(content, HEAD_SIZE + SECTION_SIZE * place))
        if section.degree >= len(BANDS) or section.count > section.most:
            raise SplatFileError(
                f"expected up to {section.most} splats of degree 0 to {len(BANDS) - 1}, "
                f"got {section.count} of degree {section.degree}: damaged"
            )
        if section.buckets and section.bucket_size != BUCKET_SIZE:
            raise SplatFileError(
                f"expected centres of {BUCKET_SIZE} bytes, got {section.bucket_size}: damaged"
            )
        end += section.before + section.record(head.level).itemsize * section.most
        if end > len(content):
            raise SplatFileError(f"expected sections of {end} bytes or more, got {len(content)}: cut off")
        yield section


def _unpacked(content: bytes, at: int, section: _Section, head: _Head) -> RawGaussians:
    rows = np.frombuffer(content, section.record(head.level), section.count, at + section.before)
    means = rows["mean"].astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if head.level:
            whole = section.whole or WHOLE_RANGE
            means = (means - whole) * (section.block / 2 / whole) + _centres(content, at, section)
        scales = np.log(rows["scale"].astype(np.float64))
        rest = rows["rest"].astype(np.float64)
        if head.level == len(FORMS) - 1:
            rest = head.rest[0] + rest / 255 * (head.rest[1] - head.rest[0])
        return RawGaussians(
            means=means.astype(np.float32),
            quats=rows["quat"].astype(np.float32),
            log_scales=scales.astype(np.float32),
            opacity_logits=logits(rows["color"][:, 3] / 255),
            colors=(rows["color"][:, :3] / 255).astype(np.float32),
            harmonics=_by_function(rest.astype(np.float32), section.degree),
        )


def _centres(content: bytes, at: int, section: _Section) -> NDArray[np.float64]:
    """(N, 3), of the bucket that each splat is in: first those that are full."""
    lengths = np.frombuffer(content, "<u4", section.partial, at).astype(np.int64)
    centres = np.frombuffer(content, "<f4", 3 * section.buckets, at + 4 * section.partial).reshape(-1, 3)
    places = np.arange(section.count)
    in_full = min(section.full * section.in_bucket, section.count)
    later = np.searchsorted(np.cumsum(lengths), places - in_full, side="right")
    bucket = np.where(places < in_full, places // max(section.in_bucket, 1), section.full + later)
    if len(bucket) and bucket.max() >= section.buckets:
        raise SplatFileError(f"expected buckets for {section.count} splats, got {section.buckets}: damaged")
    return centres[bucket].astype(np.float64)


def _by_function(rest: NDArray[np.float32], degree: int) -> NDArray[np.float32]:
    """(N, B, 3) of (N, 3B), in which each degree has its own red, green and blue."""
    ends = BANDS[: degree + 1]
    parts = [
        rest[:, 3 * start : 3 * end].reshape(len(rest), 3, end - start).transpose(0, 2, 1)
        for start, end in pairwise(ends)
    ]
    none = np.zeros((len(rest), 0, 3), np.float32)
    return np.ascontiguousarray(np.concatenate([none, *parts], axis=1))
