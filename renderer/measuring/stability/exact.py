"""Pictures, depths and gradients in float64, by the literal reading of Eqs 13-16; it takes torch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.measuring.stability.scenes import CAMERA, NEAR, SCENES, camera_of
from renderer.splats import Splats

if TYPE_CHECKING:
    from torch import Tensor

FloatArray = NDArray[np.float64]
NAMES: Final = ("means", "quats", "scales", "opacities", "colors")
BACKDROP: Final = (0.3, 0.7, 0.1)
"""What the loss sees behind the splats."""


@dataclass(frozen=True, eq=False)
class Exact:
    """Of one set of splats."""

    image: FloatArray
    """Over black."""
    alpha: FloatArray
    depth: FloatArray
    loss: float
    """What `slopes` are of."""
    gradients: dict[str, FloatArray]
    """Of the loss by each of NAMES."""


class LossGradients(NamedTuple):
    """Of a loss by colour over BACKDROP (H, W, 3), by alpha and by depth (H, W)."""

    image: FloatArray
    alpha: FloatArray
    depth: FloatArray


def slopes() -> LossGradients:
    """Random ones."""
    rng = np.random.default_rng(5)
    shape = CAMERA.height, CAMERA.width
    return LossGradients(rng.normal(size=(*shape, 3)), rng.normal(size=shape), 0.05 * rng.normal(size=shape))


@cache
def of_scene(name: str) -> Exact:
    """Of one of SCENES."""
    return exact(SCENES[name](), camera_of(name))


def exact(splats: Splats, camera: Camera = CAMERA) -> Exact:
    """As `camera`, of CAMERA's size, sees them."""
    import torch

    from renderer.rasterize.reference import rasterize_reference

    def tensor(name: str) -> Tensor:
        return torch.tensor(getattr(splats, name).astype(np.float64), requires_grad=True)

    inputs = [tensor(name) for name in NAMES]
    means, quats, scales, opacities, colors = inputs
    drawn = rasterize_reference(means, quats, scales, opacities, colors, camera, near=NEAR)
    seen = drawn.image + (1 - drawn.alpha)[..., None] * torch.tensor(BACKDROP, dtype=torch.float64)
    parts = zip((seen, drawn.alpha, drawn.depth), slopes(), strict=True)
    loss = torch.stack([(part * torch.tensor(by)).sum() for part, by in parts]).sum()
    loss.backward()  # type: ignore[no-untyped-call]
    zero = torch.zeros(1, dtype=torch.float64)
    gradients = {
        name: (zero.expand_as(value) if value.grad is None else value.grad).numpy()
        for name, value in zip(NAMES, inputs, strict=True)
    }
    image, alpha, depth = (part.detach().numpy() for part in (drawn.image, drawn.alpha, drawn.depth))
    return Exact(image, alpha, depth, float(loss.detach()), gradients)
