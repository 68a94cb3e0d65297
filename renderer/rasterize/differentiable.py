"""The CPU rasteriser as a torch function, for methods that need autograd."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from functools import lru_cache
from typing import Any
from weakref import finalize

import torch
from torch import Tensor

from renderer.camera import Camera
from renderer.rasterize.cpu import Background, Rasterizer
from renderer.splats import RenderMode, Splats


@lru_cache(maxsize=2)
def _spare(width: int, height: int) -> deque[Rasterizer]:
    """The rasteriser of that size that no graph holds any more, if any: its memory is there already."""
    return deque(maxlen=1)


class _Lent:
    """A rasteriser for as long as a graph needs what it keeps between forward and backward."""

    def __init__(self, spare: deque[Rasterizer], width: int, height: int) -> None:
        try:
            self.rasterizer = spare.pop()
        except IndexError:  # Taken, perhaps by another thread in between.
            self.rasterizer = Rasterizer(width, height)
        finalize(self, spare.append, self.rasterizer)


def _splats(given: Sequence[Tensor]) -> Splats:
    """Of means, quats, scales, opacities and colors, in their memory."""
    return Splats(*(value.detach().numpy() for value in given))


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
        given = means, quats, scales, opacities, colors
        # Kept by torch, which raises where one of them is changed in place before the backward pass.
        ctx.save_for_backward(*given)
        ctx.lent = _Lent(_spare(camera.width, camera.height), camera.width, camera.height)
        ctx.rasterizer = ctx.lent.rasterizer
        ctx.rasterizer.forward(_splats(given), camera, near, mode=mode)
        ctx.background = background
        picture = ctx.rasterizer.rendered(camera.width, camera.height, background)
        return (
            torch.from_numpy(picture.image),
            torch.from_numpy(picture.alpha),
            torch.from_numpy(picture.depth),
        )

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor | None, ...]:
        if torch.is_grad_enabled():  # A graph of the gradients is wanted, in which these would be constants.
            raise RuntimeError("only rasterize(backend='reference') can be differentiated twice")
        ctx.rasterizer.set_adjoint(*(value.numpy() for value in gradients), ctx.background)
        result = ctx.rasterizer.backward(_splats(ctx.saved_tensors))
        arrays = (result.means, result.quats, result.scales, result.opacities, result.colors)
        return (*(torch.from_numpy(array) for array in arrays), None, None, None, None)
