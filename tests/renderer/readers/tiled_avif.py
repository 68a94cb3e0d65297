"""AVIF images of two tiles beside each other, as cameras of telephones write HEIC."""

from __future__ import annotations

import io
import struct
from pathlib import Path

from PIL import Image


def tiled(path: Path, tile: Image.Image) -> Path:
    """The tile twice. Source: ISO/IEC 23008-12, 6.6.2.3 (image grid)."""
    stored = io.BytesIO()
    tile.save(stored, "AVIF")
    whole = stored.getvalue()
    data = whole[whole.index(b"mdat") + 4 :]
    size = _full(b"ispe", struct.pack(">II", *tile.size))
    both = _full(b"ispe", struct.pack(">II", 2 * tile.width, tile.height))
    shares = b"".join(struct.pack(">HBBB", item, 2, 0x81, 2) for item in (1, 2))
    ipma = _full(b"ipma", struct.pack(">I", 3) + shares + struct.pack(">HBB", 3, 1, 3))
    described = _box(b"iprp", _box(b"ipco", _found(whole, b"av1C") + size + both) + ipma)
    grid = struct.pack(">BBBBHH", 0, 0, 0, 1, 2 * tile.width, tile.height)
    brand = _box(b"ftyp", b"avif" + bytes(4) + b"avifmif1")
    first = len(brand) + len(_meta(0, len(data), len(grid), described)) + 8
    meta = _meta(first, len(data), len(grid), described)
    path.write_bytes(brand + meta + _box(b"mdat", data + grid))
    return path


def _meta(first: int, length: int, grid: int, described: bytes) -> bytes:
    places = ((1, first, length), (2, first, length), (3, first + length, grid))
    listed = b"".join(struct.pack(">HHHII", item, 0, 1, at, size) for item, at, size in places)
    kinds = ((1, b"av01"), (2, b"av01"), (3, b"grid"))
    items = b"".join(_full(b"infe", struct.pack(">HH", item, 0) + kind + b"\0", 2) for item, kind in kinds)
    content = (
        _full(b"hdlr", bytes(4) + b"pict" + bytes(13)),
        _full(b"pitm", struct.pack(">H", 3)),
        _full(b"iloc", bytes((0x44, 0)) + struct.pack(">H", 3) + listed),
        _full(b"iinf", struct.pack(">H", 3) + items),
        _full(b"iref", _box(b"dimg", struct.pack(">HHHH", 3, 2, 1, 2))),
        described,
    )
    return _full(b"meta", b"".join(content))


def _found(whole: bytes, kind: bytes) -> bytes:
    at = whole.index(kind) - 4
    return whole[at : at + struct.unpack_from(">I", whole, at)[0]]


def _box(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", 8 + len(content)) + kind + content


def _full(kind: bytes, content: bytes, version: int = 0) -> bytes:
    return _box(kind, struct.pack(">I", version << 24) + content)
