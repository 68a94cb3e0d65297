"""An image file as an array, its size and what it stores; a ClipError that names it where it is none."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageFile, ImageOps, UnidentifiedImageError

from renderer.budget import OverBudget
from renderer.clip import ByteImage, ClipError
from renderer.listing import listed
from renderer.readers.byte_levels import in_bytes
from renderer.readers.image_files.file_kinds import ARRAY
from renderer.readers.image_files.orientation import UPRIGHT, upright
from renderer.readers.image_files.picture_files import BROKEN, mapped_npy, opened
from renderer.readers.image_files.tiff_layouts import TiffLayout, tiff_layout
from renderer.readers.image_files.used_bits import ALL, deep_levels, holds_deep, stretched
from renderer.readers.misnamed import barred, what_it_is
from renderer.regular_files import what_else


class SeveralSizes(ClipError):
    """Pictures that are fine one by one, and no clip together."""


def read_stored(path: Path) -> NDArray[Any]:
    """The values of a picture or .npy file as stored: of a picture (H, W) or (H, W, channels), 8 or 16 bit or
    float.

    Raises:
        ClipError: the file is missing, truncated or no picture or array.
    """
    if path.suffix.lower() == ARRAY:
        return np.array(_mapped(path))
    try:
        with opened(path) as picture:
            return np.asarray(picture.convert("RGB") if picture.mode == "P" else picture)
    except BROKEN as error:
        raise _unreadable(path, error) from error


Stored = Literal["colour", "bytes", "numbers"]
"""Several channels, one of 8 bits, or one of more bits or of floats."""


def stored_kind(path: Path) -> tuple[Stored, tuple[int, int]]:
    """What a picture or .npy file holds, by its header, and width and height.

    Raises:
        ClipError: the file is missing or no picture or array.
    """
    if path.suffix.lower() == ARRAY:
        return _array_kind(_mapped(path))
    try:
        with opened(path) as picture:
            mode, size = picture.mode, picture.size
    except BROKEN as error:
        raise _unreadable(path, error) from error
    if mode.startswith(("I", "F")):
        return "numbers", size
    return ("bytes" if mode in ("1", "L") else "colour"), size


def _mapped(path: Path) -> NDArray[Any]:
    try:
        return mapped_npy(path)
    except (OSError, ValueError) as error:
        raise ClipError(f"expected a numpy array, got an unreadable file: {path}") from error


def _array_kind(array: NDArray[Any]) -> tuple[Stored, tuple[int, int]]:
    sides = [side for side in array.shape if side > 1]
    if len(sides) != 2:
        return "colour", (1, 1)
    return ("bytes" if array.dtype.itemsize == 1 else "numbers"), (sides[1], sides[0])


def read_rgb(path: Path, bits: int = ALL) -> ByteImage:
    """(H, W, 3) uint8; grey becomes RGB, 16 bit is scaled to 8, alpha is dropped; upright, as its EXIF says.

    `bits`: that values of 16 bits use, see `used_bits`.

    Raises:
        ClipError: the file is missing, truncated, no picture, or holds floats.
    """
    try:
        if bits < ALL and holds_deep(path):
            return _of_fewer_bits(path, bits)
        layout = _readable(path)
        with opened(path) as picture:
            turned = ImageOps.exif_transpose(picture)
            if not picture.mode.startswith(("I", "F")):
                return np.array(turned.convert("RGB"), dtype=np.uint8)
            grey = np.asarray(turned)
        grey = layout.meant(grey) if layout else grey
    except BROKEN as error:
        raise _unreadable(path, error) from error
    if grey.dtype.kind == "f" or grey.min() < 0 or grey.max() > 65535:
        numbers = layout.numbers if layout else grey.dtype
        raise ClipError(f"expected an image of 8 or 16 bits, got {numbers} values: {path}")
    byte = in_bytes(grey)
    return np.repeat(byte[:, :, None], 3, axis=2)


def _of_fewer_bits(path: Path, bits: int) -> ByteImage:
    """Raises ClipError or one of BROKEN."""
    with opened(path) as picture:
        picture.load()  # OpenCV fills what a truncated file lacks without a word.
        orientation = UPRIGHT if picture.format == "TIFF" else _orientation(picture, path)
    levels = deep_levels(path)
    if levels is None:
        raise ClipError(f"expected an intact image, got a damaged file: {path}")
    byte = in_bytes(stretched(upright(levels, orientation), bits))
    return np.repeat(byte[:, :, None], 3, axis=2) if byte.ndim == 2 else byte


def _readable(path: Path) -> TiffLayout | None:
    """Of a TIFF. Raises OSError, or ClipError for one that is misread."""
    layout = tiff_layout(path) if path.is_file() else None
    if layout and layout.misread:
        raise ClipError(f"expected grey, RGB or RGBA values, got a TIFF of {layout.misread}: {path}")
    return layout


def upright_size(path: Path) -> tuple[int, int]:
    """Width and height as `read_rgb` gives them, by the header. Raises ClipError: the file is no picture."""
    try:
        with opened(path) as picture:
            return _upright_size(picture, path)
    except BROKEN as error:
        raise _unreadable(path, error) from error


def common_size(paths: Iterable[Path]) -> tuple[int, int]:
    """Width and height shared by all the pictures; only their headers are read.

    Raises:
        SeveralSizes: as the line counts.
        ClipError: a file that is no picture.
    """
    found: dict[tuple[int, int], list[Path]] = {}
    for path in paths:
        found.setdefault(upright_size(path), []).append(path)
    if not found:
        raise ClipError("expected at least one image, got none")
    (size, usual), *others = sorted(found.items(), key=lambda each: -len(each[1]))
    if others:
        raise SeveralSizes(_differing(size, usual, others))
    return size


def _differing(
    size: tuple[int, int], usual: list[Path], others: list[tuple[tuple[int, int], list[Path]]]
) -> str:
    """The sentence about pictures of several sizes: which differ, and what to do."""
    odd = [path for _, paths in others for path in paths]
    sizes = " and ".join(f"{width}x{height}" for (width, height), _ in others)
    count = f"{len(odd)} of {len(odd) + len(usual)} images ({listed([path.name for path in odd])})"
    wanted = f"expected one size, {size[0]}x{size[1]} as {usual[0].name}"
    return f"{wanted}, got {sizes}: {count}; move these elsewhere or resize all to one size: {odd[0]}"


def _upright_size(picture: ImageFile.ImageFile, path: Path) -> tuple[int, int]:
    """As `read_rgb` turns it: EXIF orientations 5 to 8 lie on their side."""
    width, height = picture.size
    if _orientation(picture, path) < 5:
        return width, height
    # Of some formats Pillow tells the size before turning, of others after it.
    rows, columns = read_rgb(path).shape[:2]
    return columns, rows


def _orientation(picture: ImageFile.ImageFile, path: Path) -> int:
    """By its EXIF."""
    # Of a PNG, Pillow decodes all pixels before it tells the EXIF, which may, but hardly does, follow them.
    whole = picture.format != "PNG" or _tells_more_after_pixels(path)
    exif = picture.getexif() if whole else Image.Image.getexif(picture)
    return int(exif.get(ExifTags.Base.Orientation, UPRIGHT))


def _tells_more_after_pixels(path: Path) -> bool:
    """Whether a PNG has anything between its pixels and its end; only the heads of its chunks are read."""
    seen = False
    with path.open("rb", buffering=0) as file:
        file.seek(8)
        while len(head := file.read(8)) == 8:
            length, kind = struct.unpack(">I4s", head)
            if kind == b"IEND":
                return False
            if seen and kind != b"IDAT":
                return True
            seen = seen or kind == b"IDAT"
            file.seek(length + 4, os.SEEK_CUR)
    return True


def _unreadable(path: Path, error: Exception) -> ClipError:
    if not path.exists():
        return ClipError(f"expected an image, got no such file: {path}")
    if isinstance(error, ClipError):
        return error
    if isinstance(error, OverBudget):
        return ClipError(f"{error}: {path}")
    if not path.is_file():
        return ClipError(f"expected an image, got {what_else(path)}: {path}")
    if isinstance(error, PermissionError):
        return ClipError(f"expected an image, got {barred(error)}: {path}")
    if isinstance(error, UnidentifiedImageError):
        return ClipError(
            f"expected an image, got {what_it_is(path) or 'a file that is not an image'}: {path}"
        )
    return ClipError(f"expected an intact image, got a damaged or truncated file ({error}): {path}")
