"""Pictures and their gradients on any torch device: the raw values go there, their gradients come back.

What moves Gaussians, Adam, density control and checkpoints stay on the processor, where they touch only what
a frame reaches: the same code for every device and every method.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor

from renderer.camera import Camera
from renderer.near_plane import NEAR_SHARE
from renderer.rasterize.cuda import Drawn, rasterize_cuda
from renderer.raw_gaussians import FIELDS, RawGaussians
from renderer.splats import Float32Array, RenderMode
from renderer.torch_train.harmonics import seen_colors
from renderer.torch_train.losses import picture_loss
from renderer.train.frames import TrainFrame
from renderer.train.gradient_backend import LossGradients
from renderer.train.losses import LossWeights, Measured

Draw = Callable[..., Drawn]
"""With the parameters of `rasterize_cuda`."""


class TorchBackend:
    """See `GradientBackend` of renderer.train. Every tile is drawn: without tissue it has no gradient."""

    def __init__(self, device: str, draw: Draw = rasterize_cuda) -> None:
        self._device, self._draw = torch.device(device), draw
        self._centers = torch.zeros((1, 0, 2))

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
        raw = {
            name: torch.from_numpy(value).to(self._device).requires_grad_()
            for name, value in now.arrays().items()
        }
        drawn = self._draw(*_activated(raw, frame.camera), frame.camera, near=NEAR_SHARE * size, mode=mode)
        loss, squared = picture_loss(drawn.picture, frame, weights, size)
        loss.backward()  # type: ignore[no-untyped-call]
        self._centers = drawn.centers
        by = {name: _gradient(raw[name]) for name in FIELDS}
        seen = (by["colors"] != 0).any(dim=1) | (by["opacity_logits"] != 0)
        measured = Measured(loss.item(), squared.item())
        return LossGradients(
            measured, RawGaussians(**{name: _array(value) for name, value in by.items()}), seen.cpu().numpy()
        )

    def by_centers(self) -> Float32Array:
        """See GradientBackend."""
        return _array(_gradient(self._centers)[0])


def _activated(raw: dict[str, Tensor], camera: Camera) -> tuple[Tensor, ...]:
    """Means, quaternions, scales, opacities and the colours that the camera sees."""
    center = torch.tensor(camera.position, dtype=torch.float32, device=raw["means"].device)
    colors = seen_colors(raw["means"], raw["harmonics"], raw["colors"], center)
    return (
        raw["means"], raw["quats"], raw["log_scales"].exp(), raw["opacity_logits"].sigmoid(), colors,
    )  # fmt: skip


def _gradient(leaf: Tensor) -> Tensor:
    return torch.zeros_like(leaf) if leaf.grad is None else leaf.grad


def _array(values: Tensor) -> Float32Array:
    array: Float32Array = np.ascontiguousarray(values.detach().cpu().numpy())
    return array
