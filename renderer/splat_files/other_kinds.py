"""Files that hold no splats that are read here: which kind each is, and what can be done about it."""

from __future__ import annotations

import io
import zipfile
from pathlib import PurePath
from typing import Final

from renderer.file_signatures import ANYWHERE, PNG_SIGNATURE

CONVERT: Final = "convert it to .ply with SuperSplat or splat-transform"
SUFFIXES: Final = {
    ".sog": "a damaged .sog file: not a zip archive",
    ".safetensors": "a model: give the folder of its run",
}
"""What a name alone tells."""
ZIP: Final = b"PK\x03\x04"
STARTS: Final = {
    **ANYWHERE,
    PNG_SIGNATURE: "a PNG image",
    b"\xff\xd8\xff": "a JPEG image",
    b"\x28\xb5\x2f\xfd": "a zstd file: decompress it first",
}
"""First bytes of kinds that come with the wrong name."""


def named_kind(content: bytes, name: str) -> str | None:
    """What the file is in place of splats, and what to do; None where nothing tells."""
    if not content:
        return "an empty file"
    if content.startswith(ZIP):
        return _zip_kind(content)
    start = next((start for start in STARTS if content.startswith(start)), None)
    if start is None and content[:4] == b"RIFF" and content[8:12] == b"WEBP":
        return "a WebP image"
    return SUFFIXES.get(PurePath(name).suffix.lower()) if start is None else STARTS[start]


def _zip_kind(content: bytes) -> str:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, ValueError, NotImplementedError):
        return "a damaged zip archive"
    inside = next((name for name in names if name.lower().endswith(".ply")), None)
    return "a zip archive: unpack it first" + (f" and open {PurePath(inside).name}" if inside else "")
