"""The ICC profile of an image, which says what its numbers look like, for what is made of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from numpy.typing import NDArray

from renderer.readers.image_files.picture_files import opened
from renderer.readers.image_files.pictures import BROKEN, is_frame

KINDS: Final = {b"GRAY": (1,), b"RGB ": (3, 4)}
"""Channels that a profile's numbers may have, by what its header says at KIND."""
KIND: Final = slice(16, 20)
LARGEST: Final = 1 << 22
"""Bytes; what is larger describes no colours of a screen or camera."""


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
