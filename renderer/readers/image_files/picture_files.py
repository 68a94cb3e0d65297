"""Picture files and arrays are opened here alone: regular files, within the budget by their headers."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFile, UnidentifiedImageError

from renderer.budget import budget
from renderer.readers.dicom.opening import is_dicom
from renderer.readers.image_files.coded_picture import CodedPicture, is_coded
from renderer.readers.image_files.tiff_layouts import tiff_numbers
from renderer.regular_files import require_regular

UNREADABLE_ARRAY = (
    OSError, ValueError, EOFError, TypeError, KeyError, OverflowError, MemoryError, SyntaxError,
    RecursionError, TokenError,
)  # fmt: skip
"""What numpy's reader raises for headers that make no sense."""
BROKEN = (OSError, SyntaxError, ValueError, EOFError, Image.DecompressionBombError)
"""What `opened` raises for what is no picture, and decoding for one that is damaged."""
NONSENSE = (TypeError, KeyError, IndexError, AttributeError, OverflowError, MemoryError, struct.error)
"""What Pillow raises beside errors of its own, for a header or a chunk that is damaged."""
WIDTH_TAG, HEIGHT_TAG = 256, 257


@contextmanager
def opened(path: Path) -> Iterator[ImageFile.ImageFile]:
    """A picture whose header was read and whose pixels were not, by Pillow.

    Raises:
        OverBudget: it has too many pixels.
        OSError, ValueError, SyntaxError: it is no regular file, or no picture; or what is read of it while
            it is open is damaged. Of DICOM and of `is_coded` a ClipError, which is a ValueError, says all.
    """
    if not require_regular(path):
        raise UnidentifiedImageError(f"expected an image, got an empty file: {path}")
    try:
        with _opened(path) as picture:
            # What has a name Pillow maps into memory, and then reads grey TIFF that lies on its side wrongly.
            picture.filename = ""
            budget().require(pixels=picture.width * picture.height)
            yield picture
    except NONSENSE as error:
        raise ValueError(f"its header makes no sense: {error}".rstrip(": ")) from error


def _opened(path: Path) -> ImageFile.ImageFile:
    if is_coded(path):
        return CodedPicture(path)
    return _dicom(path) if is_dicom(path) else Image.open(path)


def _dicom(path: Path) -> ImageFile.ImageFile:
    from renderer.readers.dicom.still import DicomStill

    return DicomStill(path)


def require_size(path: Path) -> None:
    """As `opened`, for files that another decoder reads; a TIFF by its own first directory.

    Raises:
        OverBudget, OSError: see `opened`. A file that tells no size is left to its decoder.
    """
    require_regular(path)
    if (told := tiff_numbers(path, WIDTH_TAG, HEIGHT_TAG)) is not None:
        budget().require(pixels=math.prod(told))
        return
    try:
        with opened(path):
            pass
    except UnidentifiedImageError:
        pass


def read_npy(path: Path) -> NDArray[Any]:
    """The array of a .npy file, as `mapped_npy`, in memory."""
    return np.array(mapped_npy(path))


def mapped_npy(path: Path) -> NDArray[Any]:
    """The array of a .npy file where it lies, which claims no more than the file holds; objects are never
    unpickled.

    Raises:
        OSError: it is no regular file.
        ValueError: it is damaged, holds several arrays, or has more pixels than the budget.
    """
    require_regular(path)
    try:
        mapped = np.load(path, mmap_mode="r", allow_pickle=False)
    except UNREADABLE_ARRAY as error:
        raise ValueError(f"it is damaged or not an array: {path}") from error
    if not isinstance(mapped, np.ndarray):
        raise ValueError(f"it holds several arrays: {path}")
    budget().require(pixels=math.prod(mapped.shape[:2]))
    return mapped
