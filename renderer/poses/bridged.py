"""A clip whose frames without a pose of their own are as good as not there."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from renderer.clip import Clip, Frame, within


def without_bridged(clip: Clip, bridged: Collection[int]) -> Clip:
    """The same clip where no pixel of these frames is tissue, or evaluated: where their camera was is not
    known, as through a jump, and they may show nothing. The very same clip where there are none."""
    if not bridged:
        return clip

    def read_frame(index: int) -> Frame:
        index = range(len(clip))[index]
        frame = clip.read_frame(index)
        if index not in bridged:
            return frame
        # A mask that leaves nothing says nothing of where tools are, nor need anyone look for them.
        return replace(within(frame, np.zeros_like(frame.tissue_mask)), tools_are_known=True)

    return replace(clip, read_frame=read_frame)
