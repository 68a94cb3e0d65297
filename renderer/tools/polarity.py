"""Whether masks of tools look as if they marked the tissue."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from renderer.clip import Clip, ClipError
from renderer.evenly import evenly
from renderer.readers.masks.tool_masks import Sample, marks_tissue
from renderer.tools.mask_files import MaskFiles

_SAMPLES: Final = 4


def with_doubt(masks: MaskFiles, clip: Clip) -> MaskFiles:
    """The same masks of the frames of the clip, with a notice where `marks_tissue` holds for a few of them,
    spread evenly. No more than a notice: tools may fill the view, or a mask keep a small part of it. Nothing
    is said where one of them cannot be read: it need not be in the part that is used.
    """
    try:
        samples = [_sample(masks, clip, index) for index in evenly(sorted(masks.files), _SAMPLES)]
    except ClipError:
        return masks
    if not samples or not marks_tissue(samples):
        return masks
    share = float(np.mean([sample.marked.mean() for sample in samples]))
    said = (
        f"masks in {masks.folder.name}/ look inverted: not black = tool is expected, and "
        f"{100 * share:.0f} % of the pixels are not black, on what looks like tissue"
    )
    return replace(masks, notices=(*masks.notices, said))


def _sample(masks: MaskFiles, clip: Clip, index: int) -> Sample:
    frame = clip.read_frame(index)
    mask = masks.read(index, (frame.image.shape[1], frame.image.shape[0]))
    assert mask is not None
    return Sample(frame.image, mask, frame.measured_depth)
