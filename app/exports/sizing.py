"""How large the images of an export are."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from renderer.clip import ByteImage

LEAST_WIDTH, MOST_WIDTH = 16, 16384
MOST_SCALE = 64


@dataclass(frozen=True)
class Sizing:
    """Whole squares, or a chosen width; `PanesRecord` says within which limits."""

    scale: int = 1
    """Pixels of the file a pixel of the picture, each way: no value is made up between two."""
    width: int | None = None
    """Pixels across in place of that, the shape kept: averaged when smaller, interpolated when larger."""

    def of(self, image: ByteImage) -> ByteImage:
        """(H, W, 3) in this size. Values are those of the file: what is stored is meant for screens, and so
        is what comes out."""
        if self.width is not None and self.width != image.shape[1]:
            height = max(1, round(image.shape[0] * self.width / image.shape[1]))
            way = cv2.INTER_AREA if self.width < image.shape[1] else cv2.INTER_CUBIC
            return np.asarray(cv2.resize(image, (self.width, height), interpolation=way), dtype=np.uint8)
        if self.width is not None or self.scale == 1:
            return image
        return np.ascontiguousarray(image.repeat(self.scale, axis=0).repeat(self.scale, axis=1))
