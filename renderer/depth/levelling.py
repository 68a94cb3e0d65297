"""Eyes that are turned against each other in the image, or see it a little larger: rows are brought level."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import ByteImage
from renderer.depth.alignment import TO_DEVIATION

Matches = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Places (M, 2) in px of what both images of a pair show, in the left and in the right one."""

MOST_TURNED: Final = 3.0
"""Degrees: eyes of one scope are mounted more alike than that."""
MOST_STRETCHED: Final = 0.03
ROUNDS: Final = 10
WITHIN: Final = 2.5
"""Deviations of the rows that are left, beyond which a match is by chance."""
LEAST_DEVIATION: Final = 0.2
"""px, to which places are exact."""


@dataclass(frozen=True)
class Level:
    """What brings rows of right images level with those of the left ones, but for a distance that is the same
    in all rows: y + turn (x - cx) + stretch (y - cy)."""

    turn: float
    stretch: float

    @property
    def degrees(self) -> float:
        return math.degrees(self.turn)

    def said(self) -> str:
        turned = f"right images are turned by {self.degrees:.1f} degrees"
        return f"the eyes are turned against each other: {turned} and stretched by {100 * self.stretch:.1f} %"

    def applied(self, image: ByteImage) -> ByteImage:
        """The image (H, W, 3), turned and stretched about its middle; what comes in repeats the edge."""
        height, width = image.shape[:2]
        scale = 1 + self.stretch
        linear = np.array([[scale, -self.turn], [self.turn, scale]])
        middle = np.array([(width - 1) / 2, (height - 1) / 2])
        matrix = np.column_stack((linear, middle - linear @ middle))
        moved = cv2.warpAffine(
            image, matrix, (width, height), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        return np.asarray(moved, np.uint8)


def level_of(pairs: Sequence[Matches]) -> Level | None:
    """By least squares over the matches of several pairs, each with a distance of its rows of its own, those
    left out by and by that do not agree; None: the eyes are turned by more than eyes of one scope are."""
    rows = np.concatenate([_centred(left[:, 1] - right[:, 1]) for left, right in pairs])
    places = np.concatenate([_centred(right) for _, right in pairs])
    system, kept = np.column_stack((places, np.ones(len(places)))), np.ones(len(places), bool)
    found = np.zeros(3)
    for _ in range(ROUNDS):
        if kept.sum() < len(found):
            return None
        found = np.linalg.lstsq(system[kept], rows[kept], rcond=None)[0]
        off = np.abs(rows - system @ found)
        kept = off <= WITHIN * max(TO_DEVIATION * float(np.median(off)), LEAST_DEVIATION)
    level = Level(turn=float(found[0]), stretch=float(found[1]))
    within = abs(level.degrees) <= MOST_TURNED and abs(level.stretch) <= MOST_STRETCHED
    return level if within else None


def _centred(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(values - np.median(values, axis=0)) if len(values) else values
