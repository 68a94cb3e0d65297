"""What a clip's tool masks mean: which value is the tool, and which rows are no picture at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, ByteImage, ClipError

Marked = Literal["tool", "tissue"]

DARK: Final = 127
"""Up to which a mask of grey levels marks nothing, as what is compressed has noise around 0."""
MOST_LABELS: Final = 16
SAMPLES: Final = 4
"""Frames by which the masks of a clip are judged."""
_LOSSY: Final = frozenset({".jpg", ".jpeg"})
_CLEAR = 0.2
"""Difference in share of measured depth that counts as a vote."""
_REDDER = 0.03
"""Difference in (R - B) / (R + G + B) that counts as a vote: tissue is redder than steel."""
_BAR_SHARE = 1 / 8
"""More dead rows than this share of the height are missing depth, not a status bar."""


@dataclass(frozen=True, eq=False)
class Sample:
    """One frame looked at to judge a clip."""

    image: ByteImage
    """(H, W, 3)"""
    marked: BoolImage
    """(H, W), True where the mask file is not zero."""
    depth: NDArray[np.float32] | None
    """(H, W), 0 = none."""


def is_lossy(path: Path) -> bool:
    """Whether a mask is compressed such that its 0 is noisy, by its name."""
    return path.suffix.lower() in _LOSSY


def levels(stored: NDArray[Any]) -> NDArray[Any]:
    """(H, W): of each pixel of a mask the largest of its colours; alpha does not count."""
    if stored.ndim == 2:
        return stored
    colours = 1 if stored.shape[2] == 2 else 3
    return np.asarray(stored[:, :, :colours].max(axis=2))


def marked_pixels(stored: NDArray[Any], labels: int = 1) -> BoolImage:
    """(H, W), True where a mask of 0/255, 0/1 or grey with compression noise is set; where it holds no value
    above `labels`, all but 0 are labels of what is marked."""
    grey = levels(stored)
    return np.asarray(grey > (0.5 if grey.max() <= labels else DARK))


def highest_label(masks: Sequence[NDArray[Any]]) -> int:
    """For `marked_pixels`, of the masks of one clip (H, W), none of them lossy: some may show fewer labels
    than others. Values that count 1, 2, ... are labels, and so are others up to MOST_LABELS."""
    found = set[float]().union(*(np.unique(mask[mask != 0]).tolist() for mask in masks))
    counted = set(range(1, len(found) + 1))
    return MOST_LABELS if found and found == counted and len(found) <= MOST_LABELS else 1


def marked_share(samples: Sequence[Sample]) -> float:
    """Share of all pixels that the masks mark, in [0, 1]."""
    return float(np.mean([sample.marked.mean() for sample in samples]))


def marks_tissue(samples: Sequence[Sample]) -> bool:
    """Whether the marked pixels are clearly the tissue rather than the tool.

    Three witnesses vote: stereo depth is measured on tissue and cut out or missing under tools;
    tissue covers the larger part of the picture; tissue is redder. Two of them must say so, since
    each alone fails on real clips (depth may cover tools, tools may fill the view, fat is yellow).
    """
    share = marked_share(samples)
    if not 0.001 < share < 0.999:
        return False
    votes = [share > 0.5, _redness_gap(samples) > _REDDER, _depth_gap(samples) > _CLEAR]
    return sum(votes) >= 2


def refuse_inverted(samples: Sequence[Sample], marked: Marked, masks: Path) -> None:
    """Raises ClipError when masks of this folder that should mark `marked` look like the opposite."""
    other: Marked = "tissue" if marked == "tool" else "tool"
    if other == "tool":
        samples = [replace(one, marked=~one.marked) for one in samples]
    if marks_tissue(samples):
        expected = f"expected masks that mark {marked}, got masks that look as if they mark {other}"
        hint = f"set mask_polarity (--mask-polarity {other}, or {marked} if they are right)"
        raise ClipError(f"{expected}; {hint}: {masks}")


def _redness_gap(samples: Sequence[Sample]) -> float:
    """Redness of marked minus that of unmarked pixels."""
    totals = {True: np.zeros(3), False: np.zeros(3)}
    for sample in samples:
        for side, total in totals.items():
            total += sample.image[sample.marked == side].sum(axis=0, dtype=np.float64)
    redness = {side: (total[0] - total[2]) / max(total.sum(), 1.0) for side, total in totals.items()}
    return float(redness[True] - redness[False])


def _depth_gap(samples: Sequence[Sample]) -> float:
    """Share of marked pixels with depth minus that of unmarked ones; 0 without depth."""
    counts = np.zeros((2, 2))
    for sample in samples:
        if sample.depth is not None:
            measured = sample.depth > 0
            for side in (0, 1):
                here = sample.marked == bool(side)
                counts[side] += measured[here].sum(), here.sum()
    shares = counts[:, 0] / np.maximum(counts[:, 1], 1)
    return float(shares[1] - shares[0])


def burned_in_rows(samples: Sequence[Sample]) -> int:
    """How many rows at the bottom are a status bar or border instead of the picture.

    A row counts when every sample has no depth in it (stereo never matches text that is drawn
    over both views) or one flat colour. A tall block of such rows is not taken for a bar.
    """
    height = samples[0].image.shape[0]
    dead = np.logical_and.reduce([_flat_rows(sample) | _unmeasured_rows(sample) for sample in samples])
    rows = height if dead.all() else int(np.argmin(dead[::-1]))
    return rows if rows <= height * _BAR_SHARE else 0


def _flat_rows(sample: Sample) -> BoolImage:
    """(H,), True where the row has one colour."""
    return np.asarray(sample.image.std(axis=1).max(axis=1) < 1.0)


def _unmeasured_rows(sample: Sample) -> BoolImage:
    """(H,), True where the row has no depth although the frame has some."""
    if sample.depth is None or not sample.depth.any():
        return np.zeros(sample.image.shape[0], dtype=bool)
    return np.asarray(~(sample.depth > 0).any(axis=1))
