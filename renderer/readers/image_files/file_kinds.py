"""Which files are images and which are videos, by name and header."""

from __future__ import annotations

import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from pathlib import Path

from renderer.clip import ClipError
from renderer.pyav_presence import has_pyav
from renderer.readers.dicom.header import Kind, dicom_kind
from renderer.readers.dicom.opening import SUFFIXES as DICOM
from renderer.readers.dicom.opening import has_pydicom
from renderer.readers.image_files.coded_picture import CODED
from renderer.readers.image_files.picture_files import BROKEN, opened
from renderer.regular_files import require_regular

NAMED = frozenset({".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm"})
"""Suffixes of pictures and of nothing else."""

SUFFIXES = NAMED | DICOM
"""Of DICOM, some are videos, too, and many have other names: see `is_frame`."""

UNNAMED = frozenset({"PNG", "JPEG", "MPO", "BMP", "TIFF", "WEBP", "PPM"})
"""Formats, as Pillow calls them, that count without a suffix as well."""

ANIMATED = frozenset({"PNG", "WEBP"})
"""Of these, several images are a film; of a TIFF they are pages, and of an MPO, previews."""

ARRAY = ".npy"

GIF = ".gif"
"""Of an image, or of a film of several."""

VIDEOS = frozenset({".avi", ".m4v", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".mts", ".ogv", ".webm", ".wmv"})

RARER_VIDEOS = frozenset({".3gp", ".asf", ".flv", ".gif", ".m2ts", ".m2v", ".mxf", ".ts", ".vob", ".y4m"})
"""Other names of what the reader of videos opens."""

SYSTEM_FILES = frozenset({"thumbs.db", "ehthumbs.db", "desktop.ini"})
"""What a file manager leaves in folders of pictures."""


def is_visible(path: Path) -> bool:
    """Whether a person has put it there: neither hidden nor left by a file manager."""
    return not path.name.startswith(".") and path.name.lower() not in SYSTEM_FILES


def is_picture(path: Path) -> bool:
    """Whether the name is one of a visible picture file. Those of CODED are frames alone: see `is_frame`."""
    return path.suffix.lower() in SUFFIXES and not path.name.startswith(".")


def is_frame(path: Path) -> bool:
    """Whether a file is one picture of its folder: by its name, of CODED where PyAV is there to read it; a
    GIF of one image; DICOM of any name but those of others; or an image without a suffix."""
    suffix = path.suffix.lower()
    if suffix in CODED:
        return is_visible(path) and has_pyav()
    if suffix in NAMED:
        return is_picture(path)
    if suffix == GIF:
        return is_visible(path) and _is_still(path)
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
        return not (suffix == GIF and _is_still(path)) and not (suffix == ".ts" and _is_text(path))
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


def natural_key(path: Path) -> tuple[tuple[tuple[int, str], ...], str]:
    """Orders 2.jpg before 10.jpg, and 02.jpg before 2.jpg, however the system lists them."""
    parts = re.findall(r"\d+|\D+", path.name)
    return tuple((int(part), "") if part.isdecimal() else (-1, part) for part in parts), path.name


def is_array(path: Path) -> bool:
    """Whether the name is one of a visible numpy array."""
    return path.suffix.lower() == ARRAY and is_visible(path)
