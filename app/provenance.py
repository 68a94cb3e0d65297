"""Where a picture comes from, written into it: PNG with an iTXt chunk "vesselsplat" that holds JSON.

No absolute path and no user name: a source is named by its base name and its SHA-256.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import struct
import zlib
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic_core import to_jsonable_python

from app.atomic import write_bytes
from app.errors import UserError
from renderer.depth.stereo_pairs import eye_folders
from renderer.json_files import parsed
from renderer.ply_comments import split
from renderer.readers.endonerf import FOLDERS, POSES, is_endonerf
from renderer.readers.hamlyn import is_hamlyn
from renderer.readers.picture_kinds import map_folders, photo_folder
from renderer.readers.pictures import is_picture
from renderer.readers.scared import is_scared
from renderer.readers.stereomis import is_stereomis
from renderer.readers.structure_from_motion import is_structure_from_motion
from renderer.regular_files import read_whole, require_regular

NOTICE = "Research use only. Not a medical device."
KEYWORD = "vesselsplat"
SCHEMA = 1
PIXEL_LIBRARIES = ("numpy", "numba", "opencv-contrib-python-headless", "pillow", "av")
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"

Image = NDArray[np.uint8] | NDArray[np.uint16]


def version() -> str:
    return installed_version("vesselsplat")


def strict_json(value: object, *, indent: int | None = None) -> str:
    """JSON text of numbers, arrays, dataclasses and containers of them.

    NaN and infinities become null; what is not UTF-8 in the name of a file becomes a question mark.
    """
    plain = to_jsonable_python(value, inf_nan_mode="null", fallback=_plain)
    text = json.dumps(plain, allow_nan=False, ensure_ascii=False, indent=indent)
    return text.encode(errors="replace").decode()


def comments(facts: object) -> tuple[str, ...]:
    """Short lines of ASCII for a PLY file, which takes no other text."""
    return split(KEYWORD, json.dumps(parsed(strict_json(facts))))


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"no JSON form for {type(value).__name__}")


def provenance(**facts: object) -> dict[str, Any]:
    """The given facts below what every export says: app, version, libraries, schema, UTC time, notice."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    head = {"app": "VesselSplat", "version": version(), "schema": SCHEMA, "utc": now, "notice": NOTICE}
    return head | {"libraries": dict(libraries())} | facts


def repeatable(**facts: object) -> dict[str, Any]:
    """As `provenance`, without the hour: what is drawn of a model at exact moments and poses is the same file
    every time."""
    return {name: value for name, value in provenance(**facts).items() if name != "utc"}


@cache
def libraries() -> tuple[tuple[str, str], ...]:
    """Names and versions of what pixels pass through, and the kind of processor."""
    return *((name, _installed(name)) for name in PIXEL_LIBRARIES), ("processor", platform.machine())


def _installed(name: str) -> str:
    try:
        return installed_version(name)
    except PackageNotFoundError:
        return "none"


def source(path: Path) -> dict[str, str]:
    """Base name and SHA-256 of a file or of all files of a folder."""
    return {"name": path.absolute().name, "sha256": digest(path)}


def digest(path: Path) -> str:
    """SHA-256 in hex of a file's bytes, or of the manifest (relative name, SHA-256) of a folder's files.

    Of a clip the manifest holds what its reader uses, so that a run kept inside it, or what a file manager
    leaves there, is no change; of another folder, its visible files.

    Raises OSError: there is no such file or folder, or it is something else.
    """
    if not path.is_dir():
        require_regular(path)
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    manifest = hashlib.sha256()
    for file_path in sorted(_files(path)):
        name = os.fsencode(file_path.relative_to(path).as_posix())
        manifest.update(name + f"\0{digest(file_path)}\n".encode())
    return manifest.hexdigest()


LAYOUTS = (is_scared, is_structure_from_motion, is_stereomis, is_hamlyn)
"""Whose folders hold nothing but the clip."""


def _files(folder: Path) -> list[Path]:
    """What a clip is read from; links that lead nowhere are no files."""
    if is_endonerf(folder):
        poses = folder / POSES
        parts = [folder / name for name in FOLDERS if (folder / name).is_dir()]
        return [path for part in parts for path in _pictures(part)] + [poses] * poses.is_file()
    if any(is_layout(folder) for is_layout in LAYOUTS):
        return [path for path in folder.rglob("[!.]*") if path.is_file()]
    maps = map_folders(folder)
    places = [place for place in eye_folders(folder) or (photo_folder(folder),) if place not in maps]
    found = [path for place in places for path in _pictures(place)]
    found += [path for place in maps for path in _visible(place) if is_picture(path) or path.suffix == ".npy"]
    return found or _visible(folder)


def _pictures(folder: Path) -> list[Path]:
    """The numbered ones, else all: beside a numbered picture, readers leave the others out."""
    pictures = [path for path in _visible(folder) if is_picture(path)]
    return [path for path in pictures if re.search(r"\d", path.stem)] or pictures


def _visible(folder: Path) -> list[Path]:
    return [path for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")]


def write_png(path: Path, image: Image, facts: dict[str, Any]) -> None:
    """Write atomically an (H, W), (H, W, 3) RGB or (H, W, 4) RGBA image with its provenance and sRGB tag."""
    write_bytes(path, encode_png(image, facts))


def write_sidecar(path: Path, facts: dict[str, Any]) -> None:
    """Write the provenance of a file whose format carries none beside it, as NAME.json."""
    write_bytes(path.with_name(f"{path.name}.json"), strict_json(facts, indent=2).encode())


def encode_png(image: Image, facts: dict[str, Any]) -> bytes:
    """The bytes of a PNG that carries `facts`; 8 or 16 bits a channel as the image has."""
    order = {3: cv2.COLOR_RGB2BGR, 4: cv2.COLOR_RGBA2BGRA}
    stored = cv2.cvtColor(image, order[image.shape[2]]) if image.ndim == 3 else image
    done, encoded = cv2.imencode(".png", stored)
    assert done
    plain = encoded.tobytes()
    header_end = len(PNG_SIGNATURE) + 25
    text = KEYWORD.encode() + b"\0\0\0\0\0" + strict_json(facts).encode()
    # sRGB rendering intent 0: perceptual.
    return plain[:header_end] + _chunk(b"sRGB", b"\0") + _chunk(b"iTXt", text) + plain[header_end:]


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def read_provenance(path: Path) -> dict[str, Any]:
    """The facts inside a PNG of ours. Raises UserError when there are none."""
    content = read_whole(path)
    prefix = KEYWORD.encode() + b"\0\0\0\0\0"
    position = len(PNG_SIGNATURE)
    while content.startswith(PNG_SIGNATURE) and position + 12 <= len(content):
        (length,) = struct.unpack_from(">I", content, position)
        body = content[position + 8 : position + 8 + length]
        if content[position + 4 : position + 8] == b"iTXt" and body.startswith(prefix):
            return _facts_of(body.removeprefix(prefix), path)
        position += 12 + length
    raise UserError(f"expected a PNG written by VesselSplat, found no provenance in {path.name}")


def _facts_of(text: bytes, path: Path) -> dict[str, Any]:
    try:
        facts = parsed(text)
    except ValueError as error:
        raise UserError(f"expected the JSON of a provenance ({error}): {path}") from error
    if not isinstance(facts, dict):
        raise UserError(f"expected a JSON object, got {type(facts).__name__}: {path}")
    return facts
