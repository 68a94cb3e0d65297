"""Files that hold no splats that are read here: which kind each is, and what can be done about it."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path, PurePath
from types import MappingProxyType
from typing import Any, Final

from renderer.file_signatures import ANYWHERE
from renderer.json_files import parsed, read_text

CONVERT: Final = "convert it to .ply with SuperSplat or splat-transform"
SOG: Final = f"SOG: {CONVERT}"
SPLAT_SUFFIXES: Final = MappingProxyType(
    {".ksplat": f"a .ksplat file: {CONVERT}", ".sog": "a damaged .sog file: not a zip archive"}
)
"""Of splats, told by their names alone."""
SUFFIXES: Final = MappingProxyType({**SPLAT_SUFFIXES, ".safetensors": "a model: give the folder of its run"})
SOG_LIST: Final = "meta.json"
"""Ends the name of the file beside the pictures of an unpacked SOG."""
ZIP: Final = b"PK\x03\x04"
STARTS: Final = MappingProxyType(
    {
        **ANYWHERE,
        b"\x89PNG\r\n\x1a\n": "a PNG image",
        b"\xff\xd8\xff": "a JPEG image",
        b"\x28\xb5\x2f\xfd": "a zstd file: decompress it first",
        b"glTF": f"a glTF file: {CONVERT}",
    }
)
"""First bytes of kinds that come with the wrong name."""


def named_kind(content: bytes, name: str) -> str | None:
    """What the file is in place of splats, and what to do; None where nothing tells."""
    if not content:
        return "an empty file"
    if content.startswith(ZIP):
        return _zip_kind(content)
    if _is_sog_list(content, name):
        return f"the list of an unpacked {SOG}"
    start = next((start for start in STARTS if content.startswith(start)), None)
    if start is None and content[:4] == b"RIFF" and content[8:12] == b"WEBP":
        return "a WebP image"
    return SUFFIXES.get(PurePath(name).suffix.lower()) if start is None else STARTS[start]


def is_sog_list(path: Path) -> bool:
    """Whether a file is the list of an unpacked SOG, by its name and what it says."""
    try:
        return path.name.endswith(SOG_LIST) and _is_sog_list(read_text(path), path.name)
    except OSError:
        return False


def _is_sog_list(content: bytes, name: str) -> bool:
    if not name.endswith(SOG_LIST):
        return False
    try:
        said: Any = parsed(content)
    except ValueError:
        return False
    return isinstance(said, dict) and ({"means", "sh0"} <= said.keys() or "lodLevels" in said)


def _zip_kind(content: bytes) -> str:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, ValueError, NotImplementedError):
        return "a damaged zip archive"
    if any(name.endswith(SOG_LIST) for name in names):
        return SOG
    inside = next((name for name in names if name.lower().endswith(".ply")), None)
    return "a zip archive: unpack it first" + (f" and open {PurePath(inside).name}" if inside else "")
