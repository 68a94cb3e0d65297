"""The training loss in float64, term by term, and its slope along a way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from renderer.clip import Frame
from renderer.rasterize.tiles import LEFT, PLANE_BLUE, PLANE_DEPTH, PLANE_RED
from renderer.train.losses import CLEAR, LossWeights

FloatArray = NDArray[np.float64]
STEP: Final = 1e-7
"""Of the differences that slopes are."""


@dataclass(frozen=True, eq=False)
class ExactLoss:
    """Of one frame with its depth; planes (5, H, W) are those of the raster, without padding."""

    frame: Frame
    weights: LossWeights
    size: float
    opaque: NDArray[np.bool_]
    """(H, W) True: some frame shows tissue there."""
    unseen: NDArray[np.bool_]
    """(H, W) True: no frame shows tissue there."""

    def value(self, planes: FloatArray) -> float:
        """All terms."""
        return self._of_depth(planes) + self._of_picture(planes)

    def slope(self, planes: FloatArray, way: FloatArray) -> float:
        """Along `way`: of the depth terms as they are written, which may be too large for differences, and of
        the others by those."""
        more, less = (self._of_picture(planes + step * way) for step in (STEP, -STEP))
        return (more - less) / (2 * STEP) + self._depth_slope(planes, way)

    def _of_picture(self, planes: FloatArray) -> float:
        weights, image = self.weights, self.frame.image / 255.0
        mask, picture = self.frame.tissue_mask, planes[PLANE_RED : PLANE_BLUE + 1].transpose(1, 2, 0)
        loss = weights.color * np.abs(picture - image)[mask].sum() / max(1, 3 * mask.sum())
        left = planes[LEFT]
        through = np.maximum(left - np.float64(CLEAR), 0)[self.opaque].sum() + (1 - left)[self.unseen].sum()
        loss += weights.opacity * through / max(1, self.opaque.sum() + self.unseen.sum())
        loss += weights.image_variation * sum(_steps(picture[..., c]) for c in range(3)) / picture.size
        alpha = 1 - planes[LEFT]
        drawn = (alpha > 0.5) & (planes[PLANE_DEPTH] > 0)
        inverse = np.where(drawn, alpha / np.where(drawn, planes[PLANE_DEPTH], 1), np.nan)
        return float(loss + weights.inverse_depth_variation * self.size * _steps(inverse) / inverse.size)

    def _compared(self, planes: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, int]:
        """Alpha, drawn and measured depth where both are, and at how many pixels it is measured."""
        assert self.frame.depth is not None
        alpha, known = 1 - planes[LEFT], self.frame.depth_mask
        both = known & (alpha > 0.5)
        drawn = planes[PLANE_DEPTH][both] / alpha[both]
        return alpha[both], drawn, self.frame.depth[both].astype(np.float64), max(1, int(known.sum()))

    def _of_depth(self, planes: FloatArray) -> float:
        _, drawn, measured, count = self._compared(planes)
        loss = self.weights.depth * np.abs(drawn - measured).sum() / self.size
        loss += self.weights.inverse_depth * np.abs(1 / drawn - 1 / measured).sum() * self.size
        return float(loss / count)

    def _depth_slope(self, planes: FloatArray, way: FloatArray) -> float:
        alpha, drawn, measured, count = self._compared(planes)
        both = self.frame.depth_mask & (1 - planes[LEFT] > 0.5)
        change = (way[PLANE_DEPTH][both] + drawn * way[LEFT][both]) / alpha
        by_drawn = self.weights.depth / self.size + self.weights.inverse_depth * self.size / drawn**2
        return float((by_drawn * np.sign(drawn - measured) * change).sum() / count)


def _steps(values: FloatArray) -> float:
    """Sum of the absolute differences of neighbours, NaN being none."""
    return float(sum(np.nansum(np.abs(np.diff(values, axis=axis))) for axis in (0, 1)))
