"""Files of several pictures, of which one alone is read: TIFF of many pages, what is animated, both eyes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from renderer.listing import listed
from renderer.readers.image_files.coded_picture import is_stereo_pair
from renderer.readers.image_files.picture_files import BROKEN, opened

PAGED = frozenset({".tif", ".tiff", ".webp", ".png", ".dcm", ".dicom", ".avif", ""})
BESIDE: Final = "MPO"
"""The format of a JPEG with previews, which are no further images."""


def left_pages(paths: Sequence[Path]) -> Iterator[str]:
    """One sentence where files hold more than the picture that is read; their headers are looked at."""
    if pairs := [path.name for path in paths if is_stereo_pair(path)]:
        yield f"of a stereo pair one image is read, without that of the other eye: {listed(pairs)}"
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
