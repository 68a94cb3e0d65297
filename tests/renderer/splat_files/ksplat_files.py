""".ksplat files for tests, packed splat by splat by the words of the format alone."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from itertools import pairwise

from renderer.raw_gaussians import RawGaussians

WHOLE = 32767
BLOCK = 8.0
DEGREES = {0: 0, 3: 1, 8: 2, 15: 3}
ENDS = (0, 3, 8, 15)


def head(
    sections: int,
    count: int,
    level: int,
    rest: tuple[float, float] = (0, 0),
    version: tuple[int, int] = (0, 1),
) -> bytes:
    numbers = struct.pack("<BBHIIIIHH", *version, 0, sections, sections, count, count, level, 0)
    return (numbers + struct.pack("<5f", 0, 0, 0, *rest)).ljust(4096, b"\0")


def section(
    raw: RawGaussians, level: int, rest: tuple[float, float], in_bucket: int, whole: int, room: int = 0
) -> tuple[bytes, bytes]:
    """Header and content. Buckets are of splats in their order, of `in_bucket`, the last two of fewer."""
    lengths = lengths_of(len(raw), in_bucket) if level else []
    full = sum(length == in_bucket for length in lengths)
    bands = raw.harmonics.shape[1]
    partial = lengths[full:]
    numbers = struct.pack(
        "<IIIIfHHIIIIH", len(raw), len(raw) + room, in_bucket if level else 0, len(lengths),
        BLOCK if level else 0, 12 if level else 0, 0, whole if level else 0, 0, full, len(partial),
        DEGREES[bands],
    )  # fmt: skip
    content = struct.pack(f"<{len(partial)}I", *partial)
    records, centres, start = b"", b"", 0
    for length in lengths or [len(raw)]:
        inside = range(start, start + length)
        centre = tuple(
            (min(float(raw.means[place][axis]) for place in inside) + 0.1) if length else 0.0
            for axis in range(3)
        )
        centre = struct.unpack("<3f", struct.pack("<3f", *centre))
        centres += struct.pack("<3f", *centre) if level else b""
        for place in inside:
            records += record(raw, place, level, rest, centre, whole or WHOLE)
        start += length
    size = {0: 44, 1: 24, 2: 24}[level] + 3 * bands * {0: 4, 1: 2, 2: 1}[level]
    return numbers.ljust(1024, b"\0"), content + centres + records + bytes(size * room)


def lengths_of(count: int, in_bucket: int) -> list[int]:
    full, left = divmod(count, in_bucket)
    return [in_bucket] * full + [part for part in (left // 2, left - left // 2) if part]


def record(
    raw: RawGaussians, place: int, level: int, rest: tuple[float, float], centre: Sequence[float], whole: int
) -> bytes:
    plain = "f" if level == 0 else "e"
    mean = [float(value) for value in raw.means[place]]
    sizes = [math.exp(float(value)) for value in raw.log_scales[place]]
    packed = struct.pack("<3f", *mean)
    if level:
        steps = [
            round((value - middle) / (BLOCK / 2 / whole)) + whole
            for value, middle in zip(mean, centre, strict=True)
        ]
        packed = struct.pack("<3H", *steps)
    packed += struct.pack(f"<3{plain}4{plain}", *sizes, *map(float, raw.quats[place]))
    alpha = 255 / (1 + math.exp(-float(raw.opacity_logits[place])))
    packed += bytes(round(255 * min(max(float(value), 0), 1)) for value in raw.colors[place])
    packed += bytes([round(alpha)])
    bands = raw.harmonics.shape[1]
    for start, end in pairwise(ENDS):
        for color in range(3):
            for band in range(start, min(end, bands)):
                value = float(raw.harmonics[place][band][color])
                if level == 2:
                    low, high = rest if any(rest) else (-1.5, 1.5)
                    share = min(max((value - low) / (high - low), 0), 1)
                    packed += bytes([round(255 * share)])
                else:
                    packed += struct.pack("<f" if level == 0 else "<e", value)
    return packed


def ksplat(
    *parts: RawGaussians,
    level: int = 0,
    rest: tuple[float, float] = (0, 0),
    in_bucket: int = 4,
    whole: int = 0,
    room: int = 0,
) -> bytes:
    """A section for each part."""
    made = [section(part, level, rest, in_bucket, whole, room) for part in parts]
    start = head(len(parts), sum(map(len, parts)), level, rest)
    return start + b"".join(each[0] for each in made) + b"".join(each[1] for each in made)
