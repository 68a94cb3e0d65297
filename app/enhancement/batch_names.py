"""Names of outputs that lie in one folder: all different, on disks too that know no letter case."""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence
from itertools import chain, count
from pathlib import Path
from typing import Final

from app.enhancement.dicom_files import is_dicom_name
from app.files.codecs import MP4, ending_of
from app.files.image_files import is_image

STILL: Final = (".png", ".tiff")
FILM: Final = (MP4, f"{MP4}.json")
"""What may stand behind the name of an output; a video's record is beside it."""


def alike(name: str) -> str:
    """The same for names that may be one on some disk."""
    return unicodedata.normalize("NFC", name.casefold())


def free_name(wanted: str, endings: Sequence[str], taken: set[str]) -> str:
    """`wanted`, or with the first number from 2 on with which none of its files is taken; then all are."""
    names = chain((wanted,), (f"{wanted}-{number}" for number in count(2)))
    own = next(name for name in names if taken.isdisjoint(alike(name + ending) for ending in endings))
    taken.update(alike(own + ending) for ending in endings)
    return own


def free_folder(wanted: str, taken: set[str]) -> str:
    """The same for a folder; one that is called like a file would be written as that."""
    path = Path(wanted)
    is_like_a_file = is_image(path) or is_dicom_name(path) or ending_of(path)
    return free_name(f"{wanted}-images" if is_like_a_file else wanted, ("",), taken)
