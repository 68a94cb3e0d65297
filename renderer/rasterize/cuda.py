"""The rasteriser for NVIDIA cards: gsplat's kernels with the conventions of the other backends.

They are the same but for this: gsplat leaves out the splat that takes a pixel's transmittance to 1e-4, in
place of the one after it; opacities, in place of alphas, are capped at 0.99, since its own cap of 0.999 would
so leave out up to a tenth of a pixel's light; and it projects in float32 and adds gradients up in no fixed
order, so that results repeat to rounding only. Checked on an H200 (gsplat 1.5.3 built for CUDA 13.0, torch
2.11); without a card, the tests take gsplat's own torch statement of its kernels.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

from renderer.camera import Camera
from renderer.rasterize.cpu import BLACK, Background
from renderer.rasterize.reference import ALPHA_MAX, LOW_PASS, Rendered
from renderer.splats import RenderMode


class Drawn(NamedTuple):
    """A picture, float32 on the device of the Gaussians."""

    picture: Rendered
    centers: Tensor
    """(1, N, 2) in pixels; has a `grad` after a backward pass."""


def rasterize_cuda(
    means: Tensor,
    quats: Tensor,
    scales: Tensor,
    opacities: Tensor,
    colors: Tensor,
    camera: Camera,
    background: Background = BLACK,
    *,
    near: float = 0.01,
    mode: RenderMode = "default",
) -> Drawn:
    """See `rasterize`; float32 tensors, all on one card.

    Raises:
        ImportError: gsplat is not installed.
    """
    from gsplat import rasterization

    device = means.device
    # gsplat divides by the length of a quaternion; the zero one turns nothing here.
    unturned = quats.new_tensor([1.0, 0.0, 0.0, 0.0])
    pixels, alpha, extras = rasterization(
        means=means,
        quats=torch.where((quats == 0).all(dim=1, keepdim=True), unturned, quats),
        scales=scales,
        # The slope passes the cap, or an opacity above it could never fall.
        opacities=opacities - (opacities - ALPHA_MAX).clamp(min=0).detach(),
        colors=colors,
        viewmats=torch.tensor(camera.camera_from_world, dtype=torch.float32, device=device)[None],
        Ks=torch.tensor(camera.intrinsics, dtype=torch.float32, device=device)[None],
        width=camera.width,
        height=camera.height,
        near_plane=near,
        eps2d=LOW_PASS,
        packed=False,
        backgrounds=torch.tensor([background], dtype=torch.float32, device=device),
        render_mode="RGB+ED",
        rasterize_mode="antialiased" if mode == "mip" else "classic",
    )
    centers: Tensor = extras["means2d"]
    if centers.requires_grad:
        centers.retain_grad()
    return Drawn(Rendered(pixels[0, ..., :3], alpha[0, ..., 0], pixels[0, ..., 3]), centers)
