"""Panels burned into frames whose tools are masked: found in the frames to train on, beside the masks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Interval, Len

from app.runs.dark_surround import percent
from renderer.clip import BoolImage, ByteImage, Frame
from renderer.tools.search import still_pixels, tools_alone
from renderer.tools.shrinking import shrunk, shrunk_mask
from renderer.tools.still import StillArea, still_areas
from renderer.train.events import Omission


@dataclass(frozen=True)
class BurnedIn:
    """What stands still beside masks of tools, and has not the colour of tissue: it is neither trained on
    nor evaluated."""

    frames: Annotated[int, Ge(1)]
    """Of those looked at, the ones that show some."""
    looked_at: Annotated[int, Ge(1)]
    share: Annotated[float, Interval(gt=0, le=1)]
    """Of the pixels of all frames looked at."""
    still: Annotated[tuple[StillArea, ...], Len(1)]


def burned_in_of(frames: Iterable[Frame]) -> BurnedIn | None:
    """What these frames show; None where there is nothing, or where no masks of tools are known or change
    from frame to frame: then `tools_in` looks for it.

    It has to look like a tool, to stand still and to be found in most frames, as without masks: tissue at
    rest has another colour. What is masked in some frames alone counts as seen, lest pale tissue beside a
    mask should seem to enter from there, as a tool does from the edge.
    """
    images, masks, is_masked = list[ByteImage](), list[BoolImage](), False
    for frame in frames:
        images.append(shrunk(frame.image))
        masks.append(frame.tissue_mask)
        if masks[-1].shape != masks[0].shape:
            return None
        is_masked |= frame.tools_are_known or bool((masks[-1] != masks[0]).any())
    if not is_masked:
        return None
    seen = np.logical_or.reduce(masks)
    found = [tools_alone(image, seen) * shrunk_mask(mask) for image, mask in zip(images, masks, strict=True)]
    still = still_areas(images, found)
    shares = [
        float((mask & still_pixels(image, still, mask.shape)).mean())
        for image, mask in zip(images, masks, strict=True)
    ]
    shown = sum(share > 0 for share in shares)
    return BurnedIn(shown, len(shares), sum(shares) / len(shares), still) if shown else None


def omission_of(found: BurnedIn) -> Omission:
    """What leaving it out is, in words and numbers; a tool that never moves looks as text does."""
    return Omission(
        "text or tools at rest",
        f"unchanged beside the masks in {found.frames} of {found.looked_at} frames",
        f"{percent(found.share)} of the pixels",
        "tools",
    )
