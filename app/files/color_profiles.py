"""The ICC profile of an image, which says what its numbers look like, for what is made of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from numpy.typing import NDArray

from app.files.embedded import CARRIERS
from renderer.readers.image_files.file_kinds import is_frame
from renderer.readers.image_files.picture_files import BROKEN, opened

KINDS: Final = {b"GRAY": (1,), b"RGB ": (3, 4)}
"""Channels that a profile's numbers may have, by what its header says at KIND."""
KIND: Final = slice(16, 20)
LARGEST: Final = 1 << 22
"""Bytes; what is larger describes no colours of a screen or camera."""

HOLDING: Final = frozenset({*CARRIERS, ".webp"})
"""Suffixes of files that are written with a profile."""
USUAL: Final = (b"sRGB", "sRGB".encode("utf-16-be"))
"""In the description of a profile of the colours that a file without one has."""


def loses_profile(output: Path, source: Path, image: NDArray[Any]) -> bool:
    """Whether the colours of an `image`, as those in the file `source`, are shown as others in a file named
    `output`, since that holds no profile."""
    profile = b"" if output.suffix.lower() in HOLDING else profile_of(source, image)
    return bool(profile) and not any(name in profile for name in USUAL)


def profile_of(path: Path, image: NDArray[Any]) -> bytes:
    """The profile in a file, for an `image` made of its numbers; empty without one, or where it is of other
    numbers, as of the inks of a print."""
    if not path.is_file() or not is_frame(path):
        return b""
    try:
        with opened(path) as picture:
            profile = bytes(picture.info.get("icc_profile") or b"")
    except BROKEN:
        return b""
    channels = 1 if image.ndim == 2 else image.shape[2]
    fits = channels in KINDS.get(profile[KIND], ()) and len(profile) <= LARGEST
    return profile if fits else b""
