"""Picture files: one file in, one array out, or a ClipError that names the file."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageOps, UnidentifiedImageError

from renderer.clip import ByteImage, ClipError

SUFFIXES = frozenset({".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm"})

_BROKEN = (OSError, SyntaxError, ValueError, EOFError, Image.DecompressionBombError)


def is_picture(path: Path) -> bool:
    """Whether the name is one of a visible picture file."""
    return path.suffix.lower() in SUFFIXES and not path.name.startswith(".")


def natural_key(path: Path) -> tuple[tuple[int, str], ...]:
    """Orders 2.jpg before 10.jpg."""
    parts = re.findall(r"\d+|\D+", path.name)
    return tuple((int(part), "") if part.isdecimal() else (-1, part) for part in parts)


def read_stored(path: Path) -> NDArray[Any]:
    """The values as stored, (H, W) or (H, W, channels), 8 or 16 bit or float.

    Raises:
        ClipError: the file is missing, truncated or no picture.
    """
    try:
        with Image.open(path) as picture:
            return np.asarray(picture.convert("RGB") if picture.mode == "P" else picture)
    except _BROKEN as error:
        raise _unreadable(path, error) from error


def read_rgb(path: Path) -> ByteImage:
    """(H, W, 3) uint8; grey becomes RGB, 16 bit is scaled to 8, alpha is dropped; upright, as its EXIF says.

    Raises:
        ClipError: the file is missing, truncated, no picture, or holds floats.
    """
    try:
        with Image.open(path) as picture:
            if not picture.mode.startswith(("I", "F")):
                upright = ImageOps.exif_transpose(picture)
                return np.array(upright.convert("RGB"), dtype=np.uint8)
    except _BROKEN as error:
        raise _unreadable(path, error) from error
    grey = read_stored(path)
    if grey.dtype.kind == "f" or grey.min() < 0 or grey.max() > 65535:
        raise ClipError(f"expected a picture of 8 or 16 bits, got {grey.dtype} values: {path}")
    byte = ((grey.astype(np.uint32) + 128) // 257).astype(np.uint8)
    return np.repeat(byte[:, :, None], 3, axis=2)


def common_size(paths: Iterable[Path]) -> tuple[int, int]:
    """Width and height shared by all the pictures; only their headers are read.

    Raises:
        ClipError: two sizes, or a file that is no picture.
    """
    first: tuple[Path, tuple[int, int]] | None = None
    for path in paths:
        try:
            with Image.open(path) as picture:
                size = _upright_size(picture)
        except _BROKEN as error:
            raise _unreadable(path, error) from error
        first = first or (path, size)
        if size != first[1]:
            expected = f"{first[1][0]}x{first[1][1]} as {first[0].name}"
            raise ClipError(f"expected a picture of {expected}, got {size[0]}x{size[1]}: {path}")
    if first is None:
        raise ClipError("expected at least one picture, got none")
    return first[1]


def _upright_size(picture: Image.Image) -> tuple[int, int]:
    """As `read_rgb` turns it: EXIF orientations 5 to 8 lie on their side."""
    width, height = picture.size
    lies = picture.getexif().get(ExifTags.Base.Orientation, 1) >= 5
    return (height, width) if lies else (width, height)


def _unreadable(path: Path, error: Exception) -> ClipError:
    if not path.exists():
        return ClipError(f"expected a picture, got no such file: {path}")
    if isinstance(error, UnidentifiedImageError):
        return ClipError(f"expected a picture, got a file that is none: {path}")
    return ClipError(f"expected a whole picture, got a damaged or truncated file ({error}): {path}")
