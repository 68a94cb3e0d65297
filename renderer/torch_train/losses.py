"""The training loss in torch: the terms of renderer/train/losses.py, differentiated by autograd."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from renderer.rasterize.reference import Rendered
from renderer.train.frames import TrainFrame
from renderer.train.losses import CLEAR, SPARSE, LossWeights, guess_line

HALF = 0.5
"""Depth is compared where alpha is larger."""


@dataclass(frozen=True, eq=False)
class Target:
    """A training frame without its padding, on a device."""

    colors: Tensor
    """(H, W, 3) in [0, 1]."""
    mask: Tensor
    """(H, W) True: supervised."""
    opaque: Tensor
    """(H, W) True: some frame shows tissue there."""
    unseen: Tensor
    """(H, W) True: no frame shows tissue there."""
    depth: Tensor
    """(H, W), 0 = not supervised."""

    @classmethod
    def of(cls, frame: TrainFrame, device: torch.device) -> Target:
        """The bytes cross to the device, not the floats."""
        inside = slice(frame.camera.height), slice(frame.camera.width)
        masks = frame.color_mask[inside], frame.opaque[inside], frame.unseen[inside]
        arrays = frame.colors[:, *inside], *masks, frame.depth[inside]
        colors, mask, opaque, unseen, depth = (
            torch.from_numpy(np.ascontiguousarray(array)).to(device) for array in arrays
        )
        return cls(colors.permute(1, 2, 0).float() * (1 / 255), mask, opaque, unseen, depth)


def picture_loss(
    picture: Rendered, frame: TrainFrame, weights: LossWeights, size: float
) -> tuple[Tensor, Tensor]:
    """The loss, and the mean squared error over supervised pixels and channels."""
    target = Target.of(frame, picture.image.device)
    per_color = 1.0 / max(3 * frame.n_colors, 1)
    errors = (picture.image - target.colors) * target.mask[:, :, None]
    loss = weights.color * per_color * errors.abs().sum()
    if weights.opacity > 0:
        through = (1 - picture.alpha - float(CLEAR)).clamp(min=0.0) * target.opaque
        per_opacity = weights.opacity / max(frame.n_opaque + frame.n_unseen, 1)
        loss = loss + per_opacity * (through.sum() + (picture.alpha * target.unseen).sum())
    if weights.depth > 0 or weights.inverse_depth > 0:
        known = _fitted(target.depth, picture) if frame.depth_is_guess else target.depth
        compared = target.mask & (known > 0) & (picture.alpha > HALF)
        expected, measured = (torch.where(compared, depth, 1.0) for depth in (picture.depth, known))
        per_depth = 1.0 / max(frame.n_depths, 1)
        loss = loss + weights.depth * per_depth / size * (expected - measured).abs().sum()
        nearness = (1 / measured - 1 / expected).abs().sum()
        loss = loss + weights.inverse_depth * per_depth * size * nearness
    if weights.takes_whole_picture:
        loss = loss + _variation(picture, weights, size)
    return loss, per_color * errors.detach().square().sum()


def _variation(picture: Rendered, weights: LossWeights, size: float) -> Tensor:
    """Of the colours and of 1 / depth between pixels that are drawn, each a mean over their numbers."""
    drawn = (picture.alpha > HALF) & (picture.depth > 0)
    inverse = torch.where(drawn, 1 / torch.where(drawn, picture.depth, 1.0), 0.0)
    colors = picture.image.new_zeros(())
    nearness = picture.image.new_zeros(())
    for axis in (0, 1):
        count = inverse.shape[axis] - 1
        pairs = drawn.narrow(axis, 0, count) & drawn.narrow(axis, 1, count)
        colors = colors + picture.image.diff(dim=axis).abs().sum()
        nearness = nearness + (inverse.diff(dim=axis).abs() * pairs).sum()
    pixels = inverse.numel()
    per_color = weights.image_variation / (3 * pixels)
    return per_color * colors + weights.inverse_depth_variation * size / pixels * nearness


def _fitted(guess: Tensor, picture: Rendered) -> Tensor:
    """A guessed depth, fitted to what is drawn as on the processor; no gradient goes through the fit."""
    light, depth = picture.alpha.detach(), picture.depth.detach()
    sparse = (guess, light, depth * light)
    scale, shift = guess_line(*(values[SPARSE].cpu().numpy() for values in sparse))
    inverse = scale / torch.where(guess > 0, guess, 1.0) + shift
    usable = (guess > 0) & (inverse > 0) & (scale > 0)
    return torch.where(usable, 1 / torch.where(usable, inverse, 1.0), 0.0)
