"""`.spz` of version 3, which every reader of the format opens, and 4; see spz.py for what the planes hold."""

from __future__ import annotations

import gzip
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.harmonics import BANDS
from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.splat_files import spz_streams
from renderer.splat_files.packed_ply import without_largest
from renderer.splat_files.splat_file import coefficients_of
from renderer.splat_files.spz import ANTIALIASED, COLOR_SCALE, HEAD, MAGIC, MOST
from renderer.splat_files.y_up import y_up
from renderer.splats import RenderMode

VERSION: Final = 3
LEVEL: Final = 12
"""Of Zstandard, beyond which files hardly shrink."""
FINEST: Final = 20
"""After the point of a position, and with them at most 23 in all."""
SIZES: Final = (-10.0, 255 / 16 - 10, 1 / 16)
"""Logarithms: the least, the largest, and how far apart those are that the format holds."""
HARMONICS: Final = (-1.0, 127 / 128, 1 / 128)
"""The same of coefficients; and of those of the colour."""
COLORS: Final = (-0.5 / COLOR_SCALE, 0.5 / COLOR_SCALE, 1 / 255 / COLOR_SCALE)
Plane = NDArray[np.uint8]


def clipped(raw: RawGaussians) -> tuple[str, ...]:
    """What is beyond what the format holds, and is written as the nearest that it does, in words."""
    least, largest = (f"{np.exp(end):.3g}" for end in SIZES[:2])
    told = (
        (raw.log_scales, SIZES, f"sizes are beyond {least} to {largest}"),
        (coefficients_of(raw.colors), COLORS, "values of colours are beyond -0.44 to 1.44"),
        (raw.harmonics, HARMONICS, "values of colours by direction are beyond -1 to 1"),
    )
    counted = ((_beyond(values, *held), values.size, said) for values, held, said in told)
    return tuple(
        f"{count} of {size} {said}, which SPZ does not hold: they are clipped"
        for count, size, said in counted
        if count
    )


def _beyond(values: NDArray[Any], least: float, most: float, step: float) -> int:
    """How many are farther out than rounding moves them."""
    return int(((values < least - step / 2) | (values > most + step / 2)).sum())


def spz_bytes(raw: RawGaussians, mode: RenderMode = "default") -> bytes:
    """What `read_spz` gives back to half a step: sizes, from 4.5e-5 to 370, to 3 %, opacities to 1 / 510,
    harmonics, from -1 to 1, to 1 / 256; positions to 1 / 4,000,000 of the farthest coordinate, or 5e-7.
    `clipped` says what is beyond.

    Raises:
        ValueError: more splats than the format takes, or one farther away than it can say.
    """
    bits, planes = _planes(raw)
    head = HEAD.pack(MAGIC, VERSION, len(raw), _degree(raw), bits, _flags(mode), 0)
    # Without a time, so that one model gives one file.
    return gzip.compress(head + b"".join(planes), mtime=0)


def spz_streams_bytes(raw: RawGaussians, mode: RenderMode = "default") -> bytes:
    """The same of version 4: a stream a plane, each zipped with Zstandard; those without bytes are left out.

    Raises:
        ValueError: as `spz_bytes`.
    """
    import zstandard

    bits, planes = _planes(raw)
    told = [plane for plane in planes if plane]
    streams = [zstandard.ZstdCompressor(LEVEL).compress(plane) for plane in told]
    flags = _flags(mode)
    head = spz_streams.HEAD.pack(
        MAGIC, spz_streams.VERSION, len(raw), _degree(raw), bits, flags, len(told), spz_streams.HEAD.size
    )
    sizes = zip(streams, told, strict=True)
    table = b"".join(spz_streams.SIZES.pack(len(stream), len(plane)) for stream, plane in sizes)
    return head + table + b"".join(streams)


def _planes(raw: RawGaussians) -> tuple[int, list[bytes]]:
    """Bits after the point of positions, and what `spz.unpacked` takes apart."""
    farthest = float(np.abs(raw.means).max(initial=0))
    bits = int(min(FINEST, 22 - np.floor(np.log2(max(farthest, 1e-9)))))
    if len(raw) > MOST or bits < 0:
        raise ValueError(
            f"expected up to {MOST} splats nearer than {1 << 23} for SPZ, "
            f"got {len(raw)} as far as {farthest:.3g}"
        )
    raw = y_up(raw)
    planes = (
        _positions(raw.means, bits),
        _bytes(255.0 * sigmoid(raw.opacity_logits)),
        _bytes(255 * (coefficients_of(raw.colors) * COLOR_SCALE + 0.5)),
        _bytes(16 * (raw.log_scales + 10.0)),
        _rotations(raw.quats[:, [1, 2, 3, 0]]),
        _bytes(128 * (raw.harmonics.astype(np.float64) + 1)),
    )
    return bits, [plane.tobytes() for plane in planes]


def _degree(raw: RawGaussians) -> int:
    return BANDS.index(raw.harmonics.shape[1])


def _flags(mode: RenderMode) -> int:
    return ANTIALIASED if mode == "mip" else 0


def _bytes(values: NDArray[Any]) -> Plane:
    return np.asarray(np.clip(np.rint(values), 0, 255), np.uint8)


def _positions(means: NDArray[np.float32], bits: int) -> Plane:
    """24 bits each, the lowest byte first."""
    most = (1 << 23) - 1
    whole = np.clip(np.rint(means.astype(np.float64) * (1 << bits)), -most, most).astype("<i4")
    return np.ascontiguousarray(whole[..., None]).view(np.uint8)[..., :3]


def _rotations(quats: NDArray[np.float32]) -> Plane:
    """Of x, y, z, w."""
    given, largest = without_largest(quats)
    words = largest.astype(np.uint32)
    for part in given.T:
        size = np.minimum(np.rint(np.abs(part) / np.sqrt(0.5) * 511), 511).astype(np.uint32)
        words = words << 10 | (part < 0).astype(np.uint32) << 9 | size
    return words.astype("<u4").view(np.uint8)
