"""What an image file carries beside its pixels: a text, as iTXt in a PNG, comments in a JPEG and the
description in a TIFF; and the ICC profile of its colours."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from typing import Final

from renderer.file_signatures import PNG_SIGNATURE

KEYWORD: Final = "vesselsplat"
PNG_TEXT: Final = KEYWORD.encode() + b"\0\0\0\0\0"
JPEG_START: Final = b"\xff\xd8"
APP0, APP2, SCAN, COMMENT = 0xE0, 0xE2, 0xDA, 0xFE
JPEG_TEXT: Final = KEYWORD.encode() + b"\0"
LONGEST_COMMENT: Final = 65533 - len(JPEG_TEXT)
"""Bytes; a longer text goes on in the next one."""
TIFF_ORDERS: Final = {b"II*\0": "<", b"MM\0*": ">"}
JPEG_PROFILE: Final = b"ICC_PROFILE\0"
LONGEST_PROFILE: Final = 65533 - len(JPEG_PROFILE) - 2
"""Bytes of one part, of which each has its number and their count before it."""
DESCRIPTION, ASCII = 270, 2
PROFILE, UNDEFINED = 34675, 7
TIFF_TEXT: Final = KEYWORD.encode() + b" "


def carrying(suffix: str, content: bytes, text: str, profile: bytes) -> bytes:
    """The image file with the text in it, of ASCII in a TIFF; `suffix` is one of CARRIERS. Without a profile
    its colours are those of sRGB."""
    return CARRIERS[suffix.lower()](content, text.encode(), profile)


def carried(content: bytes) -> bytes | None:
    """The provenance that VesselSplat wrote into an image file; None where there is none."""
    try:
        if content.startswith(PNG_SIGNATURE):
            return next(_png_texts(content), None)
        if content.startswith(JPEG_START):
            return b"".join(_jpeg_comments(content)) or None
        return _tiff_text(content) if content[:4] in TIFF_ORDERS else None
    except (struct.error, IndexError):
        return None  # It ends too early.


def _png(content: bytes, text: bytes, profile: bytes) -> bytes:
    """Behind the header, with the profile, or the tag of sRGB, rendering intent 0: perceptual."""
    end = len(PNG_SIGNATURE) + 25
    named = b"ICC profile\0\0" + zlib.compress(profile)
    colours = _chunk(b"iCCP", named) if profile else _chunk(b"sRGB", b"\0")
    return content[:end] + colours + _chunk(b"iTXt", PNG_TEXT + text) + content[end:]


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def _png_texts(content: bytes) -> Iterator[bytes]:
    at = len(PNG_SIGNATURE)
    while at + 12 <= len(content):
        (length,) = struct.unpack_from(">I", content, at)
        body = content[at + 8 : at + 8 + length]
        if content[at + 4 : at + 8] == b"iTXt" and body.startswith(PNG_TEXT):
            yield body.removeprefix(PNG_TEXT)
        at += 12 + length


def _jpeg(content: bytes, text: bytes, profile: bytes) -> bytes:
    """Behind the header of JFIF, which has to come first."""
    colours = _parts(profile, LONGEST_PROFILE)
    bodies = [
        *(
            (APP2, JPEG_PROFILE + bytes((at, len(colours))) + part)
            for at, part in enumerate(colours, start=1)
        ),
        *((COMMENT, JPEG_TEXT + part) for part in _parts(text, LONGEST_COMMENT)),
    ]
    added = b"".join(struct.pack(">BBH", 0xFF, kind, 2 + len(body)) + body for kind, body in bodies)
    end = next((at + 2 + length for kind, at, length in _segments(content) if kind == APP0), 2)
    return content[:end] + added + content[end:]


def _parts(whole: bytes, length: int) -> list[bytes]:
    return [whole[at : at + length] for at in range(0, len(whole), length)]


def _segments(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Kind, place of the length, and length of all that comes before the pixels."""
    at = len(JPEG_START)
    while at + 4 <= len(content):
        mark, kind, length = struct.unpack_from(">BBH", content, at)
        if mark != 0xFF or kind == SCAN:
            return
        yield kind, at, length
        at += 2 + length


def _jpeg_comments(content: bytes) -> Iterator[bytes]:
    for kind, at, length in _segments(content):
        body = content[at + 4 : at + 2 + length]
        if kind == COMMENT and body.startswith(JPEG_TEXT):
            yield body.removeprefix(JPEG_TEXT)


def _tiff(content: bytes, text: bytes, profile: bytes) -> bytes:
    """A directory at the end in place of the first one: the same entries, the description and the profile."""
    order, entries, following = _directory(content)
    added = [(DESCRIPTION, ASCII, TIFF_TEXT + text + b"\0"), (PROFILE, UNDEFINED, profile)]
    body, made = b"", list[bytes]()
    for tag, kind, value in added:
        if value:
            made.append(struct.pack(f"{order}HHII", tag, kind, len(value), len(content) + len(body)))
            body += value
            body += b"\0" * (-(len(content) + len(body)) % 2)
    kept = [one for one in entries if _tag(order, one) not in (DESCRIPTION, PROFILE)]
    all_of_them = sorted((*kept, *made), key=lambda one: _tag(order, one))
    directory = struct.pack(f"{order}H", len(all_of_them)) + b"".join(all_of_them) + following
    start = struct.pack(f"{order}I", len(content) + len(body))
    return content[:4] + start + content[8:] + body + directory


def _tag(order: str, entry: bytes) -> int:
    return int(struct.unpack_from(f"{order}H", entry)[0])


def _directory(content: bytes) -> tuple[str, list[bytes], bytes]:
    """Order of bytes, entries of 12 bytes each, and where the next directory is."""
    order = TIFF_ORDERS[content[:4]]
    (at,) = struct.unpack_from(f"{order}I", content, 4)
    (count,) = struct.unpack_from(f"{order}H", content, at)
    end = at + 2 + 12 * count
    return order, [content[place : place + 12] for place in range(at + 2, end, 12)], content[end : end + 4]


def _tiff_text(content: bytes) -> bytes | None:
    order, entries, _ = _directory(content)
    for entry in entries:
        tag, kind, length, at = struct.unpack(f"{order}HHII", entry)
        body = content[at : at + length]
        if (tag, kind) == (DESCRIPTION, ASCII) and body.startswith(TIFF_TEXT):
            return body.removeprefix(TIFF_TEXT).rstrip(b"\0")
    return None


CARRIERS: Final[dict[str, Callable[[bytes, bytes, bytes], bytes]]] = {
    ".png": _png, ".jpg": _jpeg, ".jpeg": _jpeg, ".tif": _tiff, ".tiff": _tiff
}  # fmt: skip
