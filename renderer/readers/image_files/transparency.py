"""What of an image file is fully transparent: nothing is seen there, whatever colour is stored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from PIL import ImageOps

from renderer.clip import BoolImage, Clip, ClipError, Frame, numbered, within
from renderer.evenly import evenly
from renderer.readers.image_files.picture_files import BROKEN, opened

LOOKED_AT: Final = 9
"""Evenly spread images of a folder."""
SAID: Final = "fully transparent pixels count as outside of the tissue"


def visible(path: Path) -> BoolImage | None:
    """(H, W), upright, False where alpha is 0; None of a file without transparency.

    Raises:
        ClipError: the file is missing or no intact image.
    """
    try:
        with opened(path) as picture:
            if not picture.has_transparency_data:
                return None
            turned = ImageOps.exif_transpose(picture)
            return np.asarray(turned.convert("RGBA").getchannel("A")) > 0
    except BROKEN as error:
        raise ClipError(f"expected an intact image, got a damaged one ({error}): {path}") from error


def hides_some(paths: Sequence[Path]) -> bool:
    """Whether a pixel of some of these, evenly spread, is fully transparent; damaged files tell nothing."""
    return any(_hides_some(path) for path in evenly(paths, LOOKED_AT))


def where_visible(clip: Clip, files: Sequence[Path]) -> Clip:
    """The clip, of which these are the frames' files, where what is fully transparent is no tissue."""
    if not any(_may_hide(path) for path in evenly(files, LOOKED_AT)):
        return clip

    def read_visible(index: int) -> BoolImage | None:
        return visible(files[numbered(index, len(files))])

    def read_frame(index: int) -> Frame:
        kept = read_visible(index)
        return clip.read_frame(index) if kept is None else within(clip.read_frame(index), kept)

    said = (f"{SAID} (--alpha ignored takes them for tissue)",) if hides_some(files) else ()
    return replace(clip, read_frame=read_frame, read_visible=read_visible, notices=(*clip.notices, *said))


def _may_hide(path: Path) -> bool:
    """By its header."""
    try:
        with opened(path) as picture:
            return picture.has_transparency_data
    except BROKEN:
        return False  # Its reader says what is wrong.


def _hides_some(path: Path) -> bool:
    try:
        seen = visible(path)
    except ClipError:
        return False
    return seen is not None and not seen.all()
