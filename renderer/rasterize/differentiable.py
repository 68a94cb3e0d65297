"""The CPU rasteriser as a torch function, for methods that need autograd."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from torch import Tensor

from renderer.camera import Camera
from renderer.rasterize.cpu import Background, Rasterizer
from renderer.splats import RenderMode, Splats


class CpuRasterize(torch.autograd.Function):
    """means, quats, scales, opacities, colors -> image, alpha, depth, all float32 on the CPU."""

    @staticmethod
    def forward(
        ctx: Any,
        means: Tensor,
        quats: Tensor,
        scales: Tensor,
        opacities: Tensor,
        colors: Tensor,
        camera: Camera,
        background: Background,
        near: float,
        mode: RenderMode,
    ) -> tuple[Tensor, Tensor, Tensor]:
        arrays = [value.detach().numpy() for value in (means, quats, scales, opacities, colors)]
        ctx.splats = Splats(*arrays)
        ctx.rasterizer = Rasterizer(camera.width, camera.height)
        ctx.rasterizer.forward(ctx.splats, camera, near, mode=mode)
        ctx.background = background
        ctx.rendered = ctx.rasterizer.rendered(camera.width, camera.height, background)
        picture = ctx.rendered
        return (
            torch.from_numpy(picture.image),
            torch.from_numpy(picture.alpha),
            torch.from_numpy(picture.depth),
        )

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor | None, ...]:
        by_image, by_alpha, by_depth = (value.numpy().astype(np.float64) for value in gradients)
        ctx.rasterizer.set_adjoint(by_image, by_alpha, by_depth, ctx.rendered, ctx.background)
        result = ctx.rasterizer.backward(ctx.splats)
        arrays = (result.means, result.quats, result.scales, result.opacities, result.colors)
        return (*(torch.from_numpy(array) for array in arrays), None, None, None, None)
