"""Whether images that follow one another are frames of one recording, or each a subject of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from typing import Final

import cv2
import numpy as np

from app.errors import UserError
from app.files.image_files import ArrayImage
from enhance.image import Float32Image
from renderer.clip import ClipError
from renderer.evenly import evenly

PAIRS: Final = 4
"""Neighbours that are looked at, evenly spread."""
SIDE: Final = 64
"""Pixels of the small copies."""
COARSE: Final = SIDE / 16
"""Sigma of what is left out of them: shading and the outline of the field of view are alike in all images."""
BORDER, SHIFT = 6, 4
"""Small pixels that are left out at the border, and by which neighbours may be apart."""
ALIKE: Final = 0.7
"""Correlation of details: .85 and more, in the middle, between frames of a recording (laparoscopy, fetoscopy,
mesentery, sinus, wall, pulling), .55 and less between images of different eyes or frames a second apart."""


def is_recording(count: int, read: Callable[[int], ArrayImage]) -> bool:
    """Whether `count` images, read by number, show one scene that moves."""
    return are_alike(likenesses(count, read))


def likenesses(count: int, read: Callable[[int], ArrayImage]) -> Iterator[float]:
    """Of neighbours, pair by pair, but for those that cannot be read; of fewer than two images none."""
    for first in evenly(range(count - 1), PAIRS):
        with suppress(UserError, ClipError, OSError):
            yield _likeness(read(first), read(first + 1))


def are_alike(found: Iterable[float]) -> bool:
    """Whether neighbours of such likenesses are frames of one recording: half of them and more look alike."""
    values = list(found)
    return bool(values) and float(np.median(values)) >= ALIKE


def _likeness(one: ArrayImage, other: ArrayImage) -> float:
    """Correlation of details, at the shift where it is highest."""
    if one.shape[:2] != other.shape[:2]:
        return 0.0
    details, beside = _details(one), _details(other)
    inner = np.ascontiguousarray(details[SHIFT:-SHIFT, SHIFT:-SHIFT])
    if not inner.any() or not beside.any():
        return float(np.array_equal(details, beside))
    return float(cv2.matchTemplate(beside, inner, cv2.TM_CCOEFF_NORMED).max())


def _details(image: ArrayImage) -> Float32Image:
    """(SIDE - 2 BORDER, SIDE - 2 BORDER) grey, less its blur."""
    small = np.asarray(cv2.resize(image.astype(np.float32), (SIDE, SIDE), interpolation=cv2.INTER_AREA))
    grey = small if small.ndim == 2 else small[..., :3].mean(axis=2)
    details = grey - cv2.GaussianBlur(grey, (0, 0), COARSE)
    return np.ascontiguousarray(details[BORDER:-BORDER, BORDER:-BORDER], dtype=np.float32)
