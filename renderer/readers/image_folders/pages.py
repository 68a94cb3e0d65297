"""Files of several pictures, of which the first alone is read: TIFF of many pages, and what is animated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from renderer.readers.image_files.picture_files import opened
from renderer.readers.image_files.pictures import BROKEN
from renderer.readers.listing import listed

PAGED = frozenset({".tif", ".tiff", ".webp", ".png", ".dcm", ".dicom", ".avif", ""})
BESIDE: Final = "MPO"
"""The format of a JPEG with previews, which are no further images."""


def left_pages(paths: Iterable[Path]) -> Iterator[str]:
    """One sentence where files hold more than the picture that is read; their headers are looked at."""
    several = [f"{path.name} of {count}" for path in paths if (count := _pages(path)) > 1]
    if several:
        yield f"of a file with several images only the first is read: {listed(several)}"


def _pages(path: Path) -> int:
    if path.suffix.lower() not in PAGED:
        return 1
    try:
        with opened(path) as picture:
            return 1 if picture.format == BESIDE else int(getattr(picture, "n_frames", 1))
    except BROKEN:
        return 1
