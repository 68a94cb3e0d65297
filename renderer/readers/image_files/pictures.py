"""Which files are images and which are videos, by name and header; an image file as an array, or a ClipError
that names it."""

from __future__ import annotations

import os
import re
import struct
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageFile, ImageOps, UnidentifiedImageError

from renderer.budget import OverBudget
from renderer.clip import ByteImage, ClipError
from renderer.listing import listed
from renderer.pyav_presence import has_pyav
from renderer.readers.byte_levels import in_bytes
from renderer.readers.dicom.header import Kind, dicom_kind
from renderer.readers.dicom.opening import SUFFIXES as DICOM
from renderer.readers.dicom.opening import has_pydicom
from renderer.readers.image_files.coded_picture import CODED
from renderer.readers.image_files.picture_files import mapped_npy, opened
from renderer.readers.image_files.tiff_layouts import TiffLayout, tiff_layout
from renderer.readers.misnamed import what_it_is
from renderer.regular_files import require_regular, what_else


class SeveralSizes(ClipError):
    """Pictures that are fine one by one, and no clip together."""


NAMED = frozenset({".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm"})
"""Suffixes of pictures and of nothing else."""

SUFFIXES = NAMED | DICOM
"""Of DICOM, some are videos, too, and many have other names: see `is_frame`."""

UNNAMED = frozenset({"PNG", "JPEG", "MPO", "BMP", "TIFF", "WEBP", "PPM"})
"""Formats, as Pillow calls them, that count without a suffix as well."""

ANIMATED = frozenset({"PNG", "WEBP"})
"""Of these, several images are a film; of a TIFF they are pages, and of an MPO, previews."""

ARRAY = ".npy"

VIDEOS = frozenset({".avi", ".m4v", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".mts", ".ogv", ".webm", ".wmv"})

RARER_VIDEOS = frozenset({".3gp", ".asf", ".flv", ".gif", ".m2ts", ".m2v", ".mxf", ".ts", ".vob", ".y4m"})
"""Other names of what the reader of videos opens."""

SYSTEM_FILES = frozenset({"thumbs.db", "ehthumbs.db", "desktop.ini"})
"""What a file manager leaves in folders of pictures."""

BROKEN = (OSError, SyntaxError, ValueError, EOFError, Image.DecompressionBombError)


def is_visible(path: Path) -> bool:
    """Whether a person has put it there: neither hidden nor left by a file manager."""
    return not path.name.startswith(".") and path.name.lower() not in SYSTEM_FILES


def is_picture(path: Path) -> bool:
    """Whether the name is one of a visible picture file. Those of CODED are frames alone: see `is_frame`."""
    return path.suffix.lower() in SUFFIXES and not path.name.startswith(".")


def is_frame(path: Path) -> bool:
    """Whether a file is one picture of its folder: by its name, of CODED where PyAV is there to read it;
    DICOM of any name but those of others; or an image without a suffix."""
    suffix = path.suffix.lower()
    if suffix in CODED:
        return is_visible(path) and has_pyav()
    if suffix in NAMED:
        return is_picture(path)
    return _kind(path) == "image" or is_unnamed(path)


def is_unnamed(path: Path) -> bool:
    """Whether a visible file without a suffix holds one image, by its header."""
    return not path.suffix and is_visible(path) and holds_image(path)


def holds_image(path: Path) -> bool:
    """Whether a file of any name holds one image, by its header."""
    try:
        with opened(path) as picture:
            is_film = picture.format in ANIMATED and getattr(picture, "is_animated", False)
            return picture.format in UNNAMED and not is_film
    except BROKEN:
        return False


def opens(path: Path) -> bool:
    """Whether a file is a picture by its header."""
    try:
        with opened(path):
            return True
    except BROKEN:
        return False


def moves(path: Path) -> bool:
    """Whether a file is a video: by its name, but for a GIF of one image and a text named .ts; or DICOM
    that holds several frames or a video."""
    suffix = path.suffix.lower()
    if suffix in VIDEOS | RARER_VIDEOS:
        return not (suffix == ".gif" and _is_still(path)) and not (suffix == ".ts" and _is_text(path))
    return _kind(path) == "clip"


def _is_still(path: Path) -> bool:
    try:
        with opened(path) as picture:
            return not getattr(picture, "is_animated", False)
    except BROKEN:
        return False


def _is_text(path: Path) -> bool:
    """By its beginning: the tables of a stream, with which it begins, have zeros, as texts of UTF-16 have."""
    try:
        require_regular(path)
        with path.open("rb") as file:
            start = file.read(4096)
        return b"\0" not in start or start.startswith((BOM_UTF16_LE, BOM_UTF16_BE))
    except OSError:
        return False


def require_moving(path: Path, frames: int) -> None:
    """Raises ClipError: a file under the name of a video, in which so many frames were found, is an image,
    for which the decoder makes up a rate."""
    if frames == 1 and path.suffix.lower() in VIDEOS and holds_image(path):
        raise ClipError(f"expected a video, got an image: rename it to its own suffix, such as .png: {path}")


def _kind(path: Path) -> Kind | None:
    suffix = path.suffix.lower()
    looked_at = suffix in DICOM or (suffix not in NAMED | CODED | VIDEOS and has_pydicom())
    return dicom_kind(path) if looked_at and is_visible(path) else None


def natural_key(path: Path) -> tuple[tuple[int, str], ...]:
    """Orders 2.jpg before 10.jpg."""
    parts = re.findall(r"\d+|\D+", path.name)
    return tuple((int(part), "") if part.isdecimal() else (-1, part) for part in parts)


def is_array(path: Path) -> bool:
    """Whether the name is one of a visible numpy array."""
    return path.suffix.lower() == ARRAY and is_visible(path)


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


def read_rgb(path: Path) -> ByteImage:
    """(H, W, 3) uint8; grey becomes RGB, 16 bit is scaled to 8, alpha is dropped; upright, as its EXIF says.

    Raises:
        ClipError: the file is missing, truncated, no picture, or holds floats.
    """
    try:
        layout = _readable(path)
        with opened(path) as picture:
            upright = ImageOps.exif_transpose(picture)
            if not picture.mode.startswith(("I", "F")):
                return np.array(upright.convert("RGB"), dtype=np.uint8)
            grey = np.asarray(upright)
        grey = layout.meant(grey) if layout else grey
    except BROKEN as error:
        raise _unreadable(path, error) from error
    if grey.dtype.kind == "f" or grey.min() < 0 or grey.max() > 65535:
        numbers = layout.numbers if layout else grey.dtype
        raise ClipError(f"expected an image of 8 or 16 bits, got {numbers} values: {path}")
    byte = in_bytes(grey)
    return np.repeat(byte[:, :, None], 3, axis=2)


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
    # Of a PNG, Pillow decodes all pixels before it tells the EXIF, which may, but hardly does, follow them.
    whole = picture.format != "PNG" or _tells_more_after_pixels(path)
    exif = picture.getexif() if whole else Image.Image.getexif(picture)
    if exif.get(ExifTags.Base.Orientation, 1) < 5:
        return width, height
    # Of some formats Pillow tells the size before turning, of others after it.
    rows, columns = read_rgb(path).shape[:2]
    return columns, rows


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
    if isinstance(error, UnidentifiedImageError):
        return ClipError(
            f"expected an image, got {what_it_is(path) or 'a file that is not an image'}: {path}"
        )
    return ClipError(f"expected an intact image, got a damaged or truncated file ({error}): {path}")
