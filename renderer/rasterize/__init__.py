"""Differentiable drawing of Gaussians (paper Eqs 13-16). torch is imported only when it is used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from torch import Tensor

    from renderer.camera import Camera
    from renderer.rasterize.reference import Rendered

Backend = Literal["auto", "cpu", "reference"]


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
) -> Rendered:
    """Image (H, W, 3), alpha (H, W) and expected depth (H, W; 0 where alpha is 0) of activated Gaussians.

    Differentiable in the first five arguments. "cpu", which "auto" chooses, computes in float32 with
    numba kernels; "reference" in float64 with plain torch, slowly. `near` is in scene units.

    Raises:
        ValueError: shapes that do not agree, or an unknown backend.
    """
    from renderer.rasterize.differentiable import CpuRasterize
    from renderer.rasterize.reference import Rendered, rasterize_reference

    if backend == "reference":
        return rasterize_reference(means, quats, scales, opacities, colors, camera, background, near=near)
    if backend not in ("auto", "cpu"):
        raise ValueError(f"backend must be auto, cpu or reference, got {backend!r}")
    floats = [value.float() for value in (means, quats, scales, opacities, colors)]
    image, alpha, depth = CpuRasterize.apply(*floats, camera, background, near)  # type: ignore[no-untyped-call]
    return Rendered(image, alpha, depth)
