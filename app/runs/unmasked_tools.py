"""Tools in the frames of a clip that comes without masks of them, found in the frames to train on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Final

import numpy as np
from annotated_types import Ge, Interval

from renderer.clip import BoolImage, ByteImage, Clip, Frame
from renderer.tools.search import REACH, tools_alone, with_margin, with_still
from renderer.tools.shrinking import shrunk
from renderer.tools.still import StillArea, still_areas
from renderer.train.events import Omission

GREY: Final = 4
"""Levels between the channels of a grey pixel, which JPEG and video may colour a little."""


@dataclass(frozen=True)
class FoundTools:
    """Tools that were found by their colour: training leaves them out, as `find_tools` finds them."""

    frames: Annotated[int, Ge(1)]
    """Of those looked at, the ones that show tools."""
    looked_at: Annotated[int, Ge(1)]
    share: Annotated[float, Interval(gt=0, le=1)]
    """Of the pixels of all frames looked at."""
    still: tuple[StillArea, ...] = ()
    """Of them; runs of versions before have none, and find each frame's tools by that frame alone."""
    reach: Annotated[float, Interval(ge=0, le=1)] = 0.0
    """Of the longer side: pieces of a tool are as near to each other; 0, as in runs of versions before: each
    enters by itself."""


def tools_in(frames: Iterable[Frame]) -> FoundTools | None:
    """What these frames show, but for those whose tools are known; None where there is nothing, or where the
    clip's own masks change from frame to frame: then they are masks of tools."""
    first, images, alone = list[BoolImage](), list[ByteImage](), list[ByteImage]()
    for frame in frames:
        if frame.tools_are_known:
            continue
        mask = frame.tissue_mask
        first = first or [mask]
        if mask.shape != first[0].shape or (mask != first[0]).any():
            return None
        images.append(shrunk(frame.image))
        alone.append(tools_alone(images[-1], mask))
    still = still_areas(images, alone)
    shares = [
        float(with_margin(with_still(one, small, still), first[0].shape).mean())
        for small, one in zip(images, alone, strict=True)
    ]
    found = sum(share > 0 for share in shares)
    return FoundTools(found, len(shares), sum(shares) / len(shares), still, REACH) if found else None


def untold_in(clip: Clip) -> tuple[str, ...]:
    """That grey frames tell no tools, to a person; nothing where they have colour, or where it is known what
    is tissue. Raises ClipError: the first frame to train on cannot be read."""
    first = clip.read_frame(clip.train_indices[0])
    if first.tools_are_known or not first.tissue_mask.all() or np.ptp(first.image, axis=2).max() > GREY:
        return ()
    return (
        "the frames are grey: tools cannot be told by their colour and are reconstructed as tissue; masks of "
        "them leave them out (--tool-masks DIR)",
    )


def omission_of(found: FoundTools) -> Omission:
    """What leaving them out is, in words and numbers."""
    return Omission(
        "tools",
        f"found by their colour in {found.frames} of {found.looked_at} frames, as the clip has no masks",
        f"{100 * found.share:.0f} % of the pixels",
        "tools",
    )
