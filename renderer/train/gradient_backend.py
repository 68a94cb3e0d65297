"""What a training step asks of whatever draws: a picture's loss and its gradients by the raw values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from renderer.near_plane import NEAR_SHARE
from renderer.rasterize.cpu import Gradients, Rasterizer
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Float32Array, RenderMode, Splats
from renderer.train.frames import TrainFrame
from renderer.train.losses import LossWeights, Measured, picture_loss


@dataclass(frozen=True, eq=False)
class LossGradients:
    """Of the loss of one picture."""

    measured: Measured
    by: RawGaussians
    seen: NDArray[np.bool_]
    """(N,) True: takes part in the picture; the gradients of the others are 0."""


class GradientBackend(Protocol):
    """Draws and differentiates, on a processor or on a card; all else of a step is the same on both."""

    def loss_and_gradients(
        self,
        now: RawGaussians,
        frame: TrainFrame,
        weights: LossWeights,
        size: float,
        *,
        every_tile: bool,
        mode: RenderMode = "default",
    ) -> LossGradients:
        """Of the Gaussians as they are at the frame's time; `size` is the scene's.

        Without `every_tile`, tiles without tissue may stay undrawn, where no loss looks at them.
        """
        ...

    def by_centers(self) -> Float32Array:
        """(N, 2) gradient of the last loss by the centres on screen, in pixels."""
        ...


class CpuBackend:
    """See GradientBackend: the numba kernels."""

    def __init__(self) -> None:
        self._rasterizer = Rasterizer(1, 1)
        self._size = (1, 1)

    def loss_and_gradients(
        self,
        now: RawGaussians,
        frame: TrainFrame,
        weights: LossWeights,
        size: float,
        *,
        every_tile: bool,
        mode: RenderMode = "default",
    ) -> LossGradients:
        """See GradientBackend."""
        if self._size != (frame.camera.width, frame.camera.height):
            self._size = frame.camera.width, frame.camera.height
            self._rasterizer = Rasterizer(*self._size)
        splats, rasterizer = now.splats(), self._rasterizer
        wanted = None if every_tile or weights.takes_whole_picture else frame.tile_wanted
        rasterizer.forward(splats, frame.camera, NEAR_SHARE * size, wanted, mode)
        measured = picture_loss(rasterizer, frame, weights, size)
        return LossGradients(measured, _by_raw(rasterizer.backward(splats), splats), rasterizer.visible)

    def by_centers(self) -> Float32Array:
        """See GradientBackend."""
        return self._rasterizer.by_centers()


def _by_raw(by: Gradients, splats: Splats) -> RawGaussians:
    """Gradients by the raw values from those by the activated ones."""
    return RawGaussians(
        means=by.means,
        quats=by.quats,
        log_scales=by.scales * splats.scales,
        opacity_logits=by.opacities * splats.opacities * (1 - splats.opacities),
        colors=by.colors,
        harmonics=by.harmonics,
    )
