"""Files of splats for the tests of what reads them, packed here by the words of the formats alone."""

from __future__ import annotations

import gzip
import io
import struct
import zipfile
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import zstandard
from numpy.typing import NDArray

from renderer.raw_gaussians import RawGaussians
from renderer.splat_files import SplatFileError
from renderer.splat_files.splat_file import SplatFile

NAMES = ("x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
         "rot_0", "rot_1", "rot_2", "rot_3")  # fmt: skip


def gaussians(count: int, bands: int = 0, seed: int = 0) -> RawGaussians:
    rng = np.random.default_rng(seed)

    def normal(*shape: int) -> NDArray[np.float32]:
        return rng.standard_normal(shape).astype(np.float32)

    return RawGaussians(
        means=50 * normal(count, 3),
        quats=normal(count, 4),
        log_scales=normal(count, 3),
        opacity_logits=3 * normal(count),
        colors=rng.uniform(-0.2, 1.2, (count, 3)).astype(np.float32),
        harmonics=0.3 * normal(count, bands, 3),
    )


def ply(fields: dict[str, NDArray[Any]], order: str = "<", kind: str = "f4") -> bytes:
    """A file with one element, in any byte order ("=" is text) and type."""
    layout = {"<": "binary_little_endian", ">": "binary_big_endian", "=": "ascii"}[order]
    said = {"f4": "float", "f8": "double"}[kind]
    count = len(next(iter(fields.values())))
    head = ["ply", f"format {layout} 1.0", f"element vertex {count}"]
    head += [*(f"property {said} {name}" for name in fields), "end_header", ""]
    rows = np.stack(list(fields.values()), axis=1)
    text = "\n".join(" ".join(repr(float(value)) for value in row) for row in rows)
    body = text.encode() if order == "=" else rows.astype(order + kind).tobytes()
    return "\n".join(head).encode() + body


def word(shares: Sequence[float], widths: Sequence[int]) -> int:
    """Shares of [0, 1] as whole numbers of so many bits, the first on top."""
    out = 0
    for share, width in zip(shares, widths, strict=True):
        out = out << width | round(share * ((1 << width) - 1))
    return out


def packed_ply(rows: Sequence[tuple[int, int, int, int]], bounds: Sequence[float], sh: bytes = b"") -> bytes:
    """Words of splats, the 18 bounds of each chunk one after the other, and 9 bytes of harmonics a splat."""
    names = [f"{end}_{name}" for end in ("min", "max") for name in ("x", "y", "z")]
    names += [f"{end}_scale_{name}" for end in ("min", "max") for name in ("x", "y", "z")]
    names += [f"{end}_{name}" for end in ("min", "max") for name in ("r", "g", "b")]
    words = ("packed_position", "packed_rotation", "packed_scale", "packed_color")
    head = ["ply", "format binary_little_endian 1.0", f"element chunk {len(bounds) // 18}"]
    head += [f"property float {name}" for name in names]
    head += [f"element vertex {len(rows)}", *(f"property uint {name}" for name in words)]
    if sh:
        head += [f"element sh {len(sh) // 9}", *(f"property uchar f_rest_{place}" for place in range(9))]
    body = np.array(bounds, "<f4").tobytes() + np.array(rows, "<u4").tobytes() + sh
    return "\n".join([*head, "end_header", ""]).encode() + body


def spz(
    version: int, degree: int, planes: Sequence[bytes], *, count: int, bits: int = 12, flags: int = 0
) -> bytes:
    head = struct.pack("<IIIBBBB", 0x5053474E, version, count, degree, bits, flags, 0)
    return gzip.compress(head + b"".join(planes), mtime=0)


def spz_streams(
    degree: int, planes: Sequence[bytes], *, count: int, bits: int = 12, flags: int = 0, extra: bytes = b""
) -> bytes:
    """Version 4, with what a maker adds before the table."""
    streams = [zstandard.ZstdCompressor().compress(plane) for plane in planes]
    head = struct.pack(
        "<IIIBBBBI12x", 0x5053474E, 4, count, degree, bits, flags, len(planes), 32 + len(extra)
    )
    table = b"".join(
        struct.pack("<QQ", len(stream), len(plane)) for stream, plane in zip(streams, planes, strict=True)
    )
    return head + extra + table + b"".join(streams)


def zipped(*names: str) -> bytes:
    """An archive of files with these names."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name in names:
            archive.writestr(name, "{}")
    return file.getvalue()


def at(content: bytes, place: int, form: str, value: float) -> bytes:
    """The content with another value at a place, in a form of the module struct."""
    changed = bytearray(content)
    struct.pack_into(f"<{form}", changed, place, value)
    return bytes(changed)


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    out = bytearray(content)
    for _ in range(rng.integers(1, 4)):
        at = int(rng.integers(len(out) if rng.random() < 0.4 else max(len(out) // 4, 1)))
        match rng.integers(4):
            case 0:
                out[at] = rng.integers(256)
            case 1:
                del out[at : at + int(rng.integers(1, 30))]
            case 2:
                out[at:at] = out[at : at + int(rng.integers(1, 30))]
            case _:
                out[at : at + 1] = str(rng.choice([0, 1, 9, 2**31, 10**13])).encode()
        if not out:
            break
    return bytes(out)


def is_refused(read: Callable[..., SplatFile], *given: Any) -> bool:
    """In one line; else all values of what is read are finite."""
    try:
        got = read(*given)
    except SplatFileError as error:
        said = str(error)
    else:
        assert all(np.isfinite(value).all() for value in got.raw.arrays().values())
        return False
    assert "\n" not in said
    return True
