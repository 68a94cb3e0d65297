"""Differentiable drawing of Gaussians (paper Eqs 13-16). torch is imported only when it is used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from torch import Tensor

    from renderer.camera import Camera
    from renderer.rasterize.reference import Rendered
    from renderer.splats import RenderMode

Backend = Literal["auto", "cpu", "cuda", "reference"]


def rasterize(
    means: Tensor,  # (N, 3)
    quats: Tensor,  # (N, 4) wxyz, any length
    scales: Tensor,  # (N, 3) > 0
    opacities: Tensor,  # (N,) in [0, 1]
    colors: Tensor,  # (N, 3)
    camera: Camera,
    background: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    backend: Backend = "auto",
    near: float = 0.01,
    mode: RenderMode = "default",
) -> Rendered:
    """Image (H, W, 3), alpha (H, W) and expected depth (H, W; 0 where alpha is 0) of activated Gaussians.

    Differentiable in the first five arguments; twice with "reference" only. "cpu" computes in float32 with
    numba kernels; "cuda" in float32 with gsplat's; "reference" in float64 with plain torch, slowly. "auto" is
    "cuda" for tensors that are on a GPU, else "cpu". `near` is in scene units.
    `mode` "mip" compensates for the low-pass filter, see RenderMode.

    Raises:
        TypeError: anything but tensors and a Camera, such as arrays of numpy.
        ValueError: shapes that do not agree, `near` that is not above 0, or an unknown backend or mode.
        ImportError: no torch; "cuda" without gsplat.
        RuntimeError: by the backward pass of "cpu" with `create_graph`.

    Example:
        >>> import torch
        >>> from renderer import Camera, rasterize
        >>> means, quats = torch.tensor([[0.0, 0.0, 5.0]]), torch.tensor([[1.0, 0.0, 0.0, 0.0]])
        >>> scales, opacities = torch.full((1, 3), 0.3), torch.tensor([0.9])
        >>> colors = torch.tensor([[0.8, 0.2, 0.2]], requires_grad=True)
        >>> rendered = rasterize(means, quats, scales, opacities, colors, Camera.from_fov(60, 64, 48))
        >>> rendered.image.sum().backward()
        >>> tuple(rendered.depth.shape), bool((colors.grad > 0).all())
        ((48, 64), True)
    """
    from torch import Tensor

    from renderer.camera import Camera
    from renderer.rasterize.cuda import rasterize_cuda
    from renderer.rasterize.differentiable import CpuRasterize
    from renderer.rasterize.reference import Rendered, rasterize_reference
    from renderer.splats import require_drawable

    tensors = means, quats, scales, opacities, colors
    if not (all(isinstance(one, Tensor) for one in tensors) and isinstance(camera, Camera)):
        got = ", ".join(type(one).__name__ for one in (*tensors, camera))
        raise TypeError(f"expected five tensors and a Camera, got {got}")
    require_drawable(near, mode)
    if backend == "reference":
        return rasterize_reference(
            means, quats, scales, opacities, colors, camera, background, near=near, mode=mode
        )
    if backend not in ("auto", "cpu", "cuda"):
        raise ValueError(f"backend must be auto, cpu, cuda or reference, got {backend!r}")
    means, quats, scales, opacities, colors = (one.float() for one in tensors)
    if backend == "cuda" or (backend == "auto" and means.is_cuda):
        drawn = rasterize_cuda(
            means, quats, scales, opacities, colors, camera, background, near=near, mode=mode
        )
        return drawn.picture
    image, alpha, depth = CpuRasterize.apply(  # type: ignore[no-untyped-call]
        means, quats, scales, opacities, colors, camera, background, near, mode
    )
    return Rendered(image, alpha, depth)
