"""Tools in the frames of a clip that comes without masks of them, found in the frames to train on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Interval

from renderer.clip import BoolImage, Frame
from renderer.tools.search import find_tools
from renderer.train.events import Omission


@dataclass(frozen=True)
class FoundTools:
    """Where `find_tools` finds some, they are no tissue."""

    frames: Annotated[int, Ge(1)]
    """Of those looked at, the ones that show tools."""
    looked_at: Annotated[int, Ge(1)]
    share: Annotated[float, Interval(gt=0, le=1)]
    """Of the pixels of all frames looked at."""


def tools_in(frames: Iterable[Frame]) -> FoundTools | None:
    """What these frames show, but for those whose tools are known; None where there is nothing, or where the
    clip's own masks change from frame to frame: then they are masks of tools."""
    first, shares = list[BoolImage](), list[float]()
    for frame in frames:
        if frame.tools_are_known:
            continue
        mask = frame.tissue_mask
        first = first or [mask]
        if mask.shape != first[0].shape or (mask != first[0]).any():
            return None
        shares.append(float(find_tools(frame.image, mask).mean()))
    found = sum(share > 0 for share in shares)
    return FoundTools(found, len(shares), sum(shares) / len(shares)) if found else None


def omission_of(found: FoundTools) -> Omission:
    """What leaving them out is, in words and numbers."""
    return Omission(
        "tools",
        f"found by their colour in {found.frames} of {found.looked_at} frames, as the clip has no masks",
        f"{100 * found.share:.0f} % of the pixels",
        "tools",
    )
