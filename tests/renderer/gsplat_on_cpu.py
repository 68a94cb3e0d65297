"""gsplat's public function on a processor, its CUDA kernels replaced by its own torch statements of them.

Projection, tiles, offsets, alphas and their autograd are gsplat's. What it has for CUDA alone is stated here
from the comments and rules of its kernels: which splats reach a pixel before it is opaque, and the two sums
along rays that it takes from the package nerfacc.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

import pytest
import torch
from torch import Tensor

INSTALL = "gsplat is not installed: pip install --no-deps gsplat jaxtyping wadler-lindig"
ALPHA_CUT, ALPHA_MAX, STOP = 1 / 255, 0.999, 1e-4


def install(monkeypatch: pytest.MonkeyPatch) -> None:
    """Until the end of the test. Skips it where there is no gsplat."""
    rendering: Any = pytest.importorskip("gsplat.rendering", reason=INSTALL)
    from gsplat.cuda import _torch_impl, _wrapper

    def projection(
        means: Tensor, covars: None, quats: Tensor, scales: Tensor, views: Tensor, lenses: Tensor,
        width: int, height: int, **rest: Any,
    ) -> Any:  # fmt: skip
        spread, _ = _torch_impl._quat_scale_to_covar_preci(quats, scales, True, False)
        assert not rest["packed"]
        return _torch_impl._fully_fused_projection(
            means, spread, views, lenses, width, height, rest["eps2d"], rest["near_plane"],
            calc_compensations=rest["calc_compensations"],
        )  # fmt: skip

    def tiles(means2d: Tensor, radii: Tensor, depths: Tensor, size: int, *grid: int, **_: Any) -> Any:
        return _torch_impl._isect_tiles(means2d.detach(), radii, depths.detach(), size, *grid)

    def pixels(*given: Any, backgrounds: Tensor, packed: bool, absgrad: bool) -> Any:
        return _torch_impl._rasterize_to_pixels(*given, backgrounds=backgrounds)

    rays = ModuleType("nerfacc")
    vars(rays).update(render_weight_from_alpha=weights, accumulate_along_rays=summed)
    monkeypatch.setitem(sys.modules, "nerfacc", rays)
    monkeypatch.setattr(rendering, "fully_fused_projection", projection)
    monkeypatch.setattr(rendering, "isect_tiles", tiles)
    monkeypatch.setattr(rendering, "isect_offset_encode", _torch_impl._isect_offset_encode)
    monkeypatch.setattr(rendering, "rasterize_to_pixels", pixels)
    monkeypatch.setattr(_wrapper, "rasterize_to_indices_in_range", reached)


def reached(
    first: int, last: int, light: Tensor, means2d: Tensor, conics: Tensor, opacities: Tensor,
    width: int, height: int, tile: int, offsets: Tensor, ids: Tensor,
) -> tuple[Tensor, Tensor, Tensor]:  # fmt: skip
    """Splats, pixels and images of every pair that counts, each pixel's splats nearest first, one image."""
    assert first == 0
    starts = [*offsets.flatten().tolist(), len(ids)]
    splats, places = [], []
    for row in range(offsets.shape[-2]):
        for column in range(offsets.shape[-1]):
            index = row * offsets.shape[-1] + column
            some = ids[starts[index] : starts[index + 1]].long()
            y = torch.arange(row * tile, min(row * tile + tile, height))
            x = torch.arange(column * tile, min(column * tile + tile, width))
            dx = means2d[0, some, 0] - (x[None, :, None] + 0.5)
            dy = means2d[0, some, 1] - (y[:, None, None] + 0.5)
            a, b, c = conics[0, some].unbind(1)
            sigma = 0.5 * (a * dx * dx + c * dy * dy) + b * dx * dy
            alpha = (opacities[0, some] * torch.exp(-sigma)).clamp(max=ALPHA_MAX)
            counts = (alpha >= ALPHA_CUT) & (sigma >= 0)
            counts &= torch.cumprod(1 - torch.where(counts, alpha, 0.0), dim=2) > STOP
            below, beside, which = counts.nonzero(as_tuple=True)
            splats.append(some[which])
            places.append(y[below] * width + x[beside])
    pairs = torch.cat(splats), torch.cat(places)
    return *pairs, torch.zeros_like(pairs[0])


def weights(alphas: Tensor, *, ray_indices: Tensor, n_rays: int) -> tuple[Tensor, Tensor]:
    """Of pairs that lie together ray by ray: alpha times the product of 1 - alpha before it on its ray."""
    logs = torch.log1p(-alphas.double())
    before = logs.cumsum(0) - logs
    starts = torch.ones_like(ray_indices, dtype=torch.bool)
    starts[1:] = ray_indices[1:] != ray_indices[:-1]
    ray = starts.cumsum(0) - 1
    light = torch.exp(before - before[starts][ray]).float()
    return alphas * light, light


def summed(values: Tensor, extra: Tensor | None, *, ray_indices: Tensor, n_rays: int) -> Tensor:
    """Sums (rays, channels) of values times `extra` (pairs, channels)."""
    terms = values[:, None] if extra is None else values[:, None] * extra
    return values.new_zeros((n_rays, terms.shape[1])).index_add(0, ray_indices, terms)
