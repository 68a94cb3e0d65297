"""Eyes whose rows lie apart: by a constant, as of a rig that was mounted or cropped so, or frame by frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import ByteImage

SMALLEST: Final = 0.5
"""px: rows that are closer are left as they are, as matching takes them."""
FEWEST: Final = 10
"""Features by which one pair tells its rows."""
DECIDING: Final = 20
"""Features of a pair that has a say in whether the rows of a clip vary, or its eyes are swapped."""
SCATTERED: Final = 1.5
"""px, the median distance of a pair's rows from their median, beyond which it has none: matches by chance."""
VARYING: Final = 2.0
"""px between the pairs of a clip: eyes that do not look at the same moment see a moving camera at two places.
Rows of clips from fixed cameras vary by up to 1 px from pair to pair, features being few."""
NEARLY_ALL: Final = 0.9
"""Of the features of a pair, where its eyes are swapped; the others match by chance."""
PAIRS: Final = 5
"""Pairs that are looked at, spread over the clip: one alone may have too few features to tell."""


@dataclass(frozen=True)
class Rows:
    """By how many right images are to be moved down."""

    usual: float = 0.0
    vary: bool = False
    """From frame to frame: each is looked at."""

    def said(self) -> tuple[str, ...]:
        if self.vary:
            return (
                "the eyes' rows are apart by a distance that varies: each right image is moved by its own",
            )
        if self.usual:
            return (f"the eyes' rows are {abs(self.usual):.1f} px apart: right images are moved by that",)
        return ()


def row_offset(shifts: Sequence[NDArray[np.float64]]) -> tuple[float, float]:
    """From shifts (M, 2) of several pairs, left minus right: by how much right images are to be moved down,
    and the median distance of rows in px that is left then, of the first pair or of all, the larger one."""
    every = np.concatenate(shifts)[:, 1]
    offset = float(np.median(every))
    if abs(offset) < SMALLEST:
        offset = 0.0
    return offset, max(float(np.median(np.abs(down - offset))) for down in (shifts[0][:, 1], every))


def own_offsets(shifts: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """The same rows of each pair by itself (P,), of those alone that show much, and agree."""
    return np.array([_own(each) for each in shifts if has_a_say(each)])


def has_a_say(shifts: NDArray[np.float64]) -> bool:
    """Whether a pair (M, 2) shows much whose rows agree."""
    return len(shifts) >= DECIDING and scatter(shifts) <= SCATTERED


def is_swapped(shifts: NDArray[np.float64]) -> bool:
    """Whether the right image of a pair (M, 2) shows nearly all farther right; not said of what shows little.
    Eyes that look at one near point have some of the tissue on either side of it."""
    return has_a_say(shifts) and bool(np.quantile(shifts[:, 0], NEARLY_ALL) < 0)


def scatter(shifts: NDArray[np.float64]) -> float:
    """Median distance in px of the rows (M, 2) of a pair from their median."""
    return float(np.median(np.abs(shifts[:, 1] - np.median(shifts[:, 1]))))


def own_offset(shifts: NDArray[np.float64], usual: float) -> float:
    """Of one pair; `usual` where it shows too little to tell."""
    found = _own(shifts)
    return usual if math.isnan(found) else found


def _own(shifts: NDArray[np.float64]) -> float:
    return float(np.median(shifts[:, 1])) if len(shifts) >= FEWEST else math.nan


def moved_down(image: ByteImage, rows: float) -> ByteImage:
    """The image (H, W, 3) moved by so many rows, up where negative; what comes in repeats the edge."""
    move = np.array([[1, 0, 0], [0, 1, rows]], np.float32)
    size = (image.shape[1], image.shape[0])
    moved = cv2.warpAffine(image, move, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(moved, np.uint8)


def unseen(rows: float) -> slice:
    """The rows of the left image that an image moved by so many does not show."""
    count = math.ceil(abs(rows))
    return slice(0, count) if rows >= 0 else slice(-count, None)
