"""Whether two picture files that are called left and right show one scene."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from renderer.budget import OverBudget
from renderer.clip import ClipError
from renderer.depth.stereo import FEWEST_FEATURES, feature_shifts
from renderer.readers.image_files.pictures import read_rgb
from renderer.readers.image_files.used_bits import used_bits

_REMEMBERED = 32  # Opening a folder asks several times.


def may_be_one_scene(left: Path, right: Path) -> bool:
    """What cannot be read may: its reader says what is wrong."""
    try:
        return _show_one_scene(left, right, (left.stat().st_mtime_ns, right.stat().st_mtime_ns))
    except (ClipError, OverBudget, OSError):
        return True


@lru_cache(_REMEMBERED)
def _show_one_scene(left: Path, right: Path, changed: tuple[int, int]) -> bool:
    """`changed`: when the files were, so that others of the same names are looked at again. By the bits that
    they use: as stored, those of a camera of 10 or 12 are nearly black."""
    pair = left, right
    bits = used_bits(pair)
    return len(feature_shifts(*(read_rgb(path, bits) for path in pair))) >= FEWEST_FEATURES
