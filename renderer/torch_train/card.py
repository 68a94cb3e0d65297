"""Whether a graphics card can train: tried by drawing on it, which also compiles gsplat's kernels."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout

import torch

from renderer.camera import Camera
from renderer.rasterize.cuda import rasterize_cuda

CAMERA = Camera(20.0, 20.0, 8.5, 8.5, 16, 16)
OPACITY = 0.5
TOLERANCE = 1e-3


def trouble(device: str = "cuda") -> str | None:
    """What keeps the card from drawing, in one line; None when a Gaussian comes out right, with its slope."""
    if device == "cuda" and not torch.cuda.is_available():
        return f"torch {torch.__version__} finds no GPU: install a CUDA build from https://pytorch.org"
    try:
        # gsplat says on stdout that it compiles.
        with redirect_stdout(sys.stderr):
            alpha, slope = _centre(torch.device(device))
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        return (
            f"gsplat cannot render here; it needs the CUDA toolkit (nvcc) to compile its kernels ({reason})"
        )
    if abs(alpha - OPACITY) > TOLERANCE or abs(slope - 1) > TOLERANCE:
        return f"gsplat renders incorrectly here: expected alpha {OPACITY}, got {alpha:.4f}"
    return None


def _centre(device: torch.device) -> tuple[float, float]:
    """Alpha at the centre of a Gaussian, and its slope by the opacity."""
    opacities = torch.full((1,), OPACITY, device=device, requires_grad=True)
    drawn = rasterize_cuda(
        torch.tensor([[0.0, 0.0, 10.0]], device=device),
        torch.tensor([[1.0, 0.0, 0.0, 0.0]], device=device),
        torch.ones((1, 3), device=device),
        opacities,
        torch.ones((1, 3), device=device),
        CAMERA,
    )
    alpha = drawn.picture.alpha[8, 8]
    alpha.backward()  # type: ignore[no-untyped-call]
    assert opacities.grad is not None
    return alpha.item(), opacities.grad.item()
