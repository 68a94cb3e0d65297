"""How well the tool masks of neighbouring frames agree: where they do not, one of them is wrong."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, ByteImage
from renderer.tools.shrinking import shrunk, shrunk_mask

WEAK: Final = 0.6
"""IoU with the frame before, below which a mask should be looked at."""
_LEAST = 0.002
"""Of the image: less, in both frames, is nothing."""
_THINNEST = 12  # px: the flow takes no image that is narrower or lower.


class Agreement:
    """Follows a clip: the IoU of each mask with that of the frame before, moved along by optical flow.

    Kroeger et al., Fast optical flow using dense inverse search, 2016.
    """

    def __init__(self) -> None:
        self._flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
        self._before: tuple[ByteImage, BoolImage] | None = None

    def with_next(self, image: ByteImage, mask: BoolImage) -> float | None:
        """Of the next frame, RGB (H, W, 3), and its mask (H, W); None for the first, where neither shows a
        tool, and where the small image is too thin for the flow."""
        grey = cv2.cvtColor(shrunk(image), cv2.COLOR_RGB2GRAY)
        tool = shrunk_mask(mask)
        before, self._before = self._before, (np.asarray(grey, dtype=np.uint8), tool)
        if before is None or before[0].shape != grey.shape or min(grey.shape) < _THINNEST:
            return None
        moved = self._moved(*before, np.asarray(grey, dtype=np.uint8))
        if max(moved.mean(), tool.mean()) < _LEAST:
            return None
        return float(np.count_nonzero(moved & tool) / np.count_nonzero(moved | tool))

    def _moved(self, grey: ByteImage, tool: BoolImage, to: ByteImage) -> BoolImage:
        back = np.asarray(self._flow.calc(to, grey, np.zeros((*tool.shape, 2), np.float32)), dtype=np.float32)
        rows, columns = tool.shape
        x, y = np.meshgrid(np.arange(columns, dtype=np.float32), np.arange(rows, dtype=np.float32))
        soft: NDArray[np.float32] = tool.astype(np.float32)
        places = x + back[:, :, 0], y + back[:, :, 1]
        moved = cv2.remap(soft, *places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(moved > 0.5)
