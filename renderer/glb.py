"""Binary glTF 2.0 as a container: the JSON, and the bytes behind it."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any, Final

from renderer.json_files import parsed

MAGIC: Final = b"glTF"
VERSION: Final = 2
HEAD: Final = struct.Struct("<4sII")
CHUNK: Final = struct.Struct("<I4s")
JSON, BINARY = b"JSON", b"BIN\0"
SHAPES: Final[Mapping[int, str]] = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
"""What arrays of so many columns are called."""
WIDTHS: Final[Mapping[str, int]] = {shape: width for width, shape in SHAPES.items()}
SPLATS: Final = "KHR_gaussian_splatting"
"""The extension of Khronos for Gaussian splats."""


class GlbError(ValueError):
    """It is no binary glTF 2.0, or not whole."""


def glb(text: bytes, binary: bytes) -> bytes:
    """A file of JSON and bytes, each filled up to whole words."""
    chunks = b"".join(
        CHUNK.pack(len(content), kind) + content
        for kind, content in (
            (JSON, text + b" " * (-len(text) % 4)),
            (BINARY, binary + bytes(-len(binary) % 4)),
        )
    )
    return HEAD.pack(MAGIC, VERSION, HEAD.size + len(chunks)) + chunks


def opened_glb(content: bytes) -> tuple[Any, bytes]:
    """The JSON, of whatever kind, and the bytes behind it, none where there are none.

    Raises:
        GlbError: another version, no JSON, or a file that is cut off.
        ValueError: JSON that cannot be read.
    """
    if len(content) < HEAD.size + CHUNK.size:
        raise GlbError("expected a glTF file, got one that is cut off")
    magic, version, length = HEAD.unpack_from(content)
    if (magic, version) != (MAGIC, VERSION):
        raise GlbError(f"expected binary glTF {VERSION}.0, got version {version}")
    size, kind = CHUNK.unpack_from(content, HEAD.size)
    if length > len(content) or kind != JSON:
        raise GlbError("expected a glTF file, got one that is cut off or begins without JSON")
    start = HEAD.size + CHUNK.size
    document, start = parsed(content[start : start + size].decode()), start + size
    if start + CHUNK.size > len(content):
        return document, b""
    size, kind = CHUNK.unpack_from(content, start)
    start += CHUNK.size
    return document, content[start : start + size] if kind == BINARY else b""


def length_of(content: bytes) -> int:
    """Bytes of a file that could be opened, as it states."""
    return int(HEAD.unpack_from(content)[2])
