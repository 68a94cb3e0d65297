"""What a few masks of a clip tell of all: labels or levels, tools or tissue, and what is said of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ClipError
from renderer.evenly import evenly, evenly_floored
from renderer.readers.clip_options import ClipOptions
from renderer.readers.image_files.pictures import read_stored
from renderer.readers.masks.tool_masks import (
    DARK,
    SAMPLES,
    Marked,
    Sample,
    highest_label,
    is_lossy,
    levels,
    marked_share,
    refuse_inverted,
)

_MOST_LOOKED_AT: Final = 32
"""Masks of a clip whose first ones are empty."""
_NOISE: Final = 0.001
"""Share of the pixels that are not 0, up to which they are traces of a compression."""


def labels_of(masks: Sequence[Path], looked_at: Iterable[int]) -> int:
    """Up to which value the masks of a clip are labels, see `highest_label`: by those that are looked at, and
    where these are empty by the first of some others that is not. Raises ClipError: one cannot be read."""
    if is_lossy(masks[0]):
        return 1
    seen = [_levels(masks[index]) for index in looked_at]
    if not any(mask.any() for mask in seen):
        read = (_levels(mask) for mask in evenly_floored(masks, _MOST_LOOKED_AT))
        seen += islice((mask for mask in read if mask.any()), 1)
    return highest_label(seen)


def _levels(path: Path) -> NDArray[Any]:
    return levels(read_stored(path))


def unmarked(masks: Sequence[Path], labels: int) -> list[str]:
    """A sentence about values that mark nothing, in masks that were looked at; `labels` as of `labels_of`."""
    seen = [_levels(path) for path in masks]
    dark = [mask for mask in seen if labels < mask.max() <= DARK]
    if not dark:
        return []
    said = f"{masks[0].parent.name}/ holds values up to {int(max(mask.max() for mask in dark))} of 255"
    if not any(mask.max() > DARK for mask in seen):
        return [f"{said} and marks nothing: above {DARK} it would"]
    some = sum(np.count_nonzero(mask) > _NOISE * mask.size for mask in dark)
    there = f"{some} of {len(seen)} frames looked at"
    return [f"{said} alone in {there} and marks nothing there: above {DARK} it would"] if some else []


def judged_nonzero(
    masks: Sequence[Path], marked: Marked, sample: Callable[[int], Sample], options: ClipOptions
) -> list[str]:
    """What is worth saying of masks, one a frame or none, that mark `marked` and are read by `read_nonzero`.
    Raises ClipError: they look inverted, and nothing says how they are meant."""
    if masks and options.mask_polarity == "auto":
        looked_at = evenly_floored(range(len(masks)), SAMPLES)
        refuse_inverted([sample(index) for index in looked_at], marked, masks[0].parent)
    return unmarked(evenly(list(filter(is_lossy, masks)), SAMPLES), labels=1)


def judged(masks: Path, samples: Sequence[Sample], options: ClipOptions) -> list[str]:
    """What is worth saying of a folder of masks as tools. Raises ClipError: no polarity fits."""
    share = marked_share(samples)
    marked = f"{masks.name}/ marks {100 * share:.0f} % of the image as tool"
    if options.mask_polarity == "auto":
        if share > 0.999:
            hint = "if 255 is tissue, set mask_polarity (--mask-polarity tissue)"
            raise ClipError(f"{marked}; {hint}: {masks}")
        refuse_inverted(samples, "tool", masks)
    return [marked] if options.mask_polarity != "tissue" and share > 0.5 else []
